"""Elastic linkages under motors and by laws of motion: both engines, closed forms, energies."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from flexmech import (
    ConstantSpeed,
    DcMotor,
    ExudynEngine,
    InputError,
    LawDrive,
    Mechanism,
    MotorDrive,
    ReferenceEngine,
    RotatingArm,
    Shaping,
    SpeedControl,
    TableDrive,
    TorqueMotor,
    response,
)
from flexmech.analyses import ResponseRequest, amplitudes_after_stop
from flexmech.linkages import LAWS
from tests.support.mechanisms import GRAVITY, model, strip

FOUR_BAR = model("aluminium_fourbar")
CURVE = TorqueMotor((0.0, 15.0, 20.0), (0.4, 0.3, 0.0), inertia=5e-4)
DC = DcMotor(1.2, 0.06, 24.0, 1e-3, gear_ratio=10.0, inertia=2e-5)
COUPLING = {"coupling_stiffness": 20.0, "coupling_damping": 1e-3}
STEEP = TorqueMotor((0.0, 20.0), (1.5, 0.0), inertia=5e-3)
THOROUGH = pytest.mark.thorough


def run(
    motor: Any,
    control: Any = None,
    mechanism: Mechanism = FOUR_BAR,
    kinds: Any = (ReferenceEngine, ExudynEngine),
    time: float | None = None,
    **asked: Any,
) -> xr.Dataset:
    drive = MotorDrive(motor, control, time=time) if time else MotorDrive(motor, control)
    request = ResponseRequest(drive, **({"samples": 90, "modes": 2, "step": 1e-4} | asked))
    return response([kind(mechanism, 2) for kind in kinds], request).dataset


def gap(data: xr.Dataset, name: str) -> float:
    first, second = data[name].values
    return float(np.abs(second - first).max() / np.abs(first).max())


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("motor", "control"),
    [
        (CURVE, SpeedControl(0.1, 0.5, 15.0)),
        (replace(CURVE, **COUPLING), None),
        pytest.param(DC, SpeedControl(0.5, 2.0, 15.0), marks=THOROUGH),
        pytest.param(replace(DC, **COUPLING), SpeedControl(0.5, 2.0, 15.0), marks=THOROUGH),
    ],
    ids=["curve with control", "on a coupling", "dc", "dc on a coupling"],
)
def test_both_engines_start_alike_under_a_motor(motor: Any, control: Any) -> None:
    """Elastic links rotate the shaft away from the rigid linkage's angle."""
    data = run(motor, control, time=0.03)
    assert gap(data, "shaft_rotation") < 0.04
    assert gap(data, "deflection") < 0.06
    assert gap(data, "motor_torque") < 0.03
    if motor.coupling_stiffness is not None:
        assert gap(data, "motor_speed") < 2e-3
        assert gap(data, "driving_torque") < 0.01
        return
    speed = data["crank_speed_over_time"] + data["crank_speed_fluctuation"]
    wanted = (motor.gear_ratio * speed).transpose("engine", "time")
    xr.testing.assert_allclose(data["motor_speed"].drop_attrs(), wanted)


@pytest.mark.thorough
def test_the_work_of_the_motor_is_in_the_energies() -> None:
    """The error of the mesh remains: twice the elements leave a quarter of it."""
    request = ResponseRequest(MotorDrive(CURVE, time=0.03), samples=60, modes=2, step=4e-5)
    errors = []
    for elements in (2, 4):
        data = response(ReferenceEngine(FOUR_BAR, elements), request).dataset.isel(engine=0)
        work = float(data["drive_work"][-1])
        assert float(data["motor_power"].integrate("time")) == pytest.approx(work, rel=2e-3)
        errors.append(float(data["energy_error"]))
    assert errors[0] / errors[1] > 3.0
    assert errors[1] < 1e-4


