"""Crank speeds and angles: in any unit, as lists and ranges, or those of the model file."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import flexmech
from flexmech import InputError
from flexmech.modelfile import mechanism_from_toml, template
from tests.support.command import run_command

RPM = np.pi / 30
UNITS = {"rad/s": 1.0, "rpm": RPM, "rps": 2 * np.pi, "deg/s": np.pi / 180}
TURN = np.radians([0.0, 120.0, 240.0])


def with_speeds(*speeds: str) -> flexmech.Mechanism:
    listed = ", ".join(f'"{speed}"' for speed in speeds)
    text = re.sub(r"crank_speeds = .*", f"crank_speeds = [{listed}]", template("four-bar"))
    return mechanism_from_toml(text)


def kinematics(folder, *words):
    ended = run_command(folder, "kinematics", "models/steel_fourbar.toml", *words, "--no-plots")
    assert ended.exit_code == 0, ended.stderr
    return ended


# --- what is typed ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("typed", "angles"),
    [
        ("0:1:0.333333", [0, 0.333333, 0.666666, 1]),
        ("0,1.5 rad", [0, 85.94366926962348]),
        ("-30,0,60,120.5", [-30, 0, 60, 120.5]),
    ],
)
def test_angles_are_lists_or_ranges_of_degrees(typed, angles, tmp_path):
    found = kinematics(tmp_path / "out", "--speed", "1", "--angles", typed).table("drive")
    np.testing.assert_allclose(found["crank_angle_deg"], angles, rtol=1e-9)


@pytest.mark.parametrize(
    ("typed", "speeds", "unit"),
    [
        ("0,50,100 rpm", [0, 50 * RPM, 100 * RPM], "rpm"),
        ("300 rpm, 10 rad/s ,0", [0, 10, 300 * RPM], "rad/s"),
        ("0 rpm:1 rps:30 rpm", [0, 30 * RPM, 60 * RPM], "rpm"),
    ],
)
def test_one_unit_at_the_end_is_that_of_all_speeds(typed, speeds, unit, command):
    words = ("--angles", "0", "--modes", "1", "--elements", "1", "--engine", "reference")
    model = "models/rotating_arm.toml"
    ended = command("frequencies", model, *words, "--speeds", typed, "--no-plots")
    found = ended.table("frequencies")["crank_speed_rad_s"]
    assert found == pytest.approx(speeds, rel=1e-9)
    (stored,) = flexmech.stored_results(ended.folder).all
    assert stored.dataset.attrs["speed_unit"] == unit


# --- in Python ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("speed", "unit"), [(20.0, "rad/s"), (0.5, "rpm"), (50.0, "rps"), (7.3, "deg/s")]
)
def test_a_speed_in_any_unit_gives_the_same_numbers(speed, unit):
    mechanism, number = with_speeds("1 rad/s"), speed / UNITS[unit]
    found = flexmech.kinematics(mechanism, number, speed_unit=unit).dataset
    same = flexmech.kinematics(mechanism, speed).dataset
    np.testing.assert_allclose(found["driving_torque"], same["driving_torque"], rtol=1e-9)
    assert (found.attrs["speed_unit"], same.attrs["speed_unit"]) == (unit, "rad/s")
    requests = (
        flexmech.analyses.ResponseRequest(number, speed_unit=unit).drive.speed,
        flexmech.analyses.RunningHammerRequest(number, speed_unit=unit).crank_speed,
        flexmech.analyses.ComparisonRequest("record.csv", number, speed_unit=unit).crank_speed,
        found.attrs["crank_speed"],
    )
    assert requests == pytest.approx((speed,) * 4, rel=1e-14)


def maps(mechanism, speeds, unit):
    """Results of the functions that take several speeds."""
    engine, few = flexmech.ReferenceEngine(mechanism, 1), {"modes": 1, "speed_unit": unit}
    yield flexmech.moving_frequencies(engine, TURN, speeds, **few)
    yield flexmech.campbell(engine, speeds, crank_angles=TURN, **few)


@pytest.mark.thorough
def test_a_map_reads_its_speeds_in_the_unit_that_is_given():
    mechanism = with_speeds("300 rpm")
    pairs = zip(
        maps(mechanism, [100.0, 200.0], "rpm"),
        maps(mechanism, [100 * RPM, 200 * RPM], None),
        strict=True,
    )
    for found, same in pairs:
        assert found.dataset["crank_speed"].values == pytest.approx([100 * RPM, 200 * RPM])
        units = (found.dataset.attrs["speed_unit"], same.dataset.attrs["speed_unit"])
        assert units == ("rpm", "rad/s")
        for name, values in same.dataset.data_vars.items():
            if values.dtype.kind == "f":
                np.testing.assert_allclose(found.dataset[name], values, rtol=1e-6, atol=1e-9)


def test_a_drive_is_in_rad_per_s_and_takes_no_unit():
    drive = flexmech.ConstantSpeed(20.0, run_up_time=0.1)
    assert flexmech.analyses.ResponseRequest(drive).drive is drive
    for beside in ({"speed_unit": "rpm"}, {"run_up_time": 0.1}):
        with pytest.raises(InputError, match="ConstantSpeed"):
            flexmech.analyses.ResponseRequest(drive, **beside)
    typed = flexmech.analyses.ResponseRequest(300.0, speed_unit="rpm", run_up_time=0.1)
    assert typed.drive == flexmech.ConstantSpeed(10 * np.pi, 0.1)
    assert replace(typed, revolutions=1.0).drive == typed.drive
    with pytest.raises(InputError, match="speed_unit"):
        replace(with_speeds("1 rad/s"), speed_unit="mm")


# --- speeds that nobody typed -------------------------------------------------------------------


def test_a_map_takes_the_speeds_of_the_model():
    """Frequencies at rest and at each; a Campbell diagram up to 1.5 times the greatest."""
    mechanism = with_speeds("20 rad/s", "300 rpm")
    greatest = 300 * RPM
    frequencies, diagram = maps(mechanism, None, None)
    assert frequencies.dataset["crank_speed"].values == pytest.approx([0.0, 20.0, greatest])
    speeds = diagram.dataset["crank_speed"].values
    assert (speeds.min(), speeds.max()) == pytest.approx((0.0, 1.5 * greatest))
    assert np.abs(speeds - greatest).min() < 1e-9 * greatest
    for found in (frequencies, diagram):
        assert found.dataset.attrs["speed_unit"] == "rpm"


def test_a_run_takes_the_greatest_speed_whichever_way_it_turns():
    mechanism = with_speeds("-300 rpm", "10 rad/s", "100 rpm")
    request = flexmech.analyses.ResponseRequest(revolutions=0.02, samples=60, modes=1)
    run = flexmech.response(flexmech.ReferenceEngine(mechanism, 1), request)
    assert run.dataset.attrs["crank_speed"] == pytest.approx(-300 * RPM)
    assert flexmech.kinematics(mechanism).dataset.attrs["crank_speed"] == pytest.approx(-300 * RPM)
    assert flexmech.kinematics(with_speeds()).dataset.attrs["crank_speed"] == 0.0


def test_a_command_says_which_speed_of_the_model_it_took(command, tmp_path):
    model = tmp_path / "fast.toml"
    model.write_text(template("four-bar"), encoding="utf-8")
    ended = command("kinematics", model, "--no-plots")
    assert "speed of the model file: 300 rpm" in ended.stdout
    words = ("--angles", "0:360:60", "--modes", "1", "--elements", "1", "--no-plots")
    ended = command("campbell", model, *words)
    assert "speeds of the model file: 0 to 450 rpm" in ended.stdout
