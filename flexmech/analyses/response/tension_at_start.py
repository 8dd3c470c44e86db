"""Where links that stretch begin: with the tension that linear equations give them.

Linear equations leave out half the square of the slopes, which runs count: at the displacements of
these a stiff link would have many times its tension, and would ring along itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.choices import Prestress
from flexmech.linear_system import Engine, LinkFrames, RotationTerms
from flexmech.linkages import RigidMotion

# Each leaves of the stretch about the part by which the links have turned.
_PASSES = 4


# Internal forces (B, n_link) of nonlinear links at displacements (B, n_link).
Forces = Callable[[list[FloatArray]], Sequence[FloatArray]]


def without_second_order_stretch(
    frames: LinkFrames,
    motion: RigidMotion,
    displacement: Sequence[FloatArray],
    expected: Sequence[FloatArray],
    internal_forces: Forces,
    held: Sequence[int] | IntArray = (),
) -> list[FloatArray]:
    """Displacements at which nonlinear links have the tension that linear ones have.

    Parameters
    ----------
    frames : LinkFrames
        Of the links, reduced or not.
    motion : RigidMotion
        Batch of shape (B,).
    displacement : sequence of ndarray, shape (B, n_link)
        Of each link in its frame, by the linear equations.
    expected : sequence of ndarray, shape (B, n_link)
        Internal forces by the linear equations: :func:`linear_forces`.
    internal_forces : callable
    held : sequence of int
        Coordinates of the frames that stay: that of a free shaft.

    Returns
    -------
    list of ndarray, shape (B, n_link)
    """
    straight = [link.stiffness for link in frames.links]
    stiffness = frames.assemble(motion, straight, RotationTerms.all_or_none(False)).stiffness
    free = np.setdiff1d(np.arange(stiffness.shape[-1]), held)
    of_free = stiffness[..., free[:, None], free]
    taken_back = list(displacement)
    for _ in range(_PASSES):
        found = internal_forces(taken_back)
        stretching = [
            np.where(link.is_axial, force - linear, 0.0)
            for link, force, linear in zip(frames.links, found, expected, strict=True)
        ]
        gathered = frames.gather(motion, stretching)
        step = np.zeros((*gathered.shape, 1))
        step[:, free] = np.linalg.solve(of_free, gathered[:, free, None])
        moved = frames.link_coordinates(motion, step)
        taken_back = [q - by[..., 0] for q, by in zip(taken_back, moved, strict=True)]
    return taken_back


def linear_forces(
    engine: Engine,
    motion: RigidMotion,
    displacement: Sequence[FloatArray],
    prestress: Prestress,
) -> list[FloatArray]:
    """Internal force of each link by its tangent in the state that it is linear about.

    Parameters
    ----------
    engine : Engine
    motion : RigidMotion
        Batch of shape (B,).
    displacement : sequence of ndarray, shape (B, n_link)
        Of each link in its frame.
    prestress : {"none", "axial", "equilibrium"}
        What the equations are linear about.

    Returns
    -------
    list of ndarray, shape (B, n_link)

    Raises
    ------
    ComputationError
        If there is no equilibrium.
    """
    state = engine.stressed_links(motion, prestress)
    forces = [np.zeros_like(q) for q in displacement]
    beyond = list(displacement)
    if state.displacement is not None:
        found = state.internal_force
        if found is None:
            found = engine.running_links(motion, state.displacement).internal_force
        assert found is not None
        forces = found
        beyond = [q - at for q, at in zip(displacement, state.displacement, strict=True)]
    return [
        force + (tangent @ change[..., None])[..., 0]
        for force, tangent, change in zip(forces, state.tangent, beyond, strict=True)
    ]
