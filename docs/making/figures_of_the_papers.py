"""The page that has every figure and table of the three papers beside ours.

It stands in the repository with small pictures, for readers without a build. A build holds it
against what the scenarios give today; ``docs/build.py --papers`` writes it anew.
"""

from __future__ import annotations

import io
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from PIL import Image

from making.gallery import PRINTED, scenario_results
from making.pictures import PICTURES, alike
from making.printed import difference
from making.state import REPOSITORY
from making.tables_of_the_papers import PaperTables

__all__ = ["STUDY", "Row", "changed_page", "figures_page", "paper_rows", "write_page"]

HEAD = """# Figures and tables of the papers

Every figure and table of the three papers that this project starts from, beside ours: what the
paper has there, our picture or table, and how they compare. No picture of a paper is shown. Ours
are drawn by the scripts in `scenarios/` to which the pictures lead, and each verdict is read from
what they wrote. The [equations](theory/sources.md) and the [misprints](errata.md) have pages of
their own. The command `python docs/build.py --papers` writes this page.

"""
CLAIMS_HEAD = """## All claims of E

What E says of its figures and tables, claim by claim, as `scenarios/papers/elamy_2023.py` finds it:
from the paper's own tables, and from our models of its linkages.

"""
PAGE = REPOSITORY / "docs" / "figures_of_the_papers.md"
SMALL, COLOURS = 520, 32
"""Width in pixels of the pictures of the page, and their number of colours."""
ROWS = Path(__file__).with_suffix(".toml")
STUDY = "papers/elamy_2023"
"""Scenario that puts the claims of E to the test."""
STUDY_CLAIMS = "composite_claims.csv"

Results = Callable[[str], Path]
Quote = Mapping[str, str]


@dataclass(frozen=True)
class Row:
    """A figure or table, or some that have one answer; see the file of the rows.

    Parameters
    ----------
    paper, number, shows : str
    ours : sequence of str
        Pictures, each as ``SCENARIO/PICTURE``.
    table, reason, not_judged : str
        Empty where there is none.
    quotes : sequence of mapping
    claims : mapping
    study_claims : sequence of str
    """

    paper: str
    number: str
    shows: str
    ours: Sequence[str] = ()
    table: str = ""
    reason: str = ""
    not_judged: str = ""
    quotes: Sequence[Quote] = ()
    claims: Mapping[str, str] | None = None
    study_claims: Sequence[str] = ()

    @property
    def anchor(self) -> str:
        """Anchor of the heading of its table."""
        return f"{self.paper}-{self.number}".lower().replace(" ", "-").replace(".", "")


def paper_rows() -> list[Row]:
    """All rows, in the order of the papers."""
    return [Row(**row) for row in _stored()["rows"]]


def figures_page(results: Results = scenario_results) -> str:
    """Markdown of all rows and tables.

    Parameters
    ----------
    results : callable, optional
        Folder of what a scenario wrote, by its name.

    Raises
    ------
    RuntimeError
        If a picture, a line or a claim that a row names was not written.
    """
    stored = _stored()
    tables = PaperTables(stored["printed"], results(STUDY))
    parts = [HEAD]
    for short, paper in stored["papers"].items():
        rows = [row for row in paper_rows() if row.paper == short]
        parts += [f"## {short}: {paper}\n", _listed(rows, results)]
        parts += [
            f"### {short}, {row.number}\n\n{getattr(tables, row.table)()}\n"
            for row in rows
            if row.table
        ]
    return "\n".join([*parts, CLAIMS_HEAD + _claims_table(results(STUDY))])


def _stored() -> dict[str, Any]:
    return tomllib.loads(ROWS.read_text(encoding="utf-8"))


def _listed(rows: list[Row], results: Results) -> str:
    lines = ["| in the paper | ours | comparison |", "|-|-|-|"]
    for row in rows:
        ours = [_picture(row, path, results) for path in row.ours]
        if row.table:
            ours.append(f"[our table](#{row.anchor})")
        cells = (
            f"**{row.number}**<br>{row.shows}",
            "<br>".join(ours) or "none",
            "<br>".join(_comparison(row, results)),
        )
        lines.append(" | ".join(["", *(cell.replace("|", r"\|") for cell in cells), ""]).strip())
    return "\n".join(lines) + "\n"


def _picture(row: Row, path: str, results: Results) -> str:
    """A small picture that leads to its scenario."""
    name, _, picture = path.rpartition("/")
    if not (results(name) / picture).is_file():
        raise RuntimeError(f"{row.paper}, {row.number}: {name} draws no {picture}")
    words = picture.removesuffix(".png").replace("_", " ")
    alt = f"{row.paper}, {row.number}: {words}"
    return f"[![{alt}](pictures/papers/{_small_name(path)})](../scenarios/{name}.py)"


