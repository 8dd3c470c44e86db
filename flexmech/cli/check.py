"""``flexmech check``: what a model file says, as it was understood."""

from __future__ import annotations

from flexmech.cli import options
from flexmech.cli.deliver import deliver
from flexmech.cli.pictures import asked_pictures


def check(
    model: options.Model,
    out: options.OptionalOut = None,
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
) -> None:
    """Print what was understood of a model file.

    With the first natural frequencies at rest.
    """
    from flexmech.analyses.check import ModelCheck, check_mechanism
    from flexmech.modelfile import load_mechanism
    from flexmech.reference import ReferenceEngine

    mechanism = load_mechanism(model)
    deliver(
        ModelCheck,
        lambda _: check_mechanism(ReferenceEngine(mechanism)),
        out,
        model=model,
        pictures=asked_pictures(no_plots, formats, width),
    )
