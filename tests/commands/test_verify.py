"""``flexmech verify``: verdicts on cases, their file, and the exit code."""

from __future__ import annotations

import json
import sys
from dataclasses import replace

import numpy as np
import pytest

from flexmech import InputError, Verification, verify
from flexmech.verification import (
    Computation,
    Outcome,
    VerificationCase,
    verification_case,
    verification_cases,
)
from tests.support.command import columns_of, run_command

CASE = verification_case("Limits of the transmission angle: case 1")
MATRIX = verification_case("Stiffness of graphite/epoxy [0/30/-45], plies of 5 mm: A")
WRONG = replace(CASE, name="a wrong number", expected=(57.05, 116.0))
LACKING = replace(CASE, name="a package that is not there", needs=("skfem",))
NOWHERE = Computation("four_bar_frequencies", {"model": "threebar", "engine": "reference"})
REFUSED = replace(
    CASE,
    name="a linkage that is not there",
    measured_by=NOWHERE.with_(elements=2, crank_angles=[0.0], modes=1),
)
MORE = replace(CASE, name="more numbers than expected", expected=(57.05,))


@pytest.fixture(scope="module", autouse=True)
def _without_scikit_fem():
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "skfem", None)
        yield


@pytest.fixture(scope="module")
def six() -> Verification:
    return verify([CASE, MATRIX, WRONG, LACKING, REFUSED, MORE])


def test_verdicts_and_reasons_are_those_of_the_numbers(six):
    verdicts = ["passed", "passed", "failed", "skipped", "failed", "failed"]
    assert six.dataset["verdict"].values.tolist() == verdicts
    assert six.failed == (WRONG.title, REFUSED.title, MORE.title)
    reasons = six.dataset["reason"].values.tolist()
    assert reasons[0] == ""
    assert "scikit-fem" in reasons[3]
    assert "threebar" in reasons[4]
    assert "2 numbers" in reasons[5]
    counts = {one.of or one.name: one.value for one in six.summary().numbers}
    assert counts == {"cases_passed": 2.0, "cases_failed": 3.0, "cases_skipped": 1.0}


def test_the_table_has_a_row_a_number_and_loads_back(six, tmp_path):
    six.save(tmp_path)
    table = columns_of(tmp_path / "verification.csv")
    assert ",".join(table).startswith(
        "case,source,quantity,expected,measured,tolerance,deviation,verdict"
    )
    wrong = table["case"] == WRONG.title
    assert table["verdict"][wrong].tolist() == ["passed", "failed"]
    assert float(table["deviation"][wrong][1]) == pytest.approx(116.0 - 115.288, abs=1e-3)
    loaded = Verification.load(tmp_path / "verification.nc")
    assert loaded.dataset.identical(six.dataset)
    assert loaded.failed == six.failed


@pytest.mark.parametrize("factor", [0.5, 2.0, np.nan])
def test_every_case_fails_where_its_last_number_is_off_by_twice_the_tolerance(factor):
    """A number that is not finite is a deviation too."""
    for case in verification_cases(thorough=True):
        known = not isinstance(case.expected, Computation)
        expected = case.expected_values() if known else np.array([1.0, 2.0])
        scale = {
            "relative": np.abs(expected),
            "relative to the largest": np.abs(expected).max(),
            "absolute": 1.0,
        }[case.deviation_kind]
        measured = expected.copy()
        measured[-1] = (expected + factor * case.tolerance * scale)[-1]
        outcome = Outcome(replace(case, needs=()), expected, measured)
        assert outcome.verdict == ("passed" if factor == 0.5 else "failed"), case.title


def test_cases_have_a_title_of_their_own_a_source_and_a_second_way():
    cases = verification_cases(thorough=True)
    assert len({case.title for case in cases}) == len(cases) > 60
    assert not any(case.thorough for case in verification_cases())
    for case in cases:
        assert case.tolerance > 0
        assert case.source
        assert case.expected != case.measured_by
        if not isinstance(case.expected, Computation):
            assert len(case.labels) in (0, len(case.expected))


@pytest.mark.parametrize(("cases", "words"), [([], "there is none"), ([CASE, CASE], "same title")])
def test_cases_that_cannot_be_verified_are_refused(cases: list[VerificationCase], words):
    with pytest.raises(InputError, match=words):
        verify(cases)


def test_an_unknown_case_is_refused_with_the_nearest():
    with pytest.raises(InputError, match="did you mean 'Limits of the transmission angle"):
        verification_case("Limits of the transmission angle: case 11")


@pytest.mark.parametrize(("cases", "code"), [((CASE, LACKING), 0), ((CASE, WRONG), 1)])
def test_the_exit_code_is_1_where_a_case_fails(monkeypatch, tmp_path, cases, code):
    """A minute of cases stands in the command; here two take their place."""
    monkeypatch.setattr(
        "flexmech.verification.compute.verification_cases", lambda *, thorough: cases
    )
    ended = run_command(tmp_path / "out", "verify", "--no-plots", "--json")
    assert ended.exit_code == code
    assert ended.files == ["summary.txt", "verification.csv", "verification.nc"]
    assert (WRONG.title in ended.stderr) == (code == 1)
    assert f"{2 - code - (code == 0)} of 2" in json.loads(ended.stdout)["answer"][0]
