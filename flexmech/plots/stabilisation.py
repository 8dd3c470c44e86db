"""The stabilisation chart: poles of models of rising order over the receptance."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.errors import InputError
from flexmech.plots import style
from flexmech.plots.frf import first_angle
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.series import Look, line_handle, series_style

HEIGHT = 3.0
# Of the orders' axis, that the receptance behind the poles takes.
BEHIND = 0.9
CURVE: Look = {"color": style.MID_GREY, "lw": 0.8, "zorder": 1}
EIGEN: Look = {"color": "0.1", "lw": 0.8, "ls": (0, (1, 2)), "zorder": 1.5}
# On the axis: modes that the fit keeps, since noise does not explain them as well.
IDENTIFIED: Look = {
    "marker": "^",
    "markersize": 6.5,
    "color": series_style(2).color,
    "ls": "none",
    "clip_on": False,
    "zorder": 5,
}
STATES: dict[str, tuple[str, Look]] = {
    "new": (
        "new pole",
        {"marker": ".", "markersize": 2.5, "color": "0.6", "markeredgewidth": 0.0, "ls": "none"},
    ),
    "frequency": (
        "stable in frequency",
        {
            "marker": "o",
            "markersize": 3.5,
            "color": series_style(0).color,
            "markerfacecolor": "white",
            "markeredgewidth": 0.8,
            "ls": "none",
        },
    ),
    "stable": (
        "stable in damping as well",
        {"marker": "o", "markersize": 3.5, "color": series_style(0).color, "ls": "none"},
    ),
    "chosen": (
        "chosen to begin the fit",
        {
            "marker": "D",
            "markersize": 5.5,
            "color": series_style(1).color,
            "ls": "none",
            "zorder": 4,
        },
    ),
}
NO_CHART = (
    "this hammer test has no stabilisation chart: its modes were identified by peaks and circles; "
    'install flexmech[modal-test] and ask for method="lscf"'
)


def plot_stabilisation(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the poles of models of rising order over frequency, at the first crank angle.

    Behind them is the receptance on a logarithmic scale of its own, and dotted are the natural
    frequencies of the eigen model. Triangles on the axis are the modes identified: a pole that was
    chosen to begin the fit is dropped by it where noise explains the receptances as well.

    Parameters
    ----------
    dataset : Dataset
        Of a ``HammerTest`` result whose modes were identified by LSCF.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there is no chart.
    """
    if "chart_order" not in dataset:
        raise InputError(NO_CHART)
    with sheet(grid(1, 1, HEIGHT), ax=ax) as drawn:
        drawn.header(_handles(), _title(dataset), of=dataset)
        _draw(drawn.panels[0], first_angle(dataset))
        drawn.label_x("Frequency (Hz)")
        drawn.label_y("Modes of the model")
    return drawn.figure


def _draw(axes: Axes, one: xr.Dataset) -> None:
    orders = float(np.nanmax(one["chart_order"].values))
    lines = one["frequency"].values
    level = np.log(np.abs(one["receptance_real"].values + 1j * one["receptance_imag"].values))
    finite = np.isfinite(level)
    low, high = level[finite].min(), level[finite].max()
    part = (level - low) / (high - low) if high > low else np.zeros_like(level)
    axes.plot(lines[finite], BEHIND * orders * part[finite], **CURVE)
    for frequency in one["eigen_frequency"].values:
        if np.isfinite(frequency):
            axes.axvline(frequency, **EIGEN)
    state = one["chart_state"].values
    for name, (_, look) in STATES.items():
        which = state == name
        axes.plot(one["chart_frequency"].values[which], one["chart_order"].values[which], **look)
    identified = one["identified_frequency"].values
    axes.plot(identified, np.zeros_like(identified), **IDENTIFIED)
    axes.set_xlim(0.0, float(lines[-1]))
    axes.set_ylim(0.0, 1.04 * orders)


def _handles() -> list[Artist]:
    poles = [line_handle(words, **look) for words, look in STATES.values()]
    return [
        *poles,
        line_handle("identified", **IDENTIFIED),
        line_handle("receptance, logarithmic", **CURVE),
        line_handle("eigen model", **EIGEN),
    ]


def _title(dataset: xr.Dataset) -> str:
    degrees = float(np.degrees(first_angle(dataset)["crank_angle"]))
    response = dataset.attrs["response_point"]
    return f"Stabilisation chart at crank angle {degrees:.6g} deg, response at {response}"