@pytest.mark.thorough
@pytest.mark.parametrize("kind", [ReferenceEngine, ExudynEngine])
def test_a_heavy_flywheel_turns_as_prescribed(kind: Any) -> None:
    """The effect of elastic links on the shaft falls as one over its inertia."""
    away = []
    for inertia in (0.5, 5.0):
        heavy = replace(FOUR_BAR, shaft_inertia=inertia)
        # To 10 rad/s in a twentieth of a second.
        motor = TorqueMotor((0.0,), (200.0 * inertia,))
        data = run(motor, mechanism=heavy, kinds=(kind,), time=0.05, step=5e-5)
        away.append(float(data["peak_shaft_rotation"].item()))
        speed = data["motor_speed"].values[0]
        assert float(np.abs(speed - 200.0 * data["time"].values).max()) < 0.05 / inertia
    assert away[0] / away[1] == pytest.approx(10.0, rel=0.1)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("motor", "gravity", "kinds"),
    [
        (STEEP, (0.0, 0.0), (ExudynEngine,)),
        pytest.param(STEEP, GRAVITY, (ReferenceEngine, ExudynEngine), marks=THOROUGH),
        pytest.param(
            replace(STEEP, coupling_stiffness=300.0, coupling_damping=0.01),
            (0.0, 0.0),
            (ReferenceEngine, ExudynEngine),
            marks=THOROUGH,
        ),
    ],
    ids=["curve", "weight", "on a coupling"],
)
def test_a_run_stays_on_the_settled_motion_that_is_found_directly(
    motor: Any, gravity: Any, kinds: Any
) -> None:
    """To a thousandth of its fluctuation, of which elastic links change a hundredth."""
    mechanism = replace(FOUR_BAR, gravity=gravity)
    asked = {"samples": 180, "step": 2e-4, "revolutions": 1.0, "start": "periodic"}
    data = run(motor, mechanism=mechanism, kinds=kinds, **asked)
    found = float(data.attrs["elastic_settled_fluctuation"])
    assert abs(found / float(data.attrs["settled_fluctuation"]) - 1) > 0.008
    np.testing.assert_allclose(data["last_turn_fluctuation"], found, rtol=1e-3)
    speed = float(data.attrs["elastic_settled_speed"])
    np.testing.assert_allclose(data["last_turn_speed"], speed, rtol=2e-5)
    assert float(data["peak_shaft_rotation"].max()) < 1e-4
    bent = data["deflection"].values
    assert np.abs(bent[:, -1] - bent[:, 0]).max() < 3e-3 * np.abs(bent).max()


@pytest.mark.thorough
def test_a_long_run_from_rest_ends_on_the_settled_motion() -> None:
    usual = {"samples": 180, "kinds": (ReferenceEngine,)}
    ended = run(STEEP, start="equilibrium", revolutions=8.0, **(usual | {"step": 5e-4}))
    direct = run(STEEP, start="periodic", revolutions=1.0, **(usual | {"step": 2e-4}))
    found = float(direct.attrs["elastic_settled_fluctuation"])
    rigid = float(direct.attrs["settled_fluctuation"])
    assert abs(float(ended["last_turn_fluctuation"].item()) - found) < 0.1 * abs(rigid - found)


def test_the_settled_motion_of_damped_links_on_a_flywheel_is_found() -> None:
    """The moment of the links at the clamp turns the shaft, and is balanced over a turn."""
    sections = {k: s.with_damping_time(1e-4) for k, s in FOUR_BAR.sections.items()}
    damped = replace(FOUR_BAR, sections=sections, shaft_inertia=0.2)
    steady = TorqueMotor((0.0, 20.0), (20.0, 0.0))
    asked = {"samples": 24, "step": 2e-3, "revolutions": 1.0, "start": "periodic"}
    data = run(steady, mechanism=damped, kinds=(ReferenceEngine,), **asked)
    found = float(data.attrs["elastic_settled_fluctuation"])
    assert found / float(data.attrs["settled_fluctuation"]) == pytest.approx(1.018, abs=5e-3)
    assert float(data["last_turn_fluctuation"].item()) == pytest.approx(found, rel=1e-3)


