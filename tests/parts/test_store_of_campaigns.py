"""Files of a campaign of designs: the same bytes whoever computes it, however it is interrupted.

Designs are computed by a function in the place of the mechanism.
"""

from __future__ import annotations

import json
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Timer
from typing import Any

import numpy as np
import pytest
import zarr

from flexmech import ComputationError, InputError
from flexmech.studies import Correlation, Goal, Limit, Output, optimum_study, sweep_study
from flexmech.studies.evaluation import Evaluated, Task
from flexmech.studies.scatter import Scatter
from tests.support.study_data import Scripted, bytes_of, density, study, thickness

CHUNK = 256
COUNT, STORE = 3 * CHUNK + 5, "designs.zarr"
SWEEP = study(thickness(1e-3, 3e-3), thickness(1e-3, 3e-3, link="rocker"))


def scripted(designs: np.ndarray) -> np.ndarray:
    """A number of every design, and none of some."""
    numbers = np.sin(1e4 * designs[:, :1]) + designs[:, 1:]
    return np.where(numbers < -0.9, np.nan, numbers)


class StoppedError(Exception):
    """Interruption of a campaign."""


@dataclass
class Counting(Scripted):
    """Workers that note how many designs each of their tasks has, but those of finer models."""

    seconds: float = 0.0
    tasks: list[int] = field(default_factory=list)

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        found = super().submit(fn, *args, **kwargs).result().found
        future: Future[Any] = Future()
        future.set_result(Task(found, self.seconds * len(args[1])))
        if args[2] == 1:
            self.tasks.append(len(args[1]))
        return future


