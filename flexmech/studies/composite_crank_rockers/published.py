"""What Elamy et al. 2023 print of their composite crank-rockers (Tables 2 to 6)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from importlib import resources

import pandas as pd
import xarray as xr

from flexmech.linkages import FourBar

__all__ = [
    "CASES",
    "LAMINATES",
    "POSITIONS",
    "PublishedLaminate",
    "published_case",
    "published_tables",
]


@dataclass(frozen=True)
class PublishedLaminate:
    """A row of Table 2, its two headers put right (they are swapped in print).

    Parameters
    ----------
    stack : str
        Carbon and glass plies.
    youngs_modulus : float
        In Pa.
    poisson_ratio : float
    density : float
        In kg/m^3.
    """

    stack: str
    youngs_modulus: float
    poisson_ratio: float
    density: float


LAMINATES = {
    "C1": PublishedLaminate("[C/C/C/C/C]", 99.73e9, 0.27, 1538.0),
    "C2": PublishedLaminate("[C/C/G/C/C]", 92.24e9, 0.27, 1640.0),
    "C3": PublishedLaminate("[C/G/C/G/C]", 84.25e9, 0.26, 1742.0),
    "C4": PublishedLaminate("[G/C/G/C/G]", 73.32e9, 0.26, 1844.0),
    "C5": PublishedLaminate("[G/G/C/G/G]", 66.60e9, 0.25, 1946.0),
    "C6": PublishedLaminate("[G/G/G/G/G]", 62.61e9, 0.25, 2048.0),
}
"""Table 2."""

CASES = {1: (0.27, 0.83, 0.67), 2: (0.42, 1.00, 0.79), 3: (0.14, 0.90, 0.46), 4: (0.21, 0.91, 0.46)}
"""Table 3: crank, coupler and rocker over the ground."""

POSITIONS = ("min", "90", "max")
"""Of the transmission angle: crank at 0 deg, a right angle, crank at 180 deg."""


def published_case(case: int, ground: float = 1.0) -> FourBar:
    """Linkage of Table 3 with a ground of the given length in m."""
    crank, coupler, rocker = CASES[case]
    return FourBar(ground, ground * crank, ground * coupler, ground * rocker)


@lru_cache
def published_tables() -> xr.Dataset:
    """Tables 4 to 6.

    Returns
    -------
    xarray.Dataset
        ``finite_element`` and ``measured`` fundamental frequency in Hz and ``damping``
        factor, over ``position``, ``laminate`` and ``case``.
    """
    table = resources.files("flexmech.studies") / "composite_crank_rockers/data/frequencies.csv"
    dims = ["position", "laminate", "case"]
    with table.open(encoding="utf-8") as stream:
        rows = pd.read_csv(stream, comment="#", dtype={"position": str})
    tables: xr.Dataset = rows.set_index(dims).to_xarray()
    order = {"position": list(POSITIONS), "laminate": list(LAMINATES), "case": list(CASES)}
    return tables.sel(order).assign_coords(order)
