"""What tests ask of figures over time and of spectra."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure


def panels(figure: Figure) -> list[Axes]:
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]


def y_labels(figure: Figure) -> list[str]:
    return [axes.get_ylabel().replace("\n", " ") for axes in panels(figure)]


def drawn(axes: Axes, color: str) -> np.ndarray:
    (line,) = [line for line in axes.lines if line.get_color() == color]
    return np.asarray(line.get_ydata())


def top_axis(figure: Figure) -> Axes:
    (top,) = figure.axes[0].child_axes
    return top


def tick_texts(axes: Axes) -> list[str]:
    return [label.get_text() for label in axes.get_xticklabels()]


def legend_texts(figure: Figure) -> list[str]:
    (legend,) = figure.legends
    return [text.get_text() for text in legend.get_texts()]


def shown_texts(figure: Figure) -> list[Any]:
    """Texts that are drawn: ticks outside the limits are not."""
    (legend,) = figure.legends
    texts = [*legend.get_texts(), legend.get_title()]
    children = [child for axes in figure.axes for child in axes.child_axes]
    for axes in [*figure.axes, *children]:
        texts += axes.texts
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            ticks = [t for t in axis.get_major_ticks() if low <= t.get_loc() <= high]
            shown = [label for tick in ticks for label in (tick.label1, tick.label2)]
            texts += [axis.label, axis.get_offset_text(), *shown]
    return [text for text in texts if text.get_visible() and text.get_text().strip()]


def check_layout(figure: Figure, narrowest: float = 500) -> None:
    """No text leaves the figure or touches another; no panel is squeezed to nothing."""
    figure.draw_without_rendering()
    texts = shown_texts(figure)
    boxes = [text.get_window_extent() for text in texts]
    frame = figure.bbox
    for text, box in zip(texts, boxes, strict=True):
        reach = max(-box.x0, -box.y0, box.x1 - frame.x1, box.y1 - frame.y1)
        assert reach <= 0.5, f"{text.get_text()!r} leaves the figure"
    for first in range(len(boxes)):
        for second in range(first):
            one, two = boxes[first], boxes[second]
            wide = min(one.x1, two.x1) - max(one.x0, two.x0)
            tall = min(one.y1, two.y1) - max(one.y0, two.y0)
            names = texts[first].get_text(), texts[second].get_text()
            assert wide <= 1 or tall <= 1, f"{names} overlap"
    assert all(axes.bbox.height > 60 and axes.bbox.width > narrowest for axes in panels(figure))
