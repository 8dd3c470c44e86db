"""Kinematics of rigid linkages."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from pylinkage.actuators import Crank
from pylinkage.components import Ground
from pylinkage.dyads import RRRDyad
from pylinkage.simulation import Linkage as OtherLinkage

from flexmech.errors import InputError
from flexmech.linkages import (
    Clamp,
    FourBar,
    Link,
    LinkEnd,
    Pin,
    Pivot,
    RotatingArm,
    Topology,
    continuous_angles,
)
from tests.support.strategies import STEEL_LINKAGE, Posture, numbers, postures

TURN = np.linspace(0.0, 2 * np.pi, 361)
# Central differences of eighth order for the first and second derivative.
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])


@given(postures())
def test_follower_angles_are_those_of_the_drawn_linkage(drawn: Posture) -> None:
    motion = drawn.linkage.motion(drawn.crank_angle)
    turned = motion.angle[1] - drawn.coupler_angle
    assert abs(np.exp(1j * turned) - 1) < 1e-9


@given(postures(), numbers(0.01, 30) | numbers(-30, -0.01), numbers(-500, 500))
def test_coupler_and_rocker_meet_in_b_and_stay_together(
    drawn: Posture, speed: float, acceleration: float
) -> None:
    linkage = drawn.linkage
    motion = linkage.motion(drawn.crank_angle, speed, acceleration)
    crank, coupler, rocker = linkage.crank, linkage.coupler, linkage.rocker
    for name in ("position", "velocity", "acceleration"):
        at = getattr(motion, name)
        scale = np.abs(at(0, crank)).max() + np.abs(at(1, coupler)).max()
        assert np.abs(at(1, coupler) - at(2, rocker)).max() <= 1e-11 * scale
        assert np.abs(at(0, crank) - at(1, 0.0)).max() <= 1e-14 * scale
    assert np.array_equal(motion.position(2, 0.0), [linkage.ground, 0.0])
    assert motion.angular_velocity[0] == speed
    assert motion.angular_acceleration[0] == acceleration


@given(postures(), numbers(1, 30), numbers(-500, 500))
def test_velocities_and_accelerations_are_derivatives_of_positions(
    drawn: Posture, speed: float, acceleration: float
) -> None:
    pace = speed + np.sqrt(abs(acceleration))
    step = 5e-4 / pace
    time = step * np.arange(-4, 5)
    angle = drawn.crank_angle + speed * time + acceleration * time**2 / 2
    path = drawn.linkage.motion(angle)
    motion = drawn.linkage.motion(drawn.crank_angle, speed, acceleration)
    for values, rate, change in (
        (np.unwrap(path.angle, axis=0), motion.angular_velocity, motion.angular_acceleration),
        (path.position(1, 0.7), motion.velocity(1, 0.7), motion.acceleration(1, 0.7)),
        (path.position(2, 0.7), motion.velocity(2, 0.7), motion.acceleration(2, 0.7)),
    ):
        scale = np.abs(rate).max() + pace
        assert np.abs(FIRST @ values / step - rate).max() <= 1e-8 * scale
        scale = np.abs(change).max() + pace**2
        assert np.abs(SECOND @ values / step**2 - change).max() <= 1e-6 * scale


def freudenstein(linkage: FourBar) -> tuple[float, float, float]:
    """K1, K2, K3 of Kumar & Chandrakar, eqs. 1.7 to 1.9 (1.9 corrected, errata K)."""
    r1, r2, r3, r4 = linkage.lengths.values()
    return r1 / r2, r1 / r4, (r2**2 - r3**2 + r4**2 + r1**2) / (2 * r2 * r4)


def test_freudenstein_constant_of_the_first_mechanism() -> None:
    assert freudenstein(STEEL_LINKAGE)[2] == pytest.approx(1.26698, abs=5e-6)


@given(postures())
def test_rocker_angle_solves_freudensteins_equation(drawn: Posture) -> None:
    k1, k2, k3 = freudenstein(drawn.linkage)
    theta2, _, theta4 = drawn.linkage.motion(drawn.crank_angle).angle
    equation = k1 * np.cos(theta4) - k2 * np.cos(theta2) + k3 - np.cos(theta2 - theta4)
    assert abs(equation) <= 1e-12 * (k1 + k2 + abs(k3) + 1)


def test_branches_are_the_two_roots_of_the_half_angle_quadratic() -> None:
    k1, k2, k3 = freudenstein(STEEL_LINKAGE)
    theta = TURN[5:-5:10]
    a = np.cos(theta) - k1 - k2 * np.cos(theta) + k3
    b = -2 * np.sin(theta)
    c = k1 - (k2 + 1) * np.cos(theta) + k3
    for branch, sign in (("open", -1), ("crossed", 1)):
        root = 2 * np.arctan((-b + sign * np.sqrt(b**2 - 4 * a * c)) / (2 * a))
        rocker = replace(STEEL_LINKAGE, branch=branch).motion(theta).angle[:, 2]
        assert np.exp(1j * rocker) == pytest.approx(np.exp(1j * root), abs=1e-12)


def test_open_branch_has_b_above_the_ground_at_crank_angle_zero() -> None:
    crossed = replace(STEEL_LINKAGE, branch="crossed")
    assert STEEL_LINKAGE.motion(0.0).position(2, 0.2667)[1] > 0
    assert crossed.motion(0.0).position(2, 0.2667)[1] < 0


@given(postures())
def test_transmission_angle_lies_between_coupler_and_rocker(drawn: Posture) -> None:
    motion = drawn.linkage.motion(drawn.crank_angle)
    to_a = motion.position(1, 0.0) - motion.position(1, drawn.linkage.coupler)
    to_o4 = motion.position(2, 0.0) - motion.position(2, drawn.linkage.rocker)
    cross = to_a[0] * to_o4[1] - to_a[1] * to_o4[0]
    expected = np.arctan2(abs(cross), to_a @ to_o4)
    assert drawn.linkage.transmission_angle(drawn.crank_angle) == pytest.approx(expected, abs=1e-9)


# Elamy et al. 2023, Table 3, with the limits of errata E.7.
@pytest.mark.parametrize(
    ("lengths", "least", "greatest"),
    [
        ((1.00, 0.27, 0.83, 0.67), 57.05, 115.29),
        ((1.00, 0.42, 1.00, 0.79), 35.41, 104.38),
        ((1.00, 0.14, 0.90, 0.46), 70.09, 109.62),
        ((1.00, 0.21, 0.91, 0.46), 60.24, 120.46),
    ],
)
def test_transmission_angle_limits_of_the_crank_rockers(
    lengths: tuple[float, ...], least: float, greatest: float
) -> None:
    linkage = FourBar(*lengths)
    assert linkage.grashof_class == "crank-rocker"
    assert np.degrees(linkage.transmission_angle_limits()) == pytest.approx(
        [least, greatest], abs=0.005
    )


@given(postures())
def test_transmission_angle_stays_within_its_limits_and_reaches_them(drawn: Posture) -> None:
    linkage = drawn.linkage
    least, greatest = linkage.transmission_angle_limits()
    here = float(linkage.transmission_angle(drawn.crank_angle))
    assert least - 1e-9 <= here <= greatest + 1e-9
    if linkage.crank_turns_fully:
        ends = linkage.transmission_angle([0.0, np.pi])
        assert ends == pytest.approx([least, greatest], abs=1e-12)
    else:
        assert least == 0.0 or greatest == pytest.approx(np.pi)


@given(postures())
def test_grashof_class_tells_whether_the_crank_can_turn(drawn: Posture) -> None:
    if drawn.linkage.crank_turns_fully:
        assert np.isfinite(drawn.linkage.motion(TURN, 1.0, 1.0).angular_acceleration).all()
    else:
        with pytest.raises(InputError, match="crank angle"):
            drawn.linkage.motion(np.array([0.0, np.pi]))


@pytest.mark.parametrize(
    ("lengths", "kind", "turns"),
    [
        ((4.0, 1.0, 3.0, 3.5), "crank-rocker", True),
        ((4.0, 3.0, 3.5, 1.0), "rocker-crank", False),
        ((1.0, 4.0, 3.0, 3.5), "double-crank", True),
        ((4.0, 3.0, 1.0, 3.5), "double-rocker", False),
        ((4.0, 2.0, 4.0, 2.0), "change-point", False),
        ((5.0, 3.0, 3.0, 3.0), "triple-rocker", False),
    ],
)
def test_grashof_classes(lengths: tuple[float, ...], kind: str, turns: bool) -> None:
    linkage = FourBar(*lengths)
    assert linkage.grashof_class == kind
    assert linkage.crank_turns_fully is turns


def test_a_crank_angle_out_of_reach_is_named() -> None:
    linkage = FourBar(5.0, 3.0, 3.0, 3.0)
    message = r"cannot be assembled at crank angle 135 deg.*triple-rocker"
    with pytest.raises(InputError, match=message):
        linkage.motion(np.radians([0.0, 135.0, 180.0]))
    with pytest.raises(InputError, match=message):
        linkage.transmission_angle(np.radians(135.0))


def test_a_locked_crank_angle_is_named() -> None:
    linkage = FourBar(5.0, 3.0, 3.0, 3.0)
    # |A - O4| = coupler + rocker = 6
    locked = np.arccos((25 + 9 - 36) / 30)
    with pytest.raises(InputError, match=rf"locks at crank angle {np.degrees(locked):g} deg"):
        linkage.motion(locked)
    linkage.motion(locked - 1e-3)


def test_a_change_point_is_named() -> None:
    with pytest.raises(InputError, match="meets a change point at crank angle 180 deg"):
        FourBar(4.0, 2.0, 4.0, 2.0).motion(np.radians([90.0, 180.0]))


def test_links_that_can_never_close_are_refused_with_their_lengths() -> None:
    with pytest.raises(InputError, match=r"any crank angle: the coupler \(7 m\).*\(6 m\)"):
        FourBar(1.0, 2.0, 7.0, 3.0)


@pytest.mark.parametrize("length", [0.0, -1.0, np.nan, np.inf])
def test_a_length_must_be_positive(length: float) -> None:
    with pytest.raises(InputError, match="length of the rocker must be positive"):
        FourBar(1.0, 1.0, 1.0, length)
    with pytest.raises(InputError, match="length of the arm must be positive"):
        RotatingArm(length)


def test_an_unknown_branch_is_refused() -> None:
    with pytest.raises(InputError, match="one of open, crossed, got 'closed'"):
        FourBar(1.0, 1.0, 1.0, 1.0, "closed")  # type: ignore[arg-type]


@pytest.mark.parametrize("linkage", [STEEL_LINKAGE, RotatingArm(1.0, 0.2)])
def test_arguments_of_motion_broadcast(linkage: FourBar | RotatingArm) -> None:
    angle, speed = np.array([[0.1], [0.2], [0.3]]), np.array([1.0, 2.0])
    motion = linkage.motion(angle, speed, 5.0)
    links = len(linkage.topology.links)
    assert motion.angle.shape == motion.angular_acceleration.shape == (3, 2, links)
    assert motion.origin_acceleration.shape == (3, 2, links, 2)
    assert motion.position(links - 1, 0.1).shape == (3, 2, 2)
    one = linkage.motion(0.2, 2.0, 5.0)
    assert one.angle.shape == (links,)
    assert one.crank_angle.shape == ()
    assert one.acceleration(links - 1, 0.1) == pytest.approx(
        motion.acceleration(links - 1, 0.1)[1, 1], rel=1e-13
    )


def test_transmission_angle_keeps_the_shape_of_its_argument() -> None:
    assert STEEL_LINKAGE.transmission_angle(0.3).shape == ()
    assert STEEL_LINKAGE.transmission_angle(np.zeros((2, 3))).shape == (2, 3)


@settings(max_examples=20)
@given(numbers(-3, 3), numbers(-20, 20), numbers(-100, 100), numbers(0, 2))
def test_arm_moves_on_a_circle_around_the_axis(
    angle: float, speed: float, acceleration: float, hub: float
) -> None:
    motion = RotatingArm(1.0, hub).motion(angle, speed, acceleration)
    radius = hub + 0.6
    turn = np.exp(1j * angle)
    velocity, change = motion.velocity(0, 0.6), motion.acceleration(0, 0.6)
    assert complex(*motion.position(0, 0.6)) == pytest.approx(radius * turn)
    assert complex(*velocity) == pytest.approx(1j * speed * radius * turn)
    expected = (1j * acceleration - speed**2) * radius * turn
    assert complex(*change) == pytest.approx(expected, abs=1e-10)


def test_angles_of_a_swinging_crank_are_counted_on_from_zero() -> None:
    """They swing to both sides of crank angle zero, where they keep their values."""
    swinging = FourBar(ground=0.3, crank=0.25, coupler=0.17, rocker=0.2)
    assert swinging.grashof_class == "triple-rocker"
    crank_angle = np.linspace(-1.4, 1.4, 57)
    motion = swinging.motion(crank_angle)
    counted = continuous_angles(swinging, motion)
    np.testing.assert_array_equal(counted[:, 0], crank_angle)
    np.testing.assert_allclose(counted[28], motion.angle[28], rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.exp(1j * counted), np.exp(1j * motion.angle), atol=1e-12)
    assert np.abs(np.diff(counted, axis=0)).max() < 1.0


def test_a_resized_arm_stands_on_a_hub_of_the_ground() -> None:
    """Its hub grows as the ground does, whatever the arm's own length."""
    grown = RotatingArm(1.0, 0.2).resized({"arm": 1.03}, 1.01)
    assert grown.motion(0.0).position(0, 0.0)[0] == pytest.approx(0.202, rel=1e-12)
    assert grown.motion(0.0).position(0, grown.length)[0] == pytest.approx(1.232, rel=1e-12)


