"""Figures over the crank speed: critical speeds, bands of growth, and peaks."""

from __future__ import annotations

import numpy as np
import pytest

import flexmech
from flexmech import InputError, MovingFrequencies, plots
from tests.support.figure_checks import heading, legend_texts, panels, tick_texts, top_axis
from tests.support.figures import data_of, figure_of
from tests.support.results import frequencies
from tests.support.strategies import fourbar

RPM = 30 / np.pi
ENDS = ("lowest", "highest")


def test_frequencies_at_few_crank_angles_are_curves_over_the_speed() -> None:
    data = frequencies().dataset.isel(crank_angle=[2, 0]).assign_attrs(speed_unit="rpm")
    figure = plots.plot_frequencies_over_speed(data)
    angles = np.degrees(data["crank_angle"].values)
    assert legend_texts(figure)[:2] == [f"{angle:.6g} deg" for angle in sorted(angles)]
    for mode, axes in enumerate(panels(figure)):
        for place, angle in enumerate(sorted(data["crank_angle"].values)):
            along = data["frequency"].isel(engine=0, mode=mode).sel(crank_angle=angle)
            line = axes.lines[place * data.sizes["engine"]]
            np.testing.assert_allclose(line.get_xdata(), RPM * data["crank_speed"].values)
            np.testing.assert_allclose(line.get_ydata(), along)
    result = MovingFrequencies(data)
    assert "frequencies" not in result.figures()  # two points each, over the crank angle
    assert "frequencies_over_speed" in result.figures()
    assert heading(result.plot()) == heading(figure)
    over_the_turn = frequencies().figures()
    assert "frequencies" in over_the_turn
    assert "frequencies_over_speed" not in over_the_turn


def test_critical_speeds_lie_on_the_rays_of_their_orders() -> None:
    data, axes = data_of(plots.plot_campbell), figure_of(plots.plot_campbell).axes[0]
    met = data["critical_gap"].values <= 0
    drawn = {
        tuple(np.round(line.get_xdata(), 6))
        for line in axes.lines
        if len(line.get_xdata()) == 2
        and any(
            np.allclose(line.get_ydata(), order * np.asarray(line.get_xdata()) / (2 * np.pi))
            for order in data["critical_order"].values
        )
    }
    ends = np.stack([data["critical_start"], data["critical_end"]], axis=-1)[met]
    assert {tuple(np.round(pair, 6)) for pair in ends} <= drawn
    orders = [text.get_text() for text in axes.texts if text.get_text()[:-1].isdigit()]
    assert (orders[0][:-1], orders[-1][:-1]) == ("1", "10")


def test_circles_are_where_the_running_linkage_is_amplified_most_with_the_greatest_labelled() -> (
    None
):
    """At the end of the map the amplification goes on: it has no circle there."""
    data = data_of(plots.plot_campbell)
    met, size = data["critical_order"].values, np.full(data.sizes["critical"], np.nan)
    size[:3], speed = (1.5, 3.0, 2.25), data["critical_start"].values
    assert speed[1] == data["crank_speed"].values[-1]
    known = data.assign(
        critical_amplification=("critical", size), critical_resonance=("critical", speed)
    )
    axes = plots.plot_campbell(known).axes[0]
    circles = [line.get_xydata()[0] for line in axes.lines if line.get_markersize() == 4.5]
    wanted = [[speed[n], met[n] * speed[n] / (2 * np.pi)] for n in (2, 0)]
    np.testing.assert_allclose(circles, wanted)
    assert "2.25" in [text.get_text() for text in axes.texts]


def test_operating_speeds_within_the_diagram_are_marked() -> None:
    data = data_of(plots.plot_campbell).assign_attrs(operating_speeds="10.0 40.0")
    figure = plots.plot_campbell(data)
    dotted = [line for line in figure.axes[0].lines if line.get_linestyle() == ":"]
    assert [line.get_xdata() for line in dotted] == [[10.0, 10.0]]
    assert "operating speed" in legend_texts(figure)


def test_branches_that_no_order_reaches_are_left_out_and_named() -> None:
    """Order 10 reaches 47.7 Hz: branch 1, and branch 2 where it is 20 Hz lower than here."""
    data = data_of(plots.plot_campbell)
    names = [f"{of}_frequency" for of in ("lowest", "mean", "highest")]
    lifted = data.assign({n: data[n] + 20.0 * (data["branch"] == 2) for n in names})
    figure = plots.plot_campbell(lifted)
    assert figure.axes[0].get_ylim()[1] < float(lifted["lowest_frequency"].sel(branch=2).min())
    assert "branch 2 is higher than orders reach" in heading(figure)
    assert "higher" not in heading(plots.plot_campbell(data))


def test_speeds_are_drawn_in_the_unit_of_the_user() -> None:
    in_rpm = data_of(plots.plot_campbell).assign_attrs(speed_unit="rpm")
    axes = plots.plot_campbell(in_rpm).axes
    assert axes[-1].get_xlabel() == "Crank speed (rpm)"
    assert axes[0].get_xlim() == pytest.approx((0.0, 30.0 * RPM))
    map_ = frequencies().dataset.assign_attrs(speed_unit="rpm")
    assert legend_texts(plots.plot_frequencies(map_))[0::2][:3] == ["0 rpm", "95.49 rpm", "191 rpm"]
    assert "from rest to 191 rpm" in heading(plots.plot_speed_effect(map_))


