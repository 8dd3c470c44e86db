"""``flexmech synthesize`` and ``flexmech balance``: proportions and counterweights as files."""

from __future__ import annotations

import shlex
import tomllib
from pathlib import Path

import numpy as np
import pytest

import flexmech
from flexmech import CrankRockerSynthesis, InputError, crank_rocker_synthesis
from flexmech.analyses import BalanceRequest
from flexmech.modelfile import mechanism_from_toml, template
from tests.support.command import MODELS, Ended
from tests.support.journeys import Journey, tells
from tests.support.strategies import fourbar

WANTED = ("--deviation", "20", "--rocker-angle", "100")
ALUMINIUM = "models/aluminium_fourbar.toml"


@pytest.fixture
def designed(tmp_path: Path) -> Journey:
    return Journey(tmp_path / "design", "synthesize", *WANTED, "--ground", "0.4 m", "--no-plots")


def test_the_angles_of_a_design_are_written_and_told(designed: Journey) -> None:
    table = designed.table("transmission_angle")
    assert list(table) == ["crank_angle_deg", "transmission_angle_deg"]
    assert table["crank_angle_deg"] == pytest.approx(np.arange(361))
    assert table["transmission_angle_deg"][[0, 180, 360]] == pytest.approx([70, 110, 70], abs=1e-8)
    result = designed.result()
    assert isinstance(result, CrankRockerSynthesis)
    crank, coupler, rocker = result.dataset["length"].values[1:] / 0.4
    for value in (crank, coupler, rocker):
        assert tells(designed.answer, 1e3 * 0.4 * value) or tells(designed.answer, value)
    assert designed.ended.files == [
        "summary.txt",
        "transmission_angle.csv",
        "transmission_angle.nc",
    ]


def test_lengths_of_a_design_are_a_table_for_a_model_file(command) -> None:  # type: ignore[no-untyped-def]
    printed = command("synthesize", *WANTED, "--ground", "0.4 m", "--no-plots").stdout
    table = printed[printed.index("[linkage]") : printed.index("check:")]
    assert tomllib.loads(table)["linkage"]["crank"] == "56.3188 mm"
    model = template("four-bar")
    start, end = model.index("[linkage]"), model.index("[materials")
    linkage = mechanism_from_toml(model[:start] + table + model[end:]).linkage
    limits = np.degrees(linkage.transmission_angle_limits())
    assert limits == pytest.approx([70, 110], abs=1e-3)
    assert "[linkage]" not in str(crank_rocker_synthesis(*np.radians([20, 100])).summary())


@pytest.mark.parametrize(
    ("words", "named", "remedy"),
    [
        ("--deviation 20 --rocker-angle 60", "rocker angle", "above 30 deg"),
        ("--deviation 95 --rocker-angle 100", "--deviation", "between 0 and 90 deg"),
        ("--deviation nan --rocker-angle 100", "--deviation", "got nan"),
        ("--deviation '20 deg' --rocker-angle 100", "'--deviation'", "valid"),
        ("--deviation 20", "'--rocker-angle'", "Missing"),
        ("--deviation 20 --rocker-angle 100 --ground '4 kg'", "--ground", "length"),
        ("--deviation 20 --rocker-angle 100 --ground 400", "--ground", "unit"),
        ("--deviation 20 --rocker-angle 100 --ground '0 mm'", "--ground", "positive"),
    ],
)
def test_designs_that_cannot_be_are_refused(words: str, named: str, remedy: str, command) -> None:  # type: ignore[no-untyped-def]
    ended: Ended = command("synthesize", *shlex.split(words))
    assert (ended.exit_code, ended.stdout, ended.files) == (2, "", [])
    assert named in ended.stderr
    assert remedy in ended.stderr


# --- balance ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def journey(tmp_path_factory: pytest.TempPathFactory) -> Journey:
    folder = tmp_path_factory.mktemp("balance") / "out"
    words = ("--speed", "190 rpm", "--radius", "40 mm,60 mm", "--full", "--rigid", "--no-plots")
    return Journey(folder, "balance", ALUMINIUM, *words)


def test_counterweights_and_the_balanced_model_are_written(journey: Journey) -> None:
    """Masses in g: (m2 / 2 + m3 / 2) l2 and (m3 / 2 + m4 / 2) l4 over the radii."""
    weights = journey.table("counterweights")
    assert weights["radius_m"].tolist() == [0.04, 0.06]
    assert weights["x_m"].tolist() == [-0.04, -0.06]
    mechanism = flexmech.load_mechanism(MODELS / "aluminium_fourbar.toml")
    crank, coupler, rocker = (
        mechanism.link_mass(n).moment(0) for n in ("crank", "coupler", "rocker")
    )
    first = (crank / 2 + coupler / 2) * 0.102 / 0.04
    second = (coupler / 2 + rocker / 2) * 0.2667 / 0.06
    for link, mass in (("crank", first), ("rocker", second)):
        assert journey.number("counterweight_mass", link) == pytest.approx(1e3 * mass, rel=1e-9)
    before = journey.number("peak_shaking_force", "as given")
    assert before == pytest.approx(4.738, abs=1e-3)
    assert journey.number("peak_shaking_force", "balanced") < 1e-12 * before
    loads = journey.table("balance")
    assert list(dict.fromkeys(loads["state"])) == ["as given", "balanced"]
    assert len(loads["state"]) == 2 * 361
    assert any(tells(line, round(before, 3)) for line in journey.said["answer"])


