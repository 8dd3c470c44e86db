"""Sections of laminates: invariants, stresses inside, damping, refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech.errors import InputError
from flexmech.materials import Laminate, Layer, Material, Ply, PlyDamping
from flexmech.sections import REDUCTIONS, SHEAR_THEORIES, BeamSection, DampingTimes, LaminateSection
from flexmech.sections.beam_reduction import PlaneState, gauss_points
from tests.support.strategies import STEEL, numbers

CARBON = Ply(138e9, 9e9, 6e9, 5e9, 3e9, 0.3, 1600.0, PlyDamping(0.005, 0.06, 0.08))
GLASS = Ply(39e9, 8.4e9, 4.2e9, 4.2e9, 3.4e9, 0.26, 2000.0, PlyDamping(0.01, 0.05, 0.07))
BIMETAL = LaminateSection(
    Laminate(
        (
            Layer(Ply.isotropic(Material(70e9, 2700.0)), 1e-3),
            Layer(Ply.isotropic(Material(200e9, 7800.0)), 2e-3),
        )
    ),
    0.02,
)

layers = st.builds(
    Layer, st.sampled_from([CARBON, GLASS]), numbers(1e-4, 2e-3), numbers(-np.pi / 2, np.pi / 2)
)
laminates = st.lists(layers, min_size=1, max_size=4).map(lambda found: Laminate(tuple(found)))
sections = st.builds(LaminateSection, laminates, numbers(1e-3, 0.1), st.sampled_from(REDUCTIONS))
few = settings(max_examples=20)


def resultant(section: LaminateSection, values: np.ndarray) -> float:
    """Integral over the cross-section of values at the Gauss points of its layers."""
    _, weights = gauss_points(section.laminate)
    return float(section.width * np.sum(weights * values))


# ---- stresses ------------------------------------------------------------------------------


@given(sections, numbers(-1e3, 1e3), numbers(-10, 10), numbers(-1e3, 1e3))
@few
def test_stresses_balance_their_loads(
    section: LaminateSection, axial: float, moment: float, shear: float
) -> None:
    places, _ = gauss_points(section.laminate)
    h = section.laminate.thickness
    scale = abs(axial) + abs(moment) / h + abs(shear)
    for theory in SHEAR_THEORIES:
        found = section.stresses(places, axial, moment, shear, theory=theory)
        arm = places - section.neutral_axis
        assert resultant(section, found.normal_stress) == pytest.approx(axial, abs=1e-9 * scale)
        assert resultant(section, -arm * found.normal_stress) == pytest.approx(
            moment, abs=1e-9 * scale * h
        )
        assert resultant(section, found.shear_stress) == pytest.approx(shear, abs=1e-9 * scale)


@given(sections)
@few
def test_shear_stress_vanishes_at_the_faces(section: LaminateSection) -> None:
    places = section.places(3)
    for theory in SHEAR_THEORIES:
        shear = section.stresses(places, shear_force=1.0, theory=theory).shear_stress
        zero = 1e-10 * np.abs(shear).max()
        assert abs(shear[0, 0]) < zero
        assert abs(shear[-1, -1]) < zero
        if theory == "equilibrium":
            np.testing.assert_allclose(shear[1:, 0], shear[:-1, -1], atol=zero)


@given(sections)
@few
def test_energies_of_pure_states_are_those_of_the_stiffness(section: LaminateSection) -> None:
    places, _ = gauss_points(section.laminate)
    for load, stiffness in (
        ({"axial_force": 1.0}, section.axial_stiffness),
        ({"bending_moment": 1.0}, section.bending_stiffness),
    ):
        found = section.stresses(places, **load)
        energy = resultant(section, found.strain * found.normal_stress)
        assert energy == pytest.approx(1 / stiffness, rel=1e-9)
        strains = section._strains(load.get("axial_force", 0.0), load.get("bending_moment", 0.0))
        energies = section._strip.energy_by_direction(strains)
        assert section.width * energies.sum() == pytest.approx(1 / stiffness, rel=1e-9)


@given(sections)
@few
def test_strain_is_zero_on_the_neutral_axis_of_bending(section: LaminateSection) -> None:
    found = section.stresses(np.array([section.neutral_axis]), bending_moment=1.0)
    surface = section.laminate.thickness / 2 / section.bending_stiffness
    assert found.strain[0] == pytest.approx(0.0, abs=1e-12 * surface)
    below = section.stresses(np.array([-section.laminate.thickness / 2]), bending_moment=1.0)
    assert below.strain[0] > 0


def test_an_interface_has_two_stresses() -> None:
    rows = BIMETAL.stresses(BIMETAL.places(2), axial_force=100.0)
    strain = 100.0 / BIMETAL.axial_stiffness
    np.testing.assert_allclose(rows.strain, strain)
    np.testing.assert_allclose(rows.normal_stress, [[70e9 * strain] * 2, [200e9 * strain] * 2])
    faces = BIMETAL.laminate.boundaries
    listed = BIMETAL.stresses(faces, axial_force=100.0)
    np.testing.assert_allclose(listed.normal_stress, strain * np.array([70e9, 200e9, 200e9]))
    assert listed.place.shape == listed.shear_stress.shape == (3,)
    assert BIMETAL.stresses(faces[0], axial_force=1.0).strain.shape == ()


def test_third_order_shear_stress_jumps_with_the_stiffness() -> None:
    found = BIMETAL.stresses(BIMETAL.places(2), shear_force=1.0, theory="third-order")
    lower, upper = found.shear_stress[0, 1], found.shear_stress[1, 0]
    assert upper / lower == pytest.approx(200 / 70)


def test_without_coupling_the_loads_are_not_balanced() -> None:
    """Bending about the mid-plane as if the stack were symmetric, and what that leaves."""
    places, _ = gauss_points(BIMETAL.laminate)
    found = BIMETAL.stresses(places, bending_moment=1.0, shear_force=1.0, coupled=False)
    stiffness = BIMETAL.bending_stiffness + BIMETAL.axial_stiffness * BIMETAL.neutral_axis**2
    np.testing.assert_allclose(found.strain, -places / stiffness)
    left = -BIMETAL.coupling_stiffness / stiffness
    assert resultant(BIMETAL, found.normal_stress) == pytest.approx(left)
    assert resultant(BIMETAL, -places * found.normal_stress) == pytest.approx(1.0)
    top = BIMETAL.stresses(BIMETAL.laminate.boundaries[-1:], shear_force=1.0, coupled=False)
    assert top.shear_stress[0] == pytest.approx(left / BIMETAL.width)


def test_coupling_does_not_matter_in_a_symmetric_stack() -> None:
    pair = (Layer(CARBON, 1e-3, 0.4), Layer(GLASS, 2e-3))
    section = LaminateSection(Laminate((*pair, *pair[::-1])), 0.02)
    places = section.places(4)
    with_it, without = (
        section.stresses(places, 10.0, 1.0, 5.0, coupled=coupled) for coupled in (True, False)
    )
    np.testing.assert_allclose(with_it.normal_stress, without.normal_stress)
    np.testing.assert_allclose(with_it.shear_stress, without.shear_stress, atol=1e-6)


# ---- the section as a whole ----------------------------------------------------------------


@given(sections)
@few
def test_a_stack_turned_over_has_its_axes_on_the_other_side(section: LaminateSection) -> None:
    over = replace(section, laminate=Laminate(section.laminate.layers[::-1]))
    h = section.laminate.thickness
    for name in ("neutral_axis", "mass_axis"):
        assert getattr(over, name) == pytest.approx(-getattr(section, name), abs=1e-10 * h)
    for name in ("axial_stiffness", "bending_stiffness", "shear_stiffness", "rotary_inertia"):
        assert getattr(over, name) == pytest.approx(getattr(section, name), rel=1e-9)
    third, turned = section.third_order, over.third_order
    signs = np.array([1, -1, -1])
    scale = np.sqrt(np.outer(np.diag(third.stiffness), np.diag(third.stiffness)))
    np.testing.assert_allclose(
        turned.stiffness / scale, np.outer(signs, signs) * third.stiffness / scale, atol=1e-9
    )


@given(laminates, numbers(1e-3, 0.1))
@few
def test_twice_stacked_to_the_middle_has_no_coupling(laminate: Laminate, width: float) -> None:
    both = Laminate((*laminate.layers, *laminate.layers[::-1]))
    for reduction in REDUCTIONS:
        section = LaminateSection(both, width, reduction)
        assert section.neutral_axis == section.mass_axis == section.coupling_stiffness == 0.0


@given(sections)
@few
def test_a_layer_cut_in_two_changes_nothing(section: LaminateSection) -> None:
    first, *rest = section.laminate.layers
    parts = (replace(first, thickness=f * first.thickness) for f in (0.3, 0.7))
    cut = replace(section, laminate=Laminate((*parts, *rest)))
    for name in ("axial_stiffness", "bending_stiffness", "shear_stiffness"):
        assert getattr(cut, name) == pytest.approx(getattr(section, name), rel=1e-9)
    loss, other = section.specific_damping, cut.specific_damping
    assert (loss.axial, loss.bending, loss.shear) == pytest.approx(
        (other.axial, other.bending, other.shear), rel=1e-9
    )


@given(laminates)
@few
def test_holding_the_link_across_stiffens_it(laminate: Laminate) -> None:
    narrow, wide = (LaminateSection(laminate, 0.01, reduction) for reduction in REDUCTIONS)
    assert narrow.axial_stiffness <= wide.axial_stiffness * (1 + 1e-12)
    assert narrow.bending_stiffness <= wide.bending_stiffness * (1 + 1e-12)
    gap = wide.third_order.stiffness - narrow.third_order.stiffness
    scale = np.sqrt(np.diag(wide.third_order.stiffness))
    assert np.linalg.eigvalsh(gap / np.outer(scale, scale)).min() > -1e-12


@given(sections)
@few
def test_third_order_stiffness_lets_more_go_than_the_classical(section: LaminateSection) -> None:
    """The strains y and 1 are the same; a narrow link relaxes the cubic ones across too."""
    third = section.third_order
    classical = section._classical
    gap = classical - third.stiffness[:2, :2]
    scale = np.sqrt(np.diag(classical))
    lowest = np.linalg.eigvalsh(gap / np.outer(scale, scale)).min()
    assert lowest > -1e-12
    if section.reduction == "wide":
        np.testing.assert_allclose(gap / np.outer(scale, scale), 0.0, atol=1e-12)


def test_thin_links_keep_their_digits_in_third_order_theory() -> None:
    """Powers of y up to the sixth span 18 orders of magnitude in a thickness of 1 mm."""
    whole = Laminate((Layer(CARBON, 0.6, 0.3), Layer(GLASS, 0.4, -1.0)))
    thin = Laminate(tuple(replace(x, thickness=1e-3 * x.thickness) for x in whole.layers))
    sections = LaminateSection(whole, 2.0), LaminateSection(thin, 2e-3)
    unit, small = (section.third_order.stiffness for section in sections)
    scale = 1e-3 ** np.array([1.0, 2.0, 4.0])
    np.testing.assert_allclose(small / np.outer(scale, scale), unit, rtol=1e-11)


def test_equal_sections_are_equal_and_hash_alike() -> None:
    again = replace(BIMETAL)
    assert BIMETAL.axial_stiffness > 0  # computed and kept in one of them
    assert again == BIMETAL
    assert hash(again) == hash(BIMETAL)
    assert replace(BIMETAL, reduction="wide") != BIMETAL
    assert BeamSection.of_laminate(again) == BeamSection.of_laminate(BIMETAL)
    assert hash(BeamSection.of_laminate(again)) == hash(BeamSection.of_laminate(BIMETAL))


def test_places_reach_from_face_to_face() -> None:
    np.testing.assert_allclose(
        BIMETAL.places(3), [[-1.5e-3, -1e-3, -0.5e-3], [-0.5e-3, 0.5e-3, 1.5e-3]]
    )


# ---- damping -------------------------------------------------------------------------------


def damped(section: LaminateSection, loss: PlyDamping) -> LaminateSection:
    """The section with one loss in all its plies."""
    layers = section.laminate.layers
    plies = (replace(layer.ply, specific_damping=loss) for layer in layers)
    pairs = zip(layers, plies, strict=True)
    return replace(section, laminate=Laminate(tuple(replace(x, ply=ply) for x, ply in pairs)))


@given(sections, numbers(0.0, 1.0))
@few
def test_one_capacity_everywhere_is_that_of_the_section(
    section: LaminateSection, psi: float
) -> None:
    found = damped(section, PlyDamping(psi, psi, psi)).specific_damping
    assert (found.axial, found.bending, found.shear) == pytest.approx((psi,) * 3, rel=1e-9)


@given(sections)
@few
def test_loss_is_linear_in_the_capacities(section: LaminateSection) -> None:
    """One direction more lossy than the others at a time: the shares of the energy."""
    gains = np.zeros(3)
    for more in np.eye(3):
        found = damped(section, PlyDamping(*(1.0 + more))).specific_damping
        gains += np.array([found.axial, found.bending, found.shear]) - 1.0
    np.testing.assert_allclose(gains, 1.0, rtol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 0.001, 1.5])
def test_a_negative_share_of_the_energy_is_no_gain(angle: float) -> None:
    """Poisson's contraction works against the stress along the other direction."""
    small = LaminateSection(Laminate((Layer(CARBON, 1e-3, angle),)), 0.01)
    loss = PlyDamping(longitudinal=1.0) if angle > 1 else PlyDamping(transverse=1.0)
    found = damped(small, loss).specific_damping
    assert (found.axial, found.bending) == (0.0, 0.0)


