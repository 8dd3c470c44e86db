"""Campaigns: composite crank-rockers beside what is published, and the verification."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from flexmech.arrays import FloatArray
from flexmech.plots import scales
from flexmech.plots.layout import AxesLike, grid, sheet, wrapped
from flexmech.plots.reading import names_of, values_of
from flexmech.plots.style import Look, line_handle, series_handle, series_line, series_style

# Of one position, three of which fit a page, in inches.
PANEL = 1.9
# From dark to light, so that the order shows without colour as well.
SHADES = ("#08306b", "#08519c", "#2171b5", "#4292c6", "#9ecae1", "#deebf7")
# A fifth of the distance between two groups is left free, so that they are told apart.
BAR_WIDTH = 0.8 / len(SHADES)
# Middle of each laminate's bar from the middle of its group.
OFFSETS = (np.arange(len(SHADES)) - (len(SHADES) - 1) / 2) * BAR_WIDTH
EDGE: Look = {"edgecolor": "black", "linewidth": 0.4}
MARK: Look = {"ls": "", "ms": 3.8, "mew": 0.9}
DIAMOND = MARK | {"marker": "D", "color": series_style(1).color}
DASH = MARK | {"marker": "_", "color": "black"}
RING = MARK | {"marker": "o", "color": "black", "mfc": "white"}
BAND: Look = {"color": series_style(0).color, "alpha": 0.15, "linewidth": 0.0}
# The model that the claims are held against.
FIRST = {"plies": "woven", "layers": "across width"}
POSITIONS = {
    "min": "Least transmission angle",
    "90": "Transmission angle 90 deg",
    "max": "Greatest transmission angle",
}

# Of a subject, whose name may have two lines, in inches.
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


def plot_composite_frequencies(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw fundamental frequencies by laminate, case and position as ratios.

    Elamy et al. 2023, Figure 8 and Tables 4 to 6. Bars are linkages with a clamped crank and hinged
    links; open circles have links that are rigidly joined.

    Parameters
    ----------
    dataset : Dataset
        Of :func:`flexmech.studies.study_composites`.
    ax : sequence of Axes, optional
        The user's, one for each of three positions. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    computed = dataset["frequency"].sel(FIRST | {"beams": "converged"})
    marks = {
        "rigid joints": (dataset["rigid_joints_frequency"], RING),
        "FE, published": (dataset["finite_element"], DIAMOND),
        "measured": (dataset["measured"], DASH),
    }
    title = "Frequency over that of C1, case 1, least transmission angle (bars: computed, hinged)"
    return _bars(computed, marks, "C1", title, "Ratio of frequencies (-)", ax)


def plot_composite_damping(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw damping by laminate, case and position as ratios.

    Elamy et al. 2023, Figure 9 and Tables 4 to 6. Bars are beams that only bend; open circles
    are beams that shear too, by third-order theory.

    Parameters
    ----------
    dataset : Dataset
        Of :func:`flexmech.studies.study_composites`.
    ax : sequence of Axes, optional
        The user's, one for each of three positions. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    computed = dataset["strain_energy_damping"].sel(FIRST)
    marks = {
        "third order": (computed.sel(beams="third order"), RING),
        "measured": (dataset["damping"], DIAMOND),
    }
    title = "Damping over that of C6, case 1, least transmission angle (bars: computed, bending)"
    return _bars(computed.sel(beams="converged"), marks, "C6", title, "Ratio of damping (-)", ax)


def plot_laminate_factors(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw how the frequency changes with the laminate, by model of plies and the way they lie.

    The band has twice the uncertainty of the first model by Table 1.

    Parameters
    ----------
    dataset : Dataset
        Of :func:`flexmech.studies.study_composites`, with ``laminate_factor`` (plies, layers,
        beams, laminate), ``laminate_factor_spread`` and ``published_laminate_factor`` (laminate);
        C1 is 1.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    factor = dataset["laminate_factor"]
    bent, stacked = factor.sel(beams="converged"), {"layers": "through thickness"}
    first = bent.sel(FIRST)
    curves = {
        "woven, plies in the plane": first,
        "woven, stacked": bent.sel(stacked | {"plies": "woven"}),
        "straight, plies in the plane": bent.sel(FIRST | {"plies": "unidirectional"}),
        "straight, stacked": bent.sel(stacked | {"plies": "unidirectional"}),
        "one modulus a laminate, Table 2": bent.sel(FIRST | {"plies": "table 2"}),
        "published, Tables 5 and 6": dataset["published_laminate_factor"],
    }
    with sheet(grid(1, 1, 3.0), ax=ax) as drawn:
        (axes,) = drawn.panels
        names, handles = names_of(dataset, "laminate"), []
        spread = 2 * dataset["laminate_factor_spread"]
        axes.fill_between(names, (first - spread).values, (first + spread).values, **BAND)
        for number, (label, values) in enumerate(curves.items()):
            line = series_line(number) | {"marker": series_style(number).marker, "markersize": 4}
            axes.plot(names, values.values, **line)
            handles.append(series_handle(number, label, **line))
        sheared = factor.sel(FIRST | {"beams": "third order"})
        axes.plot(names, sheared.values, **RING)
        handles.append(line_handle("woven, plies in the plane, third order", **RING))
        handles.append(Patch(label="twice the uncertainty by Table 1", **BAND))
        drawn.header(handles, "Frequency of each laminate over that of C1")
        axes.set_ylim(0.0, 1.05)
        axes.set(xlabel="Laminate", ylabel="Ratio of frequencies (-)")
    return drawn.figure


def plot_running_against_steel(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the greatest driving torque and deflection of each laminate and of steel, by case.

    Filled points are woven plies, open ones the moduli and densities of Table 2.

    Parameters
    ----------
    dataset : Dataset
        Of :func:`flexmech.studies.study_composites`, with ``peak_torque`` and ``peak_deflection``
        over ``running_plies``, ``material`` and ``case``.
    ax : sequence of Axes, optional
        The user's, one for each of two panels. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    quantities = {
        "peak_torque": ("Greatest driving torque of rigid links", "Torque (N m)", 1.0),
        "peak_deflection": ("Greatest deflection", "Deflection (mm)", 1e3),
    }
    materials = names_of(dataset, "material")
    with sheet(grid(2, 1, 5.0, sharex=True), ax=ax) as drawn:
        for axes, (name, (title, label, unit)) in zip(
            drawn.panels, quantities.items(), strict=True
        ):
            for number, case in enumerate(dataset["case"].values):
                peaks = unit * dataset[name].sel(case=case)
                look = series_line(number) | {"marker": series_style(number).marker}
                woven, printed = (
                    values_of(peaks.sel(running_plies=plies), "material")
                    for plies in ("woven", "table 2")
                )
                axes.plot(materials, woven, **(look | {"markersize": 4}))
                ring = look | {"linestyle": "", "mfc": "none", "markersize": 6}
                axes.plot(materials, printed, **ring)
            axes.set_yscale("log")
            axes.set_title(title)
            axes.set_ylabel(label)
        handles = [
            series_handle(n, f"case {case}", marker=series_style(n).marker)
            for n, case in enumerate(dataset["case"].values)
        ]
        handles += [
            line_handle("woven plies", **(RING | {"mfc": "black"})),
            line_handle("as one material, Table 2", **RING),
        ]
        drawn.header(handles, "Composite crank-rockers in motion, and the same links of steel")
        drawn.label_x("Links of")
    return drawn.figure


def _bars(
    computed: xr.DataArray,
    marks: dict[str, tuple[xr.DataArray, Look]],
    unit: str,
    title: str,
    y_label: str,
    ax: AxesLike | None,
) -> Figure:
    """One panel a position, one group of bars a case; ``unit`` is the laminate that has 1."""

    def ratio(values: xr.DataArray, position: str) -> FloatArray:
        one = values.sel(laminate=unit, case=1, position="min")
        return values_of(values.sel(position=position) / one, "laminate", "case")

    cases = np.arange(computed.sizes["case"])
    places = cases + OFFSETS[:, None]
    with sheet(grid(3, 1, 3 * PANEL + 0.2, sharex=True, sharey=True), ax=ax) as drawn:
        laminates = zip(SHADES, names_of(computed, "laminate"), strict=True)
        bars = [Patch(facecolor=shade, label=name, **EDGE) for shade, name in laminates]
        lines = [line_handle(label, **look) for label, (_, look) in marks.items()]
        drawn.header([*bars, *lines], title)
        for axes, (position, words) in zip(drawn.panels, POSITIONS.items(), strict=True):
            axes.set_title(words)
            heights = ratio(computed, position)
            for laminate, shade in enumerate(SHADES):
                axes.bar(places[laminate], heights[laminate], BAR_WIDTH, color=shade, **EDGE)
            for values, look in marks.values():
                axes.plot(places.ravel(), ratio(values, position).ravel(), **look)
            scales.plain_numbers(axes)
            axes.set_xticks(cases, [f"case {case}" for case in computed["case"].values])
        # Only now: the panels share the axis, and a limit ends its fitting to what is drawn.
        for axes in drawn.panels:
            axes.set_ylim(bottom=0.0)
        drawn.label_x("Proportions of the linkage")
        drawn.label_y(y_label)
    return drawn.figure


def plot_verification(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw each deviation over its tolerance, a row for each subject.

    What lies left of the dashed line is near enough. Cases that were skipped or could not be
    computed have no deviation; the latter stand at the right end.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Verification`` result.
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
