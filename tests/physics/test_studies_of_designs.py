"""Studies of designs against closed forms: Sobol's indices, percentiles, optima and fronts.

Ishigami and Homma 1990, *Uncertainty Modelling and Analysis*, 398-403: the function whose shares
of the variance are known, Y = sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1, each x uniform from -pi to pi.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
import scipy

from flexmech import example_model, load_mechanism, natural_frequencies
from flexmech.studies import (
    Correlation,
    Goal,
    Limit,
    Optimum,
    Output,
    Study,
    Uncertainty,
    Variable,
    optimum_study,
    sweep_study,
    uncertainty_study,
)
from flexmech.units import DENSITY, LENGTH, STRESS
from tests.support.study_data import MASS, Scripted, density, study, thickness

LINKS = "crank", "coupler", "rocker"
STILL = {"speed": 0.0, "prestress": "none", "angles": 4}


def ishigami(designs: np.ndarray) -> np.ndarray:
    first, second, third = (-np.pi + 2 * np.pi * (designs - 1e-3) / 2e-3).T
    return (np.sin(first) + 7 * np.sin(second) ** 2 + 0.1 * third**4 * np.sin(first))[:, None]


VARIANCE = 7**2 / 8 + 0.1 * np.pi**4 / 5 + 0.1**2 * np.pi**8 / 18 + 1 / 2
FIRST_ORDER = np.array([(1 + 0.1 * np.pi**4 / 5) ** 2 / 2, 7**2 / 8, 0.0]) / VARIANCE
MIXED = 0.1**2 * np.pi**8 * (1 / 18 - 1 / 50) / VARIANCE
KURTOSIS = 3.5
TOTAL = FIRST_ORDER + np.array([MIXED, 0.0, MIXED])


@pytest.fixture(scope="module")
def shares() -> Uncertainty:
    three = study(*(thickness(1e-3, 3e-3, link=link) for link in LINKS))
    return uncertainty_study(three, 2048, executor=Scripted(ishigami))


@pytest.mark.parametrize(("index", "exact"), [("first_order", FIRST_ORDER), ("total", TOTAL)])
def test_shares_of_ishigamis_function_lie_within_their_intervals(shares, index, exact):
    found = shares.dataset.sel(output="mass")
    assert (found[f"{index}_low"].values <= exact + 1e-12).all()
    assert (found[f"{index}_high"].values >= exact - 1e-12).all()
    assert (found[f"{index}_high"] - found[f"{index}_low"]).max() < 0.25
    np.testing.assert_allclose(found[index], exact, atol=0.02)


def test_intervals_of_shares_are_drawn_by_the_seed():
    """Shares from few samples are intervals, with a warning."""
    three = study(*(thickness(1e-3, 3e-3, link=link) for link in LINKS))
    one, again, other = (
        uncertainty_study(replace(three, seed=seed), 16, executor=Scripted(ishigami))
        for seed in (1, 1, 2)
    )
    assert one.dataset["total_low"].identical(again.dataset["total_low"])
    assert not one.dataset["total_low"].equals(other.dataset["total_low"])
    [warning] = one.summary().warnings
    assert "take --samples" in warning
    assert re.search(r"\d+ to \d+ % of the variance", one.summary().answer[0])


def test_shares_of_many_samples_have_no_warning(shares):
    assert not shares.summary().warnings


def test_mean_and_deviation_are_those_of_ishigamis_function(shares):
    """Within the standard errors of a plain random sample of a function with kurtosis 3.5."""
    found, count = shares.dataset.sel(output="mass"), shares.dataset.sizes["design"]
    assert count == 2 * 2048
    assert float(found["mean"]) == pytest.approx(7 / 2, abs=np.sqrt(VARIANCE / count))
    error = np.sqrt((KURTOSIS - 1) / (4 * count))
    assert float(found["std"]) == pytest.approx(np.sqrt(VARIANCE), rel=error)


# --- the mass is linear in the density: it is normal where that is ------------------------------

VOLUME = 1.6e-3 * 25.4e-3 * (0.2794 + 0.2667)
MEAN = 2698.0 * 4.24e-3 * 25.4e-3 * 0.102 + 2923.0 * VOLUME
DEVIATION = 100.0 * VOLUME


def line(designs: np.ndarray) -> np.ndarray:
    return MEAN + DEVIATION * (designs - 2923.0) / 100.0


@pytest.fixture(scope="module")
def normal() -> Uncertainty:
    limits = (Limit("mass", greatest=MEAN + DEVIATION),)
    whole = study(density(2923.0, 100.0), limits=limits)
    return uncertainty_study(whole, 2048, executor=Scripted(line))


def test_the_mass_of_the_four_bar_is_that_of_its_rectangles():
    values = (2700.0, 3100.0)
    heavy = Variable("d", ("materials.aluminium.density",), DENSITY, "values", values)
    grid = sweep_study(study(listed("coupler", 1e-3, 3e-3, 2), heavy)).dataset
    designs = np.stack([grid["coupler"].values, grid["d"].values], axis=1)
    np.testing.assert_allclose(grid["mass"].values[:, None], masses(designs), rtol=1e-9)
    usual = masses(np.array([[1.6e-3, value] for value in values]))
    np.testing.assert_allclose(usual.ravel(), line(np.array(values)), rtol=1e-9)


def test_percentiles_of_a_normal_mass_are_the_closed_form(normal):
    found, exact = normal.dataset.sel(output="mass"), scipy.stats.norm(MEAN, DEVIATION)
    for name, part in {"p2_5": 0.025, "p50": 0.5, "p97_5": 0.975}.items():
        assert float(found[name]) == pytest.approx(exact.ppf(part), abs=0.01 * DEVIATION)
    assert float(found["mean"]) == pytest.approx(MEAN, abs=0.001 * DEVIATION)
    assert float(found["std"]) == pytest.approx(DEVIATION, rel=0.003)
    assert abs(float(found["p50"]) - MEAN) < float(found["median_error"])


def test_a_limit_one_deviation_above_the_mean_fails_in_15_87_percent(normal):
    found, beyond = normal.dataset.sel(output="mass"), scipy.stats.norm.sf(1.0)
    assert float(found["failure_probability"]) == pytest.approx(beyond, abs=0.001)
    assert float(normal.dataset["within"].mean()) == pytest.approx(1 - beyond, abs=0.001)
    for share in ("first_order", "total"):
        assert found[share].item() == pytest.approx(1.0, abs=1e-3)


def test_the_variance_of_two_correlated_variables_has_a_third_part_and_no_shares():
    """Their sum has the variance 2 s^2 (1 + r)."""
    pair = tuple(
        Variable(f"d{n}", (f"materials.{name}.density",), DENSITY, "normal", (2800.0, 100.0))
        for n, name in enumerate(("aluminium", "crank_aluminium"), start=1)
    )
    correlated = study(*pair, correlations=(Correlation(("d1", "d2"), 0.6),))
    total = Scripted(lambda designs: designs.sum(axis=1, keepdims=True))
    result = uncertainty_study(correlated, 2048, executor=total)
    found, exact = result.dataset.sel(output="mass"), 100.0 * np.sqrt(2 * 1.6)
    assert float(found["std"]) == pytest.approx(exact, rel=0.01)
    assert float(found["p97_5"]) == pytest.approx(5600 + 1.959964 * exact, rel=1e-3)
    assert set(result.tables()) == {"uncertainty", "designs"}


def test_what_an_output_does_not_depend_on_has_no_share_and_one_value_takes_no_runs():
    key = "materials.crank_aluminium.youngs_modulus"
    stiff = Variable("stiff", (key,), STRESS, "normal", (68.9e9, 1e9))
    fixed = thickness(2e-3, distribution="values", link="rocker")
    result = uncertainty_study(study(thickness(1e-3, 3e-3), stiff, fixed), 16).dataset
    assert result["input"].values.tolist() == ["links.coupler.in_plane_thickness", "stiff"]
    found = result.sel(output="mass", input="stiff")
    for name in ("first_order", "total"):
        assert [float(found[f"{name}{end}"]) for end in ("", "_low", "_high")] == [0.0] * 3


def test_failed_designs_count_as_what_the_study_says_they_are_worth():
    """A quarter fails; that the first thickness alone decides it is nearly all of the variance."""

    def failing(designs):
        whole = designs.sum(axis=1, keepdims=True)
        return np.where(designs[:, :1] > 2.5e-3, np.nan, whole)

    two = thickness(1e-3, 3e-3), thickness(1e-3, 3e-3, link="rocker")
    worth = study(*two, failure_values={"mass": 5.0})
    result = uncertainty_study(worth, 64, executor=Scripted(failing)).dataset
    found = result.sel(output="mass")
    assert float(found["failure_probability"]) == pytest.approx(0.25, abs=0.02)
    numbers = result["mass"].where(result["status"] == "ok", 5.0)
    assert float(found["mean"]) == pytest.approx(float(numbers.mean()), rel=1e-12)
    assert float(found["p97_5"]) == 5.0
    assert found["total"].values == pytest.approx([1.0, 0.0], abs=0.02)


@pytest.mark.thorough
def test_bands_of_frequencies_are_percentiles_of_single_runs():
    output = Output("lowest_frequency", speed=20.0, prestress="axial", angles=4)
    whole = study(thickness(1.4e-3, 3e-3), outputs={"f1": output})
    result = uncertainty_study(whole, 16).dataset
    bands, angles = result["frequency_percentile"], np.radians([0, 90, 180, 270, 360])
    np.testing.assert_allclose(bands["crank_angle"], angles)
    designs = result["links.coupler.in_plane_thickness"].values
    assert bands.attrs["designs"] == len(designs)
    single = [
        natural_frequencies(
            whole.parameters.mechanism_with({"links.coupler.in_plane_thickness": thick}),
            *(angles, 20.0),
            modes=3,
            prestress="axial",
        )
        for thick in designs.tolist()
    ]
    exact = np.percentile(single, [2.5, 50, 97.5], axis=0, method="hazen")
    np.testing.assert_allclose(
        bands.transpose("percentile", "crank_angle", "mode"), exact, rtol=1e-9
    )


# --- optima: frequency and mass of a slender bar at rest are proportional to its thickness ------

BAR = load_mechanism(example_model("rotating_arm"))
THICK = Variable("t", ("links.arm.in_plane_thickness",), LENGTH, "range", (1e-3, 9e-3))
OUTPUTS = MASS | {"f1": Output("lowest_frequency", **STILL)}
# Lambda of a clamped bar, Blevins 1979, Formulas for Natural Frequency, Table 8-1.
HERTZ_A_METRE = 1.8751040687**2 / (2 * np.pi * 0.4**2) * np.sqrt(70e9 / (12 * 2700.0))


def test_the_lightest_bar_above_20_hz_has_the_thickness_of_blevins():
    bar = Study(BAR, (THICK,), OUTPUTS, limits=(Limit("f1", least=20.0),), goals=(Goal("mass"),))
    found = optimum_study(bar).dataset
    assert found["t"].item() == pytest.approx(20.0 / HERTZ_A_METRE, rel=1e-4)
    assert found["mass"].item() == pytest.approx(2700 * 0.4 * 30e-3 * found["t"].item(), rel=1e-9)
    assert found["f1"].item() == pytest.approx(20.0, rel=1e-6)
    assert bool(found["within"].item())
    history = found["history"].values[0]
    assert (np.diff(history) <= 0).all()
    assert history[-1] == found["mass"].item()
    kept = found["trial_goal"].values[0, found["trial_within"].values]
    assert kept.min() == history[-1]
    assert found.sizes["trial"] == found["evaluations"].values[-1]
    thickness = found["trial_value"].sel(variable="t").values
    assert thickness[found["trial_within"].values].min() == found["t"].item()


def listed(link: str, start: float, end: float, count: int) -> Variable:
    values = tuple(np.linspace(start, end, count).tolist())
    return Variable(link, (f"links.{link}.in_plane_thickness",), LENGTH, "values", values)


@pytest.mark.thorough
def test_the_front_of_two_goals_is_that_of_an_exhaustive_grid():
    pytest.importorskip("pymoo")
    whole = study(
        *(listed("coupler", 1e-3, 3e-3, 7), listed("rocker", 1e-3, 4e-3, 7)),
        outputs=OUTPUTS,
        limits=(Limit("mass", greatest=0.13),),
        goals=(Goal("mass"), Goal("f1", "max")),
    )
    grid = sweep_study(whole).dataset
    mass, f1, inside = (grid[name].values for name in ("mass", "f1", "within"))
    better = (mass <= mass[:, None]) & (f1 >= f1[:, None])
    better &= (mass < mass[:, None]) | (f1 > f1[:, None])
    front = inside & ~(better & inside).any(axis=1)
    assert 5 < front.sum() < inside.sum() < len(mass) == 49
    columns = ("coupler", "rocker", "mass", "f1")
    exact = np.stack([grid[name].values[front] for name in columns])
    found = optimum_study(whole).dataset
    got = np.stack([found[name].values for name in columns])
    np.testing.assert_array_equal(got[:, np.lexsort(got)], exact[:, np.lexsort(exact)])
    assert found["history"].values[:, -1].tolist() == [mass[front].min(), f1[front].max()]


# --- optima by percentiles over what is uncertain -----------------------------------------------

NORMAL_90 = 1.2815515655446004
"""Standard deviations above the mean of a normal distribution that one in ten exceeds."""
SCATTERED = density(2923.0, 150.0)


def masses(designs: np.ndarray) -> np.ndarray:
    """Masses of crank, coupler and rocker by the coupler's thickness and the density of both."""
    thick, heavy = designs.T
    section = 0.2794 * thick + 0.2667 * 1.6e-3
    return (2698.0 * 4.24e-3 * 25.4e-3 * 0.102 + heavy * 25.4e-3 * section)[:, None]


