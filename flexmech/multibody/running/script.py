"""A running mechanism as a Python script that needs exudyn and numpy alone.

The script adds the items that the program's own system was made of, from the same list; items
of one type that follow each other stand in a table.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import groupby
from textwrap import wrap

from flexmech.arrays import FloatArray
from flexmech.errors import one_line
from flexmech.linkages import Drive
from flexmech.mechanism import Provenance
from flexmech.multibody.items import Item, Setting
from flexmech.multibody.running.closure import ClosedJoints, JointsClosedInTurn
from flexmech.multibody.running.script_text import (
    SHARED,
    WIDTH,
    Brackets,
    Expression,
    call,
    columns,
    expression,
    pair,
    quoted,
    statement,
)

# Coordinates of each kind of node.
_COORDINATES = {"NodePoint2DSlope1": 4, "NodeRigidBody2D": 3, "NodePointGround": 0}


HEAD = '''"""{}
"""

from __future__ import annotations

import argparse
import bisect
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

# Exudyn without range checks: as flexmech runs it, to the last digit.
os.environ["EXUDYN_MODULE"] = "fast"

import exudyn as exu
import exudyn.itemInterface as eii'''

SYSTEM = """
container = exu.SystemContainer()
mbs = container.AddSystem()
nodes, objects, markers, loads, sensors = {}, {}, {}, {}, {}"""

START = """for name, (coordinates, velocities) in start.items():
    mbs.SetNodeParameter(nodes[name], "initialCoordinates", coordinates)
    mbs.SetNodeParameter(nodes[name], "initialVelocities", velocities)
mbs.Assemble()"""

SOLVE = """
# Solve, and show it if --view is given.
parser = argparse.ArgumentParser()
parser.add_argument("--view", action="store_true", help="show it while it runs")
view = parser.parse_args().view
if view:
    container.renderer.Start()
if not mbs.SolveDynamic(settings):
    raise SystemExit("the simulation did not reach its end")
if view:
    container.renderer.DoIdleTasks()
    container.renderer.Stop()"""

PRINT = """time = mbs.GetSensorStoredData(sensors["driving_torque"])[::STRIDE, 0]
angle = np.degrees([shaft.angle(t) for t in time])
table = {"time_s": time, "crank_angle_deg": angle}
for name, sensor, component in columns:
    history = mbs.GetSensorStoredData(sensors[sensor])
    table[name] = history[::STRIDE, 1 + component]
