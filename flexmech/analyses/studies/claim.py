"""A claim of a paper and what was found: by its own tables, by ours, by all models."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import xarray as xr

from flexmech.analyses.studies.composite_crank_rockers import CONVERGED

__all__ = [
    "REPRODUCED_WITHIN",
    "Claim",
    "Share",
    "Verdict",
    "all_models",
    "extreme",
    "fall",
    "range_over_models",
    "within_a_tenth",
]

Verdict = Literal["reproduced", "not reproduced", "not checkable"]
REPRODUCED_WITHIN = 0.10
"""A number counts as reproduced when ours is within a tenth of that of the printed tables."""


@dataclass(frozen=True)
class Claim:
    """One statement of the paper and what was found.

    Parameters
    ----------
    place : str
        Where the paper says it.
    statement : str
    printed : str
        The number or words printed.
    from_tables : str
        The same, computed from the printed tables.
    computed : str
        Ours. Of these three, what there is not is empty.
    other_models : str
        Ours by the other models of plies and beams, and in the other posture with a right
        transmission angle; empty where they make no difference.
    verdict : {"reproduced", "not reproduced", "not checkable"}
    reason : str
        Why, where it needs saying.
    """

    place: str
    statement: str
    printed: str
    from_tables: str
    computed: str
    other_models: str
    verdict: Verdict
    reason: str = ""


def all_models(study: xr.Dataset) -> list[xr.DataArray]:
    """Frequencies over position, laminate and case by each model, the converged one first.

    Every model comes twice: in both postures with a right transmission angle.

    Parameters
    ----------
    study : Dataset

    Returns
    -------
    list of DataArray
    """
    models = [
        {"plies": plies, "beams": beams}
        for plies in study["plies"].values
        for beams in study["beams"].values
    ]
    models.sort(key=lambda m: m != {"plies": "unidirectional", "beams": CONVERGED})
    first = [study["frequency"].sel(model, drop=True) for model in models]
    others = [study["other_posture"].sel(model, drop=True) for model in models]
    turned = [
        frequency.where(frequency["position"] != "90", other).transpose(*frequency.dims)
        for frequency, other in zip(first, others, strict=True)
    ]
    return [*first, *turned]


def fall(frequency: xr.DataArray, dim: str, high: object, low: object) -> float:
    """Mean decrease from one coordinate to another.

    Parameters
    ----------
    frequency : DataArray
    dim : str
    high, low : object
        Coordinates along the dimension.

    Returns
    -------
    float
        In percent of the value at ``high``.
    """
    ratio = frequency.sel({dim: low}).values / frequency.sel({dim: high}).values
    return float(100 * (1 - ratio.mean()))


def range_over_models(
    models: Sequence[xr.DataArray], number: Callable[[xr.DataArray], float], unit: str
) -> str:
    """Word the least and greatest value of a number over all models.

    Parameters
    ----------
    models : sequence of DataArray
        Of :func:`all_models`.
    number : callable
        Of frequencies over position, laminate and case.
    unit : str
        Put behind, with its space.

    Returns
    -------
    str
    """
    values = [number(frequency) for frequency in models]
    return f"{min(values):.2f} to {max(values):.2f}{unit}".replace("-0.00", "0.00")


def within_a_tenth(computed: float, from_tables: float) -> Verdict:
    """Verdict on a number beside that of the printed tables."""
    near = abs(computed - from_tables) <= REPRODUCED_WITHIN * abs(from_tables)
    return "reproduced" if near else "not reproduced"


def extreme(dim: str, which: object, *, least: bool) -> Callable[[xr.DataArray], xr.DataArray]:
    """Say where a coordinate has the least or greatest value along its dimension.

    Parameters
    ----------
    dim : str
    which : object
        The coordinate.
    least : bool
        Whether it should be the least.

    Returns
    -------
    callable
        From values to truth values without the dimension.
    """

    def holds(values: xr.DataArray) -> xr.DataArray:
        extreme = values.min(dim) if least else values.max(dim)
        return values.sel({dim: which}) == extreme

    return holds


def _span(counts: list[int]) -> str:
    low, high = min(counts), max(counts)
    return f"{low}" if low == high else f"{low} to {high}"


@dataclass(frozen=True)
class Share:
    """Claim that something holds everywhere.

    Parameters
    ----------
    place, statement : str
    holds : callable
        From values over position, laminate and case to where it holds.
    """

    place: str
    statement: str
    holds: Callable[[xr.DataArray], xr.DataArray]

    def text(self, values: xr.DataArray) -> str:
        """In how many places it holds."""
        held = self.holds(values)
        return f"in {int(held.sum())} of {held.size}"

    def claim(self, published: xr.DataArray, models: Sequence[xr.DataArray], reason: str) -> Claim:
        """Test it on frequencies: the published ones, and those of all models, ours first.

        Parameters
        ----------
        published : DataArray
        models : sequence of DataArray
        reason : str

        Returns
        -------
        Claim
        """
        ours = self.holds(models[0])
        counts = [int(self.holds(frequency).sum()) for frequency in models]
        return Claim(
            self.place,
            self.statement,
            "everywhere",
            self.text(published),
            self.text(models[0]),
            f"in {_span(counts)} of {ours.size}",
            "reproduced" if bool(ours.all()) else "not reproduced",
            reason,
        )
