"""What a designer wants first, in cards: critical speeds, bending, forces, torque and strength."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from flexmech.analyses import (
    CampbellDiagram,
    Kinematics,
    ModelCheck,
    MovingFrequencies,
    Response,
    Result,
    StabilityMap,
    Strength,
    Summary,
    Table,
)
from flexmech.analyses.digits import Quantity, plain, rounded
from flexmech.analyses.response.stresses import stress_words, yielding
from flexmech.report.results import Results, speed_name, speed_unit_of
from flexmech.studies import DesignSweep, Optimum, Uncertainty

# Digits of a factor: loads and strengths are known to fewer.
_DIGITS = 3
_AT_GREATEST = ", the greatest operating speed."
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
    table : Table, optional
    """

    question: str
    value: str
    place: str
    lines: tuple[str, ...]
    further: tuple[str, ...] = ()
    table: Table | None = None


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


def brief_cards(results: Results) -> tuple[Card, ...]:
    """The cards of a brief page: motion at the tool, stress, torque, bearings, speeds, mass.

    Parameters
    ----------
    results : Results

    Returns
    -------
    tuple of Card
        Each of a question that no result answers has the reason and the remedy in its line.
    """
    return (
        _operation(results),
        _tool(results),
        _stress(results),
        _torque(results),
        _bearings(results),
        _speeds_to_avoid(results),
        _mass(results),
    )


def report_summary(results: Results, *, brief: bool = False) -> Summary:
    """What a report says first, for a terminal.

    Parameters
    ----------
    results : Results
    brief : bool
        Whether the page is a brief one.

    Returns
    -------
    Summary
    """
    shown = brief_cards(results) if brief else cards(results)
    answer = tuple(_in_a_line(card) for card in shown if brief or card.value != _NOTHING)
    said = [each.said for each in results.all]
    details = tuple(
        f"{each.title}: {line}"
        for each, one in zip(results.all, said, strict=True)
        for line in (*one.answer, one.trust)
        if line
    )
    return Summary(
        answer or details[:1],
        next((card.table for card in shown if card.table is not None), None),
        trust=trust(results),
        details=details,
        warnings=tuple(dict.fromkeys(warning for one in said for warning in one.warnings)),
        numbers=tuple(number for one in said for number in one.numbers),
    )


def _in_a_line(card: Card) -> str:
    """A card for a terminal; the reason alone where there is no number."""
    number = ", ".join(part for part in (card.value, card.place) if part not in ("", _NOTHING))
    said = (f"{number}.", *card.lines, *card.further) if number else (*card.lines, *card.further)
    return f"{card.question}: {' '.join(said)}"


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
        f"{result.subject}: {result.said.trust}"
        for kind in (CampbellDiagram, MovingFrequencies, Response)
        if (result := results.first(kind)) is not None
    ]
    return ". ".join(line[:1].upper() + line[1:] for line in found)


_NOTHING = "-"


def _missing(question: str, command: str) -> Card:
    return Card(question, _NOTHING, "", (f"Not computed: flexmech {command} answers it.",))


def _critical_speeds(results: Results) -> Card:
    """Whether orders meet a frequency at the operating speed, and what shakes itself up."""
    question = "Critical speeds"
    found = results.first(CampbellDiagram) or results.first(MovingFrequencies)
    grown = results.first(StabilityMap)
    growth = () if grown is None else grown.said.answer
    if found is None:
        missing = _missing(question, "campbell")
        return replace(missing, lines=(*growth, *missing.lines))
    said = found.said
    lines, further = [*said.answer[:1], *growth], said.answer[1:]
    if isinstance(found, MovingFrequencies):
        lines.append("flexmech campbell lists the crank speeds to avoid.")
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
        for number in run.said.numbers
        if number.name == "load_factor"
    ]
    if not found:
        return ()
    run, least = min(found, key=lambda pair: pair[1].value)
    value = rounded(least.value, math.nan, _DIGITS) if math.isfinite(least.value) else "any"
    source = run.dataset.attrs["source_of_loads"]
    place = f"times the loads until {least.of} fails, {source} loads"
    (first, *further) = run.said.answer
    return (Card("Strength", value, place, (_verdict(run, results), first), tuple(further)),)


