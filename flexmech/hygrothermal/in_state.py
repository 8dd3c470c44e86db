"""A mechanism as heat and water make it: other lengths, other sections, other masses.

A link that swells evenly along its length takes on another length and no stress; that length
goes into the linkage, so that the rigid motion is that of the swollen one. What swells
unevenly through the thickness bends the link; that stays a free curvature of its section.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from flexmech.errors import InputError
from flexmech.hygrothermal.environment import Environment, Exposure, HygrothermalState
from flexmech.hygrothermal.link_moisture import inert_links, link_profile, resin_retention
from flexmech.linkages import AttachmentPoint, CouplerPoint, FourBar, Linkage
from flexmech.materials import Ply, PlyComposition, UnknownStiffnessError
from flexmech.mechanism import Mechanism
from flexmech.sections import BeamSection, swollen_section
from flexmech.validation import check_instance


@dataclass(frozen=True)
class SwollenLink:
    """A link as the environment has made it.

    Parameters
    ----------
    length : float
        Length of its neutral axis in m, however it is bent.
    section : BeamSection
    elongation : float
        Strain from the dry to this length.
    water : float
        Mass of the water over the dry mass of the link.
    """

    length: float
    section: BeamSection
    elongation: float
    water: float

    @property
    def distance_of_pins(self) -> float:
        """In m: less than the length where the link is bent and nothing pulls it straight."""
        curvature, offset = self.section.free_curvature, self.section.neutral_axis
        if curvature == 0.0:
            return self.length
        half = curvature * self.length / 2
        # The pins stand off the ends of the neutral axis, along its normals.
        return float(self.length * np.sinc(half / np.pi) + 2 * offset * np.sin(half))


def swollen_links(mechanism: Mechanism, environment: Environment) -> dict[str, SwollenLink]:
    """Every link of a mechanism in an environment.

    Parameters
    ----------
    mechanism : Mechanism
        Dry, at its reference temperature.
    environment : HygrothermalState or Exposure

    Returns
    -------
    dict of str to SwollenLink
        Without rigid links that have no section: they stay as they are.

    Raises
    ------
    InputError
        If heat and water change no link, a resin is above its wet glass transition,
        or a property that the environment needs is not known; names the link.
    """
    check_instance(mechanism, Mechanism, "mechanism", "read one by flexmech.load_mechanism(path)")
    if not isinstance(environment, HygrothermalState | Exposure):
        raise InputError(
            f"environment must be a HygrothermalState or an Exposure, got {environment!r}; give "
            "flexmech.HygrothermalState(temperature_rise, moisture)"
        )
    topology = mechanism.linkage.topology
    inert = len(inert_links(mechanism)) == len(topology.links)
    asked = environment != HygrothermalState()
    if asked and inert and not mechanism.ground_thermal_expansion:
        raise InputError(
            f"heat and moisture change nothing in {mechanism.provenance.name!r}: no link has a "
            "thermal_expansion, a moisture_expansion or a glass_transition; add them to its "
            "materials, matrices or plies"
        )
    links = {}
    for link in topology.links:
        if link.name not in mechanism.sections:
            continue
        try:
            profile = link_profile(mechanism, link.name, environment)
            found = swollen_section(mechanism.sections[link.name], profile)
        except InputError as error:
            if error.message.startswith("links."):
                raise
            raise error.within(f"links.{link.name}") from error
        length = link.length * (1 + found.elongation)
        links[link.name] = SwollenLink(length, found.section, found.elongation, found.water)
    return links


def mechanism_in_state(mechanism: Mechanism, environment: Environment) -> Mechanism:
    """A mechanism in heat and water.

    Parameters
    ----------
    mechanism : Mechanism
        Dry, at its reference temperature.
    environment : HygrothermalState or Exposure

    Returns
    -------
    Mechanism
        With swollen lengths, softer and heavier sections, and their free curvatures. Dry and at
        the reference temperature it equals the mechanism to the last bit.

    Raises
    ------
    InputError
        As :func:`swollen_links`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/neat_resin_figure_8.toml")
    >>> wet = flexmech.mechanism_in_state(mechanism, flexmech.HygrothermalState(80.0, 0.07))
    >>> round(wet.linkage.crank / mechanism.linkage.crank, 6)
    1.026148
    """
    links, point = swollen_links(mechanism, environment), mechanism.coupler_point
    name = mechanism.provenance.name
    if environment != HygrothermalState():
        name = f"{name}, {environment.label}"
    return replace(
        mechanism,
        linkage=_resized(
            mechanism, environment, {link: swollen.length for link, swollen in links.items()}
        ),
        sections={link: swollen.section for link, swollen in links.items()},
        link_masses=tuple(
            replace(point, position=point.position * _growth(point.link, links))
            for point in mechanism.link_masses
        ),
        bodies=tuple(
            replace(body, position=body.position * _growth(body.link, links))
            for body in mechanism.bodies
        ),
        loads=tuple(
            replace(load, point=_moved_place(load.point, links)) for load in mechanism.loads
        ),
        springs=tuple(
            replace(
                spring,
                first=_moved_place(spring.first, links),
                second=_moved_place(spring.second, links),
            )
            for spring in mechanism.springs
        ),
        coupler_point=None if point is None else point.scaled(_growth("coupler", links)),
        provenance=replace(mechanism.provenance, name=name),
    )


def linkage_in_state(mechanism: Mechanism, environment: Environment) -> FourBar:
    """The rigid linkage with the distances of its pins in an environment.

    Parameters
    ----------
    mechanism : Mechanism
        Mechanism of a four-bar, dry.
    environment : HygrothermalState or Exposure

    Returns
    -------
    FourBar
        A link that its moisture bends has its pins nearer to each other than its length.

    Raises
    ------
    InputError
        If the linkage is no four-bar, or as :func:`swollen_links`.
    """
    linkage = rigid_linkage_in_state(mechanism, environment)
    if not isinstance(linkage, FourBar):
        raise InputError("a coupler curve needs a linkage of kind 'four-bar'")
    return linkage


def rigid_linkage_in_state(mechanism: Mechanism, environment: Environment) -> Linkage:
    """The rigid linkage of any kind with the distances of its pins in an environment.

    Parameters
    ----------
    mechanism : Mechanism
        Dry.
    environment : HygrothermalState or Exposure

    Returns
    -------
    Linkage
        A link that its moisture bends has its pins nearer to each other than its length.

    Raises
    ------
    InputError
        As :func:`swollen_links`.
    """
    links = swollen_links(mechanism, environment)
    lengths = {link: swollen.distance_of_pins for link, swollen in links.items()}
    return _resized(mechanism, environment, lengths)


def elongation_of(mechanism: Mechanism, link: str, environment: Environment) -> float:
    """Strain of a link in an environment; zero of a rigid one without a section.

    Parameters
    ----------
    mechanism : Mechanism
        Dry.
    link : str
    environment : HygrothermalState or Exposure

    Returns
    -------
    float
    """
    found = swollen_links(mechanism, environment).get(link)
    return 0.0 if found is None else found.elongation


def coupler_point_in_state(
    mechanism: Mechanism, point: CouplerPoint, environment: Environment
) -> CouplerPoint:
    """A point of the coupler that swells along with it.

    Parameters
    ----------
    mechanism : Mechanism
    point : CouplerPoint
        On the dry coupler.
    environment : HygrothermalState or Exposure

    Returns
    -------
    CouplerPoint
        Farther from A by the coupler's elongation, under the same angle (Singh & Sanyal 2022,
        sec. 4, corrected).
    """
    return point.scaled(1 + elongation_of(mechanism, "coupler", environment))


def _growth(link: str, links: Mapping[str, SwollenLink]) -> float:
    """New over old distances along a link."""
    return 1 + links[link].elongation if link in links else 1.0


def _moved_place(point: AttachmentPoint, links: Mapping[str, SwollenLink]) -> AttachmentPoint:
    """A place on a link that swells along with it; places of the ground stay."""
    return point if point.is_ground else replace(point, x=point.x * _growth(point.link, links))


def _resized(
    mechanism: Mechanism, environment: Environment, lengths: Mapping[str, float]
) -> Linkage:
    """The linkage with other link lengths, and the frame as its own expansion has it.

    Singh & Sanyal 2022, sec. 3, corrected: lengths times one plus the strain.
    """
    growth = 1 + mechanism.ground_thermal_expansion * environment.temperature_rise
    own = {link.name: link.length for link in mechanism.linkage.topology.links}
    return mechanism.linkage.resized({**own, **lengths}, growth)


def links_of_unknown_stiffness(mechanism: Mechanism, environment: Environment) -> tuple[str, ...]:
    """Links with a resin whose stiffness in an environment is not known.

    Parameters
    ----------
    mechanism : Mechanism
        Dry.
    environment : HygrothermalState or Exposure

    Returns
    -------
    tuple of str
        Those above their wet glass transition, or too moist for the rule that tells it.

    Raises
    ------
    InputError
        As :func:`flexmech.hygrothermal.swollen_links` for any other reason.
    """

    def unknown(link: str) -> bool:
        try:
            resin_retention(mechanism, link, environment)
        except UnknownStiffnessError:
            return True
        return False

    return tuple(filter(unknown, mechanism.linkage.topology.link_names))


def without_softening(mechanism: Mechanism) -> Mechanism:
    """The mechanism with resins that have no glass transition.

    Links of one resin swell the same without. Where fibres hold the resin back, they do so as if
    it were as stiff as at the reference.

    Parameters
    ----------
    mechanism : Mechanism
        Dry.

    Returns
    -------
    Mechanism
    """
    sections = {name: _section(section) for name, section in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def _section(section: BeamSection) -> BeamSection:
    layers = section.layers
    if layers is None:
        return section
    plies = tuple(replace(layer, ply=_ply(layer.ply)) for layer in layers.laminate.layers)
    return replace(section, layers=replace(layers, laminate=replace(layers.laminate, layers=plies)))


def _ply(ply: Ply) -> Ply:
    origin = ply.origin
    if origin is None:
        return ply
    if isinstance(origin, PlyComposition):
        matrix = replace(origin.matrix, glass_transition=None)
        return replace(ply, origin=replace(origin, matrix=matrix))
    resin = replace(origin.hygrothermal, glass_transition=None)
    return replace(ply, origin=replace(origin, hygrothermal=resin))
