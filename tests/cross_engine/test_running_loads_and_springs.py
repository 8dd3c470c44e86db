"""Runs in time with loads and springs: energy, forces, limits, and one engine against the other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexmech import (
    ConstantSpeed,
    ExudynEngine,
    InputError,
    Mechanism,
    ReferenceEngine,
    ResponseRequest,
    RotatingArm,
    load_mechanism,
    response,
)
from flexmech.analyses.response.measurements import deflections_of
from flexmech.dynamical_systems import VibrationState, step_operators
from flexmech.linear_system import Engine, Prestress
from flexmech.linkages import GROUND, AttachmentPoint, JointSpring, Load, Spring
from flexmech.linkages.motion import cross
from flexmech.time_domain import DrivenLinkage, linear_run, periodic_state
from flexmech.time_domain.integrators.linear_march import LinearMarch, StepTable
from tests.cross_engine.joined_linkages import SliderCrank, Ternary
from tests.cross_engine.test_exudyn_connectors import strips
from tests.cross_engine.test_exudyn_joints import FOUR_BAR

TABLE = Load(
    "table",
    AttachmentPoint("rocker", 0.1),
    ((0.0, 0.0), (-2.0, 1.0), (0.0, 0.0)),
    (0.0, 0.05, 0.0),
    over="crank_angle",
    at=(0.3, 0.35, 0.5),
)
PUSH = Load(
    "push",
    AttachmentPoint("coupler", 0.1),
    ((0.0, 0.0), (0.0, -1.0)),
    (0.0, 0.0),
    "ground",
    "time",
    (0.005, 0.01),
)
TURNING = Load("turning", AttachmentPoint("crank", 0.05), ((0.0, 1.0),), axes="link")
RETURN = Spring(
    "return", AttachmentPoint(GROUND, 0.1, -0.1), AttachmentPoint("rocker", 0.15), 20.0, 0.1, 0.5
)
HINGE = JointSpring("B", 0.05, 0.002, 1.0)
SPEED = 20.0


def four_bar() -> Mechanism:
    """A ternary coupler and all that can act on it."""
    loads = (TABLE, PUSH, TURNING)
    return strips(Ternary(FOUR_BAR), loads=loads, springs=(RETURN,), joint_springs=(HINGE,))


@pytest.mark.thorough
def test_both_engines_run_alike_and_account_for_all_energy() -> None:
    """The reference's equations are linear in the displacement, here up to 4e-3 of a link."""
    mechanism = four_bar()
    request = ResponseRequest(ConstantSpeed(SPEED), 0.06, step=7e-5, start="equilibrium")
    first, second = (
        response(engine, request).dataset
        for engine in (ReferenceEngine(mechanism, 4, "euler"), ExudynEngine(mechanism, 4, "ancf"))
    )

    def gap(name: str) -> float:
        values, others = first[name].values[0], second[name].values[0]
        return float(np.abs(values - others).max() / np.abs(values).max())

    for found in (first, second):
        assert float(found["energy_error"].max()) < 1e-5
        assert np.abs(found["prestress_work"]).max() > 1e-3 * found["kinetic_energy"].max()
    assert gap("deflection") < 1e-3
    assert gap("driving_torque") < 2e-4
    assert gap("strain_energy") < 1e-5
    assert gap("dissipated_energy") < 2e-5


@pytest.mark.thorough
def test_joint_forces_of_a_chain_of_followers() -> None:
    """The rocker of two beams follows the coupler at B; the second beam hangs on the first."""
    mechanism = load_mechanism(Path(__file__).parents[2] / "models" / "carton_pusher.toml")
    request = ResponseRequest(ConstantSpeed(6.0), 0.02, step=1e-4, start="equilibrium", modes=2)
    first, second = (
        response(engine, request)
        for engine in (ReferenceEngine(mechanism, 3, "euler"), ExudynEngine(mechanism, 3, "ancf"))
    )
    force, other = (found.dataset["joint_force"].values[0] for found in (first, second))
    size = np.linalg.norm(force, axis=-1).max(axis=0)
    assert size.min() > 1.0
    assert (np.linalg.norm(other - force, axis=-1).max(axis=0) / size).max() < 1e-2
    for found in (first, second):
        assert not found.dataset["deflection"].sel(link="crank").any()
        assert "crank" not in [row[1] for row in found.summary().table.groups[0]]


