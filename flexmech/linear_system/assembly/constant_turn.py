"""Linkages that are constant in their frames over a turn, such as welded links on a shaft."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import Prestress
from flexmech.linear_system.assembly.engine import Engine
from flexmech.linear_system.links.stressed_links import StressedLinks
from flexmech.linear_system.loads.connector_forces import ConnectedMatrices
from flexmech.linkages import RigidMotion, Topology

# Change along the turn, relative to the greatest value, that round-off makes: some five hundred
# times the unit round-off, of sums over the elements. A load of 1e-3 of the others is none.
UNCHANGED = 1e-13


def has_relative_motion(topology: Topology) -> bool:
    """Whether a link turns against another one or slides, so that the constraints vary.

    Parameters
    ----------
    topology : Topology

    Returns
    -------
    bool
    """
    return bool(topology.pins or topology.sliders)


def all_constant(arrays: Iterable[FloatArray], size: float = 0.0) -> bool:
    """Whether arrays (B, ...) are constant over the positions, up to round-off.

    Parameters
    ----------
    arrays : iterable of ndarray, shape (B, ...)
        Empty ones are the same.
    size : float
        To which round-off is relative where the arrays' own size is less.

    Returns
    -------
    bool
    """
    return all(
        not array.size or np.ptp(array, axis=0).max() <= UNCHANGED * max(np.abs(array).max(), size)
        for array in arrays
    )


def has_constant_tangents(tangents: ConnectedMatrices, motion: RigidMotion) -> bool:
    """Whether stiffness and damping of connectors are constant over the positions.

    Parameters
    ----------
    tangents : ConnectedMatrices
        Over a batch of shape (B,).
    motion : RigidMotion
        Of that batch.

    Returns
    -------
    bool
    """
    # A spring without tension pulls by round-off, which damping forces are large against.
    turning = float(np.abs(motion.crank_speed).max() * np.abs(tangents.damping).max())
    return all_constant((tangents.stiffness + tangents.rate_stiffness, tangents.damping), turning)


def is_constant_turn(engine: Engine, motion: RigidMotion) -> bool:
    """Whether all forces on the links are constant in the link frames over the positions.

    It is computed: the frame stands, no link turns against another one, and the forces of inertia,
    gravity, loads and springs on the straight links, and the stiffness of springs, are constant.

    Parameters
    ----------
    engine : Engine
    motion : RigidMotion
        Batch of shape (B,).

    Returns
    -------
    bool
    """
    if has_relative_motion(engine.topology) or engine.mechanism.frame is not None:
        return False
    links, connectors = engine.clamped_links, engine.connectors
    # Together: a spring without tension pulls by round-off, which differs at all positions.
    loads = connectors.with_inertia(links, motion)
    if not all_constant((motion.angular_velocity, motion.angular_acceleration, *loads)):
        return False
    tangents = connectors.matrices(engine.rigid_joint_frames, motion, "equilibrium")
    return has_constant_tangents(tangents, motion)


def stressed_along_turn(
    engine: Engine,
    motion: RigidMotion,
    prestress: Prestress,
    near: Sequence[FloatArray] | None = None,
) -> StressedLinks:
    """Stressed links over a turn; where all is constant, one position is solved for all.

    Parameters
    ----------
    engine : Engine
    motion : RigidMotion
        Batch of shape (B,).
    prestress : {"none", "axial", "equilibrium"}
    near : sequence of ndarray, shape (B, n_link), optional
        As of :meth:`flexmech.linear_system.Engine.stressed_links`.

    Returns
    -------
    StressedLinks
        Of all positions.

    Raises
    ------
    ComputationError
        If the equilibrium does not converge or is unstable; names the crank angle.
    """
    if not is_constant_turn(engine, motion):
        return engine.stressed_links(motion, prestress, near)
    first = slice(0, 1)
    start = None if near is None else [q[first] for q in near]
    found = engine.stressed_links(motion.at(first), prestress, start)
    every = np.zeros(len(motion.crank_angle), dtype=np.intp)
    return replace(found.at(every), motion=None)
