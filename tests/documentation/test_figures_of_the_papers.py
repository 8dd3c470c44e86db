"""Every figure and table of the three papers has its row, and what a row names is there."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import flexmech
from flexmech import Mechanism, ReferenceEngine
from flexmech.studies import Claim, CompositeStudy, published_tables, study_composites
from flexmech.studies.composite_crank_rockers.linkages import stored_table
from tests.documentation.pages import DOCS, REPOSITORY

sys.path.insert(0, str(DOCS))
from making import figures_of_the_papers as making
from making.gallery import HEAD, PRINTED
from making.tables_of_the_papers import PaperTables

SCENARIOS = REPOSITORY / "scenarios"
ROWS = making.paper_rows()
IDS = [f"{row.paper}, {row.number}" for row in ROWS]
# What the papers have. K counts its figures from 1.1 on, and behind 1.9 from 2.0; its tables are
# lists without numbers, and so is the one table of S, which the text calls Table 1. What section 3
# of S says of angles has no figure.
PRINTED_IN = {
    "K": [
        *(f"Figure 1.{n}" for n in range(1, 10)),
        *(f"Figure 2.{n}" for n in range(9)),
        "Lists of section 3",
    ],
    "E": [*(f"Figure {n}" for n in range(1, 10)), *(f"Table {n}" for n in range(1, 7))],
    "S": [*(f"Figure {n}" for n in range(1, 13)), "Section 3", "Table 1"],
}


def single(number: str) -> list[str]:
    """``Figures 1.7, 1.8`` one by one."""
    kind, _, rest = number.partition(" ")
    return [f"{kind[:-1]} {n}" for n in rest.split(", ")] if kind == "Figures" else [number]


@pytest.mark.parametrize("paper", PRINTED_IN)
def test_every_figure_and_table_has_one_row(paper: str) -> None:
    rows = [number for row in ROWS if row.paper == paper for number in single(row.number)]
    assert sorted(rows) == sorted(PRINTED_IN[paper])


@pytest.mark.parametrize("row", ROWS, ids=IDS)
def test_a_row_has_ours_and_a_comparison_or_a_reason(row: making.Row) -> None:
    ours = bool(row.ours or row.table)
    assert ours != bool(row.reason)
    compared = bool(row.quotes or row.claims or row.study_claims or row.not_judged)
    assert compared <= ours
    assert compared or not row.ours
    assert row.shows.endswith((".", ")"))


@pytest.mark.parametrize("row", [row for row in ROWS if row.ours], ids=lambda row: row.number)
def test_scenarios_write_the_pictures_that_rows_name(row: making.Row) -> None:
    shown = tomllib.loads((SCENARIOS / "expected_numbers.toml").read_text())
    for path in row.ours:
        name, _, picture = path.partition("/")
        if name == making.STUDY:
            assert picture in CompositeStudy.files
            continue
        assert name in shown, "not in the gallery"
        stem = picture.removesuffix(".png")
        assert any(re.fullmatch(said, stem) for said in written_by(name)), path
    for quote in [*row.quotes, *([row.claims] if row.claims else [])]:
        assert quote["scenario"] in shown


def test_a_picture_that_no_scenario_writes_would_be_found() -> None:
    said = written_by("mode_shapes")
    assert any(re.fullmatch(each, "steel_at_rest") for each in said)
    assert not any(re.fullmatch(each, "steel_in_haste") for each in said)


def written_by(scenario: str) -> list[str]:
    """Patterns of the names by which a scenario, and what it is made of, keeps its figures."""
    found = []
    for tree in trees_of(scenario):
        for node in ast.walk(tree):
            keys = node.keys if isinstance(node, ast.Dict) else []
            found += [pattern for key in keys for pattern in pattern_of(key)]
            if isinstance(node, ast.Subscript):
                found += pattern_of(node.slice)
            if isinstance(node, ast.ImportFrom) and node.module == "flexmech":
                for alias in node.names:
                    files = getattr(getattr(flexmech, alias.name), "files", ())
                    found += [re.escape(file.removesuffix(".png")) for file in files]
    return found


def trees_of(scenario: str) -> Iterator[ast.Module]:
    tree = ast.parse((SCENARIOS / f"{scenario}.py").read_text())
    yield tree
    for node in ast.walk(tree):
        own = isinstance(node, ast.ImportFrom) and str(node.module).startswith("_")
        if own and node.module not in ("__future__", "_common"):
            yield ast.parse((SCENARIOS / f"{node.module}.py").read_text())


def pattern_of(node: ast.expr | None) -> list[str]:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return [re.escape(node.value)]
    if isinstance(node, ast.JoinedStr):
        parts = [getattr(part, "value", "") for part in node.values]
        return ["".join(re.escape(p) if isinstance(p, str) else ".+" for p in parts)]
    return []


def stored_claims() -> list[tuple[str, str, str]]:
    """Place, statement and what is printed of every claim that the study puts to the test."""
    return [tuple(row[:3]) for row in stored_table("claims.toml")["claims"]]


def test_the_study_has_the_claims_that_rows_name() -> None:
    for row in ROWS:
        for start in row.study_claims:
            found = [
                place == start[1:] if start.startswith("@") else statement.startswith(start)
                for place, statement, _ in stored_claims()
            ]
            assert any(found), start


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Tables and pictures of a study whose first model found the published numbers everywhere."""
    folder = tmp_path_factory.mktemp("study")
    ours = "0.1408, 0.9005, 0.4572"
    rows = [
        Claim(place, statement, printed, "61 %", ours, "", "undecidable")
        for place, statement, printed in stored_claims()
    ]
    pd.DataFrame(rows).to_csv(folder / "composite_claims.csv", index=False)
    published = published_tables().to_dataframe().reset_index()
    table = pd.DataFrame({name: published[name] for name in ("position", "laminate", "case")})
    for name in ("finite_element", "measured"):
        table[f"published_{name}_Hz"] = published[name]
        table[f"published_{name}_ratio"] = published[name] / published[name].iloc[0]
    table["frequency_Hz"] = published["finite_element"]
    table["ratio"] = table["published_finite_element_ratio"]
    table["strain_energy_damping"] = table["published_damping"] = published["damping"]
    first, other = table.assign(plies="straight"), table.assign(plies="bent", frequency_Hz=1.0)
    pd.concat([first, other]).to_csv(folder / "composites.csv", index=False)
    return folder


