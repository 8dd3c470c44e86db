"""Answer of a frequency map: ranges of frequencies over the turn, and their changes.

How far two engines' frequencies differ, and whether their errors explain it.

What speed, heat and moisture change of frequencies, in percent with the errors of the change.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from flexmech.analyses.beam_theory import theory_reason
from flexmech.analyses.digits import MOST_DIGITS, Quantity, decimals_of, rounded
from flexmech.analyses.frequencies import damping
from flexmech.analyses.frequencies.extremes import error_of_model, known_error
from flexmech.analyses.frequencies.flutter import flutter_lines
from flexmech.analyses.frequencies.words import MOST_DECIMALS
from flexmech.analyses.summary import EngineDifference, least_explained, speed_text, trust_line
from flexmech.arrays import FloatArray
from flexmech.plots.reading import speed_unit

DIMS = ("engine", "crank_speed", "crank_angle", "mode")


@dataclass(frozen=True)
class EngineAgreement:
    """Greatest relative difference of two engines' frequencies, and where it is.

    Parameters
    ----------
    engines : tuple of str
    relative_difference : float
        ``|f_b / f_a - 1|``.
    crank_speed, crank_angle : float
        rad/s and rad.
    mode : int
        Counted from 1.
    """

    engines: tuple[str, str]
    relative_difference: float
    crank_speed: float
    crank_angle: float
    mode: int


def engine_agreement(dataset: xr.Dataset) -> EngineAgreement | None:
    """How far the first two engines differ at most; None with a single engine.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a map in one state.

    Returns
    -------
    EngineAgreement or None
    """
    names = [str(name) for name in dataset["engine"].values]
    if len(names) < 2:
        return None
    difference = _differences(dataset)
    return _at(dataset, difference, int(difference.argmax()))


def _differences(dataset: xr.Dataset) -> FloatArray:
    """``|f_b / f_a - 1|`` of the first two engines, shape (speeds, angles, modes)."""
    first, second = (dataset["frequency"].isel(engine=i).values for i in (0, 1))
    return np.asarray(np.abs(second / first - 1))


def _at(dataset: xr.Dataset, difference: FloatArray, place: int) -> EngineAgreement:
    """One of the differences, by its place among all of them."""
    speed, angle, mode = np.unravel_index(place, difference.shape)
    first, second = (str(name) for name in dataset["engine"].values[:2])
    return EngineAgreement(
        engines=(first, second),
        relative_difference=float(difference.flat[place]),
        crank_speed=float(dataset["crank_speed"][speed]),
        crank_angle=float(dataset["crank_angle"][angle]),
        mode=int(dataset["mode"][mode]),
    )


def engine_difference(dataset: xr.Dataset) -> EngineDifference | None:
    """The frequency of two engines that their errors explain least.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a map in one state.

    Returns
    -------
    EngineDifference or None
        None with a single engine.
    """
    if dataset.sizes["engine"] < 2:
        return None
    difference, allowed = _differences(dataset).ravel(), _allowed(dataset).ravel()
    return EngineDifference.least_explained(difference, allowed)


def _allowed(dataset: xr.Dataset) -> FloatArray:
    """Difference that the errors of two engines explain, shape (speeds, angles, modes).

    Where errors are not small their product counts too.
    """
    error = error_of_model(dataset).transpose("engine", "crank_speed", "mode").values[:2]
    together = np.prod(1 + error, axis=0) - 1 + 10.0**-MOST_DECIMALS
    shape = dataset["frequency"].isel(engine=0).shape
    return np.broadcast_to(together[:, None], shape)


def verdict(dataset: xr.Dataset, effect: xr.DataArray | None) -> str:
    """How far the engines differ where errors explain it least; or that only one ran.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a map in one state.
    effect : xarray.DataArray or None
        How much vibration moves its frequencies, where running states were asked for.

    Returns
    -------
    str
    """
    if dataset.sizes["engine"] < 2:
        engine = dataset["engine"].values[0]
        return f"engines: no comparison was made, only the {engine} engine ran"
    difference, allowed = _differences(dataset), _allowed(dataset)
    place = least_explained(difference.ravel(), allowed.ravel())
    explained = bool(difference.flat[place] <= allowed.flat[place])
    agreement, unit = _at(dataset, difference, place), speed_unit(dataset)
    first, second = agreement.engines
    at_most = "at most " if place == difference.argmax() else ""
    return (
        f"engines: {first} and {second} differ by {at_most}{agreement.relative_difference:.2e} of "
        f"the frequency, at {speed_text(agreement.crank_speed, unit)} {unit}, "
        f"{np.degrees(agreement.crank_angle):.6g} deg, mode {agreement.mode}"
        f"{_judged(agreement, explained, dataset, effect)}"
    )


def _judged(
    agreement: EngineAgreement, explained: bool, dataset: xr.Dataset, effect: xr.DataArray | None
) -> str:
    """Whether errors explain how far the engines differ; if not, which one to trust."""
    place = {"crank_speed": agreement.crank_speed, "mode": agreement.mode}
    error = error_of_model(dataset).sel(place)
    errors = {name: float(error.sel(engine=name)) for name in agreement.engines}
    said = " and ".join(f"{errors[name]:.1e} of {name}" for name in agreement.engines)
    if explained:
        beyond = _beyond_tolerance(agreement.relative_difference, errors, dataset)
        return f", within their estimated errors ({said}){beyond}"
    if reason := theory_reason(dataset.attrs):
        return reason
    if effect is not None:
        moving = str(abs(effect).max(DIMS[1:]).idxmax("engine").item())
        return f"; trust {moving}, whose links are in the states of the running motion"
    better, elements = min(errors, key=lambda name: errors[name]), dataset.sel(place)["element"]
    kinds = ", ".join(f"{elements.sel(engine=name).item()} ({name})" for name in agreement.engines)
    return (
        f", which is beyond their estimated errors ({said}); trust {better}, whose error is "
        f"the smaller: the elements are {kinds}"
    )


def _beyond_tolerance(apart: float, errors: Mapping[str, float], dataset: xr.Dataset) -> str:
    """Say which of two engines within their errors to trust, and why, where that is to be said.

    Where the masses of the coarser one are lumped, or where they are farther apart than the
    tolerance asked for.
    """
    better, coarser = sorted(errors, key=lambda name: errors[name])
    if "lumping_error" in dataset and dataset["lumping_error"].sel(engine=coarser).any():
        return f"; trust {better}: the masses of {coarser} are lumped"
    tolerance = dataset.attrs.get("tolerance")
    if tolerance is None or apart <= tolerance:
        return ""
    if errors[coarser] <= tolerance:
        return f"; each error is within the tolerance of {tolerance:.0e}, both together are not"
    elements = int(dataset["elements"].sel(engine=coarser).max())
    return (
        f"; beyond the tolerance of {tolerance:.0e}, for which {coarser} needs more than the "
        f"{elements} elements on a link that are the limit without --elements; trust {better}"
    )


def percent_range(values: xr.DataArray, error: float) -> str:
    """Least and greatest of relative changes in percent, to the place that their error leaves.

    Parameters
    ----------
    values : xarray.DataArray
        Relative changes.
    error : float
        Error of each of them, relative too; not a number where none is known.

    Returns
    -------
    str

    Examples
    --------
    >>> percent_range(xr.DataArray([-0.0123456, 0.02]), 3e-4)
    '-1.23 to +2.00 % ± 0.03 %'
    >>> percent_range(xr.DataArray([0.02]), math.nan)
    '+2.000 %'
    """
    ends = 100 * float(values.min()), 100 * float(values.max())
    size = max(map(abs, ends))
    places = MOST_DIGITS - 1 - math.floor(math.log10(size)) if size else 0
    known = math.isfinite(error) and error > 0
    places = max(min(places, decimals_of(100 * error)) if known else places, 0)
    percents = " to ".join(dict.fromkeys(f"{end:+.{places}f}" for end in ends))
    uncertain = f"{100 * error:.{places}f}"
    # A difference below the last printed place is no error.
    return f"{percents} % ± {uncertain} %" if known and float(uncertain) else f"{percents} %"


def speed_change(dataset: xr.Dataset, slow: int, fast: int) -> str:
    """How far the lowest mode is moved from one crank speed to another, by the first engine.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of the map in one state.
    slow, fast : int
        Numbers of the crank speeds.

    Returns
    -------
    str
    """
    first = dataset["frequency"].isel(mode=0)
    change = first.isel(crank_speed=fast) / first.isel(crank_speed=slow) - 1
    errors = known_error(dataset).isel(engine=0, mode=0)
    known = float(errors.isel(crank_speed=fast) + errors.isel(crank_speed=slow))
    return percent_range(change.isel(engine=0), max(known, _apart(change)))


def change_by_state(change: xr.DataArray, error: xr.DataArray, mode: int) -> str:
    """How far heat and moisture move a mode over the crank angles and speeds, by the first engine.

    Parameters
    ----------
    change : xarray.DataArray
        Relative, over (engine, crank_speed, crank_angle, mode).
    error : xarray.DataArray
        Relative, of frequencies in both states together, over (engine, crank_speed, mode).
    mode : int
        Its place, from 0.

    Returns
    -------
    str
    """
    of_mode = change.isel(mode=mode)
    known = float(error.isel(engine=0, mode=mode).max())
    return percent_range(of_mode.isel(engine=0), max(known, _apart(of_mode)))


def change_lines(change: xr.DataArray | None, error: xr.DataArray | None) -> list[str]:
    """How far heat and moisture move each frequency over the crank angles and speeds.

    Parameters
    ----------
    change, error : xarray.DataArray or None
        As in :func:`change_by_state`; None where there are no states.

    Returns
    -------
    list of str
    """
    if change is None or error is None:
        return []
    ranges = [
        f"{change_by_state(change, error, place)} (mode {mode})"
        for place, mode in enumerate(change["mode"].values)
    ]
    lines = [f"change from dry: {', '.join(ranges)}"]
    if change.sizes["engine"] > 1:
        lines.append(
            f"change from dry: engines differ by at most {_apart(change):.1e} of the frequency"
        )
    return lines


def _apart(change: xr.DataArray) -> float:
    """Greatest difference of any engine from the first."""
    return float(np.abs(change - change.isel(engine=0, drop=True)).max())


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
        Dataset of the map in one state.
    change : xarray.DataArray or None
        Relative change by heat and moisture, over (engine, crank_speed, crank_angle, mode).
    error : xarray.DataArray or None
        Error of the change: relative, of frequencies in both states, over (engine, crank_speed,
        mode).

    Returns
    -------
    list of str
    """
    unit = speed_unit(dataset)
    fastest = int(np.argmax(np.abs(dataset["crank_speed"].values)))
    speed = float(dataset["crank_speed"][fastest])
    errors = errors_in_hertz(extremes, dataset)
    changes = []
    for number, mode in enumerate(dataset["mode"].values[:_MOST_MODES].tolist()):
        ends = (
            rounded(
                float(extremes[end][0, fastest, number]), float(errors[end][0, fastest, number])
            )
            for end in ("lowest", "highest")
        )
        changes.append(f"f{mode} is {' to '.join(dict.fromkeys(ends))} Hz")
    where = f"At {speed_text(speed, unit)} {unit}" if speed else "At rest"
    lines = [*flutter_lines(dataset), f"{where} {', '.join(changes)} over the crank angles."]
    slowest = int(np.argmin(np.abs(dataset["crank_speed"].values)))
    if slowest != fastest and dataset["engine"].size:
        slow = float(dataset["crank_speed"][slowest])
        name = f"{speed_text(slow, unit)} {unit}" if slow else "rest"
        moved = speed_change(dataset, slowest, fastest)
        lines.append(f"Compared with {name}, the speed changes f1 by {moved}.")
    if change is not None and error is not None:
        moved = change_by_state(change, error, 0)
        lines.append(f"Compared with the dry linkage, heat and moisture change f1 by {moved}.")
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
    relative, errors = known_error(dataset), {}
    for end in ("lowest", "highest"):
        value = extremes[end]
        apart = abs(value - value.isel(engine=0)).max("engine") + 0 * value
        mesh = relative * value
        errors[end] = mesh.where(mesh > apart, apart).transpose(*value.dims)
    return xr.Dataset(errors)


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
        Dataset of the map in one state.

    Returns
    -------
    str
    """
    names = [str(name) for name in dataset["engine"].values]
    error = float(error_of_model(dataset).max())
    return trust_line(names, error, engine_difference(dataset)) + damping.trust(dataset)


def disagreement(dataset: xr.Dataset, effect: xr.DataArray | None) -> tuple[str, ...]:
    """Advice where two engines differ by more than their errors, and no theory says why.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of the map in one state.
    effect : xarray.DataArray or None
        How much vibration moves frequencies, where running states were asked for.

    Returns
    -------
    tuple of str
        One, or none.
    """
    explained = effect is not None or theory_reason(dataset.attrs)
    difference = engine_difference(dataset)
    if explained or difference is None or not difference.worth_a_warning:
        return ()
    return (verdict(dataset, effect),)
