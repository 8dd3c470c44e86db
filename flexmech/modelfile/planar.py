"""From the tables of a drawn linkage to the linkage."""

from __future__ import annotations

from flexmech.errors import InputError
from flexmech.linkages import Linkage, PlanarJoint, PlanarLink, PlanarLinkage
from flexmech.modelfile.attachment_tables import JointTable
from flexmech.modelfile.document import ModelFile
from flexmech.modelfile.linkage_tables import PlanarTable
from flexmech.modelfile.messages import Findings


def stated_linkage(tables: ModelFile, findings: Findings) -> Linkage | None:
    """Linkage of a model file.

    Parameters
    ----------
    tables : ModelFile
    findings : Findings
        What is wrong; completed here.

    Returns
    -------
    Linkage or None
        None where something is wrong.
    """
    if isinstance(tables.linkage, PlanarTable):
        return _drawn(tables, tables.linkage, findings)
    _refuse_drawing_keys(tables, findings)
    with findings.at("linkage"):
        return tables.linkage.linkage
    return None


def _refuse_drawing_keys(tables: ModelFile, findings: Findings) -> None:
    """Refuse keys of a drawing in the file of a linkage that is none."""
    kind = tables.linkage.kind
    remedy = f'leave it out, or draw the linkage with kind = "planar": a {kind} has its own'
    for name, link in tables.links.items():
        for key in ("points", "rigid"):
            if key in link.model_fields_set:
                findings.found.append(f"links.{name}.{key}: {remedy} links")
    for name, joint in tables.joints.items():
        for key in ("kind", "links", "direction", "guide", "inertia"):
            if key in joint.model_fields_set:
                findings.found.append(f"joints.{name}.{key}: {remedy} joints")


def _drawn(tables: ModelFile, table: PlanarTable, findings: Findings) -> PlanarLinkage | None:
    links, joints = _links(tables, findings), _joints(tables, table, findings)
    if findings.found:
        return None
    # Points of the ground that springs alone use belong to them.
    used = {point for link in links for point in link.points}
    sprung_to = {
        end for own in tables.springs.values() for end in own.points if isinstance(end, str)
    }
    unused = (set(table.ground) & sprung_to) - used
    with findings.at("linkage"):
        return PlanarLinkage(
            points={name: place for name, place in table.points.items() if name not in unused},
            links=tuple(links),
            ground=tuple(point for point in table.ground if point not in unused),
            joints=tuple(joints),
            drawn_at=table.drawn_at,
        )
    return None


def _links(tables: ModelFile, findings: Findings) -> list[PlanarLink]:
    """Links with points; tables without are of single beams of theirs."""
    links = [
        PlanarLink(name, tuple(table.points), table.rigid)
        for name, table in tables.links.items()
        if table.points is not None
    ]
    beams = {beam.name: link for link in links for beam in link.beams}
    for name, table in tables.links.items():
        if table.points is not None:
            continue
        with findings.at(f"links.{name}"):
            if name not in beams:
                raise InputError(
                    "points is missing; add the points at its two ends, for example points = "
                    '["A", "B"]'
                )
            if table.rigid or table.point_masses or table.bodies:
                raise InputError(
                    f"is a beam of link {beams[name].name}; state rigid, point_masses and bodies "
                    "there, with beam = its number"
                )
    return links


def _joints(tables: ModelFile, table: PlanarTable, findings: Findings) -> list[PlanarJoint]:
    joints = []
    for name, own in tables.joints.items():
        with findings.at(f"joints.{name}"):
            drawn = PlanarJoint(
                name, own.kind or "pin", tuple(own.links), own.direction, own.guide or ""
            )
            _check_inertia(own)
            # A table may be of a further joint at a point, which has a name but no kind.
            if name in table.points or drawn != PlanarJoint(name):
                joints.append(drawn)
    return joints


def _check_inertia(own: JointTable) -> None:
    if own.inertia and own.kind != "slider":
        raise InputError(
            "inertia belongs to a slider; give another joint's body to a link, in its bodies"
        )
    if own.inertia and not own.guide:
        raise InputError("a slider on the ground does not turn; leave its inertia out")
