"""Model files: what they become, and that schema, templates and models agree."""

from __future__ import annotations

import hashlib
import math
import re
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexmech.errors import InputError
from flexmech.linkages import FourBar, PlanarLinkage, RotatingArm
from flexmech.modelfile import KINDS, json_schema, load_mechanism, mechanism_from_toml, template
from flexmech.sections import DampingTimes

MODELS = Path(__file__).parents[2] / "models"
MODEL_FILES = sorted(MODELS.glob("*.toml"))

FULL = """
name = "all keys"
source = "none"
notes = "every key of the format"

[linkage]
kind = "four-bar"
ground = "254 mm"
crank = "10 cm"
coupler = "0.2794 m"
rocker = "266.7 mm"
branch = "crossed"

[materials.steel]
youngs_modulus = "200 GPa"
density = "7.8 g/cm^3"
poisson_ratio = "30 %"
damping_ratio = 0.01
damping_frequency = "50 Hz"

[links.crank]
material = "steel"
section = "rectangle"
in_plane_thickness = "4 mm"
out_of_plane_width = "6 mm"

[links.coupler]
material = "steel"
section = "rectangle"
in_plane_thickness = "4 mm"
out_of_plane_width = "6 mm"
damping_time = "3e-5 s"

[[links.coupler.point_masses]]
position = "0 mm"
mass = "5 g"

[[links.coupler.point_masses]]
position = "279.4 mm"
mass = "7 g"

[links.rocker]
section = "general"
axial_stiffness = "5 MN"
bending_stiffness = "7.8e6 N mm^2"
shear_stiffness = "1.7 MN"
mass_per_length = "202 g/m"
rotary_inertia = "0.3 g mm"
in_plane_thickness = "4.25 mm"
damping_ratio = "2 %"
damping_frequency = "100 Hz"

[joints.O2]
mass = "1 kg"

[joints.A]
mass = "20 g"

[joints.B]
mass = "0 g"

[joints.O4]
mass = "1 lb"

[environment]
gravity = ["0 m/s^2", "-9.81 m/s^2"]

[operation]
crank_speeds = ["10 rad/s", "300 rpm"]
"""


def fit_the_schema(document: dict[str, Any]) -> None:
    """Without checking the schema itself each time: another test does that."""
    jsonschema.Draft202012Validator(json_schema()).validate(document)


def test_every_key_reaches_the_mechanism() -> None:
    mechanism = mechanism_from_toml(FULL, "full.toml")
    assert mechanism.linkage == FourBar(0.254, 0.1, 0.2794, 0.2667, "crossed")
    crank, coupler, rocker = (mechanism.sections[n] for n in ("crank", "coupler", "rocker"))
    assert crank.axial_stiffness == pytest.approx(200e9 * 24e-6, rel=1e-14)
    assert crank.bending_stiffness == pytest.approx(200e9 * 6e-3 * 4e-3**3 / 12, rel=1e-14)
    assert crank.mass_per_length == pytest.approx(7800 * 24e-6, rel=1e-14)
    assert crank.shear_stiffness == pytest.approx(
        10 * 1.3 / (12 + 11 * 0.3) * 200e9 / 2.6 * 24e-6, rel=1e-14
    )
    assert crank.damping.bending == pytest.approx(2 * 0.01 / (2 * math.pi * 50), rel=1e-14)
    assert coupler.damping == DampingTimes.uniform(3e-5)
    assert rocker.axial_stiffness == 5e6
    assert rocker.bending_stiffness == 7.8
    assert rocker.shear_stiffness == 1.7e6
    assert rocker.mass_per_length == 0.202
    assert rocker.rotary_inertia == 3e-7
    assert rocker.in_plane_thickness == 4.25e-3
    assert rocker.damping.shear == pytest.approx(2 * 0.02 / (2 * math.pi * 100), rel=1e-14)
    assert mechanism.joint_masses == {"O2": 1.0, "A": 0.02, "B": 0.0, "O4": 0.45359237}
    assert [(p.link, p.position, p.mass) for p in mechanism.link_masses] == [
        ("coupler", 0.0, 0.005),
        ("coupler", 0.2794, 0.007),
    ]
    assert mechanism.gravity == (0.0, -9.81)
    assert mechanism.operating_speeds == pytest.approx((10.0, 10 * math.pi))


def test_provenance_is_name_source_file_and_hash(tmp_path: Path) -> None:
    file = tmp_path / "full.toml"
    file.write_bytes(FULL.encode())
    provenance = load_mechanism(file).provenance
    assert provenance.name == "all keys"
    assert provenance.source == "none"
    assert provenance.file == "full.toml"
    assert provenance.sha256 == hashlib.sha256(FULL.encode()).hexdigest()
    assert mechanism_from_toml(FULL, "full.toml").provenance == provenance


