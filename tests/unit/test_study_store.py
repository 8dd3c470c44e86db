"""What a study keeps: the same bytes whoever computes it, and however often it was interrupted."""

from __future__ import annotations

import json
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zarr

from flexmech.errors import ComputationError, InputError
from flexmech.studies import Goal, Limit, Output, optimum_study, sweep_study
from flexmech.studies.designs.campaign import TASK
from flexmech.studies.designs.evaluation import MOST_LETTERS, STATUSES, Evaluated
from flexmech.studies.designs.store import NAME, DesignStore
from tests.support.study_data import Scripted, bytes_of, study, thickness

COUNT = 3 * TASK + 5
SWEEP = study(thickness(1e-3, 3e-3), thickness(1e-3, 3e-3, link="rocker"))


def scripted(designs: np.ndarray) -> np.ndarray:
    """A number of every design, and none of some."""
    found = np.sin(1e4 * designs[:, :1]) + designs[:, 1:]
    return np.where(found < -0.9, np.nan, found)


class StoppedError(Exception):
    """What ends a study in its midst."""


class Stopping(Scripted):
    """Workers that are stopped after some tasks."""

    tasks = 0

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        if self.tasks == self.most:
            raise StoppedError
        self.tasks += 1
        return super().submit(fn, *args, **kwargs)

    def __init__(self, function: Any, most: int) -> None:
        super().__init__(function)
        self.most = most


class Backwards(Scripted):
    """Workers of which the last that got a task is the first to be done."""

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self.waiting: list[tuple[Future[Any], Any]] = []

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self.waiting.append((future, args))
        if len(self.waiting) == 4:
            for each, given in reversed(self.waiting):
                each.set_result(super().submit(fn, *given).result())
        return future


