"""Designs that fail: each with its status, and no neighbour of it changed by a bit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from flexmech.errors import InputError
from flexmech.studies import Output, Variable, sweep_study, uncertainty_study
from flexmech.studies.designs.design import Design
from flexmech.studies.designs.evaluation import STATUSES, evaluate
from flexmech.units import ANGULAR_SPEED, LENGTH
from tests.support.study_data import Scripted, study, thickness


@dataclass(frozen=True)
class Faulty(Output):
    """An output with a fault that no check foresees, of one length of the rocker."""

    def of(self, design: Design) -> float:
        if design.mechanism.linkage.rocker == FAULT:
            raise ZeroDivisionError("division by zero")
        return super().of(design)


FAULT = 0.2601
VARIABLES = (
    Variable("coupler", ("linkage.coupler",), LENGTH, "range", (0.25, 0.28)),
    Variable("rocker", ("linkage.rocker",), LENGTH, "range", (0.25, 0.28)),
    Variable("crank-speed", ("crank-speed",), ANGULAR_SPEED, "range", (1.0, 20.0)),
)
# An equilibrium is sought first: a linkage that has one can be unstable by its axial forces alone.
OUTPUTS = {
    "bent": Output("lowest_frequency", angles=4),
    "tense": Output("lowest_frequency", angles=4, prestress="axial"),
    "margin": Faulty("order_margin", angles=4),
}
SOUND = [[0.2794, 0.2667, 10.0], [0.27, 0.2667, 5.0], [0.2794, 0.26, 20.0]]
FAILING = {
    "not_assembled": [0.9, 0.2667, 10.0],
    "locked": [0.254, 0.102, 10.0],
    "buckled": [0.2794, 0.2667, 180.0],
    "no_equilibrium": [0.2794, 0.2667, 200.0],
    "refused": [0.2794, 0.2667, 0.0],
    "error": [0.2794, FAULT, 10.0],
}


def test_neighbours_of_every_kind_of_failure_are_equal_to_the_last_bit() -> None:
    whole = study(*VARIABLES, outputs=OUTPUTS)
    alone = evaluate(whole, np.array(SOUND))
    assert not alone.status.any()
    failing = list(FAILING.values())
    rows = [SOUND[0], *failing[:2], SOUND[1], *failing[2:], SOUND[2]]
    found = evaluate(whole, np.array(rows))
    sound = [0, 3, 8]
    np.testing.assert_array_equal(found.values[sound], alone.values, strict=True)
    assert [STATUSES[code] for code in np.delete(found.status, sound)] == list(FAILING)
    assert np.isnan(np.delete(found.values, sound, axis=0)).all()
    assert [bool(reason) for reason in found.reasons] == (found.status != 0).tolist()
    assert set(FAILING) | {"ok"} == set(STATUSES)


def test_reasons_tell_what_is_wrong_and_where() -> None:
    whole = study(*VARIABLES, outputs={"margin": Faulty("order_margin", prestress="none")})
    rows = np.array([FAILING[name] for name in ("not_assembled", "locked", "refused", "error")])
    told = evaluate(whole, rows).reasons
    assert "cannot be assembled at any crank angle" in told[0]
    assert "change point at crank angle 0 deg" in told[1]
    assert told[2] == "order_margin needs a crank speed; state speed = ..."
    assert told[3] == "ZeroDivisionError: division by zero"


def test_lengths_that_cannot_be_assembled_are_a_finding_and_not_refused() -> None:
    coupler = Variable("coupler", ("linkage.coupler",), LENGTH, "values", (0.28, 0.9))
    found = sweep_study(study(coupler)).dataset
    assert found["status"].values.tolist() == ["ok", "not_assembled"]
    assert found["within"].values.tolist() == [True, False]


class TestIncompleteSamples:
    """A number that is missing makes Sobol's indices zero without a word."""

    SAMPLE = study(thickness(1e-3, 3e-3), thickness(1e-3, 3e-3, link="rocker"))

    @staticmethod
    def failing(designs: np.ndarray) -> np.ndarray:
        whole = designs.sum(axis=1, keepdims=True)
        return np.where(designs[:, :1] > 2.5e-3, np.nan, whole)

    def test_are_refused_with_their_share_and_cause(self) -> None:
        with pytest.raises(InputError) as caught:
            uncertainty_study(self.SAMPLE, 64, executor=Scripted(self.failing))
        assert str(caught.value) == (
            "25 % of the designs cannot be computed (64 refused; the first: no number); narrow the "
            "ranges, or say in failure_values what each output counts as then"
        )

    def test_count_as_what_the_study_says_they_are_worth(self) -> None:
        worth = study(*self.SAMPLE.variables, failure_values={"mass": 5.0})
        found = uncertainty_study(worth, 64, executor=Scripted(self.failing))
        own = found.dataset.sel(output="mass")
        assert float(own["failure_probability"]) == pytest.approx(0.25, abs=0.02)
        sound = found.dataset["status"] == "ok"
        numbers = found.dataset["mass"].where(sound, 5.0)
        assert float(own["mean"]) == pytest.approx(float(numbers.mean()), rel=1e-12)
        assert float(own["p97_5"]) == 5.0
        # That the first thickness alone decides who fails is nearly all of the variance.
        assert own["total"].values == pytest.approx([1.0, 0.0], abs=0.02)

    def test_how_failures_count_is_told(self) -> None:
        worth = study(*self.SAMPLE.variables, failure_values={"mass": 5.0})
        summary = uncertainty_study(worth, 64, executor=Scripted(self.failing)).summary()
        assert (
            "designs that cannot be computed count as mass 5.000 kg in moments, percentiles and "
            "shares, and as failing"
        ) in summary.details

    def test_an_output_without_a_worth_is_still_refused(self) -> None:
        worth = study(
            *self.SAMPLE.variables,
            outputs={"mass": Output("mass"), "torque": Output("peak_driving_torque")},
            failure_values={"mass": 5.0},
        )
        both = Scripted(lambda designs: np.repeat(self.failing(designs), 2, axis=1))
        with pytest.raises(InputError, match="25 % of the designs cannot be computed"):
            uncertainty_study(worth, 64, executor=both)
