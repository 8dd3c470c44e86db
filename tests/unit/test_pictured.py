"""What pictures show beside the map: solutions between its angles, and shapes asked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from flexmech import InputError, Mechanism, MovingFrequencies, ReferenceEngine, moving_frequencies
from flexmech.analyses.frequencies import pictured
from flexmech.analyses.frequencies.formulation import Formulation
from flexmech.analyses.frequencies.frequency_map import systems_at
from flexmech.analyses.frequencies.pictured import SEEN, bent_angles
from flexmech.analyses.frequencies.positions import frequencies_at
from flexmech.analyses.frequencies.request import FrequencyRequest
from flexmech.arrays import FloatArray
from flexmech.cli import app
from flexmech.plots import plot_frequencies, plot_mode_shapes
from tests.support.figure_checks import check_layout, heading

TURN = np.radians(np.arange(0.0, 360.1, 5.0))
ALUMINIUM = str(Path(__file__).parents[2] / "models" / "aluminium_fourbar.toml")


def curves(angles: FloatArray) -> FloatArray:
    """Two speeds of two modes: one with narrow peaks, one that is straight; (2, n, 2)."""
    peaks = 50 + 1 / (1.02 - np.cos(angles[None, :] - np.array([[1.0], [4.0]])))
    return np.stack([peaks, np.broadcast_to(200 + angles, peaks.shape)], axis=-1)


def line_error(angles: FloatArray, values: FloatArray) -> FloatArray:
    """Greatest distance of lines from the curves over their range, by mode."""
    fine = np.linspace(TURN[0], TURN[-1], 20001)
    wanted = curves(fine)
    drawn = [
        [np.interp(fine, angles, values[s, :, m]) for m in range(2)] for s in range(len(values))
    ]
    off = np.abs(np.moveaxis(drawn, 1, 2) - wanted).max(axis=(0, 1))
    return np.asarray(off / np.ptp(wanted, axis=(0, 1)))


def test_lines_through_all_points_are_the_curve_to_the_eye() -> None:
    grid = curves(TURN)
    added, values = bent_angles(curves, TURN, grid, full_turn=True)
    np.testing.assert_array_equal(values, curves(added))
    assert np.all(np.diff(added) > 0)
    assert not np.isin(added, TURN).any()
    whole = np.argsort(np.append(TURN, added))
    lines = np.append(TURN, added)[whole], np.concatenate([grid, values], axis=1)[:, whole]
    assert line_error(TURN, grid)[0] > 10 * SEEN
    assert line_error(*lines)[0] < 1.2 * SEEN
    # Where the lines are straight nothing is added.
    flat = (np.abs(added[:, None] - [1.0, 4.0]) > 1.0).all(axis=1)
    assert flat.sum() == 0


def test_straight_lines_coarse_maps_and_two_angles_get_no_points() -> None:
    def refused(angles: FloatArray) -> FloatArray:
        raise AssertionError(f"solved at {angles}")

    straight = np.broadcast_to(100 + TURN[:, None], (1, len(TURN), 1))
    coarse = np.radians([0.0, 30.0, 60.0, 90.0])
    for angles, values in (
        (TURN, straight),
        (coarse, curves(coarse)),
        (TURN[:2], curves(TURN[:2])),
    ):
        added, found = bent_angles(refused, angles, values, full_turn=False)
        assert added.size == found.shape[1] == 0


@pytest.fixture(scope="module")
def engine(aluminium: Mechanism) -> ReferenceEngine:
    return ReferenceEngine(aluminium, elements=2)


@pytest.fixture(scope="module")
def found(engine: ReferenceEngine) -> MovingFrequencies:
    shapes = np.radians([45.0, 77.5])
    return moving_frequencies(engine, TURN, [0.0, 20.0], shapes_at=shapes, smooth=True)


def test_every_point_between_is_a_solution(
    engine: ReferenceEngine, found: MovingFrequencies
) -> None:
    data = found.dataset
    some = data.isel(between_angle=slice(None, None, 7))
    wanted = frequencies_at(engine, some["between_angle"].values, 20.0, Formulation())
    np.testing.assert_allclose(some["frequency_between"].sel(crank_speed=20.0), wanted, rtol=1e-9)
    # The branch is that of the angles on both sides, where these have the same.
    after = np.searchsorted(TURN, data["between_angle"].values)
    branch = data["branch_of_mode"].isel(engine=0).values
    between = data["branch_between"].values
    known = between > 0
    np.testing.assert_array_equal(between[known], branch[:, after][known])
    np.testing.assert_array_equal(known, branch[:, after] == branch[:, after - 1])
    assert known.mean() > 0.9


def test_no_branch_is_told_where_modes_change_theirs_within_the_step(
    engine: ReferenceEngine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        pictured, "frequencies_along", lambda systems, angles, speed: curves(angles)[0]
    )
    angles = np.radians([2.5, 12.5, 17.5])
    request = FrequencyRequest(TURN, np.zeros(1), Formulation(modes=2), smooth=angles)
    over = ("crank_speed", "crank_angle", "mode")
    branch = np.where(np.arange(len(TURN))[:, None] < 3, [1, 2], [2, 1])
    maps = {"frequency": (over, curves(TURN)[:1]), "branch_of_mode": (over, branch[None])}
    found = pictured.drawn_between((systems_at(engine, request, 0.0),), request, xr.Dataset(maps))
    assert found["branch_between"].values.tolist() == [[[1, 2], [0, 0], [2, 1]]]
    np.testing.assert_array_equal(found["frequency_between"], curves(angles)[:1])


def test_lines_run_through_the_points_between(found: MovingFrequencies) -> None:
    data = found.dataset.isel(mode=slice(2, 3))
    (axes,) = plot_frequencies(data).axes
    between, values = data["between_angle"].values, data["frequency_between"].values[..., 0]
    assert len(axes.lines) == 2
    for line, on_grid, added in zip(axes.lines, data["frequency"][0, ..., 0], values, strict=True):
        order = np.argsort(np.append(TURN, between))
        np.testing.assert_allclose(
            line.get_xdata(), np.degrees(np.append(TURN, between)[order]), atol=1e-8
        )
        np.testing.assert_array_equal(line.get_ydata(), np.append(on_grid, added)[order])


def test_shapes_asked_for_are_those_of_the_map(
    engine: ReferenceEngine, found: MovingFrequencies
) -> None:
    data = found.dataset
    shown = np.degrees(data["shape_angle"].values).tolist()
    assert shown == pytest.approx([45.0, 77.5])
    wanted = frequencies_at(engine, data["shape_angle"].values, 20.0, Formulation())
    np.testing.assert_allclose(data["asked_frequency"].sel(crank_speed=20.0), wanted, rtol=1e-6)
    with_check = moving_frequencies(engine, TURN[9:10], [20.0]).dataset
    one, other = (
        array.sel(part="real").values + 1j * array.sel(part="imaginary").values
        for array in (
            data["asked_shape"].sel(crank_speed=20.0).isel(shape_angle=0),
            with_check["mode_shape"].isel(engine=0, crank_speed=0, check_angle=0),
        )
    )
    for asked, stored in zip(one, other, strict=True):
        overlap = abs(np.vdot(asked, stored)) / np.linalg.norm(asked) / np.linalg.norm(stored)
        assert overlap == pytest.approx(1.0, abs=1e-4)


def test_a_picture_for_each_angle_asked_for(found: MovingFrequencies) -> None:
    names = [name for name in found.figures() if "shapes" in name]
    assert names == ["mode_shapes_45", "mode_shapes_77.5"]
    figure = plot_mode_shapes(found.dataset, shape_angle=np.radians(77.5))
    assert "crank angle 77.5°" in heading(figure)
    wanted = found.dataset["asked_frequency"].isel(shape_angle=1, mode=0).values
    texts = " / ".join(f"{value:.2f}" for value in wanted)
    assert figure.axes[0].get_title("center") == f"Mode 1\n{texts} Hz"
    rigid = [line for line in figure.axes[0].lines if line.get_color() == "0.65"]
    for line, link in zip(rigid, found.dataset["asked_position"][1], strict=True):
        np.testing.assert_array_equal(np.transpose(line.get_data()), link)
    check_layout(figure)


def test_results_with_points_between_load_as_they_are(
    found: MovingFrequencies, tmp_path: Path
) -> None:
    found.save(tmp_path)
    loaded = MovingFrequencies.load(tmp_path / "frequencies.nc")
    assert loaded.dataset.identical(found.dataset)


def test_shapes_at_angles_that_cannot_be_are_refused(engine: ReferenceEngine) -> None:
    with pytest.raises(InputError, match="shapes_at"):
        moving_frequencies(engine, TURN[:1], [0.0], shapes_at=[77.5, 3000.0])
    with pytest.raises(InputError, match="shapes_at must be a list of 72"):
        moving_frequencies(engine, TURN[:1], [0.0], shapes_at=np.linspace(0, 1, 73))


def test_the_command_names_the_option() -> None:
    done = CliRunner().invoke(app, ["frequencies", ALUMINIUM, "--shapes-at", "30,10"])
    assert done.exit_code == 2
    assert done.stderr.startswith("error: --shapes-at: got '30,10', in which 10 follows 30")
