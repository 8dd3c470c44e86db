"""Damping ratios of random crank-rockers with Kelvin-Voigt damping, rotation terms and all."""

from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from flexmech import (
    ComputationError,
    ExudynEngine,
    ReferenceEngine,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
)
from flexmech.analyses import solve_frequencies, solve_modes
from flexmech.linkages import AttachmentPoint, Spring
from flexmech.mechanism import Mechanism
from tests.support.random_mechanisms import RandomCase, random_case

DATA = Path(__file__).parents[1] / "data"
MODES = 3
ELEMENTS = 8
KINDS = {"reference": (ReferenceEngine, "euler"), "exudyn": (ExudynEngine, "ancf")}
SEEDS = [
    *range(2),
    *(pytest.param(seed, marks=pytest.mark.thorough) for seed in range(2, 100)),
]


def engine_of(case: RandomCase, name: str, elements: int = ELEMENTS):
    kind, element = KINDS[name]
    return kind(case.mechanism, elements, element)


@cache
def damped_map(seed: int, name: str) -> xr.Dataset:
    """At speed, at equilibrium, the modes in ascending order."""
    case = random_case(seed, damped=True)
    dataset = moving_frequencies(
        engine_of(case, name), case.crank_angles, [case.crank_speed], modes=MODES
    ).dataset
    return dataset.isel(engine=0, crank_speed=0)


def whole_ratios(case: RandomCase, name: str, elements: int) -> np.ndarray:
    """Of all coordinates."""
    system = (
        engine_of(case, name, elements)
        .unreduced()
        .linear_system(case.crank_angles, case.crank_speed)
    )
    return solve_modes(system, MODES).damping_ratio


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("name", KINDS)
def test_ratios_in_component_modes_are_those_of_all_coordinates(seed, name):
    """And the reduction error says how far they are."""
    dataset = damped_map(seed, name)
    exact = whole_ratios(random_case(seed, damped=True), name, ELEMENTS)
    true = np.abs(dataset["damping_ratio"].values - exact)
    assert np.all(true <= 1e-3 * np.abs(exact) + 2e-7)
    reported = dataset["damping_ratio_reduction_error"].values
    assert reported.max() == pytest.approx(true.max(), rel=0.3, abs=1e-9)


@pytest.mark.thorough
@pytest.mark.parametrize("elements", [8, 16, 32])
def test_ratios_of_many_mechanisms_are_those_of_all_coordinates(elements):
    for seed, name in product(range(20), KINDS):
        case = random_case(seed, damped=True)
        found = moving_frequencies(
            engine_of(case, name, elements), case.crank_angles, [case.crank_speed], modes=MODES
        ).dataset["damping_ratio"]
        exact = whole_ratios(case, name, elements)
        np.testing.assert_allclose(found[0, 0], exact, rtol=2e-3, atol=5e-7)


def fine_ratios(seed: int) -> np.ndarray:
    """Of all coordinates of 48 elements, from component modes by Newton's method (Ruhe 1973)."""
    case = random_case(seed, damped=True)
    engine = engine_of(case, "reference", 48)
    system = engine.linear_system(case.crank_angles, case.crank_speed, modes=MODES, detail=2.0)
    found = solve_modes(system, MODES)
    full = engine.unreduced().linear_system(case.crank_angles, case.crank_speed)
    shapes = system.unreduced_vectors(found.vectors, full.frames)
    values = found.eigenvalues.copy()
    for place in np.ndindex(values.shape):
        x, angle = shapes[place[0], :, place[1]], place[0]
        for _ in range(5):
            value = values[place]
            stiffness, damping, mass = full.stiffness[angle], full.damping[angle], full.mass[angle]
            dynamic = stiffness + value * (damping + value * mass)
            change = np.linalg.solve(dynamic, (damping + 2 * value * mass) @ x)
            largest = np.argmax(np.abs(change))
            step = x[largest] / change[largest]
            values[place], x = value - step, change / np.linalg.norm(change)
            if abs(step) < 1e-11 * abs(value):
                break
        assert abs(step.real) < 1e-8 * abs(value)  # round-off blurs the frequency alone
    return -values.real / np.abs(values)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_mesh_error_of_the_ratios_is_true(seed):
    """Within a factor of two of the distance to a fine mesh."""
    dataset = damped_map(seed, "reference")
    true = np.abs(dataset["damping_ratio"].values - fine_ratios(seed))
    estimate = dataset["damping_ratio_discretisation_error"].values
    true, estimate = true.max(axis=0), estimate.max(axis=0)
    assert np.all((estimate > true / 2) & (estimate < 2 * true + 1e-7))


