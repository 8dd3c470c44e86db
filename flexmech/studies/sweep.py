"""Outputs over many designs: every combination of values, or a sample."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from flexmech import plots
from flexmech.analyses.digits import Quantity
from flexmech.analyses.parameters import Parameters
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table, trust_line
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.mechanism import Mechanism
from flexmech.studies.campaign import evaluate_all
from flexmech.studies.evaluation import governing
from flexmech.studies.outputs import Output
from flexmech.studies.result import (
    LEAST_ERROR,
    designs_dataset,
    designs_table,
    finer_errors,
    near_a_limit,
    reason_lines,
    status_line,
)
from flexmech.studies.study import Goal, Limit, Study
from flexmech.studies.variables import Variable, known_variable
from flexmech.units import ANGULAR_SPEED, from_si

if TYPE_CHECKING:
    from matplotlib.figure import Figure


ROWS = 8
"""Rows of the table of the best designs."""


class DesignSweep(Result):
    """Outputs of many designs of a linkage.

    Parameters
    ----------
    dataset : xarray.Dataset
        Outputs over ``design`` in SI units, with the variables as coordinates; ``status`` and
        ``reason`` of designs that cannot be computed, ``within`` where every limit is kept, and
        ``relative_error`` over ``output``, the greatest of the best designs, those of the table.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "designs"
    subject = "designs"
    hallmark = "within"
    files = ("designs.csv", "designs.nc", "designs.png")

    def tables(self) -> dict[str, pd.DataFrame]:
        """Designs, one row each."""
        return {self.stem: designs_table(self.dataset)}

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw outputs over the variables, with the limits.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or sequence of them, optional

        Returns
        -------
        matplotlib.figure.Figure
        """
        return plots.plot_designs(self.dataset, ax=ax)

    @property
    def ranked(self) -> xr.Dataset:
        """Designs that can be computed, the best first: by violation, then by the first goal."""
        return ranked(self.dataset)

    def summary(self) -> Summary:
        """How many designs keep the limits, and the best of them."""
        data = self.dataset
        best = self.ranked
        count, within = data.sizes["design"], int(data["within"].sum())
        outputs = data.attrs["outputs"].split()
        numbers: tuple[Quantity, ...] = ()
        lines = [f"{within} of {count} designs keep{'s' * (within == 1)} every limit."]
        if not any({"least", "greatest"} & data[name].attrs.keys() for name in outputs):
            lines = [f"{within} of {count} designs can be computed."]
        table, error = None, float("nan")
        if best.sizes["design"]:
            first = best.isel(design=0)
            numbers = output_quantities(first, outputs)
            which = "The best is" if data.attrs["goals"] else "The first of them is"
            which = which if first["within"] else "None does; the nearest is"
            lines.append(f"{which} design {int(first['design'])}: {outputs_text(numbers)}.")
            table = designs_in_words(best.isel(design=slice(ROWS)), data.attrs["mechanism"])
            error = float(data["relative_error"].max(skipna=False).clip(min=LEAST_ERROR))
        return Summary(
            tuple(lines),
            table,
            trust_line([data.attrs["engine"]], error),
            details=(status_line(data), *reason_lines(data), *_near_lines(data)),
            numbers=numbers,
        )


def _near_lines(data: xr.Dataset) -> list[str]:
    """Designs that keep or fail a limit by less than the errors of their outputs."""
    near = near_a_limit(data)
    if not near:
        return []
    listed = ", ".join(map(str, near[:ROWS])) + (", ..." if len(near) > ROWS else "")
    return [
        "nearer to a limit than its error, so that a finer model may turn the verdict: "
        f"design{'s' * (len(near) > 1)} {listed}"
    ]


def ranked(dataset: xr.Dataset) -> xr.Dataset:
    """Designs that can be computed, the best first: by violation, then by the first goal."""
    known = dataset.isel(design=np.flatnonzero(dataset["status"].values == "ok"))
    keys = [known["violation"].values]
    goals = [goal for goal in dataset.attrs["goals"].split("\n") if goal]
    if goals:
        sense, output = goals[0].split(" ", 1)
        keys.insert(0, known[output].values * (1.0 if sense == "min" else -1.0))
    return known.isel(design=np.lexsort(keys))


def output_quantities(design: xr.Dataset, outputs: list[str]) -> tuple[Quantity, ...]:
    """Outputs of one design with their errors, in their printed units."""
    quantities = []
    for name in outputs:
        unit = design[name].attrs["shown_unit"]
        value = from_si(float(design[name]), unit)
        error = abs(value) * float(design["relative_error"].sel(output=name))
        quantities.append(
            Quantity(name, value, unit, error, design[name].attrs.get("governed_by", ""))
        )
    return tuple(quantities)


def outputs_text(numbers: Sequence[Quantity]) -> str:
    """Outputs of one design in words, each with the link or point that governs it."""
    return ", ".join(f"{one.name} {one}" + f" ({one.of})" * bool(one.of) for one in numbers)


def designs_in_words(dataset: xr.Dataset, mechanism: str) -> Table:
    """Designs as rows of a table, in their printed units."""
    names = [*dataset.attrs["variables"].split("\n"), *dataset.attrs["outputs"].split()]
    units = [str(dataset[name].attrs.get("shown_unit", "")) for name in names]
    headings = tuple(
        f"{_short(name)} {unit}".rstrip() for name, unit in zip(names, units, strict=True)
    )
    rows = []
    for number in range(dataset.sizes["design"]):
        one = dataset.isel(design=number)
        cells = [str(int(one["design"]))]
        for name, unit in zip(names, units, strict=True):
            value = one[name].item()
            cells.append(value if isinstance(value, str) else f"{from_si(value, unit):.4g}")
        rows.append((*cells, "yes" if bool(one["within"]) else "no"))
    which = "best designs" if dataset.attrs["goals"] else "designs"
    return Table(f"{which}, {mechanism}", ("design", *headings, "within"), (tuple(rows),))


def _short(name: str) -> str:
    """The last two parts of a dotted key, which tell what it is."""
    return " ".join(name.split(".")[-2:]).replace("_", " ")


def sweep_study(
    study: Study,
    *,
    samples: int | None = None,
    executor: Executor | None = None,
    progress: LabelledProgress | None = None,
    folder: Path | None = None,
    resume: bool = False,
) -> DesignSweep:
    """Outputs over the designs of a study: every combination, or a sample.

    Parameters
    ----------
    study : Study
    samples : int, optional
        Designs spread over the ranges by Sobol's sequence. Left out: every combination.
    executor : concurrent.futures.Executor, optional
        Executor of processes, of Dask, Parsl or MPI; this process if left out.
    progress : callable, optional
        Called as ``progress(label, done, total)``.
    folder : Path, optional
        Where ``designs.zarr`` is kept, so that an interrupted study can go on.
    resume : bool
        Whether to go on with the store that is there.

    Returns
    -------
    DesignSweep

    Raises
    ------
    InputError
        If there are too many designs, or the store is of another study.
    ComputationError
        If a worker was killed.
    """
    designs = study.combinations() if samples is None else study.sample(samples)
    evaluated = evaluate_all(
        study,
        designs,
        executor=executor,
        progress=progress,
        folder=folder,
        resume=resume,
        content={"samples": samples},
    )
    dataset = designs_dataset(study, designs, evaluated)
    errors = table_errors(study, designs, dataset, executor, progress)
    return DesignSweep(with_governing(study, designs, dataset).assign(relative_error=errors))


def with_governing(study: Study, designs: FloatArray, dataset: xr.Dataset) -> xr.Dataset:
    """Outputs that name the link or point which governs them in the first design of the table.

    Parameters
    ----------
    study : Study
    designs : ndarray, shape (n, k)
    dataset : xarray.Dataset
        Dataset of these designs.

    Returns
    -------
    xarray.Dataset
        With the attribute ``governed_by`` of these outputs.
    """
    first = ranked(dataset)["design"].values[:1]
    for row in designs[first - 1]:
        for name, place in governing(study, row).items():
            dataset[name].attrs["governed_by"] = place
    return dataset


def table_errors(
    study: Study,
    designs: FloatArray,
    dataset: xr.Dataset,
    executor: Executor | None = None,
    progress: LabelledProgress | None = None,
) -> xr.DataArray:
    """Greatest relative errors of the outputs of the best designs, those of the table.

    Parameters
    ----------
    study : Study
    designs : ndarray, shape (n, k)
    dataset : xarray.Dataset
        Dataset of these designs.
    executor : concurrent.futures.Executor, optional
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    xarray.DataArray
        Over ``output``; not numbers where no design or no finer model of one can be computed.
    """
    best = ranked(dataset).isel(design=slice(ROWS))
    errors = np.full(len(study.outputs), np.nan)
    if best.sizes["design"]:
        values = np.stack([best[name].values for name in study.outputs], axis=1)
        rows = designs[best["design"].values - 1]
        errors = finer_errors(study, rows, values, executor, progress).max(axis=0)
    return xr.DataArray(errors, {"output": list(study.outputs)}, "output")


def sweep(
    mechanism: Mechanism,
    variables: Mapping[str, ArrayLike],
    outputs: Mapping[str, Output],
    *,
    limits: tuple[Limit, ...] = (),
    goals: tuple[Goal, ...] = (),
    executor: Executor | None = None,
    progress: LabelledProgress | None = None,
) -> DesignSweep:
    """Outputs over every combination of values of a mechanism's parameters.

    Parameters
    ----------
    mechanism : Mechanism
    variables : mapping of str to array_like
        Values in SI units, or texts, by the keys of the model file
        (``links.coupler.in_plane_thickness``) or ``damping-ratio``, ``moisture``,
        ``temperature-rise``, ``crank-speed``.
    outputs : mapping of str to Output
        By the names that they are to have.
    limits : tuple of Limit
    goals : tuple of Goal
    executor : concurrent.futures.Executor, optional
        Executor of processes, of Dask, Parsl or MPI; this process if left out.
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    DesignSweep
        With the variables as coordinates over ``design``.

    Raises
    ------
    InputError
        If a key is unknown or a value impossible.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> found = flexmech.sweep(
    ...     mechanism,
    ...     {"links.coupler.in_plane_thickness": [1.5e-3, 2e-3]},
    ...     {"mass": flexmech.studies.Output("mass")},
    ... )
    >>> found.dataset["mass"].round(4).values
    array([0.0924, 0.1028])
    """
    parameters = Parameters.of(mechanism)
    chosen = []
    for name, values in variables.items():
        dimension = known_variable(parameters, name, (name,), ANGULAR_SPEED)
        listed = np.ravel(np.asarray(values)).tolist()
        chosen.append(Variable(name, (name,), dimension, "values", tuple(listed)))
    study = Study(mechanism, tuple(chosen), dict(outputs), limits=limits, goals=goals)
    return sweep_study(study, executor=executor, progress=progress)
