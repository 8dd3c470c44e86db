"""Weight, torque and impacts on a running linkage, and energies of its links.

Pulses of a hammer on points of links in an Exudyn system.

A point need not be a node: the force is put on the element where the point is, which spreads it
over its two nodes by its own shape functions (a consistent load). A cable element does that
itself; of the geometrically exact beam, which is linear between its nodes, each node carries its
share, on the pins' axis where the link is eccentric.

The torque on a free shaft of a running Exudyn system: that of the rigid linkage.

Kinetic energy and weight of links in an Exudyn system in ground axes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linear_system import LinkModel, RigidBody
from flexmech.linkages import Drive, Linkage
from flexmech.linkages.motion import direction, normal
from flexmech.mechanism import Mechanism
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import ItemNumber, Made
from flexmech.multibody.link_parts import BeamPart, RigidPart
from flexmech.multibody.running.user_functions import torque_history
from flexmech.time_domain import Impact, rigid_torque


class LinkEnergies:
    """Kinetic and potential energies of the links of an assembly.

    Parameters
    ----------
    assembly : LinkAssembly
    links : sequence of LinkModel
        The links' matrices in the same coordinates.
    """

    def __init__(self, assembly: LinkAssembly, links: Sequence[LinkModel]) -> None:
        self._assembly = assembly
        self._links = links
        # Without attached bodies, which turn with their nodes.
        self._mass = [link.mass for link in links]
        for number, _ in assembly.beams:
            for body in (own for own in links[number].bodies if not own.of_section):
                own = body.matrices(np.zeros(()))[0]
                self._mass[number] = self._mass[number] - body.rows.T @ own @ body.rows

    def weight(self, link: int) -> FloatArray:
        """Generalized weight of a link without attached bodies, shape (n_link,)."""
        x, y = self._assembly.mechanism.gravity
        fields = self._links[link].fields
        return np.asarray(self._mass[link] @ (x * fields.along + y * fields.across))

    def kinetic(self, link: int, position: FloatArray, velocity: FloatArray) -> FloatArray:
        """Kinetic energy of a link.

        Parameters
        ----------
        link : int
        position, velocity : ndarray, shape (m, n_link)
            Its coordinates in ground axes.

        Returns
        -------
        ndarray, shape (m,)
        """
        part, energy = self._assembly.parts[link], np.zeros(len(position))
        for body, own in self._bodies(link):
            energy += _kinetic(body, position[:, own], velocity[:, own])
        if isinstance(part, RigidPart):
            return energy
        rate = velocity
        if part.node_map is not None:
            rate = part.node_map.rate_to_nodes(position, velocity)
        if part.bodies is None:
            return np.asarray(energy + np.sum(rate @ self._mass[link] * rate, axis=1) / 2)
        nodes = rate.reshape(len(rate), -1, 3)
        return energy + part.bodies.kinetic_energy(position[:, 2::3], nodes)

    def gravity(self, link: int, position: FloatArray) -> FloatArray:
        """Potential of a link's weight but for a constant.

        Parameters
        ----------
        link : int
        position : ndarray, shape (m, n_link)
            Its coordinates in ground axes.

        Returns
        -------
        ndarray, shape (m,)
        """
        part, pull = self._assembly.parts[link], np.array(self._assembly.mechanism.gravity)
        energy = np.zeros(len(position))
        for body, own in self._bodies(link):
            energy -= _moment(body, position[:, own]) @ pull
        if isinstance(part, RigidPart):
            return energy
        nodes = position if part.node_map is None else part.node_map.to_nodes(position)
        if part.bodies is None:
            return np.asarray(energy - nodes @ self.weight(link))
        lifted = part.bodies.moment(nodes.reshape(len(nodes), -1, 3))
        return np.asarray(energy - lifted @ pull)

    def _bodies(self, link: int) -> Iterator[tuple[RigidBody, list[int]]]:
        """A rigid link or the bodies on an elastic one, and their coordinates among the link's."""
        part = self._assembly.parts[link]
        if isinstance(part, RigidPart):
            yield part.inertia, [0, 1, 2]
        start = part.coordinates.start
        for body in self._assembly.attached:
            if body.link == link:
                yield body.inertia, [body.place - start, body.place - start + 1, body.angle - start]


