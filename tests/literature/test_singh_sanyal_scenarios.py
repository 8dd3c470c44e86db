"""Scenarios on Singh & Sanyal 2022 besides the coupler curves: diffusion, and angles of the links.

Numbers of the angles are those of the verification; of the diffusion, the first terms of series.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from flexmech import CouplerPoint, HygrothermalState, coupler_paths
from flexmech.verification import verification_case

Scenario = Callable[[str], Any]


def test_swollen_angles(
    scenario: Scenario,
    expected_number: Callable[[str], Any],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    answer = scenario("swollen_angles").main(tmp_path, angles=72)
    case = verification_case("Angles of swollen links, Figures 3 and 4: wet against dry")
    text = answer.change.sel(state="R-914, +80 K, 7 % moisture")
    ends = text.sel(crank_angle=[0.0, np.pi], method="nearest").transpose("crank_angle", "link")
    assert ends.values.ravel() == pytest.approx(case.expected_values(), abs=case.tolerance)
    assert float(ends[1].sel(link="coupler")) == expected_number("swollen_angles")
    # Coupler and rocker are of one length: as one turns here, the other does on the way back.
    coupler, rocker = (text.sel(link=link).values for link in ("coupler", "rocker"))
    assert coupler == pytest.approx(-rocker[::-1], abs=1e-9)
    # The text's 80 K and the caption's 95 K differ by the swelling of the frame against the links.
    caption = answer.change.sel(state="R-914, +95 K, 7 % moisture")
    assert 1e-4 < float(abs(caption - text).max()) < 3e-3
    assert answer.by_equal_frame < 1e-9
    verdicts = {claim.claim: claim.verdict for claim in answer.claims}
    assert verdicts == {
        "theta3 and theta4 change in heat and moisture": "reproduced",
        "equations of theta3 and theta4, corrected": "reproduced",
        "equations of theta3 and theta4, as printed": "not reproduced",
    }
    assert "coupler: no root at 73 of 73 crank angles" in answer.claims[2].reason
    printed = capsys.readouterr().out
    assert "+0.77493 / -0.77493" in printed
    assert "+2.02411 / -2.02411" in printed
    files = ["angles.png", "changes.csv", "claims.csv"]
    assert sorted(file.name for file in tmp_path.iterdir()) == files
    rows = pd.read_csv(tmp_path / "changes.csv")
    assert len(rows) == 3 * 73
    assert rows["coupler_deg"][36] == pytest.approx(2.02411, abs=5e-6)


def test_verdicts_on_the_angles_are_computed(scenario: Scenario) -> None:
    """Of small changes, and of a linkage whose coupler and rocker are of two lengths."""
    module = scenario("swollen_angles")
    turn = np.linspace(0, 2 * np.pi, 25)
    mechanism = module.neat_resin("3")
    cool = module.in_state(mechanism, HygrothermalState(5.0, 0.001), turn)
    states = [each.assign_coords(state=name) for each, name in zip(cool, "ab", strict=True)]
    found = module.xr.concat(states, "state", data_vars="minimal")
    assert module._of_angles(module._change(found["angle"])).verdict == "not reproduced"
    longer = replace(mechanism, linkage=replace(mechanism.linkage, rocker=0.17))
    dry, wet = module.in_state(longer, HygrothermalState(80.0, 0.07), turn)
    states = [dry.assign_coords(state="a"), wet.assign_coords(state="b")]
    found = module.xr.concat(states, "state", data_vars="minimal")
    assert module._of_equations(found, printed=False).verdict == "reproduced"
    found["angle"][1, 3, 0] += 1e-6
    assert module._of_equations(found, printed=False).verdict == "not reproduced"


def test_figures_3_and_4_are_the_paths_of_the_command(scenario: Scenario) -> None:
    """In the caption's state, by the strain alone and as ``flexmech coupler-curve`` has them."""
    module = scenario("coupler_curves")
    turn, mechanism = np.linspace(0, 2 * np.pi, 37), module.neat_resin("3")
    state = HygrothermalState(95.0, 0.07)
    found = coupler_paths(mechanism, turn, CouplerPoint(0.0, 0.0), state)
    assert "above its wet glass transition" in found.dataset.attrs["warning"]
    wet = found.dataset["pin_position"].isel(state=1).transpose("pin", "crank_angle", "component")
    for figure, path in zip("34", wet.values, strict=True):
        drawn = module.curves_of(figure)["R-914"].position(turn)
        assert drawn == pytest.approx(path, abs=1e-12)
    # A runs on a circle about O2, B on an arc about O4, of lengths that are 2.7087 % greater.
    assert np.hypot(*wet.values[0].T) == pytest.approx(0.1027087, abs=1e-9)
    o4 = np.array([0.2 * (1 + 62.6e-6 * 95), 0.0])
    assert np.hypot(*(wet.values[1] - o4).T) == pytest.approx(0.16 * 1.027087, abs=1e-9)


