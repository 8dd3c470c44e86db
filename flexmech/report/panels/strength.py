"""Strength of links and pins: how much of it is used along the links, and internal forces."""

from __future__ import annotations

import xarray as xr

from flexmech.analyses import Strength
from flexmech.arrays import FloatArray, IntArray
from flexmech.plots.picture import Choice, Curve, Pane, Picture, joined, over_angles
from flexmech.plots.reading import names_of
from flexmech.plots.strength import (
    FORCES,
    judged_links,
    least_factor,
    used_curves,
    used_pane,
)
from flexmech.plots.style import series_line
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
            used += used_curves(own, name, when)
            forces.append((when, _forces(own, turn.angle, turn.kept, name)))
        if turn.left_out:
            thinned.append(
                f"strength{name}: {len(turn.angle)} of {turn.samples} samples of the last turn "
                "are kept"
            )
    pane = [used_pane(used)] if used else []
    return panel_of(
        "strength",
        told_apart(found, names),
        # Where pins alone are judged there is nothing along the links.
        plots=(
            plotted(
                "strength-used",
                Picture(pane, pane[0].along, found[0].dataset),
                "Strength used along the links",
            ),
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


def _forces(own: xr.Dataset, angle: FloatArray, kept: IntArray, name: str) -> Picture:
    """Internal forces over the turn where each link is nearest to failure."""
    panes = []
    for variable, words, units in FORCES:
        curves = []
        for link in judged_links(own):
            station, here = int(least_factor(own, link).argmin()), own.sel(link=link)
            place = 1e3 * float(here["position"][station])
            values = here[variable].isel(station=station).values[kept]
            look = series_line(names_of(own, "link").index(link))
            curves.append(Curve(angle, values, look, f"{link}{name}, {place:.4g} mm"))
        panes.append(Pane(words, curves, units))
    title = "Internal forces at each link's worst place"
    return over_angles(angle, panes, own, title)
