"""Errors of a speed sweep: estimated at the speeds that matter, and told with its peaks."""

import numpy as np
import pytest

import flexmech
from flexmech.analyses.speed_sweep import compute as sweep
from flexmech.analyses.speed_sweep.result import SpeedSweep
from tests.support.plot_data import sweep_dataset


def summary(dataset):
    return SpeedSweep(dataset.assign_attrs(speed_unit="rad/s", engine="reference")).summary()


@pytest.fixture(scope="module")
def engine(aluminium):
    return flexmech.ReferenceEngine(aluminium, 2)


@pytest.fixture(scope="module")
def found(engine):
    """Some speeds, of which the link that bends most bends most at the second."""
    return flexmech.speed_sweep(engine, [10.0, 36.0, 37.0, 38.0, 41.0], modes=2).dataset


def test_errors_are_known_where_each_link_bends_most(found):
    speeds = found["crank_speed"][found["peak_deflection"].argmax("crank_speed")]
    assert set(speeds.values) <= set(found["check_speed"].values)
    assert {10.0, 37.0, 41.0} <= set(found["check_speed"].values)
    assert len(found["check_speed"]) < len(found["crank_speed"])


def test_estimated_errors_of_peaks_are_those_against_a_run_that_is_far_finer(engine, found):
    """Few are less than half of what a peak is off by, and the greatest is right to a factor."""
    highest, actual = sweep.highest_frequency(engine, 2), []
    for speed in found["check_speed"].values.tolist():
        finest = engine.with_(elements=16)
        linkage = sweep.vibrating_linkage(finest, speed, 2, "equilibrium", 4 * sweep.DETAIL)
        exact = np.abs(sweep._deflections(linkage, highest, 4)).max(axis=0)
        actual.append(np.abs(found["peak_deflection"].sel(crank_speed=speed).values / exact - 1))
    estimated = found["peak_error"].values
    assert np.all(np.array(actual) < 1.5 * np.maximum(estimated, 1e-4))
    assert 0.05 < np.max(actual) < estimated.max() < 2 * np.max(actual)


def test_the_error_of_critical_speeds_is_that_of_the_frequencies_at_rest(engine, found):
    finest = engine.with_(elements=16)
    angles = sweep.sampled_turn()
    coarse, fine = (
        flexmech.natural_frequencies(each, angles, modes=2) for each in (engine, finest)
    )
    actual = np.abs(coarse / fine - 1).max(axis=0)
    assert found["discretisation_error"].values == pytest.approx(actual, rel=0.3)


def test_the_answer_has_the_digits_that_the_error_leaves():
    data = sweep_dataset()
    told = {}
    for error in (2e-3, 0.2):
        wrong = data.assign(peak_error=0 * data["peak_error"] + error)
        told[error] = summary(wrong)
    peak = 1e3 * float(data["peak_deflection"].max())
    cells = [table.table.groups[0][2][1] for table in told.values()]
    assert float(cells[0]) == pytest.approx(peak, rel=1e-3)
    assert len(cells[1]) < len(cells[0])
    assert told[2e-3].trust == "numbers are known to 0.2 %; the reference engine alone ran"
    assert told[0.2].trust == "numbers are known to 20 %; the reference engine alone ran"
    assert f"by up to {cells[1]} mm" in told[0.2].answer[0]
    assert told[0.2].numbers[0].error == pytest.approx(0.2 * peak)


def test_the_errors_of_all_checked_speeds_are_among_the_details():
    data = sweep_dataset()
    (peaks, critical) = summary(data).details
    assert peaks.count("0.2 % at") == len(data["check_speed"])
    assert "at most 0.01 %" in critical


def test_a_sweep_of_before_errors_were_estimated_says_that_there_are_none():
    data = sweep_dataset().drop_vars(["peak_error", "discretisation_error"])
    found = summary(data)
    assert "not estimated" in found.trust
    assert not found.details
    assert all(np.isnan(number.error) for number in found.numbers)


def test_a_link_that_no_load_bends_has_no_error():
    here = np.array([[0.0, 0.5], [0.0, 1.0]])
    finer = np.array([[0.0, 0.5], [0.0, 0.8], [0.0, 1.1], [0.0, 0.2]])
    error = sweep._error_of(here, finer)
    assert error[0] == 0
    assert error[1] == pytest.approx(0.1 / 1.1 / np.sqrt(0.5))


def test_peaks_that_are_equally_high_by_chance_do_not_hide_an_error():
    """The finer run peaks at another instant, where the coarser one is a third lower."""
    here = np.array([[1.0], [0.6]])
    finer = np.array([[0.7], [0.8], [0.9], [1.0]])
    assert sweep._error_of(here, finer)[0] == pytest.approx(0.3 / np.sqrt(0.5))
