"""The linkages that are computed: their model files, models of plies and beams, and positions.

The paper prints no link size. One is assumed, in the model files that are filled in here, and
only ratios are compared. Of each linkage several models are computed, since the paper leaves
open which one is meant: three of the plies, two of the way they lie, three of the beams, two of
the joints.
"""

from __future__ import annotations

import io
import tomllib
from dataclasses import replace
from functools import lru_cache
from importlib import resources
from itertools import product
from typing import Any, Literal, get_args

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import FourBar, JointSpring, continuous_angles
from flexmech.mechanism import Mechanism
from flexmech.modelfile import mechanism_from_toml
from flexmech.sections import LayerDirection
from flexmech.validation import check_choice


def stored_text(name: str) -> str:
    """Text of a file that comes with the study."""
    folder = resources.files("flexmech.studies.composite_crank_rockers") / "data"
    return folder.joinpath(name).read_text(encoding="utf-8")


def stored_table(name: str) -> dict[str, Any]:
    """What a TOML file says that comes with the study."""
    return tomllib.loads(stored_text(name))


_PUBLISHED = stored_table("published.toml")

# Table 2: stack, modulus in GPa, Poisson's ratio, density in kg/m^3 and strength in MPa.
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


PlyModel = Literal["woven", "unidirectional", "table 2"]
# Plies by the rule of mixtures, as balanced fabric (the paper's, in its words) or straight; one
# modulus and density a laminate, of its Table 2. With each the end of its model files' names.
PLY_MODELS: dict[PlyModel, str] = {
    "woven": "_woven",
    "unidirectional": "_unidirectional",
    "table 2": "_table_2",
}
# Which way the plies lie, the paper's first: its links are cut from flat sheets (section 4), so
# that bending in the plane of motion bends each ply in its own plane. What a model file says of it.
LAYERS: dict[LayerDirection, str] = {
    "across width": """Plies lie parallel to the plane of motion, as in links that are
cut from a flat sheet: five of {ply_thickness:g} mm make the width.""",
    "through thickness": """Plies are stacked in the plane of motion: five of {ply_thickness:g} mm
make the thickness.""",
}

CONVERGED, PAPERS_MESH, THIRD_ORDER = "converged", "one element a link", "third order"
# Elements a link and their kind: bending converged, as in the paper, and with shear by the
# third-order theory of its section 3.1.
BEAMS = {CONVERGED: (8, "euler"), PAPERS_MESH: (1, "euler"), THIRD_ORDER: (8, "reddy")}

Supports = Literal["clamped crank", "rigid joints", "pinned crank"]
SUPPORTS: tuple[Supports, ...] = get_args(Supports)
# A joint's spring against turning over EI / L of the coupler, with which it is as good as a weld:
# ten times more changes no frequency by a ten-thousandth.
WELD = 1e5

# The other position with a right transmission angle, beside those that the paper compares.
SECOND = "90, second crank angle"

# In m, assumed: of this size all links, the short cranks too, are slender enough for beams.
_GROUND, THICKNESS, WIDTH, _PLIES = 0.4, 5e-3, 25e-3, 5


def each_model() -> list[tuple[PlyModel, LayerDirection]]:
    """Models of plies and which way they lie; one material a laminate lies no way: once."""
    return [
        (plies, layers)
        for plies, layers in product(PLY_MODELS, LAYERS)
        if plies != "table 2" or layers == next(iter(LAYERS))
    ]


def composite_model_file(
    case: int,
    laminate: str,
    plies: PlyModel = "woven",
    layers: LayerDirection = "across width",
    *,
    in_plane_thickness: float = THICKNESS,
) -> str:
    """Model file of one linkage of the paper, with the link size that is assumed.

    Parameters
    ----------
    case : int
        1 to 4, of Table 3.
    laminate : str
        C1 to C6, of Table 2.
    plies : {"woven", "unidirectional", "table 2"}
    layers : {"across width", "through thickness"}
        Whether the plies lie parallel to the plane of motion, as in links cut from a flat sheet,
        or are stacked in it; without meaning for ``"table 2"``.
    in_plane_thickness : float
        Of the links, in m, whichever way the plies lie.

    Returns
    -------
    str
        TOML.

    Raises
    ------
    InputError
        If plies or layers are unknown.
    """
    check_choice(plies, tuple(PLY_MODELS), "plies")
    check_choice(layers, tuple(LAYERS), "layers")
    lengths = published_case(case, _GROUND).lengths
    name = "crank_rocker_table_2.toml" if plies == "table 2" else "crank_rocker.toml"
    thickness, width = (f"{1e3 * size:g} mm" for size in (in_plane_thickness, WIDTH))
    across = layers == "across width"
    ply_thickness = 1e3 * (WIDTH if across else in_plane_thickness) / _PLIES
    return stored_text(name).format(
        case=case,
        laminate=laminate,
        weave=plies,
        layers=layers,
        orientation=LAYERS[layers].format(ply_thickness=ply_thickness),
        ply_thickness=ply_thickness,
        thickness=1e3 * in_plane_thickness,
        extent=f'in_plane_thickness = "{thickness}"'
        if across
        else f'out_of_plane_width = "{width}"',
        **LAMINATES[laminate],
        **{link: 1e3 * length for link, length in lengths.items()},
    )


