"""Studies of designs against closed forms: Sobol's indices, percentiles, optima, a front.

Ishigami and Homma 1990, *Uncertainty Modelling and Analysis*, 398-403: the function whose shares
of the variance are known, Y = sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1, each x uniform from -pi to pi.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy

from flexmech import load_mechanism
from flexmech.studies import (
    Correlation,
    Goal,
    Limit,
    Output,
    Study,
    Uncertainty,
    Variable,
    optimum_study,
    sweep_study,
    uncertainty_study,
)
from flexmech.studies.designs.evaluation import evaluate
from flexmech.units import DENSITY, LENGTH
from tests.support.study_data import MASS, MODELS, Scripted, density, study, thickness

LINKS = "crank", "coupler", "rocker"
STILL = {"speed": 0.0, "prestress": "none", "angles": 4}


def ishigami(designs: np.ndarray) -> np.ndarray:
    x = -np.pi + 2 * np.pi * (designs - 1e-3) / 2e-3
    first, second, third = x.T
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


class TestIshigami:
    @pytest.mark.parametrize(("index", "exact"), [("first_order", FIRST_ORDER), ("total", TOTAL)])
    def test_shares_lie_within_their_intervals(
        self, shares: Uncertainty, index: str, exact: np.ndarray
    ) -> None:
        own = shares.dataset.sel(output="mass")
        assert (own[f"{index}_low"].values <= exact + 1e-12).all()
        assert (own[f"{index}_high"].values >= exact - 1e-12).all()
        assert (own[f"{index}_high"] - own[f"{index}_low"]).max() < 0.25

    def test_moments_are_those_of_the_function(self, shares: Uncertainty) -> None:
        own = shares.dataset.sel(output="mass")
        count = shares.dataset.sizes["design"]
        assert count == 2 * 2048
        # Within the standard errors of a plain random sample of a function with kurtosis 3.5.
        assert float(own["mean"]) == pytest.approx(7 / 2, abs=np.sqrt(VARIANCE / count))
        error = np.sqrt((KURTOSIS - 1) / (4 * count))
        assert float(own["std"]) == pytest.approx(np.sqrt(VARIANCE), rel=error)

    def test_an_output_that_never_changes_has_no_shares(self) -> None:
        three = study(
            *(thickness(1e-3, 3e-3, link=link) for link in LINKS),
            outputs=MASS | {"constant": Output("peak_driving_torque")},
        )

        def both(designs: np.ndarray) -> np.ndarray:
            return np.hstack([ishigami(designs), np.full((len(designs), 1), 3.0)])

        own = uncertainty_study(three, 512, executor=Scripted(both)).dataset
        assert np.isnan(own["total"].sel(output="constant")).all()
        alone = uncertainty_study(study(*three.variables), 512, executor=Scripted(ishigami))
        np.testing.assert_allclose(
            own["total"].sel(output="mass"),
            alone.dataset["total"].sel(output="mass"),
            rtol=1e-12,
        )


def of_density(mean: float, deviation: float) -> tuple[float, float]:
    """Mean and standard deviation of the mass of the four-bar whose density is normal."""
    section = 1.6e-3 * 25.4e-3
    crank = 2698.0 * 4.24e-3 * 25.4e-3 * 0.102
    volume = section * (0.2794 + 0.2667)
    return crank + mean * volume, deviation * volume


class TestLinearCase:
    """The mass is linear in the density, so that it is normal where that is."""

    MEAN, DEVIATION = of_density(2923.0, 100.0)

    @pytest.fixture(scope="class")
    @classmethod
    def found(cls) -> Uncertainty:
        limits = (Limit("mass", greatest=cls.MEAN + cls.DEVIATION),)
        normal = study(density(2923.0, 100.0), limits=limits)
        return uncertainty_study(normal, 2048, executor=Scripted(cls.mass))

    @classmethod
    def mass(cls, designs: np.ndarray) -> np.ndarray:
        return cls.MEAN + cls.DEVIATION * (designs - 2923.0) / 100.0

    def test_the_mass_of_the_mechanism_is_that_line(self) -> None:
        rows = np.array([[2700.0], [2923.0], [3100.0]])
        np.testing.assert_allclose(
            evaluate(study(density(2923.0, 100.0)), rows).values, self.mass(rows), rtol=1e-9
        )

    def test_percentiles_are_the_closed_form(self, found: Uncertainty) -> None:
        own = found.dataset.sel(output="mass")
        normal = scipy.stats.norm(self.MEAN, self.DEVIATION)
        for name, part in {"p2_5": 0.025, "p50": 0.5, "p97_5": 0.975}.items():
            assert float(own[name]) == pytest.approx(normal.ppf(part), abs=0.01 * self.DEVIATION)
        assert float(own["mean"]) == pytest.approx(self.MEAN, abs=0.001 * self.DEVIATION)
        assert float(own["std"]) == pytest.approx(self.DEVIATION, rel=0.003)
        assert abs(float(own["p50"]) - self.MEAN) < float(own["median_error"])

    def test_how_often_the_limit_fails(self, found: Uncertainty) -> None:
        own = found.dataset.sel(output="mass")
        beyond = scipy.stats.norm.sf(1.0)
        assert found.dataset.sizes["design"] == 4096
        assert float(own["failure_probability"]) == pytest.approx(beyond, abs=0.001)
        assert float(found.dataset["within"].mean()) == pytest.approx(1 - beyond, abs=0.001)

    def test_the_only_input_has_all_of_the_variance(self, found: Uncertainty) -> None:
        own = found.dataset.sel(output="mass")
        assert float(own["total"].item()) == pytest.approx(1.0, abs=1e-3)
        assert float(own["first_order"].item()) == pytest.approx(1.0, abs=1e-3)

    def test_correlated_inputs_have_percentiles_and_no_shares(self) -> None:
        """Of a sum of two correlated normal variables the variance has a third part."""
        pair = tuple(
            Variable(f"d{n}", (f"materials.{name}.density",), DENSITY, "normal", (2800.0, 100.0))
            for n, name in enumerate(("aluminium", "crank_aluminium"), start=1)
        )
        correlated = study(*pair, correlations=(Correlation(("d1", "d2"), 0.6),))
        total = Scripted(lambda designs: designs.sum(axis=1, keepdims=True))
        found = uncertainty_study(correlated, 2048, executor=total)
        assert found.dataset.sizes["design"] == 2048
        own = found.dataset.sel(output="mass")
        exact = 100.0 * np.sqrt(1 + 1 + 2 * 0.6)
        assert float(own["std"]) == pytest.approx(exact, rel=0.01)
        assert float(own["p97_5"]) == pytest.approx(5600 + 1.959964 * exact, rel=1e-3)
        assert "total" not in found.dataset
        assert set(found.tables()) == {"uncertainty", "designs"}
        assert set(found.figures()) == {"uncertainty"}
        assert (
            "inputs are correlated: shares in the variance are not defined (Sobol's method)"
            in found.summary().details
        )


BAR = load_mechanism(MODELS / "rotating_arm.toml")
FLOOR = 20.0
"""In Hz, below which the arm's first frequency must not be."""