def _others(run: Result, greatest: Quantity) -> tuple[str, ...]:
    """The same of the other links or joints of a run; nothing where there are none."""
    named = [
        f"{number.of} {number}"
        for number in run.said.numbers
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
            for number in run.said.numbers
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
        return f"{where}{_AT_GREATEST}"
    if any(abs(speed - each) <= _SAME_SPEED * abs(each) for each in named):
        return f"{where}, an operating speed; the greatest is {speed_name(greatest, unit)}."
    return f"{where}; the operating speed is {speed_name(greatest, unit)}."


def _operation(results: Results) -> Card:
    """Range of operating speeds, what kind of linkage turns at them, and at which numbers are."""
    question, unit = "Operating speed", speed_unit_of(results)
    named = [float(each) for each in results.attribute("operating_speeds").split()]
    kind = tuple(filter(None, [results.attribute("linkage_in_short")]))
    if not named:
        lines = ("The model file names none: add crank_speeds to [operation].", *kind)
        return Card(question, _NOTHING, "", lines)
    ends = dict.fromkeys(speed_name(end, unit) for end in (min(named), max(named)))
    value = " to ".join(ends).replace(f" {unit} to", " to")
    greatest = speed_name(max(named, key=abs), unit)
    said = f"Numbers are the greatest of all runs, at {greatest} where no speed is named."
    return Card(question, value, "", (*kind, said))


def _elsewhere(run: Result, results: Results) -> tuple[str, ...]:
    """At which speed a run is, where that is not the greatest operating speed."""
    verdict = _verdict(run, results)
    return () if verdict.endswith(_AT_GREATEST) else (verdict,)


def _tool(results: Results) -> Card:
    """How far the point that leaves its path most is off it, and how far links bend."""
    question, found = "Deflection at the tool", _greatest(results, "peak_path_deviation")
    if found is None:
        return _unanswered(results, question, "response")
    run, tool = found
    lines = [*_elsewhere(run, results), *_others(run, tool)]
    if (bent := _greatest(results, "peak_deflection")) is not None:
        lines.append(f"The {bent[1].of} bends by at most {bent[1]}.")
    return Card(question, str(tool), f"{tool.of}, off its path on rigid links", tuple(lines))


def _stress(results: Results) -> Card:
    """Greatest stress, and the least factor by which loads may rise before a part fails."""
    question, found = "Stress and safety factor", _greatest(results, "peak_stress")
    stress, place, lines = "", "", list[str]()
    if found is not None:
        stress, place = str(found[1]), f"greatest normal stress, in the {found[1].of}"
        lines = [*_elsewhere(found[0], results), *map(_sentence, yielding(found[0].dataset))]
    if not (strong := _strength(results)):
        (lacking,) = _unanswered(results, question, "strength").lines
        return Card(question, stress or _NOTHING, place, (*lines, f"No safety factor: {lacking}"))
    (factor,) = strong
    value = ", ".join(filter(None, (stress, f"factor {factor.value}")))
    return Card(question, value, place or factor.place, (*lines, *map(_sentence, factor.lines[1:])))


def _sentence(words: str) -> str:
    return f"{words[:1].upper()}{words[1:].rstrip('.')}."


def _torque(results: Results) -> Card:
    """Root mean square and greatest torque of the shaft, of the run that has the greatest."""
    question, found = "Driving torque", _greatest(results, "peak_driving_torque")
    if found is None:
        return _unanswered(results, question, "response")
    run, peak = found
    value, place = str(peak), "peak, at the shaft"
    for mean in run.said.numbers:
        if (mean.name, mean.of) == ("rms_torque", "shaft"):
            value, place = f"{mean} RMS", f"peak {peak}, at the shaft"
    return Card(question, value, place, _elsewhere(run, results))


def _bearings(results: Results) -> Card:
    """Equivalent and greatest load of every joint, in the run that has the greatest."""
    question, found = "Bearing loads", _greatest(results, "peak_joint_force")
    if found is None:
        return _unanswered(results, question, "response")
    run, most = found
    loads = [
        {one.of: one for one in run.said.numbers if one.name == name}
        for name in ("cubic_mean_force", "peak_joint_force")
    ]
    rows = [
        (joint, *(str(load.get(joint, _NOTHING)).removesuffix(" N") for load in loads))
        for joint in dict.fromkeys([*loads[0], *loads[1]])
    ]
    table = Table("load of each joint", ("joint", "cubic mean N", "peak N"), (tuple(rows),))
    place = f"greatest, of joint {most.of}"
    return Card(question, str(most), place, _elsewhere(run, results), table=table)


def _speeds_to_avoid(results: Results) -> Card:
    """What the Campbell diagram says of the operating speeds and of the others."""
    question = "Critical speeds"
    if results.first(CampbellDiagram) is None:
        return _unanswered(results, question, "campbell")
    card = _critical_speeds(results)
    return replace(card, lines=(*card.lines, *card.further), further=())


def _mass(results: Results) -> Card:
    """Mass of all that moves, and the share of the links."""
    question, found = "Moving mass", results.first(ModelCheck)
    if found is None:
        return _unanswered(results, question, "check")
    (total,) = (one for one in found.said.numbers if one.name == "total_mass")
    masses = [found.dataset[name].values.tolist() for name in ("link", "link_mass")]
    links = ", ".join(f"{name} {plain(1e3 * mass)} g" for name, mass in zip(*masses, strict=True))
    return Card(question, str(total), "", (f"Links without masses on them: {links}.",))


def _unanswered(results: Results, question: str, command: str) -> Card:
    """A card without a number: why there is none, and what to do."""
    if command in results.refused:
        return Card(question, _NOTHING, "", (f"{results.refused[command].rstrip('.')}.",))
    return _missing(question, command)
