"""Synthesis of crank-rockers: what is asked for comes back, and nothing else is accepted."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from flexmech.errors import InputError
from flexmech.linkages import (
    FourBar,
    rocker_swing,
    synthesize_crank_rocker,
    time_ratio,
    transmission_design,
)
from tests.support.strategies import numbers

# Deviation in degrees, and the rocker angle as a part of the way between its bounds.
designs = settings(max_examples=30)(given(numbers(0.5, 89.5), numbers(0.01, 0.99)))
TURN = np.linspace(0, 2 * np.pi, 7201)


def rocker_angle_at(deviation: float, part: float) -> float:
    least = 90 - deviation
    return least + part * (180 - least)


@designs
def test_angles_that_are_asked_for_come_back(deviation: float, part: float) -> None:
    rocker_angle = rocker_angle_at(deviation, part)
    linkage = synthesize_crank_rocker(*np.radians([deviation, rocker_angle])).linkage(0.4)
    limits = np.degrees(linkage.transmission_angle_limits())
    assert limits == pytest.approx([90 - deviation, 90 + deviation], abs=1e-6)
    assert np.degrees(linkage.motion(0.0).angle[2]) == pytest.approx(rocker_angle, abs=1e-5)
    assert linkage.grashof_class == "crank-rocker"


@designs
def test_design_is_the_inverse_of_synthesis(deviation: float, part: float) -> None:
    rocker_angle = rocker_angle_at(deviation, part)
    found = synthesize_crank_rocker(*np.radians([deviation, rocker_angle]))
    design = transmission_design(found.linkage(0.4))
    assert design.imbalance == pytest.approx(0.0, abs=1e-9)
    assert np.degrees(design.deviation) == pytest.approx(deviation, abs=1e-6)
    assert np.degrees(design.rocker_angle) == pytest.approx(rocker_angle, abs=1e-5)
    again = synthesize_crank_rocker(design.deviation, design.rocker_angle)
    for name in ("crank", "coupler", "rocker"):
        assert getattr(again, name) == pytest.approx(getattr(found, name), rel=1e-6)


@designs
def test_balanced_crank_rockers_have_a_unit_time_ratio(deviation: float, part: float) -> None:
    """And the swing of a centric crank-rocker, 2 asin(r2/r4)."""
    angles = np.radians([deviation, rocker_angle_at(deviation, part)])
    linkage = synthesize_crank_rocker(*angles).linkage(0.4)
    assert time_ratio(linkage) == pytest.approx(1.0, abs=1e-6)
    sine = linkage.crank / linkage.rocker
    assert np.sin(rocker_swing(linkage) / 2) == pytest.approx(sine, abs=1e-8)


@pytest.mark.parametrize("ratios", [(0.27, 0.83, 0.67), (0.42, 1.0, 0.79), (0.21, 0.91, 0.46)])
@pytest.mark.parametrize("branch", ["open", "crossed"])
def test_design_swing_and_time_ratio_are_those_of_the_motion(ratios, branch) -> None:
    crank, coupler, rocker = 0.3 * np.array(ratios)
    linkage = FourBar(0.3, crank, coupler, rocker, branch)
    angle = np.unwrap(linkage.motion(TURN).angle[:, 2])
    assert rocker_swing(linkage) == pytest.approx(np.ptp(angle), abs=1e-6)
    stroke = np.abs(TURN[angle.argmax()] - TURN[angle.argmin()])
    slower, faster = max(stroke, 2 * np.pi - stroke), min(stroke, 2 * np.pi - stroke)
    assert time_ratio(linkage) == pytest.approx(slower / faster, abs=2e-3)
    design = transmission_design(linkage)
    assert design.rocker_angle == pytest.approx(abs(angle[0]))
    transmission = linkage.transmission_angle(TURN)
    assert design.deviation == pytest.approx(np.abs(transmission - np.pi / 2).max())
    cosines = np.cos(transmission[[0, 3600]]).sum()
    assert design.imbalance == pytest.approx(cosines * ratios[1] * ratios[2])
    assert abs(design.imbalance) > 1e-9


def test_designs_are_computed_at_once() -> None:
    deviation, rocker_angle = np.radians([20.0, 30.0])[:, None], np.radians([90.0, 100, 120])
    found = synthesize_crank_rocker(deviation, rocker_angle)
    assert found.crank.shape == found.deviation.shape == (2, 3)
    one = synthesize_crank_rocker(deviation[1, 0], rocker_angle[2])
    assert found.crank[1, 2] == one.crank
    with pytest.raises(InputError, match="one design, these are 6"):
        found.linkage()


@pytest.mark.parametrize(
    ("deviation", "rocker_angle", "message"),
    [
        (0.0, 100.0, r"deviation must lie between 0 and 90 deg \(both excluded\), got 0 deg"),
        (90.0, 100.0, "deviation must lie between 0 and 90 deg .* got 90 deg"),
        (np.nan, 100.0, "deviation .* got nan"),
        (20.0, 60.0, "between 70 and 180 deg .* of 20 deg, got 60 deg; .* deviation above 30 deg"),
        (20.0, 70.0, "rocker angle must lie between 70 and 180 deg .* got 70 deg; .* raise it"),
        (20.0, -5.0, "got -5 deg; .* raise it$"),
        (20.0, 180.0, "rocker angle must lie between 70 and 180 deg .* choose a smaller one"),
        (20.0, np.nan, "rocker_angle must be finite numbers, got nan rad"),
        # The bounds named are those of the design that breaks them.
        ([10.0, 40.0], [100.0, 40.0], "between 50 and 180 deg .* of 40 deg, got 40 deg"),
        # Inside the bounds, and yet a change point to Grashof's criterion.
        (20.0, 70.0000000001, "at a bound within round-off.* between 70 and 180 deg"),
        (20.0, 179.99999999, "at a bound within round-off"),
        (89.99999999, 100.0, "at a bound within round-off"),
    ],
)
def test_what_cannot_be(deviation, rocker_angle, message: str) -> None:
    with pytest.raises(InputError, match=message):
        synthesize_crank_rocker(np.radians(deviation), np.radians(rocker_angle))


@pytest.mark.parametrize("measure", [rocker_swing, time_ratio, transmission_design])
def test_other_linkages_have_no_such_design(measure) -> None:
    with pytest.raises(InputError, match="must make a crank-rocker, got a double-crank"):
        measure(FourBar(0.2, 1.0, 0.9, 0.8))
