"""Composite crank-rockers of Elamy et al. 2023: what is printed, model files, and positions.

The paper prints no link size. One is assumed, in the model files that are filled in here, and
only ratios are compared. It leaves open how plies are made and lie: three models of plies and
two of the way they lie are computed.
"""

from __future__ import annotations

import tomllib
from collections.abc import Hashable
from dataclasses import replace
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import FourBar, JointSpring, Mechanism
from flexmech.arrays import FloatArray
from flexmech.linkages import continuous_angles
from flexmech.modelfile import mechanism_from_toml

DATA = Path(__file__).parent / "data"


def stored(name: str) -> dict[str, Any]:
    """What one of the paper's TOML files says."""
    return tomllib.loads((DATA / f"{name}.toml").read_text(encoding="utf-8"))


_PUBLISHED = stored("elamy_2023")
LAMINATES: dict[str, dict[str, Any]] = _PUBLISHED["laminates"]
"""Table 2: stack, modulus in GPa, Poisson's ratio, density in kg/m^3 and strength in MPa."""
CASES: dict[int, list[float]] = {int(case): row for case, row in _PUBLISHED["cases"].items()}
"""Table 3: crank, coupler and rocker over the ground."""
POSITIONS: dict[str, str] = _PUBLISHED["positions"]
"""Positions by their transmission angle, in words."""
SECOND = "90, second crank angle"
"""The other position with a right transmission angle, beside those that the paper compares."""
PLIES = ("woven", "unidirectional", "table 2")
"""By the rule of mixtures, as balanced fabric (the paper's, in its words) or straight; and one
modulus and density a laminate, of its Table 2."""
# The paper's first: its links are cut from flat sheets (section 4), so that bending in the plane
# of motion bends each ply in its own plane. What a model file says of it.
LAYERS = {
    "across width": """Plies lie parallel to the plane of motion, as in links that are
cut from a flat sheet: five of {:g} mm make the width.""",
    "through thickness": """Plies are stacked in the plane of motion: five of {:g} mm
make the thickness.""",
}
FLAT = next(iter(LAYERS))
# One material a laminate lies no way: it comes once.
MODELS = [*product(PLIES[:2], LAYERS), ("table 2", FLAT)]
"""Models of plies, and which way they lie; the first one is ours."""
GROUND, THICKNESS, WIDTH = 0.4, 5e-3, 25e-3
"""In m, assumed: of this size all links, the short cranks too, are slender enough for beams."""
COUNT = 5
"""Plies of a laminate."""
# A joint's spring against turning over EI / L of the coupler, with which it is as good as a weld:
# ten times more changes no frequency by a ten-thousandth.
WELD = 1e5


def published_case(case: int, ground: float = 1.0) -> FourBar:
    """Linkage of Table 3 with a ground of the given length in m."""
    return FourBar(ground, *(ground * length for length in CASES[case]))


def published_tables() -> xr.Dataset:
    """Tables 4 to 6: ``finite_element`` and ``measured`` frequency in Hz, and ``damping``."""
    rows = pd.read_csv(DATA / "elamy_2023_frequencies.csv", comment="#")
    order = {"position": list(POSITIONS), "laminate": list(LAMINATES), "case": list(CASES)}
    return rows.set_index(list(order)).to_xarray().reindex(order)


def position_angles(linkage: FourBar) -> FloatArray:
    """Crank angles in rad of the positions compared, and of the other one at a right angle, (4,).

    Elamy et al. 2023, eqs. 1-3: least transmission angle, 90 degrees, greatest. The crank passes
    two positions with 90 degrees, and the paper does not say which one it takes: the first one,
    below 180 degrees, stands for it here, and the other one last.
    """
    ground, crank, coupler, rocker = linkage.lengths.values()
    cosine = (ground**2 + crank**2 - coupler**2 - rocker**2) / (2 * ground * crank)
    right = float(np.arccos(cosine))
    return np.array([0.0, right, np.pi, 2 * np.pi - right])


