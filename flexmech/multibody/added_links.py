"""Links of a mechanism as nodes, beams and bodies of an Exudyn system."""

from __future__ import annotations

import numpy as np

from flexmech.mechanism import Mechanism
from flexmech.mesh import node_positions
from flexmech.multibody.arms import Arms
from flexmech.multibody.beam_kind import BeamKind
from flexmech.multibody.gripped_nodes import gripped_places, held_places
from flexmech.multibody.items import SystemItems
from flexmech.multibody.link_parts import RIGID_SIZE, BeamPart, LinkPart, RigidPart
from flexmech.multibody.node_bodies import NodeBodies, point_masses_at
from flexmech.multibody.polar_slopes import PolarSlopes
from flexmech.types import FloatArray


def add_links(
    items: SystemItems, mechanism: Mechanism, kind: BeamKind, elements: int
) -> list[LinkPart]:
    """Add nodes, beams and bodies of all links, along the global x axis, one upon the other.

    Parameters
    ----------
    items : SystemItems
    mechanism : Mechanism
    kind : BeamKind
        Of the elastic links.
    elements : int
        Elements a link.

    Returns
    -------
    list of LinkPart
        In the topology's order.
    """
    parts: list[LinkPart] = []
    start = 0
    for link in mechanism.linkage.topology.links:
        part = (
            _add_rigid(items, mechanism, link.name, start)
            if link.rigid
            else _add_beam(items, mechanism, kind, link.name, elements, start)
        )
        parts.append(part)
        start = part.coordinates.stop
    return parts


def _add_beam(
    items: SystemItems, mechanism: Mechanism, kind: BeamKind, name: str, elements: int, start: int
) -> BeamPart:
    section, mass = mechanism.sections[name], mechanism.link_mass(name)
    held = [*held_places(mechanism, mass, name, kind.turns_arms), *mechanism.acting_at(name)]
    positions = node_positions(mass.length, elements, held)
    items.begin(f"{name}: nodes, in the undeformed link along the x axis")
    nodes = [
        kind.add_node(items, f"{name}_node_{i}", float(x), section.neutral_axis)
        for i, x in enumerate(positions)
    ]
    items.begin(f"{name}: beam elements")
    beams = [
        kind.add_element(items, f"{name}_element_{i}", nodes[i : i + 2], float(h), section)
        for i, h in enumerate(np.diff(positions))
    ]
    stop = start + kind.per_node * len(nodes)
    bodies = None
    if not kind.carries_mass:
        points = point_masses_at(mechanism, name, positions)
        bodies = NodeBodies.added(items, name, nodes, positions, section, points)
    return BeamPart(
        name=name,
        section=section,
        kind=kind,
        positions=positions,
        nodes=nodes,
        elements=beams,
        coordinates=slice(start, stop),
        arms=Arms(section.neutral_axis) if section.is_eccentric else None,
        bodies=bodies,
        polar=_polar_slopes(kind, positions, gripped_places(mechanism, mass, name)),
    )


def _add_rigid(items: SystemItems, mechanism: Mechanism, name: str, start: int) -> RigidPart:
    mass = mechanism.link_mass(name)
    moments = (mass.moment(0), mass.moment(1), mass.moment_across, mass.moment(2))
    items.begin(f"{name}: a rigid body, its node at the start of the link")
    node = items.add("NodeRigidBody2D", f"{name}_node", referenceCoordinates=[0.0, 0.0, 0.0])
    total, along, across, second = moments
    body = items.add(
        "ObjectRigidBody2D",
        f"{name}_body",
        nodeNumber=node,
        mass=total,
        inertia=second,
        centerOfMass=[along / total, across / total] if total else [0.0, 0.0],
    )
    own = slice(start, start + RIGID_SIZE)
    return RigidPart(name, mass.length, [node], body, moments, own)


def _polar_slopes(
    kind: BeamKind, positions: FloatArray, gripped: list[float]
) -> PolarSlopes | None:
    """Nodes of a link of cables at which something holds or asks for the angle."""
    if kind.turns_arms or not gripped:
        return None
    nodes = np.unique(np.abs(positions - np.array(gripped)[:, None]).argmin(axis=1))
    return PolarSlopes(kind.per_node * nodes + 2)
