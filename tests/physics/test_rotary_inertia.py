"""Rotary inertia of sections: the rigid body of a link has it under every theory of elements."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ConstantSpeed,
    ExudynEngine,
    JointPin,
    Material,
    Mechanism,
    MotorDrive,
    ReferenceEngine,
    RotatingArm,
    TorqueMotor,
    kinematics,
    natural_frequencies,
    response,
    strength,
)
from flexmech.analyses import ResponseRequest, StrengthRequest
from flexmech.choices import Prestress
from flexmech.materials import Laminate, Layer, Ply
from flexmech.modelfile import mechanism_from_toml
from flexmech.sections import LaminateSection
from tests.support.command import run_command
from tests.support.strategies import arm, fourbar

LENGTH, HEIGHT, WIDTH, DENSITY = 0.1, 0.05, 0.01, 8000.0
MASS = DENSITY * LENGTH * HEIGHT * WIDTH
RECTANGLE = """
section = "rectangle"
material = "steel"
in_plane_thickness = "50 mm"
out_of_plane_width = "10 mm"
"""
GENERAL = """
section = "general"
axial_stiffness = "1.05e8 N"
bending_stiffness = "21875 N m^2"
mass_per_length = "4 kg/m"
rotary_inertia = "8.3333333333e-4 kg m"
in_plane_thickness = "50 mm"
"""


def thick_arm(section: str) -> str:
    return f"""
name = "thick arm"
source = "by hand"
[linkage]
kind = "planar"
ground = ["O2"]
[linkage.points]
O2 = ["0 mm", "0 mm"]
A = ["100 mm", "0 mm"]
[joints.O2]
kind = "clamp"
[materials.steel]
youngs_modulus = "210 GPa"
density = "8000 kg/m^3"
poisson_ratio = 0.3
[links.arm]
points = ["O2", "A"]
{section}
"""


@pytest.mark.parametrize("section", [RECTANGLE, GENERAL, "rigid = true" + RECTANGLE])
def test_the_torque_of_an_arm_is_that_of_a_body(section: str, tmp_path: Path) -> None:
    """m (L^2 / 3 + h^2 / 12) alpha: 1.4167 N m at 1000 rad/s^2."""
    (tmp_path / "arm.toml").write_text(thick_arm(section), encoding="utf-8")
    words = "--speed", "0", "--crank-acceleration", "1000 rad/s^2", "--angles", "0", "--no-plots"
    ended = run_command(tmp_path, "kinematics", str(tmp_path / "arm.toml"), *words)
    assert ended.exit_code == 0, ended.stderr
    torque = MASS * (LENGTH**2 / 3 + HEIGHT**2 / 12) * 1000.0
    assert ended.table("drive")["torque_Nm"] == pytest.approx([torque], rel=1e-9)


def two_layers() -> tuple[BeamSection, float]:
    """Steel beside aluminium, and the integral of ``rho y^2`` about the pins' axis, in kg m."""
    steel, light = Material(210e9, 7800.0, 0.3), Material(70e9, 2700.0, 0.3)
    layers = tuple(Layer(Ply.isotropic(one), HEIGHT / 2) for one in (steel, light))
    square = WIDTH * (7800.0 + 2700.0) * (HEIGHT / 2) ** 3 / 3
    return BeamSection.of_laminate(LaminateSection(Laminate(layers), WIDTH)), square


def test_layers_of_unlike_density_turn_about_the_axis() -> None:
    """Off the axis by Steiner: all matter at x along and y across it has rho (x^2 + y^2)."""
    section, square = two_layers()
    mechanism = replace(arm(), sections={"arm": section})
    length = mechanism.linkage.topology.links[0].length
    data = kinematics(mechanism, 0.0, crank_angles=[0.0], crank_acceleration=100.0).dataset
    inertia = section.mass_per_length * length**3 / 3 + square * length
    assert data["driving_torque"].item() == pytest.approx(100.0 * inertia, rel=1e-12)


def test_a_couple_along_the_arm_bends_it() -> None:
    """At rest, accelerated: M(x) of the inertia beyond x, its couple rho I (L - x) alpha in it."""
    mechanism = mechanism_from_toml(thick_arm(RECTANGLE))
    alpha = 1000.0
    forces = mechanism.inverse_dynamics(mechanism.linkage.motion([0.0], 0.0, alpha))
    beyond, line = LENGTH - np.array([0.0, 0.03, 0.07]), DENSITY * HEIGHT * WIDTH
    first = line * (LENGTH**3 - (LENGTH - beyond) ** 3) / 3
    lever = (LENGTH - beyond) * line * (LENGTH**2 - (LENGTH - beyond) ** 2) / 2
    wanted = -alpha * (first - lever + line * HEIGHT**2 / 12 * beyond)
    assert forces.bending_moment(0, LENGTH - beyond)[0] == pytest.approx(wanted, rel=1e-9)


