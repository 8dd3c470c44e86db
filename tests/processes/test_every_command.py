"""Every command, stopped as it writes and on a full disk: one line, no file left."""

from __future__ import annotations

import re
import resource
import signal
from pathlib import Path

import pytest

from tests.processes.forked import Ended, Place, files_of, run, send
from tests.support.command import MODELS

FOURBAR, MOIST = (MODELS / f"{name}_fourbar.toml" for name in ("aluminium", "moist_composite"))
COARSE = ("--elements", "1", "--engine", "reference")
RECORD = "crank_angle_deg,mode,frequency_Hz\n0,1,44.3\n90,1,45\n180,1,46\n270,1,45\n"
# Each writes into "out", "out.html" or the like of its working folder.
COMMANDS = {
    "frequencies": [FOURBAR, *COARSE, "--angles", "0,90", "--speeds", "0,10"],
    "campbell": [FOURBAR, *COARSE, "--angles", "0,90,180", "--speeds", "0,10,20"],
    "stability": [FOURBAR, "--elements", "1", "--modes", "2", "--speeds", "10,20"],
    "hammer": [FOURBAR, *COARSE, "--angle", "0", "--damping-ratio", "5%"],
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
    "new": ["four-bar"],
    "schema": [],
}
OUT = {"report": ["--out", "out.html"], "schema": ["--out", "out.json"], "new": ["out.toml"]}
WRITES = Place("open", r"(?s)\.flexmech-[^/]*/")


@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("way", ["stopped", "full"])
def test_a_command_that_cannot_end_leaves_no_file(name: str, way: str, tmp_path: Path) -> None:
    (tmp_path / "record.csv").write_text(RECORD)
    words = [name, *COMMANDS[name], *OUT.get(name, ["--out", "out"])]
    if way == "stopped":
        ended = run(tmp_path, *words, at=WRITES, do=send(signal.SIGTERM))
        last = one_line(ended, 128 + signal.SIGTERM)
        assert last.startswith("terminated: ")
    else:
        ended = run(tmp_path, *words, first=fill_the_disk)
        assert "cannot write to " in one_line(ended, 2)
    assert files_of(tmp_path) == ["record.csv"]
    assert not [path for path in tmp_path.rglob("*") if ".flexmech-" in path.name]


def fill_the_disk() -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (600, 600))


def one_line(ended: Ended, code: int) -> str:
    """The line that says why a command ended, behind warnings of the model."""
    assert ended.code == code, ended.stderr
    lines = [line for line in ended.stderr.splitlines() if not re.match("warning: ", line)]
    assert len(lines) == 1, ended.stderr
    return lines[0]