def thickest(percentile: float | None, samples: int, *, mechanism: bool) -> Optimum:
    """The thickest coupler whose mass is 0.1 kg by a percentile or its mean."""
    return optimum_study(
        study(
            *(thickness(1e-3, 3e-3), SCATTERED),
            limits=(Limit("mass", greatest=0.1, percentile=percentile),),
            goals=(Goal("mass", "max", percentile),),
            percentile_samples=samples,
        ),
        executor=None if mechanism else Scripted(masses),
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    "mechanism", [False, pytest.param(True, marks=pytest.mark.thorough)], ids=["product", "links"]
)
@pytest.mark.parametrize(("percentile", "apart"), [(90.0, NORMAL_90), (None, 0.0)])
def test_the_optimum_by_a_percentile_of_the_mass_is_the_closed_form(percentile, apart, mechanism):
    """Without a percentile it is that of the mean."""
    result = thickest(percentile, 256, mechanism=mechanism)
    found = result.dataset
    thick = found["links.coupler.in_plane_thickness"].item()
    low, mean, exact = masses(
        np.array([[thick, 2923.0 + d * 150.0] for d in (-1.0, 0.0, apart)])
    ).ravel()
    assert found["mass"].item() == pytest.approx(0.1, rel=1e-4)
    assert abs(exact - 0.1) < 0.02 * (mean - low)
    assert found["density"].item() == pytest.approx(2923.0)
    assert found.attrs["runs"] > 128 * int(found["evaluations"][-1])


