"""Odd environments: settings of Matplotlib, terminals, locales and homes that are not there."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr

from tests.support.command import MODELS, run_command

# Text by TeX, which most machines lack, and a key that there is not.
MATPLOTLIBRC = "text.usetex: True\nbackend: TkAgg\nfont.size: 30\nsavefig.dpi: 10\nnonsense: 1\n"
ODD = {
    "MPLBACKEND": "nonsense",
    "MATPLOTLIBRC": "{folder}/matplotlibrc",
    "COLUMNS": "1",
    "LINES": "0",
    "NO_COLOR": "1",
    "FORCE_COLOR": "1",
    "TERM": "dumb",
    "LC_ALL": "xx_YY.nonsense",
    "PYTHONUTF8": "0",
    "PYTHONCOERCECLOCALE": "0",
    "PYTHONIOENCODING": "ascii",
    "HOME": "/proc",
    "XDG_CACHE_HOME": "/proc",
    "XDG_CONFIG_HOME": "/proc",
    "TMPDIR": "/nonexistent",
    "OMP_NUM_THREADS": "abc",
    "PYTHONOPTIMIZE": "2",
}


def test_a_command_in_an_odd_environment_draws_the_picture_of_a_plain_one(tmp_path: Path) -> None:
    (tmp_path / "matplotlibrc").write_text(MATPLOTLIBRC)
    pictures = []
    for name, odd in (("plain", {}), ("odd", ODD)):
        own = {key: value.format(folder=tmp_path) for key, value in odd.items()}
        words = ["section", str(MODELS / "composite_fourbar.toml"), "--link", "crank"]
        ended = subprocess.run(
            [sys.executable, "-m", "flexmech", *words, "--out", name],
            capture_output=True,
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(MODELS.parent), **own},
            timeout=300,
        )
        assert (ended.returncode, ended.stderr) == (0, b"")
        pictures.append((tmp_path / name / "section" / "section_crank.png").read_bytes())
    assert pictures[0] == pictures[1]


def test_bytes_of_a_path_that_are_no_text_are_stored_as_escapes(tmp_path: Path) -> None:
    model = tmp_path / "r\udcff.toml"
    shutil.copy(MODELS / "steel_fourbar.toml", model)
    ended = run_command(tmp_path / "out\udcfe", "section", model, "--no-plots")
    assert (ended.exit_code, ended.stderr) == (0, "")
    with xr.open_dataset(ended.folder / "sections.nc") as stored:
        assert "r\\udcff.toml" in stored.attrs["command_line"]


def test_a_tilde_is_the_home_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(MODELS / "steel_fourbar.toml", tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    words = ("section", "~/steel_fourbar.toml", "--no-plots", "--out", "~/res")
    assert run_command(tmp_path, *words).exit_code == 0
    assert (tmp_path / "res" / "section" / "sections.csv").exists()
    missing = run_command(tmp_path, "check", "~nobody-of-this-name/model.toml")
    assert missing.exit_code == 2
    assert "~nobody-of-this-name/model.toml: there is no such home folder" in missing.stderr


BLOCKED = "import sys; sys.modules['exudyn'] = None; from flexmech.cli import main; main()"
ASKED = ("--elements", "2", "--angles", "0,90", "--speeds", "0", "--no-plots", "--out")


def without_exudyn(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """``flexmech frequencies`` on the steel four-bar where exudyn cannot be imported."""
    model = str(MODELS / "steel_fourbar.toml")
    return subprocess.run(
        [sys.executable, "-c", BLOCKED, "frequencies", model, *words, *ASKED, str(folder)],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(MODELS.parent)},
        timeout=300,
    )


def test_the_reference_engine_runs_without_exudyn(tmp_path: Path) -> None:
    ended = without_exudyn(tmp_path / "without", "--engine", "reference")
    assert (ended.returncode, ended.stderr) == (0, "")
    words = ("frequencies", MODELS / "steel_fourbar.toml", "--engine", "reference", *ASKED)
    run_command(tmp_path, *words, str(tmp_path / "with"))
    places = (tmp_path / name / "frequencies" for name in ("without", "with"))
    tables = [(place / "frequencies.csv").read_bytes() for place in places]
    assert tables[0] == tables[1]


def test_a_date_of_files_is_that_of_the_variable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    words = ("kinematics", MODELS / "steel_fourbar.toml", "--angles", "0,90", "--no-plots")
    with xr.open_dataset(run_command(tmp_path, *words).folder / "kinematics.nc") as stored:
        assert stored.attrs["date"] == "2023-11-14T22:13:20Z"
