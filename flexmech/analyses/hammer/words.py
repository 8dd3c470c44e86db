"""A hammer test in words: the modes identified, how far noise lets them vary, how it was taken."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.beam_theory import theory_lines
from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.digits import Quantity, rounded, with_error
from flexmech.analyses.summary import Summary, Table, warnings_of
from flexmech.arrays import FloatArray


def hammer_summary(dataset: xr.Dataset) -> Summary:
    """Modes identified, as papers print them, and how near they are to the eigen model.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a ``HammerTest``.

    Returns
    -------
    Summary
    """
    return Summary(
        _answer(dataset),
        _mode_table(dataset),
        _verdict(dataset),
        (*_record_lines(dataset), *theory_lines(dataset.attrs)),
        (*_unfound_warnings(dataset), *warnings_of(dataset.attrs)),
        _numbers(dataset),
    )


_HEADINGS = ("crank deg", "mode", "FE Hz", "Ex Hz", "diff %", "FE xi %", "Ex xi %", "diff %", "MAC")
_CAPTION = (
    "FE: eigen model; Ex: identified from the hammer test; xi: damping ratio; "
    "a dash: not identified, or without a grid of impacts"
)
# Standard errors to either end of a 95 % interval.
_STANDARD_ERRORS = 2.0
# Modes that the verdict speaks of, as papers do.
_FIRST_MODES = 3


def _answer(dataset: xr.Dataset) -> tuple[str, ...]:
    """Identified frequencies and damping ratios of the first modes, over all crank angles."""
    found = dataset.isel(mode=slice(None, _FIRST_MODES))
    scatters = dataset.sizes["crank_angle"] == 1 and bool(dataset.attrs["noise"])
    told = []
    for number, mode in enumerate(found["mode"].values):
        own = found.isel(mode=number)
        frequency = own["identified_frequency"].values
        ratio = own["identified_damping_ratio"].values
        known = np.isfinite(frequency)
        if not known.any():
            continue
        errors = np.abs(frequency - own["eigen_frequency"].values)[known]
        away = np.abs(ratio - own["eigen_damping_ratio"].values)[known]
        hertz = _span(frequency[known], float(errors.max()))
        percents = _span(100 * ratio[known], 100 * float(away.max()))
        if scatters:
            hertz = with_error(float(frequency[0]), _error(own, "frequency"))
            percents = with_error(100 * float(ratio[0]), 100 * _error(own, "damping_ratio"))
        told.append(f"mode {int(mode)} at {hertz} Hz, damped by {percents} %")
    angles = DEGREES * dataset["crank_angle"].values
    one = f"at crank angle {angles[0]:.6g} deg"
    where = one if len(angles) == 1 else f"at {len(angles)} crank angles"
    if not told:
        return (f"The test identifies none of the first modes {where}.",)
    return (f"The test identifies, {where}: {'; '.join(told)}.",)


def _error(mode: xr.Dataset, what: str) -> float:
    """Half of the 95 % interval that noise leaves, of a mode at one crank angle."""
    return _STANDARD_ERRORS * float(mode[f"identified_{what}_error"].values.ravel()[0])


def _error_lines(dataset: xr.Dataset) -> list[str]:
    """What noise lets vary from one test to the next, of every mode identified."""
    lines = []
    for number, angle in enumerate(dataset["crank_angle"].values):
        own = dataset.isel(crank_angle=number)
        parts = [
            f"mode {int(mode)} {float(own['identified_frequency_error'][place]):.2g} Hz and "
            f"{100 * float(own['identified_damping_ratio_error'][place]):.2g} %"
            for place, mode in enumerate(own["mode"].values)
            if np.isfinite(own["identified_frequency"][place])
        ]
        if parts:
            lines.append(
                f"standard errors by noise of frequency and damping ratio at "
                f"{DEGREES * float(angle):.6g} deg: {', '.join(parts)}"
            )
    return lines


def _span(values: FloatArray, error: float) -> str:
    """Least and greatest of some values, or the one that they are."""
    ends = (rounded(float(end), error) for end in (values.min(), values.max()))
    return " to ".join(dict.fromkeys(ends))


def _numbers(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """What was identified at the first crank angle; its error is the way to the eigen model.

    Where there is noise, standard errors by it follow.
    """
    own = dataset.isel(crank_angle=0)
    found, scatter = [], []
    for what, unit, factor in (("frequency", "Hz", 1.0), ("damping_ratio", "%", 100.0)):
        for number, mode in enumerate(own["mode"].values):
            value, eigen, error = (
                factor * float(own[name][number])
                for name in (f"identified_{what}", f"eigen_{what}", f"identified_{what}_error")
            )
            if np.isfinite(value):
                name, of = f"identified_{what}", f"mode {int(mode)}"
                found.append(Quantity(name, value, unit, abs(value - eigen), of))
                scatter.append(Quantity(f"{name}_error", error, unit, of=of))
    return (*found, *(scatter if dataset.attrs["noise"] else ()))


def _mode_table(dataset: xr.Dataset) -> Table:
    """Measured beside computed frequencies and damping ratios, as papers print them."""
    groups = []
    for number, angle in enumerate(dataset["crank_angle"].values):
        own = dataset.isel(crank_angle=number)
        rows = [
            _row(DEGREES * float(angle), own.isel(mode=mode))
            for mode in range(own.sizes["mode"])
            if np.isfinite(own["eigen_frequency"][mode])
        ]
        groups.append(tuple(rows))
    title = (
        f"hammer test, {dataset.attrs.get('mechanism', '')}: impact at {dataset.attrs['impact']}, "
        f"response at {dataset.attrs['response_point']}, {dataset.attrs['direction']}"
    )
    return Table(title, _HEADINGS, tuple(groups), text_columns=0, caption=_CAPTION)


def _record_lines(dataset: xr.Dataset) -> list[str]:
    """How the records were taken, and what they were compared with."""
    of = dataset.attrs
    samples, averages = dataset.sizes["time"], dataset.sizes["average"]
    error = _greatest(dataset, "simulation_error")
    left_out = _greatest(dataset, "superposition_error")
    direct = _greatest(dataset, "direct_difference")
    misfit = _greatest(dataset, "identification_misfit")
    return [
        f"pulse: half-sine of {1e3 * of['pulse']:.4g} ms with {of['peak_force']:g} N, by which "
        "links move a millionth of the shortest one's length: they answer linearly",
        f"records: {of['duration']:.4g} s, {samples} samples at {of['sampling_rate']:.6g} Hz, "
        f"band to {of['bandwidth']:g} Hz, lines every {1 / of['duration']:.4g} Hz; {averages} "
        f"average{'s' if averages > 1 else ''}, {_noise(of)}",
        f"windows: force about the pulse, {1e3 * of['pulse_start']:.3g} ms after the record's "
        f"begin; {_window(of)}",
        f"transient: {_transient(of)}",
        f"measured receptance (H1) against the superposition of all modes: {error} of the peak "
        "at most",
        "superposition of the modes up to twice the band with the residual term "
        f"{_residual(dataset)} m/N: {left_out} of the peak; direct solution against all modes: "
        f"{direct}",
        f"identification: {of['method']}, which leaves {misfit} of the measured receptance",
        *(_error_lines(dataset) if of["noise"] else []),
    ]


def _unfound_warnings(dataset: xr.Dataset) -> list[str]:
    """Modes of the band that the test did not show, an angle each."""
    eigen, identified = (
        np.isfinite(dataset[f"{kind}_frequency"].values) for kind in ("eigen", "identified")
    )
    missing = eigen & ~identified
    lines = []
    for number, angle in enumerate(dataset["crank_angle"].values):
        modes = dataset["mode"].values[missing[number]]
        if len(modes):
            listed = ", ".join(map(str, modes))
            lines.append(
                f"crank angle {DEGREES * float(angle):.6g} deg: mode{'s' * (len(modes) > 1)} "
                f"{listed} not identified: nearly a node at one of the points, or hidden by "
                "damping or noise; try another --impact or --response"
            )
    return lines


def _verdict(dataset: xr.Dataset) -> str:
    """How near the first modes identified are to the eigen model."""
    found = dataset.isel(mode=slice(None, _FIRST_MODES))
    apart = {
        "frequencies": _difference(found, "frequency"),
        "damping ratios": _difference(found, "damping_ratio"),
    }
    if not any(np.isfinite(each).any() for each in apart.values()):
        return "the test identifies none of the first modes; try other points"
    said = ", ".join(
        f"{name} {100 * np.nanmax(np.abs(each)):.2g} %" for name, each in apart.items()
    )
    return f"identified against eigen model, first {found.sizes['mode']} modes: {said} at most"


def _row(degrees: float, mode: xr.Dataset) -> tuple[str, ...]:
    eigen, found = float(mode["eigen_frequency"]), float(mode["identified_frequency"])
    damped, ratio = float(mode["eigen_damping_ratio"]), float(mode["identified_damping_ratio"])
    return (
        f"{degrees:.6g}",
        str(int(mode["mode"])),
        f"{eigen:.6g}",
        _number(found, "{:.6g}"),
        _number(100 * (found / eigen - 1), "{:+.3f}"),
        f"{100 * damped:.4g}",
        _number(100 * ratio, "{:.4g}"),
        _number(100 * (ratio / damped - 1), "{:+.2f}"),
        _number(float(mode["mac"]), "{:.4f}"),
    )


def _number(value: float, form: str) -> str:
    if not np.isfinite(value):
        return "-"
    text = form.format(value)
    return text if float(text) else text.lstrip("+-")


def _difference(dataset: xr.Dataset, what: str) -> FloatArray:
    return np.asarray(dataset[f"identified_{what}"] / dataset[f"eigen_{what}"] - 1)


def _greatest(dataset: xr.Dataset, name: str) -> str:
    return f"{float(np.abs(dataset[name]).max()):.1e}"


def _residual(dataset: xr.Dataset) -> str:
    values = dataset["residual_term"].values
    low, high = values.min(), values.max()
    return f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"


def _noise(of: Mapping[Any, Any]) -> str:
    if not of["noise"]:
        return "no noise"
    return f"noise of {100 * of['noise']:g} % of the signal's root mean square, seed {of['seed']}"


def _window(of: Mapping[Any, Any]) -> str:
    rate = of["window_decay_rate"]
    if not rate:
        return f"none on the response, which decays to {of['left_at_the_end']:g}"
    return (
        f"exponential with {rate:.4g} 1/s on both, so that the response ends at "
        f"{of['left_at_the_end']:g}; its damping is taken off the poles "
        "identified, and by these off the receptance of frf.csv"
    )


def _transient(of: Mapping[Any, Any]) -> str:
    if not of["simulates"]:
        return "exact answer of the linear equations to the pulse, no error of time steps"
    shift = (np.pi * of["bandwidth"] * of["step"]) ** 2 / 3
    return (
        f"Exudyn's nonlinear simulation by the trapezoidal rule in steps of "
        f"{1e3 * of['step']:.4g} ms; the rule's shift of frequencies, {100 * shift:.2g} % at "
        "the end of the band, is taken off"
    )
