"""The linkage driven by its shaft: a linear system in link frames that varies with time.

``M(t) z'' + C(t) z' + K(t) z = f(t)``: the matrices of
:mod:`flexmech.linear_system.link_frames` with all rotation terms, the inertia forces of the
rigid motion and weight as load. Links are reduced to component modes whose static shapes
turn with the pins: here the whole shape moves (Galerkin), because a response in time does
not depend on the frame in which it is written, as frozen eigenvalues do. Axial modes above
the frequencies of interest follow statically: a bowed link stretches when it bends.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexmech.choices import MODES
from flexmech.linear_system import (
    Engine,
    LinkDamping,
    LinkFrames,
    LinkModel,
    Prestress,
    RotationTerms,
    component_modes,
    condense,
    inertia_loads,
)
from flexmech.linkages import CrankDrive, RigidMotion
from flexmech.time_domain.state import LinkState, VibrationState
from flexmech.time_domain.stress_history import LinkStress, StressHistory
from flexmech.types import FloatArray

__all__ = ["DETAIL", "DrivenLinkage", "Equations", "is_reduced"]


# A start at speed shakes more than the lowest modes: component modes are kept up to this
# many times the frequency that the natural frequencies themselves would need.
DETAIL = 8.0
# Axial modes of a link that a bow couples to bending; half of them change nothing visible.
AXIAL_MODES = 6


@dataclass(frozen=True)
class Equations:
    """Equations of motion ``M z'' + C z' + K z = f`` at m instants.

    Parameters
    ----------
    motion : RigidMotion
        Batch of shape (m,).
    stress : list of LinkStress
    mass, damping, stiffness : ndarray, shape (m, n, n)
    force : ndarray, shape (m, n)
    expansion : ndarray, shape (m, size, n)
        From z to the coordinates of the frames, some of which follow statically.
    offset : ndarray, shape (m, size)
        What the loads alone add to those that follow.
    """

    motion: RigidMotion
    stress: list[LinkStress]
    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    force: FloatArray
    expansion: FloatArray
    offset: FloatArray

    def __getitem__(self, where: slice) -> Equations:
        """The equations of some of the instants, for stepping."""
        return replace(
            self,
            mass=self.mass[where],
            damping=self.damping[where],
            stiffness=self.stiffness[where],
            force=self.force[where],
        )

    def quasi_static(self) -> FloatArray:
        """Displacement z that the loads would cause if nothing moved, (m, n)."""
        return np.asarray(np.linalg.solve(self.stiffness, self.force[..., None])[..., 0])


class DrivenLinkage:
    """Linear equations of motion of an engine's links under a drive.

    Parameters
    ----------
    engine : Engine
        With component modes or without; see :func:`is_reduced`.
    drive : CrankDrive
    prestress : {"none", "axial", "equilibrium"}
        ``equilibrium`` linearizes about the quasi-static equilibrium, whose displacement is
        then part of the response.
    modes : int
        Number of natural frequencies that the reduction must get right.
    detail : float
        Multiplies the frequency up to which component modes are kept.
    with_energy : bool
        Whether energies and joint forces will be asked for.

    Attributes
    ----------
    links : tuple of LinkModel
        Reduced.
    bases : tuple of ndarray, shape (n_full, n)
        From each reduced link's coordinates to the engine's.
    frames : LinkFrames
    """

    def __init__(
        self,
        engine: Engine,
        drive: CrankDrive,
        prestress: Prestress = "equilibrium",
        *,
        modes: int = MODES,
        detail: float = DETAIL,
        with_energy: bool = True,
    ) -> None:
        self.engine = engine
        self.drive = drive
        self.prestress = prestress
        self.links, self.bases, follows = _reduced(engine, drive, prestress, modes, detail)
        self.frames = LinkFrames(engine.mechanism.linkage.topology, self.links)
        self._condensed = np.zeros(self.frames.size, dtype=bool)
        for target, condensed in zip(self.frames.targets, follows, strict=True):
            self._condensed[target[condensed]] = True
        self._stress = StressHistory(engine, self.bases, drive, prestress, with_energy=with_energy)

    @property
    def size(self) -> int:
        """Number of independent coordinates."""
        return int(np.sum(~self._condensed))

    def motion(self, time: FloatArray) -> RigidMotion:
        """Rigid motion at times of shape (m,)."""
        return self.drive.motion(self.engine.mechanism.linkage, time)

    def loads(self, motion: RigidMotion) -> list[FloatArray]:
        """Inertia forces of the rigid motion and weight on each reduced link, (m, n)."""
        full = inertia_loads(self.engine.links, motion, self.engine.mechanism.gravity)
        return [load @ basis for load, basis in zip(full, self.bases, strict=True)]

    def equations(self, time: FloatArray, *, still: bool = False) -> Equations:
        """Equations of motion.

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.
        still : bool
            Leave out the rotation terms: what the loads would do if nothing moved.

        Returns
        -------
        Equations
        """
        motion, stress = self.motion(time), self._stress.at(time)
        matrices = self.frames.assemble(
            motion,
            [s.stiffness for s in stress],
            RotationTerms.all_or_none(not still),
            [LinkDamping(s.damping, s.damping) for s in stress],
        )
        force = self._force(motion, stress)
        gone, kept = np.flatnonzero(self._condensed), np.flatnonzero(~self._condensed)
        offset = np.zeros_like(force)
        if not len(gone):
            expansion = np.broadcast_to(np.eye(self.frames.size), matrices.mass.shape)
        else:
            hold = matrices.stiffness[:, gone[:, None], gone]
            offset[:, gone] = np.linalg.solve(hold, force[:, gone, None])[..., 0]
            matrices, expansion = condense(matrices, self._condensed)
            force = force[:, kept] + np.einsum(
                "mgk,mg->mk", expansion[:, gone[:, None], np.arange(len(kept))], force[:, gone]
            )
        return Equations(
            motion,
            stress,
            matrices.mass,
            matrices.damping,
            matrices.stiffness,
            force,
            expansion,
            offset,
        )

    def link_motion(
        self, equations: Equations, vibration: VibrationState
    ) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
        """Coordinates of each reduced link and their time derivatives in its frame.

        Parameters
        ----------
        equations : Equations
            At m instants.
        vibration : VibrationState
            Arrays of shape (m, n).

        Returns
        -------
        list of tuple of ndarray, shape (m, n_link)
        """
        return self.frames.link_motion(equations.motion, *self.expanded(equations, vibration))

    def expanded(
        self, equations: Equations, vibration: VibrationState
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """All coordinates of the frames and their time derivatives, each (m, size).

        Parameters
        ----------
        equations : Equations
            At m instants.
        vibration : VibrationState
            Arrays of shape (m, n).

        Returns
        -------
        tuple of ndarray
        """
        position, velocity, acceleration = (
            (equations.expansion @ part[..., None])[..., 0]
            for part in (vibration.position, vibration.velocity, vibration.acceleration)
        )
        return position + equations.offset, velocity, acceleration

    def link_state(self, equations: Equations, vibration: VibrationState) -> LinkState:
        """State of the engine's links at the first of the instants."""
        parts = self.link_motion(equations, vibration)
        pairs = list(zip(self.bases, parts, strict=True))
        return LinkState(
            displacement=[basis @ q[0] for basis, (q, _, _) in pairs],
            rate=[basis @ rate[0] for basis, (_, rate, _) in pairs],
        )

    def coordinates(self, state: LinkState) -> tuple[FloatArray, FloatArray]:
        """Independent coordinates nearest to a state of the engine's links.

        Nearest by the mass matrix: what component modes cannot show is left out. The
        inverse of :meth:`link_state` for states that they can.

        Parameters
        ----------
        state : LinkState

        Returns
        -------
        ndarray, shape (n,)
            Position z.
        ndarray, shape (n,)
            Velocity z'.
        """
        values = np.zeros((2, self.frames.size))
        for number, (full, basis) in enumerate(zip(self.engine.links, self.bases, strict=True)):
            target = self.frames.targets[number]
            own = np.flatnonzero(target >= 0)
            own = own[~np.isin(own, self.frames.following(number))]
            both = np.stack([state.displacement[number], state.rate[number]], axis=1)
            weighted = basis.T @ full.mass
            nearest = np.linalg.solve(weighted @ basis, weighted @ both)
            values[:, target[own]] = nearest[own].T
        position, velocity = values[:, ~self._condensed]
        return position, velocity

    def unstressed(self) -> FloatArray:
        """Position z at time zero of straight links without axial stress, (n,).

        Zero, except about a bowed equilibrium: there a straight link is, to first order,
        longer by the square of the bow, which would start it with a stress that it does not
        have.
        """
        equations = self.equations(np.zeros(1), still=True)
        parts = [-s.prestress for s in equations.stress]
        inner = self.frames.gather(equations.motion, parts)[0]
        position = np.zeros(self.size)
        axial = np.flatnonzero(self._axial()[~self._condensed])
        if len(axial):
            force = equations.expansion[0].T @ inner
            stiffness = equations.stiffness[0]
            position[axial] = np.linalg.solve(stiffness[np.ix_(axial, axial)], force[axial])
        return position

    def _axial(self) -> NDArray[np.bool_]:
        """Coordinates of the frames that move their own link along its axis."""
        axial = np.zeros(self.frames.size, dtype=bool)
        for number, (link, target) in enumerate(zip(self.links, self.frames.targets, strict=True)):
            own = (target >= 0) & link.is_axial
            own[self.frames.following(number)] = False
            axial[target[own]] = True
        return axial

    def _force(self, motion: RigidMotion, stress: list[LinkStress]) -> FloatArray:
        parts = [-s.prestress for s in stress]
        if self._stress.tells_forces:
            parts = [p + load for p, load in zip(parts, self.loads(motion), strict=True)]
        return self.frames.gather(motion, parts)