def test_motors_that_cannot_run_are_refused() -> None:
    weak = MotorDrive(TorqueMotor((0.0,), (1e-3,)), time=0.1)
    with pytest.raises(InputError, match="does not start: at 0 deg"):
        response(ReferenceEngine(replace(FOUR_BAR, gravity=GRAVITY), 2), ResponseRequest(weak))
    with pytest.raises(InputError, match="free shaft"):
        ResponseRequest(MotorDrive(CURVE, time=0.1), shaft="prescribed")
    with pytest.raises(InputError, match="run_up_time"):
        ResponseRequest(MotorDrive(CURVE, time=0.1), run_up_time=1.0)


TIMES = np.linspace(0.0, 0.2, 101)
RISE = LawDrive("cycloid", np.radians(120), 0.15, dwell=0.05, start_angle=0.3)
DRIVES: dict[str, Any] = {
    "cycloid": RISE,
    "forth and back": LawDrive("trapezoid", 1.0, 0.08, 0.02, moves=2, forth_and_back=True),
    "table": TableDrive(tuple(TIMES), tuple(RISE.crank_angle(TIMES)), ends="rest"),
}


@pytest.mark.thorough
@pytest.mark.parametrize("name", DRIVES)
def test_the_work_of_the_shaft_along_a_law_is_in_the_energies(name: str) -> None:
    """From rest: all that moves and bends comes from the shaft, and goes back to it."""
    request = ResponseRequest(DRIVES[name], samples=100, step=1e-4, modes=2)
    data = response(ReferenceEngine(FOUR_BAR, 2), request).dataset
    assert np.ptp(data["drive_work"].values) > 0.9 * float(data["kinetic_energy"].max())
    assert float(data["energy_error"].item()) < 5e-5


@pytest.mark.thorough
def test_a_table_of_constant_speed_is_the_run_at_that_speed() -> None:
    time = np.linspace(0.0, 2 * np.pi / 20.0, 91)
    table = TableDrive(tuple(time), tuple(0.2 + 20.0 * time))
    found, wanted = (
        response(ReferenceEngine(FOUR_BAR, 3), ResponseRequest(drive, 1.0, 90, step=2e-4)).dataset
        for drive in (table, ConstantSpeed(20.0, start_angle=0.2))
    )
    for name in ("deflection", "driving_torque", "joint_force"):
        scale = float(np.abs(wanted[name]).max())
        np.testing.assert_allclose(found[name], wanted[name], rtol=0, atol=1e-9 * scale)


BETA = np.array([1.8751040687, 4.6940911330, 7.8547574382])
SIGMA = (np.cosh(BETA) + np.cos(BETA)) / (np.sinh(BETA) + np.sin(BETA))
ARM = Mechanism(RotatingArm(1.0), {"arm": strip(10e-3)})


