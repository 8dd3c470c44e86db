"""The verification: how cases pass, fail and are skipped, and how the result tells it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import flexmech
from flexmech.cli import app
from flexmech.verification import (
    Computation,
    Verification,
    VerificationCase,
    compute,
    verification_case,
    verification_cases,
)
from flexmech.verification.methods import METHODS
from tests.support.figure_checks import FULL_WIDTH_PANEL, GRID_PANEL, check_layout, legend_texts

CASE = verification_case("Limits of the transmission angle: case 1")
MATRIX = verification_case("Stiffness of graphite/epoxy [0/30/-45], plies of 5 mm: A")
WRONG = replace(CASE, name="a wrong number", expected=(57.05, 116.0))
LACKING = replace(CASE, name="a package that is not there", needs=("skfem",))
REFUSED = replace(
    CASE,
    name="a linkage that is not there",
    measured_by=Computation("four_bar_frequencies", {"model": "threebar", "engine": "reference"}),
)
FIVE = (CASE, MATRIX, WRONG, LACKING, REFUSED)


@pytest.fixture(autouse=True)
def _without_skfem(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flexmech.verification.cases.find_spec", lambda name: None)


@pytest.fixture
def five() -> Verification:
    refused = replace(
        REFUSED,
        measured_by=REFUSED.measured_by.with_(elements=2, crank_angles=[0.0], modes=1),
    )
    return flexmech.verify([*FIVE[:-1], refused])


def test_verdicts_are_computed(five: Verification) -> None:
    verdicts = dict(zip(five.dataset["case"].values, five.dataset["verdict"].values, strict=True))
    assert verdicts == {
        CASE.title: "passed",
        MATRIX.title: "passed",
        WRONG.title: "failed",
        LACKING.title: "skipped",
        REFUSED.title: "failed",
    }
    assert five.failed == (WRONG.title, REFUSED.title)
    reasons = five.dataset["reason"].values
    assert reasons[3] == "not installed: scikit-fem, of the extra 'verify'"
    assert reasons[4].startswith("cannot be computed: there is no example 'threebar'")


@pytest.mark.parametrize("case", verification_cases(thorough=True), ids=lambda case: case.title)
def test_every_case_can_fail(case: VerificationCase) -> None:
    """A number that is off by twice the tolerance fails, and so does one that is none."""
    known = isinstance(case.expected, tuple)
    expected = case.expected_values() if known else np.array([1.0, 2.0])
    scale = {
        "relative": np.abs(expected),
        "relative to the largest": np.abs(expected).max(),
        "absolute": 1.0,
    }[case.deviation_kind]
    for factor, verdict in ((0.5, "passed"), (2.0, "failed"), (np.nan, "failed")):
        off = expected.copy()
        off[-1] = (expected + factor * case.tolerance * scale)[-1]
        outcome = compute.Outcome(replace(case, needs=()), expected, off)
        assert outcome.verdict == verdict


def test_cases_say_what_they_are() -> None:
    cases = verification_cases(thorough=True)
    assert len({case.title for case in cases}) == len(cases) > 60
    assert {case.thorough for case in verification_cases()} == {False}
    for case in cases:
        assert case.measured_by.method in METHODS
        assert case.tolerance > 0
        assert case.source
        if isinstance(case.expected, Computation):
            assert case.expected.method in METHODS
            assert case.expected != case.measured_by
        else:
            assert len(case.labels) in (0, len(case.expected))
    used = {case.measured_by.method for case in cases}
    used |= {case.expected.method for case in cases if isinstance(case.expected, Computation)}
    assert used == set(METHODS)


def test_numbers_of_another_count_fail() -> None:
    outcome = replace(CASE, expected=(57.05,)).outcome()
    assert outcome.verdict == "failed"
    assert outcome.reason == "2 numbers were computed where 1 are expected"


@pytest.mark.parametrize(
    ("cases", "words"), [([], "there is none"), ([CASE, CASE], "two have the same title")]
)
def test_cases_that_cannot_be_verified(cases: list[VerificationCase], words: str) -> None:
    with pytest.raises(flexmech.InputError, match=words):
        flexmech.verify(cases)


def test_an_unknown_case_is_told_with_the_nearest() -> None:
    with pytest.raises(flexmech.InputError, match="did you mean 'Limits of the transmission angle"):
        verification_case("Limits of the transmission angle: case 11")


def test_files(five: Verification, tmp_path: Path) -> None:
    files = five.save(tmp_path)
    assert [file.name for file in files] == ["verification.csv", "verification.nc"]
    table = pd.read_csv(tmp_path / "verification.csv")
    first = ["case", "source", "quantity", "expected", "measured", "tolerance", "deviation"]
    assert list(table.columns[:8]) == [*first, "verdict"]
    assert len(table) == 2 + 9 + 2 + 1 + 1
    wrong = table[table["case"] == WRONG.title]
    assert [text.partition(": ")[2] for text in wrong["quantity"]] == ["least", "greatest"]
    assert list(wrong["verdict"]) == ["passed", "failed"]
    assert wrong["deviation"].iloc[1] == pytest.approx(116.0 - 115.29, abs=5.1e-3)
    loaded = Verification.load(tmp_path / "verification.nc")
    assert loaded.dataset.identical(five.dataset)
    assert loaded.failed == five.failed


def test_summary(five: Verification) -> None:
    summary = five.summary()
    assert summary.answer[0] == "2 of 5 cases passed."
    assert summary.answer[1].startswith(f"Failed: {five.failed[0]}; {five.failed[1]}")
    assert summary.answer[2].startswith("1 could not be compared here")
    assert [(one.of or one.name, one.value) for one in summary.numbers] == [
        ("cases_passed", 2.0),
        ("cases_failed", 2.0),
        ("cases_skipped", 1.0),
    ]
    assert "of its tolerance: " in summary.trust
    text = str(summary)
    assert "source: Kaw, Mechanics of Composite Materials" in text
    assert f"skipped: {LACKING.title}: not installed: scikit-fem" in text
    rows = {line.split("  ")[0]: line.split() for line in text.splitlines()}
    assert rows["a wrong number"][3:6] == ["115.288", "116", "7.1e-01"]


@pytest.mark.parametrize(("width", "panel"), [(180, FULL_WIDTH_PANEL), (88, GRID_PANEL)])
def test_picture_of_all_cases(width: float, panel: tuple[float, float]) -> None:
    outcomes = [
        compute.Outcome(replace(case, needs=()), np.ones(2), np.array([1.0, 1 + 1e-5]))
        for case in verification_cases(thorough=True)
    ]
    with flexmech.plots.page_width(width):
        check_layout(Verification(compute._dataset(outcomes)).plot(), panel)


def test_picture(five: Verification) -> None:
    figure = five.plot()
    assert legend_texts(figure) == ["passed", "failed", "tolerance"]
    (axes,) = figure.axes
    crosses = [line for line in axes.lines if line.get_marker() == "X" and len(line.get_xdata())]
    deviation = float(five.dataset["deviation"].sel(case=WRONG.title)[1])
    assert crosses[0].get_xdata() == pytest.approx([deviation / WRONG.tolerance])
    assert len(crosses) == 2


def run(monkeypatch: pytest.MonkeyPatch, cases: tuple[VerificationCase, ...], *options: str):  # type: ignore[no-untyped-def]
    def chosen(*, thorough: bool) -> tuple[VerificationCase, ...]:
        return tuple(case for case in cases if thorough or not case.thorough)

    monkeypatch.setattr(compute, "verification_cases", chosen)
    return CliRunner().invoke(app, ["verify", *options])


def test_command_that_passes(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    cases = (CASE, LACKING, replace(WRONG, thorough=True))
    shown = run(monkeypatch, cases, "--out", str(tmp_path), "--no-plots")
    assert shown.exit_code == 0, shown.stderr
    assert shown.stdout.splitlines()[0] == "1 of 2 cases passed."
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "summary.txt",
        "verification.csv",
        "verification.nc",
    ]
    assert run(monkeypatch, cases, "--thorough").exit_code == 1


def test_command_that_fails(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    out = ("--out", str(tmp_path), "--no-plots")
    shown = run(monkeypatch, (CASE, WRONG), *out)
    assert shown.exit_code == 1
    assert shown.stderr.startswith(f"error: 1 case of the verification failed: {WRONG.title}; ")
    assert "failed" in (tmp_path / "verification.csv").read_text()
    quiet = run(monkeypatch, (CASE, WRONG), "--quiet")
    assert (quiet.exit_code, quiet.stdout) == (1, "")
    content = json.loads(run(monkeypatch, (CASE, WRONG), "--json").stdout)
    assert content["answer"] == ["1 of 2 cases passed.", f"Failed: {WRONG.title}."]
    assert content["details"]["tables"][0]["rows"][1] == [
        "a wrong number", 115.288, 116.0, 0.71, 0.0051, "failed"
    ]  # fmt: skip
