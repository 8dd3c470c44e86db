"""The running linkage in moving modes: Hamiltonian, and the same as the unreduced equations."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import scipy.integrate
import scipy.interpolate
import scipy.linalg
from _ground_axes import frozen_eigenvalues, in_ground_axes

from flexmech import ExudynEngine, Mechanism, ReferenceEngine, load_mechanism
from flexmech.analyses.frequencies.eigenproblem import solve_eigenvalues
from flexmech.arrays import FloatArray
from flexmech.choices import MovingFrame
from flexmech.dynamical_systems import FloquetModes, floquet_modes, transition_matrices
from flexmech.linear_system import Engine, Prestress
from flexmech.time_domain import SampledTurn, counts_of_modes, moving_modes
from flexmech.time_domain.periodic_motion.nodal_frames import inertia_in_ground_axes

SAMPLES = 128
MODES = 6
NAMES = ("aluminium", "steel")
FRAMES: tuple[MovingFrame, ...] = ("link", "inertial")
LOADED: tuple[Prestress, ...] = ("axial", "equilibrium")


def sampled(
    engine: Engine, speed: float, prestress: Prestress, samples: int = SAMPLES
) -> SampledTurn:
    angle = np.sign(speed) * 2 * np.pi / samples * np.arange(samples)
    motion = engine.mechanism.linkage.motion(angle, speed)
    stressed = engine.stressed_links(motion, prestress)
    return SampledTurn.of(engine, motion, stressed, prestress, MODES)


def damped(mechanism: Mechanism, time: float) -> Mechanism:
    sections = {k: s.with_damping_time(time) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def steps_of(turn: SampledTurn, count: int, radians: float = 1.5) -> int:
    """Steps of so many radians of the fastest moving mode."""
    fastest = np.sqrt(turn.frozen_squares[:, count - 1].max())
    return int(np.ceil(fastest * turn.period / radians))


def multipliers(modes: FloquetModes) -> FloatArray:
    return np.exp(modes.exponent * modes.period)


def farthest(first: FloatArray, second: FloatArray) -> float:
    """Greatest distance of one of the first numbers from the nearest of the second."""
    return float(np.abs(first[:, None] - second).min(axis=1).max())


@pytest.mark.parametrize("prestress", LOADED)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("speed", [20.0, 60.0, -20.0])
def test_undamped_linkage_is_hamiltonian(mechanisms, name, prestress, speed):
    turn = sampled(ReferenceEngine(mechanisms[name]), speed, prestress)
    for count in counts_of_modes(turn, MODES, 2):
        system = moving_modes(turn, count).system(damping=0.0)
        steps = steps_of(turn, count)
        whole = np.eye(2 * count)
        for transition in transition_matrices(system, steps):
            whole = transition @ whole
        eye, nothing = np.eye(count), np.zeros((count, count))
        form = np.block([[nothing, -eye], [eye, nothing]])
        assert np.abs(whole.T @ form @ whole - form).max() < 1e-8


@pytest.mark.parametrize("prestress", LOADED)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("speed", [20.0, 60.0, -60.0])
def test_moduli_are_one_as_the_steps_double(mechanisms, name, prestress, speed):
    turn = sampled(ReferenceEngine(mechanisms[name]), speed, prestress)
    count = counts_of_modes(turn, MODES, 1)[0]
    system = moving_modes(turn, count).system(damping=0.0)
    for factor in (1, 2, 4):
        modes = floquet_modes(system, factor * steps_of(turn, count))
        found = multipliers(modes)
        gaps = np.abs(found[:, None] - found) + 10 * np.eye(len(found))
        apart = gaps.min(axis=1) > 1e-3
        assert apart.any()
        assert np.abs(np.exp(modes.log_modulus[apart]) - 1).max() < 1e-8
        assert modes.liouville_defect < 1e-10


def test_moduli_grow_inside_a_band(mechanisms):
    # The aluminium linkage has a band near 88 rad/s with axial geometric stiffness; that the
    # moduli are one elsewhere is no matter of the method.
    turn = sampled(ReferenceEngine(mechanisms["aluminium"]), 88.0, "axial")
    count = counts_of_modes(turn, MODES, 1)[0]
    system = moving_modes(turn, count).system(damping=0.0)
    modes = floquet_modes(system, steps_of(turn, count))
    assert modes.log_modulus[0] > 1e-2
    assert modes.log_modulus == pytest.approx(-modes.log_modulus[::-1], abs=1e-10)


def soft(mechanism: Mechanism, time: float = 0.0) -> Mechanism:
    """A stocky linkage whose axial modes are slow enough to integrate: EA / 400, EI / 4."""
    sections = {
        k: replace(
            s,
            axial_stiffness=s.axial_stiffness / 400,
            bending_stiffness=s.bending_stiffness / 4,
        )
        for k, s in mechanism.sections.items()
    }
    made = replace(mechanism, sections=sections)
    return damped(made, time) if time else made


def integrated_monodromy(
    engine: Engine, speed: float, prestress: Prestress, frame: MovingFrame = "link"
) -> FloatArray:
    """Transition matrix of a turn of ``M z'' + C z' + K z = 0`` by an explicit Runge-Kutta code.

    In all coordinates of the link frames, with all rotation terms; the matrices between the
    crank angles by periodic cubic splines.
    """
    count = 2880
    angle = 2 * np.pi / count * np.arange(count + 1)
    system = engine.unreduced().linear_system(angle, speed, prestress=prestress)
    if frame == "inertial":
        system = in_ground_axes(system)
    size = system.size
    matrix = np.zeros((count + 1, 2 * size, 2 * size))
    matrix[:, :size, size:] = np.eye(size)
    matrix[:, size:, :size] = -np.linalg.solve(system.mass, system.stiffness)
    matrix[:, size:, size:] = -np.linalg.solve(system.mass, system.damping)
    matrix[-1] = matrix[0]
    period = 2 * np.pi / speed
    spline = scipy.interpolate.CubicSpline(angle / speed, matrix, bc_type="periodic")

    def rate(t: float, x: FloatArray) -> FloatArray:
        return (spline(t) @ x.reshape(2 * size, -1)).ravel()

    run = scipy.integrate.solve_ivp(
        rate, (0, period), np.eye(2 * size).ravel(), method="DOP853", rtol=1e-11, atol=1e-13
    )
    return run.y[:, -1].reshape(2 * size, -1)


@pytest.mark.thorough
@pytest.mark.parametrize("prestress", LOADED)
@pytest.mark.parametrize("time", [0.0, 1e-3])
def test_multipliers_of_the_unreduced_equations(mechanisms, prestress, time):
    # Nothing is reduced here: canonical form, rates by Fourier series and Magnus expansion
    # against the second-order equations, whose rotation terms are written out.
    engine = ReferenceEngine(soft(mechanisms["aluminium"], time), elements=1, component_modes=False)
    turn = sampled(engine, 30.0, prestress, samples=256)
    moving = moving_modes(turn, turn.frames.size)
    found = multipliers(floquet_modes(moving.system(), 8 * steps_of(turn, moving.size)))
    expected = np.linalg.eigvals(integrated_monodromy(engine, 30.0, prestress))
    assert len(found) == len(expected)
    assert farthest(found, expected) < 1e-8
    assert farthest(expected, found) < 1e-8
    if time:
        # Far from where they would be without damping, so that its terms count.
        assert np.abs(found).max() < 0.2


@pytest.mark.parametrize("time", [0.0, 2e-4])
@pytest.mark.parametrize("speed", [30.0, -30.0])
def test_rotating_arm_has_the_eigenvalues_of_its_constant_system(models, time, speed):
    mechanism = damped(load_mechanism(models / "rotating_arm.toml"), time)
    engine = ReferenceEngine(mechanism, elements=4)
    turn = sampled(engine, speed, "axial", samples=32)
    moving = moving_modes(turn, counts_of_modes(turn, MODES, 1)[0])
    modes = floquet_modes(moving.system(), 128)
    system = engine.unreduced().linear_system(0.0, speed, prestress="axial")
    size = system.size
    matrix = np.block(
        [
            [np.zeros((size, size)), np.eye(size)],
            [-np.linalg.solve(system.mass[0], np.hstack((system.stiffness[0], system.damping[0])))],
        ]
    )
    expected = scipy.linalg.eigvals(matrix)
    assert len(expected) == len(modes.exponent)
    gap = modes.exponent[:, None] - expected
    # Imaginary parts are known but for multiples of the crank speed.
    turned = gap.imag - abs(speed) * np.round(gap.imag / abs(speed))
    relative = np.hypot(gap.real, turned) / np.abs(expected)
    assert relative.min(axis=1).max() < 1e-9
    assert relative.min(axis=0).max() < 1e-9


def lowest(modes: FloquetModes, count: int) -> FloatArray:
    """The multipliers that die out least, of damped modes those of the lowest frequencies."""
    return multipliers(modes)[:count]


@pytest.mark.parametrize("prestress", LOADED)
def test_each_moving_mode_more_changes_less(mechanisms, prestress):
    turn = sampled(ReferenceEngine(damped(mechanisms["aluminium"], 2e-5)), 60.0, prestress)
    counts = counts_of_modes(turn, 2, 4)
    assert len(counts) == 4
    found = []
    for count in counts:
        modes = floquet_modes(moving_modes(turn, count).system(), 2 * steps_of(turn, count))
        found.append(lowest(modes, 4))
    changes = [farthest(*pair) for pair in pairwise(found)]
    assert changes == sorted(changes, reverse=True)
    assert changes[-1] < changes[0] / 10
    assert changes[-1] < 1e-4


@pytest.mark.parametrize("time", [0.0, 2e-5])
def test_running_backwards_and_mirrored(mechanisms, time):
    # A mirrored linkage (its branch is the other one) that runs backwards is the same. So is
    # one that runs backwards: its equations are the adjoint ones in reversed time.
    forward = damped(mechanisms["aluminium"], time) if time else mechanisms["aluminium"]
    mirrored = replace(forward, linkage=replace(forward.linkage, branch="crossed"))
    found = []
    for mechanism, speed in ((forward, 40.0), (mirrored, -40.0), (forward, -40.0)):
        turn = sampled(ReferenceEngine(mechanism), speed, "axial")
        moving = moving_modes(turn, counts_of_modes(turn, MODES, 1)[0])
        found.append(multipliers(floquet_modes(moving.system(), 512)))
    assert farthest(found[0], found[1]) < 1e-9
    assert farthest(found[0], found[2]) < 1e-9


def in_both_frames(engine: Engine, speed: float, prestress: Prestress) -> list[FloatArray]:
    turn = sampled(engine, speed, prestress, samples=512)
    count = counts_of_modes(turn, MODES, 1)[0]
    return [
        multipliers(
            floquet_modes(moving_modes(turn, count, frame=frame).system(), steps_of(turn, count))
        )
        for frame in FRAMES
    ]


@pytest.mark.parametrize("prestress", LOADED)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("time", [pytest.param(0.0, marks=pytest.mark.thorough), 2e-5])
def test_multipliers_do_not_depend_on_the_frame(mechanisms, name, prestress, time):
    mechanism = damped(mechanisms[name], time) if time else mechanisms[name]
    for speed in (20.0, -60.0):
        link, inertial = in_both_frames(ReferenceEngine(mechanism, elements=4), speed, prestress)
        assert farthest(inertial, link) < 1e-8
        assert farthest(link, inertial) < 1e-8


def test_cables_have_no_terms_of_turning_frames_in_ground_axes(mechanisms):
    engine = ExudynEngine(mechanisms["aluminium"], elements=4)
    for link in engine.links:
        (_, gyroscopic, centrifugal), size = inertia_in_ground_axes(link), np.abs(link.mass).max()
        assert np.abs(gyroscopic).max() < 1e-12 * size
        assert np.abs(centrifugal).max() < 1e-12 * size
    link, inertial = in_both_frames(engine, 20.0, "axial")
    assert farthest(inertial, link) < 1e-8


def test_what_beams_do_not_turn_with_their_nodes_falls_with_their_length(mechanisms):
    # In a rotation about the link's start the nodes move as the link, but displacements along
    # and across between them are of different degree; bending shows it.
    left = []
    for elements in (2, 4, 8):
        link = ReferenceEngine(mechanisms["aluminium"], elements=elements).links[1]
        place = link.fields.centripetal / link.fields.centripetal.max()
        bow = np.zeros(link.size)
        bow[1::3] = np.sin(np.pi * place[0::3])
        bow[2::3] = np.pi / link.fields.centripetal.max() * np.cos(np.pi * place[0::3])
        gyroscopic = inertia_in_ground_axes(link)[1]
        left.append(np.linalg.norm(gyroscopic @ bow) / np.linalg.norm(link.gyroscopic @ bow))
    assert left[0] > 1e-3
    assert np.all(np.diff(np.log2(left)) < -1.5)


@pytest.mark.thorough
def test_matrices_in_ground_axes_are_the_same_system(mechanisms):
    # Frozen eigenvalues differ, those of a whole turn do not.
    engine = ReferenceEngine(soft(mechanisms["aluminium"], 1e-3), elements=1, component_modes=False)
    link, inertial = (
        np.linalg.eigvals(integrated_monodromy(engine, 30.0, "axial", frame)) for frame in FRAMES
    )
    assert farthest(inertial, link) < 1e-8
    assert farthest(link, inertial) < 1e-8


def test_frozen_eigenvalues_at_rest_do_not_depend_on_the_frame(mechanisms):
    engine = ReferenceEngine(damped(mechanisms["steel"], 2e-5), elements=4)
    link, inertial = (
        frozen_eigenvalues(engine, [0.3, 2.0, 4.0], 0.0, prestress="none", frame=frame, modes=4)
        for frame in FRAMES
    )
    np.testing.assert_allclose(inertial, link, rtol=1e-8)


@pytest.mark.parametrize("engine_kind", [ReferenceEngine, ExudynEngine])
def test_frozen_eigenvalues_of_a_running_linkage_depend_on_the_frame(mechanisms, engine_kind):
    engine = engine_kind(damped(mechanisms["aluminium"], 2e-5), elements=4)
    link, inertial = (
        frozen_eigenvalues(engine, [0.0, 2.0], 60.0, prestress="axial", frame=frame, modes=2)
        for frame in FRAMES
    )
    assert (np.abs(link.real - inertial.real) / np.abs(link.real)).min() > 5e-3
    expected = engine.linear_system([0.0, 2.0], 60.0, prestress="axial")
    np.testing.assert_allclose(np.abs(link), np.abs(solve_eigenvalues(expected, 2)), rtol=1e-3)


def test_an_arm_in_ground_axes_has_its_flapping_frequencies(models):
    # Along the ground's axes the centripetal term is missing: chord^2 + speed^2, as in V3.
    engine = ReferenceEngine(load_mechanism(models / "rotating_arm.toml"), elements=8)
    link, inertial = (
        np.abs(frozen_eigenvalues(engine, 1.1, 30.0, prestress="axial", frame=frame, modes=1))
        for frame in FRAMES
    )
    assert inertial**2 == pytest.approx(link**2 + 30.0**2, rel=2e-4)
    assert inertial > link + 1
