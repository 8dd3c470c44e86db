"""Pictures of linkages are to scale: links, joints, paths, springs, and enlarged shapes."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

import flexmech
from flexmech import plots
from tests.support import results
from tests.support.figure_checks import check_layout, legend_texts, panels
from tests.support.figures import data_of, figure_of

FIRST, SECOND = (style.color for style in plots.SERIES_STYLES[:2])


def has_line(axes: Axes, points: np.ndarray) -> bool:
    """Whether one of the lines runs through points, in either sense."""
    lines = [np.asarray(line.get_xydata(), dtype=float) for line in axes.lines]
    return any(
        line.shape == points.shape
        and (np.allclose(line, points) or np.allclose(line[::-1], points))
        for line in lines
    )


def test_links_of_a_mechanism_are_as_long_and_thick_as_they_are() -> None:
    data, posture = data_of(plots.plot_mechanism), figure_of(plots.plot_mechanism).axes[0]
    bars = [p for p in posture.patches if isinstance(p, Polygon) and len(p.get_xy()) == 5]
    thickness = data["in_plane_thickness"].values
    assert posture.get_aspect() == 1.0
    for bar, link, height in zip(bars, data["rigid_position"].values, thickness, strict=True):
        corners = bar.get_xy()[:4]
        sides = np.hypot(*np.diff(corners, axis=0).T)
        length = np.hypot(*(link[-1] - link[0]))
        np.testing.assert_allclose(sides, [length, height, length])
        np.testing.assert_allclose(corners.mean(axis=0), link[[0, -1]].mean(axis=0))
    for path in data["path"].values:
        assert has_line(posture, path)


def test_sections_of_a_mechanism_have_one_scale_in_millimetres() -> None:
    data, sections = data_of(plots.plot_mechanism), figure_of(plots.plot_mechanism).axes[1]
    frames = [
        patch
        for patch in sections.patches
        if isinstance(patch, Rectangle) and patch.get_facecolor()[3] == 0
    ]
    heights = [patch.get_height() for patch in frames]
    assert sections.get_aspect() == 1.0
    assert heights == pytest.approx((1e3 * data["in_plane_thickness"]).values.tolist())
    assert [patch.get_width() for patch in frames] == pytest.approx([25.4] * 3)


def test_a_linkage_stands_on_its_joints() -> None:
    data, (axes,) = data_of(plots.plot_linkage), figure_of(plots.plot_linkage).axes
    assert [text.get_text() for text in axes.texts] == ["100 mm", "O2", "A", "B", "O4"]
    places = data["joint_position"].sel(joint=["O2", "A", "B", "O4"]).values
    circles = np.vstack([line.get_xydata() for line in axes.lines if line.get_marker() == "o"])
    np.testing.assert_allclose(sorted(circles.tolist()), sorted(places.tolist()), atol=1e-12)
    tips = [patch.get_xy()[0] for patch in axes.patches if len(patch.get_xy()) == 4]
    np.testing.assert_allclose(tips, places[[0, 3]], atol=1e-12)


def test_a_drawing_shows_sliders_springs_masses_loads_and_gravity() -> None:
    """The carton pusher: block and wall where they are, and a legend of all that is attached."""
    pusher = flexmech.load_mechanism(flexmech.example_model("carton_pusher"))
    check = flexmech.check_mechanism(flexmech.ReferenceEngine(pusher, 2))
    figure = check.plot()
    assert isinstance(figure, Figure)
    check_layout(figure)
    axes = figure.axes[0]
    motion = flexmech.kinematics(pusher, 1.0, crank_angles=[np.radians(60.0)])
    # The block of the slider around E.
    slider = motion.dataset["point_position"].sel(point="E").values.ravel()
    blocks = [patch.get_xy()[:4].mean(axis=0) for patch in axes.patches if len(patch.get_xy()) == 5]
    assert any(np.allclose(block, slider, atol=1e-6) for block in blocks)
    # The spring ends at the wall at x = 0.8 m.
    assert any(np.allclose(line.get_xydata()[-1], [0.8, 0.38], atol=1e-4) for line in axes.lines)
    texts = legend_texts(figure)
    for word in ("point mass (largest 600 g)", "spring", "torsional damper", "gravity (9.81 m/s²)"):
        assert word in texts
    assert any(text.startswith("load over the crank angle") for text in texts)


def test_mode_shapes_are_enlarged_along_the_stored_shape_beside_the_rigid_linkage() -> None:
    data = data_of(plots.plot_mode_shapes)
    axes = panels(figure_of(plots.plot_mode_shapes))[1]
    rigid = data["rigid_position"][0].values
    assert all(has_line(axes, link) for link in rigid)
    bent = [
        np.asarray(line.get_xydata())[:: (len(line.get_xdata()) - 1) // (len(rigid[0]) - 1)]
        for line in axes.lines
        if line.get_color() == FIRST and len(line.get_xdata()) > len(rigid[0])
    ]
    moved = np.array(bent) - rigid
    stored = data["mode_shape"].isel(engine=0, crank_speed=0, check_angle=0, mode=1)
    stored = stored.sel(part="real").values
    cosine = np.sum(moved * stored) / np.linalg.norm(moved) / np.linalg.norm(stored)
    assert abs(cosine) == pytest.approx(1.0, abs=1e-6)
    assert axes.get_aspect() == 1.0
    first = data["frequency"].isel(engine=0, mode=1, crank_angle=0).values
    title = " / ".join(f"{value:.4g}" for value in first)
    assert axes.get_title("center") == f"Mode 2\n{title} Hz"


def test_the_coupler_curve_its_close_up_and_its_double_points_are_in_millimetres() -> None:
    data = data_of(plots.plot_coupler_curve)
    curve, close_up, pins = panels(figure_of(plots.plot_coupler_curve))
    for state in range(data.sizes["state"]):
        assert has_line(curve, 1e3 * data["position"].values[state])
    assert has_line(close_up, 1e3 * data["close_up"].values[0, 0])
    assert has_line(pins, 1e3 * data["pin_position"].transpose("state", "pin", ...).values[0, 0])
    marks = [line.get_xydata()[0] for line in curve.lines if len(line.get_xdata()) == 1]
    np.testing.assert_allclose(marks, 1e3 * data["double_point_position"].values)
    assert curve.get_aspect() == 1.0
    assert legend_texts(figure_of(plots.plot_coupler_curve))[0] == "dry: 1 crunode, 0 cusps"


def test_balance_draws_the_counterweights_on_the_linkage() -> None:
    data, axes = data_of(plots.plot_balance), panels(figure_of(plots.plot_balance))[0]
    masses = [f"{1e3 * mass:.4g} g" for mass in data["counterweight_mass"].values if mass]
    assert [text.get_text() for text in axes.texts] == masses
    places = np.array([text.xy for text in axes.texts])
    pivots = np.array([line.get_xydata()[0] for line in axes.lines if line.get_color() == SECOND])
    away = np.hypot(*(places - pivots[: 2 * len(places) : 2]).T)
    np.testing.assert_allclose(away, data["counterweight_radius"].values[: len(away)])


def test_strength_marks_the_worst_places_with_their_load_factors() -> None:
    data, (axes, along) = data_of(plots.plot_strength), panels(figure_of(plots.plot_strength))
    factors, parts = data["margin_load_factor"].values, data["margin_part"].values.tolist()
    modes = data["margin_mode"].values
    told = [f"{f:.3g}: {mode} at " for f, mode in zip(factors, modes, strict=True)]
    texts = [text.get_text() for text in axes.texts]
    assert [text[: len(words)] for text, words in zip(texts, told, strict=True)] == told
    assert [label.get_text() for label in axes.get_yticklabels()] == parts
    dots = [line.get_xydata()[0] for line in axes.lines if line.get_marker() == "o"]
    np.testing.assert_allclose(dots, np.stack([100 / factors, [1, 2, 3]], axis=-1))
    most = {line.get_color(): np.nanmax(line.get_ydata()) for line in along.lines}
    links = data["link"].values.tolist()
    for part, factor in zip(parts, factors, strict=True):
        color = plots.SERIES_STYLES[links.index(part)].color
        assert most[color] == pytest.approx(100 / factor)


def test_points_with_a_guide_move_along_it_and_a_crank_pin_is_not_drawn() -> None:
    pusher = flexmech.load_mechanism(flexmech.example_model("carton_pusher"))
    data = flexmech.kinematics(pusher, 20.0, crank_angles=results.TURN).dataset
    assert plots.drawn_points(data) == ["E", "B", "D"]
    figure = plots.plot_motion(data)
    assert sorted(legend_texts(figure)) == ["along its line", "along x", "along y"]
    (along,) = figure.axes[0].get_lines()
    np.testing.assert_allclose(along.get_ydata(), 1e3 * data["slider_position"].values[:, 0])
