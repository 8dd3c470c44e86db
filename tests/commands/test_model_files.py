"""Model files: what a key becomes, in SI units, and that schema, templates and models agree."""

from __future__ import annotations

import hashlib
import math
import re
import tomllib

import jsonschema
import numpy as np
import pytest

import flexmech
from flexmech import (
    FourBar,
    InputError,
    JointSpring,
    Load,
    PlyStrength,
    RotatingArm,
    Spring,
)
from flexmech.linkages import GROUND, AttachmentPoint
from flexmech.materials import PlyComposition, published_constituents
from flexmech.modelfile import (
    KINDS,
    json_schema,
    mechanism_from_toml,
    mechanism_with,
    quantities_of,
    template,
)
from flexmech.units import LENGTH, RATIO, STRESS
from tests.support.command import MODELS

DATA = MODELS.parent / "tests" / "data"
EVERY_KEY = (DATA / "every_key.toml").read_text(encoding="utf-8")
SCHEMA = jsonschema.Draft202012Validator(json_schema())
LAMINATES = (DATA / "every_laminate_key.toml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def mechanism():
    return mechanism_from_toml(EVERY_KEY, "every_key.toml")


def changed(old: str, new: str):
    """The arm of laminates with a part of its file replaced."""
    assert old in LAMINATES
    return mechanism_from_toml(LAMINATES.replace(old, new, 1))


def layers_of(mechanism, link="arm"):
    return mechanism.sections[link].layers.laminate.layers


# --- keys of links and matter -------------------------------------------------------------------


def test_keys_of_the_linkage(mechanism):
    linkage = FourBar(0.254, 0.1, 0.2794, 0.2667, "crossed", ("B",))
    assert mechanism.linkage == linkage
    point = mechanism.coupler_point
    assert (point.distance, point.angle) == (0.16, pytest.approx(math.radians(35)))
    assert mechanism.ground_thermal_expansion == 12e-6
    assert mechanism.gravity == (0.0, -9.81)
    assert mechanism.reference_temperature == pytest.approx(298.15)
    assert mechanism.operating_speeds == pytest.approx((10.0, 10 * math.pi))
    assert mechanism.speed_unit == "rpm"


def test_a_file_without_a_name_names_its_mechanism(tmp_path):
    keys = re.compile("^(name|source) = .*$", flags=re.MULTILINE)
    file = tmp_path / "packing arm.toml"
    file.write_text(keys.sub("", template("four-bar"), count=2), encoding="utf-8")
    provenance = flexmech.load_mechanism(file).provenance
    assert (provenance.name, provenance.source) == ("packing arm", "")


def test_a_rectangle_of_a_material_has_the_stiffness_and_mass_of_the_textbooks(mechanism):
    crank = mechanism.sections["crank"]
    area, modulus = 4e-3 * 6e-3, 200e9
    assert crank.axial_stiffness == pytest.approx(modulus * area, rel=1e-14)
    assert crank.bending_stiffness == pytest.approx(modulus * area * 4e-3**2 / 12, rel=1e-14)
    assert crank.mass_per_length == pytest.approx(7800 * area, rel=1e-14)
    assert crank.rotary_inertia == pytest.approx(7800 * area * 4e-3**2 / 12, rel=1e-14)
    # Cowper's shear correction of a rectangle at Poisson's ratio 0.3.
    shear = 10 * 1.3 / (12 + 11 * 0.3) * modulus / 2.6 * area
    assert crank.shear_stiffness == pytest.approx(shear, rel=1e-14)


def test_a_damping_ratio_at_a_frequency_is_a_time(mechanism):
    """tau = 2 zeta / (2 pi f): of the material, unless the link states its own."""
    crank, coupler, rocker = (mechanism.sections[n].damping for n in ("crank", "coupler", "rocker"))
    assert crank.bending == pytest.approx(2 * 0.01 / (100 * math.pi), rel=1e-14)
    assert (coupler.axial, coupler.bending, coupler.shear) == (3e-5, 3e-5, 3e-5)
    assert rocker.shear == pytest.approx(2 * 0.02 / (200 * math.pi), rel=1e-14)


def test_a_general_section_is_as_stated(mechanism):
    rocker = mechanism.sections["rocker"]
    expected = {
        "axial_stiffness": 5e6,
        "bending_stiffness": 7.8,
        "shear_stiffness": 1.7e6,
        "mass_per_length": 0.202,
        "rotary_inertia": 3e-7,
        "in_plane_thickness": 4.25e-3,
        "neutral_axis": -2e-4,
        "mass_axis": 1e-4,
        "free_strain": 1e-4,
        "free_curvature": 0.02,
    }
    assert {name: getattr(rocker, name) for name in expected} == expected


def test_masses_bodies_and_the_shaft(mechanism):
    assert mechanism.joint_masses == {"O2": 1.0, "A": 0.02, "B": 0.0, "O4": 0.45359237}
    masses = [(one.link, one.position, one.mass) for one in mechanism.link_masses]
    assert masses == [("coupler", 0.0, 0.005), ("coupler", 0.2794, 0.007)]
    (body,) = mechanism.bodies
    assert (body.link, body.position, body.mass) == ("crank", 0.02, 0.3)
    assert (body.inertia, body.offset) == (pytest.approx(2e-4), (-0.005, 0.01))
    assert mechanism.shaft_inertia == pytest.approx(1e-3)


def test_loads_and_springs(mechanism):
    gas, hit, push = sorted(mechanism.loads, key=lambda load: load.name)
    end = AttachmentPoint("coupler", 0.2794)
    assert push == Load("push", end, ((1.0, -2000.0),), (0.05,), "link")
    place = AttachmentPoint("rocker", 0.03)
    forces, torques, at = ((5.0, 0.0), (0.0, 5.0)), (0.0, 0.1), (0.0, math.pi / 2)
    assert gas == Load("gas", place, forces, torques, "ground", "crank_angle", at)
    assert (hit.over, hit.at, hit.force) == ("time", (0.0, 0.01), ((0.0, 0.0), (30.0, 0.0)))
    assert sorted(mechanism.springs, key=lambda spring: spring.name) == [
        Spring(
            "back",
            AttachmentPoint("crank", 0.1),
            AttachmentPoint(GROUND, 0.1, -0.05),
            3e3,
            0.1,
            0.5,
        ),
        Spring("tie", AttachmentPoint("coupler", 0.05), AttachmentPoint(GROUND, 0.254), 10.0, 0.0),
    ]
    free = math.radians(20)
    assert sorted(mechanism.joint_springs, key=lambda spring: spring.joint) == [
        JointSpring("A", 2.0, 0.1, free),
        JointSpring("B", radial_stiffness=1e6, radial_damping=10.0),
    ]


def test_pins_and_strengths(mechanism):
    (pin,) = mechanism.joint_pins
    assert (pin.joint, pin.diameter, pin.bush_length) == ("A", 3e-3, 4e-3)
    assert (pin.allowable_bearing_pressure, pin.allowable_pv) == (30e6, 1e5)
    eyes = {eye.link: (eye.thickness, eye.width, eye.edge_distance) for eye in pin.eyes}
    assert eyes == {"crank": (5e-3, 8e-3, 6e-3), "coupler": (5e-3, 9e-3, 6e-3)}
    steel = layers_of(mechanism, "crank")[0].ply.isotropic_material
    assert steel.yield_strength == 235e6
    fatigue = steel.fatigue
    assert (fatigue.tensile_strength, fatigue.endurance_limit) == (400e6, 160e6)
    assert (fatigue.endurance_cycles, fatigue.basquin_exponent) == (2e6, -0.085)


def test_the_two_mechanisms_of_kumar_and_chandrakar(steel, aluminium):
    """Section 3 of the paper; errata K on which of b and h is in the plane."""
    assert steel.linkage == FourBar(0.254, 0.1, 0.2794, 0.2667)
    assert aluminium.linkage == FourBar(0.254, 0.102, 0.2794, 0.2667)
    for mechanism, link, modulus, density, width, height in (
        (steel, "coupler", 200e9, 7800, 6.1e-3, 4.25e-3),
        (aluminium, "crank", 68.9e9, 2698, 25.4e-3, 4.24e-3),
        (aluminium, "rocker", 68.9e9, 2923, 25.4e-3, 1.6e-3),
    ):
        section = mechanism.sections[link]
        assert section.mass_per_length == pytest.approx(density * width * height)
        assert section.bending_stiffness == pytest.approx(modulus * width * height**3 / 12)


def test_the_slender_arm_has_slenderness_70_and_unit_frequency():
    mechanism = flexmech.load_mechanism(MODELS / "rotating_arm_slender_70.toml")
    assert mechanism.linkage == RotatingArm(1.0, 0.0)
    arm = mechanism.sections["arm"]
    assert math.sqrt(arm.axial_stiffness / arm.bending_stiffness) == pytest.approx(70, rel=1e-12)
    assert math.sqrt(arm.bending_stiffness / arm.mass_per_length) == 1.0
    assert arm.mass_per_length / arm.rotary_inertia == pytest.approx(4900, rel=1e-12)


# --- laminates ----------------------------------------------------------------------------------


def test_a_stack_becomes_its_layers_from_the_lowest_up():
    layers = layers_of(mechanism_from_toml(LAMINATES))
    assert [layer.ply.name for layer in layers] == ["C", "A", "A", "T"]
    assert [layer.thickness for layer in layers] == [1e-3] * 4
    assert np.degrees([layer.angle for layer in layers]) == pytest.approx([30, 0, 0, 0])


@pytest.mark.parametrize(
    ("stacking", "expected"),
    [
        ("[C/A/C]", [("C", 0), ("A", 0), ("C", 0)]),
        (" [ C @ 45 / A*2 ] ", [("C", 45), ("A", 0), ("A", 0)]),
        ("[C@-45.5*2]s", [("C", -45.5)] * 4),
        ("[C@0/ C@90]S", [("C", 0), ("C", 90), ("C", 90), ("C", 0)]),
    ],
)
def test_notation_of_stacks(stacking, expected):
    """After @ an angle in degrees, after * how often, and s mirrors the stack."""
    layers = layers_of(changed("[C@30/A*2/T]", stacking))
    found = [(layer.ply.name, pytest.approx(math.degrees(layer.angle))) for layer in layers]
    assert found == expected


def test_angles_and_thicknesses_may_stand_in_lists():
    lists = (
        'stacking = "[C/A/T]"\nangles = ["10 deg", "0 deg", "-0.5 rad"]\n'
        'ply_thickness = ["1 mm", "2 mm", "0.5 mm"]'
    )
    layers = layers_of(changed('stacking = "[C@30/A*2/T]"\nply_thickness = "1 mm"', lists))
    assert [layer.angle for layer in layers] == pytest.approx([math.radians(10), 0, -0.5])
    assert [layer.thickness for layer in layers] == [1e-3, 2e-3, 5e-4]


def test_plies_are_those_of_the_micromechanics():
    """Carbon in polyester at 60 %: 0.6 Ef + 0.4 Em by the rule of mixtures."""
    ply = layers_of(mechanism_from_toml(LAMINATES))[0].ply
    assert ply.longitudinal_modulus == pytest.approx(121.872e9)
    assert ply.density == pytest.approx(1542.4)
    published = published_constituents()
    carbon, polyester = published["carbon"], published["polyester"]
    mixed = flexmech.ply_from_constituents(carbon, polyester, 0.6, "rule-of-mixtures")
    assert ply.transverse_modulus == mixed.transverse_modulus
    woven = layers_of(changed('laminate = "mixed"', 'laminate = "fabric"'))
    assert [layer.thickness for layer in woven] == [2.5e-4] * 4
    fabric = woven[0].ply
    assert fabric.longitudinal_modulus == fabric.transverse_modulus


def test_a_damping_frequency_takes_the_specific_damping_of_the_plies():
    """zeta = psi / (4 pi) of a mode at that frequency."""
    fabric = 'laminate = "fabric"\ndamping_frequency = "50 Hz"'
    section = changed('laminate = "mixed"', fabric).sections["arm"]
    ratio = 2 * math.pi * 50 * section.damping.bending / 2
    assert ratio == pytest.approx(section.specific_damping.bending / (4 * math.pi))
    assert 0 < section.damping.bending < section.damping.shear


def test_strengths_and_the_temperature_of_cure():
    laminate = mechanism_from_toml(LAMINATES).sections["arm"].layers.laminate
    assert laminate.stress_free_temperature == pytest.approx(393.15)
    numbers = (1500e6, 1.2e9, 40e6, 246e6, 68e6, 50e6, 0.35, 0.3)
    assert laminate.layers[-1].ply.strength == PlyStrength(*numbers, "a data sheet")
    assert laminate.layers[0].ply.strength is None


def test_what_is_in_a_measured_ply_stands_beside_its_constants():
    table = 'resin = { moisture_expansion = "3e-3 1/percent", mass_fraction = 0.3 }'
    damping = 'longitudinal_damping = "0.5 %"'
    resin = layers_of(changed(damping, table))[-1].ply.resin
    assert (resin.mass_fraction, resin.hygrothermal.moisture_expansion) == (0.3, 0.3)
    composed = 'constituents = { fibre = "own", matrix = "resin", fibre_volume_fraction = 0.6 }'
    ply = layers_of(changed(damping, composed))[-1].ply
    assert ply.longitudinal_modulus == 135e9
    assert isinstance(ply.origin, PlyComposition)
    assert ply.origin.fibre.name == "own"


def test_a_general_section_may_know_its_layers_its_loss_and_where_water_enters():
    general = (
        'section = "general"\naxial_stiffness = "5 MN"\nbending_stiffness = "7.8 N m^2"\n'
        'mass_per_length = "202 g/m"\nrotary_inertia = "0.3 g mm"\nin_plane_thickness = "4 mm"\n'
        'damping_frequency = "50 Hz"\nexposed_faces = "lower"\n'
        "specific_damping = { axial = 0.01, bending = 0.02, shear = 0.03 }"
    )
    mechanism = changed('section = "laminate"', general)
    section = mechanism.sections["arm"]
    assert section.bending_stiffness == 7.8
    assert math.isinf(section.shear_stiffness)
    assert section.damping.bending == pytest.approx(0.02 / (2 * math.pi) / (100 * math.pi))
    assert len(section.layers.laminate.layers) == 4
    assert mechanism.wetting_of("arm").faces == "lower"


@pytest.mark.parametrize(
    ("stacking", "flexural", "membrane", "density"),
    [
        ("[C/C/C/C/C]", 121.9, 121.9, 1542),
        ("[C/G/C/G/C]", 105.5, 90.3, 1744),
        ("[G/G/C/G/G]", 43.6, 58.7, 1946),
    ],
)
def test_stacks_of_elamy(stacking, flexural, membrane, density):
    """Moduli in GPa by the rule of mixtures at 60 % fibres; density in kg/m^3.

    Table 2 of the paper prints other ones, which do not follow from its Table 1 by this rule.
    """
    glass = '[plies.G]\ntype = "constituents"\nfibre = "E-glass"\nmatrix = "polyester"\n'
    glass += 'fibre_volume_fraction = 0.6\nrule = "rule-of-mixtures"\n[plies.W]'
    text = LAMINATES.replace("[plies.W]", glass).replace("[C@30/A*2/T]", stacking)
    arm = mechanism_from_toml(text).sections["arm"]
    area, height = 20e-3 * 5e-3, 5e-3
    assert 12e-9 * arm.bending_stiffness / (area * height**2) == pytest.approx(flexural, abs=0.06)
    assert 1e-9 * arm.axial_stiffness / area == pytest.approx(membrane, abs=0.06)
    assert arm.mass_per_length / area == pytest.approx(density, abs=0.6)


# --- files --------------------------------------------------------------------------------------


def test_provenance_is_name_source_file_and_hash(tmp_path):
    """A byte-order mark and the lines of Windows change nothing but the hash."""
    file = tmp_path / "every_key.toml"
    plain = mechanism_from_toml(EVERY_KEY, "every_key.toml")
    for text in (EVERY_KEY, "\ufeff" + EVERY_KEY, EVERY_KEY.replace("\n", "\r\n")):
        file.write_bytes(text.encode())
        found = flexmech.load_mechanism(file)
        known = found.provenance
        assert (known.name, known.source, known.file) == ("all keys", "none", "every_key.toml")
        assert known.sha256 == hashlib.sha256(text.encode()).hexdigest()
        assert found == plain


def fit_the_schema(text: str) -> None:
    SCHEMA.validate(tomllib.loads(text))


def test_the_schema_is_one_and_models_and_templates_fit_it():
    jsonschema.Draft202012Validator.check_schema(json_schema())
    files = [*MODELS.glob("*.toml"), *DATA.glob("*.toml")]
    for text in (*(template(kind) for kind in KINDS), *(f.read_text("utf-8") for f in files)):
        fit_the_schema(text)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('crank = "10 cm"', "crank = 10"),
        ('crank = "10 cm"', 'crank = "10"'),
        ('crank = "10 cm"', 'crank_length = "10 cm"'),
        ('kind = "four-bar"', 'kind = "five-bar"'),
        ('section = "general"', ""),
        (', "-9.81 m/s^2"]', "]"),
    ],
)
def test_the_schema_refuses_what_the_loader_refuses(old, new):
    text = EVERY_KEY.replace(old, new)
    with pytest.raises(InputError):
        mechanism_from_toml(text)
    with pytest.raises(jsonschema.ValidationError):
        fit_the_schema(text)


