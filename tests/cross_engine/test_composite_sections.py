"""Thick and unsymmetric sections, as laminates have them: both engines, all that they do.

Exudyn's geometrically exact beams are linear. Bending converges in fourth order, but what pins
that move, stress and eccentric mass add is of third and second; where less is wanted than these
leave, frequencies and deflections are extrapolated from meshes one twice as fine as the other.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech import (
    BeamSection,
    ExudynEngine,
    FourBar,
    InputError,
    Mechanism,
    PointMass,
    ReferenceEngine,
    RotatingArm,
    natural_frequencies,
)
from flexmech.analyses import solve_frequencies, solve_modes
from flexmech.analyses.response.measurements import deflections
from flexmech.beams.theories import Timoshenko
from flexmech.linear_system import DeadMoments, inertia_loads
from flexmech.linkages import ConstantSpeed, inverse_dynamics
from flexmech.multibody.library import load_exudyn
from flexmech.multibody.linearize import static_equilibrium
from flexmech.sections import DampingTimes
from flexmech.threads import one_thread
from flexmech.time_domain import DrivenLinkage, LinkState, linear_run
from tests.support.strategies import fourbar as slender_fourbar

LINKS = ("crank", "coupler", "rocker")
HEIGHT = 0.25 / 8
ANGLES = np.radians([40.0, 200.0])
UNSYMMETRIC = (0.1, -0.05)
INTEGRATORS = ("trapezoidal", "generalized-alpha")


def section(neutral=0.0, mass=0.0, *, axial=2e7, shear=1 / 30):
    """Height an eighth of the rocker; axes by the height, shear by the axial stiffness."""
    per_length = 1600.0 * HEIGHT * 0.02
    return BeamSection(
        axial_stiffness=axial,
        bending_stiffness=axial * HEIGHT**2 / 12,
        shear_stiffness=axial * shear,
        mass_per_length=per_length,
        rotary_inertia=per_length * HEIGHT**2 / 12,
        in_plane_thickness=HEIGHT,
        neutral_axis=neutral * HEIGHT,
        mass_axis=mass * HEIGHT,
    )


def fourbar(axes=(0.0, 0.0), *, stiffness=2e7, shear=1 / 30, eccentric=LINKS, **more):
    sections = {
        name: section(*(axes if name in eccentric else (0.0, 0.0)), axial=stiffness, shear=shear)
        for name in LINKS
    }
    return Mechanism(FourBar(0.35, 0.12, 0.3, 0.25), sections, **more)


def laden(axes=UNSYMMETRIC, **more):
    return fourbar(
        axes,
        gravity=(3.0, -9.81),
        joint_masses={"A": 0.1, "B": 0.2},
        link_masses=(PointMass("coupler", 0.1, 0.05),),
        **more,
    )


def damped(mechanism, axial, bending, shear):
    times = DampingTimes(axial, bending, shear)
    sections = {k: replace(s, damping=times) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def uncoupled(mechanism):
    sections = {k: s.without_coupling() for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def reference(mechanism, elements):
    return ReferenceEngine(mechanism, elements, "timoshenko", component_modes=False)


def exudyn(mechanism, elements):
    return ExudynEngine(mechanism, elements, "geometrically-exact", component_modes=False)


def extrapolated(values):
    """Limit of values from meshes of which each is twice as fine as the one before.

    The error has even powers of the element length, as Romberg's trapezoidal sums have.
    """
    factor = 4
    while len(values) > 1:
        values = [(factor * b - a) / (factor - 1) for a, b in pairwise(values)]
        factor *= 4
    return values[0]


def frequencies(engine, speed, angles=ANGLES, **options):
    return natural_frequencies(engine, angles, speed, modes=4, **options)


def gap(mechanism, speed, meshes=(12, 24), **options):
    """Greatest relative difference of four frequencies, both engines on the same meshes.

    Extrapolated in third order. Rotation terms make an error of first order in the mesh, the
    same in both engines.
    """
    coarse, fine = (
        frequencies(exudyn(mechanism, n), speed, **options)
        / frequencies(reference(mechanism, n), speed, **options)
        for n in meshes
    )
    return np.abs((8 * fine - coarse) / 7 - 1).max()


# --- the linear system --------------------------------------------------------------------


@pytest.mark.parametrize("axes", [(0.0, 0.0), UNSYMMETRIC])
@pytest.mark.parametrize("speed", [0.0, 50.0])
def test_frequencies_agree(axes, speed):
    """Measured 4e-6, and 2.3e-5 of unsymmetric links, at rest and at 50 rad/s."""
    assert gap(fourbar(axes), speed) < (5e-5 if any(axes) else 1e-5)


@pytest.mark.parametrize("axes", [(0.0, 0.0), UNSYMMETRIC])
def test_eight_elements_are_enough(axes):
    """Linear elements as they are would be 2 to 10 percent high."""
    mechanism = fourbar(axes)
    exact = frequencies(reference(mechanism, 16), 0.0)
    error = np.abs(frequencies(exudyn(mechanism, 8), 0.0) / exact - 1).max(axis=0)
    assert error[:2].max() < 2e-4
    assert error.max() < 1e-3


def test_the_coupling_matters():
    """The first four frequencies of the unsymmetric links move by up to 7 percent."""
    mechanism = fourbar(UNSYMMETRIC)
    for speed in (0.0, 50.0):
        with_it, without = (
            frequencies(reference(m, 8), speed) for m in (mechanism, uncoupled(mechanism))
        )
        assert np.abs(without / with_it - 1).max() > 0.05


def test_tension_acts_along_the_normal_of_the_section(monkeypatch):
    """As in the exact beam (Haringx), not along the axis (Engesser): they differ by N / kGA.

    Measured 5e-6 and 6e-4 at 200 rad/s; the latter goes with the square of the speed.
    """
    options = {"angles": ANGLES[:1], "rotation_terms": False}
    assert gap(fourbar(), 200.0, **options) < 2e-5
    monkeypatch.setattr(Timoshenko, "softening", lambda self, section: 0.0)
    slow, fast = (gap(fourbar(), speed, **options) for speed in (100.0, 200.0))
    assert fast > 3e-4
    assert fast / slow == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("link", LINKS)
def test_one_unsymmetric_link_with_weight_and_masses(link):
    """Joints between a link with arms and links without; a node at a point mass."""
    assert gap(laden(eccentric=(link,)), 30.0, angles=ANGLES[:1]) < 5e-5


@pytest.mark.parametrize("speed", [0.0, 50.0])
def test_damping_ratios_agree(speed):
    """Stretching, bending and shear damped unlike, so that the arms tell them apart."""
    mechanism = damped(laden((0.3, -0.2)), 1e-4, 2e-5, 5e-5)
    ratios = [
        extrapolated(
            [
                solve_modes(engine(mechanism, n).linear_system(ANGLES[:1], speed), 4).damping_ratio
                for n in (6, 12, 24)
            ]
        )
        for engine in (exudyn, reference)
    ]
    np.testing.assert_allclose(ratios[0], ratios[1], rtol=5e-4)


def test_rigid_fields_meet_the_same_inertia():
    """Mass, Coriolis and centripetal matrices and the first moment, as in the reference."""
    mechanism = laden()
    for first, second in zip(
        exudyn(mechanism, 5).links, reference(mechanism, 5).links, strict=True
    ):
        fields = [
            np.stack([model.fields.along, model.fields.across, model.fields.tangential], axis=1)
            for model in (first, second)
        ]
        scale = np.abs(fields[1].T @ second.mass @ fields[1]).max()
        for name in ("mass", "gyroscopic", "centrifugal_mass"):
            one, other = (
                f.T @ getattr(model, name) @ f
                for model, f in zip((first, second), fields, strict=True)
            )
            np.testing.assert_allclose(one, other, rtol=0, atol=1e-12 * scale)
        for one, other in zip(
            first.first_moment @ fields[0], second.first_moment @ fields[1], strict=True
        ):
            np.testing.assert_allclose(one, other, rtol=0, atol=1e-12 * scale)


def test_unreduced_frequencies_are_exudyn_s_own():
    """At rest its own eigenvalues of the constrained system are an oracle."""
    mechanism, angles = laden(), np.radians([0.0, 70.0, 200.0, 310.0])
    engine = exudyn(mechanism, 6)
    model, motion = engine.model, mechanism.linkage.motion(angles)
    assembly = model.assembly
    computed = solve_frequencies(engine.linear_system(angles, prestress="none"), 6)
    initial = load_exudyn().ConfigurationType.Initial
    with one_thread():
        for number, expected in enumerate(computed):
            pose = assembly.arms.to_nodes(model.move_to(motion, number))
            assembly.mbs.systemData.SetODE2Coordinates(pose, initial)
            squares = np.sort(assembly.mbs.ComputeODE2Eigenvalues()[0])[:6]
            np.testing.assert_allclose(np.sqrt(squares) / (2 * np.pi), expected, rtol=1e-8)


@given(neutral=st.floats(-0.49, 0.49), mass=st.floats(-0.49, 0.49))
@settings(max_examples=20, deadline=None)
def test_a_section_s_mass_is_all_there(neutral, mass):
    """Mass, first moment and rotary inertia of a link are the section's, wherever its axes."""
    own = section(neutral, mass)
    link = exudyn(Mechanism(RotatingArm(0.25), {"arm": own}), 3).links[0]
    assert np.linalg.eigvalsh(link.mass).min() > 0
    kinds = (link.fields.along, link.fields.across, link.fields.tangential)
    total = np.array([[f @ link.mass @ g for g in kinds] for f in kinds]) / 0.25
    first = own.first_moment_of_mass
    whole, middle = own.mass_per_length, own.mass_per_length * 0.25 / 2
    turning = own.rotary_inertia + first * own.mass_axis + whole * 0.25**2 / 3
    expected = [[whole, 0.0, -first], [0.0, whole, middle], [-first, middle, turning]]
    np.testing.assert_allclose(total, expected, rtol=1e-12, atol=1e-15)
    moment = link.first_moment[0]
    assert moment @ link.fields.along == pytest.approx(0.25 * first, rel=1e-12, abs=1e-15)
    arms = -0.25 * whole * own.mass_axis**2
    assert moment[link.readings.slope :: link.readings.per_node].sum() == pytest.approx(
        arms, rel=1e-12, abs=1e-15
    )