def _small_name(path: str) -> str:
    return path.removeprefix("papers/").replace("/", "_")


def _small(picture: Path) -> bytes:
    """The picture of a scenario in the size of the page, as PNG."""
    drawn = Image.open(picture).convert("RGB")
    size = (SMALL, round(SMALL * drawn.height / drawn.width))
    data = io.BytesIO()
    drawn.resize(size, Image.Resampling.LANCZOS).quantize(COLOURS).save(data, "PNG", optimize=True)
    return data.getvalue()


def _made(results: Results) -> dict[Path, bytes]:
    """The page and its pictures as they are today, by their files."""
    made = {PAGE: figures_page(results).encode()}
    for path in (path for row in paper_rows() for path in row.ours):
        name, _, picture = path.rpartition("/")
        made[PICTURES / "papers" / _small_name(path)] = _small(results(name) / picture)
    return made


def changed_page(results: Results = scenario_results) -> list[str]:
    """Files of the page that do not show what the scenarios give today, line by line."""
    return [
        f"{path.relative_to(REPOSITORY)}: shows an older state; run docs/build.py --papers"
        for path, made in _made(results).items()
        if not path.exists()
        or (difference(path.read_text(), made.decode()) if path == PAGE else not alike(path, made))
    ]


def write_page(results: Results = scenario_results) -> None:
    """Put the page and its pictures into the repository as they are today."""
    made = _made(results)
    for path in set((PICTURES / "papers").glob("*.png")) - made.keys():
        path.unlink()
    for path, data in made.items():
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(data)


def _comparison(row: Row, results: Results) -> list[str]:
    if row.reason:
        return [row.reason]
    found = [_quoted(row, quote, results) for quote in row.quotes]
    if row.claims:
        found += _claimed(row, results(row.claims["scenario"]), row.claims["figure"])
    if row.study_claims:
        found += _of_the_study(row, results(STUDY))
    if row.not_judged:
        found.append(f"**not judged.** {row.not_judged}")
    if row.table and not found:
        found.append("in the table")
    return found


def _quoted(row: Row, quote: Quote, results: Results) -> str:
    """A line that a scenario printed."""
    lines = (results(quote["scenario"]) / PRINTED).read_text(encoding="utf-8").splitlines()
    text = [line.strip() for line in lines]
    starts = [n for n, line in enumerate(text) if line.startswith(quote.get("after", ""))]
    for line in text[starts[0] :] if starts else []:
        if line.startswith(quote["line"]):
            note = quote.get("told")
            return f"{note}: {line}" if note else line
    raise RuntimeError(
        f"{row.paper}, {row.number}: {quote['scenario']} prints no {quote['line']!r}"
    )


def _claimed(row: Row, folder: Path, figure: str) -> list[str]:
    """Verdicts of a scenario that judges what a paper says."""
    claims = pd.read_csv(folder / "claims.csv", dtype=str)
    rows = claims[claims["figure"] == figure]
    if rows.empty:
        raise RuntimeError(f"{row.paper}, {row.number}: no claim of {figure!r} in {folder.name}")
    return [f"{own.claim}: **{own.verdict}** ({own.reason})" for own in rows.itertuples()]


def _of_the_study(row: Row, folder: Path) -> list[str]:
    claims = pd.read_csv(folder / STUDY_CLAIMS, dtype=str, keep_default_na=False)
    found = []
    for start in row.study_claims:
        if start.startswith("@"):
            wanted = claims[claims["place"] == start[1:]]
        else:
            wanted = claims[claims["statement"].str.startswith(start)]
        if wanted.empty:
            raise RuntimeError(f"{row.paper}, {row.number}: the study has no claim {start!r}")
        for claim in wanted.itertuples():
            theirs = {"printed": claim.printed, "its tables": claim.from_tables}
            known = [f"{words} {value}, " for words, value in theirs.items() if value]
            said = known[0] if known else ""
            found.append(f"{claim.statement}: {said}ours {claim.computed}: **{claim.verdict}**")
    return found


def _claims_table(folder: Path) -> str:
    claims = pd.read_csv(folder / STUDY_CLAIMS, dtype=str, keep_default_na=False)
    lines = ["| place | claim | printed | its tables | ours | our other models | verdict |"]
    lines += ["|-|-|-|-|-|-|-|"]
    for claim in claims.itertuples():
        ours = f"{claim.computed} ± {claim.spread}" if claim.spread else claim.computed
        parts = [
            f"**{claim.verdict}**",
            claim.fails_if and f"what would fail it: {claim.fails_if}",
        ]
        verdict = "<br>".join(filter(None, [*parts, claim.reason]))
        lines.append(
            f"| {claim.place} | {claim.statement} | {claim.printed} | {claim.from_tables} | "
            f"{ours} | {claim.other_models} | {verdict} |"
        )
    return "\n".join(lines) + "\n"
