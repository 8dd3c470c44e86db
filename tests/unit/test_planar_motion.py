"""Motion of planar linkages: loops close, rates are derivatives, the branch is the drawing's."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, find, given, settings

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import FourBar, PlanarJoint, PlanarLink, PlanarLinkage, RigidMotion
from flexmech.linkages.planar.newton import NewtonGroup
from flexmech.linkages.planar.plan import _Order
from flexmech.linkages.topology import LinkEnd
from tests.support.random_planar import planar_linkages
from tests.support.strategies import postures

SLOW = settings(
    max_examples=60, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much]
)
SIZE = 4.0  # of the random drawings, in m
NAMES = (
    "angle",
    "angular_velocity",
    "angular_acceleration",
    "origin",
    "origin_velocity",
    "origin_acceleration",
)


def drawn_as_planar(linkage: FourBar, crank_angle: float) -> PlanarLinkage:
    motion = linkage.motion(crank_angle)
    a, b = motion.position(1, 0.0), motion.position(1, linkage.coupler)
    return PlanarLinkage(
        {"O2": (0.0, 0.0), "A": tuple(a), "B": tuple(b), "O4": (linkage.ground, 0.0)},
        (
            PlanarLink("crank", ("O2", "A")),
            PlanarLink("coupler", ("A", "B")),
            PlanarLink("rocker", ("O4", "B")),
        ),
        ("O2", "O4"),
        (PlanarJoint("O2", "clamp"),),
        crank_angle,
    )


def without_dyads(linkage: PlanarLinkage) -> PlanarLinkage:
    """The same linkage, all of whose bodies are found together by Newton's method."""
    again = PlanarLinkage(
        linkage.points, linkage.links, linkage.ground, linkage.joints, linkage.drawn_at
    )
    assembly = again._assembly
    order = _Order(again.drawing, assembly.bodies, assembly.drawn_at)
    assume(order.unknown)
    unknown = tuple(order.unknown)
    joints = order._on(unknown)
    group = NewtonGroup(again.drawing, assembly.bodies, joints, unknown, assembly.drawn_at)
    assembly.steps = (group,)
    return again


def of_end(motion: RigidMotion, linkage: PlanarLinkage, end: LinkEnd, what: str) -> FloatArray:
    topology = linkage.topology
    number = topology.index(end.link)
    x = 0.0 if end.end == "start" else topology.links[number].length
    return getattr(motion, what)(number, x)