@pytest.mark.parametrize("branch", ["open", "crossed"])
def test_pylinkage_finds_the_same_motion_over_a_turn(branch: str) -> None:
    ours = replace(STEEL_LINKAGE, branch=branch)
    steps, speed, alpha = 72, 20.0, 50.0
    start = ours.motion(0.0).position(2, ours.rocker)
    o2, o4 = Ground(0.0, 0.0), Ground(ours.ground, 0.0)
    crank = Crank(o2, ours.crank, angular_velocity=2 * np.pi / steps)
    rocker = RRRDyad(crank.output, o4, ours.coupler, ours.rocker, x=start[0], y=start[1])
    theirs = OtherLinkage([o2, o4, crank, rocker])
    theirs.set_input_velocity(crank, speed, alpha)
    found = list(theirs.step_with_derivatives(iterations=steps))
    angle = 2 * np.pi / steps * np.arange(1, steps + 1)
    motion = ours.motion(angle, speed, alpha)
    for kind, at in enumerate((motion.position, motion.velocity, motion.acceleration)):
        other = np.array([point[kind][3] for point in found])
        assert at(2, ours.rocker) == pytest.approx(other, rel=1e-8, abs=1e-9)


START, END = LinkEnd("bar", "start"), LinkEnd("bar", "end")
BAR = Link("bar", 1.0)


def test_topology_refuses_wrong_connections() -> None:
    with pytest.raises(InputError, match="link names must differ"):
        Topology((BAR, BAR))
    with pytest.raises(InputError, match="names link 'rod'; links are"):
        Topology((BAR,), clamps=(Clamp("O", LinkEnd("rod", "start")),))
    with pytest.raises(InputError, match="depends on two joints; make it the leader"):
        Topology((BAR,), clamps=(Clamp("O", START),), pivots=(Pivot("P", START),))
    circle = Topology((BAR,), pins=(Pin("A", START, END), Pin("B", END, START)))
    with pytest.raises(InputError, match="pins and welds lead in a circle"):
        circle.leader_of(START)


def test_topology_of_a_fourbar() -> None:
    topology = STEEL_LINKAGE.topology
    assert topology.link_names == ("crank", "coupler", "rocker")
    assert topology.joint_names == ("O2", "A", "B", "O4")
    assert [link.length for link in topology.links] == [0.1, 0.2794, 0.2667]
    assert topology.leader_of(LinkEnd("rocker", "end")) == LinkEnd("coupler", "end")
