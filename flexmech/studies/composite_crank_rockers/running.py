"""The linkages of the paper in motion, beside links of steel of the same size.

The paper claims less driving torque and power and says at no speed how much; the speed here is
assumed. Torque, power and joint forces are those of rigid links. Deflections are those of the
periodic motion of linear beams, vibration included.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np
import xarray as xr

from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.analyses.speed_sweep.compute import periodic_peaks, vibrating_linkage
from flexmech.arrays import LabelledProgress, silent
from flexmech.linear_system import Engine
from flexmech.materials import Material
from flexmech.mechanism import Mechanism
from flexmech.sections import BeamSection
from flexmech.studies.composite_crank_rockers.linkages import (
    CASES,
    LAMINATES,
    THICKNESS,
    WIDTH,
    PlyModel,
    composite_crank_rocker,
    position_angles,
    published_case,
)

MakeEngine = Callable[[Mechanism, int, str], Engine]

CRANK_SPEED = 20.0
"""In rad/s, assumed: the paper states none."""
STEEL = Material(youngs_modulus=200e9, density=7850.0, poisson_ratio=0.3)
"""Assumed: the paper says metal."""
# Of the crank, at which torque and forces are taken.
_ANGLES = np.radians(np.arange(361.0))
_PLIES: tuple[PlyModel, ...] = ("woven", "table 2")
# Elements a link: twice as many change no deflection by more than half a percent.
_ELEMENTS = 4
_NAMES = ("peak_torque", "peak_power", "peak_joint_force", "peak_deflection")


def steel_crank_rocker(case: int) -> Mechanism:
    """The linkage of a case with links of steel, as thick and wide as those of composites.

    Parameters
    ----------
    case : int

    Returns
    -------
    Mechanism
    """
    section = BeamSection.rectangle(STEEL, THICKNESS, WIDTH)
    composite = composite_crank_rocker(case, "C1", "table 2")
    return replace(composite, sections=dict.fromkeys(composite.sections, section))


def running_peaks(make_engine: MakeEngine, progress: LabelledProgress | None = None) -> xr.Dataset:
    """Greatest values over a turn at a steady crank speed.

    Parameters
    ----------
    make_engine : callable
        Engine of a mechanism, a number of elements a link and an element.
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    xarray.Dataset
        ``peak_torque`` of the shaft in N m, ``peak_power`` in W, ``peak_joint_force`` in N and
        ``peak_deflection`` in m, over ``running_plies`` (woven, and one material a laminate of
        Table 2), ``material`` (C1 to C6 and steel) and ``case``. Plies lie parallel to the plane
        of motion.
    """
    materials, names = [*LAMINATES, "steel"], _NAMES
    places = {"running_plies": list(_PLIES), "material": materials, "case": list(CASES)}
    unknown = xr.DataArray(np.nan, places, list(places))
    found = {name: unknown.copy() for name in names}
    every = [*product(_PLIES, LAMINATES, CASES), *product([None], ["steel"], CASES)]
    for done, (plies, material, case) in enumerate(every, start=1):
        mechanism = (
            steel_crank_rocker(case)
            if plies is None
            else composite_crank_rocker(case, material, plies)
        )
        at = {"material": material, "case": case} | ({"running_plies": plies} if plies else {})
        for name, peak in zip(names, _peaks(mechanism, case, make_engine), strict=True):
            found[name].loc[at] = peak
        (progress or silent)("running linkages", done, len(every))
    return xr.Dataset(found)


def _peaks(
    mechanism: Mechanism, case: int, make_engine: MakeEngine
) -> tuple[float, float, float, float]:
    """Torque, power, joint force and deflection."""
    rigid = mechanism.inverse_dynamics(mechanism.linkage.motion(_ANGLES, CRANK_SPEED))
    forces = [np.hypot(*force.T).max() for force in rigid.joint_force.values()]
    engine = make_engine(mechanism, _ELEMENTS, "euler").fit_for(1)
    at_rest = natural_frequencies(engine, position_angles(published_case(case)), modes=1)
    linkage = vibrating_linkage(engine, CRANK_SPEED, 1, "none")
    deflection = periodic_peaks(linkage, float(at_rest.max()))
    return (
        float(np.abs(rigid.driving_torque).max()),
        float(np.abs(rigid.driving_power).max()),
        float(max(forces)),
        float(deflection.max()),
    )
