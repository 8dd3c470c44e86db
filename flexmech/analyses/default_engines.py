"""Engines by their names, and those of mechanisms that are given where an engine can be.

Analyses know no engine but by its contract; here alone one is chosen for somebody who did not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexmech import choices
from flexmech.choices import EngineName
from flexmech.errors import InputError
from flexmech.mechanics import Engine
from flexmech.mechanism import Mechanism

if TYPE_CHECKING:
    from flexmech.multibody import ExudynEngine as ExudynEngine
    from flexmech.multibody import ExudynSystem as ExudynSystem


def engine_kind(name: EngineName) -> type[Engine]:
    """Class of an engine; Exudyn is loaded only if it is chosen.

    Parameters
    ----------
    name : {"reference", "exudyn"}

    Returns
    -------
    type
    """
    if name == "reference":
        from flexmech.reference import ReferenceEngine

        return ReferenceEngine
    from flexmech.multibody import ExudynEngine

    return ExudynEngine


def engine_for(value: Engine | Mechanism, name: EngineName = "reference") -> Engine:
    """The engine of a mechanism; whatever else is given stays as it is.

    Parameters
    ----------
    value : Engine or Mechanism
    name : {"reference", "exudyn"}

    Returns
    -------
    Engine
    """
    return engine_kind(name)(value) if isinstance(value, Mechanism) else value


def chosen_engines(
    mechanism: Mechanism,
    engine: choices.EngineChoice,
    element: choices.ElementName | None = None,
    elements: int | None = None,
    shaft: choices.ShaftChoice = "prescribed",
    mass: choices.MassChoice | None = None,
) -> list[Engine]:
    """Make the engines chosen, the reference first.

    Parameters
    ----------
    mechanism : Mechanism
    engine : {"reference", "exudyn", "both"}
    element : str, optional
        Goes to the engine that has it; the other one takes the element of the same theory,
        so that the two can be held against each other. Left out: the engine chooses.
    elements : int, optional
        On each link. Left out: as many as a map begins with.
    shaft : {"prescribed", "free"}
    mass : {"distributed", "lumped"}, optional
        Mass of the reference engine; beside it Exudyn keeps distributed mass, which is that of
        both where it is left out.

    Returns
    -------
    list of Engine

    Raises
    ------
    InputError
        If none of the engines chosen has the element, or lumped masses.
    """
    chosen: list[choices.EngineName] = list(choices.ELEMENTS) if engine == "both" else [engine]
    if element is not None and choices.engine_of(element) not in chosen:
        own = ", ".join(name for one in chosen for name in choices.ELEMENTS[one])
        raise InputError(
            f"--element {element} is not an element of the {engine} engine, which has {own}; "
            f"choose --engine {choices.engine_of(element)} or --engine both, or leave --element out"
        )
    if mass == "lumped" and "reference" not in chosen:
        raise InputError(
            "--mass lumped is a choice of the reference engine; choose --engine reference, or "
            "--engine both to see distributed mass beside it"
        )
    engines: list[Engine] = []
    for name in chosen:
        kind = engine_kind(name)
        its_element = None if element is None else kind.element_like(element)
        its_mass = mass or "distributed" if name == "reference" else "distributed"
        count = elements or choices.ELEMENTS_A_LINK
        engines.append(kind(mechanism, count, its_element, shaft=shaft, mass=its_mass))
    return engines
