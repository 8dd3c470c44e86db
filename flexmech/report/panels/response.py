"""The running linkage: deflections, driving torque, pin forces and spectra."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import Response, Table
from flexmech.report.arrays import MOST_POINTS
from flexmech.report.last_turn import LastTurn, last_turn
from flexmech.report.panel import Choice, Panel, Plot, Reading, Trace, YAxis
from flexmech.report.results import Results
from flexmech.report.words import (
    decimals_of,
    engine_names,
    speed_name,
    speed_unit_of,
    state_of,
    with_error,
)
from flexmech.types import FloatArray


def response_panel(results: Results) -> Panel | None:
    """Deflections, torque and joint forces over the last turn of every run."""
    runs = results.of_kind(Response)
    if not runs:
        return None
    unit = speed_unit_of(results)
    deflection: list[Trace] = []
    force: list[Trace] = []
    shaft: list[Trace] = []
    readings: list[Reading] = []
    thinned = []
    for run in runs:
        data, turn = run.dataset, last_turn(run.dataset)
        for engine in engine_names(data):
            when = _when(run, engine, unit)
            deflection += _deflections(data, turn, engine, when)
            force += _forces(data, turn, engine, when)
            shaft += _shaft(data, turn, engine, when)
            readings += _readings(run, turn, engine, when)
        if turn.left_out:
            thinned.append(
                f"run at {when['speed']}: {len(turn.angle)} of {turn.samples} samples of the last "
                f"turn are kept, at most {MOST_POINTS} to a line"
            )
    links = [str(name) for name in runs[0].dataset["link"].values]
    joints = [str(name) for name in runs[0].dataset["joint"].values]
    plots: tuple[Plot, ...] = (
        Plot(
            "deflection",
            "Crank angle (deg)",
            tuple(YAxis(link) for link in links),
            tuple(deflection),
            f"Deflection in mm of {', '.join(links)} over the last turn",
            "angle",
            tick=60.0,
            height=110 + 120 * len(links),
            title="Deflection (mm)",
        ),
        Plot(
            "forces",
            "Crank angle (deg)",
            (*(YAxis(f"{joint} (N)") for joint in joints), YAxis("torque (N m)")),
            tuple(force),
            "Size of the force of each joint and driving torque over the last turn, elastic and "
            "rigid links",
            "angle",
            tick=60.0,
            height=110 + 100 * (len(joints) + 1),
            title="Joint forces (N) and driving torque (N m)",
        ),
    )
    if shaft:
        plots = (*plots, _shaft_plot(shaft))
    start = {"rigid": "from undeformed links", "equilibrium": "from the quasi-static equilibrium"}
    begun = {start.get(str(run.dataset.attrs["start"]), "on the periodic motion") for run in runs}
    said = [run.summary() for run in runs]
    lines = [
        f"{speed_name(float(run.dataset.attrs['crank_speed']), unit)}: {line}"
        for run, one in zip(runs, said, strict=True)
        for line in (*one.lines, one.verdict)
    ]
    return Panel(
        name="response",
        title="Deflection, pin forces and torque of the running linkage",
        caption=(
            f"Last turn of a run {' or '.join(sorted(begun))}, against crank angle: deflection of "
            "each pinned link's middle and of a clamped link's tip from the straight line of its "
            "frame, size of each joint's force, and the torque of the shaft. Dashed: rigid links."
            + " A free shaft turns away from its prescribed angle, at a speed that fluctuates."
            * bool(shaft)
        ),
        equation="M_r z̈ + C_r ż + K_r z = f(t),  q = N(t) z",
        source=(
            "link frames joined at the pins; reference engine: linear links by the trapezoidal "
            "rule, links that stretch by the square of their slopes by Lobatto's method; Exudyn: "
            "full nonlinear simulation"
        ),
        plots=plots,
        readings=tuple(readings),
        tables=(_peak_table(runs, unit),),
        lines=tuple(lines),
        warnings=tuple(warning for one in said for warning in one.warnings),
        thinned=tuple(thinned),
    )


def spectrum_panel(results: Results) -> Panel | None:
    """Amplitude of each link's deflection over frequency."""
    runs = results.of_kind(Response)
    if not runs:
        return None
    unit = speed_unit_of(results)
    links = [str(name) for name in runs[0].dataset["link"].values]
    traces, at_orders = [], False
    for run in runs:
        data = run.dataset
        stems = bool(data.attrs.get("spectrum_turns"))
        at_orders |= stems
        frequency = data["spectrum_frequency"].values
        for engine in engine_names(data):
            for number, link in enumerate(links):
                amplitude = 1e3 * data["spectrum"].sel(engine=engine, link=link).values
                traces.append(
                    Trace(
                        link,
                        *_spectrum_points(frequency, amplitude, data, stems=stems),
                        colour=number,
                        look="points" if stems else "solid",
                        when=_when(run, engine, unit),
                    )
                )
    plot = Plot(
        "spectrum",
        "Frequency (Hz)",
        (YAxis("Amplitude (mm)", logarithmic=True),),
        tuple(traces),
        f"Amplitude of the deflection of {', '.join(links)} against frequency, logarithmic",
        height=340,
    )
    return Panel(
        name="spectrum",
        title="Spectrum of the deflection",
        caption=(
            "Amplitude of the deflection against frequency"
            + (
                ": points stand at the orders of the crank, as periodic motion has no others."
                * at_orders
            )
        ),
        equation="u(t) = Σ a_n cos(n ω t + φ_n)",
        source="discrete Fourier transform of whole turns, or with a Hann window",
        plots=(plot,),
    )


