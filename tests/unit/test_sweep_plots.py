"""Figures of speed sweeps and of the effect of vibration show the dataset's numbers."""

from __future__ import annotations

from itertools import pairwise

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.plots import SERIES_STYLES, plot_speed_sweep, plot_vibration_effect
from tests.support.figure_checks import (
    check_layout,
    check_texts,
    heading,
    legend_texts,
    shown_texts,
)
from tests.support.plot_data import HIGHEST, LOWEST, sweep_dataset, vibration_dataset


def link_panels(figure: Figure) -> list[Axes]:
    """Panels from top to bottom, without the strip of names above them."""
    panels = [axes for axes in figure.axes if axes.get_ylabel()]
    return sorted(panels, key=lambda axes: -axes.get_position().y0)


def strip_of(figure: Figure) -> Axes:
    (strip,) = [axes for axes in figure.axes if not axes.get_ylabel()]
    return strip


def check_sweep(figure: Figure) -> None:
    check_texts(figure)
    assert all(axes.bbox.height > 100 for axes in link_panels(figure))


class TestSpeedSweep:
    def test_lines_are_the_peaks_in_millimetres(self) -> None:
        dataset = sweep_dataset()
        figure = plot_speed_sweep(dataset)
        panels = link_panels(figure)
        assert [axes.get_ylabel() for axes in panels] == [
            "Crank tip\npeak deflection (mm)",
            "Coupler middle\npeak deflection (mm)",
            "Rocker middle\npeak deflection (mm)",
        ]
        for link, axes in enumerate(panels):
            line, marks = axes.lines
            np.testing.assert_array_equal(line.get_xdata(), dataset["crank_speed"])
            np.testing.assert_allclose(line.get_ydata(), 1e3 * dataset["peak_deflection"][:, link])
            np.testing.assert_array_equal(marks.get_xdata(), dataset["settled_speed"])
            np.testing.assert_allclose(marks.get_ydata(), 1e3 * dataset["settled_peak"][:, link])
            assert marks.get_linestyle() == "None"
            assert axes.get_yscale() == "log"
            low, high = axes.get_ylim()
            assert low < min(line.get_ydata())
            assert high > max(marks.get_ydata())

    def test_both_speed_axes(self) -> None:
        figure = plot_speed_sweep(sweep_dataset(links=1))
        assert link_panels(figure)[-1].get_xlabel() == "Crank speed (rad/s)"
        (top,) = strip_of(figure).child_axes
        assert top.get_xlabel() == "Crank speed (rpm)"
        figure.draw_without_rendering()
        ratio = np.divide(top.get_xlim(), link_panels(figure)[0].get_xlim())
        np.testing.assert_allclose(ratio, 60 / (2 * np.pi))

    def test_unit_of_the_user_is_on_the_lower_axis(self) -> None:
        dataset = sweep_dataset(links=1)
        plain = link_panels(plot_speed_sweep(dataset))[0]
        dataset.attrs["speed_unit"] = "rpm"
        figure = plot_speed_sweep(dataset)
        (axes,) = link_panels(figure)
        assert axes.get_xlabel() == "Crank speed (rpm)"
        (top,) = strip_of(figure).child_axes
        assert top.get_xlabel() == "Crank speed (rad/s)"
        figure.draw_without_rendering()
        rpm = 30 / np.pi
        np.testing.assert_allclose(axes.get_xlim(), rpm * np.array(plain.get_xlim()))
        np.testing.assert_allclose(top.get_xlim(), plain.get_xlim())
        for line, other in zip(axes.lines, plain.lines, strict=True):
            np.testing.assert_allclose(line.get_xdata(), rpm * other.get_xdata())
            np.testing.assert_array_equal(line.get_ydata(), other.get_ydata())
        starts = [[patch.get_x() for patch in panel.patches] for panel in (axes, plain)]
        np.testing.assert_allclose(starts[0], rpm * np.array(starts[1]))

    def test_shaded_are_the_critical_speeds(self) -> None:
        dataset = sweep_dataset(modes=1, settled=False)
        for axes in link_panels(plot_speed_sweep(dataset)):
            shaded = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in axes.patches]
            probes = np.linspace(2.0, 40.0, 2001)
            inside = [any(low <= probe <= high for low, high in shaded) for probe in probes]
            order = dataset["order"].values
            bands = zip(LOWEST[0] / order, HIGHEST[0] / order, strict=True)
            wanted = np.any([(probes >= low) & (probes <= high) for low, high in bands], axis=0)
            np.testing.assert_array_equal(inside, wanted)
            # Overlapping shades would look darker than others.
            assert all(one[1] < two[0] for one, two in pairwise(sorted(shaded)))

    def test_names_stand_in_their_bands_and_do_not_touch(self) -> None:
        figure = plot_speed_sweep(sweep_dataset(modes=4))
        texts = strip_of(figure).texts
        names = [text.get_text() for text in texts]
        assert {"f₁/7", "f₁/8", "f₂/8", "f₂/12"} < set(names)
        # Beyond the range of speeds.
        assert not {"f₁/6", "f₁/1", "f₂/6", "f₄/20"} & set(names)
        for text in texts:
            mode, order = text.get_text().translate(str.maketrans("₁₂₃₄", "1234"))[1:].split("/")
            low = LOWEST[int(mode) - 1] / int(order)
            high = HIGHEST[int(mode) - 1] / int(order)
            assert low <= text.get_position()[0] <= high
        check_sweep(figure)

    def test_without_simulations_and_bands(self) -> None:
        figure = plot_speed_sweep(sweep_dataset(settled=False, fastest=8.0))
        assert legend_texts(figure) == ["steady state"]
        assert not strip_of(figure).texts
        assert all(len(axes.lines) == 1 for axes in link_panels(figure))
        check_sweep(figure)

    def test_legend(self) -> None:
        texts = ", ".join(legend_texts(plot_speed_sweep(sweep_dataset())))
        assert texts == "steady state, settled simulation, f₁/order, f₂/order"

    def test_layout(self) -> None:
        for modes, links in ((1, 1), (2, 3)):
            check_sweep(plot_speed_sweep(sweep_dataset(modes, links)))

    def test_gaps_and_links_that_do_not_bend(self) -> None:
        dataset = sweep_dataset()
        dataset["peak_deflection"][10:20] = np.nan
        dataset["peak_deflection"][:, 0] = 0.0
        dataset["settled_peak"][:, 0] = 0.0
        figure = plot_speed_sweep(dataset)
        assert link_panels(figure)[0].get_yscale() == "linear"
        assert np.isnan(link_panels(figure)[1].lines[0].get_ydata()).sum() == 10

    def test_order_of_the_speeds_does_not_matter(self) -> None:
        dataset = sweep_dataset()
        backwards = plot_speed_sweep(dataset.isel(crank_speed=slice(None, None, -1)))
        drawn = link_panels(backwards)[1].lines[0].get_ydata()
        np.testing.assert_allclose(drawn, 1e3 * dataset["peak_deflection"][:, 1])


