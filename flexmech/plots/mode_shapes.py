"""Mode shapes drawn on the linkage."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from flexmech.arrays import FloatArray
from flexmech.plots import angle_panels, style
from flexmech.plots.angle_panels import has_many_speeds
from flexmech.plots.layout import AxesLike, Layout, height_of, sheet, tiles
from flexmech.plots.linkage import part_handles
from flexmech.plots.linkage_parts import parts_of
from flexmech.plots.linkage_sketch import RIGID, LinkageSketch
from flexmech.plots.reading import engine_label, highest_speed, mode_label, speed_texts, values_of
from flexmech.plots.style import line_handle, series_handle, series_line

# Panels a row on a wide and on a narrow page, and points drawn between two stations of a link.
PANELS_A_ROW, NARROW_ROW, POINTS_A_STATION = 4, 2, 4
# Largest displacement as drawn, over the linkage's size.
ENLARGED_TO = 0.14
# Marks of masses and bodies over those in a picture of one linkage.
SMALL = 0.6
# Of the scale bar with its words over the linkage's size.
BAR_ROOM = 0.14
# An end that moves less than this part of the largest displacement in every mode is held.
AT_REST = 1e-6
NOT_SHOWN = ["crank_angle", "check_angle", "shape_angle"]
SHAPE = ("crank_speed", "mode", "link", "station", "component")


def plot_mode_shapes(
    dataset: xr.Dataset,
    *,
    ax: AxesLike | None = None,
    check_angle: float | None = None,
    shape_angle: float | None = None,
) -> Figure:
    """Draw each mode on the linkage, with the shape at every crank speed on top of another.

    As Kumar and Chandrakar's Figures 1.7-1.9 and 2.3-2.8: the rigid linkage in grey and the
    deflected one, enlarged; of more than five speeds that at the highest. A complex shape is
    turned in phase until its largest component is real, and its real part is drawn; signs are
    those that match the first speed.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result. The first engine's shapes are drawn.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode. Left out: a new figure is made.
    check_angle : float, optional
        Crank angle in rad; the nearest angle with stored shapes is taken. Default the first.
    shape_angle : float, optional
        Instead: the nearest of the crank angles in rad at which shapes were asked for.

    Returns
    -------
    Figure
    """
    speed = ""
    if has_many_speeds(dataset):
        place, text = highest_speed(dataset)
        dataset = dataset.isel(crank_speed=[place])
        speed = f"{text} and "
    shown = _stored(dataset, check_angle) if shape_angle is None else _asked(dataset, shape_angle)
    frequency, stored = shown["frequency"], shown["shape"]
    real, imaginary = (values_of(stored.sel(part=part), *SHAPE) for part in ("real", "imaginary"))
    shapes = real_shapes(real + 1j * imaginary)
    # As the first speed's, whose phases may differ by half a turn.
    overlap = np.sum(shapes * shapes[:1], axis=(-3, -2, -1), keepdims=True)
    shapes *= np.where(overlap < 0, -1.0, 1.0)
    rigid = values_of(shown["position"], "place", *SHAPE[2:])
    held = np.abs(shapes[..., [0, -1], :]).max(axis=(0, 1, -1)) <= AT_REST
    sketch = LinkageSketch(rigid[0], parts_of(dataset, rigid, held), mark_size=SMALL)
    deflected = _smooth(sketch.links + ENLARGED_TO * sketch.size * shapes)
    sketch = replace(sketch, around=deflected.reshape(-1, 2))
    limits = sketch.limits(deflected, BAR_ROOM)
    n_speeds, n_modes = shapes.shape[:2]
    widths = _line_widths(n_speeds)
    with sheet(_layout(limits, n_modes, n_speeds), ax=ax, fewer=angle_panels.ONE_MODE) as drawn:
        handles = [
            series_handle(number, text, linewidth=widths[number])
            for number, text in enumerate(speed_texts(dataset))
        ]
        title = (
            f"Mode shapes at {speed}crank angle {np.degrees(shown.attrs['angle']):.4g}° by "
            f"{engine_label(dataset)}, displacement enlarged"
        )
        handles += [line_handle("rigid linkage", **RIGID), *part_handles(sketch)]
        drawn.header(handles, title, of=dataset)
        texts = [_frequencies_text(one) for one in values_of(frequency, "mode", "crank_speed")]
        for mode, axes in enumerate(drawn.panels):
            sketch.frame(axes, limits)
            heading = f"{mode_label(dataset['mode'].values[[mode]].tolist())}\n{texts[mode]}"
            axes.set_title(heading, loc="center", fontsize=8, linespacing=1.3)
            sketch.draw(axes)
            for number, links in enumerate(deflected[:, mode]):
                line = series_line(number) | {"lw": widths[number], "zorder": 2 + 0.1 * number}
                for link in links:
                    axes.plot(*link.T, **line)
        sketch.draw_scale_bar(drawn.panels[0])
    return drawn.figure


def _stored(dataset: xr.Dataset, check_angle: float | None) -> xr.Dataset:
    """Shapes of the first engine at one of the map's check angles, that position first."""
    angles = dataset["check_angle"].values.astype(float)
    nearest = 0 if check_angle is None else int(np.argmin(np.abs(angles - check_angle)))
    first = dataset.isel(engine=0)
    order = [nearest, *(n for n in range(len(angles)) if n != nearest)]
    position = first["rigid_position"].isel(check_angle=order).rename(check_angle="place")
    shown = {
        "frequency": first["frequency"].sel(crank_angle=angles[nearest], method="nearest"),
        "shape": first["mode_shape"].isel(check_angle=nearest),
    }
    whole = xr.Dataset(
        {name: each.drop_vars(NOT_SHOWN, errors="ignore") for name, each in shown.items()}
    )
    whole["position"] = position.drop_vars("place")
    return whole.assign_attrs(angle=angles[nearest])


