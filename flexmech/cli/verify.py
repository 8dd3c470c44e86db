"""``flexmech verify``: what flexmech computes on this machine, beside numbers from elsewhere."""

from __future__ import annotations

from flexmech.cli import options
from flexmech.cli.deliver import deliver
from flexmech.cli.pictures import asked_pictures
from flexmech.errors import ComputationError


def verify(
    thorough: options.Thorough = False,
    out: options.OptionalOut = None,
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
) -> None:
    """Verify this installation against published numbers, closed forms and other programs.

    Of each case the number that is farthest off, with its source and tolerance; exit code 1 where
    one fails.
    """
    from flexmech.verification import Verification, verify

    result = deliver(
        Verification,
        lambda progress: verify(thorough=thorough, progress=progress),
        out,
        pictures=asked_pictures(no_plots, formats, width),
    )
    if result.failed:
        count = len(result.failed)
        raise ComputationError(
            f"{count} case{'s' * (count > 1)} of the verification failed: "
            f"{'; '.join(result.failed)}; flexmech is not to be trusted there on this machine"
        )
