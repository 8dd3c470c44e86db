"""Choices without effect: component modes, positions and designs computed side by side."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexmech import (
    ExudynEngine,
    JointSpring,
    Mechanism,
    ReferenceEngine,
    RotationTerms,
    Spring,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
)
from flexmech.linkages import GROUND, AttachmentPoint
from flexmech.modelfile import mechanism_with
from flexmech.studies import Output, sweep
from tests.support.random_mechanisms import random_case
from tests.support.strategies import fourbar

ANGLES = np.linspace(0.0, 2 * np.pi, 7)


def both(engine: Any, angles: Any, speed: float, **options: Any) -> Any:
    """Frequencies and damping ratios with component modes and with all coordinates, (2, 2, ...)."""
    found = [
        moving_frequencies(one, angles, [speed], **options).dataset
        for one in (engine, engine.unreduced())
    ]
    return [
        [data[name].values.squeeze() for data in found] for name in ("frequency", "damping_ratio")
    ]


@pytest.mark.parametrize(
    ("prestress", "speed"), [("none", 0.0), ("axial", 20.0), ("equilibrium", 20.0)]
)
def test_six_frequencies_are_those_of_all_coordinates(prestress: Any, speed: float) -> None:
    engine = ReferenceEngine(fourbar(joint_masses={"A": 0.02, "B": 0.05}), 8)
    options = {"modes": 6, "prestress": prestress}
    found, exact = (
        natural_frequencies(one, ANGLES, speed, **options) for one in (engine, engine.unreduced())
    )
    assert found == pytest.approx(exact, rel=2e-5)
    if not speed:
        # Rayleigh: what is reduced is stiffer.
        assert (found >= exact * (1 - 1e-10)).all()


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("speed", "time", "element"),
    [(60.0, 0.0, "euler"), (33.0, 1e-3, "euler"), (60.0, 0.0, "timoshenko")],
)
def test_deeply_bowed_and_strongly_damped_links_stay_as_they_are(
    aluminium: Mechanism, speed: float, time: float, element: str
) -> None:
    """Where no number of straight links' modes helps."""
    sections = {n: s.with_damping_time(time) for n, s in aluminium.sections.items()}
    engine = ReferenceEngine(replace(aluminium, sections=sections), 6, element)
    frequency, ratio = both(engine, np.radians([0.0, 330.0]), speed, modes=3)
    assert frequency[0] == pytest.approx(frequency[1], rel=2.1e-5)
    assert ratio[0] == pytest.approx(ratio[1], rel=1.1e-3, abs=1e-7)


@pytest.mark.parametrize(
    ("seed", "kind"),
    [
        (0, ReferenceEngine),
        pytest.param(3, ExudynEngine, marks=pytest.mark.thorough),
        *(pytest.param(seed, ReferenceEngine, marks=pytest.mark.thorough) for seed in range(4, 12)),
    ],
)
def test_random_damped_mechanisms_at_high_speed_stay_as_they_are(seed: int, kind: Any) -> None:
    case = random_case(seed, damped=True)
    frequency, ratio = both(
        kind(case.mechanism, 8), case.crank_angles, 2.5 * case.crank_speed, modes=3
    )
    assert frequency[0] == pytest.approx(frequency[1], rel=2.1e-5)
    assert ratio[0] == pytest.approx(ratio[1], rel=1.1e-3)


@pytest.mark.thorough
@pytest.mark.parametrize("kind", [ReferenceEngine, ExudynEngine])
def test_dampers_of_springs_and_joints_stay_as_they_are(kind: Any) -> None:
    """Their forces bend links in ways that few modes have."""
    case = random_case(5303, angles=3)
    ground = AttachmentPoint(GROUND, 0.1, -0.3)
    on_coupler = AttachmentPoint("coupler", 0.4 * case.mechanism.linkage.lengths["coupler"])
    mechanism = replace(
        case.mechanism,
        springs=(Spring("damper", on_coupler, ground, 1000.0, 0.3, damping=3.0),),
        joint_springs=(JointSpring("B", torsional_stiffness=1.0, torsional_damping=0.01),),
    )
    frequency, ratio = both(
        kind(mechanism, 8), case.crank_angles, case.crank_speed, modes=2, prestress="none"
    )
    assert frequency[0] == pytest.approx(frequency[1], rel=2e-5)
    assert ratio[0] == pytest.approx(ratio[1], rel=1.1e-3)


def test_damping_of_plies_and_the_stretch_of_thick_links_stay_as_they_are(
    models: Any, tmp_path: Any
) -> None:
    """Plies whose bending, stretching and shear lose differently; links 5 mm thick a ply."""
    text = (models / "composite_fourbar.toml").read_text(encoding="utf-8")
    thick = tmp_path / "thick.toml"
    thick.write_text(text.replace('thickness = "1 mm"', 'thickness = "5 mm"'), encoding="utf-8")
    engine = ReferenceEngine(load_mechanism(thick), 3, "zigzag")
    frequency, ratio = both(engine, ANGLES[1:2], 0.0, modes=4)
    assert frequency[0] == pytest.approx(frequency[1], rel=2e-5)
    assert ratio[0] == pytest.approx(ratio[1], rel=2e-3)


