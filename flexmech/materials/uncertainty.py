"""How uncertain a number is that is computed from uncertain constituents."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from flexmech.errors import InputError
from flexmech.materials.constituents import Fibre, Matrix
from flexmech.numbers import checked_tuple

# Of an uncertainty: small enough for a derivative, far above rounding.
_STEP = 1e-3


def propagated_uncertainty(
    function: Callable[..., float], constituents: Sequence[Fibre | Matrix]
) -> float:
    """Uncertainty of a number computed from constituents, to first order.

    The uncertainties that the constituents carry are taken as independent: the root of the
    sum of squares of each one times the number's derivative, by central differences
    (JCGM 100:2008, *Guide to the expression of uncertainty in measurement*, eq. 10). First
    order is poor where an uncertainty is large: the printed one of the carbon fibre's shear
    modulus is 42 % of it.

    Parameters
    ----------
    function : callable
        Of the constituents, in their order; gives the modulus of a ply, a stiffness of a
        laminate or any other number that follows from them.
    constituents : sequence of Fibre or Matrix
        Each once, so that it varies everywhere together.

    Returns
    -------
    float
        In the units of the number.

    Examples
    --------
    >>> import flexmech
    >>> table = flexmech.published_constituents()
    >>> def modulus(fibre, resin):
    ...     return flexmech.ply_from_constituents(fibre, resin, 0.6).longitudinal_modulus / 1e9
    >>> parts = table["carbon"], table["polyester"]
    >>> spread = flexmech.propagated_uncertainty(modulus, parts)
    >>> print(f"{modulus(*parts):.1f} +/- {spread:.1f} GPa")
    121.9 +/- 12.0 GPa
    """
    if not callable(function):
        raise InputError(f"function must be called with the constituents, got {function!r}")
    remedy = "give a Fibre and a Matrix in a tuple"
    constituents = checked_tuple(constituents, (Fibre, Matrix), "constituents", remedy)
    total = 0.0
    for place, constituent in enumerate(constituents):
        for name, spread in constituent.uncertainty.items():
            ends = []
            for sign in (1.0, -1.0):
                moved: list[Any] = list(constituents)
                value = getattr(constituent, name) + sign * _STEP * spread
                moved[place] = replace(constituent, **{name: value})
                ends.append(function(*moved))
            total += ((ends[0] - ends[1]) / (2 * _STEP)) ** 2
    return float(np.sqrt(total))
