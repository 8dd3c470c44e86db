"""Motion of four-bars: Freudenstein, Kumar & Chandrakar, Elamy et al., Grashof, another program."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from elamy_linkages import published_case
from pylinkage.actuators import Crank
from pylinkage.components import Ground
from pylinkage.dyads import RRRDyad
from pylinkage.simulation import Linkage as OtherLinkage

from flexmech import FourBar, InputError
from flexmech.linkages import continuous_angles
from flexmech.verification import verification_case
from tests.support.strategies import ALUMINIUM_LINKAGE, STEEL_LINKAGE

TURN = np.radians(np.arange(1.0, 360.0, 7.5))
SPEED = 20.0


@pytest.fixture(params=[0.0, -150.0], ids=["constant speed", "slowing down"])
def alpha2(request: pytest.FixtureRequest) -> float:
    """Acceleration of the crank in rad/s^2."""
    return float(request.param)


def freudenstein(linkage: FourBar) -> tuple[float, float, float]:
    """K1, K2, K3 of Kumar & Chandrakar, eqs. 1.7 to 1.9 (1.9 corrected, errata K)."""
    r1, r2, r3, r4 = linkage.lengths.values()
    return r1 / r2, r1 / r4, (r2**2 - r3**2 + r4**2 + r1**2) / (2 * r2 * r4)


@pytest.mark.parametrize(("branch", "sign"), [("open", -1), ("crossed", 1)])
def test_the_branches_are_the_roots_of_freudensteins_quadratic(branch: str, sign: int) -> None:
    """K3 of the steel mechanism is 1.26698, as printed."""
    k1, k2, k3 = freudenstein(STEEL_LINKAGE)
    assert k3 == pytest.approx(1.26698, abs=5e-6)
    a = np.cos(TURN) - k1 - k2 * np.cos(TURN) + k3
    b, c = -2 * np.sin(TURN), k1 - (k2 + 1) * np.cos(TURN) + k3
    root = 2 * np.arctan((-b + sign * np.sqrt(b**2 - 4 * a * c)) / (2 * a))
    rocker = replace(STEEL_LINKAGE, branch=branch).motion(TURN).angle[:, 2]
    assert np.exp(1j * rocker) == pytest.approx(np.exp(1j * root), abs=1e-12)


def test_the_open_branch_has_b_above_the_ground_at_crank_angle_zero() -> None:
    heights = [
        replace(STEEL_LINKAGE, branch=branch).motion(0.0).position(2, 0.2667)[1]
        for branch in ("open", "crossed")
    ]
    assert heights[0] > 0 > heights[1]


def test_angular_accelerations_are_kumars_equations_1_35_and_1_36(alpha2: float) -> None:
    """With sin(th2 - th3) in the term of alpha2 where th4 is printed."""
    _, r2, r3, r4 = STEEL_LINKAGE.lengths.values()
    motion = STEEL_LINKAGE.motion(TURN, SPEED, alpha2)
    (th2, th3, th4), (_, w3, w4) = motion.angle.T, motion.angular_velocity.T
    sine, cosine = np.sin(th4 - th3), np.cos(th4 - th3)
    above = r2 * SPEED**2 * np.cos(th2 - th4) + r2 * alpha2 * np.sin(th2 - th4)
    third = (above + r3 * w3**2 * cosine - r4 * w4**2) / (r3 * sine)
    above = r2 * SPEED**2 * np.cos(th2 - th3) + r2 * alpha2 * np.sin(th2 - th3)
    fourth = (above - r4 * w4**2 * cosine + r3 * w3**2) / (r4 * sine)
    found = motion.angular_acceleration.T
    assert found == pytest.approx(np.stack([np.full(len(TURN), alpha2), third, fourth]), rel=1e-9)


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_limits_of_the_transmission_angle_are_at_crank_angles_0_and_180(number: int) -> None:
    """Elamy et al. 2023, Table 3, with the limits of errata E.7."""
    linkage = published_case(number)
    limits = np.degrees(linkage.transmission_angle_limits())
    case = verification_case(f"Limits of the transmission angle: case {number}")
    assert limits == pytest.approx(case.expected_values(), abs=0.005)
    at_ends = np.degrees(linkage.transmission_angle([0.0, np.pi]))
    assert at_ends == pytest.approx(limits, abs=1e-9)


def test_with_the_rocker_driving_the_transmission_angle_is_that_at_a() -> None:
    """In its dead points crank and coupler are in line, and the rocker turns around."""
    motion = ALUMINIUM_LINKAGE.motion(TURN)
    a, b = motion.position(0, ALUMINIUM_LINKAGE.crank), motion.position(2, 0.2667)
    sides = np.linalg.norm(a, axis=1) * np.linalg.norm(b - a, axis=1)
    cosine = np.sum(-a * (b - a), axis=1) / sides
    found = ALUMINIUM_LINKAGE.reversed_transmission_angle(TURN)
    assert found == pytest.approx(np.arccos(cosine), abs=1e-9)
    fine = np.radians(np.arange(0, 360.0, 0.01))
    rocker = ALUMINIUM_LINKAGE.motion(fine, 1.0).angular_velocity[:, 2]
    turning = np.flatnonzero(np.diff(np.sign(rocker)))
    assert len(turning) == 2
    assert np.sin(ALUMINIUM_LINKAGE.reversed_transmission_angle(fine[turning])).max() < 3e-4


@pytest.mark.parametrize(
    ("lengths", "kind", "turns"),
    [
        ((4.0, 1.0, 3.0, 3.5), "crank-rocker", True),
        ((4.0, 3.0, 3.5, 1.0), "rocker-crank", False),
        ((1.0, 4.0, 3.0, 3.5), "double-crank", True),
        ((4.0, 3.0, 1.0, 3.5), "double-rocker", False),
        ((0.3 + 2e-10, 0.1, 0.2, 0.2), "change-point", False),
        ((0.3 - 3e-9, 0.1, 0.2, 0.2), "crank-rocker", True),
        ((5.0, 3.0, 3.0, 3.0), "triple-rocker", False),
    ],
)
def test_grashofs_criterion(lengths: tuple[float, ...], kind: str, turns: bool) -> None:
    """Lengths that add up to nine digits make a change point."""
    linkage = FourBar(*lengths)
    assert linkage.grashof_class == kind
    assert linkage.crank_turns_fully is turns


@pytest.mark.parametrize("branch", ["open", "crossed"])
def test_pylinkage_computes_the_same_motion(branch: str) -> None:
    ours = replace(STEEL_LINKAGE, branch=branch)
    steps, alpha = 72, 50.0
    start = ours.motion(0.0).position(2, ours.rocker)
    o2, o4 = Ground(0.0, 0.0), Ground(ours.ground, 0.0)
    crank = Crank(o2, ours.crank, angular_velocity=2 * np.pi / steps)
    rocker = RRRDyad(crank.output, o4, ours.coupler, ours.rocker, x=start[0], y=start[1])
    theirs = OtherLinkage([o2, o4, crank, rocker])
    theirs.set_input_velocity(crank, SPEED, alpha)
    steps_of_theirs = list(theirs.step_with_derivatives(iterations=steps))
    motion = ours.motion(2 * np.pi / steps * np.arange(1, steps + 1), SPEED, alpha)
    for kind, at in enumerate((motion.position, motion.velocity, motion.acceleration)):
        other = np.array([point[kind][3] for point in steps_of_theirs])
        assert at(2, ours.rocker) == pytest.approx(other, rel=1e-8, abs=1e-9)


@pytest.mark.parametrize(
    ("lengths", "gained"), [((1.0, 0.3, 1.2, 1.1), 0), ((0.3, 1, 1.1, 0.9), 1)]
)
def test_angles_are_counted_on_over_turns(lengths: tuple[float, ...], gained: int) -> None:
    """The coupler and rocker of a drag link turn with the crank, those of a crank-rocker swing."""
    linkage = FourBar(*lengths)
    counted = continuous_angles(linkage, linkage.motion(np.linspace(-7, 14, 2000)))
    assert np.abs(np.diff(counted, axis=0)).max() < 0.2
    turn = linkage.motion([0.5, 0.5 + 2 * np.pi])
    turned = np.diff(continuous_angles(linkage, turn), axis=0)[0] / (2 * np.pi)
    assert turned == pytest.approx([1, gained, gained], abs=1e-9)


@pytest.mark.parametrize(
    ("lengths", "crank_angle", "said"),
    [
        ((5.0, 3.0, 3.0, 3.0), 135.0, r"cannot be assembled at crank angle 135 deg.*triple-rocker"),
        # |A - O4| is the sum of coupler and rocker.
        ((5.0, 3.0, 3.0, 3.0), np.degrees(np.arccos(-2 / 30)), r"locks at crank angle 93\.82"),
        ((4.0, 2.0, 4.0, 2.0), 180.0, "change point at crank angle 180 deg"),
        # A crank as long as the ground leads its pin through the other pivot.
        ((0.2, 0.2, 0.21, 0.15), 0.0, "cannot be assembled"),
    ],
)
def test_where_a_four_bar_cannot_stand_its_crank_angle_is_named(
    lengths: tuple[float, ...], crank_angle: float, said: str
) -> None:
    linkage = FourBar(*lengths)
    with np.errstate(all="raise"), pytest.raises(InputError, match=said):
        linkage.motion(np.radians([crank_angle]))


def test_a_linkage_locks_where_a_velocity_has_less_than_nine_digits() -> None:
    """Coupler and rocker are in line but for a millionth of a radian."""
    linkage = FourBar(0.25, 0.2, 0.21, 0.15)

    def crank_angle(sine: float) -> float:
        sides = linkage.coupler**2 + linkage.rocker**2 - linkage.ground**2 - linkage.crank**2
        cosine = -np.sqrt(1 - sine**2) * 2 * linkage.coupler * linkage.rocker
        return float(np.arccos((cosine - sides) / (2 * linkage.ground * linkage.crank)))

    linkage.motion(crank_angle(5e-6))
    with pytest.raises(InputError, match="locks"):
        linkage.motion(crank_angle(2e-7))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((1.0, 2.0, 7.0, 3.0), r"any crank angle: the coupler \(7 m\).*\(6 m\)"),
        ((1.0, 1.0, 1.0, 0.0), "length of the rocker must be positive"),
        ((1.0, 1.0, np.nan, 1.0), "coupler"),
        ((1.0, 1.0, 1.0, 1.0, "closed"), "one of open, crossed, got 'closed'"),
    ],
)
def test_lengths_that_make_no_four_bar_are_refused(arguments: tuple, said: str) -> None:
    with pytest.raises(InputError, match=said):
        FourBar(*arguments)


def test_speeds_that_no_shaft_has_are_refused() -> None:
    STEEL_LINKAGE.motion(0.0, 5e8)
    with pytest.raises(InputError, match="no shaft"):
        STEEL_LINKAGE.motion(0.0, 2e9)