def _when(run: Response, engine: str, unit: str) -> Choice:
    speed = speed_name(float(run.dataset.attrs["crank_speed"]), unit)
    return {"engine": engine, "state": state_of(run.dataset.attrs), "speed": speed}


def _deflections(data: xr.Dataset, turn: LastTurn, engine: str, when: Choice) -> list[Trace]:
    return [
        Trace(
            link,
            turn.angle,
            turn.of(1e3 * data["deflection"].sel(engine=engine, link=link).values),
            colour=number,
            when=when,
            followed={},
            axis=number,
            legend=False,
        )
        for number, link in enumerate(map(str, data["link"].values))
    ]


def _sizes(force: xr.DataArray) -> FloatArray:
    return np.asarray(np.hypot(force.sel(component="x").values, force.sel(component="y").values))


def _forces(data: xr.Dataset, turn: LastTurn, engine: str, when: Choice) -> list[Trace]:
    joints = [str(name) for name in data["joint"].values]
    own = data.sel(engine=engine)
    pairs: list[tuple[FloatArray, FloatArray]] = [
        (_sizes(own["joint_force"].sel(joint=j)), _sizes(data["rigid_joint_force"].sel(joint=j)))
        for j in joints
    ]
    pairs.append((own["driving_torque"].values, data["rigid_driving_torque"].values))
    traces = []
    for number, (elastic, rigid) in enumerate(pairs):
        traces.append(
            Trace(
                *("elastic links", turn.angle, turn.of(elastic), 0),
                when=when,
                followed={},
                axis=number,
                legend=number == 0,
            )
        )
        traces.append(
            Trace(
                *("rigid links", turn.angle, turn.of(rigid), "#8c8c8c", "dash", 1.0),
                when=when,
                axis=number,
                legend=number == 0,
            )
        )
    return traces


def _shaft(data: xr.Dataset, turn: LastTurn, engine: str, when: Choice) -> list[Trace]:
    """Rotation and speed of a free shaft against what is prescribed."""
    if "shaft_rotation" not in data:
        return []
    own = data.sel(engine=engine)
    rotation = np.degrees(own["shaft_rotation"].values)
    fluctuation = own["crank_speed_fluctuation"].values
    return [
        Trace(
            *("free shaft", turn.angle, turn.of(values), 0),
            when=when,
            followed={},
            axis=number,
            legend=False,
        )
        for number, values in enumerate((rotation, fluctuation))
    ]


