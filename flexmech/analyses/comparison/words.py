"""A comparison with a record in words: what was fitted, how far it holds, and what is wrong."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.comparison.problem import DAMPING, GAIN, STIFFNESS
from flexmech.analyses.digits import Quantity
from flexmech.analyses.response.agreement import LARGE_BOW
from flexmech.analyses.summary import Summary, Table, crank_speed_text, warnings_of

# Part of the record's variance from which a model is said to miss what was measured.
_POOR = 0.5
# Parameters that the answer tells one by one.
_MOST_TOLD = 2
# Relative difference of frequencies beyond which other modes are compared, or another linkage.
_FAR_OFF = 0.1
# Of its sign turned, a record must be explained better by this factor to be thought of so.
_TURNED_BETTER = 0.8
# Factor or its inverse beyond which a gain is no error of calibration.
_CALIBRATION = 2.0
# Factor of the intervals' width below which nobody needs to be told of it.
_LITTLE_WIDER = 1.2
# Beyond it two parameters can hardly be told apart: each is known three times worse than alone.
_CLOSE = 0.95


def comparison_summary(data: xr.Dataset) -> Summary:
    """Fitted parameters, their correlation and what remains; how the record was aligned.

    Parameters
    ----------
    data : xarray.Dataset
        Of a ``Comparison``.

    Returns
    -------
    Summary
    """
    unexplained, *intervals = _residual_lines(data)
    details = (
        *_record_lines(data),
        *_ratio_lines(data),
        *_correlation_lines(data),
        unexplained,
        _verdict(data),
    )
    nothing = "no interval is known: nothing was fitted, the model is compared as it is"
    return Summary(
        _answer(data),
        _fit_table(data),
        next(iter(intervals), nothing),
        details,
        (*_warnings(data), *warnings_of(data.attrs)),
        _numbers(data),
    )


def _numbers(data: xr.Dataset) -> tuple[Quantity, ...]:
    """Fitted parameters with half of their 95 % intervals, and what they leave unexplained."""
    fitted = []
    for name in data["parameter"].values:
        own = data.sel(parameter=name)
        kind, _, link = str(name).partition(":")
        unit = str(own["parameter_unit"].item())
        half = float(own["upper"] - own["lower"]) / 2
        fitted.append(
            Quantity(
                f"fitted_{kind}", float(own["fitted"]), "" if unit == "1" else unit, half, link
            )
        )
    return (*fitted, Quantity("unexplained", 100 * float(data.attrs["unexplained"]), "%"))


def _answer(data: xr.Dataset) -> tuple[str, ...]:
    """What fits best, and what of the record it leaves unexplained."""
    *fitted, unexplained = _numbers(data)
    lines = []
    for one, name in zip(fitted, data["parameter"].values, strict=True):
        own = data.sel(parameter=name)
        low, high = (f"{float(own[end]):.5g}" for end in ("lower", "upper"))
        kind = one.name.removeprefix("fitted_")
        what, of = {
            DAMPING: (f"damping time of {f'the {one.of}' if one.of else 'the links'}", ""),
            STIFFNESS: (f"stiffness of the {one.of}", " of the model's"),
        }.get(kind, (kind.replace("_", " "), ""))
        if kind == DAMPING and not float(own["lower"]) > 0:
            whose = what.removeprefix("damping time ")
            what = f"record shows no damping {whose}: the damping time that fits best"
        lines.append(f"The {what} is {one}{of} ({low} to {high} with 95 % probability).")
    how = "as it is" if not fitted else "with these values" if len(fitted) > 1 else "with it"
    last = f"The model {how} leaves {unexplained.value:.3g} % of the record's variance unexplained."
    # Many links have a parameter each: the table lists them.
    return (*lines[:_MOST_TOLD], last)


def _fit_table(data: xr.Dataset) -> Table | None:
    """Fitted parameters with their 95 % intervals; None where nothing was fitted."""
    if not data.sizes["parameter"]:
        return None

    def row(number: int) -> tuple[str, ...]:
        own = data.isel(parameter=number)
        name, unit = str(own["parameter"].item()), str(own["parameter_unit"].item())
        keys = ("fitted", "standard_error", "lower", "upper")
        value, error, lower, upper = (f"{float(own[key]):.5g}" for key in keys)
        return (name, value, "-" if unit == "1" else unit, error, f"{lower} to {upper}")

    headings = ("parameter", "value", "unit", "std. error", "95 % interval")
    rows = tuple(row(number) for number in range(data.sizes["parameter"]))
    title = f"fitted to {data.attrs['record']}, {data.attrs['mechanism']}"
    return Table(title, headings, (rows,))


def _record_lines(data: xr.Dataset) -> list[str]:
    """What was compared, and how the record was aligned."""
    attrs = data.attrs
    column, quantity = attrs["column"], attrs["quantity"]
    lines = [f"compared: {column!r} of {attrs['record']} with {quantity} of the {_engine(attrs)}"]
    if "time" in data.dims:
        angle, length = np.degrees(attrs["start_angle"]), float(data["time"][-1] - data["time"][0])
        turns = length * abs(attrs["crank_speed"]) / (2 * np.pi)
        by = (
            "found from the record itself"
            if attrs["aligned_by"] == "record"
            else "as its column says"
        )
        lines += [
            f"record: {data.sizes['time']} samples, {length:.4g} s, {turns:.4g} turns at "
            f"{crank_speed_text(attrs)}",
            f"aligned: the record begins at crank angle {angle:.4g} deg, {by}",
            f"its free vibration begins in the state that fits best: {attrs['free_states']} "
            "numbers, found for every value of the parameters",
        ]
    elif "sample" in data.dims:
        modes = ", ".join(str(mode) for mode in np.unique(data["mode"].values))
        by = "by its frequencies" if attrs["mode_found"] else "as its column says"
        word = "modes" if "," in modes else "mode"
        lines.append(
            f"record: {data.sizes['sample']} natural frequencies of {word} {modes} ({by}) at "
            f"{crank_speed_text(attrs)}"
        )
    else:
        frequency = data["frequency"].values
        lines.append(
            f"record: {len(frequency)} frequencies from {frequency[0]:.4g} to "
            f"{frequency[-1]:.4g} Hz, crank locked at "
            f"{np.degrees(attrs['crank_angle_locked']):.6g} deg"
        )
    return lines


def _ratio_lines(data: xr.Dataset) -> list[str]:
    """Fitted damping times as damping ratios of the first natural frequency."""
    hertz = float(data.attrs["first_frequency"])
    lines = []
    for name in data["parameter"].values:
        own = data.sel(parameter=name)
        if not str(name).startswith(DAMPING):
            continue
        value, low, high = (
            100 * np.pi * hertz * float(own[key]) for key in ("fitted", "lower", "upper")
        )
        whose = str(name).partition(":")[2]
        of = f" of the {whose}'s material" if whose else ""
        lines.append(
            f"as a damping ratio{of} at {hertz:.4g} Hz, the first natural frequency: {value:.4g} % "
            f"({low:.4g} to {high:.4g} %)"
        )
    return lines


def _correlation_lines(data: xr.Dataset) -> list[str]:
    """Correlation of each pair of parameters."""
    names = [str(name) for name in data["parameter"].values]
    lines = []
    for first, second in combinations(range(len(names)), 2):
        value = float(data["correlation"].values[first, second])
        hardly = "; the record hardly tells them apart" if abs(value) > _CLOSE else ""
        lines.append(f"correlation of {names[first]} and {names[second]}: {value:.3f}{hardly}")
    return lines


def _residual_lines(data: xr.Dataset) -> list[str]:
    """What remains unexplained, and what that does to the intervals."""
    attrs = data.attrs
    parts = [data[name].values for name in data if str(name).startswith("residual")]
    size = float(np.sqrt(np.mean(sum(part**2 for part in parts))))
    unit = f" {attrs['unit']}" if attrs["unit"] else ""
    part = f", {100 * _part(data):.2g} % of the frequencies" if "sample" in data.dims else ""
    lines = [
        f"unexplained: {100 * attrs['unexplained']:.3g} % of the record's variance, a residual of "
        f"{size:.3g}{unit} root mean square{part}"
    ]
    if not data.sizes["parameter"]:
        return lines
    order, widened = attrs["residual_order"], attrs["widened"]
    if not order and widened < _LITTLE_WIDER:
        return [*lines, "the residual looks like white noise: the intervals hold for that"]
    intervals = "the intervals of white noise cover that"
    if widened > 1.0:
        intervals = f"the intervals are up to {widened:.3g} times wider than for white noise"
    lacks = "hat the model lacks may shift the values by more than that"
    if not order:
        where = f"larger where the record tells most, so that {intervals}; w{lacks}"
        return [*lines, f"the residual is {where}"]
    return [
        *lines,
        f"the residual is no white noise (autoregressive of order {order}): the model lacks "
        f"something, or the noise is coloured; {intervals}. W{lacks}",
    ]


def _verdict(data: xr.Dataset) -> str:
    """What to do with the numbers."""
    times, factors = [], []
    for name in data["parameter"].values:
        kind, _, link = str(name).partition(":")
        value = float(data["fitted"].sel(parameter=name))
        if kind == DAMPING and value > 0:
            times.append(f'damping_time = "{value:.4g} s" of {link or "each link"}')
        elif kind == STIFFNESS:
            factors.append(f"{value:.5g} on all moduli of {link}")
    if not times + factors:
        return "applied: nothing; nothing of the model was fitted"
    return f"applied: nothing; to use it, write into the model file: {'; '.join(times + factors)}"


def _warnings(data: xr.Dataset) -> tuple[str, ...]:
    """What makes the fit worthless, or is to be known before it is used."""
    attrs = data.attrs
    if "sample" in data.dims:
        # Frequencies that hardly move with the crank angle have hardly any variance to explain.
        far = (
            f"the frequencies differ by {100 * _part(data):.2g} % on average: the numbers mean "
            "little; check the crank speed, the units, and the numbers of the modes"
        )
        return (*_placed(data), *([far] if _part(data) >= _FAR_OFF else []))
    if attrs["unexplained"] >= _POOR:
        return (_unexplained(attrs),)
    large = (
        f"a link deflects by {100 * attrs.get('bow', 0.0):.2g} % of its length: the linear "
        "equations that are fitted here shift damping and frequencies by a few per cent then"
    )
    return (*([large] if attrs.get("bow", 0.0) > LARGE_BOW else []), *_odd_values(data))


def _placed(data: xr.Dataset) -> tuple[str, ...]:
    """Which mode a record without the numbers of its modes was laid beside."""
    if not data.attrs["mode_found"]:
        return ()
    return (
        f"{data.attrs['record']} has no column 'mode': its frequencies are taken as those of mode "
        f"{int(data['mode'].values[0])}, the only one near them; add a column 'mode' that numbers "
        "them from 1, the fundamental frequency, if they are of another",
    )


def _unexplained(attrs: Mapping[str, Any]) -> str:
    """What to look at where most of a record is unexplained."""
    left = f"{100 * attrs['unexplained']:.3g} % of the record remain unexplained"
    turned = attrs.get("turned_unexplained", float("nan"))
    if turned < _TURNED_BETTER * attrs["unexplained"] and "gain" in attrs:
        return (
            f"{left}, and {100 * turned:.3g} % with a gain of {attrs['gain']:.4g}: fit the gain as "
            "well (--fit damping,gain)"
        )
    if turned < _TURNED_BETTER * attrs["unexplained"]:
        return (
            f"{left}, and {100 * turned:.3g} % with its sign turned: the gauge may sit on the "
            "other face of the link; turn the sign of the column"
        )
    return (
        f"{left}: the numbers mean little; check the crank speed or angle, --quantity, and the "
        "units of the record"
    )


def _odd_values(data: xr.Dataset) -> list[str]:
    """Fitted values that fit well and that no linkage or calibration has."""
    lines = []
    for name in data["parameter"].values:
        own = data.sel(parameter=name)
        value = float(own["fitted"])
        if str(name) == GAIN and not 1 / _CALIBRATION < value < _CALIBRATION:
            lines.append(
                f"a gain of {value:.4g} is no calibration: "
                + ("the gauge or the hammer is turned around" if value < 0 else "check the units")
                + " (damping and stiffness do not depend on it)"
            )
        if str(name).startswith(DAMPING) and float(own["upper"]) < 0:
            lines.append(
                f"the record grows where {name} is to make it decay, which no material does: check "
                "the order of its samples, or the sign of its imaginary part (the phase of a "
                "response lags behind the force)"
            )
    return lines


def _part(data: xr.Dataset) -> float:
    """Residual over the measured frequencies, root mean square."""
    ratio = data["residual"].values / data["measured"].values
    # A record may hold numbers whose squares are beyond what a float can be.
    greatest = max(float(np.abs(ratio).max()), np.finfo(float).tiny)
    return greatest * float(np.sqrt(np.mean((ratio / greatest) ** 2)))


def _engine(attrs: dict[str, object]) -> str:
    return f"{attrs['engine']} engine ({attrs['element']})"
