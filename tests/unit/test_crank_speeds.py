"""Crank speeds: with the unit that was typed, or those of the model file, in every form."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import flexmech
from flexmech.analyses.crank_speeds import CAMPBELL, GREATEST, STABILITY, rad_per_s, told_speeds
from flexmech.cli import app
from flexmech.errors import InputError, nearest, slips
from flexmech.modelfile import mechanism_from_toml, template
from flexmech.units import ANGULAR_SPEED, parse_quantity, to_si

RPM = np.pi / 30
UNITS = {"rad/s": 1.0, "rpm": RPM, "rps": 2 * np.pi, "deg/s": np.pi / 180}
ALUMINIUM = flexmech.example_model("aluminium_fourbar")


def with_speeds(*speeds: str) -> flexmech.Mechanism:
    listed = ", ".join(f'"{speed}"' for speed in speeds)
    text = re.sub(r"crank_speeds = .*", f"crank_speeds = [{listed}]", template("four-bar"))
    return mechanism_from_toml(text)


@pytest.fixture(scope="module")
def mechanism() -> flexmech.Mechanism:
    return with_speeds("20 rad/s", "300 rpm")


# --- the unit of a model file -------------------------------------------------------------------


def test_the_unit_of_the_last_speed_is_kept(mechanism: flexmech.Mechanism):
    assert mechanism.speed_unit == "rpm"
    assert mechanism.operating_speeds == (20.0, parse_quantity("300 rpm", ANGULAR_SPEED))
    assert with_speeds("300 rpm", "20 rad/s").speed_unit == "rad/s"
    assert with_speeds().speed_unit == "rad/s"
    assert "operating speeds: 190.986, 300 rpm" in mechanism.described()


@pytest.mark.parametrize("unit", UNITS)
def test_it_is_written_back(unit: str):
    own = with_speeds("7 rad/s", f"12.3 {unit}")
    written = own.to_toml()
    assert f'"12.3 {unit}"' in written
    again = mechanism_from_toml(written)
    assert (again, again.speed_unit) == (own, unit)


def test_what_is_no_unit_of_speeds_is_refused(mechanism: flexmech.Mechanism):
    with pytest.raises(InputError, match=r"^speed_unit: got '1.0 mm'"):
        replace(mechanism, speed_unit="mm")


# --- one form for all -------------------------------------------------------------------------


@given(st.floats(-1e5, 1e5), st.sampled_from(sorted(UNITS)))
def test_a_number_and_its_unit_are_the_quantity_that_is_typed(number: float, unit: str):
    written = f"{number:f}"
    speed = to_si(float(written), unit, ANGULAR_SPEED)
    assert speed == parse_quantity(f"{written} {unit}", ANGULAR_SPEED)
    assert speed == pytest.approx(float(written) * UNITS[unit], rel=1e-14)
    assert rad_per_s([[float(written)]], unit).tolist() == [[speed]]
    assert rad_per_s(number, None) == number


def check_speed(speed: float, unit: str) -> None:
    """A speed in rad/s, typed in a unit, against itself."""
    own = with_speeds("1 rad/s")
    number = speed / UNITS[unit]
    found = flexmech.kinematics(own, number, speed_unit=unit).dataset
    same = flexmech.kinematics(own, speed).dataset
    np.testing.assert_allclose(found["driving_torque"], same["driving_torque"], rtol=1e-9)
    assert (found.attrs["speed_unit"], same.attrs["speed_unit"]) == (unit, "rad/s")
    assert found.attrs["crank_speed"] == pytest.approx(speed, rel=1e-14)
    requests = (
        flexmech.ResponseRequest(number, speed_unit=unit).drive.speed,
        flexmech.RunningHammerRequest(number, speed_unit=unit).speed,
        flexmech.ComparisonRequest(number, speed_unit=unit).crank_speed,
        flexmech.KinematicsRequest(crank_speed=number, speed_unit=unit).speed_of(own),
    )
    assert requests == pytest.approx((speed,) * 4, rel=1e-14)


@pytest.mark.parametrize(
    ("speed", "unit"), [(20.0, "rad/s"), (0.5, "rpm"), (50.0, "rps"), (7.3, "deg/s")]
)
def test_speeds_in_any_unit_give_the_same_numbers(speed: float, unit: str):
    check_speed(speed, unit)


@pytest.mark.thorough
@settings(deadline=None)
@given(st.floats(0.5, 50.0), st.sampled_from(sorted(UNITS)))
def test_any_speeds_in_any_unit_give_the_same_numbers(speed: float, unit: str):
    check_speed(speed, unit)


def maps(engine: object, speeds: list[float] | None, unit: str | None) -> list[flexmech.Result]:
    """Results of all functions that take several speeds."""
    turn = np.radians([0.0, 120.0, 240.0])
    few = {"modes": 1, "speed_unit": unit}
    found: list[flexmech.Result] = [
        flexmech.moving_frequencies(engine, turn, speeds, **few),
        flexmech.campbell(engine, speeds, crank_angles=turn, **few),
        flexmech.stability(engine, speeds, prestress="axial", **few),
    ]
    if speeds is not None:
        found.append(flexmech.speed_sweep(engine, speeds, **few))
    return found


def test_maps_read_their_speeds_in_the_unit_that_is_given(mechanism: flexmech.Mechanism):
    engine = flexmech.ReferenceEngine(mechanism, elements=2)
    typed = maps(engine, [100.0, 200.0], "rpm")
    for found, same in zip(typed, maps(engine, [100 * RPM, 200 * RPM], None), strict=True):
        assert found.dataset["crank_speed"].values == pytest.approx([100 * RPM, 200 * RPM])
        assert (found.dataset.attrs["speed_unit"], same.dataset.attrs["speed_unit"]) == (
            "rpm",
            "rad/s",
        )
        for name, values in same.dataset.data_vars.items():
            if values.dtype.kind == "f":
                np.testing.assert_allclose(
                    found.dataset[name], values, rtol=1e-6, atol=1e-9, err_msg=str(name)
                )


def test_a_report_reads_its_speeds_in_the_unit_that_is_given(mechanism: flexmech.Mechanism):
    request = flexmech.ReportRequest([0.0, 190.0], include=("kinematics",), speed_unit="rpm")
    own, *found = flexmech.report_results(mechanism, request).all
    assert own.stem == "check"
    assert [each.dataset.attrs["crank_speed"] for each in found] == pytest.approx([190 * RPM])
    assert found[0].dataset.attrs["speed_unit"] == "rpm"
    # Speeds that are left out are the file's, those given are in rad/s all the same.
    mixed = flexmech.ReportRequest(include=("campbell",), campbell_speeds=[0.0, 5.0, 10.0], modes=1)
    diagram = flexmech.report_results(mechanism, mixed).all[1].dataset
    assert diagram["crank_speed"].values == pytest.approx([0.0, 5.0, 10.0])
    assert diagram.attrs["speed_unit"] == "rpm"


def test_a_drive_is_in_rad_per_s_and_takes_no_unit():
    drive = flexmech.ConstantSpeed(20.0, run_up_time=0.1)
    assert flexmech.ResponseRequest(drive).drive is drive
    for beside in ({"speed_unit": "rpm"}, {"run_up_time": 0.1}):
        with pytest.raises(InputError, match="a ConstantSpeed is in rad/s and has its own run-up"):
            flexmech.ResponseRequest(drive, **beside)
    typed = flexmech.ResponseRequest(300.0, speed_unit="rpm", run_up_time=0.1)
    assert typed.drive == flexmech.ConstantSpeed(to_si(300.0, "rpm", ANGULAR_SPEED), 0.1)
    assert replace(typed, revolutions=1.0).drive == typed.drive
    with pytest.raises(InputError, match="the request has its own; give it there"):
        flexmech.response(ALUMINIUM and with_speeds("1 rad/s"), typed, speed_unit="rpm")


# --- speeds that nobody typed -------------------------------------------------------------------


def test_maps_take_the_speeds_of_the_mechanism(mechanism: flexmech.Mechanism):
    greatest = mechanism.operating_speeds[1]
    frequencies, diagram, stability = maps(mechanism, None, None)
    assert frequencies.dataset["crank_speed"].values == pytest.approx([0.0, 20.0, greatest])
    for found, first in ((diagram, 0.0), (stability, 0.5)):
        speeds = found.dataset["crank_speed"].values
        assert (speeds.min(), speeds.max()) == pytest.approx((first * greatest, 1.5 * greatest))
        # The operating speed is one of them.
        assert np.abs(speeds - greatest).min() < 1e-9 * greatest
    assert {each.dataset.attrs["speed_unit"] for each in (frequencies, diagram, stability)} == {
        "rpm"
    }


def test_runs_take_the_greatest_speed_whichever_way_it_turns():
    own = with_speeds("-300 rpm", "10 rad/s", "100 rpm")
    run = flexmech.response(own, flexmech.ResponseRequest(revolutions=0.05, samples=60))
    assert run.dataset.attrs["crank_speed"] == pytest.approx(-300 * RPM)
    assert run.dataset.attrs["speed_unit"] == "rpm"
    assert flexmech.kinematics(own).dataset.attrs["crank_speed"] == pytest.approx(-300 * RPM)


def test_without_a_speed_the_remedy_is_named():
    own = with_speeds()
    for ask in (flexmech.campbell, flexmech.stability, flexmech.response):
        with pytest.raises(InputError, match=r'names no crank speed; .*crank_speeds = \["300 rpm"'):
            ask(own)
    assert flexmech.kinematics(own).dataset.attrs["crank_speed"] == 0.0


def test_which_speeds_were_taken_is_told(mechanism: flexmech.Mechanism):
    assert told_speeds(mechanism, GREATEST(mechanism)) == "speed of the model file: 300 rpm"
    assert told_speeds(mechanism, CAMPBELL(mechanism)) == "speeds of the model file: 0 to 450 rpm"
    assert told_speeds(mechanism, STABILITY(mechanism)) == (
        "speeds of the model file: 150 to 450 rpm"
    )
    few = rad_per_s([0.0, 1.0, 2.0, 3.0, 4.0], "rpm")
    assert told_speeds(mechanism, few) == "speeds of the model file: 0, 1, 2, 3 and 4 rpm"
    assert told_speeds(mechanism, rad_per_s(np.arange(6.0), "rpm")).endswith("0 to 5 rpm")
    assert told_speeds(mechanism, rad_per_s([123.4567], "rpm")).endswith("123.457 rpm")
    assert told_speeds(with_speeds(), few[:1]) == "speeds, for the model names none: 0 rad/s"
    for usual in (CAMPBELL, STABILITY):  # smooth curves, and no long wait
        assert 20 <= usual.count <= 100


# --- on the command line ------------------------------------------------------------------------


def run(*arguments: object) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, [str(each) for each in arguments])
    return result.exit_code, result.stdout, result.stderr


@pytest.fixture
def model(tmp_path: Path) -> Path:
    file = tmp_path / "fast.toml"
    assert run("new", "four-bar", file)[0] == 0
    return file


QUICK = ("--engine", "reference", "--no-plots")


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (
            ("campbell", "--angles", "0:360:60", "--modes", "1"),
            "speeds of the model file: 0 to 450",
        ),
        (("frequencies", "--angles", "0:360:60"), "speeds of the model file: 0, 95.493 and 300"),
        (("response", "--revolutions", "0.05"), "speed of the model file: 300"),
        (("stability", "--prestress", "axial", "--elements", "2", "--modes", "1"), "150 to 450"),
    ],
)
def test_commands_take_the_speeds_of_the_model_file_and_say_so(
    asked: tuple[str, ...], said: str, model: Path, tmp_path: Path
):
    code, printed, errors = run(asked[0], model, *asked[1:], *QUICK, "--out", tmp_path / "out")
    assert code == 0, errors
    assert f"{said} rpm" in printed.splitlines()[0]
    (stored,) = (tmp_path / "out").glob("*.nc")
    (found,) = flexmech.stored_results(stored.parent).all
    assert found.dataset.attrs["speed_unit"] == "rpm"


def test_kinematics_and_an_impact_on_the_running_linkage_take_it_too(model: Path, tmp_path: Path):
    code, printed, _ = run("kinematics", model, "--no-plots", "--out", tmp_path / "out")
    assert (code, printed.splitlines()[0]) == (0, "speed of the model file: 300 rpm")
    running = ("hammer", "--running", model, *QUICK, "--elements", "2", "--prestress", "axial")
    asked = ("--damping-ratio", "10%", "--bandwidth", "60", "--out", tmp_path / "out")
    code, printed, errors = run(*running, *asked)
    assert (code, printed.splitlines()[0]) == (0, "speed of the model file: 300 rpm"), errors


@pytest.mark.parametrize("command", ["campbell", "stability", "response", "export"])
def test_a_file_without_a_speed_is_refused_with_the_remedy(command: str, model: Path):
    text = model.read_text(encoding="utf-8")
    model.write_text(re.sub("crank_speeds = .*", "", text), encoding="utf-8")
    code, printed, errors = run(command, model)
    assert (code, printed) == (2, "")
    option = "--speed" if command in ("response", "export") else "--speeds"
    assert f"error: {option}: is left out, and the model names no crank speed; give it" in errors


def test_rotation_terms_are_refused_in_the_words_that_were_typed(model: Path):
    code, _, errors = run("stability", model, "--no-rotation-terms")
    assert code == 2
    assert "No such option: --no-rotation-terms" in errors


# --- words that are nearly right ----------------------------------------------------------------


@pytest.mark.parametrize(("typed", "meant"), [("rmp", "rpm"), ("rda/s", "rad/s"), ("prs", "rps")])
def test_swapped_letters_come_first(typed: str, meant: str):
    with pytest.raises(InputError, match=f"did you mean '{meant}'"):
        parse_quantity(f"1500{typed}", ANGULAR_SPEED)


def test_units_of_other_kinds_are_told_as_before():
    from flexmech.units import FORCE, LENGTH

    assert parse_quantity("1e12 N", FORCE) == 1e12
    for text, dimension, said in (
        ("5 mn", FORCE, "did you mean 'MN'"),
        ("5 foot-long", LENGTH, "is unknown; write a length, for example"),
    ):
        with pytest.raises(InputError, match=said):
            parse_quantity(text, dimension)


words = st.text("abc", max_size=6)


@given(words, words)
def test_slips_are_a_distance(first: str, second: str):
    assert slips(first, second) == slips(second, first) >= abs(len(first) - len(second))
    assert (slips(first, second) == 0) == (first == second)


@given(words, words)
def test_a_swap_of_neighbours_is_one_slip(first: str, second: str):
    assert slips(f"{first}xy{second}", f"{first}yx{second}") == 1
    assert slips(f"{first}x{second}", first + second) == 1


def test_the_fewest_slips_decide_among_words_that_share_most_letters():
    known = ["rps", "rpx", "rpy", "rpz", "rpm"]
    assert nearest("rmp", known) == "rpm"  # the fifth
    assert nearest("qqq", known) == ""
    assert nearest("x" * 10_000 + "rpm", known) == ""
    long = "link_" + 60 * "a"
    assert nearest(long + "b", [long]) == long
