"""A mechanism on one sheet: posture and paths, sections to scale, and transmission angle."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Polygon, Rectangle
from matplotlib.transforms import Bbox

from flexmech.arrays import FloatArray
from flexmech.plots import scales, style
from flexmech.plots.drawing import draw_pane
from flexmech.plots.drawn_linkage.figures import name_joints, named_places, part_handles
from flexmech.plots.drawn_linkage.sketch import LinkageSketch
from flexmech.plots.drawn_linkage.symbols import OUTLINE
from flexmech.plots.layout import AxesLike, Layout, height_of, round_length, sheet
from flexmech.plots.picture import Curve, Pane, Picture, Span, over_angles
from flexmech.plots.reading import degrees, names_of, values_of
from flexmech.plots.style import LABEL_POINTS, Look, line_handle, series_style

# Least and greatest height of the posture above the rest, and height of a row below it, in inches:
# with the legend two thirds of a page. Greatest height of a posture beside the rest.
POSTURE_HEIGHT = (1.7, 3.4)
HIGH_POSTURE = 4.4
ROW_HEIGHT = 2.2
# Height of a panel's heading in inches.
HEADING = 0.25
# What the numbers along the transmission angle take of the width.
AXIS_INCHES = 0.6
# Room below for the scale bar with its words, over the height.
BAR_ROOM = 0.05
LINK: Look = {"fc": "0.88", "ec": OUTLINE, "lw": 0.7, "zorder": 0.9, "joinstyle": "round"}
RIGID_LINK: Look = LINK | {"fc": "0.7"}
# Thickness of a link without a section over the linkage's size: that of links that are stout.
RIGID_WIDTH = 0.02
AXIS: Look = {"color": OUTLINE, "lw": 0.5, "ls": (0.0, (6.0, 2.0, 1.5, 2.0))}
PIN_PATH: Look = {"color": style.MID_GREY, "lw": 0.6}
POINTS = ("coupler point", "coupler's middle")
"""Names of paths that are of points of the coupler, not of its pins."""
POINT_PATH: Look = {"color": series_style(0).color, "lw": 1.3}
COUPLER: Look = {"fc": series_style(0).color, "alpha": 0.12, "lw": 0, "zorder": 0.6}
MASS_COLOR = series_style(1).color
# Greys of plies in the order in which they come, apart enough to be distinguished.
PLY_GREYS = ("0.92", "0.72", "0.52", "0.82", "0.62")
WHOLE_FRAME: Look = {"fc": "none", "ec": OUTLINE, "lw": 0.7}
UNKNOWN_WIDTH = WHOLE_FRAME | {"ls": (0.0, (3.0, 2.0))}
# A line of the words beside sections in inches: a third more than the height of their letters.
LINE_INCHES = 0.13
# Panel of sections: the share of the width that sections have, the rest is for words; and the
# height of the scale bar with its own.
DRAWN, BAR_INCHES = 0.42, 0.32
# Share of the width that sections have beside a posture: their words need a third of a page.
BESIDE = 0.36
# More layers than these are distinguished by their greys alone: edges would fill them.
MOST_EDGES = 60


def plot_mechanism(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw a mechanism: posture with paths, sections to scale, transmission angle over the turn.

    The links are as thick as they are in the plane of the linkage, at the scale of the bar below
    them. Sections stand with the plane's thickness upward and the width along the joint axes to
    the right, all at one scale, with the layers of their stacks.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``ModelCheck`` result that has a posture; m, kg and rad.
    ax : sequence of Axes, optional
        The user's: three, or two where there is no transmission angle. Left out: a new figure is
        made.

    Returns
    -------
    Figure
    """
    sketch = LinkageSketch.of(dataset, mass_color=MASS_COLOR)
    sketch = replace(sketch, around=_places(sketch, dataset))
    limits = _limits(sketch)
    turns = "transmission_angle" in dataset
    beside = _stands_beside(limits, turns)
    stacks = _Stacks.of(dataset.assign(grey=_greys(dataset)), BESIDE if beside else 1 / 2)
    make = _beside if beside else _above
    with sheet(make(limits, stacks.height, turns), ax=ax) as drawn:
        drawn.header(_handles(dataset, sketch), of=dataset)
        posture, sections, *rest = drawn.panels
        angle = np.degrees(dataset["posture_angle"].item())
        posture.set_title(f"Posture at crank angle {angle:.4g}°")
        sketch.frame(posture, limits)
        _draw_links(posture, dataset, sketch)
        _draw_paths(posture, dataset)
        sketch.draw(posture, **AXIS)
        sketch.draw_scale_bar(posture)
        name_joints(posture, sketch, dataset)
        _draw_sections(sections, stacks)
        for axes in rest:
            turned = transmission_picture(dataset)
            draw_pane(axes, turned.panes[0])
            drawn.title(axes, turned.panes[0].title)
            scales.crank_angle_axis(axes, turned.places, narrow=True)
    return drawn.figure