# --- the state of stress ------------------------------------------------------------------


def strain_energy(engine, link, displacement):
    """Of a link displaced in its frame; ``displacement`` (m, n) are those of the pins' axis."""
    assembly = engine.model.assembly
    part = assembly.parts[link]
    section = part.section
    nodes = part.arms.to_nodes(displacement)
    strains = assembly.kind.strains(nodes, 0 * nodes, np.diff(part.positions), section)
    return sum(strain.energy for strain in strains)


@pytest.fixture(scope="module")
def bent():
    """Soft links, bent by a fifteenth of a radian, and their equilibrium at two positions."""
    engine = exudyn(laden((0.3, -0.2), stiffness=2e5), 6)
    motion = engine.mechanism.linkage.motion(ANGLES, 80.0)
    loads = inertia_loads(engine.links, motion, engine.mechanism.gravity)
    dead = DeadMoments.of(engine.links, motion, engine.mechanism.gravity, loads)
    equilibrium = static_equilibrium(engine.model, motion, loads, dead)
    assert max(np.abs(q).max() for q in equilibrium.displacement) > 0.05
    return engine, motion, loads, dead, equilibrium


def test_inner_forces_balance_the_loads(bent):
    """The derivative of the strain energy is the load, but where joints and clamp act.

    That on matter off the axis is the less the farther its arm has turned.
    """
    engine, _, loads, dead, equilibrium = bent
    fallen = [np.zeros_like(load.T) for load in loads]
    dead.add_forces(fallen, [q.T for q in equilibrium.displacement])
    acting = [load - less.T for load, less in zip(loads, fallen, strict=True)]
    assert (
        max(np.abs(less).max() / np.abs(f).max() for less, f in zip(fallen, loads, strict=True))
        > 1e-5
    )
    for link, (place, load) in enumerate(zip(equilibrium.displacement, acting, strict=True)):
        model = engine.links[link]
        joined = [*model.start, *model.end, *(model.start_rotation if link == 0 else ())]
        free = np.setdiff1d(np.arange(model.size), joined)
        away = 1e-6 * np.eye(model.size)[free]
        for state, force in zip(place, load, strict=True):
            higher, lower = (strain_energy(engine, link, state + d) for d in (away, -away))
            gradient = (higher - lower) / 2e-6
            assert np.abs(gradient - force[free]).max() < 1e-7 * np.abs(force).max()


