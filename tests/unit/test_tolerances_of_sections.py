"""Tolerances and meshes of matter, sections and beams: each test fails if its constant is off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

import flexmech
from flexmech.arrays import ROUND_OFF, SAME_PLACE
from flexmech.beams import comparison, solid_link
from flexmech.beams.plane_link import plane_link
from flexmech.beams.restrained_ends import restrained_ends
from flexmech.beams.zigzag_shapes import SMALL, BoundaryLayers, ZigzagBeam
from flexmech.errors import InputError
from flexmech.linkages import LinkMass
from flexmech.materials import Hygrothermal, Laminate, Layer, Material, Ply, solid_stiffness
from flexmech.materials.laminate import MARGIN
from flexmech.materials.moisture import DiffusionLayer, Diffusivity, MoistureEquilibrium
from flexmech.materials.moisture.cells import FEWEST_CELLS, layer_mesh
from flexmech.materials.moisture.slab import (
    FOURIER_OF_CHANGE,
    early_uptake,
    remaining_uptake,
    shen_springer_uptake,
)
from flexmech.materials.stacking import parse_stacking
from flexmech.model_text import SharedTables
from flexmech.sections import BeamSection, HygrothermalProfile, LaminateSection, swollen_section
from flexmech.sections.free_edges import WIDEST, free_edges, laminate_solid, layer_runs

NEARER, FARTHER = 0.1 * SAME_PLACE, 10 * SAME_PLACE
KNOWN = flexmech.published_constituents()
CARBON = flexmech.ply_from_constituents(
    KNOWN["carbon (isotropic shear)"], KNOWN["polyester (isotropic shear)"], 0.6
)
ALUMINIUM = Ply.isotropic(Material(70e9, 2700.0, 0.33))
FOAM = Ply.isotropic(Material(70e6, 60.0, 0.3))


def angle_plies(*angles: float, thickness: float = 0.5e-3) -> Laminate:
    return Laminate.stacked([CARBON] * len(angles), thickness, np.radians(angles))


def section(laminate: Laminate, ratio: float) -> LaminateSection:
    return LaminateSection(laminate, ratio * laminate.thickness)


# --- matter -------------------------------------------------------------------------------------


def test_layers_too_thin_to_compute_with():
    def laminate(part):
        return Laminate((Layer(CARBON, 1e-3), Layer(CARBON, part * 1e-3)))

    assert len(laminate(FARTHER).layers) == 2
    with pytest.raises(InputError, match="too little to compute with"):
        laminate(NEARER)


def test_angles_in_degrees_are_written_short_and_exact():
    for angle in range(1, 90, 7):
        table = angle_plies(angle).to_table(SharedTables())
        assert table["stacking"].endswith(f"polyester_isotropic_shear@{angle}]")
    third = angle_plies(12.34567891).to_table(SharedTables())
    assert "@12.34567891]" in third["stacking"]


def test_solids_of_plies_are_stiff_in_all_directions():
    stiff = replace(CARBON, transverse_shear_modulus=1e4 * CARBON.transverse_modulus)
    soft = replace(CARBON, transverse_shear_modulus=1e-4 * CARBON.transverse_modulus)
    for ply, ratio in ((stiff, None), (soft, 0.5)):
        compliance = np.linalg.inv(solid_stiffness(Layer(ply, 1e-3)))
        assert np.linalg.eigvalsh(compliance)[0] > 0
        told = -compliance[1, 2] / compliance[1, 1]
        span = 2 * (1 - ply.poisson_ratio**2 * ply.transverse_modulus / ply.longitudinal_modulus)
        expected = -1 + MARGIN * span if ratio is None else ratio
        assert told == pytest.approx(expected, rel=1e-9)
        assert told >= -1 + 0.01 * span
        assert told <= min(0.5, -1 + 0.99 * span)


def test_uncertainties_are_propagated_to_first_order():
    """Of a cube, whose third derivative shows in a step that is too long."""
    fibre = KNOWN["carbon"]
    value, spread = fibre.youngs_modulus, fibre.uncertainty["youngs_modulus"]
    only = replace(fibre, uncertainty={"youngs_modulus": spread})
    found = flexmech.propagated_uncertainty(lambda own: (own.youngs_modulus / value) ** 3, [only])
    assert found == pytest.approx(3 * spread / value, rel=1e-8)


def test_a_resin_takes_what_rounding_makes_of_its_saturation():
    resin = Hygrothermal(equilibrium=MoistureEquilibrium(0.07))
    assert resin.checked_moisture(0.07 * (1 + 0.1 * ROUND_OFF)) > 0.07
    with pytest.raises(InputError, match="more than the resin takes up"):
        resin.checked_moisture(0.07 * (1 + 10 * ROUND_OFF))


def test_chamis_rule_ends_where_its_data_do():
    resin = Hygrothermal(moisture_expansion=0.3, glass_transition=400.0)
    assert resin.wet_glass_transition(0.10) < resin.wet_glass_transition(0.099)
    with pytest.raises(InputError, match="beyond Chamis' rule"):
        resin.wet_glass_transition(0.101)


def test_stacks_have_as_many_layers_as_anybody_makes():
    assert len(parse_stacking("[C*500]s")) == 1000
    with pytest.raises(InputError, match="at most 1000 layers"):
        parse_stacking("[C*1001]")


# --- water --------------------------------------------------------------------------------------


def test_each_layer_has_cells_enough_and_fine_ones_at_the_faces():
    water = Diffusivity(1e-12)
    layers = [DiffusionLayer(t, water, c) for t, c in ((1e-3, 10.0), (1e-5, 20.0), (1e-3, 10.0))]
    mesh = layer_mesh(layers, "both", 100)
    assert np.bincount(mesh.material).min() == FEWEST_CELLS == 4
    one = layer_mesh(layers[:1], "both", 400).sizes
    assert one.max() / one.min() == pytest.approx(np.cosh(2.0) ** 2, rel=0.02)


def test_images_and_cosines_meet():
    fourier = np.array([FOURIER_OF_CHANGE])
    assert early_uptake(fourier) + remaining_uptake(fourier) == pytest.approx(1.0, abs=1e-15)
    with np.errstate(divide="raise", invalid="raise"):
        assert early_uptake(np.zeros(1)) == 0.0
    assert FOURIER_OF_CHANGE == 0.2


def test_shen_and_springers_fit_as_published():
    """1 - exp(-7.3 (D t / s^2)^0.75), s = h of a plate with both faces wet."""
    found = shen_springer_uptake([1.0], 2.0, 0.4)
    assert found == pytest.approx(1 - np.exp(-7.3 * 0.1**0.75), rel=1e-14)


# --- edges and faces of sections ----------------------------------------------------------------


def test_places_on_the_faces_are_inside():
    own = section(angle_plies(0, 90), 4.0)
    half = own.laminate.thickness / 2
    own.stresses(np.array([half * (1 + NEARER), -half * (1 + NEARER)]), bending_moment=1.0)
    with pytest.raises(InputError, match="outside its layer"):
        own.stresses(np.array([half * (1 + 3 * FARTHER)]), bending_moment=1.0)


def test_symmetric_stacks_bend_about_their_middle():
    for stack in ((45, -45, -45, 45), (10, 35, 35, 10), (30, 0, -20, 0, 30)):
        own = section(angle_plies(*stack, thickness=0.1e-3 / 3), 3.0)
        assert own.neutral_axis == 0.0
        assert own.mass_axis == 0.0
    unequal = section(Laminate((Layer(CARBON, 1e-3), Layer(CARBON, 1.001e-3, 0.3))), 3.0)
    assert 0 < abs(unequal.neutral_axis) < 1e-3


def test_symmetric_stacks_swell_straight():
    angles = np.radians([30, 7, 11, 11, 7, 30])
    own = LaminateSection(Laminate.stacked([CARBON] * 6, 0.1e-3 / 3, angles), 0.02)
    hot = swollen_section(BeamSection.of_laminate(own), HygrothermalProfile(60.0, 0.0, 293.15))
    assert hot.section.free_curvature == 0.0


def test_plies_of_one_angle_have_no_free_edges_of_their_own():
    assert free_edges(angle_plies(0, 90, 0), 0.01) is None
    for angle in (20, 30, 45):
        one = free_edges(angle_plies(angle, angle), 2e-3)
        assert one is not None
        assert not one.relaxation.any()


def test_stacks_that_do_not_twist_are_told_exactly():
    """Of antisymmetric angle plies D16 is zero."""
    edges = free_edges(angle_plies(30, -30), 2e-3)
    assert edges is not None
    assert edges.torsion == 0.0


def test_slices_of_a_moist_ply_are_one_run():
    soft = [replace(CARBON, transverse_modulus=CARBON.transverse_modulus * f) for f in (1, 0.9)]
    layers = (Layer(soft[0], 1e-3, 0.5), Layer(soft[1], 1e-3, 0.5), Layer(FOAM, 1e-3, 0.5))
    assert len(layer_runs(Laminate(layers))[1]) == 2


def about_neutral_axis(laminate: Laminate, ratio: float) -> float:
    """Bending stiffness of a section in three dimensions over that of joined plies."""
    width = ratio * laminate.thickness
    free = laminate_solid(laminate, width).stiffness_of([0, 5]) / width
    joined = np.linalg.inv(np.linalg.inv(laminate.plate_stiffness)[np.ix_([0, 3], [0, 3])])
    own, other = (m[1, 1] - m[0, 1] ** 2 / m[0, 0] for m in (free, joined))
    return float(own / other)


@pytest.mark.parametrize(
    ("angles", "finer"),
    [
        ((45, -45, -45, 45), 0.93619),
        ((45, -45, 45, -45, 30, -30), 0.87269),
        ((45, -45, 45, -45, 30, -30, 60, -60), 0.89149),
    ],
)
def test_sections_in_three_dimensions_are_near_to_finer_ones(angles, finer):
    """Of three times as many columns and four times as many rows, as wide as thick."""
    assert about_neutral_axis(angle_plies(*angles), 1.0) == pytest.approx(finer, rel=1e-3)


def test_edges_of_wide_links_stay_as_they_are():
    """At twice the greatest width that is computed half of it is lost to edges."""
    laminate = angle_plies(45, -45, -45, 45)
    wide = about_neutral_axis(laminate, 2 * WIDEST)
    told = section(laminate, 2 * WIDEST).bending_stiffness
    joined = np.linalg.inv(np.linalg.inv(laminate.plate_stiffness)[np.ix_([0, 3], [0, 3])])
    exact = wide * joined[1, 1] * 2 * WIDEST * laminate.thickness
    assert told == pytest.approx(exact, rel=2e-4)


def test_plies_of_narrow_links_are_free():
    laminate = angle_plies(45, -45, -45, 45)
    own = section(laminate, 0.02)
    alone = 1 / np.linalg.inv(laminate.transformed_stiffness)[:, 0, 0]
    faces = laminate.boundaries
    free = float(alone @ np.diff(faces**3) / 3) * own.width
    assert own.bending_stiffness == pytest.approx(free, rel=2e-2)


# --- links in two and three dimensions ----------------------------------------------------------

SANDWICH = LaminateSection(
    Laminate((Layer(ALUMINIUM, 1e-3), Layer(FOAM, 18e-3), Layer(ALUMINIUM, 1e-3))), 0.02
)


def plane_frequencies(mass: LinkMass, modes: int = 4):
    link = plane_link("arm", SANDWICH, mass, [True, False], modes)
    inner = np.ix_(*[np.arange(3, len(link.stiffness))] * 2)
    squares = scipy.linalg.eigh(link.stiffness[inner], link.mass[inner], eigvals_only=True)
    return np.sqrt(squares[:modes]) / (2 * np.pi)


def test_arms_in_two_dimensions_are_near_to_finer_ones():
    """Of 128 elements along and 16 rows; evenly spaced ones are 1e-3 off."""
    found = plane_frequencies(LinkMass(0.2, SANDWICH.mass_per_length))
    np.testing.assert_allclose(found[:2], [319.14310, 998.57799], rtol=3e-4)


def test_enough_modes_between_faces_for_those_asked_for():
    mass = LinkMass(0.2, SANDWICH.mass_per_length)
    assert plane_frequencies(mass, 1)[0] == pytest.approx(plane_frequencies(mass, 8)[0], rel=1e-8)
    assert plane_frequencies(mass, 9)[8] > plane_frequencies(mass, 9)[7]


def test_nodes_give_way_to_point_masses_beside_them():
    from flexmech.beams.plane_link import ALONG, _nodes_along

    nodes = _nodes_along(LinkMass(1.0, 1.0), ())
    near, far = nodes[10] + 5e-4, nodes[10] + 5e-3
    assert len(_nodes_along(LinkMass(1.0, 1.0, (near,), (0.1,)), ())) == ALONG + 1
    assert len(_nodes_along(LinkMass(1.0, 1.0, (far,), (0.1,)), ())) == ALONG + 2


def test_links_compressed_near_to_their_frequency_are_told():
    beam = BeamSection.of_laminate(SANDWICH)
    lowest = comparison.compression_frequency(SANDWICH)
    mass = LinkMass(0.2, beam.mass_per_length)
    assert comparison._is_compressed(beam, mass, 0.06 * lowest)
    assert not comparison._is_compressed(beam, mass, 0.04 * lowest)


def test_twist_matters_from_a_percent_of_the_frequency_on():
    for angle, matters in ((0.5, False), (1, False), (5, True), (30, True)):
        assert solid_link.twists_matter(section(angle_plies(angle), 4.0)) is matters


def test_long_links_and_many_runs_are_not_computed_in_three_dimensions():
    laminate = angle_plies(30)
    long = restrained_ends(section(laminate, 4.0), 41 * 4 * laminate.thickness)
    assert long is not None
    assert not long.solid
    many = angle_plies(*[30, -30, 45] * 3)
    found = restrained_ends(section(many, 4.0), 10 * 4 * many.thickness)
    assert found is not None
    assert not found.solid


# --- boundary layers of zigzag beams ------------------------------------------------------------


def test_series_and_exponentials_are_as_exact_as_each_other():
    place, exponent = np.linspace(-1, 1, 9), np.full(9, SMALL)
    by_series, exact = (
        BoundaryLayers._series(place, exponent),
        BoundaryLayers._direct(place, exponent),
    )
    for name in vars(exact):
        np.testing.assert_allclose(
            getattr(by_series, name), getattr(exact, name), rtol=0, atol=1e-12
        )
    small = BoundaryLayers.of(place, np.full(9, 1e-6))
    np.testing.assert_allclose(small.bubble[0], 1.5 * (1 - place**2), atol=1e-11)
    large = BoundaryLayers.of(place, np.full(9, 3.0)).odd[0]
    np.testing.assert_allclose(large, np.sinh(3 * place) / np.sinh(3.0), atol=1e-14)


def test_points_of_integration_follow_boundary_layers():
    beam = BeamSection.of_laminate(SANDWICH)
    length = np.array([0.5])
    fraction, weight = ZigzagBeam().quadrature(length, beam)
    for depth in beam.zigzag.fall_off:
        found = float((weight * np.exp(-2 * fraction * length[:, None] / depth)).sum())
        assert found == pytest.approx(depth / 2 * (1 - np.exp(-2 * length[0] / depth)), rel=1e-4)