def _places(sketch: LinkageSketch, dataset: xr.Dataset) -> FloatArray:
    """Places of paths, the names of joints and the thickness of links, (n, 2)."""
    half = np.nan_to_num(values_of(dataset["in_plane_thickness"], "link"))[:, None, None] / 2
    inside = [named_places(sketch, dataset), sketch.links - half, sketch.links + half]
    if "path" in dataset:
        inside.append(values_of(dataset["path"], "path", "crank_angle", "component"))
    return np.concatenate([points.reshape(-1, 2) for points in inside])


def _limits(sketch: LinkageSketch) -> Bbox:
    """Limits of the posture and all around it."""
    limits = sketch.limits(np.empty((0, 2)))
    # Paths may be much larger than the linkage, which the room for the scale bar is made for.
    low = limits.y0 - BAR_ROOM * limits.height
    return Bbox.from_extents(limits.x0, low, limits.x1, limits.y1)


def _stands_beside(limits: Bbox, turns: bool) -> bool:
    """Whether the rest stands to the right of the posture, and not below it.

    A posture that is not flat would leave the page empty on both sides of it, and the sections
    alone half of the page below it. On a narrow page all of it stands under each other.
    """
    highest = POSTURE_HEIGHT[1]
    flat = height_of(limits, style.figure_width(), 0.0, highest) < highest
    return not style.is_narrow() and not (turns and flat)


def _above(limits: Bbox, sections: float, turns: bool) -> Layout:
    """The posture above what else there is."""
    # In one column the posture stands over the axis of the transmission angle.
    beside = AXIS_INCHES if turns and style.is_narrow() else 0.1
    posture = height_of(limits, style.figure_width() - beside, *POSTURE_HEIGHT) + HEADING
    below = [sections + HEADING] + [ROW_HEIGHT] * turns
    rows = [posture, *below] if style.is_narrow() else [posture, max(below)]
    columns = 1 if style.is_narrow() else len(below)

    def make(figure: Figure) -> list[Axes]:
        cells = figure.add_gridspec(len(rows), columns, height_ratios=rows)
        first = figure.add_subplot(cells[0, :])
        places = [divmod(number, columns) for number in range(len(below))]
        return [first, *(figure.add_subplot(cells[1 + row, place]) for row, place in places)]

    return Layout(1 + len(below), sum(rows), make)


def _beside(limits: Bbox, sections: float, turns: bool) -> Layout:
    """The posture, and to the right of it the sections over the transmission angle."""
    width = (1 - BESIDE) * style.figure_width() - 0.1
    posture = height_of(limits, width, POSTURE_HEIGHT[0], HIGH_POSTURE) + HEADING
    rows = [sections + HEADING] + [ROW_HEIGHT + HEADING] * turns

    def make(figure: Figure) -> list[Axes]:
        widths = [1 - BESIDE, BESIDE]
        cells = figure.add_gridspec(len(rows), 2, width_ratios=widths, height_ratios=rows)
        first = figure.add_subplot(cells[:, 0])
        return [first, *(figure.add_subplot(cells[row, 1]) for row in range(len(rows)))]

    return Layout(1 + len(rows), max(posture, sum(rows)), make)


def _handles(dataset: xr.Dataset, sketch: LinkageSketch) -> list[Artist]:
    """Legend entries of paths, parts, plies and the usual transmission angles."""
    handles: list[Artist] = []
    names = names_of(dataset, "path_name") if "path" in dataset else []
    pins = [name for name in names if name not in POINTS]
    if pins:
        handles.append(line_handle(_paths_of(pins), **PIN_PATH))
    handles += [
        line_handle(f"path of the {name}", marker="o", markersize=4, **POINT_PATH)
        for name in names
        if name in POINTS
    ]
    handles += part_handles(sketch)
    plies = _plies(dataset)
    for ply, grey in plies.items() if len(plies) > 1 else ():
        handles.append(Patch(fc=grey, ec=style.MID_GREY, lw=0.6, label=ply.replace("$", r"\$")))
    if "transmission_angle" in dataset:
        low, high = _degrees(dataset["usual_transmission_angle"])
        usual = f"usual transmission angle, {low:g}° to {high:g}°"
        handles.append(Patch(color=style.LIGHT_GREY, lw=0, label=usual))
    return handles


def _paths_of(pins: list[str]) -> str:
    """Common name of the paths of pins and tips."""
    names = [f"the {name}" if name.startswith("tip") else name for name in pins]
    if len(names) == 1:
        return f"path of {names[0]}"
    return f"paths of {', '.join(names[:-1])} and {names[-1]}"


