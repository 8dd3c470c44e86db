"""``flexmech balance``: its files, words and refusals."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_hex
from typer.testing import CliRunner

import flexmech
from flexmech import Balance, BalanceRequest, InputError
from flexmech.cli import app
from flexmech.modelfile.read import mechanism_from_toml
from flexmech.plots import plot_balance
from flexmech.plots.style import series_style
from tests.support.figure_checks import check_layout, panels
from tests.support.strategies import arm, fourbar
from tests.unit.balance_data import balance_dataset, balance_result

pytestmark = pytest.mark.usefixtures("rough_pictures")

MODELS = Path(__file__).parents[2] / "models"
ALUMINIUM = MODELS / "aluminium_fourbar.toml"


def run(*arguments: str | Path) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, ["balance", *(str(each) for each in arguments)])
    return result.exit_code, result.stdout, result.stderr


class TestCommand:
    def test_it_writes_tables_picture_and_the_balanced_model(self, tmp_path: Path) -> None:
        options = ("--speed", "190 rpm", "--radius", "40 mm,60 mm", "--rigid", "--out", tmp_path)
        code, printed, errors = run(ALUMINIUM, *options)
        assert (code, errors) == (0, "")
        assert {file.name for file in tmp_path.iterdir()} == {*Balance.files, "summary.txt"}
        first, second, third = printed.splitlines()[:3]
        assert first.startswith("Full balance of the shaking force (Berkof and Lowen 1969): ")
        assert "40 mm from O2, opposite the link; " in first
        assert "on the rocker, 60 mm from O4, opposite the link." in first
        assert second.startswith("The shaking force of rigid links goes from 4.738 to 0 N, the sha")
        assert third.startswith("For it ")
        weights = pd.read_csv(tmp_path / "counterweights.csv").set_index("link")
        assert weights["radius_m"].tolist() == [0.04, 0.06]
        assert weights["x_m"].tolist() == [-0.04, -0.06]
        loads = pd.read_csv(tmp_path / "balance.csv")
        assert loads["state"].unique().tolist() == ["as given", "balanced"]
        assert len(loads) == 2 * 361
        loaded = Balance.load(tmp_path / "balance.nc")
        assert loaded.dataset["shaking_force"].dims == ("state", "crank_angle", "component")
        assert loaded.texts()["balanced.toml"] == (tmp_path / "balanced.toml").read_text()

    def test_for_programs(self, tmp_path: Path) -> None:
        code, printed, _ = run(ALUMINIUM, "--rigid", "--json", "--no-plots", "--out", tmp_path)
        assert code == 0
        numbers = json.loads(printed)["numbers"]
        masses = {one["of"]: one["value"] for one in numbers if one["name"] == "counterweight_mass"}
        assert masses == pytest.approx({"crank": 62.8276, "rocker": 64.8716}, rel=1e-5)
        forces = {one["of"]: one["value"] for one in numbers if one["name"] == "peak_shaking_force"}
        assert forces["balanced"] < 1e-12 * forces["as given"]

    def test_a_compromise(self, tmp_path: Path) -> None:
        options = ("--weights", "1,0.5,0.5", "--rigid", "--no-plots", "--out", tmp_path)
        code, printed, _ = run(ALUMINIUM, *options)
        assert code == 0
        assert printed.splitlines()[1].startswith(
            "A compromise with weights of 1 for shaking force, 0.5 for shaking moment, 0.5 for "
            "driving torque: "
        )

    def test_of_a_slider_crank(self, tmp_path: Path) -> None:
        options = ("--share", "60%", "--rigid", "--no-plots", "--out", tmp_path)
        code, printed, _ = run(MODELS / "slider_crank.toml", *options)
        assert code == 0
        said = "Balance of the rotating masses and of 60 % of the reciprocating mass: "
        assert said in printed
        assert [body.link for body in load(tmp_path).bodies].count("crank") == 2

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            (("--weights", "1,1"), "weights: must be 3 numbers, of shaking force, shaking moment"),
            (("--weights", "0,0,0"), "one of them positive"),
            (("--weights", "1,-1,0"), "weights: each weight must be zero or positive"),
            (("--weights", "1,x,0"), "--weights: "),
            (("--radius", "30"), "--radius: got '30', which has no unit"),
            (("--radius", "1 mm,2 mm,3 mm"), "radii: got 3, and 2 can carry a counterweight"),
            (("--radius", "0 mm"), "radii: each radius must be positive"),
            (("--share", "140%"), "share: must be 0 to 1, got 1.4"),
            (("--speed", "0"), "--speed: got '0', at which nothing turns"),
        ],
    )
    def test_what_makes_no_sense_is_refused(self, options, message, tmp_path: Path) -> None:
        code, _, errors = run(ALUMINIUM, *options, "--rigid", "--out", tmp_path / "none")
        assert code == InputError.exit_code
        assert message in errors
        assert errors.count("\n") == 1
        assert not (tmp_path / "none").exists()

    @pytest.mark.parametrize(
        ("name", "has"),
        [
            ("carton_pusher", "5 links, 1 clamp, 3 pins, 1 pivot, 1 slider, 1 weld"),
            ("rotating_arm", "1 link, 1 clamp: "),
            ("watt_six_bar", "links, 1 clamp, "),
        ],
    )
    def test_other_linkages_are_refused_with_what_they_have(self, name: str, has: str) -> None:
        code, _, errors = run(MODELS / f"{name}.toml", "--speed", "5", "--rigid")
        assert code == InputError.exit_code
        assert "counterweights are found for a four-bar and a slider-crank, whose loop" in errors
        assert has in errors
        assert errors.count("\n") == 1


def load(folder: Path) -> flexmech.Mechanism:
    return flexmech.load_mechanism(folder / "balanced.toml")


class TestModelFile:
    REQUEST = BalanceRequest(20.0, elastic=False)

    def test_the_users_own_file_is_kept(self) -> None:
        given = flexmech.load_mechanism(ALUMINIUM)
        text = flexmech.balance(given, self.REQUEST).texts()["balanced.toml"]
        own = ALUMINIUM.read_text().splitlines()
        assert text.splitlines()[0] == 'name = "aluminium four-bar, balanced"'
        assert text.splitlines()[1 : len(own)] == own[1:]
        assert '[[links.crank.bodies]]\nposition = "0 mm"\nmass = "62.8' in text

    @pytest.mark.parametrize("made", ["in Python", "links in a line"])
    def test_one_that_takes_no_tables_is_written_anew(self, made: str) -> None:
        given = fourbar()
        if made == "links in a line":
            text = ALUMINIUM.read_text()
            for link in ("crank", "coupler", "rocker"):
                start = text.index(f"[links.{link}]")
                text = text[:start] + text[text.index("\n\n", start) + 2 :]
            kept = "{material='aluminium',section='rectangle',in_plane_thickness='2 mm',"
            kept += "out_of_plane_width='25 mm'}"
            links = f"links = {{crank={kept},coupler={kept},rocker={kept}}}\n"
            given = mechanism_from_toml(text.replace("[linkage]", f"{links}\n[linkage]", 1))
        text = flexmech.balance(given, self.REQUEST).texts()["balanced.toml"]
        written = mechanism_from_toml(text)
        assert len(written.bodies) == 2
        assert written.linkage == given.linkage
        assert text.startswith("# Counterweights: full balance of the shaking force")

    def test_counterweights_come_to_what_is_there(self) -> None:
        """Balanced once more nothing is left to add."""
        once = flexmech.balance(flexmech.load_mechanism(ALUMINIUM), self.REQUEST)
        again = flexmech.balance(mechanism_from_toml(once.texts()["balanced.toml"]), self.REQUEST)
        assert np.all(once.dataset["counterweight_mass"] > 0)
        assert np.all(again.dataset["counterweight_mass"] == 0)
        assert again.summary().answer[0].startswith("No counterweight is needed")


class TestRequest:
    def test_its_speed_is_the_mechanisms_or_has_a_unit(self) -> None:
        mechanism = flexmech.load_mechanism(ALUMINIUM)
        rigid = BalanceRequest(elastic=False)
        assert flexmech.balance(mechanism, rigid).dataset.attrs["crank_speed"] == 20.0
        with pytest.raises(InputError, match="crank_speed: is left out, and the model names none"):
            flexmech.balance(fourbar(), rigid)
        with pytest.raises(InputError, match="speed_unit: the request has its own"):
            flexmech.balance(mechanism, rigid, speed_unit="rpm")
        with pytest.raises(InputError, match="at which nothing shakes"):
            BalanceRequest(0.0)

    def test_what_is_not_there_cannot_be_weighed(self) -> None:
        """Rigid rods without mass need no torque."""
        drawn = flexmech.load_mechanism(MODELS / "slider_crank.toml").linkage
        rigid = tuple(replace(link, rigid=True) for link in drawn.links)
        mechanism = flexmech.Mechanism(replace(drawn, links=rigid), {})
        request = BalanceRequest(5.0, weights=(0, 0, 1), elastic=False)
        with pytest.raises(InputError, match="has no driving torque at this speed"):
            flexmech.balance(mechanism, request)

    def test_one_radius_is_for_all(self) -> None:
        one, both = (
            flexmech.balance(fourbar(), BalanceRequest(20.0, radii=radii, elastic=False)).dataset
            for radii in (0.05, (0.05, 0.05))
        )
        assert one.identical(both)


class TestElasticLinks:
    def test_what_they_leave_is_told(self) -> None:
        """Of stiff links nothing is left; of thin ones with long tails most, with a warning."""
        request = BalanceRequest(20.0, radii=(0.05, 0.13))
        thin = flexmech.balance(fourbar(), request)
        said = thin.summary()
        assert any("elastic links keep" in line for line in said.warnings)
        stiff = flexmech.balance(
            fourbar(thickness=(30e-3, 30e-3, 30e-3)), BalanceRequest(15.0, radii=(0.05, 0.05))
        )
        force = np.linalg.norm(stiff.dataset["elastic_shaking_force"].values, axis=-1).max(axis=-1)
        assert force[1] < 0.01 * force[0]
        assert not stiff.summary().warnings
        first = thin.dataset["first_frequency"].values
        assert first[0] == pytest.approx(43.7, rel=0.01)
        assert first[1] < first[0]
        assert "first natural frequency" in said.answer[-1]


class TestPicture:
    def test_it_is_the_dataset(self) -> None:
        data = balance_dataset()
        figure = plot_balance(data)
        check_layout(figure)
        plane, size, moment, torque = panels(figure)
        color = series_style(0).color
        force = data["shaking_force"].sel(state="as given").values
        (path,) = [line for line in plane.lines if to_hex(line.get_color()) == color.lower()]
        np.testing.assert_allclose(path.get_xydata(), force, rtol=1e-12)
        shown = [line for line in size.lines if to_hex(line.get_color()) == color.lower()]
        wanted = [force, data["elastic_shaking_force"].sel(state="as given").values]
        drawn = sorted((line.get_ydata() for line in shown), key=len)
        for line, values in zip(drawn, sorted(wanted, key=len), strict=True):
            np.testing.assert_allclose(line, np.linalg.norm(values, axis=-1), rtol=1e-12)
        for axes, name in ((moment, "shaking_moment"), (torque, "driving_torque")):
            lines = [line.get_ydata() for line in axes.lines if len(line.get_ydata()) > 2]
            np.testing.assert_allclose(lines, data[name].transpose("state", ...).values)

    def test_a_balanced_force_is_a_point(self) -> None:
        plane = panels(plot_balance(balance_dataset()))[0]
        assert any(line.get_marker() == "o" and line.get_xdata()[0] == 0 for line in plane.lines)
        half = balance_dataset()
        half["shaking_force"] = half["shaking_force"] + half["shaking_force"].sel(state="as given")
        plane = panels(plot_balance(half))[0]
        assert all(line.get_marker() != "o" for line in plane.lines)


def test_the_table_has_what_it_takes_and_gives() -> None:
    table = balance_result().summary().table
    assert table is not None
    rows = {row[0]: row[2:] for group in table.groups for row in group}
    assert rows["shaking force, rigid links"][1:] == ("0", "-100.0")
    data = balance_dataset()
    mass = 1e3 * data["moving_mass"].values
    assert float(rows["moving mass"][0]) == pytest.approx(mass[0], rel=1e-3)
    force = np.linalg.norm(data["joint_force"].sel(joint="O4").values, axis=-1).max(axis=-1)
    assert [float(cell) for cell in rows["force at O4"][:2]] == pytest.approx(force, rel=1e-3)
    assert rows["first natural frequency"][:2] == ("43.7", "20.1")


def test_an_arm_is_none() -> None:
    with pytest.raises(InputError, match="whose loop has one coupler; this linkage has 1 link"):
        flexmech.balance(arm(), 5.0)