def test_tangent_is_the_second_derivative_of_the_strain_energy(bent):
    engine, motion, _, dead, equilibrium = bent
    running = engine.running_clamped_links(motion, equilibrium.displacement)
    turning = dead.rotation_stiffness([q.T for q in equilibrium.displacement])
    random = np.random.default_rng(1)
    for link, (place, tangent) in enumerate(
        zip(equilibrium.displacement, equilibrium.tangent, strict=True)
    ):
        np.testing.assert_allclose(running.tangent[link], tangent, rtol=0, atol=1e-4)
        rows, stiffness = turning[link]
        tangent[:, rows, rows] -= stiffness.T
        for state, matrix in zip(place, tangent, strict=True):
            away = random.normal(0, 1e-4, (8, len(state))) * np.tile(
                [0.01, 0.01, 1], len(state) // 3
            )
            middle = strain_energy(engine, link, state[None])
            ends = [strain_energy(engine, link, state + d) for d in (away, -away)]
            curvature = np.einsum("mi,ij,mj->m", away, matrix, away)
            np.testing.assert_allclose(sum(ends) - 2 * middle, curvature, rtol=1e-5)


def test_equilibrium_is_that_of_the_reference():
    """Displacements of the pins' axis at places where every mesh has a node."""
    mechanism = fourbar(UNSYMMETRIC, gravity=(3.0, -9.81), joint_masses={"B": 0.2})
    motion = mechanism.linkage.motion(ANGLES, 50.0)

    def displaced(engine):
        state = engine.stressed_links(motion, "equilibrium").displacement
        pairs = zip(engine.links, state, strict=True)
        return np.stack([q @ link.shape[::5].transpose(1, 2, 0) for link, q in pairs])

    exact = displaced(reference(mechanism, 8))
    found = extrapolated([displaced(exudyn(mechanism, n)) for n in (4, 8, 16)])
    assert np.abs(found - exact).max() < 2e-4 * np.abs(exact).max()


