"""Engines and elements of ``--engine``, ``--element`` and ``--elements``."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from flexmech.errors import InputError

if TYPE_CHECKING:
    from flexmech.linear_system import Engine as AnyEngine
    from flexmech.mechanism import Mechanism

__all__ = [
    "Element",
    "ElementOption",
    "Elements",
    "Engine",
    "EngineOption",
    "element_of_engines",
    "make_engines",
]


class Engine(StrEnum):
    """Choices of ``--engine``."""

    reference = "reference"
    exudyn = "exudyn"
    both = "both"


class Element(StrEnum):
    """Choices of ``--element``."""

    euler = "euler"
    ancf = "ancf"
    geometrically_exact = "geometrically-exact"


EngineOption = Annotated[Engine, typer.Option(help="Which engine computes.")]
ElementOption = Annotated[
    Element | None,
    typer.Option(
        help="Beam element, for the engine that has it. Left out: euler in the reference, "
        "ancf in Exudyn."
    ),
]
Elements = Annotated[int, typer.Option(min=1, help="Elements on each link.")]

_ELEMENTS = {
    Engine.reference: (Element.euler,),
    Engine.exudyn: (Element.ancf, Element.geometrically_exact),
}


def element_of_engines(engine: Engine, element: Element | None) -> dict[Engine, Element]:
    """Which engines run, and the element of each.

    Parameters
    ----------
    engine : Engine
    element : Element or None
        Goes to the engine that has it; the other one keeps its default.

    Returns
    -------
    dict
        Element by engine, the reference first.

    Raises
    ------
    InputError
        If none of the engines chosen has the element.
    """
    chosen = list(_ELEMENTS) if engine is Engine.both else [engine]
    if element is not None and not any(element in _ELEMENTS[one] for one in chosen):
        owner = next(one for one, elements in _ELEMENTS.items() if element in elements)
        own = ", ".join(_ELEMENTS[engine])
        raise InputError(
            f"--element {element} is not an element of the {engine} engine, which has {own}; "
            f"choose --engine {owner} or --engine both, or leave --element out"
        )
    return {one: element if element in _ELEMENTS[one] else _ELEMENTS[one][0] for one in chosen}


def make_engines(
    mechanism: Mechanism, chosen: dict[Engine, Element], elements: int
) -> list[AnyEngine]:
    """Make the engines chosen, each with its element.

    Parameters
    ----------
    mechanism : Mechanism
    chosen : dict
        Element by engine, of :func:`element_of_engines`.
    elements : int
        On each link.

    Returns
    -------
    list of flexmech.linear_system.Engine
        The reference first.
    """
    engines: list[AnyEngine] = []
    if Engine.reference in chosen:
        from flexmech.reference import ReferenceEngine

        element = chosen[Engine.reference]
        engines.append(ReferenceEngine(mechanism, elements=elements, element=element.value))
    if Engine.exudyn in chosen:
        from flexmech.multibody import ExudynEngine

        element = chosen[Engine.exudyn]
        engines.append(ExudynEngine(mechanism, elements=elements, element=element.value))
    return engines
