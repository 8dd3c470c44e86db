"""A strut under a pulsating axial force: the regions of Mathieu's equation.

The rod of a slider-crank whose crank is a ten-thousandth of it, pressed by a force on the slider
that pulsates n times a turn. With its first frequency w without force and Euler's load P_E its
deflection as ``sin(k pi x / L)`` obeys

    q'' + tau k^4 w^2 q' + k^4 w^2 (1 - (P0 + P1 cos n W t) / (k^2 P_E)) q = 0

(N. M. Beliaev 1924; V. V. Bolotin, The Dynamic Stability of Elastic Systems, 1964).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
import scipy.special
from numpy.typing import NDArray

from flexmech import (
    AttachedBody,
    BeamSection,
    ExudynEngine,
    Load,
    Material,
    Mechanism,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    ReferenceEngine,
    stability,
)
from flexmech.linkages import AttachmentPoint
from tests.support.random_mechanisms import log_uniform

FloatArray = NDArray[np.float64]
CRANK = 1e-4
# Rows of the table of the force in each of its periods; it is linear between them.
ROWS = 96
# Tolerance of an edge: eight elements a half wave leave 4e-5 (fourth order); the table and the
# bow of a rod in equilibrium as much.
ELEMENTS, EDGE = 8, 1e-4


@dataclass(frozen=True)
class Strut:
    """A strut, and a region of Mathieu's equation.

    Parameters
    ----------
    length : float
    section : BeamSection
    steady, pulsating : float
        P0 and P1 over Euler's load.
    pulses : int
        Number n of periods of the force in a turn.
    wave : int
        Number k of half waves of the strut.
    order : int
        Of the region, about ``2 / order`` times the strut's frequency.
    """

    length: float
    section: BeamSection
    steady: float
    pulsating: float
    pulses: int
    wave: int = 1
    order: int = 1

    @property
    def euler_load(self) -> float:
        return float(np.pi**2 * self.section.bending_stiffness / self.length**2)

    @property
    def unloaded(self) -> float:
        """Frequency of the k-th mode without force, rad/s."""
        wave = self.wave * np.pi / self.length
        section = self.section
        return float(wave**2 * np.sqrt(section.bending_stiffness / section.mass_per_length))

    @property
    def natural(self) -> float:
        """The same under the steady force."""
        return float(self.unloaded * np.sqrt(1 - self.steady / self.wave**2))

    @property
    def edges(self) -> tuple[float, float]:
        """Crank speeds, the lower one first, by the characteristic values of Mathieu's equation.

        In ``y'' + (a - 2 q cos 2 s) y = 0`` the depth ``2 q / a`` is that of the stiffness.
        """
        depth = self.pulsating / (self.wave**2 - self.steady)

        def edge(value: np.ufunc) -> float:
            q = scipy.optimize.brentq(lambda q: value(self.order, q) - 2 * q / depth, 1e-6, 20.0)
            return float(2 * self.natural / np.sqrt(2 * q / depth) / self.pulses)

        first, last = map(edge, (scipy.special.mathieu_a, scipy.special.mathieu_b))
        return min(first, last), max(first, last)

    def growth(self, speed: float, damping_time: float) -> float:
        """Greatest growth rate in 1/s of the first two modes, over a period of the force."""
        drive = self.pulses * speed
        period = 2 * np.pi / drive

        def largest(wave: int) -> float:
            square = replace(self, wave=wave).unloaded ** 2

            def rate(t: float, x: FloatArray) -> FloatArray:
                force = (self.steady + self.pulsating * np.cos(drive * t)) / wave**2
                q, v = x.reshape(2, 2)
                return np.concatenate([v, -square * (damping_time * v + (1 - force) * q)])

            run = scipy.integrate.solve_ivp(
                rate, (0.0, period), np.eye(2).ravel(), method="DOP853", rtol=1e-11, atol=1e-13
            )
            multipliers = np.linalg.eigvals(run.y[:, -1].reshape(2, 2))
            return float(np.log(np.abs(multipliers)).max() / period)

        return max(largest(wave) for wave in (1, 2))

    def mechanism(self, damping_time: float = 0.0) -> Mechanism:
        crank = CRANK * self.length
        end = float(np.sqrt(self.length**2 - crank**2))
        linkage = PlanarLinkage(
            {"O2": (0.0, 0.0), "A": (0.0, crank), "B": (end, 0.0)},
            (PlanarLink("crank", ("O2", "A"), rigid=True), PlanarLink("rod", ("A", "B"))),
            ("O2",),
            (PlanarJoint("O2", "clamp"), PlanarJoint("B", "slider", direction=0.0)),
        )
        at = 2 * np.pi / (ROWS * self.pulses) * np.arange(ROWS * self.pulses)
        force = self.euler_load * (self.steady + self.pulsating * np.cos(self.pulses * at))
        rows = tuple((-float(each), 0.0) for each in force)
        load = Load(
            "press",
            AttachmentPoint("rod", linkage.topology.links[1].length),
            rows,
            (0.0,) * len(rows),
            over="crank_angle",
            at=tuple(at.tolist()),
        )
        section = self.section.with_damping_time(damping_time) if damping_time else self.section
        hub = AttachedBody("crank", 0.0, mass=1e-3, inertia=1e-6)
        return Mechanism(linkage, {"rod": section}, loads=(load,), bodies=(hub,))


def drawn(seed: int) -> Strut:
    """A slender strut of any metal or polymer in the first or second region of a mode."""
    random = np.random.default_rng([seed, 31])
    length = log_uniform(random, 0.1, 1.0)
    material = Material(log_uniform(random, 3e9, 210e9), random.uniform(1200.0, 8000.0))
    section = BeamSection.rectangle(
        material, length * log_uniform(random, 1 / 400, 1 / 120), log_uniform(random, 5e-3, 4e-2)
    )
    wave, order = [(1, 1), (1, 2), (2, 1)][seed % 3]
    most = 0.4 if order == 1 else 0.8
    return Strut(
        length,
        section,
        random.uniform(-0.5, 0.4),
        random.uniform(most / 2, most),
        int(random.integers(3, 7)),
        wave,
        order,
    )


def growth(strut: Strut, speed: float, damping_time: float = 0.0) -> float:
    engine = ReferenceEngine(strut.mechanism(damping_time), ELEMENTS * strut.wave, "euler")
    found = stability(engine, [speed], prestress="axial", modes=2).dataset
    return float(found["growth_rate"].item())


@pytest.mark.thorough
@pytest.mark.parametrize(("seed", "part"), [(0, 0.4), (1, 0.9), (2, 0.9), (0, 1.2)])
def test_damping_takes_from_the_growth_of_a_strut_what_it_should(seed: int, part: float) -> None:
    """Less than closes the region, and more."""
    strut = drawn(seed)
    speed = float(np.mean(strut.edges))
    undamped = strut.growth(speed, 0.0)
    time = part * 2 * undamped / strut.unloaded**2
    engine = ReferenceEngine(strut.mechanism(time), ELEMENTS * strut.wave, "euler")
    expected = strut.growth(speed, time)
    assert (expected > 0) is (part < 1)
    found = stability(engine, [speed], prestress="axial", modes=2).dataset["growth_rate"]
    assert found.item() == pytest.approx(expected, abs=2e-3 * undamped)


@pytest.mark.parametrize(
    ("seed", "kind", "element", "prestress"),
    [
        (0, ReferenceEngine, "euler", "axial"),
        pytest.param(0, ExudynEngine, "ancf", "equilibrium", marks=pytest.mark.thorough),
        pytest.param(1, ReferenceEngine, "euler", "equilibrium", marks=pytest.mark.thorough),
        pytest.param(2, ReferenceEngine, "euler", "axial", marks=pytest.mark.thorough),
    ],
)
def test_the_map_of_a_strut_finds_both_edges_and_how_far_off_they_are(
    seed: int, kind: Any, element: str, prestress: Any
) -> None:
    """It grows between the edges of Mathieu's equation alone."""
    strut = drawn(seed)
    edges = np.array(strut.edges)
    speeds = np.linspace(edges[0] - np.ptp(edges) / 4, edges[1] + np.ptp(edges) / 4, 5)
    engine = kind(strut.mechanism(), ELEMENTS * strut.wave, element)
    bands = stability(engine, speeds, prestress=prestress, modes=2).dataset
    assert bands.sizes["band"] == 1
    assert bands["band_kind"].item() == "principal"
    assert int(bands["band_order"].item()) == strut.pulses * strut.order
    for edge, expected in zip(("lower", "upper"), edges, strict=True):
        found, error = (float(bands[f"band_{edge}{what}"][0]) for what in ("", "_mesh_error"))
        assert found == pytest.approx(expected, rel=EDGE)
        assert error < EDGE * expected
