"""Bands of crank speed in which the aluminium four-bar shakes itself up, by both engines."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from flexmech import ReferenceEngine, StabilityMap, load_mechanism, stability
from tests.support.mechanisms import case

PACKER = Path(__file__).parents[1] / "data" / "packer.toml"
SPEEDS = [74.0, 76.0, 78.0]


@pytest.fixture(scope="module")
def maps() -> list[xr.Dataset]:
    """By both engines; twice the second frequency is eight times the crank's near 76.5 rad/s."""
    return [
        stability(engine, SPEEDS, prestress="axial", modes=4, damping_ratio=0.001).dataset
        for engine in case("aluminium four-bar").engines(5)
    ]


@pytest.mark.thorough
def test_a_band_that_is_narrower_than_the_step_is_found_named_and_closed(
    maps: list[xr.Dataset],
) -> None:
    band = maps[0].isel(band=0)
    assert (str(band["band_kind"].item()), int(band["band_order"])) == ("principal", 8)
    assert not band["band_lower_open"]
    assert not band["band_upper_open"]
    assert 76.0 < float(band["band_lower"]) < 76.6 < float(band["band_upper"]) < 77.5
    assert 0.004 < float(band["band_closing_damping_ratio"]) < 0.01


@pytest.mark.thorough
def test_edges_by_both_engines_agree_within_their_errors(maps: list[xr.Dataset]) -> None:
    first, second = (found.isel(band=0) for found in maps)
    for edge in ("band_lower", "band_upper"):
        gap = abs(float(first[edge]) - float(second[edge]))
        errors = sum(
            float(one[f"{edge}_{kind}_error"])
            for one in (first, second)
            for kind in ("step", "reduction", "mesh")
        )
        assert gap < 0.2
        assert gap < 3 * errors


@pytest.mark.thorough
def test_modes_that_meet_in_a_band_have_opposite_krein_signatures(maps: list[xr.Dataset]) -> None:
    """Elsewhere the signature of a definite system is the sign of the Floquet exponent's angle."""
    for found in maps:
        assert found["is_definite"].all()
        band = found.isel(band=0)
        assert float(band["band_first_signature"]) > 0.01
        assert float(band["band_second_signature"]) < -0.01
        assert float(found["liouville_defect"].max()) < 1e-6


def test_modes_of_a_branch_are_conjugate_or_both_real_inside_a_band_too() -> None:
    """At 137 rad/s one mode of the steel four-bar has two real multipliers."""
    steel = ReferenceEngine(case("steel four-bar").mechanism, 2)
    found = stability(steel, [137.0], prestress="axial", modes=3, damping_ratio=0.0005).dataset
    [turn] = np.exp(1j * found["angle"].values[0])
    assert np.abs(turn.imag).min() < 1e-6
    np.testing.assert_allclose(turn[::2] * turn[1::2], 1.0, atol=1e-6)


@pytest.mark.thorough
def test_growth_ends_at_the_closing_damping_ratio(maps: list[xr.Dataset]) -> None:
    band = maps[0].isel(band=0)
    closing, fastest = (
        float(band[name]) for name in ("band_closing_damping_ratio", "band_fastest_speed")
    )
    engine = case("aluminium four-bar").engines(5)[0]
    speeds = np.linspace(float(band["band_lower"]), float(band["band_upper"]), 3)
    assert speeds[0] < fastest < speeds[-1]
    grows = [
        float(
            stability(engine, speeds, prestress="axial", modes=4, damping_ratio=share * closing)
            .dataset["growth_rate"]
            .max()
        )
        for share in (0.9, 1.02)
    ]
    assert grows[0] > 0 > grows[1]


@pytest.mark.thorough
def test_multipliers_are_the_same_in_both_frames() -> None:
    engine = ReferenceEngine(case("aluminium four-bar").mechanism, 4)
    link, ground = (
        stability(
            engine, [60.0], prestress="equilibrium", frame=frame, modes=6, damping_ratio=0.001
        ).dataset
        for frame in ("link", "inertial")
    )
    for name in ("multiplier_modulus", "growth_rate"):
        np.testing.assert_allclose(link[name], ground[name], rtol=1e-6)
    np.testing.assert_allclose(
        np.sort(link["log_modulus"]), np.sort(ground["log_modulus"]), atol=1e-8
    )


