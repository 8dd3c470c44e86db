"""The result of kinematics: strokes, greatest forces and torque, and all extremes in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from flexmech import plots
from flexmech.analyses.aspects.law import law_aspect
from flexmech.analyses.aspects.motor import motor_aspect
from flexmech.analyses.aspects.motor_choice import motor_choice_aspect
from flexmech.analyses.aspects.shaking import harmonics_line, point_text
from flexmech.analyses.aspects.sizing import sizing_aspect
from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.digits import MOST_DIGITS, Quantity, percent, rounded
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Aspect, Row, Summary, Table, drive_words
from flexmech.arrays import ROUND_OFF

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Details have a digit more than answers, as files of results are held against each other by them.
_DETAILED = MOST_DIGITS + 1
# Digits of the crank angle of an extreme: a tenth of a degree.
_ANGLE_DIGITS = 4
# Relative error of extremes: less is below the digits of all that is printed.
_LEAST_ERROR = 1e-6
_MOTION_AND_FORCE = ("m/s", "at deg", "m/s²", "at deg", "N", "at deg")
_MM, _PER_RADIAN = 1e3, DEGREES
# The answer has so many sentences at most.
_SENTENCES = 3
# Units in which the table of extremes has others.
_SHOWN = {
    "m": (_MM, "mm"),
    "rad": (_PER_RADIAN, "deg"),
    "m/s^2": (1.0, "m/s²"),
    "rad/s^2": (1.0, "rad/s²"),
}


class Kinematics(Result):
    """Motion of the rigid linkage over the crank angle, and the forces that it takes.

    Parameters
    ----------
    dataset : xarray.Dataset
        The variables of ``schema.toml``: of links, joints, points, sliders and lumped masses over
        the crank angle, or over time under a law of motion; over ``extreme`` the least and the
        greatest value of what ``extreme_quantity`` and ``extreme_of`` name, sought between the
        angles too. The attributes ``crank_speed``, and where the crank accelerates
        ``crank_acceleration`` in rad/s^2 and ``shaft_inertia_torque`` in N m, which the shaft's own
        inertia takes besides the driving torque.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "kinematics"
    subject = "kinematics and joint forces"
    hallmark = "angular_acceleration"

    def tabulated(self) -> xr.Dataset:
        """The dataset with sliders among the points, and the acceleration asked for."""
        data = self.dataset
        asked = data.attrs.get("crank_acceleration")
        if asked is not None:
            data = data.assign(crank_acceleration_asked=float(asked))
        if "slider" not in data:
            return data
        along = {
            f"{name}_along": data[f"slider_{name}"]
            .rename(slider="point")
            .reindex(point=data["point"].values)
            for name in ("position", "velocity", "acceleration")
        }
        return data.assign(along)

    def pictures(self) -> list[str]:
        """Names of the pictures; none of points that do nothing but turn with the crank."""
        moves = bool(plots.drawn_points(self.dataset))
        return [name for name in super().pictures() if moves or name != "motion"]

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw angles, angular velocities and accelerations of the links.

        Parameters
        ----------
        ax : sequence of matplotlib.axes.Axes, optional
            Three of the user's.
        """
        return plots.plot_kinematics(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Strokes, greatest forces and torque; what each place does and carries; all extremes."""
        data = self.dataset
        extremes, warning = _found(data), str(data.attrs.get("warning", ""))
        table = (_extremes_table(data, extremes),)
        rigid = Aspect(
            _answer(data, extremes), table, (warning,) if warning else (), _numbers(data, extremes)
        )
        others = (
            motor_choice_aspect(data),
            _notes(data, extremes),
            sizing_aspect(data),
            law_aspect(data),
            motor_aspect(data),
        )
        return Summary.of((rigid, *others), _table(data, extremes), _trust(data), most=_SENTENCES)


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

    @property
    def peak(self) -> Row:
        """Greatest value and where."""
        return self.texts()[1], self.at[1]

    def _text(self, value: float, factor: float, most: int) -> str:
        if abs(value) <= self.error:
            return "0"
        return rounded(factor * value, factor * self.error, most)


_Extremes = dict[tuple[str, str], _Extreme]


