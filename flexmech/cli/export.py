"""``flexmech export``: the running mechanism as a script for Exudyn."""

from __future__ import annotations

from pathlib import Path
from typing import cast

from flexmech.choices import MODES
from flexmech.cli import arguments, options
from flexmech.cli.engines import make_engines
from flexmech.cli.environment import parse_environment
from flexmech.cli.failures import naming, telling
from flexmech.cli.printing import Report
from flexmech.cli.progress import progress_bar
from flexmech.cli.running import parse_request
from flexmech.errors import one_line
from flexmech.files import check_writable, given_path


def export(
    model: options.Model,
    speed: options.Speed,
    revolutions: options.Revolutions = "4",
    element: options.Element = None,
    elements: options.Elements = 8,
    start: options.Start = "rigid",
    step: options.Step = arguments.AUTO,
    samples: options.Samples = 720,
    integrator: options.Integrator = "trapezoidal",
    run_up: options.RunUp = "0",
    modes: options.ModesOfInterest = MODES,
    temperature_rise: options.TemperatureRise = None,
    moisture: options.Moisture = None,
    relative_humidity: options.RelativeHumidity = None,
    time: options.ExposureTime = None,
    out: options.Out = Path("results"),
) -> None:
    """The running mechanism as a script for Exudyn.

    Writes linkage.py, which needs exudyn and numpy alone and makes, solves and shows the system
    that response --engine exudyn runs.
    """
    request = parse_request(
        speed,
        revolutions,
        run_up,
        step,
        samples=samples,
        start=start,
        modes=modes,
        integrator=integrator,
    )
    environment = parse_environment(temperature_rise, moisture, relative_humidity, time)

    from flexmech.analyses import Summary
    from flexmech.analyses.response import exudyn_system
    from flexmech.modelfile import load_mechanism
    from flexmech.multibody import SCRIPT, ExudynEngine

    mechanism = load_mechanism(model)
    with naming("--out"):
        out = given_path(out)
        check_writable(out, [SCRIPT])
    with progress_bar() as progress, telling(model, request.speed_unit):
        [engine] = make_engines(mechanism, "exudyn", element, elements)
        system = exudyn_system(
            cast(ExudynEngine, engine), request, environment=environment, progress=progress
        )
    with naming("--out"):
        [file] = system.save(out)
    counts = (
        f"{len(system.nodes)} nodes, {len(system.objects)} elements, bodies and joints, "
        f"{len(system.sensors)} sensors; {system.steps} steps of {system.step:.4g} s"
    )
    named = one_line(str(file), most=len(str(file)))
    summary = Summary((counts,), f"next: python {named}")
    remark = arguments.speed_remark("--speed", speed, [request.drive.speed])
    Report(summary, (file,), (f"files: {named}",), remark).print()
