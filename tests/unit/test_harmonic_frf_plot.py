"""The picture of harmonic transfer functions shows the dataset's numbers."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import plots
from tests.support.figure_checks import check_layout, drawn, heading, legend_texts, panels, y_labels
from tests.support.running_hammer_data import (
    FREQUENCY,
    IDENTIFIED,
    ORDERS,
    resonance,
    running_hammer_dataset,
)


def test_amplitude_and_phase_of_each_order_are_the_datasets() -> None:
    figure = plots.plot_harmonic_frf(running_hammer_dataset())
    for row in range(len(ORDERS)):
        amplitude, phase = panels(figure)[2 * row : 2 * row + 2]
        frozen, identified, predicted = (np.asarray(line.get_ydata()) for line in amplitude.lines)
        np.testing.assert_allclose(predicted, np.abs(resonance()[row]))
        np.testing.assert_allclose(identified, IDENTIFIED * predicted)
        assert frozen.max() < predicted.max()
        angle = drawn(phase, plots.SERIES_STYLES[0].color)
        shown = np.isfinite(angle)
        np.testing.assert_allclose(angle[shown], np.degrees(np.angle(resonance()[row]))[shown])
        assert shown[FREQUENCY < 50.0].all()
        assert amplitude.get_yscale() == "log"
    check_layout(figure)


def test_each_panel_says_which_order_it_is() -> None:
    labels = y_labels(plots.plot_harmonic_frf(running_hammer_dataset()))
    assert [label.split("{")[1].split("}")[0] for label in labels[::2]] == ["-1", "0", "+1"]
    assert all(label.endswith("(m/N)") for label in labels[::2])


def test_heading_names_points_speed_and_engine_and_the_legend_the_lines() -> None:
    figure = plots.plot_harmonic_frf(running_hammer_dataset(speed_unit="rpm"))
    for word in ("rocker:0.5", "coupler:0.5", "191 rpm", "exudyn"):
        assert word in heading(figure)
    assert legend_texts(figure) == [
        "identified from impacts",
        "predicted by the periodic model",
        "frozen linkage",
    ]


@pytest.mark.parametrize("orders", [(0,), (-1, 0)])
def test_few_orders_have_few_panels(orders: tuple[int, ...]) -> None:
    dataset = running_hammer_dataset().sel(order=list(orders))
    assert len(panels(plots.plot_harmonic_frf(dataset))) == 2 * len(orders)


def test_an_order_that_answers_nothing_is_drawn_empty() -> None:
    """As every other order of a rotating arm."""
    dataset = running_hammer_dataset()
    for name in ("receptance", "predicted", "frozen"):
        for part in ("real", "imag"):
            dataset[f"{name}_{part}"].loc[{"order": 1}] = 0.0
    amplitude = panels(plots.plot_harmonic_frf(dataset))[4]
    assert all(np.isnan(line.get_ydata()).all() for line in amplitude.lines)
