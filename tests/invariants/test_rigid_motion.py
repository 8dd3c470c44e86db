"""The motion of every rigid linkage: closed loops, rates that are derivatives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings

from flexmech import FourBar, InputError, PlanarJoint, PlanarLinkage, example_model, load_mechanism
from flexmech.linkages import LinkEnd
from tests.support.mechanisms import drawn
from tests.support.random_planar import planar_linkages
from tests.support.strategies import Posture, numbers, postures

SLOW = settings(
    max_examples=40, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much]
)
SIZE = 4.0  # of the random drawings, in m
# Differences of eighth order for the first and second derivative.
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])


@given(postures(), numbers(0.01, 30) | numbers(-30, -0.01), numbers(-500, 500))
def test_coupler_and_rocker_of_a_four_bar_stay_together(
    posture: Posture, speed: float, acceleration: float
) -> None:
    """At the coupler angle at which it was drawn."""
    linkage = posture.linkage
    motion = linkage.motion(posture.crank_angle, speed, acceleration)
    assert abs(np.exp(1j * (motion.angle[1] - posture.coupler_angle)) - 1) < 1e-9
    for name in ("position", "velocity", "acceleration"):
        at = getattr(motion, name)
        scale = np.abs(at(0, linkage.crank)).max() + np.abs(at(1, linkage.coupler)).max()
        assert np.abs(at(1, linkage.coupler) - at(2, linkage.rocker)).max() <= 1e-11 * scale
        assert np.abs(at(0, linkage.crank) - at(1, 0.0)).max() <= 1e-14 * scale


@given(postures())
def test_the_transmission_angle_stays_within_its_limits(posture: Posture) -> None:
    """A crank that turns fully reaches both, one that does not locks at 0 or 180 degrees."""
    linkage = posture.linkage
    least, greatest = linkage.transmission_angle_limits()
    here = float(linkage.transmission_angle(posture.crank_angle))
    assert least - 1e-9 <= here <= greatest + 1e-9
    if linkage.crank_turns_fully:
        ends = linkage.transmission_angle([0.0, np.pi])
        assert ends == pytest.approx([least, greatest], abs=1e-12)
        return
    assert least == 0.0 or greatest == pytest.approx(np.pi)
    with pytest.raises(InputError, match="crank angle"):
        linkage.motion(np.array([0.0, np.pi]))


def check_rates(linkage: FourBar | PlanarLinkage, start: float) -> None:
    """Velocities and accelerations against differences in time of a crank that speeds up."""
    speed, acceleration, step = 1.5, 2.0, 2e-3
    time = step * np.arange(-4, 5)
    path = linkage.motion(start + speed * time + acceleration * time**2 / 2)
    motion = linkage.motion(start, speed, acceleration)
    turning = 1 + np.abs(motion.angular_velocity).max()
    turned = np.angle(np.exp(1j * (path.angle - path.angle[4])))
    for values, first, second in (
        (turned, motion.angular_velocity, motion.angular_acceleration),
        (path.origin, motion.origin_velocity, motion.origin_acceleration),
    ):
        for weights, power, exact in ((FIRST, 1, first), (SECOND, 2, second)):
            rate = np.tensordot(weights, values, 1) / step**power
            scale = (1 + np.abs(exact).max()) * turning**4
            assert np.abs(rate - exact).max() < 1e-6 * scale


@SLOW
@given(planar_linkages())
def test_rates_of_drawn_linkages_are_derivatives(linkage: PlanarLinkage) -> None:
    """Away from the drawing, where points have slid from where their lines were drawn."""
    for away in (0.2, -0.2, 0.03):
        try:
            linkage.motion(linkage.drawn_angle + away + np.array([-0.02, 0.02]))
        except InputError:
            continue
        motion = linkage.motion(linkage.drawn_angle + away, 1.5, 2.0)
        # Close to a dead point the differences themselves say nothing.
        assume(np.abs(motion.angular_velocity).max() < 20)
        assume(np.abs(motion.angular_acceleration).max() < 1e3)
        check_rates(linkage, linkage.drawn_angle + away)
        return
    assume(False)


@pytest.mark.parametrize(
    "kind", ["slider on a rocker", "ram between two bushings", "driven output"]
)
def test_rates_of_linkages_that_slide_on_moving_lines_are_derivatives(kind: str) -> None:
    if kind == "driven output":
        # Newton's method finds four of its links together.
        linkage = load_mechanism(example_model("stephenson_six_bar")).linkage
        linkage = replace(linkage, joints=(PlanarJoint("O6", "clamp"),))
    elif kind == "ram between two bushings":
        points = {"O2": (0, 0), "A": (0, 0.1), "B": (0.3, 0.05), "C": (0.5, 0.15)}
        along = float(np.arctan2(0.1, 0.2))
        joints = {name: PlanarJoint(name, "slider", (), along) for name in "BC"}
        links = {"crank": ("O2", "A"), "rod": ("A", "B"), "ram": ("B", "C")}
        linkage = drawn(points, links, {"O2": "clamp", **joints})
        assert np.ptp(linkage.motion(np.linspace(1.3, 1.8, 9)).angle[:, 2]) < 1e-14
    else:
        points = {"O2": (0, 0), "A": (0.05, 0.0866), "B": (0.2638, 0.2665), "O4": (0.254, 0)}
        points |= {"C": (0.35, 0.15), "D": (0.27, 0.21)}
        links = {"crank": ("O2", "A"), "coupler": ("A", "B", "C"), "rocker": ("O4", "B")}
        links["rod"] = ("C", "D")
        joints = {"O2": "clamp", "D": PlanarJoint("D", "slider", (), 0.3, "rocker")}
        linkage = drawn(points, links, joints, ("O4",), ("rocker",))
    check_rates(linkage, linkage.drawn_angle + 0.05)


@SLOW
@given(planar_linkages())
def test_drawn_linkages_stand_as_drawn_and_their_loops_close(linkage: PlanarLinkage) -> None:
    """At the drawing's crank angle, and beside it."""
    motion = linkage.motion(linkage.drawn_angle)
    beams = [beam for link in linkage.links for beam in link.beams]
    for number, beam in enumerate(beams):
        for point, x in ((beam.start, 0.0), (beam.end, linkage.topology.links[number].length)):
            apart = motion.position(number, x) - linkage.points[point]
            assert np.abs(apart).max() < 1e-13 * SIZE, beam
    try:
        motion = linkage.motion(linkage.drawn_angle + np.linspace(-0.05, 0.05, 5))
    except InputError:
        return
    topology = linkage.topology

    def place(end: LinkEnd) -> np.ndarray:
        number = topology.index(end.link)
        return motion.position(number, topology.links[number].length * (end.end == "end"))

    for tie in topology.ties:
        assert np.abs(place(tie.leader) - place(tie.follower)).max() < 1e-13 * SIZE, tie
    for held in (*topology.pivots, *topology.clamps):
        point = linkage.points[held.joint.split("-")[0]]
        assert np.abs(place(held.link_end) - point).max() < 1e-13 * SIZE, held
    for slider in topology.sliders:
        at, angle = place(slider.link_end), slider.direction
        if slider.guide:
            guide = topology.index(slider.guide)
            at, angle = at - motion.origin[:, guide], angle + motion.angle[:, guide]
        off = np.cos(angle) * at[:, 1] - np.sin(angle) * at[:, 0] - slider.offset
        assert np.abs(off).max() < 1e-13 * SIZE, slider


