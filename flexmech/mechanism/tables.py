"""Tables of a model file that a mechanism writes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flexmech.linkages import Linkage
from flexmech.materials import REFERENCE_TEMPERATURE
from flexmech.mechanism.attachment_tables import body_table
from flexmech.mechanism.parts import AttachedBody, PointMass, Wetting
from flexmech.model_text import SharedTables, TomlTable, quantity
from flexmech.sections import BeamSection
from flexmech.units import ACCELERATION, ANGULAR_SPEED, INERTIA, TEMPERATURE


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
            {**body_table(body), **_beam_number(beams, body.link)}
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


def environment_table(gravity: Sequence[float], reference_temperature: float) -> TomlTable:
    """Table ``[environment]``; empty where it is as if left out.

    Parameters
    ----------
    gravity : sequence of float
        Along x and y in m/s^2.
    reference_temperature : float
        In K.

    Returns
    -------
    dict
    """
    table: TomlTable = {}
    if any(gravity):
        table["gravity"] = [quantity(component, ACCELERATION) for component in gravity]
    if reference_temperature != REFERENCE_TEMPERATURE:
        table["reference_temperature"] = quantity(reference_temperature, TEMPERATURE)
    return table


def operation_table(crank_speeds: Sequence[float]) -> TomlTable:
    """Table ``[operation]``; empty where no speed is stated."""
    speeds = [quantity(speed, ANGULAR_SPEED) for speed in crank_speeds]
    return {"crank_speeds": speeds} if speeds else {}


def shaft_table(inertia: float) -> TomlTable:
    """Table ``[shaft]``; empty where it has no inertia."""
    return {"inertia": quantity(inertia, INERTIA)} if inertia else {}
