"""A disk on a turning shaft of unequal stiffness, seen along its axis (H. H. Jeffcott 1919).

A light arm turns with the shaft and carries the disk: it bends in one direction of the turning
frame and stretches in the other. Without damping the disk's whirl grows between the two critical
speeds ``sqrt(k / m)`` (D. M. Smith, Proc. Royal Society A 142 (1933) 92-118). Damping of the shaft
itself makes it whirl above the critical speed of a round shaft, and damping of the ground puts that
off (A. L. Kimball, Physical Review 21 (1923) 703; F. M. Dimentberg, Flexural Vibrations of Rotating
Shafts, 1961).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from flexmech import (
    AttachedBody,
    BeamSection,
    ExudynEngine,
    JointSpring,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
    stability,
)
from tests.support.random_mechanisms import log_uniform
from tests.support.running_modes import ArmInBearing

# Part of the disk's mass that the arm adds.
LIGHT = 1e-7
# Error of an exponent over the critical speeds: the arm's mass, round-off of stiff directions.
SAME = 1e-6
ENGINES: list[tuple[Any, str]] = [(ReferenceEngine, "euler"), (ExudynEngine, "ancf")]


@dataclass(frozen=True)
class Shaft:
    """A disk on a shaft.

    Parameters
    ----------
    mass, length : float
        Of the disk; of the arm, which does not matter.
    along, across : float
        Stiffness in the directions of the turning frame, N/m.
    time : float
        Kelvin-Voigt time of the shaft in s.
    bearing, damping : float
        Of the ground, in all directions: stiffness in N/m and damping in N s/m.
    """

    mass: float
    length: float
    along: float
    across: float
    time: float = 0.0
    bearing: float = 0.0
    damping: float = 0.0

    @property
    def critical_speeds(self) -> tuple[float, float]:
        """Without the ground's stiffness, the lower one first; rad/s."""
        first, last = np.sqrt(np.sort([self.along, self.across]) / self.mass).tolist()
        return first, last

    def polynomials(self, speed: float) -> list[list[np.poly1d]]:
        """Rows of the equations in the turning frame, each entry by the exponent."""
        m, turn = self.mass, np.poly1d([2 * self.mass * speed, self.damping * speed])
        still = [
            np.poly1d([m, self.time * k + self.damping, k + self.bearing - m * speed**2])
            for k in (self.along, self.across)
        ]
        return [[still[0], -turn], [turn, still[1]]]

    def exponents(self, speed: float) -> np.ndarray:
        """The four of the turning frame, in 1/s."""
        (a, b), (c, d) = self.polynomials(speed)
        return np.asarray((a * d - b * c).roots)

    def mechanism(self) -> Mechanism:
        section = BeamSection(
            axial_stiffness=self.along * self.length,
            bending_stiffness=self.across * self.length**3 / 3,
            shear_stiffness=1e3 * self.along * self.length,
            mass_per_length=LIGHT * self.mass / self.length,
            rotary_inertia=LIGHT**2,
            in_plane_thickness=self.length / 20,
        )
        disk = {"link": "arm", "position": self.length, "mass": self.mass}
        if self.bearing:
            # Where no stress counts, the disk may be anywhere.
            joint = JointSpring(
                "bearing", radial_stiffness=self.bearing, radial_damping=self.damping
            )
            return Mechanism(
                ArmInBearing(self.length),
                {"arm": section.with_damping_time(self.time)},
                bodies=(AttachedBody(**disk),),
                joint_springs=(joint,),
            )
        # The disk is on the axis, where nothing pulls it: a force there moves it as the tip would
        # move under the same force.
        body = AttachedBody(**disk, offset=(-self.length, 0.0))
        if self.time:
            section = section.with_damping_time(self.time)
        return Mechanism(RotatingArm(self.length), {"arm": section}, bodies=(body,))


def drawn(seed: int) -> Shaft:
    random = np.random.default_rng([seed, 17])
    mass, first = log_uniform(random, 0.1, 10.0), log_uniform(random, 10.0, 500.0)
    stiffness = mass * first**2 * np.array([1.0, log_uniform(random, 1.1, 3.0)])
    along, across = random.permutation(stiffness).tolist()
    return Shaft(mass, log_uniform(random, 0.05, 0.5), along, across)


