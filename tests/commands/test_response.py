"""``flexmech response``: a tenth of a turn by the reference and by both engines, with its files."""

from __future__ import annotations

import re
import shutil

import numpy as np
import pytest

import flexmech
from tests.support.command import MODELS
from tests.support.journeys import Journey, tells

ALUMINIUM = "models/aluminium_fourbar.toml"
PACKER = MODELS.parent / "tests/data/packer.toml"
WET = MODELS.parent / "tests/data/wet_four_bar.toml"
SHORT = ("--revolutions", "0.1", "--elements", "2", "--samples", "720", "--no-plots")
ONE = ("--engine", "reference", *SHORT)
COLUMNS = (
    "engine,time_s,crank_angle_deg,coupler_mid_deflection_m,rocker_mid_deflection_m,"
    "crank_tip_deflection_m,coupler_mid_strain,rocker_mid_strain,driving_torque_Nm,"
    "pin_A_x_N,pin_A_y_N,pin_B_x_N,pin_B_y_N,bearing_O2_x_N,bearing_O2_y_N,bearing_O4_x_N,"
    "bearing_O4_y_N,shaking_force_x_N,shaking_force_y_N,shaking_moment_Nm"
)
PROBES = {
    "crank": "crank_tip_deflection_m",
    "coupler": "coupler_mid_deflection_m",
    "rocker": "rocker_mid_deflection_m",
}


@pytest.fixture(scope="module")
def journey(tmp_path_factory):
    folder = tmp_path_factory.mktemp("response") / "out"
    return Journey(folder, "response", ALUMINIUM, *ONE, "--speed", "20", "--start", "rigid")


def test_the_table_holds_a_row_for_each_sample(journey):
    found = journey.table("response")
    assert ",".join(found) == COLUMNS
    assert len(found["time_s"]) == 73
    np.testing.assert_allclose(found["crank_angle_deg"], np.linspace(0, 36, 73), atol=1e-8)
    np.testing.assert_allclose(found["time_s"], np.radians(found["crank_angle_deg"]) / 20)


def test_peaks_are_those_of_the_curves_and_between_samples_a_little_more(journey):
    found = journey.table("response")
    for row, (link, column) in zip(journey.rows, PROBES.items(), strict=True):
        _, name, _, deflection, degrees, turn, strain, stress, place, _ = row
        sample = 1e3 * np.abs(found[column]).max()
        assert (name, turn) == (link, 1)
        assert sample <= deflection * (1 + 1e-3) <= 1.03 * sample
        peak = journey.number("peak_deflection", link)
        assert deflection == pytest.approx(peak, abs=1e-4)
        at = found["crank_angle_deg"][np.abs(found[column]).argmax()]
        assert degrees == pytest.approx(at, abs=1.5)
        assert journey.number("peak_stress", link) == pytest.approx(stress, rel=1e-2)
        if link == "coupler":
            greatest = 1e6 * np.abs(found["coupler_mid_strain"]).max()
            assert greatest <= strain < 1.02 * greatest
            # E eps in the middle; greatest somewhat off it, and with the normal force.
            assert 68.9e-3 * strain < stress < 1.1 * 68.9e-3 * strain
            assert 0.4 < place / 279.4 < 0.7
            assert tells(journey.answer, round(peak, 3))


def test_forces_and_torque_are_those_of_the_curves(journey):
    found = journey.table("response")
    for pin in "AB":
        force = np.hypot(found[f"pin_{pin}_x_N"], found[f"pin_{pin}_y_N"]).max()
        assert 0.999 * force <= journey.number("peak_joint_force", pin) < 1.03 * force
    torque = np.abs(found["driving_torque_Nm"]).max()
    peak = journey.number("peak_driving_torque")
    assert 0.999 * torque <= peak < 1.03 * torque
    assert tells(journey.said["answer"][1], round(peak, 3))
    # At its clamp the crank is bent by the torque, to which the greatest stress belongs: T h / 2 I.
    by_hand = 1e-6 * peak * 4.24e-3 / 2 / (25.4e-3 * 4.24e-3**3 / 12)
    assert journey.number("peak_stress", "crank") == pytest.approx(by_hand, rel=0.02)


