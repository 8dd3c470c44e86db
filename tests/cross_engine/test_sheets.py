"""Linkages of links with plies parallel to the plane of motion, from the model file on."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import flexmech
from flexmech.modelfile import load_mechanism
from flexmech.sections import LaminateSection, SheetSection

MODEL = Path(__file__).parents[2] / "models" / "moist_composite_fourbar.toml"
STATE = flexmech.HygrothermalState(40.0, 0.01)


def text(layers: str = "across width", size: str = 'in_plane_thickness = "15 mm"') -> str:
    """The moist four-bar, its links cut from flat sheets."""
    own = MODEL.read_text(encoding="utf-8").replace('exposed_faces = "lower"\n', "")
    return own.replace('out_of_plane_width = "20 mm"', f'layers = "{layers}"\n{size}')


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sheets") / "sheets.toml"
    path.write_text(text(), encoding="utf-8")
    return path


def test_both_engines_agree_hot_and_moist(model: Path) -> None:
    mechanism = flexmech.mechanism_in_state(load_mechanism(model), STATE)
    angles = np.radians([0.0, 75.0, 210.0])
    first, other = (
        flexmech.natural_frequencies(
            make(mechanism, elements=12, element=element), angles, 20.0, modes=3
        )
        for make, element in (
            (flexmech.ReferenceEngine, "timoshenko"),
            (flexmech.ExudynEngine, "geometrically-exact"),
        )
    )
    np.testing.assert_allclose(first, other, rtol=2e-3)


def test_a_mechanism_survives_the_way_through_text(model: Path, tmp_path: Path) -> None:
    mechanism = load_mechanism(model)
    assert all(isinstance(s.layers, SheetSection) for s in mechanism.sections.values())
    again = tmp_path / "again.toml"
    for own in (mechanism, flexmech.mechanism_in_state(mechanism, STATE)):
        again.write_text(own.to_toml(), encoding="utf-8")
        found = load_mechanism(again)
        for name, section in own.sections.items():
            assert found.sections[name].layers == section.layers
            assert found.sections[name].bending_stiffness == section.bending_stiffness


def test_heat_and_water_soften_and_swell_it(model: Path) -> None:
    dry = load_mechanism(model)
    wet = flexmech.mechanism_in_state(dry, STATE)
    for name, section in dry.sections.items():
        then = wet.sections[name]
        assert then.bending_stiffness < section.bending_stiffness
        assert then.in_plane_thickness > section.in_plane_thickness
        assert then.free_curvature == 0.0


@pytest.mark.parametrize(
    ("layers", "size", "words"),
    [
        ("across width", 'out_of_plane_width = "20 mm"', "links.crank: in_plane_thickness is mis"),
        ("through thickness", 'in_plane_thickness = "2 mm"', "out_of_plane_width is missing"),
        (
            "across width",
            'in_plane_thickness = "2 mm"\nout_of_plane_width = "2 mm"',
            "it is the thickness of the laminate",
        ),
        (
            "across width",
            'in_plane_thickness = "2 mm"\ntwist = "free"',
            "twist is of layers through the thickness",
        ),
        ("across", 'in_plane_thickness = "2 mm"', "did you mean 'across width'"),
    ],
)
def test_wrong_keys_are_named(layers: str, size: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(text(layers, size), encoding="utf-8")
    with pytest.raises(flexmech.InputError, match=re.escape(words)):
        load_mechanism(path)


def test_one_sided_moisture_is_refused(model: Path, tmp_path: Path) -> None:
    """It would bend the link out of the plane."""
    path = tmp_path / "coated.toml"
    one_sided = text().replace('layers = "across', 'exposed_faces = "lower"\nlayers = "across')
    path.write_text(one_sided, encoding="utf-8")
    exposure = flexmech.Exposure(0.0, 0.9, 30 * 86400.0)
    with pytest.raises(flexmech.InputError, match="not symmetric"):
        flexmech.mechanism_in_state(load_mechanism(path), exposure)
    both = flexmech.mechanism_in_state(load_mechanism(model), exposure)
    assert both.sections["rocker"].free_curvature == 0.0


def test_the_other_direction_is_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "through.toml"
    path.write_text(text("through thickness", 'out_of_plane_width = "20 mm"'), encoding="utf-8")
    own, stated = load_mechanism(MODEL), load_mechanism(path)
    assert own.sections == stated.sections
    assert isinstance(own.sections["crank"].layers, LaminateSection)
