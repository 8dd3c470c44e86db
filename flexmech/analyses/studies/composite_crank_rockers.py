"""The campaign of Elamy et al. 2023: six laminates, four crank-rockers, three positions.

The paper prints no link size. One is assumed, in the model files that this module fills in,
and only ratios are compared.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib import resources
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

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
from flexmech.materials import Material
from flexmech.mechanism import Mechanism
from flexmech.modelfile import mechanism_from_toml
from flexmech.sections import BeamSection

__all__ = [
    "PLY_MODELS",
    "PlyModel",
    "composite_crank_rocker",
    "composite_model_file",
    "position_angles",
    "study_composites",
]

FloatArray = NDArray[np.float64]
PlyModel = Literal["unidirectional", "woven", "table 2"]
PLY_MODELS: tuple[PlyModel, ...] = ("unidirectional", "woven", "table 2")
GROUND = 0.4
# How the links are divided: converged, and as the paper does it.
MESHES = {"euler, 8 elements a link": 8, "euler, 1 element a link": 1}
MakeEngine = Callable[[Mechanism, int], Engine]


def composite_model_file(case: int, laminate: str, weave: str = "unidirectional") -> str:
    """Model file of one linkage of the paper, with the link size that is assumed.

    Parameters
    ----------
    case : int
        1 to 4, of Table 3.
    laminate : str
        C1 to C6, of Table 2.
    weave : {"unidirectional", "woven"}

    Returns
    -------
    str
        TOML.
    """
    linkage = published_case(case, 1e3 * GROUND)
    text = resources.files("flexmech.analyses.studies").joinpath("data", "crank_rocker.toml")
    return text.read_text(encoding="utf-8").format(
        case=case,
        laminate=laminate,
        stack=LAMINATES[laminate].stack,
        weave=weave,
        crank=linkage.crank,
        coupler=linkage.coupler,
        rocker=linkage.rocker,
    )


def composite_crank_rocker(case: int, laminate: str, plies: PlyModel) -> Mechanism:
    """One linkage of the paper.

    Parameters
    ----------
    case : int
    laminate : str
    plies : {"unidirectional", "woven", "table 2"}
        Plies by the rule of mixtures, straight or as balanced fabric; or the one modulus and
        density that Table 2 prints for the whole laminate.

    Returns
    -------
    Mechanism
    """
    weave = "woven" if plies == "woven" else "unidirectional"
    text = composite_model_file(case, laminate, weave)
    mechanism = mechanism_from_toml(text, f"case_{case}_{laminate}.toml")
    if plies != "table 2":
        return mechanism
    printed = LAMINATES[laminate]
    material = Material(printed.youngs_modulus, printed.density, printed.poisson_ratio)
    crank = mechanism.sections["crank"]
    assert crank.layers is not None
    section = BeamSection.rectangle(material, crank.in_plane_thickness, crank.layers.width)
    return replace(mechanism, sections=dict.fromkeys(mechanism.sections, section))


def position_angles(linkage: FourBar) -> FloatArray:
    """Crank angles of the positions compared, and of the other one at a right angle, (4,).

    Elamy et al. 2023, eqs. 1-3: least transmission angle, 90 degrees, greatest; in rad.
    """
    ground, crank, coupler, rocker = linkage.lengths.values()
    cosine = (ground**2 + crank**2 - coupler**2 - rocker**2) / (2 * ground * crank)
    right = float(np.arccos(cosine))
    return np.array([0.0, right, np.pi, 2 * np.pi - right])


def study_composites(
    make_engine: MakeEngine, progress: Callable[[str, int, int], None] | None = None
) -> xr.Dataset:
    """Fundamental frequency and damping of all linkages, beside the published ones.

    Parameters
    ----------
    make_engine : callable
        Engine of a mechanism and a number of elements a link.
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    xarray.Dataset
        ``frequency`` in Hz over ``plies``, ``mesh``, ``position``, ``laminate`` and ``case``;
        ``other_posture``, the same at the second crank angle with a right transmission
        angle; ``strain_energy_damping``; the published ``finite_element``, ``measured`` and
        ``damping``; ``transmission_angle`` in rad over ``crank_angle`` and ``case``.
    """
    meshes = list(MESHES.values())
    shape = (len(PLY_MODELS), len(meshes), len(POSITIONS) + 1, len(LAMINATES), len(CASES))
    frequency = np.empty(shape)
    damping = np.full((len(POSITIONS), len(LAMINATES), len(CASES)), np.nan)
    done, total = 0, len(PLY_MODELS) * len(LAMINATES) * len(CASES)
    for p, plies in enumerate(PLY_MODELS):
        for m, laminate in enumerate(LAMINATES):
            for c, case in enumerate(CASES):
                mechanism = composite_crank_rocker(case, laminate, plies)
                angles = position_angles(published_case(case))
                for e, elements in enumerate(meshes):
                    engine = make_engine(mechanism, elements)
                    found = natural_frequencies(engine, angles, modes=1)
                    frequency[p, e, :, m, c] = found[:, 0]
                if plies == "unidirectional":
                    engine = make_engine(mechanism, meshes[0])
                    damping[:, m, c] = strain_energy_damping(engine, angles[:3], modes=1)[:, 0]
                done += 1
                if progress is not None:
                    progress("linkages", done, total)
    dims = ("plies", "mesh", "position", "laminate", "case")
    turn = np.radians(np.arange(361.0))
    angle = np.stack([published_case(case).transmission_angle(turn) for case in CASES], axis=1)
    dataset = published_tables().assign(
        frequency=(dims, frequency[:, :, :3]),
        other_posture=(("plies", "mesh", "laminate", "case"), frequency[:, :, 3]),
        strain_energy_damping=(dims[2:], damping),
        transmission_angle=(("crank_angle", "case"), angle),
    )
    dataset = dataset.assign_coords(plies=list(PLY_MODELS), mesh=list(MESHES), crank_angle=turn)
    for name in ("frequency", "other_posture", "finite_element", "measured"):
        dataset[name].attrs.update(units="Hz", long_name="fundamental natural frequency")
    dataset["transmission_angle"].attrs.update(units="rad", long_name="transmission angle")
    return dataset
