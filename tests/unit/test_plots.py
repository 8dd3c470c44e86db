"""Figures show the numbers of the dataset, with units, inside their frame."""

from __future__ import annotations

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flexmech.analyses import MovingFrequencies
from flexmech.arrays import unbroken_runs
from flexmech.errors import InputError
from flexmech.plots import (
    plot_agreement,
    plot_damping_ratio,
    plot_frequencies,
    plot_mode_shapes,
    plot_speed_effect,
)
from flexmech.plots.frequencies import mode_groups
from flexmech.plots.layout import legend_columns
from flexmech.plots.reading import speed_label
from flexmech.plots.style import SERIES_STYLES
from tests.support.figure_checks import check_layout, heading, legend_texts, lines_in, panels
from tests.support.plot_data import FULL_TURN, TERMS, arm_dataset, frequency_dataset

ALL_PLOTS = (plot_frequencies, plot_speed_effect, plot_mode_shapes, plot_agreement)
SIX_SPEEDS = (-20.0, -10.0, 0.0, 5.0, 10.0, 20.0)


@pytest.fixture(scope="module")
def dataset() -> xr.Dataset:
    return frequency_dataset()


def grey_lines(axes: Axes) -> list[Line2D]:
    """Lines of what shares one look."""
    return [
        line for line in axes.lines if line.get_color() == "0.45" and line.get_linewidth() == 0.8
    ]


def y_label(figure: Figure) -> str:
    return figure.get_supylabel() or figure.axes[0].get_ylabel()


class TestFrequencies:
    def test_one_panel_a_mode_with_units(self, dataset: xr.Dataset) -> None:
        figure = plot_frequencies(dataset)
        assert [axes.get_title("left") for axes in figure.axes] == [
            f"Mode {n}" for n in (1, 2, 3, 4)
        ]
        assert y_label(figure) == "Frequency (Hz)"
        assert figure.axes[-1].get_xlabel() == "Crank angle (deg)"
        assert figure.get_figwidth() * 25.4 == pytest.approx(180)

    def test_legend_names_speeds_and_engines_along_the_row(self, dataset: xr.Dataset) -> None:
        texts = ", ".join(legend_texts(plot_frequencies(dataset)))
        assert texts == "0 rad/s, 10 rad/s, 20 rad/s, reference (euler), exudyn (ancf)"

    def test_lines_are_the_first_engine(self, dataset: xr.Dataset) -> None:
        figure = plot_frequencies(dataset)
        for mode, axes in enumerate(figure.axes):
            for speed in range(3):
                (drawn,) = lines_in(axes, speed, len(FULL_TURN))
                wanted = dataset["frequency"].isel(engine=0, crank_speed=speed, mode=mode)
                np.testing.assert_array_equal(drawn, wanted)
            assert axes.lines[0].get_xdata()[[0, -1]].tolist() == [0.0, 360.0]

    def test_markers_are_the_second_engine(self, dataset: xr.Dataset) -> None:
        axes = plot_frequencies(dataset).axes[2]
        marks = [line for line in axes.lines if line.get_linestyle() == "None"]
        assert len(marks) == 3
        for speed, line in enumerate(marks):
            places = np.isin(np.round(np.degrees(dataset["crank_angle"]), 9), line.get_xdata())
            wanted = dataset["frequency"].isel(engine=1, crank_speed=speed, mode=2)
            np.testing.assert_array_equal(line.get_ydata(), wanted.values[places])
            assert 8 <= len(line.get_xdata()) <= 15

    def test_panels_have_their_own_limits(self, dataset: xr.Dataset) -> None:
        for mode, axes in enumerate(plot_frequencies(dataset).axes):
            band = dataset["frequency"].isel(mode=mode)
            low, high = axes.get_ylim()
            assert low < float(band.min())
            assert high > float(band.max())
            assert high - low < 1.3 * float(band.max() - band.min())

    def test_order_of_angles_does_not_matter(self) -> None:
        angles = np.radians([200.0, 0.0, 90.0])
        axes = plot_frequencies(frequency_dataset(angles=angles)).axes[0]
        assert axes.lines[0].get_xdata().tolist() == [0.0, 90.0, 200.0]

    def test_single_angle_is_marked(self) -> None:
        figure = plot_frequencies(frequency_dataset(angles=(np.radians(60.0),)))
        assert all(line.get_marker() not in ("", "None") for line in figure.axes[0].lines)
        low, high = figure.axes[-1].get_xlim()
        assert low < 60.0 < high

    def test_flat_frequency_does_not_blow_up_round_off(self) -> None:
        flat = frequency_dataset(speeds=(0.0,), modes=1)
        flat["frequency"][:] = 50.0 + 1e-12 * np.arange(len(FULL_TURN))[:, None]
        low, high = plot_frequencies(flat).axes[0].get_ylim()
        assert high - low > 0.1

    def test_does_not_change_the_dataset(self, dataset: xr.Dataset) -> None:
        before = dataset.copy(deep=True)
        for plot in ALL_PLOTS:
            plot(dataset)
        xr.testing.assert_identical(dataset, before)


