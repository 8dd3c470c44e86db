"""Whether two engines agree within the errors that they estimate of themselves, and in words."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from flexmech.analyses.beam_theory import theory_reason
from flexmech.analyses.digits import Quantity
from flexmech.analyses.summary import least_explained

CAUSES = ("step", "reduction", "mesh", "rotation")
# Names of :meth:`Response.agreement` and :meth:`Response.force_agreement`, and of the errors of
# each cause.
_ERRORS = {
    "deflection": "deflection",
    "peak_deflection": "peak_deflection",
    "peak_stress": "peak_stress",
    "joint_force": "force",
    "peak_joint_force": "peak_force",
    "driving_torque": "torque",
    "peak_driving_torque": "peak_torque",
}
# The same of points that move, and of a frame on springs.
_ERRORS_OF_POINTS = {"path_deviation": "path", "peak_path_deviation": "peak_path"}
_ERRORS_OF_FRAME = dict.fromkeys(("frame_displacement", "frame_rotation", "floor_force"), "frame")
# Deflection over a link's length beyond which linear equations show: a damping time that is fitted
# to deflections of 3 mm of 280 mm is off by 2 %, to 6.5 mm by 5 %.
LARGE_BOW = 0.01
# Rotation of a frame in rad beyond which linear equations show: they are off by about as much.
LARGE_ROTATION = 0.01


def errors_of(dataset: xr.Dataset) -> xr.Dataset:
    """Errors by step, component modes, a frame's rotation and, where it was checked, mesh together.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a response.

    Returns
    -------
    xarray.Dataset
        ``deflection``, ``peak_deflection`` and ``peak_stress`` over (engine, link), ``joint_force``
        and ``peak_joint_force`` over (engine, joint), ``driving_torque`` and
        ``peak_driving_torque`` over (engine); each over its own peak. Of points that move also
        ``path_deviation`` and ``peak_path_deviation`` over (engine, point), of a frame on springs
        ``frame_displacement``, ``frame_rotation`` and ``floor_force`` over (engine).
    """
    known = [cause for cause in CAUSES if f"{cause}_error" in dataset]
    names = _ERRORS | (_ERRORS_OF_FRAME if "frame_rotation" in dataset else {})
    names |= _ERRORS_OF_POINTS if "path_deviation" in dataset else {}
    by_cause = (
        xr.Dataset({name: dataset[f"{cause}_error_of_{of}"] for name, of in names.items()})
        for cause in known
    )
    return sum(by_cause, start=xr.Dataset(dict.fromkeys(names, 0.0)))


def best_known(errors: xr.DataArray) -> int:
    """Place of the engine whose greatest error over the links is the least.

    Parameters
    ----------
    errors : xarray.DataArray
        Over (engine, link).
    """
    return int(errors.max("link").argmin("engine"))


def quantities_of(
    values: xr.DataArray, errors: xr.DataArray, place: int, name: str, unit: str, factor: float
) -> list[Quantity]:
    """Numbers of one engine; the error is its own, or how far engines differ where that is more.

    Parameters
    ----------
    values : xarray.DataArray
        Over (engine), or over (engine, link) or (engine, joint), in SI units.
    errors : xarray.DataArray
        Errors of these.
    place : int
        Place of the engine.
    name, unit : str
    factor : float
        From the SI unit to ``unit``.

    Returns
    -------
    list of Quantity
        One, or one for each link or joint.
    """
    own = values.isel(engine=place)
    apart = abs(values - own).max("engine")
    worst = np.maximum(errors.isel(engine=place).values, apart.values)
    labels = own[own.dims[0]].values if own.dims else [""]
    pairs = zip(np.atleast_1d(own.values), np.atleast_1d(worst), strict=True)
    return [
        Quantity(name, factor * float(value), unit, factor * float(error), str(of))
        for of, (value, error) in zip(labels, pairs, strict=True)
    ]


def peak_quantities(dataset: xr.Dataset, name: str, unit: str, factor: float) -> list[Quantity]:
    """Peaks with their errors, of the engine whose deflections are known best.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a response.
    name : str
        Name of the variable, such as ``"peak_stress"``.
    unit : str
    factor : float
        From the SI unit to ``unit``.

    Returns
    -------
    list of Quantity
        Empty where the run has no such peaks.
    """
    if name not in dataset:
        return []
    errors = errors_of(dataset)
    peaks, place = dataset[name], best_known(errors["deflection"])
    return quantities_of(peaks, errors[name] * peaks, place, name, unit, factor)


def motion_gaps(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """How far the first two engines differ in the motion of points and of a frame, over its peaks.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a response.

    Returns
    -------
    dict of str to xarray.DataArray
        By the names of :func:`errors_of`: ``path_deviation`` over (point) where points move, and
        the three of a frame on springs.
    """
    histories = {name: dataset[name] for name in _ERRORS_OF_FRAME if name in dataset}
    if "path_deviation" in dataset:
        away = dataset["point_position"] - dataset["rigid_point_position"]
        histories["path_deviation"] = away
    found = {}
    for name, values in histories.items():
        if "component" not in values.dims:
            values = values.expand_dims("component")
        first, second = (values.isel(engine=number, drop=True) for number in (0, 1))
        apart, peak = (
            ((own**2).sum("component") ** 0.5).max("time") for own in (first - second, second)
        )
        found[name] = apart / peak
    return found


def within_errors(gaps: xr.Dataset, dataset: xr.Dataset) -> xr.Dataset:
    """Whether two engines differ by no more than their errors together.

    Parameters
    ----------
    gaps : xarray.Dataset
        Differences over the peak, by the names of :func:`errors_of`.
    dataset : xarray.Dataset
        Dataset of the response.

    Returns
    -------
    xarray.Dataset
        Of bool, by the names and the dimensions of the differences.
    """
    allowed = errors_together(dataset)
    return xr.Dataset({name: gaps[name] <= allowed[name] for name in gaps})


def errors_together(dataset: xr.Dataset) -> xr.Dataset:
    """:func:`errors_of` both engines together, which explain a difference of them."""
    return errors_of(dataset).isel(engine=slice(2)).sum("engine")


def representative(agreement: xr.DataArray | None, dataset: xr.Dataset) -> tuple[str, str] | None:
    """The engine of the smallest errors where two agree within them, and a label for both."""
    if agreement is None:
        return None
    if not within_errors(xr.Dataset({"deflection": agreement}), dataset)["deflection"].all():
        return None
    worst = errors_of(dataset)["deflection"].max("link")
    return str(worst.idxmin("engine").item()), "both"


class JudgedLine(NamedTuple):
    """A line on how far two engines differ, and whether their errors explain that.

    Parameters
    ----------
    said : str
    explained : bool
    """

    said: str
    explained: bool


def agreement_line(agreement: xr.DataArray | None, dataset: xr.Dataset) -> JudgedLine:
    """Say how far the engines differ at most, link by link; or that there is no comparison.

    Where that is more than their errors, also which one to trust.
    """
    engines = dataset["engine"].values
    if agreement is None:
        alone = f"engines: no comparison was made, only the {engines[0]} engine ran"
        return JudgedLine(alone, True)
    said = (
        f"engines: deflections of {engines[0]} and {engines[1]} differ by at most "
        f"{listed(agreement)} of the link's peak"
    )
    return _judged(said, agreement, errors_of(dataset)["deflection"], dataset)


def force_agreement_lines(agreement: xr.Dataset | None, dataset: xr.Dataset) -> list[JudgedLine]:
    """Say how far the engines' forces and torque differ, and whether their errors explain it.

    None with a single engine.
    """
    if agreement is None:
        return []
    first, second = dataset["engine"].values[:2]
    band = f"up to {dataset.attrs['force_band']:.3g} Hz"
    torque, peak = (float(agreement[name]) for name in ("driving_torque", "peak_driving_torque"))
    errors = errors_of(dataset)

    def judged(said: str, force: str, torque: str) -> JudgedLine:
        gaps, own = (_side_by_side(part, force, torque) for part in (agreement, errors))
        return _judged(said, gaps, own, dataset)

    along = (
        f"engines: joint forces {band} of {first} and {second} differ by at most "
        f"{listed(agreement['joint_force'])} of the joint's peak, torque by {torque:.1e}"
    )
    peaks = (
        "engines: peaks of these joint forces differ by "
        f"{listed(agreement['peak_joint_force'])}, of torque by {peak:.1e}"
    )
    return [
        judged(along, "joint_force", "driving_torque"),
        judged(peaks, "peak_joint_force", "peak_driving_torque"),
        *_frame_lines(agreement, dataset),
    ]


def _frame_lines(agreement: xr.Dataset, dataset: xr.Dataset) -> list[JudgedLine]:
    """How far the engines differ in the motion of a frame on springs; none where it stands."""
    names = [name for name in _ERRORS_OF_FRAME if name in agreement]
    if not names:
        return []
    labels = [name.replace("_", " ") for name in names]
    gaps, errors = (
        xr.concat([part[name] for name in names], xr.DataArray(labels, dims="of", name="of"))
        for part in (agreement, errors_of(dataset))
    )
    first, second = dataset["engine"].values[:2]
    said = f"engines: {first} and {second} differ by at most {listed(gaps)} of the peak"
    return [_judged(said, gaps, errors, dataset)]


def _side_by_side(part: xr.Dataset, force: str, torque: str) -> xr.DataArray:
    """Joint forces and torque along one dimension."""
    both = (part[force], part[torque].expand_dims(joint=["torque"]))
    said = ("joint_kind", "force_on", "force_by")
    return xr.concat([values.drop_vars(said, errors="ignore") for values in both], "joint")


def _judged(said: str, gaps: xr.DataArray, errors: xr.DataArray, dataset: xr.Dataset) -> JudgedLine:
    """A line on differences to its end: within the errors, or why not and which engine to trust.

    Parameters
    ----------
    said : str
    gaps : xarray.DataArray
        Over links, or joints and torque.
    errors : xarray.DataArray
        Over engine too.
    dataset : xarray.Dataset
    """
    (of,) = gaps.dims
    errors = errors.sel({of: gaps[of]}).isel(engine=slice(2))
    allowed = errors.sum("engine")
    if bool((gaps <= allowed).all()):
        return JudgedLine(f"{said}, within their estimated errors", True)
    if reason := theory_reason(dataset.attrs) or _large_rotation(dataset) or _large_bow(dataset):
        return JudgedLine(f"{said}{reason}", False)
    worst = {of: gaps[of].values[least_explained(gaps.values, allowed.values)]}
    estimated = errors.sel(worst)
    why = f", which is beyond their estimated errors (of {worst[of]}: {listed(estimated)})"
    return JudgedLine(f"{said}{why}{_unexplained(estimated, dataset)}", False)


def _unexplained(estimated: xr.DataArray, dataset: xr.Dataset) -> str:
    """Say which errors the estimates leave out, and which engine to trust if that is known.

    Parameters
    ----------
    estimated : xarray.DataArray
        Errors over engine.
    dataset : xarray.Dataset
    """
    nonlinear = dataset["nonlinear"].values.astype(bool)[: estimated.sizes["engine"]]
    simulated, linear = (
        estimated["engine"].values[nonlinear],
        estimated["engine"].values[~nonlinear],
    )
    left_out = f"the nonlinear terms that {linear[0]} leaves out" if linear.size else ""
    if "mesh_error" not in dataset:
        missing = ["the mesh error (--check-mesh gives it)"]
        missing += [left_out] if simulated.size and linear.size else []
        return f"; these estimates do not cover {' and '.join(missing)}"
    if simulated.size and linear.size:
        return f"; trust {simulated[0]}: no estimate covers {left_out}"
    return f"; trust {estimated.idxmin('engine').item()}, whose errors are the smaller"


def _large_rotation(dataset: xr.Dataset) -> str:
    """Why to trust the engine in which a frame turns by any angle; nothing of small rotations."""
    turned = float(dataset.get("rotation_error", xr.DataArray(0.0)).max())
    simulated = dataset["engine"].values[dataset["nonlinear"].values.astype(bool)]
    if turned <= LARGE_ROTATION or len(simulated) != 1:
        return ""
    return (
        f"; trust {simulated[0]}, in which a frame turns by any angle: it turns by up to "
        f"{np.degrees(turned):.2g} deg, and linear equations hold for small rotations"
    )


def _large_bow(dataset: xr.Dataset) -> str:
    """Why to trust the engine whose displacements may be large; nothing where they are small."""
    bow = abs(dataset["deflection"]).max(("engine", "time")) / dataset["length"]
    simulated = dataset["engine"].values[dataset["nonlinear"].values.astype(bool)]
    if float(bow.max()) <= LARGE_BOW or len(simulated) != 1:
        return ""
    link, most = bow.idxmax("link").item(), 100 * float(bow.max())
    return (
        f"; trust {simulated[0]}, which follows displacements of any size: {link} deflects by "
        f"up to {most:.2g} % of its length, and linear equations leave the joints where the "
        "rigid linkage has them"
    )


def listed(values: xr.DataArray, form: str = "{:.1e}") -> str:
    """Values along a dimension, each with its label behind it.

    Parameters
    ----------
    values : xarray.DataArray
        Values of one dimension with labels.
    form : str

    Returns
    -------
    str
    """
    labels = values[values.dims[0]].values
    return ", ".join(
        f"{form.format(value)} ({label})"
        for label, value in zip(labels, values.values, strict=True)
    )
