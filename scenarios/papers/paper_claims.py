"""A claim of a paper, what was found of it, and words for it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

Verdict = Literal["reproduced", "not reproduced", "undecidable", "not judged"]
# A number counts as reproduced when ours is within a tenth of the one printed, or within twice
# ours' own uncertainty where that is more.
REPRODUCED_WITHIN = 0.10
SPREADS = 2.0
# Outcome of a test: texts of a claim by their names, ``holds`` and ``decidable`` if that can be
# checked, and ``numbers`` for its reason.
Found = dict[str, Any]


@dataclass(frozen=True)
class Band:
    """Numbers that count as the one that a paper prints.

    Half of it is a tenth of the number printed, or twice the uncertainty of ours where that is
    more. A band that is not narrower than the effect claimed decides nothing: it holds the
    effect and none of it alike.

    Parameters
    ----------
    printed : float
    spread : float
        Standard uncertainty of our number.
    no_effect : float
        The number if there were no such effect.

    Examples
    --------
    >>> band = Band(62.2, spread=4.0)
    >>> band.half, band.decides, band.holds(48.5)
    (8.0, True, False)
    """

    printed: float
    spread: float = 0.0
    no_effect: float = 0.0

    @property
    def half(self) -> float:
        """From the number printed to an edge."""
        return max(REPRODUCED_WITHIN * abs(self.printed), SPREADS * self.spread)

    @property
    def edges(self) -> tuple[float, float]:
        """Least and greatest number that counts as the one printed."""
        return self.printed - self.half, self.printed + self.half

    @property
    def decides(self) -> bool:
        """Whether it is narrower than the effect."""
        return self.half < abs(self.printed - self.no_effect)

    def holds(self, computed: float) -> bool:
        """Whether a number counts as the one printed.

        Parameters
        ----------
        computed : float
        """
        return abs(computed - self.printed) <= self.half


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
        Ours by other models; empty where they make no difference.
    verdict : {"reproduced", "not reproduced", "undecidable", "not judged"}
    reason : str
        Why, where it needs saying.
    spread : str
        Uncertainty of ours by that of what is printed; empty where there is none.
    fails_if : str
        What of ours would have made the claim fail; of a claim that is not judged, why nothing.
    """

    place: str
    statement: str
    printed: str
    from_tables: str
    computed: str
    other_models: str
    verdict: Verdict
    reason: str = ""
    spread: str = ""
    fails_if: str = ""

    def __str__(self) -> str:
        numbers = {
            "printed": self.printed,
            "from its tables": self.from_tables,
            "computed": " \N{PLUS-MINUS SIGN} ".join(filter(None, (self.computed, self.spread))),
            "by model": self.other_models,
        }
        known = ", ".join(f"{word} {value}" for word, value in numbers.items() if value)
        return f"{self.place}, {self.statement}: {known}"

    @property
    def paper(self) -> str:
        """Paper that the place names; empty for the one under test."""
        return self.place.rpartition(", ")[0]

    @property
    def concluded(self) -> str:
        """The statement, with the number printed where it is one of a number."""
        return (
            f"{self.statement} {self.printed}" if self.statement.endswith(" by") else self.statement
        )


def verdict_on(holds: bool | None, *, decidable: bool = True) -> Verdict:
    """Put a finding on a statement into a word.

    Parameters
    ----------
    holds : bool or None
        Whether it holds; None where there is nothing to compare it with.
    decidable : bool
        Whether a number that held would differ from one that did not; see :class:`Band`.

    Returns
    -------
    {"reproduced", "not reproduced", "undecidable", "not judged"}

    Examples
    --------
    >>> verdict_on(None)
    'not judged'
    """
    if holds is None:
        return "not judged"
    if not decidable:
        return "undecidable"
    return "reproduced" if holds else "not reproduced"


def within_a_tenth(printed: float, computed: float) -> bool:
    """Whether a number counts as that of the paper.

    Parameters
    ----------
    printed : float
        In the paper's text or tables.
    computed : float
        Ours.

    Returns
    -------
    bool

    Examples
    --------
    >>> within_a_tenth(62.22, 48.45)
    False
    """
    return abs(computed - printed) <= REPRODUCED_WITHIN * abs(printed)


