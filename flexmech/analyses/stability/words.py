"""A stability map in words: speeds of growing vibration, damping that ends it, and confidence."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import groupby

import numpy as np
import scipy.optimize
import xarray as xr

from flexmech.analyses.beam_theory import theory_lines, theory_reason
from flexmech.analyses.details import (
    Range,
    details_table,
    engines_line,
    notes_of,
    ranges_text,
    speed_name,
)
from flexmech.analyses.digits import Quantity, percent, plain
from flexmech.analyses.stability.growth import (
    EDGES,
    NO,
    NO_EQUILIBRIUM,
    NOT_COMPUTED,
    PARTS,
    YES,
)
from flexmech.analyses.summary import (
    EngineDifference,
    Summary,
    Table,
    speed_text,
    trust_line,
    warnings_of,
)
from flexmech.arrays import FloatArray, unbroken_runs
from flexmech.plots.reading import lies_in, operating_speeds, speed_unit
from flexmech.units import from_si

# Bands of an engine that the table shows; of more, the fastest growing.
_MOST_ROWS = 24
# Digits of damping ratios and growth rates.
_DIGITS = 3
# What exponents are compared by, in words.
_CHECKS = {"reduction": "number of moving modes", "mesh": "mesh", "theory": "beam theory"}


def summary_of(data: xr.Dataset) -> Summary:
    """Answer, table, trust, details, warnings and numbers of a stability map.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a ``StabilityMap``.

    Returns
    -------
    Summary
    """
    notes = notes_of(__package__)
    definite = (
        notes["definite"].format(name) for name in _engines(data) if _is_definite(data, name)
    )
    details: tuple[Table | str, ...] = (
        *theory_lines(data.attrs),
        *details_table(_quantities(data)),
        *definite,
        notes["frame"],
        _verdict(data),
    )
    warned = (*_interrupted(data), *_gaps(data), *_disagreement(data), *warnings_of(data.attrs))
    return Summary(_answer(data), _table(data), _trust(data), details, warned, _numbers(data))


def _engines(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data["engine"].values]


def _is_definite(data: xr.Dataset, engine: str) -> bool:
    return bool(data["is_definite"].sel(engine=engine))


def _bands(data: xr.Dataset, engine: str) -> list[xr.Dataset]:
    """Bands of an engine, by increasing speed."""
    return [data.isel(band=n) for n in np.flatnonzero(data["band_engine"].values == engine)]


def _answer(data: xr.Dataset) -> tuple[str, ...]:
    """Whether a vibration grows at the operating speed, where it does, and how fast."""
    first = _engines(data)[0]
    bands, ranges = _bands(data, first), _known_ranges(data)
    asked = [(float(data["crank_speed"][0]), float(data["crank_speed"][-1]))]
    within = ranges_text(ranges or asked, speed_unit(data))
    lines = [f"No growing vibration was found {within}."]
    if bands:
        many = "one band" if len(bands) == 1 else f"{len(bands)} bands"
        fastest = max(bands, key=_rate)
        lines = [
            f"Vibration grows in {many} {within}, fastest at {_range(fastest)}: "
            f"{_rate(fastest):.{_DIGITS}g} 1/s."
        ]
        ratios = [float(band["band_closing_damping_ratio"]) for band in bands]
        if np.isfinite(ratios).all():
            closed = "it" if len(bands) == 1 else "all of them"
            lines.append(f"A damping ratio of {100 * max(ratios):.{_DIGITS}g} % closes {closed}.")
    elif bool(data["interrupted"][0]):
        growing = data["crank_speed"].values[data["unstable"].values[0] == YES]
        listed = ", ".join(speed_text(speed, speed_unit(data)) for speed in growing[:_MOST_ROWS])
        unit = speed_unit(data)
        lines = [f"bands were not sought; vibration grows at: {listed or 'none'} {unit}"]
    operating = _at_operating_speed(data, bands, ranges)
    return (*operating, *lines, *_missed(data, first), *_about(data))


def _at_operating_speed(
    data: xr.Dataset, bands: list[xr.Dataset], ranges: list[Range]
) -> Iterator[str]:
    """Whether the greatest operating speed among those mapped lies in a band."""
    for speed in sorted(operating_speeds(data), key=abs)[-1:]:
        name = speed_name(data, speed)
        inside = [band for band in bands if lies_in(data, [_ends(band)], speed)]
        if not lies_in(data, ranges, speed):
            yield f"Stability at {name} is unknown: nothing was computed near it."
        elif inside:
            yield f"{name} is unstable: it lies in the band of {_range(inside[0])}."
        else:
            yield f"{name} lies outside every unstable band found."


def _missed(data: xr.Dataset, engine: str) -> Iterator[str]:
    """Bands that the steps in speed may miss."""
    for step in _greatest_step(data, engine):
        unit = speed_unit(data)
        yield (
            f"Speeds up to {step:.2g} {unit} apart were solved with the lowest "
            f"{data.sizes['multiplier'] // 2} modes: smaller steps and more modes may show further "
            "bands."
        )


def _about(data: xr.Dataset) -> Iterator[str]:
    """Motion that vibrations are about, where it is not the one that runs."""
    level, distance = data.attrs["prestress"], float(data.attrs["motion_distance"])
    if level == "equilibrium":
        speed = speed_name(data, data["crank_speed"][-1])
        far = f"is unknown to linear equations at {speed}"
        if math.isfinite(distance):
            far = f"departs from it by {percent(distance)} of its peak deflection at {speed}"
        yield (
            f"This is the stability of the quasi-static equilibrium; the periodic motion {far}: "
            "check it with --prestress trajectory."
        )
    elif level != "trajectory":
        yield (
            "This is the stability of straight links; check that of the motion itself by "
            "--prestress trajectory."
        )


def _known_ranges(data: xr.Dataset) -> list[Range]:
    """Ranges of speeds at which the first engine knows whether a vibration grows.

    In rad/s, from slow to fast, as far as speeds were solved for, those between the speeds asked
    for too; parted by speeds without equilibrium.
    """
    asked, states = data["crank_speed"].values, data["unstable"].values[0]
    known = np.isin(states, (YES, NO))
    solved = np.setdiff1d(_solved_speeds(data, _engines(data)[0]), asked)
    speeds = np.concatenate([asked, solved])
    order = np.argsort(np.abs(speeds))
    speeds, known = speeds[order], np.append(known, np.ones(len(solved), dtype=bool))[order]
    return [(float(speeds[run[0]]), float(speeds[run[-1]])) for run in unbroken_runs(known)]


def _solved_speeds(data: xr.Dataset, engine: str) -> FloatArray:
    return np.unique(data["curve_speed"].values[data["curve_engine"].values == engine])


def _greatest_step(data: xr.Dataset, engine: str) -> list[float]:
    """Greatest distance of two speeds solved for, in the user's unit; none without two."""
    steps = np.diff(_solved_speeds(data, engine))
    return [abs(from_si(float(steps.max()), speed_unit(data)))] if steps.size else []