@pytest.mark.thorough
def test_about_the_periodic_motion_growth_is_nearly_that_about_the_equilibrium() -> None:
    """At 20 rad/s the motion is a tenth of its greatest displacement away from it."""
    engine = ReferenceEngine(case("aluminium four-bar").mechanism, 3)
    still, running = (
        stability(engine, [20.0], prestress=level, modes=3, damping_ratio=0.005).dataset
        for level in ("equilibrium", "trajectory")
    )
    assert 0.01 < float(running["orbit_distance"].item()) < 0.5
    assert float(running["orbit_residual"].item()) < 1e-6
    first, second = float(still["growth_rate"].item()), float(running["growth_rate"].item())
    assert 0 < abs(second - first) < 0.2 * abs(first)


def test_damped_links_are_judged_about_their_motion_and_undamped_ones_about_the_equilibrium() -> (
    None
):
    engine = ReferenceEngine(case("aluminium four-bar").mechanism, 2)
    running = stability(engine, [20.0], modes=2, damping_ratio=0.02)
    still = stability(engine, [20.0], modes=2)
    assert running.dataset.attrs["prestress"] == "trajectory"
    assert still.dataset.attrs["prestress"] == "equilibrium"
    # By the linear equations of both, damped and not.
    asked = stability(engine, [20.0], modes=2, damping_ratio=0.02, prestress="equilibrium").dataset
    distance = float(running.dataset["orbit_distance"].item())
    assert asked.attrs["motion_distance"] == pytest.approx(distance, rel=0.1)
    assert 0.05 < still.dataset.attrs["motion_distance"] < 0.2
    assert "quasi-static equilibrium" in " ".join(still.summary().answer)
    # Near a critical speed the motion is farther away than its peak.
    still.dataset.attrs["motion_distance"] = 1.1
    assert " 110 % of its peak" in " ".join(still.summary().answer)


@pytest.mark.thorough
def test_a_vibration_grows_about_the_motion_of_a_damped_steel_linkage() -> None:
    """Exudyn's run gains 1.139 1/s, and its edge is at 63.896 rad/s; the equilibrium loses 1.1."""
    steel = case("steel four-bar").mechanism
    sections = {k: s.with_damping_time(5e-6) for k, s in steel.sections.items()}
    engine = ReferenceEngine(replace(steel, sections=sections))
    growth = {
        level: float(stability(engine, [64.0], prestress=level).dataset["growth_rate"].item())
        for level in (None, "equilibrium")
    }
    assert growth[None] == pytest.approx(1.16, abs=0.03)
    assert growth["equilibrium"] < -1.0


@pytest.mark.thorough
def test_modes_that_die_out_within_a_step_leave_the_map_of_the_others() -> None:
    """Kelvin-Voigt damping of 0.5 % at 50 Hz overdamps modes above 10 kHz."""
    engine = ReferenceEngine(load_mechanism(PACKER), 8)
    found = stability(engine, [188.0], prestress="equilibrium").dataset
    assert float(found["growth_rate"].item()) == pytest.approx(-13.635, abs=1e-3)
    assert np.isnan(found["check_reduction"]).all()
    assert np.isfinite(found["check_mesh"]).all()


@pytest.mark.thorough
def test_a_speed_without_equilibrium_is_told_and_the_map_goes_on() -> None:
    aluminium = replace(case("aluminium four-bar").mechanism, operating_speeds=(148.0,))
    result = stability(
        ReferenceEngine(aluminium, 2),
        [60.0, 150.0],
        prestress="equilibrium",
        modes=1,
        damping_ratio=0.3,
    )
    found = result.dataset
    assert np.isfinite(float(found["growth_rate"][0, 0]))
    assert "crank angle" in str(found["reason"][0, 1].item())
    assert "148 rad/s is unknown" in result.summary().answer[0]


