"""A link of the reference engine: beam elements put together along one line."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexmech.linear_system import LinkModel, RigidFields
from flexmech.linkages import LinkMass
from flexmech.mesh import middle_curvature, node_positions, station_shapes
from flexmech.reference.elements import (
    gyroscopic_matrix,
    mass_matrix,
    shape_functions,
    stiffness_matrix,
)
from flexmech.sections import BeamSection

__all__ = ["assemble_chain", "link_model"]

FloatArray = NDArray[np.float64]


def assemble_chain(elements: FloatArray) -> FloatArray:
    """Sum the matrices of consecutive elements; (..., e, 6, 6) -> (..., n, n), n = 3 (e + 1)."""
    count = elements.shape[-3]
    batch = elements.shape[:-3]
    total = np.zeros((*batch, count + 1, 3, count + 1, 3))
    first, second = np.arange(count), np.arange(1, count + 1)
    blocks = np.moveaxis(elements, -3, 0)
    for rows, i in ((first, slice(0, 3)), (second, slice(3, 6))):
        for columns, j in ((first, slice(0, 3)), (second, slice(3, 6))):
            total[..., rows, :, columns, :] += blocks[..., i, j]
    size = 3 * (count + 1)
    return total.reshape(*batch, size, size)


def link_model(
    name: str, section: BeamSection, mass: LinkMass, elements: int
) -> tuple[LinkModel, FloatArray]:
    """Build one link of Euler-Bernoulli beam elements.

    Parameters
    ----------
    name : str
    section : BeamSection
    mass : LinkMass
        Distributed and point masses of the link.
    elements : int

    Returns
    -------
    LinkModel
        Coordinates (u, v, phi) node by node.
    ndarray, shape (e + 1,)
        Node positions in m.
    """
    nodes = node_positions(mass.length, elements, mass.point_positions)
    lengths = np.diff(nodes)
    size = 3 * len(nodes)
    inertia, gyroscopic, stiffness = assemble_chain(
        np.stack(
            [
                mass_matrix(lengths, mass.mass_per_length),
                gyroscopic_matrix(lengths, mass.mass_per_length),
                stiffness_matrix(lengths, section.axial_stiffness, section.bending_stiffness),
            ]
        )
    )
    for position, value in zip(mass.point_positions, mass.point_masses, strict=True):
        u = 3 * int(np.argmin(np.abs(nodes - position)))
        inertia[[u, u + 1], [u, u + 1]] += value
        gyroscopic[u, u + 1] -= value
        gyroscopic[u + 1, u] += value
    model = LinkModel(
        name=name,
        mass=inertia,
        gyroscopic=gyroscopic,
        translational_mass=inertia,
        stiffness=stiffness,
        damping=section.damping_time * stiffness,
        is_axial=np.arange(size) % 3 == 0,
        start=np.array([0, 1]),
        end=np.array([size - 3, size - 2]),
        start_rotation=np.array([2]),
        end_rotation=np.array([size - 1]),
        shape=station_shapes(nodes, 3, shape_functions),
        curvature=middle_curvature(nodes, 3, slope=2, deflection=1),
        fields=_rigid_fields(nodes),
    )
    return model, nodes


def _rigid_fields(nodes: FloatArray) -> RigidFields:
    zero = np.zeros((len(nodes), 3))
    along, across, centripetal, tangential = (zero.copy() for _ in range(4))
    along[:, 0] = 1.0
    across[:, 1] = 1.0
    centripetal[:, 0] = nodes
    tangential[:, 1] = nodes
    tangential[:, 2] = 1.0
    return RigidFields(*(field.ravel() for field in (along, across, centripetal, tangential)))