def _table(data: xr.Dataset) -> Table | None:
    """Edges with their errors, names and growth rates, grouped by engine; None without bands."""
    unit, groups, left_out = speed_unit(data), [], 0
    for engine in _engines(data):
        bands = _bands(data, engine)
        shown = sorted(sorted(bands, key=_rate, reverse=True)[:_MOST_ROWS], key=_ends)
        left_out += len(bands) - len(shown)
        groups += [tuple(_row(engine, band, unit) for band in shown)] if shown else []
    if not groups:
        return None
    caption = "+-: larger error of the two edges, by steps, moving modes and mesh"
    if data["band_lower_open"].any() or data["band_upper_open"].any():
        caption += "; <, >: edge of the computed range, beyond which the band goes on"
    if left_out:
        caption += f"; {left_out} that grow more slowly are left out here"
    return Table(
        f"unstable bands, {data.attrs.get('mechanism', '')}",
        ("engine", "what meets", f"from {unit}", f"to {unit}", "+-", "grows 1/s", "closed by"),
        tuple(groups),
        text_columns=2,
        caption=caption,
    )


def _row(engine: str, band: xr.Dataset, unit: str) -> tuple[str, ...]:
    closing = float(band["band_closing_damping_ratio"])
    errors = [from_si(_error(band, edge), unit) for edge in EDGES]
    return (
        engine,
        _name(band),
        *_edges(band),
        f"{np.nanmax(errors):.1g}" if np.isfinite(errors).any() else "cut by the range",
        f"{_rate(band):.{_DIGITS}g}",
        f"{100 * closing:.{_DIGITS}g} %" if np.isfinite(closing) else "-",
    )


