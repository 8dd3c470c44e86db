"""The linkages that are computed: their model files, models of plies and beams, and positions.

The paper prints no link size. One is assumed, in the model files that are filled in here, and
only ratios are compared. Of each linkage several models are computed, since the paper leaves
open which one is meant: three of the plies, three of the beams.
"""

from __future__ import annotations

import io
import tomllib
from importlib import resources
from typing import Any, Literal

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.arrays import FloatArray
from flexmech.linkages import FourBar
from flexmech.mechanism import Mechanism
from flexmech.modelfile import mechanism_from_toml


def stored_text(name: str) -> str:
    """Text of a file that comes with the study."""
    folder = resources.files("flexmech.studies.composite_crank_rockers") / "data"
    return folder.joinpath(name).read_text(encoding="utf-8")


def stored_table(name: str) -> dict[str, Any]:
    """What a TOML file says that comes with the study."""
    return tomllib.loads(stored_text(name))


_PUBLISHED = stored_table("published.toml")

# Table 2: stack, modulus in GPa, Poisson's ratio and density in kg/m^3 of each laminate.
LAMINATES: dict[str, dict[str, Any]] = _PUBLISHED["laminates"]

# Table 3: crank, coupler and rocker over the ground.
CASES: dict[int, list[float]] = {int(case): row for case, row in _PUBLISHED["cases"].items()}

# Of the transmission angle, each in words.
POSITIONS: dict[str, str] = _PUBLISHED["positions"]


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


PlyModel = Literal["unidirectional", "woven", "table 2"]
# Plies by the rule of mixtures, straight or as balanced fabric (the paper's, in its words); one
# modulus and density a laminate, of its Table 2. With each the end of its model files' names.
PLY_MODELS: dict[PlyModel, str] = {"unidirectional": "", "woven": "_woven", "table 2": "_table_2"}

CONVERGED, PAPERS_MESH, WITH_SHEAR = "converged", "one element a link", "with shear"
# Elements a link and their kind: bending converged, as in the paper, and with shear.
BEAMS = {CONVERGED: (8, "euler"), PAPERS_MESH: (1, "euler"), WITH_SHEAR: (8, "timoshenko")}

# The other position with a right transmission angle, beside those that the paper compares.
SECOND = "90, second crank angle"

# In m, assumed: of this size all links, the short cranks too, are slender enough for beams.
_GROUND, _PLY_THICKNESS = 0.4, 1e-3


def composite_model_file(
    case: int,
    laminate: str,
    plies: PlyModel = "unidirectional",
    ply_thickness: float = _PLY_THICKNESS,
) -> str:
    """Model file of one linkage of the paper, with the link size that is assumed.

    Parameters
    ----------
    case : int
        1 to 4, of Table 3.
    laminate : str
        C1 to C6, of Table 2.
    plies : {"unidirectional", "woven", "table 2"}
    ply_thickness : float
        Of each of the five plies, in m.

    Returns
    -------
    str
        TOML.
    """
    lengths = published_case(case, _GROUND).lengths
    name = "crank_rocker_table_2.toml" if plies == "table 2" else "crank_rocker.toml"
    return stored_text(name).format(
        case=case,
        laminate=laminate,
        weave=plies,
        ply_thickness=1e3 * ply_thickness,
        thickness=5e3 * ply_thickness,
        **LAMINATES[laminate],
        **{link: 1e3 * length for link, length in lengths.items()},
    )


def composite_model_files() -> dict[str, str]:
    """Text of the model file of every linkage, by names such as ``case_2_C3_woven.toml``."""
    return {
        f"case_{case}_{laminate}{ending}.toml": composite_model_file(case, laminate, plies)
        for plies, ending in PLY_MODELS.items()
        for case in CASES
        for laminate in LAMINATES
    }


def composite_crank_rocker(
    case: int, laminate: str, plies: PlyModel, ply_thickness: float = _PLY_THICKNESS
) -> Mechanism:
    """One linkage of the paper.

    Parameters
    ----------
    case : int
    laminate : str
    plies : {"unidirectional", "woven", "table 2"}
        See :data:`PLY_MODELS`.
    ply_thickness : float
        In m; the ground is 0.4 m long.

    Returns
    -------
    Mechanism
    """
    return mechanism_from_toml(composite_model_file(case, laminate, plies, ply_thickness))


def position_angles(linkage: FourBar) -> FloatArray:
    """Crank angles of the positions compared, and of the other one at a right angle, (4,).

    Elamy et al. 2023, eqs. 1-3: least transmission angle, 90 degrees, greatest; in rad. The
    crank passes two positions with 90 degrees, and the paper does not say which one it takes:
    the first one, below 180 degrees, stands for it here, and the other one last.
    """
    ground, crank, coupler, rocker = linkage.lengths.values()
    cosine = (ground**2 + crank**2 - coupler**2 - rocker**2) / (2 * ground * crank)
    right = float(np.arccos(cosine))
    return np.array([0.0, right, np.pi, 2 * np.pi - right])