def found(engine: Any, speed: float) -> np.ndarray:
    """Floquet exponents, whose imaginary parts are known but for whole turns."""
    data = stability(engine, [speed], prestress="none", modes=2).dataset.isel(engine=0)
    turned = data["log_modulus"].values[0] + 1j * data["angle"].values[0]
    return np.asarray(turned * speed / (2 * np.pi))


def apart(first: np.ndarray, second: np.ndarray, speed: float) -> float:
    """Greatest distance of an exponent from the nearest other one, whole turns left out."""
    gap = first[:, None] - second
    turned = gap.imag - speed * np.round(gap.imag / speed)
    distance = np.hypot(gap.real, turned)
    return float(max(distance.min(axis=0).max(), distance.min(axis=1).max()))


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("seed", "kind", "element"),
    [
        (0, ReferenceEngine, "euler"),
        *(pytest.param(seed, *ENGINES[seed % 2], marks=pytest.mark.thorough) for seed in (1, 2)),
        pytest.param(0, ExudynEngine, "ancf", marks=pytest.mark.thorough),
    ],
)
def test_a_disk_whirls_between_its_critical_speeds_alone(
    seed: int, kind: Any, element: str
) -> None:
    shaft = drawn(seed)
    engine = kind(shaft.mechanism(), 2, element)
    first, last = shaft.critical_speeds
    for speed in (1.001 * last,):
        own = found(engine, speed)
        assert apart(own, shaft.exponents(speed), speed) < 10 * SAME * last
        assert own.real.max() < SAME * last
    for speed in (1.001 * first, np.sqrt(first * last)):
        own, expected = found(engine, speed), shaft.exponents(speed)
        assert own.real.max() == pytest.approx(expected.real.max(), rel=2e-3)
        assert apart(own, expected, speed) < 1e-4 * last


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_the_map_finds_the_critical_speeds(seed: int) -> None:
    shaft = drawn(seed)
    first, last = shaft.critical_speeds
    speeds = np.linspace(0.9 * first, 1.1 * last, 9)
    engine = ReferenceEngine(shaft.mechanism(), 2, "euler")
    bands = stability(engine, speeds, prestress="axial", modes=2).dataset
    edges = [float(bands[f"band_{edge}"][0]) for edge in ("lower", "upper")]
    assert edges == pytest.approx([first, last], rel=SAME)
    assert bands.sizes["band"] == 1


@pytest.mark.thorough
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.thorough) for seed in range(1, 4))]
)
def test_damping_of_the_shaft_and_of_the_ground(seed: int) -> None:
    random = np.random.default_rng([seed, 18])
    shaft = drawn(seed)
    first, last = shaft.critical_speeds
    shaft = replace(
        shaft,
        time=log_uniform(random, 0.01, 0.2) / last,
        bearing=shaft.along * random.uniform(0.1, 1.0),
        damping=shaft.mass * first * log_uniform(random, 0.01, 0.2),
    )
    engine = ReferenceEngine(shaft.mechanism(), 2, "euler")
    for speed in (1.05 * first, 1.2 * last):
        own, expected = found(engine, speed), shaft.exponents(speed)
        assert apart(own, expected, speed) < 1e-4 * max(last, speed)


@pytest.mark.thorough
def test_damping_of_a_round_shaft_makes_it_whirl_above_a_limit() -> None:
    """The critical speed times one and the damping of the ground over that of the shaft."""
    shaft = replace(drawn(0), time=1e-3, bearing=0.5 * drawn(0).along)
    shaft = replace(shaft, across=shaft.along, damping=0.1 * shaft.time * shaft.along)
    critical = np.sqrt((shaft.along + shaft.bearing) / shaft.mass)
    limit = critical * (1 + shaft.damping / (shaft.time * shaft.along))
    engine = ReferenceEngine(shaft.mechanism(), 2, "euler")
    for part in (0.99, 1.01):
        grows = found(engine, float(part * limit)).real.max() > 0
        assert bool(grows) is (part > 1)
