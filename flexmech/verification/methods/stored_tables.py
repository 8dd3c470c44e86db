"""Tables of numbers by others that come with flexmech."""

from __future__ import annotations

import io
from importlib import resources

import pandas as pd


def stored_table(name: str) -> pd.DataFrame:
    """Table of the verification's data.

    Parameters
    ----------
    name : str
        Name of its file without the ending; comments there name the source.

    Returns
    -------
    pandas.DataFrame
    """
    folder = resources.files("flexmech.verification") / "data"
    text = folder.joinpath(f"{name}.csv").read_text(encoding="utf-8")
    return pd.read_csv(io.StringIO(text), comment="#")
