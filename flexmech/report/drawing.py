"""Drawings that do not move, as SVG: sections with their layers."""

from __future__ import annotations

from html import escape

import numpy as np
import xarray as xr

__all__ = ["stacks_drawing"]

# In units of the drawing: width, room of a row's words, least height of a section.
WIDTH, DRAWN, LEAST = 640.0, 300.0, 3.0
# Greys of plies, light and dark, as a share of the ink over the paper.
SHADES = (0.18, 0.42, 0.66, 0.30, 0.54)


def stacks_drawing(data: xr.Dataset) -> tuple[str, str]:
    """Sections of all links under each other, at one scale.

    Parameters
    ----------
    data : xarray.Dataset
        Of a ``ModelCheck``: faces, plies and angles of the layers.

    Returns
    -------
    str, str
        SVG, and what is to be seen in it. Names are escaped.
    """
    thick = 1e3 * data["in_plane_thickness"].values.astype(float)
    width = 1e3 * data["out_of_plane_width"].values.astype(float)
    widest = float(np.nanmax(np.append(width[np.isfinite(width)], thick.max())))
    scale = DRAWN / widest
    plies = list(dict.fromkeys(str(ply) for ply in data["ply"].values.ravel() if str(ply)))
    rows, top = [], 10.0
    for number in range(data.sizes["link"]):
        height = max(scale * thick[number], LEAST)
        row = max(height, 46.0)
        wide = scale * width[number] if np.isfinite(width[number]) else DRAWN
        rows.append(_row(data.isel(link=number), plies, (top, row), (wide, height)))
        words = _words(data.isel(link=number), thick[number], width[number])
        for line, text in enumerate(words):
            y = top + row / 2 - 7.0 * (len(words) - 1) + 15.0 * line + 4.0
            strong = ' class="strong"' if line == 0 else ""
            rows.append(f'<text x="{DRAWN + 24:g}" y="{y:g}"{strong}>{escape(text)}</text>')
        top += row + 14.0
    legend = []
    for number, ply in enumerate(plies):
        shade = SHADES[number % len(SHADES)]
        legend.append(
            f'<rect x="0" y="{top:g}" width="14" height="10" class="ply" fill-opacity="{shade}"/>'
        )
        legend.append(f'<text x="20" y="{top + 9:g}">{escape(ply)}</text>')
        top += 17.0
    bar = scale * 10.0
    legend.append(f'<path d="M0 {top + 6:g}h{bar:g}" class="bar"/>')
    legend.append(f'<text x="{bar + 8:g}" y="{top + 10:g}">10 mm</text>')
    text = "; ".join(
        ", ".join(_words(data.isel(link=n), thick[n], width[n])) for n in range(len(thick))
    )
    frame = f'viewBox="0 0 {WIDTH:g} {top + 18:g}" class="stacks"'
    return f"<svg {frame}>{''.join(rows + legend)}</svg>", text


def _row(
    link: xr.Dataset, plies: list[str], place: tuple[float, float], size: tuple[float, float]
) -> str:
    """Layers of one section, the lowest y at the bottom, with a frame around them."""
    (top, row), (wide, height) = place, size
    low, high = (link[f"layer_{face}"].values.astype(float) for face in ("low", "high"))
    real = np.isfinite(low)
    bottom, whole = float(low[real].min()), float(high[real].max() - low[real].min())
    base = top + (row + height) / 2
    parts = []
    for number in np.flatnonzero(real).tolist():
        y = base - height * (high[number] - bottom) / whole
        tall = height * (high[number] - low[number]) / whole
        ply = str(link["ply"].values[number])
        shade = SHADES[plies.index(ply) % len(SHADES)] if ply else SHADES[0]
        parts.append(
            f'<rect x="0.5" y="{y:.2f}" width="{wide:.2f}" height="{tall:.2f}" class="ply" '
            f'fill-opacity="{shade}"/>'
        )
    parts.append(
        f'<rect x="0.5" y="{base - height:.2f}" width="{wide:.2f}" height="{height:.2f}" '
        'class="frame"/>'
    )
    return "".join(parts)


def _words(link: xr.Dataset, thick: float, width: float) -> list[str]:
    across = f"{width:.4g} mm wide" if np.isfinite(width) else "width not stated"
    words = [str(link["link"].item()), f"{thick:.4g} mm thick, {across}"]
    stack = str(link["stacking"].item())
    return [*words, stack] if stack else words
