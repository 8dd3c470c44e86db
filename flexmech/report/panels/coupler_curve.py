"""The path of the coupler point."""

from __future__ import annotations

import numpy as np

from flexmech.analyses import CouplerPaths
from flexmech.report.panel import Panel, Plot, Trace, YAxis
from flexmech.report.results import Results
from flexmech.report.words import crank_degrees


def coupler_panel(results: Results) -> Panel | None:
    """Coupler curves of each state, with their crunodes and cusps."""
    result = results.first(CouplerPaths)
    if result is None:
        return None
    data = result.dataset
    traces = []
    for number, name in enumerate(map(str, data["name"].values)):
        own = data.isel(state=number)
        x, y = (1e3 * own["position"].sel(component=axis).values for axis in "xy")
        traces.append(
            Trace(
                name,
                x,
                y,
                number,
                "solid" if number == 0 else "dash",
                followed={},
                angle=crank_degrees(data["crank_angle"].values),
            )
        )
        points = np.flatnonzero(data["double_point_state"].values == number)
        if points.size:
            places = 1e3 * data["double_point_position"].values[points]
            traces.append(
                Trace(
                    f"crunode or cusp, {name}",
                    places[:, 0],
                    places[:, 1],
                    colour=number,
                    look="points",
                    width=8.0,
                )
            )
    said = result.summary()
    return Panel(
        name="coupler-curve",
        title="Coupler curve",
        caption=(
            "Path of the coupler point over the turn, of each state; the dot is where it stands "
            "at the crank angle chosen. Larger points are crunodes and cusps of the whole curve."
        ),
        equation="p(θ₂) = r₂ e^{iθ₂} + e · e^{i(θ₃ + γ)}, a curve of sixth degree",
        source=(
            "S. Singh and S. Sanyal (2022); double points from the cubic on the circle of "
            "singular foci"
        ),
        plots=(
            Plot(
                "coupler",
                "x (mm)",
                (YAxis("y (mm)"),),
                tuple(traces),
                "Path of the coupler point in the plane, dry and in the environment asked for",
                "point",
                equal=True,
                height=420,
            ),
        ),
        lines=(*said.lines, said.verdict),
        warnings=said.warnings,
    )