@pytest.mark.thorough
def test_the_study_writes_what_the_page_reads(
    results: Callable[[str], Path], tmp_path: Path
) -> None:
    def engine(mechanism: Mechanism, elements: int, element: str) -> ReferenceEngine:
        return ReferenceEngine(mechanism, min(elements, 2), element, component_modes=False)

    found = study_composites(engine)
    for name, frame in found.tables().items():
        frame.to_csv(tmp_path / f"{name}.csv", index=False)
    for row in ROWS:
        for path in row.ours:
            if path.startswith(making.STUDY):
                (tmp_path / path.partition("/")[2]).touch()
    page = making.figures_page(tmp_path, lambda n: tmp_path if n == making.STUDY else results(n))
    for number in (4, 5, 6):
        assert len(numbers_of(page, f"e-table-{number}", 4)) == 24


def verdict_of(row: making.Row) -> str:
    """Verdicts that are not all the same."""
    return "not reproduced" if row.number.endswith("6") else "reproduced"


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory, study: Path) -> Callable[[str], Path]:
    """Folders of scenarios that wrote all that the rows name, in words of their own."""
    tmp_path, folders = tmp_path_factory.mktemp("scenarios"), {making.STUDY: study}
    for row in ROWS:
        named = [path.partition("/")[::2] for path in row.ours]
        for name, picture in named:
            folder = folders.setdefault(name, tmp_path / name)
            folder.mkdir(exist_ok=True)
            (folder / picture).write_bytes(b"a picture")
        for quote in row.quotes:
            with (folders[quote["scenario"]] / PRINTED).open("a") as printed:
                printed.write(f"{quote.get('after', '')}\n  {quote['line']} told {row.number}\n")
        if row.claims:
            file = folders[row.claims["scenario"]] / "claims.csv"
            claim = {"figure": row.claims["figure"], "claim": f"claim of {row.number}"}
            claim |= {"verdict": verdict_of(row), "reason": "measured"}
            pd.DataFrame([claim]).to_csv(file, mode="a", header=not file.exists(), index=False)
    return folders.__getitem__


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("made")


@pytest.fixture(scope="module")
def page(results: Callable[[str], Path], made: Path) -> str:
    return making.figures_page(made, results)


