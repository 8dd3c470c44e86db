"""Every figure: letters are legible, colours distinguishable, and axes may be given."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text

from flexmech import InputError, plots
from tests.support.figure_checks import check_layout, legend_texts, panels, shown_texts
from tests.support.figures import FIGURES, Plot, data_of, figure_of

# A page of a journal in mm: its height, and the width of one of its columns and of both.
PAGE_HEIGHT, COLUMN, PAGE = 250.0, 88.0, 180.0
# Letters may not be smaller, in points.
LEAST_LETTERS = 6.5
OF_SEVERAL_MECHANISMS = {plots.plot_verification}
# Its lines are coloured by time.
BY_A_SCALE = {plots.plot_moisture}
# Okabe and Ito, *Color Universal Design*, 2008.
SAFE_COLOURS = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"}

thorough = pytest.mark.thorough
EVERY = pytest.mark.parametrize("plot", FIGURES, ids=lambda plot: plot.__name__)
# Two thirds of the figures once by default, by turns in one column and over both.
WIDTHS = pytest.mark.parametrize(
    ("plot", "width"),
    [
        pytest.param(
            plot,
            width,
            marks=[] if number % 3 and (number % 2 == 0) == (width == COLUMN) else thorough,
            id=f"{plot.__name__}-{width:.0f}",
        )
        for number, plot in enumerate(FIGURES)
        for width in (COLUMN, PAGE)
    ],
)


def is_grey(colour: object) -> bool:
    return np.ptp(to_rgb(colour)) < 1e-9


def test_each_plot_of_the_room_is_among_them() -> None:
    names = {name for name in plots.__all__ if name.startswith("plot_")}
    assert {plot.__name__ for plot in FIGURES} == names


@pytest.mark.thorough
@WIDTHS
def test_figure_is_read_at_a_width_of_a_page(plot: Plot, width: float) -> None:
    """No text is cut off or touches another; letters have 6.5 points; the mechanism is named."""
    data = data_of(plot)
    with plots.page_width(width):
        figure = plot(data.assign_attrs(mechanism="weaver's $1 loom"))
    assert figure.get_figwidth() * 25.4 == pytest.approx(width)
    assert figure.get_figheight() * 25.4 < PAGE_HEIGHT
    check_layout(figure)
    texts = shown_texts(figure)
    assert min(text.get_fontsize() for text in texts) >= LEAST_LETTERS
    named = any(r"Weaver's \$1 loom" in text.get_text() for text in texts)
    assert named is (plot not in OF_SEVERAL_MECHANISMS)


@EVERY
def test_lines_have_colours_that_colour_blind_readers_tell_apart(plot: Plot) -> None:
    lines = [line for axes in panels(figure_of(plot)) for line in axes.lines]
    joined = [line.get_color() for line in lines if line.get_linestyle() != "None"]
    colours = {to_hex(colour) for colour in joined if not is_grey(colour)}
    assert plot in BY_A_SCALE or colours <= SAFE_COLOURS


@EVERY
def test_axes_of_the_user_hold_what_a_new_figure_holds(plot: Plot) -> None:
    """No heading, the height as it was, letters of the user's family; data stay as they were."""
    count, data = FIGURES[plot][1], data_of(plot)
    before, settings = data.copy(deep=True), dict(mpl.rcParams)
    with mpl.rc_context({"font.family": "DejaVu Serif"}):
        figure = Figure(figsize=(8, 4 * count), layout="constrained")
        given = figure.subplots(count, 1, squeeze=False)[:, 0]
        assert plot(data, ax=given if count > 1 else given[0]) is figure
        letters = {text.get_fontname() for text in figure.findobj(Text)}
    assert letters == {"DejaVu Serif"}
    new = figure_of(plot)
    for axes, other in zip(given, panels(new), strict=True):
        for line, wanted in zip(axes.lines, other.lines, strict=True):
            np.testing.assert_array_equal(line.get_xdata(), wanted.get_xdata())
            np.testing.assert_array_equal(line.get_ydata(), wanted.get_ydata())
        assert axes.get_title("left") == other.get_title("left")
        assert axes.lines or axes.patches or axes.collections
    assert not figure.legends
    assert figure.get_figheight() == 4 * count
    if new.legends and legend_texts(new):
        legend = given[0].get_legend()
        assert {text.get_text() for text in legend.get_texts()} == set(legend_texts(new))
    xr.testing.assert_identical(data, before)
    assert dict(mpl.rcParams) == settings
    assert not plt.get_fignums()


@pytest.mark.parametrize("plot", [plots.plot_pareto, plots.plot_forces], ids=lambda p: p.__name__)
def test_a_wrong_number_of_axes_is_refused_with_the_right_one(plot: Plot) -> None:
    count = FIGURES[plot][1]
    given = Figure().subplots(1, count + 1)
    with pytest.raises(InputError, match=rf"^ax: .* {count} panels? .*{count + 1} Axes"):
        plot(data_of(plot), ax=given)
