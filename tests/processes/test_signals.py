"""Signals at named places of a run: one line, the exit code of shells, all files or none."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path

import pytest

from tests.processes.forked import (
    TEMPORARY,
    Place,
    files_of,
    run,
    send,
    start,
    until,
)
from tests.support.command import MODELS

MODEL = MODELS / "aluminium_fourbar.toml"
QUICK = ("--engine", "reference", "--elements", "2", "--angles", "0,90", "--speeds", "0,10")
RUN = ("frequencies", MODEL, *QUICK, "--out", "out")
WHOLE = ["frequencies.csv", "frequencies.nc", "summary.txt"]
LINES = {signal.SIGINT: "interrupted: ", signal.SIGTERM: "terminated: "}
SIGNALS = pytest.mark.parametrize("number", LINES, ids=lambda number: number.name)
BY_WORKERS = pytest.mark.skipif(
    sys.platform != "linux" or len(os.sched_getaffinity(0)) < 2, reason="one process does it all"
)
BEFORE, AFTER = False, True
# Whether the set of files is there when a signal comes at the place.
PLACES = {
    "as the model is read": (Place("open", MODEL.name), BEFORE),
    "as the temporary folder is made": (Place("tempfile.mkdtemp", TEMPORARY), BEFORE),
    "as a table is written": (Place("open", "frequencies.csv"), BEFORE),
    "as a picture is written": (Place("open", "frequencies.png"), BEFORE),
    "as files are moved": (Place("os.rename", "^out/frequencies/frequencies.nc"), AFTER),
    "as the temporary folder is removed": (
        Place("shutil.rmtree", f"^out/frequencies/{TEMPORARY}[^/]*$"),
        AFTER,
    ),
}


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """Folder with a table of an earlier run."""
    folder = tmp_path / "out" / "frequencies"
    folder.mkdir(parents=True)
    (folder / "frequencies.csv").write_text("old")
    return folder


@SIGNALS
@pytest.mark.parametrize("name", PLACES)
def test_a_signal_ends_a_run_in_one_line_with_all_files_or_none(
    name: str, number: signal.Signals, out: Path
) -> None:
    place, moved = PLACES[name]
    plots = [] if "picture" in name else ["--no-plots"]
    ended = run(out.parents[1], *RUN, *plots, at=place, do=send(number))
    assert (ended.code, ended.stderr.count("\n")) == (128 + number, 1), ended.stderr
    assert ended.stderr.startswith(LINES[number])
    assert files_of(out) == (WHOLE if moved else ["frequencies.csv"])
    assert ((out / "frequencies.csv").read_text() == "old") != moved
    assert not list(out.glob(f"{TEMPORARY}*"))


@pytest.mark.parametrize(
    ("place", "left"),
    [
        (Place("open", "frequencies.csv"), ["frequencies.csv"]),
        (Place("os.rename", "^out/frequencies/frequencies.nc"), ["frequencies.csv"]),
    ],
    ids=["as a table is written", "as files are moved"],
)
def test_a_killed_run_leaves_files_of_one_set_and_the_next_cleans_up(
    place: Place, left: list[str], out: Path
) -> None:
    assert run(out.parents[1], *RUN, "--no-plots", at=place, do=send(signal.SIGKILL)).code == -9
    assert list(out.glob(f"{TEMPORARY}*"))
    assert [path.name for path in out.iterdir() if path.is_file()] == left
    assert run(out.parents[1], *RUN, "--no-plots").code == 0
    assert files_of(out) == WHOLE
    assert not list(out.glob(f"{TEMPORARY}*"))


@SIGNALS
@pytest.mark.parametrize("module", ["numpy", "scipy"])
def test_a_signal_during_imports_ends_a_run_in_one_line(
    module: str, number: signal.Signals, tmp_path: Path
) -> None:
    """Imports swallow exceptions, or turn them into others."""
    script = f"""
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
def watch(event, arguments):
    if event == "import" and arguments[0] == "{module}":
        os.kill(os.getpid(), {int(number)})
