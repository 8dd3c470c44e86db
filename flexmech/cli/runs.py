"""Commands on the running linkage in time: its response, and a script for Exudyn that runs it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple, cast

from typer import Option

from flexmech import analyses, choices, plots
from flexmech.analyses import typed
from flexmech.analyses.typed import Together
from flexmech.cli import options
from flexmech.cli.asking import speeds_or_own
from flexmech.cli.deliver import deliver, mechanism_of, progress_bar, say
from flexmech.cli.failures import telling
from flexmech.errors import InputError, naming, one_line
from flexmech.files import check_writable, given_path

if TYPE_CHECKING:
    from flexmech.mechanism import Mechanism


NO_TURNS = (
    "remark: --revolutions counts for nothing under a law that ends: the run lasts until the end "
    "of its last dwell; leave it out"
)


class Run(NamedTuple):
    """What a run is asked to be but for its crank speed; and what was typed.

    Parameters
    ----------
    request : ResponseRequest
    speed : Speeds or None
    revolutions : float or None
    """

    request: analyses.ResponseRequest
    speed: typed.Speeds | None
    revolutions: float | None

    def of(self, mechanism: Mechanism) -> tuple[analyses.ResponseRequest, typed.Speeds]:
        """The request and the speed, the mechanism's own where none was typed."""
        from flexmech.crank_values import DRIVE_OR_GREATEST

        speed = speeds_or_own(self.speed, mechanism, "--speed", DRIVE_OR_GREATEST)
        with naming("--revolutions, --samples, --run-up, --step"):
            request = replace(self.request, **speed.keywords())
        if self.revolutions is not None and request.ends_with_a_law:
            said = [speed.remark, NO_TURNS] if speed.remark else [NO_TURNS]
            speed = replace(speed, remark="\n".join(said))
        return request, speed


def asked_run(
    speed: Annotated[typed.Speeds | None, typed.SPEED] = None,
    revolutions: Annotated[float | None, typed.REVOLUTIONS] = None,
    start: choices.Start = "rigid",
    step: Annotated[float | None, typed.STEP] = options.AUTO,
    samples: Annotated[int, Option(min=8)] = 720,
    integrator: choices.Integrator = "trapezoidal",
    run_up: Annotated[float, typed.RUN_UP] = options.ZERO,
    modes: options.KeptModes = choices.MODES,
    moment_point: options.MomentPoint = None,
) -> Run:
    """A run in time.

    Options
    -------
    speed
        Crank speed: rad/s unless a unit is given, as in "300 rpm". Negative turns backwards. Left
        out: the [drive] of the model, or the greatest speed at which it operates.
    revolutions : NUMBER
        Turns at that speed, or under a motor from rest; may be a fraction; 4 if left out. A law of
        the [drive] ends with its last dwell.
    start
        rigid: undeformed links at the rigid motion's velocities; equilibrium: links bent
        quasi-statically by the loads; periodic: on the periodic motion, under a motor settled.
    step : auto|SECONDS
        Time step: s unless a unit is given, as in "0.1 ms"; auto: halved until deflections hold
        still.
    samples
        Samples saved of each turn, or of each move of a law.
    integrator
        Time integration in Exudyn; the reference engine has its own.
    run_up : SECONDS
        Duration of a smooth (cycloidal) run-up to the speed, before the turns: s unless a unit is
        given.
    modes
        Natural frequencies of interest: set the time step and the spectra's range.
    """
    if start == "periodic" and run_up:
        raise InputError(
            "--start periodic needs a constant crank speed; leave --run-up out, or choose "
            "--start rigid or equilibrium"
        )

    asked = None, 4.0 if revolutions is None else revolutions, samples, start, step, integrator
    with naming("--revolutions, --samples, --run-up"):
        request = analyses.ResponseRequest(*asked, modes=modes, run_up_time=run_up)
    return Run(replace(request, moment_point=moment_point), speed, revolutions)


AskedRun = Annotated[Run, Together(asked_run)]