class TestBranches:
    def test_crossing_modes_share_a_panel(self) -> None:
        crossing = frequency_dataset(crossing=True)
        assert mode_groups(crossing) == [[0, 1], [2], [3]]
        figure = plot_frequencies(crossing)
        assert figure.axes[0].get_title("left") == "Modes 1 and 2"
        assert [text.get_text() for text in figure.axes[0].texts] == ["branch 2", "branch 1"]

    def test_lines_follow_branches_and_do_not_jump(self) -> None:
        crossing = frequency_dataset(crossing=True)
        axes = plot_frequencies(crossing).axes[0]
        first, second = lines_in(axes, 0, len(FULL_TURN))
        at_rest = crossing.isel(engine=0, crank_speed=0)
        for number, drawn in ((1, first), (2, second)):
            branch = at_rest["frequency"].where(at_rest["branch_of_mode"] == number).sum("mode")
            np.testing.assert_array_equal(drawn, branch)
            # A jump to the other branch would show as a kink.
            assert np.abs(np.diff(drawn, 2)).max() < 0.2

    def test_coarse_angles_do_not_join_distant_modes(self) -> None:
        coarse = frequency_dataset(angles=np.radians([0.0, 120.0, 240.0]))
        coarse["branch_of_mode"][:, :, 1, :] = [3, 2, 1, 4]
        assert mode_groups(coarse) == [[0], [1], [2], [3]]

    def test_branch_entering_from_above_keeps_its_points(self) -> None:
        entering = frequency_dataset(crossing=True, modes=2, engines=("reference",))
        branches = entering["branch_of_mode"].values
        branches[:, :, 40, :] = np.where(branches[:, :, 40, :] == 2, 5, branches[:, :, 40, :])
        axes = plot_frequencies(entering).axes[0]
        (alone,) = [
            line
            for line in axes.lines
            if line.get_color() == "#0072B2" and line.get_marker() == "."
        ]
        wanted = entering["frequency"].values[0, 0, 40][branches[0, 0, 40] == 5]
        np.testing.assert_array_equal(alone.get_ydata(), wanted)

    def test_veering_is_marked_where_flagged(self) -> None:
        crossing = frequency_dataset(crossing=True)
        figure = plot_frequencies(crossing)
        flags = crossing["veering"].isel(engine=0).any(("crank_speed", "mode")).values
        assert len(figure.axes[0].patches) == len(unbroken_runs(flags)) > 0
        assert not figure.axes[1].patches
        assert "veering" in legend_texts(figure)

    def test_runs_of_flags(self) -> None:
        flags = np.array([True, False, True, True, False, True])
        assert unbroken_runs(flags) == [range(1), range(2, 4), range(5, 6)]


