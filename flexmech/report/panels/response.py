"""The running linkage: deflections, driving torque, pin forces and spectra."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses import Response, Table
from flexmech.analyses.digits import decimals_of, with_error
from flexmech.arrays import FloatArray
from flexmech.plots.reading import STARTS, bending_links, names_of
from flexmech.report.last_turn import MOST_POINTS, LastTurn, over_a_turn
from flexmech.report.panel import (
    FRAME_HEIGHT,
    GREY,
    Choice,
    Look,
    Panel,
    Plot,
    Reading,
    Trace,
    YAxis,
    further_lines,
    over_angle,
    panel_of,
)
from flexmech.report.panels.kinematics import forces_plot
from flexmech.report.results import (
    Results,
    speed_name,
    speed_unit_of,
    state_of,
)


def response_panel(results: Results) -> Panel | None:
    """Deflections, torque and joint forces over the last turn of every run."""
    runs, unit = results.of_kind(Response), speed_unit_of(results)
    if not runs:
        return None
    deflection, force, shaft = list[Trace](), list[Trace](), list[Trace]()
    frame = list[Trace]()
    links, joints = bending_links(runs[0].dataset), names_of(runs[0].dataset, "joint")
    states = {state_of(run.dataset.attrs) for run in runs}
    answer, readings, lines = list[str](), list[Reading](), list[str]()
    warnings, thinned = list[str](), list[str]()
    for run in runs:
        data, said = run.dataset, run.summary()
        turn = over_a_turn(data["crank_angle"].values)
        speed = speed_name(float(data.attrs["crank_speed"]), unit)
        for engine in names_of(data, "engine"):
            shown = _Shown(data, turn, engine, _when(run, engine, unit))
            deflection += _deflections(shown, links)
            force += _forces(shown)
            shaft += _shaft(shown)
            frame += _frame(shown)
            readings += _readings(run, shown, links)
        at = f"{speed}, {state_of(data.attrs)}" if len(states) > 1 else speed
        answer += [f"{at}: {line}" for line in said.answer]
        lines += [f"{at}: {line}" for line in further_lines(said)]
        warnings += said.warnings
        if turn.left_out:
            thinned.append(
                f"run at {speed}: {len(turn.angle)} of {turn.samples} samples of the last "
                f"turn are kept, at most {MOST_POINTS} to a line"
            )
    plots = [
        over_angle(
            "deflection",
            tuple(YAxis(link) for link in links),
            deflection,
            text=f"Deflection in mm of {', '.join(links)} over the last turn",
            height=FRAME_HEIGHT + 120 * len(links),
            title="Deflection (mm)",
        ),
        forces_plot("forces", joints, force, "over the last turn, elastic and rigid links"),
    ]
    if shaft:
        plots.append(
            over_angle(
                "shaft",
                (YAxis("rotation (deg)"), YAxis("speed (rad/s)")),
                shaft,
                text="Rotation of the free shaft away from its prescribed angle and its speed less "
                "the prescribed one over the last turn",
                height=310,
                title="Free shaft: rotation and speed fluctuation",
            )
        )
    if frame:
        plots.append(
            over_angle(
                "frame",
                (YAxis("x (mm)"), YAxis("y (mm)"), YAxis("rotation (deg)"), YAxis("floor (N)")),
                frame,
                text="Displacement and rotation of the frame on springs, and the size of the force "
                "on the floor, over the last turn",
                height=480,
                title="Frame on springs: displacement, rotation, force on the floor",
            )
        )
    begun = {STARTS[str(run.dataset.attrs["start"])] for run in runs}
    return panel_of(
        "response",
        answer=tuple(answer),
        plots=tuple(plots),
        readings=tuple(readings),
        tables=(_peak_table(runs, links, unit),),
        lines=tuple(lines),
        warnings=tuple(warnings),
        thinned=tuple(thinned),
        begun=" or ".join(sorted(begun)),
        free_shaft=(
            " A free shaft turns away from its prescribed angle, at a speed that fluctuates."
            * bool(shaft)
        ),
    )


def spectrum_panel(results: Results) -> Panel | None:
    """Amplitude of each link's deflection over frequency."""
    runs, unit = results.of_kind(Response), speed_unit_of(results)
    if not runs:
        return None
    links = bending_links(runs[0].dataset)
    traces, at_orders = list[Trace](), False
    for run in runs:
        data = run.dataset
        stems = bool(data.attrs.get("spectrum_turns"))
        at_orders |= stems
        for engine in names_of(data, "engine"):
            for number, link in enumerate(links):
                amplitude = 1e3 * data["spectrum"].sel(engine=engine, link=link).values
                points = _spectrum_points(amplitude, data, stems=stems)
                look: Look = "points" if stems else "solid"
                traces.append(Trace(link, *points, number, look, when=_when(run, engine, unit)))
    plot = Plot(
        "spectrum",
        "Frequency (Hz)",
        (YAxis("Amplitude (mm)", logarithmic=True),),
        tuple(traces),
        f"Amplitude of the deflection of {', '.join(links)} against frequency, logarithmic",
        height=340,
    )
    orders = ": points stand at the orders of the crank, as periodic motion has no others."
    return panel_of("spectrum", plots=(plot,), at_orders=orders * at_orders)


@dataclass(frozen=True)
class _Shown:
    """A run by one engine over the last turn, and what the reader must have chosen to see it."""

    data: xr.Dataset
    turn: LastTurn
    engine: str
    when: Choice

    @property
    def own(self) -> xr.Dataset:
        """Of the engine."""
        return self.data.sel(engine=self.engine)

    def trace(self, name: str, values: FloatArray, axis: int, colour: int = 0) -> Trace:
        """A line whose values the cursor's dot follows."""
        along = self.turn.angle, self.turn.of(values), colour
        return Trace(name, *along, when=self.when, followed={}, axis=axis, legend=False)


