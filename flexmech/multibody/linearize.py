"""Linearization in link frames from Exudyn's absolute coordinates, and static equilibrium."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import (
    LESS_LOADED,
    LOAD_STEPS,
    DeadMoments,
    EquilibriumError,
    refuse_positions,
)
from flexmech.linkages import RigidMotion
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import ROUND_OFF
from flexmech.multibody.library import load_exudyn
from flexmech.multibody.link_parts import BeamPart, RigidPart, turn_vectors
from flexmech.multibody.rigid_tangents import geometric_stiffness, line_forces
from flexmech.multibody.static_model import (
    StaticModel,
    set_tolerance,
    simulation_settings,
    solve_static,
    static_settings,
)

# How often dampers are turned into their lines. Each time leaves less than a hundredth of the
# change, so that twice leave 3e-7 of the forces and four times their round-off.
DAMPER_TURNS = 8


def linearized(
    assembly: LinkAssembly, settings: Any, state: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mass, stiffness and damping matrix in Exudyn's coordinates.

    Exudyn linearizes about the initial state, whatever was solved before.

    Parameters
    ----------
    assembly : LinkAssembly
    settings : exudyn.SimulationSettings
    state : ndarray, shape (size,)
        Exudyn's coordinates, less the reference ones.

    Returns
    -------
    mass, stiffness, damping : ndarray, shape (size, size)
    """
    initial = load_exudyn().ConfigurationType.Initial
    assembly.mbs.systemData.SetODE2Coordinates(state, initial)
    mass, stiffness, damping = map(np.array, assembly.mbs.ComputeLinearizedSystem(settings)[:3])
    for _, part in assembly.beams:
        if not part.section.damping.any:
            # Bodies off their nodes leave the round-off of differences by velocities.
            damping[part.coordinates] = 0.0
    return mass, stiffness, damping


@dataclass(frozen=True)
class StaticEquilibrium:
    """Quasi-static equilibrium over a batch of positions, link by link, in link frames.

    Parameters
    ----------
    displacement : list of ndarray, shape (B, n_link)
    tangent, damping : list of ndarray, shape (B, n_link, n_link)
    line_force : ndarray, shape (B, n_sliders)
        Force of each line on the end that slides on it, along the line's normal, in N.
    """

    displacement: list[FloatArray]
    tangent: list[FloatArray]
    damping: list[FloatArray]
    line_force: FloatArray


def static_equilibrium(
    model: StaticModel,
    motion: RigidMotion,
    loads: list[FloatArray],
    dead: DeadMoments,
) -> StaticEquilibrium:
    """Quasi-static equilibrium of each position and its tangent stiffness.

    Parameters
    ----------
    model : StaticModel
    motion : RigidMotion
        Batch of shape (B,).
    loads : list of ndarray, shape (B, n_link)
        Forces on each link in its frame.
    dead : DeadMoments
        Of bodies and rigid links.

    Returns
    -------
    StaticEquilibrium

    Raises
    ------
    ComputationError
        If Exudyn's static solver does not converge; names the crank angle and speed.
    """
    assembly, batch = model.assembly, len(motion.crank_angle)
    tangents = _Tangents(model, batch)
    relative = motion.angle - motion.angle[:, assembly.base, None]
    applied, settings = _applied(model, motion, loads, dead), static_settings()
    round_off = ROUND_OFF * assembly.nodal_force_scale
    deformation = np.zeros(assembly.size)
    displacement = np.empty((batch, assembly.size))
    line_force = np.zeros((batch, len(model.sliders)))
    for number in range(batch):
        pose = model.move_to(motion, number)
        forces, couples = (values[number] for values in applied)
        model.loads.set(forces, couples)
        loaded = float(np.abs(forces).sum()) + model.swelling_force
        loaded += 0.0 if model.applied is None else model.applied.scale_of_forces
        set_tolerance(settings, loaded, round_off)
        start = pose + assembly.turned(deformation, relative[number])
        if not solve_static(assembly, settings, assembly.nodes.to_nodes(start)):
            _solve_in_steps(model, settings, pose, forces, couples, motion, number)
        for _ in range(DAMPER_TURNS):
            if model.applied is None or not model.applied.converge():
                break
            solved = np.array(assembly.mbs.systemData.GetODE2Coordinates())
            solve_static(assembly, settings, solved)
        state = assembly.nodes.to_axis(assembly.mbs.systemData.GetODE2Coordinates())
        turning = geometric_stiffness(model, state, couples)
        line_force[number] = line_forces(model)
        moved = assembly.deformation(state, pose)
        deformation = displacement[number] = assembly.turned(moved, -relative[number])
        tangents.linearize_at(number, settings[0], state, forces, turning)
    stiffness, damping = tangents.in_link_frames(relative)
    return StaticEquilibrium(
        displacement=[displacement[:, part.coordinates] for part in assembly.parts],
        tangent=stiffness,
        damping=damping,
        line_force=line_force,
    )


