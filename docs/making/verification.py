"""The verification report, from numbers measured when the pages are built."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pandas as pd

from making.state import cache_folder, environment

__all__ = ["verification_page"]

HEAD = """# Verification report

What flexmech computed when these pages were built, beside published numbers, closed forms, other
programs, and between its two engines. Nothing on this page is typed by hand: it is the table of
`flexmech verify --thorough`, whose cases the tests run too. Run `flexmech verify` for the same on
your machine (a minute). A case passes where its deviation is within its tolerance, which is stated
with the case.

"""
NAME = "verification.csv"


def verification_page(folder: Path) -> str:
    """Run the verification, put its picture into a folder; Markdown of all cases."""
    results = _results()
    rows = pd.read_csv(results / NAME, keep_default_na=False)
    (folder / "verification.png").write_bytes((results / "verification.png").read_bytes())
    counts = rows.groupby("case", sort=False)["verdict"].agg(_of_the_case).value_counts()
    told = ", ".join(f"{counts.get(word, 0)} {word}" for word in ("passed", "failed", "skipped"))
    parts = [
        HEAD,
        f"**{len(rows['case'].unique())} cases: {told}.** The picture shows each deviation over "
        "its tolerance.\n\n![Deviation over tolerance of every case](verification.png)\n",
    ]
    for source, of_source in rows.groupby("source", sort=False):
        parts += [f"## {source}\n"]
        for case, of_case in of_source.groupby("case", sort=False):
            parts += [f"### {case}\n", _table(of_case), ""]
    return "\n".join(parts)


def _results() -> Path:
    """Folder of what `flexmech verify` wrote; it runs only if the folder is not there yet."""
    folder = cache_folder() / "verification"
    if not (folder / NAME).exists():
        command = [sys.executable, "-m", "flexmech", "verify", "--thorough", "--quiet"]
        run = subprocess.run(
            [*command, "--out", str(folder)], capture_output=True, text=True, env=environment()
        )
        if run.returncode:
            raise RuntimeError(f"the verification failed: {run.stderr.strip()}")
    return folder


def _of_the_case(verdicts: pd.Series[str]) -> str:
    """A case fails where one of its numbers does."""
    return "failed" if "failed" in set(verdicts) else str(verdicts.iloc[0])


def _table(rows: pd.DataFrame) -> str:
    """Numbers of a case; what is the same in all of them is said once."""
    kind, tolerance = rows["deviation_kind"].iloc[0], rows["tolerance"].iloc[0]
    lines = [f"Tolerance: {tolerance:g} ({kind}).", ""]
    lines += ["| quantity | expected | measured | deviation | verdict |", "|-|-|-|-|-|"]
    for row in rows.itertuples():
        if row.verdict == "skipped":
            lines.append(f"| {row.quantity} | | | | skipped: {row.reason} |")
            continue
        numbers = f"{float(row.expected):.6g} | {float(row.measured):.6g}"
        lines.append(f"| {row.quantity} | {numbers} | {float(row.deviation):.1e} | {row.verdict} |")
    return "\n".join(lines)
