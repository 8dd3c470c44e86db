"""Coupler curves: places, derivatives, curvature, the sextic, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flexmech.errors import InputError
from flexmech.linkages import CouplerCurve, CouplerPoint, FourBar, coupler_sextic, double_points
from scenarios._cusp_transitions import cusp_transitions
from tests.support.strategies import angles, numbers

CRANK_ROCKER = FourBar(1.0, 0.4, 0.9, 0.8)
DOUBLE_ROCKER = FourBar(1.0, 0.9, 0.5, 1.1)
CHANGE_POINT = FourBar(1.0, 0.5, 0.8, 0.7)
TURN = np.linspace(0.0, 2 * np.pi, 37)

few = settings(max_examples=20)


@st.composite
def crank_rockers(draw: st.DrawFn) -> FourBar:
    """With the ground as unit, away from locking and change points."""
    crank, coupler, rocker = (
        draw(numbers(0.1, 0.6)),
        draw(numbers(0.4, 1.5)),
        draw(numbers(0.4, 1.5)),
    )
    branch = draw(st.sampled_from(["open", "crossed"]))
    ordered = sorted((1.0, crank, coupler, rocker))
    assume(crank == ordered[0])
    assume(ordered[0] + ordered[3] < ordered[1] + ordered[2] - 0.05)
    return FourBar(1.0, crank, coupler, rocker, branch)


@st.composite
def curves(draw: st.DrawFn) -> CouplerCurve:
    return CouplerCurve(
        draw(crank_rockers()), CouplerPoint(draw(numbers(0.0, 2.0)), draw(angles()))
    )


def by_differences(function, angle, step):
    """Of fourth order."""
    ahead, behind = (
        function(angle + step) - function(angle - step),
        (function(angle + 2 * step) - function(angle - 2 * step)),
    )
    return (8 * ahead - behind) / (12 * step)


@few
@given(curves())
def test_place_closes_with_both_pins(curve: CouplerCurve) -> None:
    motion = curve.linkage.motion(TURN)
    place = curve.position(TURN)
    assert place.shape == (len(TURN), 2)
    pin_a, pin_b = motion.position(0, curve.linkage.crank), motion.position(2, curve.linkage.rocker)
    triangle = curve.point.triangle(curve.linkage.coupler)
    assert np.linalg.norm(place - pin_a, axis=-1) == pytest.approx(triangle.near, abs=1e-12)
    assert np.linalg.norm(place - pin_b, axis=-1) == pytest.approx(triangle.far, abs=1e-9)
    turned = (pin_b - pin_a) @ [1, 1j] / curve.linkage.coupler * np.exp(1j * curve.point.angle)
    assert (place - pin_a) @ [1, 1j] == pytest.approx(curve.point.distance * turned, abs=1e-9)


@few
@given(curves())
def test_triangle_is_seen_from_the_point(curve: CouplerCurve) -> None:
    near, far, cosine, sine = curve.point.triangle(curve.linkage.coupler)
    assume(min(near, far) > 1e-3)
    to_a, to_b = -curve.point.place, [curve.linkage.coupler, 0.0] - curve.point.place
    assert cosine * near * far == pytest.approx(to_a @ to_b, abs=1e-12)
    assert sine * near * far == pytest.approx(to_a[0] * to_b[1] - to_a[1] * to_b[0], abs=1e-12)


@few
@given(curves(), angles())
def test_derivatives_are_those_of_the_place(curve: CouplerCurve, angle: float) -> None:
    first = by_differences(curve.position, angle, 1e-3)
    second = by_differences(curve.derivative, angle, 1e-3)
    scale = 1 + np.abs(curve.second_derivative(TURN)).max()
    assert curve.derivative(angle) == pytest.approx(first, abs=1e-7 * scale)
    assert curve.second_derivative(angle) == pytest.approx(second, abs=1e-6 * scale)
    assert curve.speed(angle) == pytest.approx(np.linalg.norm(first), abs=1e-7 * scale)


@few
@given(curves(), angles())
def test_curvature_is_how_the_tangent_turns(curve: CouplerCurve, angle: float) -> None:
    assume(curve.speed(angle + np.array([-2e-3, 0.0, 2e-3])).min() > 0.05)
    here = curve.derivative(angle) @ [1, 1j]

    def direction(at):
        return np.angle(curve.derivative(at) @ [1, 1j] / here)

    bend = by_differences(direction, angle, 1e-3) / curve.speed(angle)
    assert curve.curvature(angle) == pytest.approx(bend, rel=1e-4, abs=1e-4)


def test_pins_have_circles_for_curves() -> None:
    """Counter-clockwise about O2; about O4 as the rocker turns."""
    at_a = CouplerCurve(CRANK_ROCKER, CouplerPoint(0.0, 1.0))
    assert at_a.curvature(TURN) == pytest.approx(1 / 0.4)
    at_b = CouplerCurve(CRANK_ROCKER, CouplerPoint(0.9, 0.0))
    turning = CRANK_ROCKER.motion(TURN, 1.0).angular_velocity[:, 2]
    moves = np.abs(turning) > 1e-3
    bend = np.where(turning > 0, 1, -1) / 0.8
    assert at_b.curvature(TURN[moves]) == pytest.approx(bend[moves], rel=1e-6)
    for point in (at_a.point, at_b.point, CouplerPoint(0.9, 2 * np.pi)):
        assert double_points(CRANK_ROCKER, point) == ()


@few
@given(curves())
def test_sextic_is_zero_on_both_branches(curve: CouplerCurve) -> None:
    lengths = curve.linkage.lengths
    for branch in ("open", "crossed"):
        linkage = FourBar(**lengths, branch=branch)
        place = CouplerCurve(linkage, curve.point).position(TURN)
        assert np.abs(coupler_sextic(curve.linkage, curve.point, place)).max() < 1e-10


def test_sextic_is_not_zero_elsewhere() -> None:
    point = CouplerPoint(0.7, 0.6)
    curve = CouplerCurve(CRANK_ROCKER, point)
    across = curve.derivative(TURN)[:, ::-1] * [1, -1] / curve.speed(TURN)[:, None]
    for offset in (-0.01, 0.01):
        beside = curve.position(TURN) + offset * across
        assert np.abs(coupler_sextic(CRANK_ROCKER, point, beside)).min() > 1e-5


def test_sextic_is_tricircular() -> None:
    """Far away only b^2 r^6 is left, whatever the direction."""
    place = 1e4 * np.stack([np.cos(TURN), np.sin(TURN)], axis=-1)
    far = coupler_sextic(CRANK_ROCKER, CouplerPoint(0.7, 0.6), place)
    assert far == pytest.approx((1e4 / 1.1) ** 6, rel=1e-3)


def test_sextic_does_not_depend_on_the_unit_of_length() -> None:
    place = np.array([0.3, -0.2])
    small = coupler_sextic(CRANK_ROCKER, CouplerPoint(0.7, 0.6), place)
    large = coupler_sextic(FourBar(1e3, 400, 900, 800), CouplerPoint(700, 0.6), 1e3 * place)
    assert large == pytest.approx(small, rel=1e-12)


def test_scaled_point_and_linkage_give_the_scaled_curve() -> None:
    point = CouplerPoint(0.7, 0.6)
    large = CouplerCurve(FourBar(2.0, 0.8, 1.8, 1.6), point.scaled(2.0))
    small = CouplerCurve(CRANK_ROCKER, point)
    assert large.position(TURN) == pytest.approx(2 * small.position(TURN))
    assert large.curvature(TURN) == pytest.approx(small.curvature(TURN) / 2)


def test_curvature_at_a_cusp_is_refused() -> None:
    """The coupler point is put where the instant centre is at 60 deg."""
    motion = CRANK_ROCKER.motion(np.radians(60.0))
    along_crank, along_rocker = (np.exp(1j * motion.angle[k]) for k in (0, 2))
    reach = along_rocker.imag / (along_crank.conjugate() * along_rocker).imag
    arm = (reach * along_crank - 0.4 * along_crank) * np.exp(-1j * motion.angle[1])
    curve = CouplerCurve(CRANK_ROCKER, CouplerPoint(abs(arm), np.angle(arm)))
    assert curve.speed(np.radians(60.0)) == pytest.approx(0.0, abs=1e-13)
    assert np.all(np.isfinite(curve.curvature(np.radians([59.0, 61.0]))))
    with pytest.raises(InputError, match="stands still at crank angle 60 deg"):
        curve.curvature(np.radians([30.0, 60.0]))


@pytest.mark.parametrize(
    ("distance", "angle", "message"),
    [
        (-0.1, 0.0, "must not be negative"),
        (np.nan, 0.0, "pin A must be a number, got nan m"),
        ("33 mm", 0.0, "pin A must be a number of m, got '33 mm'; .* units are for model files"),
        (0.1, np.nan, "angle of the coupler point must be a number"),
        (0.1, 320.0, r"a full turn .* got 320.0 rad; for degrees give np.radians\(320.0\)"),
    ],
)
def test_points_that_are_none(distance: float, angle: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        CouplerPoint(distance, angle)


@pytest.mark.parametrize("factor", [0.0, -1.0, np.nan, np.inf])
def test_factors_must_be_positive(factor: float) -> None:
    with pytest.raises(InputError, match="factor of the coupler's lengths must be positive"):
        CouplerPoint(0.1, 0.0).scaled(factor)


def test_curve_refuses_what_the_linkage_refuses() -> None:
    curve = CouplerCurve(DOUBLE_ROCKER, CouplerPoint(0.5, 1.0))
    for method in (curve.position, curve.derivative, curve.second_derivative, curve.curvature):
        with pytest.raises(InputError, match="cannot be assembled at crank angle 180 deg"):
            method(np.pi)


@pytest.mark.parametrize("place", [0.1, [0.1, 0.2, 0.3], np.zeros((2, 3))])
def test_sextic_wants_places(place: object) -> None:
    with pytest.raises(InputError, match="along their last axis"):
        coupler_sextic(CRANK_ROCKER, CouplerPoint(0.5, 1.0), place)


def test_change_points_have_no_circuits() -> None:
    with pytest.raises(InputError, match="the linkage has a change point"):
        double_points(CHANGE_POINT, CouplerPoint(0.5, 1.0))


@pytest.mark.parametrize(
    ("start", "stop", "steps", "message"),
    [
        (0.0, 0.0, 64, "two different finite parameters"),
        (0.0, np.nan, 64, "two different finite parameters"),
        (0.0, 1.0, 1, "at least 2 steps"),
        (0.0, 1.0, 10, "coupler point is in a pin at parameter 0.5"),
        (1.0, 3.0, 10, "crank-rocker at parameter 1 and a triple-rocker at 1.8"),
    ],
)
def test_families_that_are_not_followed(
    start: float, stop: float, steps: int, message: str
) -> None:
    def family(parameter: float) -> tuple[FourBar, CouplerPoint]:
        point = CouplerPoint(abs(parameter - 0.5), 0.3)
        return FourBar(1.0, 0.4 * max(1.0, parameter), 0.9, 0.8), point

    with pytest.raises(InputError, match=message):
        cusp_transitions(family, start, stop, steps)
