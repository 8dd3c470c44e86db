"""A claim of a paper, what was found of it, and its line in a report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

Verdict = Literal["reproduced", "not reproduced", "not judged"]
# A number counts as reproduced when ours is within a tenth of the one printed.
REPRODUCED_WITHIN = 0.10


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
    verdict : {"reproduced", "not reproduced", "not judged"}
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

    def __str__(self) -> str:
        numbers = {
            "printed": self.printed,
            "from its tables": self.from_tables,
            "computed": self.computed,
            "by model": self.other_models,
        }
        known = ", ".join(f"{word} {value}" for word, value in numbers.items() if value)
        return f"{self.place}, {self.statement}: {known}"


def verdict_on(holds: bool | None) -> Verdict:
    """Put a finding on a statement into a word.

    Parameters
    ----------
    holds : bool or None
        Whether it holds; None where there is nothing to compare it with.

    Returns
    -------
    {"reproduced", "not reproduced", "not judged"}

    Examples
    --------
    >>> flexmech.studies.verdict_on(None)
    'not judged'
    """
    if holds is None:
        return "not judged"
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
    >>> flexmech.studies.within_a_tenth(62.22, 48.45)
    False
    """
    return abs(computed - printed) <= REPRODUCED_WITHIN * abs(printed)


def claim_lines(claims: Sequence[Claim]) -> Iterator[str]:
    """Claims under their verdicts, each with its numbers and below it the reason."""
    for verdict in get_args(Verdict):
        yield f"{verdict}:"
        last = ""
        for claim in claims:
            if claim.verdict == verdict:
                yield f"  {claim}"
                if claim.reason and claim.reason != last:
                    yield f"    {claim.reason}"
                last = claim.reason


def count_of_verdicts(claims: Sequence[Claim]) -> str:
    """One line with the number of claims of each verdict."""
    counts = Counter(claim.verdict for claim in claims)
    numbers = ", ".join(f"{counts[verdict]} {verdict}" for verdict in get_args(Verdict))
    return f"{len(claims)} claims: {numbers}"