def _applied(
    model: StaticModel, motion: RigidMotion, loads: list[FloatArray], dead: DeadMoments
) -> tuple[FloatArray, FloatArray]:
    """Arguments over a batch of :meth:`flexmech.multibody.static_loads.StaticLoads.set`.

    Forces (B, n_link) transformed from link frames to the crank's frame, and couples.
    """
    assembly = model.assembly
    relative = motion.angle - motion.angle[:, assembly.base, None]
    forces = np.concatenate(loads, axis=1)
    places = {turned.angle: number for number, turned in enumerate(model.loads.turning)}
    couples = np.zeros((len(forces), len(places), 2))
    for number, (link, row) in enumerate(zip(dead.links.tolist(), dead.rows, strict=True)):
        part = assembly.parts[link]
        angle = part.coordinates.start + row
        if not isinstance(part, RigidPart):
            # What turns with the body is not on the node as well.
            forces[:, angle] -= dead.moment[number]
        couple = couples[:, places[angle]]
        couple[:] = np.transpose([dead.virial[number], dead.moment[number]]) / part.length
        turn_vectors(couple, (np.array([0]), np.array([1])), relative[:, link])
    for link, part in enumerate(assembly.parts):
        own, angle = forces[:, part.coordinates], relative[:, link]
        turn_vectors(own, part.force_vectors, angle)
    return forces, couples


def running_tangents(
    model: StaticModel, motion: RigidMotion, displacement: Sequence[FloatArray]
) -> tuple[list[FloatArray], list[FloatArray]]:
    """Tangent stiffness and damping of each link in its frame in given states.

    Parameters
    ----------
    model : StaticModel
    motion : RigidMotion
        Batch of shape (B,).
    displacement : sequence of ndarray, shape (B, n_link)
        Elastic displacement of each link in its frame.

    Returns
    -------
    list of ndarray, shape (B, n_link, n_link)
        Stiffness.
    list of ndarray, shape (B, n_link, n_link)
        Damping.
    """
    assembly = model.assembly
    relative = motion.angle - motion.angle[:, assembly.base, None]
    together = np.concatenate(displacement, axis=1)
    settings, tangents = simulation_settings(), _Tangents(model, len(together))
    for number, q in enumerate(together):
        state = model.move_to(motion, number) + assembly.turned(q, relative[number])
        tangents.linearize_at(number, settings, state)
    return tangents.in_link_frames(relative)


def internal_forces(model: StaticModel, displacement: Sequence[FloatArray]) -> list[FloatArray]:
    """Elastic forces of each link in its frame in given states.

    Parameters
    ----------
    model : StaticModel
    displacement : sequence of ndarray, shape (B, n_link)
        Elastic displacement of each link in its frame.

    Returns
    -------
    list of ndarray, shape (B, n_link)
        The derivatives of the strain energy by which Exudyn's elements store it.
    """
    forces = []
    for part, q in zip(model.assembly.parts, displacement, strict=True):
        if isinstance(part, RigidPart):
            forces.append(np.zeros_like(q))
            continue
        mapped = part.node_map
        force = _internal_force(part, q if mapped is None else mapped.to_nodes(q))
        forces.append(force if mapped is None else mapped.force(q, force))
    return forces


