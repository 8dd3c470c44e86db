"""Counterweights: shaking force, shaking moment and driving torque before and after."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmech.analyses import Balance
from flexmech.plots.reading import degrees, names_of
from flexmech.report import panel
from flexmech.report.results import Results


@panel.shows(Balance)
def balance_panel(result: Balance, results: Results) -> panel.Panel:
    """Loads over the crank angle as given and balanced, of elastic links where they were run."""
    data, traces = result.dataset, list[panel.Trace]()
    angle, states = degrees(data["crank_angle"]), names_of(data, "state")
    for number, state in enumerate(states):
        own = data.sel(state=state)
        force = np.linalg.norm(own["shaking_force"].values, axis=-1)
        lines = force, own["shaking_moment"].values, own["driving_torque"].values
        for axis, values in enumerate(lines):
            look: dict[str, Any] = {"axis": axis, "legend": axis == 0, "followed": {}}
            traces.append(panel.Trace(state, angle, values, number, **look))
        if "elastic_shaking_force" in own:
            turned = np.degrees(own["elastic_angle"].values)
            running = np.linalg.norm(own["elastic_shaking_force"].values, axis=-1)
            name = f"{state}, elastic links"
            traces.append(panel.Trace(name, turned, running, number, "dot", 1.0))
    axes = ("shaking force (N)", "shaking moment (N m)", "driving torque (N m)")
    plot = panel.over_angle(
        "balance",
        tuple(panel.YAxis(title) for title in axes),
        traces,
        text="Shaking force, shaking moment and driving torque over the crank angle, as given and "
        "balanced",
        height=480,
    )
    return panel.panel_of("balance", result.summary(), plots=(plot,))
