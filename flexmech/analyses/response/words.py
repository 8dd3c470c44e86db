"""What a run says: the table of peaks and the lines below it.

What a run answers: how far links bend, their stress, the joint forces and the torque.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.details import details_table
from flexmech.analyses.digits import MOST_DIGITS, Quantity, rounded
from flexmech.analyses.response.agreement import (
    agreement_line,
    errors_of,
    errors_together,
    force_agreement_lines,
    peak_quantities,
)
from flexmech.analyses.response.path import path_words
from flexmech.analyses.response.stresses import stress_words
from flexmech.analyses.summary import EngineDifference, Table, trust_line

# Digits of deflections in the table of peaks.
_TABLE_DIGITS = 5
# A crank angle this close below a whole turn, in turns, is the turn's end.
_WHOLE_TURN = 1e-9


def peak_table(
    peaks: xr.Dataset,
    start: float,
    title: str,
    trusted: tuple[str, str] | None = None,
    errors: xr.Dataset | None = None,
) -> Table:
    """Peak deflection, strain and stress of each link, where, and the crank angle then.

    Parameters
    ----------
    peaks : xarray.Dataset
        Peaks as of :meth:`flexmech.analyses.Response.peaks`.
    start : float
        Crank angle at time zero in rad.
    title : str
    trusted : (str, str), optional
        Engine that stands for all, where they agree, and what it is called then.
    errors : xarray.Dataset, optional
        Errors of the peaks of ``deflection`` and ``stress`` over themselves, over (engine, link):
        digits that they do not support are left out.

    Returns
    -------
    Table
        One row for each engine and link that is not rigid.
    """

    def row(engine: str, label: str, link: str) -> tuple[str, ...]:
        peak = peaks.sel(engine=engine, link=link)
        place = str(peak["probe"].item())
        degrees, turn = _crank(float(peak["deflection_angle"]), start)

        def told(name: str, factor: float, digits: int = MOST_DIGITS, by: str = "stress") -> str:
            value = factor * float(peak[name])
            error = 0.0 if errors is None else float(errors[by].sel(engine=engine, link=link))
            return rounded(value, value * error, digits) if np.isfinite(value) else "-"

        deflection = told("deflection", 1e3, _TABLE_DIGITS, by="deflection")
        # A clamped link is bent most at its clamp; strain in its middle is no peak.
        strain = told("strain", 1e6) if place == "middle" else "-"
        stress = told("stress", 1e-6), "-", "-"
        if np.isfinite(peak["stress"]):
            stressed, _ = _crank(float(peak["stress_angle"]), start)
            stress = stress[0], f"{1e3 * float(peak['stress_place']):.3g}", f"{stressed:.1f}"
        return (label, link, place, deflection, f"{degrees:.1f}", str(turn), strain, *stress)

    headings = (
        *("engine", "link", "place", "deflection mm", "at deg", "turn"),
        *("strain 1e-6", "stress MPa", "at mm", "at deg"),
    )
    bent = peaks.sel(link=(peaks["deflection"] > 0).any("engine"))
    links = [str(link) for link in (bent if bent.sizes["link"] else peaks)["link"].values]
    shown = [trusted] if trusted else [(str(e), str(e)) for e in peaks["engine"].values]
    groups = tuple(tuple(row(*engine, link) for link in links) for engine in shown)
    return Table(title, headings, groups, text_columns=3)


# Checks of a run: in words, with the printed unit and what a number is multiplied by.
_CHECKS = {
    "energy_error": ("energy gap over peak kinetic energy", "%", 100.0),
    "constraint_drift": ("constraint drift", "m", 1.0),
    "step": ("time step", "ms", 1e3),
}
# Causes of errors, in words.
_CAUSES = {
    "step": "time step",
    "reduction": "component modes",
    "mesh": "mesh",
    "rotation": "frame rotation",
}
_OF_FORCES = {
    "force": "forces",
    "peak_force": "their peaks",
    "torque": "torque",
    "peak_torque": "its peak",
}


def check_tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    """How far the run may be trusted: energy, constraints, and errors by their causes."""
    quantities = [
        Quantity(words, factor * float(value), unit, of=str(engine))
        for name, (words, unit, factor) in _CHECKS.items()
        for engine, value in zip(dataset["engine"].values, dataset[name].values, strict=True)
    ]
    errors = errors_of(dataset)["peak_driving_torque"]
    quantities += [
        Quantity("peak driving torque", float(one), "N m", float(errors[n] * one), str(engine))
        for n, (engine, one) in enumerate(
            zip(dataset["engine"].values, dataset["peak_driving_torque"].values, strict=True)
        )
    ]
    rigid = float(abs(dataset["rigid_driving_torque"]).max())
    quantities.append(Quantity("peak driving torque", rigid, "N m", of="rigid links"))
    band = float(dataset.attrs["force_band"])
    quantities.append(Quantity("band of forces and torque", band, "Hz", of="elastic links"))
    return (*details_table(quantities), _error_table(dataset))


def _error_table(dataset: xr.Dataset) -> Table:
    """Errors by each cause: of each link that deflects, and of the joint that is off most."""
    bent = (dataset["peak_deflection"] > 0).any("engine")
    links = dataset["link"].values[bent.values] if bent.any() else dataset["link"].values
    groups = []
    for cause, words in _CAUSES.items():
        # Links that are not reduced have no component modes.
        known = dataset.get(f"{cause}_error", xr.zeros_like(dataset["step"])) > 0
        rows = []
        for engine in dataset["engine"].values[known.values]:
            own = dataset.sel(engine=engine)
            errors = [*own[f"{cause}_error_of_deflection"].sel(link=links).values]
            errors += [own[f"{cause}_error_of_{name}"].max() for name in _OF_FORCES]
            rows.append((words, str(engine), *(f"{float(error):.1e}" for error in errors)))
        groups.append(tuple(rows))
    return Table(
        "estimated errors of deflections, joint forces and torque, over their peaks",
        ("by", "engine", *map(str, links), *_OF_FORCES.values()),
        tuple(filter(None, groups)),
        text_columns=2,
    )


def force_table(peaks: xr.Dataset, data: xr.Dataset) -> Table:
    """Peaks of the joint forces, next to rigid links'.

    Parameters
    ----------
    peaks : xarray.Dataset
        Peaks as of :meth:`flexmech.analyses.Response.peaks`.
    data : xarray.Dataset
        Data of the response.

    Returns
    -------
    Table
    """
    engines = [str(engine) for engine in data["engine"].values]
    force = peaks["joint_force"]
    error = errors_of(data)["peak_joint_force"] * force
    texts = np.vectorize(rounded, otypes=[object])(force.values, error.values)
    force = force.copy(data=texts)
    rigid_force = np.hypot(*np.moveaxis(data["rigid_joint_force"].values, -1, 0)).max(axis=0)
    sides = (data[name].values.tolist() for name in ("joint", "force_by", "force_on"))
    rows = (
        (*side, *force.isel(joint=number).values, f"{rigid_force[number]:.4g}")
        for number, side in enumerate(zip(*sides, strict=True))
    )
    headings = ("joint", "of", "on", *engines, "rigid links")
    return Table("peak joint forces in N", headings, (tuple(rows),), text_columns=3)


def spectrogram_lines(dataset: xr.Dataset) -> list[str]:
    """Say which frequencies the spectrogram resolves, or that there is none, and by what."""
    predicted = dataset.attrs.get("prediction_note")
    lines = [predicted] if predicted else []
    if "spectrogram" in dataset:
        note = dataset.attrs.get("spectrogram_note")
        return [*lines, f"spectrogram: {note}"] if note else lines
    longer = "give a longer dwell" if "drive" in dataset.attrs else "ask for more --revolutions"
    return [*lines, f"spectrogram: not drawn, the run is shorter than its window; {longer}"]


def _crank(angle: float, start: float) -> tuple[float, int]:
    """Crank angle in degrees from 0 to 360, and the turn since the start that it is in."""
    turned = abs(angle - start) / (2 * np.pi)
    degrees = round(float(np.degrees(angle)), 6) % 360
    return degrees, int(turned + _WHOLE_TURN) + 1


# Variables with a peak, its printed unit, and what a number is multiplied by.
_PEAKS = {
    "deflection": ("mm", 1e3),
    "stress": ("MPa", 1e-6),
    "joint_force": ("N", 1.0),
    "driving_torque": ("N m", 1.0),
    "path_deviation": ("mm", 1e3),
}


def numbers(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """Greatest deflection and stress of each link, joint forces and torque, with their errors.

    Of the engine whose errors are the smaller. The error is the one that it estimates, or the
    difference of two engines where that is more.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a response.

    Returns
    -------
    tuple of Quantity
        ``peak_deflection``, ``peak_stress``, ``peak_joint_force``, ``peak_driving_torque`` and
        ``peak_path_deviation``.
    """
    found = (
        one
        for name, (unit, factor) in _PEAKS.items()
        for one in peak_quantities(dataset, f"peak_{name}", unit, factor)
    )
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
        Dataset of a response.

    Returns
    -------
    tuple of str
    """
    found = numbers(dataset)
    bent, stress, force, torque, path = (greatest(found, f"peak_{name}") for name in _PEAKS)
    lines = ["No link bends: all are rigid."]
    if bent is not None:
        angles = dataset["peak_deflection_angle"].sel(link=bent.of).isel(engine=0)
        the = "In settled motion the" if dataset.attrs.get("start") == "periodic" else "The"
        lines = [
            f"{the} {bent.of} bends by at most {bent}, at {DEGREES * float(angles) % 360:.0f} deg"
            f"{'' if stress is None else '; ' + stress_words(dataset, stress)}."
        ]
    carried = "" if force is None else f"Joint {force.of} carries up to {force}; "
    needed = "" if torque is None else f"the shaft needs up to {torque}."
    lines.append((carried + needed)[:1].upper() + (carried + needed)[1:])
    if path is not None:
        lines.append(path_words(dataset, path))
    decays = dataset.attrs.get("damped", True) or "drive" in dataset.attrs
    if not decays and dataset.attrs.get("start") != "periodic":
        lines.append(
            "Without damping the starting vibration never decays: add damping, or ask for --start "
            "periodic."
        )
    return tuple(lines)


def trust(dataset: xr.Dataset, agreement: xr.DataArray | None, forces: xr.Dataset | None) -> str:
    """How far the peaks are known, and whether the engines agree within their errors.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a response.
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
    return trust_line(names, error, engine_difference(dataset, agreement, forces))


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
    difference = EngineDifference.least_explained(apart, allowed, of)
    if "mesh_error" in dataset:
        return difference
    return replace(difference, left_out="those of the mesh (more --elements show them)")


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