class Lost(Executor):
    """Workers that are killed."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_exception(RuntimeError("KilledWorker: three attempts"))
        return future


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole")
    sweep_study(SWEEP, samples=COUNT, executor=Scripted(scripted), folder=folder)
    return folder


class TestContent:
    def test_numbers_statuses_and_names(self, whole: Path) -> None:
        group = zarr.open_group(store=whole / NAME, mode="r")
        assert set(group.array_keys()) == {"numbers", "status", "reasons", "done"}
        numbers, status = group["numbers"][:], group["status"][:]
        assert numbers.shape == (COUNT, 3)
        np.testing.assert_array_equal(numbers[:, :2], SWEEP.sample(COUNT))
        np.testing.assert_array_equal(numbers[:, 2:], scripted(SWEEP.sample(COUNT)))
        assert set(status.tolist()) == {0, STATUSES.index("refused")}
        assert group["done"][:].tolist() == [TASK, TASK, TASK, 5]
        assert group.attrs["variables"] == SWEEP.names
        assert group.attrs["outputs"] == ["mass"]
        assert group.attrs["units"] == ["m", "m", "kg"]
        assert group.attrs["statuses"] == list(STATUSES)
        assert group["reasons"].shape == (COUNT, MOST_LETTERS)

    def test_neither_time_nor_host_nor_path(self, whole: Path) -> None:
        for file in whole.rglob("zarr.json"):
            text = file.read_text()
            assert str(whole) not in text
            assert "/" not in json.dumps(json.loads(text)["attributes"])

    def test_every_chunk_is_written_whatever_is_in_it(self, tmp_path: Path) -> None:
        """Zarr leaves out chunks of the fill value, such as those without a reason."""
        sound = Scripted(lambda designs: designs[:, :1])
        sweep_study(SWEEP, samples=3, executor=sound, folder=tmp_path)
        for name in ("numbers/c/0/0", "status/c/0", "reasons/c/0/0", "done/c/0"):
            assert (tmp_path / NAME / name).is_file()

    def test_reasons_are_cut_between_letters(self, tmp_path: Path) -> None:
        store = DesignStore.create(
            tmp_path / NAME, 2, {"variables": ["a"], "outputs": ["b"]}, chunk=2
        )
        reason = "µ" * MOST_LETTERS
        found = Evaluated(np.array([[1.0], [np.nan]]), np.array([0, 5]), ["", reason])
        store.write(0, np.array([[3.0], [4.0]]), found)
        designs, read = store.read()
        assert designs.tolist() == [[3.0], [4.0]]
        assert read.reasons == ["", "µ" * (MOST_LETTERS // 2)]
        np.testing.assert_array_equal(read.values, found.values)


class TestSameBytes:
    def test_of_one_process_and_of_several_threads(self, tmp_path: Path) -> None:
        for name, workers in (("one", None), ("two", ThreadPoolExecutor(2))):
            found = sweep_study(SWEEP, samples=20, executor=workers, folder=tmp_path / name)
            found.save(tmp_path / name, formats=())
            (tmp_path / name / "designs.nc").unlink()
        assert bytes_of(tmp_path / "one") == bytes_of(tmp_path / "two")

    def test_in_whatever_order_tasks_end(self, whole: Path, tmp_path: Path) -> None:
        sweep_study(SWEEP, samples=COUNT, executor=Backwards(scripted), folder=tmp_path)
        assert bytes_of(tmp_path) == bytes_of(whole)

    @pytest.mark.parametrize("tasks", [0, 1, 3])
    def test_after_an_interruption(self, whole: Path, tmp_path: Path, tasks: int) -> None:
        self.interrupted(tmp_path, tasks)
        assert bytes_of(tmp_path) != bytes_of(whole)
        left = DesignStore(tmp_path / NAME, TASK).pending()
        assert len(left) in (4 - tasks, 5 - tasks)
        resumed = Stopping(scripted, 4)
        sweep_study(SWEEP, samples=COUNT, executor=resumed, folder=tmp_path, resume=True)
        assert resumed.tasks == len(left)
        assert bytes_of(tmp_path) == bytes_of(whole)

    def test_a_study_that_is_done_is_not_computed_again(self, whole: Path) -> None:
        before = bytes_of(whole)
        idle = Stopping(scripted, 0)
        found = sweep_study(SWEEP, samples=COUNT, executor=idle, folder=whole, resume=True)
        assert found.dataset.sizes["design"] == COUNT
        assert bytes_of(whole) == before

    def test_what_a_killed_process_leaves_is_removed(self, whole: Path, tmp_path: Path) -> None:
        self.interrupted(tmp_path, 2)
        store = tmp_path / NAME
        (store / "numbers" / "c" / "1").mkdir(parents=True, exist_ok=True)
        (store / "numbers" / "c" / "1" / "0.8f3e.partial").write_bytes(b"half")
        (tmp_path / f".{NAME}.old" / "numbers").mkdir(parents=True)
        (tmp_path / f".{NAME}.new").mkdir()
        sweep_study(SWEEP, samples=COUNT, executor=Scripted(scripted), folder=tmp_path, resume=True)
        assert bytes_of(tmp_path) == bytes_of(whole)
        assert [path.name for path in tmp_path.iterdir()] == [NAME]

    def test_a_task_that_was_written_but_not_marked(self, whole: Path, tmp_path: Path) -> None:
        self.interrupted(tmp_path, 3)
        done = next((tmp_path / NAME / "done" / "c").iterdir())
        done.unlink()
        (tmp_path / NAME / "status" / "c" / done.name).unlink()
        sweep_study(SWEEP, samples=COUNT, executor=Scripted(scripted), folder=tmp_path, resume=True)
        assert bytes_of(tmp_path) == bytes_of(whole)

    @staticmethod
    def interrupted(folder: Path, tasks: int) -> None:
        """A study that is stopped when so many tasks were given out, the last not yet kept."""

        def one_after_the_other(label: str, done: int, total: int) -> None:
            del label, total
            if done >= tasks * TASK:
                raise StoppedError

        with pytest.raises(StoppedError):
            sweep_study(
                SWEEP,
                samples=COUNT,
                executor=Stopping(scripted, 0) if tasks == 0 else Scripted(scripted),
                progress=one_after_the_other,
                folder=folder,
            )

    def test_workers_that_are_killed_are_told_in_one_line(self, tmp_path: Path) -> None:
        with pytest.raises(ComputationError) as caught:
            sweep_study(SWEEP, samples=COUNT, executor=Lost(), folder=tmp_path)
        assert str(caught.value) == (
            "a worker was lost, for want of memory perhaps (RuntimeError: KilledWorker: three "
            "attempts); what is done is kept with --out: go on with --resume and fewer workers"
        )

    def test_what_a_study_refuses_is_no_lost_worker(self, tmp_path: Path) -> None:
        class Refusing(Lost):
            def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
                future: Future[Any] = Future()
                future.set_exception(InputError("no such engine"))
                return future

        with pytest.raises(InputError, match=r"^no such engine$"):
            sweep_study(SWEEP, samples=COUNT, executor=Refusing(), folder=tmp_path)


class TestSearches:
    """A search is repeated from what is kept, and goes on where that ends."""

    ONE = study(
        thickness(1e-3, 3e-3),
        thickness(1e-3, 3e-3, link="rocker"),
        outputs={"mass": Output("mass"), "torque": Output("peak_driving_torque", angles=8)},
        limits=(Limit("torque", least=0.02),),
        goals=(Goal("mass"),),
    )

    @pytest.fixture(scope="class")
    @classmethod
    def whole(cls, tmp_path_factory: pytest.TempPathFactory) -> Path:
        folder = tmp_path_factory.mktemp("search")
        cls.found = optimum_study(cls.ONE, folder=folder).dataset
        return folder

    found: Any = None

    @pytest.mark.parametrize("least", [pytest.param(5, marks=pytest.mark.thorough), 60])
    def test_that_are_interrupted(self, whole: Path, tmp_path: Path, least: int) -> None:
        def stop(label: str, done: int, total: int) -> None:
            del label, total
            if done >= least:
                raise StoppedError

        with pytest.raises(StoppedError):
            optimum_study(self.ONE, folder=tmp_path, progress=stop)
        kept, whole_count = (len(DesignStore(f / NAME, 8).read()[0]) for f in (tmp_path, whole))
        assert 0 < kept < whole_count
        again = optimum_study(self.ONE, folder=tmp_path, resume=True).dataset
        assert bytes_of(tmp_path) == bytes_of(whole)
        assert again.identical(self.found)

    def test_keep_every_design_once(self, whole: Path) -> None:
        designs, found = DesignStore(whole / NAME, 8).read()
        assert len(np.unique(designs, axis=0)) == len(designs) > 60
        assert (found.status == 0).all()
        assert np.isfinite(found.values).all()

    def test_that_are_done_compute_nothing_anew(self, whole: Path) -> None:
        before, idle = bytes_of(whole), Stopping(scripted, 0)
        again = optimum_study(self.ONE, folder=whole, resume=True, executor=idle).dataset
        assert again.identical(self.found)
        assert bytes_of(whole) == before

    def test_of_other_limits_are_other_searches(self, whole: Path) -> None:
        other = study(
            *self.ONE.variables,
            outputs=self.ONE.outputs,
            limits=(Limit("torque", least=0.03),),
            goals=self.ONE.goals,
        )
        with pytest.raises(InputError, match=r"is of another study: limits is "):
            optimum_study(other, folder=whole, resume=True)

    def test_of_a_sweep_are_none(self, whole: Path) -> None:
        with pytest.raises(InputError, match="is of another study: "):
            sweep_study(self.ONE, folder=whole, resume=True)
