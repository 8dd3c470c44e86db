"""Results that have no panel of their own: what they say, in tables and lines."""

from __future__ import annotations

from flexmech.analyses import CrankRockerSynthesis, SpeedSweep
from flexmech.report.panel import Panel
from flexmech.report.results import Results

KINDS = (SpeedSweep, CrankRockerSynthesis)


def other_panel(results: Results) -> Panel | None:
    """Summaries of results without a panel."""
    found = [each for each in results.all if isinstance(each, KINDS)]
    if not found:
        return None
    said = [each.summary() for each in found]
    return Panel(
        name="further-results",
        title="Further results",
        caption=f"In words and tables: {', '.join(each.title for each in found)}.",
        source=", ".join(
            dict.fromkeys(str(each.dataset.attrs.get("source", "")) for each in found)
        ),
        tables=tuple(table for one in said for table in one.tables),
        lines=(
            *(line for one in said for line in one.lines),
            *(one.verdict for one in said if one.verdict),
        ),
        warnings=tuple(warning for one in said for warning in one.warnings),
    )
