"""The campaign of Elamy et al. 2023: six laminates, four crank-rockers, three positions."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
import xarray as xr

from flexmech.analyses.frequencies import natural_frequencies, strain_energy_damping
from flexmech.analyses.provenance import provenance
from flexmech.linear_system import Engine
from flexmech.mechanism import Mechanism
from flexmech.reference import ReferenceEngine
from flexmech.studies.composite_crank_rockers.linkages import (
    BEAMS,
    PAPERS_MESH,
    PLY_MODELS,
    composite_crank_rocker,
    position_angles,
)
from flexmech.studies.composite_crank_rockers.published import (
    CASES,
    LAMINATES,
    POSITIONS,
    published_case,
    published_tables,
)
from flexmech.studies.composite_crank_rockers.result import CompositeStudy
from flexmech.studies.composite_crank_rockers.structure import laminate_factors
from flexmech.types import FloatArray, LabelledProgress

__all__ = ["MakeEngine", "composite_dataset", "study_composites"]

MakeEngine = Callable[[Mechanism, int, str], Engine]
FREQUENCIES = ("frequency", "other_posture", "finite_element", "measured")
ATTRIBUTES = {
    "mechanism": "composite crank-rockers",
    "source": "M. I. Elamy et al., Improving the dynamic performance of the crank-rocker "
    "mechanism, ERJ Menoufia University 46(4), October 2023",
}


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
    It takes a quarter of a minute.

    >>> study = flexmech.study_composites()  # doctest: +SKIP
    >>> print(study.summary().verdict)  # doctest: +SKIP
    33 claims: 9 reproduced, 15 not reproduced, 9 not checkable
    """
    shape = (len(PLY_MODELS), len(BEAMS), len(POSITIONS) + 1, len(LAMINATES), len(CASES))
    frequency, damping = np.empty(shape), np.full(shape, np.nan)
    linkages = list(product(enumerate(PLY_MODELS), enumerate(LAMINATES), enumerate(CASES)))
    for done, ((p, plies), (m, laminate), (c, case)) in enumerate(linkages, start=1):
        mechanism = composite_crank_rocker(case, laminate, plies)
        angles = position_angles(published_case(case))
        for b, (beams, elements) in enumerate(BEAMS.items()):
            engine = make_engine(mechanism, *elements)
            frequency[p, b, :, m, c] = natural_frequencies(engine, angles, modes=1)[:, 0]
            if plies != "table 2" and beams != PAPERS_MESH:
                damping[p, b, :, m, c] = strain_energy_damping(engine, angles, modes=1)[:, 0]
        if progress is not None:
            progress("linkages", done, len(linkages))
    versions = {k: v for k, v in provenance([engine]).items() if k.endswith("_version")}
    return CompositeStudy(composite_dataset(frequency, damping).assign_attrs(versions))


def composite_dataset(frequency: FloatArray, damping: FloatArray) -> xr.Dataset:
    """Dataset of the study.

    Parameters
    ----------
    frequency, damping : ndarray, shape (plies, beams, positions, laminates, cases)
        In Hz, and by modal strain energy. The last position is the second crank angle with a
        right transmission angle.

    Returns
    -------
    xarray.Dataset
        See :class:`CompositeStudy`.
    """
    dims = ("plies", "beams", "position", "laminate", "case")
    turn = np.radians(np.arange(361.0))
    angle = np.stack([published_case(case).transmission_angle(turn) for case in CASES], axis=1)
    dataset = published_tables().assign(
        frequency=(dims, frequency[:, :, :3]),
        other_posture=(("plies", "beams", "laminate", "case"), frequency[:, :, 3]),
        strain_energy_damping=(dims, damping[:, :, :3]),
        transmission_angle=(("crank_angle", "case"), angle),
    )
    dataset = dataset.assign_coords(plies=list(PLY_MODELS), beams=list(BEAMS), crank_angle=turn)
    published = dataset["finite_element"].sel(position=["90", "max"])
    dataset = dataset.assign(
        laminate_factor=laminate_factors(dataset["frequency"]),
        published_laminate_factor=laminate_factors(published),
    )
    for names, units, words in (
        (FREQUENCIES, "Hz", "fundamental natural frequency"),
        (("laminate_factor", "published_laminate_factor"), "1", "frequency over that of C1"),
        (("strain_energy_damping",), "1", "damping ratio by modal strain energy"),
        (("damping",), "1", "printed damping factor"),
        (("transmission_angle",), "rad", "transmission angle"),
        (("crank_angle",), "rad", "crank angle"),
    ):
        for name in names:
            dataset[name].attrs = {"units": units, "long_name": words}
    return dataset.assign_attrs(ATTRIBUTES)
