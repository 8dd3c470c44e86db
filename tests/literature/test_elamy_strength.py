"""First-ply failure of Elamy's laminates and linkages, beside the strengths of Table 2."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from flexmech import StrengthRequest, strength
from flexmech.studies import CompositeStudy, composite_crank_rocker
from flexmech.studies.composite_crank_rockers.strength_tables import strength_answer
from flexmech.studies.composite_crank_rockers.strengths import (
    CRITERION,
    STRENGTHS,
    first_ply_failures,
    strong_mechanism,
)
from tests.support.published_study import published_study

# Plies by the rule of mixtures in MPa, and how many of five are of carbon.
CARBON, GLASS = 121_872.0, 42_972.0
OF_CARBON = np.array([5, 4, 3, 2, 1, 0])


@pytest.fixture(scope="module")
def found() -> xr.Dataset:
    return first_ply_failures()


@pytest.mark.parametrize(
    ("load", "of_carbon", "of_glass"),
    [("tension", 1950.0, 1280.0), ("compression", 1480.0, 800.0)],
)
def test_first_ply_of_stretched_laminates_by_hand(
    found: xr.Dataset, load: str, of_carbon: float, of_glass: float
) -> None:
    """Plies bear one strain, and carbon fails at a smaller one: each glass ply weakens the stack.

    Poisson's ratios of the plies differ by a hundredth, which counts for a hundred-thousandth.
    """
    share = OF_CARBON / 5
    expected = of_carbon * (share + (1 - share) * GLASS / CARBON)
    expected[-1] = of_glass
    own = found["first_ply_stress"].sel(section_load=load)
    for layers in own["layers"]:
        np.testing.assert_allclose(own.sel(layers=layers) / 1e6, expected, rtol=1e-4)
    assert found["first_ply"].sel(section_load=load).values.tolist() == [[*"CCCCC", "G"]] * 2


def test_first_ply_of_bent_laminates_by_hand(found: xr.Dataset) -> None:
    """Stacked in the plane of motion, glass outside is strained most and carbon inside spared."""
    own = found["first_ply_stress"].sel(section_load="bending") / 1e6
    in_plane, stacked = (own.sel(layers=each) for each in ("across width", "through thickness"))
    compressed = found["first_ply_stress"].sel(section_load="compression", layers="across width")
    np.testing.assert_allclose(in_plane, compressed / 1e6, rtol=1e-9)
    # C5, [G/G/C/G/G]: outer glass fails at 800 / 42972 of strain before the carbon, which lies at a
    # fifth of the distance from the middle.
    second_moment = (CARBON - GLASS) / 5**3 + GLASS
    assert 1480 / CARBON * 5 > 800 / GLASS
    assert float(stacked[4]) == pytest.approx(800 / GLASS * second_moment, rel=1e-4)
    assert found["first_ply"].sel(section_load="bending").values[1].tolist() == [*"CCCGGG"]


def test_first_ply_fails_below_what_table_2_prints(found: xr.Dataset) -> None:
    """Table 2 falls evenly from C1 to C6; first-ply failure has its least at C5."""
    tension = found["first_ply_stress"].sel(section_load="tension").isel(layers=0)
    printed = published_study()["printed_strength"]
    assert (tension < printed).all()
    assert tension["laminate"].values[tension.values.argmin()] == "C5"


def test_failure_speed_is_that_of_strength(found: xr.Dataset) -> None:
    """At the speed that was found the weakest link has a load factor of one."""
    at = {"layers": "through thickness", "laminate": "C4", "case": 3}
    speed = float(found["failure_speed"].sel(at))
    linkage = composite_crank_rocker(3, "C4", "unidirectional", "through thickness")
    there = strength(
        strong_mechanism(linkage),
        StrengthRequest(
            np.radians(np.arange(0.0, 361.0, 5.0)), speed, criterion=CRITERION, source="rigid"
        ),
    ).dataset
    assert float(there["margin_load_factor"][0]) == pytest.approx(1.0, rel=1e-9)
    assert there["margin_part"].values[0] == found["failing_link"].sel(at)
    assert {one.source[:11] for one in STRENGTHS.values()} == {"P. D. Soden"}


def test_longest_crank_breaks_first(found: xr.Dataset) -> None:
    """Case 2 has it, and C5 is weakest in its plane and stacked."""
    speed = found["failure_speed"]
    assert (speed.idxmin("case") == 2).all()
    said = strength_answer(published_study().drop_vars(list(found)).merge(found))
    least = float(speed.min())
    assert (
        f"case 2 of C5, plies across width, breaks first as the speed rises, at {least:.0f}" in said
    )
    assert "crank" in said


def test_study_tells_it(tmp_path: Path) -> None:
    study = CompositeStudy(published_study())
    table = study.tables()["composite_strength"]
    assert len(table) == 6 * 2 * (3 + 4)
    row = table[(table.laminate == "C1") & (table.loaded_by == "tension")].iloc[0]
    assert row["nominal_stress_MPa"] == pytest.approx(row["table_2_strength_MPa"] / 2)
    (shown,) = (t for t in study.summary().tables if t.title.startswith("First-ply failure"))
    assert shown.groups[0][0][:3] == ("C1", "2775", "1387")
    assert shown.groups[0][0][-1] == "100 (case 4)"
    assert "for comparison only" in shown.caption
    assert any("breaks first as the speed rises" in line for line in study.summary().lines)
    study.save(tmp_path)
    again = CompositeStudy.load(tmp_path / "composites.nc")
    xr.testing.assert_identical(again.dataset, study.dataset)
