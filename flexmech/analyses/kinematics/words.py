"""What kinematics says in words: the answer, what each place does and carries, all extremes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.digits import MOST_DIGITS, Quantity, percent, rounded
from flexmech.analyses.motor import motor_answer, motor_lines, motor_numbers
from flexmech.analyses.remarks import drive_words, speed_with_unit
from flexmech.analyses.shaking import harmonics_line, point_text
from flexmech.analyses.summary import Row, Summary, Table
from flexmech.arrays import ROUND_OFF

TRANSMISSION = {
    "transmission_angle": "transmission angle",
    "reversed_transmission_angle": "transmission angle with the rocker driving",
}
"""Angles that some linkages have, in words."""

# Details have a digit more than answers, as files of results are held against each other by them.
_DETAILED = MOST_DIGITS + 1
# Digits of the crank angle of an extreme: a tenth of a degree.
_ANGLE_DIGITS = 4
# Relative error of extremes: less is below the digits of all that is printed.
_TOLD = 1e-6
_MOTION_AND_FORCE = ("m/s", "at deg", "m/s²", "at deg", "N", "at deg")
_MM, _PER_RADIAN = 1e3, DEGREES


@dataclass(frozen=True)
class _Extreme:
    """Least and greatest value with their crank angles in degrees, and their error."""

    least: float
    least_at: float
    greatest: float
    greatest_at: float
    error: float

    def texts(self, factor: float = 1.0, most: int = MOST_DIGITS) -> tuple[str, str]:
        """Least and greatest value in another unit."""
        return self._text(self.least, factor, most), self._text(self.greatest, factor, most)

    @property
    def at(self) -> tuple[str, str]:
        """Crank angles of the least and the greatest value in degrees."""
        low, high = (f"{angle:.{_ANGLE_DIGITS}g}" for angle in (self.least_at, self.greatest_at))
        return low, high

    @property
    def span(self) -> float:
        """From the least value to the greatest."""
        return self.greatest - self.least

    @property
    def size(self) -> float:
        """Greatest absolute value."""
        return max(abs(self.least), abs(self.greatest))

    def peak(self, most: int = MOST_DIGITS) -> Row:
        """Greatest value and where."""
        return self.texts(1.0, most)[1], self.at[1]

    def range(self, what: str, unit: str, factor: float = 1.0) -> str:
        """Both values and where, in a line."""
        pairs = zip(self.texts(factor, _DETAILED), self.at, strict=True)
        return f"{what}: " + " to ".join(f"{value} {unit} (at {at} deg)" for value, at in pairs)

    def _text(self, value: float, factor: float, most: int) -> str:
        if abs(value) <= self.error:
            return "0"
        return rounded(factor * value, factor * self.error, most)


_Found = dict[tuple[str, str], _Extreme]


def _found(data: xr.Dataset) -> _Found:
    """Extremes by quantity and what it is of; what rounding leaves of others is in the error."""
    units, sizes = data["extreme_unit"].values.astype(str), dict[str, float]()
    peaks = np.maximum(abs(data["least"].values), abs(data["greatest"].values))
    for unit, peak in zip(units.tolist(), peaks.tolist(), strict=True):
        sizes[unit] = max(sizes.get(unit, 0.0), peak)
    # Torque comes from forces and arms.
    arm = float(abs(data["centre_position"]).max())
    sizes["N m"] = max(sizes["N m"], arm * sizes["N"])
    sizes["W"] = max(sizes["W"], sizes["N m"] * abs(float(data.attrs["crank_speed"])))
    noise = [ROUND_OFF * sizes[unit] for unit in units.tolist()]
    error = np.fmax(data["extreme_error"].values, noise)
    numbers = zip(
        data["least"].values.tolist(),
        (_PER_RADIAN * data["least_angle"].values).tolist(),
        data["greatest"].values.tolist(),
        (_PER_RADIAN * data["greatest_angle"].values).tolist(),
        error.tolist(),
        strict=True,
    )
    names = zip(data["extreme_quantity"].values, data["extreme_of"].values, strict=True)
    return {
        (str(name), str(of)): _Extreme(*row) for (name, of), row in zip(names, numbers, strict=True)
    }


def summary_of(data: xr.Dataset) -> Summary:
    """Answer, table, trust and details of a dataset of kinematics.

    Parameters
    ----------
    data : xarray.Dataset
        Of a ``Kinematics`` result.

    Returns
    -------
    Summary
    """
    if "least" not in data:
        return Summary(
            ("this file is of an earlier version, which kept no extremes: compute anew",)
        )
    found = _found(data)
    lumped = "lumped_joint_force" in data
    warning = str(data.attrs.get("warning", ""))
    return Summary(
        _answer(data, found),
        _table(data, found),
        _trust(data),
        (_link_table(data, found), _joint_table(data, found, lumped), *_lines(data, found, lumped)),
        (warning,) if warning else (),
        _numbers(data, found),
    )


def _answer(data: xr.Dataset, found: _Found) -> tuple[str, ...]:
    """Strokes, or the swing; the transmission angle; forces, torque and power."""
    said = [_stroke_text(slider, found) for slider in _sliders(data)]
    angle = found.get(("transmission_angle", ""))
    if angle is not None:
        low, high = angle.texts(_PER_RADIAN)
        text = f"the transmission angle is {low} to {high} deg"
        if "rocker_swing" in data:
            text = f"the rocker swings through {_swing(data).value:.4g} deg; {text}"
        said.append(f"{text[0].upper()}{text[1:]}.")
    joint = _most_loaded(data, found)
    force, torque = found["joint_force", joint], found["driving_torque", ""]
    low, high = torque.texts()
    if force.size <= force.error:
        said.append("Nothing acts on the links: no joint carries a force.")
    else:
        driven = f"is {low} to {high}" if torque.span > torque.error else f"is {high}"
        said.append(
            f"The greatest joint force is {force.peak()[0]} N, at {joint}; the driving torque "
            f"{driven} N m."
        )
    power = found["driving_power", ""]
    if "time" in data.dims and power.span > power.error:
        low, high = power.texts()
        said.append(f"The shaft gives {low} to {high} W.")
    if _mean_text(data, found) not in ("", "0"):
        said.append(f"The shaft gives {_mean_text(data, found)} W on average.")
    motor = motor_answer(data)
    most = 3 - len(motor)
    return (*motor, *(said[-most:] if len(said) > most else said))


def _stroke_text(slider: str, found: _Found) -> str:
    place, speed, acceleration = (
        found[f"slider_{name}", slider] for name in ("position", "velocity", "acceleration")
    )
    low, high = place.texts(_MM)
    if place.span <= place.error:
        return f"{slider} stands at {high} mm along its line."
    stroke = rounded(_MM * place.span, _MM * place.error)
    text = f"{slider} strokes {stroke} mm, from {low} to {high} mm along its line"
    if speed.size <= speed.error:
        return f"{text}."
    fastest = rounded(speed.size, speed.error)
    return (
        f"{text}, at up to {fastest} m/s and {rounded(acceleration.size, acceleration.error)} m/s²."
    )


def _table(data: xr.Dataset, found: _Found) -> Table:
    """A row for each joint and each other point: how it moves, and which force it carries."""
    kinds = dict(zip(_names(data, "joint"), data["joint_kind"].values.tolist(), strict=True))
    places = dict.fromkeys([*kinds, *_names(data, "point")])
    rows, slides = [], bool(_sliders(data))
    for name in places:
        stroke = found.get(("slider_position", name))
        length = "" if stroke is None else rounded(_MM * stroke.span, _MM * stroke.error)
        moves = [found.get((what, name)) for what in ("velocity", "acceleration", "joint_force")]
        cells = (text for each in moves for text in (each.peak() if each else ("", "")))
        rows.append((name, str(kinds.get(name, "point")), *[length] * slides, *cells))
    if ("shaking_force", "") in found:
        shaking = found["shaking_force", ""].peak()
        rows.append(("frame", "shaking", *[""] * slides, "", "", "", "", *shaking))
    return Table(
        f"greatest values {_range_text(data)}, {data.attrs['mechanism']} "
        f"{drive_words(data.attrs)}{_acceleration_text(data)}",
        ("place", "kind", *["stroke mm"] * slides, *_MOTION_AND_FORCE),
        (tuple(rows),),
        text_columns=2,
    )


def _range_text(data: xr.Dataset) -> str:
    """From where to where, in crank angle or in time."""
    if "time" in data.dims:
        return f"in {float(data['time'][-1]):.6g} s"
    angles = data["crank_angle"].values
    first, last = (f"{_PER_RADIAN * angle:.6g}" for angle in (angles[0], angles[-1]))
    return f"at crank angle {first} deg" if first == last else f"from {first} to {last} deg"


def _link_table(data: xr.Dataset, found: _Found) -> Table:
    """Motion of the links."""
    names = ("angular_velocity", "angular_acceleration", "centre_acceleration")
    rows = (
        (link, *(text for name in names for text in found[name, link].peak(_DETAILED)))
        for link in _names(data, "link")
    )
    headings = ("link", "rad/s", "at deg", "rad/s²", "at deg", "centre m/s²", "at deg")
    return Table("greatest values of the links", headings, (tuple(rows),))


def _joint_table(data: xr.Dataset, found: _Found, lumped: bool) -> Table:
    """Joint forces, of what on what, by lumped masses too."""
    names = ["joint_force", *(["lumped_joint_force"] * lumped)]
    said = ("joint", "joint_kind", "force_by", "force_on")
    rows = (
        (
            *(str(data.sel(joint=joint)[name].item()) for name in said),
            *(text for name in names for text in found[name, joint].peak(_DETAILED)),
        )
        for joint in _names(data, "joint")
    )
    return Table(
        "greatest joint forces",
        ("joint", "kind", "of", "on", "N", "at deg", *(("lumped N", "at deg") * lumped)),
        (tuple(rows),),
        text_columns=4,
    )


def _lines(data: xr.Dataset, found: _Found, lumped: bool) -> list[str]:
    """Torque, power, transmission angles, and the ranges of sliders and points."""
    lines = [found["driving_torque", ""].range("driving torque", "N m")]
    if lumped:
        what = f"driving torque by {data.sizes['lump']} lumped masses"
        lines.append(found["lumped_driving_torque", ""].range(what, "N m"))
    lines.append(found["driving_power", ""].range("driving power", "W"))
    lines += [*_law_lines(data), *motor_lines(data)]
    if shaft := float(data.attrs.get("shaft_inertia_torque", 0.0)):
        lines.append(f"driving torque: the shaft's own inertia takes {shaft:.5g} N m besides")
    if mean := _mean_text(data, found):
        lines.append(f"mean driving power over the turn: {mean} W")
    if ("shaking_force", "") in found:
        lines.append(found["shaking_force", ""].range("shaking force on the frame", "N"))
        what = f"shaking moment on the frame about {point_text(data)}"
        lines.append(found["shaking_moment", ""].range(what, "N m"))
    if "order" in data:
        lines.append(harmonics_line(data))
    lines += [
        found[angle, ""].range(words, "deg", _PER_RADIAN)
        for angle, words in TRANSMISSION.items()
        if (angle, "") in found
    ]
    along = {"position": ("mm", _MM), "velocity": ("m/s", 1.0), "acceleration": ("m/s²", 1.0)}
    for slider in _sliders(data):
        for name, (unit, factor) in along.items():
            what = f"{slider}: {name} along its line"
            lines.append(found[f"slider_{name}", slider].range(what, unit, factor))
    for point in _names(data, "point"):
        x, y = (found[f"position_{axis}", point].texts(_MM, _DETAILED) for axis in "xy")
        lines.append(f"{point}: x {x[0]} to {x[1]} mm, y {y[0]} to {y[1]} mm")
    return lines


def _law_lines(data: xr.Dataset) -> list[str]:
    """Greatest speed and acceleration under a law, and what the shaft's own inertia takes."""
    if "time" not in data.dims:
        return []
    speed, acceleration = (
        float(abs(data[name]).max()) for name in ("crank_speed_over_time", "crank_acceleration")
    )
    lines = [
        f"crank: speed up to {speed_with_unit(data, speed)}, acceleration up to "
        f"{acceleration:.5g} rad/s²"
    ]
    if "shaft_inertia_torque" in data:
        whole = data["driving_torque"] + data["shaft_inertia_torque"]
        torque, power = (
            float(abs(one).max()) for one in (whole, whole * data["crank_speed_over_time"])
        )
        lines.append(
            f"drive: with the shaft's own inertia up to {torque:.5g} N m and {power:.5g} W"
        )
    return lines + [str(note) for note in [data.attrs.get("drive_note")] if note]


