"""Animations hold the stored motion, enlarged as stated, and can be played."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from PIL import Image

from flexmech.errors import InputError
from flexmech.linkages import FourBar, Linkage, RotatingArm, drawn_joints
from flexmech.plots import SERIES_STYLES, animation, mp4_available, write_animation
from flexmech.plots.animation import EnlargedMotion, Scene
from flexmech.plots.drawn_linkage.parts import extent_of
from flexmech.plots.drawn_linkage.sketch import JOINT
from tests.support.figure_checks import shown_texts

STATIONS = np.linspace(0.0, 1.0, 21)
FOURBAR = FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667)
ARM = RotatingArm(length=0.4, hub_radius=0.025)
GREATEST = 1e-3


def response_dataset(
    linkage: Linkage = FOURBAR, turns: float = 1.0, samples: int = 33
) -> xr.Dataset:
    """Dataset by the schema of Response, with bows of at most 1 mm and twice that in exudyn."""
    angle = np.linspace(0.0, 2 * np.pi * turns, samples)
    motion = linkage.motion(angle)
    lengths = [link.length for link in linkage.topology.links]
    links = [
        np.stack([motion.position(n, s * length) for s in STATIONS], axis=1)
        for n, length in enumerate(lengths)
    ]
    position = np.stack(links, axis=1)
    along = position[:, :, -1] - position[:, :, 0]
    normal = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    bow = GREATEST * np.sin(np.pi * STATIONS) * np.cos(5 * angle)[:, None]
    displacement = bow[:, None, :, None] * normal[:, :, None, :]
    names = list(linkage.topology.link_names)
    return xr.Dataset(
        {
            "rigid_position": (("time", "link", "station", "component"), position),
            "displacement": (
                ("engine", "time", "link", "station", "component"),
                np.stack([displacement, 2 * displacement]),
            ),
        },
        coords={
            "engine": ["reference", "exudyn"],
            "element": ("engine", ["euler", "ancf"]),
            "time": angle / 20.0,
            "crank_angle": ("time", angle),
            "link": names,
            "probe": ("link", ["tip"] + ["middle"] * (len(names) - 1)),
            "station": STATIONS,
            "component": ["x", "y"],
        },
        attrs={
            "mechanism": "test linkage",
            "crank_speed": 20.0,
            "drawing": json.dumps(drawn_joints(linkage.topology)),
        },
    )


def scene_of(dataset: xr.Dataset, engine: int = 1, enlargement: float | None = None):
    motion = EnlargedMotion.of(dataset.isel(engine=[engine]), enlargement)
    return Scene(motion), motion


def support_tips(scene) -> list[list[float]]:
    """Where the supports hold the linkage."""
    return [p.get_xy()[0].tolist() for p in scene._axes.patches if len(p.get_xy()) == 4]


def joints_of(scene) -> list:
    """Marks of pins and of the shaft."""
    wanted = ("white", JOINT["mec"])
    return [
        line
        for line in scene._axes.lines
        if line.get_marker() == "o" and line.get_markerfacecolor() in wanted
    ]


def legend_label(scene) -> str:
    (text,) = [
        text.get_text()
        for text in scene._axes.figure.legends[0].get_texts()
        if "enlarged" in text.get_text()
    ]
    return text


def frames_of(path: Path) -> list[np.ndarray]:
    with Image.open(path) as image:
        frames = []
        for number in range(image.n_frames):
            image.seek(number)
            frames.append(np.asarray(image.convert("RGB")).astype(int))
    return frames


def count_near(frame: np.ndarray, color: str) -> int:
    wanted = [int(color[start : start + 2], 16) for start in (1, 3, 5)]
    return int(np.sum(np.abs(frame - wanted).max(axis=-1) < 24))


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[tuple[int, int]]]:
    path = tmp_path_factory.mktemp("gif") / "run.gif"
    calls: list[tuple[int, int]] = []
    write_animation(response_dataset(samples=13), path, progress=lambda *call: calls.append(call))
    return path, calls


class TestGif:
    def test_one_frame_a_sample_without_the_repeated_first(self, written) -> None:
        path, calls = written
        frames = frames_of(path)
        assert len(frames) == 12
        assert calls == [(done, 12) for done in range(1, 13)]

    def test_loops_and_is_white_and_small(self, written) -> None:
        path, _ = written
        with Image.open(path) as image:
            assert image.info["loop"] == 0
            assert image.info["duration"] == 50
        assert path.stat().st_size < 3e6
        for frame in frames_of(path)[::5]:
            assert frame[0, 0].tolist() == frame[-1, -1].tolist() == [255, 255, 255]

    def test_linkage_moves_and_its_path_grows(self, written) -> None:
        frames = frames_of(written[0])
        blue, orange = SERIES_STYLES[0].color, SERIES_STYLES[1].color
        assert all(count_near(frame, blue) > 200 for frame in frames)
        assert count_near(frames[11], orange) > 3 * count_near(frames[2], orange) > 0
        assert np.abs(frames[7] - frames[8]).max() > 100

    def test_number_of_frames_is_bounded(self) -> None:
        for samples in (119, 121, 500, 1441):
            frames = EnlargedMotion.of(response_dataset(samples=samples), 1.0).frames
            assert 60 <= len(frames) <= 120
            assert len(set(np.diff(frames))) == 1
            assert frames[-1] == samples - 1

    def test_only_the_last_revolution(self) -> None:
        dataset = response_dataset(turns=2.5, samples=101)
        _, motion = scene_of(dataset)
        np.testing.assert_array_equal(motion.time, dataset["time"].values[60:])
        part = scene_of(response_dataset(turns=0.5))[1]
        assert part.frames[0] == 0


class TestPicture:
    @pytest.mark.parametrize("engine", [0, 1])
    def test_draws_the_stored_motion_enlarged(self, engine: int) -> None:
        dataset = response_dataset()
        scene, _ = scene_of(dataset, engine, 15.0)
        scene.picture(7)
        stored = dataset["displacement"].values[engine, 7]
        rigid = dataset["rigid_position"].values[7]
        for link in range(3):
            drawn = np.transpose(scene._deflected[link].get_data())
            np.testing.assert_allclose(drawn, rigid[link] + 15.0 * stored[link], rtol=1e-14)
            np.testing.assert_array_equal(np.transpose(scene._rigid[link].get_data()), rigid[link])
        assert legend_label(scene) == "displacement enlarged 15 times"

    def test_path_is_the_true_one_of_the_coupler_s_middle(self) -> None:
        """However much the displacements of the links are enlarged."""
        dataset = response_dataset()
        scene, _ = scene_of(dataset, enlargement=40.0)
        scene.picture(9)
        wanted = dataset["rigid_position"] + dataset["displacement"].isel(engine=1)
        wanted = wanted.sel(link="coupler").isel(station=10, time=slice(10))
        drawn = np.transpose(scene._trace.get_data())
        np.testing.assert_allclose(drawn, wanted.transpose("time", "component"), rtol=1e-14)
        np.testing.assert_array_equal(np.transpose(scene._point.get_data()), drawn[-1:])
        assert scene._trace.get_label() == "true path of the coupler's middle"

    def test_path_of_a_coupler_point_is_carried_by_the_line_of_the_pins(self) -> None:
        point = {"coupler_point_distance": 0.16, "coupler_point_angle": np.radians(35)}
        dataset = response_dataset().assign_attrs(point)
        # Both pins moved and the coupler turned: the point with them.
        dataset["displacement"][:, :, 1, -1] += np.array([2e-3, -3e-3])
        scene, _ = scene_of(dataset)
        scene.picture(9)
        drawn = np.transpose(scene._trace.get_data())
        places = (dataset["rigid_position"] + dataset["displacement"].isel(engine=1)).sel(
            link="coupler"
        )
        start, end = (places.isel(station=n, time=slice(10)).values for n in (0, -1))
        to_point, along = drawn - start, end - start
        np.testing.assert_allclose(np.hypot(*to_point.T), 0.16)
        turned = np.arctan2(*to_point.T[::-1]) - np.arctan2(*along.T[::-1])
        np.testing.assert_allclose(np.degrees(np.mod(turned, 2 * np.pi)), 35.0)
        assert scene._trace.get_label() == "true path of the coupler point"

    def test_time_and_angle_are_those_of_the_sample(self) -> None:
        scene, _ = scene_of(response_dataset())
        scene.picture(8)
        text = scene._clock.get_text().replace("\N{FIGURE SPACE}", " ")
        assert re.fullmatch(r"time 0\.0785 s +crank angle +90°", text)

    def test_default_enlargement_is_round_and_about_a_tenth(self) -> None:
        dataset = response_dataset()
        for factor, wanted in ((1.0, "20"), (0.1, "200"), (1e-3, "20\N{THIN SPACE}000"), (40, "1")):
            scaled = dataset.assign(displacement=factor * dataset["displacement"])
            scene, motion = scene_of(scaled)
            assert legend_label(scene) == f"displacement enlarged {wanted} times"
            if factor <= 1:
                greatest = motion.enlargement * 2 * GREATEST * factor
                assert 0.06 < greatest / extent_of(motion.rigid) < 0.17

    def test_nothing_to_enlarge(self) -> None:
        still = response_dataset()
        still["displacement"][:] = 0.0
        assert scene_of(still)[1].enlargement == 1.0

    def test_joints_and_supports(self) -> None:
        scene, motion = scene_of(response_dataset())
        scene.picture(5)
        pins = np.vstack([line.get_xydata() for line in joints_of(scene)])
        rigid = motion.rigid[5]
        wanted = [rigid[0, 0], rigid[0, -1], rigid[1, -1], rigid[2, 0]]
        np.testing.assert_allclose(
            sorted(pins.tolist()), sorted(np.array(wanted).tolist()), atol=1e-9
        )
        np.testing.assert_allclose(support_tips(scene), [[0.0, 0.0], [0.254, 0.0]], atol=1e-12)

    def test_arm_turns_on_its_shaft(self) -> None:
        scene, _ = scene_of(response_dataset(ARM))
        (disc,) = [p.get_xy() for p in scene._axes.patches if len(p.get_xy()) > 10]
        assert np.hypot(*disc.T) == pytest.approx(0.025)
        assert support_tips(scene) == [[0.0, 0.0]]
        assert scene._trace.get_label() == "true path of the arm's tip"

    @pytest.mark.parametrize("linkage", [FOURBAR, ARM])
    def test_nothing_leaves_the_picture(self, linkage: Linkage) -> None:
        scene, motion = scene_of(response_dataset(linkage))
        picture = scene.picture(0)
        assert picture.shape[0] % 2 == picture.shape[1] % 2 == 0
        figure = scene._axes.figure
        boxes = [text.get_window_extent() for text in shown_texts(figure)]
        assert len(boxes) >= 5
        for box in boxes:
            assert box.x0 >= 0
            assert box.y0 >= 0
            assert box.x1 <= figure.bbox.x1
            assert box.y1 <= figure.bbox.y1
        corners = scene._axes.transData.transform(motion.deflected.reshape(-1, 2))
        title = scene._clock.get_window_extent()
        assert corners[:, 1].max() < title.y0
        assert corners[:, 0].min() > 0
        assert corners[:, 1].min() > 0
        assert corners[:, 0].max() < figure.bbox.x1


class TestRequest:
    @pytest.mark.parametrize("enlargement", [0.0, -1.0, np.nan, np.inf])
    def test_enlargement_is_positive(self, tmp_path: Path, enlargement: float) -> None:
        with pytest.raises(InputError, match="positive"):
            write_animation(response_dataset(), tmp_path / "a.gif", enlargement=enlargement)

    def test_unknown_engine(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match=r"'abaqus'.*reference, exudyn"):
            write_animation(response_dataset(), tmp_path / "a.gif", engine="abaqus")

    def test_unknown_format(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match=r"\.gif or \.mp4"):
            write_animation(response_dataset(), tmp_path / "a.avi")

    def test_mp4_without_ffmpeg(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(animation, "mp4_available", lambda: False)
        with pytest.raises(InputError, match="ffmpeg"):
            write_animation(response_dataset(), tmp_path / "a.mp4")
        assert not list(tmp_path.iterdir())

    @pytest.mark.skipif(not mp4_available(), reason="needs ffmpeg")
    def test_mp4(self, tmp_path: Path) -> None:
        path = tmp_path / "a.mp4"
        write_animation(response_dataset(samples=9), path)
        assert path.read_bytes()[4:8] == b"ftyp"

    def test_engine_by_name(self, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
        titles: list[str] = []
        whole = animation._write_gif

        def keep(path: Path, pictures) -> None:
            whole(path, pictures)
            titles.append(motions[-1].run_name)

        motions: list = []
        of = EnlargedMotion.of
        monkeypatch.setattr(animation, "_write_gif", keep)
        monkeypatch.setattr(
            EnlargedMotion, "of", lambda *given: motions.append(of(*given)) or motions[-1]
        )
        for engine in (None, "reference"):
            write_animation(response_dataset(samples=4), tmp_path / "a.gif", engine=engine)
        assert "exudyn (ancf)" in titles[0]
        assert "reference (euler)" in titles[1]