def _draw_links(axes: Axes, dataset: xr.Dataset, sketch: LinkageSketch) -> None:
    """Links as thick as they are; those without a section as thick as a rigid one is drawn."""
    for link, known in zip(sketch.links, dataset["in_plane_thickness"].values, strict=True):
        thickness = known if np.isfinite(known) else RIGID_WIDTH * sketch.size
        along = (link[-1] - link[0]) / np.hypot(*(link[-1] - link[0]))
        aside = thickness / 2 * np.array([-along[1], along[0]])
        corners = [link[0] + aside, link[-1] + aside, link[-1] - aside, link[0] - aside]
        axes.add_patch(Polygon(corners, **(LINK if np.isfinite(known) else RIGID_LINK)))


def _draw_paths(axes: Axes, dataset: xr.Dataset) -> None:
    """Paths over the turn, and the coupler's triangle up to its point."""
    if "path" not in dataset:
        return
    paths = values_of(dataset["path"], "path", "crank_angle", "component")
    for name, path, place in zip(
        names_of(dataset, "path_name"), paths, dataset["path_position"].values, strict=True
    ):
        if name not in POINTS:
            axes.plot(*path.T, **PIN_PATH, zorder=0.7)
            continue
        axes.plot(*path.T, **POINT_PATH, zorder=2.0)
        pins = dataset["rigid_position"].sel(link="coupler").values[[0, -1]]
        axes.add_patch(Polygon([*pins, place], **COUPLER))
        axes.plot(*place, "o", color=POINT_PATH["color"], ms=4, zorder=5)


@dataclass(frozen=True)
class _Row:
    """One section in the panel of sections.

    Parameters
    ----------
    texts : list of str
        Lines beside it.
    width : float
        In mm; not a number where none is known.
    thickness : float
        In mm.
    layers : list of (float, float, str)
        Lower and upper face in mm, and grey.
    across : bool
        Whether the layers lie side by side across the width.
    """

    texts: list[str]
    width: float
    thickness: float
    layers: list[tuple[float, float, str]]
    across: bool

    @property
    def least_height(self) -> float:
        """Least height of its lines in inches."""
        return LINE_INCHES * (len(self.texts) + 0.4)


@dataclass(frozen=True)
class _Stacks:
    """Sections under each other in a panel, at one scale.

    Parameters
    ----------
    width, height : float
        Size of the panel in inches.
    scale : float
        Millimetres an inch of the panel.
    rows : list of _Row
    """

    width: float
    height: float
    scale: float
    rows: list[_Row]

    @classmethod
    def of(cls, dataset: xr.Dataset, share: float) -> _Stacks:
        """Fit the sections of a dataset into a panel of a share of a wide page."""
        wide = (style.figure_width() - 0.5) * (1.0 if style.is_narrow() else share)
        letters = int(wide * (1 - DRAWN) * 72 / (0.62 * LABEL_POINTS))
        thick = np.isfinite(dataset["in_plane_thickness"].values)
        names = [
            name for name, known in zip(names_of(dataset, "link"), thick, strict=True) if known
        ]
        rows = [_row(dataset.sel(link=name), letters) for name in names]
        widest = max((row.width for row in rows if np.isfinite(row.width)), default=0.0)
        room = ROW_HEIGHT - 0.25 - BAR_INCHES
        # With the gaps between rows, so that there is a scale at which many links fit.
        least = sum(row.least_height + LINE_INCHES / 2 for row in rows)
        height = max(room, 1.1 * least)
        # As large as the width allows, and smaller until the rows fit.
        thickest = max((row.thickness for row in rows), default=1.0)
        scale = max(widest / (DRAWN * wide), thickest / height)
        while sum(cls._height(row, scale) for row in rows) > height:
            scale *= 1.05
        height = sum(cls._height(row, scale) for row in rows)
        return cls(wide, height + BAR_INCHES, scale, rows)

    @staticmethod
    def _height(row: _Row, scale: float) -> float:
        """Height of a row in inches."""
        return max(row.thickness / scale, row.least_height) + LINE_INCHES / 2

    def heights(self) -> list[float]:
        """Heights of the rows in mm of the panel."""
        return [self.scale * self._height(row, self.scale) for row in self.rows]


def _row(link: xr.Dataset, letters: int) -> _Row:
    """A section with its name, its size and its stack, as far as a number of letters holds it."""
    thick, width = (1e3 * link[one].item() for one in ("in_plane_thickness", "out_of_plane_width"))
    across = f"{width:.4g} mm wide" if np.isfinite(width) else "width not stated"
    texts = [str(link["link"].item()).capitalize(), f"{thick:.4g} mm thick, {across}"]
    if stack := str(link["stacking"].item()):
        shown = stack if len(stack) <= letters else f"{stack[: letters - 1]}…"
        texts.append(shown.replace("$", r"\$"))
    faces = zip(
        *(link[one].values.tolist() for one in ("layer_low", "layer_high", "grey")), strict=True
    )
    layers = [(1e3 * low, 1e3 * up, g) for low, up, g in faces if low < up]
    across = link["direction_of_layers"].item() == "across width"
    return _Row(texts, width, thick, layers, across)


