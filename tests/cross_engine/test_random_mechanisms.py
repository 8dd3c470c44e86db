"""What holds of the shipped mechanisms holds of random crank-rockers too."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.linalg
import xarray as xr

from flexmech import ExudynEngine, ReferenceEngine, moving_frequencies, natural_frequencies
from flexmech.analyses import solve_frequencies
from flexmech.analyses.frequencies.discretisation import mesh_error
from flexmech.analyses.frequencies.formulation import Formulation, Systems
from flexmech.linear_system import Engine
from tests.support.random_mechanisms import random_case

ELEMENTS = 16
COARSE, FINE = 8, 64
SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.thorough) for seed in range(1, 100))]


@cache
def frequency_map(seed: int) -> xr.Dataset:
    """At speed, at equilibrium, with all rotation terms, by both engines; without the speed."""
    case = random_case(seed)
    engines = [
        ReferenceEngine(case.mechanism, ELEMENTS, "euler"),
        ExudynEngine(case.mechanism, ELEMENTS, "ancf"),
    ]
    found = moving_frequencies(engines, case.crank_angles, [case.crank_speed])
    return found.dataset.isel(crank_speed=0)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_engines_agree(seed):
    """Better than 1e-4: their meshes are the same, their interpolation nearly."""
    frequency = frequency_map(seed)["frequency"]
    np.testing.assert_allclose(frequency[1], frequency[0], rtol=1e-4)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_reduction_error_is_small_and_true(seed):
    case = random_case(seed)
    dataset = frequency_map(seed).isel(engine=0)
    whole = ReferenceEngine(case.mechanism, ELEMENTS, "euler").unreduced()
    exact = natural_frequencies(whole, case.crank_angles, case.crank_speed)
    true = np.abs(np.sort(dataset["frequency"].values, axis=-1) / exact - 1).max()
    assert true < 2e-5
    # Round-off blurs the reported error and the true one.
    blurred = 2 * round_off(whole)
    assert dataset["reduction_error"].max() == pytest.approx(true, rel=0.3, abs=blurred)


def round_off(engine: ReferenceEngine) -> float:
    """How far round-off blurs a lowest frequency that is soft against the highest one.

    Rounding may change squares of frequencies by the machine's precision times the highest one; of
    0.3 Hz beside 400 kHz it changes the frequency by about a thousandth of that bound (measured).
    """
    system = engine.linear_system(0.0, 0.0, prestress="none")
    squares = scipy.linalg.eigvalsh(system.stiffness[0], system.mass[0])
    return float(1e-3 * np.finfo(float).eps * squares[-1] / squares[0])


def estimates_and_truth(seed: int) -> np.ndarray:
    """Reported discretisation error of each frequency, its distance to a fine mesh, its round-off.

    Few elements and all coordinates: the mesh makes the whole error.
    """
    case = random_case(seed)
    coarse = ReferenceEngine(case.mechanism, COARSE, "euler", component_modes=False)
    dataset = moving_frequencies(coarse, case.crank_angles, [case.crank_speed]).dataset
    dataset = dataset.isel(engine=0, crank_speed=0)
    exact = natural_frequencies(
        coarse.with_(elements=FINE, component_modes=True), case.crank_angles, case.crank_speed
    )
    order = np.argsort(dataset["frequency"].values, axis=-1)
    found, estimate = (
        np.take_along_axis(dataset[name].values, order, axis=-1).ravel()
        for name in ("frequency", "discretisation_error")
    )
    blurred = round_off(coarse.with_(elements=FINE))
    return np.stack([estimate, np.abs(found / exact.ravel() - 1), np.full(found.shape, blurred)])


@pytest.mark.parametrize(
    "seeds", [range(2), pytest.param(range(2, 100), marks=pytest.mark.thorough)], ids=str
)
def test_the_discretisation_error_is_true(seeds):
    """Within a factor of two, but for errors so small that the fine mesh blurs them."""
    pairs = [estimates_and_truth(seed) for seed in seeds]
    estimate, true, blurred = np.concatenate(pairs, axis=1)
    matters = true > 2e-5 + blurred
    assert np.mean(matters) > 0.2
    assert np.all((estimate > true / 2)[matters] & (estimate < 2 * true)[matters])
    assert np.mean((estimate > true / 2) & (estimate < 2 * true)) > 0.9


def stretching_estimates_and_truth(make, element: str, seed: int) -> np.ndarray:
    """Of thick links at rest: mesh errors of modes that owe a fifth of their stiffness to EA."""
    case = random_case(seed, angles=2, thickness=4.0)
    formulation = Formulation("none", rotation_terms=False, modes=8)

    def frequencies(engine: Engine) -> np.ndarray:
        detailed = Systems(engine, formulation, detail=8.0)
        return solve_frequencies(detailed.at(case.crank_angles, 0.0), formulation.modes)

    engine = make(case.mechanism, COARSE, element)
    found, fine = frequencies(engine), frequencies(engine.with_(elements=12 * COARSE))
    sections = case.mechanism.sections.items()
    stiffer = {n: replace(s, axial_stiffness=1.02 * s.axial_stiffness) for n, s in sections}
    stiff = engine.with_(mechanism=replace(case.mechanism, sections=stiffer), element=element)
    stretches = (frequencies(stiff) / found) ** 2 - 1 > 0.2 * 0.02
    estimate = mesh_error(Systems(engine, formulation), case.crank_angles, 0.0).frequency
    return np.stack([estimate, np.abs(found / fine - 1)])[:, stretches]


@pytest.mark.parametrize(
    "seeds", [range(2), pytest.param(range(2, 60), marks=pytest.mark.thorough)], ids=str
)
@pytest.mark.parametrize(
    ("make", "element"),
    [
        (ReferenceEngine, "euler"),
        pytest.param(ReferenceEngine, "timoshenko", marks=pytest.mark.thorough),
        (ExudynEngine, "ancf"),
        pytest.param(ExudynEngine, "geometrically-exact", marks=pytest.mark.thorough),
    ],
)
def test_discretisation_errors_of_modes_that_stretch_links_are_true(make, element, seeds):
    """Within a factor of two, but for one in fifty: errors of exact beams change their sign."""
    pairs = [stretching_estimates_and_truth(make, element, seed) for seed in seeds]
    estimate, true = np.concatenate(pairs, axis=1)
    matters = true > 2e-5
    assert np.count_nonzero(matters) > 2 * len(seeds)
    assert np.mean((estimate > true / 2)[matters] & (estimate < 2 * true)[matters]) > 0.98
    assert np.all(estimate[matters] > true[matters] / 4)
