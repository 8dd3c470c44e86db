"""A comparison with a record in words: what was fitted, how far it holds, and what is wrong."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.comparison.problem import DAMPING, GAIN, STIFFNESS
from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.details import details_table
from flexmech.analyses.digits import Quantity
from flexmech.analyses.response.agreement import LARGE_BOW
from flexmech.analyses.summary import Summary, Table, crank_speed_text, warnings_of

# Part of the record's variance from which a model is said to miss what was measured.
_POOR = 0.5
# Parameters that the answer lists one by one.
_MOST_PARAMETERS = 2
# Relative difference of frequencies beyond which other modes are compared, or another linkage.
_FAR_OFF = 0.1
# With its sign turned, a record must be explained better by this factor to be thought
# of so.
_TURNED_BETTER = 0.8
# Factor or its inverse beyond which a gain is no error of calibration.
_CALIBRATION = 2.0
# Factor of the intervals' width below which it is not printed.
_LITTLE_WIDER = 1.2
# Beyond it two parameters can hardly be separated: each is known three times worse than alone.
_CLOSE = 0.95


def summary_of(data: xr.Dataset) -> Summary:
    """Answer, table, trust, details, warnings and numbers of a comparison with a record.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a ``Comparison``.

    Returns
    -------
    Summary
    """
    return Summary(
        _answer(data),
        _fit_table(data),
        _trust(data),
        (*details_table(_quantities(data)), *_notes(data)),
        (*_warnings(data), *warnings_of(data.attrs)),
        _numbers(data),
    )


def _parameters(data: xr.Dataset) -> Iterator[tuple[str, str, xr.Dataset]]:
    """Kind, link and values of each fitted parameter; without a link where it is of all."""
    for name in data["parameter"].values.tolist():
        kind, _, link = name.partition(":")
        yield kind, link, data.sel(parameter=name)


def _numbers(data: xr.Dataset) -> tuple[Quantity, ...]:
    """Fitted parameters with half of their 95 % intervals, and what they leave unexplained."""
    fitted = []
    for kind, link, parameter in _parameters(data):
        unit = _unit(parameter)
        half = float(parameter["upper"] - parameter["lower"]) / 2
        fitted.append(Quantity(f"fitted_{kind}", float(parameter["fitted"]), unit, half, link))
    return (*fitted, Quantity("unexplained", 100 * float(data.attrs["unexplained"]), "%"))


def _unit(parameter: xr.Dataset) -> str:
    unit = str(parameter["parameter_unit"].item())
    return "" if unit == "1" else unit


def _answer(data: xr.Dataset) -> tuple[str, ...]:
    """Best values, and the part of the record that stays unexplained."""
    *fitted, unexplained = _numbers(data)
    lines = []
    for one, (kind, link, parameter) in zip(fitted, _parameters(data), strict=True):
        low, high = (f"{float(parameter[end]):.5g}" for end in ("lower", "upper"))
        what, of = kind.replace("_", " "), ""
        if kind == STIFFNESS:
            what, of = f"stiffness of the {link}", " of the model's"
        elif kind == DAMPING:
            what = f"damping time of {f'the {link}' if link else 'the links'}"
            if not float(parameter["lower"]) > 0:
                whose = what.removeprefix("damping time ")
                what = f"record shows no damping {whose}: the damping time that fits best"
        lines.append(f"The {what} is {one}{of} ({low} to {high} with 95 % probability).")
    how = "as it is" if not fitted else "with these values" if len(fitted) > 1 else "with it"
    last = f"The model {how} leaves {unexplained.value:.3g} % of the record's variance unexplained."
    # Many links have a parameter each: the table lists them.
    return (*lines[:_MOST_PARAMETERS], last)


def _fit_table(data: xr.Dataset) -> Table | None:
    """Fitted parameters with their 95 % intervals; None where nothing was fitted."""
    rows = []
    for name in data["parameter"].values.tolist():
        parameter = data.sel(parameter=name)
        keys = ("fitted", "standard_error", "lower", "upper")
        value, error, lower, upper = (f"{float(parameter[key]):.5g}" for key in keys)
        rows.append((name, value, _unit(parameter) or "-", error, f"{lower} to {upper}"))
    headings = ("parameter", "value", "unit", "std. error", "95 % interval")
    title = f"fitted to {data.attrs['record']}, {data.attrs['mechanism']}"
    return Table(title, headings, (tuple(rows),)) if rows else None


def _trust(data: xr.Dataset) -> str:
    """Effect of the residual on the intervals."""
    order, widened = data.attrs["residual_order"], data.attrs["widened"]
    if not data.sizes["parameter"]:
        return "no interval is known: nothing was fitted, the model is compared as it is"
    if not order and widened < _LITTLE_WIDER:
        return "the residual looks like white noise: the intervals hold for that"
    intervals = "the intervals of white noise cover that"
    if widened > 1.0:
        intervals = f"the intervals are up to {widened:.3g} times wider than for white noise"
    lacks = "hat the model lacks may shift the values by more than that"
    if not order:
        where = f"larger where the record is most sensitive, so that {intervals}; w{lacks}"
        return f"the residual is {where}"
    return (
        f"the residual is no white noise (autoregressive of order {order}): the model lacks "
        f"something, or the noise is coloured; {intervals}. W{lacks}"
    )


def _quantities(data: xr.Dataset) -> Iterator[Quantity]:
    """Size and place of the record, damping ratios, correlations, and what is unexplained."""
    attrs = data.attrs
    samples = next(
        data.sizes[name] for name in ("time", "sample", "frequency") if name in data.dims
    )
    yield Quantity("samples of the record", float(samples), "")
    if "time" in data.dims:
        length = float(data["time"][-1] - data["time"][0])
        yield Quantity("length of the record", length, "s")
        turns = length * abs(attrs["crank_speed"]) / (2 * np.pi)
        yield Quantity("turns of the crank", turns, "", of=crank_speed_text(attrs))
        by = "from the record" if attrs["aligned_by"] == "record" else "by its column"
        angle = round(DEGREES * float(attrs["start_angle"]), 9)
        yield Quantity("crank angle at its beginning", angle, "deg", of=by)
        states = float(attrs["free_states"])
        yield Quantity("numbers of its free vibration", states, "", of="found for all values")
    elif "sample" in data.dims:
        by = "by its frequencies" if attrs["mode_found"] else "by its column"
        for mode in np.unique(data["mode"].values).tolist():
            yield Quantity("mode of the record", float(mode), "", of=by)
        differ = "differences from the frequencies, root mean square"
        yield Quantity(differ, 100 * _part(data), "%")
    else:
        for end, place in (("lowest", 0), ("highest", -1)):
            yield Quantity(f"{end} frequency of the record", float(data["frequency"][place]), "Hz")
        angle = DEGREES * float(attrs["crank_angle_locked"])
        yield Quantity("locked crank angle", angle, "deg")
    hertz = float(attrs["first_frequency"])
    for kind, link, parameter in _parameters(data):
        if kind == DAMPING:
            ratio, half = (
                100 * np.pi * hertz * float(value)
                for value in (parameter["fitted"], (parameter["upper"] - parameter["lower"]) / 2)
            )
            of = f"{f'{link}, ' if link else ''}{hertz:.4g} Hz"
            yield Quantity("damping ratio of the first mode", ratio, "%", half, of)
    names = data["parameter"].values.tolist()
    for first, second in combinations(range(len(names)), 2):
        value = float(data["correlation"].values[first, second])
        hardly = ", hardly separable" if abs(value) > _CLOSE else ""
        yield Quantity("correlation", value, "", of=f"{names[first]}, {names[second]}{hardly}")
    parts = [data[name].values for name in data if str(name).startswith("residual")]
    size = float(np.sqrt(np.mean(sum(error**2 for error in parts))))
    yield Quantity("residual, root mean square", size, str(attrs["unit"]))


def _notes(data: xr.Dataset) -> Iterator[str]:
    """Compared quantities, and the use of the numbers."""
    attrs, written = data.attrs, []
    yield (
        f"compared: {attrs['column']!r} of {attrs['record']} with {attrs['quantity']} of the "
        f"{attrs['engine']} engine ({attrs['element']})"
    )
    for kind, link, parameter in _parameters(data):
        value = float(parameter["fitted"])
        if kind == DAMPING and value > 0:
            written.append(f'damping_time = "{value:.4g} s" of {link or "each link"}')
        elif kind == STIFFNESS:
            written.append(f"{value:.5g} on all moduli of {link}")
    listed = f"to use it, write into the model file: {'; '.join(written)}"
    yield f"applied: nothing; {listed if written else 'nothing of the model was fitted'}"


def _warnings(data: xr.Dataset) -> tuple[str, ...]:
    """Warnings on a fit that is worthless, or to be known before it is used."""
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
    """Mode that a record without numbers of modes was compared with."""
    if not data.attrs["mode_found"]:
        return ()
    return (
        f"{data.attrs['record']} has no column 'mode': its frequencies are taken as those of mode "
        f"{int(data['mode'].values[0])}, the only one near them; add a column 'mode' that numbers "
        "them from 1, the fundamental frequency, if they are of another",
    )


def _unexplained(attrs: Mapping[str, Any]) -> str:
    """Likely causes where most of a record is unexplained."""
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


def _odd_values(data: xr.Dataset) -> Iterator[str]:
    """Fitted values that fit well and that no linkage or calibration has."""
    for kind, link, parameter in _parameters(data):
        value = float(parameter["fitted"])
        if kind == GAIN and not 1 / _CALIBRATION < value < _CALIBRATION:
            check = "the gauge or the hammer is turned around" if value < 0 else "check the units"
            yield (
                f"a gain of {value:.4g} is no calibration: {check} (damping and stiffness do not "
                "depend on it)"
            )
        if kind == DAMPING and float(parameter["upper"]) < 0:
            yield (
                f"the record grows where {f'{kind}:{link}' if link else kind} is to make it decay, "
                "which no material does: check the order of its samples, or the sign of its "
                "imaginary part (the phase of a response lags behind the force)"
            )


def _part(data: xr.Dataset) -> float:
    """Residual over the measured frequencies, root mean square."""
    ratio = data["residual"].values / data["measured"].values
    # A record may hold numbers whose squares are beyond what a float can be.
    greatest = max(float(np.abs(ratio).max()), np.finfo(float).tiny)
    return greatest * float(np.sqrt(np.mean((ratio / greatest) ** 2)))
