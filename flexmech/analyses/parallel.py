"""Independent tasks on all processors, in the order in which they are asked for."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor, wait
from contextlib import contextmanager
from multiprocessing.process import BaseProcess
from typing import Any, TypeVar

from flexmech.errors import ComputationError, FlexmechError, one_line
from flexmech.interruption import STOPPING, uninterrupted
from flexmech.threads import one_thread

# Tasks that are not worth processes of their own. Speed alone.
FEW = 2

# Time in s within which processes at work have to end after an interruption: a long call of
# compiled code would keep them for minutes.
GRACE = 0.5
# Python answers a signal that comes while it begins to wait only after it has waited; so no wait
# is longer than this, in s.
HEARING = 0.2
# PR_SET_PDEATHSIG of <linux/prctl.h>: no process outlives the one that waits for it.
ENDS_WITH_PARENT = 1

_tasks: list[tuple[Callable[[Any], Any], Sequence[Any]]] = []

Item = TypeVar("Item")
Answer = TypeVar("Answer")


def in_order(task: Callable[[Item], Answer], items: Sequence[Item]) -> Iterator[Answer]:
    """Answers of a task to items, on all processors.

    Processes are split off where the system does that safely, which is on Linux; elsewhere, and
    for few items, the tasks run one after the other. What an interruption leaves undone is not
    begun, and processes that are still at work shortly afterwards are ended.

    Parameters
    ----------
    task : callable
    items : sequence

    Yields
    ------
    object
        Answer for each item, in their order.

    Raises
    ------
    ComputationError
        If one of the processes is lost.
    """
    here = sys.platform.startswith("linux")
    workers = min(len(os.sched_getaffinity(0)), len(items)) if here else 1
    if workers < 2 or len(items) <= FEW:
        with one_thread():
            yield from map(task, items)
        return
    # What a process is split off with need not be sent to it: tasks and items may be large.
    _tasks.append((task, items))
    others = set(multiprocessing.active_children())
    try:
        context = multiprocessing.get_context("fork")
        with ProcessPoolExecutor(workers, context, _begin, (os.getpid(),)) as pool:
            try:
                # Python drops an exception that a signal raises while a process is split off.
                with uninterrupted(), warnings.catch_warnings():
                    # Progress runs in a thread of its own, which the processes do not use.
                    warnings.simplefilter("ignore", DeprecationWarning)
                    waiting = [pool.submit(_do, number) for number in range(len(items))]
                for future in waiting:
                    while not wait([future], HEARING).done:
                        pass
                    with loss_of_workers("close other programs and begin anew"):
                        answer = future.result()
                    yield answer
            except BaseException:
                with uninterrupted():
                    pool.shutdown(wait=False, cancel_futures=True)
                    _end(set(multiprocessing.active_children()) - others)
                raise
    finally:
        _tasks.pop()


@contextmanager
def loss_of_workers(
    remedy: str, loss: type[Exception] | tuple[type[Exception], ...] = BrokenExecutor
) -> Iterator[None]:
    """Name a process that ended before it had answered.

    Parameters
    ----------
    remedy : str
        What to do.
    loss : type of Exception, or tuple of these
        What the executor raises then.

    Raises
    ------
    ComputationError
        In place of that.
    """
    try:
        yield
    except FlexmechError:
        raise
    except loss as error:
        reason = one_line(f"{type(error).__name__}: {error}", 200)
        raise ComputationError(
            f"a worker was lost, for want of memory perhaps ({reason}); {remedy}"
        ) from error


def _end(processes: Iterable[BaseProcess]) -> None:
    """End processes that do not end by themselves: nobody waits for their answers."""
    last = time.monotonic() + GRACE
    for process in processes:
        process.join(max(0.0, last - time.monotonic()))
    for process in processes:
        if process.is_alive():
            process.kill()
        process.join()


def _do(number: int) -> Any:
    task, items = _tasks[-1]
    return task(items[number])


def _begin(parent: int) -> None:
    """In a new process: the one that waits for it answers signals, and takes it along."""
    for number in STOPPING:
        signal.signal(number, signal.SIG_IGN)
    ctypes.CDLL(None).prctl(ENDS_WITH_PARENT, signal.SIGKILL)
    if os.getppid() != parent:  # it ended before that
        os._exit(1)
    one_thread().__enter__()
