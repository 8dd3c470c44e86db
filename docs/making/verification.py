"""The verification report, from numbers measured when the pages are built."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from flexmech.verification import Verification
from making.state import command_results

__all__ = ["verification_page", "verification_results"]

HEAD = """# Verification report

What flexmech computed when these pages were built, beside published numbers, closed forms, other
programs, and between its two engines. Nothing on this page is typed by hand: it is the table of
`flexmech verify --thorough`, whose cases the tests run too. Run `flexmech verify` for the same on
your machine (a minute). A case passes where its deviation is within its tolerance, which is stated
with the case.

"""
NAME = "verification.nc"


def verification_page(folder: Path) -> str:
    """Run the verification, put its picture into a folder; Markdown of all cases."""
    results = verification_results()
    found = Verification.load(results / NAME)
    rows = found.tables()["verification"]
    (folder / "verification.png").write_bytes((results / "verification.png").read_bytes())
    parts = [
        HEAD,
        f"**{' '.join(found.summary().answer)}** The picture shows each deviation over its "
        "tolerance.\n\n"
        "![Deviation over tolerance of every case](verification.png)\n",
    ]
    rows["subject"] = rows["case"].str.partition(": ")[0]
    for source, of_source in rows.groupby("source", sort=False):
        parts += [f"## Against: {source}\n"]
        for subject, of_subject in of_source.groupby("subject", sort=False):
            parts += [f"### {subject}\n", _rows_table(of_subject), "", _numbers(of_subject), ""]
    return "\n".join(parts)


def verification_results() -> Path:
    """Folder of what `flexmech verify` wrote; it runs only if the folder is not there yet."""
    return command_results("verification", "verify", "--thorough")


def _rows_table(rows: pd.DataFrame) -> str:
    """How many numbers were compared, and which came nearest to its tolerance."""
    compared = rows[rows["verdict"] != "skipped"]
    if compared.empty:
        return f"Skipped: {rows['reason'].iloc[0]}."
    used = compared["deviation"] / compared["tolerance"]
    worst = compared.loc[used.idxmax()]
    failed = (compared["verdict"] == "failed").sum()
    verdict = f"**{failed} failed**" if failed else "all within their tolerances"
    return (
        f"{len(compared)} numbers, {verdict}. The farthest off: {worst['quantity']}, measured "
        f"{worst['measured']:.6g}, expected {worst['expected']:.6g}, deviation "
        f"{worst['deviation']:.1e} ({worst['deviation_kind']}), tolerance "
        f"{worst['tolerance']:g}."
    )


def _numbers(rows: pd.DataFrame) -> str:
    """All numbers of a subject, folded."""
    lines = ["| case | quantity | expected | measured | deviation | tolerance | verdict |"]
    lines += ["|-|-|-|-|-|-|-|"]
    for row in rows.itertuples():
        case = row.case.removeprefix(f"{row.subject}: ")
        if row.verdict == "skipped":
            lines.append(f"| {case} | {row.quantity} | | | | | skipped: {row.reason} |")
            continue
        numbers = f"{row.expected:.6g} | {row.measured:.6g}"
        deviation = f"{row.deviation:.1e} | {row.tolerance:g}"
        lines.append(f"| {case} | {row.quantity} | {numbers} | {deviation} | {row.verdict} |")
    table = "\n".join(lines)
    # What a browser folds, without a word of script.
    return f"<details><summary>All numbers</summary>\n\n{table}\n\n</details>"
