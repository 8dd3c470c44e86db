"""A frame on springs: what is stated of it, what is told, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import flexmech
from flexmech.cli.application import app
from flexmech.errors import InputError
from flexmech.linkages import carried_motion
from tests.support.sprung_frame_data import FRAME, framed_file, sprung


@pytest.fixture(scope="module")
def file(models: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("framed")
    return framed_file(folder, models / "aluminium_fourbar.toml")


class TestModelFile:
    def test_it_is_read_and_written(self, file: Path, tmp_path: Path) -> None:
        mechanism = flexmech.load_mechanism(file)
        frame = mechanism.frame
        assert frame is not None
        assert (frame.mass, frame.inertia, frame.centre) == (2.0, 0.03, (0.127, -0.02))
        assert [own.stiffness for own in frame.springs] == [(2e4, 4e4)] * 2
        again = tmp_path / "again.toml"
        again.write_text(mechanism.to_toml(), encoding="utf-8")
        assert flexmech.load_mechanism(again) == mechanism

    @pytest.mark.parametrize(
        ("old", "new", "said"),
        [
            ('mass = "2 kg"', 'mass = "0 kg"', "mass of the frame"),
            ('"0.03 kg m^2"', '"-1 kg m^2"', "inertia"),
            ('"2e4 N/m", "4e4 N/m"', '"0 N/m", "4e4 N/m"', "move along x"),
            ('"5 N s/m", "5 N s/m"', '"5 N/m", "5 N s/m"', "frame.springs"),
            ("centre", "center", "did you mean 'centre'"),
        ],
    )
    def test_what_is_wrong_is_told(
        self, models: Path, tmp_path: Path, old: str, new: str, said: str
    ) -> None:
        wrong = framed_file(tmp_path, models / "aluminium_fourbar.toml", FRAME.replace(old, new))
        with pytest.raises(InputError, match=said) as refused:
            flexmech.load_mechanism(wrong)
        assert "frame" in str(refused.value)

    def test_springs_in_one_point_let_it_turn(self) -> None:
        spring = flexmech.FrameSpring((0.1, 0.0), (1e4, 1e4))
        with pytest.raises(InputError, match="turn without force"):
            flexmech.SprungFrame(1.0, 0.1, (0.1, 0.0), (spring, spring))

    def test_loads_are_refused(self, models: Path, tmp_path: Path) -> None:
        load = '\n[loads.push]\npoint = "B"\nforce = ["1 N", "0 N"]\n'
        wrong = framed_file(tmp_path, models / "aluminium_fourbar.toml", FRAME + load)
        with pytest.raises(InputError, match="the load push acts on a linkage whose frame"):
            flexmech.load_mechanism(wrong)


@pytest.mark.parametrize(
    "command",
    [
        ["stability", "--speeds", "20,21"],
        ["hammer"],
        ["strength", "--speed", "20"],
        ["strength", "--speed", "20", "--source", "rigid"],
        ["export", "--speed", "20"],
        ["response", "--speed", "20", "--shaft", "free"],
    ],
    ids=" ".join,
)
def test_other_commands_refuse_it_in_one_line(
    file: Path, tmp_path: Path, command: list[str]
) -> None:
    name, *rest = command
    found = CliRunner().invoke(app, [name, str(file), *rest, "--out", str(tmp_path / "out")])
    assert found.exit_code == 2
    assert "frame" in found.output
    assert "on springs" in " ".join(found.output.split())
    assert not (tmp_path / "out").exists()


@pytest.fixture(scope="module")
def found(file: Path) -> flexmech.Response:
    engine = flexmech.ReferenceEngine(flexmech.load_mechanism(file), elements=4)
    request = flexmech.ResponseRequest(
        flexmech.ConstantSpeed(20.0), revolutions=1.0, start="periodic"
    )
    return flexmech.response(engine, request)


class TestRun:
    def test_the_answer_tells_how_the_frame_moves(self, found: flexmech.Response) -> None:
        said = " ".join(found.summary().answer)
        assert "The frame moves by at most 0.2" in said
        assert "its springs put up to" in said
        numbers = {one.name: one for one in found.summary().numbers}
        peak = float(found.dataset["peak_frame_displacement"][0])
        assert numbers["peak_frame_displacement"].value == pytest.approx(1e3 * peak)
        assert "frame: on springs" in str(found.summary().details)

    def test_its_springs_answer_what_shakes_it(self, found: flexmech.Response) -> None:
        """Over a turn of the periodic motion the mean force is the same on frame and floor."""
        data = found.dataset.isel(engine=0, time=slice(0, -1))
        shaking = data["shaking_force"].mean("time").values
        floor = data["floor_force"].mean("time").values
        greatest = float(abs(data["floor_force"]).max())
        assert floor == pytest.approx(shaking, abs=2e-3 * greatest)

    def test_tables_have_it(self, found: flexmech.Response) -> None:
        table = found.tables()["response"]
        assert list(table.columns[-5:]) == [
            "frame_x_m",
            "frame_y_m",
            "frame_rotation_deg",
            "floor_force_x_N",
            "floor_force_y_N",
        ]
        rotation = np.degrees(found.dataset["frame_rotation"][0].values)
        assert table["frame_rotation_deg"].to_numpy() == pytest.approx(rotation)

    def test_the_picture_is_made(self, found: flexmech.Response) -> None:
        assert "frame" in found.figures()


def test_dampers_of_the_frame_damp_its_modes(file: Path) -> None:
    """Of the frame alone c / (2 sqrt(k m)); what the links add to its mass lowers it."""
    mechanism = flexmech.load_mechanism(file)
    result = flexmech.moving_frequencies(
        flexmech.ReferenceEngine(mechanism, elements=4), np.radians([0.0, 60.0]), [0.0], modes=3
    )
    found = result.dataset["damping_ratio"].squeeze().values
    alone = 10.0 / (2 * np.sqrt(4e4 * 2.0))
    assert (found > 0.1 * alone).all()
    assert (found < 2.0 * alone).all()


def test_a_frame_carries_velocities_and_accelerations(models: Path) -> None:
    """Central differences of positions as the frame moves along a known path."""
    linkage = flexmech.load_mechanism(models / "aluminium_fourbar.toml").linkage
    drive, step = flexmech.ConstantSpeed(20.0, run_up_time=0.2), 1e-5
    time = 0.1 + step * np.arange(-1.0, 2.0)
    rates = np.array([3.0, 5.0, 7.0])
    place = 0.01 * np.sin(np.outer(time, rates))
    rate = 0.01 * rates * np.cos(np.outer(time, rates))
    change = -0.01 * rates**2 * np.sin(np.outer(time, rates))
    centre = sprung((1.0, 1.0)).centre
    moved = carried_motion(centre, drive.motion(linkage, time), place, rate, change)
    speed = (moved.origin[2] - moved.origin[0]) / (2 * step)
    assert moved.origin_velocity[1] == pytest.approx(speed, abs=1e-6)
    gain = (moved.origin_velocity[2] - moved.origin_velocity[0]) / (2 * step)
    assert moved.origin_acceleration[1] == pytest.approx(gain, abs=1e-5)
    spin = (moved.angle[2] - moved.angle[0]) / (2 * step)
    assert moved.angular_velocity[1] == pytest.approx(spin, abs=1e-6)
