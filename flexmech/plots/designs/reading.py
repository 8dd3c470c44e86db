"""What is read of the dataset of a study: its variables, outputs, goals and limits."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.plots.style import Look
from flexmech.units import from_si

# Of one panel in inches; of a front, and of a panel of contours.
PANEL, LARGE_PANEL = 2.1, 3.0
BOUND: Look = {"color": "black", "lw": 1.0, "ls": "--"}
"""Of limits."""


def computed(dataset: xr.Dataset) -> xr.Dataset:
    """Designs that can be computed.

    Parameters
    ----------
    dataset : Dataset
        Of a study.

    Returns
    -------
    Dataset

    Raises
    ------
    InputError
        If there is none.
    """
    known = dataset.isel(design=np.flatnonzero(dataset["status"].values == "ok"))
    if not known.sizes["design"]:
        raise InputError("no design can be computed; see the reasons in designs.csv")
    return known


def outputs_of(dataset: xr.Dataset) -> list[str]:
    """Names of the outputs of a study."""
    return str(dataset.attrs["outputs"]).split()


def variables_of(dataset: xr.Dataset) -> list[str]:
    """Names of what varies in a study."""
    return str(dataset.attrs["variables"]).split("\n")


def varying(dataset: xr.Dataset) -> list[str]:
    """Names of what takes two values or more among the designs; all where nothing does."""
    names = variables_of(dataset)
    return [name for name in names if len(np.unique(dataset[name].values)) > 1] or names


def goals_of(dataset: xr.Dataset) -> list[tuple[str, str]]:
    """Sense (``"min"`` or ``"max"``) and output of each goal of a study."""
    goals = [goal.split(" ", 1) for goal in str(dataset.attrs["goals"]).split("\n") if goal]
    return [(sense, output) for sense, output in goals]


def bounds(values: xr.DataArray) -> list[float]:
    """Limits of an output in the unit in which it is shown."""
    attributes = values.attrs
    return [
        from_si(float(attributes[name]), attributes["shown_unit"])
        for name in ("least", "greatest")
        if name in attributes
    ]


def shown(values: xr.DataArray) -> FloatArray:
    """Values in the unit in which they are shown; texts as they are."""
    if values.dtype.kind == "U":
        return values.values
    return np.asarray(values.values * from_si(1.0, values.attrs["shown_unit"]))


def label(values: xr.DataArray) -> str:
    """Name of a variable or output, with its unit, and of uncertain ones their percentile."""
    name = short_name(str(values.name))
    if statistic := values.attrs.get("statistic"):
        name = f"{name}, {statistic}"
    unit = values.attrs.get("shown_unit", "")
    return f"{name} ({unit or '-'})" if values.dtype.kind != "U" else name


def short_name(name: str) -> str:
    """The last two parts of a key of the model file, which tell what it is, in words."""
    return " ".join(name.split(".")[-2:]).replace("_", " ")
