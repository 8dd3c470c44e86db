"""Laminates in model files: what they become, and what is refused by name."""

from __future__ import annotations

import tomllib
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech.errors import InputError
from flexmech.materials import (
    PlyComposition,
    ply_from_constituents,
    published_constituents,
    woven_ply,
)
from flexmech.materials.stacking import parse_stacking, stacking_text
from flexmech.modelfile import json_schema, load_mechanism, mechanism_from_toml, template

MODEL = Path(__file__).parents[2] / "models" / "composite_fourbar.toml"

TEXT = """
name = "laminates"
source = "none"

[linkage]
kind = "rotating-arm"
length = "300 mm"

[materials.aluminium]
youngs_modulus = "70 GPa"
density = "2700 kg/m^3"
poisson_ratio = 0.33

[fibres.own]
youngs_modulus = "230 GPa"
shear_modulus = "15 GPa"
density = "1760 kg/m^3"
poisson_ratio = 0.2
transverse_modulus = "15 GPa"
transverse_shear_modulus = "7 GPa"

[matrices.resin]
youngs_modulus = "4 GPa"
shear_modulus = "1.48 GPa"
density = "1260 kg/m^3"
poisson_ratio = 0.35
specific_damping = "8 %"

[plies.C]
type = "constituents"
fibre = "carbon"
matrix = "polyester"
fibre_volume_fraction = 0.60
rule = "rule-of-mixtures"

[plies.W]
type = "constituents"
fibre = "own"
matrix = "resin"
fibre_volume_fraction = "55 %"
weave = "woven"
thickness = "0.25 mm"

[plies.A]
type = "isotropic"
material = "aluminium"

[plies.T]
type = "orthotropic"
longitudinal_modulus = "135 GPa"
transverse_modulus = "10 GPa"
in_plane_shear_modulus = "5 GPa"
poisson_ratio = 0.3
density = "1600 kg/m^3"
longitudinal_damping = "0.5 %"

[laminates.mixed]
stacking = "[C@30/A*2/T]"
ply_thickness = "1 mm"

[laminates.fabric]
stacking = "[W/W]s"

[links.arm]
section = "laminate"
laminate = "mixed"
out_of_plane_width = "20 mm"
"""


def changed(old: str, new: str) -> str:
    assert old in TEXT
    return TEXT.replace(old, new)


def layers_of(text: str) -> list[tuple[str, float, float]]:
    section = mechanism_from_toml(text).sections["arm"].layers
    assert section is not None
    return [(x.ply.name, x.thickness, np.degrees(x.angle)) for x in section.laminate.layers]


def test_a_stack_becomes_its_layers_from_the_lowest_up() -> None:
    names, thicknesses, angles = zip(*layers_of(TEXT), strict=True)
    assert names == ("C", "A", "A", "T")
    assert thicknesses == (1e-3,) * 4
    assert angles == pytest.approx((30.0, 0.0, 0.0, 0.0))


def test_plies_are_those_of_the_micromechanics() -> None:
    section = mechanism_from_toml(TEXT).sections["arm"].layers
    assert section is not None
    published = published_constituents()
    carbon, polyester = published["carbon"], published["polyester"]
    expected = ply_from_constituents(carbon, polyester, 0.6, "rule-of-mixtures")  # type: ignore[arg-type]
    ply = section.laminate.layers[0].ply
    assert ply.longitudinal_modulus == expected.longitudinal_modulus == pytest.approx(121.872e9)
    assert ply.density == pytest.approx(1542.4)
    text = changed('laminate = "mixed"', 'laminate = "fabric"')
    assert layers_of(text) == [("W", 2.5e-4, 0.0)] * 4
    woven = mechanism_from_toml(text).sections["arm"]
    assert woven.layers is not None
    ply = woven.layers.laminate.layers[0].ply
    assert ply.longitudinal_modulus == ply.transverse_modulus
    assert woven_ply(ply).longitudinal_modulus == pytest.approx(ply.longitudinal_modulus)
    assert woven.specific_damping is not None
    assert 0 < woven.specific_damping.axial < woven.specific_damping.shear < 0.08


