"""Resins and plies in heat and water: expansion, softening, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexmech.errors import InputError
from flexmech.materials import (
    Fibre,
    Hygrothermal,
    Material,
    Matrix,
    Ply,
    PlyComposition,
    ResinContent,
    moisture_of,
    ply_from_constituents,
    ply_in_state,
    through_thickness_strain,
    woven_ply,
)
from flexmech.materials.moisture import MoistureEquilibrium

REFERENCE = 293.15
# Singh & Sanyal 2022, table of neat resins; the glass transition is a round value.
R_914 = Hygrothermal(58.4e-6, 62.6e-6, 0.302, MoistureEquilibrium(0.07), None, 483.15)
EPOXY = Matrix(
    "epoxy",
    3.9e9,
    1.4e9,
    1280.0,
    0.37,
    thermal_expansion=58.4e-6,
    moisture_expansion=0.302,
    wet_thermal_expansion=62.6e-6,
    equilibrium=MoistureEquilibrium(0.07),
    glass_transition=483.15,
    tensile_strength=80e6,
)
CARBON = Fibre("carbon", 230e9, 20e9, 1780.0, 0.2, thermal_expansion=-0.5e-6)


def test_free_strain_is_that_of_the_errata() -> None:
    assert R_914.free_strain(80, 0.07) == pytest.approx(0.026148, rel=1e-12)
    assert R_914.free_strain(80, 0.0) == pytest.approx(58.4e-6 * 80, rel=1e-12)
    other = Hygrothermal(46.7e-6, 70e-6, 0.309, MoistureEquilibrium(0.02))
    assert other.free_strain(80, 0.02) == pytest.approx(0.011780, rel=1e-12)


def test_thermal_expansion_is_linear_between_dry_and_saturated() -> None:
    assert R_914.thermal_expansion_at(0.035) == pytest.approx(60.5e-6, rel=1e-12)


def test_wet_glass_transition_by_hand() -> None:
    # 210 degC is 410 degF; at 4 % the factor is 0.005 * 16 - 0.4 + 1 = 0.68: 278.8 degF.
    assert R_914.wet_glass_transition(0.04) == pytest.approx((278.8 - 32) / 1.8 + 273.15)
    assert R_914.wet_glass_transition(0.0) == pytest.approx(483.15)


def test_retention_by_hand() -> None:
    wet = R_914.wet_glass_transition(0.07) - 273.15
    kept = R_914.retention(REFERENCE + 80, 0.07, REFERENCE)
    assert kept == pytest.approx(np.sqrt((wet - 100) / (210 - 20)))
    assert R_914.retention(REFERENCE, 0.0, REFERENCE) == 1.0
    assert R_914.retention(REFERENCE - 40, 0.0, REFERENCE) > 1.0
    assert Hygrothermal().retention(1000.0, 0.05, REFERENCE) == 1.0


@given(st.floats(0, 0.07), st.floats(0, 0.07), st.floats(-30, 60), st.floats(-30, 60))
def test_more_heat_and_more_water_never_stiffen(
    dry: float, moist: float, cold: float, hot: float
) -> None:
    dry, moist = sorted((dry, moist))
    cold, hot = sorted((cold, hot))
    stiff = R_914.retention(REFERENCE + cold, dry, REFERENCE)
    assert R_914.retention(REFERENCE + hot, moist, REFERENCE) <= stiff


@pytest.mark.parametrize(
    ("temperature", "moisture", "said"),
    [
        (REFERENCE + 90, 0.07, "above its wet glass transition of 106.36 degC"),
        (REFERENCE + 190, 0.0, "above its wet glass transition"),
        (REFERENCE, 0.12, "beyond Chamis' rule"),
    ],
)
def test_rubber_is_an_error(temperature: float, moisture: float, said: str) -> None:
    with pytest.raises(InputError, match=said):
        R_914.retention(temperature, moisture, REFERENCE)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"thermal_expansion": np.nan}, "thermal_expansion must be a number"),
        ({"moisture_expansion": -1.0}, "moisture_expansion must be zero or positive"),
        ({"wet_thermal_expansion": 1e-6}, "equilibrium_moisture too"),
        ({"glass_transition": -1.0}, "glass_transition must be positive, got -1.0 K"),
    ],
)
def test_impossible_resins(arguments: dict[str, float], said: str) -> None:
    with pytest.raises(InputError, match=said):
        Hygrothermal(**arguments)  # type: ignore[arg-type]


def test_glass_transition_below_the_reference_is_refused() -> None:
    soft = Hygrothermal(glass_transition=280.0)
    with pytest.raises(InputError, match="not above the reference temperature of 20 degC"):
        soft.retention(270.0, 0.0, REFERENCE)


@pytest.mark.parametrize("moisture", [-0.01, np.nan])
def test_moisture_must_be_a_fraction(moisture: float) -> None:
    with pytest.raises(InputError, match="moisture must be zero or positive"):
        R_914.checked_moisture(moisture)


def test_more_than_the_resin_takes_up_is_refused() -> None:
    other = Hygrothermal(46.7e-6, 70e-6, 0.309, MoistureEquilibrium(0.02))
    with pytest.raises(InputError, match="7 % is more than the resin takes up: 2 %"):
        other.checked_moisture(0.07)


def test_metals_take_no_water() -> None:
    steel = Ply.isotropic(Material(2.1e11, 7850.0, 0.3, Hygrothermal(11.7e-6)))
    assert moisture_of(steel, 0.05) == 0.0
    assert moisture_of(Ply.isotropic(Material(2.1e11, 7850.0)), 0.05) == 0.0


def test_a_ply_that_swells_must_name_its_resin() -> None:
    ply = Ply(140e9, 10e9, 5e9, 5e9, 3.5e9, 0.3, 1600.0, moisture_expansion=(0.0, 0.2), name="C")
    with pytest.raises(InputError, match="ply 'C' has a moisture_expansion"):
        moisture_of(ply, 0.01)


def test_neat_resin_softens_alike_in_all_directions() -> None:
    ply = Ply.isotropic(Material(3.9e9, 1280.0, 0.37, R_914))
    wet = ply_in_state(ply, REFERENCE + 40, 0.05, REFERENCE)
    kept = R_914.retention(REFERENCE + 40, 0.05, REFERENCE)
    for name in ("longitudinal_modulus", "transverse_modulus", "in_plane_shear_modulus"):
        assert getattr(wet, name) == pytest.approx(kept * getattr(ply, name))
    assert wet.thermal_expansion == (R_914.thermal_expansion_at(0.05),) * 2


def test_composition_is_computed_again_with_the_softer_resin() -> None:
    ply = ply_from_constituents(CARBON, EPOXY, 0.6)
    wet = ply_in_state(ply, REFERENCE + 40, 0.05, REFERENCE)
    by_hand = ply_from_constituents(CARBON, EPOXY.in_state(REFERENCE + 40, 0.05, REFERENCE), 0.6)
    assert wet == replace(by_hand, name=ply.name)
    # The fibres carry the load along, the resin that across.
    assert wet.longitudinal_modulus / ply.longitudinal_modulus > 0.99
    assert wet.transverse_modulus / ply.transverse_modulus < 0.75


def test_strength_softens_like_stiffness() -> None:
    wet = EPOXY.in_state(REFERENCE + 40, 0.05, REFERENCE)
    assert wet.tensile_strength is not None
    assert wet.tensile_strength / 80e6 == pytest.approx(wet.youngs_modulus / 3.9e9)


def test_dry_and_unheated_plies_are_the_same_to_the_last_bit() -> None:
    for ply in (
        ply_from_constituents(CARBON, EPOXY, 0.6),
        woven_ply(ply_from_constituents(CARBON, EPOXY, 0.6, "halpin-tsai")),
        Ply.isotropic(Material(3.9e9, 1280.0, 0.37, R_914)),
    ):
        again = ply_in_state(ply, REFERENCE, 0.0, REFERENCE)
        for name in (
            "longitudinal_modulus",
            "transverse_modulus",
            "in_plane_shear_modulus",
            "transverse_shear_modulus",
            "poisson_ratio",
            "density",
            "thermal_expansion",
            "moisture_expansion",
        ):
            assert getattr(again, name) == getattr(ply, name), name


def test_resin_of_a_composition() -> None:
    resin = ply_from_constituents(CARBON, EPOXY, 0.6).resin
    assert resin is not None
    assert resin.volume_fraction == pytest.approx(0.4)
    assert resin.mass_fraction == pytest.approx(0.4 * 1280 / (0.4 * 1280 + 0.6 * 1780))
    assert resin.hygrothermal == EPOXY.hygrothermal


def test_measured_ply_keeps_its_fibres() -> None:
    resin = ResinContent(R_914, 0.3, 0.4)
    ply = Ply(140e9, 10e9, 5e9, 5e9, 3.5e9, 0.3, 1600.0, origin=resin)
    wet = ply_in_state(ply, REFERENCE + 40, 0.05, REFERENCE)
    kept = R_914.retention(REFERENCE + 40, 0.05, REFERENCE)
    assert wet.longitudinal_modulus == 140e9
    assert wet.transverse_modulus == pytest.approx(kept * 10e9)
    assert wet.transverse_shear_modulus == pytest.approx(kept * 3.5e9)


def test_woven_ply_is_free_through_its_thickness() -> None:
    single = ply_from_constituents(CARBON, EPOXY, 0.5)
    woven = woven_ply(single)
    assert isinstance(woven.origin, PlyComposition)
    assert woven.origin.woven
    through = through_thickness_strain(woven, 50.0, 0.03)
    assert through == pytest.approx(through_thickness_strain(single, 50.0, 0.03))
    in_plane = woven.thermal_expansion[0] * 50 + woven.moisture_expansion[0] * 0.03
    assert through > 3 * in_plane


def test_schapery_in_the_limits() -> None:
    # Stiff fibres hold the resin along them and squeeze it across: Singh & Sanyal, eqs. 7, 8.
    ply = ply_from_constituents(CARBON, EPOXY, 0.6)
    along, across = ply.moisture_expansion
    resin = 3.9e9 * 0.4
    assert along == pytest.approx(0.302 * resin / (resin + 230e9 * 0.6))
    nu = 0.6 * 0.2 + 0.4 * 0.37
    assert across == pytest.approx(0.302 * 0.4 * 1.37 - along * nu)
