"""Natural frequencies against crank speed, at given crank angles."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.plots import angle_panels, reading, scales
from flexmech.plots.layout import AxesLike, sheet

# Lines of a panel: of more crank angles the map over the angle says more.
MOST_ANGLES = 6
# Crank angles that make no curve over the angle, and crank speeds that make one.
POINTS, CURVE = 2, 3


def has_few_angles(dataset: xr.Dataset) -> bool:
    """Whether a map has few crank angles and more crank speeds, so that these make the curves."""
    angles, speeds = dataset.sizes["crank_angle"], dataset.sizes["crank_speed"]
    return angles <= MOST_ANGLES and speeds >= max(CURVE, angles + 1)


def has_no_curve_over_angle(dataset: xr.Dataset) -> bool:
    """Whether that map has so few crank angles that over them there are points alone."""
    return has_few_angles(dataset) and dataset.sizes["crank_angle"] <= POINTS


def plot_frequencies_over_speed(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw natural frequencies against crank speed, one panel a mode, one line a crank angle.

    Modes are in order of frequency at each speed. The first engine is drawn as lines, the others
    as markers. Of more than six crank angles six are drawn, evenly spread.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result; frequencies in Hz, angles in rad, speeds in rad/s.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    dataset = dataset.sortby(["crank_speed", "crank_angle"])
    count = dataset.sizes["crank_angle"]
    places = np.round(np.linspace(0, count - 1, min(count, MOST_ANGLES))).astype(int)
    dataset = dataset.isel(crank_angle=places)
    frequency = reading.values_of(dataset["frequency"], *reading.MAP)
    speeds, names = reading.speeds_of(dataset), []
    for angle in reading.degrees(dataset["crank_angle"]).tolist():
        names.append(f"{angle:.6g} deg")
    nowhere = np.zeros((len(speeds), 1), dtype=int)
    layout = angle_panels.angle_layout([1] * dataset.sizes["mode"])
    with sheet(layout, ax=ax, fewer=angle_panels.ONE_MODE) as drawn:
        handles = angle_panels.series_and_engines(dataset, names, along="crank_speed")
        drawn.header(handles, "Natural frequencies over crank speed", of=dataset)
        for number, (axes, mode) in enumerate(
            zip(drawn.panels, dataset["mode"].values.tolist(), strict=True)
        ):
            drawn.title(axes, reading.mode_label([mode]))
            axes.set_xlim(*scales.speed_limits(dataset))
            scales.scale_y(axes, frequency[..., number], least_part=scales.FREQUENCY_BAND)
            for place in range(len(names)):
                values = frequency[:, :, place, number, None]
                angle_panels.draw_series(axes, speeds, values, nowhere, place, len(names))
        drawn.label_x(f"Crank speed ({reading.speed_unit(dataset)})")
        drawn.label_y("Frequency (Hz)")
    return drawn.figure
