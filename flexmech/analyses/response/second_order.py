"""What linear equations leave out of a displacement: how slopes stretch the links.

Linear equations about a bowed equilibrium displace its links by small amounts, along straight
lines. By half the square of the slopes that come on top, nonlinear links are stretched as well, and
a stiff link answers with many times the tension that it has. The displacement is put in order by
giving the links free strains that take this stretch back. A statically determinate linkage then
turns as if its links were shortened, and bends no further.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.choices import Prestress
from flexmech.linear_system import Engine, LinkFrames, RotationTerms
from flexmech.linkages import RigidMotion
from flexmech.types import FloatArray

__all__ = ["without_second_order_stretch"]

# Each leaves of the stretch about the part by which the links have turned.
PASSES = 4


def without_second_order_stretch(
    engine: Engine,
    motion: RigidMotion,
    displacement: Sequence[FloatArray],
    prestress: Prestress,
) -> list[FloatArray]:
    """Displacements at which nonlinear links have the tension that linear ones have.

    Parameters
    ----------
    engine : Engine
        One that simulates: it tells the internal forces of displaced links.
    motion : RigidMotion
        Batch of shape (B,).
    displacement : sequence of ndarray, shape (B, n_link)
        Of each link in its frame, by the linear equations.
    prestress : {"none", "axial", "equilibrium"}
        What these are about.

    Returns
    -------
    list of ndarray, shape (B, n_link)

    Raises
    ------
    ComputationError
        If there is no equilibrium.
    """
    expected = _linear_forces(engine, motion, displacement, prestress)
    frames = LinkFrames(engine.tied_topology, engine.links)
    straight = [link.stiffness for link in engine.links]
    stiffness = frames.assemble(motion, straight, RotationTerms.all_or_none(False)).stiffness
    taken_back = list(displacement)
    for _ in range(PASSES):
        found = engine.running_links(motion, taken_back).internal_force
        assert found is not None
        stretching = [
            np.where(link.is_axial, force - linear, 0.0)
            for link, force, linear in zip(engine.links, found, expected, strict=True)
        ]
        gathered = frames.gather(motion, stretching)
        step = np.linalg.solve(stiffness, gathered[..., None])
        moved = frames.link_coordinates(motion, step)
        taken_back = [q - by[..., 0] for q, by in zip(taken_back, moved, strict=True)]
    return taken_back


def _linear_forces(
    engine: Engine,
    motion: RigidMotion,
    displacement: Sequence[FloatArray],
    prestress: Prestress,
) -> list[FloatArray]:
    """Internal force (B, n_link) of each link by its tangent in the state it is linear about."""
    state = engine.stressed_links(motion, prestress)
    forces = [np.zeros_like(q) for q in displacement]
    beyond = list(displacement)
    if state.displacement is not None:
        found = engine.running_links(motion, state.displacement).internal_force
        assert found is not None
        forces = found
        beyond = [q - at for q, at in zip(displacement, state.displacement, strict=True)]
    return [
        force + (tangent @ change[..., None])[..., 0]
        for force, tangent, change in zip(forces, state.tangent, beyond, strict=True)
    ]