def _kinetic(body: RigidBody, position: FloatArray, velocity: FloatArray) -> FloatArray:
    """Kinetic energy of a rigid body by place and angle of a point, (m, 3); shape (m,)."""
    momentum = body.matrices(position[:, 2])[0] @ velocity[..., None]
    return np.asarray(np.sum(velocity * momentum[..., 0], axis=1) / 2)


def _moment(body: RigidBody, position: FloatArray) -> FloatArray:
    """Mass times the place of a rigid body's centre but for a constant, (m, 2)."""
    (along, across), angle = body.first_moment, position[:, 2]
    return np.asarray(
        body.mass * position[:, :2] + along * direction(angle) + across * normal(angle)
    )


@dataclass(frozen=True)
class TorqueTable:
    """Torque at times, linear between them.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Increasing, in s.
    torque : ndarray, shape (n,)
        In N m.
    """

    time: FloatArray
    torque: FloatArray

    @classmethod
    def at_steps(cls, mechanism: Mechanism, drive: Drive, step: float, steps: int) -> Self:
        """Torque that drives the rigid linkage, at the time steps of a run.

        Parameters
        ----------
        mechanism : Mechanism
        drive : Drive
        step : float
            In s.
        steps : int

        Returns
        -------
        TorqueTable
        """
        time = step * np.arange(steps + 2, dtype=float)
        return cls(time, rigid_torque(mechanism, drive, time))

    def at(self, time: FloatArray) -> FloatArray:
        """Torque at times (m,) in N m."""
        return np.asarray(np.interp(time, self.time, self.torque))

    def user_function(self) -> Made:
        """User function of the torque, for Exudyn and for exported scripts."""
        return Made(torque_history, (self.time.tolist(), self.torque.tolist()))


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
        name = f"{assembly.parts[body.link].name}_attached_weight_{count}"
        _add_weight(assembly, name, body.number, body.body.mass, body.centre)
    for link, part in enumerate(assembly.parts):
        assembly.items.begin(f"{part.name}: point masses and weight")
        if isinstance(part, RigidPart):
            mass = part.inertia.mass
            _add_weight(assembly, f"{part.name}_weight", part.body, mass, part.centre)
            continue
        if part.bodies is not None:
            bodies = zip(part.bodies.numbers, part.bodies.mass, part.bodies.centre, strict=True)
            for number, (node_body, mass, (x, y)) in enumerate(bodies):
                name = f"{part.name}_weight_{number}"
                _add_weight(assembly, name, node_body, float(mass), (float(x), float(y)))
            continue
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


def _add_weight(
    assembly: LinkAssembly,
    name: str,
    body: ItemNumber,
    mass: float,
    centre: tuple[float, float],
) -> None:
    x, y = assembly.mechanism.gravity
    if not (mass and (x or y)):
        return
    marker = assembly.add_body_frame(body, f"{name}_centre", *centre)
    force = [float(mass * x), float(mass * y), 0.0]
    assembly.items.add("LoadForceVector", name, markerNumber=marker, loadVector=force)


def add_impacts(assembly: LinkAssembly, drive: Drive, impacts: Sequence[Impact]) -> None:
    """Add the loads of impacts to a system that is not assembled yet.

    Parameters
    ----------
    assembly : LinkAssembly
    drive : Drive
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
        yield assembly.add_axis_marker(part, float(x), name), 1.0
        return
    inside = float((x - start) / (end - start))
    for number, share in ((element, 1 - inside), (element + 1, inside)):
        node_name = f"{name}_node_{number}"
        yield assembly.add_axis_marker(part, float(part.positions[number]), node_name), share


@dataclass(frozen=True)
class _PulseForce:
    """Force of an impact in ground axes, as a user function."""

    impact: Impact
    drive: Drive
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
