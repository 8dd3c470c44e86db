"""``flexmech compare``: files, messages and exit codes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from flexmech.cli import app
from tests.support.comparison_data import MODEL, damping_time, noisy


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["compare", str(MODEL), *arguments])


@pytest.fixture
def strain(tmp_path, monkeypatch):
    """A record of a gauge at the coupler's middle, in the folder ``measured``."""
    monkeypatch.chdir(tmp_path)
    path = Path("measured/strain.csv")
    path.parent.mkdir()
    time, angle, values = noisy(4)
    rows = (
        f"{1e3 * t:.5f};{np.degrees(a) % 360:.4f};{1e6 * e:.4f}"
        for t, a, e in zip(time, angle, values, strict=True)
    )
    header = "# gauge 3\ntime [ms];crank_angle [deg];strain (um/m)"
    path.write_text("\n".join([header, *rows]), encoding="utf-8")
    return str(path)


@pytest.mark.thorough
def test_a_strain_gauge_at_the_couplers_middle(strain, tmp_path):
    done = run(strain, "--speed", "20", "--out", "results", "--no-plots", "--details")
    assert done.exit_code == 0, done.stderr
    assert "compared: 'strain (um/m)' of strain.csv with coupler_mid_strain" in done.stdout
    names = sorted(path.name for path in (tmp_path / "results").iterdir())
    assert names == ["comparison.csv", "comparison.nc", "fit.csv", "summary.txt"]
    name, value, unit, error, *ends = (
        (tmp_path / "results/fit.csv").read_text().splitlines()[1].split(",")
    )
    assert (name, unit) == ("damping", "s")
    # The record is that of a coarser mesh, whose frequencies are 0.4 % off: that shows in what
    # remains, and the interval is widened until it holds the damping.
    assert float(value) == pytest.approx(damping_time(), rel=0.1)
    assert float(ends[0]) < damping_time() < float(ends[1])
    assert float(error) > 0.05 * float(value)
    assert "the residual is no white noise" in done.stdout


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--speed", "20", "--angle", "3"), "error: --speed, --angle: give one of them"),
        (("--angle", "400"), "error: --angle: got '400'; give an angle from 0 to 360 deg"),
        (("--speed", "20", "--fit", "speed"), "error: --fit: 'speed' cannot be fitted"),
        (("--speed", "20", "--quantity", "torque"), "error: --quantity: 'torque' cannot be laid"),
        (("--speed", "300 rpm"), "error: measured/strain.csv: its crank turns at 20 rad/s"),
        (("--speed", "20 m"), "error: --speed: got '20 m'"),
    ],
)
def test_wrong_options_and_records_are_refused_in_one_line(strain, options, message):
    done = run(strain, *options, "--out", "results")
    assert done.exit_code == 2
    assert done.stderr.startswith(message)
    assert done.stderr.count("\n") == 1
    assert not Path("results").exists()


def test_a_record_over_time_is_taken_at_the_greatest_speed_of_the_model(strain):
    done = run(strain, "--fit", "none", "--no-plots", "--out", "results")
    assert done.exit_code == 0, done.stderr
    assert done.stdout.splitlines()[0] == "speed of the model file: 20 rad/s"


def test_other_records_need_a_speed_or_an_angle(strain):
    record = Path("measured/frequencies.csv")
    record.write_text("crank_angle [deg],frequency [Hz]\n0,44\n90,45\n180,46\n", encoding="utf-8")
    done = run(str(record))
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.startswith("error: --speed, --angle: give one of them")


def test_a_record_that_is_not_there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = run("nothing.csv", "--speed", "20")
    assert done.exit_code == 2
    assert done.stderr.startswith("error: nothing.csv: cannot be read")
