"""Coupler paths, as a result and from ``flexmech coupler-curve``; what both refuse."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

from flexmech import (
    CouplerPaths,
    CouplerPoint,
    HygrothermalState,
    InputError,
    coupler_paths,
    load_mechanism,
)
from flexmech.cli import app
from flexmech.cli.typed import POINT
from tests.unit.test_planar_motion import drawn_as_planar

pytestmark = pytest.mark.usefixtures("rough_pictures")

MODELS = Path(__file__).parents[2] / "models"
# Wet, this one's crank turns fully no longer.
NEAR_A_CHANGE_POINT = (
    ('coupler = "4500 mm"', 'coupler = "2275 mm"'),
    ('distance = "5000 mm", angle = "336 deg"', 'distance = "2000 mm", angle = "240 deg"'),
)
WET = ["--temperature-rise", "80", "--moisture", "7"]
TURN = np.radians(np.arange(0, 361, 30))


def run(*arguments: str | Path) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    return result.exit_code, result.stdout, result.stderr


def nearly_a_change_point(folder: Path) -> Path:
    text = (MODELS / "neat_resin_figure_8.toml").read_text()
    for old, new in NEAR_A_CHANGE_POINT:
        assert text.count(old) == 1
        text = text.replace(old, new)
    model = folder / "nearly.toml"
    model.write_text(text)
    return model


def test_figure_8_dry_and_wet(tmp_path: Path) -> None:
    model = MODELS / "neat_resin_figure_8.toml"
    options = (*WET, "--angles", "0:360:30", "--details", "--out", tmp_path)
    code, printed, errors = run("coupler-curve", model, *options)
    assert (code, errors) == (0, "")
    written = sorted(file.name for file in tmp_path.iterdir())
    assert written == sorted([*CouplerPaths.files, "summary.txt"])
    curve = pd.read_csv(tmp_path / "coupler_curve.csv")
    assert list(curve.columns) == [
        "state",
        "crank_angle_deg",
        "theta3_deg",
        "theta4_deg",
        "x_m",
        "y_m",
        "transmission_angle_deg",
        "least_transmission_angle_deg",
        "greatest_transmission_angle_deg",
    ]
    assert curve["state"].tolist() == ["dry"] * 13 + ["wet"] * 13
    mechanism = load_mechanism(model)
    paths = coupler_paths(mechanism, TURN, environment=HygrothermalState(80, 0.07)).dataset
    for number, name in enumerate(("dry", "wet")):
        rows, path = curve[curve["state"] == name], paths.isel(state=number)
        assert rows[["x_m", "y_m"]].to_numpy() == pytest.approx(path["position"].values, rel=1e-8)
        assert rows[["theta3_deg", "theta4_deg"]].to_numpy() == pytest.approx(
            np.degrees(path["angle"].values), rel=1e-8
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
    both = coupler_paths(mechanism, angles).dataset["position"].values[0]
    assert np.hypot(*(both[1] - both[0])) < 1e-10 * 5
    assert "dry: 1 crunode and 0 cusps" in printed
    assert "wet: 0 crunodes and 0 cusps" in printed
    assert "wet: ground 4522.54, crank 2308.83" in printed
    assert "\ncheck: the curve's sextic equation is met within " in printed
    said = printed.splitlines()[:3]
    assert said[0].endswith(" mm, with 1 crunode and no cusps.")
    assert said[1].startswith("At +80 K, 7 % moisture it runs through ")
    assert said[2].startswith("It is moved by at most ")


def test_the_pins_are_where_their_links_end() -> None:
    mechanism = load_mechanism(MODELS / "neat_resin_figure_8.toml")
    data = coupler_paths(mechanism, TURN, environment=HygrothermalState(80, 0.07)).dataset
    pins, centres = data["pin_position"], [np.zeros(2), [1.0, 0.0] * data["length"][:, :1].values]
    for pin, link, centre in (("A", "crank", centres[0]), ("B", "rocker", centres[1][:, None])):
        reach = np.hypot(*np.moveaxis(pins.sel(pin=pin).values - centre, -1, 0))
        length = data["length"].sel(member=link).values[:, None]
        assert reach == pytest.approx(np.broadcast_to(length, reach.shape), rel=1e-12)


def test_close_ups_are_of_the_loops_of_every_state() -> None:
    mechanism = load_mechanism(MODELS / "neat_resin_figure_8.toml")
    data = coupler_paths(mechanism, TURN, environment=HygrothermalState(80, 0.07)).dataset
    # One loop, dry; it is in the middle third of the close-up of the dry path.
    assert data["close_up"].sizes["window"] == 1
    loop = data["close_up"].values[0, 0]
    double = data["double_point_position"].values[0]
    inside = np.linalg.norm(loop - double, axis=1)[len(loop) // 3 - 2 : -len(loop) // 3 + 2]
    assert inside[[0, -1]].max() < inside.max() / 5
    without = coupler_paths(load_mechanism(MODELS / "neat_resin_figure_12.toml"), TURN).dataset
    assert not {"close_up", "framed"} & set(without)
    assert without.sizes["double_point"] == 0


def test_a_user_s_script(tmp_path: Path) -> None:
    """Ten lines with public names alone."""
    script = f"""
