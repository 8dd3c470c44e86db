"""Quantities of model files by their keys, and mechanisms with one of them changed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from flexmech import InputError, load_mechanism
from flexmech.modelfile import mechanism_with, quantities_of
from flexmech.units import LENGTH, RATIO, STRESS

MODELS = Path(__file__).parents[2] / "models"
ALUMINIUM = load_mechanism(MODELS / "aluminium_fourbar.toml")


@pytest.mark.parametrize("path", sorted(MODELS.glob("*.toml")), ids=lambda path: path.stem)
def test_every_quantity_can_be_set_to_what_it_is(path: Path) -> None:
    """And to something else, which changes the mechanism."""
    mechanism = load_mechanism(path)
    known = quantities_of(mechanism)
    assert known
    tables = {key.partition(".")[0] for key in known}
    assert tables <= {
        "linkage",
        "links",
        "materials",
        "fibres",
        "matrices",
        "plies",
        "joints",
        "laminates",
        "environment",
        "loads",
        "springs",
        "shaft",
    }
    widths = [key for key in known if key.endswith("out_of_plane_width")]
    for key in widths:
        table = key.split(".")[1]
        wider = mechanism_with(mechanism, key, 21e-3)
        # A chain of beams is one table.
        link = table if table in mechanism.sections else f"{table}-1"
        assert wider.sections[link] != mechanism.sections[link]
        assert wider.provenance == mechanism.provenance


def test_keys_are_those_of_the_file() -> None:
    known = quantities_of(ALUMINIUM)
    assert known["linkage.coupler"] is LENGTH
    assert known["links.coupler.in_plane_thickness"] is LENGTH
    assert known["materials.crank_aluminium.youngs_modulus"] is STRESS
    assert known["materials.aluminium.poisson_ratio"] is RATIO
    assert "operation.crank_speeds" not in known
    arm = quantities_of(load_mechanism(MODELS / "rotating_arm.toml"))
    # Of a value that may be left out.
    assert arm["materials.aluminium.damping_ratio"] is RATIO


def test_the_value_is_set_and_nothing_else() -> None:
    same = mechanism_with(ALUMINIUM, "linkage.coupler", 0.2794)
    assert same == ALUMINIUM
    longer = mechanism_with(ALUMINIUM, "linkage.coupler", 0.29)
    assert longer == replace(ALUMINIUM, linkage=replace(ALUMINIUM.linkage, coupler=0.29))


def test_a_mechanism_that_was_changed_keeps_its_change() -> None:
    """Its file says something else than it is."""
    changed = replace(ALUMINIUM, joint_masses={"A": 0.02})
    heavier = mechanism_with(changed, "joints.A.mass", 0.03)
    assert heavier.joint_masses == {"A": 0.03}
    assert mechanism_with(changed, "linkage.coupler", 0.29).joint_masses == {"A": 0.02}


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("linkage.couple", 0.1, r"no quantity 'linkage.couple'; did you mean 'linkage.coupler'\?"),
        ("linkage.coupler", -0.1, "linkage.coupler: must be positive"),
        ("linkage.coupler", 3.0, "cannot be assembled"),
        ("materials.aluminium.poisson_ratio", 0.7, "poisson_ratio"),
    ],
)
def test_what_cannot_be_is_refused(key: str, value: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        mechanism_with(ALUMINIUM, key, value)
