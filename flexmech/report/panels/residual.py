"""What rings after a stop, over the time of the move, by the plain and by the shaped law."""

from __future__ import annotations

import numpy as np

from flexmech.analyses import Response
from flexmech.plots.reading import names_of
from flexmech.plots.shaping import move_line
from flexmech.report.panel import FRAME_HEIGHT, GREY, Look, Panel, Plot, Trace, YAxis, panel_of
from flexmech.report.results import Results

# Modes below this part of the greatest amplitude are left out, and points below that part.
_SEEN, _DRAWN = 0.01, 1e-4


def residual_panel(results: Results) -> Panel | None:
    """Amplitude of each mode after the stop over the time until it, of every run that has it."""
    runs = [run for run in results.of_kind(Response) if "move_amplitude" in run.dataset]
    if not runs:
        return None
    plots = tuple(_plot(run, number) for number, run in enumerate(runs))
    answer = tuple(
        line for run in runs for line in run.summary().answer if "After the stop" in line
    )
    shapers = {str(run.dataset.attrs.get("shaper", "")) for run in runs} - {""}
    shaped = f", and by the law with the {' or '.join(sorted(shapers))}" if shapers else ""
    return panel_of("residual", answer=answer, plots=plots, shaped=shaped)


def _plot(run: Response, number: int) -> Plot:
    data = run.dataset
    found = data["move_amplitude"].max("link")
    greatest = float(found.max()) or 1.0
    modes = [m for m in found["mode"].values if float(found.sel(mode=m).max()) >= _SEEN * greatest]
    traces, axes = list[Trace](), list[YAxis]()
    for axis, mode in enumerate(modes or found["mode"].values[:1]):
        frequency = float(data["move_frequency"].sel(mode=mode))
        axes.append(YAxis(f"mode {mode}, {frequency:.4g} Hz (mm)", logarithmic=True))
        for law in names_of(data, "law"):
            shaped = law == "shaped"
            name = str(data.attrs["shaper"]) if shaped else "plain law"
            time, line = move_line(data, law, int(mode))
            line = 1e3 * line
            resolved = len(time) > data.sizes["move_time"]
            seen = line > 1e3 * _DRAWN * greatest
            colour: int | str = 0 if shaped else GREY
            first = axis == 0
            look: Look = "solid" if resolved else "points"
            traces.append(
                Trace(name, time[seen], line[seen], colour, look, axis=axis, legend=first)
            )
            if "simulated_move_amplitude" not in data:
                continue
            own = data["simulated_move_amplitude"].sel(law=law, mode=mode).max("link")
            at = data["whole_move_time"].sel(law=law, move_time=own["simulated_move_time"].values)
            for engine in names_of(data, "simulating_engine"):
                points = 1e3 * own.sel(simulating_engine=engine).values
                some = points > 1e3 * _DRAWN * greatest
                place = np.asarray(at.values)[some]
                label = f"{name}, {engine}"
                traces.append(
                    Trace(label, place, points[some], colour, "points", axis=axis, legend=first)
                )
    return Plot(
        "residual" if not number else f"residual-{number + 1}",
        "Time until the stop (s)",
        tuple(axes),
        tuple(traces),
        "Amplitude of each mode in the link that shows it most after the stop, against the time of "
        "the move, by plain and by shaped law",
        height=FRAME_HEIGHT + 130 * len(axes),
        title=str(data.attrs.get("drive", "")),
    )
