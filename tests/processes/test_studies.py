"""Studies whose processes are killed: resumed, they have the bytes of one that was not."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor
from pathlib import Path

import pytest

import flexmech
from flexmech.studies import load_study, sweep_study
from tests.processes.forked import Place, files_of, run, send
from tests.support.command import MODELS

pytest.importorskip("zarr")

# 516 designs in three tasks; a third of them cannot be assembled.
STUDY = f"""model = "{MODELS / "aluminium_fourbar.toml"}"
seed = 1
[vary."links.coupler.in_plane_thickness"]
range = ["1 mm", "3 mm"]
steps = 172
[vary.length]
paths = ["linkage.coupler"]
values = ["250 mm", "280 mm", "900 mm"]
[outputs]
f1 = {{ quantity = "lowest_frequency", speed = "0 rpm", prestress = "none", angles = 4 }}
"""
RESUME = ("sweep", "study.toml", "--no-plots", "--out", "out", "--resume")
SWEEP = RESUME[:-1]


def study(folder: Path) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "study.toml").write_text(STUDY)
    return folder


def bytes_of(out: Path) -> dict[str, bytes]:
    """The store of the designs and the table; the dataset tells the time of its command."""
    kept = [name for name in files_of(out) if ".zarr/" in name or name.endswith(".csv")]
    return {name: (out / name).read_bytes() for name in kept}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files of a study that ran to its end."""
    folder = study(tmp_path_factory.mktemp("whole"))
    ended = run(folder, *SWEEP)
    assert ended.code == 0, ended.stderr
    return bytes_of(folder / "out/sweep")


def test_a_study_that_is_killed_as_it_keeps_designs_is_resumed(
    whole: dict[str, bytes], tmp_path: Path
) -> None:
    folder, place = study(tmp_path), Place("os.rename", "numbers/c/1/0$")
    assert run(folder, *SWEEP, at=place, do=send(signal.SIGKILL)).code == -signal.SIGKILL
    assert "designs.zarr/done/c/0" in files_of(folder / "out/sweep")
    ended = run(folder, *RESUME)
    assert ended.code == 0, ended.stderr
    assert bytes_of(folder / "out/sweep") == whole
    assert not [name for name in files_of(folder / "out/sweep") if "partial" in name]


def kill_workers() -> None:
    for worker in multiprocessing.active_children():
        worker.kill()


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals")
def test_killed_workers_are_told_and_what_is_done_is_kept(
    whole: dict[str, bytes], tmp_path: Path
) -> None:
    folder, first = study(tmp_path), Place("os.rename", r"done/c/\d$")
    ended = run(folder, *SWEEP, "--workers", "2", at=first, do=kill_workers)
    assert (ended.code, ended.stderr.count("\n")) == (1, 1), ended.stderr
    assert "a worker was lost" in ended.stderr
    assert "--resume" in ended.stderr
    assert [name for name in files_of(folder / "out/sweep") if "done/c/" in name]
    assert run(folder, *RESUME).code == 0
    assert bytes_of(folder / "out/sweep") == whole


def test_a_pool_that_has_lost_its_worker_before_a_study_is_told(tmp_path: Path) -> None:
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        with pytest.raises(BrokenExecutor):
            pool.submit(os.abort).result()
        with pytest.raises(flexmech.ComputationError, match="a worker was lost"):
            sweep_study(load_study(study(tmp_path) / "study.toml"), executor=pool)


def test_a_cluster_finds_the_bytes_of_one_process(whole: dict[str, bytes], tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    folder = study(tmp_path)
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        ended = run(folder, *SWEEP, "--cluster", cluster.scheduler_address)
    assert ended.code == 0, ended.stderr
    assert bytes_of(folder / "out/sweep") == whole
