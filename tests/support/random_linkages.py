"""Random linkages at one posture, of cranks, dyads, welds, sliders and slotted links.

The joints are drawn where they are, so that every loop closes; velocities and accelerations
follow from the connections alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from flexmech.linkages import (
    GROUND,
    AttachmentPoint,
    Clamp,
    JointSpring,
    Link,
    LinkBody,
    LinkEnd,
    LinkMass,
    Load,
    Pin,
    Pivot,
    RigidMotion,
    Slider,
    Spring,
    Topology,
    Weld,
)
from tests.support.strategies import numbers

KINDS = ("dyad", "slider", "guided", "weld", "slotted")


@dataclass
class Drawing:
    """Links by the places of their ends, and how they are joined."""

    ends: dict[str, tuple[complex, complex]]
    rigid: set[str] = field(default_factory=set)
    clamps: list[Clamp] = field(default_factory=list)
    pivots: list[Pivot] = field(default_factory=list)
    pins: list[Pin] = field(default_factory=list)
    welds: list[Weld] = field(default_factory=list)
    sliders: list[Slider] = field(default_factory=list)

    def at(self, place: LinkEnd) -> complex:
        return self.ends[place.link][0 if place.end == "start" else 1]

    def angle(self, link: str) -> float:
        start, end = self.ends[link]
        return float(np.angle(end - start))

    def add(self, start: complex, end: complex, rigid: bool = False) -> str:
        name = f"link{len(self.ends)}"
        assume(abs(end - start) > 0.1)
        self.ends[name] = (start, end)
        if rigid:
            self.rigid.add(name)
        return name

    def slide(self, held: LinkEnd, direction: float, guide: str = "") -> None:
        """A line through the held end in a direction of the ground's or the guide's axes."""
        place = self.at(held)
        if guide:
            place = (place - self.ends[guide][0]) * np.exp(-1j * self.angle(guide))
        offset = float(np.imag(place * np.exp(-1j * direction)))
        joint = f"S{len(self.sliders)}"
        self.sliders.append(Slider(joint, held, direction, offset, guide))

    @property
    def topology(self) -> Topology:
        links = [
            Link(name, abs(end - start), name in self.rigid)
            for name, (start, end) in self.ends.items()
        ]
        return Topology(
            tuple(links),
            tuple(self.clamps),
            tuple(self.pivots),
            tuple(self.pins),
            tuple(self.welds),
            tuple(self.sliders),
        )


@dataclass(frozen=True)
class LoadedLinkage:
    """A linkage in motion with all that acts on it."""

    topology: Topology
    motion: RigidMotion
    masses: tuple[LinkMass, ...]
    loads: tuple[Load, ...]
    springs: tuple[Spring, ...]
    joint_springs: tuple[JointSpring, ...]


def points() -> st.SearchStrategy[complex]:
    return st.builds(complex, numbers(-1, 1), numbers(-1, 1))


@st.composite
def drawings(draw: st.DrawFn) -> Drawing:
    tip, hub = draw(points()), draw(st.sampled_from((0.0, 0.2)))
    assume(abs(tip) > 0.3)
    drawing = Drawing({"crank": (hub * tip / abs(tip), tip)})
    drawing.clamps.append(Clamp("O2", LinkEnd("crank", "start"), hub))
    free = [LinkEnd("crank", "end")]
    for kind in draw(st.lists(st.sampled_from(KINDS), min_size=1, max_size=4)):
        leader = draw(st.sampled_from(free))
        middle, far = draw(points()), draw(points())
        start = drawing.at(leader)
        number = len(drawing.ends)
        guides = sorted(drawing.rigid - {leader.link})
        if kind == "slotted":
            # The point slides on a rigid link that a pivot holds.
            if any(slider.link_end == leader for slider in drawing.sliders):
                continue
            if any(tie.follower == leader for tie in (*drawing.pins, *drawing.welds)):
                continue
            slot = drawing.add(far, middle, rigid=True)
            drawing.pivots.append(Pivot(f"G{number}", LinkEnd(slot, "start")))
            drawing.slide(leader, draw(numbers(-3, 3)), slot)
            free.append(LinkEnd(slot, "end"))
            continue
        first = drawing.add(start, middle, rigid=draw(st.booleans()))
        own = LinkEnd(first, "start"), LinkEnd(first, "end")
        if kind == "weld":
            drawing.welds.append(Weld(f"W{number}", leader, own[0]))
            free.append(own[1])
            continue
        drawing.pins.append(Pin(f"P{number}", leader, own[0]))
        if kind == "slider" or (kind == "guided" and not guides):
            drawing.slide(own[1], draw(numbers(-3, 3)))
        elif kind == "guided":
            drawing.slide(own[1], draw(numbers(-3, 3)), draw(st.sampled_from(guides)))
        else:
            second = drawing.add(far, middle, rigid=draw(st.booleans()))
            drawing.pins.append(Pin(f"Q{number}", own[1], LinkEnd(second, "end")))
            drawing.pivots.append(Pivot(f"G{number}", LinkEnd(second, "start")))
        free.append(own[1])
    return drawing


def moving(drawing: Drawing, speed: float, acceleration: float) -> RigidMotion:
    """Velocities and accelerations that the connections allow; complex numbers are vectors."""
    topology = drawing.topology
    names = topology.link_names
    size = 3 * len(names)
    rows: list[np.ndarray] = []
    # Right sides for velocity, and for acceleration once the velocities are known.
    sides: list[list[object]] = []

    def place(end: LinkEnd) -> tuple[np.ndarray, int, complex]:
        """Velocity of an end by the links' velocities; shape (2, size)."""
        link = names.index(end.link)
        return at_point(link, drawing.at(end) - drawing.ends[end.link][0])

    def at_point(link: int, arm: complex) -> tuple[np.ndarray, int, complex]:
        row = np.zeros((2, size))
        row[0, 3 * link], row[1, 3 * link + 1] = 1.0, 1.0
        row[:, 3 * link + 2] = -arm.imag, arm.real
        return row, link, arm

    def turning(link: int) -> np.ndarray:
        row = np.zeros((1, size))
        row[0, 3 * link + 2] = 1.0
        return row

    def fall(link: int, arm: complex, omega: np.ndarray) -> np.ndarray:
        """Part of a point's acceleration that goes with the square of the velocity."""
        return -(omega[link] ** 2) * np.array([arm.real, arm.imag])

    def add(row: np.ndarray, velocity: object, rest: object) -> None:
        rows.append(row)
        sides.append([velocity, rest])

    crank = drawing.ends["crank"][0]
    for clamp in drawing.clamps:
        row, link, _ = place(clamp.link_end)
        spin = np.array([-crank.imag, crank.real])
        inward = np.array([crank.real, crank.imag])
        add(row, speed * spin, lambda q, s=spin, i=inward: acceleration * s - speed**2 * i)
        add(turning(link), [speed], lambda q: np.array([acceleration]))
    for pivot in drawing.pivots:
        add(place(pivot.link_end)[0], np.zeros(2), lambda q: np.zeros(2))
    for tie in (*drawing.pins, *drawing.welds):
        (after, second, arm2), (before, first, arm1) = place(tie.follower), place(tie.leader)
        add(
            after - before,
            np.zeros(2),
            lambda q, a=first, b=second, c=arm1, d=arm2: fall(a, c, q[2::3]) - fall(b, d, q[2::3]),
        )
        if isinstance(tie, Weld):
            add(turning(second) - turning(first), np.zeros(1), lambda q: np.zeros(1))
    for slider in drawing.sliders:
        row, link, arm = place(slider.link_end)
        angle = slider.direction
        if not slider.guide:
            across = np.array([-np.sin(angle), np.cos(angle)])
            add(
                (across @ row)[None],
                np.zeros(1),
                lambda q, n=across, b=link, d=arm: -np.array([n @ fall(b, d, q[2::3])]),
            )
            continue
        guide = names.index(slider.guide)
        angle += drawing.angle(slider.guide)
        across = np.array([-np.sin(angle), np.cos(angle)])
        along = np.array([np.cos(angle), np.sin(angle)])
        lever = drawing.at(slider.link_end) - drawing.ends[slider.guide][0]
        under, _, _ = at_point(guide, lever)

        def coriolis(q, n=across, t=along, r=row - under, b=link, d=arm, g=guide, e=lever):
            omega = q[2::3]
            return np.array(
                [n @ (fall(g, e, omega) - fall(b, d, omega)) + 2 * omega[g] * (t @ (r @ q))]
            )

        add((across @ (row - under))[None], np.zeros(1), coriolis)
    matrix = np.concatenate(rows)
    assume(matrix.shape == (size, size) and np.linalg.cond(matrix) < 100)
    q = np.linalg.solve(matrix, np.concatenate([np.asarray(side[0]) for side in sides]))
    rate = np.linalg.solve(matrix, np.concatenate([side[1](q) for side in sides]))
    start = np.array([drawing.ends[name][0] for name in names])
    return RigidMotion(
        crank_angle=np.asarray(drawing.angle("crank")),
        crank_speed=np.asarray(speed),
        angle=np.array([drawing.angle(name) for name in names]),
        angular_velocity=q[2::3],
        angular_acceleration=rate[2::3],
        origin=np.stack([start.real, start.imag], axis=-1),
        origin_velocity=q.reshape(-1, 3)[:, :2],
        origin_acceleration=rate.reshape(-1, 3)[:, :2],
    )


