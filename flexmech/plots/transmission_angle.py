"""Transmission angle against crank angle."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from flexmech.plots import angle_panels, style
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.reading import degrees, names_of, values_of
from flexmech.plots.series import series_handles, series_line, told_apart

TITLE = "Transmission angle over a turn of the crank"


def plot_transmission_angle(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw transmission angles of linkages over the crank's turn.

    As Elamy et al. 2023, Figure 7.

    Parameters
    ----------
    dataset : Dataset
        With ``transmission_angle`` (linkage, crank_angle) in rad; the names along ``linkage``
        are those of the legend. The attributes ``wanted_least`` and ``wanted_greatest`` in rad
        shade a range, which the legend calls ``wanted_label``; ``title`` is the heading.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there are no linkages, or more than there are styles to tell them apart.
    """
    names = told_apart(names_of(dataset, "linkage"))
    curves = np.degrees(values_of(dataset["transmission_angle"], "linkage", "crank_angle"))
    angles, attrs = degrees(dataset["crank_angle"]), dataset.attrs
    with sheet(grid(1, 1, 3.2), ax=ax) as drawn:
        (axes,) = drawn.panels
        handles = series_handles(names)
        if "wanted_least" in attrs:
            wanted = np.degrees([attrs["wanted_least"], attrs["wanted_greatest"]])
            axes.axhspan(*wanted, color=style.LIGHT_GREY, zorder=0)
            words = attrs.get("wanted_label", "wanted range")
            handles.append(Patch(color=style.LIGHT_GREY, label=words))
        drawn.header(handles, str(attrs.get("title", TITLE)), of=dataset)
        axes.axhline(90.0, color=style.MID_GREY, lw=0.6, zorder=1)
        for number, values in enumerate(curves):
            axes.plot(angles, values, **series_line(number))
        angle_panels.label_angles(drawn, angles, "Transmission angle (deg)")
    return drawn.figure
