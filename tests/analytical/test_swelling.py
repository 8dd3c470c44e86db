"""Swollen sections against closed forms: bimetal strips, free expansion, kept mass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech.errors import InputError
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
    ply_from_constituents,
)
from flexmech.materials.moisture import MoistureEquilibrium
from flexmech.sections import BeamSection, HygrothermalProfile, LaminateSection, swollen_section

REFERENCE = 293.15
DRY = HygrothermalProfile(0.0, 0.0, REFERENCE)
RESIN = Hygrothermal(58.4e-6, 62.6e-6, 0.302, MoistureEquilibrium(0.07), None, 483.15)
STIFF_RESIN = replace(RESIN, glass_transition=None)
CARBON_EPOXY = ply_from_constituents(
    Fibre("carbon", 230e9, 20e9, 1780.0, 0.2, thermal_expansion=-0.5e-6),
    Matrix(
        "epoxy",
        3.9e9,
        1.4e9,
        1280.0,
        0.37,
        thermal_expansion=58.4e-6,
        moisture_expansion=0.302,
        equilibrium=MoistureEquilibrium(0.07),
        glass_transition=483.15,
    ),
    0.6,
)


def bar(resin: Hygrothermal = RESIN) -> BeamSection:
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


def test_softening_goes_into_all_stiffness() -> None:
    stiff = swollen_section(bar(STIFF_RESIN), HygrothermalProfile(40.0, 0.05, REFERENCE)).section
    soft = swollen_section(bar(), HygrothermalProfile(40.0, 0.05, REFERENCE)).section
    kept = RESIN.retention(REFERENCE + 40, 0.05, REFERENCE)
    for name in ("axial_stiffness", "bending_stiffness", "shear_stiffness"):
        assert getattr(soft, name) / getattr(stiff, name) == pytest.approx(kept)
    assert soft.mass_per_length == pytest.approx(stiff.mass_per_length)


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


def test_mirrored_moisture_does_not_bend() -> None:
    found = swollen_section(
        bar(), HygrothermalProfile(20.0, ((0.06, 0.02, 0.02, 0.06),), REFERENCE)
    )
    assert found.section.free_curvature == 0.0
    assert found.section.neutral_axis == 0.0


@given(st.lists(st.floats(0, 0.07), min_size=4, max_size=4), st.floats(-40, 30))
@settings(max_examples=20)
def test_mass_of_resin_and_water_is_kept(moisture: list[float], rise: float) -> None:
    layers = LaminateSection(
        Laminate.stacked([CARBON_EPOXY] * 4, 1e-3, np.radians([0, 90, 45, 0])), 0.02
    )
    dry = BeamSection.of_laminate(layers)
    profile = HygrothermalProfile(rise, tuple((m,) for m in moisture), REFERENCE)
    found = swollen_section(dry, profile)
    resin = CARBON_EPOXY.resin
    assert resin is not None
    added = np.mean(moisture) * resin.mass_fraction
    assert found.water == pytest.approx(added, abs=1e-15)
    mass = found.section.mass_per_length * (1 + found.elongation)
    assert mass / dry.mass_per_length == pytest.approx(1 + added, rel=1e-12)


def test_cross_ply_strain_by_hand() -> None:
    """[0/90]s in heat: both directions strain alike, by the balance of their stresses."""
    stiff = replace(CARBON_EPOXY, origin=None)
    section = BeamSection.of_laminate(
        LaminateSection(Laminate.stacked([stiff] * 4, 1e-3, np.radians([0, 90, 90, 0])), 0.02)
    )
    q = stiff.reduced_stiffness
    along, across = stiff.thermal_expansion
    pulls = (q[0, 0] + q[0, 1]) * along + (q[1, 1] + q[0, 1]) * across
    wanted = 30.0 * pulls / (q[0, 0] + q[1, 1] + 2 * q[0, 1])
    found = swollen_section(section, HygrothermalProfile(30.0, 0.0, REFERENCE))
    assert found.elongation == pytest.approx(wanted, rel=5e-3)


def test_dry_section_is_the_same_to_the_last_bit() -> None:
    damped = BeamSection.of_laminate(
        LaminateSection(Laminate.stacked([CARBON_EPOXY] * 3, 1e-3, np.radians([0, 30, -45])), 0.02)
    )
    for section in (bar(), bar().with_damping_time(1e-5), damped):
        found = swollen_section(section, DRY)
        for name in (
            "axial_stiffness",
            "bending_stiffness",
            "shear_stiffness",
            "mass_per_length",
            "rotary_inertia",
            "in_plane_thickness",
            "neutral_axis",
            "mass_axis",
            "damping",
            "free_curvature",
        ):
            assert getattr(found.section, name) == getattr(section, name), name
        assert found.elongation == found.water == 0.0


@pytest.mark.parametrize("measured", [False, True])
def test_swelling_adds_no_fibres(measured: bool) -> None:
    """Along the fibres a ply that only swells keeps the force of its fibres: EA stays."""
    if measured:
        resin = CARBON_EPOXY.resin
        assert resin is not None
        kept = ResinContent(
            replace(resin.hygrothermal, glass_transition=None), resin.mass_fraction, 0.4
        )
        ply = replace(CARBON_EPOXY, origin=kept)
    else:
        composition = CARBON_EPOXY.origin
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
    ("profile", "said"),
    [
        (HygrothermalProfile(100.0, 0.07, REFERENCE), "above its wet glass transition"),
        (HygrothermalProfile(0.0, 0.08, REFERENCE), "more than the resin takes up"),
        (HygrothermalProfile(0.0, ((0.01,), (0.02,)), REFERENCE), "moisture is given for 2 layers"),
    ],
)
def test_refused_profiles(profile: HygrothermalProfile, said: str) -> None:
    with pytest.raises(InputError, match=said):
        swollen_section(bar(), profile)


def test_temperature_below_zero_is_refused() -> None:
    with pytest.raises(InputError, match="must be above 0 K"):
        HygrothermalProfile(-300.0, 0.0, REFERENCE)


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


def test_stiffness_of_layers_is_theirs_to_the_last_bit_when_swollen():
    """By which links are told whose stiffness is stated rather than that of their layers.

    A quotient of stiffnesses times one of them misses the other by round-off in one stack of 20.
    """
    draw = np.random.default_rng(3)
    for _ in range(60):
        layers = tuple(Layer(CARBON_EPOXY, 1e-3, angle) for angle in draw.uniform(-1.5, 1.5, 3))
        width = draw.uniform(0.01, 0.03)
        section = BeamSection.of_laminate(LaminateSection(Laminate(layers), width, "wide"))
        wet = swollen_section(section, HygrothermalProfile(40.0, 0.02, REFERENCE)).section
        assert wet.layers is not None
        assert wet.bending_stiffness == wet.layers.bending_stiffness
