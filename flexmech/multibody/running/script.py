"""A running mechanism as a Python script that needs exudyn and numpy alone.

The script adds the items that the program's own system was made of, from the same list; items
of one type that follow each other stand in a table.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from inspect import getmodule, getsource
from itertools import groupby
from textwrap import wrap
from types import MethodType
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import one_line
from flexmech.linkages import Drive
from flexmech.mechanism import Provenance
from flexmech.multibody.items import Choice, Item, ItemNumber, Made, Setting
from flexmech.multibody.running import user_functions
from flexmech.multibody.running.simulation import Simulation

# All that a script may hold, in the order in which they need each other.
SHARED = [item for item in vars(user_functions).values() if getmodule(item) is user_functions]


# Columns of a script, as the usual formatter of Python leaves it.
WIDTH = 88
INDENT = "    "


@dataclass(frozen=True)
class Brackets:
    """Expressions between brackets, such as a list or the arguments of a call.

    Parameters
    ----------
    opening, closing : str
    parts : tuple of Expression
    prefix : str
        Before the opening bracket, such as ``"name="``.
    """

    opening: str
    parts: tuple[Expression, ...]
    closing: str
    prefix: str = ""

    @property
    def line(self) -> str:
        """All of it in one line."""
        inside = ", ".join(_line(entry) for entry in self.parts)
        comma = "," if self.opening == "(" and self.closing == ")" and self._is_single else ""
        return f"{self.prefix}{self.opening}{inside}{comma}{self.closing}"

    @property
    def _is_single(self) -> bool:
        return len(self.parts) == 1


Expression = str | Brackets


def _line(expression: Expression) -> str:
    return expression if isinstance(expression, str) else expression.line


def statement(lead: str, value: Expression, end: str = "", depth: int = 0) -> list[str]:
    """Lines of a statement: a lead such as ``"x = "``, an expression and what ends it.

    Parameters
    ----------
    lead : str
    value : Expression
    end : str
    depth : int
        How far it is indented.

    Returns
    -------
    list of str
    """
    whole = f"{INDENT * depth}{lead}{_line(value)}{end}"
    if len(whole) <= WIDTH or isinstance(value, str) or not value.parts:
        return [whole]
    lines = [f"{INDENT * depth}{lead}{value.prefix}{value.opening}"]
    for entry in value.parts:
        lines += statement("", entry, ",", depth + 1)
    return [*lines, f"{INDENT * depth}{value.closing}{end}"]


def call(function: str, *arguments: Expression) -> Brackets:
    """Call of a function."""
    return Brackets(f"{function}(", arguments, ")")


def pair(key: str, value: Expression) -> Expression:
    """Keyword argument."""
    if isinstance(value, str):
        return f"{key}={value}"
    return Brackets(value.opening, value.parts, value.closing, f"{key}={value.prefix}")


def expression(value: Any) -> Expression:
    """A value of an item as an expression; numbers of items by their names.

    Parameters
    ----------
    value : object
        Number, text, array, list, one of the values of :mod:`flexmech.multibody.items`, method
        or function that a script holds, or record whose class it holds.

    Returns
    -------
    Expression
    """
    if isinstance(value, Made):
        return call(value.function.__name__, *map(expression, value.arguments))
    if isinstance(value, ItemNumber):
        return f"{value.kind}s[{quoted(value.name)}]"
    if isinstance(value, Choice):
        return f"exu.{value.enumeration}.{value.name}"
    if isinstance(value, MethodType):
        return f"{type(value.__self__).__name__.lower()}.{value.__name__}"
    if isinstance(value, np.generic):
        return expression(value.item())
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, list):
        return Brackets("[", tuple(map(expression, value)), "]")
    if isinstance(value, tuple):
        return Brackets("(", tuple(map(expression, value)), ")")
    if is_dataclass(value):
        given = (pair(f.name, expression(getattr(value, f.name))) for f in fields(value))
        return call(type(value).__name__, *given)
    if callable(value):
        return str(value.__name__)
    return quoted(value) if isinstance(value, str) else repr(value)


def _array(value: np.ndarray) -> Expression:
    """Vectors as lists; matrices as arrays, by their diagonal where that is all."""
    if value.ndim == 1:
        return expression(value.tolist())
    diagonal = np.diag(value)
    if np.array_equal(value, np.diag(diagonal)):
        return call("np.diag", expression(diagonal.tolist()))
    return call("np.array", expression(value.tolist()))


def quoted(text: str) -> str:
    """Text in quotes: double ones, unless that needs more of them to be escaped."""
    return repr(text) if '"' in text else json.dumps(text, ensure_ascii=False)


def columns(rows: Sequence[Sequence[Expression]]) -> tuple[Expression, ...]:
    """Rows of a table as tuples; those of one column as they are."""
    return tuple(row[0] if len(row) == 1 else Brackets("(", tuple(row), ")") for row in rows)


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


def linkage_script(
    simulation: Simulation,
    coordinates: FloatArray,
    rates: FloatArray,
    settings: Mapping[str, Setting],
    stride: int,
) -> str:
    """Write the script.

    Parameters
    ----------
    simulation : Simulation
    coordinates, rates : ndarray, shape (n,)
        Exudyn's at time zero, node by node.
    settings : mapping of str to Setting
    stride : int
        Steps from one written sample to the next.

    Returns
    -------
    str
    """
    model = simulation.model
    start = _start(model.assembly.items.listed, coordinates, rates)
    body = "\n".join(_body(simulation, start, settings, stride))
    needed: list[str] = []
    for shared in reversed(SHARED):
        if shared.__name__ in "\n".join([body, *needed]):
            needed.insert(0, getsource(shared).rstrip())
    head = _head(model.assembly.mechanism.provenance, model.drive)
    return "\n\n\n".join([head, *needed, body]) + "\n"


def _head(provenance: Provenance, drive: Drive) -> str:
    """Docstring and imports."""
    origin = f" from {provenance.file} (SHA-256 {provenance.sha256})" if provenance.file else ""
    texts = [
        f"{provenance.name}, running at {drive.words}, as an Exudyn model.",
        f"Written by flexmech{origin}. All numbers are in SI units, angles in rad. It prints the "
        "greatest deflection of every link and writes the histories beside itself, as a CSV "
        "file; with --view it shows the linkage while it runs.",
    ]
    safe = (one_line(text, most=len(text)).replace("\\", "/").replace('"', "'") for text in texts)
    return HEAD.format("\n\n".join("\n".join(wrap(text, WIDTH - 3)) for text in safe))


def _body(
    simulation: Simulation,
    start: Iterable[Expression],
    settings: Mapping[str, Setting],
    stride: int,
) -> Iterator[str]:
    """Lines of the program itself."""
    joints, listed = simulation.model.joints, simulation.model.assembly.items.listed
    yield "# Parameters: how the shaft turns, the time step, and steps between written samples."
    yield from statement("shaft = ", expression(joints.shaft))
    step, steps = float(simulation.step), settings["timeIntegration.numberOfSteps"]
    yield from (f"STEP = {step!r}  # s", f"STEPS = {steps}", f"STRIDE = {stride}")
    yield SYSTEM
    for subject, items in groupby(listed, key=lambda item: item.subject):
        yield f"\n# {subject[:1].upper()}{subject[1:]}."
        for _, alike in groupby(items, key=lambda item: (item.type, tuple(item.values))):
            yield from _added(list(alike))
    yield "\n# Displacement from the undeformed links along x, and velocity, at time zero."
    yield from statement("start = ", Brackets("{", tuple(start), "}"))
    yield START
    if simulation.drifts:
        yield "\n# What constraints on velocities leave to drift."
        fixed = {"shaft": "shaft"}
        given = (
            pair(f.name, fixed.get(f.name, expression(getattr(joints, f.name))))
            for f in fields(joints)
        )
        yield from statement("joints = ", call("ClosedJoints", *given))
        yield "mbs.SetPostStepUserFunction(joints.after_step)"
    yield "\n# Settings."
    yield "settings = exu.SimulationSettings()"
    named = {
        "timeIntegration.numberOfSteps": "STEPS",
        "timeIntegration.endTime": "STEPS * STEP",
        "solution.sensors.writePeriod": "STEP",
    }
    for path, value in settings.items():
        yield from statement(f"settings.{path} = ", named.get(path, expression(value)))
    yield SOLVE
    yield "\n# Histories: column, sensor, component. Forces hold all frequencies, unfiltered."
    rows = tuple(expression(column) for column in _columns(listed))
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
        [quoted(item.name), *(given[key] for key in varied)]
        for item, given in zip(items, values, strict=True)
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


def _start(
    items: Sequence[Item], coordinates: FloatArray, rates: FloatArray
) -> Iterator[Expression]:
    """Entry of each node: its coordinates and velocities."""
    first = 0
    for item in items:
        if count := _COORDINATES.get(item.type, 0):
            node = slice(first, first + count)
            both = expression(coordinates[node]), expression(rates[node])
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
