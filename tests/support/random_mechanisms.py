"""A seeded generator of random crank-rockers with all that a model file can say of them.

Each seed is one mechanism, always the same: a test that fails names it, and the next run has it
again. Hypothesis draws its own and shrinks them (``tests/strategies.py``); these are for checks
whose answer is worth comparing over a fixed population, such as "95 of 100 estimates".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech import FourBar, Material, Mechanism, PointMass, ReferenceEngine, natural_frequencies
from flexmech.mechanism import Provenance
from flexmech.sections import BeamSection

LINKS = ("crank", "coupler", "rocker")
# Where the transmission angle nears 0 or 180 degrees, forces and their errors have no bound.
LEAST_SINE_OF_TRANSMISSION = 0.35


@dataclass(frozen=True)
class RandomCase:
    """A mechanism, and a crank speed in rad/s that bends its links but does not buckle them."""

    seed: int
    mechanism: Mechanism
    crank_speed: float
    crank_angles: np.ndarray

    def __repr__(self) -> str:
        return f"seed {self.seed}, {self.crank_speed:.4g} rad/s"


def random_case(
    seed: int, *, damped: bool = False, angles: int = 4, thickness: float = 1.0
) -> RandomCase:
    """Draw a crank-rocker from soft polymers to steel, with point masses on links and joints.

    Parameters
    ----------
    seed : int
    damped : bool
        Whether links have Kelvin-Voigt times, from 10 microseconds to half a millisecond.
    angles : int
        Number of crank angles, at random places of the turn.
    thickness : float
        Multiplies that of links, from 1/150 to 1/20 of their lengths.
    """
    random = np.random.default_rng(seed)
    linkage = random_crank_rocker(random)
    common = log_uniform(random, 1e-5, 5e-4)
    sections, masses = {}, []
    for link in LINKS:
        length = linkage.lengths[link]
        material = Material(
            log_uniform(random, 3e9, 210e9),
            random.uniform(1200.0, 8000.0),
            random.uniform(0.2, 0.4),
        )
        section = BeamSection.rectangle(
            material,
            in_plane_thickness=thickness * length * log_uniform(random, 1 / 150, 1 / 20),
            out_of_plane_width=log_uniform(random, 3e-3, 60e-3),
        )
        if damped:
            time = common if random.random() < 0.5 else log_uniform(random, 1e-5, 5e-4)
            section = section.with_damping_time(time)
        sections[link] = section
        mass = section.mass_per_length * length
        masses += [
            PointMass(link, length * random.uniform(0.1, 0.9), mass * log_uniform(random, 0.05, 1))
            for _ in range(random.integers(0, 3))
        ]
    joints = {
        joint: log_uniform(random, 1e-3, 0.1) for joint in ("A", "B") if random.random() < 0.5
    }
    mechanism = Mechanism(
        linkage,
        sections,
        joint_masses=joints,
        link_masses=tuple(masses),
        provenance=Provenance(f"random crank-rocker {seed}", "drawn at random"),
    )
    crank_angles = np.sort(random.uniform(0, 2 * np.pi, angles))
    speed = random.uniform(0.03, 0.12) * slowest(mechanism) / fastest_link(linkage)
    return RandomCase(seed, mechanism, float(speed), crank_angles)


def random_crank_rocker(random: np.random.Generator) -> FourBar:
    """Draw one whose crank turns fully and whose transmission angle stays useful."""
    while True:
        size = log_uniform(random, 0.1, 0.5)
        ground, crank, coupler, rocker = (size * random.uniform(0.2, 1.0, 4)).tolist()
        branch = "open" if random.random() < 0.5 else "crossed"
        shortest, *middle, longest = sorted((ground, crank, coupler, rocker))
        if crank > shortest or shortest + longest > 0.95 * sum(middle):
            continue
        linkage = FourBar(ground, crank, coupler, rocker, branch)
        turn = np.radians(np.arange(0, 360, 5))
        if np.sin(linkage.transmission_angle(turn)).min() >= LEAST_SINE_OF_TRANSMISSION:
            return linkage


def log_uniform(random: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def slowest(mechanism: Mechanism) -> float:
    """Least first angular frequency at rest over the turn, rad/s."""
    engine = ReferenceEngine(mechanism, 4, "euler")
    turn = np.radians(np.arange(0, 360, 30))
    frequency = natural_frequencies(engine, turn, modes=1, prestress="none", rotation_terms=False)
    return 2 * np.pi * float(frequency.min())


def fastest_link(linkage: FourBar) -> float:
    """Greatest angular velocity of a link over that of the crank."""
    turn = np.radians(np.arange(0, 360, 5))
    return float(np.abs(linkage.motion(turn, 1.0).angular_velocity).max())