def is_reduced(engine: Engine) -> bool:
    """Whether an engine's linear equations in time are reduced to component modes.

    Those of links that are bent without load are not: modes of straight links do not show
    the ends of a deep bow approach each other (2 % of the deflections of a coupler of
    280 mm that is bowed by 8 mm, of which doubling the detail tells a tenth).

    Parameters
    ----------
    engine : Engine

    Returns
    -------
    bool
    """
    return engine.component_modes and not engine.mechanism.is_free_strained


def _reduced(
    engine: Engine, drive: CrankDrive, prestress: Prestress, modes: int, detail: float
) -> tuple[tuple[LinkModel, ...], tuple[FloatArray, ...], tuple[NDArray[np.bool_], ...]]:
    """Links, their bases, and which of their coordinates follow statically."""
    if not is_reduced(engine):
        bases = tuple(np.eye(link.size) for link in engine.links)
        return engine.links, bases, tuple(np.zeros(link.size, dtype=bool) for link in engine.links)
    turn = drive.start_angle + np.linspace(0.0, 2 * np.pi, 73)
    motion = engine.mechanism.linkage.motion(turn, drive.speed)
    reduction = component_modes(
        engine.mechanism.linkage.topology,
        engine.links,
        modes,
        float(np.abs(motion.angular_velocity).max()),
        couples_axially=prestress == "equilibrium",
        detail=detail,
        axial_modes=AXIAL_MODES,
    )
    models = tuple(replace(model, reduced_ends=None) for model in reduction.models)
    bases = tuple(link.basis for link in reduction.links)
    return models, bases, tuple(link.condensed for link in reduction.links)
