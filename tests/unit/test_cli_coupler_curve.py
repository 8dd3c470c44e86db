"""``flexmech coupler-curve``: its tables against the library, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

from flexmech.cli import app
from flexmech.cli.coupler_curve import parse_point
from flexmech.errors import InputError
from flexmech.hygrothermal import HygrothermalState, coupler_path
from flexmech.linkages import CouplerPoint
from flexmech.modelfile import load_mechanism

pytestmark = pytest.mark.usefixtures("rough_pictures")

MODELS = Path(__file__).parents[2] / "models"
# Wet, this one's crank turns fully no longer.
NEAR_A_CHANGE_POINT = (
    ('coupler = "4500 mm"', 'coupler = "2275 mm"'),
    ('distance = "5000 mm", angle = "336 deg"', 'distance = "2000 mm", angle = "240 deg"'),
)
WET = ["--temperature-rise", "80", "--moisture", "7"]


def run(*arguments: str | Path) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    return result.exit_code, result.stdout, result.stderr


def test_figure_8_dry_and_wet(tmp_path: Path) -> None:
    model = MODELS / "neat_resin_figure_8.toml"
    code, printed, errors = run(
        "coupler-curve", model, *WET, "--angles", "0:360:30", "--out", tmp_path
    )
    assert (code, errors) == (0, "")
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "coupler_angles.png",
        "coupler_curve.csv",
        "coupler_curve.png",
        "topology.csv",
    ]
    curve = pd.read_csv(tmp_path / "coupler_curve.csv")
    assert list(curve.columns) == [
        "state",
        "crank_angle_deg",
        "theta3_deg",
        "theta4_deg",
        "x_m",
        "y_m",
    ]
    assert curve["state"].tolist() == ["dry"] * 13 + ["wet"] * 13
    mechanism = load_mechanism(model)
    assert mechanism.coupler_point is not None
    turn = np.radians(np.arange(0, 361, 30))
    for name, state in (("dry", HygrothermalState()), ("wet", HygrothermalState(80, 0.07))):
        path = coupler_path(mechanism, mechanism.coupler_point, state, turn)
        rows = curve[curve["state"] == name]
        assert rows[["x_m", "y_m"]].to_numpy() == pytest.approx(path.position, rel=1e-8)
        assert rows[["theta3_deg", "theta4_deg"]].to_numpy() == pytest.approx(
            np.degrees(path.angles), rel=1e-8
        )
    topology = pd.read_csv(tmp_path / "topology.csv")
    assert list(topology.columns) == [
        "state",
        "kind",
        "crank_angle_1_deg",
        "crank_angle_2_deg",
        "x_m",
        "y_m",
    ]
    assert topology[["state", "kind"]].to_numpy().tolist() == [["dry", "crunode"]]
    angles = np.radians(topology.iloc[0, 2:4].to_numpy(dtype=float))
    both = coupler_path(mechanism, mechanism.coupler_point, HygrothermalState(), angles).position
    assert np.hypot(*(both[1] - both[0])) < 1e-10 * 5
    assert "dry: 1 crunode and 0 cusps" in printed
    assert "wet: 0 crunodes and 0 cusps" in printed
    assert "wet: ground 4522.54, crank 2308.83" in printed


def test_errata_of_the_angles(tmp_path: Path) -> None:
    """Singh & Sanyal 2022, Figure 3's linkage: +0.77493 and +2.02411 deg (corrected)."""
    model = MODELS / "neat_resin_figure_3.toml"
    options = ["--point", "0 mm,0 deg", "--angles", "0,180", "--no-plots"]
    assert run("coupler-curve", model, *WET, *options, "--out", tmp_path)[0] == 0
    curve = pd.read_csv(tmp_path / "coupler_curve.csv").set_index("state")
    change = curve.loc["wet"].to_numpy() - curve.loc["dry"].to_numpy()
    assert change[:, 1] == pytest.approx([0.77493, 2.02411], abs=5e-6)
    assert change[:, 2] == pytest.approx([-0.77493, -2.02411], abs=5e-6)


def test_neighbouring_angles_keep_their_digits(tmp_path: Path) -> None:
    model = MODELS / "neat_resin_figure_12.toml"
    options = ["--angles", "100.12345,100.12346", "--no-plots", "--out", tmp_path]
    assert run("coupler-curve", model, *options)[0] == 0
    lines = (tmp_path / "coupler_curve.csv").read_text().splitlines()
    assert [line.split(",")[1] for line in lines[1:]] == ["100.12345", "100.12346"]


def test_wet_without_heat_and_moisture_is_drawn_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names: list[list[str]] = []

    def noted(paths: dict[str, object], title: str) -> Figure:
        names.append(list(paths))
        return Figure(figsize=(1, 1))

    monkeypatch.setattr("flexmech.plots.plot_coupler_curve", noted)
    monkeypatch.setattr("flexmech.plots.plot_coupler_angles", noted)
    model = MODELS / "neat_resin_figure_12.toml"
    options = ["--temperature-rise", "0", "--angles", "0,90", "--out", tmp_path]
    assert run("coupler-curve", model, *options)[0] == 0
    assert names == [["dry", "wet"], ["dry", "wet"]]


