"""Pictures of the motion of points: what is drawn is the dataset, and nothing is cut off."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import KinematicsRequest, kinematics, load_mechanism
from flexmech.example_models import example_model
from flexmech.plots import drawn_points, page_width, plot_motion
from flexmech.plots.motion import motion_lines
from tests.support.figure_checks import check_layout, legend_texts

TURN = np.radians(np.arange(0.0, 361.0, 5.0))


def dataset_of(name: str):
    return kinematics(load_mechanism(example_model(name)), KinematicsRequest(TURN, 20.0)).dataset


def test_a_slider_is_drawn_along_its_line_and_the_end_of_the_crank_not_at_all() -> None:
    data = dataset_of("carton_pusher")
    assert drawn_points(data) == ["E", "B", "D"]
    figure = plot_motion(data)
    assert legend_texts(figure) == ["along x", "along y", "along its line"]
    panels = figure.axes
    assert [axes.get_title("left") or axes.get_title() for axes in panels[:3]] == ["E", "B", "D"]
    (position,) = panels[0].get_lines()
    assert position.get_ydata() == pytest.approx(1e3 * data["slider_position"].values[:, 0])
    of_d = data["point_acceleration"].sel(point="D", component="y").values
    assert panels[8].get_lines()[2].get_ydata() == pytest.approx(of_d)


def test_a_coupler_point_comes_before_pins() -> None:
    data = dataset_of("neat_resin_figure_8")
    assert drawn_points(data) == ["coupler point", "B"]
    lines = motion_lines(data, drawn_points(data))
    assert [(line.point, line.along) for line in lines[:2]] == [
        ("coupler point", "x"),
        ("coupler point", "y"),
    ]


@pytest.mark.parametrize("millimetres", [88.0, 180.0])
def test_layout(millimetres: float) -> None:
    with page_width(millimetres):
        for name in ("slider_crank", "carton_pusher", "watt_six_bar"):
            check_layout(plot_motion(dataset_of(name)))
