"""What every comparison holds: the curves, the fitted parameters and what remains."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.comparison.fit import Fit
from flexmech.analyses.comparison.request import ComparisonRequest
from flexmech.linear_system import Engine
from flexmech.measured_data import MeasuredRecord
from flexmech.types import FloatArray

CURVES = ("measured", "computed", "residual")
Values = FloatArray | NDArray[np.complex128]


def comparison_dataset(
    engine: Engine,
    record: MeasuredRecord,
    request: ComparisonRequest,
    fit: Fit,
    measured: Values,
    computed: Values,
    *,
    dimension: str,
    unit: str,
    column: str,
    quantity: str,
    first_frequency: float,
) -> xr.Dataset:
    """Label measured and computed curves, and the fit.

    Parameters
    ----------
    engine : Engine
    record : MeasuredRecord
    request : ComparisonRequest
    fit : Fit
    measured, computed : ndarray, shape (N,)
        Real, or complex for a frequency-response function.
    dimension : str
        What they are written over.
    unit : str
        Of both; empty for a ratio.
    column : str
        Of the record.
    quantity : str
        What is computed, in words or by its column.
    first_frequency : float
        First natural frequency in rad/s, at which damping times are told as ratios.

    Returns
    -------
    xarray.Dataset
    """
    values = {"measured": measured, "computed": computed, "residual": measured - computed}
    dataset = xr.Dataset()
    for name, value in values.items():
        if np.iscomplexobj(value):
            # NetCDF has no complex numbers.
            dataset[f"{name}_real"], dataset[f"{name}_imag"] = (
                (dimension, np.ascontiguousarray(part)) for part in (value.real, value.imag)
            )
        else:
            dataset[name] = dimension, np.asarray(value)
    for curve in list(dataset):
        words = str(curve).replace("_", " ")
        dataset[curve].attrs.update(units=unit or "1", long_name=words)
    names = [parameter.name for parameter in fit.parameters]
    dataset = dataset.merge(
        xr.Dataset(
            {
                "fitted": ("parameter", fit.values),
                "standard_error": ("parameter", fit.standard_error),
                "lower": ("parameter", fit.lower),
                "upper": ("parameter", fit.upper),
                "correlation": (("parameter", "with_parameter"), fit.correlation),
            },
            coords={
                "parameter": np.array(names, dtype=str),
                "with_parameter": np.array(names, dtype=str),
                "parameter_unit": (
                    "parameter",
                    np.array([parameter.unit or "1" for parameter in fit.parameters], dtype=str),
                ),
            },
        )
    )
    where = (
        {"crank_angle_locked": request.angle}
        if request.speed is None
        else {"crank_speed": request.speed}
    )
    return dataset.assign_attrs(
        abscissa=record.abscissa,
        record=Path(record.source).name.encode(errors="backslashreplace").decode(),
        column=column,
        quantity=quantity,
        unit=unit,
        engine=engine.name,
        element=engine.element,
        speed_unit=request.speed_unit,
        unexplained=fit.unexplained,
        residual_order=fit.order,
        widened=fit.widened,
        first_frequency=first_frequency / (2 * np.pi),
        **where,
    )
