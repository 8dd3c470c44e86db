"""What Elamy et al. 2023 print of their composite crank-rockers (Tables 2 to 6)."""

from __future__ import annotations

import io
import tomllib
from importlib import resources
from typing import Any

import pandas as pd
import xarray as xr

from flexmech.linkages import FourBar


def stored_text(name: str) -> str:
    """Text of a file that comes with the study."""
    folder = resources.files("flexmech.studies.composite_crank_rockers") / "data"
    return folder.joinpath(name).read_text(encoding="utf-8")


def stored_table(name: str) -> dict[str, Any]:
    """What a TOML file says that comes with the study."""
    return tomllib.loads(stored_text(name))


_PUBLISHED = stored_table("published.toml")

LAMINATES: dict[str, dict[str, Any]] = _PUBLISHED["laminates"]
"""Table 2: stack, modulus in GPa, Poisson's ratio and density in kg/m^3 of each laminate."""

CASES: dict[int, list[float]] = {int(case): row for case, row in _PUBLISHED["cases"].items()}
"""Table 3: crank, coupler and rocker over the ground."""

POSITIONS: dict[str, str] = _PUBLISHED["positions"]
"""Of the transmission angle, each in words."""


def published_case(case: int, ground: float = 1.0) -> FourBar:
    """Linkage of Table 3 with a ground of the given length in m."""
    crank, coupler, rocker = CASES[case]
    return FourBar(ground, ground * crank, ground * coupler, ground * rocker)


def published_tables() -> xr.Dataset:
    """Tables 4 to 6.

    Returns
    -------
    xarray.Dataset
        ``finite_element`` and ``measured`` fundamental frequency in Hz and ``damping``
        factor, over ``position``, ``laminate`` and ``case``.

    Examples
    --------
    >>> tables = flexmech.studies.published_tables()
    >>> tables["finite_element"].sel(position="90", case=2).values
    array([99.34, 82.45, 70.08, 57.47, 47.7 , 38.34])
    """
    rows = pd.read_csv(io.StringIO(stored_text("frequencies.csv")), comment="#")
    order = {"position": list(POSITIONS), "laminate": list(LAMINATES), "case": list(CASES)}
    tables: xr.Dataset = rows.set_index(list(order)).to_xarray()
    return tables.sel(order).assign_coords(order)
