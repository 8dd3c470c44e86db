"""Commands that map natural frequencies and stability over the crank speed."""

from __future__ import annotations

from typing import Annotated

import typer

from flexmech import analyses, choices
from flexmech.analyses import typed
from flexmech.analyses.options import CampbellOptions
from flexmech.choices import ELEMENTS_A_LINK, KEPT_MODES, TOLERANCE
from flexmech.cli import options
from flexmech.cli.asking import question, speeds_or_own
from flexmech.cli.deliver import deliver, mechanism_of
from flexmech.cli.stopping import Stopped, answered_signals
from flexmech.errors import naming


def frequencies(
    model: options.Model,
    speeds: options.Speeds = None,
    angles: options.Angles = options.EVERY_5_DEGREES,
    modes: options.Modes = None,
    shapes_at: Annotated[typed.FloatArray | None, typed.SHAPES_AT] = None,
    engine: options.Engine = "both",
    element: options.Element = None,
    prestress: choices.MapPrestress = "equilibrium",
    rotation_terms: options.RotationTerms = options.ALL,
    elements: options.PinnedElements = None,
    shaft: options.Shaft = "prescribed",
    mass: choices.MassChoice = "distributed",
    tolerance: options.Tolerance = TOLERANCE,
    *,
    environment: options.AskedEnvironment,
    output: options.AskedOutput,
) -> None:
    """Moving natural frequencies of a mechanism.

    Over crank angle and crank speed: a table, CSV and NetCDF files, and pictures; in heat and
    moisture, beside those of the dry linkage.

    Options
    -------
    shapes_at : LIST
        Crank angles in degrees at which mode shapes are drawn, a picture each. Left out: the
        first of --angles.
    prestress
        none: elastic stiffness alone; axial: with the axial forces of the rigid motion;
        equilibrium: at the nonlinear quasi-static equilibrium; trajectory: in the
        states that the periodic motion runs through, beside the quasi-static ones.
    mass
        distributed: along the links; lumped: in points as Kumar & Chandrakar have it, twelve of a
        four-bar. Of the reference engine; Exudyn keeps distributed mass.
    """
    from flexmech.crank_values import operating_speeds

    mechanism = mechanism_of(model)
    drawn = bool(output.pictures.formats)
    speeds = speeds_or_own(speeds, mechanism, "--speeds", operating_speeds)
    deliver(
        analyses.MovingFrequencies,
        lambda progress: analyses.moving_frequencies(
            analyses.chosen_engines(mechanism, engine, element, elements, mass=mass),
            angles,
            speeds.numbers,
            modes=modes,
            prestress=prestress,
            rotation_terms=rotation_terms,
            speed_effect="fastest" if drawn and prestress != "none" else False,
            environment=environment,
            speed_unit=speeds.unit,
            tolerance=tolerance if elements is None else None,
            shapes_at=None if shapes_at is None else shapes_at,
            smooth=drawn,
            shaft=shaft,
            progress=progress,
        ),
        output,
        model=model,
        speeds=speeds,
    )


campbell = question(
    "campbell",
    "CampbellDiagram",
    CampbellOptions,
    engine="reference",
    rotation_terms=options.ALL,
    tolerance=TOLERANCE,
)


def stability(
    model: options.Model,
    speeds: Annotated[typed.Speeds | None, typed.SPEEDS] = None,
    engine: choices.EngineChoice = "reference",
    prestress: choices.StabilityPrestress | None = None,
    frame: choices.MovingFrame = "link",
    element: options.Element = None,
    elements: options.Elements = ELEMENTS_A_LINK,
    shaft: options.Shaft = "prescribed",
    modes: options.KeptModes = KEPT_MODES,
    steps: Annotated[int | None, typed.STEPS] = options.AUTO,
    damping_ratio: options.DampingRatio = None,
    against: tuple[str, str] | None = None,
    *,
    output: options.AskedOutput,
) -> None:
    """At which crank speeds the running linkage shakes itself up: a stability map.

    Growth rates and Floquet multipliers over crank speed, and the unstable bands with the errors
    of their edges and the damping that closes them: a table, CSV and NetCDF files, and pictures.
    Ctrl-C ends the map early and keeps what is done.

    Options
    -------
    speeds : LIST
        Crank speeds: START:STOP:STEP or a comma list with one unit at the end, as in "50:1100:10
        rpm"; rad/s if there is none. Not zero, and all of one sign. Left out: from half to 1.5
        times the model's greatest.
    engine
        Which engine computes; both stand side by side.
    prestress
        About which motion: axial: straight links with the axial forces of the rigid motion;
        equilibrium: the nonlinear quasi-static equilibrium; trajectory: the periodic motion
        itself. Left out: trajectory where links are damped, equilibrium elsewhere and with
        --against.
    frame
        Frame of the coordinates; multipliers are the same in both.
    modes
        Natural modes whose Floquet modes are kept.
    steps : auto|N
        Steps of the propagator a turn, a multiple of 16; auto: by the fastest mode.
    against : PARAMETER RANGE
        Also a map over a second parameter: damping-ratio, moisture, temperature-rise, or a
        quantity of the model file such as links.coupler.in_plane_thickness; over a comma list or
        START:STOP:STEPS, as in "damping-ratio 0:2%:20" for 20 equal steps from 0 to 2 %.
    """
    from flexmech.analyses.stability.against import asked_range
    from flexmech.analyses.stability.compute import stability as analysis
    from flexmech.crank_values import STABILITY

    mechanism = mechanism_of(model)
    speeds = speeds_or_own(speeds, mechanism, "--speeds", STABILITY)
    with naming("--against"):
        second = None if against is None else asked_range(mechanism, *against)
    earlier = len(answered_signals())
    found = deliver(
        analyses.StabilityMap,
        lambda progress: analysis(
            analyses.chosen_engines(mechanism, engine, element, elements),
            speeds.numbers,
            prestress=prestress,
            frame=frame,
            modes=modes,
            steps=steps,
            damping_ratio=damping_ratio,
            against=second,
            speed_unit=speeds.unit,
            shaft=shaft,
            progress=progress,
        ),
        output,
        model=model,
        speeds=speeds,
    )
    if found.is_interrupted:
        raise typer.Exit(Stopped(*answered_signals()[earlier:][-1:]).exit_code)
