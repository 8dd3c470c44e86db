"""Sensors of a running Exudyn system: deflections, forces of the joints, driving torque."""

from __future__ import annotations

import math

import numpy as np

from flexmech.linkages import Link
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import Choice, ItemNumber, SystemItems
from flexmech.multibody.joints import SliderJoint
from flexmech.multibody.link_parts import BeamPart, RigidPart
from flexmech.multibody.running_model import RunningModel
from flexmech.multibody.user_functions import constraint_force, guide_line_force, middle_deflection

# Kept in memory, at every step.
_KEPT = {"writeToFile": False, "storeInternal": True}
_POSITION = Choice("OutputVariableType", "Position")
_FORCE = Choice("OutputVariableType", "Force")
_ROTATION = Choice("OutputVariableType", "Rotation")
# A node this near to the middle, over the length, is the middle.
_AT_NODE = 1e-9


def add_sensors(model: RunningModel) -> None:
    """Add a deflection of every link, a force of every joint and the driving torque.

    They are named as ``coupler_deflection``, ``pin_A_force`` and ``driving_torque``. A
    deflection is that of the middle off the line between the link's ends, or of a clamped
    link's tip off the tangent at its clamp; a force acts on the held or following link, in
    ground axes.

    Parameters
    ----------
    model : RunningModel
    """
    assembly, items, topology = model.assembly, model.assembly.items, model.assembly.topology
    clamped = {clamp.held.link for clamp in topology.clamps}
    for link, part in zip(topology.links, assembly.parts, strict=True):
        if isinstance(part, RigidPart):
            continue
        points = _LinkPoints(assembly, part, link)
        items.begin(f"{link.name}: sensors of its deflection")
        if link.name in clamped:
            items.add(
                "SensorUserFunction",
                f"{link.name}_deflection",
                sensorNumbers=[points.at_node(0), points.at_node(len(part.nodes) - 1)],
                sensorUserFunction=model.shaft.tip_deflection,
                **_KEPT,
            )
        else:
            around, fraction = points.around_middle()
            items.add(
                "SensorUserFunction",
                f"{link.name}_deflection",
                sensorNumbers=[points.at_node(0), *around, points.at_node(len(part.nodes) - 1)],
                factors=[fraction],
                sensorUserFunction=middle_deflection,
                **_KEPT,
            )
    items.begin("sensors of forces and torque")
    kinds = dict(zip(topology.joint_names, topology.joint_kinds, strict=True))
    for joint in topology.joint_names:
        name = f"{kinds[joint]}_{joint}_force"
        if joint in model.sprung:
            items.add(
                "SensorObject",
                name,
                objectNumber=model.sprung[joint],
                outputVariableType=_FORCE,
                **_KEPT,
            )
        elif joint in model.sliders:
            _add_line_force(assembly, name, model.sliders[joint])
        else:
            _add_force(items, name, model.constraints[joint])
    if model.drive_constraint is not None:
        _add_force(items, "driving_torque", [model.drive_constraint])


class _LinkPoints:
    """Sensors of where points on the pins' axis of a link are."""

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
        if math.isclose(positions[nearest], middle, abs_tol=_AT_NODE * self._link.length):
            return [self.at_node(nearest)] * 2, 0.0
        before = int(np.searchsorted(positions, middle)) - 1
        x = float(middle - positions[before])
        if self._is_curved:
            inside = self._items.add(
                "SensorBody",
                f"{self._link.name}_middle",
                bodyNumber=self._part.elements[before],
                localPosition=[x, 0.0, 0.0],
                outputVariableType=_POSITION,
                **_KEPT,
            )
            return [inside, inside], 0.0
        # Between its nodes an exact beam is straight, and so is the pins' axis.
        around = [self.at_node(before), self.at_node(before + 1)]
        return around, x / float(positions[before + 1] - positions[before])

    def _added(self, number: int) -> ItemNumber:
        name, part = f"{self._link.name}_place_{number}", self._part
        if part.arms is None:
            return self._items.add(
                "SensorNode",
                name,
                nodeNumber=part.nodes[number],
                outputVariableType=_POSITION,
                **_KEPT,
            )
        assert part.bodies is not None
        return self._items.add(
            "SensorBody",
            name,
            bodyNumber=part.bodies.numbers[number],
            localPosition=[0.0, -part.arms.length, 0.0],
            outputVariableType=_POSITION,
            **_KEPT,
        )


def _add_force(items: SystemItems, name: str, constraints: list[ItemNumber]) -> None:
    items.add(
        "SensorUserFunction",
        name,
        factors=list(constraints),
        sensorUserFunction=constraint_force,
        **_KEPT,
    )


def _add_line_force(assembly: LinkAssembly, name: str, line: SliderJoint) -> None:
    """Force of a line on the end that slides on it."""
    turning = []
    if line.slider.guide:
        guide = assembly.parts[assembly.topology.index(line.slider.guide)]
        turning = [
            assembly.items.add(
                "SensorNode",
                f"{name}_guide",
                nodeNumber=guide.nodes[0],
                outputVariableType=_ROTATION,
                **_KEPT,
            )
        ]
    assembly.items.add(
        "SensorUserFunction",
        name,
        sensorNumbers=turning,
        factors=[line.constraint, line.slider.direction + math.pi / 2],
        sensorUserFunction=guide_line_force,
        **_KEPT,
    )
