"""Cross-sections of the links: their layers, and stress and moisture through the thickness."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.analyses import ModelCheck, MoistureUptake, SectionProfiles
from flexmech.analyses.section_profile.compute import property_table
from flexmech.plots.picture import Pane, Picture
from flexmech.plots.reading import names_of
from flexmech.plots.section import profile_curves, profile_pane, uptake_pane
from flexmech.report.panel import Panel, Plot, panel_of, plotted, shows
from flexmech.report.results import Results, state_of, thinning

# Variable, unit load, title of the axis, and its units in a Pa.
LOADS = (
    ("normal_stress", "axial_force", "σ by N (kPa)", 1e-3),
    ("normal_stress", "bending_moment", "σ by M (MPa)", 1e-6),
    ("shear_stress", "shear_force", "τ by V (kPa)", 1e-3),
)
# Greatest width of a drawing, as a phone shows it, and least height of a section in it, in pixels.
WIDTH, LEAST = 300.0, 3.0
# Opacity of the ink for each kind of layer: neighbours differ.
SHADES = (0.12, 0.45, 0.28, 0.65, 0.20, 0.55, 0.36, 0.75)
# Thinner layers, in pixels, are not outlined: lines would fill them.
LEAST_OUTLINED = 2.0
# Height of an entry of the key to the layers in pixels: that of its letters.
LEGEND = 12.0

Kind = tuple[str, float]
"""Kind of a layer: name of its ply, and its angle in degrees."""


@shows(SectionProfiles)
def section_panel(result: SectionProfiles, results: Results) -> Panel:
    """Stacks to scale, stress through the thickness under unit loads, and properties."""
    check = results.first(ModelCheck)
    drawings: tuple[tuple[str, str], ...] = ()
    if check is not None and "layer_low" in check.dataset:
        drawings = stack_drawings(check.dataset)
    return panel_of(
        "sections",
        result.said,
        plots=tuple(_plot(result, link, n) for n, link in enumerate(result.links_with_layers)),
        drawings=drawings,
        folded=tuple(property_table(result.dataset.sel(link=link)) for link in result.links),
        thinned=(
            "sections: stresses of every layer are drawn; flexmech section writes their tables to "
            "through_thickness.csv",
        ),
        state=state_of(result.dataset.attrs),
    )


def _plot(result: SectionProfiles, link: str, number: int) -> Plot:
    profile, panes = result.profile(link), []
    for variable, load, label, factor in LOADS:
        curves = profile_curves(profile, variable, load)
        in_unit = [
            replace(one, y=factor * one.y, name=one.name if len(curves) > 1 else "")
            for one in curves
        ]
        panes.append(Pane(label, in_unit))
    along = "y from the pins' axis (mm)"
    picture = Picture(panes, along, result.dataset)
    return plotted(f"section-{number + 1}", picture, f"Stress in the {link}")


@shows(MoistureUptake)
def moisture_panel(result: MoistureUptake, results: Results) -> Panel:
    """Uptake over the root of time, and profiles through the thickness."""
    data, kept = result.dataset, thinning(result.dataset.sizes["time"])
    thinned = f"{len(kept)} of {data.sizes['time']} times of the uptake are kept"

    def plot(name: str, make: Callable[[xr.Dataset, str], Pane], title: str) -> Plot:
        panes = tuple(make(data.isel(time=kept), link) for link in names_of(data, "link"))
        named = tuple(replace(pane, label=pane.title) for pane in panes)
        picture = Picture(named, panes[0].along, data)
        return plotted(name, picture, f"{title}: {panes[0].label.lower()}")

    return panel_of(
        "moisture",
        result.said,
        plots=(plot("uptake", uptake_pane, "Uptake"), plot("profiles", profile_pane, "Profiles")),
        thinned=(thinned,) if len(kept) < data.sizes["time"] else (),
    )


def stack_drawings(data: xr.Dataset) -> tuple[tuple[str, str], ...]:
    """Sections of all links at one scale, and a key to their layers.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a ``ModelCheck``: faces, plies and angles of the layers.

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
        svg = _svg(2 * LEGEND, LEGEND, _layer(number, (0.0, 0.0), (2 * LEGEND, LEGEND)))
        drawings.append((svg, f"{ply} at {angle:g} deg"))
    return tuple(drawings)


def _kinds(data: xr.Dataset) -> list[Kind]:
    """Every kind of layer once, in order; a section of one material has one without a name."""
    layers = data.stack(each=("link", "layer"))
    real = np.flatnonzero(np.isfinite(layers["layer_low"].values)).tolist()
    return list(dict.fromkeys(_kind(layers.isel(each=place)) for place in real))


def _kind(layer: xr.Dataset) -> Kind:
    return str(layer["ply"].item()), round(float(np.degrees(layer["ply_angle"].item())), 6)


def _section(link: xr.Dataset, kinds: list[Kind], size: tuple[float, float]) -> str:
    """Layers of one section with a frame around them.

    The lowest y is at the bottom; layers across the width stand side by side.
    """
    wide, height = size
    across = link["direction_of_layers"].item() == "across width"
    low, high = (link[f"layer_{face}"].values.astype(float) for face in ("low", "high"))
    real = np.flatnonzero(np.isfinite(low)).tolist()
    bottom, top = float(low[real].min()), float(high[real].max())
    scale = (wide if across else height) / (top - bottom)
    parts = []
    for number in real:
        tall = scale * (high[number] - low[number])
        kind = kinds.index(_kind(link.isel(layer=number)))
        if across:
            parts.append(_layer(kind, (scale * (low[number] - bottom), 0.0), (tall, height)))
        else:
            parts.append(_layer(kind, (0.0, scale * (top - high[number])), (wide, tall)))
    frame = f'<rect y="0" width="{wide:.2f}" height="{height:.2f}" class="frame"/>'
    return _svg(wide, height, "".join(parts) + frame)


def _layer(kind: int, corner: tuple[float, float], size: tuple[float, float]) -> str:
    (x, y), (wide, tall) = corner, size
    outline = " outlined" if min(size) >= LEAST_OUTLINED else ""
    return (
        f'<rect x="{x:.2f}" y="{y:.2f}" width="{wide:.2f}" height="{tall:.2f}" '
        f'class="ply{outline}" '
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
