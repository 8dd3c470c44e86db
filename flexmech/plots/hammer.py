"""Records of a hammer test: the pulse, the response, and their coherence."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.plots.frf import first_angle, hammer_title
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.reading import LENGTH_UNITS, fitting_unit
from flexmech.plots.series import Look, line_handle, series_line

HEIGHT = 4.6
# What is drawn of the force's record, in pulse durations about its start.
BEFORE_PULSE, AFTER_PULSE = 2.0, 4.0
MOST_RECORDS = 6
PULSE: Look = {"color": "0.75", "lw": 2.6}
DOTS: Look = {"marker": ".", "markersize": 4.0}
THREE = "give three Axes"


def plot_hammer(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw force pulse, response in time, and coherence over frequency.

    Parameters
    ----------
    dataset : Dataset
        Of a ``HammerTest`` result; the records of its first crank angle are drawn.
    ax : Axes or sequence of Axes, optional
        The user's, three. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    data = first_angle(dataset)
    start, pulse = (float(data.attrs[name]) for name in ("pulse_start", "pulse"))
    time = data["time"].values
    count = min(MOST_RECORDS, data.sizes["average"])
    with sheet(grid(3, 1, HEIGHT), ax=ax, fewer=THREE) as drawn:
        # Impacts without noise are the same.
        count = count if data.attrs["noise"] else 1
        handles = [line_handle("force of the hammer", **PULSE)] + [
            line_handle(f"impact {number + 1}, as recorded", **(series_line(number) | DOTS))
            for number in range(count)
        ]
        drawn.header(handles, hammer_title(dataset), of=dataset)
        force, response, coherence = drawn.panels
        scale, unit = fitting_unit(data["response"].values, LENGTH_UNITS)
        force.plot(1e3 * data["pulse_time"].values, data["pulse_force"].values, **PULSE)
        for number in reversed(range(count)):
            look = series_line(number) | {"lw": 0.8}
            force.plot(1e3 * time, data["force"].values[number], **(look | DOTS))
            response.plot(time, scale * data["response"].values[number], **look)
        force.set_xlim(1e3 * (start - BEFORE_PULSE * pulse), 1e3 * (start + AFTER_PULSE * pulse))
        force.set_xlabel("Time (ms)")
        force.set_ylabel("Force (N)")
        force.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))
        response.set_xlim(0.0, float(time[-1]))
        response.set_xlabel("Time (s)")
        response.set_ylabel(f"Displacement ({unit})")
        look = series_line(0) | {"lw": 0.8}
        coherence.plot(data["frequency"].values, data["coherence"].values, **look)
        coherence.set_xlim(0.0, float(data["frequency"].values[-1]))
        coherence.set_ylim(min(0.0, float(np.nanmin(data["coherence"]))), 1.05)
        coherence.set_xlabel("Frequency (Hz)")
        coherence.set_ylabel("Coherence")
    return drawn.figure
