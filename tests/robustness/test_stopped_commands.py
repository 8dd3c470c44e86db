"""Signals at random times and full disks, on every command: one line, all files or none."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

if os.name == "nt":
    pytest.skip("POSIX signals and limits of resources", allow_module_level=True)

import resource

ROOT = Path(__file__).parents[2]
SEED = 20241
LINES = {signal.SIGINT: "interrupted: ", signal.SIGTERM: "terminated: "}
KEPT = "warning: interrupted after "
FOURBAR = str(ROOT / "models" / "aluminium_fourbar.toml")
MOIST = str(ROOT / "models" / "moist_composite_fourbar.toml")
COARSE = ("--elements", "1", "--engine", "reference")
RECORD = "crank_angle_deg,mode,frequency_Hz\n0,1,44.3\n90,1,45\n180,1,46\n270,1,45\n"
# Each writes into "out", "out.html" or the like of its working folder.
COMMANDS = {
    "frequencies": [FOURBAR, *COARSE, "--angles", "0,90", "--speeds", "0,10"],
    "campbell": [FOURBAR, *COARSE, "--angles", "0,90,180", "--speeds", "0,10,20"],
    "stability": [FOURBAR, "--elements", "1", "--modes", "2", "--speeds", "10,20"],
    "hammer": [FOURBAR, *COARSE, "--angle", "0", "--damping-ratio", "5%"],
    "hammer --running 60": [FOURBAR, *COARSE, "--damping-ratio", "5%"],
    "response": [FOURBAR, *COARSE, "--speed", "10", "--revolutions", "0.1", "--animate"],
    "compare": [FOURBAR, "record.csv", "--speed", "0"],
    "export": [FOURBAR, "--elements", "1", "--speed", "10", "--revolutions", "0.1"],
    "report": [FOURBAR, *COARSE, "--include", "frequencies,section", "--angles", "0,90"],
    "moisture": [MOIST, "--relative-humidity", "85", "--time", "30 day"],
    "section": [MOIST],
    "kinematics": [FOURBAR, "--speed", "10"],
    "balance": [FOURBAR, "--speed", "10", "--rigid"],
    "coupler-curve": [FOURBAR, "--point", "33 mm,320 deg"],
    "synthesize": ["--deviation", "20", "--rocker-angle", "100"],
    "check": [FOURBAR],
    "study composites": ["--no-plots"],
    "new": ["four-bar"],
    "schema": [],
}
NAMES = {"report": "out.html", "schema": "out.json"}


def arguments(name: str) -> list[str]:
    out = ["out.toml"] if name == "new" else ["--out", NAMES.get(name, "out")]
    return [sys.executable, "-m", "flexmech", *name.split(), *COMMANDS[name], *out]


def files(folder: Path) -> set[str]:
    """All files but the record, and those that a killed run was about to make."""
    found = (str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())
    return {name for name in found if ".flexmech-" not in name} - {"record.csv"}


def started(
    name: str, folder: Path, before: Callable[[], None] | None = None
) -> subprocess.Popen[str]:
    folder.mkdir()
    (folder / "record.csv").write_text(RECORD)
    pipe, environment = subprocess.PIPE, {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        arguments(name),
        **{"stdout": pipe, "stderr": pipe, "cwd": folder, "env": environment},
        text=True,
        preexec_fn=before,
    )


@pytest.mark.thorough
@pytest.mark.parametrize("name", COMMANDS)
def test_a_signal_leaves_a_whole_set_or_nothing(name: str, tmp_path: Path) -> None:
    chance = random.Random(f"{SEED}/{name}")
    since = time.monotonic()
    undisturbed = started(name, tmp_path / "whole")
    _, stderr = undisturbed.communicate()
    assert undisturbed.returncode == 0, stderr
    takes, whole = time.monotonic() - since, files(tmp_path / "whole")
    assert whole
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        folder = tmp_path / number.name
        process = started(name, folder)
        # Python itself takes a moment to start, and answers signals by its own ways till then.
        time.sleep(chance.uniform(0.15, 1.0) * takes)
        process.send_signal(number)
        _, stderr = process.communicate(timeout=60)
        assert files(folder) in (set(), whole)
        if process.returncode == 0:  # it was faster
            continue
        if number == signal.SIGKILL:
            assert process.returncode == -number
            continue
        assert (process.returncode, stderr.count("\n")) == (128 + number, 1), stderr
        # A stability map keeps the speeds that are done, and warns that there are more.
        assert stderr.startswith((LINES[number], KEPT)), stderr
        assert not list(folder.rglob(".flexmech-*"))


@pytest.mark.thorough
@pytest.mark.parametrize("name", COMMANDS)
def test_a_full_disk_leaves_nothing(name: str, tmp_path: Path) -> None:
    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (600, 600))

    process = started(name, tmp_path / "full", limit)
    _, stderr = process.communicate()
    assert process.returncode == 2, stderr
    assert "cannot write to " in stderr.splitlines()[-1]
    assert files(tmp_path / "full") == set()
