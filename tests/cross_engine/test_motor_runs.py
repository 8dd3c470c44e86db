"""Elastic linkages under a motor: both engines agree, energy is closed, limits are met."""

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
    MotorDrive,
    ReferenceEngine,
    ResponseRequest,
    SpeedControl,
    TorqueMotor,
    load_mechanism,
    motor_run,
    response,
)
from flexmech.linear_system import Engine
from flexmech.linkages import Motor
from flexmech.mechanism import with_motor_run
from flexmech.modelfile import mechanism_from_toml
from flexmech.time_domain import LinkState
from tests.support.motor_models import SLIDER_CRANK

MECHANISM = load_mechanism("models/aluminium_fourbar.toml")
CURVE = TorqueMotor((0.0, 15.0, 20.0), (0.4, 0.3, 0.0), inertia=5e-4)
DC = DcMotor(1.2, 0.06, 24.0, 1e-3, gear_ratio=10.0, inertia=2e-5)
CONTROL = SpeedControl(0.5, 2.0, 15.0)
COUPLING = {"coupling_stiffness": 20.0, "coupling_damping": 1e-3}
ENGINES: list[type[Engine]] = [ReferenceEngine, ExudynEngine]


def run(motor: Motor, control: SpeedControl | None, time: float, **asked: Any) -> xr.Dataset:
    engines = [engine(MECHANISM, 2) for engine in ENGINES]
    drive = MotorDrive(motor, control, time=time)
    return response(engines, ResponseRequest(drive, samples=90, modes=2, **asked)).dataset


def apart(data: xr.Dataset, name: str, over: str = "") -> float:
    values = data[name].values
    scale = np.abs(data[over or name].values).max()
    return float(np.abs(values[1] - values[0]).max() / scale)


@pytest.mark.parametrize(
    ("motor", "control", "time"),
    [
        pytest.param(CURVE, None, 0.3, marks=pytest.mark.thorough),
        pytest.param(DC, CONTROL, 0.06, marks=pytest.mark.thorough),
        (CURVE, SpeedControl(0.1, 0.5, 15.0), 0.06),
        (replace(CURVE, **COUPLING), None, 0.06),
        pytest.param(replace(DC, **COUPLING), CONTROL, 0.06, marks=pytest.mark.thorough),
    ],
    ids=["curve", "dc with control", "curve with control", "on a coupling", "dc on a coupling"],
)
def test_engines_agree(motor: Motor, control: SpeedControl | None, time: float) -> None:
    """The shaft's own rotation away from the rigid linkage's is what elastic links do to it."""
    data = run(motor, control, time, step=1e-4)
    assert apart(data, "shaft_rotation") < 0.04
    # By meshes of two elements a link that is shaken at the start.
    assert apart(data, "deflection") < 0.06
    assert apart(data, "motor_torque") < 0.03
    if motor.coupling_stiffness is not None:
        # The rotor lags behind, and the coupling carries other torque than the motor gives.
        assert apart(data, "motor_speed") < 2e-3
        assert apart(data, "driving_torque") < 0.01
        return
    # The torque is the motor's own at the speed that the crank has.
    speed = data["crank_speed_over_time"] + data["crank_speed_fluctuation"]
    xr.testing.assert_allclose(
        data["motor_speed"].drop_attrs(), (motor.gear_ratio * speed).transpose("engine", "time")
    )
    if isinstance(motor, TorqueMotor) and control is None:
        # Both as far as the band of forces lets them through.
        gap = np.abs(data["motor_torque"] - motor.torque(data["motor_speed"]))
        assert float(gap.quantile(0.9)) < 2e-3 * max(motor.torques)


def energy_of(engine: Engine, motor: Motor, step: float) -> float:
    """How far the energy balance of a start from rest is off, with the motor's work in it."""
    request = ResponseRequest(MotorDrive(motor, time=0.05), samples=60, modes=2, step=step)
    data = response(engine, request).dataset
    if motor.coupling_stiffness is None:
        work = float(data["drive_work"].isel(engine=0, time=-1))
        power = data["motor_power"].isel(engine=0)
        assert float(power.integrate("time")) == pytest.approx(work, rel=2e-3)
    return float(data["energy_error"].item())


@pytest.mark.parametrize(
    "motor",
    [CURVE, pytest.param(replace(CURVE, **COUPLING), marks=pytest.mark.thorough)],
    ids=["curve", "on a coupling"],
)
def test_energy_is_closed_by_the_reference(motor: Motor) -> None:
    """But for what the mesh leaves: a quarter of it with twice the elements, whatever the step.

    Strains of an element whose link turns against its frame are the same to second order in its
    length.
    """
    coarse, fine = (energy_of(ReferenceEngine(MECHANISM, n), motor, 4e-5) for n in (2, 4))
    assert coarse / fine > 3.0
    assert energy_of(ReferenceEngine(MECHANISM, 8), motor, 4e-5) < 1e-5


def test_a_motor_on_a_coupling_starts_from_equilibrium() -> None:
    """At rest the coupling carries nothing, so that the links have no load."""
    drive = MotorDrive(replace(CURVE, **COUPLING), time=0.02)
    request = ResponseRequest(drive, samples=30, modes=2, step=1e-4, start="equilibrium")
    data = response(ReferenceEngine(MECHANISM, 2), request).dataset
    assert np.abs(data["deflection"].isel(time=0)).max() < 1e-9


