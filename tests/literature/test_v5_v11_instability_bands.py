"""Bands of growth of small systems: Mathieu's equation (V5) and combination resonances (V11)."""

import numpy as np
import pytest
import scipy.optimize

from flexmech.time_domain.floquet import FloquetModes, floquet_modes
from flexmech.time_domain.periodic_system import StatedPeriodicSystem
from flexmech.types import FloatArray

STEPS = 128
EDGE = 1e-5


def oscillators(
    squares: list[float], damping: float, pattern: FloatArray, depth: float, drive: float
) -> StatedPeriodicSystem:
    """``x'' + c x' + (diag(w^2) + d S cos(W t)) x = 0``."""
    size = len(squares)

    def matrix(t: FloatArray) -> FloatArray:
        stated = np.zeros((len(t), 2 * size, 2 * size))
        stated[:, :size, size:] = np.eye(size)
        stated[:, size:, :size] = (
            -np.diag(squares) - depth * pattern * np.cos(drive * t)[:, None, None]
        )
        stated[:, size:, size:] = -damping * np.eye(size)
        return stated

    return StatedPeriodicSystem(matrix, 2 * np.pi / drive)


def mathieu_discriminant(depth: float, drive: float) -> float:
    """Sum of the two multipliers of Mathieu's equation with natural frequency 1."""
    modes = floquet_modes(oscillators([1.0], 0.0, np.eye(1), depth, drive), STEPS)
    return float(np.exp(modes.exponent * modes.period).sum().real)


@pytest.mark.parametrize(
    ("depth", "order", "lower", "upper"),
    [
        (0.1, 1, 0.974849, 1.024839),
        (0.2, 1, 0.949424, 1.049344),
        (0.4, 1, 0.897995, 1.097300),
        (0.1, 2, 0.498958, 0.500208),
        (0.4, 2, 0.483383, 0.503271),
    ],
)
def test_mathieu_boundaries(depth: float, order: int, lower: float, upper: float) -> None:
    # On the edges of the first band the multipliers are both -1, of the second both +1. Their
    # sum has a root of the edge's equation there; the middle of the band has one sign of it.
    target = 2.0 * (-1) ** order

    def gap(ratio: float) -> float:
        return mathieu_discriminant(depth, 2 * ratio) - target

    def edge(inside: float, outside: float) -> float:
        assert gap(inside) * gap(outside) < 0
        return float(scipy.optimize.brentq(gap, inside, outside, xtol=1e-12))

    middle, width = (lower + upper) / 2, upper - lower
    assert edge(middle, middle - width) == pytest.approx(lower, abs=EDGE)
    assert edge(middle, middle + width) == pytest.approx(upper, abs=EDGE)


SUM, DIFFERENCE = np.array([[0.0, 1.0], [1.0, 0.0]]), np.array([[0.0, 1.0], [-1.0, 0.0]])


def combination(pattern: FloatArray, drive: float, damping: float, steps: int) -> FloquetModes:
    return floquet_modes(oscillators([1.0, 5.0], damping, pattern, 0.4, drive), steps)


@pytest.mark.parametrize(
    ("pattern", "lower", "upper"),
    [(SUM, 3.1025925, 3.3667101), (DIFFERENCE, 1.1003892, 1.3644495)],
    ids=["sum", "difference"],
)
@pytest.mark.parametrize("steps", [128, 129])
def test_edges_of_combination_resonances(
    pattern: FloatArray, lower: float, upper: float, steps: int
) -> None:
    def growth(drive: float) -> float:
        return float(combination(pattern, drive, 0.02, steps).exponent[0].real)

    found = [
        scipy.optimize.brentq(growth, edge - 0.1, edge + 0.1, xtol=1e-10) for edge in (lower, upper)
    ]
    assert found == pytest.approx([lower, upper], abs=EDGE)
    assert growth((lower + upper) / 2) > 0.01


@pytest.mark.parametrize(
    ("pattern", "drive"),
    [(SUM, np.sqrt(5) - 1), (DIFFERENCE, np.sqrt(5) + 1)],
    ids=["no difference resonance", "no sum resonance"],
)
@pytest.mark.parametrize("steps", [32, 128, 255])
def test_no_band_where_there_is_none(pattern: FloatArray, drive: float, steps: int) -> None:
    modes = combination(pattern, drive, 0.0, steps)
    assert np.abs(np.exp(modes.log_modulus) - 1).max() < 1e-12
    assert modes.liouville_defect < 1e-12


@pytest.mark.parametrize(
    ("pattern", "drive"),
    [(SUM, np.sqrt(5) + 1), (DIFFERENCE, np.sqrt(5) - 1)],
    ids=["sum", "difference"],
)
def test_multipliers_inside_a_band_are_quadruples(pattern: FloatArray, drive: float) -> None:
    log = np.sort(combination(pattern, drive, 0.0, STEPS).log_modulus)
    assert log == pytest.approx(-log[::-1], abs=1e-12)
    assert log[-1] > 0.05