class Backwards(Scripted):
    """Workers of which the last that got a task is the first to be done."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        waiting = self.__dict__.setdefault("waiting", [])
        if not waiting:
            Timer(0.02, self._finish).start()
        waiting.append((future, super().submit(fn, *args).result()))
        return future

    def _finish(self) -> None:
        waiting = self.__dict__["waiting"]
        while waiting:
            future, found = waiting.pop()
            future.set_result(found)


class Failing(Executor):
    """Workers that end with an error."""

    def __init__(self, error: Exception) -> None:
        self.error = error

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_exception(self.error)
        return future


def campaign(folder: Path, executor: Executor, **more: Any):
    return sweep_study(SWEEP, samples=COUNT, executor=executor, folder=folder, **more)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole")
    campaign(folder, Scripted(scripted))
    return folder


def interrupted(folder: Path, chunks: int) -> None:
    """A campaign that is stopped when so many chunks were done, the last task not yet kept."""

    def stop(label: str, done: int, total: int) -> None:
        if done >= chunks * CHUNK:
            raise StoppedError

    with pytest.raises(StoppedError):
        campaign(folder, Scripted(scripted), progress=stop)


def test_the_store_holds_numbers_statuses_and_names_and_neither_place_nor_time(whole):
    group = zarr.open_group(store=whole / STORE, mode="r")
    numbers = group["numbers"][:]
    np.testing.assert_array_equal(numbers[:, :2], SWEEP.sample(COUNT))
    np.testing.assert_array_equal(numbers[:, 2:], scripted(SWEEP.sample(COUNT)))
    failed = np.isnan(numbers[:, 2])
    assert 0 < failed.sum() < COUNT
    statuses = np.array(group.attrs["statuses"])[group["status"][:]]
    assert (statuses == np.where(failed, "refused", "ok")).all()
    names = {name: group.attrs[name] for name in ("variables", "outputs", "units")}
    assert names == {"variables": SWEEP.names, "outputs": ["mass"], "units": ["m", "m", "kg"]}
    for file in whole.rglob("zarr.json"):
        text = file.read_text()
        assert str(whole) not in text
        assert "/" not in json.dumps(json.loads(text)["attributes"])


def test_bytes_are_those_of_one_process_of_threads_and_of_tasks_that_end_backwards(whole, tmp_path):
    campaign(tmp_path / "backwards", Backwards(scripted))
    assert bytes_of(tmp_path / "backwards") == bytes_of(whole)
    for name, workers in (("one", None), ("two", ThreadPoolExecutor(2))):
        sweep_study(SWEEP, samples=8, executor=workers, folder=tmp_path / name)
    assert bytes_of(tmp_path / "one") == bytes_of(tmp_path / "two")


@pytest.mark.parametrize("chunks", [1, 3])
def test_after_an_interruption_what_is_left_is_computed_and_bytes_are_the_same(
    whole, tmp_path, chunks
):
    interrupted(tmp_path, chunks)
    assert bytes_of(tmp_path) != bytes_of(whole)
    kept = int(zarr.open_group(store=tmp_path / STORE, mode="r")["done"][:].sum())
    assert 0 < kept < chunks * CHUNK
    resumed = Counting(scripted)
    campaign(tmp_path, resumed, resume=True)
    assert sum(resumed.tasks) == COUNT - kept
    assert bytes_of(tmp_path) == bytes_of(whole)
    idle = Counting(scripted)
    assert campaign(tmp_path, idle, resume=True).dataset.sizes["design"] == COUNT
    assert not idle.tasks
    assert bytes_of(tmp_path) == bytes_of(whole)


def test_what_a_killed_process_leaves_is_removed_and_unmarked_tasks_are_done_anew(whole, tmp_path):
    interrupted(tmp_path, 3)
    store = tmp_path / STORE
    done = next((store / "done" / "c").iterdir())
    done.unlink()
    (store / "status" / "c" / done.name).unlink()
    (store / "numbers" / "c" / "1").mkdir(parents=True, exist_ok=True)
    (store / "numbers" / "c" / "1" / "0.8f3e.partial").write_bytes(b"half")
    (tmp_path / f".{STORE}.old" / "numbers").mkdir(parents=True)
    (tmp_path / f".{STORE}.new").mkdir()
    campaign(tmp_path, Scripted(scripted), resume=True)
    assert bytes_of(tmp_path) == bytes_of(whole)
    assert [path.name for path in tmp_path.iterdir()] == [STORE]


def test_tasks_of_costly_designs_are_one_each_and_those_of_cheap_ones_grow():
    """A second of work, whatever a design costs; at the end there is some for every worker."""
    stress = {"mass": Output("peak_stress")}
    costly, cheap = (Counting(scripted, seconds) for seconds in (2.0, 0.01))
    sweep_study(replace(SWEEP, outputs=stress), samples=40, executor=costly)
    assert costly.tasks == [1] * 40
    sweep_study(SWEEP, samples=COUNT, executor=cheap)
    assert max(cheap.tasks) <= 100
    pool = Counting(scripted, 0.001)
    pool._max_workers = 2
    sweep_study(SWEEP, samples=COUNT, executor=pool)
    assert max(pool.tasks) > 4 * pool.tasks[0]
    assert pool.tasks[-1] <= 16
    assert sum(pool.tasks) == COUNT


def test_what_is_no_executor_is_refused_with_the_name_of_one():
    class AutoExecutor:
        """Executor of submitit: it hands out jobs, which are no futures."""

        def submit(self, *task: object) -> object:
            return object()

    for begin in (
        lambda executor: sweep_study(SWEEP, samples=4, executor=executor),
        lambda executor: optimum_study(SEARCH, executor=executor),
    ):
        with pytest.raises(
            InputError, match=r"AutoExecutor is no concurrent\.futures\.Executor.*executorlib"
        ):
            begin(AutoExecutor())


def test_a_store_that_another_run_writes_is_refused(tmp_path):
    """From the first design to the last, and whoever was there first goes on."""

    def begin_another(label: str, done: int, total: int) -> None:
        if label != "designs" or not 0 < done < total:
            return
        for more in ({}, {"resume": True}):
            with pytest.raises(InputError, match="another run writes its designs there"):
                campaign(tmp_path, Scripted(scripted), **more)

    found = campaign(tmp_path, Scripted(scripted), progress=begin_another)
    again = campaign(tmp_path, Scripted(scripted), resume=True)
    assert again.dataset["mass"].identical(found.dataset["mass"])


def test_a_lost_worker_is_told_with_the_remedy_and_a_refusal_is_no_lost_worker(tmp_path):
    with pytest.raises(ComputationError, match="--resume"):
        campaign(tmp_path / "lost", Failing(RuntimeError("KilledWorker")))
    with pytest.raises(InputError, match=r"^no such engine$"):
        campaign(tmp_path / "refused", Failing(InputError("no such engine")))


# --- searches -----------------------------------------------------------------------------------

SEARCH = replace(SWEEP, limits=(Limit("mass", greatest=0.1),), goals=(Goal("mass", "max"),))


def masses(designs: np.ndarray) -> np.ndarray:
    """Masses of crank, coupler and rocker by the thicknesses of the last two."""
    links = 2923.0 * 25.4e-3 * (designs @ np.array([0.2794, 0.2667]))
    return (2698.0 * 4.24e-3 * 25.4e-3 * 0.102 + links)[:, None]


def search(folder: Path, **more: Any):
    return optimum_study(SEARCH, **({"executor": Scripted(masses)} | more), folder=folder).dataset


@pytest.mark.thorough
def test_a_search_goes_on_from_what_is_kept_and_ends_with_the_same_bytes(tmp_path):
    """A search that is done computes nothing anew; another one or a sweep is none of it."""
    done, stopped = tmp_path / "done", tmp_path / "stopped"
    found = search(done)
    assert found["mass"].item() == pytest.approx(0.1, rel=1e-4)

    def stop(label: str, count: int, total: int) -> None:
        if count >= 40:
            raise StoppedError

    with pytest.raises(StoppedError):
        search(stopped, progress=stop)
    assert bytes_of(stopped) != bytes_of(done)
    assert search(stopped, resume=True).identical(found)
    assert bytes_of(stopped) == bytes_of(done)
    idle = Counting(scripted)
    assert search(done, resume=True, executor=idle).identical(found)
    assert not idle.tasks
    other = replace(SEARCH, limits=(Limit("mass", greatest=0.11),))
    with pytest.raises(InputError, match="limits is "):
        optimum_study(other, folder=done, resume=True)
    with pytest.raises(InputError, match="of another study"):
        sweep_study(SEARCH, folder=done, resume=True)


# --- samples around the designs of a search -----------------------------------------------------

SCATTERED = study(
    thickness(1e-3, 3e-3),
    density(2923.0, 150.0),
    goals=(Goal("mass", "min", 90.0),),
    percentile_samples=16,
)


def test_percentiles_of_each_design_are_of_its_samples_with_the_same_random_numbers():
    """An output that is thickness times density; the same density nine in ten times for both."""

    def computed(rows: np.ndarray) -> Evaluated:
        values = rows[:, :1] * rows[:, 1:]
        return Evaluated(values, np.zeros(len(rows), dtype=int), [""] * len(rows))

    scatter = Scatter.of(SCATTERED)
    found = scatter.evaluated(scatter.designs(np.array([[0.1], [0.7]])), computed).values
    heavy = found[:, 0] / [1.2e-3, 2.4e-3]
    assert heavy[0] == pytest.approx(heavy[1], rel=1e-12)
    assert 2923.0 + 150.0 < heavy[0] < 2923.0 + 1.6 * 150.0


def test_what_a_search_chooses_goes_with_nothing_and_something_must_be_left_to_choose():
    pair = Correlation(("density", SCATTERED.names[0]), 0.9)
    with pytest.raises(InputError, match="cannot go with density"):
        optimum_study(replace(SCATTERED, correlations=(pair,)))
    with pytest.raises(InputError, match="none is left to choose"):
        optimum_study(study(density(2923.0, 150.0), goals=(Goal("mass"),)))
