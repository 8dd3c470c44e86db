"""Summaries of results: tables and lines, for a terminal, a notebook or a script.

Remarks name the conditions: heat and moisture, and loads that are left out. The last line says how
far the printed numbers are known, and whether the engines agree.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any, SupportsFloat

import numpy as np
import xarray as xr

from flexmech.analyses.beam_theory import theory_warnings
from flexmech.analyses.digits import Quantity, percent
from flexmech.analyses.requests import environment_of
from flexmech.arrays import FloatArray
from flexmech.hygrothermal import Environment, inert_links, resin_retention, swollen_links
from flexmech.mechanism import Mechanism
from flexmech.plots.reading import speed_unit
from flexmech.units import from_si

Row = tuple[str, ...]


@dataclass(frozen=True)
class Table:
    """A table of texts.

    Parameters
    ----------
    title : str
    headings : tuple of str
    groups : tuple of tuple of tuple of str
        Rows, in groups with a line between them.
    text_columns : int
        How many columns hold words, on the left; the others hold numbers.
    caption : str
    """

    title: str
    headings: Row
    groups: tuple[tuple[Row, ...], ...]
    text_columns: int = 1
    caption: str = ""

    def __str__(self) -> str:
        rows = [self.headings, *(row for group in self.groups for row in group)]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        rule = "-" * (sum(widths) + 2 * (len(widths) - 1))
        lines = [self.title, self._line(self.headings, widths)]
        for group in self.groups:
            lines += [rule, *(self._line(row, widths) for row in group)]
        return "\n".join([*lines, self.caption] if self.caption else lines)

    def _line(self, row: Row, widths: list[int]) -> str:
        cells = [
            text.ljust(width) if number < self.text_columns else text.rjust(width)
            for number, (text, width) in enumerate(zip(row, widths, strict=True))
        ]
        return "  ".join(cells).rstrip()

    def _repr_html_(self) -> str:
        caption = f"<p>{escape(self.caption)}</p>" if self.caption else ""
        heading = "".join(f"<th>{escape(text)}</th>" for text in self.headings)
        rows = "".join(
            "<tr>" + "".join(f"<td>{escape(text)}</td>" for text in row) + "</tr>"
            for group in self.groups
            for row in group
        )
        return (
            f"<table><caption>{escape(self.title)}</caption><thead><tr>{heading}</tr></thead>"
            f"<tbody>{rows}</tbody></table>{caption}"
        )

    def as_data(self) -> dict[str, Any]:
        """The same for JSON: what is a number is one, and what a cell leaves out is None."""
        words = self.text_columns
        rows = [row for group in self.groups for row in group]
        return {
            "title": self.title,
            "columns": list(self.headings),
            "rows": [[*row[:words], *map(_number, row[words:])] for row in rows],
            "caption": self.caption,
        }


def _number(cell: str) -> float | str | None:
    """A number where a cell is one, else its text."""
    if cell in ("", "-"):
        return None
    try:
        return float(cell)
    except ValueError:
        return cell


@dataclass(frozen=True)
class Aspect:
    """Share of one thing, such as a motor, in the summary of a result.

    Parameters
    ----------
    answer, details, warnings, numbers : tuple
        As those of a :class:`Summary`; all are empty where there is no such thing.
    leads : bool
        Whether its answer stands before those of the others.
    """

    answer: tuple[str, ...] = ()
    details: tuple[Table | str, ...] = ()
    warnings: tuple[str, ...] = ()
    numbers: tuple[Quantity, ...] = ()
    leads: bool = False


@dataclass(frozen=True)
class Summary:
    """Summary of a result: the answer first, and all else on request.

    Parameters
    ----------
    answer : tuple of str
        One to three sentences that say what the user came for.
    table : Table, optional
        The one table that the answer rests on.
    trust : str
        The line that says how far the numbers above are known; may be empty.
    details : tuple of Table or str
        Everything else that is known, from the first to the last.
    warnings : tuple of str
        What the user must act on; commands write them to stderr, before all else.
    numbers : tuple of Quantity
        The numbers of the answer, for programs.
    """

    answer: tuple[str, ...]
    table: Table | None = None
    trust: str = ""
    details: tuple[Table | str, ...] = ()
    warnings: tuple[str, ...] = ()
    numbers: tuple[Quantity, ...] = ()

    @classmethod
    def of(
        cls,
        aspects: Sequence[Aspect],
        table: Table | None = None,
        trust: str = "",
        most: int | None = None,
    ) -> Summary:
        """The summary of what a result says of one thing after the other.

        Parameters
        ----------
        aspects : sequence of Aspect
        table : Table, optional
        trust : str
        most : int, optional
            Sentences of the answer at most: the last ones stay, and those of aspects that lead.
        """
        lead = [said for aspect in aspects if aspect.leads for said in aspect.answer]
        others = [said for aspect in aspects if not aspect.leads for said in aspect.answer]
        dropped = 0 if most is None else max(len(lead) + len(others) - most, 0)
        return cls(
            (*lead, *others[dropped:]),
            table,
            trust,
            tuple(detail for aspect in aspects for detail in aspect.details),
            tuple(warning for aspect in aspects for warning in aspect.warnings),
            tuple(number for aspect in aspects for number in aspect.numbers),
        )

    @property
    def first(self) -> tuple[Table | str, ...]:
        """Answer, table and trust: what a command prints."""
        parts = (*self.answer, self.table, self.trust)
        return tuple(part for part in parts if part)

    @property
    def parts(self) -> tuple[Table | str, ...]:
        """All of it but the warnings: what a command prints with details."""
        return (*self.first, *self.details)

    @property
    def tables(self) -> tuple[Table, ...]:
        """The tables among the parts."""
        return tuple(part for part in self.parts if not isinstance(part, str))

    @property
    def lines(self) -> tuple[str, ...]:
        """The lines among the parts."""
        return tuple(part for part in self.parts if isinstance(part, str))

    def as_data(self) -> dict[str, Any]:
        """The same for JSON: numbers of tables are numbers, and what a cell leaves out is None."""
        lines = (part for part in self.details if isinstance(part, str))
        tables = (part for part in self.details if not isinstance(part, str))
        return {
            "answer": list(self.answer),
            "numbers": [number.as_data() for number in self.numbers],
            "table": None if self.table is None else self.table.as_data(),
            "trust": self.trust,
            "warnings": list(self.warnings),
            "details": {
                "tables": [table.as_data() for table in tables],
                "lines": [line for part in lines for line in part.split("\n")],
            },
        }

    @property
    def _whole(self) -> tuple[Table | str, ...]:
        return (*(f"warning: {text}" for text in self.warnings), *self.parts)

    def __str__(self) -> str:
        return "\n".join(map(str, self._whole))

    def _repr_html_(self) -> str:
        return "".join(
            f"<p>{escape(part)}</p>" if isinstance(part, str) else part._repr_html_()
            for part in self._whole
        )


def state_name(environment: Environment) -> str:
    """Name of the state in an environment beside ``"dry"``."""
    # An environment without heat and moisture is labelled dry too.
    return "wet" if environment.label == "dry" else environment.label


def environment_lines(
    mechanism: Mechanism, environment: Environment | None, *, lengths_alone: bool = False
) -> list[str]:
    """Effects of heat and moisture on each link.

    Parameters
    ----------
    mechanism : Mechanism
        Dry, at its reference temperature.
    environment : HygrothermalState or Exposure, optional
        None where none was asked for: then there is nothing to say.
    lengths_alone : bool
        Whether to leave out how stiff and heavy the links are then.

    Returns
    -------
    list of str
        A result keeps them in its dataset as the attribute ``environment_lines``, one text
        with a line for each.

    Raises
    ------
    InputError
        If it is no environment, or as :func:`flexmech.hygrothermal.swollen_links`.
    """
    if environment is None:
        return []
    lines = [f"state: {environment_of(environment).label}"]
    for name, link in swollen_links(mechanism, environment).items():
        if lengths_alone:
            lines.append(
                f"{name}: {100 * link.elongation:+.4f} % longer, {100 * link.water:.3g} % water"
            )
            continue
        dry, kept = mechanism.sections[name], resin_retention(mechanism, name, environment)
        stiffness = link.section.bending_stiffness / dry.bending_stiffness
        mass = link.section.mass_per_length / dry.mass_per_length
        line = (
            f"{name}: {100 * link.elongation:+.4f} % longer, {100 * link.water:.3g} % water, "
            f"bending stiffness times {stiffness:.4f}, mass per length times {mass:.4f}"
        )
        if kept is not None:
            # Least and most of it, where the link is not equally moist.
            share = " to ".join(dict.fromkeys(f"{100 * part:.4g}" for part in kept))
            line += f", resin keeps {share} % of its stiffness"
        if link.section.free_curvature:
            sagitta = abs(link.section.free_curvature) * link.length**2 / 8
            line += f", bowed without load by {1e3 * sagitta:.4g} mm at its middle"
        lines.append(line)
    inert = inert_links(mechanism)
    if inert:
        lines.append(f"heat and moisture have no effect on: {', '.join(inert)} (no such keys)")
    return lines


LEFT_OUT = "loads_left_out"


def left_out_attributes(mechanism: Mechanism) -> dict[str, str]:
    """Attribute that names the loads over time; nothing where there are none.

    Parameters
    ----------
    mechanism : Mechanism

    Returns
    -------
    dict of str to str
    """
    names = [load.name for load in mechanism.loads if load.over == "time"]
    return {LEFT_OUT: ", ".join(names)} if names else {}


def left_out_warnings(attributes: Mapping[Any, Any]) -> tuple[str, ...]:
    """Warning that loads are left out, one line or none."""
    if LEFT_OUT not in attributes:
        return ()
    return (
        f"loads over time are left out here: {attributes[LEFT_OUT]}; they have no value at a crank "
        "angle, and flexmech response counts them",
    )


CHOSEN_DAMPING = "chosen_damping"


def warnings_of(attributes: Mapping[Any, Any]) -> tuple[str, ...]:
    """Warnings of a result on what it leaves out and on what was chosen for it.

    Loads over time, the frequency at which specific damping counts, and what beam theories do.
    """
    chosen = str(attributes.get(CHOSEN_DAMPING, "")).splitlines()
    return (*left_out_warnings(attributes), *chosen, *theory_warnings(attributes))


def speed_text(speed: SupportsFloat, unit: str) -> str:
    """A crank speed in rad/s, in a unit to six digits."""
    return f"{from_si(float(speed), unit):.6g}"


def speed_with_unit(dataset: xr.Dataset, speed: SupportsFloat) -> str:
    """A crank speed in rad/s, to five digits in the unit in which a result speaks of speeds."""
    unit = speed_unit(dataset)
    return f"{from_si(float(speed), unit):.5g} {unit}"


def crank_speed_text(attributes: Mapping[Any, Any]) -> str:
    """Crank speed of a result, in the unit in which it speaks of speeds."""
    unit = str(attributes["speed_unit"])
    return f"{speed_text(attributes['crank_speed'], unit)} {unit}"


def drive_words(attributes: Mapping[Any, Any]) -> str:
    """At which crank speed a result is, or under which law of motion."""
    law = attributes.get("drive")
    return f"at {crank_speed_text(attributes)}" if law is None else f"under {law}"


# Relative difference of engines below which nobody needs to act: materials and dimensions are known
# no better, and the numbers have no more digits than that leaves.
_LITTLE = 0.01


@dataclass(frozen=True)
class EngineDifference:
    """How far two engines differ in one number, and how much of it their errors explain.

    Parameters
    ----------
    apart : float
        Relative; not a number where one engine alone has the number.
    allowed : float
        Errors of both engines together, relative.
    of : str
        What differs, such as ``"peak driving torque"``; empty where all numbers are of a kind.
    left_out : str
        Which errors are not counted, in words.
    """

    apart: float
    allowed: float
    of: str = ""
    left_out: str = ""

    @classmethod
    def least_explained(
        cls,
        apart: Sequence[float] | FloatArray,
        allowed: Sequence[float] | FloatArray,
        of: Sequence[str] = (),
    ) -> EngineDifference:
        """The number of many that errors explain least.

        Parameters
        ----------
        apart, allowed : array_like, shape (N,)
        of : sequence of str, optional
            N names.
        """
        place = least_explained(apart, allowed)
        return cls(float(apart[place]), float(allowed[place]), of[place] if of else "")

    @property
    def agree(self) -> bool:
        """Whether the engines differ by no more than their errors together."""
        return self.apart <= self.allowed

    @property
    def worth_a_warning(self) -> bool:
        """Whether they differ by more than their errors explain, and by much."""
        return not self.agree and not self.apart <= _LITTLE


def least_explained(
    apart: Sequence[float] | FloatArray, allowed: Sequence[float] | FloatArray
) -> int:
    """Difference of two engines that is farthest beyond their errors; the greatest if none is.

    Parameters
    ----------
    apart, allowed : array_like, shape (N,)
        Differences, and errors of both engines together; relative.

    Returns
    -------
    int

    Examples
    --------
    >>> least_explained([0.02, 4e-4], [0.1, 3e-4]), least_explained([0.02, 4e-4], [0.1, 5e-4])
    (1, 0)
    """
    apart = np.asarray(apart)
    beyond = apart - np.asarray(allowed)
    return int(np.argmax(beyond if (beyond > 0).any() else apart))


def trust_line(
    engines: Sequence[str], error: float, difference: EngineDifference | None = None
) -> str:
    """How far the numbers of an answer are known, in one line.

    Parameters
    ----------
    engines : sequence of str
        That ran.
    error : float
        Greatest relative error of what is printed; not a number where none is estimated.
    difference : EngineDifference, optional
        Difference of two engines, where errors explain it least. Left out: where one engine ran
        alone, or where the error holds the differences that errors explain.

    Returns
    -------
    str

    Examples
    --------
    >>> trust_line(["reference", "exudyn"], 2e-5, EngineDifference(1.9e-4, 2e-4))
    'numbers are known to 0.019 %; both engines agree within 0.019 %'
    >>> trust_line(["reference", "exudyn"], 2e-5, EngineDifference(0.02, 3e-5))
    'reference and exudyn differ by 2 %, more than their errors of 0.003 % explain'
    >>> trust_line(["reference"], 2e-5)
    'numbers are known to 0.002 %; the reference engine alone ran'
    """
    apart = math.nan if difference is None else difference.apart
    # A difference of one quantity, such as a torque over time, is no error of the others.
    counts = difference is not None and not difference.of and math.isfinite(apart)
    greatest = max(error, apart) if counts else error
    known = f"numbers are known to {percent(greatest)}"
    if difference is not None and not difference.agree:
        said = f"{' and '.join(engines)} differ{_by(difference)}"
        return said if difference.worth_a_warning else f"{known}; {said}"
    if not math.isfinite(greatest):
        known = "errors of the numbers are not estimated"
    if len(engines) == 1:
        return f"{known}; the {engines[0]} engine alone ran"
    within = "" if difference is None else f" within {percent(apart)}{_where(difference)}"
    return f"{known}; both engines agree{within}"


def _by(difference: EngineDifference) -> str:
    if not math.isfinite(difference.apart):
        return " by more than their errors explain"
    apart, allowed = percent(difference.apart), percent(difference.allowed)
    beyond = f", which leave out {difference.left_out}" if difference.left_out else ""
    return f" by {apart}{_where(difference)}, more than their errors of {allowed} explain{beyond}"


def _where(difference: EngineDifference) -> str:
    return f" in the {difference.of}" if difference.of else ""
