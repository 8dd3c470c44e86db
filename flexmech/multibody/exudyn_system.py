"""A running mechanism as an Exudyn system for the user, with sensors, and as a script.

Sensors of a running Exudyn system: deflections, forces of the joints, driving torque.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.files import given_path, moved_into
from flexmech.linkages import Drive, Link
from flexmech.model_text import short_repr
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import Choice, Item, ItemKind, ItemNumber, SystemItems, applied
from flexmech.multibody.joints import SliderJoint
from flexmech.multibody.link_parts import BeamPart, RigidPart
from flexmech.multibody.running.model import RunningModel
from flexmech.multibody.running.script import ScriptSource, linkage_script
from flexmech.multibody.running.simulation import Simulation
from flexmech.multibody.running.user_functions import (
    constraint_force,
    guide_line_force,
    middle_deflection,
)
from flexmech.time_domain import LinkState

# Kept in memory, at every step.
_KEPT = {"writeToFile": False, "storeInternal": True}


def add_sensors(model: RunningModel) -> None:
    """Add a deflection of every link, a force of every joint and the driving torque.

    They are named as ``coupler_deflection``, ``pin_A_force`` and ``driving_torque``. A
    deflection is that of the middle off the line between the link's ends, or of a clamped
    link's tip off the tangent at its clamp; a force acts on the held or following link, in
    ground axes. Of a frame on springs there are ``frame_place`` and ``frame_rotation``.

    Parameters
    ----------
    model : RunningModel
    """
    assembly, items, topology = model.assembly, model.assembly.items, model.assembly.topology
    clamped = {clamp.link_end.link for clamp in topology.clamps}
    turning = []
    if model.frame is not None:
        items.begin("sensors of the frame on springs")
        node = model.frame.node
        _add(items, "SensorNode", "frame_place", "Displacement", nodeNumber=node)
        turning = [_add(items, "SensorNode", "frame_rotation", "Rotation", nodeNumber=node)]
    for link, part in zip(topology.links, assembly.parts, strict=True):
        if isinstance(part, RigidPart):
            continue
        points = _LinkPoints(assembly, part, link)
        items.begin(f"{link.name}: sensors of its deflection")
        around: list[ItemNumber] = []
        beyond = turning
        given: dict[str, Any] = {"sensorUserFunction": model.shaft.tip_deflection}
        if link.name not in clamped:
            (around, fraction), beyond = points.around_middle(), []
            given = {"factors": [fraction], "sensorUserFunction": middle_deflection}
        ends = points.at_node(0), points.at_node(len(part.nodes) - 1)
        numbers = [ends[0], *around, ends[1], *beyond]
        name = f"{link.name}_deflection"
        items.add("SensorUserFunction", name, sensorNumbers=numbers, **given, **_KEPT)
    items.begin("sensors of forces and torque")
    kinds = dict(zip(topology.joint_names, topology.joint_kinds, strict=True))
    for joint in topology.joint_names:
        name = f"{kinds[joint]}_{joint}_force"
        if joint in model.sprung:
            _add(items, "SensorObject", name, "Force", objectNumber=model.sprung[joint])
        elif joint in model.sliders:
            _add_line_force(assembly, name, model.sliders[joint], turning)
        else:
            _add_force(items, name, model.constraints[joint])
    if model.drive_constraint is not None:
        _add_force(items, "driving_torque", [model.drive_constraint])


def _add(items: SystemItems, type_: str, name: str, output: str, **values: Any) -> ItemNumber:
    """Sensor of an output variable."""
    variable = Choice("OutputVariableType", output)
    return items.add(type_, name, **values, outputVariableType=variable, **_KEPT)


class _LinkPoints:
    """Position sensors of points on the pins' axis of a link."""

    def __init__(self, assembly: LinkAssembly, part: BeamPart, link: Link) -> None:
        self._items = assembly.items
        self._is_curved = assembly.kind.carries_mass
        self._part = part
        self._link = link
        self._at_node: dict[int, ItemNumber] = {}

    def at_node(self, number: int) -> ItemNumber:
        """Point on the axis at a node."""
        if number not in self._at_node:
            self._at_node[number] = self._added(number)
        return self._at_node[number]

    def around_middle(self) -> tuple[list[ItemNumber], float]:
        """Points before and behind the middle, and how far from the one to the other it is."""
        positions, middle = self._part.positions, self._link.length / 2
        nearest = int(np.argmin(np.abs(positions - middle)))
        if math.isclose(positions[nearest], middle, abs_tol=SAME_PLACE * self._link.length):
            return [self.at_node(nearest)] * 2, 0.0
        before = int(np.searchsorted(positions, middle)) - 1
        x = float(middle - positions[before])
        if self._is_curved:
            name, body = f"{self._link.name}_middle", self._part.elements[before]
            inside = self._of_body(name, body, x, 0.0)
            return [inside, inside], 0.0
        # Between its nodes an exact beam is straight, and so is the pins' axis.
        around = [self.at_node(before), self.at_node(before + 1)]
        return around, x / float(positions[before + 1] - positions[before])

    def _added(self, number: int) -> ItemNumber:
        name, part = f"{self._link.name}_place_{number}", self._part
        if part.arms is None:
            number = part.nodes[number]
            return _add(self._items, "SensorNode", name, "Position", nodeNumber=number)
        assert part.bodies is not None
        return self._of_body(name, part.bodies.numbers[number], 0.0, -part.arms.length)

    def _of_body(self, name: str, body: ItemNumber, x: float, y: float) -> ItemNumber:
        where = {"bodyNumber": body, "localPosition": [x, y, 0.0]}
        return _add(self._items, "SensorBody", name, "Position", **where)


