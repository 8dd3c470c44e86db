"""Figures of a response show the numbers of the dataset, with units, inside their frame."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from flexmech.plots import plot_forces, plot_response
from flexmech.plots.reading import LENGTH_UNITS, fitting_unit
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
from tests.support.plot_data import arm_response, response_dataset

ALL_PLOTS = (plot_response, plot_forces)
COLORS = ("#0072B2", "#D55E00")
PARTS = ("magnitude", "x", "y")
MINUS = "\N{MINUS SIGN}"


@pytest.fixture(scope="module")
def dataset() -> xr.Dataset:
    return response_dataset()


class TestResponse:
    def test_panels_and_units(self, dataset: xr.Dataset) -> None:
        figure = plot_response(dataset)
        assert y_labels(figure) == [
            "Crank tip deflection (mm)",
            "Coupler middle deflection (mm)",
            "Rocker middle deflection (mm)",
            "Coupler middle strain (µm/m)",
            "Rocker middle strain (µm/m)",
        ]
        assert figure.axes[-1].get_xlabel() == "Time (s)"
        assert legend_texts(figure) == ["reference (euler)", "exudyn (ancf)"]

    def test_a_rigid_link_has_no_panel(self, dataset: xr.Dataset) -> None:
        elastic = dataset["link"] != "crank"
        rigid = dataset.assign(deflection=dataset["deflection"].where(elastic, 0.0))
        labels = y_labels(plot_response(rigid))
        assert len(labels) == 4
        assert not any("Crank" in label for label in labels)

    def test_lines_are_the_dataset_s(self, dataset: xr.Dataset) -> None:
        figure = plot_response(dataset)
        wanted = [1e3 * dataset["deflection"].sel(link=link) for link in dataset["link"].values]
        wanted += [1e6 * dataset["strain"].sel(link=link) for link in ("coupler", "rocker")]
        for axes, values in zip(panels(figure), wanted, strict=True):
            for engine, color in enumerate(COLORS):
                np.testing.assert_array_equal(drawn(axes, color), values.isel(engine=engine))
            np.testing.assert_array_equal(axes.lines[-1].get_xdata(), dataset["time"])

    def test_engines_are_told_apart_without_colour(self, dataset: xr.Dataset) -> None:
        lines = [
            line for line in plot_response(dataset).axes[1].lines if line.get_color() in COLORS
        ]
        first, second = lines
        assert first.get_linestyle() == "-"
        assert second.get_linestyle() == "--"
        # The lower line shows beside the upper one where both are the same.
        assert first.get_linewidth() > second.get_linewidth()

    def test_many_vibrations_are_drawn_thinner(self) -> None:
        widths = [
            plot_response(response_dataset(turns, ("reference",))).axes[1].lines[-1].get_linewidth()
            for turns in (1.0, 6.0)
        ]
        assert widths[0] > widths[1]

    def test_ripples_do_not_make_a_line_thinner(self) -> None:
        rippled = arm_response()
        time, slow = rippled["time"], np.cos(rippled["crank_angle"])
        ripples = np.sin(2 * np.pi * 200.0 * time)
        widths = []
        for size in (0.02, 0.1):
            rippled["deflection"][:] = 1e-3 * (slow + size * ripples).values[None, :, None]
            widths.append(plot_response(rippled).axes[0].lines[-1].get_linewidth())
        assert widths[0] > widths[1]

    def test_many_panels_stand_in_two_columns_on_one_page(self, dataset: xr.Dataset) -> None:
        links = [f"{name}-{n}" for n in (1, 2) for name in dataset["link"].values]
        many = xr.concat([dataset, dataset], "link", data_vars="minimal").assign_coords(link=links)
        figure = plot_response(many)
        check_layout(figure)
        assert len(panels(figure)) == 10
        assert figure.get_figheight() * 25.4 < 240.0
        first, second, third = figure.axes[:3]
        for axes in (first, second):
            (top,) = axes.child_axes
            assert top.get_xlabel() == "Crank angle (deg)"
        assert not third.child_axes
        assert second.get_position().x0 > first.get_position().x1

    def test_too_many_vibrations_are_drawn_as_their_envelope(self) -> None:
        run = arm_response(40.0)
        fast = np.sin(2 * np.pi * 100.0 * run["time"]) * np.cos(run["time"])
        run["deflection"][:] = (1e-3 * fast).values[None, :, None]
        figure = plot_response(run)
        (axes,) = panels(figure)
        assert "envelope of the vibration" in legend_texts(figure)
        edges = [line.get_ydata() for line in axes.lines if line.get_color() in COLORS]
        assert [len(edge) for edge in edges] == [300, 300]
        assert (edges[0] <= edges[1]).all()
        (band,) = axes.collections
        corners = band.get_paths()[0].vertices
        # All of the vibration is inside, and the band follows its size.
        assert corners[:, 1].min() == pytest.approx(1e3 * float(run["deflection"].min()))
        assert corners[:, 1].max() == pytest.approx(1e3 * float(run["deflection"].max()))
        upper = corners[corners[:, 1] > 0]
        np.testing.assert_allclose(upper[:, 1], np.abs(np.cos(upper[:, 0])), atol=0.06)
        assert "envelope of the vibration" not in legend_texts(plot_response(arm_response()))

    def test_arm_has_one_panel(self) -> None:
        assert y_labels(plot_response(arm_response())) == ["Arm tip deflection (mm)"]

    def test_tiny_deflections_have_a_smaller_unit(self) -> None:
        tiny = arm_response()
        tiny["deflection"][:] *= 1e-4
        (axes,) = panels(plot_response(tiny))
        assert axes.get_ylabel() == "Arm tip\ndeflection (µm)"
        np.testing.assert_array_equal(drawn(axes, COLORS[0]), 1e6 * tiny["deflection"][0, :, 0])

    def test_unit_fits_the_values(self) -> None:
        units = {1e-3: "mm", 9e-6: "µm", 1e-9: "nm", 1e-15: "nm", 0.0: "mm"}
        for largest, unit in units.items():
            assert fitting_unit(np.array([0.0, -largest]), LENGTH_UNITS)[1] == unit

    def test_heading_says_speed_start_and_run_up(self) -> None:
        starts = {
            "rigid": "undeformed links",
            "equilibrium": "quasi-static equilibrium",
            "periodic": "periodic motion",
        }
        for start, text in starts.items():
            run = response_dataset(start=start)
            run.attrs["run_up_time"] = 0.25
            words = heading(plot_response(run))
            assert all(part in words for part in ("20 rad/s", text, "run-up of 0.25 s"))


class TestCrankAngleAxis:
    @staticmethod
    def numbers_at_ticks(figure: Figure, run: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
        """What is written at the ticks, and the crank angles in rad at their times."""
        top = top_axis(figure)
        written = [float(text.replace(MINUS, "-")) for text in tick_texts(top)]
        assert len(written) >= 3
        turned = np.interp(top.get_xticks(), run["time"], run["crank_angle"])
        return np.array(written), turned

    def test_one_turn_is_in_degrees(self, dataset: xr.Dataset) -> None:
        figure = plot_response(dataset)
        assert top_axis(figure).get_xlabel() == "Crank angle (deg)"
        written, turned = self.numbers_at_ticks(figure, dataset)
        np.testing.assert_allclose(written, np.degrees(turned), atol=1e-9)

    def test_many_turns_are_counted_in_either_sense(self) -> None:
        for speed in (20.0, -20.0):
            run = response_dataset(6.0, speed=speed)
            figure = plot_response(run)
            assert top_axis(figure).get_xlabel() == "Crank angle (revolutions)"
            written, turned = self.numbers_at_ticks(figure, run)
            np.testing.assert_allclose(written, turned / (2 * np.pi), atol=1e-9)
            assert np.sign(speed) * 6.0 in written
        marks = [line for line in figure.axes[2].lines if len(line.get_xdata()) == 2]
        upright = [line for line in marks if line.get_xdata()[0] == line.get_xdata()[1]]
        assert len(upright) == 7

    def test_run_up_stands_at_the_right_times(self) -> None:
        run_up = response_dataset()
        time = run_up["time"].values
        run_up["crank_angle"] = ("time", 2 * np.pi * (time / time[-1]) ** 2)
        written, turned = self.numbers_at_ticks(plot_response(run_up), run_up)
        np.testing.assert_allclose(written, np.degrees(turned), atol=1e-2)


class TestForces:
    def test_panels_and_units(self, dataset: xr.Dataset) -> None:
        figure = plot_forces(dataset)
        assert y_labels(figure) == [
            "Driving torque (N m)",
            *(f"Force at {joint}, {part} (N)" for joint in "AB" for part in PARTS),
        ]
        assert legend_texts(figure)[-1] == "rigid links"
        assert y_labels(plot_forces(arm_response()))[1:] == [
            f"Force at O2, {part} (N)" for part in PARTS
        ]

    def test_magnitudes_are_those_of_the_components(self, dataset: xr.Dataset) -> None:
        axes = panels(plot_forces(dataset))[1]
        at = {"joint": "A"}
        for of_engine, color in zip(dataset["joint_force"].sel(at), COLORS, strict=True):
            wanted = np.hypot(of_engine.sel(component="x"), of_engine.sel(component="y"))
            np.testing.assert_allclose(drawn(axes, color), wanted, rtol=1e-14)
        rigid = dataset["rigid_joint_force"].sel(at)
        wanted = np.hypot(rigid.sel(component="x"), rigid.sel(component="y"))
        np.testing.assert_allclose(drawn(axes, "0.25"), wanted, rtol=1e-14)

    def test_of_more_joints_than_a_page_holds_magnitudes_are_drawn(
        self, dataset: xr.Dataset
    ) -> None:
        pins = dataset.assign_coords(joint_kind=("joint", ["pin"] * dataset.sizes["joint"]))
        assert y_labels(plot_forces(pins))[1:] == [
            f"Force at {joint}, magnitude (N)" for joint in ("O2", "A", "B", "O4")
        ]

    def test_lines_are_the_dataset_s(self, dataset: xr.Dataset) -> None:
        torque, *_, last = panels(plot_forces(dataset))
        place = {"joint": "B", "component": "y"}
        for engine, color in enumerate(COLORS):
            of_engine = dataset.isel(engine=engine)
            np.testing.assert_array_equal(drawn(torque, color), of_engine["driving_torque"])
            np.testing.assert_array_equal(drawn(last, color), of_engine["joint_force"].sel(place))
        np.testing.assert_array_equal(drawn(torque, "0.25"), dataset["rigid_driving_torque"])
        np.testing.assert_array_equal(drawn(last, "0.25"), dataset["rigid_joint_force"].sel(place))

    def test_pins_are_told_by_their_kind_and_not_by_their_name(self, dataset: xr.Dataset) -> None:
        renamed = dataset.assign_coords(
            joint=["Q", "Output", "B", "ground"],
            joint_kind=("joint", ["clamp", "pin", "pin", "pivot"]),
        )
        assert y_labels(plot_forces(renamed))[1:] == [
            f"Force at {joint}, {part} (N)" for joint in ("Output", "B") for part in PARTS
        ]
        clamped = arm_response().assign_coords(joint_kind=("joint", ["clamp"]))
        assert y_labels(plot_forces(clamped))[1:] == [f"Force at O2, {part} (N)" for part in PARTS]

    def test_ringing_is_all_in_view_and_can_be_seen_through(self, dataset: xr.Dataset) -> None:
        axes = panels(plot_forces(dataset))[2]
        ringing, calm, rigid = axes.lines[-3:]
        low, high = axes.get_ylim()
        assert low < ringing.get_ydata().min()
        assert high > ringing.get_ydata().max()
        assert ringing.get_alpha() < 1.0
        assert calm.get_alpha() == 1.0
        assert rigid.get_zorder() > calm.get_zorder()


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
