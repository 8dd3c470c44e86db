"""What is found of a claim, and words for numbers."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from flexmech.studies.claim import SPREADS, Band


class Finding(NamedTuple):
    """Texts of a claim, whether it holds if that can be checked, and numbers for its reason.

    Parameters
    ----------
    from_tables, computed, other_models : str
    holds : bool or None
    numbers : iterable of float or str
        For the claim's reason.
    spread : str
        Uncertainty of what is computed.
    decidable : bool
        Whether holding differs from not holding, within the uncertainty.
    fails_if : str
    """

    from_tables: str
    computed: str
    other_models: str = ""
    holds: bool | None = None
    numbers: Iterable[float | str] = ()
    spread: str = ""
    decidable: bool = True
    fails_if: str = ""

    def judged_by(self, band: Band, computed: float, unit: str, decimals: int = 2) -> Finding:
        """The same, held against a number that is printed.

        Parameters
        ----------
        band : Band
        computed : float
            Our number.
        unit : str
        decimals : int
            Of the numbers in words.

        Returns
        -------
        Finding
        """
        edges = f"{band.edges[0]:.{decimals}f} to {band.edges[1]:.{decimals}f} {unit}".rstrip()
        words = f"ours is outside {edges}"
        if not band.decides:
            words += f", which holds {band.no_effect:g} too and decides nothing"
        return self._replace(
            holds=band.holds(computed),
            decidable=band.decides,
            spread=f"{band.spread:.{decimals}f} {unit}".rstrip() if band.spread else "",
            fails_if=words,
        )

    def judged_by_order(
        self, difference: float, spread: float, words: str, least: float = 0.0
    ) -> Finding:
        """The same, held against an order that is claimed.

        Parameters
        ----------
        difference : float
            The least relative difference in the order claimed; negative where it is reversed.
        spread : float
            Its standard uncertainty.
        words : str
            What fails it.
        least : float
            Up to which a difference counts as none.

        Returns
        -------
        Finding
        """
        told = f"{100 * difference:z.2f} %"
        if spread:
            told += f" \N{PLUS-MINUS SIGN} {100 * spread:.2f} %"
        return self._replace(
            holds=difference > least,
            decidable=spread == 0 or abs(difference) > SPREADS * spread,
            fails_if=f"{words}; the least difference is {told}",
        )


def numbers_in(printed: str) -> list[float]:
    """Numbers in what is printed.

    Parameters
    ----------
    printed : str

    Returns
    -------
    list of float
    """
    return [float(number) for number in re.findall(r"[\d.]+", printed)]


def span(numbers: ArrayLike, decimals: int = 2) -> str:
    """Least and greatest of numbers in words, or the one that both are.

    Parameters
    ----------
    numbers : array_like
    decimals : int

    Returns
    -------
    str
    """
    ends = (f"{end:z.{decimals}f}" for end in (np.min(numbers), np.max(numbers)))
    return " to ".join(dict.fromkeys(ends))
