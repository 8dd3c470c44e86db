"""What is drawn of a comparison is its dataset, and nothing is clipped or overlaps."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import plots
from tests.support.comparison_data import drawn_dataset
from tests.support.figure_checks import check_layout, heading, legend_texts, panels


@pytest.mark.parametrize("kind", ["time", "frequency", "sample"])
@pytest.mark.parametrize("width", [88.0, pytest.param(180.0, marks=pytest.mark.thorough)])
def test_layout(kind, width):
    with plots.page_width(width):
        check_layout(plots.plot_comparison(drawn_dataset(kind)))


def test_curves_residual_and_spectra_over_time():
    data = drawn_dataset()
    figure = plots.plot_comparison(data)
    curves, residual, spectra = panels(figure)
    drawn = [line.get_ydata() for line in curves.lines if len(line.get_ydata()) > 2]
    np.testing.assert_allclose(drawn[0], 1e6 * data["measured"])
    np.testing.assert_allclose(drawn[1], 1e6 * data["computed"])
    np.testing.assert_allclose(residual.lines[-1].get_ydata(), 1e6 * data["residual"])
    np.testing.assert_allclose(spectra.lines[2].get_ydata(), 1e6 * data["spectrum"][2, 1:])
    assert spectra.get_yscale() == "log"
    assert legend_texts(figure) == ["measured", "computed", "residual"]
    assert "damping 36.00 ± 0.72 µs, stiffness:coupler 1.010 ± 0.020" in " ".join(
        heading(figure).split()
    )
    assert "at 20 rad/s" in heading(figure)


def test_amplitude_and_phase_of_a_function():
    data = drawn_dataset("frequency")
    amplitude, phase, residual = panels(plots.plot_comparison(data))
    measured = data["measured_real"].values + 1j * data["measured_imag"].values
    factor = 1e3 if "mm/N" in amplitude.get_ylabel() else 1e6
    np.testing.assert_allclose(amplitude.lines[0].get_ydata(), factor * np.abs(measured))
    np.testing.assert_allclose(phase.lines[0].get_ydata(), np.degrees(np.angle(measured)))
    assert residual.get_ylabel().startswith("Residual")


def test_frequencies_of_each_mode():
    data = drawn_dataset("sample")
    upper, lower = panels(plots.plot_comparison(data))
    second = data["measured"].values[data["mode"].values == 2]
    np.testing.assert_allclose(upper.lines[2].get_ydata(), second)
    assert len(lower.lines) == 3


def test_a_comparison_without_a_fit_names_none():
    assert "±" not in heading(plots.plot_comparison(drawn_dataset(fitted=False)))