def with_damping_time(mechanism: Mechanism, time: float) -> Mechanism:
    """One for all links."""
    sections = {name: s.with_damping_time(time) for name, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


@pytest.mark.parametrize(
    "seeds", [range(8), pytest.param(range(8, 200), marks=pytest.mark.thorough)], ids=str
)
def test_modes_are_refused_that_creep_and_no_others(seeds):
    """Of one damping time for all links: those above ``2 / tau``, as at rest."""
    ran = refused = 0
    for seed in seeds:
        case = random_case(seed, damped=True, angles=2)
        still = ReferenceEngine(with_damping_time(case.mechanism, 0.0), ELEMENTS, "euler")
        natural = 2 * np.pi * natural_frequencies(still, case.crank_angles, modes=7)
        swinging = 1 + seed % 5
        gap = natural[:, swinging].min() / natural[:, swinging - 1].max()
        if gap < 1.1:
            continue
        time = 2 / (natural[:, swinging - 1].max() * np.sqrt(gap))
        mechanism = with_damping_time(case.mechanism, time)
        for reduced in (True, False):
            engine = ReferenceEngine(mechanism, ELEMENTS, "euler", component_modes=reduced)
            speed = case.crank_speed / 10  # slow: at rest the answer is known
            system = engine.linear_system(
                case.crank_angles, speed, modes=7, detail=1.0 if reduced else None
            )
            modes = solve_modes(system, swinging, spare=2)
            assert np.all(modes.damping_ratio[:, :swinging] < 1)
            found = solve_frequencies(system, swinging)
            np.testing.assert_allclose(modes.frequency[:, :swinging], found, rtol=1e-6)
            np.testing.assert_allclose(2 * np.pi * found, natural[:, :swinging], rtol=0.02)
            for solve in (solve_modes, solve_frequencies):
                with pytest.raises(ComputationError, match="of the lowest modes oscillate"):
                    solve(system, swinging + 1)
            refused += 1
        ran += 1
    assert ran > len(seeds) / 3
    assert refused


def test_one_mode_asked_for_needs_no_others():
    """Nine oscillate, below ``1 / (pi tau)`` = 790 Hz; real eigenvalues begin at 395 Hz."""
    engine = ReferenceEngine(load_mechanism(DATA / "soft_damped_crank.toml"), 16)
    angles = np.radians([20.667, 21.0])
    dataset = moving_frequencies(engine, angles, [1.113], modes=1).dataset
    assert dataset["frequency"][0, 0, 0, 0] == pytest.approx(2.33873, rel=1e-4)
    assert dataset["damping_ratio"][0, 0, 0, 0] == pytest.approx(0.00288, abs=5e-6)
    system = engine.linear_system(angles, 1.113, modes=9, detail=1.0)
    assert solve_modes(system, 9).damping_ratio[0, 5] == pytest.approx(0.42, abs=0.005)
    with pytest.raises(ComputationError, match="fewer than 10 of the lowest modes oscillate"):
        solve_modes(system, 10)


def test_the_summary_gives_errors_as_shares_of_the_ratio():
    """Of both kinds, and the ratio in percent with the digits that they leave known."""
    case = random_case(0, damped=True)
    result = moving_frequencies(
        engine_of(case, "reference"), case.crank_angles, [case.crank_speed], modes=1
    )
    lines = str(result.summary()).splitlines()
    line = next(x for x in lines if "Kelvin-Voigt" in x and "reduction" in x)
    data = result.dataset.isel(engine=0, crank_speed=0, mode=0)
    share = data["damping_ratio_discretisation_error"].values / data["damping_ratio"].values
    assert f"at most {100 * share.max():.2g} % of it, reduction" in line
    known = 100 * float(data["damping_ratio_discretisation_error"].max())
    last_place = 10.0 ** -len(line.split(": ")[1].split()[0].partition(".")[2])
    assert known / 10 < last_place < 10 * known


def test_ratios_of_dampers_alone_have_errors_and_negative_ones_are_explained():
    case = random_case(5024)
    ground = AttachmentPoint("ground", 0.1, -0.3)
    damper = Spring("s", AttachmentPoint("coupler", 0.05), ground, 1.0, 0.3, damping=1e-4)
    mechanism = replace(case.mechanism, springs=(damper,))
    result = moving_frequencies(
        ReferenceEngine(mechanism, 8, "euler"), case.crank_angles, [case.crank_speed], modes=1
    )
    assert result.dataset["damping_ratio_reduction_error"].max() < 1e-6
    assert result.dataset["damping_ratio"].min() < 0
    said = str(result.summary())
    assert "damping ratio (dampers) of mode 1" in said
    assert "that is no instability" in said