class _Tangents:
    """Stiffness and damping of each link over a batch of states."""

    def __init__(self, model: StaticModel, batch: int) -> None:
        self._assembly = assembly = model.assembly
        self._model = model
        self._matrices = [
            np.empty((2, batch, len(part.straight), len(part.straight))) for part in assembly.parts
        ]
        self._state, self._outer, self._turning = np.zeros((3, batch, assembly.size))

    def linearize_at(
        self,
        number: int,
        settings: Any,
        state: FloatArray,
        outer: FloatArray | float = 0.0,
        turning: FloatArray | float = 0.0,
    ) -> None:
        """Linearize about a state.

        Parameters
        ----------
        number : int
            Of the state.
        settings : exudyn.SimulationSettings
        state : ndarray, shape (size,)
        outer : ndarray, shape (size,), optional
            Forces on Exudyn's coordinates that keep their direction.
        turning : ndarray, shape (size,), optional
            Stiffness of rigid links and attached bodies against turning.
        """
        assembly = self._assembly
        with self._model.links_alone():
            _, stiffness, damping = linearized(assembly, settings, assembly.nodes.to_nodes(state))
        self._state[number], self._outer[number], self._turning[number] = state, outer, turning
        for matrices, part in zip(self._matrices, assembly.parts, strict=True):
            for matrix, whole in zip(matrices, (stiffness, damping), strict=True):
                matrix[number] = whole[part.coordinates, part.coordinates]

    def in_link_frames(self, angle: FloatArray) -> tuple[list[FloatArray], list[FloatArray]]:
        """Both in frames rotated by ``angle`` (B, n_links) against the model's."""
        result: tuple[list[FloatArray], list[FloatArray]] = [], []
        for link, part in enumerate(self._assembly.parts):
            own = part.coordinates
            stiffness, damping = self._matrices[link]
            if isinstance(part, BeamPart) and (mapped := part.node_map) is not None:
                state = self._state[:, own]
                force = _internal_force(part, mapped.to_nodes(state))
                if part.polar is not None:
                    force -= self._outer[:, own]
                stiffness = mapped.tangent(state, stiffness, force)
                damping = mapped.matrix(state, damping)
            for matrices, matrix in zip(result, (stiffness, damping), strict=True):
                matrices.append(_to_link_frame(matrix, angle[:, link], *part.vectors))
            every = np.arange(len(part.straight))
            result[0][link][:, every, every] += self._turning[:, own]
        return result


def _solve_in_steps(
    model: StaticModel,
    settings: Sequence[Any],
    pose: FloatArray,
    forces: FloatArray,
    couples: FloatArray,
    motion: RigidMotion,
    number: int,
) -> None:
    """Solve from the undeformed links, in load steps if necessary, or raise an error."""
    assembly = model.assembly
    nodes = assembly.nodes.to_nodes(pose)
    for steps in LOAD_STEPS:
        start = nodes
        for part in np.arange(1, steps + 1) / steps:
            model.loads.set(part * forces, part * couples)
            if model.applied is not None:
                model.applied.scale(float(part))
            model.swell(float(part))
            if not solve_static(assembly, settings, start):
                break
            start = np.array(assembly.mbs.systemData.GetODE2Coordinates())
        else:
            return
    model.swell(1.0)
    residual = float(assembly.mbs.sys["staticSolver"].conv.residual)
    other = "none" if assembly.kind.turns_arms else "axial"  # only cables carry tension straight
    refuse_positions(
        motion,
        np.arange(len(motion.crank_angle)) == number,
        "Exudyn finds no quasi-static equilibrium",
        f" (residual {residual:.3g} N), even in {LOAD_STEPS[-1]} load steps; {LESS_LOADED}, or use "
        f"prestress {other!r}",
        EquilibriumError,
    )


def _internal_force(part: BeamPart, nodes: FloatArray) -> FloatArray:
    """Elastic forces on a link's nodes, (B, n), at coordinates less the reference ones."""
    return part.kind.internal_force(nodes, np.diff(part.positions), part.section)


def _to_link_frame(matrix: FloatArray, angle: FloatArray, x: IntArray, y: IntArray) -> FloatArray:
    """``T' K T`` for matrices (B, n, n) with T the turn of all vectors by ``angle`` (B,)."""
    cosine, sine = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    for _ in range(2):  # columns, then (transposed) rows
        turned = matrix.copy()
        turned[:, :, x] = cosine * matrix[:, :, x] + sine * matrix[:, :, y]
        turned[:, :, y] = cosine * matrix[:, :, y] - sine * matrix[:, :, x]
        matrix = np.swapaxes(turned, 1, 2)
    return matrix