def test_a_band_between_two_others_is_found_where_each_speed_asked_for_lies_in_one() -> None:
    """Twice the second frequency is nine times the crank's near 68.5 rad/s, between 65.6 and 70.2.

    A map in steps of a tenth finds the three bands one by one.
    """
    engine = ReferenceEngine(case("aluminium four-bar").mechanism, 2)
    ratios = [0.0, 0.01]
    found = stability(
        engine, [65.563, 70.19], prestress="axial", modes=2, against=("damping-ratio", ratios)
    )
    assert found.dataset["unstable"].values.tolist() == [["yes", "yes"]]
    bands = found.bands().round(2)
    edges = bands[["from_rad_s", "to_rad_s"]].values.tolist()
    assert edges == [[65.56, 65.57], [68.35, 68.76], [70.12, 70.19]]
    assert bands["order"].tolist() == [9, 9, 8]
    # The map over damping grows in the same bands as the curve, and no other growth is faster.
    data = found.dataset
    inside = data["against_speed"].values
    rate = data["against_band_growth_rate"].values[0]
    grows = data["against_band_unstable"].values[0] == "yes"
    within = [any(low < w < high for low, high in found.bands()[["from_rad_s", "to_rad_s"]].values)
              for w in inside]  # fmt: skip
    np.testing.assert_array_equal(grows[0], within)
    assert rate[0].max() == pytest.approx(bands["largest_growth_rate_1_s"].max(), rel=0.02)
    assert not grows[1].any()  # 0.269 % closes all of them
    # What steps may not see is part of the answer.
    closing, steps = found.summary().answer[1:3]
    assert "0.269 %" in closing
    assert "rad/s apart" in steps


def test_speeds_without_equilibrium_are_not_said_to_be_stable() -> None:
    """A map as it is where the linkage has no equilibrium from some speed on."""
    aluminium = replace(case("aluminium four-bar").mechanism, operating_speeds=(24.0,))
    engine = ReferenceEngine(aluminium, 1)
    data = stability(engine, [20.0, 21.0, 25.0], prestress="axial", modes=1).dataset
    assert "24 rad/s lies outside" in StabilityMap(data).summary().answer[0]
    data = data.isel(curve=data["curve_speed"].values < 23)
    states = np.array([["no", "no", "no equilibrium"]])
    data = data.assign(unstable=(data["unstable"].dims, states))
    operating, stable, *_ = StabilityMap(data).summary().answer
    assert operating.startswith("Stability at 24 rad/s is unknown")
    last = data["curve_speed"].values.max()
    assert f"from 20 to {last:.6g} rad/s" in stable


def test_a_map_beyond_the_buckling_of_straight_links_ends_with_bands_in_its_range() -> None:
    """There the modes that are kept change from speed to speed, and growth is level at an edge."""
    engine = ReferenceEngine(case("aluminium four-bar").mechanism, 1)
    found = stability(engine, [145.0, 150.0], prestress="axial", modes=1)
    assert found.dataset["unstable"].values.tolist() == [["no equilibrium"] * 2]
    edges = found.bands()[["from_rad_s", "to_rad_s"]].values
    assert len(edges) == 2
    assert ((edges >= 145) & (edges <= 150)).all()
    assert np.isfinite(found.bands()["error_rad_s"]).all()


@pytest.mark.thorough
def test_bands_and_their_names_do_not_depend_on_the_step() -> None:
    """Modes that damping holds together beside a band are mixtures, at more of finer steps."""
    engine, found = ReferenceEngine(case("steel four-bar").mechanism, 4), []
    for step in (0.5, 2.0):
        speeds = np.arange(160.0, 180.1, step)
        about = {"prestress": "equilibrium", "damping_ratio": 0.001}
        found.append(stability(engine, speeds, modes=4, **about).dataset)
    names = [list(zip(d["band_kind"].values, d["band_order"].values, strict=True)) for d in found]
    assert names[0] == names[1]
    assert len(names[0]) == 6
    for edge in ("band_lower", "band_upper"):
        np.testing.assert_allclose(found[0][edge], found[1][edge], atol=1e-5)
