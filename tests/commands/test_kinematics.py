"""``flexmech kinematics``: tables, sentences and refusals, at angles, over time, under a motor."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

import flexmech
from flexmech import LawDrive, kinematics, motor_run
from flexmech.analyses import KinematicsRequest
from tests.support.command import MODELS, Ended
from tests.support.journeys import Journey, tells
from tests.support.strategies import arm, fourbar

ALUMINIUM = "models/aluminium_fourbar.toml"
TURN = np.radians(np.arange(0, 361, 30))
COLUMNS = {
    "kinematics": "crank_angle_deg link angle_deg angular_velocity_rad_s "
    "angular_acceleration_rad_s2 centre_x_m centre_y_m centre_ax_m_s2 centre_ay_m_s2 "
    "inertia_force_x_N inertia_force_y_N inertia_moment_Nm",
    "motion": None,
    "forces": "crank_angle_deg joint of on x_N y_N moment_Nm",
    "drive": "crank_angle_deg torque_Nm power_W transmission_angle_deg "
    "reversed_transmission_angle_deg",
    "shaking_force": "crank_angle_deg shaking_force_x_N shaking_force_y_N shaking_moment_Nm",
    "shaking_harmonics": "order shaking_force_x_amplitude_N shaking_force_y_amplitude_N "
    "shaking_force_x_phase_deg shaking_force_y_phase_deg shaking_force_greatest_N "
    "shaking_moment_amplitude_Nm shaking_moment_phase_deg",
    "sizing": "quantity of value unit",
    "forces_lumped": "crank_angle_deg joint of on x_N y_N moment_Nm",
    "drive_lumped": "crank_angle_deg torque_Nm power_W",
    "lumped_masses": "crank_angle_deg link position_m mass_kg ax_m_s2 ay_m_s2 "
    "inertia_force_x_N inertia_force_y_N",
}
LAW = LawDrive("cycloid", np.radians(120), 0.15, dwell=0.1, start_angle=0.3)


@pytest.fixture(scope="module")
def journey(tmp_path_factory: pytest.TempPathFactory) -> Journey:
    """A turn of the aluminium four-bar, its mass distributed and lumped."""
    words = ("--speed", "190 rpm", "--angles", "0:360:30", "--lumped", "1,4,4", "--no-plots")
    point = ("--moment-point", "127 mm,-30 mm")
    folder = tmp_path_factory.mktemp("kinematics") / "out"
    return Journey(folder, "kinematics", ALUMINIUM, *words, *point)


def test_tables_have_their_columns_and_hold_the_result(journey: Journey) -> None:
    rows = {name: journey.table(name) for name in COLUMNS}
    for name, columns in COLUMNS.items():
        if columns:
            assert " ".join(rows[name]) == columns
    lengths = [len(next(iter(table.values()))) for name, table in rows.items() if name != "motion"]
    assert lengths == [39, 52, 13, 13, 11, 12, 52, 13, 156]
    assert (rows["forces"]["joint"][0], rows["forces"]["on"][0]) == ("O2", "crank")
    data = journey.result().dataset
    mechanism = flexmech.load_mechanism(MODELS / "aluminium_fourbar.toml")
    asked = KinematicsRequest(
        190.0, crank_angles=TURN, lumped=(1, 4, 4), moment_point=(0.127, -0.03), speed_unit="rpm"
    )
    assert data.identical(kinematics(mechanism, asked).dataset)
    torque = data["driving_torque"].values
    assert rows["drive"]["torque_Nm"] == pytest.approx(torque, rel=1e-9, abs=1e-12)
    at_a = rows["forces"]["joint"] == "A"
    force = data["joint_force"].sel(joint="A", component="x").values
    assert rows["forces"]["x_N"][at_a] == pytest.approx(force, rel=1e-9)
    moment = data["shaking_moment"].values
    assert rows["shaking_force"]["shaking_moment_Nm"] == pytest.approx(moment, rel=1e-8, abs=1e-12)


def test_the_shaking_moment_is_about_the_point_asked_for(journey: Journey) -> None:
    """Moved by the force from the shaft's axis."""
    mechanism = flexmech.load_mechanism(MODELS / "aluminium_fourbar.toml")
    about = kinematics(mechanism, 190 * np.pi / 30, crank_angles=TURN).dataset
    force = about["shaking_force"]
    moved = about["shaking_moment"] - 0.127 * force.sel(component="y")
    moved = moved - 0.03 * force.sel(component="x")
    found = journey.table("shaking_force")["shaking_moment_Nm"]
    assert found == pytest.approx(moved.values, rel=1e-8, abs=1e-12)