def asked_shaping(
    shaper: choices.ShaperName | None = None,
    shaped_modes: Annotated[tuple[int, ...] | None, typed.SHAPED_MODES] = None,
    shaped_for: choices.ShapedFor = "end",
    tolerated: Annotated[float | None, typed.TOLERATED] = None,
) -> analyses.Shaping | None:
    """A shaper of the law of motion.

    Options
    -------
    shaper
        Run a law that stops shaped as well, beside the plain one: zv (zero vibration), zvd (zero
        vibration and derivative) or ei (extra insensitive).
    shaped_modes : LIST
        For which it is shaped, as in 1,2. Left out: those that ring by a tenth of the most or more.
    shaped_for
        Whose frequencies count: end, where the crank stops; path, along its path.
    tolerated : RATIO
        For ei: what it leaves at the frequency, over the plain law; 5% if left out.
    """
    shaping = None
    if shaper is not None:
        with naming("--shaper, --shaped-modes, --tolerated"):
            shaping = analyses.Shaping(shaper, shaped_modes, shaped_for, tolerated)
    elif shaped_modes is not None or shaped_for != "end" or tolerated is not None:
        raise InputError("--shaped-modes, --shaped-for, --tolerated need --shaper; add --shaper")
    return shaping


AskedShaping = Annotated["analyses.Shaping | None", Together(asked_shaping)]


def response(
    model: options.Model,
    run: AskedRun,
    shaping: AskedShaping,
    engine: options.Engine = "both",
    element: options.Element = None,
    elements: options.Elements = choices.ELEMENTS_A_LINK,
    prestress: choices.Prestress = "equilibrium",
    shaft: options.Shaft = "prescribed",
    check_mesh: Annotated[bool, Option("--check-mesh")] = False,
    animate: Annotated[bool, Option("--animate")] = False,
    store: choices.Store = "needed",
    *,
    environment: options.AskedEnvironment,
    output: options.AskedOutput,
) -> None:
    """The running mechanism in time.

    Deflections, strains, driving torque and joint forces at constant crank speed, or by the law or
    the motor of [drive]: a table, files, pictures and an animation; dry, or in heat and moisture.
    With --shaper: residual vibration by a shaped law beside the plain one.

    Options
    -------
    prestress
        Of the reference engine's equations and of the frequencies drawn into the spectrogram: as
        in frequencies; at equilibrium the running links stretch by the square of their slopes.
    check_mesh
        Repeat with twice the elements and compare.
    animate
        Write an animation: GIF, and MP4 where ffmpeg exists.
    store
        What response.nc holds: needed for pictures, animation and comparisons; or all, with the
        places and energies of the links at every sample.
    """
    from flexmech.analyses.response.compute import response as analysis

    mechanism = mechanism_of(model)
    request, speed = run.of(mechanism)
    with naming("--shaper"):
        request = replace(request, shaping=shaping, prestress=prestress)
    alone = "animation: a GIF alone, for MP4 needs ffmpeg; install it and run again"
    deliver(
        analyses.Response,
        lambda progress: analysis(
            analyses.chosen_engines(mechanism, engine, element, elements, shaft),
            request,
            check_mesh=check_mesh,
            environment=environment,
            progress=progress,
        ),
        output,
        model=model,
        speeds=speed,
        further=analyses.Response.save_animations if animate else None,
        remark=alone if animate and not plots.mp4_available() else "",
        saving={"store": store},
    )


def export(
    model: options.Model,
    run: AskedRun,
    element: options.Element = None,
    elements: options.Elements = choices.ELEMENTS_A_LINK,
    *,
    environment: options.AskedEnvironment,
    out: options.Out = Path("results"),
    printing: options.AskedPrinting,
) -> None:
    """The running mechanism as a script for Exudyn.

    Writes linkage.py, which needs exudyn and numpy alone and makes, solves and shows the system
    that response --engine exudyn runs.
    """
    from flexmech.analyses.response.compute import exudyn_system
    from flexmech.multibody import SCRIPT, ExudynEngine

    mechanism = mechanism_of(model)
    request, speed = run.of(mechanism)
    with naming("--out"):
        out = given_path(out)
        check_writable(out, [SCRIPT])
    with progress_bar() as progress, telling(model, speed.unit):
        [engine] = analyses.chosen_engines(mechanism, "exudyn", element, elements)
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
    summary = analyses.Summary((counts,), trust=f"next: python {named}", warnings=system.remarks)
    say(summary, [file], [f"files: {named}"], [speed.remark], printing)
