"""Floquet modes of periodic systems whose exponents are known, by the propagator of sixth order."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from flexmech import ComputationError
from flexmech.dynamical_systems import (
    FloquetModes,
    StatedPeriodicSystem,
    floquet_modes,
    transition_matrices,
)
from flexmech.verification import VerificationCase, verification_cases
from flexmech.verification.methods.periodic_systems import known_system

FloatArray = NDArray[np.float64]
# Validation V10, cases of the verification.
KNOWN = [case for case in verification_cases() if case.measured_by.method == "known_exponents"]


def entries(*rows: tuple[object, ...]) -> FloatArray:
    """Stack (N, n, n) from entries that are numbers or functions' values (N,)."""
    flat = np.broadcast_arrays(*[np.asarray(value, dtype=float) for row in rows for value in row])
    return np.stack(flat, axis=-1).reshape(*flat[0].shape, len(rows), len(rows[0]))


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
def test_exponents_that_are_known_are_found_with_an_odd_number_of_steps(
    case: VerificationCase,
) -> None:
    found = case.measured_by.with_(steps=257).values()
    assert found == pytest.approx(case.expected_values(), abs=case.tolerance)
    modes = floquet_modes(known_system(case.measured_by.settings["system"]), 257)
    assert modes.liouville_defect < 1e-12


def test_error_of_exponents_falls_with_the_sixth_power_of_the_step() -> None:
    counts, errors = np.array([64, 128, 256]), []
    for count in counts.tolist():
        found = KNOWN[0].measured_by.with_(steps=count).values()
        errors.append(np.abs(found - KNOWN[0].expected_values()).max())
    rates = np.diff(np.log(errors)) / np.diff(np.log(counts))
    assert rates[-1] == pytest.approx(-6, abs=0.3)


@given(seed=st.integers(0, 10**6), steps=st.integers(16, 70), size=st.integers(1, 7))
@settings(max_examples=15, deadline=None)
def test_exponents_of_a_constant_system_are_its_eigenvalues(
    seed: int, steps: int, size: int
) -> None:
    matrix = 0.3 * np.random.default_rng(seed).normal(size=(size, size))
    modes = floquet_modes(constant(matrix, 1.3), steps)
    # No eigenvalue turns by more than pi in this period; those of a cluster are ill conditioned.
    condition = np.linalg.cond(np.linalg.eig(matrix)[1])
    gaps = np.abs(modes.exponent[:, None] - np.linalg.eigvals(matrix))
    assert max(gaps.min(axis=1).max(), gaps.min(axis=0).max()) < 1e-14 * steps * condition


@pytest.mark.parametrize(
    "exponents",
    [
        pytest.param([0.0, -2000.0], id="underflow"),
        pytest.param([0.0, -150.8, -157.1], id="near and far"),
        pytest.param([-3.0 * k for k in range(20)], id="chain"),
        pytest.param([0.0, -1.0, -8e3, -9e3], id="lost in a step"),
        pytest.param([20.0, 19.0, -19.0, -20.0], id="grown"),
    ],
)
def test_multipliers_of_far_different_size_are_all_found(exponents: list[float]) -> None:
    modes = floquet_modes(uneven(with_exponents(exponents, 1), 1.0), 251)
    # The matrix itself has its eigenvalues to its round-off only.
    size = max(abs(value) for value in exponents)
    assert modes.log_modulus == pytest.approx(np.array(exponents), abs=1e-9 * size)
    assert modes.liouville_defect < 1e-9


@pytest.mark.parametrize("weak", [-24.0, -2000.0])
def test_a_weak_invariant_subspace_that_stands_first_is_put_last(weak: float) -> None:
    """Columns of the unit matrix span the weak modes: iteration from it would leave them first."""
    matrix = np.array([[weak, 0.0, 5.0], [0.0, 2 * weak, 1.0], [0.0, 0.0, 0.5]])
    modes = floquet_modes(uneven(matrix, 1.0), 600)
    assert modes.log_modulus == pytest.approx(np.array([0.5, weak, 2 * weak]), rel=1e-11)
    # Where the pace is that of the mean, and what it has gained is made up for.
    shapes = modes.shapes()[0]
    assert np.abs(matrix @ shapes - shapes * modes.exponent).max() < 1e-9 * np.abs(weak)


def test_modes_that_die_out_within_a_step_are_known_or_refused() -> None:
    matrix = with_exponents([0.0, -1.0, -1e7, -2e7], 3)
    modes = floquet_modes(constant(matrix, 1.0), 32)
    assert modes.log_modulus[:2] == pytest.approx([0.0, -1.0], abs=1e-7)
    assert modes.log_modulus[2:] == pytest.approx([-1e7, -2e7], rel=1e-9)
    with pytest.raises(ComputationError, match="more steps"):
        floquet_modes(uneven(np.diag([0.0, -1e7]), 1.0), 32)


