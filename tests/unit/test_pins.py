"""Pins in model files, in Python, and in the results of strength."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import flexmech
from flexmech.analyses.response.run import run_engine
from flexmech.analyses.response.stresses import carried
from flexmech.analyses.strength.joint_loads import JointLoads
from flexmech.analyses.strength.result import Strength
from flexmech.analyses.strength.running import Runs
from flexmech.errors import InputError
from flexmech.linear_system import RunningLinks
from flexmech.plots import page_width
from flexmech.reference import ReferenceEngine
from tests.support.figure_checks import check_texts, legend_texts, panels
from tests.support.strength_data import composite

MODELS = Path(__file__).parents[2] / "models"
JOINTS = """
[joints.A]
diameter = "8 mm"
eye_thickness = "6 mm"
eye_width = { crank = "20 mm", coupler = "18 mm" }
eye_edge_distance = "12 mm"
bush_length = "10 mm"
allowable_pv = "2 MPa m/s"

[joints.B]
diameter = "6 mm"
allowable_bearing_pressure = "30 MPa"
"""
TEXT = (MODELS / "aluminium_fourbar.toml").read_text(encoding="utf-8")
Written = Callable[[str], Path]


@pytest.fixture
def written(tmp_path: Path) -> Written:
    def write(text: str) -> Path:
        path = tmp_path / "pinned.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def rigid(speed: float) -> flexmech.StrengthRequest:
    """In rpm, of links that are taken as rigid: no search stands between force and factor."""
    return flexmech.StrengthRequest(crank_speed=speed, speed_unit="rpm", source="rigid")


def pinned_text(yield_strength: bool = True) -> str:
    blunt = TEXT.replace('yield_strength = "240 MPa"\n', "")
    return (TEXT if yield_strength else blunt) + JOINTS


def test_pins_of_a_model_file(written: Written) -> None:
    mechanism = flexmech.load_mechanism(written(pinned_text()))
    first, second = mechanism.joint_pins
    assert first == flexmech.JointPin(
        "A",
        8e-3,
        (
            flexmech.PinEye("crank", 6e-3, 20e-3, 12e-3),
            flexmech.PinEye("coupler", 6e-3, 18e-3, 12e-3),
        ),
        bush_length=10e-3,
        allowable_pv=2e6,
    )
    assert second == flexmech.JointPin("B", 6e-3, allowable_bearing_pressure=30e6)
    assert "diameters of pins: A 8 mm; B 6 mm" in mechanism.described()
    assert flexmech.load_mechanism(written(mechanism.to_toml())) == mechanism


def test_a_chain_of_beams_goes_by_its_name(written: Written) -> None:
    text = (MODELS / "stephenson_six_bar.toml").read_text(encoding="utf-8")
    head, tail = text.split("[joints.C]\n")
    pin = 'diameter = "8 mm"\neye_width = { coupler = "30 mm", connector = "20 mm" }\n'
    mechanism = flexmech.load_mechanism(written(f"{head}[joints.C]\n{pin}{tail}"))
    (own,) = mechanism.joint_pins
    assert own.eye("coupler-2").width == 0.03
    assert own.eye("connector").width == 0.02
    assert flexmech.load_mechanism(written(mechanism.to_toml())) == mechanism


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "[joints.A]",
            "[joints.O2]",
            r"joints\.O2: .*no pin, pivot or slider; these are \['A', 'B', 'O4'\]",
        ),
        ('"8 mm"', '"22 mm"', r"joints\.A: .*width of the eye of the coupler must be greater"),
        ('"12 mm"', '"4 mm"', r"joints\.A: .*edge_distance of the eye .* greater than 0.004 m"),
        (
            'coupler = "18 mm"',
            'rocker = "18 mm"',
            r"joints\.A: eye_width\.rocker: .* coupler, crank",
        ),
        ('diameter = "6 mm"\n', "", r"joints\.B: allowable_bearing_pressure belongs to the diam"),
        (
            'allowable_pv = "2 MPa m/s"\n',
            "",
            r"joints\.A: bush_length belongs to an allowable_pv",
        ),
        ("2 MPa m/s", "2 MPa", r"joints\.A\.allowable_pv: .*not that of a p v.*1\.8 MPa m/s"),
        ('"18 mm"', '"18 kg"', r"joints\.A\.eye_width\.coupler: .*'kg'"),
        ('"10 mm"', '"0 mm"', r"joints\.A\.bush_length: must"),
        ("30 MPa", "30 Pa", r"joints\.B\.allowable_bearing_pressure: .*did you mean '30 GPa'"),
    ],
)
def test_what_is_wrong_is_named(written: Written, old: str, new: str, said: str) -> None:
    assert JOINTS.count(old) == 1
    path = written(TEXT + JOINTS.replace(old, new))
    with pytest.raises(InputError, match=said):
        flexmech.load_mechanism(path)


def test_pins_made_in_python_are_checked() -> None:
    eye = flexmech.PinEye("rocker", width=20e-3)
    mechanism = flexmech.load_mechanism(MODELS / "aluminium_fourbar.toml")
    with pytest.raises(InputError, match=r"the rocker has no eye there; .*coupler and crank"):
        replace(mechanism, joint_pins=(flexmech.JointPin("A", 8e-3, (eye,)),))
    with pytest.raises(InputError, match="two eyes"):
        flexmech.JointPin("B", 8e-3, (eye, eye))
    with pytest.raises(InputError, match="diameter"):
        flexmech.JointPin("B", 0.0)
    with pytest.raises(InputError, match="thickness of the eye of the rocker"):
        flexmech.PinEye("rocker", thickness=-1.0)
    twice = replace(mechanism, joint_pins=(flexmech.JointPin("B", 8e-3),) * 2)
    with pytest.raises(InputError, match="twice"):
        twice.to_toml()


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Strength:
    path = tmp_path_factory.mktemp("pins") / "pinned.toml"
    path.write_text(pinned_text(), encoding="utf-8")
    return flexmech.strength(flexmech.load_mechanism(path), rigid(1000.0))


def test_tables_have_pins(found: Strength) -> None:
    tables = found.tables()
    margins, pins = tables["margins"], tables["pins"]
    assert list(pins) == [
        "engine",
        "joint",
        "link",
        "check",
        "crank_angle_deg",
        "stress_Pa",
        "mean_Pa",
        "allowable_Pa",
        "load_factor",
        "speed_factor",
    ]
    # Two eyes by yield, net section and edge, and a bush; two by the stated pressure and by yield.
    assert pins.groupby("joint").size().to_dict() == {"A": 7, "B": 4}
    assert margins["kind"].tolist().count("pin") == 2
    assert margins["load_factor"].is_monotonic_increasing
    for joint, rows in pins.groupby("joint"):
        row = margins[(margins["part"] == joint) & (margins["kind"] == "pin")].iloc[0]
        worst = rows.loc[rows["load_factor"].idxmin()]
        assert row["load_factor"] == worst["load_factor"]
        assert row["speed_factor"] == rows["speed_factor"].min()
        assert row["mode_of_failure"] == worst["check"]
        assert row["crank_angle_deg"] == worst["crank_angle_deg"]
    np.testing.assert_allclose(pins["load_factor"], pins["allowable_Pa"] / pins["stress_Pa"])
    assert (pins["mean_Pa"] < pins["stress_Pa"]).all()
    by_check = pins.set_index(["joint", "link", "check"])["stress_Pa"]
    # The same force in holes of one diameter and length.
    crank, coupler = (by_check["A", link, "bearing yield"] for link in ("crank", "coupler"))
    assert crank == pytest.approx(coupler)


def test_files_of_pins(found: Strength, tmp_path: Path) -> None:
    files = {path.name for path in found.save(tmp_path)}
    assert "pins.csv" in files
    rows = (tmp_path / "margins.csv").read_text().splitlines()
    (bush,) = (row for row in rows if row.startswith("A,pin"))
    # Nothing where a part has no layer.
    assert bush.endswith(",p v")
    assert ",bush,," in bush
    assert any(",surface,1," in row.replace(' surface"', ",surface") for row in rows)
    again = Strength.load(tmp_path / "strength.nc")
    xr.testing.assert_identical(again.dataset, found.dataset)
    assert str(again.summary()) == str(found.summary())


def test_words_name_pins_and_what_is_left_out(found: Strength) -> None:
    summary = found.summary()
    data = found.dataset
    weakest = int(data["margin_speed_factor"].values.argmin())
    assert data["margin_part"].values[weakest] == "A"
    assert "(pin A)" in summary.answer[0]
    assert {number.of for number in summary.numbers} >= {"pin A", "pin B", "crank"}
    lines = "\n".join(summary.lines)
    for said in (
        "pins, net tension left out for want of eye_width: B (rocker, coupler)",
        "pins, shear-out left out for want of eye_edge_distance: B (rocker, coupler)",
        "pins, p v left out for want of allowable_pv: B",
        "pins not judged, for they state no diameter: O4",
        "the cube of the speed",
    ):
        assert said in lines


def test_an_overloaded_pin_is_the_answer(written: Written) -> None:
    text = pinned_text().replace("2 MPa m/s", "0.001 MPa m/s")
    summary = flexmech.strength(flexmech.load_mechanism(written(text)), rigid(2000.0)).summary()
    assert summary.answer[0].startswith("pin A fails first, by p v in the bush, crank at ")
    assert "pin A does not bear its loads" in summary.warnings[0]


@pytest.mark.parametrize("width", [180.0, 88.0])
def test_pins_are_in_the_picture(found: Strength, width: float) -> None:
    with page_width(width):
        figures = found.figures()
        for figure in figures.values():
            check_texts(figure)
    assert any(text.startswith("pin") for text in legend_texts(figures["strength"]))
    factors = found.tables()["margins"].set_index("part")["load_factor"]
    texts = {text.get_text() for text in panels(figures["strength"])[0].texts}
    assert f"{factors['A']:.3g}" in texts
    plt.close("all")


def test_plies_give_no_strength_of_an_eye() -> None:
    """Of a laminate only the stated bearing pressure is checked."""
    pin = flexmech.JointPin("B", 8e-3, allowable_bearing_pressure=50e6)
    mechanism = replace(composite(), joint_pins=(pin, flexmech.JointPin("O4", 8e-3)))
    found = flexmech.strength(mechanism, 950.0, speed_unit="rpm")
    pins = found.tables()["pins"]
    assert set(pins["check"]) == {"bearing pressure"}
    assert set(pins["joint"]) == {"B"}
    lines = "\n".join(found.summary().lines)
    of_eye = "for the strengths of plies do not give that of an eye"
    assert f"left out {of_eye}: B (rocker, coupler), O4 (rocker)" in lines
    assert "pins, bearing pressure left out for want of allowable_bearing_pressure: O4" in lines


def test_links_without_layers_need_a_thickness() -> None:
    mechanism = composite()
    sections = dict(mechanism.sections)
    sections["rocker"] = replace(sections["rocker"], layers=None)
    allowed = {"allowable_bearing_pressure": 50e6, "allowable_pv": 1e6}
    bare = flexmech.JointPin("O4", 8e-3, **allowed)
    mechanism = replace(mechanism, sections=sections, joint_pins=(bare,))
    found = flexmech.strength(mechanism, 950.0, speed_unit="rpm")
    assert "pins" not in found.tables()
    lines = "\n".join(found.summary().lines)
    assert "left out for want of eye_thickness: O4 (rocker)" in lines
    assert "p v left out for want of bush_length: O4" in lines
    stated = replace(bare, eyes=(flexmech.PinEye("rocker", 10e-3),))
    found = flexmech.strength(replace(mechanism, joint_pins=(stated,)), 950.0, speed_unit="rpm")
    assert set(found.tables()["pins"]["check"]) == {"bearing pressure", "p v"}
    assert "for its material is not known: O4 (rocker)" in "\n".join(found.summary().lines)


@pytest.mark.parametrize("search", [False, pytest.param(True, marks=pytest.mark.thorough)])
def test_a_hole_between_the_ends_of_a_link_tears_nothing_out(search: bool) -> None:
    mechanism = flexmech.load_mechanism(MODELS / "stephenson_six_bar.toml")
    strong = flexmech.Material(70e9, 2700.0, 0.33, yield_strength=240e6)
    section = flexmech.BeamSection.rectangle(strong, 16e-3, 10e-3)
    links = mechanism.linkage.topology.link_names
    eyes = tuple(flexmech.PinEye(link, edge_distance=12e-3) for link in ("coupler-1", "rocker"))
    pinned = replace(
        mechanism,
        sections=dict.fromkeys(links, section),
        joint_pins=(flexmech.JointPin("B", 8e-3, eyes),),
    )
    found = flexmech.strength(
        pinned, flexmech.StrengthRequest(crank_speed=20.0, search_speed=search)
    )
    pins = found.tables()["pins"]
    checks = pins.groupby("link")["check"].apply(list).to_dict()
    assert checks["coupler-1"] == ["bearing yield"]
    assert checks["rocker"] == ["bearing yield", "net tension", "shear-out"]
    assert "not at an end of the link: B (coupler-1)" in "\n".join(found.summary().lines)


def test_ends_of_running_links_turn_as_they_are_seen_to() -> None:
    """Rate of the rigid link and of its vibration: the slope of the end's angle over time."""
    mechanism = flexmech.load_mechanism(MODELS / "aluminium_fourbar.toml")
    request = flexmech.StrengthRequest(crank_speed=20.0, source="periodic")
    runs = Runs.of([ReferenceEngine(mechanism, 4)], request, 20.0)
    (engine,) = runs.engines
    trajectory = run_engine(engine, runs.request, runs.plan, lambda *_: None).trajectory
    links, motion = engine.links, carried(engine, trajectory, runs.request.drive)
    moved = trajectory.displacement, trajectory.rate, trajectory.rate
    running = RunningLinks.of_run(engine, motion, trajectory.time, *moved)
    loads = JointLoads.of_running_links(running)
    angles = np.unwrap(motion.angle, axis=0)
    vibrating = 0.0
    for number, link in enumerate(links):
        for side, place in enumerate((0.0, 1.0)):
            turned = trajectory.displacement[number] @ link.readings.rotation_at(place)
            seen = np.gradient(angles[:, number] + turned, trajectory.time)
            rate = loads.rate[:, number, side]
            np.testing.assert_allclose(rate[1:-1], seen[1:-1], atol=0.01 * np.abs(rate).max())
            own = rate - motion.angular_velocity[:, number]
            vibrating = max(vibrating, np.abs(own).max() / np.abs(rate).max())
    # Far beyond the tolerance: the vibration is seen.
    assert vibrating > 0.03