def _trust(data: xr.Dataset) -> str:
    """How far extremes are known; equations of rigid links have no mesh and no engine."""
    error, least, greatest = (data[name].values for name in ("extreme_error", "least", "greatest"))
    sizes = np.maximum(np.maximum(abs(least), abs(greatest)), np.finfo(float).tiny)
    if not np.isfinite(error).all():
        return (
            "values are of the crank angles asked for alone: between them the linkage cannot be "
            "moved; links are rigid here"
        )
    # What is zero but for round-off has no relative error.
    known = np.where(sizes > ROUND_OFF, error / sizes, 0.0)
    return f"numbers are known to {percent(max(float(known.max()), _TOLD))}; links are rigid here"


def _numbers(data: xr.Dataset, found: _Found) -> tuple[Quantity, ...]:
    """The numbers of the answer."""
    numbers = []
    for slider in _sliders(data):
        place = found["slider_position", slider]
        numbers.append(Quantity("stroke", _MM * place.span, "mm", _MM * place.error, slider))
        for name, unit in (("velocity", "m/s"), ("acceleration", "m/s^2")):
            along = found[f"slider_{name}", slider]
            numbers.append(Quantity(f"peak_{name}", along.size, unit, along.error, slider))
    joint = _most_loaded(data, found)
    force, torque = found["joint_force", joint], found["driving_torque", ""]
    numbers.append(Quantity("peak_joint_force", force.greatest, "N", force.error, joint))
    numbers.append(Quantity("peak_driving_torque", torque.size, "N m", torque.error))
    if "time" in data.dims:
        power = found["driving_power", ""]
        numbers.append(Quantity("peak_driving_power", power.size, "W", power.error))
    for name, unit in (("shaking_force", "N"), ("shaking_moment", "N m")):
        if (shaking := found.get((name, ""))) is not None:
            numbers.append(Quantity(f"peak_{name}", shaking.size, unit, shaking.error, "frame"))
    if (angle := found.get(("transmission_angle", ""))) is not None:
        error = _PER_RADIAN * angle.error
        for name in ("least", "greatest"):
            value = _PER_RADIAN * getattr(angle, name)
            numbers.append(Quantity(f"{name}_transmission_angle", value, "deg", error))
    if "rocker_swing" in data:
        numbers.append(_swing(data))
    if (mean := _mean(data, found)) is not None:
        numbers.append(mean)
    return (*numbers, *motor_numbers(data))


