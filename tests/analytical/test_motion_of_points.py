"""Strokes, velocities and accelerations of sliders and points, against closed forms."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from flexmech import (
    CouplerCurve,
    CouplerPoint,
    FourBar,
    Kinematics,
    KinematicsRequest,
    Mechanism,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    kinematics,
)
from flexmech.mechanism import AttachedBody
from tests.support.strategies import fourbar

CRANK, ROD, SPEED = 0.04, 0.16, 157.0
# In steps of 50 degrees no angle is near an extreme.
COARSE = np.radians([0.0, 50, 100, 150, 200, 250, 300, 350, 360])
STEPS_OF_60 = np.radians(np.arange(0.0, 361.0, 60.0))


def slider_crank(offset: float = 0.0) -> Mechanism:
    """Crank and rod of rigid bodies, the slider on a line beside the shaft."""
    reach = np.sqrt(ROD**2 - (CRANK - offset) ** 2)
    linkage = PlanarLinkage(
        points={"O2": (0, 0), "A": (0, CRANK), "B": (reach, offset)},
        links=(PlanarLink("crank", ("O2", "A"), True), PlanarLink("rod", ("A", "B"), True)),
        ground=("O2",),
        joints=(PlanarJoint("O2", "clamp"), PlanarJoint("B", "slider", direction=0.0)),
    )
    bodies = (
        AttachedBody("crank", 0.02, 0.3, 2e-4),
        AttachedBody("rod", 0.08, 0.04, 1e-4),
        AttachedBody("rod", ROD, 0.15, 0.0),
    )
    return Mechanism(linkage, {}, bodies=bodies)


def number(result: Kinematics, name: str, of: str = "") -> float:
    (found,) = (one.value for one in result.summary().numbers if one.name == name and one.of == of)
    return found


@pytest.mark.parametrize("angles", [COARSE, np.radians(np.arange(361.0))])
def test_the_stroke_of_a_slider_crank_is_twice_the_crank(angles) -> None:
    found = kinematics(slider_crank(), KinematicsRequest(angles, SPEED))
    assert number(found, "stroke", "B") == pytest.approx(2e3 * CRANK, rel=1e-12)
    # At the dead centre: r omega^2 (1 + r / l).
    expected = CRANK * SPEED**2 * (1 + CRANK / ROD)
    assert number(found, "peak_acceleration", "B") == pytest.approx(expected, rel=1e-12)
    assert found.summary().answer[0].startswith("B strokes 80.00 mm, from 120.0 to 200.0 mm along")


@pytest.mark.parametrize("offset", [0.03, -0.05])
def test_the_stroke_with_an_offset(offset: float) -> None:
    """Between the positions in which crank and rod are in one line, stretched and folded."""
    found = kinematics(slider_crank(offset), KinematicsRequest(COARSE, SPEED))
    stretched = np.sqrt((ROD + CRANK) ** 2 - offset**2)
    folded = np.sqrt((ROD - CRANK) ** 2 - offset**2)
    assert number(found, "stroke", "B") == pytest.approx(1e3 * (stretched - folded), rel=1e-12)


def test_the_greatest_velocity_is_found_between_the_angles() -> None:
    """Where the acceleration is zero, against its closed form on a fine grid."""
    theta = np.linspace(0.0, np.pi, 400001)
    sine = np.sqrt(ROD**2 - (CRANK * np.sin(theta)) ** 2)
    velocity = CRANK * SPEED * np.sin(theta) * (1 + CRANK * np.cos(theta) / sine)
    found = kinematics(slider_crank(), KinematicsRequest(COARSE, SPEED))
    assert number(found, "peak_velocity", "B") == pytest.approx(velocity.max(), rel=1e-10)


def test_an_accelerated_crank_moves_the_slider_by_alpha_too() -> None:
    """Table, file and words have alpha2 and what it does to the slider."""
    alpha, theta = 3000.0, np.radians([0.0, 40.0, 90.0, 200.0])
    request = KinematicsRequest(theta, SPEED, crank_acceleration=alpha)
    found = kinematics(slider_crank(), request)
    root = np.sqrt(ROD**2 - (CRANK * np.sin(theta)) ** 2)
    lever = -CRANK * np.sin(theta) * (1 + CRANK * np.cos(theta) / root)
    constant = kinematics(slider_crank(), KinematicsRequest(theta, SPEED)).dataset
    along = found.dataset["slider_acceleration"].sel(slider="B").values
    before = constant["slider_acceleration"].sel(slider="B").values
    assert along - before == pytest.approx(lever * alpha, abs=1e-9 * CRANK * alpha)
    table = found.tables()["motion"].query("point == 'B'")
    assert table["crank_acceleration_rad_s2"].unique() == pytest.approx([alpha])
    assert table["a_along_m_s2"].to_numpy() == pytest.approx(along)
    assert "crank_acceleration_rad_s2" not in kinematics(slider_crank()).tables()["motion"]
    table = found.summary().table
    assert table is not None
    assert "and 3000 rad/s²" in table.title


def test_a_coupler_point_is_that_of_the_curve(tmp_path: Path) -> None:
    point = CouplerPoint(0.16, np.radians(35.0))
    mechanism = replace(fourbar(), coupler_point=point)
    step = 1e-4
    angles = 0.7 + step * np.arange(-2, 3)
    found = kinematics(mechanism, KinematicsRequest(angles, SPEED))
    assert isinstance(mechanism.linkage, FourBar)
    places = CouplerCurve(mechanism.linkage, point).position(angles)
    of_point = found.dataset.sel(point="coupler point").transpose("crank_angle", ...)
    assert of_point["point_position"].values == pytest.approx(places, rel=1e-12)
    first = np.array([1, -8, 0, 8, -1]) / 12 * SPEED / step
    second = np.array([-1, 16, -30, 16, -1]) / 12 * SPEED**2 / step**2
    assert of_point["point_velocity"].values[2] == pytest.approx(first @ places, rel=1e-9)
    assert of_point["point_acceleration"].values[2] == pytest.approx(second @ places, rel=1e-5)
    found.save(tmp_path)
    table = pd.read_csv(tmp_path / "motion.csv").query("point == 'coupler point'")
    assert list(table.columns) == [
        *("crank_angle_deg", "point", "x_m", "y_m", "vx_m_s", "vy_m_s", "ax_m_s2", "ay_m_s2")
    ]
    assert table[["x_m", "y_m"]].to_numpy() == pytest.approx(places, rel=1e-9)


def test_a_slider_on_a_link_moves_along_it() -> None:
    """Of a crank-shaper, against differences of the distance from the lever's pivot."""
    linkage = PlanarLinkage(
        points={"O2": (0, 0), "A": (0.04, 0.0), "O4": (0, -0.1), "C": (0.08, 0.1)},
        links=(PlanarLink("crank", ("O2", "A")), PlanarLink("lever", ("O4", "C"), True)),
        ground=("O2", "O4"),
        joints=(
            PlanarJoint("O2", "clamp"),
            PlanarJoint("A", "slider", direction=0.0, guide="lever"),
        ),
    )
    mechanism = replace(
        slider_crank(),
        linkage=replace(linkage, links=tuple(replace(one, rigid=True) for one in linkage.links)),
        bodies=(AttachedBody("crank", 0.02, 0.3, 2e-4), AttachedBody("lever", 0.1, 0.2, 1e-4)),
    )
    step = 1e-4
    angles = 0.7 + step * np.arange(-2, 3)
    data = kinematics(mechanism, KinematicsRequest(angles, SPEED)).dataset
    place = data["slider_position"].values[:, 0]
    first = np.array([1, -8, 0, 8, -1]) / 12 * SPEED / step
    second = np.array([-1, 16, -30, 16, -1]) / 12 * SPEED**2 / step**2
    assert data["slider_velocity"].values[2, 0] == pytest.approx(first @ place, rel=1e-9)
    assert data["slider_acceleration"].values[2, 0] == pytest.approx(second @ place, rel=1e-5)
    # From the pivot of the lever to the crank's pin and back: once nearest, once farthest.
    stroke = number(kinematics(mechanism, KinematicsRequest(COARSE, SPEED)), "stroke", "A")
    assert stroke == pytest.approx(80.0, rel=1e-12)


