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
    timoshenko = "timoshenko"
    reddy = "reddy"
    ancf = "ancf"
    geometrically_exact = "geometrically-exact"


EngineOption = Annotated[Engine, typer.Option(help="Which engine computes.")]
ElementOption = Annotated[
    Element | None,
    typer.Option(
        help="Beam element: euler, timoshenko or reddy in the reference, ancf or "
        "geometrically-exact in Exudyn; the other engine takes its element of the same theory. "
        "Left out: euler and ancf, or timoshenko and geometrically-exact where a link's neutral "
        "axis is off its pins."
    ),
]
Elements = Annotated[int, typer.Option(min=1, help="Elements on each link.")]

_ELEMENTS = {
    Engine.reference: (Element.euler, Element.timoshenko, Element.reddy),
    Engine.exudyn: (Element.ancf, Element.geometrically_exact),
}


# The other engine's element of the same beam theory, or of the nearest that it has.
_COUNTERPARTS = {
    Element.euler: Element.ancf,
    Element.timoshenko: Element.geometrically_exact,
    Element.reddy: Element.geometrically_exact,
    Element.ancf: Element.euler,
    Element.geometrically_exact: Element.timoshenko,
}


def element_of_engines(engine: Engine, element: Element | None) -> dict[Engine, Element | None]:
    """Which engines run, and the element of each.

    Parameters
    ----------
    engine : Engine
    element : Element or None
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
    chosen = list(_ELEMENTS) if engine is Engine.both else [engine]
    if element is not None and not any(element in _ELEMENTS[one] for one in chosen):
        owner = next(one for one, elements in _ELEMENTS.items() if element in elements)
        own = ", ".join(_ELEMENTS[engine])
        raise InputError(
            f"--element {element} is not an element of the {engine} engine, which has {own}; "
            f"choose --engine {owner} or --engine both, or leave --element out"
        )
    if element is None:
        return dict.fromkeys(chosen)
    return {one: element if element in _ELEMENTS[one] else _COUNTERPARTS[element] for one in chosen}


def make_engines(
    mechanism: Mechanism, chosen: dict[Engine, Element | None], elements: int
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
        engines.append(ReferenceEngine(mechanism, elements=elements, element=element))
    if Engine.exudyn in chosen:
        from flexmech.multibody import ExudynEngine

        element = chosen[Engine.exudyn]
        engines.append(ExudynEngine(mechanism, elements=elements, element=element))
    return engines
