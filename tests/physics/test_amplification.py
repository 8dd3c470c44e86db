"""By how much Campbell diagrams say that a running linkage is amplified, by own calculations."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import flexmech
from flexmech.analyses import deflections

PACKER = "tests/data/packer.toml"
RPM = math.pi / 30


@cache
def diagram(damped: bool = True) -> flexmech.CampbellDiagram:
    """The packer from 900 to 1250 rpm, where orders 6 to 8 meet its first frequency."""
    mechanism = flexmech.load_mechanism(PACKER)
    if not damped:
        sections = {k: s.with_damping_time(0.0) for k, s in mechanism.sections.items()}
        mechanism = replace(mechanism, sections=sections)
    engine = flexmech.ReferenceEngine(mechanism, 4)
    angles = np.radians(np.arange(0, 361, 15))
    asked = {"orders": [7, 8], "modes": 1, "speed_unit": "rpm"}
    return flexmech.campbell(engine, np.linspace(900, 1250, 8), crank_angles=angles, **asked)


def without_vibration(engine: flexmech.Engine, speed: float) -> float:
    """Greatest deflection of the links at rest in their frames, at large displacements."""
    motion = engine.mechanism.linkage.motion(np.radians(np.arange(0.0, 360.0)), speed)
    displacement = engine.stressed_links(motion, "equilibrium").displacement
    assert displacement is not None
    return float(np.abs(deflections(engine, displacement)).max())


@pytest.mark.parametrize("kind", [flexmech.ReferenceEngine, flexmech.ExudynEngine])
def test_a_linkage_is_amplified_as_its_periodic_motion_at_large_displacements_says(kind):
    """By both engines at the resonance of order 7, half of which is vibration."""
    found = diagram().critical_speeds().set_index("order").loc[7]
    assert found["from_rad_s"] < found["amplified_most_at_rad_s"] < found["to_rad_s"]
    engine, speed = kind(flexmech.load_mechanism(PACKER), 4), found["amplified_most_at_rad_s"]
    run = flexmech.response(engine, speed, revolutions=1.0, modes=2)
    amplified = float(run.peaks()["deflection"].max()) / without_vibration(engine, speed)
    assert amplified > 1.4
    assert found["amplification"] == pytest.approx(amplified, rel=0.02)


def test_an_arm_under_gravity_is_amplified_as_a_mass_on_a_spring():
    """Its frequency is the arm's; other modes carry 2 % of the deflection."""
    section = flexmech.BeamSection.rectangle(flexmech.Material(70e9, 2700.0), 3e-3, 30e-3)
    section = section.with_damping_ratio(0.02, 3.0)
    arm = flexmech.Mechanism(
        flexmech.RotatingArm(1.0), {"arm": section}, gravity=(0.0, -9.81), operating_speeds=(12.0,)
    )
    engine = flexmech.ReferenceEngine(arm, 8, "euler")
    found = flexmech.campbell(engine, [6.0, 12.0, 14.0], modes=1).dataset
    first = 2 * np.pi * flexmech.natural_frequencies(engine, [0.0], 12.0, modes=1).item()
    ratio = 12.0 / first
    spring = 1 / math.hypot(1 - ratio**2, 2 * 0.02 * ratio)
    assert spring > 1.5
    assert found["operating_amplification"].item() == pytest.approx(spring, rel=0.03)


def test_a_resonance_is_where_an_order_meets_the_frequency_of_the_running_linkage():
    """Floquet's, of which the mean frequency over the turn is 0.4 % off."""
    found = diagram().critical_speeds().set_index("order").loc[7]
    speed = found["amplified_most_at_rad_s"]
    engine = flexmech.ReferenceEngine(flexmech.load_mechanism(PACKER), 4)
    asked = {"modes": 1, "prestress": "equilibrium"}
    running = flexmech.stability(engine, [speed], **asked).dataset["frequency"].values.flat[0]
    assert 7 * speed / (2 * np.pi) == pytest.approx(running, rel=2e-3)


def test_ranges_to_avoid_are_ranked_by_their_amplification():
    found = diagram().critical_speeds().set_index("order")["amplification"]
    assert found[7] > 1.1 * found[8] > 1.2
    [said] = [line for line in diagram().summary().answer if line.startswith("Avoid")]
    first, second = (said.index(f"amplified {found[order]:.2f} times") for order in (7, 8))
    assert first < second
    numbers = [one for one in diagram().summary().numbers if one.name == "amplification"]
    assert {one.of: one.value for one in numbers}["order 7, branch 1"] == found[7]


def test_nothing_bounds_an_undamped_linkage_at_a_resonance():
    result = diagram(damped=False)
    assert np.isinf(result.critical_speeds()["amplification"]).all()
    assert result.dataset.sizes["operating_speed"] == 0
    [said] = [line for line in result.summary().answer if line.startswith("Avoid")]
    assert "without damping the deflection is unbounded" in said
    assert "times" not in said
