"""Published four-bars (V1, V2, V15) and a slider-crank (V16), beyond the verification's cases."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexmech import (
    ExudynEngine,
    InputError,
    Mechanism,
    ReferenceEngine,
    TableDrive,
    load_mechanism,
    natural_frequencies,
    response,
)
from flexmech.analyses import ResponseRequest
from flexmech.verification import verification_case, verification_cases

WU_TISO = load_mechanism(Path(__file__).parents[1] / "data" / "wu_tiso_slider_crank.toml")


def test_eight_elements_a_link_find_four_bars_at_rest_to_3e_4() -> None:
    """V1: the tolerance of the cases, whose meshes are finer, is closer."""
    cases = [case for case in verification_cases() if case.subject == "Four-bars at rest"]
    assert len(cases) > 5
    for case in cases:
        coarse = replace(case, measured_by=case.measured_by.with_(elements=8), tolerance=3e-4)
        assert coarse.outcome().verdict == "passed", case.name


def test_frequencies_of_a_four_bar_stay_below_those_of_its_pinned_links(
    aluminium: Mechanism,
) -> None:
    """Coupler and rocker held at their pins: 45.1223 and 49.5220 Hz."""
    angles = np.radians(np.arange(0, 360, 15))
    frequency = natural_frequencies(ReferenceEngine(aluminium, 8, "euler"), angles, modes=2)
    assert np.all(frequency[:, 0] < 45.1223)
    assert np.all(frequency[:, 1] < 49.5220 * (1 + 2e-5))


def test_posture_adds_more_than_half_of_what_tension_does_to_the_aluminium_four_bar() -> None:
    """V2, at 20 rad/s: the classical form with axial forces alone misses it."""
    name = "aluminium, 0 deg, 20 rad/s, reference"
    cases = [
        verification_case("Four-bars at rest: aluminium, 0 deg, reference"),
        verification_case(f"Four-bars with axial forces alone: {name}"),
        verification_case(f"Four-bars at equilibrium under their inertia forces: {name}"),
    ]
    expected, measured = (
        np.array(values)
        for values in (
            [case.expected_values()[0] for case in cases],
            [case.measured_by.values()[0] for case in cases],
        )
    )
    tension = [(row[1] - row[0]) / (row[2] - row[0]) for row in (measured, expected)]
    assert tension[0] == pytest.approx(tension[1], abs=2e-3)
    assert 1 - tension[0] > tension[0] / 2


def test_the_model_of_turcic_midha_and_bosnik_is_what_they_state(models: Path) -> None:
    """V15: A in m^2 and EI in N m^2 of crank, coupler and rocker."""
    mechanism = load_mechanism(models / "turcic_midha_bosnik_fourbar.toml")
    slender = (4.0645e-5, 0.616)
    stated = {"crank": (1.0774e-4, 11.472), "coupler": slender, "rocker": slender}
    modulus, density = 71e9, 2714.0
    for name, (area, bending) in stated.items():
        section = mechanism.sections[name]
        assert section.axial_stiffness == pytest.approx(modulus * area, rel=1e-12)
        assert section.bending_stiffness == bending
        assert section.mass_per_length == pytest.approx(density * area, rel=1e-12)
        assert section.rotary_inertia == pytest.approx(density * bending / modulus, rel=1e-6)
        # A rectangle's thickness follows from its area and second moment.
        thickness = np.sqrt(12 * bending / (modulus * area))
        assert section.in_plane_thickness == pytest.approx(thickness, rel=1e-4)
    lengths = {"ground": 0.254, "crank": 0.108, "coupler": 0.2794, "rocker": 0.2705}
    assert mechanism.linkage.lengths == pytest.approx(lengths, rel=1e-14)
    assert mechanism.joint_masses == {"A": 0.042, "B": 0.042}


def tip(data: Any, time: float) -> Any:
    """Where the crank's end is, (2,) in m."""
    place = data["rigid_position"] + data["displacement"]
    end = place.isel(engine=0, station=-1).sel(link="crank")
    return end.sel(time=time, method="nearest").values


@pytest.mark.thorough
def test_exudyn_stops_wu_and_tisos_slider_crank_where_sonneville_does() -> None:
    """V16: to 1e-4 of the crank's 10 m; the crank angle is ``3 pi t^2 / 50`` until 5 s."""
    drive = WU_TISO.drive
    assert isinstance(drive, TableDrive)
    time = np.linspace(0.0, 4.95, 100)
    np.testing.assert_allclose(drive.crank_angle(time), 3 * np.pi * time**2 / 50, atol=1e-12)
    request = ResponseRequest(drive, samples=600, step=0.01)
    found = response(ExudynEngine(WU_TISO, 8), request).dataset
    for instant, place in ((2.5, (3.960155, 9.182256)), (5.0, (-0.405688, -9.990354))):
        assert np.linalg.norm(tip(found, instant) - place) < 1e-3


@pytest.mark.thorough
def test_the_reference_refuses_the_blow_of_wu_and_tisos_crank_and_is_near_until_it() -> None:
    """Its equations are linear in the bend but for the tension: off by 2e-4 of the length."""
    engine, drive = ReferenceEngine(WU_TISO, 8), WU_TISO.drive
    assert isinstance(drive, TableDrive)
    with pytest.raises(InputError, match=r"-1\.885 rad/s at 5 s"):
        response(engine, ResponseRequest(drive, samples=600))
    rests = replace(drive, ends="free", dwell=0.0)
    found = response(engine, ResponseRequest(rests, samples=600, step=0.01)).dataset
    assert np.linalg.norm(tip(found, 2.5) - (3.960155, 9.182256)) < 3e-3
