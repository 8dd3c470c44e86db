"""What a stability map says: speeds to avoid, how sure that is, gaps, and how engines agree.

Which crank speeds a stability map has looked at, and which bands it may miss between them.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

import numpy as np
import xarray as xr

from flexmech.analyses.digits import plain
from flexmech.analyses.stability.dataset import NO, NO_EQUILIBRIUM, NOT_COMPUTED, PARTS, YES
from flexmech.analyses.summary import Table, speed_text
from flexmech.arrays import unbroken_runs
from flexmech.plots.reading import speed_unit
from flexmech.units import from_si


def known_ranges(dataset: xr.Dataset) -> list[tuple[float, float]]:
    """Ranges of speeds at which the first engine knows whether a vibration grows.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a stability map.

    Returns
    -------
    list of tuple of float
        In rad/s, from slow to fast, as far as speeds were solved for, those between the speeds
        asked for too; parted by speeds without equilibrium.
    """
    asked, states = dataset["crank_speed"].values, dataset["unstable"].values[0]
    known = np.isin(states, (YES, NO))
    first = dataset["curve_engine"].values == dataset["engine"].values[0]
    solved = np.setdiff1d(dataset["curve_speed"].values[first], asked)
    speeds = np.concatenate([asked, solved])
    order = np.argsort(np.abs(speeds))
    speeds, known = speeds[order], np.append(known, np.ones(len(solved), dtype=bool))[order]
    return [(float(speeds[run[0]]), float(speeds[run[-1]])) for run in unbroken_runs(known)]


def within(dataset: xr.Dataset) -> str:
    """Ranges of the crank speeds that a map knows, with a blank before them.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a stability map.

    Returns
    -------
    str
        Such as ``" from 100 to 500 rpm"``; all speeds asked for where none is known.
    """
    unit, speeds = speed_unit(dataset), dataset["crank_speed"].values
    ranges = known_ranges(dataset) or [(float(speeds[0]), float(speeds[-1]))]
    said = [
        f"at {speed_text(first, unit)}"
        if first == last
        else f"from {speed_text(first, unit)} to {speed_text(last, unit)}"
        for first, last in ranges
    ]
    return f" {' and '.join(said)} {unit}"


def is_known(dataset: xr.Dataset, speed: float) -> bool:
    """Whether a speed in rad/s lies in one of :func:`known_ranges`.

    What went through another unit may be off by its last digits.
    """
    slack = 1e-9 * float(np.abs(dataset["crank_speed"].values).max())
    ranges = [sorted(ends) for ends in known_ranges(dataset)]
    return any(low - slack <= speed <= high + slack for low, high in ranges)


def greatest_step(dataset: xr.Dataset, engine: str) -> str:
    """Greatest distance of two speeds at which an engine was solved for.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a stability map.
    engine : str

    Returns
    -------
    str
        Such as ``"63 rpm"``; empty where there are no two speeds.
    """
    every = np.unique(dataset["curve_speed"].values[dataset["curve_engine"].values == engine])
    if len(every) < 2:
        return ""
    unit = speed_unit(dataset)
    return f"{abs(from_si(float(np.diff(every).max()), unit)):.2g} {unit}"


# Bands of an engine that are told in a sentence and in a row; of more, the fastest growing.
MOST_LINES, MOST_ROWS = 6, 24
# What exponents are compared by, in words.
CHECKS = {
    "reduction": "number of moving modes",
    "mesh": "mesh",
    "theory": "beam theory",
}
# Growth rate in 1/s of a free shaft's motion that is none but round-off: of steady motion both its
# exponents are zero, and two that meet there are known to the root of round-off.
STILL = 1e-3
FRAME_LINE = (
    "Floquet multipliers are the same in every frame; damping ratios of frozen positions with "
    "rotation terms are not"
)


def shaft_lines(dataset: xr.Dataset) -> list[str]:
    """What becomes of the free shaft's own motion, of each engine; none where it is not free."""
    if "shaft_growth_rate" not in dataset:
        return []
    unit, lines = speed_unit(dataset), []
    for name in dataset["engine"].values:
        rate = dataset["shaft_growth_rate"].sel(engine=name).dropna("crank_speed")
        if not rate.size:
            continue
        fastest = rate.isel(crank_speed=int(rate.values.argmax()))
        where = f"{speed_text(fastest['crank_speed'], unit)} {unit}"
        said = f"grows with at most {float(fastest):.3g} 1/s, at {where}"
        if float(fastest) < STILL:
            said = f"does not grow (at most {STILL:g} 1/s)"
        lines.append(
            f"shaft: free, {name}: its own motion against the mean one {said}; it is not counted "
            "among the modes"
        )
    return lines


