"""Fatigue strengths: what is refused, how they are written, read and softened, and the package."""

from __future__ import annotations

import re
import sys
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from flexmech.analyses.strength.endurance import check_counting
from flexmech.analyses.strength.enduring_links import EnduringLinks, covers_a_turn
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.errors import InputError
from flexmech.linkages import AttachmentPoint, Load
from flexmech.materials import FatigueStrength, Laminate, Layer, Material, Ply
from flexmech.materials.plies_in_state import ply_in_state
from flexmech.modelfile import json_schema, load_mechanism, mechanism_from_toml
from flexmech.sections import LaminateSection

MODELS = Path(__file__).parents[2] / "models"
ALUMINIUM = (MODELS / "aluminium_fourbar.toml").read_text(encoding="utf-8")
BY_EXPONENT = """
[materials.aluminium.fatigue]
tensile_strength = "310 MPa"
endurance_limit = "97 MPa"
endurance_cycles = 5e8
basquin_exponent = -0.09
source = "a data sheet"
"""
BY_POINTS = """
[materials.aluminium.fatigue]
tensile_strength = "310 MPa"
sn_points = [{ cycles = 1e4, amplitude = "231.7 MPa" }, { cycles = 5e8, amplitude = "97 MPa" }]
"""
STATED = FatigueStrength(310e6, 97e6, 5e8, -0.09, source="a data sheet")
POINTS = ((1e4, 231.7e6), (5e8, 97e6))


def with_fatigue(text: str) -> str:
    return ALUMINIUM.replace("[links.crank]\n", f"{text}\n[links.crank]\n", 1)


@pytest.mark.parametrize(
    ("text", "expected"),
    [(BY_EXPONENT, STATED), (BY_POINTS, FatigueStrength(310e6, sn_points=POINTS))],
)
def test_fatigue_is_read_written_and_read_back(text: str, expected: FatigueStrength) -> None:
    mechanism = mechanism_from_toml(with_fatigue(text))
    for link, own in (("coupler", expected), ("rocker", expected), ("crank", None)):
        layers = mechanism.sections[link].layers
        assert layers is not None
        assert layers.laminate.layers[0].ply.fatigue == own
    written = mechanism.to_toml()
    jsonschema.Draft202012Validator(json_schema()).validate(tomllib.loads(written))
    assert mechanism_from_toml(written) == mechanism


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BY_EXPONENT.replace("endurance_cycles = 5e8\n", ""), "belong together"),
        (BY_EXPONENT.replace("-0.09", "0.09"), "basquin_exponent: must lie between -1 and 0"),
        (BY_EXPONENT.replace('"310 MPa"', '"90 MPa"'), "less than tensile_strength"),
        (BY_EXPONENT.replace("5e8", "0.5"), "endurance_cycles: got 0.5, but a number of cycles"),
        (BY_EXPONENT.replace('tensile_strength = "310 MPa"\n', ""), "tensile_strength: is missing"),
        (BY_EXPONENT + BY_POINTS.splitlines()[-1], "keep one of them"),
        (BY_POINTS + "basquin_exponent = -0.1\n", "keep one of them"),
        (BY_POINTS.replace('"310 MPa"', '"90 MPa"'), "last amplitude of sn_points"),
        (BY_POINTS.replace("5e8", "5e3"), "more cycles and a smaller amplitude"),
        (BY_POINTS.replace("5e8", "1.1e4"), "falls faster than the cycles rise"),
        (BY_POINTS.replace('"97 MPa"', '"97 mm"'), r"sn_points\[1\].amplitude"),
        (BY_POINTS.replace(', { cycles = 5e8, amplitude = "97 MPa" }', ""), "give one more"),
        ("\n".join(BY_POINTS.splitlines()[:-1]), "endurance_limit with endurance_cycles, or sn_"),
    ],
)
def test_wrong_fatigue_is_refused_by_its_key(text: str, message: str) -> None:
    with pytest.raises(InputError, match=r"materials\.aluminium\.fatigue") as refused:
        mechanism_from_toml(with_fatigue(text))
    assert refused.match(message)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"tensile_strength": -1.0}, "tensile_strength"),
        ({"endurance_limit": 0.0}, "endurance_limit"),
        ({"endurance_limit": None, "endurance_cycles": None}, "basquin_exponent is given without"),
        ({"basquin_exponent": None, "sn_points": (POINTS[0],)}, "two points"),
        ({"basquin_exponent": None, "sn_points": ((1e4, 2e8), (1e6, -1e8))}, "amplitude"),
    ],
)
def test_numbers_out_of_range_are_refused(values: dict[str, Any], message: str) -> None:
    if values.get("endurance_limit", 1.0) is None:
        values = values | {"sn_points": None}
        message = "needs endurance_limit"
    with pytest.raises(InputError, match=message):
        replace(STATED, **values)


def test_a_material_takes_no_other_thing_for_fatigue() -> None:
    with pytest.raises(InputError, match=r"flexmech\.FatigueStrength"):
        Material(70e9, 2700.0, fatigue=97e6)  # type: ignore[arg-type]


