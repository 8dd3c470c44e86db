"""Loads, springs and couples of sections of a running linkage, with their energy and power.

The rigid motion of a link has the rotary inertia of its sections whatever the element: a couple
``-rho I alpha`` a unit of length, with the angular acceleration of the link's rigid frame. Its
sections are normal to the axis, so that it is a force across the link at its end and the opposite
one at its start.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system import Connectors, LinkModel, deformations
from flexmech.linkages import Drive, Linkage, RigidMotion, continuous_angles
from flexmech.linkages.applied_forces import Moved, forces_of_loads, joint_gap
from flexmech.linkages.topology import leading_end
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.connectors import ConnectorItems
from flexmech.multibody.items import Made
from flexmech.multibody.running.user_functions import Shaft, load_history, section_couples
from flexmech.time_domain import ConnectorWork

# Times of a run at which the crank's range is taken: between them it gains less than 1e-6 of it.
TIMES = 2001
# Degrees of a link's angle over the crank angle, the first whose last coefficients are below
# DIGITS, in rad. Most cranks that turn round need 64; a rocker near a dead point more.
DEGREES, DIGITS = (16, 32, 64, 128, 256), 1e-10
# In rad: links that turn with the crank have second derivatives of round-off alone.
UNIFORM = 1e-6


class RunningConnectors:
    """Connectors of a running system that is not assembled yet.

    Parameters
    ----------
    items : ConnectorItems
        Of the system.
    links : sequence of LinkModel
        In the system's coordinates.
    shaft : Shaft
    start : RigidMotion
        At time zero, of shape ().
    """

    def __init__(
        self,
        items: ConnectorItems,
        links: Sequence[LinkModel],
        shaft: Shaft,
        start: RigidMotion,
    ) -> None:
        self._items = items
        self._mechanism = items.assembly.mechanism
        self._topology = items.assembly.topology
        self._all = Connectors(self._mechanism, links)
        self._shaft = shaft
        # By how much the clamped link is ahead of the crank.
        self._lead = shaft.start_angle - float(start.crank_angle)
        # A radial spring's marker is on the end that carries the place of the leading one.
        self._leading_places = {
            self._topology.end_place(item.leader): self._topology.end_place(
                leading_end(item.leader, self._topology.rigid_ties)
            )
            for item in items.joints
            if item.radial is not None and item.leader is not None
        }
        self._set(start)

    def work(
        self,
        time: FloatArray,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray],
        carried: RigidMotion,
    ) -> ConnectorWork:
        """Energy and power at instants of a run.

        Parameters
        ----------
        time : ndarray, shape (m,)
        motion : RigidMotion
            At these times.
        displacement, rate : sequence of ndarray, shape (m, n_link)
            Of the links in its frames.
        carried : RigidMotion
            The motion in ground axes, where ``motion`` is in those of a frame on springs.

        Returns
        -------
        ConnectorWork
        """
        power, pushed = np.zeros(len(time)), self._moved(carried, displacement, rate)
        prescribed = replace(carried, crank_angle=self._crank(time))
        loads = self._mechanism.loads
        for one in forces_of_loads(self._topology, prescribed, loads, time, pushed):
            drift = pushed(one.link, float(one.x))[1]
            power += one.power(carried) + np.sum(one.force * drift[:, :2], axis=1)
            power += one.torque * drift[:, 2]
        moved = self._moved(motion, displacement, rate)
        return ConnectorWork.of(deformations(self._mechanism, motion, moved), power)

    def joint_forces(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray],
    ) -> dict[str, FloatArray]:
        """Force of each sprung joint on its grounded or following link, (m, 2), by name.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        displacement, rate : sequence of ndarray, shape (m, n_link)
            Of the links in its frames.
        """
        forces, moved = {}, self._moved(motion, displacement, rate)
        for item in self._items.joints:
            if item.radial is not None:
                own = item.spring
                gap, drift = joint_gap(self._topology, motion, own, motion.angle, moved)
                force = (own.radial_stiffness or 0.0) * gap + own.radial_damping * drift
                forces[own.joint] = -force[:, :2]
        return forces

    def _moved(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray],
    ) -> Moved:
        own = self._all.moved(motion, displacement, rate)

        def moved(link: int, x: float) -> tuple[FloatArray, FloatArray]:
            found, place = own(link, x), own(*self._leading_places.get((link, x), (link, x)))
            for values, leading in zip(found, place, strict=True):
                values[:, :2] = leading[:, :2]
            return found

        return moved

    def _set(self, start: RigidMotion) -> None:
        """Set values of the items that depend on the start, before assembly."""
        assembly = self._items.assembly
        for item in self._items.loads:
            load = item.load
            rows = [
                [*map(float, pair), float(t)]
                for pair, t in zip(load.force, load.torque, strict=True)
            ]
            for number, is_torque in ((item.force, False), (item.torque, True)):
                if number is None:
                    continue
                history = Made(
                    load_history,
                    (
                        self._shaft,
                        self._lead,
                        load.over,
                        list(map(float, load.at)),
                        rows,
                        is_torque,
                    ),
                )
                assembly.items.change(number, "loadVectorUserFunction", history)
        if not self._items.joints:
            return
        linkage = assembly.mechanism.linkage
        angles = continuous_angles(linkage, start)
        for joint in self._items.joints:
            own = joint.spring
            if joint.turning is not None:
                jumped = self._topology.joint_angle(own.joint, start.angle - angles)
                assembly.items.change(joint.turning, "offset", float(jumped) + own.free_angle)
            if joint.ground is not None:
                link, x = self._topology.end_place(joint.follower)
                place = [*map(float, start.position(link, x)), 0.0]
                assembly.items.change(joint.ground, "referencePosition", place)

    def _crank(self, time: FloatArray) -> FloatArray:
        """Prescribed crank angles at times (m,)."""
        return np.array([self._shaft.angle(t) for t in time]) - self._lead


class SectionCouples:
    """Couples of the sections in a running system that is not assembled yet.

    Parameters
    ----------
    assembly : LinkAssembly
    links : sequence of LinkModel
        The links' matrices in the same coordinates.
    """

    def __init__(self, assembly: LinkAssembly, links: Sequence[LinkModel]) -> None:
        self._assembly = assembly
        self._links = {
            number: (link, float(link.uncounted_rotary_inertia))
            for number, link in enumerate(links)
            if np.any(link.uncounted_rotary_inertia)
        }

    def add(self, drive: Drive, shaft: Shaft, duration: float) -> None:
        """Add the forces at the ends of the links.

        Parameters
        ----------
        drive : Drive
        shaft : Shaft
            Of that drive.
        duration : float
            Of the run in s.
        """
        linkage = self._assembly.mechanism.linkage
        passed = np.asarray(drive.crank_angle(np.linspace(0.0, duration, TIMES)))
        first, last = float(passed.min()), float(passed.max())
        if first == last or not self._links:
            return
        last = min(last, first + 2 * np.pi)
        start = linkage.motion(drive.crank_angle(0.0))
        lead = shaft.start_angle - float(start.crank_angle)
        for number, (_, rotary) in self._links.items():
            series = _angle_over_crank(linkage, number, first, last)
            if drive.is_constant and np.abs(series.deriv(2).coef).max() < UNIFORM:
                continue
            part = self._assembly.parts[number]
            self._assembly.items.begin(f"{part.name}: couples that accelerate its sections")
            for end, node, sign in (("start", part.nodes[0], -1), ("end", part.nodes[-1], 1)):
                name = f"{part.name}_sections_{end}"
                marker = self._assembly.items.add("MarkerNodePosition", name, nodeNumber=node)
                given = (shaft, lead, [first, last], series.coef.tolist(), sign * rotary)
                self._assembly.items.add(
                    "LoadForceVector",
                    f"{name}_force",
                    markerNumber=marker,
                    loadVector=[0.0, 0.0, 0.0],
                    loadVectorUserFunction=Made(section_couples, given),
                )

    def energy_and_power(
        self,
        motion: RigidMotion,
        carried: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray],
    ) -> tuple[FloatArray, FloatArray]:
        """Kinetic energy of the sections' rotation, and the power of their couples besides.

        Parameters
        ----------
        motion : RigidMotion
            The prescribed one, a batch of shape (m,), by which the couples are.
        carried : RigidMotion
            That of the link frames, which a frame on springs or a free shaft turns besides.
        displacement, rate : sequence of ndarray, shape (m, n_link)
            Of the links in these frames.

        Returns
        -------
        ndarray, shape (m,)
            In J, of the prescribed motion.
        ndarray, shape (m,)
            In W, by all other motion of the ends.
        """
        energy, power = np.zeros((2, len(motion.crank_angle)))
        for number, (link, rotary) in self._links.items():
            omega, spin = motion.angular_velocity[:, number], carried.angular_velocity[:, number]
            (u, v), (u0, v0), length = link.end, link.start, link.readings.nodes[-1]
            q, change = displacement[number], rate[number]
            energy += rotary * length * omega**2 / 2
            drift = (spin - omega) * length + spin * (q[:, u] - q[:, u0])
            drift += change[:, v] - change[:, v0]
            power -= rotary * motion.angular_acceleration[:, number] * drift
        return energy, power


def _angle_over_crank(
    linkage: Linkage, link: int, first: float, last: float
) -> np.polynomial.Chebyshev:
    """Angle of a link over a range of crank angles, without jumps of whole turns."""
    for degree in DEGREES:
        places = np.polynomial.chebyshev.chebpts1(degree + 1)
        crank = (first + last + (last - first) * places) / 2
        angle = np.unwrap(linkage.motion(crank).angle[:, link])
        fitted = np.polynomial.Chebyshev.fit(crank, angle, degree, domain=[first, last])
        if np.abs(fitted.coef[-degree // 8 :]).max() < DIGITS:
            break
    return fitted
