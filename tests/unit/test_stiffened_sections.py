"""Sections that are stiffer as a whole, and the fit of that factor to records of laminates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import flexmech
from flexmech.beams.restrained_ends import restrained_beam
from flexmech.cli import app
from flexmech.errors import InputError
from flexmech.sections import stiffened_section

COMPOSITE = flexmech.example_model("composite_fourbar")
MOIST = flexmech.example_model("moist_composite_fourbar")
ANGLES = np.radians([0.0, 80.0, 200.0])


def stiffened(mechanism: flexmech.Mechanism, factor: float, *links: str) -> flexmech.Mechanism:
    """A mechanism with stiffer links: of those named, or of all."""
    sections = {
        name: stiffened_section(section, factor) if not links or name in links else section
        for name, section in mechanism.sections.items()
    }
    return replace(mechanism, sections=sections)


def test_all_stiffnesses_of_a_laminate_go_with_the_factor():
    section = flexmech.load_mechanism(COMPOSITE).sections["coupler"]
    stiffer = stiffened_section(section, 1.3)
    for name in ("axial_stiffness", "bending_stiffness", "shear_stiffness", "coupling_stiffness"):
        before, after = getattr(section, name), getattr(stiffer, name)
        assert after == pytest.approx(1.3 * before, rel=1e-12)
        assert after == getattr(stiffer.layers, name)
    laminates = section.layers.laminate, stiffer.layers.laminate
    plain, stiff = (laminate.plate_stiffness for laminate in laminates)
    assert stiff == pytest.approx(1.3 * plain, rel=1e-12, abs=1e-9 * np.abs(plain).max())
    third = section.third_order.stiffness, stiffer.third_order.stiffness
    assert third[1] == pytest.approx(1.3 * third[0], rel=1e-9)
    for name in ("mass_per_length", "rotary_inertia", "damping", "in_plane_thickness"):
        assert getattr(stiffer, name) == getattr(section, name)


def test_a_section_stated_to_be_stiffer_than_its_layers_stays_so():
    section = flexmech.load_mechanism(COMPOSITE).sections["coupler"]
    stated = replace(section, bending_stiffness=2 * section.bending_stiffness)
    stiffer = stiffened_section(stated, 1.3)
    assert stiffer.bending_stiffness == 1.3 * stated.bending_stiffness
    assert stiffer.bending_stiffness == pytest.approx(2 * stiffer.layers.bending_stiffness)


def test_a_factor_must_be_positive():
    section = flexmech.load_mechanism(COMPOSITE).sections["coupler"]
    with pytest.raises(InputError, match="factor of a stiffness"):
        stiffened_section(section, 0.0)


@pytest.mark.parametrize("element", ["euler", "timoshenko", "reddy", "zigzag"])
def test_frequencies_go_with_the_root_of_the_factor(element):
    damped = flexmech.load_mechanism(COMPOSITE)
    sections = {name: s.with_damping_time(0.0) for name, s in damped.sections.items()}
    mechanism = replace(damped, sections=sections)
    engine = flexmech.ReferenceEngine(mechanism, 2, element, component_modes=False)
    stiffer = engine.with_(mechanism=stiffened(mechanism, 1.21))
    before, after = (flexmech.natural_frequencies(e, ANGLES, modes=4) for e in (engine, stiffer))
    assert after == pytest.approx(1.1 * before, rel=1e-7)


def test_what_joints_restrain_of_the_twist_goes_with_the_factor():
    mechanism = flexmech.load_mechanism(MOIST)
    plain = restrained_beam(mechanism, "coupler")[1]
    stiff = restrained_beam(stiffened(mechanism, 1.21), "coupler")[1]
    assert plain is not None
    assert stiff is not None
    assert stiff.of_half_sine == pytest.approx(1.21 * plain.of_half_sine, rel=1e-6)


@pytest.mark.parametrize(
    "element", ["timoshenko", pytest.param("zigzag", marks=pytest.mark.thorough)]
)
def test_a_stiffer_laminate_is_found_by_the_command(element, tmp_path):
    mechanism = flexmech.load_mechanism(COMPOSITE)
    engine = flexmech.ReferenceEngine(stiffened(mechanism, 1.1, "coupler"), 8, element)
    angle = np.arange(0.0, 360.0, 60.0)
    frequency = flexmech.natural_frequencies(engine, np.radians(angle), modes=1)[:, 0]
    noise = 1e-3 * np.random.default_rng(1).standard_normal(len(angle))
    rows = (f"{a},{f}" for a, f in zip(angle, frequency * (1 + noise), strict=True))
    record = tmp_path / "frequencies.csv"
    record.write_text("\n".join(["crank_angle_deg,frequency_Hz", *rows]), encoding="utf-8")
    asked = ["compare", COMPOSITE, str(record), "--speed", "0", "--fit", "stiffness:coupler"]
    out = ["--element", element, "--out", str(tmp_path / "results"), "--no-plots"]
    done = CliRunner().invoke(app, [str(part) for part in (*asked, *out, "--details")])
    assert done.exit_code == 0, done.stderr
    assert f"of the reference engine ({element})" in done.stdout
    fitted = (tmp_path / "results" / "fit.csv").read_text().splitlines()[1].split(",")
    low, high = (float(end) for end in fitted[-2:])
    assert low < 1.1 < high
    assert high - low < 0.02


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("model", "element", "speed"),
    [
        ("composite_fourbar", "timoshenko", 100.0),
        ("composite_fourbar", "zigzag", 100.0),
        ("moist_composite_fourbar", "reddy", 10.0),
        # Its record turned 50 periods: a fit that begins with all of it ends 10 % too low.
        ("aluminium_fourbar", "euler", 10.0),
    ],
)
def test_a_stiffer_link_is_found_from_the_strain_of_a_run(model, element, speed, tmp_path):
    mechanism = flexmech.load_mechanism(flexmech.example_model(model))
    engine = flexmech.ReferenceEngine(mechanism, element=element)
    true = engine.with_(mechanism=stiffened(mechanism, 1.1, "coupler"))
    request = flexmech.ResponseRequest(flexmech.ConstantSpeed(speed), revolutions=2)
    data = flexmech.response(true, request).dataset.isel(engine=0)
    strain = data["strain"].sel(link="coupler").values
    noise = 0.02 * strain.std() * np.random.default_rng(3).standard_normal(len(strain))
    time, angle = data["time"].values, data["crank_angle"].values
    columns = (
        flexmech.MeasuredQuantity("crank_angle", "rad", angle),
        flexmech.MeasuredQuantity("coupler_mid_strain", "", strain + noise),
    )
    record = flexmech.MeasuredRecord("time", time, columns)
    asked = flexmech.ComparisonRequest(speed=speed, fit=("stiffness:coupler",))
    found = flexmech.compare_with_record(engine, record, asked).fitted("stiffness:coupler")
    assert found.lower < 1.1 < found.upper
    assert found.upper - found.lower < 0.01