def test_a_block_between_the_ends_of_a_link_is_left_out() -> None:
    """A rod that goes on beyond its slider: what the block gives it is not told apart."""
    linkage = flexmech.PlanarLinkage(
        points={"O2": (0.0, 0.0), "A": (0.0, 0.05), "B": (0.2, 0.0), "C": (0.3, 0.0)},
        links=(
            flexmech.PlanarLink("crank", ("O2", "A")),
            flexmech.PlanarLink("rod", ("A", "B", "C")),
        ),
        ground=("O2",),
        joints=(flexmech.PlanarJoint("O2", "clamp"), flexmech.PlanarJoint("B", "slider", (), 0.0)),
    )
    strong = flexmech.Material(70e9, 2700.0, 0.33, yield_strength=240e6)
    section = flexmech.BeamSection.rectangle(strong, 16e-3, 10e-3)
    mechanism = flexmech.Mechanism(
        linkage,
        dict.fromkeys(linkage.topology.link_names, section),
        joint_pins=(flexmech.JointPin("B", 8e-3, allowable_pv=1e6),),
    )
    found = flexmech.strength(mechanism, 20.0)
    assert "pins" not in found.tables()
    lines = "\n".join(found.summary().lines)
    assert "p v left out for the hole is not at an end of the link: B (rod-1)" in lines
