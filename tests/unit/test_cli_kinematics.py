"""Kinematics and joint forces, as a result and from ``flexmech kinematics``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text
from typer.testing import CliRunner

from flexmech import (
    InputError,
    Kinematics,
    KinematicsRequest,
    PointMass,
    kinematics,
    load_mechanism,
    plots,
)
from flexmech.cli import app
from flexmech.linkages import AttachmentPoint, Load
from flexmech.mechanism import AttachedBody
from tests.support.strategies import ALUMINIUM_LINKAGE, arm, fourbar
from tests.unit.kinematics_data import kinematics_dataset

pytestmark = pytest.mark.usefixtures("rough_pictures")

MODELS = Path(__file__).parents[2] / "models"
ALUMINIUM = MODELS / "aluminium_fourbar.toml"
TURN = np.radians(np.arange(0, 361, 30))


def run(*arguments: str | Path) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    return result.exit_code, result.stdout, result.stderr


def test_the_command_writes_the_tables_of_the_result(tmp_path: Path) -> None:
    options = ("--speed", "190 rpm", "--angles", "0:360:30", "--lumped", "1,4,4")
    code, printed, errors = run("kinematics", ALUMINIUM, *options, "--details", "--out", tmp_path)
    assert (code, errors) == (0, "")
    written = sorted(file.name for file in tmp_path.iterdir())
    # The picture of a law of motion is left out: the speed is constant.
    assert written == sorted({*Kinematics.files, "summary.txt"} - {"law.png", "motor.png"})
    assert "at 190 rpm" in printed
    assert "driving torque by 12 lumped masses" in printed
    columns = {
        "kinematics": "crank_angle_deg link angle_deg angular_velocity_rad_s "
        "angular_acceleration_rad_s2 centre_x_m centre_y_m centre_ax_m_s2 centre_ay_m_s2 "
        "inertia_force_x_N inertia_force_y_N inertia_moment_Nm",
        "forces": "crank_angle_deg joint of on x_N y_N moment_Nm",
        "drive": "crank_angle_deg torque_Nm power_W transmission_angle_deg "
        "reversed_transmission_angle_deg",
        "shaking_force": "crank_angle_deg shaking_force_x_N shaking_force_y_N shaking_moment_Nm",
        "shaking_harmonics": "order shaking_force_x_amplitude_N shaking_force_y_amplitude_N "
        "shaking_force_x_phase_deg shaking_force_y_phase_deg shaking_force_greatest_N "
        "shaking_moment_amplitude_Nm shaking_moment_phase_deg",
        "forces_lumped": "crank_angle_deg joint of on x_N y_N moment_Nm",
        "drive_lumped": "crank_angle_deg torque_Nm power_W",
        "lumped_masses": "crank_angle_deg link position_m mass_kg ax_m_s2 ay_m_s2 "
        "inertia_force_x_N inertia_force_y_N",
    }
    tables = {name: pd.read_csv(tmp_path / f"{name}.csv") for name in columns}
    assert {name: " ".join(table.columns) for name, table in tables.items()} == columns
    assert [len(table) for table in tables.values()] == [39, 52, 13, 13, 11, 52, 13, 156]
    request = KinematicsRequest(TURN, 190 * np.pi / 30, (1, 4, 4))
    data = kinematics(load_mechanism(ALUMINIUM), request).dataset
    forces = tables["forces"].set_index(["joint", "crank_angle_deg"])
    for joint in ("O2", "A", "B", "O4"):
        expected = data["joint_force"].sel(joint=joint).values
        assert forces.loc[joint][["x_N", "y_N"]].to_numpy() == pytest.approx(expected, rel=1e-9)
    assert tables["drive"]["torque_Nm"].to_numpy() == pytest.approx(
        data["driving_torque"].values, rel=1e-9
    )
    coupler = tables["kinematics"].query("link == 'coupler'")
    assert coupler["angle_deg"].to_numpy() == pytest.approx(
        np.degrees(data["angle"].sel(link="coupler").values), rel=1e-9
    )
    loaded = Kinematics.load(tmp_path / "kinematics.nc").dataset
    assert loaded.identical(data.assign_attrs(speed_unit="rpm"))


def test_without_lumped_masses_their_files_are_not_written(tmp_path: Path) -> None:
    code, printed, _ = run("kinematics", ALUMINIUM, "--no-plots", "--out", tmp_path)
    assert code == 0
    names = {file.name for file in tmp_path.iterdir()}
    csv = {"kinematics.csv", "forces.csv", "drive.csv", "motion.csv"}
    shaking = {"shaking_force.csv", "shaking_harmonics.csv"}
    assert names == {*csv, *shaking, "kinematics.nc", "summary.txt"}
    assert len(pd.read_csv(tmp_path / "drive.csv")) == 361
    assert "at 20 rad/s" in printed  # the greatest speed of the model


def test_an_arm_has_no_transmission_angle(tmp_path: Path) -> None:
    model = tmp_path / "arm.toml"
    model.write_text(arm(hub_radius=0.2).to_toml())
    options = ("--angles", "0:90:30", "--no-plots", "--out", tmp_path)
    code, printed, _ = run("kinematics", model, *options)
    assert code == 0
    assert list(pd.read_csv(tmp_path / "drive.csv")) == ["crank_angle_deg", "torque_Nm", "power_W"]
    assert "at 0 rad/s" in printed
    assert "transmission" not in printed


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--lumped", "1,4"), "lumped: 2 numbers of elements for 3 links"),
        (("--lumped", "1,x,4"), "--lumped: got '1,x,4'; give the elements of each link"),
        (("--lumped", "0,4,4"), "--lumped: got '0,4,4'"),
        (("--lumped", "1,4,2000"), "lumped: 2000 elements of a link are beyond 1000"),
        (("--moment-point", "127 mm"), "--moment-point: got '127 mm'; give x and y in ground axes"),
        (("--moment-point", "1,2"), "--moment-point: got '1', which has no unit"),
        (("--speed", "5 mm"), "--speed: "),
        (("--angles", "90,0"), "--angles: "),
        (("--crank-acceleration", "50 rad/s"), "--crank-acceleration: got '50 rad/s', whose unit"),
        (("--crank-acceleration", "1e12"), "--crank-acceleration: got '1e12', but an angular acc"),
    ],
)
def test_what_makes_no_sense_is_refused(options, message, tmp_path: Path) -> None:
    code, _, errors = run("kinematics", ALUMINIUM, *options, "--out", tmp_path / "none")
    assert code == InputError.exit_code
    assert message in errors
    assert errors.count("\n") == 1
    assert not (tmp_path / "none").exists()


def test_a_crank_that_accelerates(tmp_path: Path) -> None:
    """Its acceleration is in tables, words and titles, and in the file that is loaded back."""
    options = ("--speed", "20", "--crank-acceleration", "300 rpm/s", "--no-plots")
    given = (*options, "--angles", "0:360:30", "--out", tmp_path)
    code, printed, errors = run("kinematics", ALUMINIUM, *given)
    assert (code, errors) == (0, "")
    # Rich breaks the heading of a table where the table ends.
    assert "at 20 rad/s and 31.4159 rad/s²" in " ".join(printed.split())
    acceleration = 300 * np.pi / 30
    request = KinematicsRequest(TURN, 20.0, crank_acceleration=acceleration)
    data = kinematics(load_mechanism(ALUMINIUM), request).dataset
    assert Kinematics.load(tmp_path / "kinematics.nc").dataset.identical(data)
    assert data.attrs["crank_acceleration"] == pytest.approx(acceleration, rel=1e-15)
    motion = pd.read_csv(tmp_path / "kinematics.csv")
    crank = motion.query("link == 'crank'")["angular_acceleration_rad_s2"]
    assert crank.to_numpy() == pytest.approx(acceleration, rel=1e-9)
    torque = pd.read_csv(tmp_path / "drive.csv")["torque_Nm"].to_numpy()
    assert torque == pytest.approx(data["driving_torque"].values, rel=1e-9)
    constant = kinematics(load_mechanism(ALUMINIUM), KinematicsRequest(TURN, 20.0)).dataset
    assert np.abs(torque - constant["driving_torque"].values).max() > 1e-3
    for drawn in (plots.plot_kinematics, plots.plot_joint_forces, plots.plot_drive):
        words = [text.get_text() for text in drawn(data).findobj(Text)]
        assert any("at 20 rad/s, crank acceleration 31.42 rad/s²" in text for text in words)
    words = [text.get_text() for text in plots.plot_drive(constant).findobj(Text)]
    assert any("at 20 rad/s" in text for text in words)
    assert not any("acceleration" in text for text in words)


def test_angles_must_increase() -> None:
    with pytest.raises(InputError, match="crank_angles must be one or more in increasing order"):
        KinematicsRequest(np.array([0.2, 0.1]))


def test_the_inertia_force_is_that_of_the_centre_of_mass() -> None:
    """Against differences of the centre's path, with a body off the link."""
    body = AttachedBody("coupler", 0.1, 0.05, 2e-5, (0.02, 0.03))
    mechanism = replace(fourbar(), bodies=(body,))
    step, speed = 1e-4, 20.0
    angles = 0.7 + step * np.arange(-2, 3)
    data = kinematics(mechanism, KinematicsRequest(angles, speed)).dataset.sel(link="coupler")
    weights = np.array([-1, 16, -30, 16, -1]) / 12 * speed**2 / step**2
    acceleration = weights @ data["centre_position"].transpose("crank_angle", ...).values
    assert data["centre_acceleration"].values[2] == pytest.approx(acceleration, rel=1e-5)
    mass = mechanism.link_mass("coupler")
    assert data["inertia_force"].values[2] == pytest.approx(
        -mass.moment(0) * acceleration, rel=1e-5
    )
    own = fourbar().link_mass("coupler")
    centre, total = own.length / 2, own.moment(0) + 0.05
    x = (own.moment(0) * centre + 0.05 * 0.12) / total
    y = 0.05 * 0.03 / total
    inertia = own.moment(0) * (own.length**2 / 12 + (x - centre) ** 2 + y**2)
    inertia += 2e-5 + 0.05 * ((0.12 - x) ** 2 + (0.03 - y) ** 2)
    alpha = data["angular_acceleration"].values
    assert data["inertia_moment"].values == pytest.approx(-inertia * alpha, rel=1e-12)