def test_defaults_in_the_schema_fit_it():
    """Editors insert them."""
    definitions = json_schema()["$defs"]
    for definition in definitions.values():
        for field in definition["properties"].values():
            if field.get("default") is not None:
                schema = {**field, "$defs": definitions}
                jsonschema.Draft202012Validator(schema).validate(field["default"])


OF_FOUR_BAR = r"\[|position|mass =|offset|shape|coupler_point|damping_time|law|travel|time|dwell"


def test_what_the_templates_show_in_comments_is_right_too():
    """Keys behind # are used where they do not replace others."""
    for kind, shown in (
        ("four-bar", rf"# (?={OF_FOUR_BAR})"),
        ("rotating-arm", r"# (?=\[|position|mass =|damping_time)"),
        ("composite-four-bar", r"# (?=ply_thickness|damping_frequency)"),
        ("slider-crank", r"# (?=\[|[a-z_]+ = )"),
    ):
        without_ratio = re.sub(r"(?m)^damping_(ratio|frequency) = .*\n", "", template(kind))
        text = re.sub(rf"(?m)^{shown}", "", without_ratio)
        found, plain = mechanism_from_toml(text), mechanism_from_toml(template(kind))
        assert found != plain
        fit_the_schema(text)
    assert [load.name for load in found.loads] == ["gas"]
    assert [spring.name for spring in found.springs] == ["return"]
    assert (found.shaft_inertia, [body.mass for body in found.bodies]) == (1e-4, [0.3, 0.2])