@pytest.mark.parametrize(
    "engine", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
def test_a_force_in_axes_of_its_link(engine: type[Engine]) -> None:
    """Across the tip of an arm it bends it always alike, and the shaft holds it."""
    force, length = 0.05, 0.3
    load = Load("tip", AttachmentPoint("arm", length), ((0.0, force),), axes="link")
    section = strips(SliderCrank()).sections["crank"]
    mechanism = Mechanism(RotatingArm(length), {"arm": section}, loads=(load,))
    request = ResponseRequest(ConstantSpeed(0.05), 0.02, step=5e-3, start="equilibrium")
    found = response(engine(mechanism, 4), request).dataset
    deflection = found["deflection"].values.ravel()
    wanted = force * length**3 / (3 * section.bending_stiffness)
    assert deflection == pytest.approx(wanted, rel=1e-3)
    assert found["driving_torque"].values == pytest.approx(-force * length, rel=1e-3)
    angle = 0.05 * found["time"].values
    held = force * np.stack([np.sin(angle), -np.cos(angle)], axis=1)
    assert found["joint_force"].values[0, :, 0] == pytest.approx(held, abs=2e-3 * force)


def test_a_force_that_turns_with_a_bent_section_does_its_work() -> None:
    """The power of the turned force balances the energies; of the force as drawn it does not."""
    load = Load("across", AttachmentPoint("coupler", 0.14), ((0.0, -10.0),), axes="link")
    request = ResponseRequest(ConstantSpeed(SPEED), 0.03, step=2e-4, start="rigid", modes=2)
    engine = ReferenceEngine(strips(FOUR_BAR, loads=(load,)), 2, "euler")
    found = response(engine, request).dataset
    assert float(abs(found["deflection"]).max()) > 1e-3
    assert float(found["energy_error"].max()) < 1e-5


def test_a_torque_on_a_welded_link_is_in_the_joint_forces() -> None:
    """Slow and hardly bent, the joints bear what they bear between rigid links."""
    load = Load("torque", AttachmentPoint("beyond", 0.12), ((0.0, 0.0),), (0.1,))
    mechanism = strips(Ternary(FOUR_BAR), loads=(load,))
    request = ResponseRequest(ConstantSpeed(0.5), 0.01, step=5e-3, start="equilibrium", modes=2)
    found = response(ReferenceEngine(mechanism, 2, "euler"), request).dataset
    force, rigid = found["joint_force"].values[0], found["rigid_joint_force"].values
    assert force == pytest.approx(rigid, abs=1e-2 * np.abs(rigid).max())


def test_joint_forces_hold_a_load_where_it_has_moved_to() -> None:
    """The linkage hardly turns: torque, forces of the ground and the load are in balance."""
    load, tip = (0.0, -5.0), AttachmentPoint("beyond", 0.12)
    mechanism = strips(Ternary(FOUR_BAR), loads=(Load("tip", tip, (load,)),))
    mechanism = replace(mechanism, gravity=(0.0, 0.0))
    engine = ReferenceEngine(mechanism, 2, "euler", component_modes=False)
    linkage = DrivenLinkage(engine, ConstantSpeed(0.01), "equilibrium")
    still = linkage.equations(np.zeros(1), frozen=True).quasi_static()[0]
    found = linear_run(linkage, still, 0 * still, np.array([0.0, 0.01]), 0.005)
    motion, number = linkage.motion(np.zeros(1)), engine.topology.index("beyond")
    point, q = engine.connectors.at(number, tip.x), found.displacement[number][:1]
    moved = point.displacement(motion, q)[:, :2]
    place = motion.position(number, tip.x) + moved
    joints = engine.topology.joint_names
    first, last = (found.joint_force[:1, joints.index(name)] for name in ("O2", "O4"))
    pivot, push = np.array([[FOUR_BAR.ground, 0.0]]), np.array([load])
    left = found.driving_torque[:1] + cross(pivot, last) + cross(place, push)
    assert np.abs(cross(moved, push)).max() > 1e-3
    assert np.abs(left).max() < 1e-5
    assert np.abs(first + last + push).max() < 1e-3


@pytest.mark.parametrize(
    "engine", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
def test_the_equilibrium_at_the_start_counts_loads_over_time(engine: type[Engine]) -> None:
    """A load over time that never changes is a constant load, from the first instant on.

    Exudyn began with the equilibrium without it, and the links rang: engines were 4 % apart.
    """
    length, row = 0.3, (0.02, 0.05)
    tip = AttachmentPoint("arm", length)
    section = strips(SliderCrank()).sections["crank"]
    request = ResponseRequest(ConstantSpeed(5.0), 0.02, step=2e-4, start="equilibrium", modes=2)
    tables: list[dict[str, Any]] = [
        {"force": (row,), "torque": (0.01,)},
        {"force": (row, row), "torque": (0.01, 0.01), "over": "time", "at": (0.0, 1.0)},
    ]
    found = []
    for table in tables:
        loads = (Load("tip", tip, axes="link", **table),)
        mechanism = Mechanism(RotatingArm(length), {"arm": section}, loads=loads)
        found.append(response(engine(mechanism, 3), request).dataset)
    constant, over_time = (each["deflection"].values.ravel() for each in found)
    assert np.abs(constant).max() > 1e-4
    assert np.ptp(constant) < 2e-2 * np.abs(constant).max()
    assert over_time == pytest.approx(constant, abs=1e-6 * np.abs(constant).max())


def test_a_slow_run_tends_to_the_equilibria_at_its_angles() -> None:
    """What it is off by is inertia of the displacement: second order in the speed."""
    tip, rows = AttachmentPoint("arm", 0.3), ((0.0, 0.0), (2e-3, 4e-3), (0.0, 0.0))
    load = Load("tip", tip, rows, (0.0, 2e-4, 0.0), over="crank_angle", at=(-0.5, 1.5, 3.0))
    spring = Spring("hold", AttachmentPoint(GROUND, 0.2, 0.3), tip, 0.03, 0.1, 0.001)
    section = strips(SliderCrank()).sections["crank"]
    mechanism = Mechanism(RotatingArm(0.3), {"arm": section}, loads=(load,), springs=(spring,))
    engine = ReferenceEngine(mechanism, 3, "euler", component_modes=False)
    gaps = []
    for speed in (1.0, 0.25):
        drive = ConstantSpeed(speed)
        request = ResponseRequest(drive, 0.2, step=2e-3 / speed, start="equilibrium", modes=2)
        found = response(engine, request).dataset
        motion = drive.motion(mechanism.linkage, found["time"].values)
        still = engine.stressed_links(motion, "equilibrium").displacement
        assert still is not None
        wanted = deflections_of(engine, still)
        gaps.append(np.abs(found["deflection"].values[0] - wanted).max() / np.abs(wanted).max())
    assert gaps[1] < 1e-4
    assert gaps[0] / gaps[1] == pytest.approx(16.0, rel=0.15)


def test_tables_of_loads_are_not_smoothed_by_the_interpolation_of_steps() -> None:
    """A step between positions is that of the equations themselves, kinks of loads included."""
    linkage = DrivenLinkage(ReferenceEngine(four_bar(), 3, "euler"), ConstantSpeed(SPEED), "none")
    time = np.linspace(0.28, 0.52, 41) / SPEED
    table = StepTable(linkage, 1e-4)
    assert linkage.connectors.is_interpolated
    found = table.rows(time)[0].forced
    wanted = step_operators(linkage.equations(time), 1e-4).forced
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-5 * np.abs(wanted).max())


def test_condensed_coordinates_answer_loads_over_time_at_every_instant() -> None:
    """From the first on, and beyond the steps that are interpolated at once."""
    point, rows = AttachmentPoint("coupler", 0.1), ((-100.0, 50.0), (200.0, 0.0))
    load = Load("push", point, rows, (0.0, 0.0), over="time", at=(0.0, 0.02))
    engine = ReferenceEngine(strips(FOUR_BAR, loads=(load,)), 4, "euler")
    linkage = DrivenLinkage(engine, ConstantSpeed(SPEED))
    time, nothing = 0.01 + 1e-4 * np.arange(70.0), np.zeros(linkage.size)
    still = VibrationState(nothing, nothing, nothing)
    assert linkage.is_condensed
    assert linkage.connectors.is_interpolated
    found = LinearMarch(linkage, 1e-4).advance(time, still)[1].offset
    wanted = linkage.equations(time).expansion.offset
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-4 * np.abs(wanted).max())


