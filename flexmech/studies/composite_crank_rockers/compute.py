"""The campaign of Elamy et al. 2023: six laminates, four crank-rockers, three positions."""

from __future__ import annotations

from itertools import product

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import provenance
from flexmech.analyses.frequencies.positions import natural_frequencies, strain_energy_damping
from flexmech.arrays import LabelledProgress, silent
from flexmech.reference import ReferenceEngine
from flexmech.studies.composite_crank_rockers import linkages
from flexmech.studies.composite_crank_rockers.properties import (
    factor_uncertainty,
    laminate_properties,
)
from flexmech.studies.composite_crank_rockers.ratios import laminate_factors
from flexmech.studies.composite_crank_rockers.result import CompositeStudy
from flexmech.studies.composite_crank_rockers.running import MakeEngine, running_peaks
from flexmech.studies.composite_crank_rockers.strengths import first_ply_failures

# Every linkage and position, the second crank angle with a right transmission angle last.
_LINKAGES = {
    "position": [*linkages.POSITIONS, linkages.SECOND],
    "laminate": list(linkages.LAMINATES),
    "case": list(linkages.CASES),
}


def study_composites(
    make_engine: MakeEngine = ReferenceEngine, progress: LabelledProgress | None = None
) -> CompositeStudy:
    """Fundamental frequency and damping of all linkages at rest, beside the published ones.

    Parameters
    ----------
    make_engine : callable
        Engine of a mechanism, a number of elements a link and an element (``euler`` or
        ``reddy``).
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    CompositeStudy

    Examples
    --------
    The study takes half a minute. One linkage of it, at the three positions that the
    paper compares, and what the paper has there:

    >>> mechanism = flexmech.studies.composite_crank_rocker(2, "C3")
    >>> angles = flexmech.studies.position_angles(mechanism.linkage)[:3]
    >>> found = flexmech.natural_frequencies(flexmech.ReferenceEngine(mechanism), angles, modes=1)
    >>> (found[:, 0] / found[0, 0]).round(2)
    array([1.  , 1.08, 1.31])
    >>> printed = flexmech.studies.published_tables()["finite_element"].sel(laminate="C3", case=2)
    >>> (printed / printed[0]).values.round(2)
    array([1.  , 0.69, 1.13])
    """
    coordinates = {
        "plies": list(linkages.PLY_MODELS),
        "layers": list(linkages.LAYERS),
        "beams": list(linkages.BEAMS),
        **_LINKAGES,
    }
    unknown = xr.DataArray(np.nan, coordinates, list(coordinates))
    frequency, damping = unknown.copy(), unknown.copy()
    every = list(product(linkages.each_model(), linkages.LAMINATES, linkages.CASES))
    report = progress or silent
    for done, ((plies, layers), laminate, case) in enumerate(every, start=1):
        mechanism = linkages.composite_crank_rocker(case, laminate, plies, layers)
        angles = linkages.position_angles(linkages.published_case(case))
        for beams, elements in linkages.BEAMS.items():
            engine = make_engine(mechanism, *elements)
            place = {"plies": plies, "beams": beams, "laminate": laminate, "case": case}
            # One material a laminate lies no way.
            if plies != "table 2":
                place["layers"] = layers
            frequency.loc[place] = natural_frequencies(engine, angles, modes=1)[:, 0]
            if plies != "table 2" and beams != linkages.PAPERS_MESH:
                damping.loc[place] = strain_energy_damping(engine, angles, modes=1)[:, 0]
        report("linkages", done, len(every))
    versions = {k: v for k, v in provenance([engine]).items() if k.endswith("_version")}
    dataset = composite_dataset(
        frequency,
        damping,
        rigid_joint_frequencies(make_engine, progress),
        running_peaks(make_engine, progress),
        first_ply_failures(progress),
    )
    return CompositeStudy(dataset.assign_attrs(versions))


def rigid_joint_frequencies(
    make_engine: MakeEngine, progress: LabelledProgress | None = None
) -> xr.DataArray:
    """Fundamental frequencies with links held against turning at A and B.

    Parameters
    ----------
    make_engine : callable
    progress : callable, optional

    Returns
    -------
    DataArray
        In Hz over position, laminate and case, of the first plies and layers.
    """
    found = xr.DataArray(np.nan, _LINKAGES, list(_LINKAGES))
    every = list(product(linkages.LAMINATES, linkages.CASES))
    for done, (laminate, case) in enumerate(every, start=1):
        angles = linkages.position_angles(linkages.published_case(case))
        mechanism = linkages.composite_crank_rocker(
            case, laminate, supports="rigid joints", crank_angle=float(angles[0])
        )
        engine = make_engine(mechanism, *linkages.BEAMS[linkages.CONVERGED])
        # Without prestress the angle at which the joints have no torque does not matter, so that
        # one linkage serves all positions.
        own = natural_frequencies(engine, angles, modes=1, prestress="none")[:, 0]
        found.loc[{"laminate": laminate, "case": case}] = own
        (progress or silent)("linkages with rigid joints", done, len(every))
    return found


def composite_dataset(
    frequency: xr.DataArray,
    damping: xr.DataArray,
    rigid_joints: xr.DataArray,
    running: xr.Dataset,
    failures: xr.Dataset,
) -> xr.Dataset:
    """Dataset of the study.

    Parameters
    ----------
    frequency, damping : DataArray
        In Hz, and by modal strain energy, over (plies, layers, beams, position, laminate, case).
        The last position is the second crank angle with a right transmission angle.
    rigid_joints : DataArray
        In Hz, over (position, laminate, case).
    running : Dataset
        Of :func:`flexmech.studies.composite_crank_rockers.running.running_peaks`.
    failures : Dataset
        Of :func:`flexmech.studies.composite_crank_rockers.strengths.first_ply_failures`.

    Returns
    -------
    xarray.Dataset
        See :class:`CompositeStudy`.
    """
    turn, tables = np.radians(np.arange(361.0)), linkages.published_tables()
    factors = laminate_factors(tables["finite_element"].sel(position=["90", "max"]))
    compared = list(linkages.POSITIONS)
    dataset = tables.assign_coords(crank_angle=turn).assign(
        frequency=frequency.sel(position=compared),
        other_configuration=frequency.sel(position=linkages.SECOND, drop=True),
        rigid_joints_frequency=rigid_joints.sel(position=compared),
        rigid_joints_other_configuration=rigid_joints.sel(position=linkages.SECOND, drop=True),
        strain_energy_damping=damping.sel(position=compared),
        laminate_factor=laminate_factors(frequency.sel(position=compared)),
        published_laminate_factor=factors,
        transmission_angle=(
            ("case", "crank_angle"),
            [linkages.published_case(case).transmission_angle(turn) for case in linkages.CASES],
        ),
    )
    properties = laminate_properties()
    dataset = xr.merge([dataset, properties, running, failures], join="exact")
    relative = factor_uncertainty(properties).isel(mixed_plies=0, layers=0, drop=True)
    ours = dataset["laminate_factor"].isel(plies=0, layers=0).sel(beams=linkages.CONVERGED)
    dataset["laminate_factor_spread"] = (ours * relative).drop_vars(["plies", "layers", "beams"])
    stored = linkages.stored_table("variables.toml")
    for name, (unit, words) in stored["variables"].items():
        dataset[name].attrs = {"units": unit, "long_name": words}
    return dataset.assign_attrs(stored["attributes"])
