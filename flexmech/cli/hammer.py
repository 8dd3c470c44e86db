"""``flexmech hammer``: the virtual hammer test of a locked or running linkage."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from flexmech import units
from flexmech.choices import ELEMENTS_A_LINK
from flexmech.cli import hammer_options, options
from flexmech.cli.against import parse_damping_ratio
from flexmech.cli.arguments import parse_angles, parse_option
from flexmech.cli.deliver import deliver
from flexmech.cli.engines import make_engines
from flexmech.cli.failures import naming
from flexmech.cli.pictures import asked_pictures
from flexmech.errors import InputError

if TYPE_CHECKING:
    from flexmech.linear_system import LinkPoint
    from flexmech.mechanism import Mechanism


def hammer(
    model: options.Model,
    angle: hammer_options.LockedAngle = "0",
    impact: hammer_options.Impact = None,
    response: hammer_options.ResponsePoint = None,
    direction: hammer_options.Direction = "transverse",
    averages: hammer_options.Averages = 3,
    bandwidth: hammer_options.Bandwidth = None,
    duration: hammer_options.Duration = None,
    pulse: hammer_options.Pulse = None,
    noise: hammer_options.Noise = "0",
    grid: hammer_options.ImpactGrid = None,
    engine: hammer_options.HammerEngine = "exudyn",
    element: options.Element = None,
    elements: options.Elements = ELEMENTS_A_LINK,
    prestress: options.Prestress = "none",
    damping_ratio: options.DampingRatio = None,
    running: hammer_options.Running = None,
    uff: hammer_options.UniversalFile = False,
    seed: hammer_options.Seed = 0,
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
) -> None:
    """A hammer test of the linkage with its crank locked, as a laboratory does it, or running.

    Force pulse and response in time, coherence, frequency-response function, and natural
    frequencies and damping ratios identified from it, beside those of the eigen model: a table,
    CSV and NetCDF files, and pictures.
    """
    degrees, ratio = parse_angles(angle, "--angle"), parse_damping_ratio(damping_ratio)
    seconds = {"--duration": duration, "--pulse": pulse}
    lasting, pushing = (
        None if text is None else _positive(option, text, units.TIME)
        for option, text in seconds.items()
    )
    band = None if bandwidth is None else _positive("--bandwidth", bandwidth, units.FREQUENCY)
    fraction = parse_option("--noise", noise, units.RATIO)

    import numpy as np

    from flexmech.analyses.damping_ratios import with_damping_ratio
    from flexmech.analyses.hammer import HammerRequest, HammerTest, hammer_test
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    hit = _point(mechanism, "--impact", impact)
    request = HammerRequest(
        np.radians(degrees),
        impact=hit,
        response=hit if response is None else _point(mechanism, "--response", response),
        direction=direction,
        averages=averages,
        bandwidth=band,
        duration=lasting,
        pulse=pushing,
        noise=fraction,
        seed=seed,
        prestress=prestress,
        grid=grid,
    )
    if running is not None:
        raise InputError("--running: this version hits the locked linkage alone; leave it out")
    if uff:
        raise InputError("--uff: this version writes no universal files; leave it out")
    chosen = make_engines(mechanism, engine, element, elements)[0]
    deliver(
        HammerTest,
        lambda progress: hammer_test(
            chosen if ratio is None else with_damping_ratio(chosen, ratio),
            request,
            progress=progress,
        ),
        out,
        model=model,
        pictures=asked_pictures(no_plots, "png", "two-column"),
    )


def _point(mechanism: Mechanism, option: str, text: str | None) -> LinkPoint:
    """Point of an option; the middle of the coupler, or of the last link, where it is left out."""
    from flexmech.linear_system import LinkPoint

    topology = mechanism.linkage.topology
    names = topology.link_names
    if text is None:
        return LinkPoint("coupler" if "coupler" in names else names[-1], 0.5)
    with naming(option):
        point = LinkPoint.parse(text)
        point.index(topology)
    return point


def _positive(option: str, text: str, dimension: units.Dimension) -> float:
    value = parse_option(option, text, dimension, dimension.unit)
    if value <= 0:
        raise InputError(f"{option}: must be positive, got {text!r}")
    return value
