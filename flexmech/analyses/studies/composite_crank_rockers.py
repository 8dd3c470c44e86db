"""The campaign of Elamy et al. 2023: six laminates, four crank-rockers, three positions.

The paper prints no link size. One is assumed, in the model files that this module fills in,
and only ratios are compared. Of each linkage several models are computed, since the paper
leaves open which one is meant: three of the plies, three of the beams.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import resources
from typing import Literal

import numpy as np
import xarray as xr

from flexmech.analyses.frequencies import natural_frequencies
from flexmech.analyses.modal_damping import strain_energy_damping
from flexmech.analyses.studies.published import (
    CASES,
    LAMINATES,
    POSITIONS,
    published_case,
    published_tables,
)
from flexmech.linear_system import Engine
from flexmech.linkages import FourBar
from flexmech.mechanism import Mechanism
from flexmech.modelfile import mechanism_from_toml
from flexmech.types import FloatArray

__all__ = [
    "BEAMS",
    "PLY_MODELS",
    "MakeEngine",
    "PlyModel",
    "composite_crank_rocker",
    "composite_model_file",
    "model_file_name",
    "position_angles",
    "study_composites",
]

PlyModel = Literal["unidirectional", "woven", "table 2"]
PLY_MODELS: tuple[PlyModel, ...] = ("unidirectional", "woven", "table 2")
"""Plies by the rule of mixtures, straight or as balanced fabric (the paper's, in its words);
one modulus and density a laminate, of its Table 2."""

CONVERGED, PAPERS_MESH, WITH_SHEAR = "converged", "one element a link", "with shear"
BEAMS = {CONVERGED: ("euler", 8), PAPERS_MESH: ("euler", 1), WITH_SHEAR: ("timoshenko", 8)}
"""Element and number of elements a link: bending converged, as in the paper, and with shear."""

GROUND, PLY_THICKNESS = 0.4, 1e-3
MakeEngine = Callable[[Mechanism, str, int], Engine]


def composite_model_file(
    case: int,
    laminate: str,
    plies: PlyModel = "unidirectional",
    ply_thickness: float = PLY_THICKNESS,
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
    printed = LAMINATES[laminate]
    linkage = published_case(case, 1e3 * GROUND)
    name = "crank_rocker_table_2.toml" if plies == "table 2" else "crank_rocker.toml"
    text = resources.files("flexmech.analyses.studies").joinpath("data", name)
    return text.read_text(encoding="utf-8").format(
        case=case,
        laminate=laminate,
        stack=printed.stack,
        weave=plies,
        ply_thickness=1e3 * ply_thickness,
        thickness=5e3 * ply_thickness,
        modulus=1e-9 * printed.youngs_modulus,
        density=printed.density,
        poisson_ratio=printed.poisson_ratio,
        crank=linkage.crank,
        coupler=linkage.coupler,
        rocker=linkage.rocker,
    )


def model_file_name(case: int, laminate: str, plies: PlyModel = "unidirectional") -> str:
    """Name of a linkage's model file.

    Parameters
    ----------
    case : int
    laminate : str
    plies : {"unidirectional", "woven", "table 2"}

    Returns
    -------
    str
        Such as ``case_2_C3.toml`` or ``case_2_C3_woven.toml``.
    """
    ending = "" if plies == "unidirectional" else f"_{plies.replace(' ', '_')}"
    return f"case_{case}_{laminate}{ending}.toml"


def composite_crank_rocker(
    case: int, laminate: str, plies: PlyModel, ply_thickness: float = PLY_THICKNESS
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
    text = composite_model_file(case, laminate, plies, ply_thickness)
    return mechanism_from_toml(text, model_file_name(case, laminate, plies))


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


def study_composites(
    make_engine: MakeEngine, progress: Callable[[str, int, int], None] | None = None
) -> xr.Dataset:
    """Fundamental frequency and damping of all linkages at rest, beside the published ones.

    Parameters
    ----------
    make_engine : callable
        Engine of a mechanism, an element (``euler`` or ``timoshenko``) and a number of
        elements a link.
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    xarray.Dataset
        ``frequency`` in Hz over ``plies``, ``beams``, ``position``, ``laminate`` and ``case``;
        ``other_posture``, the same at the second crank angle with a right transmission
        angle; ``strain_energy_damping`` like ``frequency``, not a number where no loss is
        known and with one element a link; the published ``finite_element``, ``measured`` and
        ``damping``; ``transmission_angle`` in rad over ``crank_angle`` and ``case``.
    """
    shape = (len(PLY_MODELS), len(BEAMS), len(POSITIONS) + 1, len(LAMINATES), len(CASES))
    frequency, damping = np.empty(shape), np.full(shape, np.nan)
    total = len(PLY_MODELS) * len(LAMINATES) * len(CASES)
    places = list(np.ndindex(len(PLY_MODELS), len(LAMINATES), len(CASES)))
    for done, (p, m, c) in enumerate(places, start=1):
        plies, case = PLY_MODELS[p], list(CASES)[c]
        mechanism = composite_crank_rocker(case, list(LAMINATES)[m], plies)
        angles = position_angles(published_case(case))
        for e, (beams, (element, elements)) in enumerate(BEAMS.items()):
            engine = make_engine(mechanism, element, elements)
            frequency[p, e, :, m, c] = natural_frequencies(engine, angles, modes=1)[:, 0]
            if plies != "table 2" and beams != PAPERS_MESH:
                damping[p, e, :, m, c] = strain_energy_damping(engine, angles, modes=1)[:, 0]
        if progress is not None:
            progress("linkages", done, total)
    return _labelled(frequency, damping)


def _labelled(frequency: FloatArray, damping: FloatArray) -> xr.Dataset:
    dims = ("plies", "beams", "position", "laminate", "case")
    without_position = ("plies", "beams", "laminate", "case")
    turn = np.radians(np.arange(361.0))
    angle = np.stack([published_case(case).transmission_angle(turn) for case in CASES], axis=1)
    dataset = published_tables().assign(
        frequency=(dims, frequency[:, :, :3]),
        other_posture=(without_position, frequency[:, :, 3]),
        strain_energy_damping=(dims, damping[:, :, :3]),
        transmission_angle=(("crank_angle", "case"), angle),
    )
    dataset = dataset.assign_coords(plies=list(PLY_MODELS), beams=list(BEAMS), crank_angle=turn)
    for name in ("frequency", "other_posture", "finite_element", "measured"):
        dataset[name].attrs.update(units="Hz", long_name="fundamental natural frequency")
    dataset["strain_energy_damping"].attrs.update(
        units="1", long_name="damping ratio by modal strain energy"
    )
    dataset["transmission_angle"].attrs.update(units="rad", long_name="transmission angle")
    return dataset
