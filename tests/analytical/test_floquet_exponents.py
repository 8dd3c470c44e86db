"""Floquet modes of systems whose exponents are known, by the propagator of sixth order."""

from collections.abc import Callable

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import (
    FloquetModes,
    StatedPeriodicSystem,
    floquet_modes,
    transition_matrices,
)
from flexmech.errors import ComputationError
from flexmech.verification import VerificationCase, verification_cases
from flexmech.verification.methods.periodic_systems import known_system

LIOUVILLE = 1e-12


def entries(*rows: tuple[object, ...]) -> FloatArray:
    """Stack (N, n, n) from entries that are numbers or functions' values (N,)."""
    flat = np.broadcast_arrays(*[np.asarray(value, dtype=float) for row in rows for value in row])
    return np.stack(flat, axis=-1).reshape(*flat[0].shape, len(rows), len(rows[0]))


# Validation V10, cases of the verification.
KNOWN = [case for case in verification_cases() if case.measured_by.method == "known_exponents"]


def constant(matrix: FloatArray, period: float) -> StatedPeriodicSystem:
    return StatedPeriodicSystem(lambda t: np.broadcast_to(matrix, (len(t), *matrix.shape)), period)


def uneven(matrix: FloatArray, period: float) -> StatedPeriodicSystem:
    """A system that runs through a constant one at a periodic pace: with its exponents."""

    def paced(t: FloatArray) -> FloatArray:
        return np.asarray((1 + 0.3 * np.cos(2 * np.pi / period * t))[:, None, None] * matrix)

    return StatedPeriodicSystem(paced, period)


def with_exponents(exponents: list[float], seed: int) -> FloatArray:
    """Constant matrix of those eigenvalues in general directions."""
    vectors = np.random.default_rng(seed).normal(size=(len(exponents), len(exponents)))
    return np.asarray(vectors * exponents @ np.linalg.inv(vectors), dtype=float)


@pytest.mark.parametrize("case", [pytest.param(case, id=case.name) for case in KNOWN])
@pytest.mark.parametrize("steps", [257, 1000])
def test_known_exponents(case: VerificationCase, steps: int) -> None:
    found = case.measured_by.with_(steps=steps).values()
    assert found == pytest.approx(case.expected_values(), abs=case.tolerance)
    modes = floquet_modes(known_system(case.measured_by.settings["system"]), steps)
    assert modes.liouville_defect < LIOUVILLE


def test_one_monodromy_matrix_loses_the_weak_multiplier() -> None:
    # What the trap is for: without short matrices nothing is left of exp(-48 pi).
    system, whole = known_system("trap"), np.eye(2)
    for transition in transition_matrices(system, 256):
        whole = transition @ whole
    weakest = np.log(np.abs(np.linalg.eigvals(whole))).min() / system.period
    assert abs(weakest + 24) > 10


@pytest.mark.parametrize("case", [pytest.param(case, id=case.name) for case in KNOWN[:2]])
def test_error_falls_with_the_sixth_power_of_the_step(case: VerificationCase) -> None:
    counts = np.array([64, 128, 256])
    errors = [
        np.abs(case.measured_by.with_(steps=int(count)).values() - case.expected_values()).max()
        for count in counts
    ]
    rates = np.diff(np.log(errors)) / np.diff(np.log(counts))
    assert rates[-1] == pytest.approx(-6, abs=0.3)


@given(seed=st.integers(0, 10**6), steps=st.integers(16, 70), size=st.integers(1, 7))
@settings(max_examples=30, deadline=None)
def test_constant_systems_are_solved_exactly(seed: int, steps: int, size: int) -> None:
    matrix = 0.3 * np.random.default_rng(seed).normal(size=(size, size))
    modes = floquet_modes(constant(matrix, 1.3), steps)
    expected = np.linalg.eigvals(matrix)
    # No eigenvalue turns by more than pi in this period. Those of a cluster are ill conditioned,
    # and round-off adds up over the steps.
    condition = np.linalg.cond(np.linalg.eig(matrix)[1])
    gaps = np.abs(modes.exponent[:, None] - expected)
    assert gaps.min(axis=1).max() < 1e-14 * steps * condition
    assert gaps.min(axis=0).max() < 1e-14 * steps * condition
    assert modes.liouville_defect < LIOUVILLE


@pytest.mark.parametrize(
    "exponents",
    [
        [0.0, -2000.0],
        [0.0, -1.0, -2000.0, -2001.0],
        [0.0, -150.8, -157.1],
        [-3.0 * k for k in range(20)],
        [-1.0 * k for k in range(40)],
        [-6.0 * k for k in range(12)],
        [0.0, -1.0, -8e3, -9e3],
        [20.0, 19.0, -19.0, -20.0],
    ],
    ids=[
        "underflow",
        "two groups",
        "near and far",
        "chain of 3",
        "chain of 1",
        "chain of 6",
        "lost in a step",
        "grown",
    ],
)
@pytest.mark.parametrize("steps", [251, 512])
def test_multipliers_far_apart(exponents: list[float], steps: int) -> None:
    modes = floquet_modes(uneven(with_exponents(exponents, 1), 1.0), steps)
    # The matrix itself has its eigenvalues to its round-off only.
    size = max(abs(value) for value in exponents)
    assert modes.log_modulus == pytest.approx(np.array(exponents), abs=1e-9 * size)
    assert modes.liouville_defect < 1e-9


