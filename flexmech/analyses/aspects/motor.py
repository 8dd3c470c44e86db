"""A motor in a result: its torque, speed, power and current, its stall and its settled motion."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.summary import Aspect, speed_with_unit
from flexmech.arrays import FloatArray
from flexmech.linkages import DcMotor, MotorRun, SettledRun
from flexmech.linkages.motors.motor import MotorOutput
from flexmech.linkages.motors.motor_run import speed_range
from flexmech.mechanism import Mechanism

# Relative error of the rigid linkage's motion under a motor: below all digits that are printed.
_LEAST_ERROR = 1e-6
# Part of a peak over a settled turn that lies between samples: those half a degree apart miss as
# much of its tenth harmonic.
_BETWEEN = 1e-3
# By which a run of one turn may lack of it, once elastic links have moved the shaft.
_A_TURN = 1e-3


def motor_attributes(run: MotorRun) -> dict[str, str | float]:
    """Attributes that tell where a motor stalls, or how it turns once it has settled.

    Parameters
    ----------
    run : MotorRun

    Returns
    -------
    dict
    """
    values: dict[str, str | float] = {"gear_ratio": run.drive.motor.gear_ratio}
    values["run_duration"] = run.duration
    motor = run.drive.motor
    if motor.has_current and not isinstance(run, SettledRun):
        needed = float(run.equation.load.needed(run.start_angle, 0.0, 0.0))
        values["first_current"] = float(run.motor_output(0.0).current)
        values["holding_current"] = motor.holding_current(
            run.equation.train.held_by_current(needed)
        )
    if (stall := run.stall) is not None:
        return values | {
            "stall_time": stall.time,
            "stall_angle": stall.crank_angle,
            "stall_torque": stall.torque,
            "stall_needed": stall.needed,
        }
    if (settled := run.settled) is not None:
        values |= {
            "settled_in_run": int(run.has_settled),
            "crank_speed_of_run_end": float(run.crank_speed(run.duration)),
            "settled_speed": settled.mean_speed,
            "settled_fluctuation": settled.fluctuation,
            "settled_power": settled.mean_power,
        }
    if isinstance(run, SettledRun):
        values |= {
            "elastic_settled_speed": run.turn.mean_speed,
            "elastic_settled_fluctuation": run.turn.fluctuation,
            "elastic_settled_power": run.turn.mean_power,
        }
    return values


def settled_values(run: MotorRun, mechanism: Mechanism) -> dict[str, FloatArray]:
    """Crank speed, motor and joint forces over a turn of the rigid linkage's settled motion.

    Parameters
    ----------
    run : MotorRun
    mechanism : Mechanism
        With the run as its drive.

    Returns
    -------
    dict of str to ndarray
        Over ``settled_angle``; empty of a motor that stalls or does not settle.
    """
    settled = run.settled
    if settled is None:
        return {}
    acceleration = settled.equation.rates(settled.time, settled.values)[1]
    motion = mechanism.linkage.motion(settled.crank_angle, settled.speed, acceleration)
    force = mechanism.inverse_dynamics(motion).joint_force
    names = mechanism.linkage.topology.joint_names
    sizes = [np.hypot(force[name][:, 0], force[name][:, 1]) for name in names]
    values = {
        "settled_angle": settled.crank_angle,
        "settled_crank_speed": settled.speed,
        "settled_motor_torque": settled.output.torque,
        "settled_joint_force": np.stack(sizes, axis=1),
    }
    if isinstance(run.drive.motor, DcMotor):
        values["settled_motor_current"] = settled.output.current
    return values


def motor_values(run: MotorRun, given: MotorOutput, speed: FloatArray) -> dict[str, FloatArray]:
    """Output of a motor over time.

    Parameters
    ----------
    run : MotorRun
    given : MotorOutput
        Arrays of shape (N,).
    speed : ndarray, shape (N,)
        Speed of its rotor over the gear ratio, in rad/s.

    Returns
    -------
    dict of str to ndarray, shape (N,)
    """
    rotor = run.drive.motor.gear_ratio * speed
    values = {
        "motor_torque": given.torque,
        "motor_speed": rotor,
        "motor_power": given.torque * rotor,
    }
    if isinstance(run.drive.motor, DcMotor):
        values["motor_current"] = given.current
    return values


def last_turn(angle: FloatArray, speed: FloatArray, time: FloatArray) -> tuple[float, float]:
    """Mean crank speed over the last turn of a run, and its coefficient of fluctuation.

    Parameters
    ----------
    angle, speed, time : ndarray, shape (N,)

    Returns
    -------
    tuple of float
        In rad/s, and greatest less least speed over the mean; not numbers of less than a turn.
    """
    way = np.abs(angle - angle[-1])
    if way[0] < 2 * np.pi * (1 - _A_TURN):
        return np.nan, np.nan
    turn = min(2 * np.pi, float(way[0]))
    first = int(np.flatnonzero(way >= turn)[-1])
    begin = float(np.interp(turn, way[first : first + 2][::-1], time[first : first + 2][::-1]))
    mean = np.sign(angle[-1] - angle[0]) * turn / (time[-1] - begin)
    return float(mean), speed_range(time[first:], speed[first:]) / abs(float(mean))


def motor_aspect(data: xr.Dataset) -> Aspect:
    """Share of a motor in a summary; empty for a result without one.

    Parameters
    ----------
    data : xarray.Dataset

    Returns
    -------
    Aspect
        Where it stalls, or how fast and how evenly it turns the crank; peaks of what it gives, and
        the settled motion.
    """
    if "motor_torque" not in data:
        return Aspect()
    return Aspect(_answer(data), _lines(data), numbers=_numbers(data), leads=True)


def _answer(data: xr.Dataset) -> tuple[str, ...]:
    """Where the motor stalls, or how fast it turns the crank and how evenly."""
    known = data.attrs
    if "stall_angle" in known:
        angle = f"{DEGREES * known['stall_angle'] % 360:.4g} deg"
        needed = f"it gives the crank {known['stall_torque']:.4g} N m at rest, and "
        needed += f"{known['stall_needed']:.4g} N m would hold the linkage there"
        if not known["stall_time"]:
            return (f"The motor does not start: it stalls at {angle}, where {needed}.",)
        return (f"The motor stalls at {angle}, after {known['stall_time']:.4g} s: {needed}.",)
    if "elastic_settled_speed" in known:
        share, rigid = (
            rounded(100 * known[name], 0.0, 3)
            for name in ("elastic_settled_fluctuation", "settled_fluctuation")
        )
        speed = speed_with_unit(data, known["elastic_settled_speed"])
        return (
            f"Settled, the motor turns the linkage at {speed}, which fluctuates by {share} % of it "
            f"over the turn; with rigid links by {rigid} %.",
        )
    if "settled_speed" in known:
        share = rounded(100 * known["settled_fluctuation"], 0.0, 3)
        speed = speed_with_unit(data, known["settled_speed"])
        if not known["settled_in_run"]:
            end = speed_with_unit(data, known["crank_speed_of_run_end"])
            force, joint = _settled_force(data)
            return (
                f"The run ends at {end}, before the motor has settled: settled, it turns the rigid "
                f"linkage at {speed}, which fluctuates by {share} % of it over the turn, with "
                f"joint forces of up to {force}, at {joint}. What follows is of the run.",
            )
        return (
            f"Settled, the motor turns the rigid linkage at {speed}, which fluctuates by {share} % "
            "of it over the turn.",
        )
    end = abs(float(data["motor_speed"].isel(time=-1).max())) / known["gear_ratio"]
    return (
        f"The motor has brought the crank to {speed_with_unit(data, end)} after "
        f"{known['run_duration']:.4g} s; no speed at which it settles was found.",
    )


def _lines(data: xr.Dataset) -> tuple[str, ...]:
    """Peaks of what the motor gives, and the settled motion."""
    known = data.attrs
    peaks = ", ".join(
        f"{what} up to {_peaks(data, name)} {unit}"
        for name, what, unit in (
            ("motor_torque", "torque", "N m"),
            ("motor_speed", "speed", "rad/s"),
            ("motor_power", "power", "W"),
            ("motor_current", "current", "A"),
        )
        if name in data
    )
    lines = [f"motor on its own shaft: {peaks}"]
    if "first_current" in known:
        lines.append(_current_text(known))
    if "settled_speed" in known:
        for name, what in (("settled", "the rigid linkage"), ("elastic_settled", "elastic links")):
            if f"{name}_speed" not in known:
                continue
            lines.append(
                f"settled motion of {what}, found directly: mean speed "
                f"{speed_with_unit(data, known[f'{name}_speed'])}, coefficient of fluctuation "
                f"(greatest less least over mean) {rounded(known[f'{name}_fluctuation'], 0.0, 5)}, "
                f"mean power of the motor {_power(known[f'{name}_power'])} W"
            )
    elif "stall_angle" not in known:
        lines.append(
            "settled motion: none was found; no turn ends as it begins near the end of the run"
        )
    if "last_turn_speed" in data and bool(np.isfinite(data["last_turn_speed"]).all()):
        texts = ", ".join(
            f"{speed_with_unit(data, of_engine['last_turn_speed'])}, coefficient of fluctuation "
            f"{float(of_engine['last_turn_fluctuation']):.4g} ({of_engine['engine'].item()})"
            for _, of_engine in data.groupby("engine", squeeze=False)
            for of_engine in [of_engine.isel(engine=0)]
        )
        which = "only turn of the run, from rest" if _is_one_turn(data) else "last turn of the run"
        lines.append(f"{which}, with elastic links: mean speed {texts}")
    return tuple(lines)


def _is_one_turn(data: xr.Dataset) -> bool:
    """Whether the last turn of a run is its first, from rest."""
    turned = abs(float(data["crank_angle"][-1] - data["crank_angle"][0]))
    return "elastic_settled_speed" not in data.attrs and turned <= 2 * np.pi * (1 + _A_TURN)


def _numbers(data: xr.Dataset) -> tuple[Quantity, ...]:
    """Peaks of torque, power and current; settled speed and fluctuation, or the stall."""
    quantities = []
    for name, unit in (("motor_torque", "N m"), ("motor_power", "W"), ("motor_current", "A")):
        if name in data:
            sizes = abs(data[name]).max("time")
            value, apart = float(sizes.max()), float(sizes.max() - sizes.min())
            error = apart if "engine" in sizes.dims else _LEAST_ERROR * value
            quantities.append(Quantity(f"peak_{name}", value, unit, error))
    known = data.attrs
    if "stall_angle" in known:
        angle = DEGREES * float(known["stall_angle"])
        quantities.append(Quantity("stall_angle", angle, "deg", abs(angle) * _LEAST_ERROR))
    if "elastic_settled_speed" in known:
        # Engines that run on the motion that was found tell how far it is off.
        for name, of in (("settled_crank_speed", "speed"), ("speed_fluctuation", "fluctuation")):
            value = float(known[f"elastic_settled_{of}"])
            error = float(abs(data[f"last_turn_{of}"] - value).max())
            quantities.append(Quantity(name, value, "rad/s" if of == "speed" else "", error))
    elif "settled_speed" in known:
        speed, part = float(known["settled_speed"]), float(known["settled_fluctuation"])
        quantities.append(
            Quantity("settled_crank_speed", speed, "rad/s", abs(speed) * _LEAST_ERROR)
        )
        quantities.append(Quantity("speed_fluctuation", part, "", part * _LEAST_ERROR))
        force = float(data["settled_joint_force"].max())
        quantities.append(Quantity("settled_joint_force", force, "N", force * _BETWEEN))
    return tuple(quantities)


def _settled_force(data: xr.Dataset) -> tuple[str, str]:
    """Greatest joint force of the settled motion of the rigid linkage, and the joint."""
    greatest = data["settled_joint_force"].max("settled_angle")
    place = int(greatest.values.argmax())
    return f"{rounded(float(greatest[place]), 0.0, 4)} N", str(data["joint"].values[place])


def _current_text(known: Mapping[Hashable, Any]) -> str:
    """The current at time zero, and that which holds the crank then."""
    first, holding = (
        rounded(float(known[name]), 0.0, 4) for name in ("first_current", "holding_current")
    )
    if first == holding:
        held = f"holds the crank against its loads by its first current, {holding} A"
        return f"motor: {held}; state initial_current in [drive] motor for another"
    return f"motor: its first current is {first} A; {holding} A holds the crank against its loads"


def _peaks(data: xr.Dataset, name: str) -> str:
    """Greatest size of a variable, of each engine."""
    sizes = abs(data[name]).max("time")
    if "engine" not in sizes.dims:
        return rounded(float(sizes), 0.0, 5)
    return ", ".join(
        f"{rounded(float(force), 0.0, 5)} ({engine})"
        for force, engine in zip(sizes.values, data["engine"].values, strict=True)
    )


def _power(value: float) -> str:
    # A motor without losses takes none in the mean but for round-off.
    return f"{value:.4g}" if abs(value) > _LEAST_ERROR else "0"
