"""What a designer wants first: speeds to avoid, frequencies, deflection, and how sure that is."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from flexmech.analyses import (
    CampbellDiagram,
    MovingFrequencies,
    Response,
    RunningHammerTest,
    StabilityMap,
    Summary,
)
from flexmech.analyses.frequencies.extremes import known_error
from flexmech.plots.campbell import critical_stretches
from flexmech.plots.reading import merged, names_of
from flexmech.report.panels.frequencies import in_each_state
from flexmech.report.results import Results, speed_name, speed_unit_of, state_of, with_error
from flexmech.units import from_si

# Orders that are told one by one: higher ones excite little.
LOWEST_ORDERS = 3
Ranges = list[tuple[float, float]]


@dataclass(frozen=True)
class Answer:
    """A question and its answer.

    Parameters
    ----------
    question : str
    lines : tuple of str
    """

    question: str
    lines: tuple[str, ...]


def answers(results: Results) -> list[Answer]:
    """Answers to the questions that there are results for."""
    found = [
        Answer("Which crank speeds to avoid", _speeds_to_avoid(results)),
        Answer("Where the linkage shakes itself up", _growth(results)),
        Answer("Natural frequencies", _frequencies(results)),
        Answer("Deflection", _deflection(results)),
        Answer("How sure is that", _trust(results)),
    ]
    return [each for each in found if each.lines]


def report_summary(results: Results) -> Summary:
    """What a report says first, for a terminal.

    Parameters
    ----------
    results : Results

    Returns
    -------
    Summary
    """
    lines = [f"{one.question.lower()}: {line}" for one in answers(results) for line in one.lines]
    warnings = [warning for each in results.all for warning in each.summary().warnings]
    return Summary(tuple(lines), warnings=tuple(dict.fromkeys(warnings)))


def _speeds_to_avoid(results: Results) -> tuple[str, ...]:
    """Speeds at which the lowest orders meet a branch, and where no order does."""
    result = results.first(CampbellDiagram)
    if result is None:
        return ()
    data, unit = result.dataset, speed_unit_of(results)
    stretches = critical_stretches(data)
    orders = sorted({order for order, *_ in stretches})
    low, high = (float(each) for each in data["crank_speed"].values[[0, -1]])
    within = f"{from_si(low, unit):.4g} to {from_si(high, unit):.4g} {unit}"
    computed = data["order"].values
    considered = f"orders {int(computed.min())} to {int(computed.max())} of the crank"
    if not orders:
        return (f"none from {within}: no frequency is met by {considered}",)
    every = merged((start, end) for _, (start, end), _ in stretches)
    lines = [f"avoid {_listed(every, (low, high), unit)}: there {considered} meet a frequency"]
    lines += _at_chosen_speeds(results, every, unit)
    for order in orders[:LOWEST_ORDERS]:
        own = merged((start, end) for one, (start, end), _ in stretches if one == order)
        lines.append(f"order {order}: {_listed(own, (low, high), unit)}")
    if not _between(every, low, high):
        lines.append(f"no speed from {within} is free of {considered}")
    return tuple(lines)


def _at_chosen_speeds(results: Results, every: Ranges, unit: str) -> list[str]:
    """Whether the speeds of the frequencies and runs are critical."""
    speeds = {float(run.dataset.attrs["crank_speed"]) for run in results.of_kind(Response)}
    for each in results.of_kind(MovingFrequencies):
        speeds |= set(each.dataset["crank_speed"].values.tolist())
    names: dict[bool, list[str]] = {True: [], False: []}
    for speed in sorted(speeds - {0.0}):
        names[any(low <= speed <= high for low, high in every)].append(speed_name(speed, unit))
    words = {True: "critical among the speeds shown", False: "not critical"}
    return [f"{words[met]}: {', '.join(found)}" for met, found in names.items() if found]


def _between(ranges: Ranges, low: float, high: float) -> Ranges:
    """What ranges that do not overlap leave of a range."""
    edges = [low, *(end for pair in ranges for end in pair), high]
    gaps = list(pairwise(edges))[::2]
    return [(a, b) for a, b in gaps if b - a > 1e-3 * (high - low)]


def _listed(ranges: Ranges, within: tuple[float, float], unit: str) -> str:
    """Ranges in words; those that reach the end of what was computed may go on beyond it."""
    texts = []
    for low, high in ranges:
        beyond = " or more" if high >= within[1] else ""
        ends = dict.fromkeys(f"{from_si(end, unit):.4g}" for end in (low, high))
        texts.append(f"{' to '.join(ends)}{beyond}")
    return f"{', '.join(texts)} {unit}"


def _growth(results: Results) -> tuple[str, ...]:
    """Unstable bands of crank speeds, in sentences."""
    result = results.first(StabilityMap)
    if result is None:
        return ()
    told = (line for line in result.summary().lines if line.startswith("avoid"))
    return tuple(line.removeprefix("avoid: ") for line in told)


def _frequencies(results: Results) -> tuple[str, ...]:
    """Lowest and highest frequency over crank angles and speeds, in each state."""
    result = results.first(MovingFrequencies)
    if result is None:
        return ()
    lines, unit = [], speed_unit_of(results)
    states = in_each_state(result)
    for state, data in states.items():
        of = f"{state}: " if len(states) > 1 else ""
        extremes, error = MovingFrequencies(data).extremes(), known_error(data)
        for which, chosen in (("lowest", np.argmin), ("highest", np.argmax)):
            values = extremes[which].isel(engine=0)
            at = np.unravel_index(int(chosen(values.values)), values.shape)
            place = dict(zip(values.dims, at, strict=True))
            value = float(values.isel(place))
            angle = np.degrees(float(extremes[f"{which}_angle"].isel(engine=0).isel(place)))
            relative = float(error.isel(engine=0).isel(place))
            speed = float(values["crank_speed"][place["crank_speed"]])
            mode = int(values["mode"][place["mode"]])
            lines.append(
                f"{of}{which} of {data.sizes['mode']} modes {with_error(value, value * relative)} "
                f"Hz: mode {mode}, {speed_name(speed, unit)}, {angle:.0f} deg"
            )
    return tuple(lines)


def _deflection(results: Results) -> tuple[str, ...]:
    """Greatest deflection of every run, and greatest joint force."""
    lines, unit = [], speed_unit_of(results)
    for run in results.of_kind(Response):
        data, peaks = run.dataset, run.peaks().isel(engine=0)
        engine = names_of(data, "engine")[0]
        link = str(peaks["deflection"].idxmax("link").item())
        value = 1e3 * float(peaks["deflection"].max())
        error = run.errors()["peak_deflection"].sel(engine=engine, link=link)
        known = with_error(value, value * float(error))
        joint = str(peaks["joint_force"].idxmax("joint").item())
        force = float(peaks["joint_force"].max())
        state = state_of(data.attrs)
        where = speed_name(float(data.attrs["crank_speed"]), unit)
        lines.append(
            f"{where}{'' if state == 'dry' else f', {state}'}: at most {known} mm ({link}); "
            f"greatest joint force {force:.4g} N ({joint})"
        )
    return tuple(lines)


def _trust(results: Results) -> tuple[str, ...]:
    """What each result says of its engines, and what limits it."""
    lines = []
    for kind in (MovingFrequencies, CampbellDiagram, StabilityMap, RunningHammerTest, Response):
        for result in results.of_kind(kind):
            said = result.summary()
            subject = result.subject[:1].upper() + result.subject[1:]
            lines.append(f"{subject}: {said.verdict.removeprefix('engines: ')}")
    return tuple(dict.fromkeys(lines))
