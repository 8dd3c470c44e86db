"""The periodic motion by Newton's method: both engines, and Exudyn's own simulation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from flexmech import ExudynEngine, ReferenceEngine, load_mechanism
from flexmech.analyses.frequencies.formulation import RunningStates
from flexmech.linear_system import LinkFrames, RotationTerms, inertia_loads
from flexmech.linkages import ConstantSpeed
from flexmech.multibody.link_parts import turn_vectors
from flexmech.time_domain import DrivenLinkage, LinkState, nonlinear_orbit, simulated_orbit


def damped(mechanism, time):
    sections = {k: s.with_damping_time(time) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def at_stations(engine, displacement):
    """Displacements of all links at their stations, (N, s)."""
    pairs = zip(engine.links, displacement, strict=True)
    moved = [np.einsum("scn,bn->bsc", link.shape, q).reshape(len(q), -1) for link, q in pairs]
    return np.concatenate(moved, axis=1)


def gap(first, second):
    return np.abs(first - second).max() / np.abs(first).max()


@pytest.mark.parametrize(
    ("name", "speed", "time", "tolerance"),
    [
        pytest.param("aluminium", 20.0, 0.0, 2e-3, marks=pytest.mark.thorough),
        pytest.param("steel", 60.0, 1e-4, 5e-3, marks=pytest.mark.thorough),
        pytest.param("steel", 100.0, 1e-4, 1e-2, marks=pytest.mark.thorough),
    ],
)
def test_engines_agree(mechanisms, name, speed, time, tolerance):
    mechanism = damped(mechanisms[name], time) if time else mechanisms[name]
    curves, orbits = [], []
    for kind in (ReferenceEngine, ExudynEngine):
        engine = kind(mechanism, elements=8)
        orbit = nonlinear_orbit(engine, speed)
        assert orbit.residual < 1e-9
        orbits.append(orbit)
        curves.append(at_stations(engine, orbit.displacement))
    assert gap(*curves) < tolerance
    assert orbits[0].distance == pytest.approx(orbits[1].distance, rel=0.02)


@pytest.mark.parametrize("name", ["aluminium", pytest.param("steel", marks=pytest.mark.thorough)])
def test_the_simulation_stays_on_the_orbit(mechanisms, name):
    """Exudyn's trapezoidal rule returns to where it started, to the error of its step.

    The quasi-static equilibrium is a tenth of the displacement away.
    """
    engine, drive = ExudynEngine(mechanisms[name], elements=4), ConstantSpeed(20.0)
    orbit = nonlinear_orbit(engine, 20.0, samples=96)
    assert orbit.distance > 0.05
    start = LinkState([q[0] for q in orbit.displacement], [r[0] for r in orbit.rate])
    time = drive.revolution_time / 96 * np.arange(97)
    exact = at_stations(engine, orbit.displacement)
    gaps = []
    for steps in (1440, 2880):
        run = engine.simulate(drive, start, time, drive.revolution_time / steps)
        gaps.append(gap(np.concatenate([exact, exact[:1]]), at_stations(engine, run.displacement)))
    assert gaps[1] < 3e-3
    assert gaps[1] < 0.4 * gaps[0]


@pytest.mark.parametrize("speed", [pytest.param(0.5, marks=pytest.mark.thorough), 5.0])
def test_stiff_links_at_low_speed(models, speed):
    """Strains of 1e-9: by places of nodes, instead of displacements, round-off would balance none.

    The engines' orbits differ by the mesh of Exudyn's linear beams: 3 % here, a fourth of that with
    twice the elements.
    """
    composite, curves = load_mechanism(models / "composite_fourbar.toml"), []
    for kind in (ReferenceEngine, ExudynEngine):
        engine = kind(composite, elements=6)
        orbit = nonlinear_orbit(engine, speed)
        assert orbit.residual < 1e-9
        assert orbit.passes == 1
        curves.append(at_stations(engine, orbit.displacement))
    assert gap(*curves) < 4e-2


@pytest.mark.thorough
def test_the_simulated_orbit_comes_to_it_with_its_step(aluminium):
    """Free vibrations that a step slows down shift what shooting finds by 5e-3 at 1440 steps."""
    engine, drive = ExudynEngine(aluminium, elements=6), ConstantSpeed(20.0)
    orbit = nonlinear_orbit(engine, 20.0, samples=96)
    exact, time = (
        at_stations(engine, orbit.displacement),
        drive.revolution_time / 96 * np.arange(97),
    )
    linkage = DrivenLinkage(engine, drive, with_energy=False)

    def off(steps):
        step = drive.revolution_time / steps
        found = simulated_orbit(linkage, steps, lambda s: engine.simulate(drive, s, time, step))
        return gap(exact, at_stations(engine, found.turn.displacement)[:-1])

    gaps = [off(steps) for steps in (1440, 2880, 5760)]
    assert gaps[0] < 1e-2
    assert gaps[1] < 0.4 * gaps[0]
    # What is left is that to which a turn closes.
    assert gaps[2] < 1.2e-3


@pytest.mark.thorough
def test_frequencies_on_the_orbit(aluminium):
    """V2, last row, and the shifts of the simulated orbit at other crank angles.

    Damped as in ``test_response``. The simulation's own start, at 0 deg, has axial forces of the
    linear equations, which move its first frequency by 0.015 Hz.
    """
    engine = ExudynEngine(damped(aluminium, 2e-4), elements=8)
    orbit, simulated = nonlinear_orbit(engine, 20.0, samples=36), RunningStates.of(engine, 20.0)
    places = np.array([0, 1, 6])
    angles = np.radians(10.0 * places)
    states = (None, [q[places] for q in orbit.displacement], simulated.at(angles))
    still, own, other = (lowest_two(engine, angles, running) for running in states)
    assert own[0] == pytest.approx([45.197, 47.663], rel=4e-4)
    assert (own - still)[1:] == pytest.approx((other - still)[1:], rel=0.1)


def lowest_two(engine, angles, running):
    """Frequencies in Hz without rotation terms, (A, 2)."""
    system = engine.linear_system(angles, 20.0, running=running, rotation_terms=False, modes=4)
    squares = [
        scipy.linalg.eigvalsh(k, m)[:2] for k, m in zip(system.stiffness, system.mass, strict=True)
    ]
    return np.sqrt(squares) / (2 * np.pi)


@pytest.mark.parametrize("kind", [ReferenceEngine, ExudynEngine])
def test_tangents_are_the_derivatives_of_the_internal_forces(aluminium, kind):
    engine = kind(aluminium, elements=3)
    motion = aluminium.linkage.motion(np.array([0.4]), np.array([30.0]))
    rng = np.random.default_rng(4)
    state = [2e-3 * rng.standard_normal((1, link.size)) for link in engine.links]
    way = [rng.standard_normal((1, link.size)) for link in engine.links]
    h = 1e-7
    ahead, behind = (
        engine.running_links(motion, [q + s * h * w for q, w in zip(state, way, strict=True)])
        for s in (1, -1)
    )
    stressed = engine.running_links(motion, state)
    for number, w in enumerate(way):
        slope = (ahead.internal_force[number] - behind.internal_force[number]) / (2 * h)
        expected = stressed.tangent[number] @ w[0]
        assert np.abs(slope - expected).max() < 1e-5 * np.abs(expected).max()


def test_forces_on_the_orbit_balance_in_ground_axes(aluminium):
    """Newton's second law by nodes' positions in space: no turning frame, no rotation term."""
    engine, speed, samples = ExudynEngine(aluminium, elements=4), 20.0, 256
    orbit = nonlinear_orbit(engine, speed, samples=samples)
    angle = 2 * np.pi / samples * np.arange(samples)
    motion = aluminium.linkage.motion(angle, np.full(samples, speed))
    stressed = engine.running_links(motion, orbit.displacement)
    parts, forces = engine.model.assembly.parts, []
    harmonic = speed * np.arange(samples // 2 + 1)
    for number, (link, q) in enumerate(zip(engine.links, orbit.displacement, strict=True)):
        place = link.fields.centripetal + q
        turn_vectors(place, parts[number].vectors, motion.angle[:, number])
        place += motion.origin[:, number, :1] * link.fields.along
        place += motion.origin[:, number, 1:] * link.fields.across
        spectrum = -(harmonic[:, None] ** 2) * np.fft.rfft(place, axis=0)
        moved = np.fft.irfft(spectrum, samples, axis=0) @ link.mass
        turn_vectors(moved, parts[number].vectors, -motion.angle[:, number])
        forces.append(moved)
        forces[-1] += stressed.internal_force[number]
    frames = LinkFrames(aluminium.linkage.topology, engine.links)
    load = frames.gather(motion, inertia_loads(engine.links, motion, aluminium.gravity))
    still = frames.assemble(
        motion, [link.stiffness for link in engine.links], RotationTerms(False, False, False)
    ).stiffness

    def work(force):
        return np.sum(force * np.linalg.solve(still, force[..., None])[..., 0])

    # 3e-2 at the quasi-static equilibrium; here 7e-5, from harmonics above the 64th.
    assert np.sqrt(work(frames.gather(motion, forces)) / work(load)) < 2e-4
