"""Linearization in link frames from Exudyn's absolute coordinates, and static equilibrium."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linkages import RigidMotion, turned
from flexmech.mechanics import (
    LESS_LOADED,
    LOAD_STEPS,
    DeadMoments,
    EquilibriumError,
    LinkModel,
    LinkReadings,
    refuse_positions,
    rigid_link,
)
from flexmech.multibody.beams import segment_inertia
from flexmech.multibody.items import ROUND_OFF, load_exudyn
from flexmech.multibody.links import BeamPart, turn_vectors
from flexmech.multibody.static_model import (
    RELATIVE_RESIDUAL,
    StaticModel,
    simulation_settings,
    solve_static,
    static_settings,
)

# How often dampers are turned into their lines. Each time leaves less than a hundredth of the
# change, so that twice leave 3e-7 of the forces and four times their round-off.
DAMPER_TURNS = 8


def linearized(
    model: StaticModel, settings: Any, state: FloatArray, velocity: FloatArray | None = None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mass, stiffness and damping matrix of links in Exudyn's coordinates, without their springs.

    Exudyn linearizes about the initial state, whatever was solved before.

    Parameters
    ----------
    model : StaticModel
    settings : exudyn.SimulationSettings
    state : ndarray, shape (size,)
        Exudyn's coordinates, less the reference ones.
    velocity : ndarray, shape (size,), optional
        At which the damping forces count in the stiffness; none by default.

    Returns
    -------
    mass, stiffness, damping : ndarray, shape (size, size)
    """
    initial, mbs = load_exudyn().ConfigurationType.Initial, model.assembly.mbs
    mbs.systemData.SetODE2Coordinates(state, initial)
    moving = np.zeros_like(state) if velocity is None else velocity
    mbs.systemData.SetODE2Coordinates_t(moving, initial)
    if model.connectors is not None:
        model.connectors.activate(False)
    mass, stiffness, damping = map(np.array, mbs.ComputeLinearizedSystem(settings)[:3])
    if model.connectors is not None:
        model.connectors.activate(True)
    for _, part in model.assembly.beams:
        if not part.section.damping.any:
            # Bodies off their nodes leave the round-off of differences by velocities.
            damping[part.coordinates] = 0.0
    return mass, stiffness, damping


def static_equilibrium(
    model: StaticModel,
    motion: RigidMotion,
    loads: Sequence[FloatArray],
    dead: DeadMoments,
) -> tuple[list[FloatArray], list[FloatArray], list[FloatArray]]:
    """Quasi-static equilibrium of each position, and tangents of its links alone.

    Parameters
    ----------
    model : StaticModel
    motion : RigidMotion
        Batch of shape (B,).
    loads : sequence of ndarray, shape (B, n_link)
        Forces on each link in its frame.
    dead : DeadMoments
        Moments of dead loads on bodies and rigid links.

    Returns
    -------
    list of ndarray, shape (B, n_link)
        Displacement of each link in its frame.
    list of ndarray, shape (B, n_link, n_link)
        Stiffness, without that of dead moments and joint forces.
    list of ndarray, shape (B, n_link, n_link)
        Damping.

    Raises
    ------
    ComputationError
        If Exudyn's static solver does not converge; names the crank angle and speed.
    """
    assembly, batch = model.assembly, len(motion.crank_angle)
    tangents = _Tangents(model, batch)
    poses, relative = model.poses(motion)
    applied, settings = _applied(model, relative, loads, dead), static_settings()
    round_off = ROUND_OFF * assembly.nodal_force_scale
    deformation = np.zeros((1, assembly.size))
    displacement = np.empty((batch, assembly.size))
    for number in range(batch):
        one = slice(number, number + 1)
        pose, angle = poses[one], relative[one]
        model.move_to(motion, number, pose[0])
        forces, couples = (values[number] for values in applied)
        model.loads.set(forces, couples)
        loaded = float(np.abs(forces).sum()) + model.swelling_force
        loaded += 0.0 if model.connectors is None else model.connectors.scale_of_forces
        allowed = max(RELATIVE_RESIDUAL * loaded, round_off)
        settings[1].staticSolver.newton.absoluteTolerance = allowed
        start = pose + assembly.turned(deformation, angle)
        if not solve_static(assembly, settings, assembly.nodes.to_nodes(start[0])):
            _solve_in_steps(model, settings, pose[0], forces, couples, motion, number)
        for _ in range(DAMPER_TURNS):
            if model.connectors is None or not model.connectors.converge():
                break
            solved = np.array(assembly.mbs.systemData.GetODE2Coordinates())
            solve_static(assembly, settings, solved)
        state = assembly.nodes.to_axis(assembly.mbs.systemData.GetODE2Coordinates())
        deformation = assembly.turned(assembly.deformation(state[None], pose), -angle)
        displacement[number] = deformation[0]
        tangents.linearize_at(number, settings[0], state, forces)
    return assembly.by_links(displacement), *tangents.in_link_frames(relative)


