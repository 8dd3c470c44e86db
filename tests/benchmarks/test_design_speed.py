"""Frequencies of many designs at once beside a loop over them, in one run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexmech
from flexmech.analyses.designs import of_designs
from flexmech.analyses.frequencies.formulation import Formulation
from flexmech.analyses.frequencies.positions import _along, _systems
from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import Engine
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


def engines(mechanisms: list[Mechanism]) -> list[Engine]:
    return [flexmech.ReferenceEngine(mechanism, element="euler") for mechanism in mechanisms]


def together(own: list[Engine], prestress: Any, speed: float) -> list[FloatArray]:
    formulation = Formulation(prestress, bool(speed), MODES)

    def compute(engine: Engine, numbers: IntArray) -> list[FloatArray]:
        angle = np.tile(ANGLES, len(numbers))
        velocity = np.full(angle.shape, speed)
        systems = _systems(engine, angle, velocity, formulation)[2]
        return [*_along(systems, angle, velocity)[0].reshape(len(numbers), len(ANGLES), MODES)]

    return of_designs(own, compute)  # type: ignore[return-value]


@pytest.mark.parametrize("way", ["one by one", "together"])
@pytest.mark.parametrize(
    ("prestress", "speed"), [("none", 0.0), ("axial", 20.0), ("equilibrium", 20.0)]
)
def test_designs(benchmark: Any, models: Path, prestress: Any, speed: float, way: str) -> None:
    """Engines, links, component modes and their check are made anew in every round."""
    mechanisms = designs(models)
    benchmark.group = f"{DESIGNS} designs, {prestress}, {speed:g} rad/s"

    def one_by_one() -> list[FloatArray]:
        return [
            flexmech.natural_frequencies(
                engine,
                ANGLES,
                speed,
                modes=MODES,
                prestress=prestress,
                rotation_terms=bool(speed),
            )
            for engine in engines(mechanisms)
        ]

    if way == "together":
        found = benchmark(lambda: together(engines(mechanisms), prestress, speed))
    else:
        found = benchmark.pedantic(one_by_one, rounds=2)
    assert np.shape(found) == (DESIGNS, len(ANGLES), MODES)