# ---- beam sections -------------------------------------------------------------------------


def test_a_beam_section_of_a_laminate() -> None:
    beam = BeamSection.of_laminate(BIMETAL)
    for name in (
        "axial_stiffness",
        "bending_stiffness",
        "shear_stiffness",
        "mass_per_length",
        "rotary_inertia",
        "neutral_axis",
        "mass_axis",
        "third_order",
    ):
        assert getattr(beam, name) == getattr(BIMETAL, name)
    assert beam.coupling_stiffness == pytest.approx(BIMETAL.coupling_stiffness)
    assert beam.layers is BIMETAL
    assert beam.in_plane_thickness == pytest.approx(3e-3)
    assert beam.is_eccentric
    assert beam.damping == DampingTimes()
    assert beam.specific_damping is None
    assert beam.neutral_axis > 0 < beam.mass_axis  # steel above


def test_kelvin_voigt_times_of_a_laminate() -> None:
    section = LaminateSection(Laminate((Layer(CARBON, 1e-3), Layer(GLASS, 1e-3))), 0.01)
    beam = BeamSection.of_laminate(section)
    assert beam.specific_damping == section.specific_damping
    damped = beam.with_damping_frequency(50.0)
    assert damped.damping_frequency == 50.0
    assert replace(damped, damping=DampingTimes(), damping_frequency=None) == beam
    # A cycle of viscous damping loses 2 pi omega tau.
    lost = 2 * np.pi * (2 * np.pi * 50.0) * damped.damping.bending
    assert lost == pytest.approx(section.specific_damping.bending)
    with pytest.raises(InputError, match="damping frequency must be positive"):
        beam.with_damping_frequency(0.0)
    with pytest.raises(InputError, match="needs the specific damping of the plies"):
        BeamSection.of_laminate(BIMETAL).with_damping_frequency(50.0)


