"""The rod of the flexible slider-crank of Simeon (1996) in a floating frame, by few functions.

It is independent of both engines: the crank turns as prescribed, the rod's frame follows from its
length, and the displacements in that frame are sines across and a few functions along the rod. The
test set (IVP Test Set, problem "crank") has two sines, two quadratic functions, a linear strain,
and a mass of the axial functions that is 15 times too large.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import solve_ivp

from flexmech.arrays import ComplexArray, FloatArray

# Data of the test set, in SI units: crank and rod, the time at which its state is given, and the
# rod's density, modulus and side, with the mass of the slider.
CRANK_LENGTH, ROD_LENGTH, CRANK_SPEED = 0.15, 0.30, 150.0
END_TIME = 0.1
DENSITY, MODULUS, SIDE, SLIDER = 7870.0, 2e11, 0.008, 0.075552
AREA, BENDING = SIDE**2, MODULUS * SIDE**4 / 12
# Squares of slopes of four half waves are integrated to round-off.
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(24)
PLACE = (POINTS + 1) / 2
LENGTH = WEIGHTS * ROD_LENGTH / 2
MASS = DENSITY * AREA * LENGTH
# Consistent start of the test set, of the two sines and the two axial functions.
START = (0.0, 0.0, 0.103339863e-4, 0.169327969e-4)
RATE = (0.444896105, 0.463434311e-2, -0.178591076e-5, -0.268938672e-5)
# The integrator's steps are held by its stability; smaller tolerances change the tenth digit.
TOLERANCE = 1e-10


@dataclass(frozen=True, eq=False)
class FloatingRod:
    """Equations of the rod on a crank that turns as prescribed.

    Parameters
    ----------
    across, slopes : ndarray, shape (n_across, 24)
        Shapes across the rod at Gauss points, and their derivatives in 1/m.
    along, strains : ndarray, shape (n_along, 24)
        Shapes along the rod, and their derivatives in 1/m.
    tip : ndarray, shape (n_along,)
        Values of the latter at the rod's end.
    excess : float
        What the mass of the axial functions is taken too large by.
    order : {2, 3, 4}
        Order of the strain energy in which tension and slopes meet: 2 is linear, 3 has EA u' w'^2 /
        2, 4 all of EA (u' + w'^2 / 2)^2 / 2.
    """

    across: FloatArray
    slopes: FloatArray
    along: FloatArray
    strains: FloatArray
    tip: FloatArray
    excess: float = 0.0
    order: int = 2

    @classmethod
    def of_the_test_set(cls, excess: float = 0.0, order: int = 2) -> FloatingRod:
        """Two sines across, two quadratic functions along."""
        s = PLACE
        along = np.stack([4 * s - 4 * s**2, 2 * s**2 - s])
        strains = np.stack([4 - 8 * s, 4 * s - 1]) / ROD_LENGTH
        return cls(*_sines(2), along, strains, np.array([0.0, 1.0]), excess, order)

    @classmethod
    def rich(cls) -> FloatingRod:
        """Two sines across, and all along it that their squared slopes ask for; order 4."""
        sines, slopes = _sines(4)
        along = np.concatenate([PLACE[None], sines])
        strains = np.concatenate([np.full((1, len(PLACE)), 1 / ROD_LENGTH), slopes])
        return cls(*_sines(2), along, strains, np.eye(5)[0], 0.0, 4)

    @cached_property
    def start(self) -> FloatArray:
        """Coordinates and rates of the consistent start, (2 n,)."""
        if len(self.along) == len(self.across):
            return np.array([*START, *RATE])
        count, first = len(self.across) + len(self.along), len(self.across)
        return np.concatenate([self._at_rest_along(), RATE[:first], np.zeros(count - first)])

    def _at_rest_along(self) -> FloatArray:
        """Coordinates (n,) at which the straight rod starts without axial acceleration."""
        first, count = len(self.across), len(self.across) + len(self.along)
        start = np.zeros(2 * count)
        for _ in range(3):
            change = self.rate(0.0, start)[count + first :]
            columns = []
            for number in range(first, count):
                moved = start.copy()
                moved[number] += 1e-9
                columns.append((self.rate(0.0, moved)[count + first :] - change) / 1e-9)
            start[first:count] -= np.linalg.solve(np.array(columns).T, change)
        return start[:count]

    @cached_property
    def _shapes(self) -> ComplexArray:
        return np.concatenate([1j * self.across, self.along + 0j])

    @cached_property
    def _products(self) -> tuple[ComplexArray, ComplexArray, ComplexArray, float, float]:
        """Mass integrals: of pairs of shapes; of shapes with place, with 1; of place with both."""
        shapes, place = self._shapes, ROD_LENGTH * PLACE
        pairs = (shapes.conj() * MASS) @ shapes.T
        with_place = shapes @ (MASS * place)
        return pairs, with_place, shapes @ MASS, float(MASS @ place), float(MASS @ place**2)

    @cached_property
    def _tips(self) -> FloatArray:
        return np.concatenate([np.zeros(len(self.across)), self.tip])

    @cached_property
    def _axial_mass(self) -> FloatArray:
        first, count = len(self.across), len(self._tips)
        axial = np.zeros((count, count))
        axial[first:, first:] = self.excess * (self.along * MASS) @ self.along.T
        return axial

    def rate(self, time: float, state: FloatArray) -> FloatArray:
        """Velocities and accelerations.

        Parameters
        ----------
        time : float
            In s.
        state : ndarray, shape (2 n,)
            Coordinates in m and velocities in m/s.

        Returns
        -------
        ndarray, shape (2 n,)
        """
        count = len(state) // 2
        q, v, tip = state[:count], state[count:], self._tips
        # The rod's angle follows from its length: its end is on the line.
        turned = CRANK_SPEED * time
        high = CRANK_LENGTH * float(np.sin(turned))
        rise = CRANK_LENGTH * CRANK_SPEED * float(np.cos(turned))
        length, growth = ROD_LENGTH + float(tip @ q), float(tip @ v)
        sine = -high / length
        cosine = (1 - sine**2) ** 0.5
        omega = (-rise / length + high * growth / length**2) / cosine
        by_length = high / length**2 / cosine
        alpha = CRANK_SPEED**2 * high / length + 2 * rise * growth / length**2
        alpha = (alpha - 2 * high * growth**2 / length**3 + sine * omega**2) / cosine
        turn = complex(cosine, sine)
        pairs, with_place, with_one, first_moment, second_moment = self._products
        # Integrals of each shape, and of the place along the rod, with the place and the speed.
        placed = with_place.conj() + pairs @ q
        moving = pairs @ v
        size = second_moment + float((with_place.real + placed.real) @ q)
        centre = first_moment + complex(with_one @ q)
        own = complex(placed.conj() @ v)
        twist = np.outer(placed.imag, tip)
        mass = pairs.real - by_length * (twist + twist.T) + by_length**2 * size * np.outer(tip, tip)
        crank = -CRANK_LENGTH * CRANK_SPEED**2 * complex(np.cos(turned), np.sin(turned))
        crank *= turn.conjugate()
        spin = 1j * alpha - omega**2
        force = -(crank * with_one.conj() + 2j * omega * moving + spin * placed).real
        turning = crank * centre.conjugate() + 2j * omega * own + spin * size
        force += by_length * (-1j * turning).real * -tip
        sliding = cosine - length * sine * by_length
        pulled = -CRANK_LENGTH * CRANK_SPEED**2 * float(np.cos(turned)) - 2 * growth * sine * omega
        pulled -= length * (sine * alpha + cosine * omega**2)
        mass += SLIDER * sliding**2 * np.outer(tip, tip)
        force -= SLIDER * sliding * pulled * tip
        if self.excess:
            axial = self._axial_mass
            both, work = float(q @ axial @ q), float(q @ axial @ v)
            mass += axial + by_length**2 * both * np.outer(tip, tip)
            force += omega**2 * axial @ q - by_length * (alpha * both + 2 * omega * work) * tip
        return np.concatenate([v, np.linalg.solve(mass, force - self._elastic(q))])

    @cached_property
    def _weighted(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Bending stiffness of the sines; strains and slopes times EA and the points' lengths."""
        number = np.arange(1, len(self.across) + 1)
        bending = BENDING * ROD_LENGTH / 2 * (number * np.pi / ROD_LENGTH) ** 4
        stretch = MODULUS * AREA * LENGTH
        return np.asarray(bending), self.strains * stretch, self.slopes * stretch

    def _elastic(self, q: FloatArray) -> FloatArray:
        first = len(self.across)
        bending, strains, slopes = self._weighted
        across = bending * q[:first]
        strain = q[first:] @ self.strains
        if self.order == 2:
            return np.concatenate([across, strains @ strain])
        slope = q[:first] @ self.slopes
        whole = strain + slope**2 / 2
        across = across + slopes @ ((whole if self.order > 3 else strain) * slope)
        return np.concatenate([across, strains @ whole])

    def run(self, tolerance: float = 1e-6, samples: int = 20000) -> tuple[FloatArray, FloatArray]:
        """Motion from the consistent start until 0.1 s.

        Parameters
        ----------
        tolerance : float
            Relative one of the integrator.
        samples : int

        Returns
        -------
        ndarray, shape (samples + 1,)
            Time in s.
        ndarray, shape (n, samples + 1)
            Coordinates in m; the first is the deflection of the rod's middle by the first sine.
        """
        time = np.linspace(0, END_TIME, samples + 1)
        found = solve_ivp(
            self.rate, (0, END_TIME), self.start, "DOP853", time, rtol=tolerance, atol=TOLERANCE
        )
        return time, np.asarray(found.y[: len(self.start) // 2])


def rod_at_end(*, excess: float = 0.0, order: int = 2) -> FloatArray:
    """State of the slider-crank at 0.1 s by the functions of the test set.

    Parameters
    ----------
    excess : float
        What the mass of the axial functions is taken too large by.
    order : {2, 3, 4}
        Order of the strain energy.

    Returns
    -------
    ndarray, shape (3,)
        Angle of the rod in rad, place of the slider in m, first sine in m.
    """
    _, q = FloatingRod.of_the_test_set(excess, order).run(samples=1)
    length = ROD_LENGTH + q[3, -1]
    sine = -CRANK_LENGTH * np.sin(CRANK_SPEED * END_TIME) / length
    end = CRANK_LENGTH * np.cos(CRANK_SPEED * END_TIME) + length * np.sqrt(1 - sine**2)
    return np.array([np.arcsin(sine), end, q[0, -1]])


def rod_first_sine(*, excess: float = 0.0, order: int = 2) -> FloatArray:
    """First sine of the rod at 0.1 s, as in :func:`rod_at_end`.

    Parameters
    ----------
    excess : float
    order : {2, 3, 4}

    Returns
    -------
    ndarray, shape (1,)
        In m.
    """
    return rod_at_end(excess=excess, order=order)[2:]


def rod_peak(*, order: int) -> FloatArray:
    """Greatest first sine of the rod of Simeon's slider-crank, by few functions.

    Parameters
    ----------
    order : {3, 4}
        Order of the strain energy in which tension and slopes meet.

    Returns
    -------
    ndarray, shape (2,)
        In m, and its time in s.
    """
    rod = FloatingRod.rich() if order == 4 else FloatingRod.of_the_test_set(order=order)
    time, q = rod.run(tolerance=1e-4)
    size = np.abs(q[0])
    return np.array([size.max(), time[size.argmax()]])


def _sines(count: int) -> tuple[FloatArray, FloatArray]:
    """Sines at the points and their derivatives."""
    waves = np.arange(1, count + 1)[:, None] * np.pi
    return np.asarray(np.sin(waves * PLACE)), np.asarray(waves / ROD_LENGTH * np.cos(waves * PLACE))