def _applied(
    model: StaticModel, relative: FloatArray, loads: Sequence[FloatArray], dead: DeadMoments
) -> tuple[FloatArray, FloatArray]:
    """Arguments over a batch of :meth:`flexmech.multibody.static_model.StaticLoads.set`.

    Forces (B, n_link) transformed from link frames, at angles to the crank's frame, into that one,
    and couples.
    """
    assembly = model.assembly
    forces = np.concatenate(loads, axis=1)
    places = {body.angle: number for number, body in enumerate(model.loads.turning)}
    couples = np.zeros((len(forces), len(places), 2))
    for number, (link, row) in enumerate(zip(dead.links.tolist(), dead.rows, strict=True)):
        part = assembly.parts[link]
        angle = part.coordinates.start + row
        if isinstance(part, BeamPart):
            # What turns with the body is not on the node as well.
            forces[:, angle] -= dead.moment[number]
        couple = np.transpose([dead.virial[number], dead.moment[number]]) / part.length
        couples[:, places[angle]] = turned(couple, relative[:, link])
    for link, part in enumerate(assembly.parts):
        turn_vectors(forces[:, part.coordinates], part.force_vectors, relative[:, link])
    return forces, couples


def running_tangents(
    model: StaticModel,
    motion: RigidMotion,
    displacement: Sequence[FloatArray],
    rate: Sequence[FloatArray] | None = None,
) -> tuple[list[FloatArray], list[FloatArray]]:
    """Tangent stiffness and damping of each link in its frame in given states.

    Parameters
    ----------
    model : StaticModel
    motion : RigidMotion
        Batch of shape (B,).
    displacement : sequence of ndarray, shape (B, n_link)
        Elastic displacement of each link in its frame.
    rate : sequence of ndarray, shape (B, n_link), optional
        Its time derivative.

    Returns
    -------
    list of ndarray, shape (B, n_link, n_link)
        Stiffness, at a rate with the change of the damping forces by the displacement.
    list of ndarray, shape (B, n_link, n_link)
        Damping.
    """
    assembly, (poses, relative) = model.assembly, model.poses(motion)
    states = poses + assembly.turned(np.concatenate(displacement, axis=1), relative)
    rates = np.zeros_like(states)
    if rate is not None:
        moving = assembly.turned(np.concatenate(rate, axis=1), relative)
        # The velocity of a rigid link would change its inertia forces alone.
        for _, part in assembly.beams:
            rates[:, part.coordinates] = moving[:, part.coordinates]
    settings, tangents = simulation_settings(), _Tangents(model, len(states))
    for number, state in enumerate(states):
        model.move_to(motion, number, poses[number])
        tangents.linearize_at(number, settings, state, rate=rates[number])
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
        if not isinstance(part, BeamPart):
            forces.append(np.zeros_like(q))
            continue
        force = _internal_force(part, part.node_map.to_nodes(q))
        forces.append(part.node_map.force(q, force))
    return forces