def test_files_hold_what_was_printed_and_load_back(journey):
    assert journey.ended.files == [
        "paths.csv",
        "response.csv",
        "response.nc",
        "sizing.csv",
        "summary.txt",
    ]
    data = journey.result().dataset
    (table, *_) = journey.said["details"]["tables"]
    values = {tuple(row[:2]): float(row[2]) for row in table["rows"]}
    for number, engine in enumerate(data["engine"].values):
        drift = values["constraint drift", engine]
        assert drift == pytest.approx(float(data["constraint_drift"][number]), rel=1e-3)
        step = 1e3 * float(data["step"][number])
        assert values["time step", engine] == pytest.approx(step, rel=1e-3)


@pytest.mark.parametrize(
    ("words", "start"),
    [
        ((), "periodic"),
        (("--start", "rigid"), "rigid"),
        (("--run-up", "5 ms"), "rigid"),
        (("--shaft", "free", "--revolutions", "0.1"), "rigid"),
    ],
)
def test_a_linkage_at_constant_speed_runs_as_it_does_in_every_turn(tmp_path, words, start):
    """A start-up is asked for, or taken where no motion repeats itself."""
    turn = ("--speed", "1200 rpm", "--revolutions", "1", "--samples", "60", "--elements", "2")
    asked = (*turn, "--engine", "reference", "--modes", "2", "--no-plots", *words)
    journey = Journey(tmp_path / "out", "response", PACKER, *asked)
    assert journey.result().dataset.attrs["start"] == start
    bent = journey.table("response")["coupler_mid_deflection_m"]
    begins_undeformed = abs(bent[0]) <= 1e-9 * np.abs(bent).max()
    assert begins_undeformed == (start == "rigid")
    if start == "periodic":
        assert bent[-1] == pytest.approx(bent[0], abs=2e-3 * np.abs(bent).max())


def test_a_start_up_is_offered_where_no_periodic_motion_is_found(command):
    words = ("--engine", "reference", "--elements", "1", "--modes", "1", "--revolutions", "0.1")
    ended = command("response", "models/neat_resin_figure_10.toml", *words, "--no-plots")
    assert ended.exit_code == 1
    assert "start rigid runs a start-up in place of the periodic motion" in ended.stderr


def test_options_reach_the_run(tmp_path):
    words = (
        *("--revolutions", "0.01", "--step", "0.1 ms", "--run-up", "2 ms", "--check-mesh"),
        *("--elements", "2", "--modes", "2", "--start", "equilibrium", "--prestress", "none"),
        *("--speed", "-60 rpm", "--engine", "reference", "--no-plots", "--moment-point", "9 mm,0"),
    )
    words = [word.replace("9 mm,0", "9 mm,0 mm") for word in words]
    journey = Journey(tmp_path / "out", "response", ALUMINIUM, *words)
    data = journey.result().dataset
    assert data.attrs["crank_speed"] == pytest.approx(-2 * np.pi)
    assert data.attrs["run_up_time"] == 0.002
    assert (data.attrs["start"], data.attrs["prestress"]) == ("equilibrium", "none")
    assert data["step"].values.tolist() == [1e-4]
    assert float(data["mesh_error_of_deflection"].max()) > 0
    found = journey.table("response")
    assert found["crank_angle_deg"][-1] < 0
    assert found["crank_speed_rad_s"][-1] == pytest.approx(-2 * np.pi)


def test_two_engines_run_and_agree(tmp_path):
    words = ("--speed", "20", "--revolutions", "0.03", "--elements", "4", "--samples", "120")
    words = (*words, "--start", "rigid", "--no-plots")
    journey = Journey(tmp_path / "out", "response", ALUMINIUM, *words)
    found = journey.table("response")
    first, second = (found["engine"] == engine for engine in ("reference", "exudyn"))
    lines = [one for one in journey.said["details"]["lines"] if one.startswith("engines:")]
    for link, column in PROBES.items():
        peak = np.abs(found[column][first]).max()
        apart = np.abs(found[column][first] - found[column][second]).max() / peak
        assert apart < 0.02
        (told,) = re.findall(rf"(\S+) \({link}\)", lines[-1].split(" of the link's peak")[0])
        assert float(told) == pytest.approx(apart, rel=0.1)
    journey.result()


