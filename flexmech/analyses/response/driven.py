"""A run by a law of motion: speed, power, and what rings after the stop, in numbers and words.

A run under a motor: its engines, what the motor gives, and how the crank runs up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.analyses.aspects.law import law_attributes, law_values
from flexmech.analyses.aspects.motor import (
    last_turn,
    motor_attributes,
    motor_values,
    settled_values,
)
from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.response.agreement import best_known, errors_of, quantities_of
from flexmech.analyses.response.measurements import deflections, peaks_between
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.residual_vibration import LEAST_SAMPLES, StandingModes, edges, rests
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import Aspect
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.hygrothermal import Environment, mechanism_in_state
from flexmech.linkages import ConstantSpeed, MotorRun
from flexmech.linkages.motors.integrated_run import states_along
from flexmech.mechanics import Engine
from flexmech.mechanics.running import Trajectory
from flexmech.mechanism import with_motor_run


def law_of_run(engine: Engine, request: ResponseRequest) -> Values:
    """Speed and acceleration of the crank over time, and what its shaft's own inertia takes.

    Parameters
    ----------
    engine : Engine
    request : ResponseRequest

    Returns
    -------
    dict
        Empty of a run at constant speed.
    """
    drive, time = request.drive, request.sample_time()
    if drive.is_constant:
        return {}
    # Of a free shaft the driving torque is what the shaft is given, its inertia's share included.
    inertia = engine.mechanism.shaft_inertia if engine.shaft == "prescribed" else 0.0
    values: Values = {**law_values(drive, time, inertia)}
    if isinstance(drive, MotorRun):
        values |= settled_values(drive, engine.mechanism)
    return values


def drive_attributes(request: ResponseRequest) -> dict[str, str | float]:
    """Attributes that tell the drive: its speed, or the greatest one of a law and its words.

    Parameters
    ----------
    request : ResponseRequest

    Returns
    -------
    dict
        ``drive`` and ``crank_speed_at_end`` of a law or a table alone.
    """
    drive = request.drive
    if isinstance(drive, ConstantSpeed) or drive.is_constant:
        return {"crank_speed": drive.speed}
    told = {"crank_speed": drive.greatest_speed, **law_attributes(drive)}
    if isinstance(drive, MotorRun):
        told |= motor_attributes(drive)
    return told | {"crank_speed_at_end": drive.speed}


def spectra_from(request: ResponseRequest) -> float:
    """Time in s from which on spectra are made.

    From the final speed on, or from the stop; of a run that ends with its law from the start.
    """
    after = request.duration - request.drive.law_time
    return request.drive.law_time if after >= LEAST_SAMPLES * request.sample_interval else 0.0


def driven_values(refined: Trajectory, request: ResponseRequest, refinement: int) -> Values:
    """Power of the drive along a run by a law of motion.

    Parameters
    ----------
    refined : Trajectory
        At the refined samples.
    request : ResponseRequest
    refinement : int
        Refined samples for each one asked for.

    Returns
    -------
    dict
        Empty of a run at constant speed.
    """
    drive, time = request.drive, refined.time
    if drive.is_constant:
        return {}
    speed = drive.crank_speed(time)
    if refined.shaft is not None:
        speed = speed + refined.shaft.rate
    power = refined.driving_torque * speed
    return {
        "driving_power": power[::refinement],
        "peak_driving_power": peaks_between(power[:, None], time)[0][0],
    }


def residual_values(
    engine: Engine, refined: Trajectory, request: ResponseRequest, refinement: int
) -> Values:
    """The vibration that is left after a stop: edges of each deflection, amplitude of each mode.

    Parameters
    ----------
    engine : Engine
    refined, request, refinement
        As of :func:`driven_values`.

    Returns
    -------
    dict
        Empty where nothing stops: a free shaft does not stop with the law.
    """
    if request.drive.is_constant or refined.shaft is not None or not rests(request):
        return {}
    begin, sampled = request.drive.law_time, refined.time[::refinement]
    after, shown = refined.time >= begin, sampled >= begin
    time, at = refined.time[after] - begin, sampled[shown] - begin
    # At the stop and at the end of the rest besides the samples that are kept.
    at = np.concatenate([time[:1], at, time[-1:]])
    bent = deflections(engine, refined.displacement)[after]
    modes = StandingModes.of(engine, request)
    waves = modes.waves(refined, begin)
    period = 1 / float(modes.frequency[0])
    of_links = [
        edges(at, time, own, wave, modes.decay, modes.angular_frequency, period)
        for own, wave in zip(bent.T, waves, strict=True)
    ]
    lower, upper = np.moveaxis(np.array(of_links), 0, -1)
    amplitude = (upper - lower) / 2
    envelope, middle = np.full((2, len(sampled), bent.shape[1]), np.nan)
    envelope[shown], middle[shown] = amplitude[1:-1], (upper + lower)[1:-1] / 2
    return {
        "residual_envelope": envelope,
        "residual_middle": middle,
        "residual_amplitude": amplitude[0],
        "residual_amplitude_at_end": amplitude[-1],
        "standing_frequency": modes.frequency,
        "standing_damping_ratio": modes.damping_ratio,
        "modal_amplitude": np.abs(waves),
        "mode": np.arange(1, len(modes.frequency) + 1),
    }


_NAMES = ("residual_amplitude", "residual_amplitude_at_end")
_MM = 1e3


def _errors(data: xr.Dataset) -> xr.DataArray:
    """Error of a residual amplitude in m, over (engine, link): that of the deflections."""
    return errors_of(data)["deflection"] * data["peak_deflection"]


def residual_numbers(data: xr.Dataset) -> tuple[Quantity, ...]:
    """Residual amplitude of each link after the stop and at the end of the rest, peak power.

    Of the engine whose deflections have the smaller errors; the difference of two engines is an
    error too.

    Parameters
    ----------
    data : xarray.Dataset
        Of a response.

    Returns
    -------
    tuple of Quantity
        None of a run at constant speed.
    """
    if "peak_driving_power" not in data:
        return ()
    known, power = errors_of(data), data["peak_driving_power"]
    place = best_known(known["deflection"])
    own = known["peak_driving_torque"] * power
    found = quantities_of(power, own, place, "peak_driving_power", "W", 1.0)
    if _NAMES[0] not in data:
        return tuple(found)
    bent = {"link": data["peak_deflection"].max("engine") > 0}
    for name in _NAMES:
        found += quantities_of(data[name][bent], _errors(data)[bent], place, name, "mm", _MM)
    return tuple(found)


def residual_aspect(data: xr.Dataset) -> Aspect:
    """The power that a law of motion takes, and what rings after the stop.

    Parameters
    ----------
    data : xarray.Dataset
        Of a response.

    Returns
    -------
    Aspect
        Nothing of a run at constant speed; no answer where that of a shaped law has it.
    """
    if "driving_power" not in data:
        return Aspect()
    numbers = residual_numbers(data)
    answer = () if "shaped_residual_amplitude" in data else _answer(data, numbers)
    return Aspect(answer, tuple(_lines(data)), numbers=numbers)


def _answer(data: xr.Dataset, found: tuple[Quantity, ...]) -> tuple[str, ...]:
    """How far the link that rings most does after the stop; nothing where nothing stops."""
    ringing = [one for one in found if one.name == _NAMES[0]]
    if not ringing:
        return ()
    most = max(ringing, key=lambda one: one.value)
    left = next(one for one in found if one.name == _NAMES[1] and one.of == most.of)
    rest = float(data["time"][-1]) - float(data.attrs["run_up_time"])
    return (f"After the stop the {most.of} rings by {most}, after {rest:.3g} s of rest by {left}.",)


def _lines(data: xr.Dataset) -> list[str]:
    """The power that a law takes, and what rings after the stop."""
    engines = [str(name) for name in data["engine"].values]
    powers = ", ".join(
        f"{rounded(float(one), 0.0, 5)} W ({name})"
        for one, name in zip(data["peak_driving_power"].values, engines, strict=True)
    )
    lines = [f"peak driving power: {powers}"]
    if _NAMES[0] not in data:
        if not data.attrs.get("crank_speed_at_end", 1.0) and "shaft_rotation" not in data:
            lines.append("residual vibration: none is seen without a dwell; give one in the drive")
        return lines
    for name in engines:
        own_values = data.sel(engine=name)
        texts = [
            f"{link} {rounded(_MM * float(first), 0.0, 4)} to {rounded(_MM * float(last), 0.0, 4)}"
            for link, first, last in zip(
                data["link"].values, *(own_values[one].values for one in _NAMES), strict=True
            )
            if first > 0
        ]
        lines.append(
            f"residual vibration from the stop to the end of the rest: {', '.join(texts)} mm "
            f"({name})"
        )
        lines.append(f"modes after the stop: {_mode_texts(own_values)} ({name})")
    return lines


def _mode_texts(data: xr.Dataset) -> str:
    """Frequency of each mode of the standing linkage, and how much of it each link shows."""
    bent = data["link"].values[data["peak_deflection"].values > 0]
    texts = []
    for mode in data["mode"].values:
        one = data.sel(mode=mode)
        frequency = f"{float(one['standing_frequency']):.5g} Hz"
        amplitude = one["modal_amplitude"].sel(link=bent)
        if float(one["standing_damping_ratio"]) >= 1:
            texts.append(f"{frequency} damped too heavily to vibrate")
        elif amplitude.isnull().any():
            texts.append(f"{frequency} not seen in less than a period of rest")
        else:
            shown = ", ".join(
                f"{link} {rounded(_MM * float(value), 0.0, 3)}"
                for link, value in zip(bent, amplitude.values, strict=True)
            )
            texts.append(f"{frequency} {shown} mm")
    return "; ".join(texts)


def with_motor(
    engines: Sequence[Engine], request: ResponseRequest, environment: Environment | None
) -> tuple[list[Engine], ResponseRequest]:
    """Engines whose shaft is free and has the motor's rotor, and the request of a run with them.

    Parameters
    ----------
    engines : sequence of Engine
        Of one mechanism.
    request : ResponseRequest
    environment : HygrothermalState or Exposure, optional
        In which the rigid linkage has other lengths and masses.

    Returns
    -------
    list of Engine
    ResponseRequest
        Both as they are where there is no motor.

    Raises
    ------
    InputError
        If the motor does not move the linkage.
    """
    run = request.drive
    if not isinstance(run, MotorRun):
        return list(engines), request
    mechanism = engines[0].mechanism
    if environment is not None:
        wet = mechanism_in_state(mechanism, environment)
        request = replace(request, speed=run.drive).of(wet)
        run = request.drive
        assert isinstance(run, MotorRun)
    if run.stall is not None and run.stall.time == 0:
        raise InputError(
            f"drive: the motor does not start: at {np.degrees(run.stall.crank_angle):.4g} deg it "
            f"gives the crank {run.stall.torque:.4g} N m at rest, and {run.stall.needed:.4g} N m "
            "would hold the linkage there; there is no run of elastic links: give a stronger "
            "motor or another start_angle"
        )
    own = with_motor_run(mechanism, run)
    return [engine.with_(mechanism=own, shaft="free") for engine in engines], request


def motor_of_run(
    refined: Trajectory, request: ResponseRequest, refinement: int
) -> tuple[Values, FloatArray | None]:
    """What the motor gives in a run, and how evenly the crank turns in its last turn.

    Parameters
    ----------
    refined : Trajectory
        At the refined samples.
    request : ResponseRequest
    refinement : int
        Refined samples for each one asked for.

    Returns
    -------
    dict
        Empty without a motor.
    ndarray, shape (N,), or None
        Rate of the angular momentum of the rotor in N m at the samples asked for.
    """
    from scipy.interpolate import CubicSpline

    run, shaft = request.drive, refined.shaft
    if not isinstance(run, MotorRun) or shaft is None:
        return {}, None
    time = refined.time
    speed = run.crank_speed(time) + shaft.rate
    angle = run.crank_angle(time) + shaft.rotation
    train = run.equation.train
    states = states_along(train, time, angle, speed, run.states(0.0))
    given = train.motor_output(speed, states)
    values = motor_values(run, given, train.rotor_speed(speed, states))
    # The rotor turns with a frame on springs as well.
    spin = 0.0 if refined.frame is None else refined.frame.rate[:, 2]
    momentum = CubicSpline(time, train.motor.inertia * (values["motor_speed"] + spin))
    mean, fluctuation = last_turn(angle, speed, time)
    told: Values = {name: of_time[::refinement] for name, of_time in values.items()}
    told |= {"last_turn_speed": mean, "last_turn_fluctuation": fluctuation}
    return told, np.asarray(momentum(time[::refinement], 1))
