"""Loads and springs of a running linkage, with their energy and power."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system import Connectors, LinkModel, deformations
from flexmech.linkages import RigidMotion, continuous_angles
from flexmech.linkages.applied_forces import Moved, forces_of_loads, joint_gap
from flexmech.linkages.topology import leading_end
from flexmech.multibody.connectors import ConnectorItems
from flexmech.multibody.items import Made
from flexmech.multibody.running.user_functions import Shaft, load_history
from flexmech.time_domain import ConnectorWork


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
    ) -> ConnectorWork:
        """Energy and power at instants of a run.

        Parameters
        ----------
        time : ndarray, shape (m,)
        motion : RigidMotion
            At these times.
        displacement, rate : sequence of ndarray, shape (m, n_link)
            Of the links in its frames.

        Returns
        -------
        ConnectorWork
        """
        power, moved = np.zeros(len(time)), self._moved(motion, displacement, rate)
        prescribed = replace(motion, crank_angle=self._crank(time))
        loads = self._mechanism.loads
        for one in forces_of_loads(self._topology, prescribed, loads, time, moved):
            drift = moved(one.link, float(one.x))[1]
            power += one.power(motion) + np.sum(one.force * drift[:, :2], axis=1)
            power += one.torque * drift[:, 2]
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
