"""The linear equations in time: closed forms, orders of convergence, energy, periodicity."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
import scipy.linalg
from scipy.optimize import minimize_scalar

from flexmech import (
    BeamSection,
    ComputationError,
    ExudynEngine,
    FourBar,
    InputError,
    Mechanism,
    ReferenceEngine,
    example_model,
    load_mechanism,
)
from flexmech.linkages import ConstantSpeed, inverse_dynamics
from flexmech.time_domain import DrivenLinkage, linear_run, periodic_state
from flexmech.time_domain.equations_of_motion import stress_history as stress_module
from flexmech.time_domain.periodic_motion.shooting import turn_map

LEVELS = ("none", "axial", "equilibrium")


def middle(engine, trajectory, link=1):
    """Deflection of a link's middle from the line between its ends."""
    v = np.einsum("sn,bn->bs", engine.links[link].shape[:, 1], trajectory.displacement[link])
    return v[:, 10] - (v[:, 0] + v[:, 20]) / 2


def quasi_static_start(linkage):
    h = 1e-5
    position = linkage.equations(np.array([-h, 0.0, h]), frozen=True).quasi_static()
    return position[1], (position[2] - position[0]) / (2 * h)


def damped(mechanism, time):
    sections = {k: s.with_damping_time(time) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def run(mechanism, level="equilibrium", steps=1440, turns=1.0, speed=20.0, **kwargs):
    engine = ReferenceEngine(mechanism)
    linkage = DrivenLinkage(engine, ConstantSpeed(speed), level, **kwargs)
    period = linkage.drive.revolution_time
    time = period / 360 * np.arange(round(360 * turns) + 1)
    return engine, linear_run(linkage, *quasi_static_start(linkage), time, period / steps)


@pytest.mark.parametrize("level", LEVELS)
def test_the_time_step_converges_in_second_order(aluminium, level):
    curves = [middle(*run(aluminium, level, steps)) for steps in (1440, 2880, 5760)]
    first, second = np.abs(np.diff(curves, axis=0)).max(axis=1)
    assert np.log2(first / second) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("name", ["aluminium", "steel"])
def test_work_of_the_shaft_is_energy(mechanisms, name, level):
    coarse, fine = (run(mechanisms[name], level, steps)[1] for steps in (1440, 2880))
    assert fine.energy_error < 1e-5
    if level != "equilibrium":
        assert coarse.energy_error / fine.energy_error == pytest.approx(4.0, rel=0.2)
    # Axial coordinates that follow a changing bow have a velocity that the model leaves out:
    # a few millionths of the energy remain.
    # The balance is no identity: work and energies are large against the gap.
    assert np.ptp(fine.energy.drive_work) > 0.1 * fine.energy.kinetic.max()


def test_damping_takes_what_the_shaft_gives_over_a_periodic_turn(aluminium):
    mechanism = damped(aluminium, 1e-4)
    linkage = DrivenLinkage(ReferenceEngine(mechanism), ConstantSpeed(20.0), "axial")
    start = periodic_state(linkage, 2880)
    period = linkage.drive.revolution_time
    time = np.array([0.0, period / 2, period])
    energy = linear_run(linkage, start.position, start.velocity, time, period / 2880).energy
    assert energy.kinetic[2] == pytest.approx(energy.kinetic[0], rel=1e-12)
    assert energy.dissipated[2] > 1e-5
    work = energy.drive_work[2] + energy.prestress_work[2]
    assert work == pytest.approx(energy.dissipated[2], rel=5e-3)


def test_damping_matrix_is_the_rate_of_the_mass_and_a_skew_part(aluminium):
    linkage = DrivenLinkage(ReferenceEngine(aluminium), ConstantSpeed(20.0), "none")
    h, time = 1e-6, np.linspace(0.0, 0.3, 7)
    now, before, after = (linkage.equations(time + d) for d in (0.0, -h, h))
    rest = now.damping - (after.mass - before.mass) / (2 * h)
    symmetric = rest + np.swapaxes(rest, 1, 2)
    # What follows statically moves with the position; its rate is left out.
    assert np.abs(symmetric).max() < 1e-4 * np.abs(now.damping).max()


def test_stiff_links_ask_for_the_torque_and_forces_of_rigid_ones(aluminium):
    sections = {
        k: replace(
            s, bending_stiffness=1e4 * s.bending_stiffness, axial_stiffness=1e4 * s.axial_stiffness
        )
        for k, s in aluminium.sections.items()
    }
    stiff = replace(aluminium, sections=sections, gravity=(0.0, -9.81))
    _, trajectory = run(stiff, "axial", steps=2880, turns=0.25)
    motion = stiff.linkage.motion(20.0 * trajectory.time, 20.0)
    rigid = inverse_dynamics(
        stiff.linkage.topology, motion, stiff.link_masses_in_order, stiff.gravity
    )
    scale = np.abs(rigid.driving_torque).max()
    assert np.abs(trajectory.driving_torque - rigid.driving_torque).max() < 2e-3 * scale
    for number, joint in enumerate(stiff.linkage.topology.joint_names):
        force = rigid.joint_force[joint]
        gap = np.abs(trajectory.joint_force[:, number] - force).max()
        assert gap < 2e-3 * np.abs(force).max(), joint
    assert trajectory.energy_error < 1e-5
    assert np.ptp(trajectory.energy.gravity) > 1e-3


def test_rotating_arm_under_gravity_answers_as_in_closed_form(unit_arm):
    """In the arm's frame weight turns: the steady answer is a complex amplitude."""
    mechanism = replace(damped(unit_arm(100.0), 0.05), gravity=(0.0, -0.01))
    speed = 0.8
    engine = ReferenceEngine(mechanism, component_modes=False)
    linkage = DrivenLinkage(engine, ConstantSpeed(speed), "none")
    quarter = linkage.drive.revolution_time / 4
    equations = linkage.equations(np.array([0.0, quarter, 2 * quarter]))
    mean = (equations.force[0] + equations.force[2]) / 2
    cosine, sine = equations.force[0] - mean, equations.force[1] - mean
    dynamic = equations.stiffness[0] - speed**2 * equations.mass[0]
    amplitude = np.linalg.solve(dynamic + 1j * speed * equations.damping[0], cosine - 1j * sine)
    expected = np.linalg.solve(equations.stiffness[0], mean) + amplitude.real
    errors = [
        np.abs(periodic_state(linkage, steps).position - expected).max() for steps in (200, 400)
    ]
    assert errors[1] < 1e-4 * np.abs(expected).max()
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


def test_floquet_multipliers_of_a_constant_system_are_exponentials(unit_arm):
    mechanism = damped(unit_arm(100.0), 0.02)
    linkage = DrivenLinkage(ReferenceEngine(mechanism), ConstantSpeed(2.0), "axial", modes=2)
    e, n = linkage.equations(np.zeros(1)), linkage.size
    lower = -np.linalg.solve(e.mass[0], np.hstack([e.stiffness[0], e.damping[0]]))
    first_order = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower])
    exact = scipy.linalg.expm(first_order * linkage.drive.revolution_time)
    slowest = np.abs(np.linalg.eigvals(exact)).max()
    gaps = [
        abs(np.abs(np.linalg.eigvals(turn_map(linkage, steps)[0])).max() - slowest)
        for steps in (400, 800)
    ]
    assert gaps[0] < 1e-3 * slowest
    assert gaps[0] / gaps[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("level", LEVELS)
def test_periodic_motion_is_where_a_damped_run_ends(aluminium, level):
    mechanism = damped(aluminium, 1e-4)
    engine = ReferenceEngine(mechanism)
    linkage = DrivenLinkage(engine, ConstantSpeed(20.0), level)
    period = linkage.drive.revolution_time
    last = period * np.arange(12.0, 13.0001, 0.05)
    nothing = np.zeros(linkage.size)
    settled = middle(engine, linear_run(linkage, nothing, nothing, last, period / 720))
    start = periodic_state(linkage, 720)
    once = linear_run(linkage, start.position, start.velocity, last - last[0], period / 720)
    assert np.abs(settled - middle(engine, once)).max() < 1e-6 * np.abs(settled).max()


def test_reduction_keeps_the_response(aluminium):
    """Component modes against all coordinates, in the model without axial coupling."""
    engine, reduced = run(aluminium, "axial")
    full_engine = engine.unreduced()
    linkage = DrivenLinkage(full_engine, ConstantSpeed(20.0), "axial")
    period = linkage.drive.revolution_time
    full = linear_run(linkage, *quasi_static_start(linkage), reduced.time, period / 1440)
    exact = middle(engine, full)
    assert np.abs(middle(engine, reduced) - exact).max() < 5e-4 * np.abs(exact).max()


@pytest.mark.parametrize(
    "engine", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
def test_reduction_keeps_the_stiffness_of_bowed_bell_cranks(engine):
    """The other arm's couple bows an arm: elements that stretch as it bends on are too stiff."""
    full = engine(load_mechanism(example_model("watt_six_bar")), elements=8)
    first = []
    for one in (full, full.unreduced()):
        equations = DrivenLinkage(one, ConstantSpeed(12.0), with_energy=False).equations(
            np.array([0.05, 0.3]), frozen=True
        )
        pairs = zip(equations.stiffness, equations.mass, strict=True)
        first.append([scipy.linalg.eigvals(*pair).real.min() for pair in pairs])
    np.testing.assert_allclose(first[0], first[1], rtol=1e-6)


def test_stress_is_sampled_densely_enough(aluminium, monkeypatch):
    usual = middle(*run(aluminium))
    monkeypatch.setattr(stress_module, "SAMPLES_PER_TURN", 2 * stress_module.SAMPLES_PER_TURN)
    assert np.abs(middle(*run(aluminium)) - usual).max() < 1e-4 * np.abs(usual).max()


def test_blocks_and_repetition_change_nothing(aluminium, monkeypatch):
    whole = middle(*run(aluminium, "axial", turns=2.0))
    monkeypatch.setattr(import_module("flexmech.time_domain.integrators.runs"), "BLOCK_STEPS", 100)
    assert np.allclose(middle(*run(aluminium, "axial", turns=2.0)), whole, rtol=0, atol=1e-15)


def test_run_up_meets_constant_speed(aluminium):
    """Loads and equations at the end of a run-up are those of the constant speed.

    Up to the interpolation of the stress between 120 positions of a turn, 2e-6.
    """
    engine = ReferenceEngine(aluminium)
    rising = DrivenLinkage(engine, ConstantSpeed(20.0, run_up_time=0.5), "equilibrium")
    angle = float(rising.drive.crank_angle(0.5))
    steady = DrivenLinkage(engine, ConstantSpeed(20.0, start_angle=angle), "equilibrium")
    first, second = rising.equations(np.array([0.5])), steady.equations(np.zeros(1))
    for name in ("mass", "damping", "stiffness", "force"):
        a, b = getattr(first, name), getattr(second, name)
        assert np.abs(a - b).max() < 1e-5 * np.abs(b).max(), name


def test_undamped_resonance_has_no_periodic_motion(unit_arm):
    """Weight turns in the arm's frame as fast as the arm vibrates: the answer grows."""
    mechanism = replace(unit_arm(100.0), gravity=(0.0, -0.01))
    engine = ReferenceEngine(mechanism, element="euler")

    def smallest(speed):
        linkage = DrivenLinkage(engine, ConstantSpeed(speed), "none", modes=1)
        gap = np.eye(2 * linkage.size) - turn_map(linkage, 400)[0]
        return np.abs(np.linalg.eigvals(gap)).min()

    critical = minimize_scalar(smallest, bounds=(2.3, 2.6), method="bounded")
    assert critical.x == pytest.approx(3.51602 / np.sqrt(2), rel=1e-3)
    near = DrivenLinkage(engine, ConstantSpeed(critical.x), "none", modes=1)
    far = DrivenLinkage(engine, ConstantSpeed(1.2), "none", modes=1)
    size = [np.abs(periodic_state(each, 400).position).max() for each in (near, far)]
    assert size[0] > 1e2 * size[1]


def test_linkages_that_lock_are_refused():
    rocker = FourBar(0.3, 0.25, 0.2, 0.2)
    section = BeamSection(1e6, 1.0, 1e5, 0.1, 1e-9, 0.002)
    mechanism = Mechanism(rocker, dict.fromkeys(("crank", "coupler", "rocker"), section))
    with pytest.raises(InputError, match="crank angle"):
        DrivenLinkage(ReferenceEngine(mechanism, elements=2), ConstantSpeed(5.0), "none")


def test_periodic_motion_needs_a_constant_speed(aluminium):
    linkage = DrivenLinkage(
        ReferenceEngine(aluminium, elements=2), ConstantSpeed(5.0, run_up_time=1.0), "none"
    )
    with pytest.raises(InputError, match="run-up"):
        periodic_state(linkage, 100)


def test_divergence_names_time_and_crank_angle(unit_arm):
    """Beyond its natural frequency an arm without tension stiffness flies off."""
    linkage = DrivenLinkage(ReferenceEngine(unit_arm(100.0)), ConstantSpeed(20.0), "none")
    start = np.full(linkage.size, 1e-3)
    with pytest.raises(ComputationError, match=r"time .* s, crank angle .* deg"):
        linear_run(linkage, start, 0 * start, np.linspace(0, 60, 100), 0.01)