@st.composite
def link_masses(draw: st.DrawFn, length: float) -> LinkMass:
    places = draw(st.lists(numbers(0, 1), max_size=2))
    bodies = [
        LinkBody(
            draw(numbers(0, 1)) * length,
            draw(numbers(0, 2)),
            draw(numbers(0, 0.1)),
            (draw(numbers(-0.2, 0.2)), draw(numbers(-0.2, 0.2))),
        )
        for _ in range(draw(st.integers(0, 2)))
    ]
    return LinkMass(
        length,
        draw(st.sampled_from((0.0, 0.7))),
        tuple(length * place for place in places),
        tuple(draw(numbers(0, 2)) for _ in places),
        draw(st.sampled_from((0.0, 0.05))),
        tuple(bodies),
    )


@st.composite
def loaded_linkages(draw: st.DrawFn) -> LoadedLinkage:
    drawing = draw(drawings())
    topology = drawing.topology
    speed = draw(numbers(1, 10)) * draw(st.sampled_from((-1, 1)))
    motion = moving(drawing, speed, draw(numbers(-50, 50)))
    lengths = {link.name: link.length for link in topology.links}

    def on_link() -> AttachmentPoint:
        name = draw(st.sampled_from(topology.link_names))
        return AttachmentPoint(name, draw(numbers(0, 1)) * lengths[name])

    loads = [
        Load(
            f"load{number}",
            on_link(),
            ((draw(numbers(-50, 50)), draw(numbers(-50, 50))),),
            (draw(numbers(-5, 5)),),
            draw(st.sampled_from(("ground", "link"))),
        )
        for number in range(draw(st.integers(0, 2)))
    ]
    springs = []
    for number in range(draw(st.integers(0, 2))):
        first, second = on_link(), draw(st.sampled_from((None, on_link())))
        second = second or AttachmentPoint(GROUND, draw(numbers(-1, 1)), draw(numbers(-1, 1)))
        places = [
            motion.position(topology.index(point.link), point.x)
            if point.link != GROUND
            else np.array([point.x, point.y])
            for point in (first, second)
        ]
        if first.link != second.link and np.linalg.norm(places[1] - places[0]) > 0.05:
            factors = [draw(numbers(0, most)) for most in (500, 0.5, 5)]
            springs.append(Spring(f"spring{number}", first, second, *factors))
    joints = [joint.joint for joint in (*topology.pins, *topology.pivots)]
    chosen = draw(st.lists(st.sampled_from(joints), unique=True, max_size=2)) if joints else []
    turning = [
        JointSpring(joint, draw(numbers(0, 20)), draw(numbers(0, 1)), draw(numbers(-3, 3)))
        for joint in chosen
    ]
    return LoadedLinkage(
        topology,
        motion,
        tuple(draw(link_masses(length)) for length in lengths.values()),
        tuple(loads),
        tuple(springs),
        tuple(turning),
    )
