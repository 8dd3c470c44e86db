"""Heat and moisture on the command line: shared options, and frequencies beside the dry ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from typer.testing import CliRunner

from flexmech.analyses import MovingFrequencies, ResponseRequest, moving_frequencies
from flexmech.analyses.response.compute import response
from flexmech.cli import app
from flexmech.cli.options import asked_environment
from flexmech.cli.reading import from_options
from flexmech.errors import InputError
from flexmech.hygrothermal import Exposure, HygrothermalState
from flexmech.linkages import ConstantSpeed
from flexmech.modelfile import load_mechanism
from flexmech.reference import ReferenceEngine
from tests.support.figure_checks import HALF_WIDTH_PANEL, check_layout

pytestmark = pytest.mark.usefixtures("rough_pictures")

MODEL = """
name = "wet linkage"
source = "invented"
[linkage]
kind = "four-bar"
ground = "200 mm"
crank = "60 mm"
coupler = "180 mm"
rocker = "160 mm"
[materials.resin]
youngs_modulus = "3.9 GPa"
density = "1280 kg/m^3"
poisson_ratio = 0.37
thermal_expansion = "58.4e-6 1/K"
moisture_expansion = "3.02e-3 1/percent"
equilibrium_moisture = "7 percent"
glass_transition = "210 degC"
diffusivity = "6e-13 m^2/s"
[materials.steel]
youngs_modulus = "210 GPa"
density = "7850 kg/m^3"
poisson_ratio = 0.3
[links.crank]
section = "rectangle"
material = "steel"
in_plane_thickness = "6 mm"
out_of_plane_width = "10 mm"
[links.coupler]
section = "rectangle"
material = "resin"
in_plane_thickness = "6 mm"
out_of_plane_width = "10 mm"
exposed_faces = "lower"
[links.rocker]
section = "rectangle"
material = "resin"
in_plane_thickness = "6 mm"
out_of_plane_width = "10 mm"
"""
COARSE = ["--speeds", "10", "--angles", "0,120", "--elements", "2", "--modes", "2"]
QUICK = ["--engine", "reference", "--no-plots"]


@pytest.fixture
def model(tmp_path: Path) -> Path:
    file = tmp_path / "wet.toml"
    file.write_text(MODEL)
    return file


def run(*arguments: str | Path) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    return result.exit_code, result.stdout, result.stderr


def environment(typed: tuple[str | None, ...]) -> object:
    names = ("temperature_rise", "moisture", "relative_humidity", "time")
    return from_options(asked_environment)(**dict(zip(names, typed, strict=True)))


@pytest.mark.parametrize(
    ("options", "wanted"),
    [
        ((None, None, None, None), None),
        (("80", None, None, None), HygrothermalState(80.0, 0.0)),
        (("80 K", "7", None, None), HygrothermalState(80.0, 0.07)),
        (("-10 degC", "7 %", None, None), HygrothermalState(-10.0, 0.07)),
        ((None, "0.5 percent", None, None), HygrothermalState(0.0, 0.005)),
        (("60", None, "85", "30 day"), Exposure(60.0, 0.85, 30 * 86400.0)),
        ((None, None, "85 %", "0 s"), Exposure(0.0, 0.85, 0.0)),
    ],
)
def test_options_to_a_state(options: tuple[str | None, ...], wanted: object) -> None:
    assert environment(options) == wanted


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ((None, "7", "85", "30 day"), "keep one"),
        ((None, None, "85", None), "--relative-humidity is given without --time"),
        ((None, None, None, "30 day"), "--time is given without --relative-humidity"),
        (("hot", None, None, None), "--temperature-rise"),
        (("80 mm", None, None, None), "--temperature-rise"),
        ((None, "-1", None, None), "--moisture: must lie between"),
        ((None, "nan", None, None), "--moisture"),
        ((None, None, "120", "1 day"), "--relative-humidity: must lie between"),
        ((None, None, "85", "30"), "--time: .*no unit"),
        ((None, None, "85", "-3 day"), "--time: must be zero or positive"),
    ],
)
def test_options_that_cannot_be(options: tuple[str | None, ...], said: str) -> None:
    with pytest.raises(InputError, match=said):
        environment(options)


def test_frequencies_beside_the_dry_ones(model: Path, tmp_path: Path) -> None:
    out = tmp_path / "wet"
    code, printed, errors = run(
        "frequencies",
        model,
        *COARSE,
        *("--temperature-rise", "40", "--moisture", "5", "--no-plots"),
        *("--out", out, "--details"),
    )
    assert (code, errors) == (0, "")
    assert "state: +40 K, 5 % moisture" in printed
    assert "heat and moisture do nothing to: crank" in printed
    assert "wet linkage, +40 K, 5 % moisture" in printed
    alone = tmp_path / "alone"
    assert run("frequencies", model, *COARSE, "--no-plots", "--out", alone)[0] == 0
    dry, wet = (MovingFrequencies.load(folder / "frequencies.nc") for folder in (out / "dry", out))
    plain = MovingFrequencies.load(alone / "frequencies.nc")
    # To the last bit: the dry linkage is the one without the options.
    assert np.array_equal(dry.dataset["frequency"].values, plain.dataset["frequency"].values)
    effect = MovingFrequencies.load(out / "hygrothermal_effect.nc")
    assert effect.states == ("dry", "+40 K, 5 % moisture")
    ratio = wet.dataset["frequency"] / dry.dataset["frequency"] - 1
    assert effect.relative_change().values == pytest.approx(ratio.values)
    assert effect.relative_change().max() < -0.1
    xr.testing.assert_identical(effect.state("dry").dataset, dry.dataset)
    xr.testing.assert_identical(effect.state(effect.states[1]).dataset, wet.dataset)
    assert str(effect.summary()).splitlines()[-1] == printed.strip().splitlines()[-2]
    table = pd.read_csv(out / "hygrothermal_effect.csv")
    assert list(table.columns) == [
        "engine",
        "crank_speed_rad_s",
        "crank_angle_deg",
        "mode",
        "dry_frequency_Hz",
        "frequency_Hz",
        "relative_change",
    ]
    assert len(table) == 2 * 2 * 2
    check_layout(effect.plot(), HALF_WIDTH_PANEL)


def test_dry_state_on_request_is_the_dry_linkage(model: Path, tmp_path: Path) -> None:
    zero = ["--temperature-rise", "0", "--moisture", "0", *QUICK]
    assert run("frequencies", model, *COARSE, *zero, "--out", tmp_path)[0] == 0
    effect = MovingFrequencies.load(tmp_path / "hygrothermal_effect.nc")
    assert np.all(effect.relative_change().values == 0.0)


def test_exposure_bends_the_link_that_is_wet_on_one_side(model: Path, tmp_path: Path) -> None:
    exposed = [
        "--relative-humidity",
        "85",
        "--time",
        "20 day",
        "--temperature-rise",
        "20",
        "--speeds",
        "0",
    ]
    code, printed, errors = run(
        "frequencies", model, *COARSE, *exposed, *QUICK, "--out", tmp_path, "--details"
    )
    assert (code, errors) == (0, "")
    assert "bent by itself" in printed
    assert "% of its stiffness" in printed


def test_section_in_a_state(model: Path) -> None:
    alone = ("section", model, "--link", "coupler", "--details")
    dry = run(*alone)[1]
    code, wet, errors = run(*alone, "--temperature-rise", "40", "--moisture", "5")
    assert (code, errors) == (0, "")
    assert "state: +40 K, 5 % moisture" in wet
    assert "state" not in dry
    assert wet.splitlines()[:20] != dry.splitlines()[:20]


def test_check_tells_what_heat_and_water_do(model: Path) -> None:
    printed = run("check", model, "--details")[1]
    assert "heat and moisture change: coupler, rocker; water enters: coupler, rocker" in printed


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--temperature-rise", "100", "--moisture", "7"], "above its wet glass transition"),
        (["--moisture", "8"], "more than the resin takes up"),
        (["--moisture", "5", "--time", "1 day"], "--time is given without"),
    ],
)
def test_refusals(model: Path, tmp_path: Path, options: list[str], said: str) -> None:
    out = tmp_path / "none"
    code, printed, errors = run("frequencies", model, *COARSE, *options, "--out", out)
    assert code == 2
    assert said in errors
    assert len(errors.strip().splitlines()) == 1
    assert not out.exists()
    assert printed == ""


def test_a_state_that_is_not_there_is_refused(model: Path) -> None:
    engine = ReferenceEngine(load_mechanism(model), 2)
    dry = moving_frequencies(engine, [0.0, 1.0], [0.0], modes=1)
    with pytest.raises(InputError, match="computed dry alone"):
        dry.state("wet")
    with pytest.raises(InputError, match="with an environment"):
        dry.relative_change()
    heat = HygrothermalState(temperature_rise=40.0)
    both = moving_frequencies(engine, [0.0, 1.0], [0.0], modes=1, environment=heat)
    with pytest.raises(InputError, match="no state 'wet'; its states are 'dry', '\\+40 K"):
        both.state("wet")


RUN = ["--speed", "10", "--revolutions", "0.1", "--elements", "2", "--samples", "120"]


@pytest.mark.thorough
def test_response_of_the_wet_linkage(model: Path, tmp_path: Path) -> None:
    """Softer and heavier links are bent further by the same motion."""
    options = [*RUN, *QUICK, "--start", "equilibrium"]
    deflections = []
    for name, state in (("dry", []), ("wet", ["--temperature-rise", "40", "--moisture", "3"])):
        code, text, error = run(
            "response", model, *options, *state, "--details", "--out", tmp_path / name
        )
        assert (code, error) == (0, "")
        table = pd.read_csv(tmp_path / name / "response.csv")
        deflections.append(table["coupler_mid_deflection_m"].abs().max())
    assert "state: +40 K, 3 % moisture" in text
    assert "coupler: +1.1396 % longer" in text
    assert "heat and moisture do nothing to: crank" in text
    assert deflections[1] > 1.3 * deflections[0]


def test_response_refuses_to_start_a_bent_link_straight(model: Path, tmp_path: Path) -> None:
    exposure = ["--relative-humidity", "90", "--time", "10 day"]
    code, _, error = run("response", model, *RUN, *QUICK, *exposure, "--out", tmp_path / "wet")
    assert code == 2
    assert "start rigid" in error
    assert "equilibrium or periodic" in error
    assert not (tmp_path / "wet").exists()


def test_response_in_what_is_no_environment_is_refused(model: Path) -> None:
    engine = ReferenceEngine(load_mechanism(model), 2)
    with pytest.raises(InputError, match="an environment is needed, got 'wet'"):
        response(engine, ResponseRequest(ConstantSpeed(10.0)), environment="wet")  # type: ignore[arg-type]
