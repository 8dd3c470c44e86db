"""Strengths and stress-free temperatures in model files, and what heat and water leave of them."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest

from flexmech.errors import InputError
from flexmech.hygrothermal import HygrothermalState, mechanism_in_state
from flexmech.materials import Material, Ply, PlyStrength
from flexmech.materials.plies_in_state import ply_diluted, ply_in_state
from flexmech.modelfile import json_schema, load_mechanism, mechanism_from_toml

MODELS = Path(__file__).parents[2] / "models"
COMPOSITE = re.sub(
    r"\[plies\..\.strength\]\n(.+\n)+",
    "",
    (MODELS / "composite_fourbar.toml").read_text(encoding="utf-8"),
)
STRENGTH = """
[plies.C.strength]
Xt = "1500 MPa"
Xc = "1.2 GPa"
Yt = "40 MPa"
Yc = "246 MPa"
S12 = "68 MPa"
S23 = "50 MPa"
inclination_tension = 0.35
inclination_compression = "30 %"
source = "a data sheet"

[laminates.carbon]
stress_free_temperature = "120 degC"
"""
STATED = PlyStrength(1500e6, 1.2e9, 40e6, 246e6, 68e6, 50e6, 0.35, 0.3, "a data sheet")


def with_strength(text: str = STRENGTH) -> str:
    return COMPOSITE.replace("[laminates.carbon]\n", text.lstrip(), 1)


def test_strength_is_read_with_units() -> None:
    mechanism = mechanism_from_toml(with_strength())
    layers = mechanism.sections["crank"].layers
    assert layers is not None
    assert all(layer.ply.strength == STATED for layer in layers.laminate.layers)
    assert layers.laminate.stress_free_temperature == pytest.approx(393.15, abs=1e-9)
    coupler = mechanism.sections["coupler"].layers
    assert coupler is not None
    assert coupler.laminate.layers[-1].ply.strength is None
    assert coupler.laminate.stress_free_temperature is None


def test_strength_is_written_and_read_back() -> None:
    mechanism = mechanism_from_toml(with_strength())
    text = mechanism.to_toml()
    jsonschema.Draft202012Validator(json_schema()).validate(tomllib.loads(text))
    assert mechanism_from_toml(text) == mechanism


@pytest.mark.parametrize("name", ["moist_composite_fourbar", "sandwich_fourbar"])
def test_strength_of_computed_plies_is_written(name: str) -> None:
    """Plies by their constituents, and plies beside isotropic layers."""
    mechanism = load_mechanism(MODELS / f"{name}.toml")
    sections = {}
    for link, section in mechanism.sections.items():
        assert section.layers is not None
        layers = tuple(
            replace(layer, ply=replace(layer.ply, strength=STATED))
            if layer.ply.isotropic_material is None
            else layer
            for layer in section.layers.laminate.layers
        )
        laminate = replace(section.layers.laminate, layers=layers)
        sections[link] = replace(section, layers=section.layers.resized(laminate, 1.0))
    stronger = replace(mechanism, sections=sections)
    found = mechanism_from_toml(stronger.to_toml())
    for link, section in found.sections.items():
        expected = stronger.sections[link].layers
        assert section.layers is not None
        assert expected is not None
        assert section.layers.laminate == expected.laminate


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (STRENGTH.replace('Yt = "40 MPa"\n', ""), "plies.C.strength.Yt"),
        (STRENGTH.replace('"40 MPa"', '"40 mm"'), "plies.C.strength.Yt"),
        (STRENGTH.replace('"40 MPa"', '"-40 MPa"'), "plies.C.strength.Yt"),
        (STRENGTH.replace("= 0.35", "= 1.35"), "inclination_tension"),
        (STRENGTH.replace("120 degC", "-300 degC"), "stress_free_temperature"),
    ],
)
def test_wrong_strength_is_refused_by_its_key(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        mechanism_from_toml(with_strength(text))


def test_hot_moist_ply_is_as_weak_as_its_resin() -> None:
    """Chamis: the root of how far the wet glass transition still is, but for fibres in tension."""
    ply = load_mechanism(MODELS / "moist_composite_fourbar.toml").sections["coupler"].layers
    assert ply is not None
    dry = replace(ply.laminate.layers[0].ply, strength=STATED)
    assert dry.resin is not None
    kept = dry.resin.hygrothermal.retention(333.15, 0.01, 293.15)
    assert 0.1 < kept < 0.99
    wet = ply_in_state(dry, 333.15, 0.01, 293.15).strength
    assert wet is not None
    assert wet.longitudinal_tension == STATED.longitudinal_tension
    assert wet.source == STATED.source
    for name in ("longitudinal_compression", "transverse_tension", "in_plane_shear"):
        assert getattr(wet, name) == pytest.approx(kept * getattr(STATED, name), rel=1e-14)
    swollen = ply_diluted(replace(dry, strength=STATED), 1.02).strength
    assert swollen == replace(STATED, longitudinal_tension=1500e6 / 1.02)


def test_neat_resin_yields_earlier_hot() -> None:
    mechanism = load_mechanism(MODELS / "neat_resin_figure_8.toml")
    layers = mechanism.sections["coupler"].layers
    assert layers is not None
    neat = layers.laminate.layers[0].ply.isotropic_material
    assert neat is not None
    ply = Ply.isotropic(replace(neat, yield_strength=50e6))
    hot = ply_in_state(ply, 333.15, 0.0, 293.15)
    assert hot.yield_strength is not None
    part = hot.longitudinal_modulus / ply.longitudinal_modulus
    assert part < 0.99
    assert hot.yield_strength == pytest.approx(50e6 * part, rel=1e-12)
    metal = ply_in_state(Ply.isotropic(Material(70e9, 2700.0, yield_strength=2e8)), 373.0, 0, 293.0)
    assert metal.yield_strength == 2e8


def test_dry_mechanism_keeps_strength_and_stress_free_temperature() -> None:
    mechanism = mechanism_from_toml(with_strength())
    assert mechanism_in_state(mechanism, HygrothermalState()) == mechanism
