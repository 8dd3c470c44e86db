"""V7 of the validation numbers: the flexible slider-crank of Simeon (1996), IVP Test Set "crank".

The small model here makes the test set's own assumptions: a rod of two sines across and of two
quadratic functions along it in its floating frame, no work of the tension against the slope. The
test set takes a mass of the axial functions that is 15 times too large.

The number of the row for "u' w'^2 stiffness" has the work of the tension in third order alone. The
square of ``w'^2 / 2`` belongs to the same strain energy: without it a rod whose end is free to
slide softens as it bends. With it the small model, the reference and Exudyn find a peak of
1.56 mm, not 2.32 mm.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import flexmech

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
CRANK, ROD, SPEED = 0.15, 0.30, 150.0
DENSITY, MODULUS, SIDE, SLIDER = 7870.0, 2e11, 0.008, 0.075552
AREA, BENDING = SIDE**2, MODULUS * SIDE**4 / 12
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(24)
PLACE = (POINTS + 1) / 2
LENGTH = WEIGHTS * ROD / 2
# Consistent start of the test set, of the two sines and the two axial functions.
START = np.array([0.0, 0.0, 0.103339863e-4, 0.169327969e-4])
RATE = np.array([0.444896105, 0.463434311e-2, -0.178591076e-5, -0.268938672e-5])
END_TIME = 0.1


@dataclass(frozen=True)
class Rod:
    """Equations of the rod on a crank that turns as prescribed.

    ``across`` and ``along`` are shapes at the points, (n, points), with their derivatives; ``tip``
    is the value of the latter at the end. ``excess`` is what the mass of the axial functions is
    taken too large by; ``order`` is that of the strain energy in which tension and slopes meet.
    """

    across: FloatArray
    slopes: FloatArray
    along: FloatArray
    strains: FloatArray
    tip: FloatArray
    excess: float = 0.0
    order: int = 2

    @classmethod
    def of_the_test_set(cls, excess: float = 0.0, order: int = 2) -> Rod:
        s = PLACE
        along = np.stack([4 * s - 4 * s**2, 2 * s**2 - s])
        strains = np.stack([4 - 8 * s, 4 * s - 1]) / ROD
        return cls(*_sines(2), along, strains, np.array([0.0, 1.0]), excess, order)

    @classmethod
    def rich(cls) -> Rod:
        """Two sines across, and all along it that their squared slopes ask for."""
        sines, slopes = _sines(4)
        along = np.concatenate([PLACE[None], sines])
        strains = np.concatenate([np.full((1, len(PLACE)), 1 / ROD), slopes])
        return cls(*_sines(2), along, strains, np.eye(5)[0], 0.0, 4)

    def rate(self, time: float, state: FloatArray) -> FloatArray:
        """Velocities and accelerations."""
        count, first = len(state) // 2, len(self.across)
        q, v = state[:count], state[count:]
        tip = np.concatenate([np.zeros(first), self.tip])
        moved = np.concatenate([1j * self.across, self.along + 0j])
        # The rod's angle follows from its length: its end is on the line.
        turned = SPEED * time
        high, rise = CRANK * np.sin(turned), CRANK * SPEED * np.cos(turned)
        length, growth = ROD + tip @ q, float(tip @ v)
        sine = -high / length
        cosine = np.sqrt(1 - sine**2)
        omega = (-rise / length + high * growth / length**2) / cosine
        by_length = high / length**2 / cosine
        alpha = SPEED**2 * high / length + 2 * rise * growth / length**2
        alpha = (alpha - 2 * high * growth**2 / length**3 + sine * omega**2) / cosine
        place, speed = ROD * PLACE + q @ moved, v @ moved
        turn = cosine + 1j * sine
        virtual: ComplexArray = turn * (moved + 1j * np.outer(tip, by_length * place))
        free = -CRANK * SPEED**2 * np.exp(1j * turned)
        free = free + turn * (2j * omega * speed + (1j * alpha - omega**2) * place)
        weight = DENSITY * AREA * LENGTH
        mass = np.real((virtual.conj() * weight) @ virtual.T)
        force = -np.real((virtual.conj() * weight) @ free)
        sliding = cosine - length * sine * by_length
        pulled = -CRANK * SPEED**2 * np.cos(turned) - 2 * growth * sine * omega
        pulled -= length * (sine * alpha + cosine * omega**2)
        mass += SLIDER * sliding**2 * np.outer(tip, tip)
        force -= SLIDER * sliding * pulled * tip
        if self.excess:
            axial = np.zeros((count, count))
            axial[first:, first:] = self.excess * (self.along * weight) @ self.along.T
            both, work = float(q @ axial @ q), float(q @ axial @ v)
            mass += axial + by_length**2 * both * np.outer(tip, tip)
            force += omega**2 * axial @ q - by_length * (alpha * both + 2 * omega * work) * tip
        return np.concatenate([v, np.linalg.solve(mass, force - self._elastic(q, first))])

    def _elastic(self, q: FloatArray, first: int) -> FloatArray:
        number = np.arange(1, first + 1)
        across = BENDING * ROD / 2 * (number * np.pi / ROD) ** 4 * q[:first]
        strain, slope = q[first:] @ self.strains, q[:first] @ self.slopes
        second = slope**2 / 2 if self.order > 2 else 0.0 * slope
        tension = MODULUS * AREA * (strain + (second if self.order > 3 else 0.0))
        if self.order > 2:
            across = across + (self.slopes * (tension * slope * LENGTH)).sum(axis=1)
        along = (self.strains * (MODULUS * AREA * (strain + second) * LENGTH)).sum(axis=1)
        return np.concatenate([across, along])

    def run(self, start: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Times and coordinates from the start of a state on."""
        found = solve_ivp(
            self.rate, (0, END_TIME), start, "DOP853", rtol=1e-8, atol=1e-14, dense_output=True
        )
        time = np.linspace(0, END_TIME, 20001)
        return time, found.sol(time)[: len(start) // 2]


def _sines(count: int) -> tuple[FloatArray, FloatArray]:
    """Sines at the points and their derivatives."""
    waves = np.arange(1, count + 1)[:, None] * np.pi
    return np.sin(waves * PLACE), waves / ROD * np.cos(waves * PLACE)


def peak(time: FloatArray, deflection: FloatArray) -> tuple[float, float]:
    """Greatest deflection and its time."""
    place = int(np.abs(deflection).argmax())
    return float(np.abs(deflection[place])), float(time[place])


def test_the_test_sets_own_model() -> None:
    rod = Rod.of_the_test_set(excess=14.0)
    _, q = rod.run(np.concatenate([START, RATE]))
    length = ROD + q[3, -1]
    sine = -CRANK * np.sin(SPEED * END_TIME) / length
    end = CRANK * np.cos(SPEED * END_TIME) + length * np.sqrt(1 - sine**2)
    assert np.arcsin(sine) == pytest.approx(-0.331173498825626, rel=1e-6)
    assert end == pytest.approx(0.169737332842786, rel=1e-6)
    assert q[0, -1] == pytest.approx(1.893192899613509e-4, rel=1e-6)


@pytest.mark.thorough
def test_with_the_right_mass_of_the_axial_functions() -> None:
    _, q = Rod.of_the_test_set().run(np.concatenate([START, RATE]))
    assert q[0, -1] == pytest.approx(1.8930818e-4, rel=1e-6)


@pytest.mark.thorough
def test_with_tension_against_slopes_in_third_order_alone() -> None:
    time, q = Rod.of_the_test_set(order=3).run(np.concatenate([START, RATE]))
    greatest, when = peak(time, q[0])
    assert greatest == pytest.approx(2.3174e-3, rel=0.01)
    assert when == pytest.approx(0.0790, abs=1e-4)


@pytest.fixture(scope="module")
def rod_deflection() -> tuple[FloatArray, FloatArray]:
    """Time and deflection of the rod's middle by the reference engine, of slender beams."""
    mechanism = flexmech.load_mechanism(Path(__file__).parents[2] / "models" / "slider_crank.toml")
    turns = END_TIME * SPEED / (2 * np.pi)
    request = flexmech.ResponseRequest(
        flexmech.CrankDrive(SPEED), turns, samples=8000, start="equilibrium", step=4e-6
    )
    found = flexmech.response(flexmech.ReferenceEngine(mechanism, 12, "euler"), request)
    table = found.tables()["response"]
    return table["time_s"].to_numpy(), table["rod_mid_deflection_m"].to_numpy()


def test_the_product_does_not_soften(rod_deflection: tuple[FloatArray, FloatArray]) -> None:
    """Its peak is far below that of the third order alone."""
    greatest, _ = peak(*rod_deflection)
    assert greatest == pytest.approx(1.560e-3, rel=2e-3)
    assert rod_deflection[1][-1] == pytest.approx(2.10e-4, rel=0.01)


@pytest.mark.thorough
def test_the_complete_second_order_strain(rod_deflection: tuple[FloatArray, FloatArray]) -> None:
    """The small model with all of the strain's square against the product, over the whole run."""
    rod = Rod.rich()
    start = np.concatenate([_at_rest_along(rod), RATE[:2], np.zeros(5)])
    time, q = rod.run(start)
    middle = q[0]
    assert peak(time, middle)[0] == pytest.approx(peak(*rod_deflection)[0], rel=0.01)
    other = np.interp(time, *rod_deflection)
    assert np.abs(middle - other).max() < 0.03 * np.abs(other).max()


def _at_rest_along(rod: Rod) -> FloatArray:
    """Coordinates (7,) at which the straight rod starts without axial acceleration."""
    start = np.zeros(14)
    for _ in range(3):
        change = rod.rate(0.0, start)[9:]
        columns = []
        for number in range(2, 7):
            moved = start.copy()
            moved[number] += 1e-9
            columns.append((rod.rate(0.0, moved)[9:] - change) / 1e-9)
        start[2:7] -= np.linalg.solve(np.array(columns).T, change)
    return start[:7]