def test_growth_is_drawn_at_the_speeds_asked_for_and_its_bands_are_shaded() -> None:
    data = data_of(plots.plot_stability)
    growth, modulus = panels(figure_of(plots.plot_stability))
    curves = [line for line in growth.lines if len(line.get_xdata()) > 2]
    assert len(curves) == data.sizes["engine"] == 2
    for number, line in enumerate(curves):
        drawn = dict(zip(line.get_xdata(), line.get_ydata(), strict=True))
        rates = data["growth_rate"].isel(engine=number)
        for speed, rate in zip(data["crank_speed"].values, rates.values, strict=True):
            assert drawn[speed] == pytest.approx(rate)
    sizes = next(line for line in modulus.lines if len(line.get_xdata()) > 2)
    at = dict(zip(sizes.get_xdata(), sizes.get_ydata(), strict=True))
    # Over a turn an exponent grows to a multiplier.
    assert at[88.0] == pytest.approx(np.exp(data["growth_rate"].values[0, 1] * 2 * np.pi / 88.0))
    shaded = {(patch.get_x(), patch.get_x() + patch.get_width()) for patch in growth.patches}
    of_reference = data.isel(band=np.flatnonzero(data["band_engine"] == "reference"))
    for ends in zip(
        of_reference["band_lower"].values, of_reference["band_upper"].values, strict=True
    ):
        assert any(np.allclose(pair, ends) for pair in shaded)


def test_growth_against_a_second_parameter_is_coloured_where_it_grows() -> None:
    data = data_of(plots.plot_stability_against)
    axes = panels(figure_of(plots.plot_stability_against))[0]
    values = axes.collections[0].get_array()
    prefixes = {"crank_speed": "against", "against_speed": "against_band"}
    states, rates, speeds = (
        np.concatenate([of(along, prefix) for along, prefix in prefixes.items()], axis=-1)
        for of in (
            lambda along, prefix: data[f"{prefix}_unstable"].values[0],
            lambda along, prefix: data[f"{prefix}_growth_rate"].values[0],
            lambda along, prefix: data[along].values,
        )
    )
    order = np.argsort(speeds)
    grows = states[:, order] == "yes"
    assert 0 < grows.sum() < grows.size
    np.testing.assert_array_equal(~np.ma.getmaskarray(values), grows)
    wanted = rates[:, order][grows]
    np.testing.assert_allclose(np.ma.compressed(values), wanted)
    with pytest.raises(InputError, match="no second parameter"):
        plots.plot_stability_against(data.drop_dims("parameter"))


def test_many_speeds_are_colours_of_a_scale_in_the_unit_of_the_user() -> None:
    data = frequencies().dataset.isel(crank_speed=[0, 0, 1, 1, 1, 2, 2])
    many = data.assign_coords(crank_speed=np.linspace(-10.0, 50.0, 7))
    figure = plots.plot_frequencies(many.assign_attrs(speed_unit="rpm"))
    (bar,) = [axes for axes in figure.axes if axes.get_label() == "<colorbar>"]
    assert bar.get_ylabel() == "Crank speed (rpm)"
    assert bar.get_ylim() == pytest.approx([-10 * RPM, 50 * RPM])
    lines = panels(figure)[1].lines
    lightness = [np.dot(line.get_color()[:3], [0.3, 0.59, 0.11]) for line in lines]
    assert len(lines) == 7
    assert lightness == sorted(lightness)


def test_the_spectrum_names_the_orders_of_the_crank_and_shades_natural_frequencies() -> None:
    data, figure = data_of(plots.plot_spectrum), figure_of(plots.plot_spectrum)
    top = top_axis(figure)
    orders = np.array([int(text) for text in tick_texts(top)])
    np.testing.assert_allclose(top.get_xticks(), orders * 20.0 / (2 * np.pi))
    axes = panels(figure)[1]
    for patch, mode in zip(axes.patches, data["mode"].values, strict=True):
        box = patch.get_extents().transformed(axes.transData.inverted())
        ends = [float(data[f"{end}_natural_frequency"].sel(mode=mode)) for end in ENDS]
        np.testing.assert_allclose([box.x0, box.x1], ends)


def test_bands_of_a_spectrum_are_those_of_the_whole_turn_however_short_the_run() -> None:
    engine = flexmech.ReferenceEngine(fourbar(), 2)
    angles = np.radians(np.arange(0.0, 360.0, 2.0))
    over_turn = flexmech.natural_frequencies(engine, angles, 10.0, modes=3)
    for turns in (0.3, 1.0):
        asked = flexmech.analyses.ResponseRequest(
            10.0, revolutions=turns, samples=90, modes=3, step=1e-3, start="rigid"
        )
        data = flexmech.response(engine, asked).dataset
        for end, most in zip(ENDS, (over_turn.min(axis=0), over_turn.max(axis=0)), strict=True):
            np.testing.assert_allclose(data[f"{end}_natural_frequency"], most, rtol=2e-3)
