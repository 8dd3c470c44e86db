"""Runs in time of linkages in which a rigid link that moves guides another."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmech import (
    ConstantSpeed,
    ExudynEngine,
    ReferenceEngine,
    ResponseRequest,
    load_mechanism,
    response,
)
from flexmech.dynamical_systems import VibrationState
from flexmech.linkages.connection_forces import guide_place
from flexmech.linkages.motion import direction, normal
from flexmech.time_domain import DrivenLinkage
from tests.cross_engine.test_exudyn_joints import strips
from tests.cross_engine.test_two_drawings import GUIDED

MODELS = Path(__file__).parents[2] / "models"


@pytest.mark.parametrize(
    ("shaft", "torque"),
    [
        pytest.param("prescribed", "driving_torque", marks=pytest.mark.thorough),
        ("free", "shaft_rotation"),
    ],
)
def test_a_run_is_that_of_exudyn(shaft: str, torque: str, tmp_path: Path) -> None:
    """Lines that turn linearly left deflections 2e-2 off, joint forces on a free shaft 0.2."""
    mechanism = replace(GUIDED.mechanism(tmp_path, welded=False), shaft_inertia=2e-3)
    request = ResponseRequest(ConstantSpeed(6.0), revolutions=0.03)
    found, expected = (
        response(make(mechanism, 3, component_modes=False, shaft=shaft), request).dataset
        for make in (ReferenceEngine, ExudynEngine)
    )
    expected = expected.interp(time=found["time"])
    for name, near in (("deflection", 5e-4), ("joint_force", 5e-4), (torque, 3e-3)):
        gap = np.abs(found[name].values - expected[name].values).max()
        assert gap < near * np.abs(expected[name].values).max(), name


def test_two_drawings_have_one_response_at_low_speed(tmp_path: Path) -> None:
    """In component modes they were 1e-2 of the deflection apart at 3 rad/s."""
    request = ResponseRequest(ConstantSpeed(3.0), revolutions=0.01)
    body, weld = (
        response(ReferenceEngine(GUIDED.mechanism(tmp_path, welded=w), 3), request).dataset
        for w in (False, True)
    )
    expected = body["deflection"]
    found = weld["deflection"].sel(link=expected["link"])
    atol = 1e-7 * float(abs(expected).max())
    np.testing.assert_allclose(found, expected, rtol=0, atol=atol)


def test_joint_forces_balance_the_links_displaced_as_they_are() -> None:
    """At the places of the rigid motion the ram's force was 7e-3 of its peak off."""
    mechanism = load_mechanism(MODELS / "carton_pusher.toml")
    request = ResponseRequest(ConstantSpeed(5.0), revolutions=0.01)
    found, expected = (
        response(make(mechanism, 4, component_modes=False), request).dataset["joint_force"]
        for make in (ReferenceEngine, ExudynEngine)
    )
    expected = expected.interp(time=found["time"])
    gap, peak = abs(found - expected).max("time"), abs(expected).max(["time", "component"])
    assert bool(np.all(gap.values < 1.5e-3 * peak.values[..., None]))


def test_strains_are_distances_from_the_displaced_lines() -> None:
    """To the third order; the linear part is a matrix, whose rate it has too."""
    engine = ReferenceEngine(strips("rigid guide"), 3, "euler", component_modes=False)
    linkage, speed = DrivenLinkage(engine, ConstantSpeed(20.0), stretches=True), 20.0
    assert linkage.stretch is not None
    guides, topology = linkage.stretch.guides, engine.topology
    [slider] = topology.sliders
    link, guide = topology.index(slider.link_end.link), topology.index(slider.guide)
    time = np.array([0.031])
    z = 1e-3 * np.random.default_rng(1).normal(size=linkage.size)
    equations = linkage.equations(time)
    parts = linkage.link_motion(equations, VibrationState(*(x[None] for x in (z, 0 * z, 0 * z))))
    motion = equations.motion
    angle, line = motion.angle[0, guide], motion.angle[0, guide] + slider.direction
    end = linkage.links[link].end_displacement(slider.link_end.end)
    moved = parts[link][0][0, end]
    a = moved[0] * direction(motion.angle[0, link]) + moved[1] * normal(motion.angle[0, link])
    own = linkage.links[guide].readings.basis @ parts[guide][0][0]
    ends = [own[n] * direction(angle) + own[n + 1] * normal(angle) for n in (0, 3)]
    turn = (ends[1] - ends[0]) / topology.links[guide].length
    d = np.array([turn @ direction(angle), turn @ normal(angle)])
    along, across = (float(x[0]) for x in guide_place(topology, motion, slider))
    there = along * direction(angle) + across * normal(angle) + a - ends[0]
    turned = (1 + d[0]) * normal(line) - d[1] * direction(line)
    rigid = along * direction(angle) + across * normal(angle)
    expected = turned @ there - normal(line) @ rigid

    rows, rate = guides.rows(motion, linkage.frames.dependent_rows(motion))
    w = rows[0] @ z[: linkage.frames.end_count]
    stretch = guides.stretch
    strain = stretch.gradient @ w + stretch.weights @ (stretch.slopes @ w) ** 2 / 2
    root = stretch.gradient.max()
    assert abs(expected) > 1e-4
    np.testing.assert_allclose(strain / root, expected, rtol=1e-9)
    step = 1e-6
    before, after = (
        guides.rows(m, linkage.frames.dependent_rows(m))[0]
        for m in (linkage.motion(time - step), linkage.motion(time + step))
    )
    np.testing.assert_allclose(rate, (after - before) / (2 * step), atol=1e-6 * speed)
