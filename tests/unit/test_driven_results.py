"""Results under a law of motion: kinematics over time, and the run with its rest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import flexmech
from flexmech import (
    ConstantSpeed,
    InputError,
    Kinematics,
    KinematicsRequest,
    LawDrive,
    ReferenceEngine,
    Response,
    ResponseRequest,
    kinematics,
    plots,
    response,
)
from flexmech.analyses.response.residual import envelope
from flexmech.cli import app
from flexmech.report.panels.kinematics import kinematics_panel
from tests.support.figure_checks import check_layout, check_texts
from tests.support.strategies import fourbar
from tests.unit.driven_data import LAW, driven_dataset, driven_kinematics, driven_run

pytestmark = pytest.mark.usefixtures("rough_pictures")

KEYS = 'law = "cycloid"\ntravel = "120 deg"\ntime = "0.15 s"\ndwell = "0.1 s"'


@pytest.fixture
def model(tmp_path: Path) -> Path:
    mechanism = fourbar(drive=LAW, damping_time=1e-5, shaft_inertia=1e-4)
    file = tmp_path / "model.toml"
    file.write_text(mechanism.to_toml())
    return file


def run(*arguments: str | Path) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    return result.exit_code, result.stdout, result.stderr


def power_line() -> str:
    power = driven_kinematics().dataset["driving_power"].values
    return f"The shaft gives {power.min():.4g} to {power.max():.4g} W."


class TestKinematics:
    def test_is_over_time(self) -> None:
        data = driven_kinematics().dataset
        time = data["time"].values
        assert time[[0, -1]] == pytest.approx([0.0, 0.25])
        np.testing.assert_array_equal(data["crank_angle"], LAW.crank_angle(time))
        np.testing.assert_array_equal(data["crank_speed_over_time"], LAW.crank_speed(time))
        np.testing.assert_allclose(
            data["shaft_inertia_torque"], 1e-4 * LAW.crank_acceleration(time)
        )
        np.testing.assert_allclose(
            data["driving_power"], data["driving_torque"] * data["crank_speed_over_time"]
        )

    def test_states_are_those_of_the_accelerated_crank(self) -> None:
        """At each instant the state is that of a crank with this speed and acceleration."""
        data = driven_kinematics().dataset
        for number in (100, 300, 420):
            one = data.isel(time=number)
            asked = KinematicsRequest(
                [float(one["crank_angle"])],
                float(one["crank_speed_over_time"]),
                crank_acceleration=float(one["crank_acceleration"]),
            )
            state = kinematics(fourbar(shaft_inertia=1e-4), asked).dataset.isel(crank_angle=0)
            for name in ("joint_force", "driving_torque", "shaking_force", "shaking_moment"):
                np.testing.assert_allclose(one[name], state[name], rtol=1e-9, atol=1e-9)

    def test_the_drive_gives_back_what_it_has_given(self) -> None:
        """From rest to rest without weight the work of the shaft is nothing."""
        data = driven_kinematics().dataset
        work = np.trapezoid(data["driving_power"], data["time"])
        assert abs(work) < 1e-6 * float(abs(data["driving_power"]).max())

    def test_extremes_are_found_between_the_samples(self) -> None:
        data = driven_kinematics().dataset
        own = data.isel(extreme=data["extreme_quantity"].values == "driving_torque")
        assert float(own["greatest"][0]) >= float(data["driving_torque"].max())
        when = float(own["greatest_time"][0])
        assert float(own["greatest_angle"][0]) == pytest.approx(float(LAW.crank_angle(when)))
        fine = np.linspace(when - 1e-4, when + 1e-4, 201)
        motion = LAW.motion(fourbar().linkage, fine)
        torque = fourbar().inverse_dynamics(motion, fine).driving_torque
        assert torque.max() == pytest.approx(float(own["greatest"][0]), rel=1e-8)

    def test_words_tables_and_pictures(self, tmp_path: Path) -> None:
        result = driven_kinematics()
        summary = result.summary()
        assert summary.table is not None
        assert "in 0.25 s" in summary.table.title
        assert "under cycloid, 120 deg in 0.15 s, dwell 0.1 s" in summary.table.title
        assert any("with the shaft's own inertia" in str(line) for line in summary.details)
        assert power_line() in summary.answer
        assert "peak_driving_power" in {one.name for one in summary.numbers}
        for table in result.tables().values():
            assert list(table.columns[:2]) == ["time_s", "crank_angle_deg"]
        assert {"law", "drive", "kinematics"} <= set(result.figures())
        for figure in result.figures().values():
            check_layout(figure)
            check_texts(figure)
        result.save(tmp_path)
        assert Kinematics.load(tmp_path / "kinematics.nc").dataset.identical(result.dataset)

    def test_the_report_tells_it_in_words(self, tmp_path: Path) -> None:
        """Its pictures are over the crank angle."""
        driven_kinematics().save(tmp_path)
        panel = kinematics_panel(flexmech.stored_results(tmp_path))
        assert panel is not None
        assert panel.plots == ()
        assert power_line() in panel.answer

    def test_a_constant_speed_is_one_of_its_cases(self) -> None:
        found = kinematics(fourbar(drive=ConstantSpeed(20.0))).dataset
        wanted = kinematics(fourbar(), 20.0).dataset
        np.testing.assert_array_equal(found["driving_torque"], wanted["driving_torque"])

    def test_a_drive_stands_alone(self) -> None:
        with pytest.raises(InputError, match="a law of motion has its own angles, speed"):
            KinematicsRequest(crank_speed=20.0, drive=LAW)
        with pytest.raises(InputError, match="a law of motion has its own angles, speed"):
            KinematicsRequest(np.array([0.0, 1.0]), drive=LAW)

    def test_from_the_command_line(self, model: Path, tmp_path: Path) -> None:
        code, shown, _ = run("kinematics", model, "--out", tmp_path / "out")
        assert code == 0
        assert "drive of the model file: cycloid, 120 deg in 0.15 s" in shown
        drive = pd.read_csv(tmp_path / "out" / "drive.csv")
        assert drive["power_W"].abs().max() == pytest.approx(
            float(abs(driven_kinematics().dataset["driving_power"]).max())
        )
        assert (tmp_path / "out" / "law.png").exists()
        code, shown, _ = run("kinematics", model, "--speed", "20", "--out", tmp_path / "at_speed")
        assert code == 0
        assert "at 20 rad/s" in shown


class TestResponse:
    def test_is_told_as_a_law(self) -> None:
        result = driven_run()
        summary = result.summary()
        assert summary.table is not None
        assert summary.table.title.startswith("peaks under cycloid, 120 deg in 0.15 s, dwell 0.1")
        assert "rings by" in summary.answer[-1]
        assert "after 0.1 s of rest" in summary.answer[-1]
        names = {one.name for one in summary.numbers}
        assert {"peak_driving_power", "residual_amplitude", "residual_amplitude_at_end"} <= names
        told = "\n".join(map(str, summary.details))
        assert "drive: cycloid, 120 deg in 0.15 s, dwell 0.1 s; crank speed up to 27.92" in told
        assert "the shaft's own inertia takes up to 0.058487 N m" in told
        assert "modes after the stop: 45." in told
        assert "--revolutions" not in told

    def test_power_is_torque_times_speed(self) -> None:
        data = driven_dataset()
        wanted = data["driving_torque"] * data["crank_speed_over_time"]
        np.testing.assert_allclose(data["driving_power"], wanted.transpose("engine", "time"))
        peak = float(data["peak_driving_power"][0])
        assert peak == pytest.approx(float(abs(wanted).max()), rel=1e-3)

    def test_the_residual_envelope_is_that_of_the_rest(self) -> None:
        data = driven_dataset().isel(engine=0)
        rest = data["time"].values >= LAW.law_time
        assert np.isnan(data["residual_envelope"].values[~rest]).all()
        bent = data["deflection"].values[rest]
        # Damped links ring less and less.
        found = data["residual_envelope"].values[rest]
        assert (data["residual_amplitude_at_end"] < data["residual_amplitude"]).all()
        np.testing.assert_allclose(found[0], np.ptp(bent[:24], axis=0) / 2, rtol=0.05)

    def test_pictures_and_files(self, tmp_path: Path) -> None:
        result = driven_run()
        figures = result.figures()
        assert {"running_law", "residual"} <= set(figures)
        for figure in figures.values():
            check_layout(figure)
            check_texts(figure)
        result.save(tmp_path)
        table = pd.read_csv(tmp_path / "response.csv")
        assert {"crank_speed_rad_s", "driving_power_W", "rocker_residual_envelope_m"} <= set(
            table.columns
        )
        assert Response.load(tmp_path / "response.nc").summary().answer == result.summary().answer

    def test_what_is_drawn_is_the_dataset(self) -> None:
        data = driven_dataset()
        figure = plots.plot_law(data)
        lines = [axes.lines for axes in figure.axes[:4]]
        drawn = [
            next(one for one in own if np.size(one.get_xdata()) > 9).get_ydata() for own in lines
        ]
        np.testing.assert_allclose(drawn[0], np.degrees(data["crank_angle"]))
        np.testing.assert_allclose(drawn[1], data["crank_speed_over_time"])
        np.testing.assert_allclose(drawn[2], data["crank_acceleration"])
        np.testing.assert_allclose(drawn[3], data["driving_power"].isel(engine=0))

    def test_without_a_dwell_no_rest_is_seen(self) -> None:
        law = LawDrive("cycloid", 1.0, 0.1)
        request = ResponseRequest(law, samples=120, step=2e-4)
        found = response(ReferenceEngine(fourbar(), 2), request)
        assert "residual_envelope" not in found.dataset
        told = "\n".join(map(str, found.summary().details))
        assert "residual vibration: none is seen without a dwell; give one in the drive" in told

    def test_a_mechanism_runs_by_its_drive(self, model: Path, tmp_path: Path) -> None:
        asked = "--engine", "reference", "--elements", "2", "--samples", "120", "--step", "0.0002"
        code, shown, _ = run("response", model, *asked, "--out", tmp_path / "out")
        assert code == 0
        assert "drive of the model file: cycloid" in shown
        assert "After the stop the" in shown

    @pytest.mark.parametrize(
        ("asked", "message"),
        [
            (["--run-up", "0.1"], "a LawDrive is in rad/s and has its own run-up"),
            (["--start", "periodic"], "a periodic start needs a constant crank speed"),
        ],
    )
    def test_what_does_not_go_with_a_law(
        self, model: Path, tmp_path: Path, asked: list[str], message: str
    ) -> None:
        code, _, told = run("response", model, *asked, "--out", tmp_path / "out")
        assert code == 2
        [line] = told.splitlines()
        assert message in line


def test_an_envelope_is_half_of_what_follows() -> None:
    time = np.linspace(0.0, 1.0, 1001)
    wave = 3.0 + np.exp(-time) * np.cos(2 * np.pi * 50 * time)
    found = envelope(wave[:, None], 21)[:, 0]
    by_hand = [np.ptp(wave[n : n + 21]) / 2 for n in range(len(wave) - 20)]
    np.testing.assert_allclose(found[: len(by_hand)], by_hand, rtol=1e-14)
    np.testing.assert_array_equal(found[len(by_hand) :], by_hand[-1])
