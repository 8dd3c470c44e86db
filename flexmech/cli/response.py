"""``flexmech response``: the linkage of a model file running."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from flexmech.choices import MODES
from flexmech.cli import arguments, options
from flexmech.cli.deliver import deliver
from flexmech.cli.engines import make_engines
from flexmech.cli.environment import parse_environment
from flexmech.cli.pictures import asked_pictures
from flexmech.cli.running import parse_request

if TYPE_CHECKING:
    from flexmech.analyses import Response
    from flexmech.types import LabelledProgress


def response(
    model: options.Model,
    speed: options.Speed,
    revolutions: options.Revolutions = "4",
    engine: options.Engine = "both",
    element: options.Element = None,
    elements: options.Elements = 8,
    start: options.Start = "rigid",
    step: options.Step = arguments.AUTO,
    samples: options.Samples = 720,
    prestress: options.RunPrestress = "equilibrium",
    shaft: options.Shaft = "prescribed",
    integrator: options.Integrator = "trapezoidal",
    run_up: options.RunUp = "0",
    check_mesh: options.CheckMesh = False,
    modes: options.ModesOfInterest = MODES,
    temperature_rise: options.TemperatureRise = None,
    moisture: options.Moisture = None,
    relative_humidity: options.RelativeHumidity = None,
    time: options.ExposureTime = None,
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
    animate: options.Animate = False,
    store: options.Store = "needed",
) -> None:
    """The running mechanism in time.

    Deflections, strains, driving torque and joint forces at constant crank speed: a table, CSV
    and NetCDF files, pictures and an animation; dry, or in heat and moisture.
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
        prestress=prestress,
    )
    environment = parse_environment(temperature_rise, moisture, relative_humidity, time)

    from flexmech.analyses import response as analysis
    from flexmech.modelfile import load_mechanism
    from flexmech.plots import mp4_available

    mechanism = load_mechanism(model)

    def animations(result: Response, folder: Path, progress: LabelledProgress | None) -> list[Path]:
        return result.save_animations(folder, progress) if animate else []

    remark = arguments.speed_remark("--speed", speed, [request.drive.speed])
    if animate and not mp4_available():
        alone = "animation: a GIF alone, for MP4 needs ffmpeg; install it and run again"
        remark = "\n".join(line for line in (remark, alone) if line)
    deliver(
        analysis.Response,
        lambda progress: analysis.response(
            make_engines(mechanism, engine, element, elements, shaft),
            request,
            check_mesh=check_mesh,
            environment=environment,
            progress=progress,
        ),
        out,
        model=model,
        pictures=asked_pictures(no_plots, formats, width),
        speed_unit=request.speed_unit,
        further=animations,
        remark=remark,
        saving={"store": store},
    )