def angle_difference(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.asarray((first - second + np.pi) % (2 * np.pi) - np.pi)


def standing_angles(linkage: PlanarLinkage) -> FloatArray:
    """Crank angles over the turn at which it stands, among them those about the drawing."""
    around = linkage.drawn_angle + np.concatenate(
        [np.linspace(-0.05, 0.05, 5), np.radians(np.arange(0.0, 360.0, 7.0))]
    )
    return around[linkage._assembly.assemblable(around)]


# --- against the four-bar's own equations -------------------------------------------------------


@SLOW
@given(postures())
def test_a_four_bar_drawn_as_planar_moves_as_the_four_bar(posture):
    linkage = drawn_as_planar(posture.linkage, posture.crank_angle)
    angles = posture.crank_angle + np.linspace(-3.0, 3.0, 41)
    angles = angles[[stands(posture.linkage, angle) for angle in angles]]
    own, drawn = (each.motion(angles, 3.0, -2.0) for each in (posture.linkage, linkage))
    sine = np.abs(np.sin(own.angle[:, 2] - own.angle[:, 1]))
    size = max(posture.linkage.lengths.values())
    assert np.abs(drawn.origin - own.origin).max() < 1e-13 * size
    turned = angle_difference(drawn.angle, own.angle)
    # Near a dead point angles are as uncertain as the sine there says.
    assert np.all(np.abs(turned) < 1e-13 / sine[:, None])
    for name, power in (("angular_velocity", 3), ("angular_acceleration", 5)):
        first, second = getattr(drawn, name), getattr(own, name)
        scale = np.abs(second).max(axis=1, keepdims=True) + 1
        assert np.all(np.abs(first - second) < 1e-12 * scale / sine[:, None] ** power), name
    assert linkage.topology.links[1].length == pytest.approx(posture.linkage.coupler, rel=1e-13)
    assert linkage.topology.pins == posture.linkage.topology.pins
    assert linkage.topology.pivots == posture.linkage.topology.pivots
    assert linkage.topology.clamps == posture.linkage.topology.clamps


def stands(linkage: FourBar, angle: float) -> bool:
    try:
        motion = linkage.motion(angle)
    except InputError:
        return False
    return bool(abs(np.sin(motion.angle[2] - motion.angle[1])) > 0.01)


# --- closure ------------------------------------------------------------------------------------


@SLOW
@given(planar_linkages())
def test_chains_of_dyads_close(linkage):
    motion = linkage.motion(standing_angles(linkage))
    topology = linkage.topology
    for tie in topology.ties:
        apart = of_end(motion, linkage, tie.leader, "position") - of_end(
            motion, linkage, tie.follower, "position"
        )
        assert np.abs(apart).max() < 1e-13 * SIZE, tie
    for own in (*topology.pivots, *topology.clamps):
        place = of_end(motion, linkage, own.link_end, "position")
        point = linkage.points[own.joint.split("-")[0]]
        assert np.abs(place - point).max() < 1e-13 * SIZE, own
    for slider in topology.sliders:
        place = of_end(motion, linkage, slider.link_end, "position")
        angle = np.full(len(place), slider.direction)
        if slider.guide:
            guide = topology.index(slider.guide)
            place = place - motion.origin[:, guide]
            angle = angle + motion.angle[:, guide]
        off = -np.sin(angle) * place[:, 0] + np.cos(angle) * place[:, 1] - slider.offset
        assert np.abs(off).max() < 1e-13 * SIZE, slider
    for weld in topology.welds:
        ends = [topology.index(end.link) for end in (weld.leader, weld.follower)]
        turned = angle_difference(motion.angle[:, ends[0]], motion.angle[:, ends[1]])
        assert np.abs(angle_difference(turned, turned[0])).max() < 1e-13, weld


@SLOW
@given(planar_linkages())
def test_at_the_crank_angle_of_the_drawing_it_stands_as_drawn(linkage):
    motion = linkage.motion(linkage.drawn_angle)
    beams = [beam for link in linkage.links for beam in link.beams]
    for number, beam in enumerate(beams):
        for point, x in ((beam.start, 0.0), (beam.end, linkage.topology.links[number].length)):
            apart = motion.position(number, x) - linkage.points[point]
            assert np.abs(apart).max() < 1e-13 * SIZE, beam


# --- rates --------------------------------------------------------------------------------------


@SLOW
@given(planar_linkages())
def test_rates_are_derivatives(linkage):
    """Nine-point differences in time, of a crank that speeds up."""
    check_rates_near(linkage)


@pytest.mark.thorough
@settings(SLOW, max_examples=15)
@given(planar_linkages(most=2))
def test_rates_by_newtons_method_are_derivatives(linkage):
    check_rates_near(without_dyads(linkage))


def check_rates_near(linkage: PlanarLinkage) -> None:
    """Away from the drawing, where sliding points are not where their lines were drawn."""
    starts = linkage.drawn_angle + np.array([0.2, -0.2, 0.0])
    around = starts[:, None] + np.array([-0.02, 0.0, 0.02])
    moving = [linkage._assembly.assemblable(own).all() for own in around]
    assume(any(moving))
    start = float(starts[np.argmax(moving)])
    # Close to a dead point the differences themselves say nothing.
    assume(np.abs(linkage.motion(start, 1.5, 2.0).angular_acceleration).max() < 1e3)
    check_rates(linkage, start)


def check_rates(linkage: PlanarLinkage, start: float) -> None:
    speed, acceleration, step = 1.5, 2.0, 2e-3
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}

    def at(time: float) -> RigidMotion:
        angle = start + speed * time + acceleration * time**2 / 2
        return linkage.motion(angle, speed + acceleration * time, acceleration)

    around = {n: at(n * step) for n in range(-4, 5)}
    now = around[0]
    for name, derivative in zip(NAMES, NAMES[1:] + NAMES[:1], strict=True):
        if derivative in ("angle", "origin"):
            continue
        value = {n: getattr(own, name) for n, own in around.items()}
        if name == "angle":
            value = {n: now.angle + angle_difference(v, now.angle) for n, v in value.items()}
        rate = sum(w * (value[n] - value[-n]) for n, w in weights.items()) / step
        exact = getattr(now, derivative)
        tolerance = 1e-6 * (1 + np.abs(exact).max()) * (1 + np.abs(now.angular_velocity).max()) ** 4
        assert np.abs(rate - exact).max() < tolerance, derivative


