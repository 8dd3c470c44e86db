"""What a run with a free shaft delivers: columns, words, and panels of picture and report."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import cumulative_trapezoid
from typer.testing import CliRunner

from flexmech import Response, plots
from flexmech.cli.application import app
from flexmech.report.panels.response import response_panel
from flexmech.report.results import Results

MODEL = Path(__file__).parents[2] / "models" / "aluminium_fourbar.toml"
QUICK = ["--engine", "reference", "--speed", "20", "--revolutions", "0.01", "--elements", "2"]
QUICK += ["--samples", "25000"]


def run(folder: Path, *options: str) -> str:
    arguments = ["response", str(MODEL), *QUICK, "--shaft", "free", "--no-plots", *options]
    result = CliRunner().invoke(app, [*arguments, "--details", "--out", str(folder)])
    return result.output + result.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("free_shaft")
    assert "shaft: free, under the torque that drives the rigid linkage" in " ".join(
        run(folder).split()
    )
    return folder


@pytest.fixture(scope="module")
def response(folder: Path) -> Response:
    return Response.load(folder / "response.nc")


def test_rotation_and_fluctuation_are_in_the_table(folder: Path, response: Response) -> None:
    table, data = pd.read_csv(folder / "response.csv"), response.dataset.isel(engine=0)
    assert data.attrs["shaft"] == "free"
    degrees = np.degrees(data["shaft_rotation"].values)
    assert np.abs(degrees).max() > 1e-4
    assert table["shaft_rotation_deg"].values == pytest.approx(degrees, rel=1e-6)
    fluctuation = data["crank_speed_fluctuation"].values
    assert table["crank_speed_fluctuation_rad_s"].values == pytest.approx(fluctuation, rel=1e-6)
    turned = cumulative_trapezoid(fluctuation, data["time"].values, initial=0.0)
    rotation = data["shaft_rotation"].values
    assert turned == pytest.approx(rotation, abs=0.03 * np.abs(rotation).max())


def test_picture_and_report_have_panels_of_the_shaft(response: Response) -> None:
    data = response.dataset
    labels = [axes.get_ylabel() for axes in plots.plot_response(data).axes]
    assert [label for label in labels if label.startswith("Shaft")] == [
        "Shaft\nrotation (deg)",
        "Shaft speed\nfluctuation (rad/s)",
    ]
    panel = response_panel(Results.of(response))
    assert panel is not None
    traces = {trace.axis: trace.y for trace in panel.plots[-1].traces}
    drawn = np.degrees(data["shaft_rotation"].isel(engine=0).values)
    assert traces[0] == pytest.approx(drawn)


def test_a_great_rotation_is_too_much_for_linear_equations(response: Response) -> None:
    turned = response.dataset.assign(peak_shaft_rotation=("engine", np.radians([6.0])))
    assert "beyond the 5 deg" in str(Response(turned).summary())
    assert "beyond the 5 deg" not in str(response.summary())


def test_a_periodic_start_is_refused(tmp_path: Path) -> None:
    said = " ".join(run(tmp_path, "--start", "periodic").split())
    assert "a periodic start needs a prescribed shaft" in said