def test_fickian_diffusion(
    scenario: Scenario,
    expected_number: Callable[[str], Any],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    module = scenario("fickian_diffusion")
    answer = module.main(tmp_path, rises=(0.0, 80.0))
    hot = answer.days[(answer.days["figure"] == "3") & (answer.days["temperature_rise_K"] == 80)]
    found = hot["days_to_90_percent"].item()
    assert found == expected_number("fickian_diffusion")
    # The first term of Crank's eq. 4.18 is what is left: 8 / pi^2 exp(-pi^2 Fo / 4) = 0.1.
    fourier = 4 / np.pi**2 * np.log(80 / np.pi**2)
    diffusivity = 6e-13 * np.exp(45e3 / 8.314462618 * (1 / 293.15 - 1 / 373.15))
    assert found == pytest.approx(fourier * 2.5e-3**2 / diffusivity / 86400, rel=1e-6)
    assert 1e-7 < answer.off_series < 1e-4
    assert answer.straight_to == pytest.approx(0.63, abs=0.015)
    verdicts = {claim.figure + claim.claim: claim.verdict for claim in answer.claims}
    assert list(verdicts.values()) == ["reproduced"] * 3
    assert "1Fickian diffusion" in verdicts
    printed = capsys.readouterr().out
    assert "150 mm (figures 5, 7, 8, 11), +80 K: 408 d / 4.81 years / 10.1 years" in printed
    files = ["claims.csv", "days.csv", "moisture.png"]
    assert sorted(file.name for file in tmp_path.iterdir()) == files


def test_verdicts_on_the_diffusion_are_computed(scenario: Scenario) -> None:
    module = scenario("fickian_diffusion")
    uptake = module.moisture_uptake(module.plate("3"), 1.0, 3 * module.DAY, 373.15, "coupler")
    assert module._of_figure(uptake, 0.63).verdict == "not reproduced"  # not saturated by then
    assert module._of_equations(2e-3).verdict == "not reproduced"
    days = pd.DataFrame(module._days((0.0, 80.0)))
    assert module._of_temperature(days).verdict == "reproduced"
    days.loc[1, "days_to_90_percent"] = 500.0
    assert module._of_temperature(days).verdict == "not reproduced"
    # Uptake that begins slower than the root of time, as Shen & Springer's formula does.
    slow = uptake.dataset.assign(uptake=uptake.dataset["shen_springer_uptake"])
    assert module._straight_to(type(uptake)(slow)) < 0.5


def test_the_series_solves_the_equations(scenario: Scenario) -> None:
    """Equation 2 by differences, and the values at the faces and at the start."""
    exact = scenario("fickian_diffusion").exact_profile
    place, step = np.linspace(-0.9, 0.9, 7), 1e-3
    rate = (exact(place, 0.3 + step) - exact(place, 0.3 - step)) / (2 * step)
    curved = exact(place + step, 0.3) - 2 * exact(place, 0.3) + exact(place - step, 0.3)
    assert rate == pytest.approx(curved / step**2, rel=1e-4)
    assert exact(np.array([-1.0, 1.0]), 0.1) == pytest.approx([1.0, 1.0], abs=1e-12)
    assert exact(np.array([0.0, 0.5]), 1e-3) == pytest.approx([0.0, 0.0], abs=1e-6)
