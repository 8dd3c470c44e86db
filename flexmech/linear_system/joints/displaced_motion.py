"""Rigid motion with rigid links displaced, and its links as bodies."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.linkages import RigidMotion, Topology
from flexmech.linkages.body_motion import BodyMotion, dot
from flexmech.linkages.connection_forces import slider_line


@dataclass(frozen=True)
class DisplacedMotion(RigidMotion):
    """Rigid motion whose rigid links, with their frames, are displaced as in an equilibrium.

    Parameters
    ----------
    crank_angle, crank_speed, angle, angular_velocity, angular_acceleration : ndarray
        See :class:`RigidMotion`; batch of shape (B,).
    origin, origin_velocity, origin_acceleration : ndarray
        Likewise.
    turn : ndarray, shape (B, n_links)
        Rotation of each displaced rigid link against the rigid motion in rad; zero of flexible
        links.
    slide : ndarray, shape (B, n_sliders)
        Displacement of each slider along its line in m.
    design : ndarray of int, shape (B,), optional
        As of :class:`RigidMotion`.
    """

    turn: FloatArray
    slide: FloatArray

    @classmethod
    def of(cls, motion: RigidMotion, turn: FloatArray, slide: FloatArray) -> Self:
        """A rigid motion with its rigid links displaced.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        turn : ndarray, shape (B, n_links)
        slide : ndarray, shape (B, n_sliders)
        """
        own = {field.name: getattr(motion, field.name) for field in fields(RigidMotion)}
        own["angle"] = motion.angle + turn
        return cls(**own, turn=turn, slide=slide)

    @property
    def undisplaced(self) -> RigidMotion:
        """The rigid motion itself."""
        own = {field.name: getattr(self, field.name) for field in fields(RigidMotion)}
        own["angle"] = self.angle - self.turn
        return RigidMotion(**own)


def link_bodies(motion: RigidMotion, topology: Topology) -> tuple[BodyMotion, ComplexArray]:
    """Links as bodies, and positions of sliders in the axes of their guides.

    Parameters
    ----------
    motion : RigidMotion
        Batch of shape (B,); its rigid links may be displaced.
    topology : Topology

    Returns
    -------
    bodies : BodyMotion
        Of shape (B, n_links + 1), the ground last.
    slid : ndarray of complex, shape (3, B, n_sliders)
        Places in m, and their first and second time derivative: an acceleration of the rigid
        motion along the line. On the ground the displacement alone.
    """
    bodies = drawn = BodyMotion.of_links(motion)
    slid = np.zeros((3, len(motion.crank_angle), len(topology.sliders)), dtype=complex)
    lines = [slider_line(topology, slider) for slider in topology.sliders]
    if isinstance(motion, DisplacedMotion) and lines:
        slid[0] = motion.slide * np.array([line.along for line in lines])
        if topology.has_moving_guides:
            drawn = BodyMotion.of_links(motion.undisplaced)
    for number, (slider, line) in enumerate(zip(topology.sliders, lines, strict=True)):
        if slider.guide:
            guide = line.second.body
            point = drawn.moving_point(line.first.body, line.first.place)
            relative, relative_1, relative_2 = (
                own - its for own, its in zip(point, drawn.moving_point(guide, 0j), strict=True)
            )
            back, turning = np.conj(drawn.turn[:, guide]), 1j * drawn.turn_1[:, guide]
            changing = turning**2 - 1j * drawn.turn_2[:, guide]
            rate = back * (relative_1 - turning * relative)
            second = back * (relative_2 - 2 * turning * relative_1 + changing * relative)
            slid[0][:, number] += back * relative
            # The point stays on its line: what round-off leaves across it is not motion.
            slid[1][:, number] = line.along * dot(line.along, rate)
            slid[2][:, number] = line.along * dot(line.along, second)
    return bodies, slid


def general_position(topology: Topology) -> RigidMotion:
    """One position with random link angles and origins, for rank decisions.

    Parameters
    ----------
    topology : Topology

    Returns
    -------
    RigidMotion
        Batch of shape (1,) of links at rest, which need not meet.
    """
    random = np.random.default_rng(0)
    count = len(topology.links)
    angle, zero = random.uniform(-np.pi, np.pi, (1, count)), np.zeros((1, count))
    length = max(link.length for link in topology.links)
    origin = length * random.uniform(-1.0, 1.0, (1, count, 2))
    nowhere = np.zeros((1, count, 2))
    return RigidMotion(zero[:, 0], zero[:, 0], angle, zero, zero, origin, nowhere, nowhere)