def _plies(dataset: xr.Dataset) -> dict[str, str]:
    """Grey of each ply by name; a section of one material has one without a name."""
    present = np.isfinite(dataset["layer_low"].values)
    names = dict.fromkeys(dataset["ply"].values[present].tolist())
    return {name: PLY_GREYS[n % len(PLY_GREYS)] for n, name in enumerate(names)}


def _greys(dataset: xr.Dataset) -> xr.DataArray:
    """Grey of each layer of each link."""
    plies = _plies(dataset)
    greys = [[plies.get(ply, "") for ply in link] for link in dataset["ply"].values.tolist()]
    return dataset["ply"].copy(data=greys)


def _draw_sections(axes: Axes, stacks: _Stacks) -> None:
    """Sections under each other, what they are beside them, and a scale bar."""
    across, top = stacks.width * stacks.scale, stacks.height * stacks.scale
    axes.set(xlim=(0.0, across), ylim=(0.0, top), aspect="equal", anchor="NW")
    axes.set_axis_off()
    axes.set_title("Sections, in-plane thickness up")
    widths = [row.width if np.isfinite(row.width) else DRAWN * across for row in stacks.rows]
    beside = max(widths, default=0.0) + 0.04 * across
    for row, height in zip(stacks.rows, stacks.heights(), strict=True):
        middle, known = top - height / 2, np.isfinite(row.width)
        drawn, lowest = row.width if known else DRAWN * across, row.layers[0][0]
        base = middle - row.thickness / 2
        for low, high, grey in row.layers:
            corner, size = (0.0, base + low - lowest), (drawn, high - low)
            if row.across:
                corner, size = (low - lowest, base), (high - low, row.thickness)
            edge: Look = {"ec": OUTLINE, "lw": 0.25 if 1 < len(row.layers) <= MOST_EDGES else 0}
            axes.add_patch(Rectangle(corner, *size, fc=grey, **edge))
        frame = WHOLE_FRAME if known else UNKNOWN_WIDTH
        axes.add_patch(Rectangle((0.0, base), drawn, row.thickness, clip_on=False, **frame))
        words = "\n".join(row.texts)
        axes.text(beside, middle, words, fontsize=LABEL_POINTS, va="center", linespacing=1.25)
        top -= height
    line, length = LINE_INCHES * stacks.scale, round_length(DRAWN * across)
    axes.plot([0.0, length], [0.3 * line] * 2, color="black", lw=1.6)
    axes.text(0.0, 0.5 * line, f"{length:g} mm", fontsize=LABEL_POINTS, va="bottom")


def transmission_picture(dataset: xr.Dataset) -> Picture:
    """Transmission angle over the turn, with the usual range and where the posture is.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``ModelCheck`` result with ``transmission_angle``.

    Returns
    -------
    Picture
    """
    angles = degrees(dataset["crank_angle"])
    values = np.degrees(dataset["transmission_angle"].values.astype(float))
    usual = _degrees(dataset["usual_transmission_angle"])
    posture = np.degrees(dataset["posture_angle"].values[None]) % 360.0
    dot: Look = {"ls": "", "marker": "o", "color": "black", "ms": 4, "zorder": 3}
    low, high = _degrees(dataset["transmission_angle_limit"])
    lowest, highest = min(low, *usual) - 8.0, max(high, *usual) + 8.0
    pane = Pane(
        "Transmission angle (deg)",
        (
            Curve(angles, values, {"color": "black"}),
            Curve(posture, np.interp(posture, angles, values), dot),
        ),
        title=f"Transmission angle {low:.3g}° to {high:.3g}°",
        spans=(
            Span(
                usual[0], usual[1], {"color": style.LIGHT_GREY, "lw": 0, "zorder": 0}, "usual range"
            ),
            Span(90.0, 90.0, {"color": style.MID_GREY, "lw": 0.6, "zorder": 1}),
        ),
        limits=(lowest, highest),
        ticks=tuple(one for one in (0.0, 90.0, 180.0, *usual) if lowest < one < highest),
        along="Crank angle (deg)",
    )
    return over_angles(angles, [pane], dataset)


def _degrees(limits: xr.DataArray) -> list[float]:
    """Lowest and highest of a range in degrees."""
    found: list[float] = np.degrees(limits.values.astype(float)).tolist()
    return found
