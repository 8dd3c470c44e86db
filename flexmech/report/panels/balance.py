"""Counterweights: shaking force, shaking moment and driving torque before and after."""

from __future__ import annotations

from flexmech.analyses import Balance
from flexmech.plots.balance import balance_picture
from flexmech.report import panel
from flexmech.report.plotted import plotted
from flexmech.report.results import Results


@panel.shows(Balance)
def balance_panel(result: Balance, results: Results) -> panel.Panel:
    """Loads over the crank angle as given and balanced, of elastic links where they were run."""
    plot = plotted("balance", balance_picture(result.dataset))
    return panel.panel_of("balance", result.summary(), plots=(plot,))