@pytest.mark.thorough
def test_energy_is_closed_by_exudyn() -> None:
    """A torque that begins at once shakes links faster than a step: four times less of half."""
    coarse, fine = (energy_of(ExudynEngine(MECHANISM, 2), CURVE, step) for step in (4e-5, 2e-5))
    assert coarse / fine > 3.0
    assert fine < 1e-6


@pytest.mark.parametrize(
    "engine", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
def test_a_heavy_flywheel_turns_as_prescribed(engine: type[Engine]) -> None:
    """Under the torque that its speed needs; what elastic links do to it falls as one over it."""
    away = []
    for inertia in (0.5, 5.0):
        heavy = replace(MECHANISM, shaft_inertia=inertia)
        # To 10 rad/s in a twentieth of a second.
        motor = TorqueMotor((0.0,), (200.0 * inertia,))
        request = ResponseRequest(MotorDrive(motor, time=0.05), samples=60, modes=2, step=5e-5)
        data = response(engine(heavy, 2), request).dataset
        away.append(float(data["peak_shaft_rotation"].item()))
        even = 200.0 * data["time"].values
        speed = data["motor_speed"].values[0]
        assert float(np.abs(speed - even).max()) < 0.05 / inertia
    assert away[0] / away[1] == pytest.approx(10.0, rel=0.1)


@pytest.mark.parametrize(
    ("time", "steps", "tolerance"),
    [
        (0.4, (1e-3, 5e-4, 2.5e-4), (1e-8, 1e-7)),
        pytest.param(3.0, (1e-3, 5e-4, 2.5e-4), (1e-6, 1e-5), marks=pytest.mark.thorough),
    ],
)
def test_v16_by_exudyns_rigid_links(
    time: float, steps: tuple[float, ...], tolerance: tuple[float, float]
) -> None:
    """Extrapolated twice to steps of zero, against the rigid linkage's own equation."""
    mechanism = mechanism_from_toml(SLIDER_CRANK)
    rigid = motor_run(mechanism, MotorDrive(TorqueMotor((0.0,), (0.1,)), time=time))
    engine = ExudynEngine(with_motor_run(mechanism, rigid), 1, shaft="free")
    found = []
    for step in steps:
        shaft = engine.simulate(rigid, LinkState.rigid(engine.links), np.array([time]), step).shaft
        assert shaft is not None
        found.append([shaft.rotation[-1], shaft.rate[-1]])
    first, second, third = np.array(found)
    once = (4 * second - first) / 3, (4 * third - second) / 3
    left = np.abs(16 * once[1] - once[0]) / 15
    whole = [float(rigid.crank_angle(time)), float(rigid.crank_speed(time))]
    assert (left < np.array(tolerance) * whole).all()


@pytest.mark.thorough
def test_v16_by_the_reference_engines_stiff_rod() -> None:
    """What a rod that bends takes away falls as one over its stiffness, towards the rigid one."""
    left = []
    for modulus in (2e3, 2e4):
        text = SLIDER_CRANK.replace('points = ["A", "B"]\nrigid = true', 'points = ["A", "B"]')
        bodies = text[text.index("bodies", text.index("[links.rod]")) :].split("\n")[0]
        section = (
            'material = "stiff"\nsection = "rectangle"\nin_plane_thickness = "4 mm"\n'
            f'out_of_plane_width = "{0.2 / 0.3 / 7850 / 4e-3:.17g} m"'
        )
        material = f'[materials.stiff]\nyoungs_modulus = "{modulus:g} GPa"\n'
        material += 'density = "7850 kg/m^3"\npoisson_ratio = 0.3\n'
        text = text.replace(bodies, section).replace("[links.crank]", material + "[links.crank]")
        drive = MotorDrive(TorqueMotor((0.0,), (0.1,)), time=1.0)
        request = ResponseRequest(drive, samples=90, modes=1, step=2.5e-4)
        engine = ReferenceEngine(mechanism_from_toml(text), 2, "euler")
        data = response(engine, request).dataset.isel(engine=0, time=-1)
        left.append([float(data["shaft_rotation"]), float(data["crank_speed_fluctuation"])])
    (stiff, _), (stiffer, shaken) = left
    assert stiff / stiffer == pytest.approx(10.0, rel=0.01)
    assert abs(10 * stiffer - stiff) / 9 < 1e-6 * float(data["crank_angle"])
    # The rod is shaken by the sudden start, by the root of its softness.
    assert abs(shaken) < 1e-4 * float(data["crank_speed_over_time"])


def test_what_a_motor_run_cannot_be_is_refused() -> None:
    weighed = ReferenceEngine(replace(MECHANISM, gravity=(0.0, -9.81)), 2)
    with pytest.raises(InputError, match="the motor does not start: at 0 deg it gives the crank"):
        response(weighed, ResponseRequest(MotorDrive(TorqueMotor((0.0,), (1e-3,)), time=0.1)))
    with pytest.raises(InputError, match="a motor turns a free shaft"):
        ResponseRequest(MotorDrive(CURVE, time=0.1), shaft="prescribed")
    with pytest.raises(InputError, match="leave speed_unit and run_up_time out"):
        ResponseRequest(MotorDrive(CURVE, time=0.1), run_up_time=1.0)
    # A speed in place of the motor of the model is a run as ever.
    moved = replace(MECHANISM, drive=MotorDrive(CURVE))
    assert isinstance(ResponseRequest(20.0).of(moved).drive, ConstantSpeed)
