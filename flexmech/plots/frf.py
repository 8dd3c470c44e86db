"""Frequency responses: of a hammer test, and of the running linkage order by order."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.plots import scales
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.reading import amplitudes_of, complex_values, signed, speed_text
from flexmech.plots.style import MID_GREY, Look, is_narrow, line_handle, line_handles, series_style

# What a row of panels and what the axes take, in inches.
ROW_HEIGHT, AXES_HEIGHT = 1.7, 0.5
# Of a row and its axes where six panels stand under each other.
NARROW_HEIGHT = 1.3
BOTH = "give six Axes"
# Name of each response, its unit, and the power of the angular frequency that multiplies it.
RESPONSES = (
    ("Receptance", "m/N", 0),
    ("Mobility", "m/(N s)", 1),
    ("Accelerance", "m/(N s²)", 2),
)
# Colours that both figures share.
MEASURED, IDENTIFIED = (series_style(number).color for number in (0, 1))
CURVES: dict[str, tuple[str, Look]] = {
    "exact_receptance": ("eigen model, exact", {"color": "0.75", "lw": 2.6}),
    "receptance": ("measured (H1)", {"color": MEASURED, "lw": 0.8}),
    "identified_receptance": (
        "identified modes",
        {"color": IDENTIFIED, "lw": 0.9, "ls": (0.0, (4.0, 4.0))},
    ),
}
"""Receptances of the dataset, from the lowest to the uppermost line: label and look."""
# Decades of an amplitude below its peak that are drawn, at most.
DECADES = 5.0

# What a row of panels and what the axes take, in inches; on a narrow page each row becomes two.
ROW, NARROW_ROW, HARMONIC_AXES_HEIGHT = 1.25, 0.75, 0.7
# Room above the greatest amplitude, and how far below it the axis reaches at most.
HEADROOM, HARMONIC_DECADES = 2.0, 4.5
HARMONICS: dict[str, tuple[str, Look]] = {
    "frozen": ("frozen linkage", {"color": MID_GREY, "lw": 0.9, "ls": (0.0, (4.0, 2.0))}),
    "receptance": ("identified from impacts", {"color": IDENTIFIED, "lw": 2.4, "alpha": 0.55}),
    "predicted": ("predicted by the periodic model", {"color": MEASURED, "lw": 0.9}),
}
"""Harmonic transfer functions of the dataset, from the lowest line up: label and look."""
# A phase is drawn where its amplitude is above this part of the order's greatest.
LEAST_AMPLITUDE = 1e-4


def plot_frf(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw amplitude and phase of receptance, mobility and accelerance.

    Parameters
    ----------
    dataset : Dataset
        Of a ``HammerTest`` result; its first crank angle is drawn.
    ax : Axes or sequence of Axes, optional
        The user's, six: the amplitudes, then the phases. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    parts: tuple[tuple[str, Callable[[ComplexArray], FloatArray]], ...] = (
        ("amplitude", np.abs),
        ("phase (deg)", scales.phase_of),
    )
    return _draw(dataset, parts, ax)


def plot_frf_parts(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw real and imaginary part of receptance, mobility and accelerance.

    Parameters
    ----------
    dataset : Dataset
        Of a ``HammerTest`` result; its first crank angle is drawn.
    ax : Axes or sequence of Axes, optional
        The user's, six: the real parts, then the imaginary ones. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    return _draw(dataset, (("Re", np.real), ("Im", np.imag)), ax)


def curve_handles(**measured: Any) -> list[Artist]:
    """Legend entries of the curves; further properties are of the measured one."""
    return [
        line_handle(label, **(look | (measured if curve == "receptance" else {})))
        for curve, (label, look) in CURVES.items()
    ]


def first_angle(dataset: xr.Dataset) -> xr.Dataset:
    """The part of a dataset at its first crank angle."""
    return dataset.isel(crank_angle=0) if "crank_angle" in dataset.dims else dataset


def angle_text(one: xr.Dataset) -> str:
    """Crank angle of the part of a dataset at one angle."""
    return f"{float(np.degrees(one['crank_angle'])):.6g} deg"


def hammer_title(dataset: xr.Dataset) -> str:
    """Heading that says where the crank was locked, hit and watched, and by which engine."""
    of = dataset.attrs
    return (
        f"Crank locked at {angle_text(first_angle(dataset))}: impact {of['impact']}, response "
        f"{of['response_point']}, {of['direction']}; {of['engine']}"
    )


def _draw(
    dataset: xr.Dataset,
    parts: tuple[tuple[str, Callable[[ComplexArray], FloatArray]], ...],
    ax: AxesLike | None,
) -> Figure:
    data = first_angle(dataset)
    frequency = data["frequency"].values
    height = 2 * NARROW_HEIGHT if is_narrow() else 2 * ROW_HEIGHT + AXES_HEIGHT
    layout = grid(2, 3, height, sharex=True)
    with sheet(layout, ax=ax, fewer=BOTH) as drawn:
        drawn.header(curve_handles(), hammer_title(dataset), of=dataset)
        places = [(part, of) for part in parts for of in RESPONSES]
        for axes, ((name, part), (response, unit, power)) in zip(drawn.panels, places, strict=True):
            turned = (2j * np.pi * frequency) ** power
            values = {curve: part(complex_values(data, curve) * turned) for curve in CURVES}
            for curve, (_, look) in CURVES.items():
                axes.plot(frequency, values[curve], **look)
            axes.set_xlim(0.0, float(frequency[-1]))
            if name.startswith("phase"):
                scales.phase_axis(axes)
                axes.set_ylabel(f"{response}\n{name}")
                continue
            if name == "amplitude":
                axes.set_ylabel(f"{response}\n{name} ({unit})")
                low, high = scales.log_limits(values["exact_receptance"], DECADES)
                scales.log_scale(axes, low / 2, high)
            else:
                axes.set_ylabel(f"{name} {response.lower()}\n({unit})")
                axes.ticklabel_format(axis="y", style="sci", scilimits=(0, 0))
        drawn.label_x("Frequency (Hz)")
    return drawn.figure


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
    functions = {name: complex_values(dataset, name, "order", "frequency") for name in HARMONICS}
    low, high = _limits(np.abs(list(functions.values())))
    row_height = NARROW_ROW if is_narrow() else ROW
    layout = grid(len(orders), 2, row_height * len(orders) + HARMONIC_AXES_HEIGHT / 2, sharex=True)
    attrs = dataset.attrs
    title = (
        f"From {attrs['impact_point']} at f to {attrs['response_point']} at f + n f$_{{crank}}$; "
        f"{speed_text(dataset)}, {attrs['engine']} engine"
    )
    with sheet(layout, ax=ax) as drawn:
        frozen, *others = line_handles(dict(HARMONICS.values()))
        drawn.header([*others, frozen], title, of=dataset)
        for row, order in enumerate(orders):
            amplitude, phase = drawn.panels[2 * row : 2 * row + 2]
            for name, values in functions.items():
                size, look = np.abs(values[row]), HARMONICS[name][1]
                strong = np.where(size > LEAST_AMPLITUDE * size.max(), values[row], np.nan)
                amplitude.plot(frequency, amplitudes_of(values[row]), **look)
                phase.plot(frequency, scales.phase_of(strong), **look)
            scales.log_scale(amplitude, low, high)
            amplitude.set_ylabel(f"|H$_{{{signed(order)}}}$| (m/N)")
            scales.phase_axis(phase)
            phase.set_ylabel(f"∠H$_{{{signed(order)}}}$ (deg)")
            for axes in (amplitude, phase):
                axes.set_xlim(frequency[0], frequency[-1])
        drawn.label_x("Frequency f of the force (Hz)")
    return drawn.figure


def _limits(size: FloatArray) -> tuple[float, float]:
    """Of all amplitudes, from a few decades below the greatest."""
    greatest = float(size.max())
    if greatest == 0:
        return 1e-9, 1.0
    least = float(size[size > 0].min())
    return max(least / HEADROOM, greatest * 10**-HARMONIC_DECADES), greatest * HEADROOM
