"""From ``--engine``, ``--element`` and ``--elements`` to engines."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexmech.choices import ELEMENTS, ElementName, EngineChoice, EngineName, element_of, engine_of
from flexmech.errors import InputError

if TYPE_CHECKING:
    from flexmech.linear_system import Engine
    from flexmech.mechanism import Mechanism

__all__ = ["element_by_engine", "make_engines"]

Chosen = dict[EngineName, ElementName | None]


def element_by_engine(engine: EngineChoice, element: ElementName | None) -> Chosen:
    """Which engines run, and the element of each.

    Parameters
    ----------
    engine : {"reference", "exudyn", "both"}
    element : str, optional
        Goes to the engine that has it; the other one takes the element of the same theory,
        so that the two can be held against each other.

    Returns
    -------
    dict
        Element by engine, the reference first; None where the engine shall choose.

    Raises
    ------
    InputError
        If none of the engines chosen has the element.
    """
    chosen: list[EngineName] = list(ELEMENTS) if engine == "both" else [engine]
    if element is None:
        return dict.fromkeys(chosen)
    if engine_of(element) not in chosen:
        own = ", ".join(name for one in chosen for name in ELEMENTS[one])
        raise InputError(
            f"--element {element} is not an element of the {engine} engine, which has {own}; "
            f"choose --engine {engine_of(element)} or --engine both, or leave --element out"
        )
    return {one: element_of(one, element) for one in chosen}


def make_engines(mechanism: Mechanism, chosen: Chosen, elements: int) -> list[Engine]:
    """Make the engines chosen, the reference first.

    Parameters
    ----------
    mechanism : Mechanism
    chosen : dict
        Element by engine, of :func:`element_by_engine`.
    elements : int
        On each link.

    Returns
    -------
    list of Engine
    """
    engines: list[Engine] = []
    if "reference" in chosen:
        from flexmech.reference import ReferenceEngine

        engines.append(ReferenceEngine(mechanism, elements, chosen["reference"]))
    if "exudyn" in chosen:
        from flexmech.multibody import ExudynEngine

        engines.append(ExudynEngine(mechanism, elements, chosen["exudyn"]))
    return engines
