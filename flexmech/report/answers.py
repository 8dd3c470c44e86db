"""What a designer wants first, in cards: critical speeds, bending, forces, torque and strength."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from flexmech.analyses import (
    CampbellDiagram,
    Kinematics,
    MovingFrequencies,
    Response,
    Result,
    StabilityMap,
    Strength,
    Summary,
)
from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.response.stresses import stress_words, yielding
from flexmech.report.results import Results, speed_name, speed_unit_of
from flexmech.studies import DesignSweep, Optimum, Uncertainty

# Digits of a factor: loads and strengths are known to fewer.
_DIGITS = 3
# A run at the operating speed is at it but for what its unit rounds.
_SAME_SPEED = 1e-6


@dataclass(frozen=True)
class Card:
    """A question, its number, where that is, and what it means at the operating speed.

    Parameters
    ----------
    question : str
    value : str
        In large letters; a dash where nothing was computed.
    place : str
        What the number is of; may be empty.
    lines : tuple of str
        The verdict against the operating speed, and what must be seen with it.
    further : tuple of str
        Further sentences, which a narrow screen folds.
    """

    question: str
    value: str
    place: str
    lines: tuple[str, ...]
    further: tuple[str, ...] = ()


def cards(results: Results) -> tuple[Card, ...]:
    """The four cards of a report, and one of strength where it was judged.

    Parameters
    ----------
    results : Results

    Returns
    -------
    tuple of Card
        Each of a question that no result answers says which command does, unless strength has an
        answer. None of a study of designs alone, whose answer is another.
    """
    shown: tuple[Card, ...] = (
        _critical_speeds(results),
        _bending(results),
        _load(results, "Joint forces", "peak_joint_force", "greatest force of"),
        _load(results, "Driving torque", "peak_driving_torque", "greatest torque of the shaft"),
    )
    strong = _strength(results)
    if strong:
        shown = tuple(card for card in shown if card.value != _NOTHING)
    studied = all(isinstance(each, DesignSweep | Uncertainty | Optimum) for each in results.all)
    return () if studied else (*shown, *strong)


def report_summary(results: Results) -> Summary:
    """What a report says first, for a terminal.

    Parameters
    ----------
    results : Results

    Returns
    -------
    Summary
    """
    shown = cards(results)
    answer = tuple(
        f"{card.question}: {' '.join(filter(None, (card.value, card.place)))}. "
        f"{' '.join((*card.lines, *card.further))}".rstrip()
        for card in shown
        if card.value != _NOTHING
    )
    said = [each.summary() for each in results.all]
    details = tuple(
        f"{each.title}: {line}"
        for each, one in zip(results.all, said, strict=True)
        for line in (*one.answer, one.trust)
        if line
    )
    return Summary(
        answer or details[:1],
        trust=trust(results),
        details=details,
        warnings=tuple(dict.fromkeys(warning for one in said for warning in one.warnings)),
        numbers=tuple(number for one in said for number in one.numbers),
    )


def trust(results: Results) -> str:
    """How far the results of the cards are known, each in its own words.

    Parameters
    ----------
    results : Results

    Returns
    -------
    str
    """
    found = [
        f"{result.subject}: {result.summary().trust}"
        for kind in (CampbellDiagram, MovingFrequencies, Response)
        if (result := results.first(kind)) is not None
    ]
    return ". ".join(line[:1].upper() + line[1:] for line in found)


_NOTHING = "-"


def _missing(question: str, command: str) -> Card:
    return Card(question, _NOTHING, "", (f"Nothing was computed: flexmech {command} tells it.",))


def _critical_speeds(results: Results) -> Card:
    """Whether orders meet a frequency at the operating speed, and what shakes itself up."""
    question = "Critical speeds"
    found = results.first(CampbellDiagram) or results.first(MovingFrequencies)
    grown = results.first(StabilityMap)
    growth = () if grown is None else grown.summary().answer
    if found is None:
        missing = _missing(question, "campbell")
        return replace(missing, lines=(*growth, *missing.lines))
    said = found.summary()
    lines, further = [*said.answer[:1], *growth], said.answer[1:]
    if isinstance(found, MovingFrequencies):
        lines.append("flexmech campbell tells which crank speeds to avoid.")
        lowest = min(
            (one for one in said.numbers if one.name == "lowest_frequency"),
            key=lambda one: one.value,
        )
        place = f"lowest frequency, {lowest.of}"
        return Card(question, str(lowest), place, tuple(lines), further)
    starts = [one for one in said.numbers if one.name == "critical_speed_from"]
    if not starts:
        return Card(question, "none", "among the speeds computed", tuple(lines), further)
    lowest = min(starts, key=lambda one: abs(one.value))
    place = f"the lowest, of {lowest.of}"
    return Card(question, f"from {lowest}", place, tuple(lines), further)


def _bending(results: Results) -> Card:
    """Greatest deflection of the run that bends most, and the greatest stress."""
    question, found = "Deflection and stress", _greatest(results, "peak_deflection")
    if found is None:
        return _missing(question, "response")
    run, deflection = found
    lines = [_verdict(run, results)]
    if (stressed := _greatest(results, "peak_stress")) is not None:
        strained, stress = stressed
        words = stress_words(strained.dataset, stress)
        lines.append(f"{words[:1].upper()}{words[1:]}.")
        lines += [f"{line[:1].upper()}{line[1:]}." for line in yielding(strained.dataset)]
    place = f"greatest of the {deflection.of}"
    return Card(question, str(deflection), place, tuple(lines), _others(run, deflection))


def _load(results: Results, question: str, name: str, words: str) -> Card:
    """A greatest load, of elastic links if they ran, else of rigid ones."""
    found = _greatest(results, name)
    if found is None:
        return _missing(question, "response")
    run, load = found
    links = "of elastic links" if isinstance(run, Response) else "of rigid links"
    place = f"{words} {load.of}".rstrip()
    verdict = (_verdict(run, results),)
    return Card(question, str(load), f"{place}, {links}", verdict, _others(run, load))


def _strength(results: Results) -> tuple[Card, ...]:
    """Least load factor of all results of strength; none without such a result."""
    found = [
        (run, number)
        for run in results.of_kind(Strength)
        for number in run.summary().numbers
        if number.name == "load_factor"
    ]
    if not found:
        return ()
    run, least = min(found, key=lambda pair: pair[1].value)
    value = rounded(least.value, math.nan, _DIGITS) if math.isfinite(least.value) else "any"
    source = run.dataset.attrs["source_of_loads"]
    place = f"times the loads until {least.of} fails, {source} loads"
    (first, *further) = run.summary().answer
    return (Card("Strength", value, place, (_verdict(run, results), first), tuple(further)),)


def _others(run: Result, greatest: Quantity) -> tuple[str, ...]:
    """The same of the other links or joints of a run; nothing where there are none."""
    named = [
        f"{number.of} {number}"
        for number in run.summary().numbers
        if number.name == greatest.name and number.of != greatest.of
    ]
    return (f"The others: {', '.join(named)}.",) if named else ()


def _greatest(results: Results, name: str) -> tuple[Result, Quantity] | None:
    """The greatest number of a name and the run that has it.

    Elastic runs come first, and runs at constant speed before those under a law or a motor.
    """
    for kind in (Response, Kinematics):
        runs = results.of_kind(kind)
        found = [
            (run, number)
            for run in [own for own in runs if "drive" not in own.dataset.attrs] or runs
            for number in run.summary().numbers
            if number.name == name
        ]
        if found:
            return max(found, key=lambda pair: pair[1].value)
    return None


def _verdict(run: Result, results: Results) -> str:
    """At which speed a run is, and whether the model file says that the linkage runs at it."""
    speed, unit = float(run.dataset.attrs["crank_speed"]), speed_unit_of(results)
    named = [float(each) for each in results.attribute("operating_speeds").split()]
    where = f"At {speed_name(speed, unit)}"
    if not named:
        return f"{where}; the model file names no operating speed."
    greatest = max(named, key=abs)
    if abs(speed - greatest) <= _SAME_SPEED * abs(greatest):
        return f"{where}, the greatest operating speed."
    if any(abs(speed - each) <= _SAME_SPEED * abs(each) for each in named):
        return f"{where}, an operating speed; the greatest is {speed_name(greatest, unit)}."
    return f"{where}; the operating speed is {speed_name(greatest, unit)}."
