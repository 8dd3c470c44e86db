"""The campaign of Elamy et al. 2023: six laminates, four crank-rockers, three positions."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import provenance
from flexmech.analyses.frequencies.positions import natural_frequencies, strain_energy_damping
from flexmech.arrays import LabelledProgress, silent
from flexmech.linear_system import Engine
from flexmech.mechanism import Mechanism
from flexmech.reference import ReferenceEngine
from flexmech.studies.composite_crank_rockers import linkages
from flexmech.studies.composite_crank_rockers.claims import laminate_factors
from flexmech.studies.composite_crank_rockers.result import CompositeStudy

MakeEngine = Callable[[Mechanism, int, str], Engine]


def study_composites(
    make_engine: MakeEngine = ReferenceEngine, progress: LabelledProgress | None = None
) -> CompositeStudy:
    """Fundamental frequency and damping of all linkages at rest, beside the published ones.

    Parameters
    ----------
    make_engine : callable
        Engine of a mechanism, a number of elements a link and an element (``euler`` or
        ``timoshenko``).
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    CompositeStudy

    Examples
    --------
    The study takes a quarter of a minute. One linkage of it, at the three positions that the
    paper compares, and what the paper has there:

    >>> mechanism = flexmech.studies.composite_crank_rocker(2, "C3", "unidirectional")
    >>> angles = flexmech.studies.position_angles(mechanism.linkage)[:3]
    >>> found = flexmech.natural_frequencies(flexmech.ReferenceEngine(mechanism), angles, modes=1)
    >>> (found[:, 0] / found[0, 0]).round(2)
    array([1.  , 1.08, 1.32])
    >>> printed = flexmech.studies.published_tables()["finite_element"].sel(laminate="C3", case=2)
    >>> (printed / printed[0]).values.round(2)
    array([1.  , 0.69, 1.13])
    """
    coordinates = {
        "plies": list(linkages.PLY_MODELS),
        "beams": list(linkages.BEAMS),
        "position": [*linkages.POSITIONS, linkages.SECOND],
        "laminate": list(linkages.LAMINATES),
        "case": list(linkages.CASES),
    }
    unknown = xr.DataArray(np.nan, coordinates, list(coordinates))
    frequency, damping = unknown.copy(), unknown.copy()
    every = list(product(linkages.PLY_MODELS, linkages.LAMINATES, linkages.CASES))
    for done, (plies, laminate, case) in enumerate(every, start=1):
        mechanism = linkages.composite_crank_rocker(case, laminate, plies)
        angles = linkages.position_angles(linkages.published_case(case))
        for beams, elements in linkages.BEAMS.items():
            engine = make_engine(mechanism, *elements)
            place = {"plies": plies, "beams": beams, "laminate": laminate, "case": case}
            frequency.loc[place] = natural_frequencies(engine, angles, modes=1)[:, 0]
            if plies != "table 2" and beams != linkages.PAPERS_MESH:
                damping.loc[place] = strain_energy_damping(engine, angles, modes=1)[:, 0]
        (progress or silent)("linkages", done, len(every))
    versions = {k: v for k, v in provenance([engine]).items() if k.endswith("_version")}
    return CompositeStudy(composite_dataset(frequency, damping).assign_attrs(versions))


def composite_dataset(frequency: xr.DataArray, damping: xr.DataArray) -> xr.Dataset:
    """Dataset of the study.

    Parameters
    ----------
    frequency, damping : DataArray
        In Hz, and by modal strain energy, over (plies, beams, position, laminate, case). The last
        position is the second crank angle with a right transmission angle.

    Returns
    -------
    xarray.Dataset
        See :class:`CompositeStudy`.
    """
    turn, tables = np.radians(np.arange(361.0)), linkages.published_tables()
    factors = laminate_factors(tables["finite_element"].sel(position=["90", "max"]))
    dataset = tables.assign_coords(crank_angle=turn).assign(
        frequency=frequency.sel(position=list(linkages.POSITIONS)),
        other_configuration=frequency.sel(position=linkages.SECOND, drop=True),
        strain_energy_damping=damping.sel(position=list(linkages.POSITIONS)),
        laminate_factor=laminate_factors(frequency.sel(position=list(linkages.POSITIONS))),
        published_laminate_factor=factors,
        transmission_angle=(
            ("case", "crank_angle"),
            [linkages.published_case(case).transmission_angle(turn) for case in linkages.CASES],
        ),
    )
    stored = linkages.stored_table("variables.toml")
    for name, (unit, words) in stored["variables"].items():
        dataset[name].attrs = {"units": unit, "long_name": words}
    return dataset.assign_attrs(stored["attributes"])
