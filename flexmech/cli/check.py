"""``flexmech check``: what a model file says, as it was understood."""

from __future__ import annotations

from flexmech.cli import options
from flexmech.cli.arguments import parse_angle
from flexmech.cli.deliver import deliver
from flexmech.cli.pictures import asked_pictures


def check(
    model: options.Model,
    out: options.OptionalOut = None,
    no_plots: options.NoPlots = False,
    angle: options.PostureAngle = None,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
) -> None:
    """Print what was understood of a model file, and remark on what is unusual in it.

    With the first natural frequencies at rest, and a picture: posture, paths, sections to scale
    and transmission angle.
    """
    crank_angle = None if angle is None else parse_angle(angle)

    import numpy as np

    from flexmech.analyses.check import ModelCheck, check_mechanism
    from flexmech.modelfile import load_mechanism
    from flexmech.reference import ReferenceEngine

    mechanism = load_mechanism(model)
    deliver(
        ModelCheck,
        lambda _: check_mechanism(
            ReferenceEngine(mechanism), None if crank_angle is None else np.radians(crank_angle)
        ),
        out,
        model=model,
        pictures=asked_pictures(no_plots, formats, width),
    )