def test_peaks_are_told_with_their_places(journey: Journey) -> None:
    """At speed 190 rpm, beyond those of the table; 4.738 N on the frame."""
    peak = journey.number("peak_shaking_force", "frame")
    table = journey.table("shaking_force")
    size = np.hypot(table["shaking_force_x_N"], table["shaking_force_y_N"]).max()
    assert size <= peak < 1.1 * size
    assert peak == pytest.approx(4.738, abs=1e-3)
    forces = journey.table("forces")
    joint = np.hypot(forces["x_N"], forces["y_N"]).max()
    assert any(
        tells(line, joint) or "greatest joint force" in line for line in journey.said["answer"]
    )


def test_the_answer_of_a_slider_crank(command) -> None:  # type: ignore[no-untyped-def]
    """Its stroke is twice the crank of 150 mm; B's force is across its line."""
    ended: Ended = command("kinematics", "models/slider_crank.toml", "--no-plots")
    assert ended.exit_code == 0
    assert (
        "Slider B has a stroke of 300.0 mm, from 150.0 to 450.0 mm along its line" in ended.stdout
    )
    assert len(ended.stdout.splitlines()) <= 25
    csv = {f"{name}.csv" for name in COLUMNS if "lumped" not in name}
    assert set(ended.files) == csv | {"kinematics.nc", "summary.txt"}
    assert len(ended.table("drive")["power_W"]) == 361
    still = kinematics(flexmech.load_mechanism(MODELS / "slider_crank.toml"), 0.0).summary().answer
    assert "no joint carries a force" in still[1]


def test_an_arm_has_no_transmission_angle_and_round_off_is_told_as_zero(tmp_path, command) -> None:  # type: ignore[no-untyped-def]
    """At constant speed without weight it needs no torque."""
    model = tmp_path / "arm.toml"
    model.write_text(arm(hub_radius=0.2).to_toml())
    ended: Ended = command("kinematics", model, "--angles", "0:90:30", "--speed", "6", "--no-plots")
    assert list(ended.table("drive")) == ["crank_angle_deg", "torque_Nm", "power_W"]
    assert "driving torque is 0 N m" in ended.stdout
    assert "transmission" not in ended.stdout


# --- under a law and under a motor --------------------------------------------------------------


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Journey:
    """By the law of the model file, with the figures."""
    folder = tmp_path_factory.mktemp("law")
    model = folder / "model.toml"
    model.write_text(fourbar(drive=LAW, shaft_inertia=1e-4).to_toml())
    return Journey(folder / "out", "kinematics", model, "--no-plots")


def test_under_a_law_tables_are_over_time(driven: Journey) -> None:
    """The peaks of power are those printed."""
    data = driven.result().dataset
    for name in ("kinematics", "forces", "drive", "shaking_force", "motion"):
        assert list(driven.table(name))[:2] == ["time_s", "crank_angle_deg"]
    drive = driven.table("drive")
    assert drive["time_s"][[0, -1]] == pytest.approx([0.0, 0.25])
    angle = np.degrees(LAW.crank_angle(drive["time_s"]))
    assert drive["crank_angle_deg"] == pytest.approx(angle, abs=1e-6)
    power = data["driving_power"].values
    assert np.abs(drive["power_W"]).max() == pytest.approx(np.abs(power).max(), rel=1e-8)
    (line,) = (line for line in driven.said["answer"] if line.startswith("The shaft gives"))
    # Between the samples as well.
    mechanism, time = fourbar(), np.linspace(0.0, 0.25, 20001)
    motion = LAW.motion(mechanism.linkage, time)
    power = mechanism.inverse_dynamics(motion).driving_torque * motion.crank_speed
    assert tells(line, power.max())
    assert tells(line, power.min())