def _found(data: xr.Dataset) -> _Extremes:
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


def _answer(data: xr.Dataset, extremes: _Extremes) -> tuple[str, ...]:
    """Strokes, or the swing; the transmission angle; forces, torque and power."""
    said = [_stroke_text(slider, extremes) for slider in _sliders(data)]
    angle = extremes.get(("transmission_angle", ""))
    if angle is not None:
        low, high = angle.texts(_PER_RADIAN)
        text = f"the transmission angle is {low} to {high} deg"
        if "rocker_swing" in data:
            text = f"the rocker swings through {_swing(data).value:.4g} deg; {text}"
        said.append(f"{text[0].upper()}{text[1:]}.")
    joint = _most_loaded(data, extremes)
    force, torque = extremes["joint_force", joint], extremes["driving_torque", ""]
    low, high = torque.texts()
    if force.size <= force.error:
        said.append("Nothing acts on the links: no joint carries a force.")
    else:
        driven = f"is {low} to {high}" if torque.span > torque.error else f"is {high}"
        said.append(
            f"The greatest joint force is {force.peak[0]} N, at {joint}; the driving torque "
            f"{driven} N m."
        )
    power = extremes["driving_power", ""]
    if "time" in data.dims and power.span > power.error:
        low, high = power.texts()
        said.append(f"The shaft gives {low} to {high} W.")
    if _mean_text(data, extremes) not in ("", "0"):
        said.append(f"The shaft gives {_mean_text(data, extremes)} W on average.")
    return tuple(said)


def _stroke_text(slider: str, extremes: _Extremes) -> str:
    place, speed, acceleration = (
        extremes[f"slider_{name}", slider] for name in ("position", "velocity", "acceleration")
    )
    low, high = place.texts(_MM)
    if place.span <= place.error:
        return f"Slider {slider} stands at {high} mm along its line."
    stroke = rounded(_MM * place.span, _MM * place.error)
    text = f"Slider {slider} has a stroke of {stroke} mm, from {low} to {high} mm along its line"
    if speed.size <= speed.error:
        return f"{text}."
    fastest = f"{rounded(speed.size, speed.error)} m/s"
    return (
        f"{text}; it reaches {fastest} and {rounded(acceleration.size, acceleration.error)} m/s²."
    )


def _table(data: xr.Dataset, extremes: _Extremes) -> Table:
    """A row for each joint and each other point: how it moves, and which force it carries."""
    kinds = dict(zip(_names(data, "joint"), data["joint_kind"].values.tolist(), strict=True))
    places = dict.fromkeys([*kinds, *_names(data, "point")])
    rows, slides = [], bool(_sliders(data))
    for name in places:
        stroke = extremes.get(("slider_position", name))
        length = "" if stroke is None else rounded(_MM * stroke.span, _MM * stroke.error)
        moves = [extremes.get((what, name)) for what in ("velocity", "acceleration", "joint_force")]
        cells = (text for each in moves for text in (each.peak if each else ("", "")))
        rows.append((name, str(kinds.get(name, "point")), *[length] * slides, *cells))
    if ("shaking_force", "") in extremes:
        shaking = extremes["shaking_force", ""].peak
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


def _extremes_table(data: xr.Dataset, extremes: _Extremes) -> Table:
    """Least and greatest value of every quantity, and where; to the digits that are known."""
    rows = []
    for ((name, of), one), unit in zip(extremes.items(), data["extreme_unit"].values, strict=True):
        factor, shown = _SHOWN.get(str(unit), (1.0, str(unit)))
        pairs = zip(one.texts(factor, _DETAILED), one.at, strict=True)
        cells = (text for pair in pairs for text in pair)
        rows.append((of or "linkage", f"{name.replace('_', ' ')} {shown}", *cells))
    headings = ("of", "quantity", "least", "at deg", "greatest", "at deg")
    title = "least and greatest values, magnitudes of vectors"
    return Table(title, headings, (tuple(rows),), text_columns=2)