import flexmech
import numpy as np
mechanism = flexmech.load_mechanism({str(MODELS / "neat_resin_figure_8.toml")!r})
wet = flexmech.HygrothermalState(temperature_rise=80.0, moisture=0.07)
paths = flexmech.coupler_paths(mechanism, np.radians(range(0, 361, 30)), environment=wet)
crunodes = (paths.dataset["double_point_kind"] == "crunode").sum().item()
figure = paths.plot()
files = paths.save({str(tmp_path)!r}, figures=True)
loaded = flexmech.CouplerPaths.load(files[2])
print(loaded.summary())
"""
    names: dict[str, object] = {}
    exec(script, names)
    assert names["crunodes"] == 1
    assert isinstance(names["figure"], Figure)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(CouplerPaths.files)


def test_a_loaded_result_says_the_same(tmp_path: Path) -> None:
    """With a loop and without, with an environment and without, and where the crank only swings."""
    wet, part = HygrothermalState(80, 0.07), np.radians([60.0, 80.0])
    loops, plain = (load_mechanism(MODELS / f"neat_resin_figure_{n}.toml") for n in (8, 12))
    nearly = load_mechanism(nearly_a_change_point(tmp_path))
    for result in (
        coupler_paths(loops, TURN, environment=wet),
        coupler_paths(plain, TURN),
        coupler_paths(nearly, part, CouplerPoint(2.0, 4.0), wet),
    ):
        result.save(tmp_path)
        loaded = CouplerPaths.load(tmp_path / "coupler_curve.nc")
        assert loaded.dataset.identical(result.dataset)
        for name, variable in result.dataset.variables.items():
            assert loaded.dataset[name].dtype.kind == variable.dtype.kind, name
        assert str(loaded.summary()) == str(result.summary())
        for name, table in result.tables().items():
            pd.testing.assert_frame_equal(loaded.tables()[name], table)


def test_plots_into_axes_of_the_user() -> None:
    paths = coupler_paths(load_mechanism(MODELS / "neat_resin_figure_8.toml"), TURN)
    mine = Figure()
    axes = mine.subplots(1, 3)
    assert paths.plot(ax=axes) is mine
    assert all(panel.lines for panel in axes)


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


def test_an_environment_without_heat_and_moisture_is_a_state_too(tmp_path: Path) -> None:
    model = MODELS / "neat_resin_figure_12.toml"
    options = ["--temperature-rise", "0", "--angles", "0,90", "--out", tmp_path]
    assert run("coupler-curve", model, *options)[0] == 0
    found = CouplerPaths.load(tmp_path / "coupler_curve.nc").dataset
    assert found["state"].values.tolist() == ["dry", "wet"]


def test_wet_linkage_that_no_longer_turns_fully(tmp_path: Path) -> None:
    """Its loops when dry lie at crank angles that the wet linkage does not reach."""
    model = nearly_a_change_point(tmp_path)
    options = [*WET, "--angles", "60:120:20", "--details", "--out", tmp_path / "out"]
    code, printed, errors = run("coupler-curve", model, *options)
    assert (code, errors) == (0, "")
    assert "dry: 1 crunode and 0 cusps\n" in printed
    assert "on the whole circuit, both branches (triple-rocker)" in printed
    code, printed, errors = run("coupler-curve", model, *WET, "--out", tmp_path / "none")
    assert (code, printed) == (2, "")
    assert "+80 K, 7 % moisture: the linkage cannot be assembled" in errors


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
    point = ["--point", "0.01 m,90 deg"]
    assert run("coupler-curve", model, *point, "--no-plots", "--out", tmp_path)[0] == 0
    curve = pd.read_csv(tmp_path / "coupler_curve.csv")
    angle = np.radians(curve["theta3_deg"] + 90)
    crank = np.radians(curve["crank_angle_deg"])
    assert curve["x_m"].to_numpy() == pytest.approx(0.015 * np.cos(crank) + 0.01 * np.cos(angle))


def test_exposure_in_place_of_moisture(tmp_path: Path) -> None:
    model = MODELS / "neat_resin_figure_12.toml"
    for time in ("--time", "--exposure-time"):
        exposed = ["--relative-humidity", "85", time, "2 day", "--no-plots", "--out", tmp_path]
        code, printed, errors = run("coupler-curve", model, *exposed)
        assert (code, errors) == (0, "")
        assert "85 % humidity for 2 d" in printed


def test_points() -> None:
    for text, point in (
        ("33 mm,320 deg", (0.033, np.radians(320))),
        ("4.5 m, -1.5 rad", (4.5, -1.5)),
    ):
        found = POINT(text)
        assert (found.distance, found.angle) == pytest.approx(point)


def test_points_that_cannot_be() -> None:
    for text, said in (
        ("33 mm", "has 1 parts"),
        ("1,2,3", "has 3 parts"),
        ("100,30", "'100', which has no unit"),
        ("100 mm,30", "'30', which has no unit"),
        ("33 deg,4 deg", "not that of a length"),
        ("-1 mm,0 deg", "pin A"),
        ("nan,0", "'nan'"),
        (",", "''"),
    ):
        with pytest.raises(InputError, match=r"--point: .*write distance and angle, each with its"):
            POINT(text)
        with pytest.raises(InputError, match=said):
            POINT(text)


def test_transmission_angle_dry_and_wet_and_its_limits(tmp_path: Path) -> None:
    """100, 160, 160 and 200 mm, and as R-914 wet at 80 K has them: cosines of eqs. 1 to 3."""
    options = [*WET, "--point", "0 mm,0 deg", "--angles", "0:360:90", "--details", "--no-plots"]
    code, printed, _ = run(
        "coupler-curve", MODELS / "neat_resin_figure_3.toml", *options, "--out", tmp_path
    )
    assert code == 0
    curve = pd.read_csv(tmp_path / "coupler_curve.csv").set_index("state")
    for state, link, ground in (("dry", 1.0, 200.0), ("wet", 1.026148, 201.0016)):
        crank, bar = 100 * link, 160 * link
        turn = np.radians([0.0, 90.0, 180.0, 270.0, 360.0])
        across = ground**2 + crank**2 - 2 * ground * crank * np.cos(turn)
        expected = np.degrees(np.arccos((2 * bar**2 - across) / (2 * bar**2)))
        found = curve.loc[state]
        assert found["transmission_angle_deg"].to_numpy() == pytest.approx(expected, rel=1e-9)
        least, greatest = expected[0], expected[2]
        assert found["least_transmission_angle_deg"].to_numpy() == pytest.approx(least, rel=1e-9)
        assert found["greatest_transmission_angle_deg"].to_numpy() == pytest.approx(greatest)
        assert f"{state}: transmission angle {least:.5g} to {greatest:.5g} deg\n" in printed
    assert curve["transmission_angle_deg"].iloc[0] != curve["transmission_angle_deg"].iloc[5]


def test_above_the_wet_glass_transition_the_path_is_drawn_with_a_warning(tmp_path: Path) -> None:
    """The captions of Figures 3 and 4 have 95 K: strain 62.6e-6 * 95 + 3.02e-3 * 7 = 0.027087."""
    hot = ["--temperature-rise", "95", "--moisture", "7", "--angles", "0:360:30", "--details"]
    code, printed, errors = run(
        "coupler-curve", MODELS / "neat_resin_figure_8.toml", *hot, "--out", tmp_path
    )
    assert code == 0
    assert errors.startswith(
        "warning: +95 K, 7 % moisture: the resin of crank, coupler and rocker "
    )
    assert "wet glass transition" in errors
    assert len(errors.splitlines()) == 1
    assert "crank 2310.95," in printed  # 2250 * 1.027087
    assert "stiffness" not in printed
    loaded = CouplerPaths.load(tmp_path / "coupler_curve.nc")
    assert loaded.summary().warnings == (errors.strip().removeprefix("warning: "),)


def test_below_the_wet_glass_transition_there_is_no_warning() -> None:
    model = load_mechanism(MODELS / "moist_composite_fourbar.toml")
    point = CouplerPoint(0.1, 1.0)
    cool = coupler_paths(model, TURN, point, HygrothermalState(60.0, 0.04))
    assert cool.summary().warnings == ()
    assert "stiffness" in str(cool.summary())
    hot = coupler_paths(model, TURN, point, HygrothermalState(500.0, 0.04))
    assert len(hot.summary().warnings) == 1


def test_a_point_of_any_link_of_any_linkage(tmp_path: Path) -> None:
    """At the length of the first beam of the rocker's chain the point is the pivot O4."""
    code, _, errors = run(
        *("coupler-curve", MODELS / "watt_six_bar.toml", "--link", "rocker"),
        *("--point", "140 mm,20 deg", "--angles", "0:360:30", "--out", tmp_path),
    )
    assert (code, errors) == (0, "")
    found = pd.read_csv(tmp_path / "coupler_curve.csv")
    assert list(found) == ["state", "crank_angle_deg", "rocker-1_deg", "x_m", "y_m"]
    linkage = load_mechanism(MODELS / "watt_six_bar.toml").linkage
    motion = linkage.motion(np.radians(found["crank_angle_deg"]))
    number = linkage.topology.index("rocker-1")
    angle = motion.angle[:, number] + np.radians(20.0)
    expected = motion.origin[:, number] + 0.14 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    np.testing.assert_allclose(found[["x_m", "y_m"]], expected, atol=1e-10)