@pytest.mark.parametrize("weak", [-24.0, -2000.0])
def test_a_weak_invariant_subspace_that_stands_first(weak: float) -> None:
    # Columns of the unit matrix span the weak modes: iteration from it would leave them first.
    matrix = np.array([[weak, 0.0, 5.0], [0.0, 2 * weak, 1.0], [0.0, 0.0, 0.5]])
    modes = floquet_modes(uneven(matrix, 1.0), 600)
    assert modes.log_modulus == pytest.approx(np.array([0.5, weak, 2 * weak]), rel=1e-11)
    # Where the pace is that of the mean, and what it has gained is made up for.
    shapes = modes.shapes()[0]
    assert np.abs(matrix @ shapes - shapes * modes.exponent).max() < 1e-9 * np.abs(weak)


def test_a_constant_system_whose_modes_die_out_within_a_step() -> None:
    matrix = with_exponents([0.0, -1.0, -1e7, -2e7], 3)
    modes = floquet_modes(constant(matrix, 1.0), 32)
    assert modes.log_modulus[:2] == pytest.approx([0.0, -1.0], abs=1e-7)
    assert modes.log_modulus[2:] == pytest.approx([-1e7, -2e7], rel=1e-9)
    assert modes.liouville_defect < LIOUVILLE


def test_modes_that_die_out_beyond_measure_within_a_step_are_refused() -> None:
    with pytest.raises(ComputationError, match="take more steps"):
        floquet_modes(uneven(np.diag([0.0, -1e7]), 1.0), 32)


def test_shapes_of_a_constant_system_turn() -> None:
    # An angle of 4.1 rad a period is one of 4.1 - 2 pi, and the shape makes up for it.
    turn = 4.1 * np.array([[0.0, 1.0], [-1.0, 0.0]])
    modes, steps = floquet_modes(constant(turn, 1.0), 20), 20
    shapes = modes.shapes()
    moved = scipy.linalg.expm(turn / steps) @ shapes * np.exp(-modes.exponent / steps)
    assert moved == pytest.approx(np.roll(shapes, -1, axis=0), abs=1e-13)
    assert np.abs(modes.angle) == pytest.approx(2 * np.pi - 4.1)


@pytest.mark.parametrize("steps", [64, 65])
def test_defective_multiplier(steps: int) -> None:
    # y'' = 0 seen in turning coordinates: the multiplier 1 is double and has one mode.
    def matrix(t: FloatArray) -> FloatArray:
        wave, rate = 0.3 * np.sin(t), 0.3 * np.cos(t)
        # x = T y with T = [1, 0; wave, 1] and y' = [0, 1; 0, 0] y.
        return entries((-wave, 1), (rate - wave**2, wave))

    modes = floquet_modes(StatedPeriodicSystem(matrix, 2 * np.pi), steps)
    # A double root feels the square root of an error of about 1e-13.
    assert np.abs(modes.log_modulus).max() < 1e-5
    assert modes.log_modulus.sum() == pytest.approx(0, abs=1e-11)


def test_multiplier_on_the_negative_real_axis() -> None:
    # Inside the principal band of Mathieu's equation the multipliers are real and negative.
    modes = floquet_modes(mathieu(2.0, 0.2), 200)
    assert np.abs(modes.angle) == pytest.approx(np.pi, abs=1e-12)
    assert modes.log_modulus[0] > 0.1
    assert modes.log_modulus.sum() == pytest.approx(0, abs=1e-12)
    assert modes.exponent.imag == pytest.approx(modes.angle / modes.period)


def mathieu(drive: float, depth: float) -> StatedPeriodicSystem:
    def matrix(t: FloatArray) -> FloatArray:
        return entries((0, 1), (-1 - depth * np.cos(drive * t), 0))

    return StatedPeriodicSystem(matrix, 2 * np.pi / drive)


def damped_chain(t: FloatArray) -> FloatArray:
    """Three oscillators of far different damping, coupled periodically."""
    stiffness = entries(
        (4 + np.cos(t), 1.5 * np.sin(t), 0.4),
        (1.5 * np.sin(t), 30 + 5 * np.cos(2 * t), np.cos(t)),
        (0.4, np.cos(t), 400 + 0 * t),
    )
    damping = np.diag([0.05, 8.0, 90.0])
    matrix = np.zeros((len(t), 6, 6))
    matrix[:, :3, 3:] = np.eye(3)
    matrix[:, 3:, :3] = -stiffness
    matrix[:, 3:, 3:] = -damping
    return matrix


