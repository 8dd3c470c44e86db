"""Independent tasks on all processors, in the order in which they are asked for."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, TypeVar

from flexmech.interruption import STOPPING
from flexmech.threads import one_thread

__all__ = ["FEW", "in_order"]

FEW = 2
"""Tasks that are not worth processes of their own."""

_tasks: list[tuple[Callable[[Any], Any], Sequence[Any]]] = []

Item = TypeVar("Item")
Answer = TypeVar("Answer")


def in_order(task: Callable[[Item], Answer], items: Sequence[Item]) -> Iterator[Answer]:
    """Answers of a task to items, on all processors.

    Processes are split off where the system does that safely, which is on Linux; elsewhere, and
    for few items, the tasks run one after the other. What an interruption leaves undone is not
    begun.

    Parameters
    ----------
    task : callable
    items : sequence

    Yields
    ------
    object
        Of each item, in their order.
    """
    workers = min(_processors(), len(items))
    if workers < 2 or len(items) <= FEW or not sys.platform.startswith("linux"):
        with one_thread():
            yield from map(task, items)
        return
    # What a process is split off with need not be sent to it: tasks and items may be large.
    _tasks.append((task, items))
    try:
        context = multiprocessing.get_context("fork")
        with ProcessPoolExecutor(workers, context, _begin) as pool:
            with warnings.catch_warnings():
                # Progress runs in a thread of its own, which the processes do not use.
                warnings.simplefilter("ignore", DeprecationWarning)
                waiting = [pool.submit(_do, number) for number in range(len(items))]
            try:
                for future in waiting:
                    yield future.result()
            finally:
                pool.shutdown(wait=True, cancel_futures=True)
    finally:
        _tasks.pop()


def _do(number: int) -> Any:
    task, items = _tasks[-1]
    return task(items[number])


def _processors() -> int:
    """Processors that this process may use."""
    if sys.platform.startswith("linux"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _begin() -> None:
    """In a new process: the one that waits for it answers signals."""
    for number in STOPPING:
        signal.signal(number, signal.SIG_IGN)
    one_thread().__enter__()
