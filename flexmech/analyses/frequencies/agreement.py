"""How far two engines' frequencies differ, and whether their errors explain it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from flexmech.analyses.beam_theory import theory_reason
from flexmech.analyses.frequencies.extremes import error_of_model
from flexmech.analyses.frequencies.words import MOST_DECIMALS
from flexmech.analyses.remarks import speed_text
from flexmech.analyses.trust import EngineDifference, least_explained
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
        Of a map in one state.

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
    """That of two engines' frequencies which their errors explain least.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a map in one state.

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
    """What the errors of two engines explain together, shape (speeds, angles, modes).

    Of errors that are no small parts the product counts too.
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
        Of a map in one state.
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
    found, unit = _at(dataset, difference, place), speed_unit(dataset)
    first, second = found.engines
    at_most = "at most " if place == difference.argmax() else ""
    return (
        f"engines: {first} and {second} differ by {at_most}{found.relative_difference:.2e} of "
        f"the frequency, at {speed_text(found.crank_speed, unit)} {unit}, "
        f"{np.degrees(found.crank_angle):.6g} deg, mode {found.mode}"
        f"{_judged(found, explained, dataset, effect)}"
    )


def _judged(
    found: EngineAgreement, explained: bool, dataset: xr.Dataset, effect: xr.DataArray | None
) -> str:
    """Whether errors explain how far the engines differ; if not, which one to trust."""
    place = {"crank_speed": found.crank_speed, "mode": found.mode}
    error = error_of_model(dataset).sel(place)
    errors = {name: float(error.sel(engine=name)) for name in found.engines}
    said = " and ".join(f"{errors[name]:.1e} of {name}" for name in found.engines)
    if explained:
        beyond = _beyond_tolerance(found.relative_difference, errors, dataset)
        return f", within their estimated errors ({said}){beyond}"
    if reason := theory_reason(dataset.attrs):
        return reason
    if effect is not None:
        moving = str(abs(effect).max(DIMS[1:]).idxmax("engine").item())
        return f"; trust {moving}, whose links are in the states of the running motion"
    better, elements = min(errors, key=lambda name: errors[name]), dataset.sel(place)["element"]
    kinds = ", ".join(f"{elements.sel(engine=name).item()} ({name})" for name in found.engines)
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
        f"{elements} elements on a link that are taken unasked; trust {better}"
    )