def judged_by(band: Band, computed: float, unit: str, decimals: int = 2) -> Found:
    """Our number held against one that is printed."""
    edges = f"{band.edges[0]:.{decimals}f} to {band.edges[1]:.{decimals}f} {unit}".rstrip()
    words = f"ours is outside {edges}"
    if not band.decides:
        words += f", which holds {band.no_effect:g} too and decides nothing"
    return {
        "holds": band.holds(computed),
        "decidable": band.decides,
        "spread": f"{band.spread:.{decimals}f} {unit}".rstrip() if band.spread else "",
        "fails_if": words,
    }


def judged_by_order(difference: float, spread: float, words: str, least: float = 0.0) -> Found:
    """An order that is claimed: by the least relative difference in it, negative if reversed."""
    told = f"{100 * difference:z.2f} %"
    if spread:
        told += f" \N{PLUS-MINUS SIGN} {100 * spread:.2f} %"
    return {
        "holds": difference > least,
        "decidable": spread == 0 or abs(difference) > SPREADS * spread,
        "fails_if": f"{words}; the least difference is {told}",
    }


def numbers_in(printed: str) -> list[float]:
    """Numbers in what is printed."""
    return [float(number) for number in re.findall(r"[\d.]+", printed)]


def span(numbers: ArrayLike, decimals: int = 2) -> str:
    """Least and greatest of numbers in words, or the one that both are."""
    ends = (f"{end:z.{decimals}f}" for end in (np.min(numbers), np.max(numbers)))
    return " to ".join(dict.fromkeys(ends))


def claim_lines(claims: Sequence[Claim]) -> Iterator[str]:
    """Claims under their verdicts, each with its numbers, what fails it, and the reason."""
    for verdict in get_args(Verdict):
        yield f"{verdict}:"
        last = ""
        for claim in claims:
            if claim.verdict == verdict:
                yield f"  {claim}"
                if claim.fails_if:
                    yield f"    what would fail it: {claim.fails_if}"
                if claim.reason and claim.reason != last:
                    yield f"    {claim.reason}"
                last = claim.reason


def claim_table(claims: Sequence[Claim]) -> pd.DataFrame:
    """How many claims of each verdict there are, a row for each place of the paper."""
    places = list(dict.fromkeys(claim.place for claim in claims))
    counts = pd.crosstab([claim.place for claim in claims], [claim.verdict for claim in claims])
    counts = counts.reindex(index=places, columns=get_args(Verdict), fill_value=0)
    return counts.rename_axis(index=None, columns=None)


def verdict_sentences(
    paper: str, claims: Sequence[Claim], conclusions: Collection[str]
) -> tuple[str, ...]:
    """How many claims of each verdict there are, and what became of the paper's conclusions.

    Parameters
    ----------
    paper : str
        The one under test.
    claims : sequence of Claim
    conclusions : collection of str
        Statements of those claims that are conclusions.

    Returns
    -------
    tuple of str
        The verdicts by paper; then the conclusions that are not reproduced, with our number, and
        all others.
    """
    sentences = []
    for other in dict.fromkeys(claim.paper for claim in claims):
        counts = Counter(claim.verdict for claim in claims if claim.paper == other)
        numbers = [f"{counts[verdict]} {verdict}" for verdict in get_args(Verdict)]
        sentences.append(f"{other or paper}, {counts.total()} claims: {', '.join(numbers)}.")
    found: dict[Verdict, list[Claim]] = {verdict: [] for verdict in get_args(Verdict)}
    for claim in claims:
        if claim.statement in conclusions:
            found[claim.verdict].append(claim)
    missed = [f"{claim.concluded} (here {claim.computed})" for claim in found.pop("not reproduced")]
    if missed:
        sentences.append(f"Conclusions that are not reproduced: {'; '.join(missed)}.")
    others = [
        f"{verdict} ({'; '.join(claim.concluded for claim in group)})"
        for verdict, group in found.items()
        if group
    ]
    if others:
        sentences.append(f"Other conclusions: {' or '.join(others)}.")
    return tuple(sentences)
