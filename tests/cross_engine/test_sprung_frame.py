"""A frame on springs: a rigid body of Exudyn's against coordinates of the linear equations."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flexmech
from tests.support.sprung_frame_data import framed_file

PEAKS = ("peak_frame_displacement", "peak_frame_rotation", "peak_floor_force")


def both(file: Path, speed: float, start: str) -> flexmech.Response:
    mechanism = flexmech.load_mechanism(file)
    engines = [flexmech.ReferenceEngine(mechanism), flexmech.ExudynEngine(mechanism)]
    request = flexmech.ResponseRequest(flexmech.ConstantSpeed(speed), revolutions=1.0, start=start)
    return flexmech.response(engines, request)


def assert_alike(found: flexmech.Response, within: float) -> None:
    agreement, forces = found.agreement(), found.force_agreement()
    assert agreement is not None
    assert forces is not None
    assert float(agreement.max()) < within
    assert float(forces["joint_force"].max()) < within
    assert float(forces["driving_torque"]) < within
    data = found.dataset
    for name in PEAKS:
        first, second = data[name].values
        assert first == pytest.approx(second, rel=within)
    moved = data["frame_displacement"]
    apart = abs(moved[0] - moved[1]).max()
    assert float(apart) < within * float(abs(moved).max())
    assert float(data["energy_error"].max()) < 1e-6


def test_a_fourbar_on_its_periodic_motion(models: Path, tmp_path: Path) -> None:
    found = both(framed_file(tmp_path, models / "aluminium_fourbar.toml"), 20.0, "periodic")
    assert_alike(found, 3e-4)


@pytest.mark.thorough
def test_a_slider_crank_whose_line_is_on_the_frame(models: Path, tmp_path: Path) -> None:
    found = both(framed_file(tmp_path, models / "slider_crank.toml"), 20.0, "periodic")
    assert_alike(found, 1e-3)


@pytest.mark.thorough
def test_a_six_bar_with_a_welded_link(models: Path, tmp_path: Path) -> None:
    found = both(framed_file(tmp_path, models / "watt_six_bar.toml"), 10.0, "periodic")
    assert_alike(found, 2e-3)


@pytest.mark.thorough
def test_at_a_slow_crank_linear_equations_miss_nothing(models: Path, tmp_path: Path) -> None:
    """What they leave out is of second order: at 20 rad/s it is ten times as much."""
    data = both(framed_file(tmp_path, models / "aluminium_fourbar.toml"), 4.0, "periodic").dataset
    moved = data["frame_displacement"]
    assert float(abs(moved[0] - moved[1]).max()) < 5e-5 * float(abs(moved).max())


def test_frequencies_agree(models: Path, tmp_path: Path) -> None:
    mechanism = flexmech.load_mechanism(framed_file(tmp_path, models / "aluminium_fourbar.toml"))
    angles = np.radians([10.0, 200.0])
    first, second = (
        flexmech.natural_frequencies(engine(mechanism), angles, 20.0, modes=5)
        for engine in (flexmech.ReferenceEngine, flexmech.ExudynEngine)
    )
    assert first == pytest.approx(second, rel=1e-4)
    reduced = flexmech.ReferenceEngine(mechanism)
    every = flexmech.ReferenceEngine(mechanism, component_modes=False)
    for prestress in ("none", "axial", "equilibrium"):
        pair = [
            flexmech.natural_frequencies(engine, angles, 20.0, modes=5, prestress=prestress)
            for engine in (reduced, every)
        ]
        assert pair[0] == pytest.approx(pair[1], rel=2e-5)
    damped = replace(mechanism, frame=replace(mechanism.frame, mass=3.0))
    assert flexmech.natural_frequencies(damped, angles, modes=1)[0] < first[0, 0]