def test_angles_and_thicknesses_may_stand_in_lists() -> None:
    text = changed(
        'stacking = "[C@30/A*2/T]"\nply_thickness = "1 mm"',
        'stacking = "[C/A/T]"\nangles = ["10 deg", "0 deg", "-0.5 rad"]\n'
        'ply_thickness = ["1 mm", "2 mm", "0.5 mm"]',
    )
    angles = [angle for _, _, angle in layers_of(text)]
    assert angles == pytest.approx([10, 0, -np.degrees(0.5)])
    assert [t for _, t, _ in layers_of(text)] == [1e-3, 2e-3, 5e-4]


def test_damping_frequency_takes_the_plies_specific_damping() -> None:
    text = changed('laminate = "mixed"', 'laminate = "fabric"\ndamping_frequency = "50 Hz"')
    section = mechanism_from_toml(text).sections["arm"]
    assert section.specific_damping is not None
    psi = section.specific_damping.bending
    # The damping ratio of a mode at that frequency is psi / (4 pi).
    ratio = 2 * np.pi * 50 * section.damping.bending / 2
    assert ratio == pytest.approx(psi / (4 * np.pi))
    assert section.damping.shear > section.damping.bending


@pytest.mark.parametrize(
    ("stacking", "expected"),
    [
        ("[C/G/C]", [("C", None), ("G", None), ("C", None)]),
        (" [ C @ 45 / G*2 ] ", [("C", 45.0), ("G", None), ("G", None)]),
        ("[C@-45.5*2]s", [("C", -45.5)] * 4),
        ("[C1_a@0/ C1_a@90]S", [("C1_a", a) for a in (0.0, 90.0, 90.0, 0.0)]),
    ],
)
def test_notation_of_stacks(stacking: str, expected: list[tuple[str, float | None]]) -> None:
    assert parse_stacking(stacking) == expected


@pytest.mark.parametrize("stacking", ["C/G", "[C//G]", "[]", "[C/G", "[C@x]", "[C*0]", "[C@4 5]"])
def test_what_is_no_stack(stacking: str) -> None:
    with pytest.raises(InputError, match=r"\[C/G@45/C\]|has at most 1000 layers"):
        parse_stacking(stacking)


@pytest.mark.parametrize(
    ("stack", "expected"),
    [
        ([("C", 0.0)], "[C]"),
        ([("C", 0.0), ("G", 45.0), ("G", 45.0), ("C", -22.5)], "[C/G@45*2/C@-22.5]"),
        ([("C", 0.0), ("G", 0.0), ("G", 0.0), ("C", 0.0)], "[C/G]s"),
        ([("C", 0.0), ("G", 0.0), ("C", 0.0)], "[C/G/C]"),
        ([("C", 0.0)] * 4, "[C*2]s"),
    ],
)
def test_stacks_are_written_short(stack: list[tuple[str, float]], expected: str) -> None:
    assert stacking_text(stack) == expected