def _when(run: Response, engine: str, unit: str) -> Choice:
    speed = speed_name(float(run.dataset.attrs["crank_speed"]), unit)
    return {"engine": engine, "state": state_of(run.dataset.attrs), "speed": speed}


def _deflections(run: _Shown, links: list[str]) -> list[Trace]:
    deflection = 1e3 * run.own["deflection"].sel(link=links).transpose("link", ...).values
    named = enumerate(zip(links, deflection, strict=True))
    return [run.trace(link, values, number, number) for number, (link, values) in named]


def _sizes(force: xr.DataArray) -> FloatArray:
    return np.asarray(np.hypot(force.sel(component="x").values, force.sel(component="y").values))


def _forces(run: _Shown) -> list[Trace]:
    """Sizes of the joint forces and the torque, of elastic and of rigid links."""
    own, data = run.own, run.data
    pairs: list[tuple[FloatArray, FloatArray]] = [
        (_sizes(own["joint_force"].sel(joint=j)), _sizes(data["rigid_joint_force"].sel(joint=j)))
        for j in names_of(data, "joint")
    ]
    pairs.append((own["driving_torque"].values, data["rigid_driving_torque"].values))
    traces = []
    for axis, (elastic, rigid) in enumerate(pairs):
        line = run.trace("elastic links", elastic, axis)
        grey: dict[str, Any] = {"colour": GREY, "look": "dash", "width": 1.0, "followed": None}
        both = line, replace(line, name="rigid links", y=run.turn.of(rigid), **grey)
        traces += [replace(each, legend=axis == 0) for each in both]
    return traces


def _shaft(run: _Shown) -> list[Trace]:
    """Rotation and speed of a free shaft against what is prescribed."""
    if "shaft_rotation" not in run.data:
        return []
    rotation = np.degrees(run.own["shaft_rotation"].values)
    fluctuation = run.own["crank_speed_fluctuation"].values
    return [
        run.trace("free shaft", each, axis) for axis, each in enumerate((rotation, fluctuation))
    ]


def _frame(run: _Shown) -> list[Trace]:
    """Displacement and rotation of a frame on springs, and the size of the force on the floor."""
    if "frame_displacement" not in run.data:
        return []
    own = run.own
    along = [1e3 * own["frame_displacement"].sel(component=one).values for one in ("x", "y")]
    turned = np.degrees(own["frame_rotation"].values)
    lines = (*along, turned, _sizes(own["floor_force"]))
    return [run.trace("frame", each, axis) for axis, each in enumerate(lines)]


def _readings(run: Response, shown: _Shown, links: list[str]) -> list[Reading]:
    """Deflections, joint forces and torque with their errors, which are parts of the peaks."""
    own, errors = shown.own, run.errors().sel(engine=shown.engine)
    found: list[tuple[str, str, str, FloatArray, float]] = []
    for link in links:
        values, at = 1e3 * own["deflection"].sel(link=link).values, {"link": link}
        error = 1e3 * float(own["peak_deflection"].sel(at)) * float(errors["deflection"].sel(at))
        found.append(("Deflection", link, "mm", values, error))
    for joint in names_of(own, "joint"):
        values, at = _sizes(own["joint_force"].sel(joint=joint)), {"joint": joint}
        error = float(own["peak_joint_force"].sel(at)) * float(errors["joint_force"].sel(at))
        found.append(("Joint force", joint, "N", values, error))
    error = float(own["peak_driving_torque"]) * float(errors["driving_torque"])
    found.append(("Torque", "shaft", "N m", own["driving_torque"].values, error))
    turn, when = shown.turn, shown.when
    return [
        Reading(group, label, unit, turn.angle, turn.of(values), error, when, decimals_of(error))
        for group, label, unit, values, error in found
    ]


def _spectrum_points(
    amplitude: FloatArray, data: xr.Dataset, *, stems: bool
) -> tuple[FloatArray, FloatArray]:
    """Points of a spectrum: of periodic motion those at the orders alone, without round-off."""
    frequency = data["spectrum_frequency"].values
    shown = (frequency > 0) & (amplitude > 1e-6 * amplitude.max(initial=1e-300))
    if stems:
        order = 2 * np.pi * frequency / abs(float(data.attrs["crank_speed"]))
        shown &= np.abs(order - np.round(order)) < 1e-3
    return frequency[shown], amplitude[shown]


def _peak_table(runs: list[Response], links: list[str], unit: str) -> Table:
    rows: list[tuple[str, ...]] = []
    for run in runs:
        data, peaks = run.dataset, run.peaks()
        speed = speed_name(float(data.attrs["crank_speed"]), unit)
        for engine in names_of(data, "engine"):
            own, errors = peaks.sel(engine=engine), run.errors().sel(engine=engine)
            of_links = [(link, {"link": link}) for link in links]
            of_joints = [(joint, {"joint": joint}) for joint in names_of(data, "joint")]
            found = [("deflection", "deflection (mm)", 1e3, *each) for each in of_links]
            found += [("joint_force", "force (N)", 1.0, *each) for each in of_joints]
            found.append(("driving_torque", "torque (N m)", 1.0, "shaft", {}))
            for name, what, factor, of, place in found:
                value = factor * float(own[name].sel(place))
                error = abs(value) * float(errors[f"peak_{name}"].sel(place))
                start = state_of(data.attrs), engine, speed
                rows.append((*start, of, what, with_error(value, error)))
    return Table(
        "Peaks",
        ("state", "engine", "speed", "of", "quantity", "peak"),
        (tuple(rows),),
        text_columns=5,
        caption="errors: time step, component modes and, where it was checked, mesh together",
    )
