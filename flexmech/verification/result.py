"""The result of the verification: every case with its numbers and its verdict."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from flexmech import plots
from flexmech.analyses import Result, Summary, Table

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


_DIGITS = 6
_FARTHEST = "of each case the number that is farthest off; verification.csv has all of them"


class Verification(Result):
    """What was computed in each case of the verification, and whether it is near enough.

    Parameters
    ----------
    dataset : xarray.Dataset
        Over ``case`` and ``number``: ``expected``, ``measured`` and ``deviation``, not a number
        past the last of a case, and ``label``. Over ``case``: ``subject``, ``source``,
        ``quantity``, ``unit``, ``deviation_kind``, ``tolerance``, ``verdict`` (passed, failed or
        skipped) and ``reason``, which says why nothing was compared.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
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
        """Each case with the number that is farthest off, under its source; then the count."""
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
        counts = pd.Series(self.dataset["verdict"].values).value_counts()
        words = ", ".join(f"{counts.get(v, 0)} {v}" for v in ("passed", "failed", "skipped"))
        return Summary(tuple(parts), f"{self.dataset.sizes['case']} cases: {words}")

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


def _table(subject: str, source: str, cases: list[xr.Dataset]) -> Table:
    headings = ("case", "measured", "expected", "deviation", "tolerance", "verdict")
    kinds = " or ".join(dict.fromkeys(str(case["deviation_kind"].item()) for case in cases))
    units = {str(case["unit"].item()) for case in cases} - {""}
    quantities = ", ".join(dict.fromkeys(str(case["quantity"].item()) for case in cases))
    told = f"{quantities} in {' or '.join(sorted(units))}" if units else quantities
    return Table(
        f"{subject}: {told}",
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
