"""Transfer of the running linkage from a force at one point to a displacement at another.

Force and displacement are in the axes of their links' rigid frames. The truncated modes, all
faster than the moving modes, respond statically (residual flexibility): by the flexibility of the
links at each crank angle less that of the moving modes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmech.arrays import FloatArray, row_products
from flexmech.choices import LinkDirection
from flexmech.dynamical_systems import ForcedPeriodicSystem
from flexmech.linear_system import (
    CarriedLinkage,
    LinkFrames,
    LinkPoint,
    RotationTerms,
    StressedLinks,
    displacement_row,
    in_positions,
)
from flexmech.time_domain.periodic_motion.moving_modes import MovingModes
from flexmech.time_domain.periodic_motion.sampled_turn import SampledTurn

# Crank angles whose unreduced matrices are in memory at a time. Memory alone.
BATCH = 64


def forced_linkage(
    moving: MovingModes,
    stressed: StressedLinks,
    hit: LinkPoint,
    seen: LinkPoint,
    direction: LinkDirection = "transverse",
    connected: FloatArray | None = None,
) -> ForcedPeriodicSystem:
    """Periodic system of the linkage with a force as input and a displacement as output.

    Parameters
    ----------
    moving : MovingModes
    stressed : StressedLinks
        The unreduced links at the crank angles of its turn.
    hit, seen : LinkPoint
        Where the force acts, and where the displacement is read.
    direction : {"transverse", "axial"}
        Of both, in the axes of their links' frames.
    connected : ndarray, shape (N, size, size), optional
        Stiffness of loads and springs in the coordinates of the unreduced links.

    Returns
    -------
    ForcedPeriodicSystem
        From N to m. Phases count from crank angle 0. The residual flexibility is
        ``g' K^-1 f - (P' g)' (P' K P)^-1 P' f`` without rotation terms.

    Raises
    ------
    InputError
        If the linkage has no such link.
    """
    turn, size = moving.turn, moving.size
    into, out = (_row(moving, point, direction) for point in (hit, seen))
    force, reading = np.zeros((2, len(into), 2 * size))
    root = np.sqrt(moving.scale)
    force[:, size:] = into / root
    reading[:, :size] = out / root
    # Zero where the moving modes are all coordinates.
    frames, remainder = LinkFrames(turn.frames.topology, turn.unreduced), np.zeros(len(into))
    if size < frames.size + turn.size - turn.frames.size:
        modal_stiffness = np.swapaxes(moving.basis, 1, 2) @ _stiffness(turn) @ moving.basis
        remainder -= (out * np.linalg.solve(modal_stiffness, into[..., None])[..., 0]).sum(axis=1)
        remainder += _flexibility(turn, frames, stressed, (hit, seen), direction, connected)
    return ForcedPeriodicSystem(moving.system(), *map(turn.series, (force, reading, remainder)))


def _flexibility(
    turn: SampledTurn,
    frames: LinkFrames,
    stressed: StressedLinks,
    points: tuple[LinkPoint, LinkPoint],
    direction: LinkDirection,
    connected: FloatArray | None,
) -> FloatArray:
    """Displacement (N,) of the second point by a unit force on the first, of unreduced links."""
    places = [point.index(frames.topology) for point in points]
    force, row = (
        displacement_row(turn.unreduced[place], point.fraction, direction)
        for place, point in zip(places, points, strict=True)
    )
    flexibility = np.empty(len(turn.motion.crank_angle))
    carried = turn.carried
    if carried is not None:
        carried = CarriedLinkage.of(carried.mechanism, frames, turn.unreduced)
    for first in range(0, len(flexibility), BATCH):
        batch = slice(first, first + BATCH)
        motion = turn.displaced.at(batch)
        tangent = [in_positions(t, batch) for t in stressed.tangent]
        frozen = RotationTerms.all_or_none(False)
        matrices = frames.assemble(motion, tangent, frozen)
        if connected is not None:
            matrices = replace(matrices, stiffness=matrices.stiffness + connected[batch])
        loads, read = ([np.zeros(link.size) for link in turn.unreduced] for _ in range(2))
        loads[places[0]], read[places[1]] = force, row
        pushed = [np.tile(load, (len(matrices.mass), 1)) for load in loads]
        right = frames.gather(motion, pushed)
        if carried is not None:
            matrices = carried.added(motion, matrices, frozen)
            right = np.concatenate([right, carried.on_frame(motion, loads)], axis=1)
        moved = np.linalg.solve(matrices.stiffness, right[..., None])
        of_links, of_frame = moved[:, : frames.size], np.asarray(moved[:, frames.size :, 0])
        flexibility[batch] = frames.link_coordinates(motion, of_links)[places[1]][..., 0] @ row
        if carried is not None:
            flexibility[batch] += row_products(carried.on_frame(motion, read), of_frame)
    return flexibility


def _stiffness(turn: SampledTurn) -> FloatArray:
    """Stiffness of the reduced links, with that of forces without a potential, (N, n, n)."""
    if turn.connected is None:
        return turn.stiffness
    return turn.stiffness + turn.connected.circulatory


def _row(moving: MovingModes, point: LinkPoint, direction: LinkDirection) -> FloatArray:
    """Displacement of a point in the coordinates y of the moving modes, (N, m)."""
    turn = moving.turn
    number = point.index(turn.frames.topology)
    row = displacement_row(turn.unreduced[number], point.fraction, direction)
    rows = row @ turn.bases[number] @ turn.link_coordinates(moving.basis)[number]
    if turn.carried is not None:
        loads = [np.zeros(link.size) for link in turn.unreduced]
        loads[number] = row
        on_frame = turn.carried.on_frame(turn.motion, loads)[:, None]
        rows = rows + (on_frame @ moving.basis[:, turn.frames.size :])[:, 0]
    return np.asarray(rows)
