"""Tension, shear force and bending moment along the links of a rigid linkage."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages.applied_forces import ForceOnLink
from flexmech.linkages.link_mass import LinkMass
from flexmech.linkages.motion import RigidMotion, direction, normal


@dataclass(frozen=True)
class LinkForces:
    """Forces on the links of a moving linkage, and internal forces at cuts.

    Parameters
    ----------
    motion : RigidMotion
    masses : tuple of LinkMass
    gravity : tuple of float
        Gravitational acceleration in ground axes, m/s^2.
    start_force : ndarray, shape (..., n_links, 2)
        Sum of joint forces on the start of each link, ground axes, N.
    start_moment : ndarray, shape (..., n_links)
        Sum of joint couples on the start of each link, N m.
    applied : tuple of ForceOnLink
        Loads and forces of springs.
    on_guides : tuple of ForceOnLink
        Forces of sliders on their guides.
    """

    motion: RigidMotion
    masses: tuple[LinkMass, ...]
    gravity: tuple[float, float]
    start_force: FloatArray
    start_moment: FloatArray
    applied: tuple[ForceOnLink, ...]
    on_guides: tuple[ForceOnLink, ...]

    def axial_force(self, link: int, x: float | FloatArray) -> FloatArray:
        """Tension along a link in N.

        Parameters
        ----------
        link : int
        x : float or ndarray, shape (k,)
            Distances from the link's start in m. A point mass, body or load exactly there
            counts to the far side of the cut.

        Returns
        -------
        ndarray, shape (...) or (..., k)
        """
        return self._force(link, np.asarray(x, dtype=float), direction)

    def shear_force(self, link: int, x: float | FloatArray) -> FloatArray:
        """Force across a link in N that the part beyond a cut exerts on the part before it.

        Parameters
        ----------
        link : int
        x : float or ndarray, shape (k,)
            As in :meth:`axial_force`.

        Returns
        -------
        ndarray, shape (...) or (..., k)
            Positive along the y axis of the link's frame. Where the mass lies on the axis and
            the link turns at constant speed, it is the slope of :meth:`bending_moment` with the
            other sign; an angular acceleration adds to that slope by the rotary inertia of the
            sections.
        """
        return self._force(link, np.asarray(x, dtype=float), normal)

    def bending_moment(self, link: int, x: float | FloatArray) -> FloatArray:
        """Moment in N m that the part beyond a cut exerts on the part before it.

        Parameters
        ----------
        link : int
        x : float or ndarray, shape (k,)
            As in :meth:`axial_force`.

        Returns
        -------
        ndarray, shape (...) or (..., k)
            Positive where it curves the link towards the y axis of its frame.
        """
        motion, place = self.motion, np.asarray(x, dtype=float)
        angle, pull = motion.angle[..., link], self._pull(link)
        _, first, moment_across, second = _mass_before(self.masses[link], place)
        # About the link's start; the force across the cut is what moves it to the cut.
        moment = (
            np.multiply.outer(np.sum(pull * normal(angle), axis=-1), first)
            - np.multiply.outer(np.sum(pull * direction(angle), axis=-1), moment_across)
            + np.multiply.outer(motion.angular_acceleration[..., link], second)
            - _spread(self.start_moment[..., link], place)
        )
        for one, passed in self._forces_before(link, place):
            moment = moment - passed * _spread(one.moment(motion), place)
        return np.asarray(moment - place * self.shear_force(link, place))

    def _force(
        self, link: int, place: FloatArray, axis_at: Callable[[FloatArray], FloatArray]
    ) -> FloatArray:
        """Force along an axis of the link that the part beyond a cut exerts on that before it."""
        motion = self.motion
        axis = axis_at(motion.angle[..., link])
        mass, first, moment_across, _ = _mass_before(self.masses[link], place)
        centripetal = -(motion.angular_velocity[..., link] ** 2)
        tangential = motion.angular_acceleration[..., link]
        # A point (x, y) of the link accelerates by centripetal x - tangential y along the link,
        # and by tangential x + centripetal y across it.
        by_x, by_y = (tangential, centripetal) if axis_at is normal else (centripetal, -tangential)
        carried = np.sum(self.start_force[..., link, :] * axis, axis=-1)
        force = (
            np.multiply.outer(np.sum(self._pull(link) * axis, axis=-1), mass)
            + np.multiply.outer(by_x, first)
            + np.multiply.outer(by_y, moment_across)
            - _spread(carried, place)
        )
        for one, passed in self._forces_before(link, place):
            force = force - passed * _spread(np.sum(one.force * axis, axis=-1), place)
        return np.asarray(force)

    def _pull(self, link: int) -> FloatArray:
        """Acceleration less gravity at a link's start, ground axes, (..., 2)."""
        return np.asarray(self.motion.origin_acceleration[..., link, :] - self.gravity)

    def _forces_before(
        self, link: int, place: FloatArray
    ) -> Iterator[tuple[ForceOnLink, FloatArray]]:
        """Applied forces of a link, each with 1 at the cuts that it is before and 0 at others."""
        for one in (*self.applied, *self.on_guides):
            if one.link == link:
                x = np.broadcast_to(one.x, self.motion.crank_angle.shape)
                yield one, (_spread(x, place) < place).astype(float)


def _mass_before(mass: LinkMass, place: FloatArray) -> FloatArray:
    """Mass of a link before cuts, first moments along and across, polar second one, (4, ...)."""
    line = mass.mass_per_length * place
    second = line * (place**2 / 3 + mass.offset**2) + mass.rotary_inertia * place
    sums: FloatArray = np.stack([line, line * place / 2, line * mass.offset, second])
    for at, lump in zip(mass.point_positions, mass.point_masses, strict=True):
        own = lump * np.array([1.0, at, 0.0, at**2])
        sums = sums + np.multiply.outer(own, at < place)
    for body in mass.bodies:
        x, y = body.centre
        own = body.mass * np.array([1.0, x, y, x**2 + y**2]) + [0.0, 0.0, 0.0, body.inertia]
        sums = sums + np.multiply.outer(own, body.position < place)
    return np.asarray(sums)


def _spread(values: FloatArray, place: FloatArray) -> FloatArray:
    """Values (...) with dimensions for the cuts: shape (...) or (..., 1)."""
    return np.asarray(values[(..., *[None] * place.ndim)])