def _name(band: xr.Dataset) -> str:
    """Frequencies that meet, such as ``"f1 + f3 = 11 f"``, with f of the crank."""
    kind, branches = str(band["band_kind"].item()), str(band["band_branches"].item()).split()
    if not branches:
        return kind if kind == "divergence" else "name uncertain"
    sign = "-" if kind == "difference" else "+"
    return f"f{branches[0]} {sign} f{branches[-1]} = {int(band['band_order'])} f"


def _rate(band: xr.Dataset) -> float:
    return float(band["band_largest_growth_rate"])


def _ends(band: xr.Dataset) -> Range:
    return float(band["band_lower"]), float(band["band_upper"])


def _range(band: xr.Dataset) -> str:
    """From where to where a band reaches, such as ``"88.12 to 89.34 rad/s"``."""
    lower, upper = (text.lstrip("<> ") for text in _edges(band))
    goes_on = bool(band["band_lower_open"]) or bool(band["band_upper_open"])
    return f"{lower} to {upper} {speed_unit(band)}{', where the range ends' * goes_on}"


def _edges(band: xr.Dataset) -> tuple[str, str]:
    """Edges with the digits that their errors leave known; < and > where a band goes on.

    Two edges also differ in the printed digits, however great their errors are.
    """
    scale = from_si(1.0, speed_unit(band))
    values = [scale * end for end in _ends(band)]
    error = np.nan_to_num([abs(scale) * _error(band, edge) for edge in EDGES]).max()
    finest = max(min(error, abs(values[1] - values[0]) / 5), 1e-6 * max(map(abs, values)))
    decimals = int(np.clip(np.ceil(-np.log10(finest)), 0, 6))
    opened = [bool(band[f"band_{edge}_open"]) for edge in EDGES]
    # Where the range cuts a band, its end is what was asked for.
    lower, upper = (
        plain(value) if cut else f"{value:.{decimals}f}"
        for value, cut in zip(values, opened, strict=True)
    )
    return f"{'< ' * opened[0]}{lower}", f"{'> ' * opened[1]}{upper}"


def _error(band: xr.Dataset, edge: str) -> float:
    """Error of an edge in rad/s; not a number where the range of speeds cuts the band."""
    parts = sum(float(band[f"band_{edge}_{check}_error"]) for check in PARTS)
    return math.nan if bool(band[f"band_{edge}_open"]) else parts


def _numbers(data: xr.Dataset) -> tuple[Quantity, ...]:
    """Edges of the bands of the first engine with their errors; of one that is cut none."""
    unit = speed_unit(data)
    return tuple(
        Quantity(
            f"unstable_{name}",
            from_si(end, unit),
            unit,
            abs(from_si(_error(band, edge), unit)),
            _name(band),
        )
        for band in _bands(data, _engines(data)[0])
        for name, edge, end in zip(("from", "to"), EDGES, _ends(band), strict=True)
    )


def _trust(data: xr.Dataset) -> str:
    """How far edges, or without any the multipliers, are known; and whether the engines agree."""
    known = [abs(one.error / one.value) for one in _numbers(data) if math.isfinite(one.error)]
    line = trust_line(_engines(data), max(known, default=math.nan), _difference(data))
    if known:
        line = line.replace("numbers are", "edges of bands are", 1)
    else:
        error = float(np.nan_to_num(data["step_error"].values).max())
        ran = line.partition("; ")[2] or line
        line = f"logarithms of multipliers are known to {error:.0e} by the steps; {ran}"
    return "; ".join((line, *_unknown_errors(data)))


