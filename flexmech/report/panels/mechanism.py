"""The mechanism as it was understood, and its transmission angle."""

from __future__ import annotations

import numpy as np

from flexmech.analyses import ModelCheck
from flexmech.report.panel import Panel, Plot, Trace, YAxis
from flexmech.report.results import Results
from flexmech.report.words import crank_degrees


def mechanism_panel(results: Results) -> Panel | None:
    """Links, masses and operation in words and a table, and the transmission angle."""
    result = results.first(ModelCheck)
    if result is None:
        return None
    said = result.summary()
    return Panel(
        name="mechanism",
        title="The mechanism",
        caption=(
            "What was read from the model file. The transmission angle stands between coupler and "
            "rocker; between the dotted lines it is usual."
        ),
        equation="cos μ = (r₃² + r₄² − d²) / (2 r₃ r₄),  d² = r₁² + r₂² − 2 r₁ r₂ cos θ₂",
        source="law of cosines in the triangle of coupler, rocker and diagonal",
        plots=_transmission_angle(result),
        tables=said.tables,
        lines=said.lines,
        warnings=said.warnings,
    )


def _transmission_angle(result: ModelCheck) -> tuple[Plot, ...]:
    data = result.dataset
    if "transmission_angle" not in data:
        return ()
    angle = crank_degrees(data["crank_angle"].values)
    line = Trace(
        "transmission angle",
        angle,
        np.degrees(data["transmission_angle"].values.astype(float)),
        followed={},
        legend=False,
    )
    limits = [
        Trace(
            f"{limit:g} deg",
            angle[[0, -1]],
            np.full(2, limit),
            "#8c8c8c",
            "dot",
            1.0,
            legend=False,
        )
        for limit in np.degrees(data["usual_transmission_angle"].values).tolist()
    ]
    return (
        Plot(
            "transmission-angle",
            "Crank angle (deg)",
            (YAxis("Transmission angle (deg)"),),
            (line, *limits),
            "Transmission angle between coupler and rocker against crank angle",
            "angle",
            tick=60.0,
            height=260,
        ),
    )
