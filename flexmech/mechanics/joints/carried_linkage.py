"""A linkage on a frame that moves: three coordinates more, and how they are coupled by inertia.

The coordinates z of the links are those in axes that move with the frame, in which the linkage runs
as on a fixed ground; f are the displacement of the frame's centre of mass along x and y, and its
rotation phi. A point at r from that centre in these axes, which moves there with r' and r'', has
the acceleration, to first order in f::

    r'' + X'' + phi'' J r + 2 phi' J r'

written in the same axes, with J a quarter turn (Shabana, *Dynamics of Multibody Systems*, ch. 5: a
floating frame of reference). So a displaced frame does nothing to the links but for the direction
of weight and loads. The forces on the frame are those of the links' inertia in ground axes: as it
turns, the inertia forces of the rigid motion turn with it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, row_products
from flexmech.choices import Prestress
from flexmech.linkages import RigidMotion
from flexmech.linkages.applied_forces import AXES, Axes, ForceOnLink, forces_of_loads
from flexmech.linkages.motion import cross, direction, normal, quarter_turn
from flexmech.mechanics.joints.link_frames import LinkFrames
from flexmech.mechanics.joints.link_ties import DependentRows
from flexmech.mechanics.links.link_inertia import FIELDS, LinkInertia, field_coefficients
from flexmech.mechanics.links.link_model import LinkModel
from flexmech.mechanics.links.rotation_terms import RotationTerms, SystemMatrices
from flexmech.mechanics.loads.attached_points import AttachedPoint, PointJacobian
from flexmech.mechanics.loads.connectors import ConnectedMatrices
from flexmech.mechanism import Mechanism, SprungFrame

COORDINATES = 3
"""Coordinates of a frame: displacement of its centre of mass along x and y, rotation."""


@dataclass(frozen=True)
class CarriedLinkage:
    """Links of a linkage, and the frame on springs that carries them.

    Parameters
    ----------
    mechanism : Mechanism
        With the frame.
    frames : LinkFrames
    inertias, of_ends : tuple of LinkInertia
        Inertia of each link by its coordinates, and by those of its joined ends alone, which carry
        nothing with them: see :class:`flexmech.mechanics.links.link_model.EndMatrices`.
    rigid : tuple of ndarray, shape (n_full, 3)
        Rigid of each unreduced link for unit displacements along and across it and unit rotation.
    """

    mechanism: Mechanism
    frames: LinkFrames
    inertias: tuple[LinkInertia, ...]
    of_ends: tuple[LinkInertia, ...]
    rigid: tuple[FloatArray, ...]

    @classmethod
    def of(
        cls,
        mechanism: Mechanism,
        frames: LinkFrames,
        links: Sequence[LinkModel],
        bases: Sequence[FloatArray] | None = None,
    ) -> Self | None:
        """Links of a mechanism, reduced or not, on its frame; None where that stands.

        Parameters
        ----------
        mechanism : Mechanism
        frames : LinkFrames
        links : sequence of LinkModel
            Unreduced.
        bases : sequence of ndarray, shape (n_full, n_link), optional
            From the coordinates of ``frames`` to those of the unreduced links.

        Returns
        -------
        CarriedLinkage or None
        """
        if mechanism.frame is None:
            return None
        if bases is None:
            bases = [np.eye(link.size) for link in links]
        inertias, of_ends, rigid = [], [], []
        for reduced, full, basis in zip(frames.links, links, bases, strict=True):
            inertias.append(LinkInertia.of(reduced, full, basis))
            alone = reduced.reduced_ends is not None
            unit = full.end_basis(reduced.size, reduced.kept_ends) if alone else basis
            of_ends.append(LinkInertia.of(reduced, full, unit))
            fields = [getattr(full.fields, name) for name in FIELDS[:COORDINATES]]
            rigid.append(np.stack(fields, axis=1))
        return cls(mechanism, frames, tuple(inertias), tuple(of_ends), tuple(rigid))

    @property
    def frame(self) -> SprungFrame:
        """The frame that carries the linkage."""
        assert self.mechanism.frame is not None
        return self.mechanism.frame

    @property
    def gravity(self) -> tuple[float, float]:
        """In ground axes, m/s^2."""
        return self.mechanism.gravity

    def connected(
        self, links: ConnectedMatrices | None, motion: RigidMotion, prestress: Prestress
    ) -> ConnectedMatrices:
        """Matrices of connectors of the linkage, with the dampers of the frame.

        Parameters
        ----------
        links : ConnectedMatrices or None
            In the coordinates of ``frames``, (B, size, size); None where there are none.
        motion : RigidMotion
            Batch of shape (B,).
        prestress : {"none", "axial", "equilibrium"}
            As of :meth:`added`.

        Returns
        -------
        ConnectedMatrices
            (B, size + 3, size + 3), with the stiffness of follower forces on the frame.
        """
        size, batch = self.frames.size, len(motion.crank_angle)
        stiffness, damping, rate = np.zeros((3, batch, size + COORDINATES, size + COORDINATES))
        if links is not None:
            stiffness[:, :size, :size] = links.stiffness
            damping[:, :size, :size] = links.damping
            rate[:, :size, :size] = links.rate_stiffness
        damping[:, size:, size:] = self.frame.damping
        follow = self._of_followers(motion, None, prestress)
        stiffness[:, size:, :size], stiffness[:, size:, size:] = follow.on_frame, follow.frame
        conservative = not self.frame.damping.any() and (links is None or links.is_conservative)
        return ConnectedMatrices(stiffness, damping, rate, conservative)

    def fields(self, motion: RigidMotion) -> FloatArray:
        """Rigid displacement of each link by the frame's coordinates.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        ndarray, shape (n_links, B, 3, 3)
            Displacement of its start along and across its frame, and rotation.
        """
        axes = np.stack([direction(motion.angle), normal(motion.angle)], axis=-2)
        arm = motion.origin - np.asarray(self.frame.centre)
        rigid = np.zeros((*motion.angle.shape, 3, COORDINATES))
        rigid[..., :2, :2] = axes
        rigid[..., :2, 2] = (axes @ quarter_turn(arm)[..., None])[..., 0]
        rigid[..., 2, 2] = 1.0
        return np.swapaxes(rigid, 0, 1)

    def on_frame(self, motion: RigidMotion, loads: Sequence[FloatArray]) -> FloatArray:
        """Forces and moment on the frame of loads on the links that act from outside.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        loads : sequence of ndarray, shape (B, n_full) or (n_full,)
            Loads on each unreduced link in its frame, in N and N m. A row that reads a displacement
            against the ground has what the coordinates of the frame add to it.

        Returns
        -------
        ndarray, shape (B, 3)
        """
        resultants = (load @ rigid for load, rigid in zip(loads, self.rigid, strict=True))
        pairs = zip(self.fields(motion), resultants, strict=True)
        return np.asarray(
            sum((resultant[..., None, :] @ field)[:, 0] for field, resultant in pairs)
        )

    def added(
        self,
        motion: RigidMotion,
        matrices: SystemMatrices,
        terms: RotationTerms,
        expansion: FloatArray | None = None,
        time: FloatArray | None = None,
        *,
        prestress: Prestress = "equilibrium",
        followers: bool = True,
    ) -> SystemMatrices:
        """Matrices of the linkage with the coordinates of the frame, which come last.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        matrices : SystemMatrices
            Matrices of the linkage on a frame that stands, (B, n, n) each.
        terms : RotationTerms
        expansion : ndarray, shape (B, size, n), optional
            From these n coordinates to those of the link frames; they are the same by default.
        time : ndarray, shape (B,), optional
            In s; loads over time are left out without it.
        prestress : {"none", "axial", "equilibrium"}
            ``none`` leaves out that follower forces rotate with their sections.
        followers : bool
            Whether the stiffness of follower forces counts, which is not symmetric.

        Returns
        -------
        SystemMatrices
            (B, n + 3, n + 3) each.
        """
        blocks = self._blocks(motion, terms)
        self._add_dead_loads(motion, time, blocks[2])
        if followers:
            follow = self._of_followers(motion, time, prestress)
            blocks[2].on_frame[:] += follow.on_frame
            blocks[2].frame[:] += follow.frame

        def bordered(linkage: FloatArray, block: _Block) -> FloatArray:
            by_frame, on_frame = block.by_frame, block.on_frame
            if expansion is not None:
                by_frame = np.swapaxes(expansion, 1, 2) @ by_frame
                on_frame = on_frame @ expansion
            count = linkage.shape[1]
            total = np.empty((len(linkage), count + COORDINATES, count + COORDINATES))
            total[:, :count, :count] = linkage
            total[:, :count, count:] = by_frame
            total[:, count:, :count] = on_frame
            total[:, count:, count:] = block.frame
            return total

        return SystemMatrices(
            bordered(matrices.mass, blocks[0]),
            bordered(matrices.damping, blocks[1]),
            bordered(matrices.stiffness, blocks[2]),
        )

    def load(self, motion: RigidMotion, time: FloatArray | None = None) -> FloatArray:
        """Force of weight, of loads and of the inertia of the rigid motion on the frame.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        time : ndarray, shape (B,), optional
            In s; loads over time are left out without it.

        Returns
        -------
        ndarray, shape (B, 3)
            Along x and y in N, and the moment about the frame's centre in N m.
        """
        gravity = np.asarray(self.gravity)
        total = np.zeros((len(motion.crank_angle), COORDINATES))
        total[:, :2] += self.frame.mass * gravity
        fields = self.fields(motion)
        for number, inertia in enumerate(self.inertias):
            pull = self._acceleration(motion, number, gravity)
            total -= np.einsum("bkc,bk->bc", fields[number], (pull @ inertia.rigid)[:, :3])
        for push, arm in self._pushes(motion, time, AXES):
            moment = cross(arm, push.force) + push.torque
            total += np.column_stack([push.force, moment])
        return total

    def _pushes(
        self, motion: RigidMotion, time: FloatArray | None, axes: Sequence[Axes]
    ) -> Iterator[tuple[ForceOnLink, FloatArray]]:
        """Each load in one of these axes, in ground axes, and its arm (B, 2) from the centre."""
        topology = self.mechanism.linkage.topology
        acting = (load for load in self.mechanism.loads if load.axes in axes)
        loads = [load for load in acting if load.over != "time" or time is not None]
        for push in forces_of_loads(topology, motion, loads, 0.0 if time is None else time):
            yield push, motion.position(push.link, push.x) - np.asarray(self.frame.centre)

    def _moved(self, motion: RigidMotion, push: ForceOnLink) -> FloatArray:
        """Displacement and rotation of a load's point by the coordinates, (B, 3, size)."""
        length = self.mechanism.linkage.topology.links[push.link].length
        point = AttachedPoint.of(self.frames.links, push.link, float(push.x) / length, length)
        return PointJacobian.of(point, self.frames, motion).value

    def _add_dead_loads(
        self, motion: RigidMotion, time: FloatArray | None, stiffness: _Block
    ) -> None:
        """Add to the stiffness that dead loads keep their directions as the frame rotates."""
        for push, arm in self._pushes(motion, time, ("ground",)):
            moved, force = self._moved(motion, push)[:, :2], quarter_turn(push.force)
            leaning = np.einsum("bk,bkn->bn", force, moved)
            stiffness.by_frame[:, :, 2] += leaning
            stiffness.on_frame[:, 2] += leaning
            stiffness.frame[:, 2, 2] += row_products(arm, push.force)

    def _of_followers(
        self, motion: RigidMotion, time: FloatArray | None, prestress: Prestress
    ) -> _Block:
        """Stiffness by follower forces on the frame, which does nothing to them on the links.

        They rotate with it and, unless the prestress is ``none``, with their sections.
        """
        no_frame = np.zeros((COORDINATES, COORDINATES))
        stiffness = _Block.of(no_frame, len(motion.crank_angle), self.frames.size)
        for push, arm in self._pushes(motion, time, ("link",)):
            moved, force = self._moved(motion, push), quarter_turn(push.force)
            stiffness.frame[:, :2, 2] -= force
            stiffness.on_frame[:, 2] += np.einsum("bk,bkn->bn", force, moved[:, :2])
            if prestress != "none":
                stiffness.on_frame[:, :2] -= force[..., None] * moved[:, None, 2]
                moment = row_products(arm, push.force)
                stiffness.on_frame[:, 2] -= moment[:, None] * moved[:, 2]
        return stiffness

    def inertial_shapes(
        self, motion: RigidMotion, links: Sequence[NDArray[Any]], moved: NDArray[Any]
    ) -> NDArray[Any]:
        """Shapes scaled so that their products are weighted by mass.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        links : sequence of ndarray, shape (B, n_link, m)
            Coordinates of the links in the axes of the frame.
        moved : ndarray, shape (B, 3, m)
            Those of the frame.

        Returns
        -------
        ndarray, shape (B, N, m)
        """
        fields = self.fields(motion)
        parts = [np.sqrt(self.frame.inertia_matrix) @ moved]
        for root, field, coordinates in zip(self._roots, fields, links, strict=True):
            parts.append(root.T @ np.concatenate([coordinates, field @ moved], axis=1))
        return np.concatenate(parts, axis=1)

    @cached_property
    def _roots(self) -> list[FloatArray]:
        """Square root of each link's mass, by its coordinates and by its rigid displacement."""
        roots = []
        for inertia in self.inertias:
            coupled = inertia.mass[:, :3]
            both = np.block([[inertia.model.mass, coupled], [coupled.T, inertia.rigid[:3, :3]]])
            values, vectors = np.linalg.eigh(both)
            roots.append(vectors * np.sqrt(np.maximum(values, 0.0)))
        return roots

    def _acceleration(
        self, motion: RigidMotion, link: int, gravity: FloatArray | None = None
    ) -> FloatArray:
        """Coefficients (B, 4) of a link's fields by its rigid acceleration, less that of weight."""
        pull = motion.origin_acceleration[:, link] - (0.0 if gravity is None else gravity)
        speed = motion.angular_velocity[:, link]
        turning = motion.angular_acceleration[:, link]
        return field_coefficients(motion.angle[:, link], pull, turning, -(speed**2))

    def _blocks(self, motion: RigidMotion, terms: RotationTerms) -> list[_Block]:
        """Mass, damping and stiffness of the frame."""
        batch, frame = len(motion.crank_angle), self.frame
        of_frame = [frame.inertia_matrix, frame.damping, frame.stiffness]
        blocks = [_Block.of(matrix, batch, self.frames.size) for matrix in of_frame]
        mass, damping, stiffness = blocks
        # An acceleration of the frame, the rotation of weight, that of the rigid acceleration.
        pushed, swung, leaning, turned = [], [], [], []
        accelerates = terms.centripetal or terms.tangential
        quarter = np.array([-self.gravity[1], self.gravity[0]])
        for number, (field, inertia) in enumerate(
            zip(self.fields(motion), self.inertias, strict=True)
        ):
            across = np.swapaxes(field, 1, 2)
            pushed.append(inertia.mass[:, :3] @ field)
            mass.frame[:] += across @ inertia.rigid[:3, :3] @ field
            speed = motion.angular_velocity[:, number]
            along, beside = _along_and_across(motion, number, motion.origin_velocity[:, number])
            coriolis = 2 * np.column_stack([-beside, along, np.zeros(batch), -speed])
            swung.append(terms.coriolis * coriolis @ inertia.mass.T)
            by_turning = np.einsum("bkc,bk->bc", field, (coriolis @ inertia.rigid)[:, :3])
            damping.frame[:, :, 2] += terms.coriolis * by_turning
            x, y, alpha, outward = self._acceleration(motion, number).T
            quarter_on = accelerates * np.column_stack([-y, x, outward, -alpha])
            turned.append(quarter_on @ inertia.mass.T)
            by_angle = np.einsum("bkc,bk->bc", field, (quarter_on @ inertia.rigid)[:, :3])
            # A moment about the centre does not change as everything turns about it.
            stiffness.frame[:, :2, 2] += by_angle[:, :2]
            weight = np.column_stack(
                _along_and_across(motion, number, np.tile(quarter, (batch, 1)))
            )
            leaning.append(weight @ inertia.mass[:, :2].T)
            stiffness.frame[:, 2, 2] += self._weight_about_centre(motion, number)
            self._add_rows(damping, stiffness, motion, terms, number, across)
        gather = self.frames.gather
        mass.by_frame[:] = gather(motion, pushed)
        mass.on_frame[:] = np.swapaxes(mass.by_frame, 1, 2)
        damping.by_frame[:, :, 2] = gather(motion, swung)
        stiffness.by_frame[:, :, 2] = gather(motion, leaning)
        # The displaced links have the rigid acceleration at another arm.
        stiffness.on_frame[:, 2] += stiffness.by_frame[:, :, 2] - gather(motion, turned)
        return blocks

    def _add_rows(
        self,
        damping: _Block,
        stiffness: _Block,
        motion: RigidMotion,
        terms: RotationTerms,
        link: int,
        across: FloatArray,
    ) -> None:
        """Add forces on the frame by velocities and displacements of a link to the blocks.

        ``across`` (B, 3, 3) has the link's fields by the frame's coordinates, transposed.
        """
        speed = motion.angular_velocity[:, link, None, None]
        alpha = motion.angular_acceleration[:, link, None, None]
        inertia, of_ends = self.inertias[link], self.of_ends[link]

        def moving(
            rows: FloatArray, rate: Callable[[DependentRows], FloatArray] | None = None
        ) -> FloatArray:
            return self.frames.by_independent(motion, link, across @ rows[:, :3].T, rate)

        turned = moving(inertia.turned)
        if terms.coriolis:
            carried = moving(of_ends.mass, lambda tie: tie.rate)
            damping.on_frame[:] += 2 * carried - 2 * speed * turned
        if terms.tangential:
            stiffness.on_frame[:] -= alpha * turned
        if terms.centripetal:
            stiffness.on_frame[:] -= speed**2 * moving(inertia.translational)
            stiffness.on_frame[:] -= 2 * speed * moving(of_ends.turned, lambda tie: tie.rate)
        stiffness.on_frame[:] += moving(of_ends.mass, lambda tie: tie.acceleration(terms))

    def _weight_about_centre(self, motion: RigidMotion, link: int) -> FloatArray:
        """Virial of a link's weight about the frame's centre in N m, (B,)."""
        rigid = self.inertias[link].rigid
        angle = motion.angle[:, link]
        first = rigid[3, 0] * direction(angle) + rigid[3, 1] * normal(angle)
        arm = motion.origin[:, link] - np.asarray(self.frame.centre)
        return np.asarray((rigid[0, 0] * arm + first) @ np.asarray(self.gravity))


@dataclass(frozen=True)
class _Block:
    """Parts of a matrix: of the links by the frame, of the frame by the links, and its own.

    Parameters
    ----------
    by_frame : ndarray, shape (B, size, 3)
    on_frame : ndarray, shape (B, 3, size)
    frame : ndarray, shape (B, 3, 3)
    """

    by_frame: FloatArray
    on_frame: FloatArray
    frame: FloatArray

    @classmethod
    def of(cls, frame: FloatArray, batch: int, size: int) -> Self:
        """Matrices of a frame alone."""
        return cls(
            np.zeros((batch, size, COORDINATES)),
            np.zeros((batch, COORDINATES, size)),
            np.tile(frame, (batch, 1, 1)),
        )


def _along_and_across(
    motion: RigidMotion, link: int, vector: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Components of vectors (B, 2) of the ground along and across a link, (B,) each."""
    angle = motion.angle[:, link]
    return np.sum(vector * direction(angle), axis=1), np.sum(vector * normal(angle), axis=1)
