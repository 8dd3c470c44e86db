"""Geometric stiffness of rigid links and hubs by the forces on them.

A dead load F at the point r of a rigid link rotated by phi does the work ``F . R(phi) r``; its
second derivative gives the stiffness ``F . R(phi) r``. Where F is the force of a joint, this is
the derivative of ``C_q' lambda`` by the link's angle, which Exudyn's linearization does not
include.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import LinkEnd
from flexmech.linkages.motion import direction
from flexmech.multibody.link_parts import RigidPart
from flexmech.multibody.static_model import StaticModel


@dataclass(frozen=True)
class JointForce:
    """Force of a joint on a link.

    Parameters
    ----------
    link : int
    place : ndarray, shape (2,)
        Where it acts, in the model's axes in m.
    force : ndarray, shape (2,)
        In N.
    """

    link: int
    place: FloatArray
    force: FloatArray


def joint_forces(model: StaticModel, state: FloatArray) -> Iterator[JointForce]:
    """Forces of pins, welds, sliders and ground pins off nodes, and of radial springs.

    After a static solution.

    Parameters
    ----------
    model : StaticModel
    state : ndarray, shape (size,)
        Coordinates of all links.

    Returns
    -------
    iterator of JointForce
    """
    assembly = model.assembly
    data = assembly.mbs.systemData
    multipliers = _multipliers(model)

    def own(constraint: int) -> FloatArray:
        return multipliers[list(data.GetObjectLTGAE(int(constraint)))]

    def on(end: LinkEnd, force: FloatArray) -> JointForce:
        place = assembly.part_of(end).end_place(end.end, state)
        return JointForce(assembly.topology.index(end.link), place, force)

    for end, _, pin in model.grounds:
        yield on(end, -own(pin))
    for joint in model.ties:
        force = -own(joint.position)
        yield on(joint.tie.follower, force)
        yield on(joint.leader, -force)
    for line in model.sliders:
        x, y, _ = assembly.mbs.GetObjectParameter(line.constraint, "normalMarker1")
        normal = np.array([x, y])
        if line.slider.guide:
            guide = assembly.topology.index(line.slider.guide)
            angle = state[assembly.parts[guide].coordinates][2]
            cosine, sine = np.cos(angle), np.sin(angle)
            normal = np.array([cosine * x - sine * y, sine * x + cosine * y])
        on_end = on(line.slider.link_end, own(line.constraint)[0] * normal)
        yield on_end
        if line.slider.guide:
            yield JointForce(guide, on_end.place, -on_end.force)
    for item in () if model.connectors is None else model.connectors.joints:
        if item.radial is None:
            continue
        follower = on(item.follower, np.zeros(2))
        if item.leader is None:
            ground = assembly.mbs.GetObjectParameter(item.ground, "referencePosition")
            before = np.array(ground)[:2]
        else:
            before = assembly.part_of(item.leader).end_place(item.leader.end, state)
        force = -(item.spring.radial_stiffness or 0.0) * (follower.place - before)
        yield replace(follower, force=force)
        if item.leader is not None:
            yield on(item.leader, -force)


def geometric_stiffness(model: StaticModel, state: FloatArray, couples: FloatArray) -> FloatArray:
    """Geometric stiffness of rigid links, hubs and bodies at nodes after a static solution.

    Loads and springs on points of rigid links are not counted.

    Parameters
    ----------
    model : StaticModel
    state : ndarray, shape (size,)
        Coordinates of all links.
    couples : ndarray, shape (n_turning, 2)
        As :meth:`flexmech.multibody.static_loads.StaticLoads.set` took them.

    Returns
    -------
    ndarray, shape (size,)
        By the angles among the coordinates of all links, in N m/rad.
    """
    parts = model.assembly.parts
    stiffness = np.zeros(model.assembly.size)
    for turned, couple in zip(model.loads.turning, couples, strict=True):
        arm = parts[turned.link].length * direction(state[turned.angle])
        stiffness[turned.angle] += couple @ arm
    rigid = [link for link, part in enumerate(parts) if isinstance(part, RigidPart)]
    for acting in joint_forces(model, state) if rigid else ():
        if acting.link in rigid:
            own = parts[acting.link].coordinates
            stiffness[own.stop - 1] += acting.force @ (acting.place - state[own][:2])
    multipliers = _multipliers(model)
    for constraint, angle, radius in model.hubs:
        [row] = model.assembly.mbs.systemData.GetObjectLTGAE(int(constraint))
        stiffness[angle] += radius * multipliers[row]
    return stiffness


def line_forces(model: StaticModel) -> FloatArray:
    """Force of each line on the end that slides on it, along the line's normal.

    Parameters
    ----------
    model : StaticModel
        After a static solution.

    Returns
    -------
    ndarray, shape (n_sliders,)
        In N.
    """
    data, multipliers = model.assembly.mbs.systemData, _multipliers(model)
    rows = [data.GetObjectLTGAE(int(line.constraint))[0] for line in model.sliders]
    return np.array([multipliers[row] for row in rows])


def _multipliers(model: StaticModel) -> FloatArray:
    """Lagrange multipliers with the sign of a running system, opposite to the static solver's."""
    return -np.array(model.assembly.mbs.systemData.GetAECoordinates())
