"""Small periodic systems: boundaries of instability and Floquet exponents."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
import scipy.optimize

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import FloquetModes, StatedPeriodicSystem, floquet_modes

Combination = Literal["sum", "difference"]
"""Combination of the coupling: two oscillators that push each other alike, or oppositely."""

# Squares of the natural frequencies of the two oscillators, whose sum and difference are apart from
# each other and from twice a frequency, and how deeply they are coupled.
SQUARES, DEPTH = (1.0, 5.0), 0.4
COUPLINGS: dict[str, tuple[tuple[float, float], tuple[float, float]]] = {
    "sum": ((0.0, 1.0), (1.0, 0.0)),
    "difference": ((0.0, 1.0), (-1.0, 0.0)),
}
# Edges are looked for within this part of the drive in the middle of a band: it is wider than the
# bands, and no other band is so near.
AROUND = 0.15


def oscillators(
    squares: Sequence[float], damping: float, coupling: FloatArray, depth: float, drive: float
) -> StatedPeriodicSystem:
    """``x'' + c x' + (diag(w^2) + d S cos(W t)) x = 0`` as a system of first order.

    Parameters
    ----------
    squares : sequence of float
        Squares of the natural frequencies.
    damping : float
        c.
    coupling : ndarray, shape (n, n)
        S.
    depth : float
        d.
    drive : float
        W.

    Returns
    -------
    StatedPeriodicSystem
    """
    size = len(squares)

    def matrix(time: FloatArray) -> FloatArray:
        stated = np.zeros((len(time), 2 * size, 2 * size))
        stated[:, :size, size:] = np.eye(size)
        wave = np.cos(drive * time)[:, None, None]
        stated[:, size:, :size] = -np.diag(squares) - depth * coupling * wave
        stated[:, size:, size:] = -damping * np.eye(size)
        return stated

    return StatedPeriodicSystem(matrix, 2 * np.pi / drive)


def mathieu_boundaries(*, depth: float, order: int, steps: int) -> FloatArray:
    """Edges of an unstable band of ``y'' + w^2 (1 + depth cos(W t)) y = 0``.

    On the edges of bands of odd order both multipliers are -1, on those of even order 1.

    Parameters
    ----------
    depth : float
    order : int
        1 for the principal band, about W = 2 w.
    steps : int
        Steps of the propagator in a period.

    Returns
    -------
    ndarray, shape (2,)
        ``W / (2 w)``, the lower one first.
    """
    target = -2.0 if order % 2 else 2.0

    def gap(ratio: float) -> float:
        modes = floquet_modes(oscillators([1.0], 0.0, np.eye(1), depth, 2 * ratio), steps)
        return float(np.exp(modes.exponent * modes.period).sum().real) - target

    return _edges(gap, 1 / order)


def combination_modes(kind: Combination, drive: float, damping: float, steps: int) -> FloquetModes:
    """Floquet modes of two coupled oscillators.

    Parameters
    ----------
    kind : {"sum", "difference"}
        Kind of the frequencies that can resonate.
    drive, damping : float
    steps : int
        Steps of the propagator in a period.

    Returns
    -------
    FloquetModes
    """
    coupling = np.array(COUPLINGS[kind])
    return floquet_modes(oscillators(SQUARES, damping, coupling, DEPTH, drive), steps)


def combination_edges(*, kind: Combination, damping: float, steps: int) -> FloatArray:
    """Drives W between which two coupled oscillators grow.

    Parameters
    ----------
    kind : {"sum", "difference"}
        Kind of the frequencies, which the drive meets in the middle of the band.
    damping : float
    steps : int
        Steps of the propagator in a period.

    Returns
    -------
    ndarray, shape (2,)
        The lower one first.
    """

    def growth(drive: float) -> float:
        return float(combination_modes(kind, drive, damping, steps).exponent[0].real)

    return _edges(growth, _resonance(kind))


def resonance_modulus(*, kind: Combination, resonance: Combination, steps: int) -> FloatArray:
    """Largest modulus of two undamped coupled oscillators, driven at a resonance.

    Parameters
    ----------
    kind : {"sum", "difference"}
        Kind of the coupling.
    resonance : {"sum", "difference"}
        Resonance of the frequencies, at which they are driven.
    steps : int
        Steps of the propagator in a period.

    Returns
    -------
    ndarray, shape (1,)
    """
    modes = combination_modes(kind, _resonance(resonance), 0.0, steps)
    return np.exp(modes.log_modulus[:1])


def known_exponents(*, system: str, steps: int) -> FloatArray:
    """Floquet exponents of a system of two states whose exponents are known.

    Parameters
    ----------
    system : str
        One of :func:`known_system`.
    steps : int
        Steps of the propagator in a period.

    Returns
    -------
    ndarray, shape (4,)
        Real parts, the greatest first; sizes of the imaginary parts, at most ``pi`` over the
        period, as they are known but for multiples of twice that.
    """
    exponent = floquet_modes(known_system(system), steps).exponent
    return np.concatenate([exponent.real, np.abs(exponent.imag)])


def known_system(name: str) -> StatedPeriodicSystem:
    """Give a system of two states whose Floquet exponents are known.

    Parameters
    ----------
    name : {"trap", "dipole", "dipole over half its period", "triangular"}

    Returns
    -------
    StatedPeriodicSystem
    """
    matrix, period = KNOWN[name]
    return StatedPeriodicSystem(matrix, period)


def _resonance(kind: Combination) -> float:
    first, last = np.sqrt(SQUARES)
    return float(last + first if kind == "sum" else last - first)


def _edges(gap: Callable[[float], float], middle: float) -> FloatArray:
    """Roots of a function to both sides of a place, the lower one first."""
    ends = middle * (1 - AROUND), middle * (1 + AROUND)
    return np.array([scipy.optimize.brentq(gap, middle, end) for end in ends])


def _entries(*rows: tuple[object, ...]) -> FloatArray:
    """Stack (N, n, n) from entries that are numbers or functions' values (N,)."""
    flat = np.broadcast_arrays(*[np.asarray(value, dtype=float) for row in rows for value in row])
    return np.stack(flat, axis=-1).reshape(*flat[0].shape, len(rows), len(rows[0]))


def _trap(t: FloatArray) -> FloatArray:
    return _entries((0, 1), (-10 * np.cos(t), -24 - 10 * np.sin(t)))


def _dipole(t: FloatArray) -> FloatArray:
    s, half = np.sin(2 * t), np.sin(4 * t) / 2
    return _entries((-1 - s**2, 2 - half), (-2 - half, -1 - np.cos(2 * t) ** 2))


def _triangular(t: FloatArray) -> FloatArray:
    return _entries((-1 + np.sin(t), 0 * t), (1 - np.cos(t), -3))


KNOWN: dict[str, tuple[Callable[[FloatArray], FloatArray], float]] = {
    "trap": (_trap, 2 * np.pi),
    "dipole": (_dipole, np.pi),
    "dipole over half its period": (_dipole, np.pi / 2),
    "triangular": (_triangular, 2 * np.pi),
}
