"""Model files of Singh & Sanyal 2022, Figures 3 to 12: lengths, swelling and softening.

Their crossings and the changes of their angles are cases of the verification.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmech import Mechanism, load_mechanism
from flexmech.errors import InputError
from flexmech.hygrothermal import (
    Exposure,
    HygrothermalState,
    linkage_in_state,
    mechanism_in_state,
    swollen_links,
)
from flexmech.linkages import FourBar
from flexmech.modelfile import mechanism_from_toml
from tests.literature.coupler_curve_rows import ROWS, Row

DRY, WET = HygrothermalState(), HygrothermalState(80.0, 0.07)
FIGURES = ["3", *(row.figure for row in ROWS)]


def model(models: Path, figure: str) -> Mechanism:
    return load_mechanism(models / f"neat_resin_figure_{figure}.toml")


def test_there_is_one_model_a_figure(models: Path) -> None:
    names = {path.stem for path in models.glob("neat_resin_*.toml")}
    assert names == {f"neat_resin_figure_{figure}" for figure in FIGURES}


@pytest.mark.parametrize("row", ROWS, ids=[row.figure for row in ROWS])
def test_lengths(row: Row, models: Path) -> None:
    mechanism = model(models, row.figure)
    lengths = {"ground": row.frame, "crank": row.crank, "coupler": row.coupler}
    assert isinstance(mechanism.linkage, FourBar)
    found = {name: 1e3 * length for name, length in mechanism.linkage.lengths.items()}
    assert found == pytest.approx(lengths | {"rocker": row.rocker}, rel=1e-12)
    point = mechanism.coupler_point
    assert point is not None
    assert (1e3 * point.distance, np.degrees(point.angle)) == pytest.approx(
        (row.distance, row.angle), rel=1e-12
    )


@pytest.mark.parametrize("figure", FIGURES)
def test_swollen_lengths(figure: str, models: Path) -> None:
    """R-914 wet: 62.6e-6 * 80 + 3.02e-3 * 7 = 0.026148; the frame 62.6e-6 * 80 = 0.005008."""
    mechanism = model(models, figure)
    assert isinstance(mechanism.linkage, FourBar)
    dry, wet = mechanism.linkage, linkage_in_state(mechanism, WET)
    for link in ("crank", "coupler", "rocker"):
        assert wet.lengths[link] / dry.lengths[link] == pytest.approx(1.026148, abs=1e-9)
    assert wet.ground / dry.ground == pytest.approx(1.005008, abs=1e-9)


@pytest.mark.parametrize("figure", FIGURES)
def test_the_other_resin_is_there_and_takes_up_two_percent(figure: str, models: Path) -> None:
    """8551-7: 70.0e-6 * 80 + 3.09e-3 * 2 = 0.011780; a moisture of 7 % is refused."""
    text = (models / f"neat_resin_figure_{figure}.toml").read_text(encoding="utf-8")
    renamed = text.replace('material = "R-914"', 'material = "8551-7"')
    mechanism = mechanism_from_toml(renamed)
    links = swollen_links(mechanism, HygrothermalState(80.0, 0.02))
    assert [link.elongation for link in links.values()] == pytest.approx([0.011780] * 3, abs=1e-9)
    with pytest.raises(InputError, match="2 % at 100 % relative humidity"):
        swollen_links(mechanism, WET)


def test_a_frame_that_swells_with_the_links_changes_no_angle(models: Path) -> None:
    mechanism = replace(model(models, "3"), ground_thermal_expansion=0.026148 / 80)
    turn = np.radians(np.arange(0.0, 360.0, 30.0))
    dry, wet = (linkage_in_state(mechanism, s).motion(turn).angle for s in (DRY, WET))
    np.testing.assert_allclose(wet, dry, atol=1e-12)


@pytest.mark.parametrize("figure", FIGURES)
def test_the_saturated_hot_machine_is_softer_and_heavier(figure: str, models: Path) -> None:
    """Chamis: glass transition 106.36 degC wet; at 100 degC the root of 6.36 / 190 is left."""
    dry = model(models, figure)
    wet = mechanism_in_state(dry, WET)
    fahrenheit = 410 * (0.005 * 49 - 0.7 + 1)
    kept = np.sqrt(((fahrenheit - 32) / 1.8 - 100) / 190)
    assert kept == pytest.approx(0.18297, abs=1e-5)
    for link, section in wet.sections.items():
        # Width and thickness swell as the length does.
        stiffness = section.axial_stiffness / dry.sections[link].axial_stiffness
        assert stiffness == pytest.approx(kept * 1.026148**2, rel=1e-9)
        mass = section.mass_per_length / dry.sections[link].mass_per_length
        assert mass == pytest.approx(1.07 / 1.026148, rel=1e-9)


@pytest.mark.thorough
def test_rocker_wet_from_below_bends_away_from_the_water(models: Path) -> None:
    """Its lower side swells first: its middle moves down, and comes back as water gets through."""
    mechanism = load_mechanism(models / "moist_composite_fourbar.toml")
    bent = [
        swollen_links(mechanism, Exposure(60.0, 0.85, days * 86400.0))["rocker"] for days in (4, 40)
    ]
    early, late = (link.section.free_curvature for link in bent)
    assert early > 5 * abs(late) > 0
    assert bent[0].water < bent[1].water
    crank = swollen_links(mechanism, Exposure(60.0, 0.85, 30 * 86400.0))["crank"]
    assert crank.section.free_curvature == 0
    # A month at 80 degC matters: nearly all of what 85 % humidity gives in the end.
    assert crank.water == pytest.approx(0.0425 * 0.32147, rel=0.06)