def _unknown_errors(data: xr.Dataset) -> Iterator[str]:
    """Errors of exponents that are not known, and where: a line for each engine and cause."""
    for engine in _engines(data):
        speeds = data["check_speed"].values[data["check_engine"].values == engine]
        for check, words in _CHECKS.items():
            errors = data[f"check_{check}"].values[data["check_engine"].values == engine]
            if np.isnan(errors).any():
                missing = ", ".join(
                    speed_text(w, speed_unit(data)) for w in speeds[np.isnan(errors)]
                )
                yield (
                    f"the error by the {words} is not known at {missing} {speed_unit(data)} "
                    f"({engine}): the linkage to compare with has no multipliers there"
                )


def _quantities(data: xr.Dataset) -> Iterator[Quantity]:
    """Errors by their causes, Krein signatures, periodic motion and shaft, of each engine."""
    unit = speed_unit(data)
    for engine in _engines(data):
        of_engine, bands = data.sel(engine=engine), _bands(data, engine)
        for check, words in zip(PARTS, ("steps", "moving modes", "mesh"), strict=True):
            errors = [float(band[f"band_{e}_{check}_error"]) for band in bands for e in EDGES]
            worst = abs(from_si(float(np.max(np.nan_to_num(errors), initial=0.0)), unit))
            if worst:
                yield Quantity(f"error of edges by {words}", worst, unit, of=engine)
        for band in bands:
            product = float(band["band_first_signature"]) * float(band["band_second_signature"])
            where = f"{_name(band)} at {_range(band)}, {engine}"
            yield Quantity("product of the Krein signatures that meet", product, "", of=where)
        for name, words in (
            ("step_error", "error of log multipliers by steps"),
            ("liouville_defect", "gap of Liouville's integral of the trace"),
            ("orbit_residual", "residual of the periodic motion"),
        ):
            yield Quantity(words, float(of_engine[name].max()), "", of=engine)
        for n in np.flatnonzero(data["check_engine"].values == engine):
            at = f"{speed_name(data, data['check_speed'][n])}, {engine}"
            for check, words in _CHECKS.items():
                error = float(data[f"check_{check}"][n])
                yield Quantity(f"error of exponents by the {words}", error, "", of=at)
            growth = float(data["check_growth"][n])
            yield Quantity("error of the greatest log multiplier", growth, "", of=at)
        for name, words, factor, shown in (
            ("orbit_distance", "periodic motion from the equilibrium over displacement", 100, "%"),
            ("shaft_growth_rate", "growth rate of the free shaft's own motion", 1, "1/s"),
        ):
            if name in of_engine and np.isfinite(of_engine[name]).any():
                greatest = of_engine[name].isel(
                    crank_speed=int(np.nanargmax(of_engine[name].values))
                )
                at = f"{speed_name(data, greatest['crank_speed'])}, {engine}"
                yield Quantity(words, factor * float(greatest), shown, of=at)
        for step in _greatest_step(data, engine):
            yield Quantity("greatest distance of speeds solved for", step, unit, of=engine)
        if count := int(of_engine["closed_early"]):
            closed = f"closed by {100 * float(data.attrs['least_closing_ratio']):.3g} %, {engine}"
            yield Quantity("narrow bands left out", float(count), "", of=closed)


def _difference(data: xr.Dataset) -> EngineDifference | None:
    """The edge of two engines' bands that their errors explain least.

    Not a number where one engine has a band that the other has not; None where there is nothing to
    compare.
    """
    pairs, alone = _pairs(data)
    if alone:
        return EngineDifference(math.nan, math.nan)
    apart, allowed = [], []
    for one, two in pairs:
        for edge, first, second in zip(EDGES, _ends(one), _ends(two), strict=True):
            error = _error(one, edge) + _error(two, edge)
            # Where the range of speeds cuts a band, nothing is known of its edge.
            if math.isfinite(error):
                apart.append(abs(second / first - 1))
                allowed.append(abs(error / first))
    return EngineDifference.least_explained(apart, allowed) if apart else None


