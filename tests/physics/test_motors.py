"""The rigid linkage under a motor: closed forms, an exact quadrature, stalls, settled motion."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

from flexmech import (
    DcMotor,
    InputError,
    JointSpring,
    Mechanism,
    MotorDrive,
    MotorRun,
    PointMass,
    RotatingArm,
    SpeedControl,
    TorqueMotor,
    kinematics,
    motor_run,
)
from flexmech.linkages import Motor, continuous_angles
from flexmech.modelfile import mechanism_from_toml
from tests.support.motor_models import SLIDER_CRANK
from tests.support.strategies import arm, fourbar

CRANK, ROD, TORQUE, END = 0.1, 0.3, 0.1, 3.0
# A point mass on an arm without matter: whatever a section adds to inertia, it adds nothing here.
LENGTH, MASS = 0.4, 0.02
INERTIA = MASS * LENGTH**2
_SECTION = replace(arm().sections["arm"], mass_per_length=1e-12, rotary_inertia=1e-18)
ARM = Mechanism(
    RotatingArm(LENGTH), {"arm": _SECTION}, link_masses=(PointMass("arm", LENGTH, MASS),)
)
FOUR_BAR = fourbar(thickness=(2e-3, 2e-3, 2e-3), gravity=(0.0, -9.81))
SETTLING = TorqueMotor((0.0, 20.0), (2.0, 0.0), inertia=1e-3)


def slider_crank_inertia(angle: float) -> float:
    """Reduced to the crank: twice the kinetic energy at unit speed."""
    sine, cosine = np.sin(angle), np.cos(angle)
    tilt = np.arcsin(CRANK / ROD * sine)
    turn = CRANK * cosine / (ROD * np.cos(tilt))
    middle = (
        -CRANK * sine - ROD / 2 * np.sin(tilt) * turn,
        CRANK * cosine - ROD / 2 * np.cos(tilt) * turn,
    )
    slides = -CRANK * sine - ROD * np.sin(tilt) * turn
    rod = 0.2 * (middle[0] ** 2 + middle[1] ** 2) + 0.2 * ROD**2 / 12 * turn**2
    return float(0.2 * CRANK**2 / 3 + rod + 0.4 * slides**2)


def run_of(mechanism: Mechanism, motor: Motor, **others: object) -> MotorRun:
    return motor_run(mechanism, MotorDrive(motor, **others))  # type: ignore[arg-type]


def test_dc_motor_on_an_arm_is_a_linear_system() -> None:
    """Current and speed from rest, and the slower and faster time constant of the two."""
    motor = DcMotor(1.2, 0.06, 12.0, 5e-3, gear_ratio=8.0, inertia=3e-5)
    run = run_of(ARM, motor, time=0.2)
    inertia = INERTIA + 64 * 3e-5
    constant = 8.0 * 0.06
    matrix = np.array([[0.0, constant / inertia], [-constant / 5e-3, -1.2 / 5e-3]])
    still = np.linalg.solve(matrix, [0.0, -12.0 / 5e-3])
    time = np.linspace(0.0, 0.2, 21)
    wanted = np.array([still - expm(matrix * t) @ still for t in time])
    np.testing.assert_allclose(run.crank_speed(time), wanted[:, 0], rtol=1e-7, atol=1e-9)
    current = run.motor_output(time).current
    np.testing.assert_allclose(current, wanted[:, 1], rtol=1e-6, atol=1e-7)
    # Without inductance the current follows at once: one time constant.
    quick = run_of(ARM, replace(motor, inductance=0.0), time=0.2)
    rate = constant**2 / (1.2 * inertia)
    wanted = 12.0 / constant * (1 - np.exp(-rate * time))
    np.testing.assert_allclose(quick.crank_speed(time), wanted, rtol=1e-9, atol=1e-10)


# One that nearly holds the arm lets it fall back within the first step.
@pytest.mark.parametrize(("held", "back"), [(0.0, 4e-4), (0.95, 0.0)])
def test_a_motor_that_is_switched_on_without_current_lets_its_load_fall_back(
    held: float, back: float
) -> None:
    """An arm that weighs 0.08 N m, beside an integration of its three equations by another method.

    Left out, the first current is the one that holds the arm.
    """
    first = held * MASS * 9.81 * LENGTH / (8.0 * 0.06)
    motor = DcMotor(1.2, 0.06, 12.0, 0.5, initial_current=first, gear_ratio=8.0, inertia=3e-5)
    heavy = replace(ARM, gravity=(0.0, -9.81))
    inertia, weight = INERTIA + 64 * 3e-5, MASS * 9.81 * LENGTH

    def rates(_: float, values: np.ndarray) -> list[float]:
        angle, speed, current = values
        torque = 8.0 * 0.06 * current - weight * np.cos(angle)
        return [speed, torque / inertia, (12.0 - 1.2 * current - 8.0 * 0.06 * speed) / 0.5]

    time = np.linspace(0.0, 0.3, 61)
    start = [0.0, 0.0, first]
    wanted = solve_ivp(rates, (0.0, 0.3), start, "Radau", time, rtol=1e-9, atol=1e-11).y
    run = run_of(heavy, motor, time=0.3)
    assert wanted[0].min() <= -back
    np.testing.assert_allclose(run.crank_angle(time), wanted[0], atol=1e-6)
    np.testing.assert_allclose(run.motor_output(time).current, wanted[2], atol=1e-6)
    braked = run_of(heavy, replace(motor, initial_current=None), time=0.1)
    assert float(braked.motor_output(0.0).current) == pytest.approx(weight / (8.0 * 0.06))
    with pytest.raises(InputError, match="falls back by half a turn"):
        run_of(heavy, replace(motor, initial_current=-20.0), time=1.0)


def test_v16_is_the_quadrature_of_its_energy() -> None:
    """The work of the torque is the kinetic energy: M theta = J(theta) omega^2 / 2.

    The stored solution, an adaptive integration to 1e-6 a step, has 121.89082 rad and 101.69399
    rad/s, at which J(theta) omega^2 / 2 is 1e-4 more than M theta. The quadrature, and Exudyn
    extrapolated to steps of zero, have 121.886277 and 101.3656.
    """

    def duration(end: float) -> float:
        def slowness(root: float) -> float:
            # theta = root^2: no singularity at the start.
            return float(2 * np.sqrt(slider_crank_inertia(root**2) / (2 * TORQUE)))

        places = np.sqrt(np.append(np.arange(0.0, end, np.pi / 2), end))
        parts = (quad(slowness, *pair, epsabs=1e-13, epsrel=1e-13) for pair in pairwise(places))
        return float(sum(part for part, _ in parts))

    angle = brentq(lambda end: duration(end) - END, 121.0, 122.5, xtol=1e-12)
    speed = np.sqrt(2 * TORQUE * angle / slider_crank_inertia(angle))
    run = run_of(mechanism_from_toml(SLIDER_CRANK), TorqueMotor((0.0,), (TORQUE,)), time=END)
    assert float(run.crank_angle(END)) == pytest.approx(angle, rel=1e-10)
    assert float(run.crank_speed(END)) == pytest.approx(speed, rel=1e-8)
    assert angle == pytest.approx(121.89082, rel=4e-5)


def test_the_torque_of_the_motion_is_the_motors() -> None:
    """By inverse dynamics, rotor and shaft included, of every kind of motor."""
    mechanism = replace(FOUR_BAR, shaft_inertia=1e-4)
    gear, rotor = 10.0, 2e-5
    motors: list[tuple[Motor, SpeedControl | None]] = [
        (TorqueMotor((0.0, 150.0, 300.0), (0.1, 0.12, 0.0), gear_ratio=gear, inertia=rotor), None),
        (DcMotor(1.2, 0.06, 24.0, 1e-3, gear_ratio=gear, inertia=rotor), None),
        (
            DcMotor(1.2, 0.06, 24.0, 1e-3, gear_ratio=gear, inertia=rotor),
            SpeedControl(0.5, 2.0, 20.0),
        ),
    ]
    for motor, control in motors:
        run = run_of(mechanism, motor, control=control, time=0.15, start_angle=0.3)
        # At the very corners of a torque curve and of saturation the acceleration has one too.
        time = np.linspace(0.0, 0.15, 301)
        needed = mechanism.inverse_dynamics(run.motion(mechanism.linkage, time)).driving_torque
        needed += (1e-4 + rotor * gear**2) * run.crank_acceleration(time)
        given = run.crank_torque(time)
        apart = np.sort(np.abs(needed - given)) / np.abs(given).max()
        assert apart[-4] < 1e-6, (motor, control)


def test_speed_control_is_a_linear_system_until_it_saturates() -> None:
    motor = TorqueMotor((0.0, 100.0), (5.0, 5.0), gear_ratio=4.0)
    control = SpeedControl(kp=0.05, ki=0.4, target=10.0)
    run = run_of(ARM, motor, control=control, time=0.8)
    # J x'' = 4 (kp e + ki int e): the error of the angle against the target's.
    matrix = np.array([[0.0, 1.0], [-4 * 0.4 / INERTIA, -4 * 0.05 / INERTIA]])
    time = np.linspace(0.0, 0.8, 17)
    wanted = [10.0 + (expm(matrix * t) @ [0.0, -10.0])[1] for t in time]
    np.testing.assert_allclose(run.crank_speed(time), wanted, rtol=1e-8, atol=1e-8)
    weak = run_of(ARM, replace(motor, torques=(0.05, 0.05)), control=control, time=0.8)
    assert float(np.abs(weak.motor_output(time).torque).max()) == pytest.approx(0.05)
    # While it is at its limit the arm speeds up evenly.
    assert float(weak.crank_speed(0.05)) == pytest.approx(0.2 / INERTIA * 0.05, rel=1e-9)


def test_a_coupling_is_an_oscillator() -> None:
    """Under a constant torque the twist swings about that which the arm's share needs."""
    rotor, stiffness = 2e-3, 3.0
    motor = TorqueMotor((0.0,), (0.3,), inertia=rotor, coupling_stiffness=stiffness)
    run = run_of(ARM, motor, time=0.5)
    time = np.linspace(0.0, 0.5, 51)
    rate = np.sqrt(stiffness * (1 / rotor + 1 / INERTIA))
    twist = 0.3 / rotor / rate**2 * (1 - np.cos(rate * time))
    np.testing.assert_allclose(run.crank_torque(time), stiffness * twist, rtol=1e-6, atol=1e-8)
    # The whole is accelerated as if it were one body.
    whole = rotor * run.rotor_speed(time) + INERTIA * run.crank_speed(time)
    np.testing.assert_allclose(whole, 0.3 * time, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_an_arm_stalls_where_its_energy_is_spent(way: float) -> None:
    """A torque lifts it from hanging, until T phi = m g l (1 - cos phi)."""
    weighed = replace(ARM, gravity=(0.0, -9.81))
    moment = MASS * 9.81 * LENGTH
    torque = 0.5 * moment
    motor = TorqueMotor((0.0,), (way * torque,))
    run = run_of(weighed, motor, start_angle=-np.pi / 2, time=10.0)
    rise = brentq(lambda x: torque * x - moment * (1 - np.cos(x)), 0.5, np.pi)
    assert run.stall is not None
    assert run.stall.crank_angle == pytest.approx(-np.pi / 2 + way * rise, rel=1e-9)
    assert run.stall.time == run.duration < 10.0
    assert run.stall.needed == pytest.approx(way * moment * np.sin(rise), rel=1e-9)
    assert (run.speed, run.settled) == (0.0, None)
    # A little more than 0.7246 of the moment carries it over.
    over = run_of(
        weighed, TorqueMotor((0.0,), (way * 0.73 * moment,)), start_angle=-np.pi / 2, time=2.0
    )
    assert over.stall is None


def test_a_motor_that_does_not_start_stands() -> None:
    weighed = replace(ARM, gravity=(0.0, -9.81))
    moment = MASS * 9.81 * LENGTH
    run = run_of(weighed, TorqueMotor((0.0, 10.0), (0.9 * moment, 0.0)), start_angle=0.0)
    assert run.stall is not None
    assert (run.stall.time, run.stall.crank_angle) == (0.0, 0.0)
    assert run.stall.torque == pytest.approx(0.9 * moment)
    assert run.stall.needed == pytest.approx(moment)
    np.testing.assert_array_equal(run.crank_angle([0.0, 0.05, 1.0]), 0.0)


def test_a_spring_in_a_joint_is_wound_up() -> None:
    """One between crank and coupler takes more from turn to turn until the motor stalls."""
    sprung = replace(
        FOUR_BAR,
        gravity=(0.0, 0.0),
        joint_springs=(JointSpring("A", torsional_stiffness=0.02, free_angle=0.4),),
    )
    run = run_of(sprung, TorqueMotor((0.0,), (0.1,)), time=20.0)
    assert run.stall is not None
    # The work of the torque is in the spring.
    ends = np.array([0.0, run.stall.crank_angle])
    angles = continuous_angles(sprung.linkage, sprung.linkage.motion(ends))
    opening = angles[:, 1] - angles[:, 0] - 0.4
    stored = 0.02 / 2 * np.diff(opening**2)[0]
    assert run.stall.crank_angle > 2 * np.pi
    assert 0.1 * run.stall.crank_angle == pytest.approx(stored, rel=1e-8)


@pytest.mark.thorough
def test_settled_motion_is_what_a_long_run_tends_to() -> None:
    """Weight and masses give back over a turn what they take; a flywheel evens the speed out."""
    run = run_of(FOUR_BAR, SETTLING, time=4.0)
    settled = run.settled
    assert settled is not None
    fine = np.linspace(4.0 - settled.time[-1], 4.0, 20_001)
    speed = run.crank_speed(fine)
    fluctuation = float(np.ptp(speed)) / settled.mean_speed
    assert fluctuation == pytest.approx(settled.fluctuation, rel=1e-6)
    turned = float(run.crank_angle(fine[-1]) - run.crank_angle(fine[0]))
    assert turned == pytest.approx(2 * np.pi, rel=1e-7)
    assert settled.mean_power == pytest.approx(0.0, abs=1e-6)
    heavy = []
    for inertia in (1.0, 10.0):
        steady = run_of(replace(FOUR_BAR, shaft_inertia=inertia), SETTLING, time=0.2).settled
        assert steady is not None
        heavy.append(steady.fluctuation)
    assert heavy[0] / heavy[1] == pytest.approx(10.0, rel=0.02)
    assert run_of(ARM, TorqueMotor((0.0,), (0.02,)), time=1.0).settled is None


def test_an_arm_without_load_settles_at_the_no_load_speed_without_fluctuation() -> None:
    steady = run_of(ARM, DcMotor(1.2, 0.06, 12.0, gear_ratio=10.0, inertia=2e-5), time=0.5).settled
    assert steady is not None
    assert steady.mean_speed == pytest.approx(20.0)
    assert steady.fluctuation == pytest.approx(0.0, abs=1e-9)


def test_a_run_that_ends_before_it_has_settled_says_so_and_what_the_settled_motion_carries() -> (
    None
):
    """A flywheel keeps the settled speed even: joint forces are those at constant speed."""
    motor = MotorDrive(TorqueMotor((0.0, 150.0, 190.0), (2.0, 1.5, 0.0), inertia=20.0), time=20.0)
    mechanism = replace(FOUR_BAR, gravity=(0.0, 0.0))
    result = kinematics(mechanism, motor)
    steady = kinematics(mechanism, 190.0).dataset["joint_force"]
    greatest = float(np.hypot(*np.moveaxis(steady.values, -1, 0)).max())
    told = {number.name: number.value for number in result.summary().numbers}
    assert told["settled_joint_force"] == pytest.approx(greatest, rel=2e-3)
    assert told["settled_crank_speed"] == pytest.approx(190.0, rel=1e-4)
    assert "before the motor has settled" in result.summary().answer[0]
    # From rest to within 1 % of its speed.
    light = MotorDrive(SETTLING)
    assert "Settled, the motor" in kinematics(mechanism, light).summary().answer[0]


def test_kinematics_under_a_motor_balance_at_the_shaft() -> None:
    """Gear times the motor's torque is the linkage's and that of rotor and shaft."""
    motor = MotorDrive(DcMotor(1.2, 0.06, 12.0, gear_ratio=10.0, inertia=2e-5))
    data = kinematics(fourbar(), motor).dataset
    needed = data["driving_torque"] + data["shaft_inertia_torque"]
    scale = float(abs(needed).max())
    np.testing.assert_allclose(10.0 * data["motor_torque"], needed, atol=1e-5 * scale)
    np.testing.assert_allclose(data["motor_power"], data["motor_torque"] * data["motor_speed"])
    np.testing.assert_allclose(data["motor_current"], data["motor_torque"] / 0.06)
    # Its voltage drives the current against its resistance and speed.
    voltage = 1.2 * data["motor_current"] + 0.06 * data["motor_speed"]
    np.testing.assert_allclose(voltage, 12.0, rtol=1e-6)
    run = motor_run(fourbar(), motor)
    again = kinematics(fourbar(), run).dataset["crank_speed_over_time"]
    np.testing.assert_array_equal(again[-1], run.crank_speed(run.duration))


REFUSED = {
    "give one row": lambda: TorqueMotor((), ()),
    "gear_ratio must be positive": lambda: TorqueMotor((0.0,), (1.0,), gear_ratio=0.0),
    "resistance must be positive": lambda: DcMotor(0.0, 0.06, 24.0),
    "initial_current goes with inductance": lambda: DcMotor(1.2, 0.06, 24.0, initial_current=0.0),
    "speed_unit": lambda: SpeedControl(0.5, 2.0, 10.0, "mm"),
    "motor must be": lambda: MotorDrive(3.0),
    "crank that turns fully": lambda: run_of(
        fourbar(replace(FOUR_BAR.linkage, crank=0.25, coupler=0.1, rocker=0.11)), SETTLING
    ),
    "drive must be": lambda: motor_run(FOUR_BAR),
}


@pytest.mark.parametrize("said", REFUSED)
def test_motors_that_are_none_are_refused(said: str) -> None:
    with pytest.raises(InputError, match=said):
        REFUSED[said]()
