"""Several quantities of one text: comma lists and ranges, each with one unit or several."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

from flexmech.errors import InputError
from flexmech.units import Dimension, finite_value, shown, split_quantity, unit_factor

# A range hits its end when it comes this close, in steps: 0:1:0.333333 means thirds.
_HIT = Decimal("1e-5")


@dataclass(frozen=True)
class Quantities:
    """Several quantities of one text.

    Parameters
    ----------
    values : tuple of float
        In SI units.
    unit : str
        In which they were written, the last one of several.
    numbers : tuple of float
        The same values in that unit.
    """

    values: tuple[float, ...]
    unit: str
    numbers: tuple[float, ...]


def parse_quantities(
    text: str, dimension: Dimension, default_unit: str, *, most: int = 10_000
) -> Quantities:
    """Read quantities from a comma list of numbers and of ranges START:STOP:STEP.

    A unit that only the last entry has covers all of them: "0,50,100 rpm". Otherwise each entry
    other than 0 has its own.

    Parameters
    ----------
    text : str
        Such as ``"0,50,100 rpm"``, ``"0:300:50 rpm"``, ``"10 rad/s,300 rpm"`` or
        ``"10:170:10,190:350:10"``.
    dimension : Dimension
        Without a zero of its own: no temperature.
    default_unit : str
        Where no unit is written.
    most : int
        Longer ranges are taken for a slip of the keyboard.

    Returns
    -------
    Quantities
        In the order of the text. STOP is included when a whole number of steps leads to it.
        Counted in decimal, so that nothing adds up: 0:360:0.1 ends with 359.9 and 360 exactly.

    Raises
    ------
    InputError
        If a value is missing or no such quantity, the range is empty, endless or too long, or
        some entries have a unit and others have none.
    """
    pieces = [piece.split(":") for piece in text.split(",")]
    for parts in pieces:
        if len(parts) not in (1, 3):
            raise InputError(
                f"got {shown(text)}, which has {len(parts)} parts; write START:STOP:STEP, for "
                f'example "0:300:50 {default_unit}"'
            )
    if not all(part.strip() for parts in pieces for part in parts):
        raise InputError(
            f"got {shown(text)}, in which a value is missing; write START:STOP:STEP, for example "
            f'"0:300:50 {default_unit}", or a comma list such as "0,50,100 {default_unit}"'
        )
    entries = [[split_quantity(part.strip(), dimension) for part in parts] for parts in pieces]
    unit = _unit_of_bare(text, entries) or default_unit
    numbers: list[Decimal] = []
    factors: list[Decimal] = []
    for piece in entries:
        # A range is converted in its last unit, which all three numbers usually have.
        given = [unit_factor(text, own or unit, dimension) for _, own in piece]
        same = [
            number * (factor / given[-1]) for (number, _), factor in zip(piece, given, strict=True)
        ]
        numbers += _counted(text, *same, most=most) if len(same) > 1 else same
        if len(numbers) > most and len(same) > 1:
            raise _too_long(text, most)
        factors += [given[-1]] * (len(numbers) - len(factors))
    pairs, own = list(zip(numbers, factors, strict=True)), unit_factor(text, unit, dimension)
    return Quantities(
        tuple(finite_value(number, factor, text) for number, factor in pairs),
        unit,
        # Whole where that is the unit that they were written in.
        tuple(finite_value(n, Decimal(1) if of == own else of / own, text) for n, of in pairs),
    )


def _unit_of_bare(text: str, pieces: Sequence[Sequence[tuple[Decimal, str]]]) -> str:
    """Unit of the entries that have none: the last one that is written; empty if there is none."""
    entries = [entry for piece in pieces for entry in piece]
    written = [unit for _, unit in entries if unit]
    covers_all = len(written) == 1 and entries[-1][1] != ""
    if written and not covers_all and any(number and not unit for number, unit in entries):
        bare = ",".join(":".join(str(number) for number, _ in piece) for piece in pieces)
        remedy = f'write the unit once, at the end: "{bare} {written[-1]}"'
        raise InputError(
            f"got {shown(text)}, in which some values have a unit and others have none; "
            + (remedy if len(set(written)) == 1 else "give each value its unit")
        )
    return written[-1] if written else ""


def _counted(
    text: str, start: Decimal, stop: Decimal, step: Decimal, *, most: int
) -> list[Decimal]:
    """Count the numbers of a range."""
    if step <= 0:
        raise InputError(f"got {shown(text)}; STEP must be positive, for example 0:360:5")
    if stop < start:
        raise InputError(
            f"got {shown(text)}; STOP must not be less than START, for example -90:90:5"
        )
    if (stop - start) >= most * step:
        raise _too_long(text, most)
    steps = (stop - start) / step
    count = int(steps + _HIT)
    numbers = [start + number * step for number in range(count + 1)]
    if abs(steps - count) <= _HIT:
        numbers[-1] = stop
    return numbers


def _too_long(text: str, most: int) -> InputError:
    return InputError(
        f"got {shown(text)}, which is too long; choose a STEP that gives at most {most} values"
    )


def parse_counts(text: str) -> tuple[int, ...]:
    """Read whole numbers of one or more with commas between them, such as ``"1,4,4"``.

    Parameters
    ----------
    text : str

    Returns
    -------
    tuple of int

    Raises
    ------
    InputError
        If it is anything else, or one has more than four digits.
    """
    return _whole_numbers(text, "the elements of each link", "1,4,4")


def parse_modes(text: str) -> tuple[int, ...]:
    """Read numbers of modes with commas between them, such as ``"1,2"``.

    Parameters
    ----------
    text : str

    Returns
    -------
    tuple of int

    Raises
    ------
    InputError
        If it is anything else, or one has more than four digits.
    """
    return _whole_numbers(text, "modes, counted from 1", "1,2")


def _whole_numbers(text: str, what: str, example: str) -> tuple[int, ...]:
    counts = [part.strip() for part in text.split(",")]
    if not all(re.fullmatch(r"0*[1-9][0-9]{0,3}", count, re.ASCII) for count in counts):
        raise InputError(
            f"got {text!r}; give {what}, whole numbers of one or "
            f"more with commas between them, for example {example}"
        )
    return tuple(map(int, counts))
