"""Studies whose processes are killed at random times: resumed, they have the bytes of any other."""

from __future__ import annotations

import functools
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from flexmech.studies import sweep_study
from flexmech.studies.designs.campaign import TASK
from flexmech.studies.designs.store import NAME
from tests.support.study_data import FILE, THICKNESS, bytes_of, study, study_file, thickness

if os.name == "nt":
    pytest.skip("POSIX signals", allow_module_level=True)

pytestmark = pytest.mark.thorough

ROOT = Path(__file__).parents[2]
SEED = 20261
KILLS = 3
# 1,200 designs, of which a third cannot be assembled: five tasks, each about a second of work.
# Masses alone would be found before anything is killed.
SWEEP = FILE.replace("steps = 3", "steps = 400").replace("angles = 4", "angles = 300")
SEARCH = FILE.replace("angles = 4", "angles = 24").replace('"40 Hz"', '"30 Hz"')
SEARCH = SEARCH[: SEARCH.index("[vary.length]")] + SEARCH[SEARCH.index("[outputs]") :]
TEXTS = {"sweep": SWEEP, "optimize": SEARCH}


def command(
    name: str, file: Path, out: Path, *more: str, program: tuple[str, ...] = ("-m", "flexmech")
) -> subprocess.Popen[str]:
    """A command on a study in a process of its own."""
    pipe, environment = subprocess.PIPE, {**os.environ, "PYTHONPATH": str(ROOT)}
    arguments = [name, str(file), "--out", str(out), "--no-plots", *more]
    return subprocess.Popen(
        [sys.executable, *program, *arguments],
        **{"stdout": pipe, "stderr": pipe, "env": environment},
        text=True,
    )


def finished(process: subprocess.Popen[str]) -> None:
    _, stderr = process.communicate(timeout=300)
    assert process.returncode == 0, stderr


def kept(out: Path) -> dict[str, str]:
    """Files of a study but the summary and the dataset, which tell the command and its time."""
    return {
        name: digest
        for name, digest in bytes_of(out).items()
        if name.startswith(NAME) or name.endswith(".csv")
    }


def workers_of(process: int) -> list[int]:
    """Workers that a process has started, and not the process that keeps their semaphores."""
    found = subprocess.run(
        ["ps", "-o", "pid=,args=", "--ppid", str(process)],
        capture_output=True,
        text=True,
        check=False,
    )
    return [int(line.split()[0]) for line in found.stdout.splitlines() if "spawn_main" in line]


def is_running(process: int) -> bool:
    """Whether there is such a process that has not ended."""
    found = subprocess.run(
        ["ps", "-o", "stat=", "-p", str(process)], capture_output=True, text=True, check=False
    )
    return bool(found.stdout.strip()) and not found.stdout.startswith("Z")


@dataclass(frozen=True)
class Whole:
    """A study that nobody killed: its file, its folder, and how long it took in s."""

    file: Path
    out: Path
    takes: float


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Whole]:
    """Each command's study, run once."""

    @functools.cache
    def run(name: str) -> Whole:
        folder = tmp_path_factory.mktemp(name)
        file = study_file(folder, text=TEXTS[name])
        since = time.monotonic()
        finished(command(name, file, folder / "whole"))
        return Whole(file, folder / "whole", time.monotonic() - since)

    return run


@pytest.mark.parametrize(
    ("name", "more"),
    [("sweep", ()), ("sweep", ("--workers", "2")), ("optimize", ())],
    ids=["sweep", "two workers", "optimize"],
)
def test_a_study_that_is_killed_again_and_again(
    name: str, more: tuple[str, ...], whole: Callable[[str], Whole], tmp_path: Path
) -> None:
    chance = random.Random(f"{SEED}/{name}/{more}")
    file, takes = whole(name).file, whole(name).takes
    out, killed = tmp_path / "killed", 0
    for _ in range(KILLS):
        resume = ("--resume",) if (out / NAME).exists() else ()
        process = command(name, file, out, *more, *resume)
        time.sleep(chance.uniform(0.4, 0.9) * takes)
        workers = workers_of(process.pid)
        process.send_signal(signal.SIGKILL)
        killed += process.wait(timeout=60) == -signal.SIGKILL
        # Workers end with the process that gives them their tasks.
        deadline = time.monotonic() + 20
        while (left := [*filter(is_running, workers)]) and time.monotonic() < deadline:
            time.sleep(0.1)
        for each in left:
            os.kill(each, signal.SIGKILL)
        assert not left
        process.communicate(timeout=60)
    assert killed
    assert (out / NAME).exists()
    finished(command(name, file, out, *more, "--resume"))
    assert kept(out) == kept(whole(name).out)
    assert kept(out)
    assert not [path for path in out.rglob("*") if "partial" in path.name or path.name[0] == "."]


# The command kills a worker itself when the first task is done: from outside, a loaded machine may
# see the first task only when the last one is done too.
KILLS_A_WORKER = """
import contextlib, multiprocessing, os, signal
from flexmech.cli import deliver, main
def kill_one(label, done, total):
    if workers := multiprocessing.active_children():
        os.kill(workers[0].pid, signal.SIGKILL)
@contextlib.contextmanager
def killing():
    yield kill_one
deliver.progress_bar = killing
main()
"""


def test_a_worker_that_is_killed_leaves_what_is_done(
    whole: Callable[[str], Whole], tmp_path: Path
) -> None:
    file, out = whole("sweep").file, tmp_path / "killed"
    process = command("sweep", file, out, "--workers", "2", program=("-c", KILLS_A_WORKER))
    _, stderr = process.communicate(timeout=300)
    assert process.returncode == 1, stderr
    assert "a worker was lost" in stderr
    assert stderr.count("\n") == 1, stderr
    assert (out / NAME / "done" / "c").exists()
    finished(command("sweep", file, out, "--resume"))
    assert kept(out) == kept(whole("sweep").out)


def test_a_worker_of_a_cluster_that_is_killed_halfway(tmp_path: Path) -> None:
    """Dask gives its tasks to the other one: the same bytes as of this process alone."""
    distributed = pytest.importorskip("distributed")
    three = study(
        thickness(1e-3, 3e-3),
        thickness(1e-3, 3e-3, link="rocker"),
        thickness(2e-3, 5e-3, link="crank"),
    )
    count = 8 * TASK
    sweep_study(three, samples=count, folder=tmp_path / "one")
    killed: list[int] = []

    def halfway(label: str, done: int, total: int) -> None:
        del label
        if not killed and done >= total // 3:
            (first, *others) = cluster.workers.values()
            assert others
            killed.append(first.pid)
            os.kill(first.pid, signal.SIGKILL)

    cluster: Any
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        folder = tmp_path / "cluster"
        sweep_study(
            three, samples=count, executor=client.get_executor(), progress=halfway, folder=folder
        )
    assert killed
    assert bytes_of(tmp_path / "cluster") == bytes_of(tmp_path / "one")


def test_a_cluster_by_its_address(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    file = study_file(tmp_path, "steps = 3", "steps = 20")
    finished(command("sweep", file, tmp_path / "one"))
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        address = cluster.scheduler_address
        finished(command("sweep", file, tmp_path / "two", "--cluster", address))
    assert kept(tmp_path / "two") == kept(tmp_path / "one")
    assert THICKNESS in (tmp_path / "two" / "designs.csv").read_text()
