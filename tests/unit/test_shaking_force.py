"""Shaking force in what ``flexmech kinematics`` and ``flexmech response`` print and write."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import flexmech
from flexmech import InputError, KinematicsRequest, ResponseRequest
from flexmech.cli import app
from flexmech.plots import plot_running_shaking_force, plot_shaking_force, plot_shaking_orders
from tests.support.figure_checks import check_layout, panels
from tests.unit.kinematics_data import kinematics_dataset
from tests.unit.shaking_data import running_shaking_dataset

pytestmark = pytest.mark.usefixtures("rough_pictures")

ALUMINIUM = Path(__file__).parents[2] / "models" / "aluminium_fourbar.toml"
RUN = ("--engine", "reference", "--elements", "2", "--revolutions", "1", "--samples", "60")


def run(*arguments: str | Path) -> str:
    result = CliRunner().invoke(app, [str(each) for each in arguments])
    assert result.exit_code == 0, result.output
    return result.stdout


def test_kinematics_tells_it_about_the_point_asked_for(tmp_path: Path) -> None:
    asked = ("--speed", "20", "--moment-point", "127 mm,-30 mm", "--no-plots", "--out", tmp_path)
    printed = run("kinematics", ALUMINIUM, *asked, "--details")
    assert "│ frame │ shaking │" in printed
    data = flexmech.Kinematics.load(tmp_path / "kinematics.nc").dataset
    assert data["moment_point"].values.tolist() == [0.127, -0.03]
    about = flexmech.kinematics(
        flexmech.load_mechanism(ALUMINIUM), KinematicsRequest(crank_speed=20.0)
    ).dataset
    moved = about["shaking_moment"] - (
        0.127 * about["shaking_force"].sel(component="y")
        + 0.03 * about["shaking_force"].sel(component="x")
    )
    np.testing.assert_allclose(data["shaking_moment"], moved, atol=1e-12)
    low, high = (f"{value:.4g}" for value in (moved.min(), moved.max()))
    line = next(line for line in printed.splitlines() if "shaking moment on the frame" in line)
    assert line.startswith("shaking moment on the frame about (127, -30) mm: ")
    assert low[:5] in line
    assert high[:5] in line
    table = pd.read_csv(tmp_path / "shaking_force.csv")
    np.testing.assert_allclose(table["shaking_moment_Nm"], moved, rtol=1e-8, atol=1e-12)
    harmonics = pd.read_csv(tmp_path / "shaking_harmonics.csv")
    np.testing.assert_allclose(
        harmonics["shaking_force_y_phase_deg"],
        np.degrees(data["shaking_force_phase"].sel(component="y").values),
        rtol=1e-8,
    )


def test_programs_get_the_peaks(tmp_path: Path) -> None:
    asked = ("--speed", "20", "--no-plots", "--out", tmp_path, "--json")
    numbers = json.loads(run("kinematics", ALUMINIUM, *asked))["numbers"]
    found = {one["name"]: one for one in numbers if one["of"] == "frame"}
    assert found["peak_shaking_force"]["value"] == pytest.approx(4.788, abs=1e-3)
    assert found["peak_shaking_moment"]["unit"] == "N m"
    numbers = json.loads(run("response", ALUMINIUM, "--speed", "20", *RUN, *asked[2:]))["numbers"]
    found = {one["name"]: one for one in numbers if one["of"] == "frame"}
    assert found["peak_shaking_force"]["value"] > 4.8
    assert found["peak_shaking_force"]["error"] > 0


def test_a_run_tells_it_beside_rigid_links(tmp_path: Path) -> None:
    asked = ("--speed", "20", "--moment-point", "127 mm,0 mm", "--no-plots", "--out", tmp_path)
    printed = run("response", ALUMINIUM, *RUN, *asked, "--details")
    data = flexmech.Response.load(tmp_path / "response.nc").dataset
    assert data["moment_point"].values.tolist() == [0.127, 0.0]
    force = data["rigid_shaking_force"].values
    rigid = np.linalg.norm(force, axis=-1).max()
    (line,) = (line for line in printed.splitlines() if line.startswith("peak shaking force: "))
    assert line.endswith(f"N (reference), {rigid:.4g} N (rigid links)")
    assert "peak shaking moment about (127, 0) mm: " in printed
    assert "reference, last turn: shaking force and moment by order" in printed
    harmonics = pd.read_csv(tmp_path / "running_shaking_harmonics.csv")
    assert harmonics["engine"].unique().tolist() == ["reference"]
    size = data["shaking_force_order"].isel(engine=0).values
    np.testing.assert_allclose(harmonics["shaking_force_greatest_N"], size, rtol=1e-8)
    # Of the last turn alone, whose start is left out.
    last = data["rigid_shaking_force"].values[-60:]
    angle = data["crank_angle"].values[-60:]
    first = 2 * np.abs(np.mean(last * np.exp(-1j * angle)[:, None], axis=0))
    np.testing.assert_allclose(data["rigid_shaking_force_amplitude"].sel(order=1), first, rtol=1e-9)


@pytest.mark.parametrize("point", [(0.1,), "ab", (0.1, np.nan), 3.0])
def test_a_point_is_two_numbers(point: object) -> None:
    for request in (KinematicsRequest, ResponseRequest):
        with pytest.raises(InputError, match="moment_point"):
            request(moment_point=point)  # type: ignore[arg-type]


def test_a_file_of_an_earlier_version_is_shown_without() -> None:
    data = kinematics_dataset()
    old = flexmech.Kinematics(
        data.drop_vars([name for name in data.variables if "shaking" in str(name)])
        .drop_dims("order")
        .drop_vars("moment_point")
        .sel(extreme=~data["extreme_quantity"].astype(str).str.startswith("shaking"))
    )
    assert "shaking_force" not in old.tables()
    assert "shaking" not in str(old.summary())
    assert "shaking_force" not in old.figures()


def test_pictures_are_the_datasets() -> None:
    data = kinematics_dataset()
    figure = plot_shaking_force(data)
    check_layout(figure)
    force, moment = panels(figure)
    curves = [line.get_ydata() for line in force.lines if len(line.get_ydata()) > 2]
    assert any(np.allclose(curve, data["shaking_force"].sel(component="y")) for curve in curves)
    assert np.allclose(curves[0], np.linalg.norm(data["shaking_force"].values, axis=-1))
    assert np.allclose(moment.lines[-1].get_ydata(), data["shaking_moment"])
    running = running_shaking_dataset()
    check_layout(plot_running_shaking_force(running))
    bars, _ = panels(plot_shaking_orders(running))
    heights = [bar.get_height() for bar in bars.patches]
    wanted = [*running["shaking_force_order"].values, running["rigid_shaking_force_order"].values]
    np.testing.assert_allclose(heights, np.concatenate(wanted))
