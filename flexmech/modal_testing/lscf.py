"""Poles by the least-squares complex-frequency method of sdypy-EMA (extra ``modal-test``)."""

from __future__ import annotations

import warnings
from importlib.util import find_spec

import numpy as np

from flexmech.errors import InputError
from flexmech.types import ComplexArray, FloatArray

EXTRA = (
    'identification by LSCF needs sdypy-EMA, which is not installed: pip install "flexmech'
    '[modal-test]", or choose method="circle-fit"'
)


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
        raise InputError(EXTRA)


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
        model.get_poles(method="lscf", show_progress=False)
    found = []
    for poles in model.all_poles:
        hertz = abs(poles) / (2 * np.pi)
        found.append(poles[(poles.imag > 0.0) & (hertz >= band[0]) & (hertz <= band[1])])
    return found
