"""Link models from Exudyn's linearization of the undeformed links."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import LinkModel, LinkReadings, rigid_link
from flexmech.linear_system.links.link_model import NONE
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.linearize import linearized
from flexmech.multibody.link_parts import RigidPart
from flexmech.multibody.static_model import StaticModel, simulation_settings


def link_models(model: StaticModel) -> tuple[LinkModel, ...]:
    """Link models from the linearization of the undeformed system.

    In the reference configuration every link lies along the global x axis, so absolute
    coordinates are those of the link frames. A link that swelling bends is taken as if it
    had no free curvature yet: held straight against it, it would be under stress.
    """
    assembly = model.assembly
    straight = np.zeros(assembly.system_size)
    model.swell(0.0)
    with model.links_alone():
        mass, stiffness, damping = linearized(assembly, simulation_settings(), straight)
    model.swell(1.0)
    kind, models = assembly.kind, []
    for part in assembly.parts:
        if isinstance(part, RigidPart):
            models.append(rigid_link(part.name, assembly.mechanism.link_mass(part.name)))
            continue
        name = part.name
        count, size = len(part.nodes), part.coordinates.stop - part.coordinates.start
        own = [matrix[part.coordinates, part.coordinates] for matrix in (mass, stiffness, damping)]
        if part.arms is not None:
            own = [part.arms.matrix(np.zeros(size), matrix) for matrix in own]
        x, y = kind.vector_pairs(count)
        inertia = _inertia(own[0], _quarter_turn(size, x, y), y)
        if part.bodies is not None:
            # Mass along a rigid segment is mass of displacements, no rotary inertia.
            turns = np.arange(2, size, kind.per_node)
            inertia.centrifugal_mass[turns, turns] += part.bodies.link.segment
        last = size - kind.per_node
        link_mass = assembly.mechanism.link_mass(name)
        rotary = 0.0 if kind.has_rotary_inertia else link_mass.rotary_inertia
        link = LinkModel(
            name=name,
            mass=own[0],
            gyroscopic=inertia.gyroscopic,
            centrifugal_mass=inertia.centrifugal_mass,
            first_moment=inertia.first_moment,
            stiffness=own[1],
            damping=own[2],
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
                polar=NONE if part.polar is None else part.polar.first,
            ),
            fields=part.fields,
            vectors=np.stack([x, y]),
            uncounted_rotary_inertia=rotary,
        )
        models.append(link.carrying(link_mass))
    return tuple(models)


def unit_tension_stiffness(assembly: LinkAssembly) -> list[FloatArray]:
    """Geometric stiffness that unit tension in each element adds, in link frames.

    A cable element at rest in its straight shape carries tension when its reference axial
    strain is negative; its stiffness is linear in that tension.

    Parameters
    ----------
    assembly : LinkAssembly
        Of ANCF cables.

    Returns
    -------
    list of ndarray, shape (e, n_link, n_link)
    """
    straight = np.zeros(assembly.system_size)
    settings = simulation_settings()
    relaxed = linearized(assembly, settings, straight)[1]
    parts = []
    for part in assembly.parts:
        if isinstance(part, RigidPart):
            parts.append(np.zeros((0, part.straight.size, part.straight.size)))
            continue
        unit = []
        for element in part.elements:
            assembly.mbs.SetObjectParameter(element, "referenceAxialStrain", -1.0)
            tense = linearized(assembly, settings, straight)[1]
            assembly.mbs.SetObjectParameter(element, "referenceAxialStrain", 0.0)
            change = (tense - relaxed)[part.coordinates, part.coordinates]
            unit.append(change / part.section.axial_stiffness)
        parts.append(np.stack(unit))
    return parts


@dataclass(frozen=True)
class _Inertia:
    """Inertia integrals of a link besides its mass matrix; see :class:`LinkModel`."""

    gyroscopic: FloatArray
    centrifugal_mass: FloatArray
    first_moment: FloatArray


def _inertia(mass: FloatArray, quarter: FloatArray, across: IntArray) -> _Inertia:
    """Integrals of the same shapes as a straight link's mass matrix.

    Vectors and rotations are coupled in it where the centre of mass is off the pins' axis, and
    where that of a body at a node is off the node along the link, which is no first moment of
    the link. ``across`` are the coordinates that move it across.
    """
    turned = quarter.T @ mass @ quarter
    coupling = mass - mass @ quarter @ quarter.T  # what rotations exert on vectors
    coupling = quarter @ quarter.T @ coupling
    moment = -coupling.sum(axis=1)
    moment[across] = 0.0
    return _Inertia(
        gyroscopic=turned @ quarter + quarter @ coupling - (quarter @ coupling).T,
        centrifugal_mass=turned + coupling + coupling.T,
        first_moment=np.stack([moment, quarter @ moment]),
    )


def _quarter_turn(size: int, x: IntArray, y: IntArray) -> FloatArray:
    """Matrix that rotates every vector by 90 deg and drops the other coordinates."""
    quarter = np.zeros((size, size))
    quarter[x, y], quarter[y, x] = -1.0, 1.0
    return quarter