def test_the_page_tells_what_was_written(page: str, made: Path) -> None:
    for row in ROWS:
        assert f"* - **{row.number}**<br>" in page
        assert all(f"(gallery/{path})" in page for path in row.ours if making.STUDY not in path)
        assert not row.table or page.count(f"#{row.anchor})") == page.count(f"({row.anchor})=") == 1
        assert all(f"{quote['line']} told {row.number}" in page for quote in row.quotes)
        claim = f"claim of {row.number}: **{verdict_of(row)}** (measured)"
        assert not row.claims or claim in page
    assert "C6 is below C1 by: printed 62.22 %, ours 0.1408, 0.9005, 0.4572: **undecid" in page
    assert "case, within: its tables 61 %, ours 0.1408" in page
    drawn = made / "study_composites" / "frequencies_by_laminate.png"
    assert drawn.read_bytes() == b"a picture"


def row_of(paper: str, number: str) -> making.Row:
    return next(row for row in ROWS if (row.paper, row.number) == (paper, number))


def test_what_was_not_written_is_refused(results: Callable[[str], Path], tmp_path: Path) -> None:
    row = row_of("K", "Figure 1.5")
    with pytest.raises(RuntimeError, match=r"K, Figure 1\.5: lumped_masses draws no drive\.png"):
        making._picture(row, "lumped_masses/drive.png", tmp_path, results)
    quote = {"scenario": "lumped_masses", "line": "13 lumped"}
    with pytest.raises(RuntimeError, match=r"K, Figure 1\.5: lumped_masses prints no '13 lumped'"):
        making._quoted(row, quote, results)
    with pytest.raises(RuntimeError, match="no claim of '13' in coupler_curves"):
        making._claimed(row, results("coupler_curves"), "13")
    with pytest.raises(RuntimeError, match="no claim 'gears'"):
        making._of_the_study(replace(row, study_claims=("gears",)), results(making.STUDY))


def test_a_line_is_that_behind_its_heading(tmp_path: Path) -> None:
    (tmp_path / PRINTED).write_text("steel\n  claim: holds\naluminium\n  claim: fails\n")
    quote = {"scenario": "any", "line": "claim:", "after": "aluminium", "told": "Aluminium"}
    row = row_of("K", "Figure 1.5")
    assert making._quoted(row, quote, lambda name: tmp_path) == "Aluminium: claim: fails"


def numbers_of(page: str, table: str, column: int) -> list[float]:
    _, _, section = page.partition(f"({table})=")
    lines = re.findall(r"(?:^\|.*\n)+", section, re.MULTILINE)[0].splitlines()[2:]
    return [float(line.strip("| ").split(" | ")[column]) for line in lines]


def test_numbers_beside_the_printed_ones(page: str) -> None:
    lumps = [numbers_of(page, "k-figure-1-5", column) for column in (1, 2)]
    assert len(lumps[0]) == 6
    assert lumps[0] == pytest.approx(lumps[1], rel=1e-6)
    moduli = [121.9, 121.2, 105.5, 59.4, 43.6, 43.0]
    assert numbers_of(page, "e-table-2", 3) == pytest.approx(moduli, abs=0.05)
    even = np.linspace(121.872, 42.972, 6)
    assert numbers_of(page, "e-table-2", 4) == pytest.approx(even, abs=0.051)
    assert numbers_of(page, "s-table-1", 5) == pytest.approx([0.026148, 0.011780], abs=5e-7)
    # Of a balanced fabric, but for what contraction adds, the mean of along and across.
    across = [1 / (0.6 / fibre + 0.4 / 2.43) for fibre in (201.5, 70.0)]
    woven = np.array(numbers_of(page, "e-table-2", 5))[[0, 5]]
    assert woven == pytest.approx((even[[0, 5]] + across) / 2, rel=1e-2)
    # The first model of this study found what is published.
    for number in (4, 5, 6):
        published, ours = (numbers_of(page, f"e-table-{number}", column) for column in (2, 4))
        assert len(published) == 24
        assert ours == pytest.approx(published, abs=0.005)


def test_other_data_than_printed_are_refused(study: Path) -> None:
    printed: dict[str, Any] = making._stored()["printed"]
    printed["resins"]["R-914"] = [58.4, 62.6, 3.02, 7.1]
    with pytest.raises(RuntimeError, match="other data than the paper"):
        PaperTables(printed, study).resins()


def test_the_page_is_reached_from_the_gallery_and_the_first_page() -> None:
    assert "(../figures_of_the_papers.md)" in HEAD
    first = (DOCS / "index.md").read_text()
    assert "(made/figures_of_the_papers.md)" in first
    assert "\nmade/figures_of_the_papers\n" in first