def test_a_linkage_without_loads_takes_no_power_on_average() -> None:
    """At steps of 60 degrees, whose own mean is far from it."""
    found = kinematics(fourbar(), KinematicsRequest(STEPS_OF_60, 20.0))
    power = found.dataset["driving_power"].values
    assert abs(power[:-1].mean()) > 0.1
    assert abs(number(found, "mean_driving_power")) < 1e-9
    assert "mean driving power over the turn: 0 W" in found.summary().lines


def test_a_dead_point_is_at_zero_and_180_degrees() -> None:
    found = kinematics(fourbar(), KinematicsRequest(STEPS_OF_60, 20.0)).summary()
    (line,) = (one for one in found.lines if "with the rocker driving" in one)
    assert line.startswith("transmission angle with the rocker driving: 0 deg (at ")
    assert " to 180.00 deg (at " in line


def test_a_crank_that_cannot_turn_fully_is_a_warning_at_a_speed() -> None:
    swinging = replace(fourbar(), linkage=FourBar(0.254, 0.25, 0.1, 0.11))
    part = np.radians([25.0, 30.0, 35.0])
    running = kinematics(swinging, KinematicsRequest(part, 1500.0, speed_unit="rpm"))
    (warning,) = running.summary().warnings
    assert warning.startswith("the crank cannot turn fully (double-rocker), so that it cannot run")
    assert "at 1500 rpm" in warning
    assert kinematics(swinging, KinematicsRequest(part, 0.0)).summary().warnings == ()
    assert kinematics(fourbar(), KinematicsRequest(part, 20.0)).summary().warnings == ()


def test_where_the_linkage_passes_a_gap_values_are_of_the_angles_alone() -> None:
    swinging = replace(fourbar(), linkage=FourBar(0.254, 0.25, 0.1, 0.11))
    found = kinematics(swinging, KinematicsRequest(np.radians([30.0, 330.0]), 20.0))
    assert found.dataset["extreme_error"].isnull().all()
    assert found.summary().trust.startswith("values are of the crank angles asked for alone")
