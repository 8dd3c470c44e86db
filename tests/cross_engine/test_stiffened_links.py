"""Links that are stiffer as a whole are so in both engines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import flexmech
from flexmech.sections import stiffened_section


def test_a_stiffer_laminate_moves_frequencies_of_both_engines_alike():
    mechanism = flexmech.load_mechanism(flexmech.example_model("composite_fourbar"))
    coupler = stiffened_section(mechanism.sections["coupler"], 1.1)
    stiffer = replace(mechanism, sections={**mechanism.sections, "coupler": coupler})
    angle, moved = np.radians([0.0, 80.0, 200.0]), []
    for engine in (
        flexmech.ReferenceEngine(mechanism, 8, "timoshenko"),
        flexmech.ExudynEngine(mechanism, 8, "geometrically-exact"),
    ):
        before = flexmech.natural_frequencies(engine, angle, modes=3)
        after = flexmech.natural_frequencies(engine.with_(mechanism=stiffer), angle, modes=3)
        moved.append(after / before - 1)
    assert moved[0].max() > 0.03
    # Of the change, which the elements' own errors hardly touch.
    assert moved[1] == pytest.approx(moved[0], abs=0.02 * moved[0].max())
