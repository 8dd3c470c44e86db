"""Point masses and weight in a running Exudyn system."""

from __future__ import annotations

import numpy as np

from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import ItemNumber
from flexmech.multibody.link_energies import LinkEnergies
from flexmech.multibody.link_parts import RigidPart
from flexmech.multibody.node_bodies import NodeBodies


def add_running_loads(assembly: LinkAssembly, energies: LinkEnergies) -> None:
    """Add point masses and weight, node by node.

    One object over all nodes, as in the model at standstill, would make each tangent dense.

    Parameters
    ----------
    assembly : LinkAssembly
        Not assembled yet.
    energies : LinkEnergies
        Of its links, for their weight.
    """
    for count, body in enumerate(assembly.attached):
        if body.body.mass and any(assembly.mechanism.gravity):
            name = f"{assembly.parts[body.link].name}_attached_weight_{count}"
            _add_weight(assembly, name, body.number, body.body.mass, body.centre)
    for link, part in enumerate(assembly.parts):
        if isinstance(part, RigidPart):
            _add_body_weight(assembly, part)
            continue
        if part.bodies is not None:
            _add_node_weights(assembly, part.name, part.bodies)
            continue
        assembly.items.begin(f"{part.name}: point masses and weight")
        masses = assembly.point_masses(part)
        weights = energies.weight(link).reshape(len(part.nodes), -1)
        for number, (node, mass, weight) in enumerate(
            zip(part.nodes, masses, weights, strict=True)
        ):
            if mass or weight.any():
                matrix = np.diag([mass, mass] + [0.0] * (assembly.kind.per_node - 2))
                assembly.items.add(
                    "ObjectGenericODE2",
                    f"{part.name}_load_{number}",
                    nodeNumbers=[node],
                    massMatrix=matrix,
                    forceVector=weight,
                )


def _add_body_weight(assembly: LinkAssembly, part: RigidPart) -> None:
    if any(assembly.mechanism.gravity) and part.moments[0]:
        assembly.items.begin(f"{part.name}: weight")
        _add_weight(assembly, f"{part.name}_weight", part.body, part.moments[0], part.centre)


def _add_node_weights(assembly: LinkAssembly, link: str, bodies: NodeBodies) -> None:
    """Weight of a link at the centres of mass of the bodies at its nodes."""
    if not any(assembly.mechanism.gravity):
        return
    assembly.items.begin(f"{link}: weight")
    pairs = zip(bodies.numbers, bodies.mass, bodies.centre, strict=True)
    for number, (body, mass, (x, y)) in enumerate(pairs):
        _add_weight(assembly, f"{link}_weight_{number}", body, float(mass), (float(x), float(y)))


def _add_weight(
    assembly: LinkAssembly,
    name: str,
    body: ItemNumber,
    mass: float,
    centre: tuple[float, float],
) -> None:
    marker = assembly.items.add(
        "MarkerBodyRigid", f"{name}_centre", bodyNumber=body, localPosition=[*centre, 0.0]
    )
    x, y = assembly.mechanism.gravity
    force = [float(mass * x), float(mass * y), 0.0]
    assembly.items.add("LoadForceVector", name, markerNumber=marker, loadVector=force)