@pytest.mark.parametrize("change", ["\ufeff", "\r\n"], ids=["byte-order mark", "Windows lines"])
def test_habits_of_windows_editors_change_nothing_but_the_hash(tmp_path: Path, change: str) -> None:
    text = change + FULL if change == "\ufeff" else FULL.replace("\n", change)
    file = tmp_path / "full.toml"
    file.write_bytes(text.encode())
    mechanism = load_mechanism(file)
    plain = mechanism_from_toml(FULL, "full.toml")
    assert mechanism.sections == plain.sections
    assert mechanism.provenance.sha256 == hashlib.sha256(text.encode()).hexdigest()
    assert mechanism.provenance.sha256 != plain.provenance.sha256


@pytest.mark.parametrize("file", MODEL_FILES, ids=lambda file: file.stem)
def test_models_fit_the_schema_load_and_name_their_source(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    fit_the_schema(tomllib.loads(text))
    mechanism = load_mechanism(str(file))
    assert len(mechanism.provenance.source) > 20
    assert mechanism.operating_speeds


@pytest.mark.parametrize("kind", KINDS)
def test_templates_fit_the_schema_and_load(kind: str) -> None:
    text = template(kind)
    fit_the_schema(tomllib.loads(text))
    kinds = {"four-bar": FourBar, "composite-four-bar": FourBar, "rotating-arm": RotatingArm}
    kinds |= {"slider-crank": PlanarLinkage, "planar": PlanarLinkage}
    assert isinstance(mechanism_from_toml(text).linkage, kinds[kind])


def test_what_the_slider_crank_shows_in_comments_is_right_too() -> None:
    lines = [
        line.removeprefix("# ") if line.startswith("# ") and " = " in line else line
        for line in template("slider-crank").split("\n")
    ]
    text = re.sub(r"(?m)^# \[", "[", "\n".join(lines))
    # Of the two ways to state damping, one.
    text = re.sub(r"(?m)^damping_(ratio|frequency).*$", "", text)
    mechanism = mechanism_from_toml(text)
    assert mechanism.shaft_inertia == 1e-4
    assert [load.name for load in mechanism.loads] == ["gas"]
    assert [spring.name for spring in mechanism.springs] == ["return"]
    assert [body.mass for body in mechanism.bodies] == [0.3, 0.2]


DRIVE = ("# law", "# travel", "# time", "# dwell")


@pytest.mark.parametrize("kind", ["four-bar", "rotating-arm"])
def test_what_templates_show_in_comments_is_right_too(kind: str) -> None:
    lines = template(kind).split("\n")
    # A general section replaces the rectangle above it; a damping ratio the damping time.
    start = lines.index('# section = "general"')
    general = [line.removeprefix("# ") for line in lines[start : start + 7]]
    last_link = max(i for i, line in enumerate(lines) if line.startswith("[links."))
    rectangle = slice(last_link + 1, last_link + 5)
    assert lines[last_link + 1].startswith("material")
    lines[rectangle] = general
    shown = [
        line.removeprefix("# ")
        if line.startswith(("# [", "# position", "# mass =", "# damping_time", *DRIVE))
        else line
        for line in lines
    ]
    text = "\n".join(shown)
    mechanism = mechanism_from_toml(text)
    last = mechanism.linkage.topology.link_names[-1]
    rectangular = mechanism_from_toml(template(kind)).sections[last]
    assert mechanism.sections[last].bending_stiffness == pytest.approx(
        rectangular.bending_stiffness, rel=0.05
    )
    assert mechanism.sections[last].rotary_inertia == pytest.approx(
        rectangular.rotary_inertia, rel=0.05
    )
    assert len(mechanism.link_masses) == 1
    assert (mechanism.drive is not None) == (kind == "four-bar")
    fit_the_schema(tomllib.loads(text))


def test_full_example_fits_the_schema() -> None:
    fit_the_schema(tomllib.loads(FULL))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('crank = "10 cm"', "crank = 10"),
        ('crank = "10 cm"', 'crank = "10"'),
        ('crank = "10 cm"', 'crank_length = "10 cm"'),
        ('kind = "four-bar"', 'kind = "five-bar"'),
        ('section = "general"', ""),
        ('source = "none"', ""),
        ('gravity = ["0 m/s^2", "-9.81 m/s^2"]', 'gravity = ["0 m/s^2"]'),
    ],
)
def test_schema_refuses_what_the_loader_refuses(old: str, new: str) -> None:
    text = FULL.replace(old, new)
    assert text != FULL
    with pytest.raises(InputError):
        mechanism_from_toml(text)
    with pytest.raises(jsonschema.ValidationError):
        fit_the_schema(tomllib.loads(text))


