"""Damping by modal strain energy as a part of the result: dataset, files, lines and picture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from typer.testing import CliRunner

from flexmech.analyses import (
    MovingFrequencies,
    moving_frequencies,
    solve_modes,
    strain_energy_damping,
)
from flexmech.analyses.frequencies.damping import strain_energy_lines
from flexmech.analyses.frequencies.formulation import RunningStates
from flexmech.analyses.frequencies.modal_damping import StrainEnergyDamping, links_without_loss
from flexmech.cli.application import app
from flexmech.errors import InputError
from flexmech.linear_system import Engine
from flexmech.mechanism import Mechanism
from flexmech.multibody import ExudynEngine
from flexmech.plots import SERIES_STYLES, plot_modal_damping
from flexmech.reference import ReferenceEngine
from flexmech.sections import SpecificDamping
from tests.support.figure_checks import check_layout, legend_texts, lines_in
from tests.support.plot_data import FULL_TURN, frequency_dataset
from tests.support.strategies import fourbar

ANGLES = np.radians([0.0, 60.0, 120.0, 240.0, 300.0, 360.0])
SPEEDS = [0.0, 20.0]
LOSS = {
    "crank": SpecificDamping(0.02, 0.05, 0.3),
    "coupler": SpecificDamping(0.1, 0.07, 0.2),
}
MODEL = str(Path(__file__).parents[2] / "models" / "aluminium_fourbar.toml")


def losing(damping_time: float = 0.0, **loss: SpecificDamping) -> Mechanism:
    mechanism = fourbar(damping_time=damping_time)
    sections = {k: replace(s, specific_damping=loss.get(k)) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


@pytest.fixture(scope="module")
def result() -> MovingFrequencies:
    return moving_frequencies(ReferenceEngine(losing(**LOSS), 3), ANGLES, SPEEDS, modes=3)


@pytest.fixture(scope="module")
def dataset() -> xr.Dataset:
    """Invented numbers of two engines over a full turn."""
    return with_damping(frequency_dataset())


def with_damping(dataset: xr.Dataset) -> xr.Dataset:
    frequency = dataset["frequency"]
    ratio = 1e-3 + 2e-5 * frequency / frequency["mode"] ** 2
    ratio.attrs["links_without_data"] = "rocker"
    return dataset.assign(strain_energy_damping=ratio)


class TestDataset:
    def test_ratio_stands_beside_each_frequency(self, result: MovingFrequencies) -> None:
        ratio = result.dataset["strain_energy_damping"]
        assert ratio.dims == result.dataset["frequency"].dims
        assert ratio.attrs == {
            "units": "1",
            "long_name": "damping ratio by modal strain energy",
            "links_without_data": "rocker",
        }
        engine = ReferenceEngine(losing(**LOSS), 3, component_modes=False)
        for speed, values in zip(SPEEDS, ratio.values[0], strict=True):
            alone = strain_energy_damping(engine, ANGLES, speed, modes=3)
            assert values == pytest.approx(alone, rel=1e-4)
        assert np.ptp(ratio.values[0], axis=(0, 1)).min() > 1e-4

    def test_it_is_left_out_where_no_section_tells_a_loss(self) -> None:
        nothing = SpecificDamping(0.0, 0.0, 0.0)
        mechanism = losing(damping_time=1e-6, crank=nothing)
        assert links_without_loss(mechanism) == ("crank", "coupler", "rocker")
        engine = ReferenceEngine(mechanism, 2)
        found = moving_frequencies(engine, ANGLES[:2], [0.0])
        assert "strain_energy_damping" not in found.dataset
        assert list(found.tables()) == ["frequencies"]
        assert StrainEnergyDamping.of(engine) is None
        with pytest.raises(InputError, match="no section of this mechanism has specific damping"):
            strain_energy_damping(engine, 0.0)

    def test_it_does_not_change_what_was_there(self, result: MovingFrequencies) -> None:
        plain = moving_frequencies(ReferenceEngine(losing(), 3), ANGLES, SPEEDS, modes=3)
        own = ["strain_energy_damping", "strain_energy_damping_discretisation_error"]
        xr.testing.assert_identical(plain.dataset, result.dataset.drop_vars(own))

    def test_its_error_is_that_against_a_far_finer_mesh(self, result: MovingFrequencies) -> None:
        """Not less than half of it, nor more than twice as much, of modes that do not veer."""
        name = "strain_energy_damping"
        error = result.dataset[f"{name}_discretisation_error"]
        angles = error["check_angle"].values
        for speed, estimated in zip(SPEEDS, error.values[0], strict=True):
            here, fine = (
                strain_energy_damping(
                    ReferenceEngine(losing(**LOSS), elements, component_modes=False),
                    *(angles, speed),
                    modes=3,
                )
                for elements in (3, 24)
            )
            actual = np.abs(here - fine)
            assert actual.max() > 1e-8
            assert estimated.max(axis=0) == pytest.approx(actual.max(axis=0), rel=1.0, abs=1e-7)
            assert np.all(actual.max(axis=0) < 2 * estimated.max(axis=0) + 1e-7)

    def test_kelvin_voigt_times_stay_what_frequencies_are_solved_with(self) -> None:
        tau = 1e-5
        viscous = ReferenceEngine(losing(tau, **LOSS), 3)
        data = moving_frequencies(viscous, [0.0, 1.0], [0.0], modes=2).dataset
        omega_tau = 2 * np.pi * data["frequency"].values * tau
        assert data["damping_ratio"].values == pytest.approx(omega_tau / 2, rel=1e-3)
        undamped = ReferenceEngine(losing(**LOSS), 3)
        alone = strain_energy_damping(undamped, [0.0, 1.0], modes=2)
        assert data["strain_energy_damping"].values[0, 0] == pytest.approx(alone, rel=1e-4)

    @pytest.mark.parametrize("prestress", ["none", "equilibrium"])
    def test_reduction_does_not_change_it(self, prestress: str) -> None:
        options = {"modes": 3, "prestress": prestress}
        ratios = [
            strain_energy_damping(
                ReferenceEngine(losing(**LOSS), 4, component_modes=reduced), ANGLES, 20.0, **options
            )
            for reduced in (True, False)
        ]
        assert ratios[0] == pytest.approx(ratios[1], rel=1e-4)

    @pytest.mark.parametrize(
        ("one", "other", "tolerance"),
        [("euler", "ancf", 1e-4), ("timoshenko", "geometrically-exact", 1e-2)],
    )
    def test_engines_agree(self, one: str, other: str, tolerance: float) -> None:
        """Exudyn's linear beam converges in second order, from 7e-3 with 16 elements."""
        mechanism = losing(**LOSS, rocker=SpecificDamping(0.05, 0.02, 0.4))
        first = strain_energy_damping(ReferenceEngine(mechanism, 8, one), 0.5, 20.0, modes=3)
        second = strain_energy_damping(ExudynEngine(mechanism, 16, other), 0.5, 20.0, modes=3)
        assert second == pytest.approx(first, rel=tolerance)


