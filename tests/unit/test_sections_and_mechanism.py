"""Materials, beam sections and mechanisms: values and refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from flexmech import ReferenceEngine, load_mechanism, natural_frequencies
from flexmech.errors import FlexmechError, InputError
from flexmech.linkages import JointSpring, RotatingArm
from flexmech.materials import Material
from flexmech.mechanism import Mechanism, PointMass
from flexmech.sections import BeamSection, DampingTimes
from tests.support.strategies import LINKS, STEEL, fourbar, numbers


def test_rectangle_of_the_steel_links() -> None:
    section = BeamSection.rectangle(STEEL, in_plane_thickness=4.25e-3, out_of_plane_width=6.1e-3)
    assert section.axial_stiffness == pytest.approx(200e9 * 25.925e-6)
    assert section.bending_stiffness == pytest.approx(200e9 * 6.1e-3 * 4.25e-3**3 / 12)
    assert section.mass_per_length == pytest.approx(7800 * 25.925e-6)
    assert section.rotary_inertia == pytest.approx(7800 * 6.1e-3 * 4.25e-3**3 / 12)
    assert section.in_plane_thickness == 4.25e-3
    assert not section.damping.any


def test_shear_stiffness_uses_cowpers_coefficient() -> None:
    section = BeamSection.rectangle(replace(STEEL, poisson_ratio=0.25), 0.01, 0.02)
    shear = 200e9 / 2.5
    assert section.shear_stiffness == pytest.approx(12.5 / 14.75 * shear * 2e-4)


@given(numbers(1e-3, 1e-1), numbers(1e-3, 1e-1))
def test_bending_stiffness_over_axial_is_the_squared_radius_of_gyration(h: float, b: float) -> None:
    section = BeamSection.rectangle(STEEL, h, b)
    squared_radius = section.bending_stiffness / section.axial_stiffness
    assert squared_radius == pytest.approx(h**2 / 12)
    assert section.rotary_inertia / section.mass_per_length == pytest.approx(h**2 / 12)


def test_damping_ratio_at_a_frequency() -> None:
    section = BeamSection.rectangle(STEEL, 0.01, 0.02).with_damping_ratio(0.02, 50.0)
    assert section.damping.bending * 2 * np.pi * 50.0 / 2 == pytest.approx(0.02)
    assert section.with_damping_time(3e-5).damping == DampingTimes(3e-5, 3e-5, 3e-5)
    assert replace(section, damping=DampingTimes()) == BeamSection.rectangle(STEEL, 0.01, 0.02)


SECTION = BeamSection.rectangle(STEEL, 0.01, 0.02)


@pytest.mark.parametrize(
    "name",
    [
        "axial_stiffness",
        "bending_stiffness",
        "mass_per_length",
        "rotary_inertia",
        "in_plane_thickness",
    ],
)
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_a_section_needs_positive_values(name: str, value: float) -> None:
    with pytest.raises(InputError, match=f"{name} of a beam section must be positive, got {value}"):
        replace(SECTION, **{name: value})


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, -np.inf])
def test_a_shear_stiffness_is_positive(value: float) -> None:
    with pytest.raises(InputError, match=f"shear_stiffness of a beam section .*got {value}"):
        replace(SECTION, shear_stiffness=value)


@pytest.mark.parametrize("name", ["neutral_axis", "mass_axis"])
def test_the_axes_of_a_section_lie_inside_it(name: str) -> None:
    for value in (0.005, -0.006):
        with pytest.raises(InputError, match=f"{name} must lie inside the section, got {value} m"):
            replace(SECTION, **{name: value})
    with pytest.raises(InputError, match=f"{name} of a beam section must be a number, got nan m"):
        replace(SECTION, **{name: np.nan})


@pytest.mark.parametrize("value", [-1e-9, np.nan, np.inf])
def test_damping_must_not_be_negative(value: float) -> None:
    with pytest.raises(InputError, match="damping_time must be zero or positive"):
        SECTION.with_damping_time(value)
    with pytest.raises(InputError, match="damping ratio must be zero or positive"):
        SECTION.with_damping_ratio(value, 50.0)


@pytest.mark.parametrize("frequency", [0.0, -1.0, np.nan, np.inf])
def test_damping_frequency_must_be_positive(frequency: float) -> None:
    with pytest.raises(InputError, match="damping frequency must be positive"):
        SECTION.with_damping_ratio(0.01, frequency)


def test_a_rectangle_needs_two_positive_sides() -> None:
    with pytest.raises(InputError, match="in_plane_thickness must be positive, got 0"):
        BeamSection.rectangle(STEEL, 0.0, 0.02)
    with pytest.raises(InputError, match="out_of_plane_width must be positive, got nan"):
        BeamSection.rectangle(STEEL, 0.01, np.nan)


def test_shear_modulus() -> None:
    assert Material(200e9, 7800.0, 0.25).shear_modulus == pytest.approx(80e9)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((0.0, 7800.0, 0.3), "youngs_modulus must be positive"),
        ((np.inf, 7800.0, 0.3), "youngs_modulus must be positive"),
        ((200e9, -1.0, 0.3), "density must be positive"),
        ((200e9, 7800.0, 0.5), "poisson_ratio must lie between -1 and 0.5, got 0.5"),
        ((200e9, 7800.0, -1.0), "poisson_ratio must lie between"),
        ((200e9, 7800.0, np.nan), "poisson_ratio must lie between"),
    ],
)
def test_a_material_needs_sensible_values(values: tuple[float, ...], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Material(*values)


def test_joint_masses_belong_to_the_leading_link() -> None:
    mechanism = fourbar(joint_masses={"O2": 1.0, "A": 2.0, "B": 3.0, "O4": 4.0})
    crank, coupler, rocker = mechanism.link_masses_in_order
    assert (crank.point_positions, crank.point_masses) == ((0.0, 0.102), (1.0, 2.0))
    assert (coupler.point_positions, coupler.point_masses) == ((0.2794,), (3.0,))
    assert (rocker.point_positions, rocker.point_masses) == ((0.0,), (4.0,))
    assert coupler.mass_per_length == mechanism.sections["coupler"].mass_per_length


def test_point_masses_come_in_order_and_zero_ones_not_at_all() -> None:
    points = tuple(PointMass("coupler", x, m) for x, m in ((0.2, 1.0), (0.1, 2.0), (0.05, 0.0)))
    mass = fourbar(link_masses=points, joint_masses={"A": 0.0}).link_mass("coupler")
    assert (mass.point_positions, mass.point_masses) == ((0.1, 0.2), (2.0, 1.0))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"joint_masses": {"C": 1.0}}, r"unknown joint 'C'; joints are \('O2', 'A', 'B', 'O4'\)"),
        ({"joint_masses": {"A": -1.0}}, "A must be zero or positive, got -1.0 kg"),
        ({"joint_masses": {"A": np.nan}}, "A must be zero or positive, got nan kg"),
        ({"link_masses": (PointMass("rod", 0.1, 1.0),)}, "unknown link 'rod'; links are"),
        (
            {"link_masses": (PointMass("crank", 0.2, 1.0),)},
            r"position 0.2 m is not on the crank \(0 to 0.102 m\)",
        ),
        (
            {"link_masses": (PointMass("crank", np.nan, 1.0),)},
            "position on the crank must be a number, got nan m",
        ),
        ({"link_masses": (PointMass("crank", 0.1, -1.0),)}, "mass on the crank must be zero"),
        ({"gravity": (0.0, np.inf)}, "gravity must be a number, got inf m/s"),
    ],
)
def test_a_mechanism_refuses_what_it_cannot_have(wrong: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        fourbar(**wrong)


def test_a_radial_stiffness_is_all_that_a_bearing_needs() -> None:
    """The linkage had to name the joint as well: the stiffness alone was left out."""
    bearing = JointSpring("B", radial_stiffness=2e3)
    mechanism = fourbar(joint_springs=(bearing,))
    assert mechanism.linkage.topology.sprung_joints == {"B"}
    named = replace(fourbar().linkage, sprung=("B",))
    assert replace(mechanism, linkage=named) == mechanism
    rigid = natural_frequencies(ReferenceEngine(fourbar(), 4), 0.3, modes=1)
    assert natural_frequencies(ReferenceEngine(mechanism, 4), 0.3, modes=1) < 0.9 * rigid
    slider_crank = load_mechanism("models/slider_crank.toml")
    sprung = replace(slider_crank, joint_springs=(replace(bearing, joint="A"),))
    assert sprung.linkage.topology.sprung_joints == {"A"}


def test_what_springs_alone_hold_needs_one() -> None:
    named = replace(fourbar().linkage, sprung=("A", "B"))
    bearing = JointSpring("B", radial_stiffness=2e3)
    with pytest.raises(InputError, match="springs alone hold A, and there is none; give JointS"):
        fourbar(linkage=named, joint_springs=(bearing,))
    with pytest.raises(InputError, match=r"an arm has no pin or pivot, got .* \['tip'\]"):
        RotatingArm(0.3).sprung_at({"tip"})


def test_each_link_needs_one_section() -> None:
    good = fourbar()
    for names in (LINKS[:2], (*LINKS, "rod")):
        with pytest.raises(InputError, match="give one section for each link"):
            Mechanism(good.linkage, dict.fromkeys(names, SECTION))
    assert Mechanism(RotatingArm(1.0), {"arm": SECTION}).link_mass("arm").length == 1.0


def test_refusals_are_flexmech_errors_and_value_errors() -> None:
    assert issubclass(InputError, FlexmechError)
    assert issubclass(InputError, ValueError)