RIGID_TIP = """
name = "elastic arm with a thick rigid tip"
source = "by hand"
[linkage]
kind = "planar"
ground = ["O2"]
[linkage.points]
O2 = ["0 mm", "0 mm"]
A = ["200 mm", "0 mm"]
B = ["300 mm", "0 mm"]
[joints.O2]
kind = "clamp"
[joints.A]
kind = "weld"
[materials.steel]
youngs_modulus = "210 GPa"
density = "8000 kg/m^3"
poisson_ratio = 0.3
[links.arm]
points = ["O2", "A"]
section = "rectangle"
material = "steel"
in_plane_thickness = "4 mm"
out_of_plane_width = "10 mm"
[links.tip]
points = ["A", "B"]
rigid = true
"""


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
@pytest.mark.parametrize("prestress", ["none", "equilibrium"])
def test_a_rigid_link_vibrates_with_the_rotary_inertia_of_its_section(
    engine: Any, prestress: Prestress
) -> None:
    """As a line of the same mass with a body of m h^2 / 12 and no mass in its middle."""
    line = GENERAL.replace("8.3333333333e-4", "1e-20")
    body = (
        f'{{ position = "50 mm", mass = "1e-15 kg", inertia = "{MASS * HEIGHT**2 / 12} kg m^2" }}'
    )
    by_section, by_body = (
        natural_frequencies(
            engine(mechanism_from_toml(RIGID_TIP + own), 4),
            *(0.0, 30.0),
            modes=3,
            prestress=prestress,
        )
        for own in (RECTANGLE, f"{line}bodies = [{body}]")
    )
    assert by_section == pytest.approx(by_body, rel=1e-9)


# Elements without rotary inertia, in either engine.
SLENDER = [(ReferenceEngine, "euler"), (ExudynEngine, "ancf")]


def stiff_fourbar() -> Mechanism:
    """Links a third as thick as long, a hundred times as stiff as steel."""
    mechanism = fourbar()
    lengths, stiff = mechanism.linkage.lengths, Material(210e11, 7800.0, 0.3)
    sections = {
        name: BeamSection.rectangle(stiff, lengths[name] / 3, WIDTH) for name in mechanism.sections
    }
    return replace(mechanism, sections=sections)


@pytest.mark.parametrize(
    ("engine", "element"),
    [
        *SLENDER,
        (ReferenceEngine, "timoshenko"),
        pytest.param(ReferenceEngine, "zigzag", marks=pytest.mark.thorough),
        pytest.param(ExudynEngine, "geometrically-exact", marks=pytest.mark.thorough),
    ],
)
def test_forces_of_stiff_links_are_those_of_rigid_ones(engine: Any, element: str) -> None:
    """Driving torque and joint forces of a run; without the rotary inertia 1e-2 is missing."""
    mechanism, speed = stiff_fourbar(), 20.0
    asked = {"start": "equilibrium", "modes": 2, "samples": 1500, "step": 1e-5}
    request = ResponseRequest(ConstantSpeed(speed), 0.006, **asked)
    data = response([engine(mechanism, 2, element)], request).dataset.isel(engine=0)
    angles = data["crank_angle"].values
    rigid = kinematics(mechanism, speed, crank_angles=angles).dataset
    for name in ("driving_torque", "joint_force"):
        had = data[name].transpose("time", ...).values
        wanted = rigid[name].transpose("crank_angle", ...).values
        assert had == pytest.approx(wanted, abs=1e-3 * np.abs(wanted).max())


@pytest.mark.parametrize(("engine", "element"), SLENDER)
def test_internal_forces_of_stiff_links_are_those_of_rigid_ones(engine: Any, element: str) -> None:
    """At the quasi-static equilibrium; the sections' couples are 1e-2 of the bending moments."""
    # A pin whose bush is judged, so that no link needs a strength.
    pins, mechanism = (JointPin("B", 8e-3, bush_length=10e-3, allowable_pv=1e6),), stiff_fourbar()
    plain = {name: replace(section, layers=None) for name, section in mechanism.sections.items()}
    mechanism = replace(mechanism, joint_pins=pins, sections=plain)
    request = StrengthRequest(20.0, crank_angles=np.radians([20.0, 140.0]), search_speed=False)
    by_engine, by_hand = (
        strength(engine(mechanism, 2, element), replace(request, source=source)).dataset.isel(
            engine=0
        )
        for source in ("quasi-static", "rigid")
    )
    for name in ("bending_moment", "shear_force", "axial_force"):
        had, wanted = by_engine[name].values, by_hand[name].values
        assert had == pytest.approx(wanted, abs=1e-3 * np.nanmax(np.abs(wanted)), nan_ok=True)


@pytest.mark.parametrize(
    ("engine", "element"),
    [SLENDER[0], pytest.param(*SLENDER[1], marks=pytest.mark.thorough)],
)
def test_a_motor_turns_a_stiff_arm_as_a_rigid_one(engine: Any, element: str) -> None:
    """5 N m from rest: the hub of a free shaft leads the rigid motion by next to nothing."""
    section = BeamSection.rectangle(Material(210e12, DENSITY, 0.3), HEIGHT, WIDTH)
    mechanism = Mechanism(RotatingArm(LENGTH), {"arm": section}, shaft_inertia=1e-4)
    request = ResponseRequest(
        MotorDrive(TorqueMotor((0.0,), (5.0,)), time=0.002), samples=20, modes=1, step=1e-5
    )
    data = response([engine(mechanism, 2, element, shaft="free")], request).dataset.isel(engine=0)
    inertia = MASS * (LENGTH**2 / 3 + HEIGHT**2 / 12) + 1e-4
    turned = 5.0 / inertia * data["time"].values ** 2 / 2
    assert np.abs(data["shaft_rotation"]).max() < 1e-3 * turned[-1]
    np.testing.assert_allclose(data["crank_angle"], turned, atol=1e-12)
