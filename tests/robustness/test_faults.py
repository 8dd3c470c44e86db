"""Full disks, signals, vanished folders and two runs at once: files come as whole sets, or not."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import xarray as xr
from typer.testing import CliRunner

from flexmech.analyses import MovingFrequencies
from flexmech.cli import app
from flexmech.files import PREFIX, moved_into
from tests.robustness.writer import NAMES

if os.name == "nt":
    pytest.skip("POSIX signals, shells and limits of resources", allow_module_level=True)

import resource

WRITER = Path(__file__).with_name("writer.py")
MODELS = Path(__file__).parents[2] / "models"
QUICK = ("--engine", "reference", "--elements", "2", "--angles", "0,90", "--speeds", "0,10")
LINES = {signal.SIGINT: "interrupted: ", signal.SIGTERM: "terminated: "}
PICTURES = [f"{name}.png" for name in ("frequencies", "mode_shapes", "speed_effect")]
WHOLE = ["frequencies.csv", "frequencies.nc", *PICTURES, "summary.txt"]
SEED = 20240


def command(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "flexmech", *map(str, arguments)]


def frequencies(out: Path, model: str = "aluminium_fourbar", *more: str) -> list[str]:
    return command("frequencies", MODELS / f"{model}.toml", *QUICK, "--out", out, *more)


def run(
    arguments: list[str], *, cwd: Path | None = None, before: Callable[[], None] | None = None
) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(MODELS.parent)}
    return subprocess.run(
        arguments, capture_output=True, text=True, cwd=cwd, preexec_fn=before, env=environment
    )


def start(arguments: list[str]) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(MODELS.parent)}
    pipe = subprocess.PIPE
    return subprocess.Popen(arguments, stdout=pipe, stderr=pipe, text=True, env=environment)


def names(folder: Path) -> list[str]:
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())


def one_error(done: subprocess.CompletedProcess[str], code: int = 2) -> str:
    assert done.returncode == code, done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith("error: "), done.stderr
    return done.stderr


# What the disk does.


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("largest", "options"), [(12_000, ["--no-plots"]), (1000, []), (40_000, [])]
)
def test_a_disk_that_is_full_is_told_and_nothing_is_left(
    largest: int, options: list[str], tmp_path: Path
) -> None:
    """Tables have some 2 kB here, the NetCDF file 30 kB, and pictures more."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))

    (tmp_path / "frequencies.csv").write_text("old")
    done = run([*frequencies(tmp_path), *options], before=limit)
    assert f"--out: cannot write to {tmp_path} (" in one_error(done)
    assert names(tmp_path) == ["frequencies.csv"]
    assert (tmp_path / "frequencies.csv").read_text() == "old"


