"""Measurements: hammer tests, locked and running, and a record beside what is computed."""

from __future__ import annotations

import numpy as np

from flexmech import plots
from flexmech.analyses import Comparison, HammerTest, RunningHammerTest
from flexmech.plots.frf import CURVES, angle_text
from flexmech.plots.picture import Curve, Pane, Picture
from flexmech.plots.reading import complex_values
from flexmech.plots.style import series_line
from flexmech.report import panel
from flexmech.report.panel import plotted
from flexmech.report.results import Results, speed_name, speed_unit_of

# Curves of both figures that are shown: variable, and dashes or colour and
# more.
RECEPTANCES = (("exact_receptance", "--"), ("receptance", "-"))
# Angles whose curves are shown, each with a colour of its own; the table holds all.
MOST_ANGLES = 6


@panel.shows(HammerTest)
def hammer_panel(result: HammerTest, results: Results) -> panel.Panel:
    """Receptance and coherence over frequency, and measured beside computed modes."""
    data = result.dataset
    shown = min(MOST_ANGLES, data.sizes["crank_angle"])
    left_out = data.sizes["crank_angle"] - shown
    sizes, coherences = list[Curve](), list[Curve]()
    for number in range(shown):
        own = data.isel(crank_angle=number)
        at, frequency, line = angle_text(own), own["frequency"].values, series_line(number)
        for name, dashes in RECEPTANCES:
            size, look = np.abs(complex_values(own, name)), line | {"ls": dashes}
            sizes.append(Curve(frequency, size, look, f"{CURVES[name][0]}, {at}"))
        coherences.append(Curve(frequency, own["coherence"].values, line))
    panes = (
        Pane("Receptance (m/N)", sizes, scale="log", height=1.5),
        Pane("Coherence", coherences),
    )
    plot = plotted("hammer-frf", Picture(panes, "Frequency (Hz)", data, places=frequency))
    of = {name: data.attrs[name] for name in ("impact", "response_point", "direction", "engine")}
    thinned = (f"curves of {left_out} more crank angles",) if left_out else ()
    return panel.panel_of("hammer", result.said, plots=(plot,), thinned=thinned, **of)


@panel.shows(RunningHammerTest)
def running_hammer_panel(result: RunningHammerTest, results: Results) -> panel.Panel:
    """Amplitudes of every order over the frequency of the force."""
    data, attrs = result.dataset, result.dataset.attrs
    plot = plotted("harmonic-response", plots.plot_harmonic_frf.picture(data))
    of = {name: attrs[name] for name in ("response_point", "impact_point", "direction")}
    of["speed"] = speed_name(float(attrs["crank_speed"]), speed_unit_of(results))
    return panel.panel_of("running-hammer", result.said, plots=(plot,), **of)


@panel.shows(Comparison)
def comparison_panel(result: Comparison, results: Results) -> panel.Panel:
    """Measured and computed curves with the residual, and what was fitted."""
    data = result.dataset
    plot = plotted("comparison", plots.plot_comparison.picture(data))
    of = {name: data.attrs[name] for name in ("column", "record", "quantity")}
    return panel.panel_of("comparison", result.said, plots=(plot,), **of)
