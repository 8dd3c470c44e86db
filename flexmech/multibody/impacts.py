"""Pulses of a hammer on points of links in an Exudyn system.

A point need not be a node: the force is put on the element where the point is, which spreads it
over its two nodes by its own shape functions (a consistent load). A cable element does that
itself; of the geometrically exact beam, which is linear between its nodes, each node carries its
share, on the pins' axis where the link is eccentric.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmech.errors import InputError
from flexmech.linkages import CrankDrive, Linkage, LockedCrank
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import ItemNumber
from flexmech.multibody.link_parts import BeamPart, RigidPart
from flexmech.time_domain.recorded_runs import Impact


def add_impacts(
    assembly: LinkAssembly, drive: CrankDrive | LockedCrank, impacts: Sequence[Impact]
) -> None:
    """Add the loads of impacts to a system that is not assembled yet.

    Parameters
    ----------
    assembly : LinkAssembly
    drive : CrankDrive or LockedCrank
        By which the links' rigid frames turn, and the forces with them.
    impacts : sequence of Impact

    Raises
    ------
    InputError
        If one is on no link of the mechanism.
    """
    for count, impact in enumerate(impacts):
        assembly.items.begin(f"impact on {impact.point}")
        link = impact.point.index(assembly.topology)
        force = _PulseForce(impact, drive, assembly.mechanism.linkage, link)
        part = assembly.parts[link]
        if isinstance(part, RigidPart):
            raise InputError(
                f"the impact is on the {part.name}, which is rigid; strike an elastic link"
            )
        shares = _shares(assembly, part, impact.point.fraction, f"impact_{count}")
        for marker, share in shares:
            assembly.items.add(
                "LoadForceVector",
                f"{marker.name}_force",
                markerNumber=marker,
                loadVector=[0.0, 0.0, 0.0],
                loadVectorUserFunction=force.times(share),
            )


def _shares(
    assembly: LinkAssembly, part: BeamPart, fraction: float, name: str
) -> Iterator[tuple[ItemNumber, float]]:
    """Markers that carry a unit force on a point, and the share of each."""
    x = fraction * part.positions[-1]
    element = int(np.searchsorted(part.positions, x, side="right")) - 1
    element = min(element, len(part.elements) - 1)
    start, end = part.positions[element : element + 2]
    if part.bodies is None:
        place = [float(x - start), 0.0, 0.0]
        body = part.elements[element]
        yield (
            assembly.items.add("MarkerBodyPosition", name, bodyNumber=body, localPosition=place),
            1.0,
        )
        return
    inside = float((x - start) / (end - start))
    for number, share in ((element, 1 - inside), (element + 1, inside)):
        node_name = f"{name}_node_{number}"
        if part.arms is not None:
            yield assembly.add_axis_point(part, number, node_name), share
        else:
            node = part.nodes[number]
            yield assembly.items.add("MarkerNodePosition", node_name, nodeNumber=node), share


@dataclass(frozen=True)
class _PulseForce:
    """Force of an impact in ground axes, as Exudyn asks for it."""

    impact: Impact
    drive: CrankDrive | LockedCrank
    linkage: Linkage
    link: int

    def times(self, share: float) -> Any:
        """User function of a load that carries a share of the force."""

        def force(mbs: Any, t: float, load: Any) -> list[float]:
            # Exudyn asks for it several times a step, nearly always outside the pulse.
            pulse = self.impact.pulse
            if not pulse.start < t < pulse.end:
                return [0.0, 0.0, 0.0]
            size = share * float(pulse.force(t))
            angle = float(self.drive.motion(self.linkage, np.array([t])).angle[0, self.link])
            if self.impact.direction == "transverse":
                angle += math.pi / 2
            return [size * math.cos(angle), size * math.sin(angle), 0.0]

        return force
