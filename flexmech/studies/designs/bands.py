"""Natural frequencies over the crank angle of a sample of designs: medians and intervals."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.default_engines import engine_kind
from flexmech.analyses.frequencies.formulation import Formulation
from flexmech.analyses.frequencies.positions import frequencies_at
from flexmech.arrays import FloatArray
from flexmech.linear_system import Engine
from flexmech.studies.designs.design import turn
from flexmech.studies.designs.evaluation import design_of, guarded
from flexmech.studies.designs.outputs import OF_FREQUENCIES, Output
from flexmech.studies.designs.study import Study

MOST_DESIGNS = 64
"""Whose frequencies are drawn, the first of a sample: they alone are spread evenly too."""
PERCENTILES = (2.5, 50.0, 97.5)
# Of so few the interval of 95 % is that of the outermost designs.
_LEAST_DESIGNS = 8


def frequency_bands(study: Study, designs: FloatArray) -> xr.Dataset:
    """Percentiles of the natural frequencies over the crank angle.

    They are of the speed, prestress and crank angles of the study's first output that is found
    from natural frequencies. Modes are in ascending order at every crank angle.

    Parameters
    ----------
    study : Study
    designs : ndarray, shape (n, k)
        Of a sample; the first :data:`MOST_DESIGNS` of them are taken.

    Returns
    -------
    xarray.Dataset
        ``frequency_percentile`` in Hz over (percentile, mode, crank_angle), with the number of
        designs in its attribute ``designs``; empty where no output is found from frequencies, or
        few designs can be computed.
    """
    asked = [each for each in study.outputs.values() if each.quantity in OF_FREQUENCIES]
    if not asked:
        return xr.Dataset()
    found = _frequencies(study, asked[0], designs[:MOST_DESIGNS])
    if len(found) < _LEAST_DESIGNS:
        return xr.Dataset()
    parts = np.percentile(np.array(found), PERCENTILES, axis=0, method="hazen")
    # A turn ends where it begins.
    angles = np.append(turn(asked[0].angles), 2 * np.pi)
    parts = np.concatenate([parts, parts[:, :1]], axis=1)
    return xr.Dataset(
        {
            "frequency_percentile": (
                ("percentile", "crank_angle", "mode"),
                parts,
                {"units": "Hz", "long_name": "natural frequency", "designs": len(found)},
            )
        },
        {
            "percentile": ("percentile", list(PERCENTILES), {"units": "%"}),
            "crank_angle": ("crank_angle", angles, {"units": "rad"}),
            "mode": np.arange(1, parts.shape[2] + 1),
        },
    ).transpose("percentile", "mode", "crank_angle")


def bands_table(bands: xr.DataArray) -> pd.DataFrame:
    """Percentiles of the natural frequencies as columns, modes one after the other.

    Parameters
    ----------
    bands : xarray.DataArray
        The ``frequency_percentile`` of :func:`frequency_bands`.

    Returns
    -------
    pandas.DataFrame
    """
    rows = bands.transpose("mode", "crank_angle", "percentile")
    modes, angles = (rows[name].values for name in ("mode", "crank_angle"))
    low, median, high = rows.values.reshape(-1, len(PERCENTILES)).T
    return pd.DataFrame(
        {
            "mode": np.repeat(modes, len(angles)),
            "crank_angle_rad": np.tile(angles, len(modes)),
            **{"p2_5_Hz": low, "p50_Hz": median, "p97_5_Hz": high},
        }
    )


def _frequencies(study: Study, output: Output, designs: FloatArray) -> list[FloatArray]:
    """Frequencies (angles, modes) of the designs that have some."""
    engine = engine_kind(study.engine)(study.mechanism)
    found = (guarded(partial(_of_one, study, engine, output, row))[0] for row in designs)
    return [own for own in found if own is not None]


def _of_one(study: Study, engine: Engine, output: Output, row: FloatArray) -> FloatArray:
    """Frequencies (angles, modes) of one design."""
    modes, design = max(output.mode, 3), design_of(study, engine, row)
    formulation = Formulation(output.prestress, True, modes)
    angles, speed = turn(output.angles), output.speed_of(design)
    return frequencies_at(design.engine.fit_for(modes), angles, speed, formulation)