def _shaft_plot(traces: list[Trace]) -> Plot:
    return Plot(
        "shaft",
        "Crank angle (deg)",
        (YAxis("rotation (deg)"), YAxis("speed (rad/s)")),
        tuple(traces),
        "Rotation of the free shaft away from its prescribed angle and its speed less the "
        "prescribed one over the last turn",
        "angle",
        tick=60.0,
        height=310,
        title="Free shaft: rotation and speed fluctuation",
    )


def _readings(run: Response, turn: LastTurn, engine: str, when: Choice) -> list[Reading]:
    data = run.dataset
    own, errors = data.sel(engine=engine), run.errors().sel(engine=engine)
    found: list[tuple[str, str, str, FloatArray, float]] = []
    for link in map(str, data["link"].values):
        values = 1e3 * own["deflection"].sel(link=link).values
        peak = 1e3 * float(own["peak_deflection"].sel(link=link))
        error = peak * float(errors["deflection"].sel(link=link))
        found.append(("Deflection", link, "mm", values, error))
    for joint in map(str, data["joint"].values):
        values = _sizes(own["joint_force"].sel(joint=joint))
        peak = float(own["peak_joint_force"].sel(joint=joint))
        error = peak * float(errors["joint_force"].sel(joint=joint))
        found.append(("Joint force", joint, "N", values, error))
    torque, peak = own["driving_torque"].values, float(own["peak_driving_torque"])
    error = peak * float(errors["driving_torque"])
    found.append(("Torque", "shaft", "N m", torque, error))
    return [
        Reading(group, label, unit, turn.angle, turn.of(values), error, when, decimals_of(error))
        for group, label, unit, values, error in found
    ]


def _spectrum_points(
    frequency: FloatArray, amplitude: FloatArray, data: xr.Dataset, *, stems: bool
) -> tuple[FloatArray, FloatArray]:
    """Points of a spectrum: of periodic motion those at the orders alone, without round-off."""
    shown = (frequency > 0) & (amplitude > 1e-6 * amplitude.max(initial=1e-300))
    if stems:
        order = 2 * np.pi * frequency / abs(float(data.attrs["crank_speed"]))
        shown &= np.abs(order - np.round(order)) < 1e-3
    return frequency[shown], amplitude[shown]


def _peak_table(runs: list[Response], unit: str) -> Table:
    rows: list[tuple[str, ...]] = []
    for run in runs:
        data, peaks = run.dataset, run.peaks()
        speed = speed_name(float(data.attrs["crank_speed"]), unit)
        for engine in engine_names(data):
            own, start = peaks.sel(engine=engine), (state_of(data.attrs), engine, speed)
            errors = run.errors().sel(engine=engine)
            found = [
                (
                    *(link, "deflection (mm)", 1e3 * float(own["deflection"].sel(link=link))),
                    float(errors["peak_deflection"].sel(link=link)),
                )
                for link in map(str, data["link"].values)
            ]
            found += [
                (
                    *(joint, "force (N)", float(own["joint_force"].sel(joint=joint))),
                    float(errors["peak_joint_force"].sel(joint=joint)),
                )
                for joint in map(str, data["joint"].values)
            ]
            torque = float(own["driving_torque"]), float(errors["peak_driving_torque"])
            found.append(("shaft", "torque (N m)", *torque))
            rows += [
                (*start, of, what, with_error(value, abs(value) * error))
                for of, what, value, error in found
            ]
    return Table(
        "Peaks",
        ("state", "engine", "speed", "of", "quantity", "peak"),
        (tuple(rows),),
        text_columns=5,
        caption="errors: time step, component modes and, where it was checked, mesh together",
    )