class TestOptimumWithAClosedForm:
    """Frequency and mass of a slender bar at rest are proportional to its thickness."""

    THICKNESS = Variable("t", ("links.arm.in_plane_thickness",), LENGTH, "range", (1e-3, 9e-3))
    OUTPUTS = MASS | {"f1": Output("lowest_frequency", **STILL)}  # type: ignore[arg-type]

    def frequency_of_one_metre(self) -> float:
        """First frequency over thickness of the bar as it is computed."""
        row = np.array([[3e-3]])
        whole = Study(BAR, (self.THICKNESS,), self.OUTPUTS)
        return float(evaluate(whole, row).values[0, 1] / 3e-3)

    def test_a_slender_bar_is_that_of_euler_and_bernoulli(self) -> None:
        # Lambda of a clamped bar, Blevins 1979, Formulas for Natural Frequency, Table 8-1.
        slender = 1.8751040687**2 / (2 * np.pi * 0.4**2) * np.sqrt(70e9 / (12 * 2700.0))
        assert self.frequency_of_one_metre() == pytest.approx(slender, rel=1e-4)

    def test_least_mass_above_a_frequency(self) -> None:
        one = Study(
            BAR,
            (self.THICKNESS,),
            self.OUTPUTS,
            limits=(Limit("f1", least=FLOOR),),
            goals=(Goal("mass"),),
        )
        found = optimum_study(one).dataset
        exact = FLOOR / self.frequency_of_one_metre()
        assert found["t"].item() == pytest.approx(exact, rel=1e-6)
        assert found["mass"].item() == pytest.approx(2700 * 0.4 * 30e-3 * exact, rel=1e-6)
        assert bool(found["within"].item())
        history = found["history"].values[0]
        assert (np.diff(history) <= 0).all()
        assert history[-1] == found["mass"].item()

    def test_greatest_frequency_below_a_mass(self) -> None:
        one = Study(
            BAR,
            (self.THICKNESS,),
            self.OUTPUTS,
            limits=(Limit("mass", greatest=0.15),),
            goals=(Goal("f1", "max"),),
        )
        found = optimum_study(one).dataset
        exact = 0.15 / (2700 * 0.4 * 30e-3)
        assert found["t"].item() == pytest.approx(exact, rel=1e-6)

    @pytest.mark.thorough
    def test_two_variables_whose_least_mass_is_at_the_corner(self) -> None:
        """The width does not change the frequency: the least of it is best."""
        width = Variable("w", ("links.arm.out_of_plane_width",), LENGTH, "range", (20e-3, 60e-3))
        two = Study(
            BAR,
            (self.THICKNESS, width),
            self.OUTPUTS,
            limits=(Limit("f1", least=FLOOR),),
            goals=(Goal("mass"),),
        )
        found = optimum_study(two).dataset
        exact = FLOOR / self.frequency_of_one_metre()
        assert found["w"].item() == pytest.approx(20e-3, rel=1e-6)
        assert found["mass"].item() == pytest.approx(2700 * 0.4 * 20e-3 * exact, rel=1e-6)