def crank_rocker_file(
    case: int,
    laminate: str,
    plies: str = PLIES[0],
    layers: str = FLAT,
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
    in_plane_thickness : float
        Of the links, in m, whichever way the plies lie.

    Returns
    -------
    str
        TOML.
    """
    flat = layers == FLAT
    ply_thickness = 1e3 * (WIDTH if flat else in_plane_thickness) / COUNT
    thickness, width = (f'"{1e3 * size:g} mm"' for size in (in_plane_thickness, WIDTH))
    name = "elamy_2023_table_2" if plies == "table 2" else "elamy_2023_plies"
    return (
        (DATA / f"{name}.toml")
        .read_text(encoding="utf-8")
        .format(
            case=case,
            laminate=laminate,
            weave=plies,
            layers=layers,
            orientation=LAYERS[layers].format(ply_thickness),
            ply_thickness=ply_thickness,
            thickness=1e3 * in_plane_thickness,
            extent=f"in_plane_thickness = {thickness}" if flat else f"out_of_plane_width = {width}",
            **LAMINATES[laminate],
            **{link: 1e3 * size for link, size in published_case(case, GROUND).lengths.items()},
        )
    )


def crank_rocker_files() -> dict[str, str]:
    """Text of the model file of every linkage, as ``case_2_C3_woven_across_width.toml``."""
    return {
        "_".join(f"case {case} {laminate} {kind}".split()) + ".toml": crank_rocker_file(
            case, laminate, plies, layers
        )
        for plies, layers in MODELS
        for kind in (plies if plies == "table 2" else f"{plies} {layers}",)
        for case, laminate in product(CASES, LAMINATES)
    }


@lru_cache(maxsize=256)
def crank_rocker(
    case: int,
    laminate: str,
    plies: str = PLIES[0],
    layers: str = FLAT,
    in_plane_thickness: float = THICKNESS,
) -> Mechanism:
    """One linkage of the paper, its crank clamped and its links hinged; see its model file.

    With the paper's own supports, a crank that is pinned and links that are hinged, it moves
    without strain: its first natural frequency would be zero.
    """
    return mechanism_from_toml(crank_rocker_file(case, laminate, plies, layers, in_plane_thickness))


def with_rigid_joints(
    mechanism: Mechanism, crank_angle: float, stiffness: float = WELD
) -> Mechanism:
    """A linkage with its links held against turning at A and B.

    Parameters
    ----------
    mechanism : Mechanism
        Of a four-bar.
    crank_angle : float
        At which the joints have no torque, in rad.
    stiffness : float
        Of the joints, over EI / L of the coupler.
    """
    linkage, topology = mechanism.linkage, mechanism.linkage.topology
    angles = continuous_angles(linkage, linkage.motion(np.array([crank_angle]), 0.0))
    length = topology.links[topology.index("coupler")].length
    stiffness *= mechanism.sections["coupler"].bending_stiffness / length
    springs = tuple(
        JointSpring(
            pin.joint,
            torsional_stiffness=stiffness,
            free_angle=float(topology.joint_angle(pin.joint, angles)[0]),
        )
        for pin in topology.pins
    )
    return replace(mechanism, joint_springs=springs)


def laminate_factors(frequency: xr.DataArray) -> xr.DataArray:
    """Factor s of each laminate against C1: geometric mean over cases and positions.

    Linear theory with one modulus and one density a laminate gives the same ratio of two
    laminates in every linkage and position: frequency = s(laminate) q(case, position).
    """
    ratio = frequency / frequency.sel(laminate="C1")
    return geometric_mean(ratio, [dim for dim in frequency.dims if dim in ("position", "case")])


def geometric_mean(values: xr.DataArray, dims: str | list[Hashable]) -> xr.DataArray:
    """Geometric mean over dimensions."""
    mean: xr.DataArray = np.exp(np.log(values).mean(dims))
    return mean


def deviation_at_best_scale(computed: xr.DataArray, published: xr.DataArray) -> float:
    """Greatest relative deviation from published values, left by the scale that makes it least.

    With ratios of computed to published values from a to b that scale is 2 / (a + b), and
    what it leaves (b - a) / (a + b).
    """
    ratio = computed / published
    low, high = float(ratio.min()), float(ratio.max())
    return (high - low) / (high + low)