@pytest.mark.thorough
@pytest.mark.parametrize("pages", range(1, 40, 3))
def test_a_small_file_system_that_is_full(pages: int, tmp_path: Path) -> None:
    size = 4096 * pages
    mount = f"mount -t tmpfs -o size={size} tmpfs {tmp_path}"
    if subprocess.run(["unshare", "-rm", "sh", "-c", mount], capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    inner = " ".join(frequencies(tmp_path))
    done = run(
        ["unshare", "-rm", "sh", "-c", f"{mount}; {inner}; code=$?; ls -A {tmp_path}; exit $code"]
    )
    assert "--out: cannot write to" in one_error(done)
    assert done.stdout == ""


@pytest.mark.thorough
@pytest.mark.parametrize("redirect", [">/dev/full", ">&-", "| head -0"])
def test_output_that_cannot_be_printed_is_told_in_one_line(redirect: str) -> None:
    text = " ".join(command("check", MODELS / "slider_crank.toml"))
    done = run(["bash", "-c", f"{text} {redirect}; exit ${{PIPESTATUS[0]}}"])
    assert "error: stdout: cannot be written" in one_error(done)


@pytest.mark.thorough
@pytest.mark.parametrize("redirect", ["2>/dev/full", "2>&-"])
def test_messages_that_cannot_be_printed_leave_the_exit_code(redirect: str) -> None:
    text = " ".join(command("check", "nothing.toml"))
    assert run(["bash", "-c", f"{text} {redirect}"]).returncode == 2


# Folders.


def test_a_folder_that_nobody_can_write_is_refused_before_the_work() -> None:
    done = CliRunner().invoke(app, frequencies(Path("/proc/flexmech"))[3:])
    assert done.exit_code == 2
    assert done.stderr.startswith("error: --out: cannot write to /proc/flexmech")
    assert done.stderr.count("\n") == 1


def test_a_folder_that_vanishes_while_it_computes_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "deep" / "out"
    out.mkdir(parents=True)
    summary = MovingFrequencies.summary

    def vanish(self: MovingFrequencies) -> object:
        shutil.rmtree(tmp_path / "deep", ignore_errors=True)
        return summary(self)

    monkeypatch.setattr(MovingFrequencies, "summary", vanish)
    done = CliRunner().invoke(app, frequencies(out, "steel_fourbar", "--no-plots")[3:])
    assert done.exit_code == 0, done.output
    assert names(out) == ["frequencies.csv", "frequencies.nc", "summary.txt"]


def test_a_folder_that_vanishes_while_it_writes_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    datasets = MovingFrequencies.datasets

    def vanish(self: MovingFrequencies) -> dict[str, xr.Dataset]:
        shutil.rmtree(out)
        return datasets(self)

    monkeypatch.setattr(MovingFrequencies, "datasets", vanish)
    done = CliRunner().invoke(app, frequencies(out, "steel_fourbar", "--no-plots")[3:])
    assert done.exit_code == 2
    assert done.stderr.startswith("error: --out: cannot write to")
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.thorough
def test_a_working_folder_that_is_gone_is_told(tmp_path: Path) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    done = run(["bash", "-c", f"cd {gone}; rmdir {gone}; {' '.join(frequencies(Path('res')))}"])
    assert "--out: cannot write to res" in one_error(done)


def test_the_home_folder_is_meant_by_a_tilde(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copy(MODELS / "steel_fourbar.toml", tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    arguments = ["section", "~/steel_fourbar.toml", "--out=~/res", "--no-plots"]
    assert CliRunner().invoke(app, arguments).exit_code == 0
    tables = ["sections.csv", "sections.nc", "summary.txt", "through_thickness.csv"]
    assert names(tmp_path / "res") == tables
    missing = CliRunner().invoke(app, ["check", "~nobody-of-this-name/model.toml"])
    assert missing.exit_code == 2
    assert "~nobody-of-this-name/model.toml: there is no such home folder" in missing.stderr


# Signals.


def wait_for_handlers(process: subprocess.Popen[str]) -> None:
    """Until Python answers SIGTERM; before that the interpreter itself starts."""
    bit = 1 << (signal.SIGTERM - 1)
    status = Path(f"/proc/{process.pid}/status")
    while process.poll() is None:
        caught = next(line for line in status.read_text().splitlines() if "SigCgt" in line)
        if int(caught.split()[1], 16) & bit:
            return
        time.sleep(0.001)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> float:
    """How long a run takes after Python answers signals, in s."""
    process = start(frequencies(tmp_path_factory.mktemp("undisturbed") / "out"))
    wait_for_handlers(process)
    since = time.monotonic()
    process.communicate()
    assert process.returncode == 0
    return time.monotonic() - since


def check_signal(delay: float, number: int, folder: Path) -> None:
    """A run that gets a signal after a time ends in one line, with a whole set or none."""
    process = start(frequencies(folder / "out"))
    wait_for_handlers(process)
    time.sleep(delay)
    process.send_signal(number)
    _, stderr = process.communicate()
    if process.returncode == 0:  # it was faster
        return
    assert (process.returncode, stderr.count("\n")) == (128 + number, 1), stderr
    assert stderr.startswith(LINES[signal.Signals(number)])
    assert names(folder / "out") in ([], WHOLE)  # just before the end the set is there
    assert not list(folder.rglob(f"{PREFIX}*"))


NEEDS_PROC = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs /proc")
SIGNALS = pytest.mark.parametrize(
    "number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"]
)


@NEEDS_PROC
@SIGNALS
@pytest.mark.parametrize("delay", [0.0, 0.4])
def test_a_signal_ends_a_run_in_one_line(delay: float, number: int, tmp_path: Path) -> None:
    check_signal(delay, number, tmp_path)


@pytest.mark.thorough
@NEEDS_PROC
@SIGNALS
@pytest.mark.parametrize("part", range(1, 26))
def test_a_signal_at_any_time_ends_a_run_in_one_line(
    part: int, number: int, undisturbed: float, tmp_path: Path
) -> None:
    """From start to end, however long these are apart."""
    check_signal(part / 25 * undisturbed, number, tmp_path)


@pytest.mark.thorough
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_a_signal_while_pictures_are_drawn_leaves_the_earlier_set(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "frequencies.csv").write_text("old")
    (tmp_path / "frequencies.png").write_text("old")
    script = (
        "import os, sys; from flexmech.analyses import MovingFrequencies as M; "
        f"M.figures = lambda self: os.kill(os.getpid(), {int(number)}); "
        "from flexmech.cli import main; main()"
    )
    arguments = frequencies(tmp_path)
    done = run([arguments[0], "-c", script, *arguments[3:]])
    assert (done.returncode, done.stderr.count("\n")) == (128 + number, 1), done.stderr
    assert names(tmp_path) == ["frequencies.csv", "frequencies.png"]
    assert {path.read_text() for path in tmp_path.iterdir()} == {"old"}


BUSY = """
import os, time
from pathlib import Path
import flexmech.analyses.stability.engine_map as engine_map
from flexmech.cli import main
def busy(solver, crank_speed):
    # A worker does not answer signals, as in a long call of compiled code.
    (Path("{folder}") / str(os.getpid())).touch()
    time.sleep(600)
engine_map._outcome = busy
main()
"""


@pytest.mark.skipif(
    sys.platform != "linux" or len(os.sched_getaffinity(0)) < 2, reason="one process does it all"
)
@pytest.mark.thorough
@pytest.mark.parametrize(
    "number",
    [signal.SIGINT, signal.SIGTERM, signal.SIGKILL],
    ids=["SIGINT", "SIGTERM", "SIGKILL"],
)
def test_workers_that_are_busy_end_with_the_map(number: int, tmp_path: Path) -> None:
    at_work = tmp_path / "at_work"
    at_work.mkdir()
    model = str(MODELS / "steel_fourbar.toml")
    options = f"--speeds 20,25,30 --elements 1 --modes 2 --prestress axial --out {tmp_path / 'out'}"
    script = BUSY.format(folder=at_work)
    process = start([sys.executable, "-c", script, "stability", model, *options.split()])
    while len(names(at_work)) < 2:
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)
    since = time.monotonic()
    process.send_signal(number)
    _, stderr = process.communicate()
    # A loaded machine takes its time: left alone, the workers would last for 600 s.
    while any(Path(f"/proc/{worker}").exists() for worker in names(at_work)):
        assert time.monotonic() - since < 60
        time.sleep(0.01)
    assert time.monotonic() - since < 60
    if number != signal.SIGKILL:
        assert (process.returncode, stderr.count("\n")) == (128 + number, 1), stderr
        assert stderr.startswith(LINES[signal.Signals(number)])


@contextmanager
def writing(folder: Path, *marks: str) -> Iterator[list[subprocess.Popen[str]]]:
    """Programs that write sets into a folder, each at work."""
    writers = [start([sys.executable, str(WRITER), str(folder), mark]) for mark in marks]
    try:
        for writer in writers:
            assert writer.stdout is not None
            assert writer.stdout.readline() == "ready\n"
        yield writers
    finally:
        for writer in writers:
            writer.kill()
            writer.communicate()


def check_one_set(folder: Path, *, whole: bool) -> None:
    """All files are of one set."""
    left = [name for name in NAMES if (folder / name).is_file()]
    assert len({(folder / name).read_text() for name in left}) == bool(left)
    assert left == NAMES or not whole


KILLS = pytest.mark.parametrize(
    "kills", [8, pytest.param(300, marks=pytest.mark.thorough)], ids=["some", "many"]
)


@KILLS
def test_a_killed_run_leaves_files_of_one_set_and_the_next_cleans_up(
    kills: int, tmp_path: Path
) -> None:
    chance = random.Random(SEED)
    for number in range(kills):
        with writing(tmp_path, str(number)) as (writer,):
            time.sleep(chance.uniform(0.0, 0.05))
            writer.kill()
            writer.wait(timeout=60)
        check_one_set(tmp_path, whole=False)
        with moved_into(tmp_path) as temporary:
            (temporary / "below").mkdir()
            for name in NAMES:
                (temporary / name).write_text("clean")
        check_one_set(tmp_path, whole=True)
        assert not list(tmp_path.glob(f"{PREFIX}*"))


@KILLS
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_a_signal_never_cuts_a_set_in_two(number: int, kills: int, tmp_path: Path) -> None:
    """Python ends by itself at SIGINT, and the system ends it at SIGTERM."""
    chance = random.Random(SEED)
    for mark in range(kills):
        with writing(tmp_path, str(mark)) as (writer,):
            time.sleep(chance.uniform(0.0, 0.05))
            writer.send_signal(number)
            writer.wait(timeout=60)
        check_one_set(tmp_path, whole=True)


def test_two_runs_in_one_folder_leave_the_set_of_one(tmp_path: Path) -> None:
    chance = random.Random(SEED)
    for _ in range(4):
        with writing(tmp_path, "a", "b", "c") as writers:
            time.sleep(chance.uniform(0.1, 0.2))
            for writer in writers:
                writer.send_signal(signal.SIGINT)
            for writer in writers:
                writer.wait(timeout=60)
        check_one_set(tmp_path, whole=True)


@pytest.mark.thorough
def test_two_runs_of_two_models_leave_the_set_of_one(tmp_path: Path) -> None:
    models = ("aluminium_fourbar", "steel_fourbar")
    for process in [start(frequencies(tmp_path, model, "--no-plots")) for model in models]:
        _, stderr = process.communicate()
        assert process.returncode == 0, stderr
    assert names(tmp_path) == ["frequencies.csv", "frequencies.nc", "summary.txt"]
    result = MovingFrequencies.load(tmp_path / "frequencies.nc")
    assert str(result.summary()) in (tmp_path / "summary.txt").read_text(encoding="utf-8")
    again = tmp_path / "again"
    result.save(again)
    assert (again / "frequencies.csv").read_text() == (tmp_path / "frequencies.csv").read_text()