# --- quantities by their keys -------------------------------------------------------------------


def test_a_quantity_is_set_by_its_key_and_nothing_else_changes(aluminium):
    known = quantities_of(aluminium)
    assert known["linkage.coupler"] is LENGTH
    assert known["materials.crank_aluminium.youngs_modulus"] is STRESS
    assert known["materials.aluminium.poisson_ratio"] is RATIO
    assert "operation.crank_speeds" not in known
    assert mechanism_with(aluminium, "linkage.coupler", 0.2794) == aluminium
    longer = mechanism_with(aluminium, "linkage.coupler", 0.29)
    assert longer.linkage == FourBar(0.254, 0.102, 0.29, 0.2667)
    assert longer.sections == aluminium.sections
    thicker = mechanism_with(aluminium, "links.coupler.in_plane_thickness", 3.2e-3)
    ratio = thicker.sections["coupler"].bending_stiffness
    assert ratio == pytest.approx(8 * aluminium.sections["coupler"].bending_stiffness)
    bad = (("linkage.couple", 0.1), *(("linkage.coupler", bad) for bad in (-0.1, 3, np.nan)))
    for key, value in bad:
        with pytest.raises(InputError, match=r"linkage|assembled"):
            mechanism_with(aluminium, key, value)


@pytest.mark.parametrize("model", ["moist_composite_fourbar", "rotating_l_beam", "watt_six_bar"])
def test_every_width_of_a_model_can_be_changed(model):
    mechanism = flexmech.load_mechanism(MODELS / f"{model}.toml")
    keys = [key for key in quantities_of(mechanism) if key.endswith("out_of_plane_width")]
    for key in keys:
        table = key.split(".")[1]
        # A chain of beams is one table.
        link = table if table in mechanism.sections else f"{table}-1"
        wider = mechanism_with(mechanism, key, 21e-3)
        assert wider.sections[link] != mechanism.sections[link]