class TestVibrationEffect:
    def test_draws_the_affected_engine_at_the_highest_speed(self) -> None:
        dataset = vibration_dataset()
        figure = plot_vibration_effect(dataset)
        title = heading(figure)
        assert title == "Natural frequencies at \N{MINUS SIGN}20 rad/s, exudyn (ancf)"
        chosen = dataset.isel(engine=1, crank_speed=1)
        for mode, axes in enumerate(figure.axes[:-1]):
            running, still = axes.lines
            np.testing.assert_array_equal(running.get_ydata(), chosen["frequency"][:, mode])
            np.testing.assert_array_equal(
                still.get_ydata(), chosen["quasi_static_frequency"][:, mode]
            )
            assert (running.get_linestyle(), still.get_linestyle()) == ("-", "--")
            np.testing.assert_allclose(running.get_xdata()[[0, -1]], [0.0, 360.0])
            assert axes.get_title("left") == f"Mode {mode + 1}"

    def test_lowest_panel_is_the_relative_difference(self) -> None:
        dataset = vibration_dataset()
        axes = plot_vibration_effect(dataset).axes[-1]
        chosen = dataset.isel(engine=1, crank_speed=1)
        ratio = chosen["frequency"] / chosen["quasi_static_frequency"]
        for mode in range(4):
            (line,) = [line for line in axes.lines if line.get_color() == SERIES_STYLES[mode].color]
            np.testing.assert_allclose(line.get_ydata(), 100 * (ratio[:, mode] - 1), atol=1e-12)
        low, high = axes.get_ylim()
        assert low < -0.4
        assert high > 0.4

    def test_labels(self) -> None:
        figure = plot_vibration_effect(vibration_dataset(modes=2))
        assert [axes.get_ylabel() for axes in figure.axes] == [
            "Frequency\n(Hz)",
            "Frequency\n(Hz)",
            "Difference\n(%)",
        ]
        assert figure.axes[-1].get_xlabel() == "Crank angle (deg)"
        assert legend_texts(figure) == ["running", "quasi-static", "mode 1", "mode 2"]

    def test_first_engine_if_vibration_changes_nothing(self) -> None:
        figure = plot_vibration_effect(vibration_dataset(affected=()))
        assert "reference (euler)" in heading(figure)
        assert "exudyn" not in heading(figure)
        assert len(figure.axes[0].lines) == 2

    def test_two_affected_engines(self) -> None:
        dataset = vibration_dataset(2, ("reference", "exudyn", "other"), affected=(1, 2))
        figure = plot_vibration_effect(dataset)
        assert {"exudyn (ancf)", "other (euler)"} < set(legend_texts(figure))
        first, _, second, _ = figure.axes[0].lines
        assert first.get_marker() != second.get_marker()
        check_layout(figure)

    def test_layout(self) -> None:
        for modes in (1, 6):
            check_layout(plot_vibration_effect(vibration_dataset(modes)))

    def test_few_angles_are_marked(self) -> None:
        figure = plot_vibration_effect(vibration_dataset(step=60.0))
        line = figure.axes[0].lines[0]
        assert line.get_marker() not in ("", "None")


@pytest.mark.parametrize(
    ("plot", "dataset"),
    [(plot_speed_sweep, sweep_dataset()), (plot_vibration_effect, vibration_dataset())],
)
def test_leaves_matplotlib_s_state_and_the_dataset_alone(plot, dataset: xr.Dataset) -> None:
    settings, before = dict(mpl.rcParams), dataset.copy(deep=True)
    figure = plot(dataset)
    assert shown_texts(figure)
    assert not plt.get_fignums()
    assert dict(mpl.rcParams) == settings
    xr.testing.assert_identical(dataset, before)