class TestRunningStates:
    def test_states_of_the_equilibrium_lose_what_the_equilibrium_loses(self) -> None:
        engine = ExudynEngine(losing(**LOSS), 2, component_modes=False)
        system = engine.linear_system([0.5, 2.0], 20.0)
        modes, losses = solve_modes(system, 3), StrainEnergyDamping.of(engine)
        assert losses is not None
        states = engine.stressed_links(system.motion, "equilibrium").displacement
        still = losses.ratio(system, modes, "equilibrium")
        assert losses.ratio(system, modes, "none", states) == pytest.approx(still, rel=1e-6)
        assert np.abs(losses.ratio(system, modes, "none") / still - 1).max() > 1e-3

    def test_a_map_along_the_trajectory_loses_in_its_states(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """The states given are those of straight links."""

        class Straight:
            def __init__(self, engine: Engine) -> None:
                self.sizes = [link.size for link in engine.links]

            def at(self, crank_angle: np.ndarray) -> list[np.ndarray]:
                return [np.zeros((len(crank_angle), size)) for size in self.sizes]

        monkeypatch.setattr(RunningStates, "of", lambda engine, speed: Straight(engine))
        engine = ExudynEngine(losing(**LOSS), 2)
        levels = ("trajectory", "none", "equilibrium")
        found, straight, bowed = (
            moving_frequencies(engine, [0.5, 2.0], [20.0], modes=2, prestress=level)
            .dataset["strain_energy_damping"]
            .values
            for level in levels
        )
        assert found == pytest.approx(straight, rel=1e-6)
        assert np.abs(found / bowed - 1).max() > 1e-3


class TestFiles:
    def test_csv_has_a_row_for_each_ratio(self, result: MovingFrequencies, tmp_path: Path) -> None:
        paths = result.save(tmp_path)
        assert [p.name for p in paths] == ["frequencies.csv", "damping.csv", "frequencies.nc"]
        lines = paths[1].read_text(encoding="utf-8").splitlines()
        assert lines[0] == "engine,crank_speed_rad_s,crank_angle_deg,mode,damping_ratio"
        ratio = result.dataset["strain_energy_damping"].values[0]
        assert len(lines) == 1 + ratio.size
        for line, (s, a, m) in zip(lines[1:], np.ndindex(ratio.shape), strict=True):
            engine, *values = line.split(",")
            expected = [SPEEDS[s], np.degrees(ANGLES[a]), m + 1, ratio[s, a, m]]
            assert engine == "reference"
            assert [float(v) for v in values] == pytest.approx(expected, rel=1e-9)
        assert paths[0].read_text(encoding="utf-8").splitlines()[0].count(",") == 6
        xr.testing.assert_identical(MovingFrequencies.load(paths[2]).dataset, result.dataset)

    def test_command_reports_and_writes_it(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        for other in ("plot_frequencies", "plot_mode_shapes"):
            monkeypatch.setattr(f"flexmech.plots.{other}", lambda dataset, **choices: Figure())
        loads = [losing(**LOSS), losing()]
        monkeypatch.setattr("flexmech.modelfile.load_mechanism", lambda path: loads.pop(0))
        arguments = [
            "frequencies", MODEL, "--engine", "reference", "--elements", "2", "--modes", "2",
            "--speeds", "0", "--angles", "0,90,180", "--out", str(tmp_path),
        ]  # fmt: skip
        done = CliRunner().invoke(app, [*arguments, "--details"])
        assert done.exit_code == 0, done.output
        assert (
            "damping by modal strain energy: 0.518 % to 0.555 % over the crank angles (mode 1), 0.0"
        ) in done.stdout
        assert "no specific damping is known of rocker" in done.stdout
        assert (tmp_path / "damping.csv").is_file()
        assert (tmp_path / "damping.png").read_bytes().startswith(b"\x89PNG")
        again = CliRunner().invoke(app, [*arguments, "--no-plots"])
        assert again.exit_code == 0, again.output
        assert "strain energy" not in again.stdout
        (stale,) = [line for line in again.stdout.splitlines() if "earlier run" in line]
        assert "damping.csv" in stale
        assert "damping.png" in stale


class TestLines:
    def test_ranges_engines_and_links_without_data(self, dataset: xr.Dataset) -> None:
        dataset = dataset.isel(mode=slice(2)).copy(deep=True)
        ratio = dataset["strain_energy_damping"]
        ratio[:] = 4e-3
        ratio[0, 1, 3, 0], ratio[1, 2, 4, 0], ratio[1, 0, 0, 1] = 3.456e-3, 5.2e-3, 4.5e-3
        assert strain_energy_lines(dataset) == [
            "damping by modal strain energy: 0.346 % to 0.520 % over the crank angles and speeds "
            "(mode 1), 0.400 % to 0.450 % (mode 2)",
            "damping by modal strain energy: engines differ by at most 1.2e-03",
            "damping by modal strain energy: no specific damping is known of rocker; taken as "
            "without loss",
        ]

    def test_no_more_is_said_than_is_known(self, dataset: xr.Dataset) -> None:
        one = dataset.isel(engine=[0]).copy()
        one["strain_energy_damping"].attrs["links_without_data"] = ""
        assert len(strain_energy_lines(one)) == 1
        assert strain_energy_lines(frequency_dataset()) == []


class TestPicture:
    def test_one_panel_a_speed_and_one_line_a_mode_in_percent(self, dataset: xr.Dataset) -> None:
        before = dataset.copy(deep=True)
        figure = plot_modal_damping(dataset)
        assert [axes.get_title("left") for axes in figure.axes] == [
            "0 rad/s", "10 rad/s", "20 rad/s",
        ]  # fmt: skip
        assert figure.get_supylabel() == "Damping ratio (%)"
        assert figure.axes[-1].get_xlabel() == "Crank angle (deg)"
        for speed, axes in enumerate(figure.axes):
            for mode in range(4):
                (line,) = lines_in(axes, mode, len(FULL_TURN))
                ratio = dataset["strain_energy_damping"].values[0, speed, :, mode]
                np.testing.assert_allclose(line, 100 * ratio, rtol=1e-12)
        modes = {f"mode {n}" for n in (1, 2, 3, 4)}
        assert set(legend_texts(figure)) == modes | {"reference (euler)", "exudyn (ancf)"}
        check_layout(figure)
        xr.testing.assert_identical(dataset, before)

    def test_markers_are_the_second_engine(self, dataset: xr.Dataset) -> None:
        axes = plot_modal_damping(dataset).axes[2]
        marks = [line for line in axes.lines if line.get_linestyle() == "None"]
        assert len(marks) == 4
        for mode, line in enumerate(marks):
            places = np.isin(np.round(np.degrees(dataset["crank_angle"]), 9), line.get_xdata())
            wanted = dataset["strain_energy_damping"].values[1, 2, places, mode]
            np.testing.assert_allclose(line.get_ydata(), 100 * wanted, rtol=1e-12)

    def test_a_line_breaks_off_where_another_branch_takes_the_mode(self) -> None:
        crossing = with_damping(frequency_dataset(crossing=True, engines=("reference",)))
        axes = plot_modal_damping(crossing).axes[0]
        pieces = [line for line in axes.lines if line.get_color() == SERIES_STYLES[0].color]
        shown = np.array([np.isfinite(line.get_ydata()) for line in pieces])
        assert shown.shape == (2, len(FULL_TURN))
        assert np.all(shown.sum(axis=0) == 1)
        assert np.abs(np.diff(shown[0].astype(int))).sum() == 2
        whole = [line for line in axes.lines if line.get_color() == SERIES_STYLES[2].color]
        assert len(whole) == 1

    def test_of_many_speeds_six_are_drawn(self) -> None:
        speeds = np.arange(0.0, 21.0, 2.0)
        many = with_damping(frequency_dataset(speeds, modes=2))
        figure = plot_modal_damping(many)
        titles = [axes.get_title("left") for axes in figure.axes]
        assert len(titles) == 6
        assert (titles[0], titles[-1]) == ("0 rad/s", "20 rad/s")
        check_layout(figure)

    def test_equal_damping_does_not_blow_up_round_off(self, dataset: xr.Dataset) -> None:
        flat = dataset.isel(crank_angle=[5]).copy(deep=True)
        flat["strain_energy_damping"][:] = 4e-3 * (1 + 1e-12 * np.arange(4))
        axes = plot_modal_damping(flat).axes[0]
        low, high = axes.get_ylim()
        assert high - low > 1e-3
        assert all(line.get_marker() not in ("", "None") for line in axes.lines)

    def test_it_refuses_a_result_without_losses(self) -> None:
        with pytest.raises(InputError, match="with specific damping"):
            plot_modal_damping(frequency_dataset())
