"""Pictures of a stability map show the dataset's numbers."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from flexmech import InputError, plots
from tests.support.figure_checks import check_layout, check_texts, legend_texts, panels
from tests.support.stability_data import (
    FREQUENCIES,
    GROWTH,
    SPEEDS,
    growth_at,
    stability_dataset,
)

EVERY = [
    plots.plot_stability,
    plots.plot_floquet_frequencies,
    plots.plot_floquet_harmonics,
    plots.plot_stability_against,
]


def by_name(plot: object) -> str:
    return str(getattr(plot, "__name__", plot))


@pytest.mark.thorough
@pytest.mark.parametrize("engines", [1, 2])
@pytest.mark.parametrize("plot", EVERY, ids=by_name)
def test_texts_do_not_touch(plot: object, engines: int) -> None:
    figure = plot(stability_dataset(engines=engines))  # type: ignore[operator]
    assert isinstance(figure, Figure)
    check_layout(figure)


@pytest.mark.parametrize("plot", EVERY, ids=by_name)
def test_backward_speeds_are_drawn(plot: object) -> None:
    dataset = stability_dataset()
    turned = dataset.assign_coords(
        crank_speed=-dataset["crank_speed"], moving_speed=-dataset["moving_speed"]
    )
    for edge in ("lower", "upper", "fastest"):
        name = "band_fastest_speed" if edge == "fastest" else f"band_{edge}"
        turned[name] = -turned[name]
    check_texts(plot(turned))  # type: ignore[operator]


@pytest.mark.parametrize("plot", EVERY[:3], ids=by_name)
def test_a_map_without_multipliers_has_no_picture(plot: object) -> None:
    dataset = stability_dataset()
    for name in ("growth_rate", "frequency", "harmonic_share"):
        dataset[name] = np.nan * dataset[name]
    with pytest.raises(InputError, match="no equilibrium at any speed"):
        plot(dataset)  # type: ignore[operator]


class TestGrowth:
    def test_curve_holds_speeds_asked_for_and_bands(self) -> None:
        dataset = stability_dataset()
        growth, modulus = panels(plots.plot_stability(dataset))
        line = max(growth.lines, key=lambda each: len(each.get_xdata()))
        drawn = dict(zip(line.get_xdata(), line.get_ydata(), strict=True))
        asked = dataset["growth_rate"].isel(engine=0, crank_speed=slice(-1))
        # Edges and the fastest speed of a band stand at some of these, too.
        for speed, rate in asked.drop_sel(crank_speed=[84.0, 97.0, 99.0]).to_series().items():
            assert drawn[speed] == rate
        # Edges grow with zero, the fastest speed with the band's rate.
        assert (drawn[88.1], drawn[88.7], drawn[89.3]) == (0.0, GROWTH, 0.0)
        # Between speeds asked for, where growth is known; these alone are marked.
        assert drawn[88.4] == growth_at(88.4)
        assert drawn[92.5] == growth_at(92.5)
        marked = {line.get_xdata()[place] for place in line.get_markevery()}
        assert marked == set(SPEEDS.tolist())
        sizes = max(modulus.lines, key=lambda each: len(each.get_xdata()))
        at = dict(zip(sizes.get_xdata(), sizes.get_ydata(), strict=True))
        assert at[88.7] == pytest.approx(np.exp(GROWTH * 2 * np.pi / 88.7))

    def test_bands_are_named_and_gaps_hatched(self) -> None:
        figure = plots.plot_stability(stability_dataset())
        growth = panels(figure)[0]
        names = {text.get_text(): text.get_position()[0] for text in growth.texts}
        assert names == pytest.approx({"f₁+f₃ = 11f": 88.7, "2f₂ = 7f": 84.1, "?": 98.5}, abs=0.1)
        assert {"twice a frequency", "sum of two frequencies", "unnamed band"} <= set(
            legend_texts(figure)
        )
        hatched = [patch for patch in growth.patches if patch.get_hatch() == "////"]
        assert len(hatched) == 1
        assert hatched[0].get_x() == 97.5

    def test_a_name_without_room_is_left_out_and_not_set_over_another_band(self) -> None:
        dataset = stability_dataset()
        dataset["band_lower"].values[0], dataset["band_upper"].values[0] = 88.75, 88.77
        growth = panels(plots.plot_stability(dataset))[0]
        assert {text.get_text() for text in growth.texts} == {"f₁+f₃ = 11f", "?"}

    def test_narrow_bands_are_marks_and_wide_ones_are_shaded(self) -> None:
        growth = panels(plots.plot_stability(stability_dataset()))[0]
        heights = {
            round(patch.get_x(), 3): patch.get_height()
            for patch in growth.patches
            if patch.get_hatch() != "////"
        }
        assert heights == {84.0: 0.05, 88.1: 1.0, 97.0: 1.0}

    def test_a_second_engine_has_its_own_curve(self) -> None:
        figure = plots.plot_stability(stability_dataset(engines=2))
        assert {"reference (euler)", "exudyn (ancf)"} <= set(legend_texts(figure))
        curves = [line for line in figure.axes[0].lines if len(line.get_xdata()) > 2]
        assert len(curves) == 2


class TestFrequencies:
    def test_points_and_bands_are_the_numbers(self) -> None:
        dataset = stability_dataset()
        (axes,) = panels(plots.plot_floquet_frequencies(dataset))
        points = [line for line in axes.lines if line.get_linestyle() == "None"]
        assert len(points) == len(FREQUENCIES)
        for line, frequency in zip(points, FREQUENCIES, strict=True):
            values = np.asarray(line.get_ydata(), dtype=float)
            assert values[:-1] == pytest.approx(frequency)
            assert np.isnan(values[-1])
        filled = axes.collections[: len(FREQUENCIES)]
        for area, frequency in zip(filled, FREQUENCIES, strict=True):
            box = area.get_paths()[0].get_extents()
            assert (box.y0, box.y1) == pytest.approx((0.9 * frequency, 1.1 * frequency))

    def test_every_branch_has_its_number_though_two_are_close(self) -> None:
        dataset = stability_dataset()
        mean = dataset["mean_frequency"] = dataset["mean_frequency"].copy()
        mean[{"branch": 1}] = 1.001 * mean.isel(branch=0)
        (axes,) = panels(plots.plot_floquet_frequencies(dataset))
        numbers = [text.get_text() for text in axes.texts]
        assert numbers == [str(n) for n in dataset["branch"].values]


class TestHarmonics:
    def test_four_branches_at_most(self) -> None:
        dataset = stability_dataset()
        drawn = panels(plots.plot_floquet_harmonics(dataset))
        assert [axes.get_title("left") for axes in drawn] == [f"Branch {n}" for n in range(1, 5)]
        cells = np.ma.getdata(drawn[0].collections[0].get_array())
        assert cells.shape == (9, len(SPEEDS))
        assert cells[4, 0] == pytest.approx(0.7)


class TestAgainst:
    def test_growth_is_coloured_and_decay_white(self) -> None:
        dataset = stability_dataset()
        (axes,) = panels(plots.plot_stability_against(dataset))
        values = axes.collections[0].get_array()
        assert values is not None
        grows = dataset["against_unstable"].values[0] == "yes"
        np.testing.assert_array_equal(~np.ma.getmaskarray(values), grows)
        np.testing.assert_allclose(
            np.ma.compressed(values), dataset["against_growth_rate"].values[0][grows]
        )
        assert axes.get_ylabel() == "Damping ratio (%)"
        assert axes.get_ylim() == pytest.approx((-0.25, 2.25))

    def test_what_has_no_equilibrium_is_hatched(self) -> None:
        (axes,) = panels(plots.plot_stability_against(stability_dataset()))
        hatched = [each for each in axes.collections if each.get_hatch()]
        assert len(hatched) == 1
        assert hatched[0].get_array().count() == 5 * 3

    def test_without_a_second_parameter(self) -> None:
        with pytest.raises(InputError, match="no second parameter"):
            plots.plot_stability_against(stability_dataset(against=False))