def composite_model_files() -> dict[str, str]:
    """Text of the model file of every linkage, as ``case_2_C3_woven_across_width.toml``."""
    return {
        f"case_{case}_{laminate}{_ending(plies, layers)}.toml": composite_model_file(
            case, laminate, plies, layers
        )
        for plies, layers in each_model()
        for case in CASES
        for laminate in LAMINATES
    }


def _ending(plies: PlyModel, layers: LayerDirection) -> str:
    return PLY_MODELS[plies] + ("" if plies == "table 2" else f"_{layers.replace(' ', '_')}")


def composite_crank_rocker(
    case: int,
    laminate: str,
    plies: PlyModel = "woven",
    layers: LayerDirection = "across width",
    *,
    in_plane_thickness: float = THICKNESS,
    supports: Supports = "clamped crank",
    crank_angle: float | None = None,
) -> Mechanism:
    """One linkage of the paper.

    Parameters
    ----------
    case : int
    laminate : str
    plies : {"woven", "unidirectional", "table 2"}
        See :data:`PLY_MODELS`.
    layers : {"across width", "through thickness"}
        See :data:`LAYERS`.
    in_plane_thickness : float
        In m; the ground is 0.4 m long.
    supports : {"clamped crank", "rigid joints", "pinned crank"}
        Crank clamped and links hinged to each other; or besides held against turning at A and B,
        by springs as stiff as welds, which the linkage has at one crank angle alone. The paper's
        own boundary conditions, a crank that is pinned and links that are hinged, are refused.
    crank_angle : float, optional
        At which the joints are made rigid, in rad; only rigid joints have one.

    Returns
    -------
    Mechanism

    Raises
    ------
    InputError
        If plies, layers or supports are unknown, a crank is to be pinned, or rigid joints have no
        crank angle, or others have one.

    Examples
    --------
    >>> welded = flexmech.studies.composite_crank_rocker(
    ...     1, "C3", supports="rigid joints", crank_angle=np.pi
    ... )
    >>> [spring.joint for spring in welded.joint_springs]
    ['A', 'B']
    """
    check_choice(supports, SUPPORTS, "supports")
    if supports == "pinned crank":
        raise InputError(
            'supports = "pinned crank": with all links hinged and the crank free to turn the '
            "linkage is a mechanism, which moves without strain: its first natural frequency is "
            'zero; choose "clamped crank" or "rigid joints"'
        )
    text = composite_model_file(
        case, laminate, plies, layers, in_plane_thickness=in_plane_thickness
    )
    mechanism = _read(text)
    rigid = supports == "rigid joints"
    if rigid is (crank_angle is None):
        remedy = (
            "give the crank_angle at which the joints are made rigid"
            if rigid
            else "leave out crank_angle: hinged links have none"
        )
        raise InputError(f'supports = "{supports}": {remedy}')
    return mechanism if crank_angle is None else with_rigid_joints(mechanism, crank_angle)


@lru_cache(maxsize=256)
def _read(text: str) -> Mechanism:
    """Mechanism of a model file, which the study reads for several questions."""
    return mechanism_from_toml(text)


def with_rigid_joints(
    mechanism: Mechanism, crank_angle: float, relative_stiffness: float = WELD
) -> Mechanism:
    """The linkage with its links held against turning at A and B.

    Parameters
    ----------
    mechanism : Mechanism
        Of a four-bar.
    crank_angle : float
        At which the joints have no torque, in rad.
    relative_stiffness : float
        Of the joints, over EI / L of the coupler.

    Returns
    -------
    Mechanism
    """
    linkage, topology = mechanism.linkage, mechanism.linkage.topology
    at = linkage.motion(np.array([crank_angle]), 0.0)
    angles = continuous_angles(linkage, at)
    length = topology.links[topology.index("coupler")].length
    stiffness = relative_stiffness * mechanism.sections["coupler"].bending_stiffness / length
    return replace(
        mechanism,
        joint_springs=tuple(
            JointSpring(
                pin.joint,
                torsional_stiffness=stiffness,
                free_angle=float(topology.joint_angle(pin.joint, angles)[0]),
            )
            for pin in topology.pins
        ),
    )


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