# --- branch -------------------------------------------------------------------------------------


@SLOW
@given(planar_linkages())
def test_nothing_jumps_along_the_turn(linkage):
    """Between close crank angles no point moves farther than its velocity says."""
    step = 1e-3
    angles = linkage.drawn_angle + step * np.arange(-60, 61)
    stand = linkage._assembly.assemblable(angles)
    first, last = 60 - np.argmin(stand[60::-1]), 60 + np.argmin(stand[60:])
    near = angles if stand.all() else angles[first + 1 : last]
    assume(len(near) > 2)
    motion = linkage.motion(near, 1.0)
    moved = np.abs(np.diff(motion.origin, axis=0)).max(axis=(1, 2))
    turned = np.abs(angle_difference(motion.angle[1:], motion.angle[:-1])).max(axis=1)
    fastest = np.abs(motion.origin_velocity).max(axis=(1, 2))
    spinning = np.abs(motion.angular_velocity).max(axis=1)
    for change, rate in ((moved, fastest), (turned, spinning)):
        assert np.all(change <= 2 * step * np.maximum(rate[1:], rate[:-1]) + 1e-9)


@pytest.mark.thorough
@settings(SLOW, max_examples=25)
@given(planar_linkages(most=2))
def test_newtons_method_finds_what_the_dyads_give(linkage):
    angles = linkage.drawn_angle + np.linspace(-0.2, 0.2, 9)
    angles = angles[linkage._assembly.assemblable(angles)]
    other = without_dyads(linkage)
    reached = other._assembly.assemblable(angles)
    # Newton's method stops at the first dead point, dyads stand beyond it as well.
    assert reached[np.argmin(np.abs(angles - linkage.drawn_angle))]
    motion, same = (each.motion(angles[reached], 2.0, 1.0) for each in (linkage, other))
    assume(np.abs(motion.angular_velocity).max() < 50)
    scale = 1 + np.abs(motion.angular_velocity).max()
    for name, power in (("origin", 1), ("origin_velocity", 3), ("origin_acceleration", 5)):
        apart = np.abs(getattr(motion, name) - getattr(same, name)).max()
        assert apart < 1e-10 * scale**power, name


KINDS_OF_STEPS = [
    ("TwoLoci", "Circle", "Circle"),
    ("TwoLoci", "Circle", "Line"),
    ("SlidingBody", "NoneType", "NoneType"),
]


@pytest.mark.parametrize("kind", KINDS_OF_STEPS)
def test_random_linkages_have_dyads_of_every_kind(kind: tuple[str, ...]) -> None:
    """The strategy above would test nothing if its linkages were all alike."""

    def has_it(linkage: PlanarLinkage) -> bool:
        return any(
            kind
            == (
                type(step).__name__,
                *(type(getattr(step, name, None)).__name__ for name in ("first", "second")),
            )
            for step in linkage._assembly.steps
        )

    looking = settings(max_examples=5000, database=None, phases=[Phase.generate])
    find(planar_linkages(), has_it, settings=looking)
