"""Strength of links and pins: how much of it is used along the links, and internal forces."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import Strength
from flexmech.arrays import FloatArray, IntArray
from flexmech.plots.picture import Choice, Curve, Pane, Picture, Span, joined, over_angles
from flexmech.plots.reading import names_of
from flexmech.plots.strength import FAILS, FORCES
from flexmech.plots.style import MID_GREY, series_line
from flexmech.report.panel import Panel, panel_of, plotted, told_apart
from flexmech.report.results import Results, over_a_turn, speed_name, speed_unit_of


def strength_panel(results: Results) -> Panel | None:
    """Used part of the strength along the links, and internal forces at the worst places.

    Of several speeds and sources of loads, each has its lines.
    """
    found = results.of_kind(Strength)
    if not found:
        return None
    used, forces, thinned = list[Curve](), list[tuple[Choice, Picture]](), list[str]()
    names = _distinct(found, results)
    for result, distinct in zip(found, names, strict=True):
        data, name = result.dataset, f" at {distinct}" if len(found) > 1 else ""
        turn = over_a_turn(data["crank_angle"].values)
        for engine in names_of(data, "engine"):
            when = {"engine": engine} if data.sizes["engine"] > 1 else {}
            own = data.sel(engine=engine)
            used += _used(own, name, when)
            forces.append((when, _forces(own, turn.angle, turn.kept, name)))
        if turn.left_out:
            thinned.append(
                f"strength{name}: {len(turn.angle)} of {turn.samples} samples of the last turn "
                "are kept"
            )
    limit = Span(FAILS, FAILS, {"color": MID_GREY, "lw": 0.8, "ls": ":"}, "fails")
    pane = Pane("1 / load factor (%)", used, spans=(limit,))
    along = "Place from the link's start (mm)"
    picture = Picture([pane], along, found[0].dataset)
    return panel_of(
        "strength",
        told_apart(found, names),
        # Where pins alone are judged there is nothing along the links.
        plots=(
            plotted("strength-used", picture, "Strength used along the links"),
            plotted("internal-forces", joined(forces), forces[0][1].title),
        )
        if used
        else (),
        thinned=tuple(thinned),
    )


def _distinct(found: list[Strength], results: Results) -> list[str]:
    """What tells results from each other: speed and source of loads."""
    unit = speed_unit_of(results)
    return [
        f"{speed_name(float(one.dataset.attrs['crank_speed']), unit)}, "
        f"{one.dataset.attrs['source_of_loads']}"
        for one in found
    ]


def _judged(data: xr.Dataset) -> list[str]:
    """Links of whose places load factors are known, in order."""
    known = data["load_factor"].notnull().any([d for d in data["load_factor"].dims if d != "link"])
    return [name for name in names_of(data, "link") if bool(known.sel(link=name))]


def _least(own: xr.Dataset, link: str) -> FloatArray:
    """Least load factor of the layers at each station of a link, infinite where nothing grows."""
    factor = own["load_factor"].sel(link=link).transpose("station", "layer", "surface").values
    return np.asarray(np.nanmin(np.where(np.isnan(factor), np.inf, factor), axis=(1, 2)))


def _used(own: xr.Dataset, name: str, when: Choice) -> list[Curve]:
    """Strength used along each link in percent, at the worst crank angle of each place."""
    curves = []
    links = names_of(own, "link")
    for link in _judged(own):
        place = 1e3 * own["position"].sel(link=link).values
        known = np.isfinite(place)
        with np.errstate(divide="ignore"):
            percent = FAILS / _least(own, link)[known]
        # What breaks without any load has no end.
        percent[np.isinf(percent)] = np.nan
        look = series_line(links.index(link))
        curves.append(Curve(place[known], percent, look, f"{link}{name}", when=when))
    return curves


def _forces(own: xr.Dataset, angle: FloatArray, kept: IntArray, name: str) -> Picture:
    """Internal forces over the turn where each link is nearest to failure."""
    panes = []
    for variable, words, units in FORCES:
        curves = []
        for link in _judged(own):
            station, here = int(_least(own, link).argmin()), own.sel(link=link)
            place = 1e3 * float(here["position"][station])
            values = here[variable].isel(station=station).values[kept]
            look = series_line(names_of(own, "link").index(link))
            curves.append(Curve(angle, values, look, f"{link}{name}, {place:.4g} mm"))
        panes.append(Pane(words, curves, units))
    title = "Internal forces at each link's worst place"
    return over_angles(angle, panes, own, title)
