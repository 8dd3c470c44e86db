"""A moving picture holds a frame a sample of the last turn, and ends as it began."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from PIL import Image

from flexmech import InputError, plots
from tests.support.results import response

BLUE, ORANGE = (style.color for style in plots.SERIES_STYLES[:2])


def one_turn(samples: int) -> xr.Dataset:
    """The last turn of a run, with so many samples."""
    data = response().dataset
    return data.isel(
        time=np.linspace(data.sizes["time"] // 2, data.sizes["time"] - 1, samples, dtype=int)
    )


def frames_of(path: Path) -> list[np.ndarray]:
    with Image.open(path) as image:
        frames = []
        for number in range(image.n_frames):
            image.seek(number)
            frames.append(np.asarray(image.convert("RGB")).astype(int))
        assert image.info["loop"] == 0
    return frames


def count_near(frame: np.ndarray, color: str) -> int:
    wanted = [int(color[start : start + 2], 16) for start in (1, 3, 5)]
    return int(np.sum(np.abs(frame - wanted).max(axis=-1) < 24))


@pytest.mark.thorough
def test_the_linkage_moves_and_its_path_grows(tmp_path: Path) -> None:
    """The last of 9 samples repeats the first and is left out: 8 frames on white."""
    calls: list[tuple[int, int]] = []
    path = tmp_path / "run.gif"
    plots.write_animation(one_turn(9), path, progress=lambda *call: calls.append(call))
    frames = frames_of(path)
    assert calls == [(done, 8) for done in range(1, 9)]
    assert len(frames) == 8
    assert all(frame[0, 0].tolist() == frame[-1, -1].tolist() == [255] * 3 for frame in frames)
    assert all(count_near(frame, BLUE) > 200 for frame in frames)
    assert count_near(frames[7], ORANGE) > 2 * count_near(frames[2], ORANGE) > 0
    assert np.abs(frames[3] - frames[4]).max() > 100


def test_only_the_last_turn_is_shown_with_at_most_120_frames(tmp_path: Path) -> None:
    calls: list[tuple[int, int]] = []
    whole = response().dataset
    assert whole.sizes["time"] == 241, "two turns of 120 samples"

    def stop(*call: int) -> None:
        """End with the first frame, which says how many there will be."""
        calls.append(call)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        plots.write_animation(whole, tmp_path / "run.gif", progress=stop)
    assert calls == [(1, 120)]


def test_displacements_can_be_enlarged_until_they_are_seen(tmp_path: Path) -> None:
    pictures = []
    for number, enlargement in enumerate((1.0, 200.0)):
        path = tmp_path / f"{number}.gif"
        plots.write_animation(one_turn(3), path, engine="reference", enlargement=enlargement)
        pictures.append(frames_of(path)[0])
    assert np.abs(pictures[0] - pictures[1]).max() > 100
    # Links that are hardly bent cover the rigid ones, which are grey.
    greys = [np.sum(np.ptp(picture, axis=-1) < 8) for picture in pictures]
    assert greys[0] != greys[1]


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("a.avi", {}, r"\.gif or \.mp4"),
        ("a.gif", {"enlargement": -1.0}, "positive"),
        ("a.gif", {"engine": "abaqus"}, r"'abaqus'.*reference, exudyn"),
    ],
)
def test_what_cannot_be_drawn_is_refused_and_leaves_no_file(
    name: str, options: dict[str, object], words: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words):
        plots.write_animation(one_turn(3), tmp_path / name, **options)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not plots.mp4_available(), reason="needs ffmpeg")
def test_an_mp4_is_a_file_of_that_format(tmp_path: Path) -> None:
    plots.write_animation(one_turn(3), tmp_path / "a.mp4")
    assert (tmp_path / "a.mp4").read_bytes()[4:8] == b"ftyp"