BEARING = """
name = "rigid links on a bearing"
source = "made for this test"
[linkage]
kind = "planar"
drawn_at = "60 deg"
ground = ["O2", "O4"]
points.O2 = ["0 mm", "0 mm"]
points.A = ["50 mm", "86.6 mm"]
points.B = ["300 mm", "200 mm"]
points.O4 = ["250 mm", "0 mm"]
[links.crank]
points = ["O2", "A"]
rigid = true
[links.coupler]
points = ["A", "B"]
rigid = true
mass = "1 kg"
inertia = "0.01 kg m^2"
centre = "130 mm"
[links.rocker]
points = ["B", "O4"]
section = "general"
axial_stiffness = "{0}e9 N"
bending_stiffness = "{0}e6 N m^2"
shear_stiffness = "{0}e9 N"
mass_per_length = "6 kg/m"
rotary_inertia = "1e-3 kg m"
in_plane_thickness = "40 mm"
[joints.O2]
kind = "clamp"
[joints.O4]
radial_stiffness = "1e6 N/m"
"""


def test_a_rigid_link_is_one_that_is_very_stiff():
    """On a soft bearing the first mode does not depend on how stiff the rocker is."""
    soft, stiff = (
        flexmech.natural_frequencies(
            flexmech.ReferenceEngine(mechanism_from_toml(BEARING.format(size))), 1.0, modes=2
        )
        for size in (1, 10)
    )
    assert soft[0] > 10
    assert stiff == pytest.approx(soft, rel=1e-3)