# --- the run ------------------------------------------------------------------------------


def deflected(engine, drive, time, step):
    """Middle deflections of all links (N, links) from rest, and the run."""
    if isinstance(engine, ExudynEngine):
        run = engine.simulate(drive, LinkState.rigid(engine.links), time, step)
    else:
        linkage = DrivenLinkage(engine, drive, "equilibrium")
        run = linear_run(linkage, linkage.unstressed(), np.zeros(linkage.size), time, step)
    return deflections(engine, run), run


def test_runs_of_both_engines_agree():
    """Run-up of undamped unsymmetric links: 3e-4 of the peaks apart, 8e-2 without coupling.

    Over more periods of vibration the meshes' own frequencies, a few thousandths apart before
    the extrapolation, run out of phase.
    """
    drive, step = ConstantSpeed(20.0, run_up_time=0.05), 1e-4
    time = np.linspace(0.0, 0.05, 101)
    mechanism = fourbar(UNSYMMETRIC, stiffness=2e6)
    exact, linear = deflected(reference(mechanism, 6), drive, time, step)
    curves, runs = zip(
        *(deflected(exudyn(mechanism, n), drive, time, step) for n in (8, 16)), strict=True
    )
    peak = np.abs(exact).max(axis=0)
    assert np.all(np.abs(extrapolated(curves) - exact).max(axis=0) < 5e-4 * peak)
    without, _ = deflected(reference(uncoupled(mechanism), 3), drive, time, step)
    assert np.all(np.abs(without - exact).max(axis=0) > 0.08 * peak)
    for run in (*runs, linear):
        assert run.energy_error < 1e-5


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("times", [(0.0, 0.0, 0.0), (1e-3, 2e-5, 5e-5)])
def test_energy_is_balanced(times, integrator):
    """With weight and masses: the balance closes in second order of the step."""
    mechanism, errors = damped(laden((0.3, -0.2), stiffness=2e6), *times), []
    engine, drive = exudyn(mechanism, 3), ConstantSpeed(30.0)
    for step in (2e-4, 1e-4):
        time = np.linspace(0.0, 0.1, 11)
        start = LinkState.rigid(engine.links)
        errors.append(engine.simulate(drive, start, time, step, integrator=integrator).energy_error)
    assert errors[1] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.3)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_stiff_links_have_the_forces_of_rigid_ones(integrator):
    """Joint forces and torque through arms, with the centres of mass off the pins' axis."""
    mechanism = damped(laden(stiffness=2e9), 2e-6, 2e-6, 2e-6)
    engine = ExudynEngine(mechanism, 3)
    drive = ConstantSpeed(-8.0, run_up_time=0.2, start_angle=1.0)
    motion = mechanism.linkage.motion(drive.crank_angle(np.zeros(1)))
    loads = inertia_loads(engine.links, motion, mechanism.gravity)
    dead = DeadMoments.of(engine.links, motion, mechanism.gravity, loads)
    sagging = static_equilibrium(engine.model, motion, loads, dead).displacement
    start = LinkState([q[0] for q in sagging], LinkState.rigid(engine.links).rate)
    time = np.linspace(0.0, 0.4, 41)
    run = engine.simulate(drive, start, time, 5e-4, integrator=integrator)
    motion = mechanism.linkage.motion(
        drive.crank_angle(time), drive.crank_speed(time), drive.crank_acceleration(time)
    )
    rigid = inverse_dynamics(
        mechanism.linkage.topology, motion, mechanism.link_masses_in_order, mechanism.gravity
    )
    names = mechanism.linkage.topology.joint_names
    forces = np.stack([rigid.joint_force[name] for name in names], axis=1)
    assert np.abs(run.joint_force - forces).max() < 1e-3 * np.abs(forces).max()
    assert (
        np.abs(run.driving_torque - rigid.driving_torque).max()
        < 2e-3 * np.abs(rigid.driving_torque).max()
    )


