"""Pictures of a mechanism: what is drawn is the dataset, to scale, and nothing is cut off."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patches import Polygon, Rectangle

from flexmech.linkages import FourBar
from flexmech.plots import SERIES_STYLES, page_width, plot_mechanism
from flexmech.plots.drawn_linkage.sketch import JOINT, WELD
from tests.support.figure_checks import check_layout, legend_texts, panels
from tests.support.plot_data import ARM, mechanism_dataset

FOLDED = FourBar(ground=0.05, crank=0.1, coupler=0.11, rocker=0.1)


@pytest.fixture(scope="module")
def dataset() -> xr.Dataset:
    return mechanism_dataset()


def rectangles(axes: Axes) -> list[Rectangle]:
    return [patch for patch in axes.patches if isinstance(patch, Rectangle)]


def test_links_are_as_thick_as_they_are(dataset: xr.Dataset) -> None:
    posture = plot_mechanism(dataset).axes[0]
    bars = [p for p in posture.patches if isinstance(p, Polygon) and len(p.get_xy()) == 5]
    assert len(bars) == 3
    for bar, link, thickness in zip(
        bars, dataset["rigid_position"].values, dataset["in_plane_thickness"].values, strict=True
    ):
        corners = bar.get_xy()[:4]
        sides = np.hypot(*np.diff(corners, axis=0).T)
        np.testing.assert_allclose(sides, [np.hypot(*(link[-1] - link[0])), thickness, sides[0]])
        np.testing.assert_allclose(corners.mean(axis=0), link[[0, -1]].mean(axis=0))


def test_paths_are_the_dataset_s_and_the_point_is_on_the_coupler(dataset: xr.Dataset) -> None:
    posture = plot_mechanism(dataset).axes[0]
    drawn = [line.get_xydata() for line in posture.lines]
    for path in dataset["path"].values:
        assert any(np.array_equal(line, path) for line in drawn if len(line) == len(path))
    assert [name for name in legend_texts(plot_mechanism(dataset)) if "path" in name] == [
        "paths of A and B",
        "path of the coupler point",
    ]
    triangles = [p.get_xy() for p in posture.patches if len(p.get_path().vertices) == 4]
    coupler, point = dataset["rigid_position"].values[1], dataset["path_position"].values[2]
    assert any(np.allclose(t[:3], [coupler[0], coupler[-1], point]) for t in triangles)


def test_discs_have_areas_as_the_masses_and_small_ones_are_seen(dataset: xr.Dataset) -> None:
    posture = plot_mechanism(dataset).axes[0]
    discs = [line for line in posture.lines if line.get_color() == SERIES_STYLES[1].color]
    areas = np.array([disc.get_markersize() for disc in discs]) ** 2
    # A quarter would be hidden by the circle of the pin.
    np.testing.assert_allclose(areas / areas[0], [1.0, 64 / 144, 0.5])
    assert np.sqrt(areas.min()) > 2.0 * JOINT["ms"]
    assert np.sqrt(areas.min()) > 1.5 * WELD["ms"]
    np.testing.assert_allclose(
        np.vstack([disc.get_xydata() for disc in discs]),
        [*dataset["joint_position"].values[1:3], dataset["point_mass_position"].values[0]],
    )
    assert "point mass (largest 40 g)" in legend_texts(plot_mechanism(dataset))


def test_sections_have_one_scale_and_their_layers(dataset: xr.Dataset) -> None:
    sections = plot_mechanism(dataset).axes[1]
    assert sections.get_aspect() == 1.0
    frames = [patch for patch in rectangles(sections) if patch.get_facecolor()[3] == 0]
    assert [patch.get_height() for patch in frames] == pytest.approx([10.0, 8.0, 6.0])
    assert [patch.get_width() for patch in frames[:2]] == pytest.approx([20.0, 25.0])
    assert frames[2].get_linestyle() not in ("-", "solid")
    layers = [patch for patch in rectangles(sections) if patch.get_facecolor()[3] > 0]
    assert [patch.get_height() for patch in layers] == pytest.approx([2.5] * 4 + [2.0] * 4 + [6.0])
    # From the lowest up: in the crank carbon, carbon, glass, carbon.
    greys = [patch.get_facecolor()[0] for patch in layers[:4]]
    assert greys[0] == greys[1] == greys[3] != greys[2]
    bottoms = [patch.get_y() for patch in layers[:4]]
    assert bottoms == sorted(bottoms)
    assert [text.get_text() for text in sections.texts] == [
        "Crank\n10 mm thick, 20 mm wide\n[C*2/G/C]",
        "Coupler\n8 mm thick, 25 mm wide\n[C*2/G*2]",
        "Rocker\n6 mm thick, width not stated",
        "20 mm",
    ]
    bar = sections.lines[0].get_xdata()
    assert bar[1] - bar[0] == pytest.approx(20.0)


def test_transmission_angle_with_the_usual_range_and_the_posture(dataset: xr.Dataset) -> None:
    axes = plot_mechanism(dataset).axes[2]
    curve = next(line for line in axes.lines if len(line.get_xdata()) == 73)
    np.testing.assert_allclose(curve.get_ydata(), np.degrees(dataset["transmission_angle"]))
    assert axes.get_title("left") == "Transmission angle 32.2° to 81.3°"
    (mark,) = [line for line in axes.lines if line.get_marker() == "o"]
    assert mark.get_xdata() == pytest.approx([60.0])
    (band,) = axes.patches
    assert (band.get_y(), band.get_height()) == (40.0, 100.0)


def test_an_arm_has_no_transmission_angle() -> None:
    figure = plot_mechanism(mechanism_dataset(ARM))
    assert len(panels(figure)) == 2
    assert legend_texts(figure)[0] == "path of the tip"
    check_layout(figure)


@pytest.mark.parametrize("millimetres", [88.0, 180.0])
def test_layout(millimetres: float) -> None:
    """Of linkages whose links lie on each other, and of a stack that is too long to be written."""
    long = mechanism_dataset()
    long["stacking"] = ("link", ["[" + "/".join(["carbon@45"] * 40) + "]", "", ""])
    with page_width(millimetres):
        for dataset in (mechanism_dataset(FOLDED, 90.0), long):
            check_layout(plot_mechanism(dataset))


def test_a_curve_ends_where_the_linkage_cannot_stand(dataset: xr.Dataset) -> None:
    swinging = dataset.copy(deep=True)
    swinging["transmission_angle"][20:40] = np.nan
    swinging["path"][:, 20:40] = np.nan
    figure = plot_mechanism(swinging)
    check_layout(figure)
    curve = next(line for line in figure.axes[2].lines if len(line.get_xdata()) == 73)
    assert np.isnan(curve.get_ydata()[20:40]).all()


def test_sections_stand_beside_a_posture_without_a_transmission_angle() -> None:
    """Below it they would leave half the page empty; on a narrow page they stay below."""
    dataset = mechanism_dataset(ARM)
    figure = plot_mechanism(dataset)
    figure.draw_without_rendering()
    posture, sections = (axes.get_position() for axes in figure.axes)
    assert sections.x0 >= posture.x1
    assert 0.3 < sections.width < 0.4
    with page_width(88.0):
        narrow = plot_mechanism(dataset)
        narrow.draw_without_rendering()
        posture, sections = (axes.get_position() for axes in narrow.axes)
        assert sections.y1 <= posture.y0
        check_layout(narrow)


def test_a_posture_that_is_not_flat_fills_the_height_beside_the_rest(dataset: xr.Dataset) -> None:
    figure = plot_mechanism(dataset)
    check_layout(figure)
    posture, sections, angle = (axes.get_position() for axes in figure.axes)
    assert min(sections.x0, angle.x0) >= posture.x1 - 0.02
    assert sections.y0 > angle.y1
    # At one scale along x and y, so that what the linkage covers is what its axes cover.
    assert posture.height > 0.7
    flat = dataset.copy(deep=True)
    for name in ("path", "rigid_position", "joint_position"):
        flat[name] = flat[name] * xr.DataArray([1.0, 0.2], dims="component")
    flat = flat.assign_attrs(drawing=flat.attrs["drawing"])
    figure = plot_mechanism(flat)
    check_layout(figure)
    posture, sections, angle = (axes.get_position() for axes in figure.axes)
    assert posture.y0 > max(sections.y1, angle.y1)
