"""``flexmech frequencies``: a coarse map by both engines, with its files and its sentences."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import flexmech
from flexmech.analyses import MovingFrequencies
from tests.support.command import MODELS
from tests.support.journeys import Journey, tells

COLUMNS = "engine,crank_speed_rad_s,crank_angle_deg,mode,branch,frequency_Hz,damping_ratio"
COARSE = ("--angles", "0,60", "--modes", "2", "--elements", "2")
WET = MODELS.parent / "tests/data/wet_four_bar.toml"


@pytest.fixture(scope="module")
def journey(tmp_path_factory):
    folder = tmp_path_factory.mktemp("frequencies")
    words = ("models/aluminium_fourbar.toml", *COARSE, "--no-plots")
    return Journey(folder / "out", "frequencies", *words, "--speeds", "0,190.98593171 rpm")


def test_the_table_has_a_row_for_each_engine_speed_angle_and_mode(journey):
    found = journey.table("frequencies")
    assert ",".join(found) == COLUMNS
    assert len(found["mode"]) == 2 * 2 * 2 * 2
    assert list(dict.fromkeys(found["engine"])) == ["reference", "exudyn"]
    assert sorted(set(found["crank_speed_rad_s"])) == pytest.approx([0.0, 20.0])
    assert set(found["crank_angle_deg"]) == {0.0, 60.0}
    assert (np.diff(found["frequency_Hz"].reshape(-1, 2)) > 0).all()


def test_files_hold_what_was_printed_and_load_back(journey):
    files = ["frequencies.csv", "frequencies.nc", "summary.txt"]
    assert journey.ended.files == files
    data = journey.result().dataset
    assert data.attrs["speed_unit"] == "rpm"
    assert data["frequency"].dims == ("engine", "crank_speed", "crank_angle", "mode")
    assert data["frequency"].attrs["units"] == "Hz"
    assert data.attrs["elements"] == 2


def test_mode_shapes_are_scaled_to_one_and_links_meet(journey):
    data = journey.result().dataset
    size = np.sqrt((data["mode_shape"] ** 2).sum(["part", "component"]))
    assert size.max(["link", "station"]).values == pytest.approx(1.0)
    crank, coupler, rocker = (
        data["rigid_position"].sel(link=link) for link in ("crank", "coupler", "rocker")
    )
    for one, other, station in ((crank, coupler, 0.0), (coupler, rocker, 1.0)):
        there = other.sel(station=station).values
        np.testing.assert_allclose(one.sel(station=1.0).values, there, atol=1e-12)
    assert (rocker.sel(station=0.0).values == [0.254, 0.0]).all()


def test_lowest_and_highest_frequencies_are_those_of_the_table(journey):
    found = journey.table("frequencies")
    first = found["engine"] == "reference"
    for row, (speed, mode) in zip(journey.rows, ((0, 1), (0, 2), (20, 1), (20, 2)), strict=True):
        at = first & (found["mode"] == mode) & np.isclose(found["crank_speed_rad_s"], speed)
        band = found["frequency_Hz"][at]
        of = f"mode {mode} at {'0 rpm' if speed == 0 else '190.986 rpm'}"
        assert journey.number("lowest_frequency", of) == pytest.approx(band.min(), rel=1e-9)
        assert journey.number("highest_frequency", of) == pytest.approx(band.max(), rel=1e-9)
        assert row[3] == pytest.approx(band.min(), abs=0.051)
        assert row[5] == pytest.approx(band.max(), abs=0.051)
        if speed:
            assert tells(journey.said["answer"][0], round(band.min(), 1))
            assert tells(journey.said["answer"][0], round(band.max(), 1))


def test_engines_differ_by_what_is_told_and_less_than_their_errors(journey):
    frequency = journey.table("frequencies")["frequency_Hz"].reshape(2, -1)
    apart = np.abs(frequency[1] / frequency[0] - 1).max()
    (line,) = (one for one in journey.said["details"]["lines"] if one.startswith("engines:"))
    assert tells(line, apart)
    assert journey.error("highest_frequency", "mode 2 at 190.986 rpm") > apart * frequency[0].max()
    agreement = journey.result().agreement()
    assert agreement.relative_difference == pytest.approx(apart, rel=1e-6)


def test_the_effect_of_speed_is_split_without_a_remainder(aluminium):
    """Geometric, configuration, Coriolis, centripetal and tangential parts add up."""
    engine = flexmech.ReferenceEngine(aluminium, 2)
    angles = np.radians([0.0, 40.0])
    every, fastest = (
        flexmech.moving_frequencies(engine, angles, [0, -20, 10], modes=2, speed_effect=which)
        for which in (True, "fastest")
    )
    frequency = every.dataset["frequency"].sel(engine="reference")
    effect = every.dataset["speed_effect"]
    change = (frequency - frequency.sel(crank_speed=0.0)).values
    np.testing.assert_allclose(effect.sum("term").values, change, atol=1e-5 * frequency.max())
    assert np.abs(change).max() > 0.1
    alone = fastest.dataset["speed_effect"]
    np.testing.assert_array_equal(alone.sel(crank_speed=-20), effect.sel(crank_speed=-20))
    assert alone.sel(crank_speed=10).isnull().all()


def test_pictures_are_those_that_there_is_data_for(command, rough_pictures):
    model = "models/rotating_arm.toml"
    words = ("--engine", "reference", "--speeds", "0,10", "--all")
    ended = command("frequencies", model, *COARSE, *words)
    pictures = {name for name in ended.files if name.endswith(".png")}
    assert pictures == {
        *("damping.png", "frequencies.png", "mode_shapes.png", "speed_effect.png"),
    }
    damped = ended.table("frequencies")["damping_ratio"]
    assert (damped > 0).all()


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("words", "elements"),
    [
        ("--element geometrically-exact", ["timoshenko", "geometrically-exact"]),
        ("--engine exudyn", ["ancf"]),
        ("--engine reference --element reddy", ["reddy"]),
    ],
)
def test_an_element_goes_to_the_engine_that_has_it(words, elements, command):
    model = "models/steel_fourbar.toml"
    words = [*COARSE, "--speeds", "0", *words.split(), "--no-plots"]
    ended = command("frequencies", model, *words)
    data = MovingFrequencies.load(ended.folder / "frequencies.nc").dataset
    assert data["element"].values.tolist() == elements


def test_a_failure_names_speed_and_angle_in_the_unit_that_was_typed(command):
    words = (*COARSE, "--engine", "reference", "--prestress", "axial", "--no-plots")
    model = "models/aluminium_fourbar.toml"
    ended = command("frequencies", model, *words, "--speeds", "0:3000:1500 rpm")
    assert ended.exit_code == 1
    assert "3000 rpm" in ended.stderr
    assert "deg" in ended.stderr
    assert "rad/s" not in ended.stderr
    assert ended.files == []


def test_the_mode_of_a_free_shaft_has_a_table_of_its_own(command):
    words = (*COARSE, "--engine", "reference", "--shaft", "free", "--speeds", "0")
    ended = command("frequencies", "models/aluminium_fourbar.toml", *words, "--no-plots")
    shaft = ended.table("shaft")
    names = "engine,crank_speed_rad_s,crank_angle_deg,kind,frequency_Hz,growth_rate_1_s"
    assert ",".join(shaft) == names
    assert shaft["kind"].tolist() == ["rigid", "rigid"]
    assert (shaft["frequency_Hz"] < 1e-3).all()
    assert ended.table("frequencies")["mode"].tolist() == [1, 2, 1, 2]


def test_a_wet_linkage_stands_beside_the_dry_one(tmp_path):
    state = ("--temperature-rise", "40", "--moisture", "5", "--speeds", "10", "--no-plots")
    words = ("--engine", "reference", *COARSE)
    wet = Journey(tmp_path / "wet", "frequencies", WET, *words, *state)
    dry = Journey(tmp_path / "dry", "frequencies", WET, *words, *state[4:])
    effect = wet.table("hygrothermal_effect")
    change = effect["frequency_Hz"] / effect["dry_frequency_Hz"] - 1
    np.testing.assert_allclose(effect["relative_change"], change, rtol=1e-6)
    # To the last digit: the dry linkage is the one without the options.
    np.testing.assert_array_equal(
        effect["dry_frequency_Hz"], dry.table("frequencies")["frequency_Hz"]
    )
    np.testing.assert_array_equal(effect["frequency_Hz"], wet.table("frequencies")["frequency_Hz"])
    assert change.max() < -0.1
    first = 100 * change[effect["mode"] == 1]
    (line,) = (one for one in wet.said["details"]["lines"] if one.startswith("change from dry"))
    assert any(tells(line, value) for value in first)
    whole = MovingFrequencies.load(wet.ended.folder / "hygrothermal_effect.nc")
    assert whole.states == ("dry", "+40 K, 5 % moisture")
    xr.testing.assert_identical(
        whole.state("dry").dataset,
        MovingFrequencies.load(wet.ended.folder / "dry" / "frequencies.nc").dataset,
    )
