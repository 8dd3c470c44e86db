"""Tables of a model file that a mechanism writes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from flexmech import units
from flexmech.errors import InputError
from flexmech.linkages import (
    GROUND,
    AttachmentPoint,
    JointSpring,
    Linkage,
    Load,
    PlanarJoint,
    PlanarLinkage,
    Spring,
)
from flexmech.mechanism.parts import AttachedBody, JointPin, PointMass, Wetting
from flexmech.model_text import SharedTables, TomlTable, fields_table, quantity
from flexmech.sections import BeamSection


def links_table(
    linkage: Linkage,
    sections: Mapping[str, BeamSection],
    wetting: Mapping[str, Wetting],
    points: Sequence[PointMass],
    bodies: Sequence[AttachedBody],
    shared: SharedTables,
) -> TomlTable:
    """Table ``[links]``.

    Parameters
    ----------
    linkage : Linkage
    sections : mapping of str to BeamSection
        By beam; rigid ones may have none.
    wetting : mapping of str to Wetting
    points : sequence of PointMass
    bodies : sequence of AttachedBody
    shared : SharedTables
        Tables that several links name; completed here.

    Returns
    -------
    dict
    """
    drawn = {link.name: link for link in getattr(linkage, "links", ())}
    beams_of = {name: [beam.name for beam in link.beams] for name, link in drawn.items()}
    tables: TomlTable = {}
    for name, beams in (beams_of or {own: [own] for own in linkage.topology.link_names}).items():
        own = [_beam_table(sections.get(beam), wetting.get(beam), shared) for beam in beams]
        masses = [
            {**point.to_table(), **_beam_number(beams, point.link)}
            for point in points
            if point.link in beams
        ]
        attached = [
            {**body.to_table(), **_beam_number(beams, body.link)}
            for body in bodies
            if body.link in beams
        ]
        tables[name] = {
            **({"points": list(drawn[name].points)} if drawn else {}),
            **({"rigid": True} if drawn and drawn[name].rigid else {}),
            **own[0],
            **({"point_masses": masses} if masses else {}),
            **({"bodies": attached} if attached else {}),
        }
        further = zip(beams[1:], own[1:], strict=True)
        tables |= {beam: table for beam, table in further if table != own[0]}
    return tables


def _beam_table(
    section: BeamSection | None, wetting: Wetting | None, shared: SharedTables
) -> TomlTable:
    """Keys of a beam's section and of where water enters it."""
    return {
        **({} if section is None else section.to_table(shared)),
        **({} if wetting is None else wetting.to_table()),
    }


def _beam_number(beams: Sequence[str], beam: str) -> TomlTable:
    """Key that names a beam of a chain, from whose start places are counted."""
    return {"beam": beams.index(beam) + 1} if len(beams) > 1 else {}


def joints_table(
    linkage: Linkage,
    joint_masses: Mapping[str, float],
    springs: Sequence[JointSpring],
    pins: Sequence[JointPin],
) -> TomlTable:
    """Table ``[joints]``; empty where no joint is drawn, has mass, a spring or a diameter.

    Parameters
    ----------
    linkage : Linkage
    joint_masses : mapping of str to float
        In kg, by joint.
    springs : sequence of JointSpring
    pins : sequence of JointPin

    Returns
    -------
    dict

    Raises
    ------
    InputError
        If a joint has two springs or pins: a file states one.
    """
    drawn = linkage.joints if isinstance(linkage, PlanarLinkage) else ()
    tables: dict[str, TomlTable] = {joint.point: _drawn_table(joint) for joint in drawn}
    for joint, mass in joint_masses.items():
        tables.setdefault(joint, {})["mass"] = quantity(mass, units.MASS)
    _refuse_repeated("joint_springs", [own.joint for own in springs])
    for own in springs:
        tables.setdefault(own.joint, {}).update(_spring_keys(own))
    _refuse_repeated("joint_pins", [pin.joint for pin in pins])
    for pin in pins:
        tables.setdefault(pin.joint, {}).update(pin.to_table())
    return tables


def _drawn_table(joint: PlanarJoint) -> TomlTable:
    table: TomlTable = {"kind": joint.kind}
    if joint.links:
        table["links"] = list(joint.links)
    table |= fields_table(joint, {"direction": units.ANGLE})
    return {**table, "guide": joint.guide} if joint.guide else table


def _spring_keys(own: JointSpring) -> TomlTable:
    dimensions = {
        "torsional_stiffness": units.TORSIONAL_STIFFNESS,
        "torsional_damping": units.TORSIONAL_DAMPING,
        "free_angle": units.ANGLE,
        "radial_stiffness": units.SPRING_STIFFNESS,
        "radial_damping": units.DAMPING,
    }
    # Stated even where it is zero, so that a spring without effect is read back too.
    stiffness = quantity(own.torsional_stiffness, units.TORSIONAL_STIFFNESS)
    return {"torsional_stiffness": stiffness, **fields_table(own, dimensions)}


def loads_table(loads: Sequence[Load]) -> TomlTable:
    """Table ``[loads]``; empty where there is none."""
    _refuse_repeated("loads", [load.name for load in loads])
    return {load.name: _load_table(load) for load in loads}


def _load_table(load: Load) -> TomlTable:
    table: TomlTable = _place(load.point)
    if load.axes != "ground":
        table["axes"] = load.axes
    if load.over == "constant":
        table["force"] = [quantity(along, units.FORCE) for along in load.force[0]]
        table["torque"] = quantity(load.torque[0], units.TORQUE)
        return table
    place = units.ANGLE if load.over == "crank_angle" else units.TIME
    rows = zip(load.at, load.force, load.torque, strict=True)
    table["over"] = load.over
    table["table"] = [
        [
            quantity(at, place),
            *(quantity(along, units.FORCE) for along in force),
            quantity(torque, units.TORQUE),
        ]
        for at, force, torque in rows
    ]
    return table


def springs_table(springs: Sequence[Spring]) -> TomlTable:
    """Table ``[springs]``; empty where there is none."""
    _refuse_repeated("springs", [spring.name for spring in springs])
    dimensions = {
        "stiffness": units.SPRING_STIFFNESS,
        "free_length": units.LENGTH,
        "damping": units.DAMPING,
    }
    return {
        spring.name: {
            "points": [_end(spring.first), _end(spring.second)],
            **fields_table(spring, dimensions),
        }
        for spring in springs
    }


def _end(point: AttachmentPoint) -> TomlTable | list[str | float]:
    if point.link == GROUND:
        return [quantity(point.x, units.LENGTH), quantity(point.y, units.LENGTH)]
    return _place(point)


def _place(point: AttachmentPoint) -> TomlTable:
    return {"link": point.link, "position": quantity(point.x, units.LENGTH)}


def _refuse_repeated(what: str, names: Iterable[str]) -> None:
    known: set[str] = set()
    for name in names:
        if name in known:
            raise InputError(f"{what}: {name!r} is there twice, a model file has one of a name")
        known.add(name)
