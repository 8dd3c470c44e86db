"""Transfer of the running linkage from a force at one point to a displacement at another.

Force and displacement are in the axes of their links' rigid frames. The truncated modes, all
faster than the moving modes, respond statically (residual flexibility): by the flexibility of the
links at each crank angle less that of the moving modes.
"""

from __future__ import annotations

from collections.abc import Sequence

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
        From N to m. Phases count from crank angle 0.

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
    remainder = residual_flexibility(moving, stressed, hit, seen, direction, connected)
    return ForcedPeriodicSystem(moving.system(), *map(turn.series, (force, reading, remainder)))


def residual_flexibility(
    moving: MovingModes,
    stressed: StressedLinks,
    hit: LinkPoint,
    seen: LinkPoint,
    direction: LinkDirection = "transverse",
    connected: FloatArray | None = None,
) -> FloatArray:
    """Residual flexibility of the truncated modes at each crank angle.

    ``g' K^-1 f - (P' g)' (P' K P)^-1 P' f``: flexibility of the unreduced links less that of the
    moving modes, without rotation terms.

    Parameters
    ----------
    moving : MovingModes
    stressed : StressedLinks
        The unreduced links at the crank angles of its turn.
    hit, seen : LinkPoint
    direction : {"transverse", "axial"}
    connected : ndarray, shape (N, size, size), optional
        Stiffness of loads and springs in the coordinates of the unreduced links.

    Returns
    -------
    ndarray, shape (N,)
        In m/N. Zero where the moving modes are all coordinates.
    """
    turn = moving.turn
    frames = LinkFrames(turn.frames.topology, turn.unreduced)
    count = len(moving.basis)
    if moving.size == frames.size:
        return np.zeros(count)
    into, out = (_row(moving, point, direction) for point in (hit, seen))
    places = [point.index(frames.topology) for point in (hit, seen)]
    rows = [
        displacement_row(turn.unreduced[place], point.fraction, direction)
        for place, point in zip(places, (hit, seen), strict=True)
    ]
    flexibility = np.empty(count)
    for first in range(0, count, BATCH):
        some = slice(first, first + BATCH)
        motion = turn.displaced.at(some)
        tangent = [in_positions(t, some) for t in stressed.tangent]
        frozen = RotationTerms.all_or_none(False)
        stiffness = frames.assemble(motion, tangent, frozen).stiffness
        if connected is not None:
            stiffness = stiffness + connected[some]
        loads = [np.zeros((len(stiffness), link.size)) for link in turn.unreduced]
        loads[places[0]][:] = rows[0]
        moved = np.linalg.solve(stiffness, frames.gather(motion, loads)[..., None])
        whole = frames.link_coordinates(motion, moved)[places[1]][..., 0] @ rows[1]
        own = np.linalg.solve(_stiffness(moving, tangent, some), into[some, :, None])[..., 0]
        flexibility[some] = whole - (out[some] * own).sum(axis=1)
    return flexibility


def _stiffness(moving: MovingModes, tangent: Sequence[FloatArray], some: slice) -> FloatArray:
    """``P' K P`` at some crank angles, (B, m, m)."""
    turn, modes = moving.turn, moving.basis[some]
    reduced = turn.frames.link_coordinates(turn.displaced.at(some), modes)
    shapes = [basis @ q for basis, q in zip(turn.bases, reduced, strict=True)]
    parts = [np.swapaxes(q, 1, 2) @ (k @ q) for q, k in zip(shapes, tangent, strict=True)]
    if turn.connected is not None:
        parts.append(np.swapaxes(modes, 1, 2) @ (turn.connected.stiffness[some] @ modes))
    return np.asarray(sum(parts))


def _row(moving: MovingModes, point: LinkPoint, direction: LinkDirection) -> FloatArray:
    """Displacement of a point in the coordinates y of the moving modes, (N, m)."""
    turn = moving.turn
    number = point.index(turn.frames.topology)
    row = displacement_row(turn.unreduced[number], point.fraction, direction) @ turn.bases[number]
    reduced = turn.frames.link_coordinates(turn.displaced, moving.basis)[number]
    return np.asarray(row @ reduced)
