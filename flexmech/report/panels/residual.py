"""What rings after a stop, over the time of the move, by the plain and by the shaped law."""

from __future__ import annotations

from flexmech.analyses import Response
from flexmech.plots.shaping import move_picture
from flexmech.report.panel import Panel, panel_of
from flexmech.report.plotted import plotted
from flexmech.report.results import Results


def residual_panel(results: Results) -> Panel | None:
    """Amplitude of each mode after the stop over the time until it, of every run that has it."""
    runs = [run for run in results.of_kind(Response) if "move_amplitude" in run.dataset]
    if not runs:
        return None
    plots = tuple(
        plotted(
            f"residual-{number}" if number > 1 else "residual",
            move_picture(run.dataset),
            str(run.dataset.attrs.get("drive", "")),
        )
        for number, run in enumerate(runs, 1)
    )
    answer = tuple(
        line for run in runs for line in run.summary().answer if "After the stop" in line
    )
    shapers = {str(run.dataset.attrs.get("shaper", "")) for run in runs} - {""}
    shaped = f", and by the law with the {' or '.join(sorted(shapers))}" if shapers else ""
    return panel_of("residual", answer=answer, plots=plots, shaped=shaped)
