"""Transmission angle against crank angle."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from flexmech.errors import InputError
from flexmech.plots.style import (
    LIGHT_GREY,
    MID_GREY,
    SERIES_STYLES,
    crank_angle_axis,
    header_height,
    header_legend,
    new_figure,
    publication_style,
    series_handle,
    series_style,
)
from flexmech.types import FloatArray

__all__ = ["plot_transmission_angle"]

HEIGHT = 3.2


def plot_transmission_angle(
    crank_angle: FloatArray,
    curves: Mapping[str, FloatArray],
    band: tuple[float, float] | None = None,
    band_label: str = "range",
) -> Figure:
    """Draw transmission angles of linkages over the crank's turn.

    As Elamy et al. 2023, Figure 7.

    Parameters
    ----------
    crank_angle : ndarray, shape (A,)
        In rad.
    curves : mapping of str to ndarray, shape (A,)
        Transmission angles in rad, by what the legend calls them.
    band : tuple of float, optional
        Range to shade, in rad.
    band_label : str
        What the legend calls it.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there are no curves, or more than there are styles to tell them apart.
    """
    if not 1 <= len(curves) <= len(SERIES_STYLES):
        raise InputError(f"one to {len(SERIES_STYLES)} curves can be drawn, got {len(curves)}")
    with publication_style():
        title = "Transmission angle over a turn of the crank"
        handles: list[Artist] = [series_handle(n, name) for n, name in enumerate(curves)]
        if band is not None:
            handles.append(Patch(color=LIGHT_GREY, label=band_label))
        figure = new_figure(HEIGHT + header_height(handles, title))
        axes = figure.subplots()
        degrees = np.degrees(crank_angle)
        axes.axhline(90.0, color=MID_GREY, lw=0.6, zorder=1)
        if band is not None:
            axes.axhspan(*np.degrees(band), color=LIGHT_GREY, zorder=0)
        for number, values in enumerate(curves.values()):
            style = series_style(number)
            axes.plot(degrees, np.degrees(values), color=style.color, linestyle=style.linestyle)
        crank_angle_axis(axes, degrees)
        axes.set_xlabel("Crank angle (deg)")
        axes.set_ylabel("Transmission angle (deg)")
        header_legend(figure, handles, title)
    return figure
