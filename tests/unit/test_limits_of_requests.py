"""What is taken for a slip of the keyboard: accepted up to a limit, refused beyond it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import flexmech
from flexmech.analyses.campbell.request import CampbellRequest
from flexmech.analyses.comparison import over_angle, over_frequency, over_time, quantities
from flexmech.analyses.frequencies.formulation import Formulation
from flexmech.analyses.frequencies.request import FrequencyRequest
from flexmech.analyses.kinematics.request import KinematicsRequest
from flexmech.analyses.requests import in_radians
from flexmech.analyses.stability.against import Against
from flexmech.analyses.stability.engine_map import _refuse_too_many_steps
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.errors import InputError
from flexmech.measured_data import MeasuredQuantity
from flexmech.units import RATIO

POINT = flexmech.LinkPoint("coupler", 0.5)
DRIVE = flexmech.ConstantSpeed(2 * np.pi)


def orders_of_a_diagram(count):
    none = np.zeros(1)
    CampbellRequest(none, none, np.array([count]), Formulation(), "rad/s")


def shapes_asked_for(count):
    FrequencyRequest(
        np.linspace(0.0, 6.0, 100), np.zeros(1), shapes_at=np.linspace(0.0, 6.0, count)
    )


def frequencies_of_a_map(count):
    FrequencyRequest(np.linspace(0.0, 6.0, count // 40), np.linspace(0.0, 1.0, 10))


LIMITS = {
    "order": (orders_of_a_diagram, 1000),
    "72 crank angles": (shapes_asked_for, 72),
    "do not fit into memory": (frequencies_of_a_map, 4_000_000),
    "elements of a link": (lambda n: KinematicsRequest(lumped=(n,)), 1000),
    "list of 1 to": (
        lambda n: Against("x", np.linspace(0.0, 1.0, n), RATIO),
        1000,
    ),
    "averages": (lambda n: flexmech.HammerRequest([0.0], averages=n), 1000),
    "orders": (
        lambda n: flexmech.RunningHammerRequest(20.0, POINT, POINT, orders=n),
        20,
    ),
    "samples": (lambda n: flexmech.ResponseRequest(DRIVE, 1000.0, samples=n // 1000), 2_000_000),
    "steps of a run": (lambda n: flexmech.ResponseRequest(DRIVE, 1.0, step=1.0 / n), 50_000_000),
    "steps must be": (lambda n: StabilityRequest(np.array([20.0]), steps=n), 1_000_000),
    "must be in rad": (lambda n: in_radians("angles", n * np.pi / 10), 160),
    "times the lowest": (lambda n: _refuse_too_many_steps(StabilityRequest([float(n)]), 1.0), 250),
}


@pytest.mark.parametrize("named", LIMITS)
def test_limits(named):
    request, most = LIMITS[named]
    request(most)
    with pytest.raises(InputError, match=named):
        request(round(1.1 * most / 16 + 1) * 16)


def test_a_sweep_has_at_most_a_thousand_orders():
    """What else is wrong is said of those alone."""
    for orders, named in ((1000, "modes"), (1001, "orders")):
        with pytest.raises(InputError, match=f"^{named}"):
            flexmech.speed_sweep(None, [1.0], orders=orders, modes=0)


def record(**columns):
    values = {name: np.asarray(value, dtype=float) for name, value in columns.items()}
    return SimpleNamespace(
        source="record.csv",
        position=np.linspace(0.0, 1.0, len(next(iter(values.values())))),
        has=lambda name: name in values,
        names=tuple(values),
        unreadable={},
        quantity=lambda name: MeasuredQuantity(name, "rad", values[name]),
    )


def test_modes_are_numbered_up_to_fifty():
    def numbered(number):
        own, every = record(mode=[number] * 3), np.arange(3)
        return over_angle._modes(None, own, 0.0, np.zeros(3), np.ones(3), every)

    assert numbered(50).tolist() == [50] * 3
    with pytest.raises(InputError, match="number modes"):
        numbered(51)


def test_a_record_without_modes_is_one_of_the_lowest_six(monkeypatch):
    def frequencies(engine, speed, angle, modes):
        return np.tile(10.0 * np.arange(1, modes + 1), (len(angle), 1))

    monkeypatch.setattr(over_angle, "_frequencies", frequencies)
    angle = np.linspace(0.0, 1.0, 3)
    for hertz, number in ((61.0, 6), (90.0, 6)):
        own = over_angle._modes(None, record(x=angle), 0.0, angle, np.full(3, hertz), np.arange(3))
        assert own.tolist() == [number] * 3


def test_speeds_and_angles_of_a_record_are_those_asked_for_but_for_rounding():
    """A table gives six digits; a protractor tells a hundredth of a degree."""
    rows = over_angle._at_speed(record(crank_speed=[62.8319, 62.833]), 20 * np.pi)
    assert rows.tolist() == [0]
    own = record(crank_angle=np.radians([30.005, 30.05]))
    own.position = np.arange(2)
    assert over_frequency._at_angle(own, np.radians(30.0)).tolist() == [0]


def test_the_speed_of_a_record_is_the_one_given_to_a_hundredth():
    time = np.linspace(0.0, 1.0, 50)
    for off, refused in ((0.005, False), (0.02, True)):
        own = record(crank_angle=20 * (1 + off) * time)
        if refused:
            with pytest.raises(InputError, match="its crank turns at"):
                over_time._crank_angle(own, 20.0, time)
        else:
            assert over_time._crank_angle(own, 20.0, time)[0] == pytest.approx(0.0, abs=1e-12)


def test_no_link_survives_a_tenth_of_strain():
    gauge = SimpleNamespace(unit="", kind="strain", column="strain")
    for most, refused in ((0.05, False), (0.2, True)):
        measured = MeasuredQuantity("strain", "", np.array([0.0, most]))
        if refused:
            with pytest.raises(InputError, match="which no link survives"):
                quantities._check(measured, gauge, record(x=[0.0]))
        else:
            quantities._check(measured, gauge, record(x=[0.0]))
