"""A seeded generator of slider-cranks and of six-bars after Watt and Stephenson.

Each seed is one mechanism, always the same. Hypothesis draws linkages of its own
(``tests/random_planar.py``); these run at speed, and their joints never come near a dead point.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from flexmech import (
    AttachedBody,
    BeamSection,
    Material,
    Mechanism,
    PointMass,
    ReferenceEngine,
    natural_frequencies,
)
from flexmech.errors import InputError
from flexmech.linkages import Link, PlanarJoint, PlanarLink, PlanarLinkage
from flexmech.mechanism import Provenance
from tests.support.random_mechanisms import log_uniform, random_crank_rocker

Kind = Literal["slider-crank", "watt", "stephenson"]
KINDS: tuple[Kind, ...] = get_args(Kind)
TURN = np.radians(np.arange(0.0, 360.0, 10.0))
# Least sine of the angle between a dyad's links, or between a rod and its line's normal.
LEAST_SINE = 0.4
# Greatest sag of links under their weight, roughly, over the shortest link's length.
MOST_SAG = 0.01
DrawnSection = Callable[[np.random.Generator, Link], BeamSection]


@dataclass(frozen=True)
class PlanarCase:
    """A mechanism, and a crank speed in rad/s that bends its links but does not buckle them."""

    seed: int
    mechanism: Mechanism
    crank_speed: float
    crank_angles: np.ndarray

    def __repr__(self) -> str:
        links = "-".join(link.name for link in self.mechanism.linkage.topology.links)
        return f"seed {self.seed}, {links}, {self.crank_speed:.4g} rad/s"


@dataclass
class Chain:
    """Points, links and joints of a drawing that grows."""

    points: dict[str, complex]
    links: list[PlanarLink]
    joints: list[PlanarJoint]
    ground: list[str]

    def linkage(self, drawn_at: float) -> PlanarLinkage:
        places = {name: (place.real, place.imag) for name, place in self.points.items()}
        return PlanarLinkage(
            places, tuple(self.links), tuple(self.ground), tuple(self.joints), drawn_at
        )


def strip(random: np.random.Generator, link: Link) -> BeamSection:
    """Section from soft polymer to steel, a 120th to a 25th of its length thick, damped."""
    material = Material(
        log_uniform(random, 3e9, 210e9), random.uniform(1200.0, 8000.0), random.uniform(0.2, 0.4)
    )
    section = BeamSection.rectangle(
        material,
        in_plane_thickness=link.length * log_uniform(random, 1 / 120, 1 / 25),
        out_of_plane_width=log_uniform(random, 5e-3, 40e-3),
    )
    return section.with_damping_time(log_uniform(random, 1e-5, 5e-4))


def planar_case(
    seed: int,
    kind: Kind,
    section: DrawnSection = strip,
    *,
    angles: int = 4,
    share: tuple[float, float] = (0.03, 0.1),
) -> PlanarCase:
    """Draw a linkage of a kind with sections, masses, weight, a speed and crank angles.

    Parameters
    ----------
    seed : int
    kind : {"slider-crank", "watt", "stephenson"}
    section : callable
        Draws that of an elastic link.
    angles : int
        Number of crank angles, at random places of the turn.
    share : tuple of float
        Least and greatest angular velocity of the fastest link over the slowest vibration.
    """
    random = np.random.default_rng([seed, KINDS.index(kind)])
    linkage = planar_linkage(random, kind)
    links = linkage.topology.links
    sections = {link.name: section(random, link) for link in links}
    weights = {link.name: sections[link.name].mass_per_length * link.length for link in links}
    masses = tuple(
        PointMass(link.name, link.length * random.uniform(0.1, 0.9), part * weights[link.name])
        for link in links
        for part in (log_uniform(random, 0.05, 1.0),)
        if random.random() < 0.4
    )
    bodies = tuple(
        AttachedBody(
            link.name,
            link.length * random.uniform(0.0, 1.0),
            mass := weights[link.name] * log_uniform(random, 0.05, 1.0),
            mass * (0.1 * link.length) ** 2 * random.uniform(0.0, 1.0),
            tuple((0.15 * link.length * random.uniform(-1, 1, 2)).tolist()),
        )
        for link in links
        if random.random() < 0.2
    )
    free = [name for name in linkage.points if name not in linkage.ground]
    typical = float(np.median(list(weights.values())))
    joints = {
        name: typical * log_uniform(random, 0.05, 1.0) for name in free if random.random() < 0.5
    }
    mechanism = Mechanism(
        linkage,
        sections,
        joint_masses=known_joints(linkage, joints),
        link_masses=masses,
        bodies=bodies,
        provenance=Provenance(f"random {kind} {seed}", "drawn at random"),
    )
    crank_angles = np.sort(random.uniform(0, 2 * np.pi, angles))
    lowest = slowest(mechanism)
    speed = random.uniform(*share) * lowest / fastest_link(linkage)
    if random.random() < 0.5:
        weight = min(9.81, MOST_SAG * lowest**2 * min(link.length for link in links))
        mechanism = replace(mechanism, gravity=(0.0, -weight))
    return PlanarCase(seed, mechanism, float(speed), crank_angles)


def known_joints(linkage: PlanarLinkage, masses: Mapping[str, float]) -> dict[str, float]:
    """Masses of those points that are joints of the topology."""
    return {name: mass for name, mass in masses.items() if name in linkage.topology.joint_names}


def slowest(mechanism: Mechanism) -> float:
    """Least first angular frequency at rest over the turn, rad/s."""
    engine = ReferenceEngine(mechanism, 4, "euler")
    frequency = natural_frequencies(
        engine, TURN[::3], modes=1, prestress="none", rotation_terms=False
    )
    return 2 * np.pi * float(frequency.min())


def fastest_link(linkage: PlanarLinkage) -> float:
    """Greatest angular velocity of a link over that of the crank."""
    return float(np.abs(linkage.motion(TURN, 1.0).angular_velocity).max())


def planar_linkage(random: np.random.Generator, kind: Kind) -> PlanarLinkage:
    """Draw until the crank turns fully and no dyad comes near a dead point."""
    while True:
        chain, drawn_at, dyads = (
            slider_crank(random) if kind == "slider-crank" else six_bar(random, kind)
        )
        if random.random() < 0.3:
            add_welded_arm(random, chain)
        try:
            linkage = chain.linkage(drawn_at)
            motion = linkage.motion(TURN, 1.0)
        except InputError:
            continue
        angle = dict(zip(linkage.topology.link_names, motion.angle.T, strict=True))
        angle |= {"": np.pi / 2, "output": angle.get("output", angle.get("output-2"))}
        meeting = [angle[first] - angle[last] for first, last in dyads]
        fastest = np.abs(motion.angular_velocity).max()
        least = min((np.abs(np.sin(one)).min() for one in meeting), default=1.0)
        if least > LEAST_SINE and fastest < 3:
            return linkage


# The chain, the crank angle at which it is drawn, and pairs of links that meet in a dyad; of a
# link whose end slides along the x axis the second one is empty.
Drawn = tuple[Chain, float, list[tuple[str, str]]]


def slider_crank(random: np.random.Generator) -> Drawn:
    """With a straight rod, or with one that bends at a weld."""
    crank = log_uniform(random, 0.05, 0.2)
    rod, offset = crank * random.uniform(2.2, 4.0), crank * random.uniform(-0.6, 0.6)
    tip = 1j * crank
    end = complex(np.sqrt(rod**2 - (crank - offset) ** 2), offset)
    chain = Chain(
        {"O2": 0j, "A": tip, "B": end},
        [
            PlanarLink("crank", ("O2", "A"), bool(random.random() < 0.2)),
            PlanarLink("rod", ("A", "B")),
        ],
        [PlanarJoint("O2", "clamp"), PlanarJoint("B", "slider", (), 0.0)],
        ["O2"],
    )
    dyads = [("rod", "")]
    if random.random() < 0.4:
        bend_at_weld(random, chain, "rod")
        dyads = []
    return chain, np.pi / 2, dyads


def six_bar(random: np.random.Generator, kind: Kind) -> Drawn:
    """A crank-rocker with a second dyad on its rocker (Watt) or its coupler (Stephenson)."""
    four, drawn_at = random_crank_rocker(random), random.uniform(0, 2 * np.pi)
    motion = four.motion(np.array([drawn_at]), 1.0)
    pivot = complex(four.ground, 0.0)
    first, second = (complex(*motion.position(1, x)[0]) for x in (0.0, four.coupler))
    chain = Chain(
        {"O2": 0j, "A": first, "B": second, "O4": pivot},
        [PlanarLink("crank", ("O2", "A"))],
        [PlanarJoint("O2", "clamp")],
        ["O2", "O4"],
    )
    turn = np.exp(1j * random.uniform(0.5, 2.5) * random.choice([-1, 1]))
    if kind == "watt":
        chain.points["C"] = pivot + (second - pivot) * turn * random.uniform(0.5, 1.2)
        chain.links += [PlanarLink("coupler", ("A", "B")), PlanarLink("rocker", ("B", "O4", "C"))]
        base = four.rocker
    else:
        chain.points["C"] = second + (first - second) * turn * random.uniform(0.3, 0.8)
        chain.links += [PlanarLink("coupler", ("A", "B", "C")), PlanarLink("rocker", ("O4", "B"))]
        base = four.coupler
    start, way = chain.points["C"], np.exp(2j * np.pi * random.random())
    meeting = start + base * random.uniform(0.7, 1.5) * way
    chain.points["D"] = complex(meeting)
    chain.links.append(PlanarLink("connector", ("C", "D")))
    if random.random() < 0.3:
        chain.joints.append(PlanarJoint("D", "slider", (), 0.0))
        return chain, drawn_at, [("connector", "")]
    side = np.exp(1j * random.uniform(1.0, 2.1) * random.choice([-1, 1]))
    chain.points["O6"] = complex(meeting - base * random.uniform(0.7, 1.5) * way * side)
    chain.links.append(PlanarLink("output", ("O6", "D")))
    chain.ground.append("O6")
    return chain, drawn_at, [("connector", "output")]


def bend_at_weld(random: np.random.Generator, chain: Chain, name: str) -> None:
    """Draw a link as two beams that are welded at an angle."""
    number = next(n for n, link in enumerate(chain.links) if link.name == name)
    start, end = chain.links[number].points
    way = chain.points[end] - chain.points[start]
    knee = random.uniform(0.35, 0.65) + 1j * random.uniform(-0.15, 0.15)
    chain.points["K"] = chain.points[start] + knee * way
    chain.links[number] = PlanarLink(name, (start, "K", end))


def add_welded_arm(random: np.random.Generator, chain: Chain) -> None:
    """A beam that is welded to the far end of the last link and carries what is there."""
    last = chain.links[-1]
    start, end = last.points[0], last.points[-1]
    way = chain.points[end] - chain.points[start]
    turn = np.exp(1j * random.uniform(0.4, 1.6) * random.choice([-1, 1]))
    chain.points["W"] = complex(chain.points[start] - way * turn * random.uniform(0.3, 0.6))
    if start in chain.ground:
        chain.links[-1] = PlanarLink(last.name, ("W", *last.points), last.rigid)
        return
    chain.links.append(PlanarLink("arm", (start, "W")))
    chain.joints.append(PlanarJoint(start, "weld", (last.name, "arm")))
