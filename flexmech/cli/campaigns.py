"""Commands that run many cases: those of the verification, and the campaign of a paper."""

from __future__ import annotations

from typing import Annotated

from typer import Option

from flexmech.cli import options
from flexmech.cli.deliver import deliver
from flexmech.errors import ComputationError


def verify(
    thorough: Annotated[bool, Option("--thorough")] = False, *, output: options.AskedOptionalOutput
) -> None:
    """Verify this installation against published numbers, closed forms and other programs.

    Of each case the number that is farthest off, with its source and tolerance; exit code 1 where
    one fails.

    Options
    -------
    thorough
        With the cases that take longer.
    """
    from flexmech.verification import Verification, verify

    result = deliver(
        Verification, lambda progress: verify(thorough=thorough, progress=progress), output
    )
    if result.failed:
        count = len(result.failed)
        raise ComputationError(
            f"{count} case{'s' * (count > 1)} of the verification failed: "
            f"{'; '.join(result.failed)}; flexmech is not to be trusted there on this machine"
        )


def composites(output: options.AskedOutput) -> None:
    """Composite crank-rockers of Elamy et al. 2023.

    Six laminates, four linkages, three positions of the transmission angle.
    """
    from flexmech.studies import CompositeStudy, study_composites

    deliver(CompositeStudy, lambda progress: study_composites(progress=progress), output)
