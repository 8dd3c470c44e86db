"""Campbell diagrams: crossings of invented bands, fits, gaps, tables and the command."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from flexmech import (
    CampbellDiagram,
    ComputationError,
    HygrothermalState,
    InputError,
    ReferenceEngine,
    campbell,
    mechanism_in_state,
)
from flexmech.analyses.campbell.crossings import HIGHEST, LOWEST, Edge, critical_speeds, edges_of
from flexmech.analyses.campbell.sampling import band_fit, speed_grid
from flexmech.cli.application import app
from flexmech.cli.typed import ORDERS
from flexmech.mechanism import Mechanism
from flexmech.modelfile import mechanism_from_toml
from tests.support.plot_data import campbell_dataset
from tests.unit.test_cli_state import MODEL as WET

pytestmark = pytest.mark.usefixtures("rough_pictures")

MODELS = Path(__file__).parents[2] / "models"
SPEED = np.linspace(0.0, 100.0, 201)
BANDS = ["engine", "crank_speed_rad_s", "branch", "lowest_Hz", "mean_Hz", "highest_Hz"]
CRITICAL = ["engine", "order", "branch", "from_rad_s", "to_rad_s", "nearest_relative_gap"]


def bands(lowest: Any, highest: Any) -> np.ndarray:
    """One branch in turns per second, on the speeds above."""
    ends = [np.broadcast_to(np.asarray(end, dtype=float), SPEED.shape) for end in (lowest, highest)]
    values = np.stack([ends[0], (ends[0] + ends[1]) / 2, ends[1]], axis=1)
    return values[:, :, None] / (2 * np.pi)


def found(values: np.ndarray, orders: list[int]) -> list[tuple[int, float, float, float]]:
    """Critical speeds with edges at the middle of their step."""
    edges = edges_of(SPEED, values, np.array(orders))
    middle = {edge: float(SPEED[edge.place : edge.place + 2].mean()) for edge in edges}
    return [
        (c.order, c.start, c.end, c.gap)
        for c in critical_speeds(SPEED, values, np.array(orders), middle)
    ]


class TestCrossings:
    def test_a_ray_enters_by_the_lowest_and_leaves_by_the_highest(self) -> None:
        values = bands(30.1, 40.2)
        assert edges_of(SPEED, values, np.array([1])) == [
            Edge(1, 1, LOWEST, 60, enters=True),
            Edge(1, 1, HIGHEST, 80, enters=False),
        ]
        assert found(values, [1, 2]) == [(1, 30.25, 40.25, 0.0), (2, 15.25, 20.25, 0.0)]

    def test_a_band_that_is_passed_within_one_step(self) -> None:
        assert found(bands(30.1, 30.2), [1]) == [(1, 30.25, 30.25, 0.0)]

    def test_a_band_that_turns_back_is_met_twice(self) -> None:
        values = bands(30.1 + 0.0 * SPEED, np.where(SPEED < 60, 40.2, SPEED + 5.0))
        assert found(values, [1]) == [(1, 30.25, 40.25, 0.0), (1, 59.75, 100.0, 0.0)]

    def test_ranges_are_cut_off_at_gaps_and_ends(self) -> None:
        values = bands(0.0, 200.0)
        values[100:120] = np.nan
        edges = edges_of(SPEED, values, np.array([1]))
        ranges = critical_speeds(SPEED, values, np.array([1]), dict.fromkeys(edges, 0.0))
        assert [(c.start, c.end) for c in ranges] == [(0.0, 49.5), (60.0, 100.0)]
        assert all(c.starts_inside and c.ends_inside for c in ranges)

    def test_near_misses_have_a_gap_and_far_ones_no_row(self) -> None:
        values = bands(105.0, 110.0)
        assert found(values, [1]) == [(1, 100.0, 100.0, pytest.approx(5 / 105))]
        assert not found(bands(150.0, 160.0), [1])

    def test_the_crank_may_turn_backwards(self) -> None:
        values = bands(30.1, 40.2)
        edges = edges_of(-SPEED[::-1], values, np.array([1]))
        assert [(e.end, e.enters) for e in edges] == [(HIGHEST, True), (LOWEST, False)]


class TestFit:
    def test_cubics_are_met(self) -> None:
        nodes = np.array([0.0, 1.0, 2.5, 3.0, 5.0])
        at = np.linspace(0, 5, 23)
        values = np.stack([nodes**3 - 2 * nodes] * 3, axis=1)[:, :, None]
        wanted = at**3 - 2 * at
        np.testing.assert_allclose(band_fit(nodes, values, at)[:, 1, 0], wanted, atol=1e-12)

    def test_bends_of_both_ends_are_met_between_the_nodes(self) -> None:
        nodes, at = np.arange(12.0), np.linspace(4.0, 7.0, 31)

        def band(x: np.ndarray) -> np.ndarray:
            lowest = np.minimum(50 + x**2 / 9, 80 - 4 * x)
            return np.stack([lowest, 0 * x + 90, 200 - lowest], axis=1)[:, :, None]

        np.testing.assert_allclose(band_fit(nodes, band(nodes), at), band(at), rtol=1e-12)

    def test_few_nodes(self) -> None:
        for count in (1, 2, 3):
            nodes = np.arange(float(count))
            values = np.stack([nodes] * 3, axis=1)[:, :, None]
            fitted = band_fit(nodes, values, nodes[-1:] / 2)
            assert fitted[0, 0, 0] == pytest.approx(nodes[-1] / 2)

    def test_few_speeds_are_divided_for_the_search(self) -> None:
        grid, places = speed_grid(np.array([0.0, 10.0, 40.0]))
        assert len(grid) >= 129
        np.testing.assert_array_equal(grid[places], [0.0, 10.0, 40.0])
        assert np.all(np.diff(grid) > 0)
        assert len(speed_grid(np.array([5.0]))[0]) == 1


@pytest.fixture
def diagram(unit_arm: Callable[[float], Mechanism]) -> CampbellDiagram:
    """Beyond its natural frequency at rest, 3.516 rad/s, an arm without tension turns over."""
    return campbell(
        ReferenceEngine(unit_arm(100.0), 2),
        np.linspace(0.0, 6.0, 25),
        crank_angles=np.radians(np.arange(0.0, 360.0, 60.0)),
        modes=2,
        orders=[1, 2],
        prestress="none",
    )


class TestGap:
    def test_a_speed_without_equilibrium_has_no_row(self, diagram: CampbellDiagram) -> None:
        table = diagram.bands()
        assert list(table.columns) == BANDS
        assert not table.isna().any(axis=None)
        assert table["crank_speed_rad_s"].max() == 3.5
        assert np.all(table["lowest_Hz"] <= table["mean_Hz"])
        assert np.all(table["mean_Hz"] <= table["highest_Hz"])

    def test_the_gap_is_told_with_its_reason(self, diagram: CampbellDiagram) -> None:
        (line,) = [part for part in diagram.summary().warnings if part.startswith("gap:")]
        first = float(diagram.dataset["gap_first"][0])
        assert first == 3.75
        assert "from 3.75 to 6 rad/s (10 speeds)" in str(line)
        assert f"crank speed {first:g} rad/s" in str(line)
        assert "crank angle" in str(line)

    def test_no_critical_speed_reaches_into_it(self, diagram: CampbellDiagram) -> None:
        table = diagram.critical_speeds()
        assert list(table.columns) == CRITICAL
        assert len(table)
        assert table["to_rad_s"].max() < float(diagram.dataset["gap_first"][0])

    def test_it_loads_back_equal(self, diagram: CampbellDiagram, tmp_path: Path) -> None:
        diagram.save(tmp_path)
        loaded = CampbellDiagram.load(tmp_path / "campbell.nc")
        assert loaded.dataset.identical(diagram.dataset)

    def test_speeds_that_all_fail_are_an_error(self, aluminium: Mechanism) -> None:
        with pytest.raises(ComputationError, match=r"crank angle .* crank speed 200 rad/s"):
            campbell(
                ReferenceEngine(aluminium, 2),
                [200.0, 220.0],
                crank_angles=np.radians([0.0, 30.0]),
                modes=2,
            )


def test_without_gaps_or_crossings_it_loads_back_equal(
    aluminium: Mechanism, tmp_path: Path
) -> None:
    engine, angles = ReferenceEngine(aluminium, 2), np.radians(np.arange(0.0, 360.0, 60.0))
    result = campbell(engine, [0.0], crank_angles=angles, modes=1, orders=[1])
    result.save(tmp_path)
    assert CampbellDiagram.load(tmp_path / "campbell.nc").dataset.identical(result.dataset)
    assert not len(result.critical_speeds())
    assert "no order meets a branch" in str(result.summary())


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"crank_speeds": [1.0, 1.0]}, "crank_speeds repeats"),
        ({"crank_speeds": []}, "crank_speeds must be"),
        ({"crank_speeds": [np.nan]}, "crank_speeds"),
        ({"orders": [0]}, "orders must be whole numbers"),
        ({"orders": [1.5]}, "orders must be whole numbers"),
        ({"orders": [2, 2]}, "orders repeats"),
        ({"orders": []}, "orders must be a list"),
        ({"prestress": "trajectory"}, "prestress"),
        ({"tolerance": 0.0}, "tolerance"),
    ],
)
def test_what_is_refused(aluminium: Mechanism, asked: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        campbell(ReferenceEngine(aluminium, 2), **({"crank_speeds": [1.0]} | asked))


class TestEnvironment:
    """Heat and moisture, as an argument and as options."""

    ASKED = HygrothermalState(temperature_rise=60.0, moisture=0.04)
    WAY: ClassVar[dict[str, Any]] = {
        "crank_angles": np.radians(np.arange(0.0, 360.0, 60.0)),
        "modes": 2,
        "orders": [5, 6],
    }

    def test_bands_are_those_of_the_mechanism_in_that_state(self) -> None:
        dry = mechanism_from_toml(WET)
        found, by_hand, without = (
            campbell(mechanism, [0.0, 10.0], **self.WAY, **environment).dataset
            for mechanism, environment in (
                (dry, {"environment": self.ASKED}),
                (mechanism_in_state(dry, self.ASKED), {}),
                (dry, {}),
            )
        )
        for part in ("lowest_frequency", "highest_frequency"):
            np.testing.assert_array_equal(found[part], by_hand[part])
            # The resin is softer and heavier.
            assert (found[part] < 0.99 * without[part]).all()
        assert found.attrs["mechanism"] == f"wet linkage, {self.ASKED.label}"

    def test_the_state_is_told_with_the_links(self) -> None:
        mechanism = mechanism_from_toml(WET)
        wet, dry = (
            campbell(mechanism, [0.0], **self.WAY, environment=each).summary()
            for each in (self.ASKED, None)
        )
        assert f"state: {self.ASKED.label}" in wet.details
        assert any(str(line).startswith("rocker: ") for line in wet.details)
        assert "state: " not in str(dry)

    def test_what_is_no_environment_is_refused(self, aluminium: Mechanism) -> None:
        with pytest.raises(InputError, match="an environment is needed"):
            campbell(aluminium, [0.0], environment="60 K")  # type: ignore[arg-type]

    def test_options(self, tmp_path: Path) -> None:
        model = tmp_path / "wet.toml"
        model.write_text(WET)
        state = ["--temperature-rise", "60", "--moisture", "4", "--no-plots"]
        out = tmp_path / "out"
        result = run(str(model), "--speeds", "0,10", *QUICK, *state, "--out", str(out))
        assert result.exit_code == 0, result.output
        assert "+60 K, 4 % moisture" in result.output
        found = CampbellDiagram.load(out / "campbell.nc").dataset
        again = campbell(
            ReferenceEngine(mechanism_from_toml(WET), 2),
            [0.0, 10.0],
            **self.WAY | {"crank_angles": np.radians(np.arange(0.0, 361.0, 30.0))},
            environment=self.ASKED,
        ).dataset
        np.testing.assert_allclose(found["mean_frequency"], again["mean_frequency"], rtol=1e-12)


class TestOrders:
    @pytest.mark.parametrize(
        ("text", "orders"),
        [("1:10", list(range(1, 11))), ("2:7:2", [2, 4, 6]), ("4,1", [1, 4]), ("3", [3])],
    )
    def test_what_can_be_written(self, text: str, orders: list[int]) -> None:
        assert ORDERS(text) == orders

    @pytest.mark.parametrize("text", ["0:3", "3:1", "1.5", "1,1", "", "a", "1:2:3:4", "1e9", "-1"])
    def test_what_is_refused(self, text: str) -> None:
        with pytest.raises(InputError, match="--orders"):
            ORDERS(text)


def run(*arguments: str) -> Any:
    return CliRunner().invoke(app, ["campbell", *arguments, "--details"])


QUICK = ["--angles", "0:360:30", "--modes", "2", "--elements", "2", "--orders", "5,6"]


class TestCommand:
    def test_files_and_words(self, tmp_path: Path) -> None:
        # Without tension the arm turns over beyond its natural frequency at rest.
        speeds = ["--speeds", "0:1200:120 rpm", "--prestress", "none"]
        model = str(MODELS / "rotating_arm.toml")
        result = run(model, *speeds, *QUICK, "--response", "--out", str(tmp_path))
        assert result.exit_code == 0, result.output
        names = {path.name for path in tmp_path.iterdir()}
        assert names == {
            *("campbell.csv", "critical_speeds.csv", "response_peaks.csv"),
            *("campbell.nc", "campbell.png", "summary.txt"),
        }
        assert list(pd.read_csv(tmp_path / "campbell.csv").columns) == BANDS
        assert list(pd.read_csv(tmp_path / "critical_speeds.csv").columns) == CRITICAL
        for name in ("campbell", "critical_speeds", "response_peaks"):
            assert not pd.read_csv(tmp_path / f"{name}.csv").isna().any(axis=None)
        words = " ".join(result.output.split())
        assert "gap: reference has no result from" in words
        assert "rpm" in words
        assert "periodic motion: at" in words

    def test_all_speeds_fail(self, tmp_path: Path) -> None:
        model = str(MODELS / "aluminium_fourbar.toml")
        result = run(model, "--speeds", "200", *QUICK, "--out", str(tmp_path / "out"))
        assert result.exit_code == 1
        assert "aluminium_fourbar.toml" in result.output
        assert not (tmp_path / "out").exists()

    def test_wrong_options(self, tmp_path: Path) -> None:
        model = str(MODELS / "aluminium_fourbar.toml")
        for wrong in (["--orders", "0"], ["--speeds", "5 m"], ["--angles", "x"]):
            result = run(model, "--speeds", "10", *wrong, "--out", str(tmp_path))
            assert result.exit_code == 2
            assert wrong[0] in result.output


def test_choosing_branches_and_orders() -> None:
    result = CampbellDiagram(campbell_dataset(peaks=False))
    figure = result.plot(branches=1, orders=[5])
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[0] == "branch 1"
    assert "branch 2" not in labels


def test_operating_speeds_are_told_by_the_orders_that_meet_there() -> None:
    """Order 5 meets branch 1 from 52.78 to 57.81 rad/s; of branch 1 again it is only near."""
    data = campbell_dataset()
    data.attrs["operating_speeds"] = "40.0 55.0 28.0 95.5"
    (line,) = (
        str(part)
        for part in CampbellDiagram(data).summary().parts
        if str(part).startswith("operating speeds of the model file")
    )
    assert line.partition(": ")[2].split("; ") == [
        "40 rad/s is met by none of these orders",
        "55 rad/s is met by order 5 (branch 1)",
        "28 rad/s is met by none of these orders",
        "95.5 rad/s is not among the speeds asked for",
    ]
    data.attrs["operating_speeds"] = ""
    assert "operating" not in str(CampbellDiagram(data).summary())


def test_a_column_of_near_misses_stands_only_where_there_are_some() -> None:
    data = campbell_dataset()
    assert "nearest" in str(CampbellDiagram(data).summary())
    met = data.isel(critical=[0, 2])
    assert "nearest" not in str(CampbellDiagram(met).summary())
