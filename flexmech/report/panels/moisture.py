"""How water gets into the links."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import MoistureUptake
from flexmech.report.arrays import thinning
from flexmech.report.panel import Look, Panel, Plot, Trace, YAxis
from flexmech.report.results import Results
from flexmech.types import IntArray
from flexmech.units import from_si

LAWS: tuple[tuple[str, str, Look], ...] = (
    ("uptake", "", "solid"),
    ("short_time_uptake", "law of the root of time", "dash"),
    ("shen_springer_uptake", "Shen and Springer", "dot"),
)


def moisture_panel(results: Results) -> Panel | None:
    """Uptake over the root of time, and profiles through the thickness."""
    result = results.first(MoistureUptake)
    if result is None:
        return None
    data, said = result.dataset, result.summary()
    kept = thinning(data.sizes["time"])
    thinned = f"{len(kept)} of {data.sizes['time']} times of the uptake are kept"
    return Panel(
        name="moisture",
        title="Moisture in the links",
        caption=(
            "Water that the links have taken up over that in equilibrium, against the root of "
            "time, and moisture of the resin through the thickness at some times."
        ),
        equation="∂c/∂t = ∇ · (D ∇c)",
        source="Fick's second law; C.-H. Shen and G. S. Springer, J. Composite Materials 10 (1976)",
        plots=(_uptake(data, kept), _profiles(data)),
        tables=said.tables,
        lines=(*said.lines, said.verdict),
        warnings=said.warnings,
        thinned=(thinned,) if len(kept) < data.sizes["time"] else (),
    )


def _uptake(data: xr.Dataset, kept: IntArray) -> Plot:
    root = np.sqrt([from_si(float(time), "day") for time in data["time"].values[kept]])
    traces = [
        Trace(
            link if name == LAWS[0][0] else words,
            root,
            data[name].sel(link=link).values[kept],
            number,
            look,
            legend=name == LAWS[0][0] or number == 0,
        )
        for number, link in enumerate(map(str, data["link"].values))
        for name, words, look in LAWS
    ]
    return Plot(
        "uptake",
        "Root of time (√day)",
        (YAxis("Uptake over equilibrium"),),
        tuple(traces),
        "Uptake of water of each link against the root of time",
        height=380,
        title="Uptake",
    )


def _profiles(data: xr.Dataset) -> Plot:
    links = [str(name) for name in data["link"].values]
    traces = []
    for axis, link in enumerate(links):
        own = data.sel(link=link)
        for time in range(own.sizes["profile_time"]):
            one = own.isel(profile_time=time)
            days = from_si(float(one["profile_time"]), "day")
            place, water = 1e3 * one["place"].values, 100 * one["profile"].values
            known = np.isfinite(place) & np.isfinite(water)
            name = f"after {days:.3g} d"
            line = place[known], water[known]
            traces.append(Trace(name, *line, colour=time, axis=axis, legend=axis == 0))
    return Plot(
        "profiles",
        "Place from the middle (mm)",
        tuple(YAxis(f"{link} (%)") for link in links),
        tuple(traces),
        "Moisture of the resin through the thickness of each link at some times",
        height=110 + 150 * len(links),
        title="Moisture through the thickness",
    )
