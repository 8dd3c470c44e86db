"""Natural frequencies of many designs, one after the other, as studies compute them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexmech
from flexmech.arrays import FloatArray
from flexmech.mechanism import Mechanism

ANGLES = np.linspace(0.0, 2 * np.pi, 36, endpoint=False)
DESIGNS, MODES = 64, 3


def designs(models: Path) -> list[Mechanism]:
    """Aluminium four-bars with links of other thicknesses."""
    mechanism = flexmech.load_mechanism(models / "aluminium_fourbar.toml")
    random = np.random.default_rng(0)
    found = []
    for thicker in 1 + 0.2 * random.random((DESIGNS, 3)):
        sections = {
            link: replace(
                section,
                axial_stiffness=factor * section.axial_stiffness,
                bending_stiffness=factor**3 * section.bending_stiffness,
                mass_per_length=factor * section.mass_per_length,
            )
            for (link, section), factor in zip(mechanism.sections.items(), thicker, strict=True)
        }
        found.append(replace(mechanism, sections=sections))
    return found


@pytest.mark.parametrize(
    ("prestress", "speed"), [("none", 0.0), ("axial", 20.0), ("equilibrium", 20.0)]
)
def test_designs(benchmark: Any, models: Path, prestress: Any, speed: float) -> None:
    """Engines, links, component modes and their check are made anew in every round."""
    mechanisms = designs(models)

    def one_by_one() -> list[FloatArray]:
        return [
            flexmech.natural_frequencies(
                flexmech.ReferenceEngine(mechanism, element="euler"),
                ANGLES,
                speed,
                modes=MODES,
                prestress=prestress,
                rotation_terms=bool(speed),
            )
            for mechanism in mechanisms
        ]

    found = benchmark.pedantic(one_by_one, rounds=2)
    assert np.shape(found) == (DESIGNS, len(ANGLES), MODES)
