"""Sections that do not shear, and sections that are far too stiff in shear for a beam to tell."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmech import (
    ExudynEngine,
    Mechanism,
    ReferenceEngine,
    check_mechanism,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
)
from flexmech.analyses import solve_frequencies
from flexmech.verification import verification_case

MODELS = Path(__file__).parents[2] / "models"
ANGLES = np.radians([0.0, 60.0])
# The four-bar of Turcic, Midha and Bosnik (1984) in Hz, Euler-Bernoulli beams.
EXPECTED = [
    verification_case(f"Four-bar of Turcic, Midha & Bosnik at rest: {angle}, reference").expected
    for angle in ("0 deg", "60 deg")
]
ENGINES = [
    (ReferenceEngine, "euler"),
    (ReferenceEngine, "timoshenko"),
    (ReferenceEngine, "zigzag"),
    (ExudynEngine, "ancf"),
    (ExudynEngine, "geometrically-exact"),
]


def turcic(shear_stiffness: float) -> Mechanism:
    mechanism = load_mechanism(MODELS / "turcic_midha_bosnik_fourbar.toml")
    sections = {
        name: replace(section, shear_stiffness=shear_stiffness)
        for name, section in mechanism.sections.items()
    }
    return replace(mechanism, sections=sections)


@pytest.mark.parametrize("shear_stiffness", [1e9, 1e12, math.inf])
@pytest.mark.parametrize(("engine", "element"), ENGINES)
def test_component_modes_of_beams_that_hardly_shear(engine, element, shear_stiffness) -> None:
    """Round-off in them gave 47.55, 50.84 and 190.3 Hz at both angles."""
    made = engine(turcic(shear_stiffness), 16, element)
    system = made.linear_system(ANGLES, prestress="none", modes=3, detail=1.0)
    np.testing.assert_allclose(solve_frequencies(system, 3), EXPECTED, rtol=3e-4)
    exact = natural_frequencies(made.unreduced(), ANGLES, modes=3)
    np.testing.assert_allclose(solve_frequencies(system, 3), exact, rtol=1e-5)


@pytest.mark.parametrize("shear_stiffness", [1e9, 1e12, math.inf])
def test_such_beams_are_eulers(shear_stiffness: float) -> None:
    mechanism = turcic(shear_stiffness)
    assert ReferenceEngine(mechanism).element == "euler"
    assert ExudynEngine(mechanism).element == "ancf"
    result = moving_frequencies(ReferenceEngine(mechanism, 16), ANGLES, [0.0], modes=3)
    np.testing.assert_allclose(result.dataset["frequency"][0, 0], EXPECTED, rtol=1e-5)


def test_one_link_that_does_not_shear_among_others_that_do() -> None:
    soft = turcic(2e3)
    mixed = replace(soft, sections=soft.sections | {"crank": turcic(math.inf).sections["crank"]})
    reference, exudyn = (
        natural_frequencies(engine(mixed, 16, component_modes=False), ANGLES, modes=3)
        for engine in (ReferenceEngine, ExudynEngine)
    )
    assert np.abs(reference / EXPECTED - 1).max() > 0.01
    np.testing.assert_allclose(exudyn, reference, rtol=3e-3)


@pytest.mark.parametrize("line", ['shear_stiffness = "rigid"\n', ""])
def test_a_model_file_says_so_or_nothing(line: str, tmp_path: Path) -> None:
    text = (MODELS / "spin_up_beam.toml").read_text(encoding="utf-8")
    changed = text.replace('shear_stiffness = "1.0e7 N"\n', line)
    assert changed != text
    path = tmp_path / "rigid.toml"
    path.write_text(changed, encoding="utf-8")
    mechanism = load_mechanism(path)
    assert mechanism.sections["arm"].shear_stiffness == math.inf
    assert not mechanism.sections["arm"].shears
    shown = str(check_mechanism(ReferenceEngine(mechanism, 2)).summary())
    assert re.search(r"kGA \(N\) +rigid", shown)
    again = tmp_path / "again.toml"
    again.write_text(mechanism.to_toml(), encoding="utf-8")
    assert load_mechanism(again).sections == mechanism.sections