def avoid_lines(dataset: xr.Dataset) -> list[str]:
    """The bands of the first engine, a sentence each; and how many more there are."""
    first = str(dataset["engine"].values[0])
    own = dataset.isel(band=np.flatnonzero(dataset["band_engine"].values == first))
    if not own.sizes["band"] and bool(dataset["interrupted"][0]):
        growing = dataset["unstable"].values[0] == "yes"
        speeds = from_si(1.0, speed_unit(dataset)) * dataset["crank_speed"].values[growing]
        some = ", ".join(f"{speed:.6g}" for speed in speeds[:MOST_ROWS]) or "none"
        return [f"bands were not searched for; speeds that grow: {some} {speed_unit(dataset)}"]
    if not own.sizes["band"]:
        return [f"avoid: {first} finds no crank speed{within(dataset)} at which a vibration grows"]
    lines = [f"avoid {_sentence(own.isel(band=n))}" for n in _fastest(own, MOST_LINES)]
    if rest := max(own.sizes["band"] - MOST_LINES, 0):
        bands = "1 more band" if rest == 1 else f"{rest} more bands"
        lines.append(f"{bands}, in which vibrations grow more slowly: see the table and bands.csv")
    return lines


def band_table(dataset: xr.Dataset) -> Table | None:
    """Edges with their errors, names and growth rates, grouped by engine; None without bands."""
    unit = speed_unit(dataset)
    groups, left_out = [], 0
    for name in dataset["engine"].values:
        own = dataset.isel(band=np.flatnonzero(dataset["band_engine"].values == name))
        shown = _fastest(own, MOST_ROWS)
        left_out += own.sizes["band"] - len(shown)
        rows = tuple(_row(str(name), own.isel(band=n), unit) for n in shown)
        groups += [rows] if rows else []
    if not groups:
        return None
    caption = "+-: greater error of the two edges by steps, moving modes and mesh"
    if dataset["band_lower_open"].any() or dataset["band_upper_open"].any():
        caption += (
            ", of the band's own edges alone; <, >: cut by the range, the band goes on beyond"
        )
    if left_out:
        caption += f"; {left_out} that grow more slowly are left out here"
    return Table(
        f"unstable bands, {dataset.attrs.get('mechanism', '')}",
        ("engine", "what meets", f"from {unit}", f"to {unit}", "+-", "grows 1/s", "closed by"),
        tuple(groups),
        text_columns=2,
        caption=caption,
    )


def band_name(band: xr.Dataset) -> str:
    """Which frequencies make a multiple of the crank's frequency.

    Parameters
    ----------
    band : xarray.Dataset
        At one band.

    Returns
    -------
    str
        Such as ``"the sum of modes 1 and 3 is 11 times the crank's frequency"``.
    """
    kind, branches = str(band["band_kind"].item()), str(band["band_branches"].item()).split()
    if kind == "divergence":
        return "a mode diverges without oscillating, as in static buckling"
    if kind == "unnamed" or not branches:
        return "which frequencies meet there is uncertain"
    times = f"{int(band['band_order'])} times the crank's frequency"
    if kind == "principal":
        return f"twice the frequency of mode {branches[0]} is {times}"
    return f"the {kind} of modes {branches[0]} and {branches[-1]} is {times}"


def band_range(band: xr.Dataset, unit: str) -> str:
    """From where to where a band reaches, such as ``"88.12 to 89.34 rad/s"``."""
    lower, upper = (text.lstrip("<> ") for text in _edges(band, unit))
    goes_on = bool(band["band_lower_open"]) or bool(band["band_upper_open"])
    return f"{lower} to {upper} {unit}{', where the range ends' * goes_on}"


def error_lines(dataset: xr.Dataset) -> list[str]:
    """How sure edges and multipliers are, of each engine."""
    lines, unit = [], speed_unit(dataset)
    for place, name in enumerate(dataset["engine"].values):
        own = dataset.isel(engine=place)
        said = []
        bands = dataset.isel(band=np.flatnonzero(dataset["band_engine"].values == name))
        if bands.sizes["band"]:
            known = _edge_error(bands, unit)
            said.append(
                f"edges of bands at most {known}"
                if known
                else "the range of speeds cuts all bands, whose own edges are not known"
            )
        if np.isfinite(own["step_error"]).any():
            said.append(f"logarithms of multipliers at most {_multiplier_error(own, name)}")
            defect = float(own["liouville_defect"].max())
            said.append(f"their sum meets Liouville's integral of the trace within {defect:.0e}")
        if said:
            lines.append(f"errors, {name}: {'; '.join(said)}")
    return lines