def test_the_reversed_transmission_angle_is_that_at_a() -> None:
    data = kinematics(fourbar(), KinematicsRequest(TURN, 20.0)).dataset
    for angle, found in zip(TURN, data["reversed_transmission_angle"].values, strict=True):
        motion = ALUMINIUM_LINKAGE.motion(angle)
        a, b = motion.position(0, ALUMINIUM_LINKAGE.crank), motion.position(2, 0.2667)
        cosine = -a @ (b - a) / np.linalg.norm(a) / np.linalg.norm(b - a)
        assert found == pytest.approx(np.arccos(cosine), abs=1e-12)


def test_reversed_dead_points_are_where_crank_and_coupler_are_in_line() -> None:
    """There the rocker turns around and cannot drive the crank."""
    angles = np.radians(np.arange(0, 360.0, 0.01))
    reverse = ALUMINIUM_LINKAGE.reversed_transmission_angle(angles)
    rocker = ALUMINIUM_LINKAGE.motion(angles, 1.0).angular_velocity[:, 2]
    turning = np.flatnonzero(np.diff(np.sign(rocker)))
    assert len(turning) == 2
    assert np.sin(reverse[turning]).max() < 3e-4


def test_weight_is_no_inertia_force() -> None:
    still = replace(fourbar(), gravity=(0.0, -9.81))
    data = kinematics(still, KinematicsRequest(TURN, 0.0)).dataset
    assert not data["inertia_force"].any()
    assert abs(data["joint_force"]).max() > 0.1
    assert not data["driving_power"].any()


