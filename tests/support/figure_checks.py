"""What tests ask of every figure."""

from __future__ import annotations

from itertools import combinations

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.text import Text

# Width and height in pixels that a panel must exceed.
LEAST_PANEL = (60.0, 40.0)


def panels(figure: Figure) -> list[Axes]:
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]


def heading(figure: Figure) -> str:
    """Line above the legend."""
    (legend,) = figure.legends
    return legend.get_title().get_text()


def top_axis(figure: Figure) -> Axes:
    (top,) = figure.axes[0].child_axes
    return top


def tick_texts(axes: Axes) -> list[str]:
    return [label.get_text() for label in axes.get_xticklabels()]


def legend_texts(figure: Figure) -> list[str]:
    (legend,) = figure.legends
    return [text.get_text() for text in legend.get_texts()]


def shown_tick_labels(axis: Axis) -> list[Text]:
    """Ticks outside the limits are not drawn."""
    low, high = sorted(axis.get_view_interval())
    room = 1e-9 * (high - low)
    ticks = [t for t in axis.get_major_ticks() if low - room <= t.get_loc() <= high + room]
    return [label for tick in ticks for label in (tick.label1, tick.label2)]


def shown_texts(figure: Figure) -> list[Text]:
    """Texts that are drawn, of axes inside and beside other axes too."""
    texts = list(figure.texts)
    for legend in figure.legends:
        texts += [*legend.get_texts(), legend.get_title()]
    supylabel = getattr(figure, "_supylabel", None)
    texts += [supylabel] if supylabel is not None and supylabel not in texts else []
    children = [child for axes in figure.axes for child in axes.child_axes]
    for axes in [*figure.axes, *children]:
        texts += [axes.title, axes._left_title, *axes.texts]
        for axis in (axes.xaxis, axes.yaxis):
            if axes.axison and axis.get_visible():
                texts += [axis.label, axis.get_offset_text(), *shown_tick_labels(axis)]
    return [text for text in texts if text.get_visible() and text.get_text().strip()]


def check_texts(figure: Figure) -> None:
    """No text leaves the figure or touches another."""
    figure.draw_without_rendering()
    texts = shown_texts(figure)
    boxes = [text.get_window_extent() for text in texts]
    frame = figure.bbox
    for text, box in zip(texts, boxes, strict=True):
        reach = max(-box.x0, -box.y0, box.x1 - frame.x1, box.y1 - frame.y1)
        assert reach <= 0.5, f"{text.get_text()!r} leaves the figure"
    for (one, first), (two, second) in combinations(zip(boxes, texts, strict=True), 2):
        wide = min(one.x1, two.x1) - max(one.x0, two.x0)
        tall = min(one.y1, two.y1) - max(one.y0, two.y0)
        assert min(wide, tall) <= 1, f"{first.get_text()!r} touches {second.get_text()!r}"


def check_layout(figure: Figure) -> None:
    """Texts stand apart, legends cover no panel, and no panel is squeezed to nothing."""
    check_texts(figure)
    for legend in figure.legends:
        frame = legend.get_window_extent()
        assert not any(frame.overlaps(axes.get_tightbbox()) for axes in figure.axes)
    # Text that cannot fit makes the layout give up and shrink the panels to nothing.
    width, height = LEAST_PANEL
    assert all(axes.bbox.width > width and axes.bbox.height > height for axes in panels(figure))
