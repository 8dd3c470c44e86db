"""A running mechanism as an Exudyn system for the user, with sensors, and as a script.

Sensors of a running Exudyn system: deflections, forces of the joints, driving torque.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.files import given_path, moved_into
from flexmech.mechanics.running import LinkState
from flexmech.model_text import short_repr
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import Choice, Item, ItemKind, ItemNumber, SystemItems, applied
from flexmech.multibody.joints import SliderJoint
from flexmech.multibody.links import BeamPart
from flexmech.multibody.running.model import RunningModel
from flexmech.multibody.running.script import linkage_script
from flexmech.multibody.running.simulation import Simulation
from flexmech.multibody.running.user_functions import (
    constraint_force,
    guide_line_force,
    middle_deflection,
)

# Kept in memory, at every step.
_KEPT = {"writeToFile": False, "storeInternal": True}


def add_sensors(model: RunningModel) -> None:
    """Add a deflection of every link, a force of every joint and the driving torque.

    They are named as ``coupler_deflection``, ``pin_A_force`` and ``driving_torque``. A
    deflection is that of the middle off the line between the link's ends, or of a clamped
    link's tip off the tangent at its clamp; a force acts on the held or following link, in
    ground axes. A frame on springs has ``frame_place`` and ``frame_rotation``.

    Parameters
    ----------
    model : RunningModel
    """
    items, topology = model.assembly.items, model.assembly.topology
    turning = []
    if model.frame is not None:
        items.begin("sensors of the frame on springs")
        node = model.frame.node
        _add(items, "SensorNode", "frame_place", "Displacement", nodeNumber=node)
        turning = [_add(items, "SensorNode", "frame_rotation", "Rotation", nodeNumber=node)]
    for _, part in model.assembly.beams:
        items.begin(f"{part.name}: sensors of its deflection")
        _add_deflection(model, part, turning)
    items.begin("sensors of forces and torque")
    for joint, kind in zip(topology.joint_names, topology.joint_kinds, strict=True):
        name = f"{kind}_{joint}_force"
        if joint in model.sprung:
            _add(items, "SensorObject", name, "Force", objectNumber=model.sprung[joint])
        elif joint in model.sliders:
            _add_line_force(model.assembly, name, model.sliders[joint], turning)
        else:
            _compute(items, name, constraint_force, factors=model.constraints[joint])
    if model.drive_constraint is not None:
        _compute(items, "driving_torque", constraint_force, factors=[model.drive_constraint])


def _add(items: SystemItems, type_: str, name: str, output: str, **values: Any) -> ItemNumber:
    """Sensor of an output variable."""
    variable = Choice("OutputVariableType", output)
    return items.add(type_, name, **values, outputVariableType=variable, **_KEPT)


def _compute(items: SystemItems, name: str, function: Callable[..., Any], **given: Any) -> None:
    """Sensor of what a function makes of other sensors and of numbers."""
    items.add("SensorUserFunction", name, **given, sensorUserFunction=function, **_KEPT)


def _add_deflection(model: RunningModel, part: BeamPart, turning: list[ItemNumber]) -> None:
    """Sensor of the middle of a link, or of a clamped one's tip, and of the places it needs."""
    assembly, known, near = model.assembly, dict[float, ItemNumber](), SAME_PLACE * part.length

    def at(x: float) -> ItemNumber:
        if x not in known:
            number = int(np.abs(part.positions - x).argmin())
            at_node = abs(part.positions[number] - x) <= near
            name = f"{part.name}_place_{number}" if at_node else f"{part.name}_middle"
            body, *place = assembly.body_place(part, x)
            given = {"bodyNumber": body, "localPosition": [*place, 0.0]}
            known[x] = _add(assembly.items, "SensorBody", name, "Position", **given)
        return known[x]

    name, ends = f"{part.name}_deflection", (0.0, part.length)
    if any(clamp.link_end.link == part.name for clamp in assembly.topology.clamps):
        places = [*(at(x) for x in ends), *turning]
        _compute(assembly.items, name, model.shaft.tip_deflection, sensorNumbers=places)
        return
    middle = part.length / 2
    around, fraction = [middle, middle], 0.0
    behind = int(np.searchsorted(part.positions, middle - near))
    if part.kind.has_angles and part.positions[behind] > middle + near:
        # Between its nodes an exact beam is straight, and so is the pins' axis.
        around = part.positions[behind - 1 : behind + 1].tolist()
        fraction = (middle - around[0]) / (around[1] - around[0])
    places = [at(x) for x in (ends[0], *around, ends[1])]
    given = {"sensorNumbers": places, "factors": [fraction]}
    _compute(assembly.items, name, middle_deflection, **given)


def _add_line_force(
    assembly: LinkAssembly, name: str, line: SliderJoint, turning: list[ItemNumber]
) -> None:
    """Force of a line on the end that slides on it; a line on the ground turns with a frame."""
    items = assembly.items
    if line.slider.guide:
        [node] = assembly.parts[assembly.topology.index(line.slider.guide)].nodes
        turning = [_add(items, "SensorNode", f"{name}_guide", "Rotation", nodeNumber=node)]
    factors = [line.constraint, line.slider.direction + math.pi / 2]
    _compute(items, name, guide_line_force, sensorNumbers=turning, factors=factors)


SCRIPT = "linkage.py"


@dataclass(frozen=True, eq=False, repr=False)
class ExudynSystem:
    """The assembled Exudyn system of a running mechanism, with named items and sensors.

    :func:`flexmech.exudyn_system` returns it. It stands at time zero with the velocities of its
    start, and is solved by the settings with which flexmech itself runs it.

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
        Choices that the model leaves open.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> request = flexmech.analyses.ResponseRequest(20.0, 0.01, step=1e-4)
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
    def of(cls, simulation: Simulation, start: LinkState, stride: int) -> ExudynSystem:
        """System of a simulation's model, with sensors added.

        Parameters
        ----------
        simulation : Simulation
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
        return cls(
            items.container,
            items.mbs,
            applied(settings),
            tuple(items.listed),
            float(simulation.step),
            simulation.steps,
            linkage_script(simulation, coordinates, rates, settings, stride),
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
