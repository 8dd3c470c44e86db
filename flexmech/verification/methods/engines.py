"""Engines by name, on the example models."""

from __future__ import annotations

from functools import cache
from typing import Any

from flexmech.choices import ElementName, EngineName
from flexmech.example_models import example_model
from flexmech.mechanics import Engine
from flexmech.mechanism import Mechanism
from flexmech.modelfile import load_mechanism
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine

SLENDER: dict[EngineName, ElementName] = {"reference": "euler", "exudyn": "ancf"}
"""Elements that only bend and stretch, as the published frequencies of slender links have it."""


@cache
def example(name: str) -> Mechanism:
    """Mechanism of an example model."""
    return load_mechanism(example_model(name))


def engine_of_name(
    engine: EngineName, mechanism: Mechanism, elements: int, **options: Any
) -> Engine:
    """Make an engine; further options are its own, ``element`` and ``component_modes``.

    Parameters
    ----------
    engine : {"reference", "exudyn"}
    mechanism : Mechanism
    elements : int
        On each link.

    Returns
    -------
    Engine
    """
    kinds: dict[EngineName, type[Engine]] = {"reference": ReferenceEngine, "exudyn": ExudynEngine}
    return kinds[engine](mechanism, elements, **options)