np.savetxt(
    Path(__file__).with_suffix(".csv"),
    np.column_stack(list(table.values())),
    fmt="%.12g",
    delimiter=",",
    header=",".join(table),
    comments="",
)
for name, history in table.items():
    if name.endswith("deflection_m"):
        peak = np.argmax(np.abs(history))
        print(
            f"{name.removesuffix('_m')}: at most {1e3 * abs(history[peak]):.8g} mm, "
            f"at {time[peak]:.6g} s, crank angle {angle[peak]:.6g} deg"
        )"""


@dataclass(frozen=True)
class ScriptSource:
    """Data from which a script is written.

    Parameters
    ----------
    provenance : Provenance
        Of the mechanism.
    drive : Drive
    items : sequence of Item
    joints : JointsClosedInTurn or ClosedJoints
    drifts : bool
        Whether these need to be put in place after every step.
    coordinates, rates : ndarray, shape (n,)
        Exudyn's at time zero, node by node.
    settings : mapping of str to Setting
    step : float
        In s.
    stride : int
        Steps from one written sample to the next.
    """

    provenance: Provenance
    drive: Drive
    items: Sequence[Item]
    joints: JointsClosedInTurn | ClosedJoints
    drifts: bool
    coordinates: FloatArray
    rates: FloatArray
    settings: Mapping[str, Setting]
    step: float
    stride: int


def linkage_script(source: ScriptSource) -> str:
    """Write the script.

    Parameters
    ----------
    source : ScriptSource

    Returns
    -------
    str
    """
    body = "\n".join(_body(source))
    needed: list[str] = []
    for each in reversed(SHARED):
        if each.__name__ in "\n".join([body, *needed]):
            needed.insert(0, inspect.getsource(each).rstrip())
    return "\n\n\n".join([_head(source), *needed, body]) + "\n"


def _head(source: ScriptSource) -> str:
    """Docstring and imports."""
    provenance = source.provenance
    origin = f" from {provenance.file} (SHA-256 {provenance.sha256})" if provenance.file else ""
    texts = [
        f"{provenance.name}, running at {source.drive.words}, as an Exudyn model.",
        f"Written by flexmech{origin}. All numbers are in SI units, angles in rad. It prints the "
        "greatest deflection of every link and writes the histories beside itself, as a CSV "
        "file; with --view it shows the linkage while it runs.",
    ]
    safe = (one_line(text, most=len(text)).replace("\\", "/").replace('"', "'") for text in texts)
    return HEAD.format("\n\n".join("\n".join(wrap(text, WIDTH - 3)) for text in safe))


def _body(source: ScriptSource) -> Iterator[str]:
    """Lines of the program itself."""
    joints = source.joints
    yield "# Parameters: how the shaft turns, the time step, and steps between written samples."
    yield from statement("shaft = ", expression(joints.shaft))
    steps = source.settings["timeIntegration.numberOfSteps"]
    yield from (f"STEP = {source.step!r}  # s", f"STEPS = {steps}", f"STRIDE = {source.stride}")
    yield SYSTEM
    for subject, items in groupby(source.items, key=lambda item: item.subject):
        yield f"\n# {subject[:1].upper()}{subject[1:]}."
        for _, alike in groupby(items, key=lambda item: (item.type, tuple(item.values))):
            yield from _added(list(alike))
    yield "\n# Displacement from the undeformed links along x, and velocity, at time zero."
    yield from statement("start = ", Brackets("{", tuple(_start(source)), "}"))
    yield START
    if source.drifts:
        yield "\n# What constraints on velocities leave to drift."
        fixed = {"shaft": "shaft"}
        given = (
            pair(f.name, fixed.get(f.name, expression(getattr(joints, f.name))))
            for f in fields(joints)
        )
        yield from statement("joints = ", call(type(joints).__name__, *given))
        yield "mbs.SetPostStepUserFunction(joints.after_step)"
    yield "\n# Settings."
    yield "settings = exu.SimulationSettings()"
    named = {
        "timeIntegration.numberOfSteps": "STEPS",
        "timeIntegration.endTime": "STEPS * STEP",
        "solution.sensors.writePeriod": "STEP",
    }
    for path, value in source.settings.items():
        yield from statement(f"settings.{path} = ", named.get(path, expression(value)))
    yield SOLVE
    yield "\n# Histories: column, sensor, component. Forces hold all frequencies, unfiltered."
    rows = tuple(expression(column) for column in _columns(source.items))
    yield from statement("columns = ", Brackets("[", rows, "]"))
    yield PRINT


def _added(items: Sequence[Item]) -> Iterator[str]:
    """Statements that add items of one type; what differs between several in a table."""
    first = items[0]
    values = [{key: expression(value) for key, value in item.values.items()} for item in items]
    if len(items) == 1:
        yield from _one(first, quoted(first.name), values[0])
        return
    varied = [key for key in first.values if any(v[key] != values[0][key] for v in values)]
    rows = [
        [quoted(item.name), *(own[key] for key in varied)]
        for item, own in zip(items, values, strict=True)
    ]
    table = Brackets("[", columns(rows), "]")
    yield from statement(f"for {', '.join(['name', *varied])} in ", table, ":")
    shared = values[0] | {key: key for key in varied}
    yield from _one(first, "name", shared, depth=1)


def _one(item: Item, name: str, values: Mapping[str, Expression], depth: int = 0) -> Iterator[str]:
    given = (pair(key, value) for key, value in values.items())
    made = call(f"eii.{item.type}", pair("name", name), *given)
    added = call(f"mbs.Add{item.kind.capitalize()}", made)
    yield from statement(f"{item.kind}s[{name}] = ", added, depth=depth)


def _start(source: ScriptSource) -> Iterator[Expression]:
    """Entry of each node: its coordinates and velocities."""
    first = 0
    for item in source.items:
        count = _COORDINATES.get(item.type, 0) if item.kind == "node" else 0
        if count:
            own = slice(first, first + count)
            both = (expression(source.coordinates[own]), expression(source.rates[own]))
            yield Brackets("(", both, ")", f"{quoted(item.name)}: ")
            first += count


def _columns(items: Sequence[Item]) -> Iterator[tuple[str, str, int]]:
    """Column of a table, and the sensor and component that it holds."""
    for item in items:
        name = item.name
        if name == "frame_place":
            yield from (("frame_x_m", name, 0), ("frame_y_m", name, 1))
        elif name == "frame_rotation":
            yield "frame_rotation_rad", name, 2
        if item.type != "SensorUserFunction":
            continue
        if name.endswith("_deflection"):
            is_tip = item.values["sensorUserFunction"].__name__ == "tip_deflection"
            link, place = name.removesuffix("_deflection"), "tip" if is_tip else "mid"
            yield f"{link}_{place}_deflection_m", name, 0
        elif name.endswith("_force"):
            yield f"{name.removesuffix('_force')}_x_N", name, 0
            yield f"{name.removesuffix('_force')}_y_N", name, 1
        else:
            yield f"{name}_Nm", name, 0
