"""Tolerances of hammer tests and of modes: each test fails if its constant is another one."""

from __future__ import annotations

import importlib
from types import SimpleNamespace

import numpy as np
import pytest

import flexmech
from flexmech.analyses.hammer import plan
from flexmech.analyses.running_hammer import compute as running
from flexmech.analyses.running_hammer import measured, prediction
from flexmech.analyses.running_hammer.plan import GUARD_ORDERS
from flexmech.errors import InputError
from flexmech.modal_testing import circle_fit, identify
from flexmech.modal_testing.identified import modal_sum
from tests.support.hammer_data import ALUMINIUM

identification = importlib.import_module("flexmech.modal_testing.identify")

# --- records of a locked linkage ----------------------------------------------------------------


def greatest_found(centre: float) -> float:
    """Greatest value at the instants of the search, of one wave of ten in the first period."""
    seen = []

    def motion(rows, hit, unit, time):
        phase = np.clip(20 * np.pi * (time - centre), -np.pi / 2, np.pi / 2)
        seen.append(np.cos(phase))
        return seen[-1]

    linkage = SimpleNamespace(topology=SimpleNamespace(links=[SimpleNamespace(length=1.0)]))
    own = SimpleNamespace(
        engine=SimpleNamespace(mechanism=SimpleNamespace(linkage=linkage)),
        natural_frequencies=lambda count: [1.0],
        rows=lambda *of: [None],
        station_rows=lambda: None,
        motion=motion,
    )
    request = SimpleNamespace(impact=None, direction=None)
    plan._force(request, [own], SimpleNamespace(start=0.0, duration=0.01))
    return float(seen[0].max())


def test_displacements_are_looked_for_at_a_hundred_instants_of_each_period():
    """Of a vibration ten times as fast as the first mode a twentieth is missed at most."""
    worst = min(greatest_found(centre) for centre in np.linspace(1.0, 1.1, 301))
    assert 0.93 < worst < 0.97


# --- runs and prediction of a running linkage ---------------------------------------------------


class EnoughError(Exception):
    """What was asked for."""


def asked_of_the_engine(monkeypatch) -> int:
    """Natural frequencies that elements of a running hammer test must be fit for."""

    def fit_for(modes):
        raise EnoughError(modes)

    monkeypatch.setattr(running, "engine_of", lambda engine: SimpleNamespace(fit_for=fit_for))
    point = flexmech.LinkPoint("coupler", 0.5)
    request = flexmech.RunningHammerRequest(20.0, point, point, damping_ratio=0.01)
    with pytest.raises(EnoughError) as found:
        running.running_hammer_test(None, request)
    return found.value.args[0]


def asked_of_the_runs(monkeypatch) -> int:
    """Natural frequencies that runs get right where the prediction needs one alone."""

    def linkage(engine, drive, prestress, modes, **of):
        raise EnoughError(modes)

    monkeypatch.setattr(measured, "DrivenLinkage", linkage)
    request = SimpleNamespace(speed=20.0, prestress="none")
    with pytest.raises(EnoughError) as found:
        measured.runner(
            flexmech.ReferenceEngine(flexmech.load_mechanism(ALUMINIUM), 2), request, None, 1
        )
    return found.value.args[0]


@pytest.mark.parametrize("asked", [asked_of_the_engine, asked_of_the_runs])
def test_elements_and_runs_have_the_modes_that_orders_and_guards_reach(monkeypatch, asked):
    """Of the aluminium linkage at 20 rad/s with two orders: more than twice that, and not ten
    times, which would cost steps and other elements for modes that nobody sees.
    """
    engine = flexmech.ReferenceEngine(flexmech.load_mechanism(ALUMINIUM), 8)
    at_rest = flexmech.natural_frequencies(engine, np.radians([0.0, 90.0, 180.0]), modes=18)
    highest = 2 * at_rest[:, 0].min() + (2 + GUARD_ORDERS) * 20.0 / (2 * np.pi)
    reached = at_rest[:, asked(monkeypatch) - 1].min()
    assert 2 * highest < reached < 10 * highest


def test_harmonic_balance_is_solved_at_the_peaks_and_across_the_band(monkeypatch):
    """No gap is wider than a third of the band; each frequency more is a large system to solve."""
    frequency, solved = np.linspace(0.0, 100.0, 201), []
    found = np.ones((2, 201))
    found[0, 33] = found[1, 141] = 5.0

    def balanced(forced, some, orders, harmonics):
        solved.extend(some.tolist())
        return found[:, np.searchsorted(frequency, some)]

    monkeypatch.setattr(prediction, "harmonic_response", lambda *of: found)
    monkeypatch.setattr(prediction, "balanced_response", balanced)
    forced = SimpleNamespace(system=SimpleNamespace(is_constant=True))
    own = prediction.Prediction(forced, forced, forced, 128, 3, 4, -1.0)
    errors = own.errors(frequency, np.array([0, 1]))
    assert errors.balance == pytest.approx([0.0, 0.0])
    assert {frequency[33], frequency[141], 0.0, 100.0} <= set(solved)
    assert np.diff(solved).max() < 100 / 3
    assert len(solved) <= 2 + 8