def test_a_load_over_time_begins_at_crank_angle_zero() -> None:
    tip = AttachmentPoint("arm", 1.0)
    load = Load("ramp", tip, ((0.0, 0.0), (0.0, 10.0)), (0.0, 0.0), "link", "time", (0.0, 1.0))
    mechanism = replace(arm(), loads=(load,))
    data = kinematics(mechanism, KinematicsRequest([0.0, 1.0, 4.0], 2.0)).dataset
    assert data["driving_torque"].values == pytest.approx([0.0, -5.0, -10.0], abs=1e-9)


def test_joint_masses_and_point_masses_stay_where_they_are_when_mass_is_lumped() -> None:
    mechanism = fourbar(joint_masses={"B": 0.3}, link_masses=(PointMass("rocker", 0.1, 0.2),))
    data = kinematics(mechanism, KinematicsRequest(TURN, 20.0, (200,))).dataset
    for name in ("joint_force", "driving_torque", "driving_power"):
        exact = data[name].values
        assert data[f"lumped_{name}"].values == pytest.approx(exact, abs=1e-4 * np.abs(exact).max())


def test_lumps_of_a_link_that_lies_beside_its_pins() -> None:
    """Acceleration of a lump off the axis, against differences of its place."""
    from flexmech.analyses.kinematics.variables import _acceleration

    linkage, step, speed = ALUMINIUM_LINKAGE, 1e-4, 20.0
    motion = linkage.motion(0.7 + step * np.arange(-2, 3), speed)
    angle = motion.angle[:, 1]
    normal = np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
    places = motion.position(1, 0.1) + 0.02 * normal
    weights = np.array([-1, 16, -30, 16, -1]) / 12 * speed**2 / step**2
    found = _acceleration(motion, 1, 0.1, 0.02)[2]
    assert found == pytest.approx(weights @ places, rel=1e-5)


def test_the_mean_power_of_a_turn_is_told_of_whole_turns_alone() -> None:
    whole = kinematics(fourbar(), KinematicsRequest(crank_speed=20.0))
    assert "mean driving power over the turn: 0 W" in whole.summary().lines
    half = kinematics(fourbar(), KinematicsRequest(TURN[:7], 20.0))
    assert not any("mean" in line for line in half.summary().lines)


