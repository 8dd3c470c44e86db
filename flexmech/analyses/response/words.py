"""What a run says: the table of peaks and the lines below it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import xarray as xr

from flexmech.analyses.beam_theory import theory_reason
from flexmech.analyses.summary import Table
from flexmech.analyses.tables import DEGREES

__all__ = [
    "agreement_line",
    "check_lines",
    "force_agreement_line",
    "load_lines",
    "peak_table",
    "shaft_columns",
    "shaft_lines",
    "spectrogram_lines",
    "standing_for_all",
    "supported",
]

MOST_DIGITS = 4
# Deflection over a link's length beyond which linear kinematics shows.
LARGE_BOW = 0.01
# Rotation of a free shaft in rad beyond which equations that are linear in it show.
LARGE_ROTATION = np.radians(5)
# A crank angle this close below a whole turn, in turns, is the turn's end.
_WHOLE_TURN = 1e-9


def peak_table(
    peaks: xr.Dataset, start: float, title: str, trusted: tuple[str, str] | None = None
) -> Table:
    """Peak deflection and strain of each link, and where the crank stands then.

    Parameters
    ----------
    peaks : xarray.Dataset
        Of :meth:`flexmech.analyses.response.Response.peaks`.
    start : float
        Crank angle at time zero in rad.
    title : str
    trusted : (str, str), optional
        Engine that stands for all, where they agree, and what it is called then.

    Returns
    -------
    Table
        One row for each engine and link that is not rigid.
    """

    def row(engine: str, label: str, link: str) -> tuple[str, ...]:
        peak = peaks.sel(engine=engine, link=link)
        place = str(peak["probe"].item())
        degrees, turn = _crank(float(peak["deflection_angle"]), start)
        # A clamped link is bent most at its clamp; strain in its middle is no peak.
        strain = f"{1e6 * float(peak['strain']):.4g}" if place == "middle" else "-"
        deflection = f"{1e3 * float(peak['deflection']):.5g}"
        return (label, link, place, deflection, f"{degrees:.1f}", str(turn), strain)

    headings = ("engine", "link", "place", "deflection mm", "at deg", "turn", "strain 1e-6")
    bent = peaks.sel(link=(peaks["deflection"] > 0).any("engine"))
    links = [str(link) for link in (bent if bent.sizes["link"] else peaks)["link"].values]
    shown = [trusted] if trusted else [(str(e), str(e)) for e in peaks["engine"].values]
    groups = tuple(tuple(row(*engine, link) for link in links) for engine in shown)
    return Table(title, headings, groups, text_columns=3)


def check_lines(dataset: xr.Dataset) -> list[str]:
    """Report how far the run may be trusted: energy, constraints, time step and mesh."""
    energy = _listed(dataset["energy_error"])
    lines = [
        f"energy balance: off by at most {energy} of the peak kinetic energy",
        f"constraint drift: at most {_listed(dataset['constraint_drift'], '{:.1e} m')}",
        f"time step: {_listed(dataset['step'], '{:.4g} s')}",
        "error by the time step (estimated): at most "
        f"{_listed(dataset['step_error'])} of the peak deflection",
        _force_errors(dataset, "step", "error of forces by the time step (estimated)"),
    ]
    reduced = dataset.sel(engine=dataset["reduction_error"] > 0)
    if reduced.sizes["engine"]:
        changes = _listed(reduced["reduction_error"])
        lines += [
            f"component modes: twice the detail changes deflections by {changes}",
            _force_errors(reduced, "reduction", "component modes: twice the detail changes forces"),
        ]
    if "mesh_error" in dataset:
        changes = _listed(dataset["mesh_error"])
        lines += [
            f"mesh: twice the elements change deflections by {changes} of their peak",
            _force_errors(dataset, "mesh", "mesh: twice the elements change forces"),
        ]
    return lines


def _force_errors(dataset: xr.Dataset, kind: str, lead: str) -> str:
    """Errors of joint forces and torque by one cause."""

    def error(of: str) -> str:
        return _listed(dataset[f"{kind}_error_of_{of}"])

    return (
        f"{lead}, of the peak: joint forces {error('force')}, their peaks {error('peak_force')}; "
        f"torque {error('torque')}, its peak {error('peak_torque')}"
    )


def shaft_columns(data: xr.Dataset) -> dict[str, xr.DataArray]:
    """Columns of a free shaft's rotation and speed over (engine, time); none where it is not."""
    if "shaft_rotation" not in data:
        return {}
    return {
        "shaft_rotation_deg": DEGREES * data["shaft_rotation"],
        "crank_speed_fluctuation_rad_s": data["crank_speed_fluctuation"],
    }


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
    lines = [
        "shaft: free, under the torque that drives the rigid linkage; it leaves its prescribed "
        f"angle by at most {_listed(DEGREES * peak, '{:.4g} deg')}, its speed the crank speed "
        f"by at most {_listed(part, '{:.3g} %')}"
    ]
    linear = peak.sel(engine=~data["nonlinear"].astype(bool))
    if linear.sizes["engine"] and float(linear.max()) > LARGE_ROTATION:
        lines.append(
            f"shaft: the equations of {', '.join(map(str, linear['engine'].values))} are linear in "
            f"its rotation, which is beyond the {np.degrees(LARGE_ROTATION):.0f} deg up to which "
            "that holds; trust the exudyn engine, or give the shaft more inertia"
        )
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
    rigid_torque = float(abs(data["rigid_driving_torque"]).max())
    rigid_force = np.hypot(*np.moveaxis(data["rigid_joint_force"].values, -1, 0)).max(axis=0)
    engines = [str(engine) for engine in data["engine"].values]

    def error(engine: str, quantity: str) -> float:
        causes = [f"{cause}_error_of_peak_{quantity}" for cause in ("step", "reduction", "mesh")]
        return sum(float(data[name].sel(engine=engine)) for name in causes if name in data)

    def line(forces: Iterable[float], name: str, relative: float | None) -> str:
        joints = zip(data["joint"].values, forces, strict=True)
        shown = ", ".join(
            f"{joint} {force:.4g}" if relative is None else f"{joint} {supported(force, relative)}"
            for joint, force in joints
        )
        return f"peak joint forces: {shown} N ({name})"

    torques = [
        f"{supported(float(peaks['driving_torque'].sel(engine=e)), error(e, 'torque'))} N m ({e})"
        for e in engines
    ]
    return [
        f"forces and torque of elastic links count up to {data.attrs['force_band']:.4g} Hz, half "
        "the lowest frequency at which the links vibrate along themselves",
        f"peak driving torque: {', '.join(torques)}, {rigid_torque:.4g} N m (rigid links)",
        *(line(peaks["joint_force"].sel(engine=e).values, e, error(e, "force")) for e in engines),
        line(rigid_force, "rigid links", None),
    ]


