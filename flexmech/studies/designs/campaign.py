"""Designs given to workers, and kept as they come back."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict
from multiprocessing import get_context, parent_process
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np

from flexmech.analyses.datasets import versions
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.errors import InputError
from flexmech.studies.designs.evaluation import Evaluated
from flexmech.studies.designs.store import NAME, DesignStore, digest
from flexmech.studies.designs.study import Study
from flexmech.studies.designs.tasks import check_executor, computed_tasks, gathered

# In s, for a scheduler to answer.
_PATIENCE = "10s"


def evaluate_all(
    study: Study,
    designs: FloatArray,
    *,
    executor: Executor | None = None,
    progress: LabelledProgress | None = None,
    folder: Path | None = None,
    resume: bool = False,
    content: dict[str, Any] | None = None,
) -> Evaluated:
    """Outputs of designs, by workers where there are some, and kept where there is a folder.

    Parameters
    ----------
    study : Study
    designs : ndarray, shape (n, k)
    executor : concurrent.futures.Executor, optional
        Any: of processes on this machine, of Dask, executorlib, Parsl or MPI. Left out: this
        process.
    progress : callable, optional
        Called as ``progress(label, done, total)``.
    folder : Path, optional
        Where the store of the designs is kept.
    resume : bool
        Whether to go on with a store that is there.
    content : dict, optional
        What else the study is, for the store.

    Returns
    -------
    Evaluated

    Raises
    ------
    InputError
        If the executor is none, the store is of another study, or another run writes it.
    ComputationError
        If a worker was killed.
    """
    check_executor(executor)
    every = np.arange(len(designs))
    if folder is None:
        return gathered(study, designs, computed_tasks(study, designs, every, executor, progress))
    described = study_content(study, len(designs)) | (content or {})
    if resume:
        store = DesignStore.reopen(folder / NAME, described)
    else:
        store = DesignStore.create(folder / NAME, len(designs), described)
    with store:
        for numbers, found in computed_tasks(study, designs, store.pending(), executor, progress):
            store.write(int(numbers[0]), designs[numbers], found)
        return store.read()[1]


def study_content(study: Study, count: int) -> dict[str, Any]:
    """What a study is, in a form that a store keeps and compares.

    Parameters
    ----------
    study : Study
    count : int
        Number of designs.

    Returns
    -------
    dict
        Its variables and outputs with their units, its seed, the digest of the model, versions.
    """
    varied = {
        f"vary.{variable.name}": [variable.distribution, variable.numbers, variable.keys]
        + [variable.steps] * (variable.distribution == "range")
        for variable in study.variables
    }
    # Of the engine's library too, which alone computes the numbers of that engine.
    packages = ("exudyn",) if study.engine == "exudyn" else ()
    return {
        "model": digest(study.mechanism.to_toml()),
        "designs": count,
        "seed": study.seed,
        "engine": study.engine,
        "variables": study.names,
        **varied,
        "outputs": list(study.outputs),
        **{f"outputs.{name}": asdict(output) for name, output in study.outputs.items()},
        "correlations": [[*one.variables, one.coefficient] for one in study.correlations],
        "units": [variable.unit for variable in study.variables]
        + [output.dimension.unit for output in study.outputs.values()],
        **versions(*packages),
    }


@contextmanager
def workers(count: int = 1, cluster: str | None = None) -> Iterator[Executor | None]:
    """Workers of this machine, or of a Dask cluster.

    Parameters
    ----------
    count : int
        Processes on this machine; one computes in this process.
    cluster : str, optional
        Address of the scheduler, such as ``tcp://scheduler:8786``.

    Yields
    ------
    concurrent.futures.Executor or None

    Raises
    ------
    InputError
        If the extra is not installed, or no scheduler answers.
    """
    if cluster is not None:
        try:
            import distributed
        except ImportError as error:
            raise InputError(
                "--cluster needs the extra packages of [cluster]: pip install 'flexmech[cluster]'"
            ) from error
        try:
            # Not the default one: xarray would lock the files it writes here by way of the cluster.
            client: Any = distributed.Client(  # type: ignore[no-untyped-call]
                cluster, timeout=_PATIENCE, set_as_default=False
            )
        except (OSError, ValueError) as error:
            raise InputError(
                f"--cluster {cluster}: no scheduler answers there; start one with 'dask "
                "scheduler', and workers with 'dask worker', in an environment that has flexmech"
            ) from error
        with client:
            yield client.get_executor()
    elif count > 1:
        # A fork would copy the threads of libraries in whatever state they are.
        with ProcessPoolExecutor(count, get_context("spawn"), _end_with_parent) as pool:
            yield pool
    else:
        yield None


def _end_with_parent() -> None:
    """Let a worker end if the process that gives it tasks is killed; it would wait for ever."""
    if (parent := parent_process()) is None:
        return

    def wait_for_it() -> None:
        parent.join()
        os._exit(1)

    Thread(target=wait_for_it, daemon=True).start()
