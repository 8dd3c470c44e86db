"""What a run says: the table of peaks and the lines below it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.digits import MOST_DIGITS, rounded
from flexmech.analyses.response.agreement import errors_of, listed
from flexmech.analyses.summary import Table

# Of deflections in the table of peaks.
_TABLE_DIGITS = 5
# Rotation of a free shaft in rad beyond which equations for small ones show.
_LARGE_ROTATION = np.radians(5)
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
        Of :meth:`flexmech.analyses.Response.peaks`.
    start : float
        Crank angle at time zero in rad.
    title : str
    trusted : (str, str), optional
        Engine that stands for all, where they agree, and what it is called then.
    errors : xarray.Dataset, optional
        Of the peaks of ``deflection`` and ``stress`` over themselves, over (engine, link): digits
        that they do not support are left out.

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


def check_lines(dataset: xr.Dataset) -> list[str]:
    """Report how far the run may be trusted: energy, constraints, time step and mesh."""
    energy = listed(dataset["energy_error"])
    lines = [
        f"energy balance: off by at most {energy} of the peak kinetic energy",
        f"constraint drift: at most {listed(dataset['constraint_drift'], '{:.1e} m')}",
        f"time step: {listed(dataset['step'], '{:.4g} s')}",
        _deflection_errors(dataset, "step", "error by the time step (estimated)"),
        _force_errors(dataset, "step", "error of forces by the time step (estimated)"),
    ]
    reduced = dataset.sel(engine=dataset["reduction_error"] > 0)
    if reduced.sizes["engine"]:
        label = "component modes: twice the detail changes deflections"
        lines += [
            _deflection_errors(reduced, "reduction", label),
            _force_errors(reduced, "reduction", "component modes: twice the detail changes forces"),
        ]
    if "mesh_error" in dataset:
        lines += [
            _deflection_errors(dataset, "mesh", "mesh: twice the elements change deflections"),
            _force_errors(dataset, "mesh", "mesh: twice the elements change forces"),
        ]
    return lines


def _deflection_errors(dataset: xr.Dataset, cause: str, label: str) -> str:
    """Errors of deflections by one cause, of each link that deflects over its own peak."""
    bent = (dataset["peak_deflection"] > 0).any("engine")
    errors = dataset[f"{cause}_error_of_deflection"]
    errors = errors.sel(link=bent) if bent.any() else errors
    listed_errors = "; ".join(
        f"{listed(errors.sel(engine=engine))}, {engine}" for engine in errors["engine"].values
    )
    return f"{label}, of the link's peak: {listed_errors}"


def _force_errors(dataset: xr.Dataset, cause: str, label: str) -> str:
    """Errors of joint forces and torque by one cause; of the joint that is off most."""

    def error(of: str) -> str:
        return listed(_greatest(dataset[f"{cause}_error_of_{of}"]))

    return (
        f"{label}, of the peak: joint forces {error('force')}, their peaks {error('peak_force')}; "
        f"torque {error('torque')}, its peak {error('peak_torque')}"
    )


def _greatest(errors: xr.DataArray) -> xr.DataArray:
    """Over engine."""
    return errors.max([name for name in errors.dims if name != "engine"])


def shaft_lines(data: xr.Dataset) -> list[str]:
    """Report how far a free shaft leaves its prescribed motion, and what linear theory makes of it.

    Parameters
    ----------
    data : xarray.Dataset
        Of the response.

    Returns
    -------
    list of str
        None where the shaft turns as prescribed.
    """
    if "shaft_rotation" not in data:
        return []
    peak = data["peak_shaft_rotation"]
    part = 100 * data["peak_crank_speed_fluctuation"] / abs(data.attrs["crank_speed"])
    left = "under the torque that drives the rigid linkage; it leaves its prescribed "
    if "motor_torque" in data:
        left = "under the motor; with elastic links it leaves the rigid linkage's "
        if data.attrs["start"] == "periodic":
            left = "under the motor; it leaves the settled motion that was found directly in its "
    lines = [
        f"shaft: free, {left}"
        f"angle by at most {listed(DEGREES * peak, '{:.4g} deg')}, its speed the crank speed "
        f"by at most {listed(part, '{:.3g} %')}"
    ]
    if "motor_torque" in data:
        # Its equations follow the shaft at any rotation.
        return lines
    linear = peak.sel(engine=~data["nonlinear"].astype(bool))
    if linear.sizes["engine"] and float(linear.max()) > _LARGE_ROTATION:
        lines.append(
            f"shaft: the equations of {', '.join(map(str, linear['engine'].values))} are for "
            f"small rotations, its own is beyond the {np.degrees(_LARGE_ROTATION):.0f} deg up to "
            "which they hold; trust the exudyn engine, or give the shaft more inertia"
        )
    return lines


def stress_lines(dataset: xr.Dataset) -> list[str]:
    """Say of what the stress is, and of which links none is told."""
    own = dataset.isel(engine=0)
    known = np.isfinite(own["peak_stress"].values)
    without = [str(link) for link in dataset["link"].values[~known]]
    line = "stress: |N| / A + |M| h / (2 I) at the surfaces, greatest along the link"
    parts = [
        f"{link} {rounded(1e-6 * float(own['peak_axial_stress'].sel(link=link)), 0.0, 3)}"
        for link in dataset["link"].values[known]
    ]
    if parts:
        line += f"; by the normal force alone at most {', '.join(parts)} MPa"
    return [f"{line}; not known of {', '.join(without)}" if without else line]


def load_lines(peaks: xr.Dataset, data: xr.Dataset) -> list[str]:
    """Report the peaks of the driving torque and the joint forces, next to rigid links'.

    Parameters
    ----------
    peaks : xarray.Dataset
        Of :meth:`flexmech.analyses.Response.peaks`.
    data : xarray.Dataset
        Of the response.

    Returns
    -------
    list of str
    """
    rigid_torque = float(abs(data["rigid_driving_torque"]).max())
    rigid_force = np.hypot(*np.moveaxis(data["rigid_joint_force"].values, -1, 0)).max(axis=0)
    engines = [str(engine) for engine in data["engine"].values]
    errors = errors_of(data)

    def forces(engine: str) -> str:
        own = peaks["joint_force"].sel(engine=engine).values
        error = errors["peak_joint_force"].sel(engine=engine).values
        return line(
            [rounded(one, one * part) for one, part in zip(own, error, strict=True)], engine
        )

    def line(texts: Iterable[str], name: str) -> str:
        pairs = zip(data["joint"].values, texts, strict=True)
        shown = ", ".join(f"{joint} {force}" for joint, force in pairs)
        return f"peak joint forces: {shown} N ({name})"

    sides = zip(*(data[name].values for name in ("joint", "force_by", "force_on")), strict=True)
    acting = ", ".join(f"{joint} of the {by} on the {on}" for joint, by, on in sides)

    def torque(engine: str) -> str:
        own = peaks["driving_torque"].sel(engine=engine)
        error = errors["peak_driving_torque"].sel(engine=engine)
        return f"{rounded(float(own), float(own * error))} N m ({engine})"

    torques = ", ".join(map(torque, engines))
    return [
        f"forces and torque of elastic links count up to {data.attrs['force_band']:.4g} Hz, half "
        "the lowest frequency at which the links vibrate along themselves",
        f"joint forces: {acting}",
        f"peak driving torque: {torques}, {rigid_torque:.4g} N m (rigid links)",
        *map(forces, engines),
        line([f"{force:.4g}" for force in rigid_force], "rigid links"),
    ]


def spectrogram_lines(dataset: xr.Dataset) -> list[str]:
    """Say which frequencies the spectrogram resolves, or that there is none, and by what."""
    predicted = dataset.attrs.get("prediction_note")
    lines = [predicted] if predicted else []
    if "spectrogram" in dataset:
        note = dataset.attrs.get("spectrogram_note")
        return [*lines, f"spectrogram: {note}"] if note else lines
    longer = "give a longer dwell" if "drive" in dataset.attrs else "ask for more --revolutions"
    return [*lines, f"spectrogram: none, the run is too short for its window; {longer}"]


def _crank(angle: float, start: float) -> tuple[float, int]:
    """Crank angle in degrees from 0 to 360, and the turn since the start that it is in."""
    turned = abs(angle - start) / (2 * np.pi)
    degrees = round(float(np.degrees(angle)), 6) % 360
    return degrees, int(turned + _WHOLE_TURN) + 1
