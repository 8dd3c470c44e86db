"""The hammer test on the running linkage: what is asked, what is refused, and its files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from flexmech import (
    ComputationError,
    ExudynEngine,
    InputError,
    LinkPoint,
    ReferenceEngine,
    RunningHammerRequest,
    RunningHammerTest,
    linkages,
    load_mechanism,
    running_hammer_test,
)
from flexmech.dynamical_systems import HalfSinePulse
from flexmech.linear_system import Engine

HIT, SEEN = LinkPoint("coupler", 0.5), LinkPoint("rocker", 0.5)
REQUEST = RunningHammerRequest(20.0, HIT, SEEN, damping_ratio=0.1, bandwidth=60.0, orders=1)


def engine(name: str = "aluminium_fourbar") -> ReferenceEngine:
    return ReferenceEngine(load_mechanism(f"models/{name}.toml"), 2)


@pytest.fixture(scope="module")
def found() -> RunningHammerTest:
    return running_hammer_test(engine(), REQUEST)


def test_the_sidebands_identified_are_those_predicted(found: RunningHammerTest) -> None:
    peaks = found.peaks()
    assert peaks["order"].tolist() == [-1, 0, 1]
    np.testing.assert_allclose(peaks["identified_m_N"], peaks["predicted_m_N"], rtol=0.05)
    assert peaks["bins_apart"].max() <= 1


def test_the_frozen_linkage_answers_otherwise(found: RunningHammerTest) -> None:
    """A test against it would not see the rotation of the crank: the check above can fail."""
    frozen = found.dataset["frozen_real"] + 1j * found.dataset["frozen_imag"]
    largest = np.abs(frozen).max("frequency").values
    assert np.abs(largest / found.peaks()["predicted_m_N"] - 1).max() > 0.05


@pytest.mark.thorough
def test_loads_and_springs_count_in_runs_and_in_what_is_predicted() -> None:
    """A spring with damper at the coupler, one in a joint, and a load over the crank angle."""
    middle = LinkPoint("rocker", 0.5)
    place = linkages.AttachmentPoint("rocker", 0.5 * 0.2667)
    spring = linkages.Spring(
        "hold", linkages.AttachmentPoint("ground", 0.2, 0.5), place, 400.0, 0.3, 0.5
    )
    hinge = linkages.JointSpring("B", 0.0, 0.002)
    load = linkages.Load(
        "press", place, ((0.0, 0.0), (2.0, 0.0)), (0.0, 0.0), "ground", "crank_angle", (0.5, 1.0)
    )
    bare = engine().mechanism
    held = replace(bare, springs=(spring,), joint_springs=(hinge,), loads=(load,))
    request = replace(REQUEST, impact=middle, response=middle, prestress="axial", bandwidth=40.0)
    with_all, without = (running_hammer_test(ReferenceEngine(m, 2), request) for m in (held, bare))
    peaks = with_all.peaks()
    np.testing.assert_allclose(peaks["identified_m_N"], peaks["predicted_m_N"], rtol=0.02)
    apart = peaks["predicted_m_N"] / without.peaks()["predicted_m_N"] - 1
    assert np.abs(apart).max() > 0.2


def test_impacts_are_small_and_have_decayed(found: RunningHammerTest) -> None:
    data = found.dataset
    assert data["halving_change"].max() < 0.01
    assert data["decay"].max() < 1e-4
    assert data.sizes["impact"] >= 2 * data.attrs["highest_fitted_order"] + 1
    assert data.attrs["condition"] < 2


def test_impacts_are_evenly_spaced_but_for_their_jitter(found: RunningHammerTest) -> None:
    place = found.dataset["impact_angle"].values / (2 * np.pi)
    count = len(place)
    away = place * count - (np.arange(count) + 0.5)
    assert 0 < np.abs(away).max() <= 0.1
    assert np.abs(away - away[0]).max() > 0.01


def test_its_files_are_as_documented(found: RunningHammerTest, tmp_path: Path) -> None:
    found.save(tmp_path, figures=True)
    assert {path.name for path in tmp_path.iterdir()} == set(found.files)
    table = pd.read_csv(tmp_path / "harmonic_frf.csv")
    assert list(table) == ["order", "frequency_Hz", "receptance_real_m_N", "receptance_imag_m_N"]
    assert len(table) == 3 * found.dataset.sizes["frequency"]
    again = RunningHammerTest.load(tmp_path / "harmonic_frf.nc")
    assert again.dataset.identical(found.dataset)


def test_its_summary_tells_condition_decay_and_halving(found: RunningHammerTest) -> None:
    text = str(found.summary())
    for word in ("condition number", "decayed to", "halving the impacts", "harmonic balance"):
        assert word in text
    assert found.summary().trust.startswith("reference: the sidebands identified and predicted")


def test_an_undamped_linkage_is_refused_with_the_option() -> None:
    with pytest.raises(InputError, match="--damping-ratio"):
        running_hammer_test(engine(), replace(REQUEST, damping_ratio=None))


def test_a_record_in_which_an_impact_does_not_decay_is_refused() -> None:
    with pytest.raises(InputError, match=r"which takes \d.* s; give --duration"):
        running_hammer_test(engine(), replace(REQUEST, duration=0.3))


def test_a_pulse_longer_than_the_record_is_refused() -> None:
    with pytest.raises(InputError, match="is longer than the record"):
        running_hammer_test(engine(), replace(REQUEST, pulse=2.0))


def test_a_linkage_that_shakes_itself_up_is_refused() -> None:
    """At 87.3 rad/s vibrations of the aluminium linkage grow."""
    growing = replace(REQUEST, crank_speed=87.3, damping_ratio=0.0005, prestress="axial")
    with pytest.raises(ComputationError, match=r"no record decays at crank speed 87\.3 rad/s"):
        running_hammer_test(engine(), growing)


def test_a_point_on_no_link_is_refused() -> None:
    with pytest.raises(InputError, match="on no link"):
        running_hammer_test(engine(), replace(REQUEST, impact=LinkPoint("shaft", 0.5)))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"crank_speed": 0.0}, "without --running"),
        ({"crank_speed": np.nan}, "crank_speed"),
        ({"impact": "coupler"}, "LinkPoint.parse"),
        ({"direction": "up"}, "direction"),
        ({"damping_ratio": 1.0}, "damping_ratio"),
        ({"orders": 0}, "orders"),
        ({"orders": 30}, "at most 20"),
        ({"averages": 0}, "averages"),
        ({"bandwidth": -1.0}, "bandwidth"),
        ({"pulse": 0.0}, "pulse"),
        ({"noise": -0.1}, "noise"),
        ({"seed": -1}, "seed"),
        ({"prestress": "much"}, "prestress"),
    ],
)
def test_what_makes_no_sense_is_refused(wrong: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(REQUEST, **wrong)  # type: ignore[arg-type]


def test_a_speed_alone_is_a_request() -> None:
    with pytest.raises(InputError, match="never decays"):  # the usual damping: none
        running_hammer_test(engine(), 20.0)
    with pytest.raises(InputError, match="crank_speed must be a number of rad/s"):
        running_hammer_test(engine(), "20 rpm")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "of", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
def test_a_rotating_arm_has_no_sidebands(of: type[Engine]) -> None:
    arm = of(load_mechanism("models/rotating_arm.toml"), 2)
    tip = LinkPoint("arm", 1.0)
    request = RunningHammerRequest(60.0, tip, tip, damping_ratio=0.2, orders=1)
    found = running_hammer_test(arm, request)
    peaks = found.peaks().set_index("order")
    assert peaks.loc[0, "identified_m_N"] == pytest.approx(peaks.loc[0, "predicted_m_N"], rel=0.05)
    assert peaks.loc[[-1, 1], "predicted_m_N"].tolist() == [0.0, 0.0]
    assert (peaks.loc[[-1, 1], "identified_m_N"] < 1e-5 * peaks.loc[0, "identified_m_N"]).all()
    assert "no sidebands are predicted" in found.summary().trust


@pytest.mark.thorough
def test_separate_runs_give_what_one_run_gives() -> None:
    """A second impact in the same run, after the first has decayed."""
    from flexmech.analyses.damping_ratios import with_damping_ratio
    from flexmech.analyses.running_hammer.measured import runner
    from flexmech.analyses.running_hammer.plan import planned
    from flexmech.analyses.running_hammer.prediction import predicted_linkage

    damped = with_damping_ratio(engine(), 0.1)
    plan = planned(damped, REQUEST, predicted_linkage(damped, REQUEST, 100.0), 90.0)
    alone = runner(damped, REQUEST, plan, 6)
    together = runner(damped, REQUEST, replace(plan, turns=2 * plan.turns), 6)
    first, second = plan.pulses()[3], plan.pulses()[7]
    length = plan.samples
    later = HalfSinePulse(
        second.peak_force, second.duration, second.start + plan.turns * plan.turn_time
    )
    one_run = together([first, later]) - together([])
    separate = alone([second]) - alone([])
    largest = np.abs(separate).max()
    np.testing.assert_allclose(one_run[length:], separate, atol=3e-4 * largest)
    assert np.abs(one_run[: length // 2]).max() > 0.1 * largest
