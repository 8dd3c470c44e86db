"""The best design of a search, computed anew by both engines; what becomes of one that fails."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import get_args

import numpy as np
import xarray as xr

from flexmech.analyses.csv_text import csv_text
from flexmech.analyses.result import Result
from flexmech.arrays import FloatArray, IntArray
from flexmech.choices import EngineName
from flexmech.errors import ComputationError, one_line
from flexmech.files import given_path, write_whole
from flexmech.studies.designs.evaluation import MOST_LETTERS, Evaluated, evaluate
from flexmech.studies.designs.result import designs_dataset, designs_table, relative_changes
from flexmech.studies.designs.scatter import Scatter
from flexmech.studies.designs.search import margins_of
from flexmech.studies.designs.study import Study
from flexmech.studies.designs.tasks import computed_tasks, gathered

SLACK = 1e-3
"""Part of a limit by which the finer models may miss it: an optimum lies on its limits."""
CANDIDATES = "pareto.csv"
"""File of the best designs, and of the candidate where there is none."""
_FINER = "with twice the elements and crank angles"


def confirmed(
    study: Study,
    scatter: Scatter,
    design: FloatArray,
    values: FloatArray,
    folder: Path | None,
) -> xr.Dataset:
    """The best design computed anew by both engines, with twice the elements and crank angles.

    Parameters
    ----------
    study : Study
    scatter : Scatter
        Of what is uncertain around it.
    design : ndarray, shape (k,)
    values : ndarray, shape (m,)
        Its outputs.
    folder : Path or None
        For the row of a design that does not hold.

    Returns
    -------
    xarray.Dataset
        ``relative_error`` over ``output`` and ``checked`` over (checking_engine, output).

    Raises
    ------
    ComputationError
        If an engine cannot compute it, or finds it beyond a limit.
    """
    engines: tuple[EngineName, ...] = get_args(EngineName)
    again = []
    for engine in engines:
        own = study.with_(engine=engine)
        found = scatter.evaluated(design[None], lambda rows: evaluate(own, rows, finer=2))  # noqa: B023
        if reason := _does_not_hold(study, found):
            raise ComputationError(
                f"the best design does not hold: {_FINER} {engine} finds {reason}; "
                f"{_told(study, design)}{_remedy(study, found)}"
                + candidate_kept(study, design, found, f"{_FINER} {engine} finds {reason}", folder)
            )
        again.append(found.values[0])
    return xr.Dataset(
        {
            "relative_error": (
                "output",
                relative_changes(values, again[engines.index(study.engine)]),
            ),
            "checked": (("checking_engine", "output"), np.stack(again)),
        },
        {"output": list(study.outputs), "checking_engine": list(engines)},
    )


def errors_of(
    study: Study,
    scatter: Scatter,
    designs: FloatArray,
    values: FloatArray,
    computed: Callable[[FloatArray], Evaluated],
    executor: Executor | None,
) -> FloatArray:
    """Greatest relative errors of several designs, by a finer model and by the number of samples.

    Parameters
    ----------
    study : Study
    scatter : Scatter
    designs : ndarray, shape (n, k)
    values : ndarray, shape (n, m)
        Their outputs.
    computed : callable
        Gives the outputs of rows that were computed on the way.
    executor : concurrent.futures.Executor or None

    Returns
    -------
    ndarray, shape (m,)
        Not numbers where a finer model cannot be computed.
    """

    def finer(rows: FloatArray) -> Evaluated:
        every = np.arange(len(rows))
        return gathered(study, rows, computed_tasks(study, rows, every, executor, finer=2))

    changes = relative_changes(values, scatter.evaluated(designs, finer).values)
    sampling = np.stack([scatter.errors(design[None], computed) for design in designs])
    return np.asarray((changes + sampling).max(axis=0))


def _does_not_hold(study: Study, found: Evaluated) -> str:
    """Why one design cannot be, if it cannot."""
    if found.status[0] != 0:
        return found.reasons[0]
    return beyond(study, found.values[0], SLACK)


def _remedy(study: Study, found: Evaluated) -> str:
    if found.status[0] != 0 or not study.limits:
        return ""
    worst = float(margins_of(study, found.values[0]).min())
    return f"; give that output more angles, or tighten its limit by {100 * -worst:.2g} %"


def beyond(study: Study, values: FloatArray, slack: float = 0.0) -> str:
    """Outputs of one design beyond a limit, in words; empty where all limits are kept.

    Parameters
    ----------
    study : Study
    values : ndarray, shape (m,)
    slack : float
        Part of a limit by which it may be missed.

    Returns
    -------
    str
    """
    names = list(study.outputs)
    margins = margins_of(study, values)
    missed: IntArray = np.flatnonzero(margins < -slack)
    told = []
    for number in missed[np.argsort(margins[missed])].tolist():
        name = study.limits[number].output
        told.append(f"{name} {study.outputs[name].told(values[names.index(name)])}")
    return ", ".join(told)


def candidate_kept(
    study: Study, design: FloatArray, found: Evaluated, reason: str, folder: Path | None
) -> str:
    """Keep the row of a design that is no optimum, and say where it is.

    Parameters
    ----------
    study : Study
    design : ndarray, shape (k,)
    found : Evaluated
        Of that design alone.
    reason : str
        Why it is none.
    folder : Path or None
        Where the row is written, if anywhere.

    Returns
    -------
    str
        For the end of a message; empty where nothing is written.
    """
    if folder is None:
        return ""
    row = Evaluated(found.values, found.status, [one_line(reason, MOST_LETTERS)])
    table = designs_table(designs_dataset(study, design[None], row), {"violation": "violation"})
    file = given_path(folder) / CANDIDATES
    form = f"%.{Result.significant_digits}g"
    write_whole(file, csv_text(table, form))
    earlier = file.with_name("optimum.toml")
    stale = f"; {earlier} is of an earlier run" if earlier.exists() else ""
    return f"; its row is in {file}{stale}"


def _told(study: Study, design: FloatArray) -> str:
    """A design in words."""
    return ", ".join(
        f"{variable.name} {variable.told(number)}"
        for variable, number in zip(study.variables, design.tolist(), strict=True)
    )
