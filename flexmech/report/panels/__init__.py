"""The panels of the report, in order: each takes the results that it understands."""

from __future__ import annotations

from collections.abc import Callable

from flexmech.report.panel import Panel
from flexmech.report.panels.campbell import campbell_panel
from flexmech.report.panels.comparison import comparison_panel
from flexmech.report.panels.coupler_curve import coupler_panel
from flexmech.report.panels.frequencies import damping_panel, frequency_panel
from flexmech.report.panels.hammer import hammer_panel
from flexmech.report.panels.kinematics import kinematics_panel
from flexmech.report.panels.mechanism import mechanism_panel
from flexmech.report.panels.moisture import moisture_panel
from flexmech.report.panels.other import other_panel
from flexmech.report.panels.response import response_panel, spectrum_panel
from flexmech.report.panels.running_hammer import running_hammer_panel
from flexmech.report.panels.sections import section_panel
from flexmech.report.panels.stability import stability_panel
from flexmech.report.results import Results

__all__ = ["PANELS", "panels_of"]

PANELS: tuple[Callable[[Results], Panel | None], ...] = (
    frequency_panel,
    damping_panel,
    campbell_panel,
    stability_panel,
    running_hammer_panel,
    response_panel,
    spectrum_panel,
    hammer_panel,
    comparison_panel,
    kinematics_panel,
    coupler_panel,
    section_panel,
    moisture_panel,
    mechanism_panel,
    other_panel,
)
"""Each gives its panel, or None where there is no result that it shows."""


def panels_of(results: Results) -> list[Panel]:
    """All panels that there are results for."""
    return [panel for make in PANELS if (panel := make(results)) is not None]
