"""What a hammer finds on the running linkage: harmonic transfer functions."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import RunningHammerTest
from flexmech.report.panel import Look, Panel, Plot, Trace, YAxis
from flexmech.report.results import Results
from flexmech.report.words import speed_name, speed_unit_of

LINES: tuple[tuple[str, str, int | str, Look, float], ...] = (
    ("frozen", "frozen linkage", "#737373", "dash", 1.2),
    ("receptance", "identified from impacts", 1, "solid", 3.0),
    ("predicted", "predicted by the periodic model", 0, "solid", 1.4),
)


def running_hammer_panel(results: Results) -> Panel | None:
    """Amplitudes of every order over the frequency of the force."""
    result = results.first(RunningHammerTest)
    if result is None:
        return None
    data = result.dataset
    said = result.summary()
    orders = data["order"].values.tolist()
    attrs = data.attrs
    speed = speed_name(float(attrs["crank_speed"]), speed_unit_of(results))
    plot = Plot(
        name="harmonic-response",
        x_title="Frequency f of the force (Hz)",
        axes=tuple(YAxis(f"order {_signed(order)} (m/N)", logarithmic=True) for order in orders),
        traces=tuple(_traces(data, orders)),
        text=(
            "Amplitude of the response at f and at multiples of the crank's frequency beside it, "
            "over the frequency f of the force: identified, predicted, and of the frozen linkage"
        ),
        height=110 + 110 * len(orders),
    )
    return Panel(
        name="running-hammer",
        title="What a hammer finds on the running linkage",
        caption=(
            f"Harmonic transfer functions at {speed}: response of {attrs['response_point']} at "
            f"f + n times the crank's frequency to a force on {attrs['impact_point']} at f, "
            f"{attrs['direction']}, in the axes of the links' rigid frames."
        ),
        equation="Y(v) = Σ H_n(v - n f_crank) P(v - n f_crank)",
        source=(
            "N. M. Wereley and S. R. Hall, 29th IEEE Conference on Decision and Control (1990) "
            "3650-3655"
        ),
        plots=(plot,),
        tables=said.tables,
        lines=(*said.lines, said.verdict),
        warnings=said.warnings,
    )


def _traces(data: xr.Dataset, orders: list[int]) -> list[Trace]:
    """Amplitudes; where nothing answers there is nothing to draw on a logarithmic axis."""
    frequency = data["frequency"].values
    traces = []
    for axis, order in enumerate(orders):
        own = data.sel(order=order)
        for variable, name, colour, look, width in LINES:
            size = np.hypot(own[f"{variable}_real"].values, own[f"{variable}_imag"].values)
            traces.append(
                Trace(
                    name=name,
                    x=frequency,
                    y=np.where(size > 0, size, np.nan),
                    colour=colour,
                    look=look,
                    width=width,
                    axis=axis,
                    legend=axis == 0,
                )
            )
    return traces


def _signed(order: int) -> str:
    return f"{order:+d}" if order else "0"