def test_a_spring_that_is_wound_up_counts_turns() -> None:
    spring = JointSpring("A", 2.0, 0.01, -0.6)
    engine = ReferenceEngine(strips(SliderCrank(), joint_springs=(spring,)), 2, "euler")
    linkage = DrivenLinkage(engine, ConstantSpeed(SPEED), "none")
    turn = linkage.drive.revolution_time
    time = 0.01 + np.array([0.0, turn])
    force = linkage.connectors.force(linkage.motion(time), time)
    assert np.abs(force[1] - force[0]).max() > 0.9 * 2.0 * 2 * np.pi
    with pytest.raises(InputError, match="wound up further with every turn"):
        response(engine, ResponseRequest(ConstantSpeed(SPEED), 0.1, start="periodic"))


def test_no_motion_is_periodic_under_a_load_over_time() -> None:
    engine = ReferenceEngine(strips(Ternary(FOUR_BAR), loads=(PUSH,)), 2, "euler")
    with pytest.raises(InputError, match="under a load over time no motion repeats itself"):
        response(engine, ResponseRequest(ConstantSpeed(SPEED), 0.1, start="periodic"))


@pytest.mark.parametrize("prestress", ["none", "axial", "equilibrium"])
def test_a_periodic_motion_under_a_table_repeats_itself(prestress: Prestress) -> None:
    tip, rows = AttachmentPoint("arm", 0.3), ((0.0, 0.0), (0.02, 0.04), (0.0, 0.0))
    load = Load("tip", tip, rows, (0.0, 2e-3, 0.0), over="crank_angle", at=(-0.5, 1.5, 3.0))
    spring = Spring("hold", AttachmentPoint(GROUND, 0.2, 0.3), tip, 0.3, 0.1, 0.05)
    section = strips(SliderCrank()).sections["crank"]
    mechanism = Mechanism(RotatingArm(0.3), {"arm": section}, loads=(load,), springs=(spring,))
    linkage = DrivenLinkage(ReferenceEngine(mechanism, 2, "euler"), ConstantSpeed(20.0), prestress)
    start, turn = periodic_state(linkage, 1440), linkage.drive.revolution_time
    run = linear_run(linkage, start.position, start.velocity, np.array([0.0, turn]), turn / 1440)
    first, last = run.displacement[0]
    np.testing.assert_allclose(last, first, rtol=0, atol=1e-7 * np.abs(first).max())
    assert np.abs(run.energy.prestress_work[-1] + run.energy.drive_work[-1]) > 1e-5
    assert run.energy_error < 1e-4


def test_a_joint_spring_keeps_its_energy_where_a_link_turns_past_half_a_turn() -> None:
    """The angle of a cable's slope, known within half a turn, jumps there; the spring does not.

    The motion was right, and the energy balance of Exudyn's run off by 7 % and more.
    """
    mechanism = strips(FOUR_BAR, joint_springs=(JointSpring("A", 0.05),))
    request = ResponseRequest(ConstantSpeed(SPEED, 0.0, 3.1), 0.02, step=2e-4, start="equilibrium")
    first, second = (
        response(engine, request).dataset
        for engine in (ReferenceEngine(mechanism, 3, "euler"), ExudynEngine(mechanism, 3, "ancf"))
    )
    stored, other = (found["strain_energy"].values[0] for found in (first, second))
    assert stored.min() > 0.1 * float(first["kinetic_energy"].max())
    assert other == pytest.approx(stored, rel=1e-3)
    assert float(second["energy_error"].max()) < 1e-4