def _pairs(data: xr.Dataset) -> tuple[list[tuple[xr.Dataset, xr.Dataset]], int]:
    """Bands of two engines that overlap most, and how many bands have no other.

    A name may be certain for one engine alone; where a band lies is known for both.
    """
    if data.sizes["engine"] < 2:
        return [], 0
    first, second = (_bands(data, name) for name in _engines(data)[:2])
    one, two = (
        np.array([sorted(_ends(b)) for b in bands]).reshape(-1, 2) for bands in (first, second)
    )
    shared = np.minimum(one[:, None, 1], two[:, 1]) - np.maximum(one[:, None, 0], two[:, 0])
    places = scipy.optimize.linear_sum_assignment(-np.maximum(shared, 0.0))
    pairs = [(first[a], second[b]) for a, b in zip(*places, strict=True) if shared[a, b] > 0]
    return pairs, len(first) + len(second) - 2 * len(pairs)


def _verdict(data: xr.Dataset) -> str:
    """How far two engines' multipliers and band edges differ; or that only one ran.

    Moduli above 1 are compared relative to the greater one, which no number may hold.
    """
    logs = np.sort(data["log_modulus"].values[:2], axis=-1)
    apart = -np.expm1(-np.abs(logs[-1] - logs[0]))
    line = engines_line(data, np.exp(np.minimum(logs.max(axis=0), 0.0)) * apart, "moduli")
    if " differ by " not in line:
        return line
    pairs, alone = _pairs(data)
    gaps = [abs(a - b) for one, two in pairs for a, b in zip(_ends(one), _ends(two), strict=True)]
    said = ["neither has an unstable band"] if not pairs and not alone else []
    if gaps:
        unit = speed_unit(data)
        said.append(f"edges of bands by at most {abs(from_si(max(gaps), unit)):.2g} {unit}")
    if alone:
        said.append(f"{alone} band{'' if alone == 1 else 's'} without a counterpart")
    return f"{line}; {', '.join(said)}{theory_reason(data.attrs)}"


def _disagreement(data: xr.Dataset) -> list[str]:
    """Difference of two engines beyond their errors, where no beam theory explains it."""
    difference = _difference(data)
    explained = theory_reason(data.attrs) or difference is None or not difference.worth_a_warning
    return [] if explained else [_verdict(data)]


def _interrupted(data: xr.Dataset) -> list[str]:
    """How far an interrupted map has come."""
    if not bool(data["interrupted"].any()) and not data.attrs.get("interrupted_against"):
        return []
    done = [
        f"{int((data['unstable'].sel(engine=name) != NOT_COMPUTED).sum())} of "
        f"{data.sizes['crank_speed']} crank speeds by {name}"
        for name in _engines(data)
    ]
    return [f"interrupted after {', '.join(done)}; finished speeds are kept"]


def _gaps(data: xr.Dataset) -> Iterator[str]:
    """Crank speeds without equilibrium, and why."""
    for name in _engines(data):
        of_engine = data.sel(engine=name)
        states = of_engine["unstable"].values.tolist()
        buckled = np.isfinite(of_engine["growth_rate"].values).tolist()
        kinds = zip(states, buckled, strict=True)
        for (state, linear), group in groupby(enumerate(kinds), key=lambda one: one[1]):
            run = of_engine.isel(crank_speed=[place for place, _ in group])
            count, speeds = run.sizes["crank_speed"], run["crank_speed"].values[[0, -1]].tolist()
            if state == NO_EQUILIBRIUM:
                where = ranges_text([(speeds[0], speeds[1])], speed_unit(data))
                yield (
                    f"gap: {name} has no equilibrium {where} ({count} speed{'s' * (count > 1)}): "
                    f"{run['reason'].values[0]}"
                    + "; multipliers there are those of the linear equations about straight links"
                    * linear
                )
