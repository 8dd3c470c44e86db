"""``flexmech response`` under a law, with a shaper, and under a motor; what a move leaves."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

import flexmech
from flexmech import (
    DcMotor,
    ExudynEngine,
    InputError,
    InputShaper,
    LawDrive,
    MotorDrive,
    ReferenceEngine,
    ShapedDrive,
    Shaping,
    SpeedControl,
    TableDrive,
    TorqueMotor,
    motor_run,
    response,
)
from flexmech.analyses import ResponseRequest, amplitudes_after_stop
from flexmech.modelfile import mechanism_from_toml
from tests.support.command import Ended
from tests.support.journeys import Journey, tells
from tests.support.strategies import fourbar

LAW = LawDrive("cycloid", np.radians(120), 0.15, dwell=0.1, start_angle=0.3)
HELD = TableDrive((0.0, 0.1, 0.2, 0.3), (0.0, 0.1, 0.4, 0.9), ends="held", dwell=0.2)
SMALL = ("--engine", "reference", "--elements", "2", "--samples", "240", "--step", "0.4 ms")


def model(folder: Path, drive: object = LAW) -> Path:
    file = folder / "model.toml"
    mechanism = fourbar(drive=drive, damping_time=1e-5, shaft_inertia=1e-4)
    file.write_text(mechanism.to_toml())
    return file


@pytest.fixture(scope="module")
def journey(tmp_path_factory: pytest.TempPathFactory) -> Journey:
    """A law beside its shaped form."""
    folder = tmp_path_factory.mktemp("law")
    words = (*SMALL, "--shaper", "zv", "--shaped-modes", "1,2")
    return Journey(folder / "out", "response", model(folder), *words, "--no-plots")


@pytest.mark.thorough
def test_a_run_by_a_law_has_its_speed_power_and_rest(journey: Journey) -> None:
    """The envelope of the rest is half of what the deflection swings over the slowest period."""
    table, data = journey.table("response"), journey.result().dataset.isel(engine=0)
    time = table["time_s"]
    assert time[[0, -1]] == pytest.approx([0.0, 0.25])
    assert table["crank_speed_rad_s"] == pytest.approx(LAW.crank_speed(time), abs=1e-7)
    power = table["driving_torque_Nm"] * table["crank_speed_rad_s"]
    assert table["driving_power_W"] == pytest.approx(power, abs=1e-7)
    peak = float(data["peak_driving_power"])
    assert np.abs(power).max() == pytest.approx(peak, rel=1e-2)
    assert journey.number("peak_driving_power") == pytest.approx(peak, rel=1e-3)
    rest = time >= LAW.law_time
    envelope = table["rocker_residual_envelope_m"]
    assert np.isnan(envelope[~rest]).all()
    frequency = float(data["standing_frequency"].min())
    window = round(1 / frequency / (time[1] - time[0]))
    bent = table["rocker_mid_deflection_m"][rest][:window]
    assert envelope[rest][0] == pytest.approx(np.ptp(bent) / 2, rel=0.05)
    # Damped links ring less and less.
    assert (data["residual_amplitude_at_end"] < data["residual_amplitude"]).all()


@pytest.mark.thorough
def test_a_shaped_run_is_a_run_by_the_shaped_law(journey: Journey) -> None:
    """A model file can state one; its delay is printed in ms."""
    data = journey.result().dataset
    times, weights = (
        tuple(data[name].values.tolist()) for name in ("impulse_time", "impulse_weight")
    )
    assert sum(weights) == pytest.approx(1.0)
    shaped = ShapedDrive(LAW, InputShaper(times, weights))
    mechanism = fourbar(damping_time=1e-5, shaft_inertia=1e-4, drive=shaped)
    assert mechanism_from_toml(mechanism.to_toml()).drive == shaped
    asked = ResponseRequest(shaped, samples=240, step=4e-4)
    alone = response(ReferenceEngine(mechanism, 2), asked).dataset
    np.testing.assert_allclose(data["shaped_time"], alone["time"])
    for name in ("deflection", "driving_torque", "crank_angle", "residual_amplitude"):
        scale = float(abs(alone[name]).max())
        np.testing.assert_allclose(data[f"shaped_{name}"], alone[name], atol=1e-9 * scale)
    assert float((data["shaped_residual_amplitude"] / data["residual_amplitude"]).max()) < 0.5
    delay = journey.number("shaper_delay")
    assert delay == pytest.approx(1e3 * data.attrs["shaper_delay"])
    assert "with the ZV shaper for modes 1 and 2" in journey.said["answer"][0]
    assert tells(journey.said["answer"][0], delay)


SWEEP = """
model = "model.toml"
[vary."drive.time"]
values = ["100 ms", "150 ms"]
[outputs]
coupler = { quantity = "residual_amplitude", link = "coupler" }
most = { quantity = "residual_amplitude", mode = 2 }
"""


def test_what_rings_over_the_time_of_a_move_is_an_output_of_sweep(tmp_path, command) -> None:  # type: ignore[no-untyped-def]
    """By the state at the stop it is that of a run that goes on."""
    drive = model(tmp_path)
    (tmp_path / "study.toml").write_text(SWEEP)
    ended: Ended = command("sweep", tmp_path / "study.toml", "--no-plots")
    assert ended.exit_code == 0, ended.stderr
    table = ended.table("designs")
    run = response(
        ReferenceEngine(flexmech.load_mechanism(drive), 8), ResponseRequest(samples=240, step=4e-4)
    )
    amplitude = run.dataset["modal_amplitude"].isel(engine=0)
    coupler, most = float(amplitude.sel(mode=1, link="coupler")), float(amplitude.sel(mode=2).max())
    assert table["coupler_m"][1] == pytest.approx(coupler, rel=5e-3)
    assert table["most_m"][1] == pytest.approx(most, rel=5e-3)


def test_a_law_without_a_dwell_shows_no_rest() -> None:
    """The remaining vibration follows from the state at the stop alone."""
    law = LawDrive("cycloid", 1.0, 0.1)
    engine = ReferenceEngine(fourbar(), 1)
    result = response(engine, ResponseRequest(law, samples=100, step=5e-4, modes=2))
    assert "residual_envelope" not in result.dataset
    assert (amplitudes_after_stop(engine, law, 2).max(axis=0) > 0).all()


def test_modes_that_ring_are_shaped_for_where_none_are_chosen() -> None:
    """Those by more than a tenth of what rings most."""
    asked = ResponseRequest(LAW, samples=120, step=8e-4, shaping=Shaping("zv"), modes=3)
    data = response(ReferenceEngine(fourbar(), 2), asked).dataset
    amplitude = data["modal_amplitude"].max("link").values[0]
    ringing = np.flatnonzero(amplitude > 0.1 * amplitude.max()) + 1
    assert data.attrs["shaped_modes"] == ",".join(map(str, ringing))


def test_a_blow_is_for_an_engine_that_simulates() -> None:
    """A table that is held at its end jumps there by its last speed, 6 rad/s."""
    assert HELD.law.blow == pytest.approx((0.3, -6.0))
    asked = ResponseRequest(HELD, samples=40, step=1e-3)
    with pytest.raises(InputError, match="reference engine"):
        response(ReferenceEngine(fourbar(), 1), asked)
    told = response(ExudynEngine(fourbar(), 1), asked).summary().details
    assert any("its speed jumps by -6 rad/s" in str(line) for line in told)


@pytest.mark.thorough
def test_a_run_under_a_motor_has_its_speed_torque_and_current(tmp_path: Path) -> None:
    motor = MotorDrive(DcMotor(1.2, 0.06, 12.0, gear_ratio=10.0, inertia=2e-5))
    words = ("--revolutions", "0.2", "--samples", "60", "--modes", "2", "--step", "0.4 ms")
    asked = ("--engine", "reference", "--elements", "2", *words, "--no-plots")
    journey = Journey(tmp_path / "out", "response", model(tmp_path, motor), *asked)
    table = journey.table("response")
    speed = table["crank_speed_rad_s"] + table["crank_speed_fluctuation_rad_s"]
    assert table["motor_speed_rad_s"] == pytest.approx(10.0 * speed, rel=1e-6)
    assert table["motor_current_A"] == pytest.approx(table["motor_torque_Nm"] / 0.06, rel=1e-6)
    voltage = 1.2 * table["motor_current_A"] + 0.06 * table["motor_speed_rad_s"]
    assert voltage == pytest.approx(12.0, rel=1e-5)
    settled = motor_run(flexmech.load_mechanism(tmp_path / "model.toml")).settled
    assert settled is not None
    assert tells(journey.said["answer"][0], settled.mean_speed)
    journey.result()


CURVE = 'torque_speed = [["0 rpm", "12 N m"], ["1500 rpm", "0 N m"]]'
DC = (
    'kind = "dc", resistance = "1.2 ohm", inductance = "1 mH", torque_constant = "0.06 N m/A", '
    'voltage = "24 V"'
)
CONTROL = 'speed_control = { kp = "0.5 V s/rad", ki = "2 V/rad", target = "10 rad/s" }'
STATED = {
    'speed = "-20 rad/s"\nrun_up_time = "0.2 s"\nstart_angle = "0.5 rad"': flexmech.ConstantSpeed(
        -20.0, 0.2, 0.5
    ),
    'law = "cycloid"\ntravel = "2 rad"\ntime = "0.15 s"\ndwell = "0.1 s"\nmoves = 4\n'
    "forth_and_back = true": LawDrive("cycloid", 2.0, 0.15, 0.1, 4, True),
    'law = "modified sine"\ntravel = "1 rad"\nmaster_angle = "90 deg"\nmaster_dwell = "270 deg"\n'
    'master_speed = "60 rpm"': LawDrive("modified sine", 1.0, 0.25, 0.75),
    f'motor = {{ {CURVE}, inertia = "2e-4 kg m^2", gear_ratio = 10 }}\ntime = "0.5 s"': MotorDrive(
        TorqueMotor((0.0, 50 * np.pi), (12.0, 0.0), inertia=2e-4, gear_ratio=10.0), time=0.5
    ),
    f"motor = {{ {DC} }}\n{CONTROL}\nstart_angle = '1 rad'": MotorDrive(
        DcMotor(1.2, 0.06, 24.0, 1e-3), SpeedControl(0.5, 2.0, 10.0), 1.0
    ),
    f"motor = {{ {DC}, initial_current = '0 A' }}": MotorDrive(
        DcMotor(1.2, 0.06, 24.0, 1e-3, initial_current=0.0)
    ),
    'motor = { torque_speed = [["0 rad/s", "-0.1 N m"]], inertia = "1 kg m^2", '
    'coupling_stiffness = "5 N m/rad", coupling_damping = "0.1 N m s/rad" }': MotorDrive(
        TorqueMotor((0.0,), (-0.1,), inertia=1.0, coupling_stiffness=5.0, coupling_damping=0.1)
    ),
}


@pytest.mark.parametrize("keys", STATED, ids=range(len(STATED)))
def test_a_drive_of_a_model_file_is_read_and_written(keys: str) -> None:
    text = f"{fourbar().to_toml()}\n[drive]\n{keys}\n"
    mechanism, drive = mechanism_from_toml(text), STATED[keys]
    assert type(mechanism.drive) is type(drive)
    if isinstance(drive, MotorDrive):
        assert mechanism.drive == drive
    else:
        time = np.linspace(0.0, 0.4, 101)
        angle = mechanism.drive.crank_angle(time)  # type: ignore[union-attr]
        np.testing.assert_allclose(angle, drive.crank_angle(time), rtol=1e-12, atol=1e-12)
    assert mechanism_from_toml(mechanism.to_toml()) == mechanism


@pytest.mark.parametrize(
    ("words", "remedy"),
    [
        ("--shaper zz", "zvd"),
        ("--shaper zv --speed '10 rad/s'", "law that stops"),
        ("--shaper zv --shaft free", "choose shaft prescribed"),
        ("--shaped-modes 1", "add --shaper"),
        ("--shaper zv --shaped-modes 0", "counted from 1"),
        ("--shaper ei --tolerated 2", "between 0 and 1"),
        ("--shaper zv --tolerated 2%", "belongs to the shaper ei"),
        ("--move-times '0:1:0.1 s'", "flexmech sweep: vary drive.time"),
        ("--run-up 0.1", "run-up"),
        ("--start periodic", "constant crank speed"),
    ],
)
def test_what_does_not_go_with_a_law_is_refused(words: str, remedy: str, tmp_path, command) -> None:  # type: ignore[no-untyped-def]
    file = model(tmp_path)
    ended: Ended = command("response", file, "--engine", "reference", *shlex.split(words))
    assert (ended.exit_code, ended.files) == (2, [])
    assert ended.stderr.count("\n") == 1
    assert remedy in ended.stderr


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"speed": LAW, "shaping": "zv"}, "give a flexmech.Shaping"),
        ({"speed": LawDrive("cycloid", 1.0, 0.1), "shaping": Shaping("zv")}, "give a dwell"),
    ],
)
def test_requests_that_cannot_be_are_refused(asked: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        response(ReferenceEngine(fourbar(), 1), ResponseRequest(**asked))  # type: ignore[arg-type]
    for wrong, told in (({"modes": ()}, "one or more"), ({"modes": (1, 1)}, "each once")):
        with pytest.raises(InputError, match=told):
            Shaping("zv", **wrong)  # type: ignore[arg-type]
