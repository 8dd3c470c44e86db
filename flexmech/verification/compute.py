"""The verification: computing its cases, and the result, every case with its verdict."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses import Result, Summary, Table
from flexmech.analyses.datasets import versions
from flexmech.analyses.digits import Quantity
from flexmech.arrays import FloatArray, LabelledProgress, silent
from flexmech.errors import InputError
from flexmech.threads import one_thread
from flexmech.verification.cases import Outcome, VerificationCase, verification_cases

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Published numbers have at most five.
_DIGITS = 6
VERDICTS = ("passed", "failed", "skipped")
"""Verdicts of cases."""
_FARTHEST = "of each case the number that is farthest off; verification.csv has all of them"


def verify(
    cases: Sequence[VerificationCase] | None = None,
    *,
    thorough: bool = False,
    progress: LabelledProgress | None = None,
) -> Verification:
    """Compare what flexmech computes on this machine with numbers from elsewhere.

    Parameters
    ----------
    cases : sequence of VerificationCase, optional
        By default those of :func:`flexmech.verification.verification_cases`.
    thorough : bool
        With those that take longer, where ``cases`` is left out.
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    Verification

    Raises
    ------
    InputError
        If there is no case, or two have one title.

    Examples
    --------
    >>> cases = [flexmech.verification.verification_case("Four-bars at rest: steel, 0 deg, exudyn")]
    >>> flexmech.verify(cases).dataset["verdict"].values
    array(['passed'], dtype='<U6')
    """
    chosen = verification_cases(thorough=thorough) if cases is None else tuple(cases)
    if not chosen:
        raise InputError("cases: there is none to verify")
    titles = [case.title for case in chosen]
    if len(set(titles)) < len(titles):
        raise InputError("cases: two have the same title; a case is known by its title")
    outcomes, report = [], progress or silent
    with one_thread():
        for done, case in enumerate(chosen, start=1):
            outcomes.append(case.outcome())
            report("cases", done, len(chosen))
    return Verification(_dataset(outcomes))


def _dataset(outcomes: Sequence[Outcome]) -> xr.Dataset:
    most = max(outcome.expected.size for outcome in outcomes)
    cases = [outcome.case for outcome in outcomes]

    def padded(values: FloatArray) -> FloatArray:
        return np.pad(values, (0, most - values.size), constant_values=np.nan)

    numbers = {
        name: (("case", "number"), np.stack([padded(getattr(each, name)) for each in outcomes]))
        for name in ("expected", "measured", "deviation")
    }
    texts = {
        name: ("case", np.array([getattr(case, name) for case in cases]))
        for name in ("subject", "source", "quantity", "unit", "deviation_kind")
    }
    labels = [
        [_label(case, number, outcome.expected.size) for number in range(most)]
        for case, outcome in zip(cases, outcomes, strict=True)
    ]
    dataset = xr.Dataset(
        {
            **numbers,
            **texts,
            "label": (("case", "number"), np.array(labels)),
            "tolerance": ("case", [case.tolerance for case in cases]),
            "verdict": ("case", np.array([outcome.verdict for outcome in outcomes])),
            "reason": ("case", np.array([outcome.reason for outcome in outcomes])),
        },
        {"case": np.array([case.title for case in cases]), "number": np.arange(1, most + 1)},
    )
    for name, words in _VARIABLES.items():
        dataset[name].attrs = {"long_name": words}
    dataset["number"].attrs["units"] = "1"
    machine = f"{platform.system()} {platform.machine()}, Python {platform.python_version()}"
    return dataset.assign_attrs(versions("exudyn") | {"machine": machine})


def _label(case: VerificationCase, number: int, count: int) -> str:
    """Name of a number of a case; empty where there is none, or one alone."""
    if number >= count:
        return ""
    if case.labels:
        return case.labels[number] if number < len(case.labels) else ""
    return str(number + 1) if count > 1 else ""


# Numbers are in the unit that their case names.
_VARIABLES = {
    "expected": "expected number, in the unit of its case",
    "measured": "number that flexmech computed, in the unit of its case",
    "deviation": "size of the difference as the case counts it",
    "subject": "group of the case",
    "source": "where the expected numbers come from",
    "quantity": "what the numbers are",
    "unit": "unit of the numbers of the case",
    "deviation_kind": "what the difference is divided by",
    "label": "what a number belongs to",
    "tolerance": "largest deviation with which the case passes",
    "verdict": "passed, failed or skipped",
    "reason": "why nothing was compared",
    "number": "number within the case",
}


class Verification(Result):
    """Computed numbers of the verification cases, and whether they are near enough.

    Parameters
    ----------
    dataset : xarray.Dataset
        Over ``case`` and ``number``: ``expected``, ``measured`` and ``deviation``, not a number
        past the last of a case, and ``label``. Over ``case``: ``subject``, ``source``,
        ``quantity``, ``unit``, ``deviation_kind``, ``tolerance``, ``verdict`` (passed, failed or
        skipped) and ``reason``, which says why nothing was compared.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "verification"
    subject = "verification of flexmech"
    hallmark = "verdict"
    files = ("verification.csv", "verification.nc", "verification.png")

    @property
    def failed(self) -> tuple[str, ...]:
        """Titles of the cases that failed."""
        verdict = self.dataset["verdict"]
        return tuple(str(case) for case in verdict["case"].values[verdict.values == "failed"])

    def tables(self) -> dict[str, pd.DataFrame]:
        """Every number of every case; of a case without numbers one row that says so."""
        rows = [row for case in self._cases() for row in _rows(case)]
        return {"verification": pd.DataFrame(rows)}

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw deviations over their tolerances, in axes of the user's if they are given."""
        return plots.plot_verification(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """How many cases pass, by subject; in detail each with the number that is farthest off."""
        parts: list[Table | str] = [_FARTHEST]
        for (subject, source), cases in groupby(
            self._cases(), lambda case: (case["subject"].item(), case["source"].item())
        ):
            listed = list(cases)
            parts.append(_table(subject, source, listed))
            parts += [
                f"{case['verdict'].item()}: {case['case'].item()}: {case['reason'].item()}"
                for case in listed
                if case["reason"].item()
            ]
        counts = pd.Series(self.dataset["verdict"].values).value_counts().to_dict()
        passed, failed, skipped = (int(counts.get(each, 0)) for each in VERDICTS)
        answer = [f"{passed} of {self.dataset.sizes['case']} cases passed."]
        if failed:
            answer.append(f"Failed: {'; '.join(self.failed)}.")
        if skipped:
            answer.append(f"{skipped} could not be compared here; --details says why.")
        numbers = zip(VERDICTS, (passed, failed, skipped), strict=True)
        return Summary(
            tuple(answer),
            _subject_table(self._cases()),
            self._farthest(),
            tuple(parts),
            numbers=tuple(Quantity(f"cases_{name}", float(n), "", 0.0) for name, n in numbers),
        )

    def _farthest(self) -> str:
        """The case that comes nearest to its tolerance, or is farthest beyond it."""
        shares = [_share(case) for case in self._cases()]
        if not any(share >= 0 for share in shares):
            return "nothing was compared"
        worst = int(np.argmax(shares))
        name = self.dataset["case"].values[worst]
        return f"the greatest deviation is {shares[worst]:.2g} of its tolerance: {name}"

    def _cases(self) -> list[xr.Dataset]:
        return [self.dataset.isel(case=number) for number in range(self.dataset.sizes["case"])]


def _known(case: xr.Dataset) -> np.ndarray[tuple[int, ...], np.dtype[np.intp]]:
    """Indices of the numbers that a case has: those with a label, or the first one alone."""
    found = np.flatnonzero(~np.isnan(case["expected"].values) | (case["label"].values != ""))
    return found if found.size else np.zeros(1, dtype=np.intp)


def _rows(case: xr.Dataset) -> list[dict[str, object]]:
    unit = case["unit"].item()
    quantity = case["quantity"].item() + (f" in {unit}" if unit else "")
    rows = []
    for number in _known(case):
        label = case["label"].values[number]
        deviation = float(case["deviation"].values[number])
        verdict = case["verdict"].item()
        if verdict != "skipped":
            verdict = "passed" if deviation <= case["tolerance"].item() else "failed"
        rows.append(
            {
                "case": case["case"].item(),
                "source": case["source"].item(),
                "quantity": f"{quantity}: {label}" if label else quantity,
                "expected": float(case["expected"].values[number]),
                "measured": float(case["measured"].values[number]),
                "tolerance": case["tolerance"].item(),
                "deviation": deviation,
                "verdict": verdict,
                "deviation_kind": case["deviation_kind"].item(),
                "reason": case["reason"].item(),
            }
        )
    return rows


def _share(case: xr.Dataset) -> float:
    """Greatest deviation of a case over its tolerance; -1 where nothing was compared."""
    known = ~np.isnan(case["expected"].values)
    if not known.any():
        return -1.0
    # A number that is none though one is expected is the farthest off of all.
    deviation = np.nan_to_num(case["deviation"].values, nan=np.inf)[known]
    return float(deviation.max() / case["tolerance"].item())


def _subject_table(cases: list[xr.Dataset]) -> Table:
    """A row for each subject: how its cases went, and how near the worst is to its tolerance."""
    rows = []
    for subject, group in groupby(cases, lambda case: str(case["subject"].item())):
        own = list(group)
        verdicts = [str(case["verdict"].item()) for case in own]
        worst = max(map(_share, own))
        counted = (str(verdicts.count(verdict)) for verdict in VERDICTS)
        share = "-" if worst < 0 else f"{worst:.2g}"
        rows.append((subject, str(len(own)), *counted, share))
    return Table(
        "verification",
        ("subject", "cases", *VERDICTS, "greatest deviation over tolerance"),
        (tuple(rows),),
    )


def _table(subject: str, source: str, cases: list[xr.Dataset]) -> Table:
    headings = ("case", "measured", "expected", "deviation", "tolerance", "verdict")
    kinds = " or ".join(dict.fromkeys(str(case["deviation_kind"].item()) for case in cases))
    units = {str(case["unit"].item()) for case in cases} - {""}
    quantities = ", ".join(dict.fromkeys(str(case["quantity"].item()) for case in cases))
    measured = f"{quantities} in {' or '.join(sorted(units))}" if units else quantities
    return Table(
        f"{subject}: {measured}",
        headings,
        (tuple(_row(subject, case) for case in cases),),
        caption=f"source: {source} (deviation: {kinds})",
    )


def _row(subject: str, case: xr.Dataset) -> tuple[str, ...]:
    name = str(case["case"].item()).removeprefix(f"{subject}: ")
    tolerance, verdict = f"{case['tolerance'].item():g}", str(case["verdict"].item())
    known = ~np.isnan(case["expected"].values)
    if not known.any():
        return (name, "-", "-", "-", tolerance, verdict)
    # A number that is none though one is expected is the farthest off of all.
    deviation = np.nan_to_num(case["deviation"].values, nan=np.inf)
    worst = int(np.argmax(np.where(known, deviation, -1.0)))
    measured, expected = (float(case[name].values[worst]) for name in ("measured", "expected"))
    return (
        name,
        f"{measured:.{_DIGITS}g}",
        f"{expected:.{_DIGITS}g}",
        f"{float(deviation[worst]):.1e}",
        tolerance,
        verdict,
    )
