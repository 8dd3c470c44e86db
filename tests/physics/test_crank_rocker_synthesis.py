"""Synthesis of crank-rockers: what is asked for comes back, by motion and by Elamy et al. 2023."""

from __future__ import annotations

import numpy as np
import pytest
from elamy_linkages import published_case
from hypothesis import given, settings

from flexmech import FourBar, InputError, crank_rocker_synthesis, synthesize_crank_rocker
from flexmech.linkages import rocker_swing, time_ratio, transmission_design
from flexmech.verification import verification_case
from tests.support.strategies import numbers

TURN = np.linspace(0, 2 * np.pi, 7201)


@settings(max_examples=20)
@given(numbers(0.5, 89.5), numbers(0.01, 0.99))
def test_a_design_has_the_angles_that_are_asked_for(deviation: float, part: float) -> None:
    """In degrees, the rocker angle as a part of the way between its bounds.

    Evenly about 90 degrees the time ratio is one and the swing 2 asin(r2 / r4).
    """
    rocker_angle = 90 - deviation + part * (90 + deviation)
    linkage = synthesize_crank_rocker(*np.radians([deviation, rocker_angle])).linkage(0.4)
    limits = np.degrees(linkage.transmission_angle_limits())
    assert limits == pytest.approx([90 - deviation, 90 + deviation], abs=1e-6)
    assert np.degrees(linkage.motion(0.0).angle[2]) == pytest.approx(rocker_angle, abs=1e-5)
    assert linkage.grashof_class == "crank-rocker"
    design = transmission_design(linkage)
    assert design.imbalance == pytest.approx(0.0, abs=1e-9)
    found = np.degrees([design.deviation, design.rocker_angle])
    assert found == pytest.approx([deviation, rocker_angle], abs=1e-5)
    assert time_ratio(linkage) == pytest.approx(1.0, abs=1e-6)
    sine = linkage.crank / linkage.rocker
    assert np.sin(rocker_swing(linkage) / 2) == pytest.approx(sine, abs=1e-8)


@pytest.mark.parametrize("branch", ["open", "crossed"])
@pytest.mark.parametrize("ratios", [(0.27, 0.83, 0.67), (0.42, 1.0, 0.79)])
def test_swing_time_ratio_and_design_are_those_of_the_motion(
    ratios: tuple[float, ...], branch: str
) -> None:
    crank, coupler, rocker = 0.3 * np.array(ratios)
    linkage = FourBar(0.3, crank, coupler, rocker, branch)  # type: ignore[arg-type]
    angle = np.unwrap(linkage.motion(TURN).angle[:, 2])
    assert rocker_swing(linkage) == pytest.approx(np.ptp(angle), abs=1e-6)
    stroke = float(np.abs(TURN[angle.argmax()] - TURN[angle.argmin()]))
    slower, faster = max(stroke, 2 * np.pi - stroke), min(stroke, 2 * np.pi - stroke)
    assert time_ratio(linkage) == pytest.approx(slower / faster, abs=2e-3)
    design, transmission = transmission_design(linkage), linkage.transmission_angle(TURN)
    assert design.rocker_angle == pytest.approx(abs(angle[0]))
    assert design.deviation == pytest.approx(np.abs(transmission - np.pi / 2).max())
    cosines = np.cos(transmission[[0, 3600]]).sum()
    assert design.imbalance == pytest.approx(cosines * ratios[1] * ratios[2])


@pytest.mark.parametrize(("number", "angles"), [(3, (20.0, 100.0)), (4, (30.0, 90.0))])
def test_table_3_follows_from_the_papers_equations_11_to_17(
    number: int, angles: tuple[float, float]
) -> None:
    """To the two digits that it prints, and back as near as two digits allow."""
    found = synthesize_crank_rocker(*np.radians(angles))
    case = verification_case(f"Proportions of crank-rockers: case {number}")
    proportions = [float(found.crank), float(found.coupler), float(found.rocker)]
    assert proportions == pytest.approx(case.expected_values(), abs=case.tolerance)
    printed = published_case(number)
    lengths = [printed.crank, printed.coupler, printed.rocker]
    assert proportions == pytest.approx(np.array(lengths) / printed.ground, abs=5e-3)
    design = transmission_design(printed)
    assert np.degrees([design.deviation, design.rocker_angle]) == pytest.approx(angles, abs=0.7)


@pytest.mark.parametrize(("number", "imbalance"), [(1, 0.0649), (2, 0.4477)])
def test_cases_1_and_2_do_not_lie_evenly_about_90_degrees(number: int, imbalance: float) -> None:
    found = transmission_design(published_case(number)).imbalance
    assert found == pytest.approx(imbalance, abs=1e-12)


def test_designs_are_computed_at_once() -> None:
    deviation, rocker_angle = np.radians([20.0, 30.0])[:, None], np.radians([90.0, 100, 120])
    many = synthesize_crank_rocker(deviation, rocker_angle)
    one = synthesize_crank_rocker(deviation[1, 0], rocker_angle[2])
    assert many.crank[1, 2] == one.crank
    with pytest.raises(InputError, match="one design, these are 6"):
        many.linkage()


@pytest.mark.parametrize(
    ("deviation", "rocker_angle", "said"),
    [
        (0.0, 100.0, "deviation must lie between 0 and 90 deg .*, got 0 deg"),
        (np.nan, 100.0, "deviation .* got nan"),
        (20.0, 60.0, "between 70 and 180 deg .* got 60 deg; .* deviation above 30 deg"),
        (20.0, 180.0, "rocker angle must lie between 70 and 180 deg .* choose a smaller one"),
        (20.0, np.nan, "rocker_angle must be finite"),
        # The bounds named are those of the design that breaks them.
        ([10.0, 40.0], [100.0, 40.0], "between 50 and 180 deg .* of 40 deg, got 40 deg"),
        # Inside the bounds, and yet a change point to Grashof's criterion.
        (20.0, 70.0000000001, "at a bound within round-off"),
    ],
)
def test_designs_that_cannot_be_are_refused(deviation, rocker_angle, said: str) -> None:
    with pytest.raises(InputError, match=said):
        synthesize_crank_rocker(np.radians(deviation), np.radians(rocker_angle))


def test_what_is_no_design_is_refused() -> None:
    with pytest.raises(InputError, match="must make a crank-rocker, got a double-crank"):
        transmission_design(FourBar(0.2, 1.0, 0.9, 0.8))
    for arguments, said in (
        (("30 deg", 1.5), "deviation must be a number of rad"),
        ((0.5, 1.6, "400 mm"), "ground must be a number of m"),
    ):
        with pytest.raises(InputError, match=said):
            crank_rocker_synthesis(*arguments)
