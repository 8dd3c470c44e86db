"""The scenario on instability thresholds of the composite crank-rockers of Elamy et al. 2023."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from flexmech import ReferenceEngine, natural_frequencies, stability
from flexmech.studies import composite_crank_rocker

Scenario = Callable[[str], Any]


def made_up(module: Any, case: int, lowest: float, *opens: float) -> Any:
    """A map whose bands open there, closed by 0.15, 0.3, 0.45 % and so on."""
    bands = pd.DataFrame(
        {
            "lower": opens,
            "upper": [speed + 0.01 for speed in opens],
            "error": 0.001,
            "growth": 0.01,
            "closing": [0.0015 * (n + 1) for n in range(len(opens))],
            "open": False,
        }
    )
    steady = np.full((len(module.FROZEN_SPEEDS), len(module.TURN)), -0.001)
    frequency = np.full((len(module.TURN), 2), [1.0, 2.0])
    return module.CaseMap(case, lowest, 0.0, 1.0, frequency, bands, steady, 0.5)


def four(module: Any) -> dict[int, Any]:
    """As the paper would have it: in the order of how far transmission angles are off."""
    opens = {1: 0.4, 2: 0.3, 3: 0.6, 4: 0.5}
    return {
        case: made_up(module, case, 100.0 * first, first, first + 0.03, first + 0.03, first + 0.06)
        for case, first in opens.items()
    }


def test_stackings_scale_frequencies_at_rest(scenario: Scenario) -> None:
    """Across the width to round-off; through the thickness stretching scales otherwise."""
    module = scenario("_composite_thresholds")
    over = module.scales().over()
    angles = np.radians([0.0, 130.0])
    first = rest("C1", "across width", angles)
    for layers, within in (("across width", 1e-8), ("through thickness", 1e-3)):
        ratio = rest("C4", layers, angles) / first
        assert ratio == pytest.approx(over.loc["C4", layers], rel=within)
    # Links of one material bend alike whichever way their plies lie.
    for laminate in ("C1", "C6"):
        across, through = over.loc[laminate]
        assert across == pytest.approx(through, rel=1e-9)


def rest(laminate: str, layers: Any, angles: Any) -> Any:
    mechanism = composite_crank_rocker(2, laminate, layers=layers)
    engine = ReferenceEngine(mechanism, 4, "euler")
    return natural_frequencies(engine, angles, modes=2)


def test_a_threshold_belongs_to_a_damping_ratio(scenario: Scenario) -> None:
    module = scenario("_composite_thresholds")
    found = made_up(module, 1, 100.0, 0.3, 0.4, 0.5, 0.6)
    assert found.thresholds == [0.3, 0.4, 0.6]
    assert np.isnan(found.threshold(0.02))
    assert found.frozen_threshold == np.inf
    assert np.isnan(found.frozen_angle)
    frozen = found.frozen.copy()
    frozen[10:, 3] = 0.003
    grows = replace(found, frozen=frozen)
    speeds = module.FROZEN_SPEEDS
    # A quarter of the way from -0.001 to 0.003.
    assert grows.frozen_threshold == pytest.approx(0.75 * speeds[9] + 0.25 * speeds[10])
    assert grows.frozen_angle == module.TURN[3]


@pytest.mark.parametrize(
    ("case", "opens", "lowest", "changed"),
    [
        (1, 0.4, 40.0, {}),
        # In rad/s case 1 opens below case 2, over their lowest frequencies it does not.
        (1, 0.4, 10.0, {"case 2 is lowest (of frequencies), of thresholds"}),
        (4, 0.5, 99.0, {"case 3 is highest (of frequencies), of thresholds"}),
        # By less than the errors of both edges above that of case 1.
        (4, 0.4015, 50.0, {"the farther transmission angles"}),
    ],
)
def test_claims_are_computed(
    scenario: Scenario, case: int, opens: float, lowest: float, changed: set[str]
) -> None:
    module = scenario("_composite_thresholds")
    maps = four(module)
    maps[case] = made_up(module, case, lowest, opens, opens + 0.03, opens + 0.03, opens + 0.06)
    claims = module.claims_of(list(maps.values()), module.scales())
    missed = {one.statement for one in claims if one.verdict == "not reproduced"}
    # 46 %, of frequencies as of thresholds.
    missed.remove("C6 is below C1 (of frequencies), of thresholds by")
    assert len(missed) == len(changed)
    assert all(any(text.startswith(start) for start in changed) for text in missed)
    assert [one.verdict for one in claims].count("not judged") == 2
    assert all(one.fails_if for one in claims)


def test_a_stacking_that_rises_is_found(scenario: Scenario) -> None:
    module = scenario("_composite_thresholds")
    scale = module.scales()
    assert scale.falls
    values = scale.values.copy()
    values.loc["C4", "through thickness"] = 1.01 * values.loc["C3", "through thickness"]
    raised = module.Scales(values)
    claims = module.claims_of(list(four(module).values()), raised)
    (said,) = (one for one in claims if one.statement.startswith("from C1 to C6"))
    assert said.verdict == "not reproduced"


def test_what_frozen_positions_are_worth(scenario: Scenario) -> None:
    said = scenario("composite_thresholds").verdict_on_frozen
    assert said(0.6, 0.2) == "raise a false alarm 3.0 times too early"
    assert said(0.6, np.inf) == "miss the first band"


@pytest.mark.thorough
def test_first_band_of_case_3(
    scenario: Scenario,
    expected_number: Callable[[str], Any],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Its threshold, its scale, and that damping closes it where it says."""
    module = scenario("composite_thresholds")
    speeds = np.linspace(0.63, 0.67, 6)
    answer = module.main(tmp_path, cases=(3,), checked_case=3, speeds=speeds)
    (found,) = answer.maps
    assert found.threshold(0.001) == expected_number("composite_thresholds")
    across, through = answer.checks
    assert across.edges < 1e-6
    assert max(across.width, across.closing) < 1e-5
    # Stretching does not scale as bending does.
    assert 1e-5 < through.edges < through.mesh
    assert answer.claims == []
    band = found.first(0.001)
    engine = ReferenceEngine(composite_crank_rocker(3, "C1"), 4, "euler")
    inside = found.lowest * np.linspace(band["lower"], band["upper"], 7)
    for part, grows in ((0.95, True), (1.05, False)):
        near = stability(engine, inside, modes=3, damping_ratio=part * band["closing"])
        assert (near.growth()["unstable"] == "yes").any() == grows
    assert "it scales" in capsys.readouterr().out
    names = ["bands.png", "frozen.png", "thresholds.png"]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
