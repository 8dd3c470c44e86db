"""Links as a model file names them, and places along them on the beams that engines know.

Pins of joints are placed here as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from flexmech.arrays import SAME_PLACE
from flexmech.errors import InputError, suggestion
from flexmech.linkages import AttachmentPoint, Linkage, PlanarLinkage
from flexmech.linkages.topology import Link, LinkEnd
from flexmech.mechanism import JointPin, PinEye
from flexmech.mechanism.checks import checked_parts
from flexmech.modelfile.attachment_tables import EYE_KEYS, JointTable
from flexmech.modelfile.document import ModelFile
from flexmech.modelfile.link_tables import LinkTable
from flexmech.modelfile.messages import Findings


class LinkPlaces:
    """Links of a file, each with its beams.

    Parameters
    ----------
    linkage : Linkage
    """

    def __init__(self, linkage: Linkage) -> None:
        self.linkage = linkage
        links = {link.name: link for link in linkage.topology.links}
        self.beams: dict[str, tuple[Link, ...]] = {name: (link,) for name, link in links.items()}
        self.names = list(links)
        if isinstance(linkage, PlanarLinkage):
            for drawn in linkage.links:
                self.beams[drawn.name] = tuple(links[beam.name] for beam in drawn.beams)
            self.names = [drawn.name for drawn in linkage.links]

    def parent(self, beam: str) -> str:
        """Link of the file that a beam belongs to."""
        return next(name for name in self.names if beam in [link.name for link in self.beams[name]])

    def table_of(self, beam: str, tables: Mapping[str, LinkTable]) -> str:
        """Name of the table of a beam: its own where there is one, or that of its link."""
        return beam if beam in tables else self.parent(beam)

    def length(self, link: str) -> float:
        """Length of all beams of a link in m."""
        return sum(beam.length for beam in self.beams[link])

    def place(self, link: str, position: float, beam: int | None = None) -> AttachmentPoint:
        """Place at a distance along a link.

        Parameters
        ----------
        link : str
            Link of the file, or a beam.
        position : float
            In m from its first joint, or from the start of a beam.
        beam : int, optional
            Number of the beam, 1 is the first.

        Returns
        -------
        AttachmentPoint

        Raises
        ------
        InputError
            If there is no such link or beam, or the position is beyond its end.
        """
        if link not in self.beams:
            raise InputError(f"there is no link {link!r}; {suggestion(link, self.names)}")
        beams = self.beams[link]
        if beam is not None:
            if beam > len(beams):
                raise InputError(
                    f"got beam {beam}, but the {link} has {len(beams)}; choose 1 to {len(beams)}"
                )
            beams = (beams[beam - 1],)
        whole = sum(own.length for own in beams)
        # Rounding of drawn coordinates may put the end of a link there.
        slack = SAME_PLACE if isinstance(self.linkage, PlanarLinkage) else 0.0
        if position > whole * (1 + slack):
            raise InputError(
                f"got {position:g} m, which is beyond the end of the {link}; choose "
                f"0 to {whole:g} m from its first joint"
            )
        for own in beams[:-1]:
            if position <= own.length:
                return AttachmentPoint(own.name, position)
            position -= own.length
        return AttachmentPoint(beams[-1].name, min(position, beams[-1].length))

    def ends(self, name: str) -> list[LinkEnd]:
        """Ends of beams at a point of the linkage or at a joint, the leading one first.

        Parameters
        ----------
        name : str

        Returns
        -------
        list of LinkEnd

        Raises
        ------
        InputError
            If there is no such point.
        """
        topology = self.linkage.topology
        known = dict(topology.joints)
        drawn: dict[str, list[LinkEnd]] = {}
        if isinstance(self.linkage, PlanarLinkage):
            for point in self.linkage.points:
                at_point = self.linkage.drawing.ends_at(point)
                drawn[point] = [end for ends in at_point.values() for end in ends]
        if name not in known and name not in drawn:
            names = list(dict.fromkeys([*drawn, *known]))
            raise InputError(f"there is no point {name!r}; {suggestion(name, names)}")
        leader = [known[name]] if name in known else []
        ties = [tie.follower for tie in topology.ties if tie.joint == name]
        return list(dict.fromkeys([*leader, *drawn.get(name, []), *ties]))

    def at_end(self, end: LinkEnd) -> AttachmentPoint:
        """Place of an end of a beam."""
        topology = self.linkage.topology
        length = topology.links[topology.index(end.link)].length
        return AttachmentPoint(end.link, 0.0 if end.end == "start" else length)


def joint_pins(tables: ModelFile, places: LinkPlaces, findings: Findings) -> tuple[JointPin, ...]:
    """Pins of the joints that state a diameter.

    Parameters
    ----------
    tables : ModelFile
    places : LinkPlaces
    findings : Findings
        What is wrong; completed here.

    Returns
    -------
    tuple of JointPin
    """
    topology = places.linkage.topology
    pins: list[JointPin] = []
    for name, joint in tables.joints.items():
        with findings.at(f"joints.{name}"):
            # The message on a joint that does not exist names all its keys.
            if joint.diameter is None or name not in topology.joint_names:
                continue
            ends = topology.turning_ends.get(name, ())
            beams = [end.link for end in ends if end is not None]
            # A link of several beams goes by its own name.
            parents = [places.parent(beam) for beam in beams]
            eyes = tuple(
                PinEye(beam, **(joint.eye_sizes(parent) | joint.eye_sizes(beam)))
                for beam, parent in zip(beams, parents, strict=True)
            )
            pin = joint.made(JointPin, joint=name, eyes=eyes)
            pins += checked_parts(topology, "joint_pins", [pin])
            for key, link in _named(joint):
                known = list(dict.fromkeys([*parents, *beams]))
                if link not in known:
                    raise InputError(f"ends elsewhere; {suggestion(link, known)}").within(
                        f"{key}.{link}"
                    )
    return tuple(pins)


def _named(joint: JointTable) -> Iterator[tuple[str, str]]:
    """Keys of sizes of eyes that are stated by link, and the links."""
    for key in EYE_KEYS.values():
        size = getattr(joint, key)
        for link in size if isinstance(size, Mapping) else ():
            yield key, link
