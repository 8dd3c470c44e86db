"""Figures of records, of designs and of studies: points, bars and areas are the dataset."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.axes import Axes

from flexmech import InputError, plots
from tests.support import results
from tests.support.figure_checks import panels
from tests.support.figures import data_of, figure_of
from tests.support.results import THICKNESS


def upright_lines(axes: Axes) -> list[float]:
    return [
        float(line.get_xdata()[0])
        for line in axes.lines
        if len(line.get_xdata()) == 2 and line.get_xdata()[0] == line.get_xdata()[1]
    ]


def test_recorded_impacts_are_points_of_force_and_displacement_in_small_units() -> None:
    data = data_of(plots.plot_hammer).isel(crank_angle=0)
    force, response, _ = panels(figure_of(plots.plot_hammer))
    assert force.get_ylabel() == "Force (mN)"
    assert response.get_ylabel() == "Displacement (nm)"
    recorded = [line for line in force.lines if line.get_marker() == "."]
    assert len(recorded) == len(response.lines) == data.sizes["average"]
    for lines, values in (
        (recorded, 1e3 * data["force"]),
        (response.lines, 1e9 * data["response"]),
    ):
        drawn = sorted(line.get_ydata().tolist() for line in lines)
        np.testing.assert_allclose(drawn, sorted(values.values.tolist()))


def test_driving_power_is_on_a_second_axis_of_the_torque_with_its_means() -> None:
    data, axes = data_of(plots.plot_drive), panels(figure_of(plots.plot_drive))[0]
    power = axes.child_axes[0]
    axes.figure.draw_without_rendering()
    assert power.get_ylabel() == "Power (W)"
    limits = data.attrs["crank_speed"] * np.array(axes.get_ylim())
    np.testing.assert_allclose(power.get_ylim(), limits)
    torque, angle = data["driving_torque"].values, data["crank_angle"].values
    rms = np.sqrt(np.trapezoid(torque**2, angle) / np.ptp(angle))
    levels = [line.get_ydata()[0] for line in axes.lines if np.ptp(line.get_ydata()) == 0]
    assert min(abs(level - rms) for level in levels) < 1e-4 * rms


def test_nyquist_circles_are_the_mobility_about_each_mode() -> None:
    data = data_of(plots.plot_nyquist).isel(crank_angle=0)
    for mode, axes in enumerate(panels(figure_of(plots.plot_nyquist))):
        circle = data.isel(mode=mode)
        assert axes.get_ylabel() == "Im (m/(N s))"
        for line, name in zip(axes.lines, ("exact", "identified"), strict=False):
            parts = [circle[f"circle_{name}_receptance_{part}"].values for part in ("real", "imag")]
            mobility = 2j * np.pi * circle["circle_frequency"].values * (parts[0] + 1j * parts[1])
            np.testing.assert_allclose(line.get_xdata() + 1j * line.get_ydata(), mobility)
    assert axes.get_aspect() == 1.0


def test_stabilisation_marks_identified_frequencies_and_shapes_their_parts() -> None:
    data = data_of(plots.plot_stabilisation).isel(crank_angle=0)
    chart = panels(figure_of(plots.plot_stabilisation))[0]
    (triangles,) = [line for line in chart.lines if line.get_marker() == "^"]
    np.testing.assert_array_equal(triangles.get_xdata(), data["identified_frequency"])
    for mode, axes in enumerate(panels(figure_of(plots.plot_impact_shapes))):
        drawn = [np.asarray(line.get_ydata()) for line in axes.lines]
        for part in ("real", "imag"):
            wanted = data[f"shape_{part}"].values[:, mode]
            assert any(len(y) == len(wanted) and np.allclose(y, wanted) for y in drawn)
        assert f"MAC {float(data['mac'][mode]):.4f}" in axes.get_title("left")


def test_a_section_is_drawn_over_its_height_with_and_without_coupling() -> None:
    data, figure = data_of(plots.plot_section), figure_of(plots.plot_section)
    place = 1e3 * data["place"].values.ravel()
    for title, name, load, label, factor in (
        ("Strain, N = 1 N", "strain", "axial_force", "Strain ($10^{-9}$)", 1e9),
        ("Strain, M = 1 N m", "strain", "bending_moment", "Strain ($10^{-6}$)", 1e6),
        (
            "Normal stress, M = 1 N m",
            "normal_stress",
            "bending_moment",
            "Normal stress (MPa)",
            1e-6,
        ),
        ("Shear stress, V = 1 N", "shear_stress", "shear_force", "Shear stress (kPa)", 1e-3),
    ):
        (axes,) = [each for each in figure.axes if each.get_title("left") == title]
        assert axes.get_xlabel() == label
        drawn = [np.asarray(line.get_xydata(), dtype=float) for line in axes.lines]
        for coupling in ("with", "without"):
            values = factor * data[name].sel(load=load, coupling=coupling).values.ravel()
            shown = np.stack([values, place], axis=-1)
            assert any(line.shape == shown.shape and np.allclose(line, shown) for line in drawn)
    (layers,) = [each for each in figure.axes if each.get_title("left") == "Layers"]
    assert [text.get_text().split()[0] for text in layers.texts] == ["C", "G"]


def test_harmonics_of_the_shaking_force_are_bars_of_each_order() -> None:
    data = data_of(plots.plot_shaking_orders)
    force, _ = panels(figure_of(plots.plot_shaking_orders))
    bars = [path.get_extents() for path in force.collections[0].get_paths()]
    np.testing.assert_allclose([(bar.x0 + bar.x1) / 2 for bar in bars], data["order"])
    np.testing.assert_allclose([bar.height for bar in bars], data["shaking_force_order"], atol=1e-9)
    shown = dict(
        zip(force.get_xticks(), [tick.get_text() for tick in force.get_xticklabels()], strict=True)
    )
    assert shown == {float(order): str(order) for order in data["order"].values.tolist()}


def test_designs_within_and_beyond_the_limit_are_told_apart() -> None:
    data, (frequency, mass) = data_of(plots.plot_designs), panels(figure_of(plots.plot_designs))
    assert [axes.get_title("left") for axes in (frequency, mass)] == ["f1 (Hz)", "mass (kg)"]
    within = data["within"].values
    assert 0 < within.sum() < within.size
    places = np.stack([data[THICKNESS], data["materials.aluminium.density"]], axis=-1)
    for axes in (frequency, mass):
        by_mark = {line.get_marker(): np.asarray(line.get_xydata()) for line in axes.lines}
        np.testing.assert_allclose(by_mark["o"], places[within])
        np.testing.assert_allclose(by_mark["x"], places[~within])
    one = data.isel(design=np.flatnonzero(data["materials.aluminium.density"] == 2800.0))
    limit, line = panels(plots.plot_designs(one))[0].lines[:2]
    np.testing.assert_allclose(line.get_ydata(), one["f1"])
    assert set(limit.get_ydata()) == {44.0}


def test_distributions_have_unit_area_and_the_percentiles_of_the_dataset() -> None:
    data = data_of(plots.plot_distributions)
    frequency, mass = panels(figure_of(plots.plot_distributions))
    percentiles = [float(data[name].sel(output="f1")) for name in ("p2_5", "p50", "p97_5")]
    np.testing.assert_allclose(sorted(upright_lines(frequency)), sorted([*percentiles, 44.0]))
    assert len(upright_lines(mass)) == 3
    (edge,) = [path.vertices for path in frequency.collections[0].get_paths()]
    area = abs(np.sum(edge[:-1, 0] * edge[1:, 1] - edge[1:, 0] * edge[:-1, 1])) / 2
    assert area == pytest.approx(1.0)


def test_shares_of_the_variance_are_points_with_their_intervals() -> None:
    data, axes = data_of(plots.plot_sensitivity), panels(figure_of(plots.plot_sensitivity))[0]
    own = data.sel(output="f1")
    points = [line for line in axes.lines if line.get_marker() in ("o", "s")]
    broken = [line.get_xdata() for line in axes.lines if np.isnan(line.get_xdata()).any()]
    intervals = [x.reshape(-1, 3) for x in broken]
    for dots, ends, name in zip(points, intervals, ("first_order", "total"), strict=True):
        np.testing.assert_allclose(dots.get_xdata(), own[name])
        np.testing.assert_allclose(ends[:, :2], own[[f"{name}_low", f"{name}_high"]].to_array().T)
        assert np.isnan(ends[:, 2]).all()
    without = data.drop_dims("input").assign_attrs(no_shares="inputs are correlated")
    with pytest.raises(InputError, match="correlated"):
        plots.plot_sensitivity(without)


def test_bands_of_frequencies_lie_between_their_percentiles() -> None:
    data = data_of(plots.plot_frequency_bands)
    axes = panels(figure_of(plots.plot_frequency_bands))[0]
    low, _, high = data["frequency_percentile"].sel(mode=1).values
    drawn = axes.collections[0].get_paths()[0].vertices[:, 1]
    assert set(low) | set(high) <= set(drawn)


def test_the_front_is_in_the_order_of_its_first_goal() -> None:
    data, (axes,) = data_of(plots.plot_pareto), figure_of(plots.plot_pareto).axes
    order = np.argsort(data["mass"].values)
    (line,) = axes.lines
    wanted = np.stack([data["mass"], data["f1"]], axis=-1)[order]
    np.testing.assert_array_equal(line.get_xydata(), wanted)
    one_goal = data.isel(goal=[0]).assign_attrs(goals="min mass")
    with pytest.raises(InputError, match="one goal has one best design"):
        plots.plot_pareto(one_goal)


def test_deviations_of_the_verification_stand_over_their_tolerances() -> None:
    data = results.verified().dataset
    axes = figure_of(plots.plot_verification).axes[0]
    passed = np.concatenate([line.get_xdata() for line in axes.lines if line.get_marker() == "o"])
    wanted = np.clip((data["deviation"] / data["tolerance"]).values.ravel(), 1e-6, None)
    np.testing.assert_allclose(np.sort(passed), np.sort(wanted))
