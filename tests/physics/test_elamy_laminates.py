"""Laminates of Elamy et al. 2023: Table 2 and its spreads; supports and the paper's mesh."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from elamy_linkages import (
    crank_rocker,
    crank_rocker_file,
    position_angles,
    published_case,
    published_tables,
    with_rigid_joints,
)
from elamy_tables import property_table

from flexmech import ReferenceEngine, natural_frequencies
from tests.support.command import MODELS

STORED = MODELS.parent / "tests/data/composite_study.nc"
LAMINATES = ("C1", "C2", "C3", "C4", "C5", "C6")
AREA, SECOND_MOMENT = 25e-3 * 5e-3, 25e-3 * 5e-3**3 / 12


def moduli(plies: str, layers: str = "across width") -> np.ndarray:
    """Flexural moduli of the six laminates in GPa."""
    sections = (crank_rocker(1, c, plies, layers).sections["crank"] for c in LAMINATES)
    return np.array([s.bending_stiffness for s in sections]) / SECOND_MOMENT / 1e9


def test_tables_4_to_6_as_printed():
    tables = published_tables()
    assert tables["finite_element"].sel(position="90", laminate="C6", case=2) == 38.34
    assert tables["measured"].sel(position="max", laminate="C1", case=3) == 258.1
    assert tables["damping"].sel(position="min", laminate="C5", case=4) == 0.371
    assert not any(np.isnan(values).any() for values in tables.values())


def test_table_2_with_its_headers_put_right():
    assert moduli("table 2") == pytest.approx([99.73, 92.24, 84.25, 73.32, 66.60, 62.61])
    sections = (crank_rocker(1, c, "table 2").sections["crank"] for c in LAMINATES)
    density = np.array([s.mass_per_length for s in sections]) / AREA
    assert density == pytest.approx([1538, 1640, 1742, 1844, 1946, 2048])


def test_flexural_moduli_of_plies_by_the_rule_of_mixtures():
    """121.9 and 43.0 GPa: equal steps across the width, by the lever of each ply through it."""
    stacked = moduli("unidirectional", "through thickness")
    assert stacked == pytest.approx([121.9, 121.2, 105.5, 59.4, 43.6, 43.0], abs=0.06)
    assert moduli("unidirectional") == pytest.approx(np.linspace(121.872, 42.972, 6), rel=1e-5)
    # [C/G/C/G/C] by hand: outer carbon 1 - 0.6^3, glass 0.6^3 - 0.2^3, carbon 0.2^3.
    by_hand = 121.872 * (1 - 0.6**3 + 0.2**3) + 42.972 * (0.6**3 - 0.2**3)
    assert stacked[2] == pytest.approx(by_hand, rel=1e-4)


@pytest.mark.parametrize("plies", ["woven", "unidirectional", "table 2"])
def test_links_are_as_large_whichever_way_their_plies_lie(plies):
    for layers in ("across width", "through thickness"):
        assert "ASSUMED" in crank_rocker_file(3, "C4", plies, layers)
        section = crank_rocker(3, "C4", plies, layers).sections["rocker"]
        assert section.in_plane_thickness == pytest.approx(5e-3)
        density = section.mass_per_length / AREA
        assert density == pytest.approx(1844 if plies == "table 2" else 1844.8)


def test_spreads_of_table_1_by_hand():
    """Along the fibres: 0.6 times that of the fibre, 0.4 times that of the resin."""
    table = property_table(xr.load_dataset(STORED))
    table = table[(table.plies == "unidirectional") & (table["layers"] == "across width")]
    spread = table.set_index("laminate")["modulus_GPa_uncertainty"]
    carbon, glass, resin = 0.6 * 20, 0.6 * 14, 0.4 * 0.01
    expected = [
        np.hypot(carbon, resin),
        np.sqrt((0.6 * carbon) ** 2 + (0.4 * glass) ** 2 + resin**2),
        np.hypot(glass, resin),
    ]
    assert spread[["C1", "C3", "C6"]].to_numpy() == pytest.approx(expected, rel=1e-4)


def test_a_right_transmission_angle_stands_between_the_limits():
    for case in (1, 2, 3, 4):
        linkage = published_case(case)
        angles = np.degrees(linkage.transmission_angle(position_angles(linkage)))
        limits = np.degrees(linkage.transmission_angle_limits())
        assert angles == pytest.approx([limits[0], 90.0, limits[1], 90.0])


def test_one_element_a_link_is_11_percent_high():
    """The paper's mesh against eight elements, at worst over its cases and positions."""
    errors = []
    for case in (1, 3, 4):
        mechanism, angles = (
            crank_rocker(case, "C1"),
            position_angles(published_case(case)),
        )
        one, many = (
            natural_frequencies(ReferenceEngine(mechanism, n, "euler", False), angles[:3], modes=1)
            for n in (1, 8)
        )
        errors.append(np.max(one / many - 1))
    assert max(errors) == pytest.approx(0.11, abs=0.01)


@pytest.mark.thorough
@pytest.mark.parametrize(("case", "laminate"), [(2, "C1"), (3, "C6")])
def test_linkages_with_rigid_joints_are_those_of_the_study_and_stiffer_than_hinged(case, laminate):
    stored = xr.load_dataset(STORED)["rigid_joints_frequency"]
    hinged = crank_rocker(case, laminate)
    for number, angle in enumerate(position_angles(published_case(case))[:3]):
        rigid = with_rigid_joints(hinged, angle)
        found, loose = (
            float(
                natural_frequencies(ReferenceEngine(m, 3, "euler", False), [angle], modes=1)[0, 0]
            )
            for m in (rigid, hinged)
        )
        exact = stored.sel(case=case, laminate=laminate).isel(position=number)
        assert found == pytest.approx(float(exact), rel=1e-4)
        assert found > 1.05 * loose
