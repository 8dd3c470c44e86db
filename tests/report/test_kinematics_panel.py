"""The report shows stored kinematics: motion, sizes of joint forces, torque."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexmech import (
    Kinematics,
    KinematicsRequest,
    ReferenceEngine,
    ReportRequest,
    check_mechanism,
    kinematics,
    load_mechanism,
    report_results,
    section_profiles,
    stored_results,
)
from flexmech.example_models import example_model
from flexmech.report.panels.kinematics import kinematics_panel, mechanism_panel
from flexmech.report.results import Results
from tests.support.kinematics_data import kinematics_result


def test_a_folder_with_kinematics_has_its_panel(tmp_path: Path) -> None:
    result = kinematics_result()
    result.save(tmp_path)
    results = stored_results(tmp_path)
    assert isinstance(results.all[0], Kinematics)
    panel = kinematics_panel(results)
    assert panel is not None
    motion, moved, forces = panel.plots
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
    assert [table.title for table in panel.tables] == [
        "greatest values from 0 to 360 deg, mechanism at 20 rad/s"
    ]
    points = {(trace.name, trace.axis): trace.y for trace in moved.traces}
    at_b = data.sel(point="B", component="x")
    assert points["B along x", 0] == pytest.approx(1e3 * at_b["point_position"].values)
    assert points["B along x", 2] == pytest.approx(at_b["point_acceleration"].values)
    assert not any(name.startswith("A ") for name, _ in points)  # it goes round with the crank


def test_without_lumped_masses_there_is_one_line_a_joint() -> None:
    panel = kinematics_panel(Results.of(kinematics_result(None)))
    assert panel is not None
    assert {trace.name for trace in panel.plots[2].traces} == {"distributed masses"}


def test_a_report_computes_them_at_each_speed_but_zero() -> None:
    """For the reader to choose among."""
    engine = ReferenceEngine(load_mechanism(example_model("slider_crank")), elements=2)
    results = report_results([engine], ReportRequest([0.0, 75.0, 150.0], include=("kinematics",)))
    speeds = [one.dataset.attrs["crank_speed"] for one in results.of_kind(Kinematics)]
    assert speeds == [75.0, 150.0]
    panel = kinematics_panel(results)
    assert panel is not None
    torque = {
        trace.when["speed"]: np.abs(trace.y).max()
        for trace in panel.plots[2].traces
        if trace.axis == 3
    }
    # No gravity: forces of inertia grow as the square of the speed.
    assert torque["150 rad/s"] == pytest.approx(4 * torque["75 rad/s"])
    assert all(line.startswith(("75 rad/s: ", "150 rad/s: ")) for line in panel.lines)


def test_a_zero_in_the_table_has_no_sign() -> None:
    request = KinematicsRequest(np.radians([0.0, 30.0]), 150.0)
    found = kinematics(load_mechanism(example_model("slider_crank")), request)
    moment = found.dataset["inertia_moment"].values
    assert np.signbit(moment[moment == 0]).any()
    numbers = found.tables()["kinematics"].select_dtypes("number").to_numpy()
    assert not np.signbit(numbers[numbers == 0]).any()


def test_other_results_have_no_such_panel() -> None:
    profile = section_profiles(load_mechanism(example_model("aluminium_fourbar")))
    assert kinematics_panel(Results.of(profile)) is None


@pytest.mark.parametrize(("model", "drawn"), [("aluminium_fourbar", 1), ("slider_crank", 0)])
def test_the_transmission_angle_is_spoken_of_where_it_is_drawn(model: str, drawn: int) -> None:
    engine = ReferenceEngine(load_mechanism(example_model(model)), 2)
    panel = mechanism_panel(Results.of(check_mechanism(engine)))
    assert panel is not None
    assert len(panel.plots) == drawn
    assert ("transmission angle" in panel.caption) == bool(drawn)
    assert bool(panel.equation) == bool(drawn)
