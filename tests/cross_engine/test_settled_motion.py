"""The settled motion of elastic links under a motor: found directly, and where runs stay or end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from flexmech import (
    DcMotor,
    ExudynEngine,
    InputError,
    MotorDrive,
    ReferenceEngine,
    ResponseRequest,
    SpeedControl,
    TorqueMotor,
    load_mechanism,
    response,
)
from flexmech.analyses.response.motor_passes import MotorPasses
from flexmech.linear_system import Engine
from flexmech.linkages import Motor
from flexmech.mechanism import Mechanism, settled_run, with_motor_run
from flexmech.time_domain import DrivenLinkage, linear_run, state_under_motor

MECHANISM = load_mechanism("models/aluminium_fourbar.toml")
CURVE = TorqueMotor((0.0, 20.0), (1.5, 0.0), inertia=5e-3)
COUPLED = replace(CURVE, coupling_stiffness=300.0, coupling_damping=0.01)
BACKWARDS = TorqueMotor((-30.0, 0.0), (0.75, -1.5), inertia=5e-3)
DC = DcMotor(1.2, 0.06, 24.0, 1e-3, gear_ratio=10.0, inertia=2e-5)
CONTROL = SpeedControl(0.5, 2.0, 15.0)
BOTH: Sequence[type[Engine]] = (ReferenceEngine, ExudynEngine)


def run(
    motor: Motor,
    control: SpeedControl | None = None,
    *,
    mechanism: Mechanism = MECHANISM,
    engines: Sequence[type[Engine]] = (ReferenceEngine,),
    **asked: Any,
) -> xr.Dataset:
    drive = MotorDrive(motor, control)
    usual = {"samples": 180, "modes": 2, "step": 2e-4, "revolutions": 1.0, "start": "periodic"}
    request = ResponseRequest(drive, **{**usual, **asked})  # type: ignore[arg-type]
    return response([engine(mechanism, 2) for engine in engines], request).dataset


@pytest.mark.parametrize(
    ("motor", "control", "gravity"),
    [
        (CURVE, None, 0.0),
        pytest.param(CURVE, None, -9.81, marks=pytest.mark.thorough),
        pytest.param(COUPLED, None, 0.0, marks=pytest.mark.thorough),
        pytest.param(DC, CONTROL, 0.0, marks=pytest.mark.thorough),
        pytest.param(BACKWARDS, None, -9.81, marks=pytest.mark.thorough),
    ],
    ids=["curve", "weight", "on a coupling", "dc with control", "backwards"],
)
def test_both_engines_stay_on_it(
    motor: Motor, control: SpeedControl | None, gravity: float
) -> None:
    """A free shaft under the motor turns as found, to a thousandth of its fluctuation."""
    mechanism = replace(MECHANISM, gravity=(0.0, gravity))
    data = run(motor, control, mechanism=mechanism, engines=BOTH)
    found = float(data.attrs["elastic_settled_fluctuation"])
    speed = float(data.attrs["elastic_settled_speed"])
    # Elastic links change the fluctuation by more than a hundredth of it.
    assert abs(found / float(data.attrs["settled_fluctuation"]) - 1) > 0.008
    for engine in ("reference", "exudyn"):
        own = data.sel(engine=engine)
        assert float(own["last_turn_fluctuation"]) == pytest.approx(found, rel=1e-3)
        assert float(own["last_turn_speed"]) == pytest.approx(speed, rel=2e-5)
        assert float(own["peak_shaft_rotation"]) < 1e-4
        # The links end the turn as they began it.
        bent = own["deflection"].values
        assert np.abs(bent[-1] - bent[0]).max() < 3e-3 * np.abs(bent).max()


@pytest.mark.thorough
def test_of_a_slider_crank_that_fluctuates_by_two_fifths() -> None:
    """Links change that by a twelfth of it; what is linear in the search leaves a part of that."""
    mechanism = load_mechanism("models/slider_crank.toml")
    motor = TorqueMotor((0.0, 200.0), (0.4, 0.0), inertia=2e-4)
    data = run(motor, mechanism=mechanism, engines=BOTH, step=2e-5)
    found = float(data.attrs["elastic_settled_fluctuation"])
    assert found / float(data.attrs["settled_fluctuation"]) > 1.07
    np.testing.assert_allclose(data["last_turn_fluctuation"], found, rtol=3e-3)
    speed = float(data.attrs["elastic_settled_speed"])
    np.testing.assert_allclose(data["last_turn_speed"], speed, rtol=1e-3)


def test_exudyn_alone_runs_on_it() -> None:
    data = run(CURVE, engines=(ExudynEngine,))
    assert float(data["peak_shaft_rotation"].item()) < 2e-5


@pytest.mark.thorough
def test_a_long_run_from_rest_ends_on_it() -> None:
    from_rest = run(CURVE, start="equilibrium", revolutions=8.0, step=5e-4)
    directly = run(CURVE)
    found = float(directly.attrs["elastic_settled_fluctuation"])
    rigid = float(directly.attrs["settled_fluctuation"])
    ends = float(from_rest["last_turn_fluctuation"].item())
    # Some vibration from the start is left.
    assert abs(ends - found) < 0.1 * abs(rigid - found)


@pytest.mark.thorough
def test_a_heavy_flywheel_evens_it() -> None:
    found = [
        run(CURVE, mechanism=replace(MECHANISM, shaft_inertia=inertia)).attrs[
            "elastic_settled_fluctuation"
        ]
        for inertia in (0.5, 5.0)
    ]
    assert found[0] / found[1] == pytest.approx(10.0, rel=0.02)


@pytest.mark.thorough
def test_a_stiff_coupling_is_none() -> None:
    directly = [
        float(run(motor).attrs["elastic_settled_fluctuation"])
        for motor in (
            replace(CURVE, coupling_stiffness=3e2, coupling_damping=0.1),
            replace(CURVE, coupling_stiffness=3e3, coupling_damping=0.1),
            CURVE,
        )
    ]
    off = [abs(own - directly[-1]) for own in directly[:-1]]
    assert off[0] / off[1] == pytest.approx(10.0, rel=0.15)


@pytest.mark.parametrize(
    "motor", [CURVE, pytest.param(COUPLED, marks=pytest.mark.thorough)], ids=["rigid", "coupled"]
)
def test_its_turns_are_one_law(motor: Motor) -> None:
    """Angle, speed and acceleration go on from turn to turn, and repeat themselves."""
    turns = settled_run(MECHANISM, MotorDrive(motor, start_angle=0.7), 3.0)
    once = turns.revolution_time
    assert turns.duration == pytest.approx(3 * once)
    assert float(turns.crank_angle(0.0)) == pytest.approx(0.7)
    time = np.linspace(0.0, 1.2 * once, 301)
    turned = turns.crank_angle(time + once) - turns.crank_angle(time)
    np.testing.assert_allclose(turned, 2 * np.pi, rtol=1e-8)
    for of in (turns.crank_speed, turns.crank_acceleration, turns.crank_torque):
        scale = float(np.abs(of(time)).max())
        np.testing.assert_allclose(of(time + once), of(time), atol=1e-6 * scale)


@pytest.mark.thorough
def test_a_constant_torque_settles_at_no_speed() -> None:
    constant = MotorDrive(TorqueMotor((0.0,), (0.1,)))
    with pytest.raises(InputError, match="settles at no speed: its torque does not fall"):
        settled_run(MECHANISM, constant)


def test_what_has_no_settled_motion_is_refused() -> None:
    weighed = replace(load_mechanism("models/steel_fourbar.toml"), gravity=(0.0, -9.81))
    weak = MotorDrive(TorqueMotor((0.0, 30.0), (0.03, 0.0)), start_angle=np.radians(280.0))
    with pytest.raises(InputError, match=r"the motor stalls at .* no settled motion"):
        settled_run(weighed, weak)
    with pytest.raises(InputError, match="a periodic start needs a prescribed shaft"):
        ResponseRequest(20.0, start="periodic", shaft="free")


def test_a_constant_torque_is_taken_back_that_the_time_of_a_turn_does_not_allow() -> None:
    """A motor that is stronger than along the motion: what keeps the time takes the rest back."""
    turns = settled_run(MECHANISM, MotorDrive(CURVE))
    steps = 720
    step = turns.revolution_time / steps
    own = with_motor_run(MECHANISM, turns)
    engine = ReferenceEngine(own, 2, shaft="free").fit_for(2)
    along = MotorPasses(turns).torque_along(step * np.arange(2.0 * steps))

    def linkage(more: float) -> DrivenLinkage:
        given = replace(along, torque=along.torque + more, recorded=[])
        return DrivenLinkage(engine, turns, "axial", modes=2, shaft_torque=given)

    states, constants = zip(
        *(state_under_motor(linkage(more), linkage(more + 1), steps) for more in (0.0, 0.02)),
        strict=True,
    )
    assert constants[1] - constants[0] == pytest.approx(-0.02, rel=1e-6)
    np.testing.assert_allclose(states[1].velocity, states[0].velocity, atol=1e-8)
    shaft = linkage(0.0).shaft_coordinates[0]
    assert states[0].position[shaft] == pytest.approx(0.0, abs=1e-12)
    # The turn closes with it alone.
    for constant, closes in ((constants[1] + 0.02, True), (0.02, False)):
        end = linear_run(
            linkage(constant),
            states[0].position,
            states[0].velocity,
            step * np.arange(steps + 1.0),
            step,
        ).shaft
        assert end is not None
        assert (abs(float(np.diff(end.rate[[0, -1]])[0])) < 1e-8) is closes