def test_the_users_file_is_kept_but_for_its_counterweights(journey: Journey) -> None:
    file = journey.ended.folder / "balanced.toml"
    assert f"model file: {file}" in journey.said["details"]["lines"]
    text = file.read_text().splitlines()
    own = (MODELS / "aluminium_fourbar.toml").read_text().splitlines()
    assert text[0] == 'name = "aluminium four-bar, balanced"'
    assert text[1 : len(own)] == own[1:]
    assert "[[links.crank.bodies]]" in text


@pytest.mark.parametrize("made", ["in Python", "links in a line"])
def test_a_model_that_takes_no_tables_is_written_anew(made: str) -> None:
    given = fourbar()
    if made == "links in a line":
        text = (MODELS / "aluminium_fourbar.toml").read_text()
        for link in ("crank", "coupler", "rocker"):
            start = text.index(f"[links.{link}]")
            text = text[:start] + text[text.index("\n\n", start) + 2 :]
        kept = "{material='aluminium',section='rectangle',in_plane_thickness='2 mm',"
        kept += "out_of_plane_width='25 mm'}"
        links = f"links = {{crank={kept},coupler={kept},rocker={kept}}}\n"
        given = mechanism_from_toml(text.replace("[linkage]", f"{links}\n[linkage]", 1))
    text = flexmech.balance(given, 20.0, full=True, rigid=True).texts()["balanced.toml"]
    written = mechanism_from_toml(text)
    assert len(written.bodies) == 2
    assert written.linkage == given.linkage


def test_counterweights_out_of_proportion_are_warned_of(command) -> None:  # type: ignore[no-untyped-def]
    """A tenth of a millimetre from the pivots: 500 times what is needed at half the length."""
    ended = command("balance", ALUMINIUM, "--radius", "0.1 mm", "--full", "--rigid", "--no-plots")
    assert ended.exit_code == 0
    assert (
        "counterweights of 118548 g are 1.25e+03 times as heavy as all that moves" in ended.stderr
    )
    ended = command("balance", ALUMINIUM, "--rigid", "--no-plots")
    assert "counterweights of" not in ended.stderr


def test_a_share_and_a_compromise_are_told(command) -> None:  # type: ignore[no-untyped-def]
    ended: Ended = command(
        "balance", "models/slider_crank.toml", "--share", "60%", "--rigid", "--no-plots"
    )
    assert "of 60 % of the reciprocating mass" in ended.stdout
    balanced = flexmech.load_mechanism(ended.folder / "balanced.toml")
    assert [body.link for body in balanced.bodies].count("crank") == 2
    ended = command("balance", ALUMINIUM, "--weights", "1,0.5,0.5", "--rigid", "--no-plots")
    assert "weights of 1 for shaking force, 0.5 for shaking moment" in ended.stdout


@pytest.mark.parametrize(
    ("model", "words", "named", "remedy"),
    [
        ("aluminium_fourbar", "--weights 1,1", "--weights", "3 numbers"),
        ("aluminium_fourbar", "--weights 0,0,0", "--weights", "one of them positive"),
        ("aluminium_fourbar", "--weights 1,-1,0", "--weights", "zero or positive"),
        ("aluminium_fourbar", "--weights 1,x,0", "--weights", "write a number"),
        ("aluminium_fourbar", "--weights 1,1,1 --full", "--full", "one of both"),
        ("slider_crank", "--speed 5 --full", "--full", "share 1"),
        ("aluminium_fourbar", "--radius 30", "--radius", "unit"),
        ("aluminium_fourbar", "--radius '1 mm,2 mm,3 mm'", "--radius", "2 can carry"),
        ("aluminium_fourbar", "--radius '0 mm'", "--radius", "positive"),
        ("aluminium_fourbar", "--share 140%", "--share", "0 to 1"),
        ("aluminium_fourbar", "--speed 0", "--speed", "nothing turns"),
        ("carton_pusher", "--speed 5", "5 links, 1 clamp", "a four-bar and a slider-crank"),
        ("rotating_arm", "--speed 5", "1 link, 1 clamp", "a four-bar and a slider-crank"),
    ],
)
def test_what_cannot_be_balanced_is_refused(
    model: str,
    words: str,
    named: str,
    remedy: str,
    command,  # type: ignore[no-untyped-def]
) -> None:
    ended: Ended = command("balance", f"models/{model}.toml", *shlex.split(words), "--rigid")
    assert (ended.exit_code, ended.files) == (2, [])
    assert ended.stderr.count("\n") == 1
    assert named in ended.stderr
    assert remedy in ended.stderr


def test_requests_that_cannot_be_are_refused() -> None:
    rigid = BalanceRequest(rigid=True)
    assert flexmech.balance(
        flexmech.load_mechanism(MODELS / "aluminium_fourbar.toml"), rigid
    ).dataset.attrs["crank_speed"] == pytest.approx(20.0)
    with pytest.raises(InputError, match="speed: is left out"):
        flexmech.balance(fourbar(), rigid)
    with pytest.raises(InputError, match="at which nothing shakes"):
        BalanceRequest(0.0)
    for request in (flexmech.analyses.KinematicsRequest, flexmech.analyses.ResponseRequest):
        with pytest.raises(InputError, match="moment_point"):
            request(moment_point=(0.1, np.nan))
