"""A hammer test in words: the modes identified, how far noise lets them vary, how it was taken."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from flexmech.analyses.beam_theory import theory_lines
from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.details import details_table, notes_of
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
        (
            *details_table(_record_quantities(dataset)),
            f"identification: {dataset.attrs['method']}",
            *_notes(dataset),
            *theory_lines(dataset.attrs),
        ),
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
# Differences over the peak of the receptance, in words.
_ERRORS = {
    "simulation_error": "measured receptance against all modes",
    "superposition_error": "modes to twice the band against all",
    "direct_difference": "direct solution against all modes",
    "identification_misfit": "measured receptance left by modes",
}
_OF_MODES = ("frequency", "damping_ratio")


def _answer(dataset: xr.Dataset) -> tuple[str, ...]:
    """Identified frequencies and damping ratios of the first modes, over all crank angles."""
    first_modes = dataset.isel(mode=slice(None, _FIRST_MODES))
    scatters = dataset.sizes["crank_angle"] == 1 and bool(dataset.attrs["noise"])
    identified = []
    for number, mode in enumerate(first_modes["mode"].values):
        of_mode = first_modes.isel(mode=number)
        frequency = of_mode["identified_frequency"].values
        ratio = of_mode["identified_damping_ratio"].values
        known = np.isfinite(frequency)
        if not known.any():
            continue
        errors = np.abs(frequency - of_mode["eigen_frequency"].values)[known]
        away = np.abs(ratio - of_mode["eigen_damping_ratio"].values)[known]
        hertz = _span(frequency[known], float(errors.max()))
        percents = _span(100 * ratio[known], 100 * float(away.max()))
        if scatters:
            hertz = with_error(float(frequency[0]), _error(of_mode, "frequency"))
            percents = with_error(100 * float(ratio[0]), 100 * _error(of_mode, "damping_ratio"))
        identified.append(f"mode {int(mode)} at {hertz} Hz with {percents} % damping")
    angles = DEGREES * dataset["crank_angle"].values
    one = f"at crank angle {angles[0]:.6g} deg"
    where = one if len(angles) == 1 else f"at {len(angles)} crank angles"
    if not identified:
        return (f"The test identifies none of the first modes {where}.",)
    return (f"The test identifies {where}: {'; '.join(identified)}.",)


def _error(mode: xr.Dataset, what: str) -> float:
    """Half of the 95 % interval that noise leaves, of a mode at one crank angle."""
    return _STANDARD_ERRORS * float(mode[f"identified_{what}_error"].values.ravel()[0])


def _span(values: FloatArray, error: float) -> str:
    """Least and greatest of some values, or the one that they are."""
    ends = (rounded(float(end), error) for end in (values.min(), values.max()))
    return " to ".join(dict.fromkeys(ends))


def _numbers(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """Identified modes at the first crank angle; errors are distances to the eigen model.

    Where there is noise, standard errors by it follow.
    """
    first_angle = dataset.isel(crank_angle=0)
    quantities, scatter = [], []
    for what, unit, factor in (("frequency", "Hz", 1.0), ("damping_ratio", "%", 100.0)):
        for number, mode in enumerate(first_angle["mode"].values):
            value, eigen, error = (
                factor * float(first_angle[name][number])
                for name in (f"identified_{what}", f"eigen_{what}", f"identified_{what}_error")
            )
            if np.isfinite(value):
                name, of = f"identified_{what}", f"mode {int(mode)}"
                quantities.append(Quantity(name, value, unit, abs(value - eigen), of))
                scatter.append(Quantity(f"{name}_error", error, unit, of=of))
    return (*quantities, *(scatter if dataset.attrs["noise"] else ()))


def _mode_table(dataset: xr.Dataset) -> Table:
    """Measured beside computed frequencies and damping ratios, as papers print them."""
    groups = []
    for number, angle in enumerate(dataset["crank_angle"].values):
        of_angle = dataset.isel(crank_angle=number)
        rows = [
            _row(DEGREES * float(angle), of_angle.isel(mode=mode))
            for mode in range(of_angle.sizes["mode"])
            if np.isfinite(of_angle["eigen_frequency"][mode])
        ]
        groups.append(tuple(rows))
    title = (
        f"hammer test, {dataset.attrs.get('mechanism', '')}: impact at {dataset.attrs['impact']}, "
        f"response at {dataset.attrs['response_point']}, {dataset.attrs['direction']}"
    )
    return Table(title, _HEADINGS, tuple(groups), text_columns=0, caption=_CAPTION)


def _record_quantities(dataset: xr.Dataset) -> Iterator[Quantity]:
    """How the records were taken, how far they are off, and what noise lets vary."""
    of = dataset.attrs
    yield Quantity("duration of the pulse", 1e3 * of["pulse"], "ms")
    yield Quantity("peak force of the pulse", of["peak_force"], "N")
    yield Quantity("time before the pulse", 1e3 * of["pulse_start"], "ms")
    yield Quantity("duration of a record", of["duration"], "s")
    yield Quantity("samples of a record", dataset.sizes["time"], "")
    yield Quantity("sampling rate", of["sampling_rate"], "Hz")
    yield Quantity("bandwidth", of["bandwidth"], "Hz")
    yield Quantity("distance of lines", 1 / of["duration"], "Hz")
    yield Quantity("averages", dataset.sizes["average"], "")
    yield Quantity("noise over signal, RMS", 100 * of["noise"], "%")
    if of["noise"]:
        yield Quantity("seed of the noise", int(of["seed"]), "")
    yield Quantity("decay rate of the window", of["window_decay_rate"], "1/s")
    yield Quantity("response at the end over its peak", 100 * of["left_at_the_end"], "%")
    if of["simulates"]:
        shift = (np.pi * of["bandwidth"] * of["step"]) ** 2 / 3
        yield Quantity("time step", 1e3 * of["step"], "ms")
        yield Quantity("shift by the time step, removed", 100 * shift, "%", of="end of the band")
    for number, angle in enumerate(dataset["crank_angle"].values):
        at = dataset.isel(crank_angle=number)
        place = f"{DEGREES * float(angle):.6g} deg"
        yield Quantity("residual term", float(at["residual_term"]), "m/N", of=place)
        for name, words in _ERRORS.items():
            yield Quantity(words, 100 * abs(float(at[name])), "% of peak", of=place)
        for mode in at["mode"].values if of["noise"] else ():
            one, mark = at.sel(mode=mode), f"mode {int(mode)}, {place}"
            hertz, ratio = (float(one[f"identified_{n}_error"]) for n in _OF_MODES)
            yield Quantity("standard error of frequency", hertz, "Hz", of=mark)
            yield Quantity("standard error of damping ratio", 100 * ratio, "%", of=mark)


def _notes(dataset: xr.Dataset) -> Iterator[str]:
    """Effects that the records leave out, and corrections of them."""
    notes, of = notes_of(__package__), dataset.attrs
    yield notes["linear"]
    yield notes["simulated" if of["simulates"] else "exact"]
    if of["window_decay_rate"]:
        yield notes["window"]


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
                f"{listed} not identified: a point lies near a node, or damping or noise hides the "
                "peak; try another --impact or --response"
            )
    return lines


def _verdict(dataset: xr.Dataset) -> str:
    """How near the first modes identified are to the eigen model."""
    first_modes = dataset.isel(mode=slice(None, _FIRST_MODES))
    apart = {
        "frequencies": _difference(first_modes, "frequency"),
        "damping ratios": _difference(first_modes, "damping_ratio"),
    }
    if not any(np.isfinite(differences).any() for differences in apart.values()):
        return "the test identifies none of the first modes; try other points"
    said = ", ".join(
        f"{name} {100 * np.nanmax(np.abs(differences)):.2g} %"
        for name, differences in apart.items()
    )
    return (
        f"identified against eigen model, first {first_modes.sizes['mode']} modes: {said} at most"
    )


def _row(degrees: float, mode: xr.Dataset) -> tuple[str, ...]:
    eigen, identified = float(mode["eigen_frequency"]), float(mode["identified_frequency"])
    damped, ratio = float(mode["eigen_damping_ratio"]), float(mode["identified_damping_ratio"])
    return (
        f"{degrees:.6g}",
        str(int(mode["mode"])),
        f"{eigen:.6g}",
        _number(identified, "{:.6g}"),
        _number(100 * (identified / eigen - 1), "{:+.3f}"),
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
