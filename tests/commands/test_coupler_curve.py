"""``flexmech coupler-curve``: a curve dry and wet, its crossings, other links, refusals."""

from __future__ import annotations

import shlex

import numpy as np
import pytest

import flexmech
from flexmech import CouplerPoint, HygrothermalState, coupler_paths
from tests.support.command import MODELS, Ended
from tests.support.journeys import Journey, tells

MODEL = "models/neat_resin_figure_8.toml"
WET = ("--temperature-rise", "80", "--moisture", "7")
COLUMNS = (
    "state,crank_angle_deg,theta3_deg,theta4_deg,x_m,y_m,transmission_angle_deg,"
    "least_transmission_angle_deg,greatest_transmission_angle_deg"
)


@pytest.fixture(scope="module")
def journey(tmp_path_factory: pytest.TempPathFactory) -> Journey:
    folder = tmp_path_factory.mktemp("coupler") / "out"
    words = (*WET, "--angles", "0:360:30", "--no-plots")
    return Journey(folder, "coupler-curve", MODEL, *words)


def test_the_curve_is_written_dry_and_wet(journey: Journey) -> None:
    curve, data = journey.table("coupler_curve"), journey.result().dataset
    assert ",".join(curve) == COLUMNS
    assert curve["state"].tolist() == ["dry"] * 13 + ["wet"] * 13
    asked = HygrothermalState(80, 0.07)
    mechanism = flexmech.load_mechanism(MODELS / "neat_resin_figure_8.toml")
    paths = coupler_paths(mechanism, np.radians(np.arange(0, 361, 30)), environment=asked).dataset
    assert data["position"].identical(paths["position"])
    for number, name in enumerate(("dry", "wet")):
        rows, path = curve["state"] == name, paths.isel(state=number)
        place = np.stack([curve["x_m"], curve["y_m"]], axis=1)[rows]
        assert place == pytest.approx(path["position"].values, rel=1e-8)
        angles = np.stack([curve["theta3_deg"], curve["theta4_deg"]], axis=1)[rows]
        assert angles == pytest.approx(np.degrees(path["angle"].values), rel=1e-8)


def test_its_double_point_is_where_two_passages_meet(journey: Journey) -> None:
    """The dry curve has it; wet, the loop is gone."""
    topology = journey.table("topology")
    columns = ["state", "kind", "crank_angle_1_deg", "crank_angle_2_deg", "x_m", "y_m"]
    assert list(topology) == columns
    assert topology["kind"].tolist() == ["crunode"]
    assert topology["state"].tolist() == ["dry"]
    angles = np.radians([topology["crank_angle_1_deg"][0], topology["crank_angle_2_deg"][0]])
    mechanism = flexmech.load_mechanism(MODELS / "neat_resin_figure_8.toml")
    both = coupler_paths(mechanism, angles).dataset["position"].values[0]
    assert np.hypot(*(both[1] - both[0])) < 1e-9
    assert both[0] == pytest.approx([topology["x_m"][0], topology["y_m"][0]], abs=1e-8)
    said = journey.said["answer"]
    assert "with 1 crunode and no cusps" in said[0]
    assert said[1].startswith("At +80 K, 7 % moisture it covers ")
    position = journey.result().dataset["position"].values
    moved = np.linalg.norm(position[1] - position[0], axis=-1).max()
    assert said[2].startswith("Its greatest shift is ")
    assert not tells(said[2], 0.9 * 1e3 * moved)
    # One loop, whose close-up is dry and around the double point.
    close = journey.result().dataset["close_up"]
    assert close.sizes["window"] == 1


def test_a_point_of_the_command_line_goes_before_the_models(command) -> None:  # type: ignore[no-untyped-def]
    """Dry alone, at every degree."""
    words = ("--point", "0.01 m,90 deg", "--no-plots")
    ended: Ended = command("coupler-curve", "models/neat_resin_figure_12.toml", *words)
    curve = ended.table("coupler_curve")
    assert set(curve["state"]) == {"dry"}
    assert len(curve["x_m"]) == 361
    angle, crank = np.radians(curve["theta3_deg"] + 90), np.radians(curve["crank_angle_deg"])
    assert curve["x_m"] == pytest.approx(0.015 * np.cos(crank) + 0.01 * np.cos(angle))
    assert "wet" not in ended.stdout