def test_wet_linkage_that_no_longer_turns_fully(tmp_path: Path) -> None:
    """Its loops when dry lie at crank angles that the wet linkage does not reach."""
    model = tmp_path / "nearly.toml"
    text = (MODELS / "neat_resin_figure_8.toml").read_text()
    for old, new in NEAR_A_CHANGE_POINT:
        assert text.count(old) == 1
        text = text.replace(old, new)
    model.write_text(text)
    options = [*WET, "--angles", "60:120:20", "--out", tmp_path / "out"]
    code, printed, errors = run("coupler-curve", model, *options)
    assert (code, errors) == (0, "")
    assert "dry: 1 crunode and 0 cusps\n" in printed
    assert "on the whole circuit, both branches (triple-rocker)" in printed
    code, printed, errors = run("coupler-curve", model, *WET, "--out", tmp_path / "none")
    assert (code, printed) == (2, "")
    assert errors.startswith("error: +80 K, 7 % moisture: the linkage cannot be assembled")


def test_dry_alone_without_pictures(tmp_path: Path) -> None:
    model = MODELS / "neat_resin_figure_6.toml"
    code, printed, _ = run("coupler-curve", model, "--no-plots", "--out", tmp_path)
    assert code == 0
    assert "wet" not in printed
    assert set(pd.read_csv(tmp_path / "coupler_curve.csv")["state"]) == {"dry"}
    assert len(pd.read_csv(tmp_path / "coupler_curve.csv")) == 361
    assert not list(tmp_path.glob("*.png"))


def test_point_of_the_command_line_goes_first(tmp_path: Path) -> None:
    model = MODELS / "neat_resin_figure_12.toml"
    assert (
        run("coupler-curve", model, "--point", "1 cm,90 deg", "--no-plots", "--out", tmp_path)[0]
        == 0
    )
    curve = pd.read_csv(tmp_path / "coupler_curve.csv")
    angle = np.radians(curve["theta3_deg"] + 90)
    crank = np.radians(curve["crank_angle_deg"])
    assert curve["x_m"].to_numpy() == pytest.approx(0.015 * np.cos(crank) + 0.01 * np.cos(angle))


def test_exposure_in_place_of_moisture(tmp_path: Path) -> None:
    model = MODELS / "neat_resin_figure_12.toml"
    exposed = ["--relative-humidity", "85", "--time", "2 day", "--no-plots", "--out", tmp_path]
    code, printed, errors = run("coupler-curve", model, *exposed)
    assert (code, errors) == (0, "")
    assert "85 % humidity for 2 d" in printed


@pytest.mark.parametrize(
    ("text", "point"),
    [
        ("33 mm,320 deg", CouplerPoint(0.033, np.radians(320))),
        ("4.5 m, -90 deg", CouplerPoint(4.5, -np.pi / 2)),
    ],
)
def test_points(text: str, point: CouplerPoint) -> None:
    found = parse_point(text)
    assert (found.distance, found.angle) == pytest.approx((point.distance, point.angle))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("33 mm", "has 1 parts"),
        ("1,2,3", "has 3 parts"),
        ("33 deg,4 deg", "not that of a length"),
        ("-1 mm,0 deg", "zero or positive"),
        ("nan,0 deg", "begin with a number"),
        (",", "begin with a number"),
        ("100,30", "got '100', which has no unit; write a length with its unit"),
        ("100 mm,30", "got '30', which has no unit; write an angle with its unit"),
    ],
)
def test_points_that_cannot_be(text: str, message: str) -> None:
    with pytest.raises(InputError, match=f"--point: .*{message}"):
        parse_point(text)


@pytest.mark.parametrize(
    ("model", "options", "said"),
    [
        ("neat_resin_figure_3.toml", [], "linkage.coupler_point: is missing"),
        ("rotating_arm.toml", ["--point", "1 m,0 deg"], "four-bar"),
        ("neat_resin_figure_8.toml", ["--temperature-rise", "95", "--moisture", "7"], "wet glass"),
        ("steel_fourbar.toml", ["--point", "0.1 m,0 deg", "--moisture", "1"], "change nothing in"),
        ("neat_resin_figure_8.toml", ["--angles", "0:360"], "--angles"),
    ],
)
def test_refusals(tmp_path: Path, model: str, options: list[str], said: str) -> None:
    out = tmp_path / "none"
    code, printed, errors = run("coupler-curve", MODELS / model, *options, "--out", out)
    assert (code, printed) == (2, "")
    assert said in errors
    assert len(errors.strip().splitlines()) == 1
    assert not out.exists()
