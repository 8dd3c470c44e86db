"""Links whose resins swell as they do, and soften nowhere: for what asks for lengths alone."""

from __future__ import annotations

from dataclasses import replace

from flexmech.hygrothermal.environment import Environment
from flexmech.hygrothermal.link_moisture import resin_retention
from flexmech.materials import Ply, PlyComposition, UnknownStiffnessError
from flexmech.mechanism import Mechanism
from flexmech.sections import BeamSection


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
