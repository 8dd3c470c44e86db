"""The panels of the report, in order: each takes the results that it understands."""

from __future__ import annotations

from flexmech.analyses import CrankRockerSynthesis
from flexmech.report.panel import Panel, PanelMaker, panel_of
from flexmech.report.panels.designs import optimum_panel, sweep_panel, uncertainty_panel
from flexmech.report.panels.frequencies import (
    campbell_panel,
    damping_panel,
    frequency_panel,
    stability_panel,
)
from flexmech.report.panels.hammer import comparison_panel, hammer_panel, running_hammer_panel
from flexmech.report.panels.kinematics import (
    balance_panel,
    coupler_panel,
    kinematics_panel,
    mechanism_panel,
)
from flexmech.report.panels.response import (
    motor_panel,
    residual_panel,
    response_panel,
    spectrum_panel,
)
from flexmech.report.panels.sections import moisture_panel, section_panel
from flexmech.report.panels.strength import strength_panel
from flexmech.report.results import Results

__all__ = ["PANELS", "panels_of"]


def other_panel(results: Results) -> Panel | None:
    """Summaries of results that have no panel of their own, in tables and lines."""
    found = [each for each in results.all if isinstance(each, CrankRockerSynthesis)]
    if not found:
        return None
    sources = dict.fromkeys(str(each.dataset.attrs.get("source", "")) for each in found)
    return panel_of(
        "further-results",
        [("", each.said) for each in found],
        source=", ".join(sources),
        titles=", ".join(each.title for each in found),
    )


PANELS: tuple[PanelMaker, ...] = (
    frequency_panel,
    damping_panel,
    campbell_panel,
    stability_panel,
    running_hammer_panel,
    response_panel,
    spectrum_panel,
    residual_panel,
    motor_panel,
    strength_panel,
    hammer_panel,
    comparison_panel,
    kinematics_panel,
    balance_panel,
    coupler_panel,
    section_panel,
    moisture_panel,
    mechanism_panel,
    optimum_panel,
    sweep_panel,
    uncertainty_panel,
    other_panel,
)
"""Each gives its panel, or None where there is no result that it shows."""


def panels_of(results: Results) -> list[Panel]:
    """All panels that there are results for."""
    return [panel for make in PANELS if (panel := make(results)) is not None]