def test_small_vibration_is_that_of_the_linear_model():
    """A clamped arm that hardly turns, started in its first mode, stretch and all."""
    engine = ExudynEngine(Mechanism(RotatingArm(0.25, 0.1), {"arm": section(*UNSYMMETRIC)}), 4)
    link, free = engine.links[0], slice(3, None)
    squares, modes = np.linalg.eig(
        np.linalg.solve(link.mass[free, free], link.stiffness[free, free])
    )
    first = np.argmin(squares.real)
    frequency, mode = np.sqrt(squares.real[first]), np.zeros(link.size)
    mode[free] = modes[:, first].real
    mode *= 1e-6 / mode[link.end[1]]
    time = np.linspace(0.0, 6 * np.pi / frequency, 31)
    start = LinkState([mode], [np.zeros(link.size)])
    run = engine.simulate(ConstantSpeed(1e-4), start, time, time[-1] / 1200)
    expected = mode * np.cos(frequency * time)[:, None]
    scale = np.abs(expected).max(axis=0)[-3:]
    assert np.all(np.abs(run.displacement[0] - expected).max(axis=0)[-3:] < 4e-3 * scale)
    assert scale[0] > 0.01 * scale[1]


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_start_and_joints_are_kept(integrator):
    engine = exudyn(laden(stiffness=2e6), 3)
    start = LinkState.rigid(engine.links)
    start.displacement[2][3:6] = 1e-4, -2e-4, 0.01
    start.rate[2][3:6] = 0.3, 0.1, 0.2
    start.displacement[2][-1], start.rate[2][-1] = 0.02, -0.4
    drive = ConstantSpeed(-15.0, start_angle=4.0)
    time = np.linspace(0.0, 0.2, 41)
    run = engine.simulate(drive, start, time, 2e-4, integrator=integrator)
    for kept, given_ in ((run.displacement, start.displacement), (run.rate, start.rate)):
        for one, other in zip(kept, given_, strict=True):
            np.testing.assert_allclose(one[0], other, rtol=0, atol=1e-13)
    crank, _, rocker = engine.links
    held = run.displacement[0][:, [*crank.start, *crank.start_rotation]]
    pivot = run.displacement[2][:, rocker.start]
    # Velocity constraints alone would let the pivot drift by 4e-6 m.
    assert max(np.abs(held).max(), np.abs(pivot).max()) < 1e-8
    torn = LinkState.rigid(engine.links)
    torn.displacement[1][:2] = 1e-3
    with pytest.raises(InputError, match=r"joint holds by 0\.00141 m"):
        engine.simulate(drive, torn, time, 2e-4)


# --- the choice of the element ------------------------------------------------------------


def test_cables_of_eccentric_sections_are_refused():
    mechanism = fourbar(UNSYMMETRIC, eccentric=("coupler",))
    with pytest.raises(InputError, match=r"section of coupler .* use element 'geometrically"):
        ExudynEngine(mechanism, 4, "ancf")
    with pytest.raises(InputError, match=r"cannot: use prestress 'equilibrium'"):
        ExudynEngine(mechanism, 4).linear_system(0.0, 10.0, prestress="axial")


def test_the_element_left_out_follows_the_sections():
    assert ExudynEngine(slender_fourbar(), 4).element == "ancf"
    assert ExudynEngine(fourbar(), 4).element == "geometrically-exact"  # thick links
    for axes in ((0.1, 0.0), (0.0, 0.1)):
        engine = ExudynEngine(fourbar(axes, eccentric=("rocker",)), 4)
        assert engine.element == "geometrically-exact"
        assert engine.with_(elements=6).unreduced().element == "geometrically-exact"
