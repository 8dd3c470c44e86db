"""A seeded generator of mechanisms that run: planar linkages under loads, springs and dampers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexmech import (
    BeamSection,
    ConstantSpeed,
    Material,
    Mechanism,
    ReferenceEngine,
    natural_frequencies,
)
from flexmech.analyses import ResponseRequest
from flexmech.errors import InputError
from flexmech.linkages import (
    GROUND,
    AttachmentPoint,
    JointSpring,
    Linkage,
    Load,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    Spring,
)
from tests.support.random_mechanisms import log_uniform, random_crank_rocker

TURN = np.radians(np.arange(0.0, 360.0, 15.0))
# Bow of a link by the load or spring that acts on it, over the link's length.
LEAST_BOW, MOST_BOW = 1e-5, 1e-3


@dataclass(frozen=True)
class RandomRun:
    """A mechanism, and how it is to run."""

    seed: int
    mechanism: Mechanism
    request: ResponseRequest

    def __repr__(self) -> str:
        own, drive = self.mechanism, self.request.drive
        acting = [load.over for load in own.loads] + ["spring"] * len(own.springs)
        acting += ["hinge"] * len(own.joint_springs)
        return (
            f"seed {self.seed}: {'-'.join(link.name for link in own.linkage.topology.links)}, "
            f"{', '.join(acting)}; {drive.speed:.4g} rad/s, start {self.request.start}, run-up "
            f"{drive.run_up_time:.3g} s"
        )


def random_run(seed: int, revolutions: float = 0.1) -> RandomRun:
    """Draw a four-bar, slider-crank or six-bar with what acts on it, its speed and its start."""
    random = np.random.default_rng([seed, 13])
    linkage = random_linkage(random)
    links = {link.name: link for link in linkage.topology.links}
    common = log_uniform(random, 1e-5, 3e-4)
    sections = {}
    for name, link in links.items():
        material = Material(
            log_uniform(random, 3e9, 210e9),
            random.uniform(1200.0, 8000.0),
            random.uniform(0.2, 0.4),
        )
        thickness = link.length * log_uniform(random, 1 / 120, 1 / 25)
        section = BeamSection.rectangle(material, thickness, log_uniform(random, 5e-3, 40e-3))
        sections[name] = section.with_damping_time(common) if random.random() < 0.7 else section
    bare = Mechanism(
        linkage, sections, gravity=(0.0, -9.81) if random.random() < 0.5 else (0.0, 0.0)
    )
    engine = ReferenceEngine(bare, 4, "euler")
    slowest = natural_frequencies(engine, TURN, modes=1, prestress="none", rotation_terms=False)
    fastest = np.abs(linkage.motion(TURN, 1.0).angular_velocity).max()
    speed = float(random.uniform(0.02, 0.08) * 2 * np.pi * slowest.min() / fastest)
    period = 2 * np.pi / speed
    elastic = [link for link in links.values() if not link.rigid]
    # A clamped crank is the softest way to hold a force.
    softest = min(3 * sections[link.name].bending_stiffness / link.length**2 for link in elastic)

    def strength() -> float:
        """A force that bends the softest link as much as is wanted."""
        return softest * log_uniform(random, LEAST_BOW, MOST_BOW)

    def place() -> tuple[str, AttachmentPoint]:
        link = elastic[random.integers(len(elastic))]
        return link.name, AttachmentPoint(link.name, link.length * random.uniform(0.2, 0.9))

    loads = []
    for number in range(random.integers(0, 3)):
        name, point = place()
        over = str(random.choice(["constant", "crank_angle", "time"]))
        rows = 1 if over == "constant" else int(random.integers(2, 5))
        size = strength()
        force = size * random.uniform(-1, 1, (rows, 2))
        torque = 0.2 * size * links[name].length * random.uniform(-1, 1, rows)
        at: tuple[float, ...] = ()
        if over == "crank_angle":
            at = tuple(np.sort(random.uniform(0, 2 * np.pi, rows)).tolist())
            force[-1], torque[-1] = force[0], torque[0]
        if over == "time":
            at = tuple(np.sort(random.uniform(0, revolutions * period, rows)).tolist())
        loads.append(
            Load(
                f"load {number}",
                point,
                tuple(map(tuple, force.tolist())),
                tuple(torque.tolist()),
                str(random.choice(["ground", "link"])),
                over,
                at,
            )
        )
    springs = []
    if random.random() < 0.6:
        name, point = place()
        reach = links[name].length
        fixed = AttachmentPoint(GROUND, *(2 * reach * random.uniform(-1, 1, 2)).tolist())
        stiffness = strength() / reach
        damping = stiffness * log_uniform(random, 0.01, 0.3) / slowest.min()
        damping = float(damping) if random.random() < 0.6 else 0.0
        springs.append(Spring("spring", fixed, point, stiffness, reach, damping))
    hinges = []
    pins = [pin.joint for pin in linkage.topology.pins]
    if pins and random.random() < 0.4:
        link = elastic[random.integers(len(elastic))]
        stiffness = strength() * link.length
        joint, damped = str(random.choice(pins)), random.random() >= 0.4
        damping = float(stiffness * 0.02 / slowest.min()) if damped else 0.0
        hinges.append(JointSpring(joint, stiffness, damping))
    mechanism = replace(
        bare, loads=tuple(loads), springs=tuple(springs), joint_springs=tuple(hinges)
    )
    start = str(random.choice(["rigid", "equilibrium", "periodic"]))
    if start == "periodic" and any(load.over == "time" for load in loads):
        start = "equilibrium"
    run_up = period * random.uniform(0.02, 0.1) if start == "rigid" and random.random() < 0.6 else 0
    request = ResponseRequest(
        ConstantSpeed(speed, float(run_up), float(random.uniform(0, 2 * np.pi))),
        revolutions,
        720,
        start,
        modes=3,
    )
    return RandomRun(seed, mechanism, request)


def random_linkage(random: np.random.Generator) -> Linkage:
    """A crank-rocker, a slider-crank, or a crank-rocker that pushes a slider."""
    kind = random.choice(["four-bar", "slider-crank", "six-bar"])
    if kind == "four-bar":
        return random_crank_rocker(random)
    while True:
        try:
            linkage = _slider_crank(random) if kind == "slider-crank" else _six_bar(random)
            linkage.motion(TURN, 1.0)
        except InputError:
            continue
        return linkage


def _slider_crank(random: np.random.Generator) -> PlanarLinkage:
    crank = log_uniform(random, 0.05, 0.3)
    rod, offset = crank * random.uniform(2.0, 4.0), crank * random.uniform(-0.5, 0.5)
    points = {
        "O2": (0.0, 0.0),
        "A": (0.0, crank),
        "B": (float(np.sqrt(rod**2 - (crank - offset) ** 2)), offset),
    }
    links = (
        PlanarLink("crank", ("O2", "A"), bool(random.random() < 0.3)),
        PlanarLink("rod", ("A", "B")),
    )
    joints = (PlanarJoint("O2", "clamp"), PlanarJoint("B", "slider", (), 0.0))
    return PlanarLinkage(points, links, ("O2",), joints, np.pi / 2)


def _six_bar(random: np.random.Generator) -> PlanarLinkage:
    four = random_crank_rocker(random)
    motion = four.motion(np.zeros(1), 1.0)
    end = motion.position(1, four.lengths["coupler"])[0]
    rod = four.lengths["rocker"] * random.uniform(2.0, 3.0)
    slope = random.uniform(-0.4, 0.4)
    points = {
        "O2": (0.0, 0.0),
        "A": tuple(motion.position(1, 0.0)[0].tolist()),
        "B": tuple(end.tolist()),
        "O4": tuple(motion.position(2, 0.0)[0].tolist()),
        "D": (float(end[0] + rod * np.cos(slope)), float(end[1] + rod * np.sin(slope))),
    }
    links = (
        PlanarLink("crank", ("O2", "A")),
        PlanarLink("coupler", ("A", "B"), bool(random.random() < 0.2)),
        PlanarLink("rocker", ("O4", "B")),
        PlanarLink("rod", ("B", "D")),
    )
    joints = (PlanarJoint("O2", "clamp"), PlanarJoint("D", "slider", (), 0.0))
    return PlanarLinkage(points, links, ("O2", "O4"), joints, 0.0)
