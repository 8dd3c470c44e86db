"""V12: the flexible slider-crank whose shaft is free (Manzl et al., arXiv 2409.18272).

Its frequencies and decay rates are cases of the verification, by both engines.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmech import ReferenceEngine, load_mechanism
from flexmech.analyses import solve_modes
from flexmech.verification import verification_case
from flexmech.verification.methods.frequencies import free_shaft_decay_rates


def test_the_stated_decay_rates_are_those_of_the_whole_turn() -> None:
    """The case has the crank angles of the extremes alone."""
    case = verification_case("Slider-crank with a free shaft, damped: 0, 47 and 91 deg, reference")
    angles = np.arange(0.0, 181.0).tolist()
    found = free_shaft_decay_rates(engine="reference", elements=16, crank_angles=angles)
    assert found.ravel() == pytest.approx(case.measured_by.values(), rel=1e-9)
    assert found.ravel() == pytest.approx(case.expected_values(), rel=1e-4)


def test_the_shaft_turns_freely(models: Path) -> None:
    damped = load_mechanism(models / "slider_crank_free_shaft.toml")
    sections = {name: each.with_damping_time(0.0) for name, each in damped.sections.items()}
    mechanism = replace(damped, sections=sections)
    engine = ReferenceEngine(mechanism, 16, "euler", shaft="free")
    modes = solve_modes(engine.linear_system(np.radians([0.0, 60.0])), 3)
    assert np.all(np.abs(modes.rigid) < 1e-3)
    assert np.all(modes.frequency > 1.0)
