"""Strength of links and pins: how much of it is used along the links, and internal forces."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import Strength
from flexmech.arrays import FloatArray
from flexmech.plots.reading import names_of
from flexmech.plots.strength import FAILS
from flexmech.report.last_turn import LastTurn, over_a_turn
from flexmech.report.panel import (
    FRAME_HEIGHT,
    GREY,
    Choice,
    Panel,
    Plot,
    Trace,
    YAxis,
    further_lines,
    over_angle,
    panel_of,
)
from flexmech.report.results import Results, speed_name, speed_unit_of

# Internal forces: variable and title of the axis.
FORCES = (
    ("axial_force", "N (N)"),
    ("shear_force", "V (N)"),
    ("bending_moment", "M (N m)"),
)


def strength_panel(results: Results) -> Panel | None:
    """Used part of the strength along the links, and internal forces at the worst places.

    Of several speeds and sources of loads, each has its lines.
    """
    found = results.of_kind(Strength)
    if not found:
        return None
    used, forces, thinned = list[Trace](), list[Trace](), list[str]()
    said = [result.summary() for result in found]
    names = _distinct(found, results)
    for result, name in zip(found, names, strict=True):
        data = result.dataset
        turn = over_a_turn(data["crank_angle"].values)
        for engine in names_of(data, "engine"):
            when = {"engine": engine} if data.sizes["engine"] > 1 else {}
            own = data.sel(engine=engine)
            used += _used(own, name, when)
            forces += _forces(own, turn, name, when)
        if turn.left_out:
            thinned.append(
                f"strength{name}: {len(turn.angle)} of {turn.samples} samples of the last turn "
                "are kept"
            )
    links = list(dict.fromkeys(link for each in found for link in _judged(each.dataset)))
    return panel_of(
        "strength",
        answer=_told(names, [one.answer for one in said]),
        # Where pins alone are judged there is nothing along the links.
        plots=(_used_plot(used, links), _forces_plot(forces, links)) if links else (),
        tables=tuple(one.table for one in said if one.table is not None),
        lines=_told(names, [further_lines(one) for one in said]),
        warnings=_told(names, [one.warnings for one in said]),
        thinned=tuple(thinned),
    )


def _distinct(found: list[Strength], results: Results) -> list[str]:
    """What tells results from each other: nothing of one alone, else speed and source of loads."""
    if len(found) == 1:
        return [""]
    unit = speed_unit_of(results)
    return [
        f" at {speed_name(float(each.dataset.attrs['crank_speed']), unit)}, "
        f"{each.dataset.attrs['source_of_loads']}"
        for each in found
    ]


def _told(names: list[str], lines: list[tuple[str, ...]]) -> tuple[str, ...]:
    """Lines of every result, each with what tells it from the others before it."""
    return tuple(
        f"{name.removeprefix(' at ')}: {line}" if name else line
        for name, own in zip(names, lines, strict=True)
        for line in own
    )


def _judged(data: xr.Dataset) -> list[str]:
    """Links of whose places load factors are known, in order."""
    known = data["load_factor"].notnull().any([d for d in data["load_factor"].dims if d != "link"])
    return [name for name in names_of(data, "link") if bool(known.sel(link=name))]


def _least(own: xr.Dataset, link: str) -> FloatArray:
    """Least load factor of the layers at each station of a link, infinite where nothing grows."""
    factor = own["load_factor"].sel(link=link).transpose("station", "layer", "surface").values
    return np.asarray(np.nanmin(np.where(np.isnan(factor), np.inf, factor), axis=(1, 2)))


def _used(own: xr.Dataset, name: str, when: Choice) -> list[Trace]:
    """Strength used along each link in percent, at the worst crank angle of each place."""
    traces = []
    links = names_of(own, "link")
    for link in _judged(own):
        place = 1e3 * own["position"].sel(link=link).values
        known = np.isfinite(place)
        with np.errstate(divide="ignore"):
            percent = FAILS / _least(own, link)[known]
        # What breaks without any load has no end.
        percent[np.isinf(percent)] = np.nan
        number = links.index(link)
        traces.append(Trace(f"{link}{name}", place[known], percent, number, when=when))
    return traces


def _used_plot(traces: list[Trace], links: list[str]) -> Plot:
    longest = max(trace.x.max() for trace in traces)
    line = np.array([0.0, longest]), np.full(2, FAILS)
    limit = Trace("fails", *line, GREY, "dot", 1.0)
    return Plot(
        "strength-used",
        "Place from the link's start (mm)",
        (YAxis("1 / load factor (%)"),),
        (*traces, limit),
        f"Part of the strength that loads use along {', '.join(links)}, at the worst layer and "
        "crank angle of each place; at 100 percent a link fails",
        title="Strength used along the links",
    )


def _forces_plot(traces: list[Trace], links: list[str]) -> Plot:
    return over_angle(
        "internal-forces",
        tuple(YAxis(title) for _, title in FORCES),
        traces,
        text="Axial force, shear force and bending moment over the crank angle at the worst place "
        f"of {', '.join(links)}",
        height=FRAME_HEIGHT + 110 * len(FORCES),
        title="Internal forces at each link's worst place",
    )


def _forces(own: xr.Dataset, turn: LastTurn, name: str, when: Choice) -> list[Trace]:
    """Internal forces over the turn where each link is nearest to failure."""
    traces, links = list[Trace](), names_of(own, "link")
    for link in _judged(own):
        station, number = int(_least(own, link).argmin()), links.index(link)
        place = 1e3 * float(own["position"].sel(link=link)[station])
        for axis, (variable, _) in enumerate(FORCES):
            values = own[variable].sel(link=link).transpose("crank_angle", "station").values
            traces.append(
                Trace(
                    f"{link}{name}, {place:.4g} mm",
                    turn.angle,
                    turn.of(values[:, station]),
                    number,
                    when=when,
                    followed={},
                    axis=axis,
                    legend=axis == 0,
                )
            )
    return traces