class TestSpeedEffect:
    def test_shows_terms_and_total_at_the_fastest_speed(self) -> None:
        reversed_ = frequency_dataset(speeds=(10.0, -30.0, 0.0))
        figure = plot_speed_effect(reversed_)
        assert "from rest to \N{MINUS SIGN}30 rad/s" in heading(figure)
        for mode, axes in enumerate(figure.axes):
            effect = reversed_["speed_effect"].isel(crank_speed=1, mode=mode)
            for term in range(len(TERMS)):
                (drawn,) = lines_in(axes, term, len(FULL_TURN))
                np.testing.assert_array_equal(drawn, effect[term])
            (total,) = [line for line in axes.lines if line.get_color() == "black"]
            np.testing.assert_allclose(total.get_ydata(), effect.sum("term"), rtol=1e-14)

    def test_labels(self, dataset: xr.Dataset) -> None:
        figure = plot_speed_effect(dataset)
        assert y_label(figure) == "Change of frequency (Hz)"
        assert figure.axes[1].get_xlabel() == "Crank angle (deg)"
        # In two rows, of which matplotlib lists one column after another.
        texts = ", ".join(legend_texts(figure))
        assert texts == "total, Coriolis, geometric, centripetal, configuration, tangential"

    def test_zero_is_in_view(self, dataset: xr.Dataset) -> None:
        for axes in plot_speed_effect(dataset).axes:
            low, high = axes.get_ylim()
            assert low < 0 < high

    def test_refuses_a_result_without_terms(self) -> None:
        with pytest.raises(InputError, match="speed_effect=True"):
            plot_speed_effect(frequency_dataset(speed_effect=False))

    def test_terms_below_a_hundredth_share_a_look_and_a_legend_entry(self) -> None:
        small = frequency_dataset(speeds=(0.0, 20.0))
        total = float(abs(small["speed_effect"].sum("term")).max())
        for number in (2, 4):
            small["speed_effect"][number] = 1e-4 * total * np.cos(small["crank_angle"])
        figure = plot_speed_effect(small)
        assert "Coriolis, tangential (below 1 % of the total)" in legend_texts(figure)
        assert not {"Coriolis", "tangential"} & set(legend_texts(figure))
        for mode, axes in enumerate(figure.axes):
            wanted = small["speed_effect"].isel(crank_speed=1, mode=mode, term=[2, 4])
            for line, values in zip(grey_lines(axes), wanted, strict=True):
                np.testing.assert_array_equal(line.get_ydata(), values)
            # The others keep the styles of their places.
            np.testing.assert_array_equal(
                lines_in(axes, 3, len(FULL_TURN))[0],
                small["speed_effect"].isel(crank_speed=1, mode=mode, term=3),
            )
        check_layout(figure)

    def test_a_term_that_matters_in_one_mode_has_its_own_entry(self) -> None:
        some = frequency_dataset(speeds=(0.0, 20.0))
        some["speed_effect"][2, ..., :3] = 0.0
        assert "Coriolis" in legend_texts(plot_speed_effect(some))


class TestManySpeeds:
    SPEEDS = tuple(np.linspace(-10.0, 50.0, 7))

    @pytest.fixture(scope="class")
    @classmethod
    def many(cls) -> xr.Dataset:
        return frequency_dataset(cls.SPEEDS, crossing=True).assign_attrs(speed_unit="rpm")

    @pytest.mark.parametrize("plot", [plot_frequencies, plot_agreement])
    def test_colours_grow_lighter_with_speed_and_no_point_is_marked(self, plot, many) -> None:
        figure = plot(many)
        (bar,) = [axes for axes in figure.axes if axes.get_label() == "<colorbar>"]
        assert bar.get_ylabel() == "Crank speed (rpm)"
        # Of the dataset's -10 to 50 rad/s.
        assert bar.get_ylim() == pytest.approx([-300 / np.pi, 1500 / np.pi])
        assert not any("rpm" in text for text in legend_texts(figure))
        for axes in panels(figure):
            coloured = [line for line in axes.lines if not isinstance(line.get_color(), str)]
            lightness = [np.dot(line.get_color()[:3], [0.3, 0.59, 0.11]) for line in coloured]
            assert len(lightness) >= len(self.SPEEDS)
            assert lightness == sorted(lightness)
            assert {line.get_marker() for line in coloured} == {""}
        check_layout(figure)

    def test_lines_are_the_first_engine_s_at_every_speed(self, many: xr.Dataset) -> None:
        lines = plot_frequencies(many).axes[1].lines
        wanted = many["frequency"].isel(engine=0, mode=2)
        assert len(lines) == len(self.SPEEDS)
        for line, values in zip(lines, wanted, strict=True):
            np.testing.assert_array_equal(line.get_ydata(), values)

    def test_mode_shapes_are_those_of_the_highest_speed(self, many: xr.Dataset) -> None:
        figure = plot_mode_shapes(many)
        assert "at 477.5 rpm and crank angle 0°" in heading(figure).replace("\n", " ")
        assert legend_texts(figure) == ["477.5 rpm", "rigid linkage"]
        frequency = float(many["frequency"][0, -1, 0, 0])
        assert figure.axes[0].get_title("center") == f"Mode 1\n{frequency:.2f} Hz"
        check_layout(figure)

    def test_five_speeds_have_styles_of_their_own(self) -> None:
        figure = plot_frequencies(frequency_dataset(self.SPEEDS[:5]))
        assert not [axes for axes in figure.axes if axes.get_label() == "<colorbar>"]


