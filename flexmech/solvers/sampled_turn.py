"""Stressed links of a running linkage at evenly spaced crank angles of a turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import FourierSeries
from flexmech.linkages import ConstantSpeed, RigidMotion
from flexmech.mechanics import (
    COORDINATES,
    CarriedLinkage,
    ConnectedMatrices,
    Engine,
    LinkFrames,
    LinkModel,
    Prestress,
    RotationTerms,
    StressedLinks,
    SystemMatrices,
    all_constant,
    body_turns,
    has_constant_tangents,
    has_relative_motion,
    is_constant_turn,
)
from flexmech.mechanics.running.driven_linkage import (
    prestressed_links,
    unreduced_links,
)

# Times the frequency up to which component modes are kept for the natural frequencies alone: the
# moving subspace is that of a few more modes than are asked for.
DETAIL = 2.0


@dataclass(frozen=True)
class SampledTurn:
    """Links in component modes at N crank angles, and the linkage's frozen natural modes.

    Parameters
    ----------
    motion : RigidMotion
        Batch of shape (N,): a turn of the crank in the order of time.
    models : tuple of LinkModel
        Links in component modes whose constraint modes rotate with the pins.
    bases : tuple of ndarray, shape (n_full, n_link)
        From each reduced link's coordinates to the engine's.
    unreduced : tuple of LinkModel
    tangent, damping : list of ndarray, shape (n_link, n_link) or (N, n_link, n_link)
        Tangent stiffness and damping matrix of each reduced link.
    damping_stiffness : list of ndarray, shape (N, n_link, n_link)
        Derivative of the damping forces of each by its displacement; empty about a state at rest.
    frames : LinkFrames
        Frames of the reduced links.
    crank_speed : float
        In rad/s.
    rigid_modes : int
        How many of the natural modes, the first ones, deform nothing: that of a free shaft.
    connected : ConnectedMatrices or None
        Connected of springs, loads and guides, and of dampers of a frame on springs; None without
        them.
    displaced : RigidMotion
        The motion whose rigid links are where their stress has turned them.
    turns : list of list of ndarray, shape (N,), or None
        Turns of bodies on the links; see :func:`flexmech.mechanics.body_turns`.
    carried : CarriedLinkage or None
        With the frame on springs that carries the linkage: its three coordinates are the last.
    """

    motion: RigidMotion
    models: tuple[LinkModel, ...]
    bases: tuple[FloatArray, ...]
    unreduced: tuple[LinkModel, ...]
    tangent: list[FloatArray]
    damping: list[FloatArray]
    damping_stiffness: list[FloatArray]
    frames: LinkFrames
    crank_speed: float
    rigid_modes: int
    connected: ConnectedMatrices | None
    displaced: RigidMotion
    turns: list[list[FloatArray]] | None
    carried: CarriedLinkage | None = None

    @classmethod
    def of(
        cls,
        engine: Engine,
        motion: RigidMotion,
        stressed: StressedLinks,
        prestress: Prestress,
        modes: int,
        fastest: float | None = None,
    ) -> Self:
        """Reduce an engine's stressed links.

        Parameters
        ----------
        engine : Engine
        motion : RigidMotion
            Batch of shape (N,) at one crank speed.
        stressed : StressedLinks
            At these positions.
        prestress : {"none", "axial", "equilibrium"}
            Level by which the component modes of the links are chosen.
        modes : int
            Number of natural frequencies for which the reduction is accurate.
        fastest : float, optional
            Crank speed in rad/s up to which the component modes must do; that of the motion by
            default.

        Returns
        -------
        SampledTurn
        """
        speed = float(motion.crank_speed[0])
        # What is constant is solved exactly, in all coordinates.
        reduces = not (is_constant_turn(engine, motion) or engine.turns_as_one_body)
        links = (
            prestressed_links(
                engine,
                ConstantSpeed(fastest or speed),
                prestress,
                modes + engine.rigid_modes,
                DETAIL,
            )
            if reduces
            else unreduced_links(engine)
        )
        models, bases = tuple(x.reduced for x in links), tuple(x.basis for x in links)
        frames = LinkFrames(engine.topology, models)
        damping = stressed.damping or [link.damping for link in engine.links]

        def reduced(matrices: Sequence[FloatArray]) -> list[FloatArray]:
            return [b.T @ matrix @ b for b, matrix in zip(bases, matrices, strict=True)]

        displaced = engine.frames.displaced(motion, stressed.displacement)
        connected = engine.connected_matrices(frames, displaced, prestress, stressed)
        carried = CarriedLinkage.of(engine.mechanism, frames, engine.links, bases)
        if carried is not None:
            connected = carried.connected(connected, motion, prestress)
        return cls(
            motion=motion,
            models=models,
            bases=bases,
            unreduced=engine.links,
            tangent=reduced(stressed.tangent),
            damping=reduced(damping),
            damping_stiffness=reduced(stressed.damping_stiffness)
            if stressed.damping_stiffness
            else [],
            frames=frames,
            crank_speed=speed,
            rigid_modes=engine.rigid_modes,
            connected=connected,
            displaced=displaced,
            turns=body_turns(engine.links, stressed.displacement),
            carried=carried,
        )

    @property
    def size(self) -> int:
        """Number n of coordinates: those of ``frames``, and of a frame on springs."""
        return self.frames.size + (0 if self.carried is None else COORDINATES)

    def link_coordinates(
        self, vectors: FloatArray, angles: slice | None = None
    ) -> list[FloatArray]:
        """Coordinates (B, n_link, m) of each link by vectors (B, n, m) at all or some angles."""
        motion = self.displaced if angles is None else self.displaced.at(angles)
        return self.frames.link_coordinates(motion, vectors[:, : self.frames.size])

    def weighted_shapes(self, vectors: FloatArray, angles: slice) -> FloatArray:
        """Shapes (B, n, m) at some of the angles, their products weighted by mass; (B, N, m)."""
        coordinates = self.link_coordinates(vectors, angles)
        if self.carried is not None:
            moved = vectors[:, self.frames.size :]
            return self.carried.inertial_shapes(self.motion.at(angles), coordinates, moved)
        weighted = [
            link.mass_root.T @ reduction @ q
            for link, reduction, q in zip(self.unreduced, self.bases, coordinates, strict=True)
        ]
        return np.concatenate(weighted, axis=1)

    def assembled(self, terms: RotationTerms) -> SystemMatrices:
        """Matrices (N, n, n) of the undamped links, and of a frame on springs that carries them.

        Without what is ``connected``.
        """
        undamped = [np.zeros((1, 1)) for _ in self.models]
        matrices = self.frames.assemble(
            self.displaced, self.tangent, terms, undamped, turns=self.turns
        )
        if self.carried is None:
            return matrices
        return self.carried.added(self.motion, matrices, terms, followers=False)

    @property
    def has_relative_motion(self) -> bool:
        """Whether links rotate or slide against each other, so that shapes vary."""
        return has_relative_motion(self.frames.topology)

    @cached_property
    def is_constant(self) -> bool:
        """Whether all matrices are constant over the turn.

        Those of links, springs, loads and guides.
        """
        if self.has_relative_motion or self.carried is not None:
            return False
        if not all_constant(m for m in (*self.tangent, *self.damping) if m.ndim == 3):
            return False
        return self.connected is None or has_constant_tangents(self.connected, self.motion)

    @property
    def period(self) -> float:
        """Time of a turn in s."""
        return 2 * np.pi / abs(self.crank_speed)

    @cached_property
    def frame_speed(self) -> FloatArray:
        """Angular velocities of the link frames, displaced rigid links included, (N, n_links)."""
        turned = self.displaced.angle - self.motion.angle
        if not turned.any():
            return self.motion.angular_velocity
        return self.motion.angular_velocity + self.rate(turned)

    def rate(self, samples: FloatArray) -> FloatArray:
        """Time derivative of a periodic function sampled over the turn, (N, ...)."""
        return FourierSeries.through(samples).rate().samples(len(samples)) / self.period

    def series(self, samples: FloatArray) -> FourierSeries:
        """Fourier series through samples (N, ...); constant where all is constant over the turn."""
        if self.is_constant:
            return FourierSeries.constant(samples.mean(axis=0))
        return FourierSeries.through(samples)

    @property
    def mass(self) -> FloatArray:
        """Mass matrix in the coordinates of ``frames``, (N, n, n)."""
        return self._frozen[0]

    @property
    def stiffness(self) -> FloatArray:
        """Stiffness in the coordinates of ``frames``, its part that has a potential, (N, n, n)."""
        return self._frozen[3]

    @property
    def frozen_squares(self) -> FloatArray:
        """Squares of the natural frequencies without rotation terms, (N, n) in (rad/s)^2.

        Negative where the linkage is statically unstable.
        """
        return self._frozen[1]

    @cached_property
    def static_squares(self) -> FloatArray:
        """Least square of a natural frequency at each crank angle, (N,) in (rad/s)^2.

        Beyond rigid modes. It is negative where the linkage is statically unstable: where forces
        follow, the least real eigenvalue of their unsymmetric stiffness counts.
        """
        if self.connected is None or self.connected.is_conservative:
            return np.asarray(self.frozen_squares[:, self.rigid_modes])
        modes, circulatory = self.frozen_modes, self.connected.circulatory
        squares = np.swapaxes(modes, 1, 2) @ (circulatory @ modes)
        diagonal = np.arange(squares.shape[1])
        squares[:, diagonal, diagonal] += self.frozen_squares
        values = np.linalg.eigvals(squares).astype(complex)
        order = np.argsort(np.abs(values), axis=1)[:, self.rigid_modes :]
        values = np.take_along_axis(values, order, axis=1)
        # Pairs of complex eigenvalues vibrate.
        return np.asarray(np.where(np.imag(values) == 0, np.real(values), np.inf).min(axis=1))

    @property
    def frozen_modes(self) -> FloatArray:
        """Natural modes without rotation terms, (N, n, n): one a column, of unit modal mass."""
        return self._frozen[2]

    def subspace(self, count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Subspaces of the lowest natural modes at all crank angles, aligned to a fixed one.

        Parameters
        ----------
        count : int
            Number m of modes.

        Returns
        -------
        ndarray, shape (n, m)
            Basis of the subspace that has most in common with those at all crank angles.
        ndarray, shape (N, m, m)
        ndarray, shape (N,)
            See :meth:`aligned`.
        """
        if count not in self._subspaces:
            weight = np.linalg.cholesky(self.mass.mean(axis=0)).T
            modes = self.frozen_modes[:, :, :count]
            span = np.linalg.qr(weight @ modes)[0]
            average = (span @ np.swapaxes(span, 1, 2)).mean(axis=0)
            most = np.linalg.eigh(average)[1][:, -count:]
            fixed = np.asarray(np.linalg.solve(weight, most))
            self._subspaces[count] = fixed, *self.aligned(count, fixed)
        return self._subspaces[count]

    def aligned(self, count: int, fixed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Combinations of the lowest natural modes that are nearest to a fixed basis.

        Parameters
        ----------
        count : int
            Number m of modes.
        fixed : ndarray, shape (n, m)

        Returns
        -------
        ndarray, shape (N, m, m)
            Orthogonal: from the combinations to the modes.
        ndarray, shape (N,)
            Least part that a direction of them has in common with the fixed basis.
        """
        modes = self.frozen_modes[:, :, :count]
        left, common, right = np.linalg.svd(np.swapaxes(modes, 1, 2) @ self.mass @ fixed)
        return left @ right, common.min(axis=1)

    @cached_property
    def _subspaces(self) -> dict[int, tuple[FloatArray, FloatArray, FloatArray]]:
        return {}

    @cached_property
    def _frozen(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        matrices = self.assembled(RotationTerms.all_or_none(False))
        if self.connected is not None:
            potential = self.connected.potential
            matrices = replace(matrices, stiffness=matrices.stiffness + potential)
        half = np.linalg.inv(np.linalg.cholesky(matrices.mass))
        across = np.swapaxes(half, 1, 2)
        squares, vectors = np.linalg.eigh(half @ matrices.stiffness @ across)
        return matrices.mass, squares, across @ vectors, matrices.stiffness
