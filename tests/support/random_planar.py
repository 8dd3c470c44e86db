"""Random planar linkages for hypothesis: a crank, and dyads of every kind on what moves already."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from flexmech.errors import InputError
from flexmech.linkages import PlanarJoint, PlanarLink, PlanarLinkage
from tests.support.strategies import numbers

DYADS = ("RRR", "RRP", "guided", "RPR", "ram", "weld")
# Least sine between the loci of a dyad where it is drawn.
LEAST_SINE = 0.35


@dataclass
class Growing:
    """A linkage that grows by dyads; ``bodies`` has the points of each body that moves."""

    points: dict[str, complex] = field(default_factory=dict)
    links: list[PlanarLink] = field(default_factory=list)
    joints: list[PlanarJoint] = field(default_factory=list)
    ground: list[str] = field(default_factory=list)

    def point(self, place: complex) -> str:
        """A new point, away from the others."""
        assume(all(abs(place - other) > 0.15 for other in self.points.values()))
        name = f"P{len(self.points)}"
        self.points[name] = place
        return name

    def link(self, *points: str, rigid: bool = False) -> str:
        name = f"link{len(self.links)}"
        self.links.append(PlanarLink(name, points, rigid))
        return name

    def on_ground(self, place: complex) -> str:
        name = self.point(place)
        self.ground.append(name)
        return name

    @property
    def moving(self) -> list[str]:
        """Points of links that do not stand still."""
        return [name for name in self.points if name not in self.ground]

    def linkage(self, drawn_at: float) -> PlanarLinkage:
        points = {name: (place.real, place.imag) for name, place in self.points.items()}
        return PlanarLinkage(
            points, tuple(self.links), tuple(self.ground), tuple(self.joints), drawn_at
        )


def places(size: float = 2.0) -> st.SearchStrategy[complex]:
    return st.builds(complex, numbers(-size, size), numbers(-size, size))


def sine(first: complex, second: complex) -> float:
    return abs((np.conj(first) * second).imag) / abs(first) / abs(second)


@st.composite
def grown(draw: st.DrawFn, most: int = 3, kinds: tuple[str, ...] = DYADS) -> Growing:
    """A crank of length 0.3 to 1 with one to three dyads, each on points that move."""
    made = Growing()
    shaft = made.on_ground(0j)
    tip = made.point(numbers_polar(draw, 0.3, 1.0))
    made.link(shaft, tip)
    made.joints.append(PlanarJoint(shaft, "clamp"))
    for _ in range(draw(st.integers(1, most))):
        add_dyad(draw, made, draw(st.sampled_from(kinds)))
    return made


def numbers_polar(draw: st.DrawFn, least: float, most: float) -> complex:
    return complex(draw(numbers(least, most)) * np.exp(1j * draw(numbers(-np.pi, np.pi))))


def add_dyad(draw: st.DrawFn, made: Growing, kind: str) -> None:
    start = draw(st.sampled_from(made.moving))
    place = made.points[start]
    if kind == "weld":
        link = next(link for link in made.links if start in link.points)
        assume(all(joint.point != start for joint in made.joints))
        arm = made.link(start, made.point(place + numbers_polar(draw, 0.3, 1.0)))
        made.joints.append(PlanarJoint(start, "weld", (link.name, arm)))
        return
    if kind == "RPR":
        assume(all(joint.point != start for joint in made.joints))
        pivot = made.on_ground(draw(places()))
        end = made.point(made.points[pivot] + numbers_polar(draw, 0.5, 1.5))
        guide = made.link(pivot, end, rigid=True)
        along = draw(numbers(-0.6, 0.6))
        axis = np.exp(1j * along) * (made.points[end] - made.points[pivot])
        arm = place - made.points[pivot]
        assume(abs((np.conj(axis) * arm).real) > LEAST_SINE * abs(axis) * abs(arm))
        made.joints.append(PlanarJoint(start, "slider", (), along, guide))
        return
    meeting = draw(places())
    assume(abs(meeting - place) > 0.4)
    joint = made.point(meeting)
    if kind == "RRR":
        other = draw(st.sampled_from(["ground", *made.moving]))
        far = made.on_ground(draw(places())) if other == "ground" else other
        assume(far != start)
        assume(abs(meeting - made.points[far]) > 0.4)
        assume(sine(meeting - place, meeting - made.points[far]) > LEAST_SINE)
        made.link(start, joint, rigid=draw(st.booleans()))
        # A chain of two beams, half of the time.
        bent = draw(st.booleans())
        between = [made.point((meeting + made.points[far]) / 2 + 0.2j)] if bent else []
        made.link(far, *between, joint)
        return
    made.link(start, joint)
    turn = draw(numbers(-np.pi, np.pi))
    if kind == "guided":
        guide = draw(st.sampled_from(made.links[:-1]))
        assume(joint not in guide.points and start not in guide.points)
        made.links[made.links.index(guide)] = PlanarLink(guide.name, guide.points, True)
        first, second = (made.points[name] for name in guide.points[:2])
        along = np.exp(1j * turn) * (second - first)
        made.joints.append(PlanarJoint(joint, "slider", (), turn, guide.name))
    else:
        along = np.exp(1j * turn)
        made.joints.append(PlanarJoint(joint, "slider", (), turn))
    # The line's normal against the arm.
    assume(sine(meeting - place, 1j * along) > LEAST_SINE)
    if kind == "ram":
        # A ram that two points of the same line guide.
        second = made.point(meeting + 0.7 * along / abs(along))
        made.link(joint, second)
        made.joints.append(PlanarJoint(second, "slider", (), turn))


@st.composite
def planar_linkages(draw: st.DrawFn, **options: object) -> PlanarLinkage:
    made = draw(grown(**options))  # type: ignore[arg-type]
    try:
        return made.linkage(draw(numbers(-np.pi, np.pi)))
    except InputError:
        assume(False)
        raise
