"""Commands beside a laboratory: a virtual hammer test, and a measured record."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

from typer import Option

from flexmech import analyses, choices
from flexmech.analyses import typed
from flexmech.cli import options
from flexmech.cli.asking import speeds_or_own
from flexmech.cli.deliver import deliver, mechanism_of
from flexmech.errors import InputError, naming

if TYPE_CHECKING:
    from flexmech.arrays import LabelledProgress


def hammer(
    model: options.Model,
    angle: Annotated[typed.FloatArray, typed.LOCKED_ANGLES] = options.ZERO,
    impact: Annotated[typed.LinkPoint | None, typed.IMPACT] = None,
    response: Annotated[typed.LinkPoint | None, typed.RESPONSE] = None,
    direction: choices.LinkDirection = "transverse",
    averages: Annotated[int, Option(min=1)] = 3,
    bandwidth: Annotated[float | None, typed.BANDWIDTH] = None,
    duration: Annotated[float | None, typed.DURATION] = None,
    pulse: Annotated[float | None, typed.PULSE] = None,
    noise: Annotated[float, typed.NOISE] = options.ZERO,
    grid: Annotated[int | None, Option(min=2)] = None,
    engine: choices.EngineName | None = None,
    element: options.Element = None,
    elements: options.Elements = choices.ELEMENTS_A_LINK,
    prestress: choices.Prestress | None = None,
    damping_ratio: options.DampingRatio = None,
    running: Annotated[typed.Speeds | None, typed.RUNNING] = None,
    uff: Annotated[bool, Option("--uff")] = False,
    seed: Annotated[int, Option(min=0, max=choices.MOST_SEED)] = 0,
    *,
    output: options.AskedOutput,
) -> None:
    """A hammer test of the linkage with its crank locked, as a laboratory does it, or running.

    Force pulse and response in time, coherence, frequency-response function, and natural
    frequencies and damping ratios identified from it, beside those of the eigen model: a table,
    CSV and NetCDF files, and pictures. With --running the harmonic transfer functions of the
    running linkage, by its linear equations.

    Options
    -------
    angle : LIST
        Crank angles in degrees at which the crank is locked: START:STOP:STEP, or a comma list.
    impact : LINK:FRACTION
        Where the hammer hits: a link, and a fraction of its length from its first joint. Left out:
        the middle of the coupler, or of the last link where there is none.
    response : LINK:FRACTION
        Where the displacement is measured. Left out: at the same place.
    direction
        Of force and displacement: across the frame of the rigid link, or along it.
    averages
        Impacts over which spectra are averaged.
    bandwidth : HZ
        Greatest frequency. Left out: a quarter above the fourth natural frequency.
    duration : SECONDS
        Duration of a record. Left out: until the vibration has decayed to 1e-4.
    pulse : SECONDS
        Duration of the half-sine pulse. Left out: one over the bandwidth.
    noise : RMS_FRACTION
        Root mean square of noise over that of the signal, as in 0.01 or "1%".
    grid : N
        Rove the impact over so many points of each link: mode shapes and MAC.
    engine
        exudyn: its nonlinear transient; reference: the exact answer of the linear equations, the
        only one with --running. Left out: exudyn, reference with --running.
    prestress
        none: elastic stiffness alone; axial: with the axial forces of the rigid motion;
        equilibrium: at the nonlinear quasi-static equilibrium. Left out: none where
        the crank is locked, equilibrium with --running.
    running : SPEED
        What a force on the running linkage does at this crank speed, order by order: rad/s unless a
        unit is given, as in "300 rpm"; alone, at the greatest speed at which the model operates.
    uff
        Write universal files too, for the programs of a laboratory.
    seed
        Of the noise: the same seed gives the same noise.
    """
    from flexmech.analyses import running_hammer_test
    from flexmech.analyses.damping_ratios import with_damping_ratio
    from flexmech.analyses.hammer.compute import hammer_test
    from flexmech.analyses.hammer.request import middle_of
    from flexmech.crank_values import GREATEST
    from flexmech.measured_data import check_uff

    mechanism = mechanism_of(model)
    topology = mechanism.linkage.topology
    middle = middle_of(topology)
    points = {"impact": impact or middle, "response": response or impact or middle}
    for option, point in points.items():
        with naming(f"--{option}"):
            point.index(topology)
    record: dict[str, Any] = {
        **points,
        "direction": direction,
        "bandwidth": bandwidth,
        "duration": duration,
    }
    impacts: dict[str, Any] = {
        "averages": averages,
        "pulse": pulse,
        "noise": noise,
        "seed": seed,
        "grid": grid,
    }
    with naming("--pulse, --duration, --averages, --noise"):
        angles, locked = angle, prestress or "none"
        request = analyses.HammerRequest(angles, prestress=locked, **record, **impacts)
    if running is not None:
        usual = analyses.HammerRequest(0.0)
        given = [name for name in impacts if impacts[name] != getattr(usual, name)]
        given += ["angle"] * (angle.tolist() != [0.0]) + ["uff"] * uff
        if given:
            raise InputError(
                f"--{given[0]} does not go with --running, which hits nothing: its answer is that "
                "of the linear equations at all crank angles; leave one of them out"
            )
    elif uff:
        with naming("--uff"):
            check_uff()
    engine = engine or ("exudyn" if running is None else "reference")
    chosen = analyses.chosen_engines(mechanism, engine, element, elements)[0]
    if running is not None:
        own = running if running.numbers else None  # --running alone
        running = speeds_or_own(own, mechanism, "--running", GREATEST)
        record |= {"prestress": prestress or "equilibrium", "damping_ratio": damping_ratio}
        asked = analyses.RunningHammerRequest(running.single, **record, speed_unit=running.unit)
        deliver(
            analyses.RunningHammerTest,
            lambda _: running_hammer_test(chosen, asked),
            output,
            model=model,
            speeds=running,
        )
        return
    deliver(
        analyses.HammerTest,
        lambda progress: hammer_test(
            chosen if damping_ratio is None else with_damping_ratio(chosen, damping_ratio),
            request,
            progress=progress,
        ),
        output,
        model=model,
        further=lambda result, folder, _: result.save_uff(folder) if uff else [],
    )


def compare(
    model: options.Model,
    record: options.GivenPath,
    speed: Annotated[typed.Speeds | None, typed.SPEED_OR_REST] = None,
    angle: Annotated[float | None, typed.RECORD_ANGLE] = None,
    quantity: str | None = None,
    fit: Annotated[tuple[str, ...] | None, typed.FIT] = None,
    engine: choices.EngineName = "reference",
    element: options.Element = None,
    *,
    output: options.AskedOutput,
) -> None:
    """A measured record beside what is computed.

    Over time the running linkage, over the crank angle natural frequencies, over frequency the
    response of the locked linkage. Damping times and stiffness are fitted with their intervals,
    and nothing of that is applied: tables, CSV and NetCDF files and a picture.

    Options
    -------
    record : RECORD
        Measured record: CSV with units in its header, as 'time [s], strain (um/m)', or a universal
        file (.uff, .unv).
    speed : W
        Crank speed at which the record was taken: rad/s unless a unit is given; 0 for natural
        frequencies at rest. Left out, of a record over time: the model's greatest.
    angle : DEG
        Crank angle in degrees at which the crank was locked, for a frequency-response function.
    quantity : COLUMN
        What is computed: a column of response.csv, such as coupler_mid_strain; for a
        frequency-response function the points of impact and response, as coupler:0.5,rocker:0.5,
        behind NAME@ where a file holds several. Left out: what the record's column names, else the
        middle of the coupler.
    fit : LIST
        What is fitted, a comma list: damping, damping:LINK, stiffness:LINK, offset, gain; or none.
        Left out: damping, of a frequency-response function gain too, and nothing for natural
        frequencies.
    engine
        Which engine computes.
    """
    from flexmech.crank_values import GREATEST
    from flexmech.measured_data import read_record

    mechanism, taken = mechanism_of(model), read_record(record)
    if speed is None and angle is None and taken.abscissa == "time":
        speed = speeds_or_own(speed, mechanism, "--speed", GREATEST)
    if (speed is None) == (angle is None):
        raise InputError(
            "--speed, --angle: give one of them: the crank speed at which the record was taken, or "
            "the angle at which the crank was locked"
        )
    with naming("--fit"):
        request = analyses.ComparisonRequest(
            None if speed is None else speed.single,
            None if angle is None else math.radians(angle),
            quantity,
            fit,
            None if speed is None else speed.unit,
        )

    def compute(progress: LabelledProgress | None) -> analyses.Comparison:
        own = analyses.chosen_engines(mechanism, engine, element)[0]
        try:
            return analyses.compare_with_record(own, taken, request, progress=progress)
        except InputError as error:
            # The library names its arguments, which are options here.
            if error.message.startswith(("fit: ", "quantity: ")):
                raise InputError(f"--{error.message}") from error
            raise

    deliver(analyses.Comparison, compute, output, model=model, record=record, speeds=speed)