def test_a_rectangle_knows_its_one_layer() -> None:
    beam = BeamSection.rectangle(STEEL, 0.01, 0.02)
    assert beam.layers is not None
    assert beam.layers.bending_stiffness == pytest.approx(beam.bending_stiffness)
    assert beam.layers.mass_per_length == pytest.approx(beam.mass_per_length)
    # Cowper's factor of the rectangle is not that of the parabola.
    assert beam.layers.shear_stiffness != pytest.approx(beam.shear_stiffness, rel=1e-3)
    assert beam.third_order.thickness == 0.01


@pytest.mark.parametrize("section", ["plain numbers", "uncoupled"])
def test_third_order_theory_needs_the_layers(section: str) -> None:
    if section == "uncoupled":
        beam = BeamSection.of_laminate(BIMETAL).without_coupling()
        reference = BIMETAL.axial_stiffness * BIMETAL.neutral_axis**2
        assert beam.bending_stiffness == pytest.approx(BIMETAL.bending_stiffness + reference)
    else:
        beam = BeamSection(1e6, 1.0, 1e5, 0.1, 1e-9, 0.002)
    with pytest.raises(InputError, match=r"third-order theory needs the layers.*timoshenko"):
        _ = beam.third_order


# ---- refusals ------------------------------------------------------------------------------