def test_a_clamped_link_alone_has_no_pins(command):
    words = ("--speed", "5", "--revolutions", "0.05", "--step", "1 ms", "--modes", "1")
    more = ("--engine", "reference", "--elements", "2", "--no-plots", "--run-up", "0.1 s")
    ended = command("response", "models/rotating_arm.toml", *words, *more)
    assert ",".join(ended.table("response")) == (
        "engine,time_s,crank_angle_deg,arm_tip_deflection_m,driving_torque_Nm,"
        "crank_speed_rad_s,crank_acceleration_rad_s2,driving_power_W,"
        "bearing_O2_x_N,bearing_O2_y_N,"
        "shaking_force_x_N,shaking_force_y_N,shaking_moment_Nm"
    )


def test_pictures_and_animations_are_those_asked_for(command, rough_pictures):
    words = ("--speed", "20", "--start", "rigid", "--engine", "reference", *SHORT[:-1])
    ended = command("response", ALUMINIUM, *words, "--all")
    drawn = [name.removesuffix(".png") for name in ended.files if name.endswith(".png")]
    first = ["forces", "motor_plane", "paths", "response"]
    assert drawn == [*first, "running_shaking_force", "spectrum"]


@pytest.mark.thorough
def test_a_run_is_animated_where_it_is_asked_for(command, rough_pictures):
    words = ("--speed", "20", "--engine", "reference", *SHORT, "--animate")
    ended = command("response", ALUMINIUM, *words)
    films = {name for name in ended.files if name.startswith("animation")}
    assert films == {"animation.gif"} | ({"animation.mp4"} if shutil.which("ffmpeg") else set())
    for name in films:
        assert name in ended.stdout.splitlines()[-1]


@pytest.mark.thorough
def test_all_is_stored_where_it_is_asked_for(command, tmp_path):
    """Else the file holds what pictures, animations and comparisons need."""
    words = ("--speed", "5", "--engine", "reference", "--elements", "1", "--no-plots")
    more = (
        "--revolutions",
        "1.5",
        "--samples",
        "250",
        "--step",
        "5 ms",
        "--store",
        "all",
        "--modes",
        "1",
    )
    ended = command("response", "models/rotating_arm.toml", *words, *more)
    all_of_it = flexmech.Response.load(ended.folder / "response.nc")
    (file,) = (name for name in all_of_it.save(tmp_path) if name.suffix == ".nc")
    rest = flexmech.Response.load(file)
    whole, needed = all_of_it.dataset, rest.dataset
    assert "kinetic_energy" in whole
    assert "kinetic_energy" not in needed
    # The frames are samples of the last turn.
    time = needed["frame_time"].values
    assert np.ptp(np.diff(time)) < 1e-9
    turned = needed["frame_angle"].values
    assert abs(turned[-1] - turned[0]) == pytest.approx(2 * np.pi)
    for name in ("displacement", "rigid_position"):
        there = whole[name].sel(time=time).rename(time="frame_time").transpose(*needed[name].dims)
        np.testing.assert_array_equal(needed[name].values, there.values)


@pytest.mark.thorough
def test_a_wet_linkage_is_bent_further(command):
    """Softer and heavier links by the same motion: the coupler by more than 30 %."""
    bent = []
    for state in ((), ("--temperature-rise", "40", "--moisture", "3")):
        words = ("--speed", "10", "--start", "equilibrium", *ONE, *state)
        ended = command("response", WET, *words)
        bent.append(np.abs(ended.table("response")["coupler_mid_deflection_m"]).max())
    assert bent[1] > 1.3 * bent[0]