def test_a_hot_resin_endures_less_and_a_metal_as_much() -> None:
    layers = load_mechanism(MODELS / "neat_resin_figure_8.toml").sections["coupler"].layers
    assert layers is not None
    neat = layers.laminate.layers[0].ply.isotropic_material
    assert neat is not None
    for own in (
        FatigueStrength(60e6, 15e6, 1e7, -0.1),
        FatigueStrength(60e6, sn_points=((1e3, 40e6), (1e7, 15e6))),
    ):
        ply = Ply.isotropic(replace(neat, fatigue=own))
        hot = ply_in_state(ply, 333.15, 0.0, 293.15)
        assert hot.fatigue is not None
        kept = hot.longitudinal_modulus / ply.longitudinal_modulus
        assert kept < 0.99
        # All stresses are as much smaller: a smaller stress lives as long as the old one did.
        for amplitude, mean in ((20e6, 0.0), (10e6, 30e6)):
            then = hot.fatigue.equivalent_amplitude(
                np.array(kept * amplitude), np.array(kept * mean)
            )
            dry = own.equivalent_amplitude(np.array(amplitude), np.array(mean))
            np.testing.assert_allclose(hot.fatigue.cycles(then), own.cycles(dry), rtol=1e-10)
        assert hot.isotropic_material is None or hot.isotropic_material.fatigue == hot.fatigue
    metal = Ply.isotropic(Material(70e9, 2700.0, fatigue=STATED))
    assert ply_in_state(metal, 373.0, 0, 293.0).fatigue == STATED


def judged_links(
    sections: dict[str, LaminateSection], request: StrengthRequest | None = None, **others: Any
) -> EnduringLinks:
    mechanism = replace(mechanism_from_toml(ALUMINIUM), **others)
    return EnduringLinks.of(mechanism, sections, request or StrengthRequest(crank_speed=1.0))


def test_links_of_several_materials_are_left_out() -> None:
    tough = Ply.isotropic(Material(70e9, 2700.0, fatigue=STATED))
    other = Ply.isotropic(Material(200e9, 7800.0, fatigue=STATED))

    def stack(*layers: Layer) -> LaminateSection:
        return LaminateSection(Laminate(layers), 20e-3)

    sections = {
        "crank": stack(Layer(tough, 1e-3), Layer(tough, 2e-3, 0.3)),
        "coupler": stack(Layer(tough, 1e-3), Layer(other, 2e-3)),
        "rocker": stack(Layer(replace(tough, fatigue=None), 1e-3)),
    }
    found = judged_links(sections)
    assert found.strengths == {"crank": STATED}
    composite, silent = found.left_out_lines
    assert composite == "fatigue of composites is not judged: coupler"
    assert silent.endswith("is missing: rocker")
    assert "[materials.NAME.fatigue]" in silent


def test_loads_that_do_not_repeat_are_not_judged() -> None:
    ply = Ply.isotropic(Material(70e9, 2700.0, fatigue=STATED))
    sections = {"crank": LaminateSection(Laminate((Layer(ply, 4e-3),)), 20e-3)}
    push = Load("push", AttachmentPoint("crank", 0.05), ((1.0, 0.0),))
    timed = replace(push, force=((1.0, 0.0),) * 2, torque=(0.0,) * 2, over="time", at=(0.0, 1.0))
    for request, loads, reason in (
        (StrengthRequest(source="transient"), (), "choose the source periodic"),
        (StrengthRequest(np.radians([0.0, 5.0, 10.0])), (), "do not cover a turn"),
        (StrengthRequest(), (push, timed), "loads over time.*: push"),
    ):
        found = judged_links(sections, request, loads=loads)
        assert not found.strengths
        (line,) = found.left_out_lines
        assert re.fullmatch(f"fatigue not judged of crank: .*{reason}", line)
    assert judged_links(sections, StrengthRequest(), loads=(push,)).strengths
    assert judged_links(sections, StrengthRequest(source="periodic")).strengths


def test_missing_package_is_told_where_cycles_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rainflow", None)
    monkeypatch.setattr("flexmech.analyses.strength.endurance.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"rainflow.*flexmech\[fatigue\]") as refused:
        check_counting(STATED)
    assert "\n" not in str(refused.value)
    check_counting(replace(STATED, basquin_exponent=None))
    # Before anything is computed.
    ply = Ply.isotropic(Material(70e9, 2700.0, fatigue=STATED))
    with pytest.raises(InputError, match=r"flexmech\[fatigue\]"):
        judged_links({"crank": LaminateSection(Laminate((Layer(ply, 4e-3),)), 20e-3)})


def test_a_turn_is_covered_with_its_end_and_without() -> None:
    degrees = np.arange(0.0, 361.0, 5.0)
    for angles in (degrees, degrees[:-1], degrees + 37.0, np.arange(0.0, 721.0, 10.0)):
        assert covers_a_turn(np.radians(angles))
    for angles in (degrees[:-2], degrees[:19], degrees[:1]):
        assert not covers_a_turn(np.radians(angles))