class TestKelvinVoigtDamping:
    def test_lines_are_the_damping_ratios_by_speed_and_mode(self) -> None:
        damped = frequency_dataset(engines=("reference",))
        values = 0.01 + 0.001 * np.cos(damped["crank_angle"] * damped["mode"])
        damped["damping_ratio"] = values * (1 + damped["crank_speed"]) + 0 * damped["damping_ratio"]
        figure = plot_damping_ratio(damped)
        for speed, axes in enumerate(figure.axes):
            for mode in range(4):
                (drawn,) = lines_in(axes, mode, len(FULL_TURN))
                wanted = 100 * damped["damping_ratio"].isel(engine=0, crank_speed=speed, mode=mode)
                np.testing.assert_allclose(drawn, wanted, rtol=1e-12)
        assert "Kelvin-Voigt" in heading(figure)

    def test_it_is_drawn_where_there_is_such_damping(self) -> None:
        undamped = frequency_dataset(engines=("reference",), modes=1)
        assert "damping_ratio" not in MovingFrequencies(undamped).figures()
        estimated = undamped.assign(damping_ratio_reduction_error=undamped["discretisation_error"])
        assert "damping_ratio" in MovingFrequencies(estimated).figures()


class TestModeShapes:
    def test_titles_hold_the_frequencies_at_that_angle(self, dataset: xr.Dataset) -> None:
        figure = plot_mode_shapes(dataset, check_angle=np.radians(62.0))
        assert "crank angle 60°" in heading(figure)
        wanted = dataset["frequency"].isel(engine=0, mode=0).sel(crank_angle=np.radians(60.0))
        texts = " / ".join(f"{value:.2f}" for value in wanted.values)
        assert figure.axes[0].get_title("center") == f"Mode 1\n{texts} Hz"

    def test_first_angle_is_the_default(self, dataset: xr.Dataset) -> None:
        assert "crank angle 0°" in heading(plot_mode_shapes(dataset))

    def test_rigid_linkage_is_the_dataset_s(self, dataset: xr.Dataset) -> None:
        axes = plot_mode_shapes(dataset).axes[0]
        rigid = [line for line in axes.lines if line.get_color() == "0.65"]
        for line, link in zip(rigid, dataset["rigid_position"][0], strict=True):
            np.testing.assert_array_equal(np.transpose(line.get_data()), link)

    def test_shapes_of_any_phase_coincide(self) -> None:
        # The speeds of this dataset hold the same shape, each at its own phase.
        figure = plot_mode_shapes(frequency_dataset())
        for axes in figure.axes:
            first, second, third = (lines_in(axes, speed, 81) for speed in range(3))
            np.testing.assert_allclose(first, second, atol=1e-12)
            np.testing.assert_allclose(first, third, atol=1e-12)

    def test_deflection_is_along_the_stored_shape(self) -> None:
        dataset = frequency_dataset()
        axes = plot_mode_shapes(dataset).axes[1]
        drawn = [line for line in axes.lines if line.get_color() == SERIES_STYLES[0].color]
        rigid = dataset["rigid_position"][0].values
        moved = np.array([np.transpose(line.get_data())[::4] for line in drawn]) - rigid
        stored = dataset["mode_shape"].isel(engine=0, crank_speed=0, check_angle=0, mode=1)
        # Here each stored part is a multiple of one real shape.
        stored = stored.sel(part="real").values
        cosine = np.sum(moved * stored) / np.linalg.norm(moved) / np.linalg.norm(stored)
        assert abs(cosine) == pytest.approx(1.0, abs=1e-12)

    def test_signs_are_those_of_the_first_speed(self) -> None:
        flipped = frequency_dataset(engines=("reference",))
        flipped["mode_shape"][:, 1] *= -1.0
        axes = plot_mode_shapes(flipped).axes[0]
        np.testing.assert_allclose(lines_in(axes, 0, 81), lines_in(axes, 1, 81), atol=1e-12)

    def test_joints(self, dataset: xr.Dataset) -> None:
        axes = plot_mode_shapes(dataset).axes[0]
        circles = {
            line.get_markerfacecolor(): line.get_xydata()
            for line in axes.lines
            if line.get_marker() == "o"
        }
        rigid = dataset["rigid_position"][0].values
        np.testing.assert_allclose(circles["0.35"], [rigid[0, 0]], atol=1e-12)
        pins = [rigid[2, 0], rigid[0, -1], rigid[1, -1]]
        np.testing.assert_allclose(circles["white"], pins, atol=1e-12)

    def test_equal_scale_and_a_scale_bar(self, dataset: xr.Dataset) -> None:
        figure = plot_mode_shapes(dataset)
        assert all(axes.get_aspect() == 1.0 for axes in figure.axes)
        assert [text.get_text() for text in figure.axes[0].texts] == ["100 mm"]

    @pytest.mark.parametrize("hub_radius", [0.0, 0.05])
    def test_arm(self, hub_radius: float) -> None:
        figure = plot_mode_shapes(arm_dataset(hub_radius))
        axes = figure.axes[0]
        assert len(figure.axes) == 3
        # A disc shows the shaft, as large as its hub where that can be seen.
        (disc,) = [patch.get_xy() for patch in axes.patches if len(patch.get_xy()) > 10]
        assert np.hypot(*disc.T) == pytest.approx(hub_radius or 0.026 * 0.4)
        joints = [line.get_xydata() for line in axes.lines if line.get_marker() == "o"]
        assert np.concatenate(joints).tolist() == [[0.0, 0.0]]
        check_layout(figure)