@pytest.mark.parametrize("width", [0.0, -1.0, np.nan, np.inf])
def test_a_width_must_be_positive(width: float) -> None:
    with pytest.raises(InputError, match=f"width of a laminate section .* got {width} m"):
        LaminateSection(BIMETAL.laminate, width)


def test_an_unknown_reduction_is_refused() -> None:
    with pytest.raises(InputError, match="reduction must be one of narrow, wide, got 'thin'"):
        LaminateSection(BIMETAL.laminate, 0.01, "thin")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"theory": "cubic"}, "theory must be one of equilibrium, third-order, got 'cubic'"),
        ({"axial_force": np.nan}, r"loads on a section must be finite, got \[nan, 0.0, 0.0\]"),
        ({"place": np.array([0.0, 2e-3])}, "place 0.002 m is outside its layer; .* 0.0015 m"),
        ({"place": np.array([np.nan])}, "place nan m is outside"),
        ({"place": np.array([[0.0], [0.0]])}, "place 0 m is outside its layer"),
        ({"place": np.zeros((3, 4))}, r"one row for each of the 2 layers; got shape \(3, 4\)"),
    ],
)
def test_stresses_refuse_what_they_cannot_have(wrong: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        BIMETAL.stresses(**{"place": BIMETAL.places(2), **wrong})  # type: ignore[arg-type]


def test_places_need_both_faces() -> None:
    with pytest.raises(InputError, match="per_layer must be 2 or more, for both faces; got 1"):
        BIMETAL.places(1)


def test_state_is_linear_through_the_thickness() -> None:
    strains = np.array([[1.0, 2.0, 3.0], [10.0, 20.0, 30.0]])
    state = PlaneState(BIMETAL.laminate, np.stack([strains, 2 * strains]))
    places, layers = np.array([0.0, 0.1, 0.1]), np.array([0, 0, 1])
    np.testing.assert_allclose(state.strain(places, layers), [[1, 2, 3], [2, 4, 6], [4, 8, 12]])