def test_pictures_show_the_dataset() -> None:
    data = kinematics_dataset()
    motion = plots.plot_kinematics(data).axes
    lines = motion[2].get_lines()[1:]
    assert lines[1].get_ydata() == pytest.approx(
        data["angular_acceleration"].sel(link="coupler").values
    )
    forces = plots.plot_joint_forces(data).axes
    size, *drawn = [line.get_ydata() for line in forces[1].get_lines()[1:]]
    at_a = data.sel(joint="A")
    assert size == pytest.approx(np.linalg.norm(at_a["joint_force"].values, axis=-1))
    assert drawn[0] == pytest.approx(at_a["joint_force"].sel(component="x").values)
    assert drawn[3] == pytest.approx(at_a["lumped_joint_force"].sel(component="y").values)
    drive = plots.plot_drive(data).axes
    assert drive[1].get_lines()[1].get_ydata() == pytest.approx(data["driving_power"].values)
    assert drive[2].get_lines()[2].get_ydata() == pytest.approx(
        np.degrees(data["reversed_transmission_angle"].values)
    )


def test_more_links_than_styles_are_told_by_their_width() -> None:
    data = kinematics_dataset().isel(link=[0, 1, 2, 0, 1, 2, 0])
    lines = plots.plot_kinematics(data).axes[0].get_lines()[1:]
    looks = {(line.get_color(), line.get_linewidth()) for line in lines}
    assert len(looks) == 7


def test_an_arm_is_drawn_without_transmission_angles() -> None:
    found = kinematics(arm(), KinematicsRequest(TURN, 5.0))
    assert len(plots.plot_drive(found.dataset).axes) == 2


def test_round_off_is_told_as_zero() -> None:
    """An L-beam at constant speed without gravity needs no torque."""
    beam = load_mechanism(MODELS / "rotating_l_beam.toml")
    said = kinematics(beam, KinematicsRequest(TURN)).summary()
    lines = [line for line in said.lines if line.startswith("driving ")]
    assert [line.count(" 0 ") for line in lines] == [2, 2]
    assert any("the driving torque is 0 N m" in line for line in said.answer)


@pytest.mark.parametrize("name", ["slider_crank", "watt_six_bar", "carton_pusher"])
def test_planar_linkages(name: str, tmp_path: Path) -> None:
    """The tables have every link and joint; a slider's force is across its line."""
    model = MODELS / f"{name}.toml"
    code, _, errors = run("kinematics", model, "--angles", "0:360:15", "--out", tmp_path)
    assert (code, errors) == (0, "")
    topology = load_mechanism(model).linkage.topology
    motion, forces = (pd.read_csv(tmp_path / f"{table}.csv") for table in ("kinematics", "forces"))
    assert set(motion["link"]) == set(topology.link_names)
    assert set(forces["joint"]) == set(topology.joint_names)
    for slider in topology.sliders:
        of_line = forces[forces["joint"] == slider.joint]
        assert of_line["y_N"].abs().max() > 1
        assert of_line["x_N"].abs().max() <= 1e-12 * of_line["y_N"].abs().max()


def test_a_rigid_link_without_a_section_has_no_lumps() -> None:
    pusher = load_mechanism(MODELS / "carton_pusher.toml")
    data = kinematics(pusher, KinematicsRequest([0.0, 1.0], lumped=(4,))).dataset
    assert data.sizes["lump"] == 4 * 5
    assert "crank" not in data["lump_link"].values
    assert data["lump_mass"].min() > 0


def test_the_answer_of_a_slider_crank(tmp_path: Path) -> None:
    """Stroke, forces and torque; where each place goes; at one angle, at rest, and by round-off."""
    model = MODELS / "slider_crank.toml"
    code, printed, _ = run("kinematics", model, "--no-plots", "--out", tmp_path)
    assert code == 0
    lines = printed.splitlines()
    assert "B strokes 300.0 mm, from 150.0 to 450.0 mm along its line, at up to " in printed
    assert "The greatest joint force is " in printed
    assert len(lines) <= 25
    (row,) = [line for line in lines if line.startswith("│ B ")]
    cells = [cell.strip() for cell in row.strip("│").split("│")]
    assert cells[:3] == ["B", "slider", "300.0"]
    mechanism = load_mechanism(model)
    (place,) = kinematics(mechanism, KinematicsRequest([0.0], 5.0)).summary().answer[:1]
    assert place == "B stands at 450.0 mm along its line."
    still = kinematics(mechanism, 0.0).summary().answer
    assert still == (
        "B strokes 300.0 mm, from 150.0 to 450.0 mm along its line.",
        "Nothing acts on the links: no joint carries a force.",
    )
    beam = load_mechanism(MODELS / "rotating_l_beam.toml")
    assert not any("average" in line for line in kinematics(beam, 6.0).summary().answer)
    pusher = kinematics(load_mechanism(MODELS / "carton_pusher.toml")).summary()
    assert pusher.answer[-1].startswith("The shaft gives 22.7")