@settings(max_examples=30)
@given(
    st.lists(
        st.tuples(st.sampled_from(["C", "G1", "core-a"]), st.sampled_from([0, 90, -45, 12.5])),
        min_size=1,
        max_size=9,
    )
)
def test_a_written_stack_reads_as_it_was(stack: list[tuple[str, float]]) -> None:
    for layers in (stack, stack + stack[::-1]):
        read = [(name, angle or 0.0) for name, angle in parse_stacking(stacking_text(layers))]
        assert read == layers


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('thickness = "0.25 mm"', 'thickness = "-1 mm"', r"plies\.W\.thickness: must be positive"),
        ('ply_thickness = "1 mm"', 'ply_thickness = "0 mm"', r"laminates\.mixed\.ply_thickness"),
        ('ply_thickness = "1 mm"', "", r"laminates\.mixed: the thickness of ply 'C' is not given"),
        ('"55 %"', "0.95", r"plies\.W: fibre_volume_fraction must lie above 0 and not above 0\.9"),
        ("fraction = 0.60", "fraction = nan", r"plies\.C\.fibre_volume_fraction"),
        ('fibre = "carbon"', 'fibre = "carbn"', r"plies\.C\.fibre: .*did you mean 'carbon'"),
        ('matrix = "polyester"', 'matrix = "glue"', r"plies\.C\.matrix: there is no matrix 'glue'"),
        ('"135 GPa"', '"0.5 GPa"', r"plies\.T: poisson_ratio .* between -0\.22.* got 0\.3"),
        ('material = "aluminium"', 'material = "steel"', r"plies\.A\.material: there is no table"),
        ("A*2/T]", "A*2/X]", r"laminates\.mixed: stacking .* names the ply 'X'"),
        ("[C@30/A*2/T]", "C@30/A", r"laminates\.mixed: got 'C@30/A', which is no stack"),
        (
            'laminate = "mixed"',
            'laminate = "mixd"',
            r"links\.arm\.laminate: .*did you mean 'mixed'",
        ),
        ('width = "20 mm"', 'width = "20 kg"', r"links\.arm\.out_of_plane_width"),
        (
            'ply_thickness = "1 mm"',
            'ply_thickness = "1 mm"\nangles = ["0 deg"]',
            "keep one of the two",
        ),
        (
            "[C@30/A*2/T]",
            '[C/A*2/T]"\nangles = ["0 deg"]\nnotation = "',
            r"laminates\.mixed\.notation",
        ),
        (
            'stacking = "[C@30/A*2/T]"',
            'stacking = "[C/A/T]"\nangles = ["0 deg"]',
            r"laminates\.mixed: angles has 1 values and the stack 3 layers",
        ),
        (
            'laminate = "mixed"',
            'laminate = "mixed"\ndamping_ratio = 0.01',
            r"links\.arm: damping_ratio is given without damping_frequency",
        ),
        (
            'ply_thickness = "1 mm"',
            'ply_thickness = ["1 mm", "-1 mm", "1 mm", "1 mm"]',
            r"laminates\.mixed\.ply_thickness\[1\]: must be positive, got '-1 mm'",
        ),
        (
            'ply_thickness = "1 mm"',
            'ply_thickness = ["1 mm", "1 kg", "1 mm", "1 mm"]',
            r"laminates\.mixed\.ply_thickness\[1\]: got '1 kg', whose unit",
        ),
        (
            'ply_thickness = "1 mm"',
            'ply_thickness = ["1 mm", "1 mm"]',
            r"laminates\.mixed: ply_thickness has 2 values and the stack 4 layers",
        ),
        (
            'ply_thickness = "1 mm"',
            'ply_thickness = ["1 mm", "1e-30 m", "1 mm", "1 mm"]',
            r"laminates\.mixed\.ply_thickness\[1\]: got .1e-30 m., but a thickness",
        ),
        (
            'ply_thickness = "1 mm"',
            'ply_thickness = "1e-300 m"',
            r"ply_thickness: got '1e-300 m'",
        ),
        ("ratio = 0.3\n", "ratio = -1\n", r"plies\.T: transverse_shear_modulus is missing: "),
        ("ply_thickness", "ply_thicknes", r"unknown key 'ply_thicknes'; did you mean 'ply_thi"),
        ('type = "isotropic"', 'type = "metal"', r"plies\.A\.type: got 'metal'"),
        ('shear_modulus = "1.48 GPa"', "", r"matrices\.resin\.shear_modulus: is missing"),
    ],
)
def test_bad_laminates_are_refused_by_name(old: str, new: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        mechanism_from_toml(changed(old, new), "bad.toml")
    assert str(caught.value).startswith("bad.toml: ")


def test_a_damping_frequency_without_specific_damping_is_refused() -> None:
    text = changed("longitudinal_damping", "# ").replace(
        'laminate = "mixed"', 'laminate = "mixed"\ndamping_frequency = "50 Hz"'
    )
    with pytest.raises(InputError, match=r"links\.arm: a damping frequency needs the specific"):
        mechanism_from_toml(text)


GENERAL = """section = "general"
axial_stiffness = "5 MN"
bending_stiffness = "7.8 N m^2"
shear_stiffness = "1.7 MN"
mass_per_length = "202 g/m"
rotary_inertia = "0.3 g mm"
in_plane_thickness = "4 mm"
"""


def test_a_general_section_may_know_its_layers_its_axes_and_its_loss() -> None:
    text = changed('section = "laminate"', GENERAL) + (
        'neutral_axis = "-0.2 mm"\nmass_axis = "0.1 mm"\nfree_curvature = "0.2 1/m"\n'
        'free_strain = 1e-3\ndamping_frequency = "50 Hz"\nexposed_faces = "lower"\n'
        "specific_damping = { axial = 0.01, bending = 0.02, shear = 0.03 }\n"
    )
    jsonschema.validate(tomllib.loads(text), json_schema(), jsonschema.Draft202012Validator)
    mechanism = mechanism_from_toml(text)
    section = mechanism.sections["arm"]
    assert section.bending_stiffness == 7.8
    assert (section.neutral_axis, section.mass_axis) == (-2e-4, 1e-4)
    assert (section.free_strain, section.free_curvature) == (1e-3, 0.2)
    assert section.specific_damping is not None
    assert section.damping == section.specific_damping.times(100 * np.pi)
    assert section.layers is not None
    assert len(section.layers.laminate.layers) == 4
    assert mechanism.wetting_of("arm").faces == "lower"


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ('damping_frequency = "5 Hz"', "damping_frequency is given without damping_ratio"),
        (
            'damping_time = "1 ms"\n'
            'damping_times = { axial = "1 ms", bending = "1 ms", shear = "1 ms" }',
            "damping_times and damping_time or damping_ratio are both given; keep one",
        ),
        ('damping_times = { axial = "1 ms" }', r"links\.arm\.damping_times\.bending: is missing"),
        ('neutral_axis = "3 mm"', r"links\.arm: neutral_axis must lie inside the section"),
    ],
)
def test_bad_general_sections_are_refused_by_name(key: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        mechanism_from_toml(changed('section = "laminate"', GENERAL) + key + "\n")


def test_layers_of_a_general_section_have_a_width_and_a_laminate() -> None:
    text = changed('section = "laminate"', GENERAL)
    with pytest.raises(InputError, match="laminate and out_of_plane_width belong together"):
        mechanism_from_toml(text.replace('out_of_plane_width = "20 mm"', ""))
    with pytest.raises(InputError, match=r"links\.arm\.laminate: .*did you mean 'mixed'"):
        mechanism_from_toml(text.replace('laminate = "mixed"', 'laminate = "mixd"'))


RESIN = """
[plies.T.resin]
moisture_expansion = "3e-3 1/percent"
mass_fraction = 0.3
volume_fraction = "40 %"
"""
COMPOSITION = """
[plies.T.constituents]
fibre = "own"
matrix = "resin"
fibre_volume_fraction = 0.6
"""


def test_what_is_in_a_measured_ply_may_stand_beside_its_constants() -> None:
    layers = mechanism_from_toml(TEXT + RESIN).sections["arm"].layers
    assert layers is not None
    known = layers.laminate.layers[-1].ply.resin
    assert known is not None
    assert (known.mass_fraction, known.volume_fraction) == (0.3, 0.4)
    assert known.hygrothermal.moisture_expansion == pytest.approx(0.3)
    layers = mechanism_from_toml(TEXT + COMPOSITION).sections["arm"].layers
    assert layers is not None
    ply = layers.laminate.layers[-1].ply
    assert ply.longitudinal_modulus == 135e9
    assert isinstance(ply.origin, PlyComposition)
    assert ply.origin.fibre.name == "own"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TEXT + RESIN + COMPOSITION, r"plies\.T: matrix, resin and constituents are given; keep o"),
        (TEXT + COMPOSITION.replace('"own"', '"one"'), r"plies\.T\.constituents\.fibre: .*'own'"),
        (TEXT + RESIN.replace("0.3\n", "3\n"), r"plies\.T: mass_fraction of the resin must be"),
        (
            changed("[matrices.resin]", "[matrices.resin]\nuncertainty = { densty = 1 }"),
            r"matrices\.resin\.uncertainty: unknown property 'densty'; did you mean 'density'",
        ),
        (
            changed("[matrices.resin]", "[matrices.resin]\nuncertainty = { density = 1 }"),
            r"matrices\.resin\.uncertainty: got the number 1.0, which has no unit",
        ),
        (
            changed(
                "[matrices.resin]", '[matrices.resin]\nuncertainty = { glass_transition = "1 K" }'
            ),
            r"matrices\.resin: uncertainty of 'resin' is of 'glass_transition'",
        ),
    ],
)
def test_bad_contents_of_plies_are_refused_by_name(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        mechanism_from_toml(text)


def test_names_and_uncertainties_of_constituents() -> None:
    text = changed(
        "[matrices.resin]",
        '[matrices.resin]\nname = "epoxy"\nsource = "a book"\n'
        'uncertainty = { density = "9 kg/m^3" }',
    ).replace("[plies.W]", '[plies.W]\nname = "fabric ply"')
    layers = mechanism_from_toml(text.replace('"mixed"', '"fabric"')).sections["arm"].layers
    assert layers is not None
    ply = layers.laminate.layers[0].ply
    assert ply.name == "fabric ply"
    assert isinstance(ply.origin, PlyComposition)
    resin = ply.origin.matrix
    assert (resin.name, resin.source, resin.uncertainty) == ("epoxy", "a book", {"density": 9.0})


def test_the_text_fits_the_schema() -> None:
    jsonschema.validate(tomllib.loads(TEXT), json_schema(), jsonschema.Draft202012Validator)


def test_the_composite_example_has_an_unsymmetric_coupler() -> None:
    mechanism = load_mechanism(MODEL)
    crank, coupler, rocker = (mechanism.sections[n] for n in ("crank", "coupler", "rocker"))
    assert not crank.is_eccentric
    assert not rocker.is_eccentric
    # Carbon lies below; glass is softer and heavier.
    assert coupler.neutral_axis < 0 < coupler.mass_axis
    assert crank.in_plane_thickness == pytest.approx(10e-3)


def test_what_the_template_shows_in_comments_is_right_too() -> None:
    text = template("composite-four-bar")
    plain = mechanism_from_toml(text).sections["crank"]
    shown = ("# ply_thickness", "# damping_frequency")
    lines = [x.removeprefix("# ") if x.startswith(shown) else x for x in text.split("\n")]
    crank = mechanism_from_toml("\n".join(lines)).sections["crank"]
    assert crank.in_plane_thickness == pytest.approx(plain.in_plane_thickness)
    assert crank.bending_stiffness == pytest.approx(plain.bending_stiffness)
    assert crank.damping.bending > plain.damping.bending == 0


ELAMY_TABLE_2 = """
name = "a laminate of Elamy et al. 2023"
source = "Elamy et al. 2023, Tables 1 and 2; plies by the rule of mixtures"

[linkage]
kind = "rotating-arm"
length = "300 mm"

[plies.C]
type = "constituents"
fibre = "carbon"
matrix = "polyester"
fibre_volume_fraction = 0.6
rule = "rule-of-mixtures"

[plies.G]
type = "constituents"
fibre = "E-glass"
matrix = "polyester"
fibre_volume_fraction = 0.6
rule = "rule-of-mixtures"

[laminates.hybrid]
stacking = "{stacking}"
ply_thickness = "0.8 mm"

[links.arm]
section = "laminate"
laminate = "hybrid"
out_of_plane_width = "25 mm"
"""


@pytest.mark.parametrize(
    ("stacking", "flexural", "membrane", "density"),
    [
        ("[C/C/C/C/C]", 121.9, 121.9, 1542),
        ("[C/C/G/C/C]", 121.2, 106.1, 1643),
        ("[C/G/C/G/C]", 105.5, 90.3, 1744),
        ("[G/C/G/C/G]", 59.4, 74.5, 1845),
        ("[G/G/C/G/G]", 43.6, 58.7, 1946),
        ("[G/G/G/G/G]", 43.0, 43.0, 2046),
    ],
)
def test_the_six_stacks_of_elamy(
    stacking: str, flexural: float, membrane: float, density: float
) -> None:
    """Moduli in GPa that the rule of mixtures gives at 60 % fibres; density in kg/m^3.

    Table 2 of the paper prints densities of 1538 to 2048, and moduli of 99.73 to 62.61 that do
    not follow from its Table 1 by this rule.
    """
    arm = mechanism_from_toml(ELAMY_TABLE_2.format(stacking=stacking)).sections["arm"]
    area = 25e-3 * 4e-3
    assert round(12 * arm.bending_stiffness / (area * 4e-3**2) / 1e9, 1) == flexural
    # In equal steps from carbon to glass.
    assert arm.axial_stiffness / area / 1e9 == pytest.approx(membrane, abs=0.06)
    assert round(arm.mass_per_length / area) == density
