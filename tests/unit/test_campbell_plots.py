"""The Campbell diagram shows the dataset's numbers."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.plots import page_width, plot_campbell
from flexmech.plots.style import TIMES
from tests.support.figure_checks import check_texts, heading, legend_texts
from tests.support.plot_data import campbell_dataset


@pytest.mark.thorough
@pytest.mark.parametrize("branches", [1, 4])
@pytest.mark.parametrize("engines", [1, 2])
@pytest.mark.parametrize("peaks", [False, True])
def test_texts_do_not_touch(branches: int, engines: int, peaks: bool) -> None:
    check_texts(plot_campbell(campbell_dataset(branches, engines=engines, peaks=peaks)))


def test_bands_and_means_are_the_numbers() -> None:
    dataset = campbell_dataset(gap=False, peaks=False)
    axes = plot_campbell(dataset).axes[0]
    drawn = [np.asarray(line.get_ydata()) for line in axes.lines]
    for name in ("lowest", "mean", "highest"):
        for wanted in dataset[f"{name}_frequency"].values[0].T:
            assert any(len(y) == len(wanted) and np.array_equal(y, wanted) for y in drawn)


def test_critical_speeds_lie_on_their_rays() -> None:
    axes = plot_campbell(campbell_dataset(peaks=False)).axes[0]
    thick = [
        line for line in axes.lines if line.get_linewidth() > 1.7 and line.get_color() == "0.1"
    ]
    ends = [(line.get_xdata(), line.get_ydata()) for line in thick]
    assert len(ends) == 2  # a near miss is none
    for (speed, frequency), order in zip(ends, (5, 9), strict=True):
        np.testing.assert_allclose(frequency, order * np.asarray(speed) / (2 * np.pi))


@pytest.mark.parametrize("highest", [4, 12, 40, 120])
@pytest.mark.parametrize("width", [180.0, 88.0])
def test_the_lowest_and_the_highest_order_keep_their_labels(highest: int, width: float) -> None:
    """Where not all orders have room, whether they leave the axes at their side or above."""
    dataset = campbell_dataset(peaks=False).assign_coords(order=np.arange(1, highest + 1))
    with page_width(width):
        figure = plot_campbell(dataset)
    texts = [text.get_text() for text in figure.axes[0].texts]
    orders = sorted(int(text.removesuffix(TIMES)) for text in texts if text.endswith(TIMES))
    assert (orders[0], orders[-1]) == (1, highest)
    assert len(orders) >= min(4, highest)
    with page_width(width):
        check_texts(figure)


def test_speeds_and_gaps_are_in_the_users_unit() -> None:
    dataset = campbell_dataset(peaks=False).assign_attrs(speed_unit="rpm")
    axes = plot_campbell(dataset).axes[0]
    assert axes.get_xlabel() == "Crank speed (rpm)"
    np.testing.assert_allclose(axes.get_xlim(), (0.0, 90.0 * 30 / np.pi))
    assert "no result" in [text.get_text() for text in axes.texts]


def test_the_legend_names_each_thing_once() -> None:
    texts = legend_texts(plot_campbell(campbell_dataset(engines=2)))
    assert len(texts) == len(set(texts))
    assert {"branch 1", "order", "critical speed", "exudyn (ancf)"} <= set(texts)


def test_bands_that_no_order_reaches_leave_the_axes_to_the_others() -> None:
    dataset = campbell_dataset(peaks=False)
    highest = dataset["highest_frequency"].max(("engine", "crank_speed")).values
    lowest = dataset["lowest_frequency"].min(("engine", "crank_speed")).values
    slow = dataset.assign_coords(order=[1])
    assert 90.0 / (2 * np.pi) < lowest[0]
    figure = plot_campbell(slow)
    # The second branch is so near to the first that it is seen with it.
    assert highest[:2].max() < figure.axes[0].get_ylim()[1] < lowest[2]
    assert "branches 3, 4 are higher than orders reach" in " ".join(heading(figure).split())
    branches = [text for text in legend_texts(figure) if "branch" in text]
    assert branches == ["branch 1", "branch 2"]
    fast = dataset.assign_coords(order=np.arange(1, 100))
    figure = plot_campbell(fast)
    assert figure.axes[0].get_ylim()[1] > highest[-1]
    assert "higher than" not in heading(figure)
