"""Motors in model files and results: what is stated, what is told and drawn, what is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from flexmech import (
    DcMotor,
    InputError,
    Kinematics,
    KinematicsRequest,
    MotorDrive,
    ResponseRequest,
    SpeedControl,
    TorqueMotor,
    kinematics,
    load_mechanism,
    motor_run,
    plots,
)
from flexmech.cli import app
from flexmech.modelfile import mechanism_from_toml, template
from tests.support.figure_checks import check_layout, check_texts
from tests.support.strategies import fourbar
from tests.unit.motor_data import MOTOR, motor_kinematics, motor_response

BASE = template("four-bar")
CURVE = 'torque_speed = [["0 rpm", "12 N m"], ["1500 rpm", "0 N m"]]'
DC = (
    'kind = "dc", resistance = "1.2 ohm", inductance = "1 mH", torque_constant = "0.06 N m/A", '
    'voltage = "24 V"'
)
CONTROL = 'speed_control = { kp = "0.5 V s/rad", ki = "2 V/rad", target = "10 rad/s" }'
STATED = {
    f'motor = {{ {CURVE}, inertia = "2e-4 kg m^2", gear_ratio = 10 }}\ntime = "0.5 s"': MotorDrive(
        TorqueMotor((0.0, 50 * np.pi), (12.0, 0.0), inertia=2e-4, gear_ratio=10.0), time=0.5
    ),
    f"motor = {{ {DC} }}\n{CONTROL}\nstart_angle = '1 rad'": MotorDrive(
        DcMotor(1.2, 0.06, 24.0, 1e-3), SpeedControl(0.5, 2.0, 10.0), 1.0
    ),
    'motor = { torque_speed = [["0 rad/s", "-0.1 N m"]], inertia = "1 kg m^2", '
    'coupling_stiffness = "5 N m/rad", coupling_damping = "0.1 N m s/rad" }': MotorDrive(
        TorqueMotor((0.0,), (-0.1,), inertia=1.0, coupling_stiffness=5.0, coupling_damping=0.1)
    ),
}


def model(keys: str) -> str:
    return f"{BASE}\n[drive]\n{keys}\n"


def test_a_target_is_told_in_its_own_unit() -> None:
    keys = f"motor = {{ {DC} }}\n{CONTROL.replace('10 rad/s', '190 rpm')}"
    drive = mechanism_from_toml(model(keys)).drive
    assert isinstance(drive, MotorDrive)
    assert drive.words.endswith("speed control to 190 rpm")
    assert ResponseRequest(drive).shown_unit == "rpm"
    assert KinematicsRequest(drive=drive).shown_unit(fourbar()) == "rpm"
    assert "190 rpm" in str(drive.to_table())
    with pytest.raises(InputError, match=r"speed_unit: .*mm"):
        SpeedControl(0.5, 2.0, 10.0, "mm")


@pytest.mark.parametrize("keys", STATED, ids=range(len(STATED)))
def test_what_is_stated_is_read_and_written(keys: str) -> None:
    mechanism = mechanism_from_toml(model(keys))
    assert mechanism.drive == STATED[keys]
    again = mechanism_from_toml(mechanism.to_toml())
    assert again == mechanism
    assert any(line.startswith("drive: ") for line in mechanism.described())


WRONG = {
    "motor = { }": "drive.motor: torque_speed is missing; add it",
    f'motor = {{ {CURVE}, inertia = "-1 kg m^2" }}': "drive.motor.inertia: must be zero or",
    'motor = { torque_speed = [["9 rpm", "1 N m"], ["0 rpm", "2 N m"]] }': "give its rows with "
    "increasing speeds",
    'motor = { torque_speed = [["0 rpm", "1 N m"], ["9 rpm", "2 N m"]] }': "the torque rises to 2 "
    "N m in its last row",
    'motor = { torque_speed = [["0 rpm"]] }': "torque_speed[0]: got 1 values; give speed",
    'motor = { torque_speed = [["0 N", "1 N m"]] }': "drive: motor: torque_speed[0]: got '0 N'",
    f'motor = {{ {CURVE}, voltage = "3 V" }}': "voltage belongs to a DC motor; add kind",
    f'motor = {{ {CURVE}, coupling_stiffness = "3 N m/rad" }}': "needs a rotor behind it",
    'motor = { kind = "dc", voltage = "3 V" }': "resistance is missing; a DC motor needs it",
    f"motor = {{ {DC} }}\nlaw = 'cycloid'": "drive: give either speed, or law with travel and time",
    f"motor = {{ {DC} }}\ntravel = '3 deg'": "drive: travel belongs to law, and not to motor",
    f"{CONTROL}\nspeed = '3 rad/s'": "drive: speed_control belongs to motor, and not to speed",
    f"motor = {{ {CURVE} }}\n{CONTROL}": "drive: speed_control: kp: got '0.5 V s/rad'",
    f"motor = {{ {DC} }}\nspeed_control = {{ kp = '0 V s/rad', target = '3 rpm' }}": "kp must be "
    "positive",
}


@pytest.mark.parametrize("keys", WRONG, ids=range(len(WRONG)))
def test_what_is_wrong_is_told_in_one_line(keys: str, tmp_path: Path) -> None:
    file = tmp_path / "model.toml"
    file.write_text(model(keys))
    result = CliRunner().invoke(app, ["kinematics", str(file), "--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    [line] = result.stderr.splitlines()
    assert WRONG[keys] in line
    assert not (tmp_path / "out").exists()


class TestKinematics:
    def test_tells_the_motor(self) -> None:
        found = motor_kinematics()
        told = found.summary()
        assert told.answer[0].startswith("Settled, the motor turns the rigid linkage at ")
        names = {one.name for one in told.numbers}
        wanted = {"settled_crank_speed", "speed_fluctuation", "peak_motor_torque"}
        assert wanted | {"peak_motor_power", "peak_motor_current"} <= names
        lines = "\n".join(map(str, told.details))
        assert "motor on its own shaft: torque up to " in lines
        assert "coefficient of fluctuation (greatest less least over mean) " in lines
        settled = motor_run(fourbar(), MOTOR).settled
        assert settled is not None
        by_name = {one.name: one.value for one in told.numbers}
        assert by_name["speed_fluctuation"] == pytest.approx(settled.fluctuation)

    def test_balances_at_the_shaft(self) -> None:
        """Gear times the motor's torque is the linkage's and that of rotor and shaft."""
        data = motor_kinematics().dataset
        needed = data["driving_torque"] + data["shaft_inertia_torque"]
        given = 10.0 * data["motor_torque"]
        np.testing.assert_allclose(given, needed, atol=1e-5 * float(abs(needed).max()))
        np.testing.assert_allclose(data["motor_power"], data["motor_torque"] * data["motor_speed"])
        np.testing.assert_allclose(data["motor_current"], data["motor_torque"] / 0.06)

    def test_pictures_and_files(self, tmp_path: Path) -> None:
        found = motor_kinematics()
        figure = found.figures()["motor"]
        check_layout(figure)
        check_texts(figure)
        found.save(tmp_path)
        table = pd.read_csv(tmp_path / "drive.csv")
        np.testing.assert_allclose(table["motor_current_A"], found.dataset["motor_current"])
        again = Kinematics.load(tmp_path / "kinematics.nc")
        assert again.summary().answer == found.summary().answer

    def test_a_stall_is_an_answer(self, tmp_path: Path) -> None:
        file = tmp_path / "model.toml"
        weak = 'motor = { torque_speed = [["0 rpm", "0.03 N m"], ["300 rpm", "0 N m"]] }\n'
        weak += 'start_angle = "280 deg"\n'
        steel = load_mechanism("models/steel_fourbar.toml").to_toml().split("[operation]")[0]
        gravity = '[environment]\ngravity = ["0 m/s^2", "-9.81 m/s^2"]\n'
        file.write_text(f"{steel}\n[drive]\n{weak}\n{gravity}")
        out = str(tmp_path / "out")
        result = CliRunner().invoke(app, ["kinematics", str(file), "--out", out])
        assert result.exit_code == 0
        assert "The motor stalls at " in result.stdout
        run = motor_run(load_mechanism(file))
        assert run.stall is not None
        assert f"{np.degrees(run.stall.crank_angle) % 360:.4g} deg" in result.stdout


class TestResponse:
    def test_tells_and_draws_the_motor(self, tmp_path: Path) -> None:
        found = motor_response()
        told = found.summary()
        assert told.answer[0].startswith("Settled, the motor turns")
        lines = "\n".join(map(str, told.details))
        assert "under the motor; with elastic links it leaves the rigid linkage's angle" in lines
        figure = found.figures()["running_motor"]
        check_layout(figure)
        check_texts(figure)
        found.save(tmp_path)
        table = pd.read_csv(tmp_path / "response.csv")
        speed = table["crank_speed_rad_s"] + table["crank_speed_fluctuation_rad_s"]
        np.testing.assert_allclose(table["motor_speed_rad_s"], 10.0 * speed, rtol=1e-6)

    def test_what_is_drawn_is_the_dataset(self) -> None:
        data = motor_response().dataset
        figure = plots.plot_motor(data)
        drawn = [
            next(one for one in axes.lines if np.size(one.get_xdata()) > 9).get_ydata()
            for axes in figure.axes[:4]
        ]
        np.testing.assert_allclose(drawn[1], data["motor_torque"].isel(engine=0))
        np.testing.assert_allclose(drawn[2], data["motor_power"].isel(engine=0))


def test_turns_of_a_run_under_a_motor_are_asked_for(tmp_path: Path) -> None:
    file = tmp_path / "motor.toml"
    curve = 'torque_speed = [["0 rpm", "3 N m"], ["191 rpm", "0 N m"]], inertia = "0.05 kg m^2"'
    file.write_text(model(f"motor = {{ {curve} }}"))
    asked = ["--revolutions", "0.05", "--engine", "reference", "--elements", "2", "--modes", "2"]
    out = str(tmp_path / "out")
    found = CliRunner().invoke(app, ["response", str(file), *asked, "--no-plots", "--out", out])
    assert found.exit_code == 0, found.output
    assert "counts for nothing" not in found.output


def test_a_run_of_a_motor_is_a_drive_of_kinematics() -> None:
    run = motor_run(fourbar(), MOTOR)
    found = kinematics(fourbar(), KinematicsRequest(drive=run)).dataset
    np.testing.assert_array_equal(found["crank_speed_over_time"][-1], run.crank_speed(run.duration))
