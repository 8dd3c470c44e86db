"""Ties of links in random topologies: what follows, its rates, and that the joints hold.

The links turn in a smooth motion that need not close: ties are linear in the coordinates at each
instant, whatever the rigid motion is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from flexmech.beams.elements import BEAM_SHAPES
from flexmech.beams.link_matrices import build_chain
from flexmech.errors import ComputationError
from flexmech.linear_system import LinkFrames, LinkModel, RotationTerms, rigid_link
from flexmech.linear_system.joints.rigid_coordinates import RigidCoordinates
from flexmech.linkages import (
    Clamp,
    Link,
    LinkEnd,
    LinkMass,
    Pin,
    Pivot,
    RigidMotion,
    Slider,
    Topology,
    Weld,
)
from flexmech.linkages.motion import direction, normal
from flexmech.materials import Material
from flexmech.sections import BeamSection

FloatArray = NDArray[np.float64]
SECTION = BeamSection.rectangle(Material(70e9, 2700.0), 4e-3, 20e-3)
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
STEP = 2e-3


@dataclass(frozen=True)
class Course:
    """Angles and places of links as smooth functions of time."""

    topology: Topology
    seed: int

    def at(self, time: float) -> RigidMotion:
        """Motion of one position at a time; a guided end stays on the line of its guide."""
        random = np.random.default_rng(self.seed)
        count = len(self.topology.links)
        mean, swing = random.uniform(-3, 3, count), random.uniform(-1, 1, count)
        rate, phase = random.uniform(0.3, 1.0, count), random.uniform(0, 6, count)
        turn = rate * time + phase
        angle = mean + swing * np.sin(turn)
        speed = swing * rate * np.cos(turn)
        change = -swing * rate**2 * np.sin(turn)
        place = random.uniform(-1, 1, (count, 2)) + random.uniform(-1, 1, (count, 2)) * time
        velocity = random.uniform(-1, 1, (count, 2))
        place = place + velocity * np.sin(time)
        # Velocities and accelerations of the origins: of a line and a sine.
        line = self._lines()
        motion = RigidMotion(
            np.zeros(1),
            np.ones(1),
            angle[None],
            speed[None],
            change[None],
            place[None],
            (line + velocity * np.cos(time))[None],
            (-velocity * np.sin(time))[None],
        )
        return self._guided(motion, time)

    def _lines(self) -> FloatArray:
        random = np.random.default_rng(self.seed)
        count = len(self.topology.links)
        random.uniform(size=4 * count), random.uniform(size=(count, 2))
        return random.uniform(-1, 1, (count, 2))

    def _guided(self, motion: RigidMotion, time: float) -> RigidMotion:
        for slider in self.topology.sliders:
            if not slider.guide:
                continue
            guide, held = (self.topology.index(n) for n in (slider.guide, slider.link_end.link))
            x = 0.0 if slider.link_end.end == "start" else self.topology.links[held].length
            angle = motion.angle[:, guide]
            omega, alpha = motion.angular_velocity[:, guide], motion.angular_acceleration[:, guide]
            d, s = slider.direction, 0.4 + 0.3 * np.sin(1.3 * time)
            ds, dds = 0.39 * np.cos(1.3 * time), -0.507 * np.sin(1.3 * time)
            along, across = direction(angle + d), normal(angle + d)
            lever = s * along + slider.offset * across
            quarter = s * across - slider.offset * along
            drift = ds * along + omega[:, None] * quarter
            pull = dds * along + 2 * omega[:, None] * ds * across
            pull = pull + alpha[:, None] * quarter - omega[:, None] ** 2 * lever
            places = [motion.origin, motion.origin_velocity, motion.origin_acceleration]
            points = [
                motion.position(held, x),
                motion.velocity(held, x),
                motion.acceleration(held, x),
            ]
            for values, point, own in zip(places, points, (lever, drift, pull), strict=True):
                values[:, guide] = point - own
        return motion


@st.composite
def topologies(draw: st.DrawFn) -> Topology:
    """Trees of links, some rigid, tied by pins and welds, held and guided here and there."""
    count = draw(st.integers(2, 5))
    links = tuple(Link(f"l{n}", 0.2 + 0.1 * n, draw(st.booleans())) for n in range(count))
    clamps, pivots, pins, welds, sliders = [], [], [], [], []
    first = LinkEnd("l0", "start")
    if draw(st.booleans()):
        clamps.append(Clamp("O", first))
    else:
        pivots.append(Pivot("O", first))
    free = [LinkEnd("l0", "end")]
    for n in range(1, count):
        leader = draw(st.sampled_from([LinkEnd(f"l{m}", "end") for m in range(n)]))
        kind = draw(st.sampled_from([Pin, Weld]))
        tie = kind(f"J{n}", leader, LinkEnd(f"l{n}", "start"))
        (pins if kind is Pin else welds).append(tie)
        free.append(LinkEnd(f"l{n}", "end"))
    tips = [end for end in free if end not in {t.leader for t in (*pins, *welds)}]
    for tip in tips:
        kind = draw(st.sampled_from(["free", "free", "pivot", "ground", "guide"]))
        guides = [link.name for link in links if link.rigid and link.name != tip.link]
        if kind == "pivot":
            pivots.append(Pivot(f"P{tip.link}", tip))
        elif kind == "ground" or (kind == "guide" and not guides):
            sliders.append(Slider(f"S{tip.link}", tip, draw(st.floats(-3, 3))))
        elif kind == "guide" and not any(s.guide for s in sliders):
            guide, offset = draw(st.sampled_from(guides)), draw(st.floats(-0.1, 0.1))
            sliders.append(Slider(f"S{tip.link}", tip, draw(st.floats(-3, 3)), offset, guide))
    return Topology(links, *map(tuple, (clamps, pivots, pins, welds, sliders)))


def models(topology: Topology, element: str = "euler") -> list[LinkModel]:
    """Rigid links and chains of one element."""
    return [
        rigid_link(link.name, LinkMass(link.length, SECTION.mass_per_length))
        if link.rigid
        else build_chain(
            link.name,
            SECTION,
            LinkMass(link.length, SECTION.mass_per_length),
            1,
            BEAM_SHAPES[element],
        ).model
        for link in topology.links
    ]


def well_posed(topology: Topology, course: Course) -> bool:
    """Whether the rigid links are not near a locked position, where everything is large."""
    rigid = RigidCoordinates(topology)
    moved = rigid.dependence(course.at(0.0)).value
    return bool(np.abs(moved).max(initial=0.0) < 30)


@settings(max_examples=150, deadline=None)
@given(topologies(), st.integers(0, 10_000), st.sampled_from(["euler", "timoshenko", "reddy"]))
def test_rates_of_what_follows_are_derivatives(topology: Topology, seed: int, element: str) -> None:
    course = Course(topology, seed)
    if not well_posed(topology, course):
        return
    frames = LinkFrames(topology, models(topology, element))
    path = [
        frames.link_coordinates(course.at(n * STEP), np.eye(frames.size)[None])
        for n in range(-4, 5)
    ]
    unit, still = np.eye(frames.size), np.zeros((frames.size, frames.size))
    now = course.at(0.0)
    many = now.at(np.zeros(frames.size, dtype=int))
    exact = frames.link_motion(many, unit, still, still)
    for number, (place, rate, change) in enumerate(exact):
        steps = np.stack([q[number][0] for q in path])
        first, second = (np.einsum("k,kij->ij", w, steps) for w in (FIRST, SECOND))
        scale = max(1.0, np.abs(steps).max(initial=0.0)) ** 3
        np.testing.assert_allclose(place.T, steps[4], atol=1e-12 * scale)
        np.testing.assert_allclose(rate.T, first / STEP, atol=1e-8 * scale)
        np.testing.assert_allclose(change.T, second / STEP**2, atol=1e-5 * scale)


def ground_displacement(
    topology: Topology, models: list[LinkModel], motion: RigidMotion, moved: list[FloatArray]
) -> dict[LinkEnd, FloatArray]:
    """Displacement of all link ends in ground axes, (2, n)."""
    found = {}
    for number, (link, model) in enumerate(zip(topology.links, models, strict=True)):
        turn = np.stack([direction(motion.angle[0, number]), normal(motion.angle[0, number])], 1)
        for end, fraction in (("start", 0.0), ("end", 1.0)):
            shape = model.readings.displacement_at(np.array([fraction]))[0]
            found[LinkEnd(link.name, end)] = turn @ shape @ moved[number][0]
    return found


@settings(max_examples=100, deadline=None)
@given(topologies(), st.integers(0, 10_000), st.sampled_from(["euler", "timoshenko", "reddy"]))
def test_the_joints_hold_and_nothing_else_is_lost(
    topology: Topology, seed: int, element: str
) -> None:
    course = Course(topology, seed)
    if not well_posed(topology, course):
        return
    links = models(topology, element)
    frames, motion = LinkFrames(topology, links), course.at(0.0)
    moved = frames.link_coordinates(motion, np.eye(frames.size)[None])
    ends = ground_displacement(topology, links, motion, moved)
    scale = max(1.0, max(np.abs(q).max(initial=0.0) for q in moved))
    conditions = 0
    for tie in topology.ties:
        np.testing.assert_allclose(ends[tie.leader], ends[tie.follower], atol=1e-10 * scale)
        conditions += 2
    for own in (*topology.clamps, *topology.pivots):
        assert np.abs(ends[own.link_end]).max(initial=0.0) < 1e-10 * scale
        conditions += 2
    for weld in topology.welds:
        turns = []
        for place in (weld.leader, weld.follower):
            number = topology.index(place.link)
            turns += list(moved[number][0][links[number].end_rotation_of(place.end)])
        for turn in turns[1:]:
            np.testing.assert_allclose(turn, turns[0], atol=1e-10 * scale)
    # Independent: no combination of them leaves all links where they are.
    every = np.concatenate([q[0] for q in moved])
    lines = _on_lines(topology, motion, ends, scale)
    assert np.linalg.matrix_rank(every, tol=1e-9) == frames.size
    if element == "euler" and _is_tree(topology):
        free = sum(link.size for link in links)
        welded = len(topology.welds) + len(topology.clamps)
        assert frames.size == free - conditions - welded - lines


def _is_tree(topology: Topology) -> bool:
    """Whether conditions are independent of each other: few enough ends are held."""
    holders = len(topology.pivots) + len(topology.sliders) + len(topology.clamps)
    return holders == 1 or not any(link.rigid for link in topology.links)


def _on_lines(
    topology: Topology, motion: RigidMotion, ends: dict[LinkEnd, FloatArray], scale: float
) -> int:
    """Check that guided ends stay on lines of the ground; how many sliders there are."""
    for slider in topology.sliders:
        if not slider.guide:
            off = np.array([-np.sin(slider.direction), np.cos(slider.direction)])
            assert np.abs(off @ ends[slider.link_end]).max(initial=0.0) < 1e-10 * scale
    return len(topology.sliders)


@settings(max_examples=60, deadline=None)
@given(topologies(), st.integers(0, 10_000))
def test_without_damping_c_is_the_rate_of_m_plus_a_skew_part(topology: Topology, seed: int) -> None:
    course = Course(topology, seed)
    if not well_posed(topology, course):
        return
    links = models(topology)
    frames = LinkFrames(topology, links)
    nothing = [np.zeros_like(link.stiffness) for link in links]
    path = [frames.assemble(course.at(n * STEP), nothing, RotationTerms()) for n in range(-4, 5)]
    rate = np.einsum("k,kij->ij", FIRST, np.stack([m.mass[0] for m in path])) / STEP
    rest = path[4].damping[0] - rate
    scale = np.abs(path[4].damping).max(initial=0.0) + np.abs(path[4].mass).max(initial=0.0)
    assert np.abs(rest + rest.T).max(initial=0.0) <= 1e-7 * scale


def test_gathered_forces_do_the_work_of_the_links_own() -> None:
    topology = Topology(
        (Link("a", 0.3), Link("b", 0.4, rigid=True), Link("c", 0.5)),
        clamps=(Clamp("O", LinkEnd("a", "start")),),
        welds=(Weld("A", LinkEnd("a", "end"), LinkEnd("b", "start")),),
        pins=(Pin("B", LinkEnd("b", "end"), LinkEnd("c", "start")),),
        sliders=(Slider("C", LinkEnd("c", "end"), 0.3),),
    )
    links = models(topology, "reddy")
    frames, motion = LinkFrames(topology, links), Course(topology, 3).at(0.2)
    random = np.random.default_rng(0)
    loads = [random.normal(size=(1, link.size)) for link in links]
    z = random.normal(size=(1, frames.size, 1))
    own = sum(
        float(f[0] @ q[0, :, 0])
        for f, q in zip(loads, frames.link_coordinates(motion, z), strict=True)
    )
    assert frames.gather(motion, loads)[0] @ z[0, :, 0] == pytest.approx(own, rel=1e-12)


def test_rigid_links_that_lock_are_refused() -> None:
    """A slider-crank whose rod stands across the line."""
    topology = Topology(
        tuple(Link(name, 0.3, rigid=True) for name in "ab"),
        pivots=(Pivot("O", LinkEnd("a", "start")),),
        pins=(Pin("A", LinkEnd("a", "end"), LinkEnd("b", "start")),),
        sliders=(Slider("B", LinkEnd("b", "end"), 0.0),),
    )
    frames = LinkFrames(topology, models(topology))
    assert frames.size == 1
    motion = Course(topology, 0).at(0.0)
    across = replace(motion, angle=np.array([[0.3, np.pi / 2]]))
    place = r"rigid links \(a, b\) and lines lock.*crank angle 0 deg"
    with pytest.raises(ComputationError, match=place):
        frames.link_coordinates(across, np.zeros((1, 1, 1)))