def _swing(data: xr.Dataset) -> Quantity:
    value = _PER_RADIAN * data["rocker_swing"].item()
    return Quantity("rocker_swing", value, "deg", ROUND_OFF * value, "rocker")


def _most_loaded(data: xr.Dataset, found: _Found) -> str:
    return max(_names(data, "joint"), key=lambda joint: found["joint_force", joint].greatest)


def _mean(data: xr.Dataset, found: _Found) -> Quantity | None:
    """Mean power over whole turns."""
    if "mean_driving_power" not in data:
        return None
    mean, error = (data[f"mean_driving_power{end}"].item() for end in ("", "_error"))
    # Round-off of power that is zero at all angles is that of forces and speeds.
    return Quantity("mean_driving_power", mean, "W", max(error, found["driving_power", ""].error))


def _mean_text(data: xr.Dataset, found: _Found) -> str:
    """Mean power in W, 0 where its error is larger; empty where the angles are no whole turns."""
    mean = _mean(data, found)
    if mean is None:
        return ""
    return "0" if abs(mean.value) <= mean.error else rounded(mean.value, mean.error)


def _sliders(data: xr.Dataset) -> list[str]:
    return _names(data, "slider")


def _names(data: xr.Dataset, of: str) -> list[str]:
    """Names along a coordinate; none where there is no such thing."""
    return [str(name) for name in data[of].values] if of in data.coords else []


def _acceleration_text(data: xr.Dataset) -> str:
    """Acceleration of the crank in words; nothing where its speed is constant."""
    acceleration = data.attrs.get("crank_acceleration")
    return "" if acceleration is None else f" and {float(acceleration):.6g} rad/s²"
