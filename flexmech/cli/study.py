"""``flexmech study``: whole campaigns, such as the composite crank-rockers of a paper."""

from __future__ import annotations

from pathlib import Path

import typer

from flexmech.cli import options
from flexmech.cli.deliver import deliver
from flexmech.cli.failures import reports_failures
from flexmech.cli.pictures import asked_pictures
from flexmech.cli.printing import prints_as_asked

study_app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)


@study_app.callback()
def studies() -> None:
    """Run a whole campaign and set it beside what is published."""


@study_app.command()
@reports_failures
@prints_as_asked
def composites(
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
) -> None:
    """Composite crank-rockers of Elamy et al. 2023.

    Six laminates, four linkages, three positions of the transmission angle.
    """
    from flexmech.studies import CompositeStudy, study_composites

    deliver(
        CompositeStudy,
        lambda progress: study_composites(progress=progress),
        out,
        pictures=asked_pictures(no_plots, formats, width),
    )