# --- variables and samples ----------------------------------------------------------------------

PROBABILITY = np.linspace(0.01, 0.99, 25)


@pytest.mark.parametrize(
    ("kind", "numbers", "exact"),
    [
        ("uniform", (2.0, 5.0), scipy.stats.uniform(2.0, 3.0)),
        ("range", (2.0, 5.0), scipy.stats.uniform(2.0, 3.0)),
        ("normal", (2.0, 0.3), scipy.stats.norm(2.0, 0.3)),
        # Mean and deviation of the quantity itself.
        (
            "lognormal",
            (2.0, 1.0),
            scipy.stats.lognorm(np.sqrt(np.log(1.25)), scale=2.0 / np.sqrt(1.25)),
        ),
    ],
)
def test_values_of_a_distribution_are_those_of_scipy(kind, numbers, exact):
    variable = Variable("v", ("v",), LENGTH, kind, numbers)
    np.testing.assert_allclose(variable.at(PROBABILITY), exact.ppf(PROBABILITY), rtol=1e-9)
    if kind == "lognormal":
        assert (exact.mean(), exact.std()) == pytest.approx(numbers)


def test_a_sample_fills_the_ranges_evenly_and_depends_on_seed_and_number_alone():
    two = study(thickness(1e-3, 3e-3), density(2923.0, 30.0))
    sample = two.sample(64)
    counts = np.bincount(np.floor(16 * (sample[:, 0] - 1e-3) / 2e-3).astype(int))
    assert counts.tolist() == [4] * 16
    assert np.mean(sample[:, 1]) == pytest.approx(2923.0, abs=2.0)
    assert np.std(sample[:, 1]) == pytest.approx(30.0, rel=0.05)
    np.testing.assert_array_equal(two.sample(7), sample[:7])
    assert (sample != replace(two, seed=2).sample(64)).all()
