"""What is known of a mechanism: sections, masses, words, and natural frequencies at rest."""

from __future__ import annotations

import numpy as np

from flexmech.analyses.check.result import ModelCheck
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.analyses.provenance import provenance, with_units
from flexmech.analyses.requests import engine_of
from flexmech.analyses.section_profile.properties import LINK_PROPERTIES, section_properties
from flexmech.errors import InputError
from flexmech.hygrothermal import absorbing_links, inert_links
from flexmech.linear_system import Engine
from flexmech.linkages import linkage_positions
from flexmech.mechanism import Mechanism
from flexmech.units import ZERO_CELSIUS

__all__ = ["check_mechanism"]


def check_mechanism(engine: Engine) -> ModelCheck:
    """What is known of a mechanism, with its natural frequencies at rest.

    Parameters
    ----------
    engine : Engine
        Of the mechanism; it computes the frequencies at crank angle 0.

    Returns
    -------
    ModelCheck
        Without frequencies where the linkage cannot stand at crank angle 0.

    Raises
    ------
    ComputationError
        As :func:`flexmech.natural_frequencies`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> check = flexmech.check_mechanism(flexmech.ReferenceEngine(mechanism))
    >>> check.dataset["length"].values
    array([0.102 , 0.2794, 0.2667])
    """
    mechanism = engine_of(engine).mechanism
    links = mechanism.linkage.topology.links
    sections = {link.name: mechanism.sections[link.name] for link in links}
    dataset = section_properties(sections).sel(coupling="with", drop=True)
    lengths = np.array([link.length for link in links])
    of_links = (lengths, lengths * dataset["mass_per_length"].values)
    for one, values in zip(LINK_PROPERTIES, of_links, strict=True):
        dataset[one.name] = ("link", values, one.attributes)
    lines = [*mechanism.described(), *_hygrothermal_lines(mechanism)]
    dataset = dataset.assign_attrs(
        provenance([engine]),
        engine=engine.name,
        linkage="\n".join(mechanism.linkage.described()),
        mechanism_lines="\n".join(lines),
        without_frequencies="",
    )
    try:
        dataset["frequency"] = ("mode", natural_frequencies(engine, 0.0))
        dataset = dataset.merge(linkage_positions(mechanism.linkage, 0.0))
    except InputError as error:
        # Not every linkage can stand at crank angle zero; what is known of it is right even so.
        dataset.attrs["without_frequencies"] = str(error)
    return ModelCheck(with_units(dataset, "check"))


def _hygrothermal_lines(mechanism: Mechanism) -> list[str]:
    """What heat and moisture change, if there is anything."""
    inert = inert_links(mechanism)
    changed = [name for name in mechanism.linkage.topology.link_names if name not in inert]
    if not changed:
        return []
    reference = f"{mechanism.reference_temperature - ZERO_CELSIUS:.4g} degC"
    return [
        f"heat and moisture change: {', '.join(changed)}; water enters: "
        f"{', '.join(absorbing_links(mechanism)) or 'none'}; reference temperature {reference}"
    ]