def test_shapes_make_up_for_whole_turns_of_the_exponent() -> None:
    """An angle of 4.1 rad a period is given as 4.1 - 2 pi."""
    turn = 4.1 * np.array([[0.0, 1.0], [-1.0, 0.0]])
    modes, steps = floquet_modes(constant(turn, 1.0), 20), 20
    shapes = modes.shapes()
    moved = scipy.linalg.expm(turn / steps) @ shapes * np.exp(-modes.exponent / steps)
    assert moved == pytest.approx(np.roll(shapes, -1, axis=0), abs=1e-13)
    assert np.abs(modes.angle) == pytest.approx(2 * np.pi - 4.1)


def test_a_double_multiplier_with_one_mode_is_found_to_the_root_of_round_off() -> None:
    """``y'' = 0`` in turning coordinates."""

    def matrix(t: FloatArray) -> FloatArray:
        wave, rate = 0.3 * np.sin(t), 0.3 * np.cos(t)
        # x = T y with T = [1, 0; wave, 1] and y' = [0, 1; 0, 0] y.
        return entries((-wave, 1), (rate - wave**2, wave))

    modes = floquet_modes(StatedPeriodicSystem(matrix, 2 * np.pi), 65)
    assert np.abs(modes.log_modulus).max() < 1e-5
    assert modes.log_modulus.sum() == pytest.approx(0, abs=1e-11)


def test_multipliers_inside_the_principal_band_of_mathieus_equation_are_negative() -> None:
    def matrix(t: FloatArray) -> FloatArray:
        return entries((0, 1), (-1 - 0.2 * np.cos(2 * t), 0))

    modes = floquet_modes(StatedPeriodicSystem(matrix, np.pi), 200)
    assert np.abs(modes.angle) == pytest.approx(np.pi, abs=1e-12)
    assert modes.log_modulus[0] > 0.1
    assert modes.log_modulus.sum() == pytest.approx(0, abs=1e-12)


def damped_chain(t: FloatArray) -> FloatArray:
    """Three oscillators of far different damping, coupled periodically."""
    stiffness = entries(
        (4 + np.cos(t), 1.5 * np.sin(t), 0.4),
        (1.5 * np.sin(t), 30 + 5 * np.cos(2 * t), np.cos(t)),
        (0.4, np.cos(t), 400 + 0 * t),
    )
    matrix = np.zeros((len(t), 6, 6))
    matrix[:, :3, 3:] = np.eye(3)
    matrix[:, 3:, :3] = -stiffness
    matrix[:, 3:, 3:] = -np.diag([0.05, 8.0, 90.0])
    return matrix


@pytest.mark.parametrize(
    "system",
    [known_system("trap"), StatedPeriodicSystem(damped_chain, 2 * np.pi)],
    ids=["trap", "damped chain"],
)
def test_shapes_solve_the_equation_and_repeat(system: StatedPeriodicSystem) -> None:
    period, steps = system.period, 400
    modes = floquet_modes(system, steps)
    shapes = modes.shapes()
    # Over a step phi(t) exp(lambda t) is what the transition matrix makes of it.
    growth = np.exp(modes.exponent * period / steps)
    moved = transition_matrices(system, steps) @ shapes
    gap = np.linalg.norm(moved - np.roll(shapes, -1, axis=0) * growth, axis=1)
    assert (gap / np.linalg.norm(shapes, axis=1)).max() < 1e-8
    # The equation itself, with the shapes' rates: phi' + lambda phi = A phi.
    order = np.fft.fftfreq(steps, 1 / steps)
    rates = np.fft.ifft(
        2j * np.pi / period * order[:, None, None] * np.fft.fft(shapes, axis=0), axis=0
    )
    matrices = system.matrices(steps, 0.0)
    residual = rates + shapes * modes.exponent - matrices @ shapes
    largest = np.abs(matrices).max() * np.abs(shapes).max(axis=(0, 1))
    assert (np.abs(residual).max(axis=(0, 1)) / largest).max() < 1e-6
    assert modes.shapes(10) == pytest.approx(shapes[::10], rel=1e-9, abs=1e-9)


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


@given(seed=st.integers(0, 10**6), late=st.floats(0.05, 6.0))
@settings(max_examples=6, deadline=None)
def test_multipliers_depend_neither_on_the_start_nor_on_periodic_coordinates(
    seed: int, late: float
) -> None:
    matrix, rng = random_periodic(seed, 4), np.random.default_rng(seed + 1)
    # x = T(t) y with T = 1 + E(t), E small enough for T to be regular.
    swing, lift = 0.12 * rng.normal(size=(2, 4, 4))

    def changed(t: FloatArray) -> FloatArray:
        s, c = np.sin(t + late)[:, None, None], np.cos(t + late)[:, None, None]
        turn, rate = np.eye(4) + swing * s + lift * c, swing * c - lift * s
        return np.asarray(np.linalg.solve(turn, matrix(t + late) @ turn - rate))

    modes = floquet_modes(StatedPeriodicSystem(matrix, 2 * np.pi), 768)
    other = floquet_modes(StatedPeriodicSystem(changed, 2 * np.pi), 768)
    assert symmetric_functions(other) == pytest.approx(symmetric_functions(modes), abs=1e-7)