def supported(value: float, error: float) -> str:
    """A value with the digits that its relative error supports, four at most.

    Parameters
    ----------
    value, error : float

    Returns
    -------
    str
        The last digit may be off by as many units as the first digit of the error says.

    Examples
    --------
    >>> supported(146.38, 4e-3)
    '146'
    """
    if not value:
        return "0"
    digits = MOST_DIGITS
    if error > 0:
        digits = min(MOST_DIGITS, max(1, int(np.floor(-np.log10(error))) + 1))
    decimals = digits - 1 - int(np.floor(np.log10(abs(value))))
    return f"{round(value, decimals):.{max(decimals, 0)}f}"


def spectrogram_lines(dataset: xr.Dataset) -> list[str]:
    """Say what the spectrogram tells apart, or that there is none, and what it is held against."""
    predicted = dataset.attrs.get("prediction_note")
    lines = [predicted] if predicted else []
    if "spectrogram" in dataset:
        note = dataset.attrs.get("spectrogram_note")
        return [*lines, f"spectrogram: {note}"] if note else lines
    return [
        *lines,
        "spectrogram: none, the run is too short for its window; ask for more --revolutions",
    ]


def _deflection_errors(dataset: xr.Dataset) -> xr.DataArray:
    """Errors of the deflections over their peak by all causes that are known, over engine."""
    causes = ("step_error", "reduction_error", "mesh_error")
    return sum((dataset[name] for name in causes if name in dataset), xr.DataArray(0.0))


def standing_for_all(agreement: xr.DataArray | None, dataset: xr.Dataset) -> tuple[str, str] | None:
    """The engine of the smallest errors where two agree within them, and what stands for both."""
    if agreement is None:
        return None
    errors = _deflection_errors(dataset)
    if float(agreement.max()) > float(errors[:2].sum()):
        return None
    return str(errors.idxmin("engine").item()), "both"


def agreement_line(agreement: xr.DataArray | None, dataset: xr.Dataset) -> str:
    """Say how far the engines differ at most, link by link; or that there is no comparison.

    Where that is more than their errors, also which one to trust.
    """
    engines = dataset["engine"].values
    if agreement is None:
        return f"engines: no comparison was made, only the {engines[0]} engine ran"
    line = (
        f"engines: deflections of {engines[0]} and {engines[1]} differ by at most "
        f"{_listed(agreement)} of the link's peak"
    )
    if standing_for_all(agreement, dataset):
        return f"{line}, within their estimated errors"
    return f"{line}{theory_reason(dataset.attrs) or _whom_to_trust(dataset)}"


def _whom_to_trust(dataset: xr.Dataset) -> str:
    """Of engines that differ by more than their errors."""
    bow = abs(dataset["deflection"]).max(("engine", "time")) / dataset["length"]
    nonlinear = dataset["nonlinear"].astype(bool)
    simulated = dataset["engine"].values[nonlinear.values]
    if float(bow.max()) > LARGE_BOW and len(simulated) == 1:
        link, most = bow.idxmax("link").item(), 100 * float(bow.max())
        return (
            f"; trust {simulated[0]}, which follows displacements of any size: {link} deflects by "
            f"up to {most:.2g} % of its length, and linear equations leave the joints where the "
            "rigid linkage has them"
        )
    errors = _deflection_errors(dataset)
    better = f"trust {errors.idxmin('engine').item()}, whose errors are the smaller"
    if "mesh_error" not in dataset:
        better += "; --check-mesh gives the error by the mesh, which is not among them"
    said = _listed(errors)
    return f", which is beyond their estimated errors, {said}; {better}"


def force_agreement_line(agreement: xr.Dataset | None, dataset: xr.Dataset) -> list[str]:
    """Say how far the engines' forces and torque differ at most, if there are two."""
    if agreement is None:
        return []
    first, second = dataset["engine"].values[:2]
    band = f"up to {dataset.attrs['force_band']:.3g} Hz"
    forces, torque = agreement["joint_force"], float(agreement["driving_torque"])
    peaks, peak = agreement["peak_joint_force"], float(agreement["peak_driving_torque"])
    return [
        f"engines: joint forces {band} of {first} and {second} differ by at most "
        f"{_listed(forces)} of the joint's peak, torque by {torque:.1e}",
        f"engines: peaks of these joint forces differ by {_listed(peaks)}, of torque by {peak:.1e}",
    ]


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