def test_a_point_of_any_link_of_any_linkage(command) -> None:  # type: ignore[no-untyped-def]
    """At the length of the first beam of the rocker's chain it is the pivot O4 at 0 degrees."""
    words = ("--link", "rocker", "--point", "140 mm,20 deg", "--angles", "0:360:30", "--no-plots")
    ended: Ended = command("coupler-curve", "models/watt_six_bar.toml", *words)
    curve = ended.table("coupler_curve")
    assert list(curve) == ["state", "crank_angle_deg", "rocker-1_deg", "x_m", "y_m"]
    linkage = flexmech.load_mechanism(MODELS / "watt_six_bar.toml").linkage
    motion = linkage.motion(np.radians(curve["crank_angle_deg"]))
    number = linkage.topology.index("rocker-1")
    arm = 0.14 * np.exp(1j * (motion.angle[:, number] + np.radians(20.0)))
    place = motion.origin[:, number] @ [1, 1j] + arm
    np.testing.assert_allclose(curve["x_m"] + 1j * curve["y_m"], place, atol=1e-9)


def test_an_exposure_stands_in_place_of_moisture(command) -> None:  # type: ignore[no-untyped-def]
    words = ("--relative-humidity", "85", "--time", "2 day", "--angles", "0,90", "--no-plots")
    ended: Ended = command("coupler-curve", "models/neat_resin_figure_12.toml", *words)
    assert (ended.exit_code, ended.stderr) == (0, "")
    assert "85 % humidity for 2 d" in ended.stdout
    assert set(ended.table("coupler_curve")["state"]) == {"dry", "wet"}


def test_above_the_wet_glass_transition_a_warning_is_given(command) -> None:  # type: ignore[no-untyped-def]
    """At 95 K: strain 62.6e-6 * 95 + 3.02e-3 * 7 = 0.027087, of a crank of 2250 mm."""
    words = ("--temperature-rise", "95", "--moisture", "7", "--angles", "0,90", "--no-plots")
    ended: Ended = command("coupler-curve", MODEL, *words, "--details")
    assert ended.exit_code == 0
    assert ended.stderr.startswith("warning: +95 K, 7 % moisture: the resin of crank, coupler")
    assert ended.stderr.count("\n") == 1
    assert f"crank {2250 * 1.027087:.6g}," in ended.stdout
    cool = coupler_paths(
        flexmech.load_mechanism(MODELS / "moist_composite_fourbar.toml"),
        [0.0, 1.0],
        CouplerPoint(0.1, 1.0),
        environment=HygrothermalState(60.0, 0.04),
    )
    assert cool.summary().warnings == ()


@pytest.mark.parametrize(
    ("model", "words", "named", "remedy"),
    [
        ("neat_resin_figure_3", "", "linkage.coupler_point", "missing"),
        ("rotating_arm", "--point '1 m,0 deg'", "'coupler'", "use one of arm"),
        ("watt_six_bar", "", "--point", '"33 mm,320 deg"'),
        ("watt_six_bar", "--point '1 m,0 deg' --link rod", "'rod'", "rocker"),
        ("steel_fourbar", "--point '100 mm,0 deg' --moisture 1", "moisture", "change nothing"),
        ("neat_resin_figure_8", "--angles 0:360", "--angles", "START:STOP:STEP"),
        ("neat_resin_figure_8", "--point '33 mm'", "--point", "distance and angle"),
        ("neat_resin_figure_8", "--point '100,30'", "--point", "unit"),
        ("neat_resin_figure_8", "--point '33 deg,4 deg'", "--point", "length"),
        ("neat_resin_figure_8", "--point '-1 mm,0 deg'", "--point", "distance and angle"),
    ],
)
def test_wrong_points_are_refused(model: str, words: str, named: str, remedy: str, command) -> None:  # type: ignore[no-untyped-def]
    ended: Ended = command("coupler-curve", f"models/{model}.toml", *shlex.split(words))
    assert (ended.exit_code, ended.stdout, ended.files) == (2, "", [])
    assert ended.stderr.count("\n") == 1
    assert named in ended.stderr
    assert remedy in ended.stderr
