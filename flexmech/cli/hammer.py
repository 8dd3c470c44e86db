"""``flexmech hammer``: the virtual hammer test of a locked or running linkage."""

from __future__ import annotations

from pathlib import Path

from flexmech import units
from flexmech.choices import ELEMENTS_A_LINK
from flexmech.cli import hammer_options, options
from flexmech.cli.against import parse_damping_ratio
from flexmech.cli.arguments import parse_angles, parse_option
from flexmech.cli.deliver import deliver
from flexmech.cli.engines import make_engines
from flexmech.cli.failures import naming
from flexmech.cli.hammer_parsing import parse_point, parse_positive
from flexmech.cli.pictures import asked_pictures
from flexmech.cli.running_hammer import deliver_running_hammer, refuse_when_running


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
    prestress: hammer_options.HammerPrestress = None,
    damping_ratio: options.DampingRatio = None,
    running: hammer_options.Running = None,
    uff: hammer_options.UniversalFile = False,
    seed: hammer_options.Seed = 0,
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
) -> None:
    """A hammer test of the linkage with its crank locked, as a laboratory does it, or running.

    Force pulse and response in time, coherence, frequency-response function, and natural
    frequencies and damping ratios identified from it, beside those of the eigen model: a table,
    CSV and NetCDF files, and pictures.
    """
    degrees, ratio = parse_angles(angle, "--angle"), parse_damping_ratio(damping_ratio)
    seconds = {"--duration": duration, "--pulse": pulse}
    lasting, pushing = (
        None if text is None else parse_positive(option, text, units.TIME)
        for option, text in seconds.items()
    )
    band = None if bandwidth is None else parse_positive("--bandwidth", bandwidth, units.FREQUENCY)
    fraction = parse_option("--noise", noise, units.RATIO)

    import numpy as np

    from flexmech.analyses.damping_ratios import with_damping_ratio
    from flexmech.analyses.hammer import HammerRequest, HammerTest, hammer_test
    from flexmech.measured_data import check_uff
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    hit = parse_point(mechanism, "--impact", impact)
    seen = hit if response is None else parse_point(mechanism, "--response", response)
    with naming("--pulse, --duration, --averages, --noise"):
        request = HammerRequest(
            np.radians(degrees),
            impact=hit,
            response=seen,
            direction=direction,
            averages=averages,
            bandwidth=band,
            duration=lasting,
            pulse=pushing,
            noise=fraction,
            seed=seed,
            prestress=prestress or "none",
            grid=grid,
        )
    pictures = asked_pictures(no_plots, formats, width)
    if running is not None:
        refuse_when_running(angle != "0", grid is not None, uff)
        chosen = make_engines(mechanism, engine, element, elements)[0]
        deliver_running_hammer(
            running, request, prestress or "equilibrium", ratio, chosen, out, model, pictures
        )
        return
    if uff:
        with naming("--uff"):
            check_uff()
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
        pictures=pictures,
        further=lambda result, folder, _: result.save_uff(folder) if uff else [],
    )