def _notes(data: xr.Dataset, extremes: _Extremes) -> Aspect:
    """Remarks beside the table of extremes: moment point, mean power, lumped masses."""
    lines = []
    if "lump" in data.dims:
        lines.append(f"lumped: by {data.sizes['lump']} masses")
    if shaft := float(data.attrs.get("shaft_inertia_torque", 0.0)):
        lines.append(f"driving torque: the shaft's own inertia takes {shaft:.5g} N m besides")
    if mean := _mean_text(data, extremes):
        lines.append(f"mean driving power over the turn: {mean} W")
    lines.append(f"shaking moment: about {point_text(data)}")
    if "order" in data:
        lines.append(harmonics_line(data))
    return Aspect(details=tuple(lines))


def _trust(data: xr.Dataset) -> str:
    """How far extremes are known; equations of rigid links have no mesh and no engine."""
    error, least, greatest = (data[name].values for name in ("extreme_error", "least", "greatest"))
    sizes = np.maximum(np.maximum(abs(least), abs(greatest)), np.finfo(float).tiny)
    if not np.isfinite(error).all():
        return (
            "values hold at the given crank angles only, because the linkage cannot move between "
            "them; links are rigid here"
        )
    # What is zero but for round-off has no relative error.
    known = max(float(np.where(sizes > ROUND_OFF, error / sizes, 0.0).max()), _LEAST_ERROR)
    return f"numbers are known to {percent(known)}; links are rigid here"


def _numbers(data: xr.Dataset, extremes: _Extremes) -> tuple[Quantity, ...]:
    """The numbers of the answer."""
    numbers = []
    for slider in _sliders(data):
        place = extremes["slider_position", slider]
        numbers.append(Quantity("stroke", _MM * place.span, "mm", _MM * place.error, slider))
        for name, unit in (("velocity", "m/s"), ("acceleration", "m/s^2")):
            along = extremes[f"slider_{name}", slider]
            numbers.append(Quantity(f"peak_{name}", along.size, unit, along.error, slider))
    joint = _most_loaded(data, extremes)
    force, torque = extremes["joint_force", joint], extremes["driving_torque", ""]
    numbers.append(Quantity("peak_joint_force", force.greatest, "N", force.error, joint))
    numbers.append(Quantity("peak_driving_torque", torque.size, "N m", torque.error))
    if "time" in data.dims:
        power = extremes["driving_power", ""]
        numbers.append(Quantity("peak_driving_power", power.size, "W", power.error))
    for name, unit in (("shaking_force", "N"), ("shaking_moment", "N m")):
        if (shaking := extremes.get((name, ""))) is not None:
            numbers.append(Quantity(f"peak_{name}", shaking.size, unit, shaking.error, "frame"))
    if (angle := extremes.get(("transmission_angle", ""))) is not None:
        error = _PER_RADIAN * angle.error
        for name in ("least", "greatest"):
            value = _PER_RADIAN * getattr(angle, name)
            numbers.append(Quantity(f"{name}_transmission_angle", value, "deg", error))
    if "rocker_swing" in data:
        numbers.append(_swing(data))
    if (mean := _mean(data, extremes)) is not None:
        numbers.append(mean)
    return tuple(numbers)


def _swing(data: xr.Dataset) -> Quantity:
    value = _PER_RADIAN * data["rocker_swing"].item()
    return Quantity("rocker_swing", value, "deg", ROUND_OFF * value, "rocker")


def _most_loaded(data: xr.Dataset, extremes: _Extremes) -> str:
    return max(_names(data, "joint"), key=lambda joint: extremes["joint_force", joint].greatest)


def _mean(data: xr.Dataset, extremes: _Extremes) -> Quantity | None:
    """Mean power over whole turns."""
    if "mean_driving_power" not in data:
        return None
    mean, error = (data[f"mean_driving_power{end}"].item() for end in ("", "_error"))
    # Round-off of power that is zero at all angles is that of forces and speeds.
    return Quantity(
        "mean_driving_power", mean, "W", max(error, extremes["driving_power", ""].error)
    )


def _mean_text(data: xr.Dataset, extremes: _Extremes) -> str:
    """Mean power in W, 0 where its error is larger; empty where the angles are no whole turns."""
    mean = _mean(data, extremes)
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
