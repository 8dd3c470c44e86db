"""Common part of results of studies: designs as rows, and in words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from concurrent.futures import Executor
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.datasets import origin
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.studies.evaluation import STATUSES, Evaluated
from flexmech.studies.study import Study
from flexmech.studies.tasks import computed_tasks, gathered

DESIGN = "design"
LEAST_ERROR = 1e-6
"""Relative error of a peak that is sought between crank angles, as of ``kinematics``: less is below
the digits of all that is printed."""


def designs_dataset(study: Study, designs: FloatArray, evaluated: Evaluated) -> xr.Dataset:
    """Designs with their outputs, over ``design``.

    Parameters
    ----------
    study : Study
    designs : ndarray, shape (n, k)
    evaluated : Evaluated

    Returns
    -------
    xarray.Dataset
        Variables as coordinates, outputs in SI units, ``status`` and ``reason``, ``within`` where
        a design is computed and keeps every limit, and ``violation``.
    """
    coordinates: dict[str, Any] = {DESIGN: np.arange(1, len(designs) + 1)}
    for variable, column in zip(study.variables, designs.T, strict=True):
        values: Any = column
        if variable.is_text:
            values = np.array([variable.value(number) for number in column])
        units = {"units": variable.unit or "1", "shown_unit": variable.shown_unit}
        coordinates[variable.name] = (
            DESIGN,
            values,
            {} if variable.is_text else units | {"long_name": variable.name},
        )
    variables: dict[str, Any] = {}
    for (name, output), column in zip(study.outputs.items(), evaluated.values.T, strict=True):
        attributes: dict[str, Any] = {
            "units": output.dimension.unit or "1",
            "shown_unit": output.shown_unit,
            "long_name": output.kind.words,
        }
        for limit in study.limits:
            if limit.output == name:
                bounds = {"least": limit.least, "greatest": limit.greatest}
                attributes |= {k: v for k, v in bounds.items() if np.isfinite(v)}
        variables[name] = (DESIGN, column, attributes)
    violation = violations(study, evaluated.values)
    computed = evaluated.status == 0
    variables |= {
        "status": (DESIGN, np.array(STATUSES)[evaluated.status]),
        "reason": (DESIGN, np.array(evaluated.reasons, dtype=str)),
        "violation": (DESIGN, np.where(computed, violation, np.nan)),
        "within": (DESIGN, computed & (violation <= 0)),
    }
    whole: dict[str, Any] = origin(study.mechanism) | {
        "seed": study.seed,
        "engine": study.engine,
        "outputs": " ".join(study.outputs),
        "variables": "\n".join(study.names),
        "goals": "\n".join(f"{goal.sense} {goal.output}" for goal in study.goals),
    }
    return xr.Dataset(variables, coordinates, whole)


def violations(study: Study, values: FloatArray) -> FloatArray:
    """Sum of the relative violations of all limits by outputs (n, m), shape (n,)."""
    names, total = list(study.outputs), np.zeros(len(values))
    for limit in study.limits:
        total += np.nan_to_num(limit.violation(values[:, names.index(limit.output)]), nan=np.inf)
    return total


def finer_errors(
    study: Study,
    designs: FloatArray,
    values: FloatArray,
    executor: Executor | None = None,
    progress: LabelledProgress | None = None,
) -> FloatArray:
    """Relative changes of outputs with twice the elements and crank angles, (n, m).

    Parameters
    ----------
    study : Study
    designs : ndarray, shape (n, k)
    values : ndarray, shape (n, m)
        Their outputs.
    executor : concurrent.futures.Executor, optional
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    ndarray, shape (n, m)
        Not numbers where the finer model cannot be computed.
    """
    every = np.arange(len(designs))
    tasks = computed_tasks(study, designs, every, executor, progress, "finer models", finer=2)
    return relative_changes(values, gathered(study, designs, tasks).values)


def near_a_limit(dataset: xr.Dataset) -> list[int]:
    """Numbers of the designs that are nearer to a limit than their outputs are known.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of :func:`designs_dataset`, with ``relative_error`` over ``output``.

    Returns
    -------
    list of int
    """
    near = np.zeros(dataset.sizes[DESIGN], dtype=bool)
    for name in dataset.attrs["outputs"].split():
        values = dataset[name].values
        error = float(dataset["relative_error"].sel(output=name)) * np.abs(values)
        for end in ("least", "greatest"):
            if end in dataset[name].attrs:
                near |= np.abs(values - dataset[name].attrs[end]) <= error
    return [int(number) for number in dataset[DESIGN].values[near]]


def relative_changes(values: FloatArray, finer: FloatArray) -> FloatArray:
    """Differences of outputs from those of a finer model, over the greater of both."""
    size = np.maximum(np.abs(finer), np.abs(values))
    with np.errstate(invalid="ignore"):
        change = np.abs(finer - values) / size
    return np.asarray(np.where(size == 0, 0.0, change))


def designs_table(dataset: xr.Dataset, extra: Mapping[str, str] | None = None) -> pd.DataFrame:
    """Designs as rows: number, variables, outputs, status and reason.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of :func:`designs_dataset`.
    extra : mapping of str to str, optional
        Further columns and the variables that they hold.

    Returns
    -------
    pandas.DataFrame
    """
    names = [*dataset.attrs["variables"].split("\n"), *dataset.attrs["outputs"].split()]
    columns: dict[str, Any] = {"design": dataset[DESIGN].values}
    columns |= {column_name(dataset, name): dataset[name].values for name in names}
    columns |= {column: dataset[name].values for column, name in (extra or {}).items()}
    columns |= {name: dataset[name].values for name in ("status", "reason")}
    return pd.DataFrame(columns)


def column_name(dataset: xr.Dataset, name: str) -> str:
    """Name of a column of numbers with its SI unit."""
    unit = str(dataset[name].attrs.get("units", "1"))
    for written, column in (("/", "_"), ("^", ""), (" ", "_")):
        unit = unit.replace(written, column)
    return name if unit == "1" else f"{name}_{unit}"


def status_line(dataset: xr.Dataset) -> str:
    """How many designs ended how."""
    counts = Counter(dataset["status"].values.tolist())
    counted = ", ".join(f"{counts[status]} {status}" for status in STATUSES if counts[status])
    return f"designs: {counted}"


def reason_lines(dataset: xr.Dataset) -> list[str]:
    """The first reason of each status but ok."""
    lines = []
    for status in STATUSES[1:]:
        of = dataset.isel(design=np.flatnonzero(dataset["status"].values == status)[:1])
        lines += [
            f"{status}, as design {number}: {reason}"
            for number, reason in zip(of[DESIGN].values, of["reason"].values, strict=True)
        ]
    return lines
