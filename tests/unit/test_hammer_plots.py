"""Pictures of a hammer test show the dataset's numbers."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import InputError, plots
from flexmech.plots.reading import FORCE_UNITS, fitting_unit
from tests.support.figure_checks import check_layout, heading, legend_texts, panels
from tests.support.hammer_data import hammer_dataset

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
    factor, unit = fitting_unit(first["pulse_force"].values, FORCE_UNITS)
    assert force.get_ylabel() == f"Force ({unit})"
    found = {tuple(line.get_ydata()) for line in recorded}
    assert found == {tuple(row) for row in factor * first["force"].values}
    assert len(response.lines) == dataset.sizes["average"]
    np.testing.assert_array_equal(coherence.lines[0].get_ydata(), first["coherence"])


def test_impacts_without_noise_are_drawn_once():
    dataset = hammer_dataset().assign_attrs(noise=0.0)
    # Their coherence, which is 1 everywhere, is left out.
    force, response = panels(plots.plot_hammer(dataset))
    assert len([line for line in force.lines if line.get_marker() == "."]) == 1
    assert len(response.lines) == 1


def test_waves_of_the_response_can_be_told_from_each_other():
    dataset = hammer_dataset()
    time = np.arange(4001) * 1e-3
    dims, shape = dataset["response"].dims, (*dataset["response"].shape[:-1], len(time))
    for rate, waves in ((1.0, 100), (4.0, 45.0 * np.log(50.0) / 4.0)):
        decaying = np.exp(-rate * time) * np.sin(2 * np.pi * 45.0 * time)
        record = (dims, np.broadcast_to(decaying, shape))
        long = dataset.drop_dims("time").assign(response=record, force=record)
        response = panels(plots.plot_hammer(long.assign_coords(time=time)))[1]
        # Until a hundredth wave, or until a fiftieth is left of the greatest displacement.
        assert response.get_xlim()[1] == pytest.approx(waves / 45.0, rel=0.02)
        assert response.get_xlabel() == "Time (s), beginning of a record of 4 s"


def test_parts_are_drawn_so_that_small_resonances_show():
    dataset = hammer_dataset()
    for axes in panels(plots.plot_frf_parts(dataset)):
        assert axes.get_yscale() == "symlog"
        values = np.concatenate([line.get_ydata() for line in axes.lines])
        low, high = axes.get_ylim()
        assert low < values.min()
        assert values.max() < high
        # A thousandth of the greatest stands clear of zero.
        part = 1e-3 * np.abs(values).max()
        to_pixels = axes.transData.transform([(0.0, 0.0), (0.0, part), (0.0, -part)])[:, 1]
        assert np.abs(to_pixels[1:] - to_pixels[0]).max() > 0.15 * axes.bbox.height


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
            mobility *= {"Im (m/(N s))": 1.0, "Im (mm/(N s))": 1e3}[axes.get_ylabel()]
            np.testing.assert_allclose(line.get_xdata() + 1j * line.get_ydata(), mobility)
            # The far end of a circle is at its natural frequency, but for the other mode.
            farthest = around[np.argmax(np.abs(mobility))]
            eigen, ratio = float(own["eigen_frequency"]), float(own["eigen_damping_ratio"])
            assert abs(farthest - eigen) < 0.5 * ratio * eigen


def test_modes_without_a_circle_are_left_out_and_named():
    dataset = hammer_dataset()
    around = dataset["circle_frequency"].isel(mode=1)
    for curve in ("exact", "identified"):
        for part, straight in (("real", 0.0 * around), ("imag", 1e-3 / around)):
            values = dataset[f"circle_{curve}_receptance_{part}"]
            values[{"mode": 1}] = straight.transpose(*values.isel(mode=1).dims)
    figure = plots.plot_nyquist(dataset)
    assert [axes.get_title("left").split(":")[0] for axes in panels(figure)] == ["Mode 1"]
    assert "without a circle here: mode 2" in " ".join(heading(figure).split())


def test_dots_do_not_hide_the_circle():
    dataset = hammer_dataset()
    lines = dataset["frequency"].values
    fine = dataset.interp(frequency=np.linspace(lines[0], lines[-1], 50 * len(lines)))
    for axes in panels(plots.plot_nyquist(fine)):
        dots = next(line for line in axes.lines if line.get_marker() == ".")
        assert 20 <= len(dots.get_xdata()) <= 40


def test_a_circle_far_from_zero_fills_its_panel():
    """As that of a small mode beside a large one, which adds nearly the same at all lines."""
    dataset = hammer_dataset()
    for name, over in (
        ("receptance", "frequency"),
        ("circle_exact_receptance", "circle_frequency"),
        ("circle_identified_receptance", "circle_frequency"),
    ):
        # A mobility of -100j.
        dataset[f"{name}_real"] -= 100.0 / (2 * np.pi * dataset[over])
    for axes in panels(plots.plot_nyquist(dataset)):
        axes.figure.draw_without_rendering()
        low, high = axes.get_ylim()
        assert high < 0
        assert (
            max(axes.dataLim.height / (high - low), axes.dataLim.width / np.ptp(axes.get_xlim()))
            > 0.85
        )


def test_without_identified_modes_there_is_no_circle():
    dataset = hammer_dataset()
    dataset["identified_frequency"][0] = np.nan
    with pytest.raises(InputError, match="no mode was identified"):
        plots.plot_nyquist(dataset)
