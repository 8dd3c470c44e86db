"""Numbers and objects that users give: what is refused, with which words; and how objects show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech.errors import InputError
from flexmech.linkages import (
    ConstantSpeed,
    CouplerCurve,
    CouplerPoint,
    FourBar,
    RotatingArm,
    double_points,
    inverse_dynamics,
    synthesize_crank_rocker,
    transmission_design,
)
from flexmech.materials import (
    Fibre,
    Laminate,
    Layer,
    Material,
    Ply,
    ply_from_constituents,
    published_constituents,
)
from flexmech.mechanism import Mechanism, PointMass
from flexmech.modelfile import load_mechanism
from flexmech.sections import BeamSection, DampingTimes, LaminateSection
from flexmech.validation import Bounds, check_number, check_pair, checked_array
from tests.support.strategies import ALUMINIUM_LINKAGE, STEEL, fourbar

STEEL_PLY = Ply.isotropic(STEEL)
SECTION = BeamSection.rectangle(STEEL, 4e-3, 2e-2)
MASKED = np.ma.masked_array([1.0, 2.0], mask=[True, False])
PUBLISHED = published_constituents()


@pytest.mark.parametrize(
    ("bounds", "inside", "outside", "words"),
    [
        (Bounds(), [-1e300, 0.0], [np.nan, np.inf], "be a number"),
        (Bounds(above=0.0), [1e-300], [0.0, -1.0, np.nan], "be positive"),
        (Bounds(least=0.0), [0.0, 5.0], [-1e-300, np.inf], "be zero or positive"),
        (Bounds(above=-1.0, below=0.5), [0.0], [-1.0, 0.5], "lie between -1 and 0.5"),
        (Bounds(least=0.0, below=0.5), [0.0], [-0.1, 0.5], "be at least 0 and less than 0.5"),
        (Bounds(above=0.0, most=1.0), [1.0], [0.0, 1.1], "be above 0 and at most 1"),
        (Bounds(least=0.0, most=1.0), [0.0, 1.0], [1.1], "be at least 0 and at most 1"),
    ],
)
def test_bounds_hold_what_they_say(bounds, inside, outside, words):
    assert bounds.words == words
    assert all(bounds.hold(number) for number in inside)
    for number in outside:
        with pytest.raises(InputError, match=f"x must {words}, got {number} m"):
            check_number(number, "x", "m", bounds)


@pytest.mark.parametrize(
    "value", ["0.1", None, True, 1j, [0.1], np.array([0.1]), np.ma.masked, MASKED]
)
def test_what_is_no_number_is_refused(value):
    with pytest.raises(InputError, match=r"length must be a number of m, got .*; give "):
        check_number(value, "length", "m")


def test_numbers_of_numpy_are_numbers():
    for value in (1, 1.0, np.float32(1), np.int64(1)):
        check_number(value, "x")
    assert checked_array([1, 2], "x").dtype == float
    for wrong in ("12", (1.0,), 1.0, (1.0, "2"), (1.0, np.nan), MASKED):
        with pytest.raises(InputError, match="pair must be"):
            check_pair(wrong, "pair")


@pytest.mark.parametrize("wrong", ["30", ["30"], MASKED, [np.nan], [1j], [[1.0], [1.0, 2.0]]])
def test_arrays_without_missing_values(wrong):
    with pytest.raises(InputError, match=r"crank_angle must be (a number of rad|finite numbers)"):
        ALUMINIUM_LINKAGE.motion(wrong)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: FourBar("0.1", 0.1, 0.1, 0.1), "length of the ground must be a number of m"),
        (lambda: FourBar("100 mm", 0.1, 0.1, 0.1), "got '100 mm'; .* units are for model files"),
        (lambda: RotatingArm(0.3, "0"), "hub_radius must be a number of m, got '0'"),
        (lambda: ConstantSpeed("20"), "crank speed must be a number of rad/s"),
        (lambda: CouplerPoint(0.1, 45), r"angle .* full turn .*give np.radians\(45\)"),
        (lambda: CouplerCurve(RotatingArm(1.0), CouplerPoint(0.1, 0.0)), "must be a FourBar"),
        (lambda: synthesize_crank_rocker("20", 2.0), "deviation must be a number of rad"),
        (lambda: synthesize_crank_rocker(20, 100), r"in rad, give np.radians\(20\)"),
        (lambda: Material("200 GPa", 7800.0), "youngs_modulus must be a number of Pa"),
        (lambda: replace(STEEL_PLY, density="7800"), "density of a ply must be a number of kg/m"),
        (lambda: Layer(STEEL_PLY, 1e-3, 45.0), r"angle of a layer .*give np.radians\(45.0\)"),
        (lambda: Layer(STEEL, 1e-3), "ply of a layer must be a Ply, got <Material: E 200 GPa"),
        (lambda: Laminate((STEEL_PLY,)), "layers holds <Ply: "),
        (lambda: LaminateSection(STEEL_PLY, 0.02), "laminate must be a Laminate"),
        (lambda: BeamSection.rectangle("steel", 0.01, 0.02), "material must be a Material"),
        (lambda: BeamSection.rectangle(STEEL, "10 mm", 0.02), "in_plane_thickness must be a num"),
        (lambda: replace(SECTION, neutral_axis="0"), "neutral_axis of a beam section must be a n"),
        (lambda: DampingTimes("1e-5"), "damping_time must be a number of s"),
        (
            lambda: ply_from_constituents("carbon", PUBLISHED["polyester"], 0.5),
            r"fibre must be a Fibre, got 'carbon'; take one of published_constituents\(\)",
        ),
        (lambda: Fibre("x", 1e9, 1e9, "1000", 0.2), "density of 'x' must be a number of kg/m"),
        (lambda: fourbar(gravity="9.81"), "gravity must be two numbers, got '9.81'"),
        (lambda: fourbar(gravity=(0, "-9.81")), "gravity must be a number of m/s"),
        (lambda: fourbar(joint_masses={"A": "20 g"}), "joint_masses: A must be a number of kg"),
        (lambda: fourbar(link_masses=((0.1, 1.0),)), "link_masses holds .*; give PointMass"),
        (
            lambda: fourbar(link_masses=(PointMass("crank", "0.1", 1.0),)),
            "link_masses: position on the crank must be a number of m",
        ),
        (lambda: fourbar(operating_speeds=("300 rpm",)), "operating_speeds must be a number of r"),
        (lambda: fourbar(reference_temperature=-1), "reference_temperature must be positive"),
        (lambda: fourbar(provenance="mine"), "provenance must be a Provenance"),
        (lambda: Mechanism("four-bar", {}), "linkage must be a linkage such as FourBar"),
        (lambda: Mechanism(RotatingArm(1.0), [SECTION]), "sections must be a Mapping"),
        (lambda: Mechanism(RotatingArm(1.0), {"arm": STEEL}), "section of the arm must be a Beam"),
        (
            lambda: Mechanism(
                RotatingArm(1.0), {"arm": SECTION}, coupler_point=CouplerPoint(0.1, 0.0)
            ),
            "coupler_point: the linkage has no coupler",
        ),
    ],
)
def test_refusals_name_argument_and_remedy(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_every_object_shows_itself_in_one_short_line():
    mechanism = load_mechanism("models/moist_composite_fourbar.toml")
    linkage, section = mechanism.linkage, mechanism.sections["coupler"]
    assert section.layers is not None
    ply = section.layers.laminate.layers[0].ply
    motion = linkage.motion(np.radians([0, 30]), 2.0)
    curve = CouplerCurve(linkage, mechanism.coupler_point)
    objects = [
        mechanism,
        mechanism.provenance,
        linkage,
        linkage.topology,
        motion,
        inverse_dynamics(linkage.topology, motion, mechanism.link_masses_in_order),
        mechanism.link_mass("crank"),
        mechanism.coupler_point,
        curve,
        *double_points(FourBar(0.05, 0.015, 0.04, 0.03), CouplerPoint(0.03, 5.0), 0.0),
        synthesize_crank_rocker(0.3, 2.0),
        synthesize_crank_rocker([0.3, 0.3], 2.0),
        transmission_design(ALUMINIUM_LINKAGE),
        ConstantSpeed(20.0),
        PointMass("crank", 0.1, 1.0),
        section,
        section.damping,
        section.layers,
        section.layers.third_order,
        section.layers.stresses(section.layers.places(3), 1.0),
        section.layers.laminate,
        section.layers.laminate.layers[0],
        ply,
        ply.specific_damping,
        ply.origin,
        ply.origin.matrix,
        ply.origin.fibre,
        ply.resin,
        ply.resin.hygrothermal,
        ALUMINIUM_LINKAGE,
        STEEL,
    ]
    for shown in map(repr, objects):
        assert len(shown) < 200, shown
        assert "\n" not in shown
        assert "array(" not in shown
    assert repr(mechanism) == (
        "<Mechanism: moist composite four-bar, four-bar, crank 100 mm, coupler 279.4 mm, "
        "rocker 266.7 mm>"
    )
    assert repr(STEEL) == "<Material: E 200 GPa, density 7800 kg/m^3, Poisson's ratio 0.3>"
    long_name = replace(mechanism.provenance, name="a " * 500)
    assert len(repr(replace(mechanism, provenance=long_name))) < 200