def _asked(dataset: xr.Dataset, shape_angle: float) -> xr.Dataset:
    """Shapes at one of the angles at which they were asked for, that position first."""
    angles = dataset["shape_angle"].values.astype(float)
    here = dataset.isel(shape_angle=int(np.argmin(np.abs(angles - shape_angle))))
    others = dataset["rigid_position"].rename(check_angle="place").drop_vars("place")
    position = xr.concat(
        [here["asked_position"].drop_vars(NOT_SHOWN, errors="ignore"), others], "place"
    )
    return xr.Dataset(
        {"frequency": here["asked_frequency"], "shape": here["asked_shape"], "position": position},
        attrs={"angle": float(here["shape_angle"])},
    )


def real_shapes(shapes: NDArray[np.complex128]) -> FloatArray:
    """Real parts of shapes, each in the phase in which its largest component is real.

    Parameters
    ----------
    shapes : ndarray of complex, shape (m, n, link, station, 2)

    Returns
    -------
    ndarray, shape (m, n, link, station, 2)
        Real, with largest displacement 1.
    """
    flat = shapes.reshape(*shapes.shape[:2], -1)
    place = np.argmax(np.abs(flat), axis=-1)[..., None]
    phase = np.angle(np.take_along_axis(flat, place, axis=-1))
    real = (flat * np.exp(-1j * phase)).real.reshape(shapes.shape)
    longest = np.hypot(real[..., 0], real[..., 1]).max(axis=(-2, -1))
    return np.asarray(real / np.where(longest > 0, longest, 1.0)[..., None, None, None])


def _smooth(deflected: FloatArray) -> FloatArray:
    """Cubic spline through the stations of each link, which stay among the points drawn."""
    stations = deflected.shape[-2]
    points = np.linspace(0, stations - 1, (stations - 1) * POINTS_A_STATION + 1)
    return np.asarray(CubicSpline(np.arange(stations), deflected, axis=-2)(points))


def _layout(limits: Bbox, n_modes: int, n_speeds: int) -> Layout:
    """Panels of equal scale, with room for the frequencies in their headings."""
    columns = 3 if n_modes in (5, 6) else min(n_modes, PANELS_A_ROW)
    if style.is_narrow():
        columns = min(columns, NARROW_ROW)
    # Less the layout's padding between the panels.
    panel = height_of(limits, style.figure_width() / columns - 0.2, 0.7, 2.6)
    title = 0.2 + 0.17 * -(-n_speeds // 3)
    return tiles(n_modes, columns, panel + title, narrow=columns)


def _frequencies_text(frequency: FloatArray) -> str:
    """Frequencies by speed in the legend's order, three a line."""
    largest = float(np.nanmax(np.abs(frequency), initial=1e-3))
    decimals = max(0, 3 - int(np.floor(np.log10(largest))))
    texts = [f"{value:.{decimals}f}" for value in frequency]
    lines = [" / ".join(texts[start : start + 3]) for start in range(0, len(texts), 3)]
    return " /\n".join(lines) + " Hz"


def _line_widths(total: int) -> list[float]:
    """Each speed thinner than the one before, so that coinciding shapes stay visible."""
    widths: list[float] = np.linspace(min(1.2 + 0.8 * (total - 1), 3.6), 1.2, total).tolist()
    return widths