@pytest.mark.thorough
def test_under_a_motor_its_settled_speed_and_current_are_told(tmp_path: Path) -> None:
    motor = 'motor = { kind = "dc", resistance = "1.2 ohm", torque_constant = "0.06 N m/A", '
    motor += 'voltage = "12 V", gear_ratio = 10, inertia = "2e-5 kg m^2" }'
    model = tmp_path / "model.toml"
    model.write_text(f"{fourbar().to_toml()}\n[drive]\n{motor}\n")
    journey = Journey(tmp_path / "out", "kinematics", model, "--no-plots")
    settled = motor_run(flexmech.load_mechanism(model)).settled
    assert settled is not None
    assert journey.number("speed_fluctuation") == pytest.approx(settled.fluctuation)
    assert journey.number("settled_crank_speed") == pytest.approx(settled.mean_speed, rel=1e-6)
    current = journey.table("drive")["motor_current_A"]
    assert journey.number("peak_motor_current") == pytest.approx(np.abs(current).max(), rel=1e-6)
    assert journey.said["answer"][0].startswith("Settled, the motor turns the rigid linkage at ")
    journey.result()


def test_a_stall_is_an_answer(tmp_path, command) -> None:  # type: ignore[no-untyped-def]
    weak = 'motor = { torque_speed = [["0 rpm", "0.03 N m"], ["300 rpm", "0 N m"]] }\n'
    steel = flexmech.load_mechanism(MODELS / "steel_fourbar.toml").to_toml()
    steel = steel.split("[operation]")[0]
    file = tmp_path / "model.toml"
    gravity = '[environment]\ngravity = ["0 m/s^2", "-9.81 m/s^2"]\n'
    file.write_text(f'{steel}\n[drive]\n{weak}start_angle = "280 deg"\n{gravity}')
    ended: Ended = command("kinematics", file, "--no-plots")
    assert ended.exit_code == 0
    stall = motor_run(flexmech.load_mechanism(file)).stall
    assert stall is not None
    (line,) = (line for line in ended.stdout.splitlines() if "The motor stalls at " in line)
    assert tells(line, np.degrees(stall.crank_angle) % 360)


@pytest.mark.parametrize(
    ("words", "option", "remedy"),
    [
        ("--lumped 1,4", "lumped", "3 links"),
        ("--lumped 1,x,4", "--lumped", "elements of each link"),
        ("--lumped 1,4,2000", "lumped", "1000"),
        ("--moment-point '127 mm'", "--moment-point", "give x and y"),
        ("--moment-point 1,2", "--moment-point", "unit"),
        ("--speed '5 mm'", "--speed", "angular speed"),
        ("--angles 90,0", "--angles", "increasing"),
        ("--crank-acceleration '50 rad/s'", "--crank-acceleration", "rad/s"),
        ("--crank-acceleration 1e12", "--crank-acceleration", "angular acc"),
    ],
)
def test_wrong_options_are_refused(words: str, option: str, remedy: str, command) -> None:  # type: ignore[no-untyped-def]
    ended: Ended = command("kinematics", ALUMINIUM, *shlex.split(words))
    assert (ended.exit_code, ended.files) == (2, [])
    assert ended.stderr.count("\n") == 1
    assert option in ended.stderr
    assert remedy in ended.stderr.replace(option, "", 1)
