"""Tension, shear force and bending moment along the links of a rigid linkage."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexmech.linkages.applied_forces import ForceOnLink
from flexmech.linkages.link_mass import LinkMass
from flexmech.linkages.motion import RigidMotion, direction, normal
from flexmech.types import FloatArray


@dataclass(frozen=True)
class LinkForces:
    """What acts on the links of a moving linkage, and what they carry inside.

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
        What sliders press on the links that guide them.
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
        return _axial_force(self, link, np.asarray(x, dtype=float))

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
            Positive along the y axis of the link's frame. Where the mass lies on the axis, it
            is the slope of :meth:`bending_moment` with the other sign.
        """
        return _shear_force(self, link, np.asarray(x, dtype=float))

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
        return _bending_moment(self, link, np.asarray(x, dtype=float))


def _axial_force(forces: LinkForces, link: int, place: FloatArray) -> FloatArray:
    """Force along a link that the part beyond a cut exerts on the part before it."""
    mass, motion = forces.masses[link], forces.motion
    along = direction(motion.angle[..., link])
    pull = motion.origin_acceleration[..., link, :] - np.asarray(forces.gravity)
    start = np.sum(pull * along, axis=-1)
    turning = motion.angular_velocity[..., link] ** 2
    at_start = np.sum(forces.start_force[..., link, :] * along, axis=-1)
    change = motion.angular_acceleration[..., link]
    mass_before = mass.mass_per_length * place
    first_before = mass_before * place / 2
    beside = mass_before * mass.offset
    for fixed, (x, y), lump in _lumps(forces, link):
        passed = lump * (fixed < place)
        mass_before, first_before = mass_before + passed, first_before + passed * x
        beside = beside + passed * y
    tension: FloatArray = (
        np.multiply.outer(start, mass_before)
        - np.multiply.outer(turning, first_before)
        - np.multiply.outer(change, beside)
        - _spread(at_start, place)
    )
    for passed, _, force, _ in _forces_before(forces, link, place):
        tension = tension - passed * _spread(force[0], place)
    return tension


def _shear_force(forces: LinkForces, link: int, place: FloatArray) -> FloatArray:
    """Force across a link that the part beyond a cut exerts on the part before it."""
    mass, motion = forces.masses[link], forces.motion
    across = normal(motion.angle[..., link])
    pull = motion.origin_acceleration[..., link, :] - np.asarray(forces.gravity)
    start = np.sum(pull * across, axis=-1)
    turning = motion.angular_velocity[..., link] ** 2
    change = motion.angular_acceleration[..., link]
    mass_before = mass.mass_per_length * place
    first_before = mass_before * place / 2
    beside = mass_before * mass.offset
    for fixed, (x, y), lump in _lumps(forces, link):
        passed = lump * (fixed < place)
        mass_before, first_before = mass_before + passed, first_before + passed * x
        beside = beside + passed * y
    shear: FloatArray = (
        np.multiply.outer(start, mass_before)
        + np.multiply.outer(change, first_before)
        - np.multiply.outer(turning, beside)
        - _spread(np.sum(forces.start_force[..., link, :] * across, axis=-1), place)
    )
    for passed, _, force, _ in _forces_before(forces, link, place):
        shear = shear - passed * _spread(force[1], place)
    return shear


def _bending_moment(forces: LinkForces, link: int, place: FloatArray) -> FloatArray:
    """Moment that the part of a link beyond a cut exerts on the part before it."""
    mass, motion = forces.masses[link], forces.motion
    angle = motion.angle[..., link]
    pull = motion.origin_acceleration[..., link, :] - np.asarray(forces.gravity)
    # Acceleration less gravity of a point (x, y): (ahead - turning x - change y) along and
    # (aside + change x - turning y) across the link.
    ahead = np.sum(pull * direction(angle), axis=-1)
    aside = np.sum(pull * normal(angle), axis=-1)
    turning = motion.angular_velocity[..., link] ** 2
    change = motion.angular_acceleration[..., link]

    def about_the_cut(
        lever: FloatArray, lever_x: FloatArray, lever_y: FloatArray, y: tuple[FloatArray, ...]
    ) -> FloatArray:
        """Moment of mass times acceleration, from sums of mass times lever (1, x, y) and y."""
        return np.asarray(
            np.multiply.outer(aside, lever)
            + np.multiply.outer(change, lever_x)
            - np.multiply.outer(turning, lever_y)
            - np.multiply.outer(ahead, y[0])
            + np.multiply.outer(turning, y[1])
            + np.multiply.outer(change, y[2])
        )

    line, off = mass.mass_per_length, mass.offset
    lever = -line * place**2 / 2
    whole = line * place * off
    moment: FloatArray = about_the_cut(
        lever, -line * place**3 / 6, lever * off, (whole, whole * place / 2, whole * off)
    )
    for fixed, (x, y), lump in _lumps(forces, link):
        passed: FloatArray = np.asarray(lump * (fixed < place), dtype=float)
        arm: FloatArray = passed * (x - place)
        across = (passed * y, passed * y * x, passed * y * y)
        moment = np.asarray(moment + about_the_cut(arm, arm * x, arm * y, across), dtype=float)
    for body in mass.bodies:
        moment = moment + np.multiply.outer(change, body.inertia * (body.position < place))
    start = np.sum(forces.start_force[..., link, :] * normal(angle), axis=-1)
    moment = moment - _spread(forces.start_moment[..., link], place)
    moment = moment + np.multiply.outer(start, place)
    for passed, (at, off_axis), force, torque in _forces_before(forces, link, place):
        turn = (_spread(at, place) - place) * _spread(force[1], place)
        turn = turn - _spread(off_axis * force[0], place) + _spread(torque, place)
        moment = moment - passed * turn
    return moment


def _lumps(forces: LinkForces, link: int) -> Iterator[tuple[float, tuple[float, float], float]]:
    """Where it is fixed, centre of mass in the link's frame and mass of each lump."""
    mass = forces.masses[link]
    for x, lump in zip(mass.point_positions, mass.point_masses, strict=True):
        yield x, (x, 0.0), lump
    for body in mass.bodies:
        yield body.position, body.centre, body.mass


def _forces_before(
    forces: LinkForces, link: int, place: FloatArray
) -> Iterator[
    tuple[FloatArray, tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray], FloatArray]
]:
    """Applied forces of a link: whether before each cut, place, (along, across), torque."""
    angle = forces.motion.angle[..., link]
    for one in (*forces.applied, *forces.on_guides):
        if one.link == link:
            x = np.broadcast_to(one.x, angle.shape)
            along = np.sum(one.force * direction(angle), axis=-1)
            across = np.sum(one.force * normal(angle), axis=-1)
            passed = (_spread(x, place) < place).astype(float)
            y = np.broadcast_to(one.y, angle.shape)
            yield passed, (x, y), (along, across), one.torque


def _spread(values: FloatArray, place: FloatArray) -> FloatArray:
    """Values of shape (...) beside those of cuts: shape (...) or (..., 1)."""
    return values[(..., *[None] * place.ndim)]