class TestTwoGoals:
    """Thicknesses of a list: the front is known from every combination."""

    LISTS = tuple(
        Variable(link, (f"links.{link}.in_plane_thickness",), LENGTH, "values", tuple(each))
        for link, each in (
            ("coupler", np.linspace(1e-3, 3e-3, 11).tolist()),
            ("rocker", np.linspace(1e-3, 4e-3, 13).tolist()),
        )
    )
    STUDY = study(
        *LISTS,
        outputs=MASS | {"f1": Output("lowest_frequency", **STILL)},  # type: ignore[arg-type]
        limits=(Limit("mass", greatest=0.13),),
        goals=(Goal("mass"), Goal("f1", "max")),
    )

    def test_the_front_is_that_of_an_exhaustive_grid(self) -> None:
        pytest.importorskip("pymoo")
        grid = sweep_study(self.STUDY).dataset
        mass, f1 = (grid[name].values for name in ("mass", "f1"))
        inside = grid["within"].values
        better = (mass <= mass[:, None]) & (f1 >= f1[:, None])
        better &= (mass < mass[:, None]) | (f1 > f1[:, None])
        front = inside & ~(better & inside).any(axis=1)
        assert 10 < front.sum() < inside.sum() < len(mass) == 143
        exact = np.stack([grid[name].values[front] for name in ("coupler", "rocker", "mass", "f1")])
        found = optimum_study(self.STUDY).dataset
        got = np.stack([found[name].values for name in ("coupler", "rocker", "mass", "f1")])
        np.testing.assert_array_equal(got[:, np.lexsort(got)], exact[:, np.lexsort(exact)])
        ends = found["history"].values[:, -1]
        assert ends.tolist() == [mass[front].min(), f1[front].max()]