def test_schema_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(json_schema())


def test_defaults_in_the_schema_fit_the_schema() -> None:
    # Editors insert them.
    definitions = json_schema()["$defs"]
    for definition in definitions.values():
        for field in definition["properties"].values():
            if field.get("default") is not None:
                schema = {**field, "$defs": definitions}
                jsonschema.Draft202012Validator(schema).validate(field["default"])


def test_the_two_mechanisms_of_kumar_and_chandrakar() -> None:
    """Section 3 of the paper; errata K on which of b and h is in the plane."""
    steel = load_mechanism(MODELS / "steel_fourbar.toml")
    assert steel.linkage == FourBar(0.254, 0.1, 0.2794, 0.2667)
    for section in steel.sections.values():
        assert section.mass_per_length == pytest.approx(7800 * 6.1e-3 * 4.25e-3)
        assert section.bending_stiffness == pytest.approx(200e9 * 6.1e-3 * 4.25e-3**3 / 12)
    aluminium = load_mechanism(MODELS / "aluminium_fourbar.toml")
    assert aluminium.linkage == FourBar(0.254, 0.102, 0.2794, 0.2667)
    for name, density, thickness in (
        ("crank", 2698, 4.24e-3),
        ("coupler", 2923, 1.6e-3),
        ("rocker", 2923, 1.6e-3),
    ):
        section = aluminium.sections[name]
        assert section.mass_per_length == pytest.approx(density * 25.4e-3 * thickness)
        assert section.bending_stiffness == pytest.approx(68.9e9 * 25.4e-3 * thickness**3 / 12)


def test_pinned_bounds_of_the_aluminium_links() -> None:
    """V1 of the validation numbers: 45.1223 Hz (coupler) and 49.5220 Hz (rocker)."""
    mechanism = load_mechanism(MODELS / "aluminium_fourbar.toml")
    for name, length, expected in (("coupler", 0.2794, 45.1223), ("rocker", 0.2667, 49.5220)):
        section = mechanism.sections[name]
        omega = (math.pi / length) ** 2 * math.sqrt(
            section.bending_stiffness / section.mass_per_length
        )
        assert omega / (2 * math.pi) == pytest.approx(expected, rel=2e-6)


def test_slender_arm_has_slenderness_70_and_unit_frequency() -> None:
    mechanism = load_mechanism(MODELS / "rotating_arm_slender_70.toml")
    assert mechanism.linkage == RotatingArm(1.0, 0.0)
    arm = mechanism.sections["arm"]
    assert math.sqrt(arm.axial_stiffness / arm.bending_stiffness) == pytest.approx(70, rel=1e-12)
    assert math.sqrt(arm.bending_stiffness / arm.mass_per_length) == 1.0
    assert arm.mass_per_length / arm.rotary_inertia == pytest.approx(4900, rel=1e-12)
    assert arm.in_plane_thickness == pytest.approx(math.sqrt(12 / 4900), rel=1e-10)


@given(
    st.floats(min_value=1.0, max_value=1e4),
    st.sampled_from([("mm", 1e-3), ("cm", 1e-2), ("inch", 0.0254)]),
)
def test_lengths_of_an_arm_survive_in_any_unit(length: float, unit: tuple[str, float]) -> None:
    name, factor = unit
    text = template("rotating-arm").replace('length = "300 mm"', f'length = "{length!r} {name}"')
    linkage = mechanism_from_toml(text).linkage
    assert isinstance(linkage, RotatingArm)
    assert linkage.length == pytest.approx(length * factor, rel=4e-16)


@given(st.text(max_size=40))
def test_any_text_is_a_mechanism_or_an_input_error(text: str) -> None:
    with pytest.raises(InputError, match=r"^any\.toml: "):
        mechanism_from_toml(text, "any.toml")


@given(
    st.dictionaries(
        st.sampled_from(["name", "source", "linkage", "links", "materials", "joints", "x"]),
        st.recursive(
            st.sampled_from(['"a"', "1", "1.5", "true", "[]", "nan"]),
            lambda inner: (
                st.lists(inner, max_size=3).map(lambda items: f"[{', '.join(items)}]")
                | st.dictionaries(
                    st.sampled_from(["kind", "crank", "section", "material", "mass"]),
                    inner,
                    max_size=3,
                ).map(lambda d: "{" + ", ".join(f"{k} = {v}" for k, v in d.items()) + "}")
            ),
            max_leaves=6,
        ),
    )
)
def test_any_toml_is_a_mechanism_or_an_input_error(tables: dict[str, str]) -> None:
    text = "\n".join(f"{key} = {value}" for key, value in tables.items())
    with pytest.raises(InputError, match=r"^any\.toml: "):
        mechanism_from_toml(text, "any.toml")
