"""Parts of a mechanism for a picture, a text or a notebook."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from html import escape
from typing import Any, Protocol

import numpy as np

from flexmech.linkages import (
    AttachmentPoint,
    JointSpring,
    Linkage,
    LinkMass,
    Load,
    Spring,
    Topology,
    linkage_positions,
    picture_crank_angle,
)
from flexmech.linkages.positions import drawn_joints
from flexmech.mechanism.parts import AttachedBody, JointPin, PointMass, Provenance
from flexmech.sections import BeamSection


class _Shown(Protocol):
    """Interface of a mechanism for pictures and notebooks."""

    @property
    def linkage(self) -> Linkage: ...
    @property
    def sections(self) -> Mapping[str, BeamSection]: ...
    @property
    def joint_masses(self) -> Mapping[str, float]: ...
    @property
    def link_masses(self) -> tuple[PointMass, ...]: ...
    @property
    def bodies(self) -> tuple[AttachedBody, ...]: ...
    @property
    def loads(self) -> tuple[Load, ...]: ...
    @property
    def springs(self) -> tuple[Spring, ...]: ...
    @property
    def joint_springs(self) -> tuple[JointSpring, ...]: ...
    @property
    def gravity(self) -> tuple[float, float]: ...
    @property
    def provenance(self) -> Provenance: ...

    def link_mass(self, link: str) -> LinkMass: ...


def drawn_parts(mechanism: _Shown) -> dict[str, Any]:
    """Joints, masses, bodies, springs, dampers, loads and gravity as a picture shows them.

    Parameters
    ----------
    mechanism : Mechanism

    Returns
    -------
    dict
        Entries of :func:`flexmech.linkages.positions.drawn_joints`, and ``masses`` (``at``,
        ``kg``), ``bodies`` (``at``, ``offset`` and ``outline`` from there in m, ``kg``),
        ``springs`` (``name``, ``ends``, whether ``stiff`` and ``damped``), ``joint_springs``
        (``joint``, whether ``torsional``, ``radial``, ``torsion_damped`` and ``radially_damped``),
        ``loads`` (``name``, ``at``, ``axes``, ``over``, ``force`` in N and ``torque`` in N m where
        they are largest) and ``gravity`` (x and y, in m/s^2). A place ``at`` is the number of a
        link and how far along it from 0 to 1; the end of a spring on the ground is ``ground``, x
        and y in m.
    """
    topology = mechanism.linkage.topology

    def at(link: str, x: float) -> list[float]:
        number = topology.index(link)
        return [number, x / topology.links[number].length]

    parts = drawn_joints(topology)
    places = {joint["name"]: joint["at"] for joint in parts["joints"]}
    masses = [
        {"at": places[joint], "kg": mass}
        for joint, mass in mechanism.joint_masses.items()
        if mass > 0
    ]
    masses += [
        {"at": at(point.link, point.position), "kg": point.mass}
        for point in mechanism.link_masses
        if point.mass > 0
    ]
    return parts | {
        "masses": masses,
        "bodies": [
            {
                "at": at(body.link, body.position),
                "offset": list(body.offset),
                "outline": [[x - body.position, y] for x, y in body.outline],
                "kg": body.mass,
            }
            for body in mechanism.bodies
        ],
        "springs": [
            {
                "name": one.name,
                "ends": [_end(topology, one.first), _end(topology, one.second)],
                "stiff": one.stiffness > 0,
                "damped": one.damping > 0,
            }
            for one in mechanism.springs
        ],
        "joint_springs": [
            {
                "joint": one.joint,
                "torsional": one.torsional_stiffness > 0,
                "radial": one.radial_stiffness is not None,
                "torsion_damped": one.torsional_damping > 0,
                "radially_damped": one.radial_damping > 0,
            }
            for one in mechanism.joint_springs
        ],
        "loads": [
            {"at": at(load.point.link, load.point.x), **_largest(load)} for load in mechanism.loads
        ],
        "gravity": list(mechanism.gravity),
    }


def drawing(mechanism: _Shown, crank_angle: float | None = None) -> str:
    """The parts of :func:`drawn_parts` as the text of a dataset's attribute ``drawing``.

    Parameters
    ----------
    mechanism : Mechanism
    crank_angle : float, optional
        In rad. With it the text tells the posture too, ``ends`` of each link in m at that
        ``crank_angle``, for datasets that hold no positions of links.

    Returns
    -------
    str

    Raises
    ------
    InputError
        If the linkage cannot stand at the crank angle.
    """
    parts = drawn_parts(mechanism)
    if crank_angle is not None:
        ends = linkage_positions(mechanism.linkage, crank_angle)["rigid_position"].values
        parts["posture"] = {"crank_angle": crank_angle, "ends": ends.tolist()}
    return json.dumps(parts)


def _end(topology: Topology, point: AttachmentPoint) -> dict[str, Any]:
    if point.is_ground:
        return {"ground": [point.x, point.y]}
    number = topology.index(point.link)
    return {"at": [number, point.x / topology.links[number].length]}


def _largest(load: Load) -> dict[str, Any]:
    """A load where its force, and where its torque is largest."""
    force = load.force[int(np.argmax(np.hypot(*np.transpose(load.force))))]
    torque = load.torque[int(np.argmax(np.abs(load.torque)))]
    return {
        "name": load.name,
        "axes": load.axes,
        "over": load.over,
        "force": list(force),
        "torque": torque,
    }


def part_lines(
    joint_masses: Mapping[str, float],
    link_masses: Iterable[PointMass],
    bodies: Iterable[AttachedBody],
    loads: Iterable[Load],
    springs: Iterable[Spring],
    joint_springs: Iterable[JointSpring],
    joint_pins: Iterable[JointPin],
) -> list[str]:
    """Parts of a mechanism in words, a line for each kind: of masses always, of others if any.

    Parameters
    ----------
    joint_masses : mapping of str to float
        In kg, by joint.
    link_masses : iterable of PointMass
    bodies : iterable of AttachedBody
    loads : iterable of Load
    springs : iterable of Spring
    joint_springs : iterable of JointSpring
    joint_pins : iterable of JointPin

    Returns
    -------
    list of str
    """
    points = (f"{p.link} {1e3 * p.mass:.6g} g at {1e3 * p.position:.6g} mm" for p in link_masses)
    kinds = {
        "joint masses": [f"{joint} {1e3 * mass:.6g} g" for joint, mass in joint_masses.items()],
        "link point masses": list(points),
        "bodies": [_body(body) for body in bodies],
        "loads": [f"{load.name} on the {_place(load.point)}, {_size(load)}" for load in loads],
        "springs": [_spring(spring) for spring in springs],
        "springs in joints": [f"{x.joint} {', '.join(_in_joint(x))}" for x in joint_springs],
        "diameters of pins": [f"{pin.joint} {1e3 * pin.diameter:.6g} mm" for pin in joint_pins],
    }
    return [
        f"{kind}: {'; '.join(texts) if 'masses' not in kind else ', '.join(texts) or 'none'}"
        for kind, texts in kinds.items()
        if texts or "masses" in kind
    ]


def _place(point: AttachmentPoint) -> str:
    if point.is_ground:
        return f"ground at ({1e3 * point.x:.6g}, {1e3 * point.y:.6g}) mm"
    return f"{point.link} at {1e3 * point.x:.6g} mm"


def _body(body: AttachedBody) -> str:
    size = f"{1e3 * body.mass:.6g} g, {body.inertia:.6g} kg m^2"
    along, across = (1e3 * distance for distance in body.offset)
    beside = f", its centre ({along:.6g}, {across:.6g}) mm from there" if any(body.offset) else ""
    return f"{body.link} {size} at {1e3 * body.position:.6g} mm{beside}"


def _size(load: Load) -> str:
    """Greatest force and torque of a load, and over what it changes."""
    force = max(math.hypot(*pair) for pair in load.force)
    torque = max(abs(value) for value in load.torque)
    parts = ([f"{force:.6g} N"] if force else []) + ([f"{torque:.6g} N m"] if torque else [])
    size = " and ".join(parts) or "0 N"
    if load.over == "constant":
        return size
    return f"at most {size}, over the {load.over.replace('_', ' ')}"


def _spring(spring: Spring) -> str:
    ends = f"{_place(spring.first)} to {_place(spring.second)}"
    return (
        f"{spring.name} {spring.stiffness:.6g} N/m, {1e3 * spring.free_length:.6g} mm long "
        f"without force, {ends}"
    )


def _in_joint(spring: JointSpring) -> Iterator[str]:
    if spring.torsional_stiffness:
        free = f"free at {math.degrees(spring.free_angle):.6g} deg"
        yield f"{spring.torsional_stiffness:.6g} N m/rad {free}"
    if spring.torsional_damping:
        yield f"{spring.torsional_damping:.6g} N m s/rad"
    if spring.radial_stiffness is not None:
        yield f"{spring.radial_stiffness:.6g} N/m radially"


def notebook_html(mechanism: _Shown) -> str:
    """A mechanism as a notebook shows it: in words, drawn, and its links in a table.

    Parameters
    ----------
    mechanism : Mechanism
    """
    from flexmech.plots import figure_html, plot_linkage

    dataset = linkage_positions(mechanism.linkage, picture_crank_angle(mechanism.linkage))
    figure = plot_linkage(
        dataset.assign_attrs(mechanism=mechanism.provenance.name, drawing=drawing(mechanism))
    )
    headings = ("link", "length (mm)", "mass (g)", "EA (N)", "EI (N m²)", "thickness (mm)")
    rows: list[tuple[str, ...]] = [headings]
    for link in mechanism.linkage.topology.links:
        length, section = link.length * 1e3, mechanism.sections.get(link.name)
        if section is None:
            mass = mechanism.link_mass(link.name).moment(0)
            rows.append((link.name, f"{length:.5g}", f"{1e3 * mass:.5g}", "rigid", "rigid", ""))
            continue
        numbers = (
            length,
            section.mass_per_length * link.length * 1e3,
            section.axial_stiffness,
            section.bending_stiffness,
            section.in_plane_thickness * 1e3,
        )
        rows.append((link.name, *(f"{number:.5g}" for number in numbers)))
    cells = ("".join(f"<td>{escape(text)}</td>" for text in row) for row in rows)
    table = "".join(f"<tr>{row}</tr>" for row in cells)
    return f"<p>{escape(repr(mechanism))}</p>{figure_html(figure)}<table>{table}</table>"
