"""Resins, plies and sections in heat and water, by hand and in closed forms.

Singh & Sanyal 2022 (neat resins, corrected); Chamis' rules of softening; Timoshenko, *J. Opt. Soc.
Am.* 11 (1925) 233 (bimetal strips).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech import InputError
from flexmech.materials import (
    Fibre,
    Hygrothermal,
    Laminate,
    Layer,
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
from flexmech.modelfile import load_mechanism
from flexmech.sections import BeamSection, HygrothermalProfile, LaminateSection, swollen_section
from tests.support.command import MODELS

REFERENCE = 293.15
# Table of neat resins of the paper; the glass transition of 210 degC is a round value.
RESIN_LINK = load_mechanism(MODELS / "neat_resin_figure_8.toml").sections["coupler"]
R_914 = RESIN_LINK.layers.laminate.layers[0].ply.resin.hygrothermal  # type: ignore[union-attr]
STIFF_RESIN = replace(R_914, glass_transition=None)
EPOXY = Matrix(
    "epoxy",
    3.9e9,
    1.4e9,
    1280.0,
    0.37,
    thermal_expansion=58.4e-6,
    moisture_expansion=0.302,
    wet_thermal_expansion=62.6e-6,
    equilibrium=R_914.equilibrium,
    glass_transition=483.15,
    tensile_strength=80e6,
)
CARBON = Fibre("carbon", 230e9, 20e9, 1780.0, 0.2, thermal_expansion=-0.5e-6)
PLY = ply_from_constituents(CARBON, EPOXY, 0.6)


def test_free_strain_and_expansion_of_a_resin_are_those_of_the_errata() -> None:
    assert R_914.free_strain(80, 0.07) == pytest.approx(0.026148, rel=1e-12)
    assert R_914.free_strain(80, 0.0) == pytest.approx(58.4e-6 * 80, rel=1e-12)
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
    # Strength softens as stiffness does.
    wet = EPOXY.in_state(REFERENCE + 40, 0.05, REFERENCE)
    assert wet.tensile_strength is not None
    assert wet.tensile_strength / 80e6 == pytest.approx(wet.youngs_modulus / 3.9e9)


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


def bar(resin: Hygrothermal = R_914) -> BeamSection:
    return BeamSection.rectangle(Material(3.9e9, 1280.0, 0.37, resin), 0.02, 0.01)


def two_layers(lower: float, upper: float, stiffness: float, share: float) -> BeamSection:
    """Bimetal strip: thermal expansions, ratio of moduli and of thicknesses (lower first)."""
    plies = [
        Ply.isotropic(Material(modulus, 1000.0, 0.0, Hygrothermal(expansion)))
        for modulus, expansion in ((1e9, lower), (stiffness * 1e9, upper))
    ]
    layers = (Layer(plies[0], 0.01 * share), Layer(plies[1], 0.01 * (1 - share)))
    return BeamSection.of_laminate(LaminateSection(Laminate(layers), 0.02))


@given(st.floats(0.2, 5.0), st.floats(0.2, 0.8))
@settings(max_examples=20)
def test_bimetal_strip_of_timoshenko(stiffness: float, share: float) -> None:
    """Timoshenko, J. Opt. Soc. Am. 11 (1925) 233, eq. 4."""
    rise, lower, upper = 50.0, 20e-6, 5e-6
    m, n = share / (1 - share), 1 / stiffness  # lower over upper thickness and modulus
    wanted = 6 * (lower - upper) * rise * (1 + m) ** 2
    wanted /= 0.01 * (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n)))
    found = swollen_section(
        two_layers(lower, upper, stiffness, share), HygrothermalProfile(rise, 0.0, REFERENCE)
    )
    # The lower side grows more: the link turns to the left along it. The thickness swells too.
    assert found.section.free_curvature == pytest.approx(wanted, rel=3e-3)
    assert found.section.free_curvature > 0


def test_uniform_swelling_of_a_neat_resin() -> None:
    dry, strain = bar(STIFF_RESIN), 0.026148
    found = swollen_section(dry, HygrothermalProfile(80.0, 0.07, REFERENCE))
    wet = found.section
    assert found.elongation == pytest.approx(strain, rel=1e-10)
    assert found.water == pytest.approx(0.07)
    assert wet.free_curvature == 0.0
    assert not wet.is_eccentric
    grown = 1 + strain
    assert wet.axial_stiffness / dry.axial_stiffness == pytest.approx(grown**2)
    assert wet.bending_stiffness / dry.bending_stiffness == pytest.approx(grown**4)
    assert wet.shear_stiffness / dry.shear_stiffness == pytest.approx(grown**2)
    # The link's own mass stays, water comes in.
    assert wet.mass_per_length * grown / dry.mass_per_length == pytest.approx(1.07)
    assert wet.in_plane_thickness == pytest.approx(0.02 * grown)


def test_gradient_of_moisture_bends_by_its_first_moment() -> None:
    """Linear moisture in an elastic bar bends it without stress: curvature is its gradient."""
    slices = tuple(np.linspace(0.02, 0.04, 401)[1::2])
    found = swollen_section(
        bar(replace(STIFF_RESIN, wet_thermal_expansion=None)),
        HygrothermalProfile(0.0, (slices,), REFERENCE),
    )
    wanted = -0.302 * (0.04 - 0.02) / 0.02
    # Slices that swell through the thickness stretch the gradient by a percent.
    assert found.section.free_curvature == pytest.approx(wanted, rel=0.015)
    assert found.elongation == pytest.approx(0.302 * 0.03, rel=2e-3)


@given(st.lists(st.floats(0, 0.07), min_size=4, max_size=4), st.floats(-40, 30))
@settings(max_examples=5)
def test_mass_of_resin_and_water_is_kept(moisture: list[float], rise: float) -> None:
    layers = LaminateSection(Laminate.stacked([PLY] * 4, 1e-3, np.radians([0, 90, 45, 0])), 0.02)
    dry = BeamSection.of_laminate(layers)
    profile = HygrothermalProfile(rise, tuple((m,) for m in moisture), REFERENCE)
    found = swollen_section(dry, profile)
    resin = PLY.resin
    assert resin is not None
    added = np.mean(moisture) * resin.mass_fraction
    assert found.water == pytest.approx(added, abs=1e-15)
    mass = found.section.mass_per_length * (1 + found.elongation)
    assert mass / dry.mass_per_length == pytest.approx(1 + added, rel=1e-12)


def test_cross_ply_strain_by_hand() -> None:
    """[0/90]s in heat: both directions strain alike, by the balance of their stresses."""
    stiff = replace(PLY, origin=None)
    section = BeamSection.of_laminate(
        LaminateSection(Laminate.stacked([stiff] * 4, 1e-3, np.radians([0, 90, 90, 0])), 0.02)
    )
    q = stiff.reduced_stiffness
    along, across = stiff.thermal_expansion
    pulls = (q[0, 0] + q[0, 1]) * along + (q[1, 1] + q[0, 1]) * across
    wanted = 30.0 * pulls / (q[0, 0] + q[1, 1] + 2 * q[0, 1])
    found = swollen_section(section, HygrothermalProfile(30.0, 0.0, REFERENCE))
    assert found.elongation == pytest.approx(wanted, rel=5e-3)


@pytest.mark.parametrize("measured", [False, True])
def test_swelling_adds_no_fibres(measured: bool) -> None:
    """Along the fibres a ply that only swells keeps the force of its fibres: EA stays."""
    if measured:
        resin = PLY.resin
        assert resin is not None
        kept = ResinContent(
            replace(resin.hygrothermal, glass_transition=None), resin.mass_fraction, 0.4
        )
        ply = replace(PLY, origin=kept)
    else:
        composition = PLY.origin
        assert isinstance(composition, PlyComposition)
        stiff = replace(composition.matrix, glass_transition=None)
        ply = ply_from_constituents(composition.fibre, stiff, 0.6)
    dry = BeamSection.of_laminate(LaminateSection(Laminate((Layer(ply, 2e-3),)), 0.02))
    wet = swollen_section(dry, HygrothermalProfile(60.0, 0.06, REFERENCE)).section
    grown = wet.in_plane_thickness / dry.in_plane_thickness
    assert grown > 1.011
    # The resin, a hundredth of the stiffness, grows with the section; the fibres do not.
    assert wet.axial_stiffness / dry.axial_stiffness == pytest.approx(1.0, abs=1e-3)


def test_wide_link_is_held_across() -> None:
    layers = LaminateSection(
        Laminate((Layer(Ply.isotropic(Material(3.9e9, 1280.0, 0.37, STIFF_RESIN)), 0.02),)),
        0.01,
        "wide",
    )
    found = swollen_section(
        BeamSection.of_laminate(layers), HygrothermalProfile(0.0, 0.07, REFERENCE)
    )
    # Held across, it grows more along: by Poisson's ratio.
    assert found.elongation == pytest.approx(1.37 * 0.302 * 0.07, rel=1e-10)


@pytest.mark.parametrize(
    ("angle", "width", "expected"), [(45, 1, -0.2501), (45, 4, -0.0971), (30, 1, -0.0746)]
)
def test_links_that_joints_keep_from_twisting_bend_less(angle, width, expected):
    """Swelling that is uneven twists off-axis plies; the joints take that back by a torque.

    Curvature in 1/m by three-dimensional elements between rigid end faces that turn about pins, of
    links of 20 and 40 thicknesses; with the twist free it is -0.334 ([45]) and -0.167 ([30]).
    """
    thickness = 4e-3
    layers = tuple(
        Layer(
            Ply(
                *(172.7e9, 7.20e9, 3.76e9, 3.76e9, 2.57e9, 0.29, 1566.7),
                thermal_expansion=(0.0, part * 1e-6),
            ),
            thickness / 3,
            np.radians(angle),
        )
        for part in (1, 2, 3)
    )
    section = BeamSection.of_laminate(
        LaminateSection(Laminate(layers), width * thickness, twist="held")
    )
    swollen = swollen_section(section, HygrothermalProfile(1000.0, 0.0, REFERENCE))
    assert swollen.section.free_curvature == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: R_914.retention(REFERENCE + 90, 0.07, REFERENCE),
            "transition of 106.36 degC",
        ),
        (lambda: R_914.retention(REFERENCE, 0.12, REFERENCE), "beyond Chamis' rule"),
        (lambda: R_914.checked_moisture(0.08), "8 % is more than the resin takes up: 7 %"),
        (lambda: R_914.checked_moisture(-0.01), "moisture must be zero or positive"),
        (lambda: replace(R_914, moisture_expansion=-1.0), "moisture_expansion"),
        (lambda: replace(R_914, equilibrium=None), "equilibrium_moisture too"),
        (lambda: Hygrothermal(glass_transition=280.0).retention(270, 0, REFERENCE), "20 degC"),
        (
            lambda: moisture_of(replace(PLY, moisture_expansion=(0.0, 0.2), origin=None), 0.01),
            "has a moisture_expansion",
        ),
        (
            lambda: swollen_section(bar(), HygrothermalProfile(100.0, 0.07, REFERENCE)),
            "above its wet glass transition",
        ),
        (
            lambda: swollen_section(bar(), HygrothermalProfile(0, ((0.01,), (0.02,)), REFERENCE)),
            "moisture is given for 2 layers",
        ),
        (lambda: HygrothermalProfile(-300.0, 0.0, REFERENCE), "above 0 K"),
    ],
)
def test_states_that_no_resin_has_are_refused(make: Callable[[], object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        make()
