"""Tables as text of CSV files, in which a spreadsheet finds no formula."""

from __future__ import annotations

import re

import pandas as pd

from flexmech.units import NUMBER

# What spreadsheets take for the beginning of a formula, where a number does not follow.
_FORMULA = re.compile(rf"(?!{NUMBER}$)[=+\-@\t\r].", re.DOTALL)


def csv_text(table: pd.DataFrame, form: str) -> str:
    r"""A table as CSV, names that would be formulas in a spreadsheet behind an apostrophe.

    Parameters
    ----------
    table : pandas.DataFrame
    form : str
        Format of its numbers, such as ``"%.10g"``.

    Returns
    -------
    str

    Examples
    --------
    >>> csv_text(pd.DataFrame({"link": ["=HYPERLINK(1)", "rod"], "mm": [1.5, -2.0]}), "%.3g")
    "link,mm\n'=HYPERLINK(1),1.5\nrod,-2\n"
    """
    written = table.rename(columns=_plain)
    for name in written.columns:
        if pd.api.types.is_numeric_dtype(written[name]):
            continue
        names = [own for own in written[name].unique() if isinstance(own, str)]
        if any(_plain(own) != own for own in names):
            written[name] = written[name].map(_plain)
    return str(written.to_csv(index=False, float_format=form, lineterminator="\n"))


def _plain(text: object) -> object:
    return f"'{text}" if isinstance(text, str) and _FORMULA.match(text) else text
