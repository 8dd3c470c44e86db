"""Strength of pins: a slider-crank by hand, links cut free, speeds at which pins fail, model files.

Formulas of Shigley's *Mechanical Engineering Design*, 9th ed., secs. 8-12 and 12-15.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import flexmech
from flexmech import (
    BeamSection,
    InputError,
    JointPin,
    Load,
    Material,
    Mechanism,
    PinEye,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    Strength,
    load_mechanism,
    strength,
)
from flexmech.analyses import StrengthRequest
from flexmech.linkages import AttachmentPoint
from flexmech.modelfile import mechanism_from_toml
from tests.support.command import MODELS

YIELD = 240e6
# Without weight, so that slider and load alone make the forces.
LIGHT = Material(70e9, 1e-6, 0.33, yield_strength=YIELD)
HEAVY = replace(LIGHT, density=2700.0)
WIDTH, HEIGHT, DIAMETER, EDGE, SPEED = 12e-3, 20e-3, 8e-3, 14e-3, 150.0
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


def in_sections(mechanism: Mechanism, material: Material) -> Mechanism:
    """The mechanism with sections of one size and material, and no masses at its joints."""
    section = BeamSection.rectangle(material, HEIGHT, WIDTH)
    sections = dict.fromkeys(mechanism.linkage.topology.link_names, section)
    return replace(mechanism, sections=sections, joint_masses={}, link_masses=())


def pinned(mechanism: Mechanism, **allowed: float) -> Mechanism:
    """The mechanism with pins of one size in all pins and pivots."""
    ends = mechanism.linkage.topology.turning_ends
    pins = tuple(
        JointPin(
            joint,
            DIAMETER,
            tuple(PinEye(end.link, edge_distance=EDGE) for end in own if end is not None),
            **allowed,
        )
        for joint, own in ends.items()
    )
    return replace(mechanism, joint_pins=pins)


def slider_crank() -> Mechanism:
    light = in_sections(load_mechanism(MODELS / "slider_crank.toml"), LIGHT)
    heavy = replace(light, joint_masses={"B": 0.5})
    return pinned(heavy, allowable_pv=5e6, allowable_bearing_pressure=30e6)


def rigid(mechanism: Mechanism, speed: StrengthRequest | float) -> Strength:
    """Strength of links taken as rigid, whose forces follow by hand."""
    asked = speed if isinstance(speed, StrengthRequest) else StrengthRequest(speed)
    return strength(mechanism, replace(asked, source="rigid"))


def checks(dataset: xr.Dataset, joint: str, link: str = "") -> dict[str, xr.Dataset]:
    """Checks of a pin in one link, or of its bush, by their modes."""
    own = (dataset["pin_joint"].values == joint) & (dataset["pin_link"].values == link)
    found = dataset.isel(pin_check=own, engine=0)
    modes = found["pin_mode"].values
    return {str(mode): found.isel(pin_check=number) for number, mode in enumerate(modes)}


@pytest.mark.parametrize(("angle", "sign"), [(0.0, 1.0), (np.pi, -1.0)])
def test_slider_crank_at_its_dead_centres(angle: float, sign: float) -> None:
    """The slider alone: F = m r w^2 (1 +- r/l), which pulls at the outer one, pushes at the inner.

    Crank and rod turn against each other by w (1 +- r/l).
    """
    mechanism = slider_crank()
    crank, rod = (link.length for link in mechanism.linkage.topology.links)
    found = rigid(mechanism, StrengthRequest(SPEED, crank_angles=np.array([angle]))).dataset
    ratio = 1 + sign * crank / rod
    force = 0.5 * crank * SPEED**2 * ratio
    own = checks(found, "A", "rod")
    bearing = force / (DIAMETER * WIDTH)
    assert float(own["bearing pressure"]["pin_stress"]) == pytest.approx(bearing, rel=1e-6)
    assert float(own["bearing yield"]["pin_load_factor"]) == pytest.approx(YIELD / bearing)
    by_speed = float(own["bearing yield"]["pin_speed_factor"])
    assert by_speed == pytest.approx(np.sqrt(YIELD / bearing), rel=1e-6)
    wear = force * SPEED * ratio / (2 * WIDTH)
    bush = checks(found, "A")["p v"]
    assert float(bush["pin_stress"]) == pytest.approx(wear, rel=1e-6)
    assert float(bush["pin_speed_factor"]) == pytest.approx(np.cbrt(5e6 / wear), rel=1e-6)
    pulls = max(sign, 0.0) * force
    net = pulls / ((HEIGHT - DIAMETER) * WIDTH)
    out = pulls / (2 * (EDGE - DIAMETER / 2) * WIDTH)
    for mode, stress in (("net tension", net), ("shear-out", out)):
        assert float(own[mode]["pin_stress"]) == pytest.approx(stress, rel=1e-6, abs=1.0)
    assert float(own["shear-out"]["pin_allowable"]) == pytest.approx(YIELD / np.sqrt(3))


def test_pin_of_a_slider_carries_its_block() -> None:
    """Through a rod without mass: the force of the other pin, whichever way the block pulls.

    A load on the block goes the same way. The rod alone turns, at the dead centre by w r/l.
    """
    mechanism = slider_crank()
    crank, rod = (link.length for link in mechanism.linkage.topology.links)
    gas = Load("gas", AttachmentPoint("rod", rod), ((-900.0, 0.0),))
    for pushed in (mechanism, replace(mechanism, loads=(gas,))):
        found = rigid(pushed, SPEED).dataset
        for mode, own in checks(found, "B", "rod").items():
            other = checks(found, "A", "rod")[mode]
            for name in ("pin_load_factor", "pin_speed_factor", "pin_worst_angle"):
                assert float(own[name]) == pytest.approx(float(other[name]), rel=1e-5)
    dead = rigid(mechanism, StrengthRequest(SPEED, crank_angles=np.zeros(1))).dataset
    wear = 0.5 * crank * SPEED**2 * (1 + crank / rod) * SPEED * (crank / rod) / (2 * WIDTH)
    assert float(checks(dead, "B")["p v"]["pin_stress"]) == pytest.approx(wear, rel=1e-6)


def three_links_on_a_pin() -> Mechanism:
    """Coupler, rocker and rod meet at B."""
    ends = {"crank": "O2 A", "coupler": "A B", "rocker": "O4 B", "rod": "B C", "output": "O6 C"}
    linkage = PlanarLinkage(
        points={
            **{"O2": (0.0, 0.0), "O4": (0.3, 0.0), "O6": (0.6, 0.0)},
            **{"A": (0.05, 0.08), "B": (0.3, 0.2), "C": (0.6, 0.2)},
        },
        links=tuple(PlanarLink(name, tuple(own.split())) for name, own in ends.items()),
        ground=("O2", "O4", "O6"),
        joints=(PlanarJoint("O2", "clamp"),),
    )
    return Mechanism(linkage, dict.fromkeys(ends, BeamSection.rectangle(LIGHT, HEIGHT, WIDTH)))


@pytest.mark.parametrize("model", ["steel_fourbar", "stephenson_six_bar", ""])
def test_force_on_an_eye_is_what_its_link_carries_there(model: str) -> None:
    """Tension and shear force at a link's end, cut free, are the force of the pin in its eye.

    Where three links meet on a pin, an eye carries what both of the others feel.
    """
    known = load_mechanism(MODELS / f"{model}.toml") if model else three_links_on_a_pin()
    topology = known.linkage.topology
    welded = {end for weld in topology.welds for end in (weld.leader, weld.follower)}
    pins = {
        joint: [end for end in own if end is not None and end not in welded]
        for joint, own in topology.pinned_ends.items()
    }
    heavy = in_sections(known, replace(LIGHT, density=2700.0))
    pins_of_one_size = tuple(
        JointPin(joint, DIAMETER, tuple(PinEye(end.link) for end in ends))
        for joint, ends in pins.items()
        if ends
    )
    mechanism, checked = replace(heavy, joint_pins=pins_of_one_size), 0
    for angle in np.radians([10.0, 200.0]):
        found = rigid(mechanism, StrengthRequest(20.0, crank_angles=np.array([angle]))).dataset
        for joint, ends in pins.items():
            for end in ends:
                own = checks(found, joint, end.link).get("bearing yield")
                if own is None:  # a hole between the ends of a chain of beams
                    continue
                inside = found.sel(link=end.link).isel(engine=0, crank_angle=0)
                size = np.hypot(inside["axial_force"], inside["shear_force"]).dropna("station")
                cut = float(size[0 if end.end == "start" else -1])
                force = float(own["pin_stress"]) * DIAMETER * WIDTH
                assert force == pytest.approx(cut, rel=1e-6)
                checked += 1
    assert checked >= 8


def loaded() -> Mechanism:
    """A four-bar with weight and a load that stay as the speed rises."""
    mechanism = load_mechanism(MODELS / "steel_fourbar.toml")
    mechanism = in_sections(mechanism, replace(LIGHT, density=7800.0))
    pull = Load("pull", AttachmentPoint("coupler", 0.1), ((800.0, -300.0),))
    mechanism = replace(mechanism, gravity=(0.0, -9.81), loads=(pull,))
    return pinned(mechanism, allowable_pv=8e6, allowable_bearing_pressure=40e6)


def test_at_its_speed_factor_each_check_is_at_its_bound() -> None:
    """Weight and load stay, inertia grows: seen by computing anew at the faster speed."""
    mechanism, angles = loaded(), np.radians(np.arange(0.0, 361.0, 20.0))
    slow = rigid(mechanism, StrengthRequest(100.0, crank_angles=angles)).dataset
    first = {str(mode): number for number, mode in reversed([*enumerate(slow["pin_mode"].values)])}
    for number in first.values():
        factor = float(slow["pin_speed_factor"][0, number])
        faster = StrengthRequest(100.0 * factor, crank_angles=angles)
        fast = rigid(mechanism, faster).dataset.isel(pin_check=number, engine=0)
        assert float(fast["pin_load_factor"]) == pytest.approx(1.0, rel=1e-9)
        assert factor**2 != pytest.approx(float(slow["pin_load_factor"][0, number]), rel=1e-2)
    assert set(first) == {"bearing yield", "bearing pressure", "net tension", "shear-out", "p v"}


def test_inertia_alone_grows_by_square_and_by_cube_and_at_rest_no_bush_wears() -> None:
    found = rigid(replace(loaded(), gravity=(0.0, 0.0), loads=()), 100.0).dataset
    power = np.where(found["pin_mode"] == "p v", 3, 2)
    factors = (found[name].values[0] for name in ("pin_speed_factor", "pin_load_factor"))
    np.testing.assert_allclose(next(factors) ** power, next(factors), rtol=1e-9)
    found = rigid(loaded(), 0.0).dataset
    wear = found["pin_mode"].values == "p v"
    assert np.isinf(found["pin_load_factor"].values[0, wear]).all()
    assert np.isfinite(found["pin_load_factor"].values[0, ~wear]).all()
    assert np.isnan(found["pin_speed_factor"]).all()


def test_pins_of_a_model_file_are_read_judged_and_written_again() -> None:
    mechanism = mechanism_from_toml(TEXT + JOINTS)
    eyes = PinEye("crank", 6e-3, 20e-3, 12e-3), PinEye("coupler", 6e-3, 18e-3, 12e-3)
    assert mechanism.joint_pins == (
        JointPin("A", 8e-3, eyes, bush_length=10e-3, allowable_pv=2e6),
        JointPin("B", 6e-3, allowable_bearing_pressure=30e6),
    )
    assert mechanism_from_toml(mechanism.to_toml()) == mechanism
    found = rigid(mechanism, 100.0)
    pins, margins = found.tables()["pins"], found.tables()["margins"]
    # Two eyes by yield, net section and edge, and a bush; two by the stated pressure and by yield.
    assert pins.groupby("joint").size().to_dict() == {"A": 7, "B": 4}
    for joint, rows in pins.groupby("joint"):
        row = margins[(margins["part"] == joint) & (margins["kind"] == "pin")].iloc[0]
        weakest = rows.loc[rows["load_factor"].idxmin()]
        for column in ("load_factor", "speed_factor"):
            assert row[column] == weakest[column]
    lines = "\n".join(found.summary().lines)
    for said in (
        "net tension not checked because eye_width is missing: B (rocker, coupler)",
        "not judged: O4",
    ):
        assert said in lines


@pytest.mark.parametrize(
    "source", ["rigid", pytest.param("quasi-static", marks=pytest.mark.thorough)]
)
def test_a_pin_has_a_row_for_the_check_that_loads_and_for_the_one_that_speed_breaks_first(
    source: str,
) -> None:
    """Pressure allows 1.5 times the loads, and the root of it in speed; p v 1.7 and the cube root.

    Short elastic links are nearly rigid ones.
    """
    mechanism = in_sections(load_mechanism(MODELS / "aluminium_fourbar.toml"), HEAVY)
    speed = StrengthRequest(
        20.0, crank_angles=np.radians(np.arange(0.0, 360.0, 30.0)), source=source
    )
    plain = JointPin("A", 8e-3, bush_length=10e-3)

    def found(**allowed: float) -> Strength:
        pinned = replace(mechanism, joint_pins=(replace(plain, **allowed),))
        return strength(flexmech.ReferenceEngine(pinned, 2), speed)

    unit = found(allowable_bearing_pressure=1e3, allowable_pv=1e3).tables()["pins"]
    stress = unit.groupby("check")["stress_Pa"].max()
    pressure, wear = 1.5 * stress["bearing pressure"], 1.7 * stress["p v"]
    both = found(allowable_bearing_pressure=pressure, allowable_pv=wear)
    margins = both.tables()["margins"]
    rows = margins[margins["kind"] == "pin"].set_index("mode_of_failure")
    assert rows["load_factor"].to_dict() == pytest.approx({"bearing pressure": 1.5, "p v": 1.7})
    speeds = rows["speed_factor"]
    assert speeds["p v"] == pytest.approx(np.cbrt(1.7), rel=1e-3)
    if source == "rigid":
        assert speeds["bearing pressure"] == pytest.approx(np.sqrt(1.5))
    else:
        # The search finds the speed at which the pin fails, not that of each check.
        assert np.isnan(speeds["bearing pressure"])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[joints.A]", "[joints.O2]", r"joints\.O2: .*no pin, pivot or slider"),
        ('"8 mm"', '"22 mm"', r"joints\.A: .*width of the eye of the coupler must be greater"),
        ('"12 mm"', '"4 mm"', r"joints\.A: .*edge_distance of the eye"),
        ('coupler = "18 mm"', 'rocker = "18 mm"', r"joints\.A: eye_width\.rocker"),
        ('diameter = "6 mm"\n', "", r"joints\.B: allowable_bearing_pressure belongs to the diam"),
        ("2 MPa m/s", "2 MPa", r"joints\.A\.allowable_pv"),
        ('"18 mm"', '"18 kg"', r"joints\.A\.eye_width\.coupler: .*'kg'"),
    ],
)
def test_keys_of_pins_that_make_no_sense_are_named(old: str, new: str, words: str) -> None:
    assert JOINTS.count(old) == 1
    with pytest.raises(InputError, match=words):
        mechanism_from_toml(TEXT + JOINTS.replace(old, new))


def test_pins_that_no_joint_can_have_are_refused() -> None:
    mechanism, eye = mechanism_from_toml(TEXT), PinEye("rocker", width=20e-3)
    with pytest.raises(InputError, match="the rocker has no eye there"):
        replace(mechanism, joint_pins=(JointPin("A", 8e-3, (eye,)),))
    with pytest.raises(InputError, match="two eyes"):
        JointPin("B", 8e-3, (eye, eye))
    with pytest.raises(InputError, match="thickness of the eye of the rocker"):
        PinEye("rocker", thickness=-1.0)


def test_pins_in_links_without_a_yield_strength_are_refused_with_the_remedy() -> None:
    soft = in_sections(load_mechanism(MODELS / "slider_crank.toml"), Material(70e9, 2700.0))
    with pytest.raises(InputError, match=r"links\.crank: .*Add yield_strength"):
        rigid(pinned(soft), 20.0)


def test_a_hole_between_the_ends_of_a_link_tears_nothing_out() -> None:
    mechanism = in_sections(load_mechanism(MODELS / "stephenson_six_bar.toml"), LIGHT)
    eyes = tuple(PinEye(link, edge_distance=EDGE) for link in ("coupler-1", "rocker"))
    found = rigid(replace(mechanism, joint_pins=(JointPin("B", 8e-3, eyes),)), 20.0)
    judged = found.tables()["pins"].groupby("link")["check"].apply(list).to_dict()
    assert judged["coupler-1"] == ["bearing yield"]
    assert judged["rocker"] == ["bearing yield", "net tension", "shear-out"]
    assert "not at an end of the link: B (coupler-1)" in "\n".join(found.summary().lines)


@pytest.mark.thorough
def test_speed_of_a_bush_is_searched_by_runs() -> None:
    """Slowly running links are nearly rigid: p v passes its bound near the cube root."""
    steel = replace(LIGHT, youngs_modulus=200e9, density=7800.0)
    mechanism = in_sections(load_mechanism(MODELS / "steel_fourbar.toml"), steel)
    wear = rigid(pinned(mechanism, allowable_pv=1.0), 60.0).dataset
    greatest = float(wear["pin_stress"].values[0, wear["pin_mode"].values == "p v"].max())
    limited = pinned(mechanism, allowable_pv=4 * greatest)
    request = StrengthRequest(60.0, source="periodic")
    data = strength(flexmech.ReferenceEngine(limited, 2), request).dataset
    assert str(data["margin_mode"].values[0]) == "p v"
    assert data["margin_speed_factor"].values[0] == pytest.approx(np.cbrt(4.0), rel=0.02)