def _add_force(items: SystemItems, name: str, constraints: list[ItemNumber]) -> None:
    items.add(
        "SensorUserFunction",
        name,
        factors=list(constraints),
        sensorUserFunction=constraint_force,
        **_KEPT,
    )


def _add_line_force(
    assembly: LinkAssembly, name: str, line: SliderJoint, turning: list[ItemNumber]
) -> None:
    """Force of a line on the end that slides on it; a line on the ground turns with a frame."""
    if line.slider.guide:
        guide = assembly.parts[assembly.topology.index(line.slider.guide)]
        node = guide.nodes[0]
        turning = [_add(assembly.items, "SensorNode", f"{name}_guide", "Rotation", nodeNumber=node)]
    assembly.items.add(
        "SensorUserFunction",
        name,
        sensorNumbers=turning,
        factors=[line.constraint, line.slider.direction + math.pi / 2],
        sensorUserFunction=guide_line_force,
        **_KEPT,
    )


SCRIPT = "linkage.py"


@dataclass(frozen=True, eq=False, repr=False)
class ExudynSystem:
    """The assembled Exudyn system of a running mechanism, with named items and sensors.

    Of :func:`flexmech.exudyn_system`. It stands at time zero with the velocities of its start,
    and is solved by the settings with which flexmech itself runs it.

    Parameters
    ----------
    container : exudyn.SystemContainer
        For the viewer: ``container.renderer.Start()``.
    mbs : exudyn.MainSystem
    settings : exudyn.SimulationSettings
    items : tuple of Item
        Nodes, objects (elements, bodies, joints), markers, loads and sensors as they were
        added: each with its ``kind``, ``type``, ``name``, ``number`` and ``values``.
    step : float
        Time step in s.
    steps : int
    script : str
        A Python script that makes the same system, solves it and prints deflections; it
        needs exudyn and numpy alone.
    remarks : tuple of str
        What was chosen for it that the model leaves open.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> request = flexmech.ResponseRequest(20.0, 0.01, step=1e-4)
    >>> system = flexmech.exudyn_system(flexmech.ExudynEngine(mechanism, 2), request)
    >>> system.mbs.SolveDynamic(system.settings)
    True
    >>> list(system.sensors)[-3:]
    ['pin_B_force', 'pivot_O4_force', 'driving_torque']
    >>> system.history("coupler_deflection").shape
    (32, 2)
    """

    container: Any
    mbs: Any
    settings: Any
    items: tuple[Item, ...]
    step: float
    steps: int
    script: str
    remarks: tuple[str, ...] = ()

    @classmethod
    def of(
        cls, simulation: Simulation, drive: Drive, start: LinkState, stride: int
    ) -> ExudynSystem:
        """System of a simulation's model, with sensors added.

        Parameters
        ----------
        simulation : Simulation
        drive : Drive
        start : LinkState
        stride : int

        Returns
        -------
        ExudynSystem
        """
        model = simulation.model
        items = model.assembly.items
        add_sensors(model)
        items.mbs.Assemble()
        coordinates, rates = simulation.set_start(start)
        if simulation.drifts:
            items.mbs.SetPostStepUserFunction(model.joints.after_step)
        settings = simulation.settings() | {
            "solution.sensors.active": True,
            "solution.sensors.writePeriod": float(simulation.step),
        }
        script = linkage_script(
            ScriptSource(
                provenance=model.assembly.mechanism.provenance,
                drive=drive,
                items=items.listed,
                joints=model.joints,
                drifts=simulation.drifts,
                coordinates=coordinates,
                rates=rates,
                settings=settings,
                step=float(simulation.step),
                stride=stride,
            )
        )
        return cls(
            items.container,
            items.mbs,
            applied(settings),
            tuple(items.listed),
            float(simulation.step),
            simulation.steps,
            script,
        )

    @property
    def nodes(self) -> dict[str, int]:
        """Exudyn's number of every node, such as ``coupler_node_0``, by its name."""
        return self._numbers("node")

    @property
    def objects(self) -> dict[str, int]:
        """Number of every element, body, joint and constraint, such as ``crank_drive``."""
        return self._numbers("object")

    @property
    def markers(self) -> dict[str, int]:
        """Number of every marker, by its name."""
        return self._numbers("marker")

    @property
    def loads(self) -> dict[str, int]:
        """Number of every load, by its name."""
        return self._numbers("load")

    @property
    def sensors(self) -> dict[str, int]:
        """Number of every sensor, such as ``coupler_deflection``, by its name."""
        return self._numbers("sensor")

    def history(self, sensor: str) -> FloatArray:
        """History of a sensor, after the system is solved.

        Parameters
        ----------
        sensor : str
            Its name, such as ``"coupler_deflection"`` in m, ``"pin_A_force"`` in N or
            ``"driving_torque"`` in N m.

        Returns
        -------
        ndarray, shape (steps + 1, 1 + n)
            Time in s and the sensor's values, at every step.
        """
        return np.asarray(self.mbs.GetSensorStoredData(self.sensors[sensor]))

    def save(self, folder: str | Path) -> list[Path]:
        """Write the script as ``linkage.py``.

        Parameters
        ----------
        folder : str or Path
            Made if it is not there.

        Returns
        -------
        list of Path

        Raises
        ------
        InputError
            If the folder cannot be written to.
        """
        folder = given_path(folder)
        with moved_into(folder) as temporary:
            (temporary / SCRIPT).write_text(self.script, encoding="utf-8", newline="\n")
        return [folder / SCRIPT]

    def __repr__(self) -> str:
        counts = {"nodes": self.nodes, "objects": self.objects, "sensors": self.sensors}
        return short_repr(self, *(f"{len(named)} {kind}" for kind, named in counts.items()))

    def _numbers(self, kind: ItemKind) -> dict[str, int]:
        return {item.name: item.number for item in self.items if item.kind == kind}
