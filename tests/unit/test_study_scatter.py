"""Optima by percentiles and means over what is uncertain, and bands of frequencies."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexmech import natural_frequencies
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.studies import (
    Correlation,
    Goal,
    Limit,
    Optimum,
    Output,
    Variable,
    load_study,
    optimum_study,
    runs_line,
    uncertainty_study,
)
from flexmech.studies.designs.bands import bands_table, frequency_bands
from flexmech.studies.designs.evaluation import Evaluated, evaluate
from flexmech.studies.designs.scatter import Scatter
from flexmech.units import LENGTH, STRESS
from tests.support.study_data import (
    ALUMINIUM,
    FILE,
    MASS,
    Scripted,
    density,
    study,
    study_file,
    thickness,
)

MEAN, DEVIATION = 2923.0, 150.0
THICKNESS = thickness(1e-3, 3e-3)
NORMAL_90 = 1.2815515655446004
"""Standard deviations above the mean of a normal distribution that one in ten exceeds."""


def masses(designs: FloatArray) -> FloatArray:
    """Masses of the links by thicknesses and densities, as the mechanism has them."""
    return evaluate(study(THICKNESS, density(MEAN, DEVIATION)), designs).values


def mass_of(thick: float, heavy: float) -> float:
    """Mass of the links by a thickness and a density."""
    return float(masses(np.array([[thick, heavy]]))[0, 0])


def terms(designs: FloatArray) -> FloatArray:
    """What the mass is linear in."""
    thick, heavy = designs.T
    return np.stack([np.ones_like(thick), heavy, thick * heavy], axis=1)


@cache
def coefficients() -> FloatArray:
    """Of the mass in its terms, of which the mechanism alone knows them."""
    rows = np.array([[1e-3, 2800.0], [3e-3, 2800.0], [2e-3, 3100.0]])
    return np.linalg.solve(terms(rows), masses(rows))


def product(designs: FloatArray) -> FloatArray:
    """The masses by the terms, in a moment."""
    return terms(designs) @ coefficients()


def thickest(percentile: float | None, samples: int = 64, *, mechanism: bool = False) -> Optimum:
    """The thickest coupler whose mass is 0.1 kg by a percentile or its mean.

    Masses of the search are those of the product, unless the mechanism is to be computed.
    """
    return optimum_study(
        study(
            THICKNESS,
            density(MEAN, DEVIATION),
            outputs=MASS,
            limits=(Limit("mass", greatest=0.1, percentile=percentile),),
            goals=(Goal("mass", "max", percentile),),
            percentile_samples=samples,
        ),
        executor=None if mechanism else Scripted(product),
    )


COMPUTED = pytest.mark.parametrize(
    "mechanism",
    [False, pytest.param(True, marks=pytest.mark.thorough)],
    ids=["product", "mechanism"],
)


class TestOptimumUnderScatter:
    """The mass is linear in the density: its percentiles have a closed form."""

    def test_the_mass_of_the_mechanism_is_the_product(self) -> None:
        rows = np.array([[1.1e-3, 2500.0], [1.7e-3, 3300.0], [2.9e-3, 2923.0]])
        np.testing.assert_allclose(product(rows), masses(rows), rtol=1e-12)

    @COMPUTED
    @pytest.mark.parametrize(("percentile", "apart"), [(90.0, NORMAL_90), (10.0, -NORMAL_90)])
    def test_a_percentile_is_that_of_the_closed_form(
        self, percentile: float, apart: float, mechanism: bool
    ) -> None:
        found = thickest(percentile, samples=256, mechanism=mechanism).dataset
        thick = found[THICKNESS.name].item()
        per_deviation = mass_of(thick, MEAN + DEVIATION) - mass_of(thick, MEAN)
        exact = mass_of(thick, MEAN + apart * DEVIATION)
        assert found["mass"].item() == pytest.approx(0.1, rel=1e-4)
        assert abs(exact - 0.1) < 0.02 * per_deviation
        assert found["density"].item() == pytest.approx(MEAN)

    @COMPUTED
    def test_without_a_percentile_it_is_the_mean(self, mechanism: bool) -> None:
        found = thickest(None, mechanism=mechanism)
        thick = found.dataset[THICKNESS.name].item()
        assert mass_of(thick, MEAN) == pytest.approx(0.1, rel=1e-3)
        assert "Over the samples: mass by its mean." in found.summary().answer

    @COMPUTED
    def test_the_summary_tells_the_runs(self, mechanism: bool) -> None:
        found = thickest(90.0, mechanism=mechanism)
        count = int(found.dataset["evaluations"][-1])
        runs = found.dataset.attrs["runs"]
        # Every design as often as there are samples, and once each where the search starts.
        assert 64 * (count - 4) < runs <= 64 * count + 32
        assert f"each with 64 samples of density: {runs} runs" in found.summary().answer[0]
        assert "Over the samples: mass by its 90 % percentile." in found.summary().answer
        assert found.dataset["relative_error"].item() > 0.001

    def test_of_listed_values_each_has_its_samples(self) -> None:
        chosen = Variable(
            "width", ("links.coupler.out_of_plane_width",), LENGTH, "values", (25e-3, 26e-3)
        )
        whole = study(chosen, density(MEAN, DEVIATION), goals=(Goal("mass", "min", 97.5),))
        found = optimum_study(whole).dataset
        assert found["width"].item() == 25e-3
        assert found.attrs["runs"] == 2 * 64


class TestScatter:
    STUDY = study(
        THICKNESS,
        density(MEAN, DEVIATION),
        goals=(Goal("mass", "min", 90.0),),
        percentile_samples=16,
    )

    def test_all_designs_have_the_same_random_numbers(self) -> None:
        asked: list[Any] = []

        def keep(rows: Any) -> Evaluated:
            asked.append(rows)
            return Evaluated(rows[:, :1], np.zeros(len(rows), dtype=int), [""] * len(rows))

        scatter = Scatter.of(self.STUDY)
        scatter.evaluated(scatter.designs(np.array([[0.1], [0.7]])), keep)
        first, second = asked[0].reshape(2, 16, 2)
        np.testing.assert_array_equal(first[:, 1], second[:, 1])
        assert len(set(first[:, 1])) == 16
        np.testing.assert_allclose(first[:, 0], 1.2e-3)
        np.testing.assert_allclose(second[:, 0], 2.4e-3)

    def test_one_failing_sample_fails_its_design_alone(self) -> None:
        def some(rows: Any) -> Evaluated:
            status = np.zeros(len(rows), dtype=int)
            status[[3, 5]] = 3
            values = np.where(status == 0, rows[:, 1], np.nan)[:, None]
            return Evaluated(values, status, ["it buckles" if each else "" for each in status])

        scatter = Scatter.of(self.STUDY)
        designs = scatter.designs(np.array([[0.1], [0.7]]))
        found = scatter.evaluated(designs, some)
        assert found.status.tolist() == [3, 0]
        assert found.reasons == ["2 of 16 samples: it buckles", ""]
        assert np.isnan(found.values[0, 0])
        assert np.isfinite(found.values[1, 0])
        # Unless the study says what a failure is worth.
        worth = Scatter.of(replace(self.STUDY, failure_values={"mass": 1e9}))
        counted = worth.evaluated(designs, some)
        assert counted.status.tolist() == [0, 0]
        assert counted.values[0, 0] > 1e8

    def test_correlated_properties_scatter_together(self) -> None:
        rocker = replace(thickness(1e-3, 1e-5, distribution="normal", link="rocker"), name="rocker")
        both = replace(
            self.STUDY,
            variables=(*self.STUDY.variables, rocker),
            correlations=(Correlation(("density", "rocker"), 0.9),),
        )
        scatter = Scatter.of(both)
        rows = scatter._around(scatter.designs(np.array([[0.5]])))
        assert np.corrcoef(rows[:, 1], rows[:, 2])[0, 1] == pytest.approx(0.9, abs=0.1)

    def test_what_is_chosen_goes_with_nothing(self) -> None:
        both = replace(self.STUDY, correlations=(Correlation(("density", THICKNESS.name), 0.9),))
        with pytest.raises(InputError, match="is chosen by the search and cannot go with density"):
            Scatter.of(both)

    def test_nothing_is_left_to_choose(self) -> None:
        alone = study(density(MEAN, DEVIATION), goals=(Goal("mass"),))
        with pytest.raises(InputError, match="none is left to choose; give one of them range"):
            optimum_study(alone)


class TestRefusedPercentiles:
    @pytest.mark.parametrize(
        ("given", "told"),
        [
            ({"variables": (THICKNESS,)}, "nothing is uncertain; give a variable normal"),
            ({"goals": (Goal("mass", "min", 100.0),)}, "must lie between 0 and 100, got 100"),
            ({"goals": (Goal("mass", "min", 2.5),)}, "too few for percentile = 2.5 .* take 64"),
            ({"limits": (Limit("mass", least=0.1),)}, "that of mass differs among its goals"),
            (
                {"percentile_samples": 24},
                "24 is no power of two; take 16 or 32",
            ),
        ],
    )
    def test_tells_the_remedy(self, given: Any, told: str) -> None:
        with pytest.raises(InputError, match=told):
            replace(TestScatter.STUDY, **given)


class TestInputsOfOneValue:
    TWO = study(thickness(1e-3, 3e-3), thickness(2e-3, distribution="values", link="rocker"))

    def test_take_no_runs(self) -> None:
        assert runs_line(self.TWO, 16).endswith("N = 16 samples and D = 1 inputs")
        found = uncertainty_study(self.TWO, 16).dataset
        assert found["input"].values.tolist() == [THICKNESS.name]
        rocker = found["links.rocker.in_plane_thickness"].values
        assert set(rocker.tolist()) == {2e-3}
        assert found["total"].values == pytest.approx(1.0, abs=0.3)
        alone = uncertainty_study(study(thickness(1e-3, 3e-3)), 16).dataset
        np.testing.assert_array_equal(found[THICKNESS.name], alone[THICKNESS.name])

    def test_what_changes_nothing_has_no_share(self) -> None:
        """Of what no output depends on the bootstrap has no interval, and SciPy warns."""
        key = "materials.crank_aluminium.youngs_modulus"
        stiff = Variable("stiff", (key,), STRESS, "normal", (68.9e9, 1e9))
        found = uncertainty_study(study(thickness(1e-3, 3e-3), stiff), 16).dataset
        own = found.sel(output="mass", input="stiff")
        for name in ("first_order", "total"):
            assert [float(own[f"{name}{end}"]) for end in ("", "_low", "_high")] == [0.0] * 3
        assert (found["total_high"].sel(input=THICKNESS.name) > 0.5).all()

    def test_of_nothing_else_nothing_is_uncertain(self) -> None:
        fixed = study(thickness(2e-3, distribution="values"))
        with pytest.raises(InputError, match="every variable has one value"):
            uncertainty_study(fixed, 16)


class TestBandsOfFrequencies:
    def test_are_percentiles_of_single_runs(self) -> None:
        output = Output("lowest_frequency", speed=20.0, prestress="axial", angles=4)
        whole = study(thickness(1.4e-3, 3e-3), outputs={"f1": output})
        designs = whole.sample(8)
        bands = frequency_bands(whole, designs)["frequency_percentile"]
        angles = np.radians([0, 90, 180, 270, 360])
        np.testing.assert_allclose(bands["crank_angle"], angles)
        alone = [
            natural_frequencies(
                whole.parameters.mechanism_with({THICKNESS.name: thick}),
                *(angles, 20.0),
                modes=3,
                prestress="axial",
            )
            for thick in designs[:, 0].tolist()
        ]
        wanted = np.percentile(alone, [2.5, 50, 97.5], axis=0, method="hazen")
        np.testing.assert_allclose(
            bands.transpose("percentile", "crank_angle", "mode"), wanted, rtol=1e-9
        )
        assert bands.attrs["designs"] == 8
        table = bands_table(bands)
        own = table[table["mode"] == 2]
        np.testing.assert_allclose(own["crank_angle_rad"], angles)
        np.testing.assert_allclose(own["p97_5_Hz"], wanted[2, :, 1])

    def test_no_output_of_frequencies_has_none(self) -> None:
        assert not frequency_bands(study(THICKNESS), study(THICKNESS).sample(8))

    def test_designs_that_fail_are_left_out(self) -> None:
        still = Output("lowest_frequency", speed=0.0, prestress="none", angles=4)
        length = Variable("length", ("linkage.coupler",), LENGTH, "range", (0.25, 0.5))
        whole = study(length, outputs={"f1": still})
        assert ALUMINIUM.linkage.lengths["coupler"] == 0.2794
        designs = np.array([[0.25 + 0.005 * number] for number in range(9)] + [[0.9]])
        assert frequency_bands(whole, designs)["frequency_percentile"].attrs["designs"] == 9
        # Seven tell nothing of an interval of 95 %.
        assert not frequency_bands(whole, designs[3:])


class TestStudyFile:
    TEXT = f"""percentile_samples = 128
{FILE}
percentile = 97.5
[vary.density]
paths = ["materials.aluminium.density"]
normal = ["2923 kg/m^3", "30 kg/m^3"]
"""

    def test_percentiles_are_read(self, tmp_path: Path) -> None:
        read = load_study(study_file(tmp_path, text=self.TEXT))
        assert read.percentile_samples == 128
        assert read.goals == (Goal("mass", "min", 97.5),)
        assert read.limits == (Limit("f1", least=40.0),)
        assert read.percentiles == {"mass": 97.5}
        assert read.uncertain == ["density"]

    @pytest.mark.parametrize(
        ("old", "new", "told"),
        [
            ("97.5", "100", "goals[0].percentile"),
            ("= 128", "= 12", "percentile_samples: 12 is no power of two; take 8 or 16"),
            ("= 128", "= 32", "too few for percentile = 97.5 of mass; take 64 or more"),
        ],
    )
    def test_what_is_wrong_is_told(self, old: str, new: str, told: str, tmp_path: Path) -> None:
        file = study_file(tmp_path, old, new, self.TEXT)
        with pytest.raises(InputError) as caught:
            load_study(file)
        assert str(caught.value).startswith(str(file))
        assert told in str(caught.value)
