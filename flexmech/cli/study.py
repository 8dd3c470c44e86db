"""``flexmech study``: whole campaigns, such as the composite crank-rockers of a paper."""

from __future__ import annotations

from pathlib import Path

import typer

from flexmech.cli.deliver import deliver
from flexmech.cli.failures import reports_failures
from flexmech.cli.options import NoPlots, Out

__all__ = ["HELP", "study_app"]

HELP = "Run a whole campaign and set it beside what is published."

study_app = typer.Typer(help=HELP, no_args_is_help=True, rich_markup_mode=None)


@study_app.callback()
def studies() -> None:
    """Choose a campaign."""


@study_app.command(
    "composites",
    help="Composite crank-rockers of Elamy et al. 2023: six laminates, four linkages, three "
    "positions of the transmission angle.",
)
@reports_failures
def composites(out: Out = Path("results"), no_plots: NoPlots = False) -> None:
    """Compute, save, draw and report the campaign, claim by claim."""
    from flexmech.studies import CompositeStudy, study_composites

    deliver(
        CompositeStudy,
        lambda progress: study_composites(progress=progress),
        out,
        draw=not no_plots,
    )