def test_the_coupler_of_a_four_bar_drawn_as_planar_has_the_same_path() -> None:
    own = load_mechanism(MODELS / "aluminium_fourbar.toml")
    drawn = replace(own, linkage=drawn_as_planar(own.linkage, 1.0))
    point = CouplerPoint(0.1, 0.5)
    first, second = (
        coupler_paths(each, np.radians(range(360)), point).dataset["position"].values
        for each in (own, drawn)
    )
    np.testing.assert_allclose(second, first, atol=1e-14)


@pytest.mark.parametrize(
    ("model", "options", "said"),
    [
        ("neat_resin_figure_3.toml", [], "linkage.coupler_point: is missing"),
        ("rotating_arm.toml", ["--point", "1 m,0 deg"], "no link 'coupler'; use one of arm"),
        ("watt_six_bar.toml", [], 'as --point "33 mm,320 deg"'),
        ("watt_six_bar.toml", ["--point", "1 m,0 deg", "--link", "rod"], "no link 'rod'"),
        (
            "steel_fourbar.toml",
            ["--point", "100 mm,0 deg", "--moisture", "1"],
            "change nothing in",
        ),
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


def test_what_python_refuses() -> None:
    mechanism = load_mechanism(MODELS / "neat_resin_figure_8.toml")
    for arguments, said in (
        ((mechanism, range(0, 361, 30)), r"crank_angles must be in rad .* np.radians"),
        ((mechanism, ["0 deg"]), "crank_angles must be a number of rad"),
        ((mechanism, 0.5), "crank_angles must be a row"),
        ((mechanism, []), "crank_angles must be"),
        (("models/steel_fourbar.toml", TURN), "read the file first: flexmech.load_mechanism"),
        ((mechanism, TURN, (0.033, 5.6)), "write flexmech.CouplerPoint"),
        ((mechanism, TURN, None, (80, 0.07)), "write flexmech.HygrothermalState"),
    ):
        with pytest.raises(InputError, match=said):
            coupler_paths(*arguments)  # type: ignore[arg-type]
