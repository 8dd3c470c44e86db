"""The verification: deviations over their tolerances."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.plots.layout import AxesLike, grid, sheet, wrapped
from flexmech.plots.reading import names_of
from flexmech.plots.style import Look, line_handle, series_style

# Height of a subject, whose name may have two lines, in inches.
ROW = 0.3
# Deviations below this part of the tolerance, and none at all, stand at the left end: how much
# smaller they are says nothing.
LEAST = 1e-6
# Inches for the names of subjects, which then have two lines at most.
LONGEST_NAME = 2.6
DOT: Look = {"ls": "", "marker": "o", "ms": 3.0, "mew": 0.0, "alpha": 0.6}
DOT |= {"color": series_style(0).color}
CROSS: Look = {"ls": "", "marker": "X", "ms": 6.5, "mew": 0.3, "color": series_style(1).color}
LIMIT: Look = {"color": "0.2", "lw": 1.0, "ls": "--"}


def plot_verification(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw each deviation over its tolerance, a row for each subject.

    Cases left of the dashed line are near enough. Cases that were skipped or could not be
    computed have no deviation; the latter stand at the right end.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Verification`` result.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    subjects = list(dict.fromkeys(names_of(dataset, "subject")))
    ratio = dataset["deviation"] / dataset["tolerance"]
    lost = (dataset["verdict"] == "failed") & ratio.isnull().all("number")
    with sheet(grid(1, 1, 0.9 + ROW * len(subjects)), ax=ax) as drawn:
        (axes,) = drawn.panels
        worst = 1.0
        for row, subject in enumerate(subjects):
            own = dataset["subject"].values == subject
            values = ratio.values[own]
            values = np.clip(values[~np.isnan(values)], LEAST, None)
            worst = max(worst, values.max(initial=1.0))
            near = values <= 1
            axes.plot(values[near], np.full(near.sum(), row), **DOT)
            axes.plot(values[~near], np.full((~near).sum(), row), **CROSS)
            if lost.values[own].any():
                axes.plot([1.0], [row], transform=axes.get_yaxis_transform(), **CROSS)
        axes.axvline(1.0, **LIMIT)
        drawn.header(
            [
                line_handle("passed", **DOT),
                line_handle("failed", **CROSS),
                line_handle("tolerance", **LIMIT),
            ],
            f"Verification: deviations over their tolerances (at the left end {LEAST:g} and less)",
        )
        names = ["\n".join(wrapped(subject, LONGEST_NAME)) for subject in subjects]
        axes.set_yticks(range(len(subjects)), names)
        axes.set_ylim(len(subjects) - 0.5, -0.5)
        axes.set_xscale("log")
        axes.set_xlim(0.6 * LEAST, 3.0 * worst)
        axes.set_xlabel("Deviation over tolerance (-)", loc="right")
    return drawn.figure
