"""What is known of a mechanism: sections, masses, words, and natural frequencies at rest."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from flexmech.analyses.check.drawn import drawn_mechanism
from flexmech.analyses.check.remarks import remarks
from flexmech.analyses.check.result import ModelCheck
from flexmech.analyses.datasets import provenance, with_units
from flexmech.analyses.frequencies.discretisation import mesh_error
from flexmech.analyses.frequencies.formulation import Formulation, Systems
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.analyses.requests import engine_of
from flexmech.analyses.section_profile.properties import LINK_PROPERTIES, section_properties
from flexmech.choices import MODES
from flexmech.errors import ComputationError, InputError
from flexmech.hygrothermal import absorbing_links, inert_links
from flexmech.linear_system import Engine
from flexmech.linkages import shown_crank_angle
from flexmech.mechanism import Mechanism
from flexmech.numbers import checked_number
from flexmech.threads import one_thread
from flexmech.types import FloatArray
from flexmech.units import ZERO_CELSIUS


def check_mechanism(engine: Engine, crank_angle: float | None = None) -> ModelCheck:
    """What is known of a mechanism, with its natural frequencies at rest and remarks on it.

    Parameters
    ----------
    engine : Engine
        Of the mechanism; it computes the frequencies.
    crank_angle : float, optional
        Of the frequencies and of the posture that is drawn, in rad. Left out: frequencies at 0,
        and a posture in which the links stand apart.

    Returns
    -------
    ModelCheck
        Without frequencies where the linkage cannot stand at crank angle 0 or has rigid links
        alone, and without a posture where it stands at no angle that was tried.

    Raises
    ------
    InputError
        If the linkage cannot stand at the crank angle that is given.
    ComputationError
        As :func:`flexmech.natural_frequencies`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> check = flexmech.check_mechanism(flexmech.ReferenceEngine(mechanism))
    >>> check.dataset["length"].values
    array([0.102 , 0.2794, 0.2667])
    >>> check.remarks[0].partition(":")[0]
    'transmission angle 32.21 to 81.33 deg leaves 40 to 140 deg'
    """
    mechanism = engine_of(engine, elastic=False).mechanism
    links = mechanism.linkage.topology.links
    sections = {link.name: mechanism.sections.get(link.name) for link in links}
    dataset = section_properties(sections).sel(coupling="with", drop=True)
    lengths = np.array([link.length for link in links])
    masses = lengths * dataset["mass_per_length"].values
    for number, link in enumerate(links):
        if sections[link.name] is None:
            own = (body.mass for body in mechanism.bodies if body.link == link.name)
            masses[number] = sum(own)
    of_links = (lengths, masses)
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
    at = 0.0 if crank_angle is None else checked_number(crank_angle, "crank_angle", "rad")
    dataset["frequency_angle"] = at
    frequency = None
    try:
        frequency, error = _oscillating(engine, at)
        dataset["frequency"] = ("mode", frequency)
        dataset["discretisation_error"] = ("mode", error)
    except InputError as error:
        if crank_angle is not None and not all(link.rigid for link in links):
            raise
        # Not every linkage can stand at crank angle zero; what is known of it is right even so.
        dataset.attrs["without_frequencies"] = str(error)
    with suppress(InputError):  # it stands at no angle that is tried: there is nothing to draw
        posture = shown_crank_angle(mechanism.linkage) if crank_angle is None else at
        drawn = drawn_mechanism(mechanism, posture)
        dataset = dataset.merge(drawn).assign_attrs(drawn.attrs)
    dataset.attrs["remarks"] = "\n".join(remarks(mechanism, frequency))
    return ModelCheck(with_units(dataset, "check"))


def _oscillating(engine: Engine, crank_angle: float) -> tuple[FloatArray, FloatArray]:
    """Natural frequencies of the lowest modes, of as many as oscillate, and their mesh error."""
    for modes in range(MODES, 1, -1):
        try:
            return _at_rest(engine, crank_angle, modes)
        except ComputationError:
            # Strongly damped links have few modes that oscillate.
            continue
    return _at_rest(engine, crank_angle, 1)


def _at_rest(engine: Engine, crank_angle: float, modes: int) -> tuple[FloatArray, FloatArray]:
    frequency = natural_frequencies(engine, crank_angle, modes=modes)
    systems = Systems(engine.fit_for(modes), Formulation(modes=modes))
    with one_thread():
        error = mesh_error(systems, np.array([crank_angle]), 0.0)
    return frequency, error.frequency[0]


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
