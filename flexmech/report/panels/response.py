"""The running linkage: deflections, forces, spectra, motors, and what rings after a stop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech import plots
from flexmech.analyses import Kinematics, Response
from flexmech.analyses.digits import decimals_of
from flexmech.arrays import FloatArray
from flexmech.plots.picture import Choice, Picture, joined
from flexmech.plots.reading import STARTS, bending_links, names_of
from flexmech.plots.response import over_time, shaft_panes
from flexmech.plots.spectra import spectrum_picture
from flexmech.report.panel import (
    Panel,
    Plot,
    Reading,
    further_lines,
    panel_of,
    plotted,
)
from flexmech.report.results import (
    MOST_POINTS,
    Results,
    over_a_turn,
    speed_name,
    speed_unit_of,
    state_of,
)


def _deflections(data: xr.Dataset) -> Picture:
    return plots.plot_response.picture(data.drop_vars("shaft_rotation", errors="ignore"))


def _forces(data: xr.Dataset) -> Picture:
    return plots.plot_forces.picture(data.drop_vars("driving_power", errors="ignore"))


def _shaft(data: xr.Dataset) -> Picture:
    return over_time(data, shaft_panes(data), "")


def _frame(data: xr.Dataset) -> Picture:
    return plots.plot_frame_motion.picture(data)


# Over the last turn: name of the plot, its title, its picture, and what there must be for it.
PICTURES: tuple[tuple[str, str, Callable[[xr.Dataset], Picture], str], ...] = (
    ("deflection", "Deflection and strain", _deflections, "deflection"),
    ("forces", "Joint forces and driving torque", _forces, "joint_force"),
    ("shaft", "Free shaft: rotation and speed fluctuation", _shaft, "shaft_rotation"),
    ("frame", "Frame on springs, and force on the floor", _frame, "frame_displacement"),
)


def response_panel(results: Results) -> Panel | None:
    """Deflections, torque and joint forces over the last turn of every run."""
    runs, unit = results.of_kind(Response), speed_unit_of(results)
    if not runs:
        return None
    links, shown = bending_links(runs[0].dataset), list[tuple[Choice, xr.Dataset]]()
    states = {state_of(run.dataset.attrs) for run in runs}
    readings, thinned, names = list[Reading](), list[str](), list[str]()
    for run in runs:
        data, turn = run.dataset, over_a_turn(run.dataset["crank_angle"].values)
        speed = speed_name(float(data.attrs["crank_speed"]), unit)
        names.append(f"{speed}, {state_of(data.attrs)}" if len(states) > 1 else speed)
        over_turn = data.isel(time=turn.kept).assign_coords(time=turn.angle)
        for number, engine in enumerate(names_of(data, "engine")):
            when = _when(run, engine, unit)
            shown.append((when, over_turn.isel(engine=[number])))
            readings += _readings(run, shown[-1][1].isel(engine=0), when, links)
        if turn.left_out:
            thinned.append(
                f"run at {speed}: {len(turn.angle)} of {turn.samples} samples of the last "
                f"turn are kept, at most {MOST_POINTS} to a line"
            )
    begun = {STARTS[str(run.dataset.attrs["start"])] for run in runs}
    return panel_of(
        "response",
        [(f"{name}: ", run.said) for name, run in zip(names, runs, strict=True)],
        plots=tuple(
            _over_turn(name, title, picture, those)
            for name, title, picture, variable in PICTURES
            if (those := [(when, data) for when, data in shown if variable in data])
        ),
        readings=tuple(readings),
        thinned=tuple(thinned),
        begun=" or ".join(sorted(begun)),
        free_shaft=(
            " A free shaft turns away from its prescribed angle, at a speed that fluctuates."
            * any("shaft_rotation" in data for _, data in shown)
        ),
    )


def spectrum_panel(results: Results) -> Panel | None:
    """Amplitude of each link's deflection over frequency."""
    runs, unit = results.of_kind(Response), speed_unit_of(results)
    if not runs:
        return None
    shown = [
        (_when(run, engine, unit), spectrum_picture(run.dataset.isel(engine=[number])))
        for run in runs
        for number, engine in enumerate(names_of(run.dataset, "engine"))
    ]
    plot = plotted("spectrum", joined(shown))
    at_orders = any(run.dataset.attrs.get("spectrum_turns") for run in runs)
    orders = ": points stand at the orders of the crank, as periodic motion has no others."
    return panel_of("spectrum", plots=(plot,), at_orders=orders * at_orders)


def _over_turn(
    name: str,
    title: str,
    picture: Callable[[xr.Dataset], Picture],
    shown: list[tuple[Choice, xr.Dataset]],
) -> Plot:
    """A picture of every run by every engine, over the last turn."""
    turned = joined([(when, picture(data)) for when, data in shown])
    return plotted(name, replace(turned, over="angle", x_label="Crank angle (deg)"), title)


def _when(run: Response, engine: str, unit: str) -> Choice:
    speed = speed_name(float(run.dataset.attrs["crank_speed"]), unit)
    return {"engine": engine, "state": state_of(run.dataset.attrs), "speed": speed}


def _sizes(force: xr.DataArray) -> FloatArray:
    return np.asarray(np.hypot(force.sel(component="x").values, force.sel(component="y").values))


def _readings(run: Response, own: xr.Dataset, when: Choice, links: list[str]) -> list[Reading]:
    """Deflections, joint forces and torque with their errors, which are parts of the peaks."""
    errors, angle = run.errors().sel(engine=own["engine"].item()), own["time"].values
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
    return [
        Reading(group, label, unit, angle, values, error, when, decimals_of(error))
        for group, label, unit, values, error in found
    ]


def motor_panel(results: Results) -> Panel | None:
    """Crank speed, and torque, power and current of the motor, of every result under a motor."""
    found = [
        result
        for result in (*results.of_kind(Kinematics), *results.of_kind(Response))
        if "motor_torque" in result.dataset
    ]
    if not found:
        return None
    said = [result.said for result in found]
    return panel_of(
        "motor",
        answer=tuple(dict.fromkeys(one.answer[0] for one in said)),
        plots=tuple(
            plotted(
                f"motor-{number}" if number > 1 else "motor",
                plots.plot_motor.picture(result.dataset),
                str(result.dataset.attrs.get("drive", "")),
            )
            for number, result in enumerate(found, 1)
        ),
        lines=tuple(line for one in said for line in further_lines(one) if "motor" in line),
    )


def residual_panel(results: Results) -> Panel | None:
    """What rings after the stop in every run that rests, and the shaped run beside it."""
    runs = [run for run in results.of_kind(Response) if "residual_envelope" in run.dataset]
    if not runs:
        return None
    shown = []
    for number, run in enumerate(runs, 1):
        place, law = f"-{number}" if number > 1 else "", str(run.dataset.attrs.get("drive", ""))
        shown.append(plotted(f"residual{place}", plots.plot_residual.picture(run.dataset), law))
        if "shaped_deflection" in run.dataset:
            shown.append(plotted(f"shaped{place}", plots.plot_shaped.picture(run.dataset), law))
    answer = tuple(line for run in runs for line in run.said.answer if "After the stop" in line)
    shapers = {str(run.dataset.attrs.get("shaper", "")) for run in runs} - {""}
    shaped = ""
    if shapers:
        shaped = f" Below: the whole move, and that with the {' or '.join(sorted(shapers))}."
    return panel_of("residual", answer=answer, plots=tuple(shown), shaped=shaped)