def link_models(model: StaticModel) -> tuple[LinkModel, ...]:
    """Link models from the linearization of the undeformed system.

    In the reference configuration every link lies along the global x axis, so absolute
    coordinates are those of the link frames. A link that swelling bends is taken as if it
    had no free curvature yet: held straight against it, it would be under stress.
    """
    assembly = model.assembly
    straight = np.zeros(assembly.system_size)
    model.swell(0.0)
    mass, stiffness, damping = linearized(model, simulation_settings(), straight)
    model.swell(1.0)
    kind, models = assembly.kind, []
    for part in assembly.parts:
        if not isinstance(part, BeamPart):
            models.append(rigid_link(part.name, assembly.mechanism.link_mass(part.name)))
            continue
        count, size = len(part.nodes), len(part.straight)
        of_nodes = [
            whole[part.coordinates, part.coordinates] for whole in (mass, stiffness, damping)
        ]
        matrices = [part.node_map.matrix(np.zeros(size), matrix) for matrix in of_nodes]
        x, y = kind.vector_pairs(count)
        gyroscopic, centrifugal_mass, first_moment = _inertia(matrices[0], x, y)
        if part.bodies:
            # Mass along a rigid segment is mass of displacements, no rotary inertia.
            turns = np.arange(2, size, kind.per_node)
            centrifugal_mass[turns, turns] += segment_inertia(part.section, part.positions)
        last = size - kind.per_node
        link_mass = assembly.mechanism.link_mass(part.name)
        link = LinkModel(
            name=part.name,
            mass=matrices[0],
            gyroscopic=gyroscopic,
            centrifugal_mass=centrifugal_mass,
            first_moment=first_moment,
            stiffness=matrices[1],
            damping=matrices[2],
            is_axial=kind.is_axial(count),
            start=np.array([0, 1]),
            end=np.array([last, last + 1]),
            start_rotation=np.array([kind.clamped]),
            end_rotation=np.array([last + kind.clamped]),
            readings=LinkReadings(
                part.positions,
                kind.per_node,
                kind.shape_functions,
                slope=kind.clamped,
                deflection=kind.deflection,
                polar=part.stretches,
            ),
            fields=part.fields,
            vectors=np.stack([x, y]),
            uncounted_rotary_inertia=0.0 if kind.has_angles else link_mass.rotary_inertia,
            vector_map=part.node_map if len(part.stretches) else None,
        )
        models.append(link.carrying(link_mass))
    return tuple(models)


def unit_tension_stiffness(model: StaticModel) -> dict[int, FloatArray]:
    """Geometric stiffness that unit tension in each element adds, in link frames.

    A cable element at rest in its straight shape carries tension when its reference axial
    strain is negative; its stiffness is linear in that tension.

    Parameters
    ----------
    model : StaticModel
        Model of ANCF cables.

    Returns
    -------
    dict of int to ndarray, shape (e, n_link, n_link)
        By the numbers of elastic links.
    """
    assembly, settings, stiffness = model.assembly, simulation_settings(), {}
    straight = np.zeros(assembly.system_size)
    relaxed = linearized(model, settings, straight)[1]
    for number, part in assembly.beams:
        unit = []
        for element in part.elements:
            assembly.mbs.SetObjectParameter(element, "referenceAxialStrain", -1.0)
            tense = linearized(model, settings, straight)[1]
            assembly.mbs.SetObjectParameter(element, "referenceAxialStrain", 0.0)
            change = (tense - relaxed)[part.coordinates, part.coordinates]
            unit.append(change / part.section.axial_stiffness)
        stiffness[number] = np.stack(unit)
    return stiffness


