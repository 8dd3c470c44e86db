"""Counterweights, and those that weigh shaking force, shaking moment and driving torque.

Forces are linear in the first moments of the counterweights and, their radii given, in the sizes
of these, to which their inertias are proportional. The weighed mean squares are a quadratic form of
both, whose least value is sought.
"""

from __future__ import annotations

import cmath
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from scipy.optimize import minimize

from flexmech.analyses.aspects.shaking import shaking_of
from flexmech.analyses.balance.request import WEIGHED
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import LinkMass, RigidMotion, inverse_dynamics
from flexmech.linkages.frame_forces import TurningLink
from flexmech.linkages.link_mass import LinkBody
from flexmech.mechanism import AttachedBody, Mechanism


@dataclass(frozen=True)
class Counterweight:
    """A point mass on a link, at a radius from the point about which the link rotates.

    Parameters
    ----------
    link : TurningLink
    length : float
        Length of the link in m.
    mass : float
        In kg.
    radius : float
        In m.
    direction : complex
        From the point to the mass in the link's frame, of size 1.
    """

    link: TurningLink
    length: float
    mass: float
    radius: float
    direction: complex

    @classmethod
    def of_moment(cls, link: TurningLink, length: float, moment: complex, radius: float) -> Self:
        """The counterweight with a first moment about the link's point of the ground.

        Parameters
        ----------
        link : TurningLink
        length : float
        moment : complex
            Along and across the link's frame, in kg m.
        radius : float
            In m.

        Returns
        -------
        Counterweight
        """
        size = abs(moment)
        return cls(link, length, size / radius, radius, moment / size if size else 1.0 + 0.0j)

    @property
    def angle(self) -> float:
        """Direction from the point to the mass against the link's frame, in rad."""
        return cmath.phase(self.direction)

    @property
    def moment(self) -> complex:
        """First moment about the point of the ground, along and across the frame, in kg m."""
        return self.mass * self.radius * self.direction

    @property
    def place(self) -> tuple[float, float]:
        """Along and across the link's frame from its start in m; it may lie beyond the joint."""
        arm = self.radius * self.direction
        return self.link.pivot + arm.real, arm.imag

    @property
    def _section(self) -> float:
        """Section that it is fixed to: the link's end at the point of the ground."""
        return 0.0 if self.link.end == "start" else self.length

    @property
    def body(self) -> AttachedBody:
        """Counterweight as a body attached to a link."""
        x, y = self.place
        offset = (x - self._section, y)
        return AttachedBody(self.link.name, self._section, self.mass, offset=offset)

    @property
    def link_mass(self) -> LinkMass:
        """A link that has this mass alone."""
        x, y = self.place
        body = LinkBody(self._section, self.mass, offset=(x - self._section, y))
        return LinkMass(self.length, 0.0, bodies=(body,))


def balanced(mechanism: Mechanism, weights: Sequence[Counterweight]) -> Mechanism:
    """A mechanism with counterweights; those without mass are left out.

    Parameters
    ----------
    mechanism : Mechanism
    weights : sequence of Counterweight

    Returns
    -------
    Mechanism
        Its name says so.
    """
    bodies = (*mechanism.bodies, *(weight.body for weight in weights if weight.mass))
    named = replace(mechanism.provenance, name=f"{mechanism.provenance.name}, balanced")
    return replace(mechanism, bodies=bodies, provenance=named)


# Features of a counterweight: its first moment along and across the link, and the size of that.
_FEATURES = 3
# Parts of the full force balance from which the search starts.
_STARTS = (1.0, 0.5, 0.1)
# Least gain over the weighed sum as given: counterweights that gain less are left out.
_GAIN = 1e-9
# Relative change of the sum, and slope of it over the scale of the moments, that end the search.
_GRADIENT = 1e-12