@pytest.mark.parametrize("speed", [0.0, 10.0, 50.0])
def test_a_fast_arm_and_one_whose_fourth_mode_stretches_stay_as_they_are(
    unit_arm: Any, speed: float
) -> None:
    """At slenderness 70: pi / 2 * 70 against 120.9 in bending; at 50, tension shapes the modes."""
    engine = ReferenceEngine(unit_arm(70), 24)
    found, exact = (
        natural_frequencies(one, 0.0, speed, modes=5, prestress="axial")
        for one in (engine, engine.unreduced())
    )
    assert found == pytest.approx(exact, rel=2e-5)
    if not speed:
        assert 2 * np.pi * found[3] == pytest.approx(np.pi / 2 * 70, rel=1e-3)


@pytest.mark.thorough
@pytest.mark.parametrize("kind", [ReferenceEngine, ExudynEngine])
def test_positions_together_have_the_frequencies_of_each_alone(
    aluminium: Mechanism, kind: Any
) -> None:
    """In any order, beside a position at rest, and where one of them needs more steps."""
    engine = kind(aluminium, 4, component_modes=False)
    angles = np.random.default_rng(2).uniform(0, 2 * np.pi, 70)
    together = natural_frequencies(engine, angles, 60.0, modes=3)
    alone = [natural_frequencies(engine, angle, 60.0, modes=3) for angle in angles[::14]]
    assert together[::14] == pytest.approx(np.array(alone), rel=1e-8)
    speeds = [0.0, 60.0]
    mapped = moving_frequencies(engine, angles[:3], speeds, modes=3).dataset["frequency"]
    assert mapped.values[0, 1] == pytest.approx(together[:3], rel=1e-5)


def test_designs_swept_together_have_the_frequencies_of_each_alone(aluminium: Mechanism) -> None:
    """One that cannot turn among them keeps its place and its reason."""
    outputs = {"second": Output("highest_frequency", speed=20.0, mode=2, angles=12)}
    key, angles = "links.coupler.in_plane_thickness", np.radians(np.arange(0, 360, 30))
    variables = {key: [2e-3, 3e-3], "linkage.crank": [0.1, 0.25]}
    together = sweep(aluminium, variables, outputs).dataset
    assert (together["status"].values == "ok").tolist() == [True, False, True, False]
    assert "crank angle" in str(together["reason"].values[1])
    changed = mechanism_with(mechanism_with(aluminium, key, 3e-3), "linkage.crank", 0.1)
    engine, modes = ReferenceEngine(changed), {"modes": 2}
    alone = moving_frequencies(engine, angles, [20.0], **modes).dataset["highest_frequency"]
    assert together["second"].values[2] == pytest.approx(float(alone[0, 0, 1]), rel=2e-5)


@pytest.mark.parametrize("modes", [3, 4])
def test_links_of_two_elements_whose_modes_miss_nothing_stay_as_they_are(modes: int) -> None:
    """The few coordinates miss round-off alone, and each matrix has its own eigenvalue."""
    engine = ReferenceEngine(load_mechanism("models/steel_fourbar.toml"), elements=2)
    angles = np.radians(np.arange(0.0, 360.0, 30.0))
    for speed in range(112, 133, 2):
        found, whole = (
            natural_frequencies(one, angles, speed, modes=modes)
            for one in (engine, engine.unreduced())
        )
        np.testing.assert_allclose(found, whole, rtol=2e-5)


@pytest.mark.parametrize("terms", ["all", "coriolis,tangential"])
def test_the_effect_of_speed_is_split_into_terms_that_add_up(
    aluminium: Mechanism, terms: str
) -> None:
    counted = RotationTerms.parse(terms)
    engine, options = ReferenceEngine(aluminium, 2), {"modes": 2, "rotation_terms": counted}
    data = moving_frequencies(
        engine, [0.0, 1.0], [0.0, 20.0], speed_effect=True, **options
    ).dataset.isel(engine=0)
    names = ["geometric", "configuration", "coriolis", "centripetal", "tangential"]
    some = [name for name in names if name != "centripetal" or terms == "all"]
    assert data["term"].values.tolist() == some
    change = data["frequency"].diff("crank_speed").isel(crank_speed=0)
    whole = data["speed_effect"].sel(crank_speed=20.0).sum("term")
    np.testing.assert_allclose(whole, change, atol=1e-6)
    alone = natural_frequencies(engine, 1.0, 20.0, **options)
    found = data["frequency"].sel(crank_speed=20.0, crank_angle=1.0).values
    np.testing.assert_allclose(found, alone, rtol=1e-6)
