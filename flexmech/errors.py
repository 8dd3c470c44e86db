"""The two kinds of failure that a user can meet, each with one clear message."""

from __future__ import annotations

import difflib
import unicodedata
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Self

from flexmech.unit_registry import from_si

CRANK_SPEED = "{crank_speed}"
"""Where a message names the crank speed of its error, in the unit that the user prefers."""

_MOST_CHARACTERS = 4000
"""Most characters of a message: a screen full."""
_MOST_TYPED = 100
"""Characters of a wrong word that are compared, for speed alone: no name is longer."""
_MOST_NEAR = 5
"""Words that share most letters with a wrong one, among which the fewest slips decide; of units
of one kind there are no more."""
_FAST = 100.0
"""In rad/s: crank speeds above it, 955 rpm and up, are printed in turns a minute as well."""
# Categories of characters that move a terminal's cursor, break a line, or turn the direction of
# writing.
_UNSEEN = ("Cc", "Cf", "Cs", "Zl", "Zp")
_BLANKS = str.maketrans("\n\r\t", "   ")


class FlexmechError(Exception):
    """Base of every error that flexmech raises on purpose.

    Parameters
    ----------
    message : str
        What is wrong (file, key or crank angle) and the remedy. The literal ``{crank_speed}`` in
        it stands for the crank speed, where one is given. It is printed in one line, see
        :func:`one_line`.
    crank_speed : float, optional
        In rad/s.

    Examples
    --------
    >>> error = FlexmechError("no equilibrium at {crank_speed}", crank_speed=20.0)
    >>> str(error)
    'no equilibrium at 20 rad/s'
    >>> error.in_unit("rpm")
    'no equilibrium at 190.986 rpm'
    """

    exit_code = 1

    def __init__(self, message: str, *, crank_speed: float | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.crank_speed = crank_speed

    def __str__(self) -> str:
        return self.in_unit("rad/s")

    def in_unit(self, unit: str) -> str:
        """Write the message with its crank speed in a unit, such as ``"rpm"``."""
        message = one_line(self.message)
        if self.crank_speed is None:
            return message
        speed = f"{from_si(self.crank_speed, unit):.6g} {unit}"
        if unit == "rad/s" and abs(self.crank_speed) >= _FAST:
            # Somebody who meant turns a minute sees it here.
            speed += f" ({from_si(self.crank_speed, 'rpm'):.5g} rpm)"
        return message.replace(CRANK_SPEED, speed)

    def within(self, place: str) -> Self:
        """The same failure with the place where it happened in front: a file, key or option."""
        return type(self)(f"{place}: {self.message}", crank_speed=self.crank_speed)


class InputError(FlexmechError, ValueError):
    """Invalid input: a wrong file, value, option or geometry."""

    exit_code = 2


class AssemblyError(InputError):
    """The links do not reach each other at a crank angle, or at any."""


class LockingError(InputError):
    """The crank cannot drive the linkage through a crank angle."""


class ComputationError(FlexmechError, RuntimeError):
    """A computation that failed on valid input."""


def missing_extra(use: str, package: str, extra: str, otherwise: str = "") -> InputError:
    """Error of an optional package that is not installed, with the command that installs it.

    Parameters
    ----------
    use, package, extra : str
        The feature, the package that it needs, and the extra of flexmech that brings it.
    otherwise : str
        What to do without it.

    Returns
    -------
    InputError

    Examples
    --------
    >>> print(missing_extra("a report", "plotly", "report"))
    a report needs plotly: in the clone of flexmech run pip install -e ".[report]"
    """
    remedy = f", or {otherwise}" if otherwise else ""
    return InputError(
        f'{use} needs {package}: in the clone of flexmech run pip install -e ".[{extra}]"{remedy}'
    )


@contextmanager
def naming(option: str) -> Iterator[None]:
    """Put the name of an option in front of the message where its value is refused."""
    try:
        yield
    except InputError as error:
        raise error.within(option) from error


def one_line(text: str, most: int = _MOST_CHARACTERS) -> str:
    r"""Write a text so that a terminal shows it in one line, whatever a user's file has in it.

    Parameters
    ----------
    text : str
    most : int
        Characters: of a longer text the middle is left out.

    Returns
    -------
    str
        Control characters as Python writes them.

    Examples
    --------
    >>> one_line("a red\x1b[31m name")
    'a red\\x1b[31m name'
    """
    if len(text) > most:
        text = f"{text[: 2 * most // 3]} [...] {text[-most // 3 :]}"
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        ascii(character)[1:-1] if unicodedata.category(character) in _UNSEEN else character
        for character in text
    )


def is_plain(text: str) -> bool:
    """Whether a text has no characters that are not seen, but line breaks and tabulators."""
    plain = text.translate(_BLANKS)
    return one_line(plain, len(plain)) == plain


def suggestion(got: str, known: Sequence[str]) -> str:
    """Word the remedy for a wrong name: the nearest known one, and all of them."""
    close = nearest(got, known)
    choices = ", ".join(known)
    return f"did you mean {close!r}? Known here: {choices}" if close else f"use one of {choices}"


def nearest(got: str, known: Sequence[str]) -> str:
    """The known word that is nearest to what was typed; empty where none is near.

    It is the word with the fewest slips of the keyboard, among those that have most letters in
    common with what was typed.

    Parameters
    ----------
    got : str
    known : sequence of str

    Returns
    -------
    str

    Examples
    --------
    >>> nearest("rmp", ["rad/s", "rps", "rpm"])
    'rpm'
    """
    got = got[:_MOST_TYPED]
    close = difflib.get_close_matches(got, known, n=_MOST_NEAR)
    return min(close, key=lambda word: slips(got, word), default="")


def slips(first: str, second: str) -> int:
    """Letters to insert, leave out, replace, or swap with the next, to make one word of another.

    Damerau, Communications of the ACM 7, 1964, 171-176: a swap counts as one slip.

    Parameters
    ----------
    first, second : str

    Returns
    -------
    int

    Examples
    --------
    >>> slips("rmp", "rpm"), slips("rmp", "rps")
    (1, 2)
    """
    before, last = [0] * (len(second) + 1), list(range(len(second) + 1))
    for i, one in enumerate(first, start=1):
        row = [i]
        for j, other in enumerate(second, start=1):
            row.append(min(last[j] + 1, row[-1] + 1, last[j - 1] + (one != other)))
            if i > 1 and j > 1 and (one, first[i - 2]) == (second[j - 2], other):
                row[-1] = min(row[-1], before[j - 2] + 1)
        before, last = last, row
    return last[-1]


def known_words(text: str, known: Sequence[str], wrong: str, example: str = "") -> tuple[str, ...]:
    """Read a comma list of known words.

    Parameters
    ----------
    text : str
    known : sequence of str
    wrong : str
        The known words, for messages about an unknown one.
    example : str
        End of messages.

    Returns
    -------
    tuple of str
        In the order of those that are known.

    Raises
    ------
    InputError
        If a word is not known.
    """
    asked = [each.strip().lower().removeprefix(".") for each in text.split(",")]
    for each in asked:
        if each not in known:
            raise InputError(
                f"got {text!r}, in which {each!r} is no {wrong}; choose from "
                f"{', '.join(known)}{example}"
            )
    return tuple(word for word in known if word in asked)
