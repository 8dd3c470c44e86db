"""``kinematics --motors``: motors of a catalogue against closed forms and own quadratures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import simpson

import flexmech
from flexmech.modelfile import CatalogueMotor
from tests.support.command import MODELS, run_command

PACKER = MODELS.parent / "tests" / "data" / "packer.toml"
HEAD = "name,rated_torque (N m),peak_torque (N m),max_speed (rpm),inertia (kg cm^2)"
ROWS = """\
strong,10,24,3000,4.5,10,1,320
weak,5,12,3000,1.2,10,1,210
geared,2.4,7.2,6000,0.6,,3,260
slow,8,20,1000,3,10,1,280
light,8,20,2000,0.3,10,1,280
"""
CATALOGUE = f"{HEAD},max_inertia_ratio,gear_ratio,price (EUR)\n{ROWS}"
ALUMINIUM = flexmech.Material(70e9, 2700.0)
LENGTH, HEIGHT, WIDTH = 0.5, 10e-3, 20e-3


def arm() -> flexmech.Mechanism:
    section = flexmech.BeamSection.rectangle(ALUMINIUM, HEIGHT, WIDTH)
    return flexmech.Mechanism(flexmech.RotatingArm(LENGTH), {"arm": section})


def of(data: object, name: str, motor: str) -> float:
    return float(data[f"candidate_{name}"].sel(candidate=motor))  # type: ignore[index]


def test_torque_of_an_arm_under_a_law_is_that_of_its_closed_form() -> None:
    """A cycloid accelerates by 2 pi h/T^2 sin(2 pi t/T); arm and rotor take torque for it."""
    travel, time, dwell, gear, rotor = np.radians(120), 0.15, 0.1, 4.0, 2e-4
    law = flexmech.LawDrive("cycloid", travel, time, dwell=dwell)
    motor = CatalogueMotor("M", 1.0, 3.0, 100.0, rotor, gear)
    data = flexmech.kinematics(arm(), law, motors=[motor]).dataset
    mass = 2700.0 * LENGTH * HEIGHT * WIDTH
    inertia = mass * (LENGTH**2 / 3 + HEIGHT**2 / 12)
    peak = (inertia / gear + rotor * gear) * 2 * np.pi * travel / time**2
    moving = np.sqrt(time / (time + dwell))
    assert of(data, "peak_torque", "M") == pytest.approx(peak, rel=1e-4)
    assert of(data, "rms_torque", "M") == pytest.approx(peak * moving / np.sqrt(2), rel=1e-4)
    assert of(data, "peak_speed", "M") == pytest.approx(gear * 2 * travel / time, rel=1e-6)
    assert of(data, "inertia_ratio", "M") == pytest.approx(inertia / (rotor * gear**2), rel=1e-6)


def test_the_catalogue_is_judged_and_the_smallest_named(tmp_path: Path) -> None:
    """At constant speed the rotor takes no torque: own quadrature of the torque in drive.csv."""
    catalogue = tmp_path / "motors.csv"
    catalogue.write_text(CATALOGUE, encoding="utf-8")
    ended = run_command(tmp_path, "kinematics", PACKER, "--motors", catalogue, "--no-plots")
    assert ended.exit_code == 0, ended.stderr
    first, second = ended.stdout.splitlines()[:2]
    assert first.startswith("The smallest of 5 motors that suffices is geared, if links are rigid")
    assert "RMS torque 2.03 of 2.40 N m" in first
    assert "speed 3600 of 6000 rpm" in first
    assert "weak fails by RMS torque, peak torque" in second
    assert "slow fails by speed" in second
    assert "light fails by ratio of inertias" in second

    found, drive = ended.table("motor_candidates"), ended.table("drive")
    torque = drive["torque_Nm"]
    rms = np.sqrt(simpson(torque**2) / (len(torque) - 1))
    gear = found["gear_ratio"]
    np.testing.assert_allclose(found["rms_torque_Nm"], rms / gear, rtol=1e-6)
    np.testing.assert_allclose(found["peak_torque_Nm"], np.abs(torque).max() / gear, rtol=1e-3)
    np.testing.assert_allclose(found["peak_speed_rad_s"], gear * 40 * np.pi, rtol=1e-9)
    np.testing.assert_allclose(found["allowed_speed_rad_s"][0], 100 * np.pi, rtol=1e-9)
    assert found["suffices"].tolist() == ["True", "False", "True", "False", "False"]
    assert found["used"][3] == pytest.approx(1.2, rel=1e-9), "by its speed"


def test_the_ratio_of_inertias_is_that_under_the_same_motor() -> None:
    """By another way there: the equation of the shaft that a motor turns."""
    mechanism = flexmech.load_mechanism(MODELS / "slider_crank.toml")
    inertia, gear = 2e-4, 2.0
    motor = flexmech.TorqueMotor((0.0, 400.0), (0.4, 0.0), gear_ratio=gear, inertia=inertia)
    under = flexmech.kinematics(mechanism, flexmech.MotorDrive(motor)).dataset
    stated = float(under["sizing_value"][under["sizing_quantity"] == "inertia_ratio"][0])
    listed = CatalogueMotor("M", 9.0, 9.0, 900.0, inertia, gear)
    data = flexmech.kinematics(mechanism, 100.0, motors=(listed,)).dataset
    assert of(data, "inertia_ratio", "M") == pytest.approx(stated, rel=1e-5)


def test_where_none_suffices_the_nearest_is_named(tmp_path: Path) -> None:
    catalogue = tmp_path / "motors.csv"
    catalogue.write_text(f"{HEAD}\na,1,2,3000,1\nb,5,15,3000,1\n", encoding="utf-8")
    ended = run_command(tmp_path, "kinematics", PACKER, "--motors", catalogue, "--no-plots")
    assert ended.stdout.startswith("None of 2 motors suffices; b comes nearest")


@pytest.mark.parametrize(
    ("table", "words", "named"),
    [
        (f"{HEAD}\n", (), "no motor below"),
        (f"{HEAD}\na,1,2,3000,1\na,2,3,3000,1\n", (), "a stands twice"),
        (f"{HEAD}\na,1,2,3000\n", (), "line 2 has 4 fields"),
        (f"{HEAD}\na,one,2,3000,1\n", (), "line 2: rated_torque: got 'one N m'"),
        (f"{HEAD}\na,-1,2,3000,1\n", (), "line 2: rated_torque"),
        (f"{HEAD}\n,1,2,3000,1\n", (), "line 2: name is empty"),
        (HEAD.replace(" (rpm)", "") + "\na,1,2,3000,1\n", (), "max_speed has no unit"),
        (HEAD.replace("(rpm)", "(kg)") + "\na,1,2,3000,1\n", (), "line 2: max_speed"),
        (
            HEAD.replace(",inertia (kg cm^2)", "") + "\na,1,2,3000\n",
            (),
            "column inertia is missing",
        ),
        (f"{HEAD}\na,1,2,3000,1\n", ("--speed", "0"), "at rest"),
        (f"{HEAD}\na,1,2,3000,1\n", ("--crank-acceleration", "3"), "one run"),
    ],
)
def test_what_is_no_catalogue_is_refused_in_a_line(
    table: str, words: tuple[str, ...], named: str, tmp_path: Path
) -> None:
    catalogue = tmp_path / "motors.csv"
    catalogue.write_text(table, encoding="utf-8")
    ended = run_command(tmp_path, "kinematics", PACKER, "--motors", catalogue, *words)
    assert ended.exit_code == 2
    assert ended.stderr.startswith("error: --motors: ")
    assert named in ended.stderr
    assert ended.stderr.count("\n") == 1
