"""From the tables of joints in a model file to their pins."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from flexmech.errors import InputError, suggestion
from flexmech.mechanism import JointPin, PinEye
from flexmech.mechanism.checks import checked_parts
from flexmech.modelfile.attachment_tables import EYE_KEYS, JointTable
from flexmech.modelfile.document import ModelFile
from flexmech.modelfile.link_places import LinkPlaces
from flexmech.modelfile.messages import Findings


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
    found: list[JointPin] = []
    for name, joint in tables.joints.items():
        with findings.at(f"joints.{name}"):
            # A joint that is not there is told of all its keys.
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
            pin = JointPin(name, joint.diameter, eyes, **joint.allowed)
            found += checked_parts(topology, "joint_pins", [pin])
            for key, link in _named(joint):
                known = list(dict.fromkeys([*parents, *beams]))
                if link not in known:
                    raise InputError(f"ends elsewhere; {suggestion(link, known)}").within(
                        f"{key}.{link}"
                    )
    return tuple(found)


def _named(joint: JointTable) -> Iterator[tuple[str, str]]:
    """Keys of sizes of eyes that are stated by link, and the links."""
    for key in EYE_KEYS.values():
        size = getattr(joint, key)
        for link in size if isinstance(size, Mapping) else ():
            yield key, link
