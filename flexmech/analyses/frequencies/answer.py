"""What a frequency map answers: where frequencies lie over the turn, and what moves them."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses.beam_theory import theory_reason
from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.frequencies import damping
from flexmech.analyses.frequencies.agreement import engine_difference, verdict
from flexmech.analyses.frequencies.changes import change_by_state, speed_change
from flexmech.analyses.frequencies.extremes import error_of_model, known_error
from flexmech.analyses.frequencies.flutter import flutter_lines
from flexmech.analyses.remarks import speed_text
from flexmech.analyses.trust import trust_line
from flexmech.plots.reading import speed_unit

# Modes and speeds that have a place in the sentences: the table lists all of them.
_MOST_MODES = 3


def answer(
    extremes: xr.Dataset,
    dataset: xr.Dataset,
    change: xr.DataArray | None,
    error: xr.DataArray | None,
) -> list[str]:
    """Flutter, frequencies of the lowest modes at the greatest speed, and what changes them.

    Parameters
    ----------
    extremes : xarray.Dataset
        As :func:`flexmech.analyses.frequencies.words.extremes_table` takes them.
    dataset : xarray.Dataset
        Of the map in one state.
    change : xarray.DataArray or None
        Relative change by heat and moisture, over (engine, crank_speed, crank_angle, mode).
    error : xarray.DataArray or None
        Of the change: relative, of frequencies in both states, over (engine, crank_speed, mode).

    Returns
    -------
    list of str
    """
    unit = speed_unit(dataset)
    fastest = int(np.argmax(np.abs(dataset["crank_speed"].values)))
    speed = float(dataset["crank_speed"][fastest])
    errors = errors_in_hertz(extremes, dataset)
    told = []
    for number, mode in enumerate(dataset["mode"].values[:_MOST_MODES].tolist()):
        ends = (
            rounded(
                float(extremes[end][0, fastest, number]), float(errors[end][0, fastest, number])
            )
            for end in ("lowest", "highest")
        )
        told.append(f"f{mode} is {' to '.join(dict.fromkeys(ends))} Hz")
    where = f"At {speed_text(speed, unit)} {unit}" if speed else "At rest"
    lines = [*flutter_lines(dataset), f"{where} {', '.join(told)} over the crank angles."]
    slowest = int(np.argmin(np.abs(dataset["crank_speed"].values)))
    if slowest != fastest and dataset["engine"].size:
        slow = float(dataset["crank_speed"][slowest])
        name = f"{speed_text(slow, unit)} {unit}" if slow else "rest"
        moved = speed_change(dataset, slowest, fastest)
        lines.append(f"Against {name} the speed changes f1 by {moved}.")
    if change is not None and error is not None:
        moved = change_by_state(change, error, 0)
        lines.append(f"Heat and moisture change f1 by {moved} against the dry linkage.")
    return lines


def errors_in_hertz(extremes: xr.Dataset, dataset: xr.Dataset) -> xr.Dataset:
    """Errors of the extremes in Hz: by mesh and component modes, or the engines' difference.

    Parameters
    ----------
    extremes, dataset : xarray.Dataset
        As in :func:`answer`.

    Returns
    -------
    xarray.Dataset
        ``lowest`` and ``highest`` over (engine, crank_speed, mode).
    """
    relative, found = known_error(dataset), {}
    for end in ("lowest", "highest"):
        value = extremes[end]
        apart = abs(value - value.isel(engine=0)).max("engine") + 0 * value
        mesh = relative * value
        found[end] = mesh.where(mesh > apart, apart).transpose(*value.dims)
    return xr.Dataset(found)


def numbers(extremes: xr.Dataset, dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """Frequencies and damping ratios of each mode at each speed, by the first engine.

    Parameters
    ----------
    extremes, dataset : xarray.Dataset
        As in :func:`answer`.

    Returns
    -------
    tuple of Quantity
    """
    unit, errors = speed_unit(dataset), errors_in_hertz(extremes, dataset)
    frequencies = tuple(
        Quantity(
            f"{end}_frequency",
            float(extremes[end][0, place, number]),
            "Hz",
            float(errors[end][0, place, number]),
            f"mode {mode} at {speed_text(speed, unit)} {unit}",
        )
        for place, speed in enumerate(dataset["crank_speed"].values)
        for number, mode in enumerate(dataset["mode"].values.tolist())
        for end in ("lowest", "highest")
    )
    return frequencies + damping.numbers(dataset)


def trust(dataset: xr.Dataset) -> str:
    """How far frequencies and damping are known, and whether the engines agree.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of the map in one state.

    Returns
    -------
    str
    """
    names = [str(name) for name in dataset["engine"].values]
    error = float(error_of_model(dataset).max())
    return trust_line(names, error, engine_difference(dataset)) + damping.trust(dataset)


def disagreement(dataset: xr.Dataset, effect: xr.DataArray | None) -> tuple[str, ...]:
    """What to do where two engines differ by more than their errors, and no theory says why.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of the map in one state.
    effect : xarray.DataArray or None
        How much vibration moves frequencies, where running states were asked for.

    Returns
    -------
    tuple of str
        One, or none.
    """
    explained = effect is not None or theory_reason(dataset.attrs)
    found = engine_difference(dataset)
    if explained or found is None or not found.worth_a_warning:
        return ()
    return (verdict(dataset, effect),)
