"""A motor and the crank that it turns: speed, torque, power and current over time."""

from __future__ import annotations

from flexmech.analyses import Kinematics, Response
from flexmech.plots.motor import motor_picture
from flexmech.report.panel import Panel, further_lines, panel_of
from flexmech.report.plotted import plotted
from flexmech.report.results import Results


def motor_panel(results: Results) -> Panel | None:
    """Crank speed, and torque, power and current of the motor, of every result under a motor."""
    found = [
        result
        for result in (*results.of_kind(Kinematics), *results.of_kind(Response))
        if "motor_torque" in result.dataset
    ]
    if not found:
        return None
    said = [result.summary() for result in found]
    return panel_of(
        "motor",
        answer=tuple(dict.fromkeys(one.answer[0] for one in said)),
        plots=tuple(
            plotted(
                f"motor-{number}" if number > 1 else "motor",
                motor_picture(result.dataset),
                str(result.dataset.attrs.get("drive", "")),
            )
            for number, result in enumerate(found, 1)
        ),
        lines=tuple(line for one in said for line in further_lines(one) if "motor" in line),
    )
