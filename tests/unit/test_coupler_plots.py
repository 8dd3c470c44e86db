"""Pictures of linkages, their paths and their water show the dataset, with units, unclipped."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from flexmech.errors import InputError
from flexmech.linkages import RotatingArm
from flexmech.plots import (
    plot_coupler_angles,
    plot_coupler_curve,
    plot_laminate_factors,
    plot_linkage,
    plot_moisture,
    plot_transmission_angle,
)
from tests.support.figure_checks import (
    FULL_WIDTH_PANEL,
    HALF_WIDTH_PANEL,
    check_layout,
    drawn,
    heading,
    legend_texts,
    panels,
    y_labels,
)
from tests.support.plot_data import (
    FOURBAR,
    TURN,
    coupler_dataset,
    linkage_dataset,
    moisture_dataset,
    transmission_dataset,
)

BLUE, ORANGE = "#0072B2", "#D55E00"


class TestCouplerCurve:
    def test_curves_in_a_unit_of_their_size(self) -> None:
        for size, unit, scale in ((0.1, "mm", 1e3), (30.0, "m", 1.0)):
            dataset = coupler_dataset(size)
            first, _, last = panels(plot_coupler_curve(dataset))
            assert first.get_xlabel() == f"x ({unit})"
            assert first.get_aspect() == 1.0
            wanted = scale * dataset["position"].sel(state="dry")
            np.testing.assert_allclose(first.lines[0].get_xydata(), wanted)
            pins = scale * dataset["pin_position"].sel(state="dry")
            for number, name in enumerate("AB"):
                line = last.lines[number].get_xydata()
                np.testing.assert_allclose(line, pins.sel(pin=name))
            assert [text.get_text() for text in last.texts] == ["A", "B"]

    def test_double_points_are_counted_and_marked(self) -> None:
        dataset = coupler_dataset(states=2)
        figure = plot_coupler_curve(dataset)
        assert heading(figure) == "Resin four-bar\nCoupler curve"
        assert legend_texts(figure) == [
            "dry: 1 crunode, 1 cusp",
            "+80 K: 0 crunodes, 0 cusps",
            "crunode",
            "cusp",
        ]
        titles = [axes.get_title(loc="left") for axes in panels(figure)]
        assert titles == ["Coupler point", "Close-up of the loops", "Pins A and B"]
        curve, close_up, _ = panels(figure)
        for axes in (curve, close_up):
            marks = [line.get_xydata()[0] for line in axes.lines if len(line.get_xdata()) == 1]
            np.testing.assert_allclose(marks, 1e3 * dataset["double_point_position"])
        check_layout(figure, HALF_WIDTH_PANEL)

    def test_no_loops_no_close_up(self) -> None:
        figure = plot_coupler_curve(coupler_dataset(looped=False))
        assert len(panels(figure)) == 2
        assert legend_texts(figure) == ["dry: 0 crunodes, 0 cusps"]
        check_layout(figure, HALF_WIDTH_PANEL)

    def test_few_angles_are_marked_and_marks_beyond_them_are_told(self) -> None:
        part = coupler_dataset(angles=TURN[:1], states=2)
        figure = plot_coupler_curve(part)
        marks = {"crunode of the whole curve", "cusp of the whole curve"}
        assert marks < set(legend_texts(figure))
        curve, close_up, _ = panels(figure)
        assert curve.lines[0].get_marker() == "o"
        assert close_up.lines[0].get_marker() in ("", "None")
        check_layout(figure, HALF_WIDTH_PANEL)
        angles = plot_coupler_angles(part)
        assert all(axes.lines[0].get_marker() == "o" for axes in panels(angles)[:2])
        check_layout(angles, HALF_WIDTH_PANEL)
        whole = plot_coupler_curve(coupler_dataset()).axes[0]
        assert whole.lines[0].get_marker() in ("", "None")

    def test_no_states_or_too_many(self) -> None:
        for plot in (plot_coupler_curve, plot_coupler_angles):
            with pytest.raises(InputError, match="one to 6 series can be drawn, got 0"):
                plot(coupler_dataset().isel(state=[]))


class TestCouplerAngles:
    def test_lines_are_the_dataset_s(self) -> None:
        dataset = coupler_dataset(states=2)
        figure = plot_coupler_angles(dataset)
        for axes, link in zip(panels(figure)[:2], ("coupler", "rocker"), strict=True):
            for state, color in (("dry", BLUE), ("+80 K", ORANGE)):
                wanted = np.degrees(dataset["angle"].sel(link=link, state=state))
                np.testing.assert_allclose(drawn(axes, color), wanted)
        assert heading(figure) == "Resin four-bar\nAngles of coupler and rocker"

    def test_change_leaves_whole_turns_out(self) -> None:
        figure = plot_coupler_angles(coupler_dataset(states=2))
        changes = [r"Change of $\theta_3$ (deg)", r"Change of $\theta_4$ (deg)"]
        assert y_labels(figure)[2:] == changes
        assert np.abs(drawn(panels(figure)[2], ORANGE)).max() < 1e-9
        check_layout(figure, HALF_WIDTH_PANEL)

    def test_one_state_has_no_changes(self) -> None:
        figure = plot_coupler_angles(coupler_dataset())
        assert len(panels(figure)) == 2
        check_layout(figure, HALF_WIDTH_PANEL)


class TestMoisture:
    def test_lines_are_the_dataset_s(self) -> None:
        dataset = moisture_dataset()
        figure = plot_moisture(dataset)
        first, uptake, last, no_laws = panels(figure)
        assert first.get_ylabel() == "Moisture of the resin (%)"
        for axes, link in ((first, "coupler"), (last, "rocker")):
            for line, profile in zip(axes.lines, dataset["profile"].sel(link=link), strict=True):
                np.testing.assert_array_equal(line.get_ydata(), 100 * profile)
                np.testing.assert_array_equal(
                    line.get_xdata(), 1e3 * dataset["place"].sel(link=link)
                )
        assert no_laws.get_xlabel() == r"Root of time ($\sqrt{\mathrm{day}}$)"
        names = ("uptake", "short_time_uptake", "shen_springer_uptake")
        for line, name in zip(uptake.lines[1:], names, strict=True):
            np.testing.assert_array_equal(line.get_ydata(), dataset[name].sel(link="coupler"))
        laws = ["finite volumes", "root of time", "Shen & Springer"]
        assert legend_texts(figure) == ["0.5 d", "4 d", *laws]
        assert heading(figure) == "Moist four-bar\nMoisture at 85 % relative humidity, 80 °C"
        check_layout(figure, HALF_WIDTH_PANEL)

    def test_laws_that_say_nothing_are_not_in_the_legend(self) -> None:
        figure = plot_moisture(moisture_dataset().sel(link=["rocker"]))
        assert legend_texts(figure)[2:] == ["finite volumes"]

    def test_time_in_a_unit_of_its_size(self) -> None:
        for day, labels, root in (
            (86400.0, ["0.5 d", "4 d"], "day"),
            (3600.0, ["0.5 h", "4 h"], "hour"),
            (1.0, ["0.5 s", "4 s"], "second"),
            (300 * 86400.0, ["150 d", "1200 d"], "day"),
        ):
            figure = plot_moisture(moisture_dataset(day, over_width=True).isel(link=[0]))
            assert legend_texts(figure)[:2] == labels
            profile, uptake = panels(figure)
            assert uptake.get_xlabel() == rf"Root of time ($\sqrt{{\mathrm{{{root}}}}}$)"
            assert profile.get_title(loc="left") == "Coupler: mean over the width"
            check_layout(figure, HALF_WIDTH_PANEL)


class TestTransmissionAngle:
    def test_one_curve_a_linkage_and_the_range_wanted(self) -> None:
        wanted = {"wanted_least": 1.0, "wanted_greatest": 1.5, "wanted_label": "wanted"}
        for count, shaded in ((1, True), (6, False), (6, True)):
            dataset = transmission_dataset(count, **(wanted if shaded else {}))
            figure = plot_transmission_angle(dataset)
            check_layout(figure, FULL_WIDTH_PANEL)
            (axes,) = figure.axes
            assert axes.get_ylabel() == "Transmission angle (deg)"
            curves = [line.get_ydata() for line in axes.lines if len(line.get_xdata()) > 2]
            np.testing.assert_allclose(curves, np.degrees(dataset["transmission_angle"]))
            names = [*dataset["linkage"].values, *(["wanted"] if shaded else [])]
            assert set(legend_texts(figure)) == set(names)
            if shaded:
                (band,) = axes.patches
                ends = band.get_y(), band.get_y() + band.get_height()  # type: ignore[attr-defined]
                assert ends == pytest.approx(tuple(np.degrees([1.0, 1.5])))

    def test_title(self) -> None:
        assert "over a turn" in heading(plot_transmission_angle(transmission_dataset()))
        titled = transmission_dataset(title="A design")
        assert heading(plot_transmission_angle(titled)) == "A design"

    def test_curves_that_cannot_be_told_apart(self) -> None:
        for count in (0, 7):
            with pytest.raises(InputError, match=f"one to 6 series can be drawn, got {count}"):
                plot_transmission_angle(transmission_dataset(count))


def test_laminate_factors_are_the_study_s() -> None:
    plies, beams = ["woven", "unidirectional", "table 2"], ["converged", "third order"]
    layers = ["across width", "through thickness"]
    factor = np.linspace(0.2, 1.0, 3 * 2 * 2 * 6).reshape(3, 2, 2, 6)
    study = xr.Dataset(
        {
            "laminate_factor": (("plies", "layers", "beams", "laminate"), factor),
            "laminate_factor_spread": ("laminate", np.full(6, 0.01)),
            "published_laminate_factor": ("laminate", np.linspace(1.0, 0.4, 6)),
        },
        coords={
            "plies": plies,
            "layers": layers,
            "beams": beams,
            "laminate": [f"C{n}" for n in range(1, 7)],
        },
    )
    figure = plot_laminate_factors(study)
    check_layout(figure, FULL_WIDTH_PANEL)
    lines = [line.get_ydata() for line in figure.axes[0].lines]
    published = study["published_laminate_factor"]
    woven, straight, one_modulus = factor[:, :, 0]
    wanted = [*woven, *straight, one_modulus[0], published, factor[0, 0, 1]]
    np.testing.assert_array_equal(lines, wanted)


class TestLinkage:
    def test_links_joints_and_supports_are_the_dataset_s(self) -> None:
        dataset = linkage_dataset()
        figure = plot_linkage(dataset)
        (axes,) = figure.axes
        assert axes.get_title() == "Test linkage"
        assert [text.get_text() for text in axes.texts] == ["100 mm", "O2", "A", "B", "O4"]
        links = [line.get_xydata() for line in axes.lines if line.get_color() == "0.5"]
        np.testing.assert_array_equal(links, dataset["rigid_position"])
        fills = {
            line.get_markerfacecolor(): line.get_xydata()
            for line in axes.lines
            if line.get_marker() == "o"
        }
        places = dataset["joint_position"]
        np.testing.assert_allclose(fills["0.35"], places.sel(joint=["O2"]), atol=1e-12)
        pins = places.sel(joint=["O4", "A", "B"])
        np.testing.assert_allclose(fills["white"], pins, atol=1e-12)
        # Triangles, whose first corner closes them; not the disc of the shaft.
        tips = [patch.get_xy()[0] for patch in axes.patches if len(patch.get_xy()) == 4]
        np.testing.assert_allclose(tips, places.sel(joint=["O2", "O4"]), atol=1e-12)

    @pytest.mark.parametrize("step", [120, pytest.param(30, marks=pytest.mark.thorough)])
    def test_names_stand_apart_from_each_other_and_from_the_links(self, step: int) -> None:
        arms = [RotatingArm(0.4, hub_radius) for hub_radius in (0.0, 0.05)]
        for linkage in (FOURBAR, *arms):
            for degrees in range(0, 360, step):
                figure = plot_linkage(linkage_dataset(linkage, degrees))
                check_layout(figure)
                (axes,) = figure.axes
                links = [line for line in axes.lines if line.get_color() == "0.5"]
                ends = [axes.transData.transform(line.get_xydata()) for line in links]
                for text in axes.texts:
                    box = text.get_window_extent().shrunk(0.6, 0.6)
                    assert not any(box.contains(x, y) for link in ends for x, y in link)
