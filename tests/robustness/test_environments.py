"""Odd environments: settings of Matplotlib, terminals, locales and folders that are not there."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr
from typer.testing import CliRunner

from flexmech.cli import app

ROOT = Path(__file__).parents[2]
# Text by TeX, which most machines lack, and a key that there is not.
MATPLOTLIBRC = "text.usetex: True\nbackend: TkAgg\nsavefig.dpi: 10\nnonsense: 1\n"
ODD = {
    "matplotlib": {"MPLBACKEND": "nonsense", "MATPLOTLIBRC": "{folder}/style/matplotlibrc"},
    "columns": {"COLUMNS": "1", "LINES": "0"},
    "no columns": {"COLUMNS": "abc"},
    "colours": {"NO_COLOR": "1", "FORCE_COLOR": "1", "TERM": "dumb"},
    "locale": {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    "unknown locale": {"LC_ALL": "xx_YY.nonsense", "PYTHONIOENCODING": "ascii"},
    "warnings": {"PYTHONWARNINGS": "error", "PYTHONDEVMODE": "1"},
    "home": {"HOME": "/proc", "XDG_CACHE_HOME": "/proc", "XDG_CONFIG_HOME": "/proc"},
    "no home": {"HOME": "/nonexistent", "MPLCONFIGDIR": "/nonexistent/below"},
    "temporary": {"TMPDIR": "/nonexistent", "TEMP": "/proc", "TMP": "/proc"},
    "optimized": {"PYTHONOPTIMIZE": "2"},
    "threads": {"OMP_NUM_THREADS": "abc", "OPENBLAS_NUM_THREADS": "-1"},
}
TOGETHER = ("matplotlib", "columns", "colours", "locale", "home", "temporary")


def section(out: Path, environment: dict[str, str]) -> subprocess.CompletedProcess[bytes]:
    model = str(ROOT / "models" / "composite_fourbar.toml")
    arguments = ["section", model, "--link", "crank", "--out", str(out)]
    own = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
    return subprocess.run(
        [sys.executable, "-m", "flexmech", *arguments], capture_output=True, env=own, cwd=out.parent
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    "names",
    [
        pytest.param(TOGETHER, id="together"),
        *(pytest.param((name,), id=name) for name in ODD),
    ],
)
def test_a_command_runs_in_any_environment(names: tuple[str, ...], tmp_path: Path) -> None:
    (tmp_path / "style").mkdir()
    (tmp_path / "style" / "matplotlibrc").write_text(MATPLOTLIBRC)
    environment = {
        key: value.format(folder=tmp_path) for name in names for key, value in ODD[name].items()
    }
    done = section(tmp_path / "out", environment)
    assert (done.returncode, done.stderr) == (0, b"")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "section_crank.png",
        "sections.csv",
        "sections.nc",
        "summary.txt",
        "through_thickness.csv",
    }


@pytest.mark.thorough
def test_pictures_do_not_follow_the_user_s_own_style(tmp_path: Path) -> None:
    pictures = []
    for name in ("plain", "styled"):
        folder = tmp_path / name
        folder.mkdir()
        if name == "styled":
            (folder / "matplotlibrc").write_text(MATPLOTLIBRC + "font.size: 30\n")
        assert section(folder / "out", {}).returncode == 0
        pictures.append((folder / "out" / "section_crank.png").read_bytes())
    assert pictures[0] == pictures[1]


def test_names_of_files_that_are_no_text_are_stored_as_escapes(tmp_path: Path) -> None:
    """Bytes that are not UTF-8, as of a name from another system."""
    model, out = tmp_path / "r\udcff.toml", tmp_path / "out\udcfe"
    shutil.copy(ROOT / "models" / "steel_fourbar.toml", model)
    done = CliRunner().invoke(app, ["section", str(model), "--out", str(out), "--no-plots"])
    assert (done.exit_code, done.stderr) == (0, "")
    with xr.open_dataset(out / "sections.nc") as stored:
        assert "r\\udcff.toml" in stored.attrs["command_line"]
    record = tmp_path / "record\udcff.csv"
    record.write_text("crank_angle_deg,mode,frequency_Hz\n0,1,44\n90,1,45\n180,1,46\n270,1,45\n")
    arguments = ["compare", str(model), str(record), "--speed", "0", "--no-plots"]
    done = CliRunner().invoke(app, [*arguments, "--out", str(out)])
    assert done.exit_code == 0, done.output
