"""Variables of a study: their values, the samples of them, and what each changes of a design."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st

from flexmech import Mechanism, load_mechanism
from flexmech.analyses.damping_ratios import lowest_frequency
from flexmech.analyses.default_engines import engine_kind
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.errors import InputError
from flexmech.hygrothermal import HygrothermalState, mechanism_in_state
from flexmech.modelfile import mechanism_from_toml
from flexmech.studies import Correlation, Output, Study, Variable, load_study, sweep
from flexmech.studies.designs.design import turn
from flexmech.studies.designs.evaluation import evaluate
from flexmech.units import DENSITY, LENGTH, RATIO
from tests.support.study_data import (
    ALUMINIUM,
    MODELS,
    THICKNESS,
    density,
    study,
    study_file,
    thickness,
)

COMPOSITE = load_mechanism(MODELS / "composite_fourbar.toml")
MOIST = load_mechanism(MODELS / "moist_composite_fourbar.toml")
PROBABILITIES = st.lists(st.floats(1e-9, 1 - 1e-9), min_size=2, max_size=20).map(np.array)
POSITIVE = st.floats(1e-4, 1e4)
STILL: dict[str, Any] = {"speed": 0.0, "prestress": "none", "angles": 4}


class TestValues:
    @given(PROBABILITIES, POSITIVE, st.floats(1e-3, 10.0))
    def test_ranges_are_uniform_between_their_ends(
        self, probability: np.ndarray, low: float, width: float
    ) -> None:
        variable = Variable("v", ("v",), LENGTH, "uniform", (low, low * (1 + width)))
        found = variable.at(probability)
        assert (found >= low).all()
        assert (found <= low * (1 + width) * (1 + 1e-15)).all()
        exact = scipy.stats.uniform(low, low * width).ppf(probability)
        np.testing.assert_allclose(found, exact, rtol=1e-12)
        np.testing.assert_allclose(variable.at(np.array([0.0, 1.0])), [low, low * (1 + width)])

    @given(PROBABILITIES, st.floats(-1e3, 1e3), POSITIVE)
    def test_normal_is_that_of_scipy(
        self, probability: np.ndarray, mean: float, deviation: float
    ) -> None:
        variable = Variable("v", ("v",), LENGTH, "normal", (mean, deviation))
        exact = scipy.stats.norm(mean, deviation)
        found = variable.at(probability)
        np.testing.assert_allclose(found, exact.ppf(probability), rtol=1e-12, atol=1e-12 * mean)

    @given(PROBABILITIES, POSITIVE, st.floats(1e-3, 3.0))
    def test_lognormal_has_the_mean_and_deviation_of_the_quantity_itself(
        self, probability: np.ndarray, mean: float, variation: float
    ) -> None:
        variable = Variable("v", ("v",), LENGTH, "lognormal", (mean, mean * variation))
        spread = np.sqrt(np.log1p(variation**2))
        exact = scipy.stats.lognorm(spread, scale=mean * np.exp(-(spread**2) / 2))
        assert exact.mean() == pytest.approx(mean)
        assert exact.std() == pytest.approx(mean * variation)
        np.testing.assert_allclose(variable.at(probability), exact.ppf(probability), rtol=1e-9)

    @given(PROBABILITIES, st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=7, unique=True))
    def test_listed_values_are_equally_likely(
        self, probability: np.ndarray, numbers: list[float]
    ) -> None:
        listed = Variable("v", ("v",), LENGTH, "values", tuple(numbers))
        places = np.floor(probability * len(numbers)).astype(int)
        np.testing.assert_array_equal(listed.at(probability), np.array(numbers)[places])
        middles = (np.arange(len(numbers)) + 0.5) / len(numbers)
        assert listed.at(middles).tolist() == listed.every().tolist() == numbers
        assert listed.at(np.array([1.0])) == numbers[-1]
        texts = Variable("v", ("v",), None, "values", tuple(map(str, numbers)))
        np.testing.assert_array_equal(texts.at(probability), places)
        assert [texts.value(place) for place in texts.at(middles)] == list(map(str, numbers))

    @given(PROBABILITIES)
    def test_a_greater_probability_is_no_smaller_value(self, probability: np.ndarray) -> None:
        kinds = ("range", "uniform", "normal", "lognormal")
        for kind in kinds:
            found = Variable("v", ("v",), LENGTH, kind, (1.0, 2.0)).at(np.sort(probability))  # type: ignore[arg-type]
            assert (np.diff(found) >= 0).all()
            assert found.shape == probability.shape

    def test_words(self) -> None:
        assert thickness(1e-3, 3e-3).told(2e-3) == "0.002 m"
        shown = Variable("v", ("v",), LENGTH, "range", (1e-3, 3e-3), shown_unit="mm")
        assert shown.told(2e-3) == "2 mm"
        assert Variable("v", ("v",), None, "values", ("a", "b")).told(1.0) == "b"


class TestSamples:
    TWO = study(thickness(1e-3, 3e-3), density(2923.0, 30.0))

    @given(st.integers(1, 70), st.integers(1, 70))
    def test_a_design_depends_on_the_seed_and_its_number_alone(self, few: int, many: int) -> None:
        shorter, longer = sorted((few, many))
        np.testing.assert_array_equal(
            self.TWO.sample(longer)[:shorter], self.TWO.sample(shorter), strict=True
        )

    def test_a_sample_of_any_size_comes_without_a_warning(self) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert self.TWO.sample(7).shape == (7, 2)

    def test_another_seed_is_another_sample(self) -> None:
        assert (self.TWO.sample(8) != self.TWO.with_(seed=2).sample(8)).all()

    def test_a_sample_fills_the_ranges_evenly(self) -> None:
        first, second = self.TWO.sample(64).T
        low, width = 1e-3, 2e-3
        counts = np.bincount(np.floor(16 * (first - low) / width).astype(int))
        assert counts.tolist() == [4] * 16
        assert np.mean(second) == pytest.approx(2923.0, abs=2.0)
        assert np.std(second) == pytest.approx(30.0, rel=0.05)

    def test_every_combination_with_the_last_variable_fastest(self) -> None:
        listed = Variable("r", ("materials.aluminium.density",), DENSITY, "values", (1e3, 2e3))
        grid = study(thickness(1e-3, 3e-3), listed).combinations()
        assert grid.shape == (10, 2)
        assert grid[:3].tolist() == [[1e-3, 1e3], [1e-3, 2e3], [1.5e-3, 1e3]]
        assert grid[-1].tolist() == [3e-3, 2e3]

    @pytest.mark.parametrize("coefficient", [-0.9, 0.5])
    def test_correlated_variables(self, coefficient: float) -> None:
        normal = thickness(2e-3, 1e-5, distribution="normal"), density(2923.0, 30.0)
        pair = Correlation((normal[0].name, "density"), coefficient)
        correlated = study(*normal, correlations=(pair,))
        found = correlated.sample(4096)
        assert np.corrcoef(found.T)[0, 1] == pytest.approx(coefficient, abs=0.01)
        assert np.std(found[:, 1]) == pytest.approx(30.0, rel=0.01)
        np.testing.assert_array_equal(correlated.sample(7), found[:7])

    def test_coefficients_that_contradict_each_other(self) -> None:
        links = "crank", "coupler", "rocker"
        three = [thickness(2e-3, 1e-5, distribution="normal", link=link) for link in links]
        names = [variable.name for variable in three]
        pairs = ((0, 1, 0.9), (1, 2, 0.9), (0, 2, -0.9))
        given = tuple(Correlation((names[i], names[j]), value) for i, j, value in pairs)
        with pytest.raises(InputError, match="must be positive definite"):
            study(*three, correlations=given)


def outputs_of(mechanism: Mechanism, variables: dict[str, Any], **outputs: Output) -> Any:
    found = sweep(mechanism, variables, outputs).dataset
    assert (found["status"] == "ok").all(), found["reason"].values
    return [found[name].values for name in outputs]


class TestWhatVariablesChange:
    def test_the_material_of_a_link(self) -> None:
        key = "links.coupler.material"
        (mass,) = outputs_of(
            ALUMINIUM, {key: ["aluminium", "crank_aluminium"]}, mass=Output("mass")
        )
        volume = 0.2794 * 1.6e-3 * 25.4e-3
        assert mass[0] - mass[1] == pytest.approx((2923.0 - 2698.0) * volume, rel=1e-9)

    def test_the_laminate_of_a_link(self) -> None:
        (mass,) = outputs_of(
            COMPOSITE,
            {"links.coupler.laminate": ["carbon_on_glass", "sandwiched_glass"]},
            mass=Output("mass"),
        )
        glass, carbon = 1813.9 * 1e-3, 1566.7 * 1e-3
        eight, six = 4 * (glass + carbon), 2 * carbon + 4 * glass
        assert mass[0] - mass[1] == pytest.approx((eight - six) * 20e-3 * 160e-3, rel=1e-9)

    def test_a_stacking(self) -> None:
        key = "laminates.carbon_on_glass.stacking"
        stackings = ["[C*4/G*4]", "[C*8]", "[G*8]"]
        mass, f1 = outputs_of(
            COMPOSITE,
            {key: stackings},
            mass=Output("mass"),
            f1=Output("lowest_frequency", **STILL),
        )
        less = 4 * (1813.9 - 1566.7) * 1e-3 * 20e-3 * 160e-3
        assert mass[0] - mass[1:] == pytest.approx([less, -less], rel=1e-9)
        assert f1[1] > f1[0] > f1[2]

    def test_three_thicknesses_that_share_a_variable(self, tmp_path: Path) -> None:
        links = [f'"links.{link}.in_plane_thickness"' for link in ("crank", "coupler", "rocker")]
        file = study_file(
            tmp_path,
            f'[vary."{THICKNESS}"]',
            f"[vary.all]\npaths = [{', '.join(links)}]",
        )
        shared = load_study(file)
        assert shared.names == ["all", "length"]
        whole = Study(ALUMINIUM, shared.variables[:1], {"mass": Output("mass")})
        found = sweep(
            ALUMINIUM,
            {f"links.{link}.in_plane_thickness": [3e-3] for link in ("crank", "coupler", "rocker")},
            whole.outputs,
        )
        assert evaluate(whole, np.array([[3e-3]])).values == found.dataset["mass"].values

    def test_the_crank_speed(self) -> None:
        (torque,) = outputs_of(
            ALUMINIUM, {"crank-speed": [5.0, 10.0, 20.0]}, torque=Output("peak_driving_torque")
        )
        assert torque / torque[0] == pytest.approx([1.0, 4.0, 16.0], rel=1e-9)

    def test_an_output_at_a_speed_of_its_own_is_taken_there(self) -> None:
        (torque,) = outputs_of(
            ALUMINIUM,
            {"crank-speed": [5.0, 10.0]},
            torque=Output("peak_driving_torque", speed=5.0),
        )
        assert torque[0] == torque[1]

    @pytest.mark.parametrize(
        ("key", "state"),
        [
            ("temperature-rise", HygrothermalState(temperature_rise=40.0)),
            ("moisture", HygrothermalState(moisture=0.01)),
        ],
    )
    def test_heat_and_moisture(self, key: str, state: HygrothermalState) -> None:
        value = state.temperature_rise or state.moisture
        (found,) = outputs_of(MOIST, {key: [value]}, f1=Output("lowest_frequency", **STILL))
        wet = engine_kind("reference")(mechanism_in_state(MOIST, state))
        dry = engine_kind("reference")(MOIST)
        there, here = (
            natural_frequencies(engine, turn(4), 0.0, modes=3, prestress="none")[:, 0].min()
            for engine in (wet, dry)
        )
        assert found[0] == pytest.approx(there, rel=1e-12)
        assert abs(there - here) > 1e-4 * here

    def test_heat_and_moisture_together(self) -> None:
        state = HygrothermalState(temperature_rise=40.0, moisture=0.01)
        both = {"temperature-rise": [40.0], "moisture": [0.01]}
        (found,) = outputs_of(MOIST, both, f1=Output("lowest_frequency", **STILL))
        engine = engine_kind("reference")(mechanism_in_state(MOIST, state))
        there = natural_frequencies(engine, turn(4), 0.0, modes=3, prestress="none")[:, 0].min()
        assert found[0] == pytest.approx(there, rel=1e-12)

    def test_the_damping_ratio(self) -> None:
        ratio = Variable("damping-ratio", ("damping-ratio",), RATIO, "values", (0.0, 0.02))
        whole = study(ratio, outputs={"m": Output("largest_multiplier", speed=20.0)})
        ((multiplier,),) = evaluate(whole, np.array([[0.02]])).values
        # The slowest decay is the first mode's: its ratio times its mean frequency over a turn.
        decay = -np.log(multiplier) / (2 * np.pi / 20.0)
        mean = lowest_frequency(engine_kind("reference")(ALUMINIUM))
        assert decay == pytest.approx(0.02 * mean, rel=0.03)

    def test_frequencies_are_those_of_the_single_run(self) -> None:
        output = Output("lowest_frequency", speed=20.0, angles=5, mode=2)
        (found,) = outputs_of(ALUMINIUM, {THICKNESS: [1.5e-3, 2.5e-3]}, f2=output)
        text = (MODELS / "aluminium_fourbar.toml").read_text()
        links = text.index("[links.coupler]")
        for value, got in zip(("1.5 mm", "2.5 mm"), found, strict=True):
            changed = text[:links] + re.sub(r'"1\.6 mm"', f'"{value}"', text[links:], count=1)
            engine = engine_kind("reference")(mechanism_from_toml(changed))
            single = natural_frequencies(engine, turn(5), 20.0, modes=3, prestress="equilibrium")
            assert got == pytest.approx(single[:, 1].min(), rel=1e-9)
