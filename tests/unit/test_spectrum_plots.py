"""Spectra and spectrograms show the numbers of the dataset, with units, inside their frame."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import QuadMesh

from flexmech.errors import InputError
from flexmech.plots import chosen, plot_spectrogram, plot_spectrum
from flexmech.plots.reading import spread
from tests.support.figure_checks import (
    FULL_WIDTH_PANEL,
    check_layout,
    drawn,
    heading,
    legend_texts,
    panels,
    tick_texts,
    top_axis,
    y_labels,
)
from tests.support.plot_data import NATURAL, arm_response, response_dataset

ALL_PLOTS = (plot_spectrum, plot_spectrogram)
COLORS = ("#0072B2", "#D55E00")


@pytest.fixture(scope="module")
def dataset() -> xr.Dataset:
    return response_dataset()


class TestSpectrum:
    def test_lines_are_the_dataset_s(self, dataset: xr.Dataset) -> None:
        figure = plot_spectrum(dataset)
        assert y_labels(figure)[1] == "Coupler middle amplitude (mm)"
        assert figure.axes[-1].get_xlabel() == "Frequency (Hz)"
        limit = 1.3 * float(dataset["natural_frequency"].max())
        for axes, link in zip(panels(figure), dataset["link"].values, strict=True):
            assert axes.get_yscale() == "log"
            assert axes.get_xlim() == (0.0, pytest.approx(limit))
            wanted = 1e3 * dataset["spectrum"].sel(link=link)
            wanted = wanted.where(wanted["spectrum_frequency"] <= limit, drop=True)
            for engine, color in enumerate(COLORS):
                np.testing.assert_array_equal(drawn(axes, color), wanted.isel(engine=engine))
            assert axes.get_ylim()[1] > float(wanted.max())

    def test_bands_are_the_ranges_of_the_predictions(self, dataset: xr.Dataset) -> None:
        figure = plot_spectrum(dataset)
        predicted = dataset["natural_frequency"]
        for axes in panels(figure):
            for band, mode in zip(axes.patches, dataset["mode"].values, strict=True):
                ends = band.get_extents().transformed(axes.transData.inverted())
                values = predicted.sel(mode=mode)
                np.testing.assert_allclose(
                    [ends.x0, ends.x1], [values.min(), values.max()], rtol=1e-9
                )
        names = [text.get_text() for text in figure.axes[0].texts]
        assert names == [f"$f_{{{mode}}}$" for mode in (1, 2, 3, 4)]

    def test_harmonics_are_multiples_of_the_turning_frequency(self, dataset: xr.Dataset) -> None:
        top = top_axis(plot_spectrum(dataset))
        orders = np.array([int(text) for text in tick_texts(top)])
        assert orders.size >= 3
        np.testing.assert_allclose(top.get_xticks(), orders * 20 / (2 * np.pi))
        np.testing.assert_allclose(top.get_xticks(minor=True)[:3], np.arange(1, 4) * 10 / np.pi)

    def test_short_run_has_no_bands(self) -> None:
        figure = plot_spectrum(response_dataset(spectrogram=False))
        assert not figure.axes[0].patches
        assert "predicted natural frequencies" not in legend_texts(figure)
        check_layout(figure, FULL_WIDTH_PANEL)

    def test_names_of_close_bands_do_not_touch(self) -> None:
        close = response_dataset()
        close["natural_frequency"][..., 1] = close["natural_frequency"][..., 0] + 0.5
        check_layout(plot_spectrum(close), FULL_WIDTH_PANEL)

    def test_labels_are_moved_apart_and_stay_in_order(self) -> None:
        places = spread(np.array([0.2, 0.201, 0.202, 0.5]), 0.05)
        np.testing.assert_allclose(places, [0.151, 0.201, 0.251, 0.5], atol=1e-12)


class TestPeriodicSpectrum:
    @pytest.mark.parametrize("turns", [1, 2])
    def test_amplitudes_stand_at_the_orders(self, turns: int) -> None:
        periodic = response_dataset(float(turns), start="periodic", spectrogram=False)
        periodic = periodic.assign_attrs(spectrum_turns=turns)
        figure = plot_spectrum(periodic)
        turning = 20 / (2 * np.pi)
        for axes, link in zip(panels(figure), periodic["link"].values, strict=True):
            wanted = 1e3 * periodic["spectrum"].sel(link=link)[:, turns::turns]
            marked = [line for line in axes.lines if line.get_linestyle() == "None"]
            for line, values in zip(marked, wanted, strict=True):
                np.testing.assert_array_equal(line.get_ydata(), values)
                orders = line.get_xdata() / turning
                np.testing.assert_allclose(orders, np.arange(1, len(orders) + 1), rtol=2e-3)
            (stems,) = axes.collections
            tops = [segment[1, 1] for segment in stems.get_segments()]
            np.testing.assert_array_equal(tops, wanted[0])
            lines = [
                line
                for line in axes.lines
                if line.get_linestyle() == "-" and line.get_color() in COLORS
            ]
            assert len(lines) == (2 if turns > 1 else 0)
            for line in lines:
                assert np.isnan(line.get_ydata()[::turns]).all()
        assert legend_texts(figure)[:2] == [
            "reference (euler), at orders",
            "exudyn (ancf), at orders",
        ]
        check_layout(figure, FULL_WIDTH_PANEL)


class TestSpectrogram:
    def test_lines_are_named_and_the_heading_says_what_is_told_apart(
        self, dataset: xr.Dataset
    ) -> None:
        note = "window 0.1 s, resolution 20 Hz: cannot tell f1 and f2 (nearest 3 Hz) apart"
        figure = plot_spectrogram(dataset.assign_attrs(spectrogram_note=note))
        assert note in heading(figure).replace("\n", " ")
        ends = dataset["natural_frequency"].isel(engine=0, window_time=-1).values
        for axes in panels(figure):
            names = {text.get_text(): text.xy[1] for text in axes.texts}
            assert list(names) == ["$f_{1}$", "$f_{2}$", "$f_{3}$", "$f_{4}$"]
            # f1 and f2 are close: their names are moved apart, the others stand at their lines.
            assert names["$f_{2}$"] - names["$f_{1}$"] > 15
            np.testing.assert_allclose([names["$f_{3}$"], names["$f_{4}$"]], ends[2:], atol=1e-9)

    def test_levels_are_the_dataset_s(self, dataset: xr.Dataset) -> None:
        figure = plot_spectrogram(dataset)
        assert y_labels(figure)[2] == "Rocker middle frequency (Hz)"
        for axes, link in zip(panels(figure), dataset["link"].values, strict=True):
            (mesh,) = [item for item in axes.collections if isinstance(item, QuadMesh)]
            amplitude = dataset["spectrogram"].isel(engine=0).sel(link=link).values
            level = 20 * np.log10(amplitude / amplitude.max())
            np.testing.assert_allclose(mesh.get_array().reshape(level.shape), level, atol=1e-9)
            assert mesh.get_clim() == (-60.0, 0.0)
            middle = mesh.get_coordinates()[0, :, 0]
            middle = (middle[1:] + middle[:-1]) / 2
            np.testing.assert_allclose(middle, dataset["window_time"], rtol=1e-9)
        (bar,) = [axes for axes in figure.axes if axes.get_label() == "<colorbar>"]
        assert bar.get_ylabel() == "Level relative to each panel's maximum (dB)"

    def test_predictions_run_along_the_ridges(self, dataset: xr.Dataset) -> None:
        for axes in panels(plot_spectrogram(dataset)):
            assert len(axes.lines) == NATURAL.size
            for line, mode in zip(axes.lines, dataset["mode"].values, strict=True):
                wanted = dataset["natural_frequency"].isel(engine=0).sel(mode=mode)
                np.testing.assert_array_equal(line.get_ydata(), wanted)
                np.testing.assert_array_equal(line.get_xdata(), dataset["window_time"])
                assert line.get_path_effects(), "it has a rim, to be seen on any colour"

    def test_engine_is_chosen_by_name(self, dataset: xr.Dataset) -> None:
        louder = dataset.copy(deep=True)
        louder["natural_frequency"][1] += 1.0
        axes = plot_spectrogram(chosen(louder, engine="exudyn")).axes[0]
        np.testing.assert_array_equal(
            axes.lines[0].get_ydata(), louder["natural_frequency"][1, :, 0]
        )
        assert "exudyn (ancf)" in heading(axes.figure)

    def test_crank_angle_is_that_of_the_windows(self) -> None:
        top = top_axis(plot_spectrogram(response_dataset(4.0)))
        ticks = dict(zip(tick_texts(top), top.get_xticks(), strict=True))
        assert ticks == {str(n): pytest.approx(n * np.pi / 10) for n in (1, 2, 3)}

    def test_single_window(self, dataset: xr.Dataset) -> None:
        figure = plot_spectrogram(dataset.isel(window_time=[3]))
        assert figure.axes[0].lines[0].get_marker() == "."
        check_layout(figure, FULL_WIDTH_PANEL)

    def test_refuses_a_short_run(self) -> None:
        with pytest.raises(InputError, match="too short for a spectrogram"):
            plot_spectrogram(response_dataset(spectrogram=False))


@pytest.mark.thorough
@pytest.mark.parametrize("plot", ALL_PLOTS)
def test_layout(plot: Any) -> None:
    for turns in (0.3, 1.0, 10.0):
        check_layout(plot(response_dataset(turns)), FULL_WIDTH_PANEL)
    check_layout(plot(arm_response()), FULL_WIDTH_PANEL)


@pytest.mark.parametrize("plot", ALL_PLOTS)
def test_leaves_dataset_and_matplotlib_alone(plot: Any, dataset: xr.Dataset) -> None:
    before, settings = dataset.copy(deep=True), dict(mpl.rcParams)
    plot(dataset)
    xr.testing.assert_identical(dataset, before)
    assert not plt.get_fignums()
    assert dict(mpl.rcParams) == settings
