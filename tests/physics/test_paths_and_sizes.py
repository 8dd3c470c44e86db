"""How far a tool leaves its path, and what sizes motor and bearings, against own calculations."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad

import flexmech
from flexmech import ExudynEngine, ReferenceEngine
from flexmech.studies import Output, sweep
from tests.support.command import run_command

PACKER = "tests/data/packer.toml"
# In m: the tool is opposite to the middle of the coupler, 40 mm off the line of its pins.
LENGTH, OFFSET = 0.15, 0.04
ONE_TURN = ("--speed", "190 rpm", "--start", "periodic", "--revolutions", "1", "--no-plots")


def of_the_tool(data: xr.Dataset) -> np.ndarray:
    """Distance in m from the path on rigid links, by the displaced axis of the coupler alone.

    The slope at the tool's foot is that of cubics through places on either side: its body makes the
    curvature jump there, so that a difference across it gives 2 % less.
    """
    drawn, moved = (
        data[name].sel(link="coupler").isel(engine=0, missing_dims="ignore").values @ [1, 1j]
        for name in ("rigid_position", "displacement")
    )
    axis, middle = drawn + moved, drawn.shape[1] // 2
    place, slopes = np.linspace(0.0, LENGTH, drawn.shape[1]), []
    for side in (-1, 1):
        near = middle + side * np.arange(4)
        slopes.append(np.polyfit(place[near] - place[middle], axis[:, near].T, 3)[-2])
    along = np.mean(slopes, axis=0)
    tool = axis[:, middle] + 1j * OFFSET * along / np.abs(along)
    chord = (drawn[:, -1] - drawn[:, 0]) / LENGTH
    return np.asarray(np.abs(tool - (drawn[:, middle] + 1j * OFFSET * chord)))


@pytest.fixture(scope="module")
def run() -> flexmech.Response:
    engine = ReferenceEngine(flexmech.load_mechanism(PACKER), 4, element="euler")
    return flexmech.response(
        engine, 1200, speed_unit="rpm", revolutions=0.04, samples=360, step=1e-4, modes=1
    )


def test_a_tool_turns_with_the_section_that_carries_it(run: flexmech.Response) -> None:
    """The axis alone leaves its path by a tenth less, and the chord of the pins by four fifths."""
    data = run.dataset
    deviation = data["path_deviation"].sel(point="coupler body 1").isel(engine=0).values
    np.testing.assert_allclose(deviation, of_the_tool(data), atol=1e-6)
    assert 1.2e-3 < deviation.max() < 1.3e-3


def test_paths_are_those_of_rigid_links_and_the_deviation(run: flexmech.Response) -> None:
    """Joint A on a circle about O2, and a deviation that is the distance of both paths."""
    table = run.tables()["paths"]
    columns = "point,time_s,crank_angle_deg,x_m,y_m,rigid_x_m,rigid_y_m,deviation_m"
    assert ",".join(table) == columns
    assert list(table["point"].unique()) == ["A", "B", "coupler point", "coupler body 1"]
    apart = np.hypot(table["x_m"] - table["rigid_x_m"], table["y_m"] - table["rigid_y_m"])
    np.testing.assert_allclose(table["deviation_m"], apart, atol=1e-15)
    crank = table[table["point"] == "A"]
    angle = np.radians(crank["crank_angle_deg"])
    np.testing.assert_allclose(crank["rigid_x_m"], 0.045 * np.cos(angle), atol=1e-12)
    tool = run.summary().as_data()["numbers"]
    (most,) = (one for one in tool if one["of"] == "coupler body 1")
    assert most["name"] == "peak_path_deviation"
    assert most["value"] == pytest.approx(1e3 * table["deviation_m"].max(), rel=1e-3)
    assert 0 < most["error"] < 0.02 * most["value"]
    assert "paths: in ground axes" in run.summary().details
    (said,) = (line for line in run.summary().answer if "path" in line)
    assert said.startswith("Coupler body 1 leaves its path on rigid links by up to 1.2")


@pytest.mark.thorough
def test_the_tool_of_the_packer_leaves_its_path_by_the_same_on_both_engines() -> None:
    """1.234 mm of slender beams; 1.248 mm where sections shear.

    The slope between stations 15 mm apart gives 1.216 mm, extrapolated to no distance 1.245 mm:
    the couple of the body bends the coupler by another curvature on each side of it.
    """
    mechanism = flexmech.load_mechanism(PACKER)
    for elements, expected in (
        (("euler", "ancf"), 1.234e-3),
        (("timoshenko", "geometrically-exact"), 1.248e-3),
    ):
        kinds = zip((ReferenceEngine, ExudynEngine), elements, strict=True)
        engines = [kind(mechanism, element=element) for kind, element in kinds]
        found = flexmech.response(
            engines, 1200, speed_unit="rpm", revolutions=1.0, start="periodic", samples=360
        )
        peaks = found.dataset["peak_path_deviation"].sel(point="coupler body 1")
        np.testing.assert_allclose(peaks, expected, rtol=1.5e-3)
        assert float(found.force_agreement()["path_deviation"].max()) < 5e-3


@pytest.mark.thorough
def test_a_study_knows_the_deviation_of_a_point_and_the_greatest(tmp_path: Path) -> None:
    outputs = {
        "tool": Output("path_deviation", speed=40 * np.pi, point="coupler body 1"),
        "most": Output("path_deviation", speed=40 * np.pi),
        "a": Output("path_deviation", speed=40 * np.pi, point="A"),
        "no": Output("path_deviation", speed=40 * np.pi, point="coupler body 2"),
    }
    mechanism = flexmech.load_mechanism(PACKER)
    single = flexmech.response(mechanism, 40 * np.pi, revolutions=1.0, start="periodic").peaks()
    expected = single["path_deviation"].isel(engine=0)
    key = {"links.crank.in_plane_thickness": [8e-3]}
    kept = {name: outputs[name] for name in ("tool", "most", "a")}
    found = sweep(mechanism, key, kept).dataset
    assert float(found["tool"][0]) == pytest.approx(float(expected.sel(point="coupler body 1")))
    assert float(found["most"][0]) == pytest.approx(float(expected.max()))
    assert float(found["a"][0]) == pytest.approx(float(expected.sel(point="A")))
    refused = sweep(mechanism, key, {"no": outputs["no"]})
    assert "no point 'coupler body 2'" in str(refused.dataset["reason"].values[0])


def sizes(path: Path) -> dict[tuple[str, str], float]:
    """Values of ``sizing.csv`` by quantity and what each is of."""
    lines = (path / "sizing.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "quantity,of,value,unit"
    rows = [line.split(",") for line in lines[1:]]
    units = {"torque": "N m", "power": "W", "speed": "rad/s", "force": "N", "ratio": ""}
    assert all(unit == units[name.rpartition("_")[2]] for name, _, _, unit in rows)
    return {(name, of): float(value) for name, of, value, _ in rows}


def test_means_of_a_turn_are_integrals_of_the_rigid_linkage(tmp_path: Path) -> None:
    """Whatever crank angles are printed; by an adaptive rule of its own."""
    words = ("--speed", "1200 rpm", "--angles", "0:360:40", "--no-plots", "--json")
    ended = run_command(tmp_path / "out", "kinematics", PACKER, *words)
    found, mechanism = sizes(ended.folder), flexmech.load_mechanism(PACKER)

    def forces_at(angle: float) -> flexmech.linkages.InverseDynamics:
        motion = mechanism.linkage.motion(np.array([angle]), 40 * np.pi)
        return mechanism.inverse_dynamics(motion)

    def mean(value, power: float) -> float:
        whole, _ = quad(lambda angle: value(angle) ** power, 0.0, 2 * np.pi, limit=200)
        return float((whole / (2 * np.pi)) ** (1 / power))

    torque = mean(lambda angle: float(forces_at(angle).driving_torque[0]), 2)
    assert found["rms_torque", "shaft"] == pytest.approx(torque, rel=1e-8)
    force = mean(lambda angle: float(np.hypot(*forces_at(angle).joint_force["O4"][0])), 3)
    assert found["cubic_mean_force", "O4"] == pytest.approx(force, rel=1e-7)
    numbers = {(n["name"], n["of"]): n["value"] for n in json.loads(ended.stdout)["numbers"]}
    assert found["peak_torque", "shaft"] == pytest.approx(
        numbers["peak_driving_torque", None], rel=1e-5
    )
    assert found["peak_power", "shaft"] == pytest.approx(40 * np.pi * found["peak_torque", "shaft"])
    assert numbers["rms_torque", "shaft"] == pytest.approx(torque)


def test_means_under_a_motor_are_over_the_run_and_its_rotor_is_compared(tmp_path: Path) -> None:
    """Means on the motor's own shaft; the linkage's mean inertia follows from its energy."""
    ended = run_command(tmp_path / "out", "kinematics", "tests/golden/models/dc.toml", "--no-plots")
    found, drive = sizes(ended.folder), ended.table("drive")
    time, torque = drive["time_s"], drive["motor_torque_Nm"]
    mean = np.trapezoid(torque**2, time) / time[-1]
    assert found["rms_torque", "motor"] == pytest.approx(mean**0.5, rel=1e-6)
    assert found["peak_speed", "motor"] == pytest.approx(drive["motor_speed_rad_s"].max(), rel=1e-4)
    mechanism = flexmech.load_mechanism("tests/golden/models/dc.toml")
    motor = mechanism.drive.motor
    motion = mechanism.linkage.motion(np.linspace(0.0, 2 * np.pi, 361)[:-1], 1.0)
    energy = sum(
        0.5 * mass.moment(0) * np.sum(_centre_velocity(motion, link, mass) ** 2, axis=-1)
        + 0.5 * mass.central_inertia * motion.angular_velocity[:, link] ** 2
        for link, mass in enumerate(mechanism.link_masses_in_order)
    )
    load = 2 * energy.mean() + mechanism.shaft_inertia
    ratio = load / (motor.inertia * motor.gear_ratio**2)
    assert found["inertia_ratio", "motor"] == pytest.approx(ratio, rel=1e-6)


def _centre_velocity(motion, link: int, mass) -> np.ndarray:
    return np.asarray(motion.velocity(link, *mass.centre))


def test_means_of_a_run_are_those_of_its_last_turn(tmp_path: Path) -> None:
    """The motion begins periodic; its ends differ by the error of the time step."""
    words = ("--engine", "reference", "--elements", "2", "--samples", "120", "--modes", "1")
    model = "models/aluminium_fourbar.toml"
    ended = run_command(tmp_path / "out", "response", model, *ONE_TURN, *words, "--json")
    found, history = sizes(ended.folder), ended.table("response")
    mean = np.sqrt((history["driving_torque_Nm"][:-1] ** 2).mean())
    assert found["rms_torque", "shaft"] == pytest.approx(mean, rel=1e-3)
    for joint, column in (("A", "pin_A"), ("O2", "bearing_O2"), ("O4", "bearing_O4")):
        size = np.hypot(history[f"{column}_x_N"], history[f"{column}_y_N"])
        cubic = (size[:-1] ** 3).mean() ** (1 / 3)
        assert found["cubic_mean_force", joint] == pytest.approx(cubic, rel=1e-3)
        assert found["peak_force", joint] == pytest.approx(size.max(), rel=0.01)
    lines = json.loads(ended.stdout)["details"]["tables"]
    (table,) = (one for one in lines if one["title"].startswith("sizes"))
    assert table["title"] == "sizes of motor and bearings, over the last turn"


def test_peaks_of_sizes_are_those_of_the_answer_between_few_samples(tmp_path: Path) -> None:
    words = ("--start", "rigid", "--engine", "reference", "--elements", "2", "--samples", "24")
    model = "models/aluminium_fourbar.toml"
    ended = run_command(tmp_path / "out", "response", model, *words, "--no-plots", "--json")
    found = sizes(ended.folder)
    numbers = {
        (one["name"], one["of"]): one["value"] for one in json.loads(ended.stdout)["numbers"]
    }
    for joint in ("O2", "A", "B", "O4"):
        peak = numbers["peak_joint_force", joint]
        assert found["peak_force", joint] == pytest.approx(peak, rel=0.01)
    torque = next(value for (name, _), value in numbers.items() if name == "peak_driving_torque")
    assert found["peak_torque", "shaft"] == pytest.approx(torque, rel=0.01)