def _inertia(
    mass: FloatArray, x: IntArray, y: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Gyroscopic and centrifugal mass matrix and first moment of a straight link.

    See :class:`LinkModel`; integrals of the same shapes as its mass matrix. Vectors, at ``x`` and
    ``y``, and rotations are coupled in it where the centre of mass is off the pins' axis, and
    where that of a body at a node is off the node along the link, which is no first moment of
    the link.
    """
    # It rotates every vector by 90 deg and drops the other coordinates.
    quarter = np.zeros_like(mass)
    quarter[x, y], quarter[y, x] = -1.0, 1.0
    turned_mass = quarter.T @ mass @ quarter
    coupling = mass - mass @ quarter @ quarter.T  # what rotations exert on vectors
    coupling = quarter @ quarter.T @ coupling
    moment = -coupling.sum(axis=1)
    moment[y] = 0.0
    return (
        turned_mass @ quarter + quarter @ coupling - (quarter @ coupling).T,
        turned_mass + coupling + coupling.T,
        np.stack([moment, quarter @ moment]),
    )


class _Tangents:
    """Stiffness and damping of each link over a batch of states."""

    def __init__(self, model: StaticModel, batch: int) -> None:
        self._assembly = assembly = model.assembly
        self._model = model
        self._matrices = [
            np.empty((2, batch, *2 * (len(part.straight),))) for part in assembly.parts
        ]
        self._state, self._rate, self._outer = np.zeros((3, batch, assembly.size))

    def linearize_at(
        self,
        number: int,
        settings: Any,
        state: FloatArray,
        outer: FloatArray | float = 0.0,
        rate: FloatArray | float = 0.0,
    ) -> None:
        """Linearize about a state.

        Parameters
        ----------
        number : int
            Number of the state.
        settings : exudyn.SimulationSettings
        state : ndarray, shape (size,)
        outer : ndarray, shape (size,), optional
            Forces on Exudyn's coordinates that keep their direction.
        rate : ndarray, shape (size,), optional
            Time derivative of the state.
        """
        assembly = self._assembly
        self._state[number], self._rate[number], self._outer[number] = state, rate, outer
        nodes = assembly.nodes.to_nodes(state)
        velocity = assembly.nodes.rate_to_nodes(state, self._rate[number])
        _, stiffness, damping = linearized(self._model, settings, nodes, velocity)
        for matrices, part in zip(self._matrices, assembly.parts, strict=True):
            for matrix, whole in zip(matrices, (stiffness, damping), strict=True):
                matrix[number] = whole[part.coordinates, part.coordinates]

    def in_link_frames(self, angle: FloatArray) -> tuple[list[FloatArray], list[FloatArray]]:
        """Both in frames rotated by ``angle`` (B, n_links) against the model's."""
        result: tuple[list[FloatArray], list[FloatArray]] = [], []
        for link, part in enumerate(self._assembly.parts):
            columns = part.coordinates
            stiffness, damping = self._matrices[link]
            mapped = part.node_map
            if isinstance(part, BeamPart) and len(mapped.first):
                state = self._state[:, columns]
                force = _internal_force(part, mapped.to_nodes(state))
                if not part.bodies:
                    force -= self._outer[:, columns]
                stiffness = mapped.tangent(state, stiffness, force)
                if (rate := self._rate[:, columns]).any():
                    stiffness += mapped.damping_stiffness(state, rate, damping)
                damping = mapped.matrix(state, damping)
            for matrices, matrix in zip(result, (stiffness, damping), strict=True):
                matrices.append(_to_link_frame(matrix, angle[:, link], *part.vectors))
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
        for fraction in np.arange(1, steps + 1) / steps:
            model.loads.set(fraction * forces, fraction * couples)
            if model.connectors is not None:
                model.connectors.scale(float(fraction))
            model.swell(float(fraction))
            if not solve_static(assembly, settings, start):
                break
            start = np.array(assembly.mbs.systemData.GetODE2Coordinates())
        else:
            return
    model.swell(1.0)
    residual = float(assembly.mbs.sys["staticSolver"].conv.residual)
    other = "none" if assembly.kind.has_angles else "axial"  # only cables carry tension straight
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