def waves_at_tip(drive: LawDrive, damping: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Angular frequencies and complex amplitudes of three modes by Duhamel's integral.

    Of the first mode with a damping ratio, at the time zero.
    """
    section, place = ARM.sections["arm"], np.linspace(0.0, 1.0, 4001)
    argument = BETA[:, None] * place
    modes = np.cosh(argument) - np.cos(argument)
    modes -= SIGMA[:, None] * (np.sinh(argument) - np.sin(argument))
    share = np.trapezoid(place * modes, place) / np.trapezoid(modes**2, place)
    frequency = BETA**2 * np.sqrt(section.bending_stiffness / section.mass_per_length)
    move = np.linspace(0.0, drive.time, 20_001)
    ratio = damping * frequency / frequency[0]
    turning = frequency * np.sqrt(np.maximum(1 - ratio**2, 1e-9))
    rate = ratio * frequency - 1j * turning
    shaken = drive.crank_acceleration(move) * np.exp(rate[:, None] * (move - drive.time))
    shaken *= np.exp(-1j * turning * drive.time)[:, None]
    return turning, -(modes[:, -1] * share / turning) * np.trapezoid(shaken, move)


@pytest.mark.parametrize("kind", [LAWS[0], LAWS[-1]])
def test_an_arm_rings_after_the_stop_as_duhamels_integral_says(kind: Any) -> None:
    """A travel so small that the arm's rotation does not stiffen it."""
    first = BETA[0] ** 2 * np.sqrt(
        ARM.sections["arm"].bending_stiffness / ARM.sections["arm"].mass_per_length
    )
    drive = LawDrive(kind, 1e-3, time=1.3 * 2 * np.pi / first, dwell=0.2)
    request = ResponseRequest(drive, samples=1000, prestress="axial", step=1e-4)
    data = response(ReferenceEngine(ARM, 8, "euler"), request).dataset.isel(engine=0, link=0)
    assert float(data["standing_frequency"][0]) == pytest.approx(first / 2 / np.pi, rel=1e-4)
    after = data.sel(time=data["time"] >= drive.time)
    angular, amplitudes = waves_at_tip(drive)
    wanted = (amplitudes @ np.exp(1j * np.multiply.outer(angular, after["time"].values))).imag
    np.testing.assert_allclose(after["deflection"], wanted, atol=5e-3 * np.abs(wanted).max())
    assert data["modal_amplitude"].values[0] == pytest.approx(abs(amplitudes[0]), rel=5e-3)


@pytest.mark.parametrize("damping", [0.031, 0.12])
def test_all_readings_of_a_damped_ring_are_its_amplitude_at_the_stop(damping: float) -> None:
    """Envelope of the deflection, fitted mode, and state at the stop: Duhamel's integral."""
    section = ARM.sections["arm"]
    rate = float(BETA[0] ** 2 * np.sqrt(section.bending_stiffness / section.mass_per_length))
    section = section.with_damping_time(2 * damping / rate)
    drive = LawDrive("modified sine", 1e-3, time=1.1 * 2 * np.pi / rate, dwell=0.4)
    request = ResponseRequest(drive, samples=200, modes=2, step=2e-4)
    arm = replace(ARM, sections={"arm": section})
    engine = ReferenceEngine(arm, 4, "euler")
    data = response(engine, request).dataset.isel(engine=0, link=0)
    wanted = abs(waves_at_tip(drive, damping)[1][0])
    fitted = float(data["modal_amplitude"].sel(mode=1))
    assert fitted == pytest.approx(wanted, rel=3e-3)
    assert float(data["residual_amplitude"]) == pytest.approx(fitted, rel=3e-3)
    assert amplitudes_after_stop(engine, drive, 2)[0, 0] == pytest.approx(fitted, rel=5e-4)
    decayed = fitted * np.exp(-damping * rate * drive.dwell)
    assert float(data["residual_amplitude_at_end"]) == pytest.approx(decayed, rel=3e-3)
    # The deflection stays within its envelope.
    after = data.sel(time=data["time"] >= drive.time)
    off = abs(after["deflection"] - after["residual_middle"])
    assert float((off - after["residual_envelope"]).max()) < 1e-9


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("kind", "damping", "tolerated"),
    [
        ("zv", 0.02, 0.0),
        pytest.param("zvd", 0.0, 0.0, marks=THOROUGH),
        pytest.param("ei", 0.02, 0.05, marks=THOROUGH),
    ],
)
def test_a_shaper_for_its_frequency_keeps_an_arm_quiet(
    kind: Any, damping: float, tolerated: float
) -> None:
    """ZV and ZVD leave less than 1 % of the plain law's ring after the stop, EI its 5 %."""
    section = ARM.sections["arm"]
    rate = BETA[0] ** 2 * np.sqrt(section.bending_stiffness / section.mass_per_length)
    section = section.with_damping_time(2 * damping / float(rate))
    mechanism = replace(ARM, sections={"arm": section})
    law = LawDrive("polynomial 4567", 1e-3, time=0.15, dwell=0.2)
    engines = [ReferenceEngine(mechanism, 4, "euler"), ExudynEngine(mechanism, 4, "ancf")]
    request = ResponseRequest(law, samples=300, step=2e-4, modes=2, shaping=Shaping(kind, (1,)))
    data = response(engines, request).dataset
    left = data["shaped_modal_amplitude"] / data["modal_amplitude"]
    assert float(np.abs(left.sel(mode=1) - tolerated).max()) < 0.01
    whole = data["shaped_residual_amplitude"] / data["residual_amplitude"]
    assert float(whole.max()) < tolerated + 0.01
    assert float(data["shaped_energy_error"].max()) < 1e-5
