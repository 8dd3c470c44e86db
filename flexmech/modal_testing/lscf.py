"""Poles by the least-squares complex-frequency method of sdypy-EMA (extra ``modal-test``).

Models of rising order give them; the stabilisation chart tells which come back from order to order,
and which are chosen. Poles of the structure stay where they are when the order of the model rises;
those that only serve noise wander. Source: P. Verboven, Frequency-domain system identification for
modal analysis, Vrije Universiteit Brussel (2002), section 5.3.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.errors import ComputationError, InputError, missing_extra

# Relative: by so much at most a stable pole's frequency differs from the order before. Half of what
# stabilisation charts usually have, since modes of linkages may be a per cent apart.
FREQUENCY_TOLERANCE = 0.005
# Relative, of the damping ratio, the window's included; as stabilisation charts usually have it.
DAMPING_TOLERANCE = 0.05
# In which a pole must be stable to be that of a mode.
PART_OF_ORDERS = 0.2
# Where a fifth of the orders is one or two: a pole that agrees but once makes no column.
LEAST_ORDERS = 3


def has_lscf() -> bool:
    """Whether sdypy-EMA is installed."""
    return find_spec("sdypy") is not None and find_spec("sdypy.EMA") is not None


def check_lscf() -> None:
    """Refuse to begin where sdypy-EMA is missing.

    Raises
    ------
    InputError
        It says what to install.
    """
    if not has_lscf():
        otherwise = 'choose method="circle-fit"'
        raise missing_extra("identification by LSCF", "sdypy-EMA", "modal-test", otherwise)


def lscf_poles(
    frequency: FloatArray,
    receptance: ComplexArray,
    band: tuple[float, float],
    orders: int,
) -> list[ComplexArray]:
    """Poles of common-denominator models of rising order, fitted to all receptances at once.

    Parameters
    ----------
    frequency : ndarray, shape (F,)
        In Hz, evenly spaced multiples of their step.
    receptance : ndarray of complex, shape (points, F)
    band : tuple of float
        In Hz, from and to: what lies outside is not fitted.
    orders : int
        Highest number of modes of a model.

    Returns
    -------
    list of ndarray of complex
        One array for each of the orders 1 to ``orders``: poles in 1/s whose imaginary part is
        positive and whose frequency lies in the band.

    Raises
    ------
    InputError
        sdypy-EMA is not installed, or there are too few frequencies for so many orders.
    ComputationError
        The records show so few modes that a model of so many has no unique fit.

    Notes
    -----
    The package's own choice of stable poles draws progress bars and knows one tolerance of
    frequency for all; its poles of all orders are taken, and :mod:`.stabilisation` chooses.
    """
    check_lscf()
    from sdypy.EMA import Model

    below = frequency <= band[1] * (1 + 1e-12)
    inside = frequency[below & (frequency >= band[0])].size
    if inside < 2 * orders + 2:
        raise InputError(
            f"{inside} frequencies between {band[0]:g} and {band[1]:g} Hz are too few for models "
            f"of {orders} modes: give a longer record, a wider band or at most "
            f"{max((inside - 2) // 2, 0)} orders"
        )
    kept = frequency[below]
    with warnings.catch_warnings():
        # Poles at the origin divide by zero within the package; they are left out below.
        warnings.simplefilter("ignore", RuntimeWarning)
        model = Model(
            receptance[:, below],
            kept,
            lower=max(band[0], float(kept[0])),
            upper=float(kept[-1]),
            pol_order_high=orders,
            frf_form="receptance",
        )
        try:
            model.get_poles(method="lscf", show_progress=False)
        except np.linalg.LinAlgError as error:
            raise ComputationError(
                f"models of up to {orders} modes have no unique fit: the records show fewer modes, "
                "without noise; ask for fewer orders or a narrower band"
            ) from error
    of_orders = []
    for poles in model.all_poles:
        hertz = abs(poles) / (2 * np.pi)
        of_orders.append(poles[(poles.imag > 0.0) & (hertz >= band[0]) & (hertz <= band[1])])
    return of_orders


@dataclass(frozen=True, eq=False)
class StabilisationChart:
    """Poles of models of rising order.

    Parameters
    ----------
    order : ndarray of int, shape (n,)
        Modes of the model that each pole belongs to.
    pole : ndarray of complex, shape (n,)
        In 1/s with positive imaginary part, free of what a window added.
    stable_frequency : ndarray of bool, shape (n,)
        The order before has a pole of the same frequency.
    stable : ndarray of bool, shape (n,)
        The order before has a pole of the same frequency and damping.
    chosen : ndarray of int, shape (k,)
        Poles that were taken for modes, sorted by frequency.
    """

    order: IntArray
    pole: ComplexArray
    stable_frequency: NDArray[np.bool_]
    stable: NDArray[np.bool_]
    chosen: IntArray

    @property
    def frequency(self) -> FloatArray:
        """In Hz, shape (n,)."""
        return np.asarray(abs(self.pole) / (2 * np.pi))

    @property
    def damping_ratio(self) -> FloatArray:
        """Shape (n,)."""
        return np.asarray(-self.pole.real / abs(self.pole))


def stabilisation_chart(poles: Sequence[ComplexArray], added_damping: float) -> StabilisationChart:
    """Compare the poles of each order with those of the order before, and choose those of modes.

    Parameters
    ----------
    poles : sequence of ndarray of complex
        Poles of the orders 1, 2, ... in 1/s, as identified: with what a window added, with positive
        imaginary part, and in the band.
    added_damping : float
        Decay rate of the exponential window in 1/s.

    Returns
    -------
    StabilisationChart
    """
    same_frequency, same_pole = [], []
    before = np.zeros(0, dtype=complex)
    for now in poles:
        near = _relative(_size(now)[:, None], _size(before)) < FREQUENCY_TOLERANCE
        alike = _relative(_ratio(now)[:, None], _ratio(before)) < DAMPING_TOLERANCE
        same_frequency.append(near.any(axis=1))
        # A growing term is no mode of a structure that was hit.
        same_pole.append((near & alike).any(axis=1) & (now.real < 0.0))
        before = now
    order = np.repeat(np.arange(1, len(poles) + 1), [of_order.size for of_order in poles])
    pole = np.concatenate(poles) if poles else before
    stable = np.concatenate(same_pole) if poles else np.zeros(0, dtype=bool)
    return StabilisationChart(
        order,
        pole + added_damping,
        np.concatenate(same_frequency) if poles else stable,
        stable,
        _chosen(order, pole, stable, len(poles)),
    )


def _chosen(
    order: IntArray, pole: ComplexArray, stable: NDArray[np.bool_], orders: int
) -> IntArray:
    """One pole for each column of stable ones that runs through enough orders."""
    least = max(LEAST_ORDERS, int(np.ceil(PART_OF_ORDERS * orders)))
    left = np.flatnonzero(stable)
    chosen: list[int] = []
    while left.size >= least:
        columns = [_column(order[left], _size(pole[left]), of) for of in range(left.size)]
        longest = max(columns, key=len)
        if len(longest) < least:
            break
        members = left[longest]
        chosen.append(int(members[_middle(pole[members])]))
        left = np.delete(left, longest)
    return np.array(sorted(chosen, key=lambda one: float(abs(pole[one]))), dtype=np.intp)


def _column(order: IntArray, frequency: FloatArray, of: int) -> IntArray:
    """Indices of the poles nearest to one pole, order by order, where one is near."""
    distance = _relative(frequency, frequency[of])
    near = np.flatnonzero(distance < FREQUENCY_TOLERANCE)
    near = near[np.argsort(distance[near], kind="stable")]
    _, first = np.unique(order[near], return_index=True)
    return np.asarray(near[first])


def _middle(poles: ComplexArray) -> int:
    """The pole nearest to the median of frequency and damping."""
    median = np.median(poles.real) + 1j * np.median(poles.imag)
    return int(np.argmin(abs(poles - median)))


def _size(poles: ComplexArray) -> FloatArray:
    return np.asarray(abs(poles), dtype=float)


def _ratio(poles: ComplexArray) -> FloatArray:
    return np.asarray(-poles.real / abs(poles))


def _relative(values: FloatArray, others: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(abs(values - others) / abs(others))
