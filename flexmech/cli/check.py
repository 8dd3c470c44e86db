"""``flexmech check``: what a model file says, as it was understood."""

from __future__ import annotations

from flexmech.cli.deliver import deliver
from flexmech.cli.failures import reports_failures
from flexmech.cli.options import Model, NoPlots, OptionalOut

__all__ = ["HELP", "check"]

HELP = "Print what was understood of a model file. With the first natural frequencies at rest."


@reports_failures
def check(model: Model, out: OptionalOut = None, no_plots: NoPlots = False) -> None:
    """Print geometry, masses and sections of a model file and its frequencies at rest."""
    from flexmech.analyses.check import ModelCheck, check_mechanism
    from flexmech.modelfile import load_mechanism
    from flexmech.reference import ReferenceEngine

    engine = ReferenceEngine(load_mechanism(model))
    deliver(ModelCheck, lambda _: check_mechanism(engine), out, draw=not no_plots)
