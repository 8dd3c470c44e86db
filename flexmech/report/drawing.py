"""Drawings that do not move, as SVG: sections with their layers."""

from __future__ import annotations

import numpy as np
import xarray as xr

# Greatest width of a drawing, and least height of a section in it.
WIDTH, LEAST = 300.0, 3.0
# Opacity of the ink for each kind of layer: neighbours differ.
SHADES = (0.12, 0.45, 0.28, 0.65, 0.20, 0.55, 0.36, 0.75)
# Thinner layers are not outlined: lines would fill them.
LEAST_OUTLINED = 2.0
LEGEND = 12.0

Kind = tuple[str, float]
"""Of a layer: name of its ply, and its angle in degrees."""


def stack_drawings(data: xr.Dataset) -> tuple[tuple[str, str], ...]:
    """Sections of all links at one scale, and a key to their layers.

    Parameters
    ----------
    data : xarray.Dataset
        Of a ``ModelCheck``: faces, plies and angles of the layers.

    Returns
    -------
    tuple of (str, str)
        SVG without any text, and what it shows in words.
    """
    # Rigid links may have no section.
    data = data.isel(link=np.flatnonzero(np.isfinite(data["in_plane_thickness"].values)))
    thick = 1e3 * data["in_plane_thickness"].values.astype(float)
    width = 1e3 * data["out_of_plane_width"].values.astype(float)
    scale = WIDTH / float(np.nanmax([*width, thick.max()]))
    kinds = _kinds(data)
    drawings = []
    for number in range(data.sizes["link"]):
        wide = width[number] if np.isfinite(width[number]) else WIDTH / scale
        size = scale * wide, max(scale * thick[number], LEAST)
        svg = _section(data.isel(link=number), kinds, size)
        drawings.append((svg, _words(data.isel(link=number), thick[number], width[number])))
    for number, (ply, angle) in enumerate(kinds if len(kinds) > 1 else ()):
        drawings.append(
            (
                _svg(2 * LEGEND, LEGEND, _layer(number, 0.0, 2 * LEGEND, LEGEND)),
                f"{ply} at {angle:g} deg",
            )
        )
    return tuple(drawings)


def _kinds(data: xr.Dataset) -> list[Kind]:
    """Every kind of layer once, in order; a section of one material has one without a name."""
    found = []
    for link in range(data.sizes["link"]):
        one = data.isel(link=link)
        for layer in np.flatnonzero(np.isfinite(one["layer_low"].values)).tolist():
            found.append(_kind(one.isel(layer=layer)))
    return list(dict.fromkeys(found))


def _kind(layer: xr.Dataset) -> Kind:
    return str(layer["ply"].item()), round(float(np.degrees(layer["ply_angle"].item())), 6)


def _section(link: xr.Dataset, kinds: list[Kind], size: tuple[float, float]) -> str:
    """Layers of one section, the lowest y at the bottom, with a frame around them."""
    wide, height = size
    low, high = (link[f"layer_{face}"].values.astype(float) for face in ("low", "high"))
    real = np.flatnonzero(np.isfinite(low)).tolist()
    bottom, top = float(low[real].min()), float(high[real].max())
    scale = height / (top - bottom)
    parts = []
    for number in real:
        tall = scale * (high[number] - low[number])
        kind = kinds.index(_kind(link.isel(layer=number)))
        parts.append(_layer(kind, scale * (top - high[number]), wide, tall))
    frame = f'<rect y="0" width="{wide:.2f}" height="{height:.2f}" class="frame"/>'
    return _svg(wide, height, "".join(parts) + frame)


def _layer(kind: int, y: float, wide: float, tall: float) -> str:
    outline = " outlined" if tall >= LEAST_OUTLINED else ""
    return (
        f'<rect y="{y:.2f}" width="{wide:.2f}" height="{tall:.2f}" class="ply{outline}" '
        f'fill-opacity="{SHADES[kind % len(SHADES)]}"/>'
    )


def _svg(wide: float, height: float, parts: str) -> str:
    """A drawing of a fixed size, which narrow screens shrink, with room for its frame."""
    w, h = wide + 2, height + 2
    return f'<svg viewBox="-1 -1 {w:.1f} {h:.1f}" width="{w:.1f}" class="stack">{parts}</svg>'


def _words(link: xr.Dataset, thick: float, width: float) -> str:
    across = f"{width:.4g} mm wide" if np.isfinite(width) else "width not stated"
    words = f"{link['link'].item()}: {thick:.4g} mm thick, {across}"
    stack = str(link["stacking"].item())
    return f"{words}, {stack}" if stack else words
