"""The picture of margins: its scale ends where parts fail, and every judged part is marked."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

import flexmech
from flexmech.plots import page_width, plot_internal_forces, plot_strength
from flexmech.plots.strength import COLOURS, NOT_JUDGED, WIDE
from tests.support.figure_checks import check_texts, legend_texts, panels
from tests.support.strength_data import composite


@pytest.fixture(scope="module")
def strong() -> xr.Dataset:
    """Far from failure."""
    return flexmech.strength(composite(), 950.0, speed_unit="rpm").dataset


def with_margins(data: xr.Dataset, rows: list[tuple[str, str, float, float]]) -> xr.Dataset:
    """The dataset with other margins: part, kind, load factor, position."""
    columns = zip(("part", "kind", "load_factor", "position"), zip(*rows, strict=True), strict=True)
    kept = data.isel(margin=[0] * len(rows))
    return kept.assign({f"margin_{name}": ("margin", np.array(own)) for name, own in columns})


def of_all_kinds(data: xr.Dataset) -> xr.Dataset:
    """A link that fails by fatigue before it yields, one at half its strength, and two pins."""
    return with_margins(
        data,
        [
            ("coupler", "fatigue", 0.8, 0.05),
            ("B", "pin", 0.9, np.nan),
            ("coupler", "link", 1.5, 0.08),
            ("crank", "link", 2.0, 0.0),
            ("A", "pin", 40.0, np.nan),
        ],
    )


def link_colours(figure: Figure) -> list[tuple[float, ...]]:
    lines = panels(figure)[0].lines
    return [to_rgba(line.get_color()) for line in lines if line.get_lw() == WIDE]


def scale(figure: Figure) -> tuple[float, float]:
    (bar,) = (axes for axes in figure.axes if axes.get_label() == "<colorbar>")
    return tuple(bar.get_ylim())


def test_scale_ends_where_parts_fail(strong: xr.Dataset) -> None:
    """Links far from failure are pale, and do not look like those about to break."""
    figure = plot_strength(strong)
    assert scale(figure) == (0.0, 100.0)
    assert strong["margin_load_factor"].min() > 100
    for colour in link_colours(figure):
        assert colour == pytest.approx(COLOURS(0.0), abs=0.03)
    assert "fails (over 100 %)" not in legend_texts(figure)
    plt.close("all")


@pytest.mark.parametrize("width", [180.0, 88.0])
def test_every_judged_part_is_marked(strong: xr.Dataset, width: float) -> None:
    data = of_all_kinds(strong)
    with page_width(width):
        figure = plot_strength(data)
        check_texts(figure)
    (axes,) = panels(figure)
    texts = [text.get_text() for text in axes.texts]
    # The coupler has its weakest margin alone.
    assert {"0.8", "0.9", "2", "40"} <= set(texts)
    assert "1.5" not in texts
    assert set(legend_texts(figure)) == {
        "worst place, with its load factor",
        "worst place by fatigue, likewise",
        "pin, likewise",
        "fails (over 100 %)",
        "not judged",
    }
    crank, coupler, rocker = link_colours(figure)
    assert crank == pytest.approx(COLOURS(0.5), abs=0.01)
    assert coupler == to_rgba("black")
    assert rocker == to_rgba(NOT_JUDGED)
    squares = [line for line in axes.lines if line.get_marker() == "s" and line.get_ms() == 5.0]
    diamonds = [line for line in axes.lines if line.get_marker() == "D"]
    assert (len(squares), len(diamonds)) == (1, 2)
    failing, strong_pin = (to_rgba(line.get_mfc()) for line in diamonds)
    assert failing == to_rgba("black")
    assert strong_pin == pytest.approx(COLOURS(0.025), abs=0.01)
    assert scale(figure) == (0.0, 100.0)
    plt.close("all")


def test_nothing_left_for_loads_is_black(strong: xr.Dataset) -> None:
    figure = plot_strength(with_margins(strong, [("rocker", "link", 0.0, 0.01)]))
    assert link_colours(figure)[2] == to_rgba("black")
    plt.close("all")


def test_lines_of_internal_forces_are_of_links_alone(strong: xr.Dataset) -> None:
    """Neither fatigue nor a pin tells at which crank angle a link is nearest to failure."""
    figure = plot_internal_forces(of_all_kinds(strong))
    labels = [axes.get_ylabel() for axes in panels(figure)[::3]]
    angle = np.degrees(float(strong["margin_crank_angle"][0]))
    assert labels[:2] == [f"crank\n(line: {angle:.4g}°)", f"coupler\n(line: {angle:.4g}°)"]
    assert labels[2] == "rocker"
    plt.close("all")
