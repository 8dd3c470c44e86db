"""A law of motion of the crank: its speed and acceleration over time, and what they take."""

from __future__ import annotations

import xarray as xr

from flexmech.analyses.summary import Aspect, speed_with_unit
from flexmech.arrays import FloatArray
from flexmech.linkages import Drive, TableDrive


def law_values(drive: Drive, time: FloatArray, shaft_inertia: float) -> dict[str, FloatArray]:
    """Crank speed and acceleration over time, and the torque that the shaft's own inertia takes.

    Parameters
    ----------
    drive : Drive
    time : ndarray, shape (N,)
        In s.
    shaft_inertia : float
        In kg m^2; zero of a shaft that takes no torque.

    Returns
    -------
    dict of str to ndarray, shape (N,)
    """
    acceleration = drive.crank_acceleration(time)
    values = {
        "crank_speed_over_time": drive.crank_speed(time),
        "crank_acceleration": acceleration,
    }
    if shaft_inertia:
        values["shaft_inertia_torque"] = shaft_inertia * acceleration
    return values


def law_attributes(drive: Drive) -> dict[str, str | float]:
    """Attributes that tell a law of motion in words.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    dict
    """
    note = {"drive_note": drive.spline_words} if isinstance(drive, TableDrive) else {}
    return {"drive": drive.words, **note}


def law_aspect(data: xr.Dataset) -> Aspect:
    """Greatest speed and acceleration under a law, and what the shaft's own inertia takes.

    Parameters
    ----------
    data : xarray.Dataset

    Returns
    -------
    Aspect
        Nothing at constant speed.
    """
    if "crank_speed_over_time" not in data:
        return Aspect()
    speed, acceleration = (
        float(abs(data[name]).max()) for name in ("crank_speed_over_time", "crank_acceleration")
    )
    lines = [
        f"drive: {data.attrs.get('drive', 'run-up')}; crank speed up to "
        f"{speed_with_unit(data, speed)}, its acceleration up to {acceleration:.5g} rad/s²"
    ]
    if note := data.attrs.get("drive_note"):
        lines.append(str(note))
    if "shaft_inertia_torque" in data:
        whole = data["driving_torque"] + data["shaft_inertia_torque"]
        inertia, torque, power = (
            float(abs(one).max())
            for one in (data["shaft_inertia_torque"], whole, whole * data["crank_speed_over_time"])
        )
        lines.append(
            f"drive: the shaft's own inertia takes up to {inertia:.5g} N m besides the driving "
            f"torque, together {torque:.5g} N m and {power:.5g} W"
        )
    return Aspect(details=tuple(lines))
