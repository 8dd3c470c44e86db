"""The report shows stored kinematics: motion, sizes of joint forces, torque."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexmech import Kinematics, load_mechanism, section_profiles, stored_results
from flexmech.example_models import example_model
from flexmech.report.panels.kinematics import kinematics_panel
from flexmech.report.results import Results
from tests.unit.kinematics_data import kinematics_result


def test_a_folder_with_kinematics_has_its_panel(tmp_path: Path) -> None:
    result = kinematics_result()
    result.save(tmp_path)
    results = stored_results(tmp_path)
    assert isinstance(results.all[0], Kinematics)
    panel = kinematics_panel(results)
    assert panel is not None
    motion, forces = panel.plots
    data = result.dataset
    by_axis = {(trace.name, trace.axis): trace.y for trace in motion.traces}
    assert len(by_axis) == 6
    rocker = data["angular_acceleration"].sel(link="rocker").values
    assert by_axis["rocker", 1] == pytest.approx(rocker)
    lines = {(trace.name, trace.axis): trace.y for trace in forces.traces}
    assert len(lines) == 2 * (4 + 1)
    at_b = data["lumped_joint_force"].sel(joint="B").values
    assert lines["lumped masses", 2] == pytest.approx(np.linalg.norm(at_b, axis=-1))
    assert lines["distributed masses", 4] == pytest.approx(data["driving_torque"].values)
    assert [trace.name for trace in motion.traces if trace.legend] == ["crank", "coupler", "rocker"]
    assert panel.tables[1].title == "greatest joint forces"


def test_without_lumped_masses_there_is_one_line_a_joint() -> None:
    panel = kinematics_panel(Results.of(kinematics_result(None)))
    assert panel is not None
    assert {trace.name for trace in panel.plots[1].traces} == {"distributed masses"}


def test_other_results_have_no_such_panel() -> None:
    profile = section_profiles(load_mechanism(example_model("aluminium_fourbar")))
    assert kinematics_panel(Results.of(profile)) is None
