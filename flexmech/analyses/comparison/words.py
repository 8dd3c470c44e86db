"""What a comparison with a record says: the table of the fit and the lines below it."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import xarray as xr

from flexmech.analyses.comparison.parameters import DAMPING, STIFFNESS
from flexmech.analyses.summary import Table
from flexmech.units import from_si

# Part of the record's variance from which a model is said to miss what was measured.
POOR = 0.5
# Relative difference of frequencies beyond which other modes are compared, or another linkage.
FAR_OFF = 0.1
# Of its sign turned, a record must be explained better by this factor to be thought of so.
TURNED_BETTER = 0.8
# Deflection over a link's length beyond which linear equations show in what they are fitted to: a
# damping time of 3 mm at 280 mm is off by 2 %, one of 6.5 mm by 5 %.
LARGE_BOW = 0.01
# Factor of the intervals' width below which nobody needs to be told of it.
LITTLE_WIDER = 1.2
# Beyond it two parameters can hardly be told apart.
CLOSE = 0.95


def fit_table(data: xr.Dataset) -> Table | None:
    """Fitted parameters with their 95 % intervals; None where nothing was fitted."""
    if not data.sizes["parameter"]:
        return None

    def row(number: int) -> tuple[str, ...]:
        own = data.isel(parameter=number)
        name, unit = str(own["parameter"].item()), str(own["parameter_unit"].item())
        keys = ("fitted", "standard_error", "lower", "upper")
        value, error, lower, upper = (f"{float(own[key]):.5g}" for key in keys)
        return (name, value, "-" if unit == "1" else unit, error, f"{lower} to {upper}")

    headings = ("parameter", "value", "unit", "std. error", "95 % interval")
    rows = tuple(row(number) for number in range(data.sizes["parameter"]))
    title = f"fitted to {data.attrs['record']}, {data.attrs['mechanism']}"
    return Table(title, headings, (rows,))


def record_lines(data: xr.Dataset) -> list[str]:
    """What was laid beside what, and how it was aligned."""
    attrs = data.attrs
    column, quantity = attrs["column"], attrs["quantity"]
    lines = [f"compared: {column!r} of {attrs['record']} with {quantity} of the {_engine(attrs)}"]
    if "time" in data.dims:
        angle, length = np.degrees(attrs["start_angle"]), float(data["time"][-1] - data["time"][0])
        turns = length * abs(attrs["crank_speed"]) / (2 * np.pi)
        by = (
            "found from the record itself"
            if attrs["aligned_by"] == "record"
            else "as its column says"
        )
        lines += [
            f"record: {data.sizes['time']} samples, {length:.4g} s, {turns:.4g} turns at "
            f"{_speed(attrs)}",
            f"aligned: the record begins at crank angle {angle:.4g} deg, {by}",
            f"its free vibration begins in the state that fits best: {attrs['free_states']} "
            "numbers, found for every value of the parameters",
        ]
    elif "sample" in data.dims:
        modes = ", ".join(str(mode) for mode in np.unique(data["mode"].values))
        by = "by its frequencies" if attrs["mode_found"] else "as its column says"
        word = "modes" if "," in modes else "mode"
        lines.append(
            f"record: {data.sizes['sample']} natural frequencies of {word} {modes} ({by}) at "
            f"{_speed(attrs)}"
        )
    else:
        frequency = data["frequency"].values
        lines.append(
            f"record: {len(frequency)} frequencies from {frequency[0]:.4g} to "
            f"{frequency[-1]:.4g} Hz, crank locked at "
            f"{np.degrees(attrs['crank_angle_locked']):.6g} deg"
        )
    return lines


def ratio_lines(data: xr.Dataset) -> list[str]:
    """Fitted damping times as damping ratios of the first natural frequency."""
    hertz = float(data.attrs["first_frequency"])
    lines = []
    for name in data["parameter"].values:
        own = data.sel(parameter=name)
        if not str(name).startswith(DAMPING):
            continue
        value, low, high = (
            100 * np.pi * hertz * float(own[key]) for key in ("fitted", "lower", "upper")
        )
        whose = str(name).partition(":")[2]
        of = f" of the {whose}'s material" if whose else ""
        lines.append(
            f"as a damping ratio{of} at {hertz:.4g} Hz, the first natural frequency: {value:.4g} % "
            f"({low:.4g} to {high:.4g} %)"
        )
    return lines


def correlation_lines(data: xr.Dataset) -> list[str]:
    """Correlation of each pair of parameters."""
    names = [str(name) for name in data["parameter"].values]
    lines = []
    for first, second in combinations(range(len(names)), 2):
        value = float(data["correlation"].values[first, second])
        hardly = "; the record hardly tells them apart" if abs(value) > CLOSE else ""
        lines.append(f"correlation of {names[first]} and {names[second]}: {value:.3f}{hardly}")
    return lines


def residual_lines(data: xr.Dataset) -> list[str]:
    """What remains unexplained, and what that does to the intervals."""
    attrs = data.attrs
    parts = [data[name].values for name in data if str(name).startswith("residual")]
    size = float(np.sqrt(np.mean(sum(part**2 for part in parts))))
    unit = f" {attrs['unit']}" if attrs["unit"] else ""
    part = f", {100 * _part(data):.2g} % of the frequencies" if "sample" in data.dims else ""
    lines = [
        f"unexplained: {100 * attrs['unexplained']:.3g} % of the record's variance, a residual of "
        f"{size:.3g}{unit} root mean square{part}"
    ]
    if not data.sizes["parameter"]:
        return lines
    wider = f"{attrs['widened']:.3g} times wider than for white noise"
    if not attrs["residual_order"] and attrs["widened"] < LITTLE_WIDER:
        return [*lines, "the residual looks like white noise: the intervals hold for that"]
    if not attrs["residual_order"]:
        return [
            *lines,
            "the residual is larger where the record tells most, so that the intervals are up to "
            f"{wider}; what the model lacks may shift the values by more than that",
        ]
    told = (
        f"the intervals are up to {wider}"
        if attrs["widened"] > 1.0
        else "the intervals of white noise cover that"
    )
    return [
        *lines,
        "the residual is no white noise (autoregressive of order "
        f"{attrs['residual_order']}): the model lacks something, or the noise is coloured; {told}. "
        "What the model lacks may shift the values by more than that",
    ]


def verdict(data: xr.Dataset) -> str:
    """What to do with the numbers."""
    times, factors = [], []
    for name in data["parameter"].values:
        kind, _, link = str(name).partition(":")
        value = float(data["fitted"].sel(parameter=name))
        if kind == DAMPING:
            times.append(f'damping_time = "{max(value, 0.0):.4g} s" of {link or "each link"}')
        elif kind == STIFFNESS:
            factors.append(f"{value:.5g} on the modulus of {link}")
    if not times + factors:
        return "applied: nothing; nothing of the model was fitted"
    return f"applied: nothing; to use it, write into the model file: {'; '.join(times + factors)}"


def warnings(data: xr.Dataset) -> tuple[str, ...]:
    """What makes the fit worthless."""
    attrs = data.attrs
    large = (
        (
            f"a link deflects by {100 * attrs['bow']:.2g} % of its length: the linear equations "
            "that are fitted here shift damping and frequencies by a few per cent then",
        )
        if attrs.get("bow", 0.0) > LARGE_BOW
        else ()
    )
    if "sample" in data.dims:
        # Frequencies that hardly move with the crank angle have hardly any variance to explain.
        if _part(data) < FAR_OFF:
            return ()
        return (
            f"the frequencies differ by {100 * _part(data):.2g} % on average: the numbers mean "
            "little; check the crank speed, the units, and the numbers of the modes",
        )
    if attrs["unexplained"] < POOR:
        return large
    turned = attrs.get("turned_unexplained", float("nan"))
    if turned < TURNED_BETTER * attrs["unexplained"]:
        return (
            f"{100 * attrs['unexplained']:.3g} % of the record remain unexplained, and "
            f"{100 * turned:.3g} % with its sign turned: the gauge may sit on the other face of "
            "the link; turn the sign of the column",
        )
    return (
        f"{100 * attrs['unexplained']:.3g} % of the record remain unexplained: the numbers mean "
        "little; check the crank speed or angle, --quantity, and the units of the record",
    )


def _part(data: xr.Dataset) -> float:
    """Residual over the measured frequencies, root mean square."""
    ratio = data["residual"].values / data["measured"].values
    # A record may hold numbers whose squares are beyond what a float can be.
    greatest = max(float(np.abs(ratio).max()), np.finfo(float).tiny)
    return greatest * float(np.sqrt(np.mean((ratio / greatest) ** 2)))


def _engine(attrs: dict[str, object]) -> str:
    return f"{attrs['engine']} engine ({attrs['element']})"


def _speed(attrs: dict[str, object]) -> str:
    unit = str(attrs["speed_unit"])
    return f"{from_si(float(str(attrs['crank_speed'])), unit):.6g} {unit}"
