"""Designs given to workers in tasks of about a second, whatever a design costs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.parallel import loss_of_workers
from flexmech.arrays import FloatArray, IntArray, LabelledProgress, silent
from flexmech.errors import InputError
from flexmech.studies.evaluation import Evaluated, Task, evaluate_task
from flexmech.studies.study import Study

# In s, of a task: so much is lost where a worker is killed, and milliseconds hand it over.
_SECONDS = 1.0
# Designs of a task at most: fewer than a chunk of the store, which every task writes anew.
_MOST = 256
# Times as many designs as in the longest task so far: the first designs are no measure of all.
_GROWTH = 4
# Tasks of a worker, one that it computes and one that waits for it.
_AHEAD = 2
# Workers of executors that do not say how many workers they have, such as those of clusters.
_WORKERS = 16
RESUMED = "what is done is kept with --out: go on with --resume and fewer workers"


def check_executor(executor: object) -> None:
    """Refuse what is no executor.

    Parameters
    ----------
    executor : object

    Raises
    ------
    InputError
        Names what is one.
    """
    if executor is None or isinstance(executor, Executor):
        return
    kind = type(executor)
    raise InputError(
        f"executor: {kind.__module__}.{kind.__qualname__} is no concurrent.futures.Executor; give "
        "a ProcessPoolExecutor, client.get_executor() of Dask, MPIPoolExecutor of mpi4py.futures, "
        "or for Slurm and Flux one of executorlib"
    )


def computed_tasks(
    study: Study,
    designs: FloatArray,
    pending: IntArray,
    executor: Executor | None,
    progress: LabelledProgress | None = None,
    label: str = "designs",
    finer: int = 1,
) -> Iterator[tuple[IntArray, Evaluated]]:
    """Outputs of the pending ones of some designs, task by task, in the order in which these end.

    Parameters
    ----------
    study : Study
    designs : ndarray, shape (n, k)
    pending : ndarray of int, shape (p,)
        Numbers of designs, ascending.
    executor : concurrent.futures.Executor or None
        This process computes where it is None.
    progress : callable, optional
        Called as ``progress(label, done, total)``.
    label : str
    finer : int
        As in :func:`flexmech.studies.evaluation.evaluate`.

    Yields
    ------
    ndarray of int
        Numbers of the designs of a task.
    Evaluated

    Raises
    ------
    InputError
        If the executor is none.
    ComputationError
        If a worker was killed.
    """
    check_executor(executor)
    report = progress or silent
    plan = _Plan.of(pending, executor)
    done, total = len(designs) - len(plan.left), len(designs)
    report(label, done, total)
    ended = _here(study, designs, plan, finer)
    if executor is not None:
        ended = _by_workers(study, designs, plan, executor, finer)
    for numbers, task in ended:
        plan.measure(task)
        done += len(numbers)
        report(label, done, total)
        yield numbers, task.found


def gathered(
    study: Study, designs: FloatArray, tasks: Iterable[tuple[IntArray, Evaluated]]
) -> Evaluated:
    """Outputs of tasks in the order of the designs.

    Parameters
    ----------
    study : Study
    designs : ndarray, shape (n, k)
    tasks : iterable of (ndarray of int, Evaluated)
        Numbers of designs, and what is found of them; of all designs together.

    Returns
    -------
    Evaluated
    """
    values = np.full((len(designs), len(study.outputs)), np.nan)
    status, reasons = np.zeros(len(designs), dtype=np.intp), [""] * len(designs)
    for numbers, found in tasks:
        values[numbers], status[numbers] = found.values, found.status
        for number, reason in zip(numbers.tolist(), found.reasons, strict=True):
            reasons[number] = reason
    return Evaluated(values, status, reasons)


@dataclass
class _Plan:
    """Designs that are left, and how many of them the next task has.

    Parameters
    ----------
    left : ndarray of int, shape (p,)
    workers : int
    shares : bool
        Whether the last tasks are made small for all workers to end together.
    """

    left: IntArray
    workers: int
    shares: bool
    cost: float = np.inf
    longest: int = 0

    @classmethod
    def of(cls, pending: IntArray, executor: Executor | None) -> _Plan:
        """The plan for an executor."""
        workers = 1 if executor is None else getattr(executor, "_max_workers", None) or _WORKERS
        return cls(pending, workers, executor is not None)

    def measure(self, task: Task) -> None:
        """Note what the designs of a task have cost."""
        count = len(task.found.status)
        self.cost = task.seconds / count
        self.longest = max(self.longest, count)

    def take(self) -> IntArray:
        """Numbers of the designs of the next task, one after the other; none where none is left."""
        size = min(_SECONDS / max(self.cost, 1e-9), _MOST, _GROWTH * self.longest)
        if self.shares:
            size = min(size, len(self.left) / (_AHEAD * self.workers))
        size = max(int(size), 1)
        # Up to the first gap, which a study that goes on has between what was computed.
        gap = np.flatnonzero(np.diff(self.left[:size]) > 1)
        numbers = self.left[: int(gap[0]) + 1 if len(gap) else size]
        self.left = self.left[len(numbers) :]
        return numbers


def _here(
    study: Study, designs: FloatArray, plan: _Plan, finer: int
) -> Iterator[tuple[IntArray, Task]]:
    while len(numbers := plan.take()):
        yield numbers, evaluate_task(study, designs[numbers], finer)


def _by_workers(
    study: Study, designs: FloatArray, plan: _Plan, executor: Executor, finer: int
) -> Iterator[tuple[IntArray, Task]]:
    waiting: dict[Future[Task], IntArray] = {}
    try:
        while True:
            while len(waiting) < _AHEAD * plan.workers and len(numbers := plan.take()):
                with loss_of_workers(RESUMED, Exception):
                    future = executor.submit(evaluate_task, study, designs[numbers], finer)
                waiting[future] = numbers
            if not waiting:
                return
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                with loss_of_workers(RESUMED, Exception):
                    found = future.result()
                yield waiting.pop(future), found
    finally:
        for future in waiting:
            future.cancel()
