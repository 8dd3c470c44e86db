"""What a run says: the table of peaks and the lines below it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import xarray as xr

from flexmech.analyses.summary import Table

__all__ = ["agreement_line", "check_lines", "load_lines", "peak_table", "spectrogram_lines"]

# A crank angle this close below a whole turn, in turns, is the turn's end.
_WHOLE_TURN = 1e-9


def peak_table(peaks: xr.Dataset, start: float, title: str) -> Table:
    """Peak deflection and strain of each link, and where the crank stands then.

    Parameters
    ----------
    peaks : xarray.Dataset
        Of :meth:`flexmech.analyses.response.Response.peaks`.
    start : float
        Crank angle at time zero in rad.
    title : str

    Returns
    -------
    Table
        One row for each engine and link.
    """

    def row(engine: str, link: str) -> tuple[str, ...]:
        peak = peaks.sel(engine=engine, link=link)
        place = str(peak["probe"].item())
        degrees, turn = _crank(float(peak["deflection_angle"]), start)
        # A clamped link is bent most at its clamp; strain in its middle is no peak.
        strain = f"{1e6 * float(peak['strain']):.4g}" if place == "middle" else "-"
        deflection = f"{1e3 * float(peak['deflection']):.5g}"
        return (engine, link, place, deflection, f"{degrees:.6g}", str(turn), strain)

    headings = ("engine", "link", "place", "deflection mm", "at deg", "turn", "strain 1e-6")
    links = [str(link) for link in peaks["link"].values]
    groups = tuple(
        tuple(row(str(engine), link) for link in links) for engine in peaks["engine"].values
    )
    return Table(title, headings, groups, text_columns=3)


def check_lines(dataset: xr.Dataset) -> list[str]:
    """Report how far the run may be trusted: energy, constraints, time step and mesh."""
    energy, step_error = _listed(dataset["energy_error"]), _listed(dataset["step_error"])
    lines = [
        f"energy balance: off by at most {energy} of the peak kinetic energy",
        f"constraint drift: at most {_listed(dataset['constraint_drift'], '{:.1e} m')}",
        f"time step: {_listed(dataset['step'], '{:.4g} s')}",
        f"error by the time step (estimated): at most {step_error} of the peak deflection",
    ]
    reduced = dataset["reduction_error"].where(dataset["reduction_error"] > 0, drop=True)
    if reduced.size:
        lines.append(f"component modes: twice the detail changes deflections by {_listed(reduced)}")
    if "mesh_error" in dataset:
        mesh = _listed(dataset["mesh_error"])
        lines.append(f"mesh: twice the elements change deflections by {mesh} of their peak")
    return lines


def load_lines(peaks: xr.Dataset, data: xr.Dataset) -> list[str]:
    """Report the peaks of the driving torque and the joint forces, next to rigid links'.

    Parameters
    ----------
    peaks : xarray.Dataset
        Of :meth:`flexmech.analyses.response.Response.peaks`.
    data : xarray.Dataset
        Of the response.

    Returns
    -------
    list of str
    """
    torque = _listed(peaks["driving_torque"], "{:.4g} N m")
    rigid_torque = float(abs(data["rigid_driving_torque"]).max())
    rigid_force = np.hypot(*np.moveaxis(data["rigid_joint_force"].values, -1, 0)).max(axis=0)

    def line(forces: Iterable[float], name: str) -> str:
        joints = zip(data["joint"].values, forces, strict=True)
        shown = ", ".join(f"{joint} {force:.4g}" for joint, force in joints)
        return f"peak joint forces: {shown} N ({name})"

    return [
        f"peak driving torque: {torque}, {rigid_torque:.4g} N m (rigid links)",
        *(line(peaks["joint_force"].sel(engine=e).values, e) for e in peaks["engine"].values),
        line(rigid_force, "rigid links"),
    ]


def spectrogram_lines(dataset: xr.Dataset) -> list[str]:
    """Say that there is no spectrogram, where there is none."""
    if "spectrogram" in dataset:
        return []
    return ["spectrogram: none, the run is too short for its window; ask for more --revolutions"]


def agreement_line(agreement: xr.DataArray | None, dataset: xr.Dataset) -> str:
    """Say how far the engines differ at most, link by link; or that there is no comparison."""
    engines = dataset["engine"].values
    if agreement is None:
        return f"engines: no comparison was made, only the {engines[0]} engine ran"
    return (
        f"engines: deflections of {engines[0]} and {engines[1]} differ by at most "
        f"{_listed(agreement)} of the link's peak"
    )


def _crank(angle: float, start: float) -> tuple[float, int]:
    """Crank angle in degrees from 0 to 360, and the turn since the start that it is in."""
    turned = abs(angle - start) / (2 * np.pi)
    degrees = round(float(np.degrees(angle)), 6) % 360
    return degrees, int(turned + _WHOLE_TURN) + 1


def _listed(values: xr.DataArray, form: str = "{:.1e}") -> str:
    """Values along a dimension, each with its label behind it."""
    labels = values[values.dims[0]].values
    return ", ".join(
        f"{form.format(value)} ({label})"
        for label, value in zip(labels, values.values, strict=True)
    )
