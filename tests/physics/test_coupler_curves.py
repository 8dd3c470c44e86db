"""Coupler curves: derivatives, curvature, the sextic, and the equations of swollen links."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flexmech import (
    CouplerCurve,
    CouplerPoint,
    FourBar,
    HygrothermalState,
    InputError,
    coupler_paths,
    example_model,
    load_mechanism,
)
from flexmech.linkages import coupler_sextic
from flexmech.verification import verification_case
from tests.support.strategies import angles, fourbar, numbers

CRANK_ROCKER = FourBar(1.0, 0.4, 0.9, 0.8)
TURN = np.linspace(0.0, 2 * np.pi, 37)
few = settings(max_examples=15)


@st.composite
def curves(draw: st.DrawFn) -> CouplerCurve:
    """Crank-rockers with the ground as unit, away from locking and change points."""
    crank, coupler, rocker = (draw(numbers(*of)) for of in ((0.1, 0.4), (0.75, 1.2), (0.75, 1.2)))
    ordered = sorted((1.0, crank, coupler, rocker))
    assume(ordered[0] + ordered[3] < ordered[1] + ordered[2] - 0.05)
    linkage = FourBar(1.0, crank, coupler, rocker, draw(st.sampled_from(["open", "crossed"])))
    return CouplerCurve(linkage, CouplerPoint(draw(numbers(0.0, 2.0)), draw(angles())))


def by_differences(function, angle, step=1e-3):
    """Derivative by central differences of fourth order."""
    near, far = (function(angle + n * step) - function(angle - n * step) for n in (1, 2))
    return (8 * near - far) / (12 * step)


@few
@given(curves())
def test_the_point_keeps_its_distances_from_both_pins(curve: CouplerCurve) -> None:
    linkage, arm = curve.linkage, curve.point.distance * np.exp(1j * curve.point.angle)
    motion = linkage.motion(TURN)
    pin_a = motion.position(0, linkage.crank) @ [1, 1j]
    pin_b = motion.position(2, linkage.rocker) @ [1, 1j]
    place = pin_a + arm * (pin_b - pin_a) / linkage.coupler
    assert curve.position(TURN) @ [1, 1j] == pytest.approx(place, abs=1e-9)


@few
@given(curves(), angles())
def test_derivatives_and_curvature_are_those_of_the_path(curve: CouplerCurve, angle: float) -> None:
    scale = 1 + np.abs(curve.second_derivative(TURN)).max()
    first = by_differences(curve.position, angle)
    assert curve.derivative(angle) == pytest.approx(first, abs=1e-7 * scale)
    second = by_differences(curve.derivative, angle)
    assert curve.second_derivative(angle) == pytest.approx(second, abs=1e-6 * scale)
    assume(curve.speed(angle + np.array([-2e-3, 0.0, 2e-3])).min() > 0.05)
    here = curve.derivative(angle) @ [1, 1j]
    turned = by_differences(lambda at: np.angle(curve.derivative(at) @ [1, 1j] / here), angle)
    expected = turned / curve.speed(angle)
    assert curve.curvature(angle) == pytest.approx(expected, rel=1e-4, abs=1e-4)


def test_pins_have_circles_for_curves() -> None:
    """Counter-clockwise about O2; about O4 as the rocker turns."""
    at_a = CouplerCurve(CRANK_ROCKER, CouplerPoint(0.0, 1.0))
    assert at_a.curvature(TURN) == pytest.approx(1 / 0.4)
    at_b = CouplerCurve(CRANK_ROCKER, CouplerPoint(0.9, 0.0))
    turning = CRANK_ROCKER.motion(TURN, 1.0).angular_velocity[:, 2]
    moves = np.abs(turning) > 1e-3
    bend = np.sign(turning[moves]) / 0.8
    assert at_b.curvature(TURN[moves]) == pytest.approx(bend, rel=1e-6)


@few
@given(curves())
def test_the_sextic_is_zero_on_both_branches_and_nowhere_beside(curve: CouplerCurve) -> None:
    for branch in ("open", "crossed"):
        other = CouplerCurve(replace(curve.linkage, branch=branch), curve.point)
        value = coupler_sextic(curve.linkage, curve.point, other.position(TURN))
        assert np.abs(value).max() < 1e-10
    beside = CouplerCurve(CRANK_ROCKER, CouplerPoint(0.7, 0.6))
    across = beside.derivative(TURN)[:, ::-1] * [1, -1] / beside.speed(TURN)[:, None]
    off = beside.position(TURN) + 0.01 * across
    assert np.abs(coupler_sextic(CRANK_ROCKER, beside.point, off)).min() > 1e-5


def test_the_sextic_is_tricircular_and_without_unit() -> None:
    """Far away only b^2 r^6 is left, whatever the direction."""
    point = CouplerPoint(0.7, 0.6)
    place = 1e4 * np.stack([np.cos(TURN), np.sin(TURN)], axis=-1)
    far = coupler_sextic(CRANK_ROCKER, point, place)
    assert far == pytest.approx((1e4 / 1.1) ** 6, rel=1e-3)
    near = np.array([0.3, -0.2])
    scaled = coupler_sextic(FourBar(1e3, 400, 900, 800), CouplerPoint(700, 0.6), 1e3 * near)
    assert scaled == pytest.approx(coupler_sextic(CRANK_ROCKER, point, near), rel=1e-12)
    large = CouplerCurve(FourBar(2.0, 0.8, 1.8, 1.6), point.scaled(2.0))
    small = CouplerCurve(CRANK_ROCKER, point)
    assert large.position(TURN) == pytest.approx(2 * small.position(TURN))
    assert large.curvature(TURN) == pytest.approx(small.curvature(TURN) / 2)


def test_the_point_in_the_instant_centre_stands_still() -> None:
    """Below a billionth of the linkage a radian its tangent is not known; there is a cusp."""
    linkage = FourBar(0.25, 0.1, 0.28, 0.27)
    motion = linkage.motion(1.1, 1.0)
    across, along = motion.origin_velocity[1]
    arm = complex(-along, across) / motion.angular_velocity[1] * np.exp(-1j * motion.angle[1])
    curve = CouplerCurve(linkage, CouplerPoint(abs(arm), float(np.angle(arm))))
    assert curve.speed(1.1) == pytest.approx(0.0, abs=1e-13)
    size = linkage.crank + curve.point.distance
    gain = float(np.hypot(*curve.second_derivative(1.1)))
    moving, still = (1.1 + part * size / gain for part in (5e-9, 3e-10))
    # The tangent of a cusp is the direction in which the point is accelerated.
    first, second = curve.derivative(moving), curve.second_derivative(1.1)
    sine = (first[0] * second[1] - first[1] * second[0]) / np.hypot(*first) / gain
    assert abs(sine) < 1e-6
    assert np.isfinite(curve.curvature(moving))
    with pytest.raises(InputError, match=r"stands still at crank angle 63\.02"):
        curve.curvature(still)


def test_angles_of_swollen_links_are_those_of_figures_3_and_4() -> None:
    """Singh & Sanyal 2022 with its equations corrected: 100, 160, 160 and 200 mm, 1.026148 wet."""
    case = verification_case("Angles of swollen links, Figures 3 and 4: wet against dry")
    mechanism = load_mechanism(example_model("neat_resin_figure_3"))
    wet = HygrothermalState(80.0, 0.07)
    turn = np.radians([0.0, 90.0, 180.0])
    data = coupler_paths(mechanism, turn, CouplerPoint(0.0, 0.0), environment=wet).dataset
    dry, swollen = data["angle"].values
    change = np.degrees(np.remainder(swollen - dry + np.pi, 2 * np.pi) - np.pi)
    found = change[[0, 2]].ravel()
    assert found == pytest.approx(case.expected_values(), abs=case.tolerance)
    for state, growth, ground in ((0, 1.0, 200.0), (1, 1.026148, 201.0016)):
        crank, bar = 100 * growth, 160 * growth
        across = ground**2 + crank**2 - 2 * ground * crank * np.cos(turn)
        transmission = np.arccos((2 * bar**2 - across) / (2 * bar**2))
        assert data["transmission_angle"].values[state] == pytest.approx(transmission, rel=1e-9)


REFUSED = {
    "must not be negative": lambda: CouplerPoint(-0.1, 0.0),
    "pin A must be a number, got nan m": lambda: CouplerPoint(np.nan, 0.0),
    "units are for model files": lambda: CouplerPoint("33 mm", 0.0),
    r"np.radians\(320.0\)": lambda: CouplerPoint(0.1, 320.0),
    "must be positive": lambda: CouplerPoint(0.1, 0.0).scaled(0.0),
    "cannot be assembled at crank angle 180 deg": lambda: CouplerCurve(
        FourBar(1.0, 0.9, 0.5, 1.1), CouplerPoint(0.5, 1.0)
    ).position(np.pi),
    "along their last axis": lambda: coupler_sextic(CRANK_ROCKER, CouplerPoint(0.5, 1.0), 0.1),
    "write flexmech.CouplerPoint": lambda: coupler_paths(fourbar(), TURN, (0.033, 5.6)),
    "write flexmech.HygrothermalState": lambda: coupler_paths(
        fourbar(), TURN, CouplerPoint(0.1, 0.0), environment=(80, 0.07)
    ),
    "read the file first": lambda: coupler_paths("models/steel_fourbar.toml", TURN),
    r"in rad .* np.radians": lambda: coupler_paths(fourbar(), range(0, 361, 30)),
}


@pytest.mark.parametrize("said", REFUSED)
def test_points_and_curves_that_are_none_are_refused(said: str) -> None:
    with pytest.raises(InputError, match=said):
        REFUSED[said]()