@pytest.mark.parametrize(
    "system",
    [
        known_system("trap"),
        StatedPeriodicSystem(damped_chain, 2 * np.pi),
        known_system("dipole"),
    ],
    ids=["trap", "damped chain", "dipole"],
)
@pytest.mark.parametrize("steps", [400, 401])
def test_shapes_solve_the_equation_and_repeat(system: StatedPeriodicSystem, steps: int) -> None:
    period, modes = system.period, floquet_modes(system, steps)
    shapes = modes.shapes()
    # Over a step phi(t) exp(lambda t) is what the transition matrix makes of it; the last step
    # leads back to the first shape.
    growth = np.exp(modes.exponent * period / steps)
    moved = transition_matrices(system, steps) @ shapes
    gap = np.linalg.norm(moved - np.roll(shapes, -1, axis=0) * growth, axis=1)
    assert (gap / np.linalg.norm(shapes, axis=1)).max() < 1e-8
    # The equation itself, with the shapes' rates: phi' + lambda phi = A phi.
    order = np.fft.fftfreq(steps, 1 / steps)
    rates = np.fft.ifft(
        2j * np.pi / period * order[:, None, None] * np.fft.fft(shapes, axis=0), axis=0
    )
    residual = rates + shapes * modes.exponent - system.matrices(steps, 0.0) @ shapes
    largest = np.abs(system.matrices(steps, 0.0)).max() * np.abs(shapes).max(axis=(0, 1))
    assert (np.abs(residual).max(axis=(0, 1)) / largest).max() < 1e-6


@given(seed=st.integers(0, 10**6), late=st.floats(0.05, 6.0))
@settings(max_examples=15, deadline=None)
def test_multipliers_do_not_depend_on_when_the_turn_begins(seed: int, late: float) -> None:
    matrix = random_periodic(seed, 4)
    modes = floquet_modes(StatedPeriodicSystem(matrix, 2 * np.pi), 512)
    other = floquet_modes(StatedPeriodicSystem(lambda t: matrix(t + late), 2 * np.pi), 512)
    assert symmetric_functions(other) == pytest.approx(symmetric_functions(modes), abs=1e-8)


@given(seed=st.integers(0, 10**6))
@settings(max_examples=15, deadline=None)
def test_multipliers_do_not_depend_on_periodic_coordinates(seed: int) -> None:
    matrix = random_periodic(seed, 4)
    rng = np.random.default_rng(seed + 1)
    # x = T(t) y with T = 1 + E(t), E small enough for T to be regular.
    swing, lift = 0.12 * rng.normal(size=(2, 4, 4))

    def changed(t: FloatArray) -> FloatArray:
        s, c = np.sin(t)[:, None, None], np.cos(t)[:, None, None]
        turn, rate = np.eye(4) + swing * s + lift * c, swing * c - lift * s
        return np.asarray(np.linalg.solve(turn, matrix(t) @ turn - rate))

    modes = floquet_modes(StatedPeriodicSystem(matrix, 2 * np.pi), 1024)
    other = floquet_modes(StatedPeriodicSystem(changed, 2 * np.pi), 1024)
    assert symmetric_functions(other) == pytest.approx(symmetric_functions(modes), abs=1e-7)


def random_periodic(seed: int, size: int) -> Callable[[FloatArray], FloatArray]:
    mean, swing, lift = 0.3 * np.random.default_rng(seed).normal(size=(3, size, size))

    def matrix(t: FloatArray) -> FloatArray:
        return np.asarray(
            mean + swing * np.sin(t)[:, None, None] + lift * np.cos(2 * t)[:, None, None]
        )

    return matrix


def symmetric_functions(modes: FloquetModes) -> FloatArray:
    """Coefficients of the polynomial of the multipliers: smooth where multipliers are double."""
    multipliers = np.exp(modes.exponent * modes.period)
    return np.poly(multipliers / np.abs(multipliers).max())


@pytest.mark.parametrize("every", [1, 4, 10, 60])
@pytest.mark.parametrize("steps", [60, 240])
def test_shapes_at_few_instants_are_those_at_all(steps: int, every: int) -> None:
    # One mode that dies out fast takes many short products, light damping alone few.
    for exponents in ([-0.1, -0.7, -0.3], [-0.1, -9.0, -0.3]):
        modes = floquet_modes(uneven(with_exponents(exponents, 3), 4.0), steps)
        assert modes.shapes(every) == pytest.approx(modes.shapes()[::every], rel=1e-9, abs=1e-9)
    same = floquet_modes(constant(with_exponents([-0.1, -0.7], 3), 4.0), steps)
    assert modes.shapes(every).shape == (steps // every, 3, 3)
    assert same.shapes(every) == pytest.approx(same.shapes()[::every])
