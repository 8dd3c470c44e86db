"""The first sentences of a study of a paper: its claims by verdict, and its conclusions."""

from collections import Counter
from dataclasses import replace

import pytest

from flexmech.studies import Claim, CompositeStudy
from flexmech.studies.claim import verdict_sentences
from flexmech.studies.composite_crank_rockers.linkages import stored_table
from tests.support.published_study import published_study

FALL = Claim("section 1", "it falls by", "30 %", "", "10 %", "", "not reproduced")
LESS = Claim("abstract", "torque is less", "less", "", "19 % of steel", "", "reproduced")
LOSS = Claim("Table 1", "damping rises by", "5 %", "", "", "", "not judged")
ASIDE = Claim("Table 2", "density", "1538", "", "1700", "", "not reproduced")
CONCLUSIONS = ["it falls by", "torque is less", "damping rises by"]


def test_conclusions_are_named_by_what_became_of_them():
    assert verdict_sentences([ASIDE, FALL, LESS, LOSS], CONCLUSIONS) == (
        "Of the paper's 4 claims 1 are reproduced, 2 are not reproduced, 0 are undecidable, "
        "1 are not judged.",
        "Of its conclusions these are not reproduced: it falls by 30 % (here 10 %).",
        "The others are reproduced (torque is less) or not judged (damping rises by 5 %).",
    )


def test_where_none_is_missed_there_are_two_sentences():
    found = verdict_sentences([ASIDE, replace(FALL, verdict="reproduced"), LESS], CONCLUSIONS)
    assert found[1:] == ("Its conclusions are reproduced (it falls by 30 %; torque is less).",)
    assert len(verdict_sentences([ASIDE], CONCLUSIONS)) == 1
    assert len(verdict_sentences([FALL], CONCLUSIONS)) == 2


def test_every_conclusion_is_one_claim():
    stored = stored_table("claims.toml")
    counts = Counter(claim[1] for claim in stored["claims"])
    assert all(counts[conclusion] == 1 for conclusion in stored["conclusions"])


@pytest.fixture(scope="module")
def study() -> CompositeStudy:
    return CompositeStudy(published_study())


def test_the_answer_of_the_study_counts_its_claims_and_names_each_conclusion_once(study):
    answer, claims = study.summary().answer, study.claims()
    counts = Counter(claim.verdict for claim in claims)
    assert answer[0].startswith(
        f"Of the paper's {len(claims)} claims {counts['reproduced']} are reproduced, "
        f"{counts['not reproduced']} are not reproduced, "
    )
    assert len(answer) == 3
    for conclusion in stored_table("claims.toml")["conclusions"]:
        (claim,) = (each for each in claims if each.statement == conclusion)
        missed = claim.verdict == "not reproduced"
        assert (claim.concluded in answer[1]) is missed
        assert (claim.concluded in answer[2]) is not missed
    assert "(here steel 200 GPa, laminates " in answer[1]
    # Its frequencies are the published ones.
    assert "frequency: C6 is below C1 by 62.22 %" in answer[2]


def test_a_conclusion_that_the_frequencies_no_longer_hold_moves_to_those_missed(study):
    data = study.dataset.copy(deep=True)
    data["frequency"].loc[{"laminate": "C6"}] *= 1.5
    answer = CompositeStudy(data).summary().answer
    assert "frequency: C6 is below C1 by 62.22 % (here " in answer[1]
    assert "C6 is below C1" not in answer[2].replace("damping: C1 is below C6", "")
