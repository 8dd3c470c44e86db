"""Pictures of studies show the designs, the limits and the shares of the dataset."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex

from flexmech import plots
from flexmech.errors import InputError
from flexmech.plots.designs.outputs import BEYOND, MOST_PANELS, WITHIN
from tests.support.design_data import (
    COUPLER,
    FAILED,
    LEAST,
    MATERIAL,
    optimum_dataset,
    sweep_designs,
    uncertainty_dataset,
    with_linkages,
)
from tests.support.figure_checks import check_layout, heading, legend_texts, panels

KINDS = ("one number", "two numbers", "number and text", "sample")


def points(axes: Axes, look: dict[str, object]) -> np.ndarray:
    """Places of the designs that have a mark."""
    (line,) = [line for line in axes.lines if line.get_marker() == look["marker"]]
    return np.asarray(line.get_xydata())


def levels(axes: Axes) -> list[float]:
    """Of the dashed contours: the limits."""
    return [
        float(level)
        for contours in axes.collections
        if "--" in np.atleast_1d(getattr(contours, "linestyles", None)).tolist()
        for level in contours.levels
    ]


class TestDesigns:
    @pytest.mark.parametrize("kind", KINDS)
    @pytest.mark.parametrize("limited", [True, False])
    @pytest.mark.parametrize("width", [88.0, 180.0])
    def test_texts_stand_apart(self, kind: str, limited: bool, width: float) -> None:
        with plots.page_width(width):
            check_layout(plots.plot_designs(sweep_designs(kind, limited=limited, failed=True)))

    def test_one_number_is_a_line_in_its_order_with_the_limit(self) -> None:
        dataset = sweep_designs("one number").isel(design=[2, 0, 3, 1])
        frequency, mass = panels(plots.plot_designs(dataset))
        line, limit = frequency.lines
        np.testing.assert_allclose(line.get_xdata(), [2, 3, 4, 5])
        np.testing.assert_array_equal(line.get_ydata(), np.sort(dataset["f1"]))
        assert set(limit.get_ydata()) == {LEAST}
        assert len(mass.lines) == 1
        assert (frequency.get_xlabel(), mass.get_ylabel()) == (
            "coupler in plane thickness (mm)",
            "mass (kg)",
        )

    def test_number_and_text_are_a_line_for_each_text(self) -> None:
        dataset = sweep_designs("number and text")
        figure = plots.plot_designs(dataset)
        assert legend_texts(figure) == ["steel", "aluminium", "limit"]
        steel, aluminium, _ = figure.axes[0].lines
        for line, name in ((steel, "steel"), (aluminium, "aluminium")):
            np.testing.assert_array_equal(
                line.get_ydata(), dataset["f1"].values[dataset[MATERIAL] == name]
            )

    def test_two_numbers_are_contours_with_the_limit_in_every_panel(self) -> None:
        dataset = sweep_designs("two numbers", failed=True)
        figure = plots.plot_designs(dataset)
        frequency, mass = panels(figure)
        assert frequency.get_title("left") == "f1 (Hz)"
        assert levels(frequency) == levels(mass) == [LEAST]
        assert len(points(mass, WITHIN)) == int(dataset["within"].sum())
        assert len(points(mass, WITHIN)) + len(points(mass, BEYOND)) == 11
        # On the dashed line the frequency is the limit: 1.2e4 h + 2e3 t.
        (line,) = [
            path
            for contours in mass.collections
            if "--" in np.atleast_1d(getattr(contours, "linestyles", None)).tolist()
            for path in contours.get_paths()
        ]
        np.testing.assert_allclose(line.vertices @ [12.0, 2.0], LEAST)
        # Grey from the least to the limit, in every panel.
        for axes in (frequency, mass):
            (grey,) = [each for each in axes.collections if getattr(each, "filled", False)]
            np.testing.assert_allclose(grey.levels, [dataset["f1"].min(), LEAST])

    def test_a_limit_from_above_is_grey_above_it(self) -> None:
        dataset = sweep_designs("two numbers", limited=False)
        dataset["mass"].attrs["greatest"] = 0.1
        for axes in panels(plots.plot_designs(dataset)):
            (grey,) = [each for each in axes.collections if getattr(each, "filled", False)]
            np.testing.assert_allclose(grey.levels, [0.1, dataset["mass"].max()])
            assert levels(axes) == [0.1]

    def test_without_limits_there_is_none_in_the_picture(self) -> None:
        figure = plots.plot_designs(sweep_designs("two numbers", limited=False))
        assert legend_texts(figure) == ["design"]
        assert not levels(figure.axes[0])

    def test_samples_are_points_and_long_texts_are_numbered(self) -> None:
        dataset = sweep_designs("sample")
        figure = plots.plot_designs(dataset)
        assert len(panels(figure)) == 4
        assert "1: [U@45/U@-45/U@0*2]s, 2: [U@0*4]s" in heading(figure).replace("\n", " ")
        over_text = figure.axes[1]
        found = points(over_text, WITHIN)
        within = dataset["within"].values
        np.testing.assert_array_equal(found[:, 0], np.tile([1, 2], 8)[within])
        np.testing.assert_array_equal(found[:, 1], dataset["f1"].values[within])
        np.testing.assert_allclose(
            points(figure.axes[0], BEYOND)[:, 0], 1e3 * dataset[COUPLER].values[~within]
        )

    def test_what_has_one_value_is_no_axis(self) -> None:
        dataset = sweep_designs("two numbers")
        fixed = dataset.isel(design=np.flatnonzero(dataset["thickness"] == 1e-3))
        line, _ = plots.plot_designs(fixed).axes[0].lines
        np.testing.assert_array_equal(line.get_ydata(), fixed["f1"])

    def test_panels_that_are_left_out_are_told(self) -> None:
        dataset = sweep_designs("sample")
        names = [f"f{number}" for number in range(7)]
        more = dataset.assign(dict.fromkeys(names, dataset["f1"]))
        figure = plots.plot_designs(more.assign_attrs(outputs=" ".join(names)))
        assert len(panels(figure)) == MOST_PANELS
        assert "the first 12 of 14 pairs" in heading(figure)

    def test_designs_that_all_fail_are_no_picture(self) -> None:
        dataset = sweep_designs().isel(design=[FAILED])
        dataset["status"][:] = "locked"
        for plot in (plots.plot_designs, plots.plot_distributions):
            with pytest.raises(InputError, match="no design can be computed"):
                plot(dataset)


class TestUncertainty:
    def test_percentiles_are_those_of_the_dataset(self) -> None:
        dataset = uncertainty_dataset()
        # What a failure counts as moves them: they are not those of the points.
        dataset["p50"] = dataset["p50"] + 1.0
        figure = plots.plot_distributions(dataset)
        check_layout(figure)
        frequency, mass = panels(figure)
        places = [float(line.get_xdata()[0]) for line in frequency.lines]
        wanted = [float(dataset[name].sel(output="f1")) for name in ("p2_5", "p50", "p97_5")]
        np.testing.assert_allclose(places, [*wanted, LEAST])
        assert len(mass.lines) == 3
        assert sum(bar.get_height() * bar.get_width() for bar in frequency.patches) == (
            pytest.approx(1.0)
        )

    def test_shares_are_bars_with_their_intervals(self) -> None:
        dataset = uncertainty_dataset()
        figure = plots.plot_sensitivity(dataset)
        check_layout(figure)
        frequency, mass = panels(figure)
        first, total = frequency.containers
        np.testing.assert_allclose([bar.get_width() for bar in first], [0.8, 0.1])
        np.testing.assert_allclose([bar.get_width() for bar in total], [0.9, 0.2])
        ends = [segment[:, 0] for part in frequency.collections for segment in part.get_segments()]
        np.testing.assert_allclose(ends, [[0.75, 0.87], [0.05, 0.17], [0.85, 0.97], [0.15, 0.27]])
        assert [text.get_text() for text in mass.texts] == ["does not vary"]
        assert to_hex(first[0].get_facecolor()) != to_hex(total[0].get_facecolor())

    def test_bands_of_frequencies_are_percentiles_of_each_mode(self) -> None:
        dataset = uncertainty_dataset()
        figure = plots.plot_frequency_bands(dataset)
        check_layout(figure)
        assert "Natural frequencies of 64 designs" in heading(figure)
        for axes, mode in zip(panels(figure), (1, 2), strict=True):
            low, median, high = dataset["frequency_percentile"].sel(mode=mode).values
            (line,) = axes.lines
            np.testing.assert_allclose(line.get_xdata(), np.arange(0, 361, 30))
            np.testing.assert_array_equal(line.get_ydata(), median)
            (shade,) = axes.collections
            drawn = shade.get_paths()[0].vertices[:, 1]
            assert set(low) | set(high) <= set(drawn)
            assert not set(median) & set(drawn)

    def test_without_frequencies_there_are_no_bands(self) -> None:
        with pytest.raises(InputError, match="ask for lowest_frequency"):
            plots.plot_frequency_bands(uncertainty_dataset().drop_vars("frequency_percentile"))

    def test_correlated_inputs_have_no_shares(self) -> None:
        with pytest.raises(InputError, match="inputs are correlated"):
            plots.plot_sensitivity(uncertainty_dataset(correlated=True))


class TestOptimum:
    def test_front_is_in_the_order_of_the_first_goal(self) -> None:
        dataset = optimum_dataset()
        figure = plots.plot_pareto(dataset)
        check_layout(figure)
        (line,) = figure.axes[0].lines
        np.testing.assert_array_equal(line.get_xdata(), np.sort(dataset["mass"]))
        np.testing.assert_array_equal(line.get_ydata(), np.sort(dataset["f1"]))
        assert figure.axes[0].get_xlabel() == "mass (kg), min"
        assert figure.axes[0].get_ylabel() == "f1 (Hz), max"

    def test_linkages_stand_above_the_front_to_one_scale(self) -> None:
        dataset = with_linkages(optimum_dataset())
        figure = plots.plot_pareto(dataset)
        check_layout(figure)
        (axes,) = figure.axes
        assert len(axes.child_axes) == dataset.sizes["design"] == 4
        assert len({inside.get_xlim() for inside in axes.child_axes}) == 1
        # From left to right by the first goal; the designs of the front are in the other order.
        for inside, number in zip(axes.child_axes, (3, 2, 1, 0), strict=True):
            links = dataset["rigid_position"].isel(design=number).values
            drawn = [np.transpose(line.get_data()) for line in inside.lines]
            found = [line for line in drawn if line.shape == links[0].shape]
            np.testing.assert_array_equal(found, links)
        # None lies on the front.
        highest = axes.transData.transform((0, float(dataset["f1"].max())))[1]
        assert all(inside.get_window_extent().y0 > highest for inside in axes.child_axes)
        ends = sorted(tuple(note.xy) for note in axes.texts)
        wanted = sorted(zip(dataset["mass"].values, dataset["f1"].values, strict=True))
        np.testing.assert_array_equal(ends, wanted)

    def test_three_goals_are_two_panels_without_lines(self) -> None:
        dataset = optimum_dataset().assign_attrs(goals="min mass\nmax f1\nmin f1")
        figure = plots.plot_pareto(dataset)
        assert len(panels(figure)) == 2
        assert all(axes.lines[0].get_linestyle() == "None" for axes in figure.axes)

    def test_one_goal_has_no_front(self) -> None:
        with pytest.raises(InputError, match="one goal has one best design"):
            plots.plot_pareto(optimum_dataset(goals=1))

    @pytest.mark.parametrize("goals", [1, 2])
    def test_search_is_a_step_for_each_goal(self, goals: int) -> None:
        dataset = optimum_dataset(goals)
        figure = plots.plot_search(dataset)
        check_layout(figure)
        for axes, goal in zip(panels(figure), dataset["goal"].values, strict=True):
            (line,) = axes.lines
            np.testing.assert_array_equal(line.get_xdata(), [64, 100, 180])
            np.testing.assert_array_equal(line.get_ydata(), dataset["history"].sel(goal=goal))
            assert line.get_drawstyle() == "steps-post"
