"""Transfer of the running linkage from a force at one point to a displacement at another.

Force and displacement are in the axes of their links' rigid frames. The truncated modes, all
faster than the moving modes, respond statically (residual flexibility): by the flexibility of the
links at each crank angle less that of the moving modes.
"""

from __future__ import annotations

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import LinkDirection
from flexmech.dynamical_systems import ForcedPeriodicSystem
from flexmech.linear_system import (
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
    if size < frames.size:
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
    for first in range(0, len(flexibility), BATCH):
        batch = slice(first, first + BATCH)
        motion = turn.displaced.at(batch)
        tangent = [in_positions(t, batch) for t in stressed.tangent]
        stiffness = frames.assemble(motion, tangent, RotationTerms.all_or_none(False)).stiffness
        if connected is not None:
            stiffness = stiffness + connected[batch]
        loads = [np.zeros((len(stiffness), link.size)) for link in turn.unreduced]
        loads[places[0]][:] = force
        moved = np.linalg.solve(stiffness, frames.gather(motion, loads)[..., None])
        flexibility[batch] = frames.link_coordinates(motion, moved)[places[1]][..., 0] @ row
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
    row = displacement_row(turn.unreduced[number], point.fraction, direction) @ turn.bases[number]
    reduced = turn.frames.link_coordinates(turn.displaced, moving.basis)[number]
    return np.asarray(row @ reduced)
