"""V12: the flexible slider-crank whose shaft is free (Manzl et al., arXiv 2409.18272)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine, load_mechanism, natural_frequencies
from flexmech.analyses import solve_modes
from flexmech.linear_system import Engine

EXPECTED = {0.0: [3.76694, 12.8244, 27.571], 60.0: [2.94941, 11.7310, 26.285]}
ENGINES: list[tuple[type[Engine], str]] = [(ReferenceEngine, "euler"), (ExudynEngine, "ancf")]


@pytest.mark.parametrize(("engine", "element"), ENGINES)
def test_frequencies_above_the_free_motion(
    models: Path, engine: type[Engine], element: str
) -> None:
    damped = load_mechanism(models / "slider_crank_free_shaft.toml")
    sections = {name: each.with_damping_time(0.0) for name, each in damped.sections.items()}
    free = engine(replace(damped, sections=sections), 24, element, shaft="free")
    for angle, expected in EXPECTED.items():
        found = natural_frequencies(free, np.radians(angle), modes=3)
        assert found == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(("engine", "element"), ENGINES)
def test_decay_rates_of_the_first_two_bending_modes(
    models: Path, engine: type[Engine], element: str
) -> None:
    """Over the turn from 2.520 to 4.2015 and from 40.28 to 48.70 1/s."""
    damped = load_mechanism(models / "slider_crank_free_shaft.toml")
    free = engine(damped, 16, element, shaft="free").unreduced()
    angles = np.radians([0.0, 47.0, 91.0])
    decay = -solve_modes(free.linear_system(angles), 2).eigenvalues.real
    assert decay.min(axis=0) == pytest.approx([2.520, 40.28], rel=1e-4)
    assert decay.max(axis=0) == pytest.approx([4.2015, 48.70], rel=1e-4)