# --- modes of receptances -----------------------------------------------------------------------

LINES = np.arange(1, 401) * 0.25


def pole_at(frequency: float, ratio: float) -> complex:
    return complex(2 * np.pi * frequency * (-ratio + 1j))


def modes_of(*poles: complex, lines=LINES, size=1.0) -> np.ndarray:
    """Receptance of one point; the greatest amplitude of each mode is about its size."""
    each = np.array(poles)
    return modal_sum(2j * np.pi * lines, each, (-size * each.real / 1j)[None])


def circles(monkeypatch, *poles):
    """Lines of all circles that are fitted, in the order in which they are, and the poles."""
    fitted, circle = [], circle_fit._circle

    def watched(s, receptance, pole):
        fitted.append(s)
        return circle(s, receptance, pole)

    monkeypatch.setattr(circle_fit, "_circle", watched)
    receptance = modes_of(*poles)
    at = np.sort(circle_fit.peaks(LINES, receptance))
    assert len(at) == len(poles)
    return fitted, circle_fit.circle_fit_poles(LINES, receptance, at, 0.0)


def test_nine_tenths_of_the_circle_of_a_mode_are_fitted(monkeypatch):
    pole = pole_at(50.0, 0.02)
    fitted, found = circles(monkeypatch, pole)
    assert found == pytest.approx([pole], rel=1e-6)
    # A mode turns 1 / (s - pole) by twice the angle that the lines are seen under.
    angle = np.angle(fitted[-1] - pole)
    assert 0.85 < 2 * np.ptp(angle) / (2 * np.pi) < 0.95


def test_circles_of_sharp_peaks_have_twice_as_many_numbers_as_unknowns(monkeypatch):
    """Each line has two, for the pole and three complex numbers of the point, which are eight."""
    pole = pole_at(50.1, 1e-4)
    fitted, found = circles(monkeypatch, pole)
    assert found == pytest.approx([pole], rel=1e-6)
    assert 2 * 8 < 2 * len(fitted[-1]) < 3 * 8


def test_poles_of_neighbouring_circles_settle_to_a_ten_millionth(monkeypatch):
    """Of two modes two per cent of their frequency and four of their widths apart."""
    pair = pole_at(50.0, 0.01), pole_at(52.0, 0.01)
    _, found = circles(monkeypatch, *pair)
    monkeypatch.setattr(circle_fit, "CONVERGED", 1e-13)
    monkeypatch.setattr(circle_fit, "MOST_ROUNDS", 200)
    _, exact = circles(monkeypatch, *pair)
    assert 1e-9 < np.abs(found / exact - 1).max() < 1e-7


def test_a_fit_has_twice_as_many_numbers_as_a_mode_and_the_rest_have_unknowns():
    lines = np.arange(40, 80) * 1.0
    receptance = modes_of(pole_at(60.0, 0.02), lines=lines)

    def found(first, last):
        band = (float(lines[first]), float(lines[last - 1]))
        return identify(lines, receptance, band=band, method="circle-fit")

    for first, last in ((12, 29), (10, 31)):
        assert found(first, last).frequency == pytest.approx([60.0], rel=1e-3)
    with pytest.raises(InputError, match="a fit needs at least 16"):
        found(14, 27)


def test_models_of_lscf_have_orders_enough_for_a_dozen_modes():
    """And not so many that a hundred lines were too few for them."""
    frequency = np.linspace(8.0, 92.0, 12)
    poles = [pole_at(one, 0.3 / one) for one in frequency]
    lines, orders = LINES[3::4], identification.ORDERS
    assert len(lines) == 100
    modes = identify(lines, modes_of(*poles, lines=lines), method="lscf", orders=orders)
    found = np.sort(modes.chart.frequency[modes.chart.chosen])
    assert found == pytest.approx(frequency, rel=1e-2)


@pytest.mark.parametrize(("size", "found"), [(0.05, 1), (0.2, 2)])
def test_peaks_of_a_tenth_of_the_greatest_that_lscf_has_missed_are_added(size, found):
    known, missed = pole_at(30.0, 0.01), pole_at(70.0, 0.01)
    receptance = modes_of(known) + modes_of(missed, size=size)
    poles = identification._with_peaks_left(LINES, receptance, np.array([known]), None, 0.0)
    assert np.isfinite(poles).sum() == found


def test_poles_within_a_tenth_of_their_width_are_one():
    pole = pole_at(50.0, 0.01)
    for apart, count in ((0.1, 1), (0.4, 2)):
        pair = np.array([pole, pole + 1j * apart * -pole.real])
        assert len(identification._distinct(pair, 0.0)) == count


def test_an_expected_mode_is_one_within_five_per_cent():
    for apart, column in ((0.04, 0), (0.06, -1)):
        assert identification._asked(np.array([50.0 / (1 + apart)]), np.array([50.0]), None) == (
            pytest.approx([column])
        )
