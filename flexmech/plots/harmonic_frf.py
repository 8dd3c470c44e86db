"""Harmonic transfer functions of the running linkage, order by order."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.plots import scales, style
from flexmech.plots.labels import speed_text
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.reading import values_of
from flexmech.plots.series import Look, line_handle, series_style
from flexmech.types import ComplexArray

# What a row of panels and what the axes take, in inches; on a narrow page each row becomes two.
ROW, NARROW_ROW, AXES_HEIGHT = 1.25, 0.75, 0.7
# Room above the greatest amplitude, and how far below it the axis reaches at most.
HEADROOM, DECADES = 2.0, 4.5
IDENTIFIED: Look = {"color": series_style(1).color, "lw": 2.4, "alpha": 0.55}
PREDICTED: Look = {"color": series_style(0).color, "lw": 0.9}
FROZEN: Look = {"color": style.MID_GREY, "lw": 0.9, "ls": (0.0, (4.0, 2.0))}
# A phase is drawn where its amplitude is above this part of the order's greatest.
LEAST_AMPLITUDE = 1e-4


def plot_harmonic_frf(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw amplitude and phase of each harmonic transfer function, a row an order.

    Along x is the frequency of the force; the response of order n is at that frequency and n
    times the crank's. Broad is what was identified from impacts, thin what is predicted, dashed
    what the frozen linkage would answer, by the Fourier series of its receptance over the turn.

    Parameters
    ----------
    dataset : Dataset
        Of a ``RunningHammerTest`` result.
    ax : Axes or sequence of Axes, optional
        The user's: amplitude and phase of each order. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    orders = dataset["order"].values.tolist()
    frequency = dataset["frequency"].values
    functions = [(_function(dataset, name), look) for name, look in _looks()]
    low, high = _limits([values for values, _ in functions])
    row_height = NARROW_ROW if style.is_narrow() else ROW
    layout = grid(len(orders), 2, row_height * len(orders) + AXES_HEIGHT / 2, sharex=True)
    with sheet(layout, ax=ax) as drawn:
        drawn.header(_handles(), _title(dataset), of=dataset)
        for row, order in enumerate(orders):
            amplitude, phase = drawn.panels[2 * row : 2 * row + 2]
            for values, look in functions:
                size = np.abs(values[row])
                amplitude.plot(frequency, np.where(size > 0, size, np.nan), **look)
                phase.plot(frequency, _phase(values[row]), **look)
            scales.log_scale(amplitude, low, high)
            amplitude.set_ylabel(f"|H$_{{{_signed(order)}}}$| (m/N)")
            _degrees(phase)
            phase.set_ylabel(f"∠H$_{{{_signed(order)}}}$ (deg)")
            for axes in (amplitude, phase):
                axes.set_xlim(frequency[0], frequency[-1])
        drawn.label_x("Frequency f of the force (Hz)")
    return drawn.figure


def _looks() -> tuple[tuple[str, Look], ...]:
    return (("frozen", FROZEN), ("receptance", IDENTIFIED), ("predicted", PREDICTED))


def _handles() -> list[Artist]:
    return [
        line_handle("identified from impacts", **IDENTIFIED),
        line_handle("predicted by the periodic model", **PREDICTED),
        line_handle("frozen linkage", **FROZEN),
    ]


def _title(dataset: xr.Dataset) -> str:
    attrs = dataset.attrs
    return (
        f"From {attrs['impact_point']} at f to {attrs['response_point']} at f + n f$_{{crank}}$; "
        f"{speed_text(dataset)}, {attrs['engine']} engine"
    )


def _function(dataset: xr.Dataset, name: str) -> ComplexArray:
    real, imaginary = (
        values_of(dataset[f"{name}_{part}"], "order", "frequency") for part in ("real", "imag")
    )
    return real + 1j * imaginary


def _limits(functions: list[ComplexArray]) -> tuple[float, float]:
    """Of all amplitudes, from a few decades below the greatest."""
    size = np.abs(np.array(functions))
    greatest = float(size.max())
    if greatest == 0:
        return 1e-9, 1.0
    least = float(size[size > 0].min())
    return max(least / HEADROOM, greatest * 10**-DECADES), greatest * HEADROOM


def _phase(values: ComplexArray) -> np.ndarray:
    """In degrees, broken where it jumps from one end to the other and where nothing answers."""
    size = np.abs(values)
    angle = np.degrees(np.angle(values))
    angle[size <= LEAST_AMPLITUDE * size.max()] = np.nan
    angle[1:][np.abs(np.diff(angle)) > 180.0] = np.nan
    return angle


def _degrees(axes: Axes) -> None:
    axes.set_ylim(-190.0, 190.0)
    axes.set_yticks([-180, -90, 0, 90, 180])


def _signed(order: int) -> str:
    if not order:
        return "0"
    return f"{'+' if order > 0 else '-'}{abs(order)}"