def gap_lines(dataset: xr.Dataset) -> list[str]:
    """Crank speeds without equilibrium, and why."""
    unit, lines = speed_unit(dataset), []
    for name in dataset["engine"].values:
        own = dataset.sel(engine=name)
        for places in _runs(own):
            run = own.isel(crank_speed=places)
            first, last = (speed_text(w, unit) for w in run["crank_speed"].values[[0, -1]])
            count = len(places)
            where = f"at {first}" if count == 1 else f"from {first} to {last}"
            reason = f"({count} speed{'' if count == 1 else 's'}): {run['reason'].values[0]}"
            if np.isfinite(run["growth_rate"].values).any():
                reason += (
                    "; multipliers there are those of the linear equations about straight links"
                )
            lines.append(f"gap: {name} has no equilibrium {where} {unit} {reason}")
    return lines


def motion_lines(dataset: xr.Dataset) -> list[str]:
    """About which motion the map is, and what that leaves out."""
    lines, unit = [], speed_unit(dataset)
    for number, name in enumerate(dataset["engine"].values):
        own = dataset.isel(engine=number)
        if np.isfinite(own["orbit_distance"]).any():
            distance = own["orbit_distance"].fillna(0.0)
            place = int(distance.values.argmax())
            at = speed_text(own["crank_speed"].values[place], unit)
            lines.append(
                f"{name}: the periodic motion is at most {100 * float(distance.max()):.3g} % of "
                f"the greatest displacement from the quasi-static equilibrium, at {at} {unit}; "
                f"its residual is at most {float(own['orbit_residual'].max()):.0e}"
            )
        if bool(own["is_definite"]):
            lines.append(
                f"{name}: the undamped Hamilton function is positive definite at all speeds, so "
                "that without damping only sums of frequencies can grow"
            )
        if count := int(own["closed_early"]):
            bands = "1 band is" if count == 1 else f"{count} bands are"
            lines.append(
                f"{name}: {bands} left out, so narrow that a damping ratio of "
                f"{100 * float(own.attrs['least_closing_ratio']):.3g} % closes "
                f"{'it' if count == 1 else 'them'}"
            )
        lines += _search_line(dataset, str(name))
    return [*lines, FRAME_LINE]


def _search_line(dataset: xr.Dataset, name: str) -> list[str]:
    """Which bands a map may miss: those between two speeds; none where there are no two."""
    step = greatest_step(dataset, name)
    if not step:
        return []
    return [
        f"{name}: bands narrower than {step}, the greatest distance of two speeds solved for, are "
        "found where two modes meet between them, and can be missed"
    ]


def interrupted_warnings(dataset: xr.Dataset) -> list[str]:
    """How far an interrupted map has come."""
    if not bool(dataset["interrupted"].any()) and not dataset.attrs.get("interrupted_against"):
        return []
    done = [
        f"{int((dataset['unstable'].sel(engine=name) != NOT_COMPUTED).sum())} of "
        f"{dataset.sizes['crank_speed']} crank speeds by {name}"
        for name in dataset["engine"].values
    ]
    return [f"interrupted after {', '.join(done)}; what was done is kept"]


def _fastest(bands: xr.Dataset, most: int) -> list[int]:
    """Places of the fastest growing bands, in the order of the speeds."""
    order = np.argsort(-bands["band_largest_growth_rate"].values, kind="stable")
    return sorted(order[:most].tolist())


def _sentence(band: xr.Dataset) -> str:
    unit, closing = speed_unit(band), float(band["band_closing_damping_ratio"])
    closed = (
        f"a damping ratio of {100 * closing:.3g} % closes it"
        if np.isfinite(closing)
        else "no damping ratio below 1 closes it"
    )
    rate = float(band["band_largest_growth_rate"])
    name = f"{band_name(band)}{_signatures(band)}"
    return f"{band_range(band, unit)}: {name}; grows with {rate:.3g} 1/s; {closed}"


def _signatures(band: xr.Dataset) -> str:
    """Of the multipliers that meet in the band; empty where they are not known."""
    product = float(band["band_first_signature"]) * float(band["band_second_signature"])
    if not np.isfinite(product):
        return ""
    return f" ({'opposite' if product < 0 else 'equal'} Krein signatures)"


def _row(engine: str, band: xr.Dataset, unit: str) -> tuple[str, ...]:
    closing = float(band["band_closing_damping_ratio"])
    errors = [edge_error(band, edge) for edge in ("lower", "upper")]
    known = [from_si(error, unit) for error in errors if np.isfinite(error)]
    return (
        engine,
        short_name(band),
        *_edges(band, unit),
        f"{max(known):.1g}" if known else "cut by the range",
        f"{float(band['band_largest_growth_rate']):.3g}",
        f"{100 * closing:.3g} %" if np.isfinite(closing) else "-",
    )