@dataclass(frozen=True)
class Loads:
    """Weighed quantities along crank angles (A,).

    Parameters
    ----------
    force : ndarray, shape (A, 2)
        Shaking force by inertia in N.
    moment : ndarray, shape (A,)
        Shaking moment by inertia in N m.
    torque : ndarray, shape (A,)
        Driving torque under all that acts, in N m.
    """

    force: FloatArray
    moment: FloatArray
    torque: FloatArray

    @property
    def rows(self) -> tuple[FloatArray, ...]:
        """Each as numbers (m,) whose squares are summed, in the order of the weights."""
        return self.force.ravel(), self.moment, self.torque


def inertia_loads(
    mechanism: Mechanism, motion: RigidMotion, point: tuple[float, float] | None = None
) -> Loads:
    """Shaking force and moment by inertia alone, and the driving torque under all that acts.

    Weight, loads and springs are left out of the shaking force, for no counterweight balances
    them: the weight is constant, and the others do not depend on masses.

    Parameters
    ----------
    mechanism : Mechanism
    motion : RigidMotion
        Batch of shape (A,).
    point : tuple of float, optional
        About which the moment is taken, m; the shaft's axis if left out.

    Returns
    -------
    Loads
    """
    masses = mechanism.link_masses_in_order
    own = _of_masses(mechanism, motion, masses, point)
    torque = mechanism.without_loads_over_time.inverse_dynamics(motion).driving_torque
    return Loads(own.force, own.moment, torque)


def _of_masses(
    mechanism: Mechanism,
    motion: RigidMotion,
    masses: Sequence[LinkMass],
    point: tuple[float, float] | None,
) -> Loads:
    """Loads by the inertia of masses, and the torque by that and their weight."""
    topology, gravity = mechanism.linkage.topology, mechanism.gravity
    forces = inverse_dynamics(topology, motion, masses)
    bare = _without_springs(mechanism)
    shaking = shaking_of(bare, forces, point)
    torque = forces.driving_torque
    if any(gravity):
        torque = inverse_dynamics(topology, motion, masses, gravity).driving_torque
    return Loads(shaking.force, shaking.moment, torque)


def _without_springs(mechanism: Mechanism) -> Mechanism:
    rigid = tuple(
        replace(own, torsional_stiffness=0.0, torsional_damping=0.0)
        for own in mechanism.joint_springs
    )
    return replace(mechanism, springs=(), joint_springs=rigid)


@dataclass(frozen=True)
class WeighedSum:
    """Weighed sum of mean squares, each over that of the linkage as given.

    Parameters
    ----------
    form : ndarray, shape (1 + 3 n, 1 + 3 n)
        Quadratic form of 1 and the features of n counterweights.
    """

    form: FloatArray

    @classmethod
    def of(
        cls,
        mechanism: Mechanism,
        motion: RigidMotion,
        links: Sequence[tuple[TurningLink, float, float]],
        weights: Sequence[float],
        point: tuple[float, float] | None,
    ) -> WeighedSum:
        """The sum for counterweights on some links.

        Parameters
        ----------
        mechanism : Mechanism
        motion : RigidMotion
            Batch of shape (A,).
        links : sequence of (TurningLink, float, float)
            Each with its length and the radius of its counterweight in m.
        weights : sequence of float
            Weights of force, moment and torque.
        point : tuple of float or None
            About which the shaking moment is taken, m.

        Returns
        -------
        WeighedSum

        Raises
        ------
        InputError
            If something is weighed that the linkage as given does not have.
        """
        given = inertia_loads(mechanism, motion, point)
        columns = [given.rows]
        for link, length, radius in links:
            columns += _features(mechanism, motion, link, length, radius, point)
        size = len(columns)
        form = np.zeros((size, size))
        for number, weight in enumerate(weights):
            if not weight:
                continue
            table = np.stack([rows[number] for rows in columns], axis=1)
            squares = table.T @ table
            if not squares[0, 0]:
                raise InputError(
                    f"weights: the linkage as given has no {WEIGHED[number]} at this speed, over "
                    "which another one could be weighed; give it the weight 0"
                )
            form += weight * squares / squares[0, 0]
        return cls(form)

    def value(self, moments: FloatArray) -> float:
        """The sum for first moments (2 n,) of counterweights, in kg m."""
        features = self._features(moments)
        return float(features @ self.form @ features)

    def gradient(self, moments: FloatArray) -> FloatArray:
        """Its derivative by the first moments (2 n,)."""
        pairs = moments.reshape(-1, 2)
        sizes = np.linalg.norm(pairs, axis=1, keepdims=True)
        along = np.divide(pairs, sizes, out=np.zeros_like(pairs), where=sizes > 0)
        by_feature = 2 * (self.form @ self._features(moments))[1:].reshape(-1, _FEATURES)
        return np.asarray(by_feature[:, :2] + by_feature[:, 2:] * along).ravel()

    @staticmethod
    def _features(moments: FloatArray) -> FloatArray:
        pairs = moments.reshape(-1, 2)
        sizes = np.linalg.norm(pairs, axis=1, keepdims=True)
        return np.concatenate([[1.0], np.concatenate([pairs, sizes], axis=1).ravel()])


