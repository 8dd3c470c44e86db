"""What a run answers: how far links bend, their stress, the joint forces and the torque."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.digits import Quantity, plain
from flexmech.analyses.response.agreement import (
    agreement_line,
    best_known,
    errors_of,
    errors_together,
    force_agreement_lines,
    quantities_of,
)
from flexmech.analyses.trust import EngineDifference, trust_line

# Variables with a peak, the unit in which it is told, and what a number is multiplied by.
_PEAKS = {
    "deflection": ("mm", 1e3),
    "stress": ("MPa", 1e-6),
    "joint_force": ("N", 1.0),
    "driving_torque": ("N m", 1.0),
}


def numbers(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """Greatest deflection and stress of each link, joint forces and torque, with their errors.

    Of the engine whose errors are the smaller. The error is the one that it estimates, or the
    difference of two engines where that is more.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a response.

    Returns
    -------
    tuple of Quantity
        ``peak_deflection``, ``peak_stress``, ``peak_joint_force`` and ``peak_driving_torque``.
    """
    errors, found = errors_of(dataset), list[Quantity]()
    place = best_known(errors["deflection"])
    for name, (unit, factor) in _PEAKS.items():
        if (peaks := dataset.get(f"peak_{name}")) is not None:
            own = errors[f"peak_{name}"] * peaks
            found += quantities_of(peaks, own, place, f"peak_{name}", unit, factor)
    return tuple(one for one in found if math.isfinite(one.value) and (one.value or not one.of))


def greatest(found: tuple[Quantity, ...], name: str) -> Quantity | None:
    """The greatest of the numbers of one name; None if there is none.

    Parameters
    ----------
    found : tuple of Quantity
    name : str
    """
    return max((one for one in found if one.name == name), key=lambda one: one.value, default=None)


def answer(dataset: xr.Dataset) -> tuple[str, ...]:
    """How far links bend, what pins carry, and what the motor must give.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a response.

    Returns
    -------
    tuple of str
    """
    found = numbers(dataset)
    bent, stress, force, torque = (greatest(found, f"peak_{name}") for name in _PEAKS)
    lines = ["No link bends: all are rigid."]
    if bent is not None:
        angles = dataset["peak_deflection_angle"].sel(link=bent.of).isel(engine=0)
        lines = [
            f"The {bent.of} bends by at most {bent}, at {DEGREES * float(angles) % 360:.0f} deg"
            f"{'' if stress is None else '; ' + stress_words(dataset, stress)}."
        ]
    carried = "" if force is None else f"Joint {force.of} carries up to {force}; "
    needed = "" if torque is None else f"the shaft needs up to {torque}."
    lines.append((carried + needed)[:1].upper() + (carried + needed)[1:])
    decays = dataset.attrs.get("damped", True) or "drive" in dataset.attrs
    if not decays and dataset.attrs.get("start") != "periodic":
        lines.append(
            "No link is damped, so that the vibration of the start does not decay: state damping, "
            "or ask for --start periodic."
        )
    return tuple(lines)


def stress_words(dataset: xr.Dataset, stress: Quantity) -> str:
    """Greatest stress, where it is, and the yield strength there.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a response.
    stress : Quantity
        Of :func:`numbers`.

    Returns
    -------
    str
    """
    own = dataset.sel(link=stress.of).isel(engine=0)
    place = f"{1e3 * float(own['peak_stress_place']):.3g} mm from its start"
    said = f"the greatest normal stress is {stress}, in the {stress.of}, {place}"
    bound = float(own["yield_strength"])
    return f"{said}; it yields at {plain(1e-6 * bound)} MPa" if math.isfinite(bound) else said


def yielding(dataset: xr.Dataset) -> tuple[str, ...]:
    """What to do with links whose stress is above the yield strength; or nothing.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a response.

    Returns
    -------
    tuple of str
    """
    found = []
    for one in numbers(dataset):
        if one.name != "peak_stress":
            continue
        bound = 1e-6 * float(dataset["yield_strength"].sel(link=one.of).isel(engine=0))
        if one.value > bound:
            found.append(
                f"the {one.of} yields: its stress reaches {one}, above the yield strength of "
                f"{plain(bound)} MPa; make it thicker or of a stronger material, or run slower"
            )
    return tuple(found)


def trust(dataset: xr.Dataset, agreement: xr.DataArray | None, forces: xr.Dataset | None) -> str:
    """How far the peaks are known, and whether the engines agree within their errors.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a response.
    agreement : xarray.DataArray or None
        Differences of deflections.
    forces : xarray.Dataset or None
        Differences of forces and torque.

    Returns
    -------
    str
    """
    names = [str(name) for name in dataset["engine"].values]
    known = [one.error / one.value for one in numbers(dataset) if one.value]
    error = max((each for each in known if math.isfinite(each)), default=math.nan)
    found = engine_difference(dataset, agreement, forces)
    # Differences of the peaks that errors explain are among their errors.
    return trust_line(names, error, None if found is None or found.agree else found)


def engine_difference(
    dataset: xr.Dataset, agreement: xr.DataArray | None, forces: xr.Dataset | None
) -> EngineDifference | None:
    """That of two engines' deflections, forces and torque which their errors explain least.

    Parameters
    ----------
    dataset, agreement, forces
        As in :func:`trust`.

    Returns
    -------
    EngineDifference or None
        None with a single engine.
    """
    if agreement is None or forces is None:
        return None
    gaps, errors = forces.assign(deflection=agreement), errors_together(dataset)
    apart, allowed, of = list[float](), list[float](), list[str]()
    for name in gaps:
        gap, error = xr.align(gaps[name], errors[name], join="left")
        apart += np.ravel(gap).tolist()
        allowed += np.ravel(error).tolist()
        what = str(name).replace("_", " ")
        labels = [f"{what} of {label}" for dim in gap.dims for label in gap[dim].values]
        of += labels or [what]
    return EngineDifference.least_explained(apart, allowed, of)


def disagreement(
    dataset: xr.Dataset, agreement: xr.DataArray | None, forces: xr.Dataset | None
) -> tuple[str, ...]:
    """What to do where the engines differ by more than their errors, and by much; or nothing.

    Parameters
    ----------
    dataset, agreement, forces
        As in :func:`trust`.
    """
    found = engine_difference(dataset, agreement, forces)
    if found is None or not found.worth_a_warning:
        return ()
    lines = (agreement_line(agreement, dataset), *force_agreement_lines(forces, dataset))
    return tuple(line.said for line in lines if not line.explained)