def short_name(band: xr.Dataset) -> str:
    """Frequencies that meet, such as ``"f1 + f3 = 11 f"``, with f of the crank.

    Parameters
    ----------
    band : xarray.Dataset
        At one band.
    """
    kind, branches = str(band["band_kind"].item()), str(band["band_branches"].item()).split()
    if not branches:
        return kind if kind == "divergence" else "name uncertain"
    sign = "-" if kind == "difference" else "+"
    return f"f{branches[0]} {sign} f{branches[-1]} = {int(band['band_order'])} f"


def _edges(band: xr.Dataset, unit: str) -> tuple[str, str]:
    """Edges with the digits that their errors leave known; < and > where a band goes on.

    Two edges are told from each other, too, however great their errors are.
    """
    scale = abs(from_si(1.0, unit))
    values = [from_si(float(band[f"band_{edge}"]), unit) for edge in ("lower", "upper")]
    errors = [scale * edge_error(band, edge) for edge in ("lower", "upper")]
    error = max((each for each in errors if np.isfinite(each)), default=0.0)
    finest = max(min(error, abs(values[1] - values[0]) / 5), 1e-6 * max(map(abs, values)))
    decimals = int(np.clip(np.ceil(-np.log10(finest)), 0, 6))
    opened = [bool(band[f"band_{edge}_open"]) for edge in ("lower", "upper")]
    # Where the range cuts a band, its end is what was asked for.
    lower, upper = (
        plain(value) if cut else f"{value:.{decimals}f}"
        for value, cut in zip(values, opened, strict=True)
    )
    return f"{'< ' * opened[0]}{lower}", f"{'> ' * opened[1]}{upper}"


def _edge_parts(band: xr.Dataset, edge: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array([float(band[f"band_{edge}_{part}_error"]) for part in PARTS])


def edge_error(band: xr.Dataset, edge: str) -> float:
    """Error of an edge in rad/s; not a number where the range of speeds cuts the band.

    Parameters
    ----------
    band : xarray.Dataset
        At one band.
    edge : {"lower", "upper"}
    """
    if bool(band[f"band_{edge}_open"]):
        return float("nan")
    return float(_edge_parts(band, edge).sum())


def _edge_error(bands: xr.Dataset, unit: str) -> str:
    """Greatest error of all edges that are not cut with its parts."""
    edges = [
        _edge_parts(bands.isel(band=n), edge)
        for n in range(bands.sizes["band"])
        for edge in ("lower", "upper")
        if np.isfinite(edge_error(bands.isel(band=n), edge))
    ]
    if not edges:
        return ""
    worst = from_si(1.0, unit) * max(edges, key=lambda parts: float(parts.sum()))
    parts = ", ".join(
        f"{n} {e:.1g}" for n, e in zip(("steps", "moving modes", "mesh"), worst, strict=True)
    )
    return f"{float(worst.sum()):.2g} {unit} ({parts})"


def _multiplier_error(own: xr.Dataset, engine: object) -> str:
    said = f"{float(own['step_error'].max()):.0e} by steps"
    checks = own.isel(check=np.flatnonzero(own["check_engine"].values == engine))
    if checks.sizes["check"]:
        unit = speed_unit(own)
        speeds = ", ".join(speed_text(w, unit) for w in checks["check_speed"].values)
        greatest = {name: float(checks[f"check_{name}"].max()) for name in (*CHECKS, "growth")}
        parts = [
            f"{greatest[name]:.0e}{of} by the {words}{how}"
            for (name, words), of, how in zip(
                CHECKS.items(), (" of themselves", "", ""), ("", " (estimated)", ""), strict=True
            )
            if np.isfinite(greatest[name])
        ]
        told = " and ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))
        said += f"; at {speeds} {unit} exponents at most {told}" if told else ""
        if np.isfinite(greatest["growth"]):
            said += f", the logarithm of the largest modulus {greatest['growth']:.0e}"
    return said


def unknown_error_lines(dataset: xr.Dataset) -> list[str]:
    """Errors of exponents that are not known, and where: a line for each engine and cause."""
    unit, lines = speed_unit(dataset), []
    for name in dataset["engine"].values:
        checks = dataset.isel(check=np.flatnonzero(dataset["check_engine"].values == name))
        for part, words in CHECKS.items():
            missing = checks["check_speed"].values[np.isnan(checks[f"check_{part}"].values)]
            if missing.size:
                where = ", ".join(speed_text(w, unit) for w in missing)
                lines.append(
                    f"the error by the {words} is not known at {where} {unit} ({name}): the "
                    "linkage to compare with has no multipliers there"
                )
    return lines


def _runs(own: xr.Dataset) -> Iterator[list[int]]:
    """Places of neighbouring speeds without equilibrium whose reasons are of one kind."""
    states = own["unstable"].values.tolist()
    buckled = np.isfinite(own["growth_rate"].values).tolist()
    for (state, _), group in groupby(range(len(states)), lambda n: (states[n], buckled[n])):
        if state == NO_EQUILIBRIUM:
            yield list(group)