def _features(
    mechanism: Mechanism,
    motion: RigidMotion,
    link: TurningLink,
    length: float,
    radius: float,
    point: tuple[float, float] | None,
) -> list[tuple[FloatArray, ...]]:
    """Loads by a unit first moment along and across a link, and by the inertia that it brings."""

    def loads(moment: complex) -> Loads:
        own = Counterweight.of_moment(link, length, moment, radius).link_mass
        others = [LinkMass(one.length, 0.0) for one in mechanism.linkage.topology.links]
        others[link.number] = own
        return _of_masses(mechanism, motion, others, point)

    ahead, behind, across = (loads(moment).rows for moment in (1.0, -1.0, 1j))
    # With two opposite counterweights the first moments cancel, and the inertias add.
    inertia = [(one + other) / 2 for one, other in zip(ahead, behind, strict=True)]
    along = tuple(one - own for one, own in zip(ahead, inertia, strict=True))
    beside = tuple(one - own for one, own in zip(across, inertia, strict=True))
    return [along, beside, tuple(inertia)]


def least_moments(weighed: WeighedSum, full: Sequence[complex]) -> list[complex]:
    """First moments of the counterweights with the least weighed sum.

    Parameters
    ----------
    weighed : WeighedSum
    full : sequence of complex
        Radii of full force balance, from parts of which the search starts; zero where there
        is none.

    Returns
    -------
    list of complex
        Zero where a counterweight gains nothing.
    """
    start = np.array([[moment.real, moment.imag] for moment in full])
    scale = float(np.abs(start).max()) or 1.0
    best = np.zeros(start.size)
    least = weighed.value(best)
    gain = _GAIN * least
    # The size of a moment has a corner at zero: with each set of counterweights there is a search.
    sets = itertools.product((False, True), repeat=len(full))
    for carried in sorted(sets, key=sum):
        free = np.repeat(carried, 2)
        for part in _STARTS if any(carried) else ():
            found, value = _search(weighed, part * start.ravel(), free, scale)
            if value < least - gain:
                best, least = found, value
    return [complex(*pair) for pair in best.reshape(-1, 2)]


def _search(
    weighed: WeighedSum, start: FloatArray, free: FloatArray, scale: float
) -> tuple[FloatArray, float]:
    """Least sum over the free moments, others zero, in parts of a scale."""

    def whole(parts: FloatArray) -> FloatArray:
        moments = np.zeros(start.size)
        moments[free] = scale * parts
        return moments

    def slope(parts: FloatArray) -> FloatArray:
        return np.asarray(scale * weighed.gradient(whole(parts))[free])

    # A full balance that is none has no direction: any other start has.
    parts = start[free] / scale
    parts = np.where(parts, parts, np.tile([-0.1, 0.0], parts.size // 2))
    found = minimize(
        lambda parts: weighed.value(whole(parts)), parts, jac=slope, options={"gtol": _GRADIENT}
    )
    return whole(found.x), float(found.fun)