@SLOW
@given(postures())
def test_a_four_bar_that_is_drawn_moves_as_the_four_bar(posture: Posture) -> None:
    own, angle = posture.linkage, posture.crank_angle
    motion = own.motion(angle)
    b = motion.position(1, own.coupler)
    points = {"O2": (0.0, 0.0), "A": tuple(motion.position(1, 0.0)), "B": tuple(b)}
    links = {"crank": ("O2", "A"), "coupler": ("A", "B"), "rocker": ("O4", "B")}
    other = drawn(points | {"O4": (own.ground, 0.0)}, links, {"O2": "clamp"}, ("O4",))
    other = replace(other, drawn_at=angle)
    angles = angle + np.linspace(-0.05, 0.05, 5)
    first, second = (each.motion(angles, 3.0, -2.0) for each in (own, other))
    sine = np.abs(np.sin(first.angle[:, 2] - first.angle[:, 1])).min()
    assert np.abs(second.origin - first.origin).max() < 1e-12
    assert np.abs(np.exp(1j * second.angle) - np.exp(1j * first.angle)).max() < 1e-12 / sine
    for name, power in (("angular_velocity", 3), ("angular_acceleration", 5)):
        values, exact = getattr(second, name), getattr(first, name)
        assert np.abs(values - exact).max() < 1e-11 * (np.abs(exact).max() + 1) / sine**power