class TestAgreement:
    def test_draws_the_relative_difference(self, dataset: xr.Dataset) -> None:
        figure = plot_agreement(dataset)
        assert y_label(figure) == "Relative difference (-)"
        for mode, axes in enumerate(figure.axes):
            assert axes.get_yscale() == "log"
            for speed in range(3):
                (drawn,) = lines_in(axes, speed, len(FULL_TURN))
                first, second = dataset["frequency"].isel(crank_speed=speed, mode=mode).values
                np.testing.assert_allclose(drawn, np.abs(second / first - 1), rtol=1e-12)

    def test_draws_each_engine_s_own_error(self, dataset: xr.Dataset) -> None:
        axes = plot_agreement(dataset).axes[3]
        for engine, marker in enumerate("x+"):
            (line,) = [line for line in axes.lines if line.get_marker() == marker]
            wanted = dataset["discretisation_error"].isel(engine=engine, mode=3).max("crank_speed")
            np.testing.assert_allclose(line.get_ydata(), wanted)
        assert {
            "estimated error of reference",
            "estimated error of exudyn",
        } < set(legend_texts(plot_agreement(dataset)))

    def test_equal_frequencies_are_drawn_at_the_floor(self) -> None:
        equal = frequency_dataset(modes=1)
        equal["frequency"][1] = equal["frequency"][0]
        axes = plot_agreement(equal).axes[0]
        (drawn,) = lines_in(axes, 0, len(FULL_TURN))
        np.testing.assert_array_equal(drawn, 1e-16)

    def test_missing_estimates_leave_a_figure(self) -> None:
        missing = frequency_dataset(modes=2)
        missing["discretisation_error"][:] = np.nan
        check_layout(plot_agreement(missing))

    def test_refuses_one_engine(self) -> None:
        with pytest.raises(InputError, match=r"two engines.*reference"):
            plot_agreement(frequency_dataset(engines=("reference",)))


@pytest.mark.thorough
@pytest.mark.parametrize("plot", ALL_PLOTS)
def test_layout(plot) -> None:
    """Of few and many modes, and of a single angle and a part of a turn."""
    for modes in (1, 8):
        check_layout(plot(frequency_dataset(SIX_SPEEDS, modes=modes)))
    for degrees in ([30.0], np.arange(30.0, 121.0, 2.0)):
        check_layout(plot(frequency_dataset(angles=np.radians(degrees))))


def test_layout_with_shared_panels() -> None:
    for modes in (2, 4):
        check_layout(plot_frequencies(frequency_dataset(crossing=True, modes=modes)))


def test_matplotlib_s_state_is_left_alone(dataset: xr.Dataset) -> None:
    settings = dict(mpl.rcParams)
    for plot in ALL_PLOTS:
        plot(dataset)
    assert not plt.get_fignums()
    assert dict(mpl.rcParams) == settings


class TestStyle:
    def test_series_differ_without_colour(self) -> None:
        assert len({style.linestyle for style in SERIES_STYLES}) == len(SERIES_STYLES)
        assert len({style.marker for style in SERIES_STYLES}) == len(SERIES_STYLES)

    @pytest.mark.parametrize(
        ("speed", "text"),
        [(0.0, "0 rad/s"), (-20.0, "\N{MINUS SIGN}20 rad/s"), (10 * np.pi, "31.42 rad/s")],
    )
    def test_speed_label(self, speed: float, text: str) -> None:
        assert speed_label(speed) == text

    def test_legend_rows_are_balanced(self) -> None:
        assert legend_columns(["20 rad/s"] * 4) == 4
        assert legend_columns(["a rather long engine name"] * 4) == 2
        assert legend_columns(["x" * 200] * 3) == 1
        assert legend_columns([]) == 1
