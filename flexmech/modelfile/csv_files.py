"""Lines of CSV files that a model file names, and numbers in them."""

from __future__ import annotations

import csv
import re
from pathlib import Path

from flexmech.errors import InputError
from flexmech.files import bytes_of
from flexmech.units import NUMBER

# Most bytes of a file of a load or a drive: a hundred thousand rows, a thousand times as fine as a
# turn asks for.
MOST_BYTES = 10_000_000
# Characters of a cell in a message: more than any number has.
MOST_SHOWN = 60


def csv_lines(path: Path, shown: str, what: str) -> tuple[list[str], list[list[str]]]:
    """Titles and rows of a CSV file, in fields, without empty rows at its end.

    Parameters
    ----------
    path : Path
    shown : str
        What messages call it.
    what : str
        What it is a table of.

    Returns
    -------
    list of str
        Without spaces around them; empty of an empty file.
    list of list of str

    Raises
    ------
    InputError
        If the file is too large, cannot be read, or is no CSV text in UTF-8.
    """
    try:
        content = bytes_of(path, f"file {shown}", f"the table of a {what}", MOST_BYTES)
        text = content.decode("utf-8-sig")
        titles, *rows = [*csv.reader(text.rstrip().splitlines(), strict=True)] or [[]]
    except UnicodeDecodeError as error:
        raise InputError(f"file {shown}: is no text in UTF-8; save it as CSV in UTF-8") from error
    except InputError:
        raise
    except (OSError, ValueError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"file {shown}: cannot be read: {reason}; give a CSV file") from error
    return [title.strip() for title in titles], rows


def check_rows(rows: list[list[str]], titles: list[str], shown: str) -> None:
    """Refuse rows that are no numbers, as many as there are titles, and a file without any.

    Parameters
    ----------
    rows : list of list of str
    titles : list of str
        Titles of the first line.
    shown : str
        What messages call the file.

    Raises
    ------
    InputError
        Names the line.
    """
    if not rows:
        raise InputError(f"file {shown}: there is no row below its first line; give at least one")
    for number, row in enumerate(rows, start=2):
        where = f"file {shown}: line {number}"
        if len(row) != len(titles):
            raise InputError(f"{where} has {len(row)} fields, the first line {len(titles)}")
        wrong = next((c for c in row if not re.fullmatch(NUMBER, c.strip())), None)
        if wrong is not None:
            raise InputError(
                f"{where} has {wrong[:MOST_SHOWN]!r}, which is no number; write numbers such as "
                "12.5 or 2e-5, with a decimal point"
            )
