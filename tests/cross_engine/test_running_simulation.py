"""Exudyn's simulation of the running linkage, held against everything that is known of it."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ComputationError,
    ExudynEngine,
    InputError,
    Mechanism,
    PointMass,
    RotatingArm,
)
from flexmech.linear_system import DeadMoments, inertia_loads
from flexmech.linkages import ConstantSpeed, inverse_dynamics
from flexmech.multibody.linearize import linearized, static_equilibrium
from flexmech.multibody.running import simulation
from flexmech.multibody.static_model import simulation_settings
from flexmech.sections import DampingTimes
from flexmech.time_domain import LinkState
from tests.cross_engine.test_six_bar import LEFT

ELEMENTS = ("ancf", "geometrically-exact")
INTEGRATORS = ("trapezoidal", "generalized-alpha")
# Fourth natural frequency of the aluminium four-bar, about 190 Hz: thirty steps a period.
STEP = 1 / (30 * 190.0)


def simulate(engine, drive, time, step, start=None, **options):
    return engine.simulate(drive, start or LinkState.rigid(engine.links), time, step, **options)


def middle_deflection(engine, trajectory, link=1):
    across = trajectory.displacement[link] @ engine.links[link].shape[:, 1].T
    return across[:, 10] - (across[:, 0] + across[:, 20]) / 2


def stiffened(mechanism, factor):
    """Sections so stiff that the links hardly bend; mass as before."""
    sections = {
        name: replace(
            section,
            **{
                f"{kind}_stiffness": factor * getattr(section, f"{kind}_stiffness")
                for kind in ("axial", "bending", "shear")
            },
        )
        for name, section in mechanism.sections.items()
    }
    return replace(mechanism, sections=sections)


@pytest.fixture(scope="module")
def laden(aluminium):
    """Everything that may act: weight, masses on joints and links, damping."""
    return replace(
        aluminium,
        gravity=(1.0, -9.81),
        joint_masses={"A": 0.05, "B": 0.03},
        link_masses=(PointMass("coupler", 0.1, 0.02),),
        sections={n: s.with_damping_time(2e-4) for n, s in aluminium.sections.items()},
    )


# --- the energies -------------------------------------------------------------------------


def arm(element, **changes):
    section = BeamSection(
        axial_stiffness=4e3,
        bending_stiffness=2.0,
        shear_stiffness=1e3,
        mass_per_length=1.0,
        rotary_inertia=1e-6,  # rigid links have none
        in_plane_thickness=0.01,
        **changes,
    )
    return ExudynEngine(Mechanism(RotatingArm(1.0, 0.2), {"arm": section}), 4, element)


def strains(assembly, displacement, rate):
    part = assembly.parts[0]
    return assembly.kind.strains(displacement, rate, np.diff(part.positions), part.section)


@pytest.mark.parametrize("element", ELEMENTS)
def test_static_force_is_the_derivative_of_the_strain_energy(element):
    engine = arm(element)
    model, assembly = engine.model, engine.model.assembly
    motion = engine.mechanism.linkage.motion(np.array([0.7]), 0.4, 5.0)
    loads = inertia_loads(engine.links, motion, (0.0, 0.0))
    dead = DeadMoments.of(engine.links, motion, (0.0, 0.0), loads)
    bent = static_equilibrium(model, motion, loads, dead).displacement[0][0]
    assert np.abs(bent[engine.links[0].end]).max() > 0.1
    free = np.arange(assembly.size) >= assembly.kind.per_node
    away = 1e-6 * np.eye(assembly.size)[free]
    gradient = [
        np.diff(
            [
                sum(s.energy[0] for s in strains(assembly, (bent + d)[None], 0 * bent[None]))
                for d in (-change, change)
            ]
        )[0]
        / 2e-6
        for change in away
    ]
    load = loads[0][0][free]
    assert np.abs(gradient - load).max() < 1e-7 * np.abs(load).max()


@pytest.mark.parametrize("element", ELEMENTS)
def test_dissipation_is_that_of_exudyn_s_damping_matrix(element):
    engine = arm(element, damping=DampingTimes(axial=0.02, bending=0.03, shear=0.05))
    random = np.random.default_rng(3)
    assembly = engine.model.assembly
    bent, rate = random.normal(0, 0.05, (2, assembly.size))
    damping = linearized(assembly, simulation_settings(), bent)[2]
    power = sum(s.dissipation[0] for s in strains(assembly, bent[None], rate[None]))
    assert power == pytest.approx(rate @ damping @ rate, rel=1e-9)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(("name", "limit"), [("aluminium", 2e-5), ("steel", 3e-5)])
def test_energy_is_balanced(mechanisms, name, limit, integrator):
    engine, drive = ExudynEngine(mechanisms[name], 4), ConstantSpeed(20.0)
    time = np.linspace(0.0, drive.revolution_time, 101)
    run = simulate(engine, drive, time, STEP, integrator=integrator)
    assert 1e-7 < run.energy_error < limit


@pytest.mark.parametrize("element", ELEMENTS)
def test_energy_is_balanced_with_weight_masses_and_damping(laden, element):
    engine, drive = ExudynEngine(laden, 4, element), ConstantSpeed(10.0, start_angle=0.5)
    run = simulate(engine, drive, np.linspace(0.0, 0.3, 101), 2e-4)
    assert run.energy_error < 4e-6
    assert run.energy.dissipated[-1] > 10 * run.energy_error * run.energy.kinetic.max()
    assert np.ptp(run.energy.gravity) > 0.1 * run.energy.kinetic.max()


# --- the forces ---------------------------------------------------------------------------


def forces_of_rigid_links(mechanism, drive, time):
    motion = mechanism.linkage.motion(
        drive.crank_angle(time), drive.crank_speed(time), drive.crank_acceleration(time)
    )
    topology = mechanism.linkage.topology
    rigid = inverse_dynamics(topology, motion, mechanism.link_masses_in_order, mechanism.gravity)
    forces = np.stack([rigid.joint_force[name] for name in topology.joint_names], axis=1)
    return forces, rigid.driving_torque


def sagging(engine, drive):
    """Start under weight alone."""
    motion = engine.mechanism.linkage.motion(drive.crank_angle(np.zeros(1)))
    loads = inertia_loads(engine.links, motion, engine.mechanism.gravity)
    dead = DeadMoments.of(engine.links, motion, engine.mechanism.gravity, loads)
    displacement = static_equilibrium(engine.model, motion, loads, dead).displacement
    return LinkState([q[0] for q in displacement], LinkState.rigid(engine.links).rate)


def assert_forces_of_rigid_links(mechanism, element, drive, integrator="trapezoidal"):
    engine = ExudynEngine(stiffened(mechanism, 100.0), 4, element)
    time = np.linspace(0.0, 2 * drive.run_up_time, 81)
    start = sagging(engine, drive)
    run = simulate(engine, drive, time, time[-1] / 1200, start, integrator=integrator)
    forces, torque = forces_of_rigid_links(mechanism, drive, time)
    assert np.abs(run.joint_force - forces).max() < 5e-4 * np.abs(forces).max()
    assert np.abs(run.driving_torque - torque).max() < 5e-4 * np.abs(torque).max()


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(
    "element", [pytest.param("ancf", marks=pytest.mark.thorough), "geometrically-exact"]
)
def test_stiff_links_have_the_forces_of_rigid_ones(laden, element, integrator):
    drive = ConstantSpeed(-8.0, run_up_time=0.5, start_angle=1.0)
    assert_forces_of_rigid_links(laden, element, drive, integrator)


@pytest.mark.parametrize("element", ELEMENTS)
def test_torque_of_a_hub_has_the_lever_of_the_clamp_force(element):
    mechanism = stiffened(arm(element).mechanism, 1e3)
    assert_forces_of_rigid_links(mechanism, element, ConstantSpeed(5.0, run_up_time=0.5))


def test_a_six_bar_runs_with_three_links_on_a_pin(aluminium):
    section = aluminium.sections["crank"]
    mechanism = Mechanism(LEFT, dict.fromkeys(LEFT.topology.link_names, section))
    assert_forces_of_rigid_links(mechanism, "ancf", ConstantSpeed(10.0, run_up_time=0.3))


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_forces_at_time_zero_are_those_that_follow(aluminium, integrator):
    """They come from the accelerations at the start and continue into the first steps."""
    engine, step = ExudynEngine(replace(aluminium, gravity=(0.0, -9.81)), 4), 1e-9
    start = LinkState.rigid(engine.links)
    bend = np.sin(np.pi * np.linspace(0, 1, 5))
    start.displacement[1][1::4] = 1e-3 * bend
    run = simulate(
        engine, ConstantSpeed(20.0), step * np.arange(3.0), step, start, integrator=integrator
    )
    scale = np.abs(run.joint_force).max()
    assert scale > 0.1
    assert np.abs(run.joint_force[0] - run.joint_force[1]).max() < 1e-2 * scale
    assert run.driving_torque[0] == pytest.approx(run.driving_torque[1], rel=1e-2)


# --- the motion ---------------------------------------------------------------------------


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("element", ELEMENTS)
def test_small_vibration_is_that_of_the_linear_model(element, integrator):
    """A clamped arm that hardly turns, started in its first mode: cosines to the end."""
    engine = arm(element)
    link = engine.links[0]
    free = np.arange(link.size)[engine.model.assembly.kind.per_node :]
    if element == "ancf":
        free = np.concatenate([[2], free])  # the clamp leaves the stretch
    stiffness, mass = link.stiffness[np.ix_(free, free)], link.mass[np.ix_(free, free)]
    squares, modes = np.linalg.eig(np.linalg.solve(mass, stiffness))
    first = np.argmin(squares.real)
    frequency, mode = np.sqrt(squares.real[first]), np.zeros(link.size)
    mode[free] = modes[:, first].real
    mode *= 1e-5 / mode[link.end[1]]
    start = LinkState([mode], [np.zeros(link.size)])
    period = 2 * np.pi / frequency
    time = np.linspace(0.0, 3 * period, 61)
    run = simulate(engine, ConstantSpeed(1e-4), time, period / 400, start, integrator=integrator)
    expected = 1e-5 * np.cos(frequency * time)
    tip = run.displacement[0][:, link.end[1]]
    # Phase lag of the rule: (2 pi / 400)^2 / 12 of the angle, 4e-4 after three periods.
    assert np.abs(tip - expected).max() < 6e-9
    assert np.abs(
        run.rate[0][:, link.end[1]] + frequency * 1e-5 * np.sin(frequency * time)
    ).max() < (6e-9 * frequency)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_second_order_in_the_step(aluminium, integrator):
    engine, drive = ExudynEngine(aluminium, 2), ConstantSpeed(20.0, run_up_time=0.1)
    time = np.linspace(0.0, 0.16, 81)
    coarse, fine, finest = (
        middle_deflection(engine, simulate(engine, drive, time, h, integrator=integrator))
        for h in (4e-4, 2e-4, 1e-4)
    )
    ratio = np.linalg.norm(coarse - fine) / np.linalg.norm(fine - finest)
    assert ratio == pytest.approx(4.0, abs=0.4)


def test_both_integrators_agree(aluminium):
    engine, drive = ExudynEngine(aluminium, 4), ConstantSpeed(20.0, run_up_time=0.1)
    time = np.linspace(0.0, 0.2, 101)
    first, second = (
        middle_deflection(engine, simulate(engine, drive, time, 2e-4, integrator=name))
        for name in INTEGRATORS
    )
    assert np.abs(first - second).max() < 2e-3 * np.abs(first).max()


def test_coupler_at_20_rad_per_s_bends_as_published(aluminium):
    """Peak of the first revolution from rigid velocities, converged in mesh and step."""
    engine, drive = ExudynEngine(aluminium, 8), ConstantSpeed(20.0)
    time = np.linspace(0.0, drive.revolution_time, 721)
    peak = np.abs(middle_deflection(engine, simulate(engine, drive, time, 2e-4))).max()
    assert peak == pytest.approx(1.2247e-3, rel=2e-3)


def test_spin_up_of_a_long_arm():
    """Simo and Vu-Quoc (1986): the tip lags most, by 0.574 m, at 6.76 s."""
    section = BeamSection(
        axial_stiffness=2.8e7,
        bending_stiffness=1.4e4,
        shear_stiffness=1e7,
        mass_per_length=1.2,
        rotary_inertia=6e-4,
        in_plane_thickness=0.1,
    )
    engine = ExudynEngine(Mechanism(RotatingArm(10.0), {"arm": section}), 6)
    time = np.linspace(0.0, 7.0, 701)
    run = simulate(engine, ConstantSpeed(6.0, run_up_time=15.0), time, 5e-3)
    tip = run.displacement[0][:, engine.links[0].end[1]]
    assert tip.min() == pytest.approx(-0.574, abs=1e-3)
    assert time[tip.argmin()] == pytest.approx(6.76, abs=0.02)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("run_up_time", [0.0, 0.3])
@pytest.mark.parametrize("element", ELEMENTS)
def test_clamp_and_pivots_stay_in_place(element, run_up_time, integrator):
    """Without the clamp being put back the trapezoidal rule would lose 3e-4 rad here."""
    engine = arm(element)
    drive = ConstantSpeed(12.0, run_up_time, start_angle=2.0)
    run = simulate(engine, drive, np.linspace(0.0, 1.0, 51), 5e-3, integrator=integrator)
    link = engine.links[0]
    held = np.concatenate([link.start, link.start_rotation])
    # Newton's method leaves 3e-9 rad where the constraint is on the place.
    assert np.abs(run.displacement[0][:, held]).max() < 1e-8
    assert np.abs(run.displacement[0][:, link.end]).max() > 1e-3


# --- the recording ------------------------------------------------------------------------


def test_blocks_leave_no_trace(aluminium, monkeypatch):
    engine, drive = ExudynEngine(aluminium, 2), ConstantSpeed(20.0)
    time = np.linspace(0.0, 0.05, 23)
    whole = simulate(engine, drive, time, 5e-4)
    monkeypatch.setattr(simulation, "BLOCK_STEPS", 7)
    pieces = simulate(engine, drive, time, 5e-4)
    for name in ("displacement", "rate"):
        for one, other in zip(getattr(whole, name), getattr(pieces, name), strict=True):
            np.testing.assert_allclose(other, one, rtol=0, atol=1e-12)
    np.testing.assert_allclose(pieces.joint_force, whole.joint_force, rtol=0, atol=1e-12)
    assert pieces.energy_error == pytest.approx(whole.energy_error, rel=1e-6)


def test_first_row_is_the_start(laden):
    engine = ExudynEngine(laden, 4, "geometrically-exact")
    start = LinkState.rigid(engine.links)
    start.displacement[2][4:8] = 1e-4
    start.rate[2][4:8] = 0.3
    run = simulate(engine, ConstantSpeed(-15.0, start_angle=4.0), np.array([0.0]), 1e-5, start)
    for kept, given in ((run.displacement, start.displacement), (run.rate, start.rate)):
        for one, other in zip(kept, given, strict=True):
            np.testing.assert_allclose(one[0], other, rtol=0, atol=1e-13)


def test_progress_is_told_and_output_is_quiet(aluminium, capsys):
    calls = []

    def progress(done, total):
        calls.append((done, total))
        sys.stdout.write("told\n")

    engine = ExudynEngine(aluminium, 2)
    simulate(engine, ConstantSpeed(20.0), np.array([0.0, 0.0501]), 2e-4, progress=progress)
    assert calls == [(0, 251), (100, 251), (200, 251)]
    assert capsys.readouterr().out == "told\n" * 3


# --- failures -----------------------------------------------------------------------------


def test_a_step_that_does_not_converge_is_named(aluminium):
    with pytest.raises(
        ComputationError, match=r"0\.01 s, crank angle .* deg: Newton.*smaller than 0\.01"
    ):
        simulate(ExudynEngine(aluminium, 2), ConstantSpeed(3000.0), np.array([0.0, 1.0]), 0.01)


def test_values_that_are_not_finite_are_named(aluminium):
    engine = ExudynEngine(aluminium, 2)
    start = LinkState.rigid(engine.links)
    start.rate[1][4] = np.nan
    with pytest.raises(ComputationError, match=r"crank angle .* deg: the values are not finite"):
        simulate(engine, ConstantSpeed(20.0), np.array([0.0, 1.0]), 1e-3, start)


def test_an_interrupt_comes_through(aluminium):
    def interrupt(done, total):
        if done:
            raise KeyboardInterrupt

    engine = ExudynEngine(aluminium, 2)
    with pytest.raises(KeyboardInterrupt):
        simulate(engine, ConstantSpeed(20.0), np.array([0.0, 1.0]), 1e-3, progress=interrupt)


@pytest.mark.parametrize(
    ("time", "step", "options", "message"),
    [
        ([0.0, 1.0], 0.0, {}, "step must be positive"),
        ([0.0, 1.0], np.nan, {}, "step must be positive"),
        ([0.0, 0.0], 1e-3, {}, "increase"),
        ([], 1e-3, {}, "increase"),
        ([-1.0, 1.0], 1e-3, {}, "zero or later"),
        ([0.0, 1.0], 1e-3, {"integrator": "euler"}, "integrator must be one of"),
    ],
)
def test_what_cannot_be_is_refused(aluminium, time, step, options, message):
    with pytest.raises(InputError, match=message):
        simulate(ExudynEngine(aluminium, 2), ConstantSpeed(20.0), np.array(time), step, **options)


def test_a_start_that_tears_a_pin_is_refused(aluminium):
    engine = ExudynEngine(aluminium, 2)
    start = LinkState.rigid(engine.links)
    start.displacement[1][:2] = 1e-3
    with pytest.raises(InputError, match=r"joint holds by 0\.00141 m"):
        simulate(engine, ConstantSpeed(20.0), np.array([0.0, 1.0]), 1e-3, start)