sys.addaudithook(watch)
from flexmech.cli import main
main()
"""
    ended = subprocess.run(
        [sys.executable, "-c", script, *map(str, RUN)],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(MODELS.parent)},
        timeout=300,
    )
    assert (ended.returncode, ended.stderr.count("\n")) == (128 + number, 1), ended.stderr
    assert ended.stderr.startswith(LINES[number])
    assert files_of(tmp_path) == []


def workers_of(process: int) -> list[int]:
    """Processes that a process has started."""
    tasks = Path(f"/proc/{process}/task").glob("*/children")
    return [int(worker) for task in tasks for worker in task.read_text().split()]


def in_another_thread() -> None:
    """Take SIGINT in a thread when a file appears: the wait of the main thread goes on."""

    def take() -> None:
        until("the file is there", Path("now").exists)
        signal.pthread_kill(threading.get_ident(), signal.SIGINT)

    threading.Thread(target=take, daemon=True).start()


@BY_WORKERS
@pytest.mark.parametrize("way", ["SIGTERM", "SIGKILL", "SIGINT in another thread"])
def test_workers_at_work_end_with_the_map(way: str, tmp_path: Path) -> None:
    other = in_another_thread if way.endswith("thread") else None
    number = signal.Signals[way.split()[0]]
    long = ("--speeds", "20:60:0.1", "--modes", "6", "--elements", "16")
    model = MODELS / "steel_fourbar.toml"
    process = start(tmp_path, "stability", model, *long, "--out", "out", first=other)
    cores = len(os.sched_getaffinity(0))
    until(
        "all workers are at work and the process waits",
        lambda: (
            sum(map(ignores_signals, workers_of(process.pid))) == cores
            and state_of(process.pid) == "S"
        ),
    )
    workers = workers_of(process.pid)
    if other:
        (tmp_path / "now").touch()
    else:
        os.kill(process.pid, number)
    ended = process.wait()
    until("workers end", lambda: not any(map(is_running, workers)))
    if number == signal.SIGKILL:
        assert ended.code == -number
        return
    assert (ended.code, ended.stderr.count("\n")) == (128 + number, 1), ended.stderr
    assert ended.stderr.startswith(LINES[number])


def as_a_worker_is_split_off() -> None:
    """Take SIGINT in a callback of the fork: Python drops what is raised there."""
    os.register_at_fork(before=lambda: os.kill(os.getpid(), signal.SIGINT))


@BY_WORKERS
def test_a_signal_as_workers_are_split_off_ends_the_map(tmp_path: Path) -> None:
    model = MODELS / "steel_fourbar.toml"
    quick = ("--speeds", "20:60:10", "--modes", "1", "--elements", "2", "--engine", "reference")
    ended = run(tmp_path, "stability", model, *quick, first=as_a_worker_is_split_off)
    assert (ended.code, ended.stderr.count("\n")) == (128 + signal.SIGINT, 1), ended.stderr
    assert ended.stderr.startswith(LINES[signal.SIGINT])


@BY_WORKERS
def test_a_map_that_loses_a_worker_ends_in_a_line(tmp_path: Path) -> None:
    long = ("--speeds", "20:60:0.1", "--modes", "6", "--elements", "16", "--engine", "reference")
    process = start(tmp_path, "stability", MODELS / "steel_fourbar.toml", *long, "--out", "out")
    until("a worker is at work", lambda: any(map(ignores_signals, workers_of(process.pid))))
    os.kill(next(filter(ignores_signals, workers_of(process.pid))), signal.SIGKILL)
    ended = process.wait()
    assert (ended.code, ended.stderr.count("\n")) == (1, 1), ended.stderr
    assert "a worker was lost" in ended.stderr
    assert files_of(tmp_path) == []


def ignores_signals(process: int) -> bool:
    """Whether a process ignores SIGINT and SIGTERM, as a worker at work does."""
    wanted = sum(1 << (number - 1) for number in LINES)
    ignored = re.search(r"SigIgn:\s*(\w+)", Path(f"/proc/{process}/status").read_text())
    return ignored is not None and int(ignored[1], 16) & wanted == wanted


def state_of(process: int) -> str:
    """``S`` of a process that sleeps, ``Z`` of one that has ended; empty if there is none."""
    with suppress(OSError):
        return Path(f"/proc/{process}/stat").read_text().rpartition(") ")[2][0]
    return ""


def is_running(process: int) -> bool:
    """Whether there is such a process that has not ended."""
    return state_of(process) not in ("", "Z")
