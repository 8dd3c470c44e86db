"""Mechanisms as model files, and results as files: what is written loads back exactly."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import jsonschema
import numpy as np
import pytest
import xarray as xr
from hypothesis import HealthCheck, given, settings

import flexmech
from flexmech import Exposure, HygrothermalState, InputError, LawDrive, PointMass
from flexmech.hygrothermal import mechanism_in_state
from flexmech.materials import published_constituents
from flexmech.mechanism import Provenance, Wetting
from flexmech.modelfile import KINDS, json_schema, mechanism_from_toml, template
from tests.support.any_mechanism import mechanisms
from tests.support.command import MODELS
from tests.support.strategies import fourbar

DATA = MODELS.parent / "tests" / "data"
FILES = sorted([*MODELS.glob("*.toml"), *DATA.glob("*.toml")])
MANY = settings(derandomize=True, deadline=None, suppress_health_check=list(HealthCheck))
SCHEMA = jsonschema.Draft202012Validator(json_schema())


def assert_survives(mechanism) -> None:
    """Written as a model file that fits the schema, it loads back equal and is written alike."""
    text = mechanism.to_toml()
    SCHEMA.validate(tomllib.loads(text))
    again = mechanism_from_toml(text)
    assert again == mechanism
    assert again.to_toml() == text
    assert again.provenance.sha256 != mechanism.provenance.sha256


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_model_survives_the_way_through_text(file):
    assert_survives(flexmech.load_mechanism(file))


def test_templates_survive_the_way_through_text():
    for kind in KINDS:
        assert_survives(mechanism_from_toml(template(kind)))


@pytest.mark.parametrize(
    ("model", "state"),
    [
        ("moist_composite_fourbar", HygrothermalState(60.0, 0.04)),
        ("moist_composite_fourbar", Exposure(40.0, 0.85, 20 * 86400.0)),
        ("neat_resin_figure_5", HygrothermalState(30.0, 0.01)),
    ],
)
def test_a_swollen_mechanism_survives(model, state):
    dry = flexmech.load_mechanism(MODELS / f"{model}.toml")
    assert mechanism_in_state(dry, HygrothermalState()) == dry
    swollen = mechanism_in_state(dry, state)
    assert swollen != dry
    assert_survives(swollen)


def test_drives_and_frames_survive():
    """Laws of motion, tables and motors, and a frame on springs."""
    motor = 'motor = { kind = "dc", resistance = "1 ohm", torque_constant = "0.1 N m/A", '
    motor += 'voltage = "24 V", gear_ratio = 5 }\ntime = "1 s"'
    drives = (
        'law = "cycloid"\ntravel = "90 deg"\ntime = "0.2 s"\ndwell = "0.1 s"\nmoves = 2',
        'table = [["0 s", "0 deg"], ["0.1 s", "9 deg"], ["0.2 s", "30 deg"], ["0.3 s", "31 deg"]]',
        'speed = "20 rad/s"\nrun_up_time = "0.5 s"',
        motor,
    )
    frame = '[frame]\nmass = "20 kg"\ninertia = "1 kg m^2"\ncentre = ["0.1 m", "-0.1 m"]\n'
    spring = '{{ point = ["{} m", "0 m"], stiffness = ["10 N/mm", "20 N/mm"] }}'
    frame += f"springs = [{spring.format(0)}, {spring.format(0.3)}]\n"
    for keys in drives:
        assert_survives(mechanism_from_toml(f"{template('four-bar')}\n[drive]\n{keys}\n"))
    assert_survives(mechanism_from_toml(f"{template('four-bar')}\n{frame}"))
    law = mechanism_from_toml(f"{template('four-bar')}\n[drive]\n{drives[0]}\n").drive
    assert law == LawDrive("cycloid", np.pi / 2, 0.2, 0.1, 2)


@settings(MANY, max_examples=10)
@given(mechanisms())
def test_any_mechanism_survives_the_way_through_text(mechanism):
    assert_survives(mechanism)


@pytest.mark.thorough
@settings(MANY, max_examples=100)
@given(mechanisms())
def test_hundred_mechanisms_survive_the_way_through_text(mechanism):
    assert_survives(mechanism)


def test_equal_plies_and_resins_stand_once_and_others_of_the_name_get_another():
    """Two plies and two resins of one name, and a published one in use beside them."""
    published = published_constituents()
    glass, polyester = published["E-glass"], published["polyester"]
    softer = replace(polyester, youngs_modulus=2e9)
    plies = [
        flexmech.ply_from_constituents(glass, resin, 0.5) for resin in (softer, polyester, softer)
    ]
    laminate = flexmech.Laminate.stacked(plies, 1e-3, [0.0, 0.3, 0.0])
    section = flexmech.BeamSection.of_laminate(flexmech.LaminateSection(laminate, 0.02))
    mechanism = flexmech.Mechanism(
        flexmech.RotatingArm(0.3), {"arm": section}, provenance=Provenance("two resins")
    )
    assert_survives(mechanism)
    tables = tomllib.loads(mechanism.to_toml())
    assert len(tables["plies"]) == 2
    assert len(tables["matrices"]) == 2


def test_the_text_is_one_that_a_person_would_write(steel):
    lines = steel.to_toml().split("\n")
    for line in (
        'crank = "100 mm"',
        'youngs_modulus = "200 GPa"',
        'in_plane_thickness = "4.25 mm"',
    ):
        assert line in lines


def test_what_can_be_said_in_two_ways_is_kept_in_one():
    masses = (PointMass("rocker", 0.1, 1.0), PointMass("crank", 0.1, 2.0))
    mechanism = fourbar(
        link_masses=masses, wetting={"crank": Wetting()}, gravity=[0, -9.81], operating_speeds=[1]
    )
    assert mechanism.link_masses == masses[::-1]
    assert (mechanism.wetting, mechanism.gravity) == ({}, (0, -9.81))
    assert mechanism.operating_speeds == (1,)
    assert_survives(mechanism)
    assert replace(mechanism, provenance=Provenance("another")) != mechanism


# --- results ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def frequencies(steel):
    engine = flexmech.ReferenceEngine(steel, 1)
    return flexmech.moving_frequencies(engine, [0.0, 1.0], [0.0, 20.0], modes=1)


def attributes(file):
    with xr.open_dataset(file, engine="h5netcdf") as dataset:
        return dict(dataset.attrs)


def stored(result, folder, **options):
    (file,) = (path for path in result.save(folder, **options) if path.suffix == ".nc")
    return file


def test_a_saved_result_loads_back_identical(frequencies, tmp_path):
    file = stored(frequencies, tmp_path / "new" / "folder", command_line="flexmech x")
    loaded = flexmech.MovingFrequencies.load(file)
    xr.testing.assert_identical(loaded.dataset, frequencies.dataset)
    for name, variable in frequencies.dataset.variables.items():
        assert loaded.dataset[name].dtype.kind == variable.dtype.kind
    assert loaded.stored_as["command_line"] == "flexmech x"


def test_a_file_says_what_it_is(frequencies, steel, tmp_path, monkeypatch):
    before = datetime.now(UTC).replace(microsecond=0)
    found = attributes(stored(frequencies, tmp_path))
    assert re.fullmatch(r"CF-1\.\d+", found["Conventions"])
    assert found["title"].endswith("steel four-bar")
    date = datetime.strptime(found["date"], "%Y-%m-%dT%H:%M:%SZ").replace(tzinfo=UTC)
    assert before <= date <= datetime.now(UTC) + timedelta(seconds=1)
    assert found["model_text"] == (MODELS / "steel_fourbar.toml").read_text(encoding="utf-8")
    assert found["flexmech_version"] == flexmech.__version__
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    one, other = (stored(frequencies, tmp_path / name) for name in ("one", "other"))
    assert attributes(one)["date"] == "1970-01-02T00:00:00Z"
    assert one.read_bytes() == other.read_bytes()


def test_a_long_model_file_is_kept_whole(tmp_path):
    """An attribute of HDF5 by itself holds 64 KB."""
    text = template("four-bar") + "# Größe\n" * 20_000
    result = flexmech.section_profiles(mechanism_from_toml(text))
    assert attributes(stored(result, tmp_path))["model_text"] == text


def test_what_is_no_result_is_not_loaded(tmp_path):
    other = tmp_path / "other.nc"
    xr.Dataset({"other": ("x", [1.0])}).to_netcdf(other, engine="h5netcdf")
    wrong = tmp_path / "wrong.nc"
    wrong.write_bytes(b"not a NetCDF file")
    for file in (tmp_path / "nothing.nc", wrong, other):
        with pytest.raises(InputError, match=file.name):
            flexmech.MovingFrequencies.load(file)
    with pytest.raises(InputError, match="cannot write to"):
        flexmech.section_profiles(fourbar()).save(wrong / "below")
