"""Pictures of a hammer test show the dataset's numbers."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import InputError, plots
from tests.unit.figure_checks import check_layout, legend_texts, panels
from tests.unit.hammer_data import hammer_dataset

EVERY = [plots.plot_hammer, plots.plot_frf, plots.plot_frf_parts, plots.plot_nyquist]


@pytest.mark.thorough
@pytest.mark.parametrize("plot", EVERY, ids=lambda plot: plot.__name__)
@pytest.mark.parametrize("width", [180.0, 88.0])
def test_texts_do_not_touch(plot, width):
    with plots.page_width(width):
        check_layout(plot(hammer_dataset()))


def test_the_records_are_those_of_the_first_angle():
    dataset = hammer_dataset()
    first = dataset.isel(crank_angle=0)
    force, response, coherence = panels(plots.plot_hammer(dataset))
    recorded = [line for line in force.lines if line.get_marker() == "."]
    assert len(recorded) == dataset.sizes["average"]
    found = {tuple(line.get_ydata()) for line in recorded}
    assert found == {tuple(row) for row in first["force"].values}
    assert len(response.lines) == dataset.sizes["average"]
    np.testing.assert_array_equal(coherence.lines[0].get_ydata(), first["coherence"])


def test_impacts_without_noise_are_drawn_once():
    dataset = hammer_dataset().assign_attrs(noise=0.0)
    force, response, _ = panels(plots.plot_hammer(dataset))
    assert len([line for line in force.lines if line.get_marker() == "."]) == 1
    assert len(response.lines) == 1


def test_mobility_and_accelerance_are_those_of_the_receptance():
    dataset = hammer_dataset()
    first = dataset.isel(crank_angle=0)
    receptance = first["receptance_real"].values + 1j * first["receptance_imag"].values
    turning = 2j * np.pi * first["frequency"].values
    amplitudes = panels(plots.plot_frf(dataset))
    parts = panels(plots.plot_frf_parts(dataset))
    for power in range(3):
        wanted = receptance * turning**power
        for axes, values in (
            (amplitudes[power], np.abs(wanted)),
            (parts[power], wanted.real),
            (parts[3 + power], wanted.imag),
        ):
            np.testing.assert_allclose(axes.lines[1].get_ydata(), values)
    phase = amplitudes[3].lines[1].get_ydata()
    drawn = np.isfinite(phase)
    np.testing.assert_allclose(phase[drawn], np.degrees(np.angle(receptance))[drawn])
    assert legend_texts(plots.plot_frf(dataset)) == [
        "eigen model, exact",
        "measured (H1)",
        "identified modes",
    ]


def test_circles_are_the_mobility_about_each_mode():
    dataset = hammer_dataset()
    circles = panels(plots.plot_nyquist(dataset))
    assert [axes.get_title("left").split(":")[0] for axes in circles] == ["Mode 1", "Mode 2"]
    for mode, axes in enumerate(circles):
        own = dataset.isel(crank_angle=0, mode=mode)
        around = own["circle_frequency"].values
        for line, name in zip(axes.lines, ("exact", "identified"), strict=False):
            parts = [own[f"circle_{name}_receptance_{part}"].values for part in ("real", "imag")]
            mobility = 2j * np.pi * around * (parts[0] + 1j * parts[1])
            np.testing.assert_allclose(line.get_xdata() + 1j * line.get_ydata(), mobility)
            # The far end of a circle is at its natural frequency, but for the other mode.
            farthest = around[np.argmax(np.abs(mobility))]
            eigen, ratio = float(own["eigen_frequency"]), float(own["eigen_damping_ratio"])
            assert abs(farthest - eigen) < 0.5 * ratio * eigen


def test_without_identified_modes_there_is_no_circle():
    dataset = hammer_dataset()
    dataset["identified_frequency"][0] = np.nan
    with pytest.raises(InputError, match="no mode was identified"):
        plots.plot_nyquist(dataset)
