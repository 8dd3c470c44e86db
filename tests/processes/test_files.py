"""Full disks, folders that vanish or cannot be written, two runs at once: all files or none."""

from __future__ import annotations

import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import flexmech
from tests.processes.forked import TEMPORARY, Ended, Place, files_of, run, start, until
from tests.support.command import MODELS

QUICK = ("--engine", "reference", "--elements", "2", "--angles", "0,90", "--speeds", "0,10")
STEEL, ALUMINIUM = (MODELS / f"{name}_fourbar.toml" for name in ("steel", "aluminium"))
TABLES = ["frequencies.csv", "frequencies.nc", "summary.txt"]


def frequencies(model: Path = STEEL, out: str | Path = "out") -> tuple[object, ...]:
    return ("frequencies", model, *QUICK, "--no-plots", "--out", out)


def assert_one_error(ended: Ended, text: str) -> None:
    """Exit code 2 and one line that names the place and says what cannot be done."""
    assert (ended.code, ended.stderr.count("\n")) == (2, 1), ended.stderr
    assert ended.stderr.startswith("error: ")
    assert text in ended.stderr


def largest_file(size: int) -> Callable[[], None]:
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def to(number: int, path: str | None) -> Callable[[], None]:
    """Standard output or error goes to a file, or is closed."""
    return lambda: os.close(number) if path is None else os.dup2(os.open(path, os.O_RDWR), number)


def test_a_full_disk_leaves_the_earlier_files(tmp_path: Path) -> None:
    """It is full as the dataset of some 30 kB is written, behind a table of 2 kB."""
    out = tmp_path / "out" / "frequencies"
    out.mkdir(parents=True)
    (out / "frequencies.csv").write_text("old")
    ended = run(tmp_path, *frequencies(), first=largest_file(12_000))
    assert_one_error(ended, "--out: cannot write to out/frequencies (")
    assert [path.name for path in out.iterdir()] == ["frequencies.csv"]
    assert (out / "frequencies.csv").read_text() == "old"


def test_a_small_file_system_that_is_full_is_told(tmp_path: Path) -> None:
    mount = f"mount -t tmpfs -o size=16384 tmpfs {tmp_path}"
    if subprocess.run(["unshare", "-rm", "sh", "-c", mount], capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    words = [sys.executable, "-m", "flexmech", *map(str, frequencies(out=tmp_path))]
    ended = subprocess.run(
        [
            "unshare",
            "-rm",
            "sh",
            "-c",
            f"{mount}; {' '.join(words)}; c=$?; ls -A {tmp_path}; exit $c",
        ],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(MODELS.parent)},
        timeout=300,
    )
    assert_one_error(Ended(ended.returncode, "", ended.stderr), "--out: cannot write to")
    assert ended.stdout == ""


@pytest.mark.parametrize("path", ["/dev/full", None], ids=["full", "closed"])
def test_output_that_cannot_be_printed_is_told(path: str | None, tmp_path: Path) -> None:
    slider_crank = MODELS / "slider_crank.toml"
    ended = run(tmp_path, "check", slider_crank, "--no-plots", "--out", "out", first=to(1, path))
    assert_one_error(ended, "stdout: cannot be written")


@pytest.mark.parametrize("path", ["/dev/full", None], ids=["full", "closed"])
def test_messages_that_cannot_be_printed_leave_the_exit_code(
    path: str | None, tmp_path: Path
) -> None:
    assert run(tmp_path, "check", "nothing.toml", first=to(2, path)).code == 2


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    ended = run(tmp_path, *frequencies(out="/proc/flexmech"))
    assert_one_error(ended, "--out: cannot write to /proc/flexmech")


def test_a_working_folder_that_is_gone_is_told(tmp_path: Path) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    assert_one_error(run(gone, *frequencies(), first=gone.rmdir), "--out: cannot write to out")


def test_a_folder_that_vanishes_before_files_are_written_is_made_again(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "out"
    out.mkdir(parents=True)
    ended = run(
        tmp_path,
        *frequencies(out="deep/out"),
        at=Place("open", STEEL.name),
        do=lambda: shutil.rmtree(out.parent),
    )
    assert (ended.code, files_of(out / "frequencies")) == (0, TABLES), ended.stderr


def test_a_folder_that_vanishes_as_files_are_written_is_told(tmp_path: Path) -> None:
    out = tmp_path / "out"
    vanishes = Place("open", "frequencies.csv")
    ended = run(tmp_path, *frequencies(), at=vanishes, do=lambda: shutil.rmtree(out))
    assert_one_error(ended, "--out: cannot write to out")
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_ends_while_another_writes_keeps_its_temporary_folder(tmp_path: Path) -> None:
    """The set is that of the run that ends last, whole."""
    slow = start(
        tmp_path,
        *frequencies(ALUMINIUM),
        at=Place("open", "frequencies.csv"),
        do=lambda: os.kill(os.getpid(), signal.SIGSTOP),
    )
    slow.wait_until_stopped()
    out = tmp_path / "out" / "frequencies"
    assert run(tmp_path, *frequencies(STEEL)).code == 0
    assert sorted(path.name for path in out.iterdir() if path.is_file()) == TABLES
    steel = (out / "frequencies.csv").read_text()
    os.kill(slow.pid, signal.SIGCONT)
    assert slow.wait().code == 0
    assert_whole(out)
    assert (out / "frequencies.csv").read_text() != steel


def test_a_run_waits_while_another_moves_its_files(tmp_path: Path) -> None:
    first = start(
        tmp_path,
        *frequencies(ALUMINIUM),
        at=Place("os.rename", "^out/frequencies/frequencies.nc"),
        do=lambda: os.kill(os.getpid(), signal.SIGSTOP),
    )
    first.wait_until_stopped()
    waits = tmp_path / "waits"
    other = start(tmp_path, *frequencies(STEEL), at=Place("fcntl.flock", ""), do=waits.touch)
    until("the other asks for the folder", waits.exists)
    assert files_of(tmp_path / "out")[-1] == "frequencies/frequencies.csv"
    os.kill(first.pid, signal.SIGCONT)
    assert first.wait().code == other.wait().code == 0
    waits.unlink()
    assert_whole(tmp_path / "out" / "frequencies")


def assert_whole(out: Path) -> None:
    """Table, dataset and summary are of one run, and no temporary folder is left."""
    assert files_of(out) == TABLES
    assert not list(out.glob(f"{TEMPORARY}*"))
    result = flexmech.MovingFrequencies.load(out / "frequencies.nc")
    assert str(result.summary()) in (out / "summary.txt").read_text(encoding="utf-8")
    result.save(out.parent / "again")
    again = (out.parent / "again" / "frequencies.csv").read_text()
    assert again == (out / "frequencies.csv").read_text()
