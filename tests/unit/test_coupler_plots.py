"""Pictures of coupler curves and moisture show what they are given, with units, unclipped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech.errors import InputError
from flexmech.plots import (
    DrawnMoisture,
    DrawnPath,
    plot_coupler_angles,
    plot_coupler_curve,
    plot_moisture,
)
from tests.unit.figure_checks import (
    HALF_WIDTH_PANEL,
    check_layout,
    drawn,
    legend_texts,
    panels,
    y_labels,
)

BLUE, ORANGE = "#0072B2", "#D55E00"
TURN = np.linspace(0.0, 2 * np.pi, 61)
EIGHT = np.stack([np.sin(2 * TURN), np.sin(TURN)], axis=1)


def path(size: float = 0.1, *, looped: bool = True, turns: int = 0) -> DrawnPath:
    pins = size * np.stack([np.cos(TURN), np.sin(TURN)], axis=1)
    angles = np.stack([0.3 * np.sin(TURN), 1 + 0.2 * np.cos(TURN)], axis=1) + 2 * np.pi * turns
    return DrawnPath(
        TURN,
        size * EIGHT,
        np.stack([pins, 2 * pins], axis=1),
        angles,
        (("crunode", np.zeros(2)), ("cusp", size * EIGHT[10])) if looped else (),
        (size * EIGHT[25:36],) if looped else (),
        size * EIGHT[28:33] if looped else np.zeros((0, 2)),
    )


def moisture(laws: bool = True) -> DrawnMoisture:
    place = np.linspace(-1e-3, 1e-3, 21)
    time = 86400 * np.linspace(0, 4, 30)
    profile = np.stack([0.05 * (place / 1e-3) ** n for n in (8, 2)])
    uptake = 1 - np.exp(-time / 86400)
    law = (np.sqrt(time / 86400), uptake) if laws else (None, None)
    return DrawnMoisture(place, 86400 * np.array([0.5, 4.0]), profile, time, uptake, *law)


@pytest.mark.parametrize(("size", "unit", "scale"), [(0.1, "mm", 1e3), (30.0, "m", 1.0)])
def test_curves_in_a_unit_of_their_size(size: float, unit: str, scale: float) -> None:
    figure = plot_coupler_curve({"dry": path(size)}, "Coupler curve")
    first = panels(figure)[0]
    assert first.get_xlabel() == f"x ({unit})"
    assert first.get_aspect() == 1.0
    assert np.ptp(first.lines[0].get_xdata()) == pytest.approx(scale * np.ptp(size * EIGHT[:, 0]))


def test_double_points_are_counted_and_marked() -> None:
    figure = plot_coupler_curve({"dry": path(), "+80 K": path(0.11, looped=False)}, "Curves")
    assert legend_texts(figure)[:2] == [
        "dry: 1 crunode, 1 cusp",
        "+80 K: 0 crunodes, 0 cusps",
    ]
    assert {"crunode", "cusp"} <= set(legend_texts(figure))
    titles = [axes.get_title(loc="left") for axes in panels(figure)]
    assert titles == ["Coupler point", "Close-up of the loops", "Pins A and B"]
    check_layout(figure, HALF_WIDTH_PANEL)


def test_no_loops_no_close_up() -> None:
    figure = plot_coupler_curve({"dry": path(looped=False)}, "Curve")
    assert len(panels(figure)) == 2
    check_layout(figure, HALF_WIDTH_PANEL)


def test_few_angles_are_marked_and_marks_beyond_them_are_told() -> None:
    whole = path()
    part = DrawnPath(
        TURN[:1],
        whole.position[:1],
        whole.pins[:1],
        whole.angles[:1],
        whole.double_points,
        whole.close_up,
        whole.framed,
    )
    figure = plot_coupler_curve({"dry": part}, "Coupler curve at one angle")
    assert legend_texts(figure)[1:] == ["crunode of the whole curve", "cusp of the whole curve"]
    curve, close_up, _ = panels(figure)
    assert curve.lines[0].get_marker() == "o"
    assert close_up.lines[0].get_marker() == "None"
    check_layout(figure, HALF_WIDTH_PANEL)
    angles = plot_coupler_angles({"dry": part, "wet": part}, "Angles at one angle")
    assert all(axes.lines[0].get_marker() == "o" for axes in panels(angles)[:2])
    check_layout(angles, HALF_WIDTH_PANEL)
    assert plot_coupler_curve({"dry": whole}).axes[0].lines[0].get_marker() == "None"


def test_change_of_angles_leaves_whole_turns_out() -> None:
    figure = plot_coupler_angles({"dry": path(), "wet": path(turns=1)}, "Angles")
    assert y_labels(figure)[2:] == [r"Change of $\theta_3$ (deg)", r"Change of $\theta_4$ (deg)"]
    change = drawn(panels(figure)[2], ORANGE)
    assert np.abs(change).max() < 1e-9
    check_layout(figure, HALF_WIDTH_PANEL)


def test_angles_of_one_state() -> None:
    figure = plot_coupler_angles({"dry": path()}, "Angles")
    assert len(panels(figure)) == 2
    check_layout(figure, HALF_WIDTH_PANEL)


def test_moisture_of_links() -> None:
    figure = plot_moisture({"coupler": moisture(), "rocker": moisture(laws=False)}, "85 %, 80 °C")
    profiles = panels(figure)[0]
    assert profiles.get_ylabel() == "Moisture of the resin (%)"
    assert profiles.lines[0].get_ydata().max() == pytest.approx(5.0)
    assert panels(figure)[-1].get_xlabel() == r"Root of time ($\sqrt{\mathrm{day}}$)"
    assert legend_texts(figure) == [
        "0.5 d",
        "4 d",
        "finite volumes",
        "root of time",
        "Shen & Springer",
    ]
    check_layout(figure, HALF_WIDTH_PANEL)


@pytest.mark.parametrize(
    ("day", "labels", "root"),
    [
        (1, ["0.5 d", "4 d"], "day"),
        (1 / 24, ["0.5 h", "4 h"], "hour"),
        (300, ["150 d", "1200 d"], "day"),
    ],
)
def test_time_in_a_unit_of_its_size(day: float, labels: list[str], root: str) -> None:
    link = moisture()
    scaled = replace(
        link, time=day * link.time, profile_time=day * link.profile_time, over_width=True
    )
    figure = plot_moisture({"coupler": scaled}, "85 %")
    assert legend_texts(figure)[:2] == labels
    profile, uptake = panels(figure)
    assert uptake.get_xlabel() == rf"Root of time ($\sqrt{{\mathrm{{{root}}}}}$)"
    assert profile.get_title(loc="left") == "Coupler: mean over the width"
    check_layout(figure, HALF_WIDTH_PANEL)


def test_nothing_to_draw() -> None:
    for plot in (plot_coupler_curve, plot_coupler_angles, plot_moisture):
        with pytest.raises(InputError):
            plot({})
