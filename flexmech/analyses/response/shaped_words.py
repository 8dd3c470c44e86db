"""What a shaper leaves of the residual vibration, in numbers, words and a table."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.response.agreement import best_known, quantities_of
from flexmech.analyses.response.driven import residual_numbers
from flexmech.analyses.response.shaped_run import TIMES_PER_PERIOD
from flexmech.analyses.summary import Aspect
from flexmech.model_text import quantity
from flexmech.units import TIME

_MM, _MS = 1e3, 1e3
_NAME = "shaped_residual_amplitude"
# A chart tells of modes that ring by this part of what rings most.
_TOLD = 0.02


def shaped_aspect(data: xr.Dataset) -> Aspect:
    """What a shaper leaves of the residual vibration, and how that goes with the time of a move.

    Parameters
    ----------
    data : xarray.Dataset
        Of a response.

    Returns
    -------
    Aspect
        Nothing of a run without a shaper and without times of a move.
    """
    chart = _chart_lines(data) if "move_amplitude" in data else []
    if _NAME not in data:
        return Aspect(details=tuple(chart))
    numbers = _numbers(data)
    return Aspect(_answer(data, numbers), (*_lines(data), *chart), numbers=numbers, leads=True)


def _numbers(data: xr.Dataset) -> tuple[Quantity, ...]:
    """Residual amplitude of each link after the shaped law, and by how much it is longer."""
    errors = data["shaped_residual_error"]
    place, bent = best_known(errors), {"link": data["peak_deflection"].max("engine") > 0}
    found = [Quantity("shaper_delay", _MS * float(data.attrs["shaper_delay"]), "ms", 0.0)]
    for name in (_NAME, f"{_NAME}_at_end"):
        found += quantities_of(data[name][bent], errors[bent], place, name, "mm", _MM)
    return tuple(found)


def _answer(data: xr.Dataset, numbers: tuple[Quantity, ...]) -> tuple[str, ...]:
    """How far the link that rings most does after both laws, and by how much one is longer."""
    found = [one for one in numbers if one.name == _NAME]
    plain = [one for one in residual_numbers(data) if one.name == "residual_amplitude"]
    before = max(plain, key=lambda one: one.value)
    after = next(one for one in found if one.of == before.of)
    most = max(found, key=lambda one: one.value)
    other = f" (the {most.of} by {most})" if most.of != after.of else ""
    delay = _MS * float(data.attrs["shaper_delay"])
    modes = str(data.attrs["shaped_modes"]).split(",")
    for_modes = f"mode{'s' if len(modes) > 1 else ''} {' and '.join(modes)}"
    return (
        f"After the stop the {before.of} rings by {before}; with the {data.attrs['shaper']} "
        f"for {for_modes} by {after}{other}; the move takes {rounded(delay, 0.0, 3)} ms longer.",
    )


def _lines(data: xr.Dataset) -> list[str]:
    """The shaper, how to state it in a model file, and what the shaped law does."""
    lines = [f"{data.attrs['shaper']} for {data.attrs['shaper_modes']}", _impulses(data)]
    for name in map(str, data["engine"].values):
        own = data.sel(engine=name)
        lines += [_residual_line(own, name), _modes_line(own, name), _peaks_line(own, name)]
    return lines


def _impulses(data: xr.Dataset) -> str:
    """Impulses as a model file has them; along a path phases."""
    weights = data["impulse_weight"].values
    if "impulse_time" in data:
        rows = ", ".join(
            f'["{quantity(float(time), TIME)}", {float(weight)!r}]'
            for time, weight in zip(data["impulse_time"].values, weights, strict=True)
        )
        return f"in [drive] of a model file: impulses = [{rows}]"
    parts = ", ".join(
        f"{weight:.4g} at {phase:.4g} of mode {mode}"
        for phase, weight, mode in zip(
            data["impulse_phase"].values, weights, data["impulse_mode"].values, strict=True
        )
    )
    return f"shaper: impulses over the phase along the path, in periods: {parts}"


def _bent(data: xr.Dataset) -> list[str]:
    """Links that bend."""
    return [str(name) for name in data["link"].values[data["peak_deflection"].values > 0]]


def _residual_line(data: xr.Dataset, engine: str) -> str:
    parts = []
    for link in _bent(data):
        ends = (data[name].sel(link=link) for name in (_NAME, f"{_NAME}_at_end"))
        first, last = (rounded(_MM * float(one), 0.0, 4) for one in ends)
        parts.append(f"{link} {first} to {last}")
    return f"residual vibration with the shaper: {', '.join(parts)} mm ({engine})"


def _modes_line(data: xr.Dataset, engine: str) -> str:
    parts = []
    for mode in data["mode"].values:
        one, before = (
            data[name].sel(mode=mode).max("link")
            for name in ("shaped_modal_amplitude", "modal_amplitude")
        )
        if float(before) > 0:
            frequency = float(data["standing_frequency"].sel(mode=mode))
            share = 100 * float(one) / float(before)
            parts.append(f"{frequency:.5g} Hz {rounded(share, 0.0, 3)} %")
    return f"the shaper leaves of each mode: {', '.join(parts)} of the plain law's ({engine})"


def _peaks_line(data: xr.Dataset, engine: str) -> str:
    bent = ", ".join(
        f"{link} {rounded(_MM * float(data['shaped_peak_deflection'].sel(link=link)), 0.0, 4)}"
        for link in _bent(data)
    )
    torque, power, error = (
        float(data[f"shaped_{name}"])
        for name in ("peak_driving_torque", "peak_driving_power", "energy_error")
    )
    return (
        f"run with the shaper: deflections up to {bent} mm, torque {torque:.4g} N m, power "
        f"{power:.4g} W; its energy balance is off by at most {error:.2g} ({engine})"
    )


def _chart_lines(data: xr.Dataset) -> list[str]:
    """Between what times of a move what rings least and most, and how the engines differ."""
    found, lines = data["move_amplitude"].max("link"), list[str]()
    curves = data["move_curve"].max("link") if "move_curve" in data else None
    resolved = set() if curves is None else set(curves["curve_mode"].values.tolist())
    unresolved = set[int]()
    for law in map(str, data["law"].values):
        own = found.sel(law=law)
        told = own["mode"].values[(own.max("move_time") > _TOLD * float(own.max())).values]
        unresolved |= {int(mode) for mode in told} - resolved
        texts = []
        for mode in told:
            values, time = own.sel(mode=mode).values, data["move_time"].values
            if curves is not None and mode in resolved:
                values = curves.sel(law=law, curve_mode=mode).values
                time = data["curve_move_time"].values
            least, most = (
                f"{rounded(_MM * float(values[place]), 0.0, 3)} mm at {float(time[place]):.4g} s"
                for place in (int(np.argmin(values)), int(np.argmax(values)))
            )
            texts.append(f"mode {mode} {least} to {most}")
        lines.append(f"residual vibration over the time of a move, {law} law: {'; '.join(texts)}")
    if unresolved:
        lines.append(_unresolved_text(data, sorted(unresolved)))
    if "simulated_move_amplitude" in data:
        at = data["simulated_move_time"].values
        own = data["move_amplitude"].sel(move_time=at).rename(move_time="simulated_move_time")
        apart = abs(data["simulated_move_amplitude"] - own).max() / own.max()
        names = ", ".join(map(str, data["simulating_engine"].values))
        lines.append(
            f"at {len(at)} of the times of a move {names} and the equations in link frames differ "
            f"by at most {float(apart):.2g} of the greatest amplitude"
        )
    return lines


def _unresolved_text(data: xr.Dataset, modes: list[int]) -> str:
    """Modes whose amplitude goes up and down faster than times of a move tell, and the remedy."""
    fastest = float(data["move_frequency"].sel(mode=modes).max())
    named = " and ".join(map(str, modes))
    names = f"modes {named} ring" if len(modes) > 1 else f"mode {named} rings"
    apart = _MS / (TIMES_PER_PERIOD * fastest)
    return (
        f"the times of the move are too far apart to tell how {names} between them: dots in "
        f"the picture; state --move-times that are at most {apart:.3g} ms apart, over a shorter "
        "range"
    )


def amplitudes_over_move_time(data: xr.Dataset) -> xr.Dataset:
    """Amplitude of each mode after the stop over the time of a move, for a table.

    Parameters
    ----------
    data : xarray.Dataset
        Of a response with ``move_amplitude``.

    Returns
    -------
    xarray.Dataset
        ``amplitude_over_move_time`` over (computed_by, law, move_time, link, mode), by equations in
        link frames and by engines, and ``whole_time`` until the stop, NaN where none is computed.
    """
    found = data["move_amplitude"].expand_dims(computed_by=["equations in link frames"])
    if "simulated_move_amplitude" in data:
        names = {"simulating_engine": "computed_by", "simulated_move_time": "move_time"}
        simulated = data["simulated_move_amplitude"].rename(names)
        found = xr.concat([found, simulated], "computed_by", join="outer")
    known = found.notnull().any(["link", "mode"])
    whole = data["whole_move_time"].where(known)
    return xr.Dataset({"amplitude_over_move_time": found, "whole_time": whole})
