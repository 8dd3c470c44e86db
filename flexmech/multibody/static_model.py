"""Static Exudyn system of a mechanism: built once, moved through the crank angles.

The model is in the crank's frame: the shaft's clamp is then a constraint on single
coordinates with a constant constraint Jacobian, whatever the crank angle. What changes
from one position to the next are the coordinates, the angle of the ground and the loads.

A rigid link may rotate under dead loads on it. The effect of distributed dead loads is given by
their resultant, their moment and their virial about the link's start, the sum of force times place:
the resultant acts at the start, and a couple of forces at start and end has the moment and the
virial.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import Clamp, RigidMotion, picture_crank_angle, turned
from flexmech.linkages.motion import normal
from flexmech.mechanics import LAST_STEP, MAX_ITERATIONS
from flexmech.mechanism import Mechanism
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.connectors import StaticConnectors
from flexmech.multibody.items import ItemNumber, load_exudyn
from flexmech.multibody.joints import (
    add_pivots,
    add_sliders,
    add_ties,
    hold_axis,
)
from flexmech.multibody.links import BeamPart, LinkPart

RELATIVE_RESIDUAL = 1e-10
"""Part of the load that may be out of balance where Exudyn's static solver takes no small step.

Its second criterion, beside the round-off of the model. Convergence is quadratic: the last
iteration brings far more than that.
"""


@dataclass(frozen=True)
class TurningBody:
    """A rigid link, or a body at a node, on which dead loads have a moment.

    Parameters
    ----------
    link : int
    angle : int
        Its angle among the coordinates of all links.
    at_start, at_end : ItemNumber
        Loads as far apart as the ends of the link.
    """

    link: int
    angle: int
    at_start: ItemNumber
    at_end: ItemNumber


class StaticLoads:
    """Loads on every coordinate of the links, set anew for each position.

    Parameters
    ----------
    assembly : LinkAssembly
        Not assembled yet; the point masses of its cables are added along.

    Attributes
    ----------
    turning : list of TurningBody
    """

    def __init__(self, assembly: LinkAssembly) -> None:
        self._assembly = assembly
        self._at_points: list[tuple[ItemNumber, int]] = []
        mass = np.zeros((assembly.size, assembly.size))
        for link, part in assembly.beams:
            if not part.bodies:
                for at in (part.firsts, part.firsts + 1):
                    mass[at, at] = part.point_masses
            elif len(part.node_map.first):
                self._add_points(link, part)
        self._nodal = assembly.items.add(
            "ObjectGenericODE2",
            "loads",
            nodeNumbers=[node for part in assembly.parts for node in part.nodes],
            massMatrix=mass if mass.any() else None,
            forceVector=np.zeros(assembly.size),
        )
        self.turning = [
            self._add_couple(link, angle, body)
            for link, part in enumerate(assembly.parts)
            for angle, body in self._turning_bodies(link, part).items()
        ]

    def set(self, forces: FloatArray, couples: FloatArray) -> None:
        """Set the forces.

        Parameters
        ----------
        forces : ndarray, shape (size,)
            Generalized forces on the coordinates of all links, in the crank's frame. The moment
            on a rigid link is not read.
        couples : ndarray, shape (n_turning, 2)
            Force on each of :attr:`turning` at its end, with its opposite at the start, in the
            crank's frame.
        """
        mbs, at_nodes = self._assembly.mbs, forces.copy()
        for load, first in self._at_points:
            _set_load(mbs, load, at_nodes[first : first + 2])
            at_nodes[first : first + 2] = 0.0
        for body, couple in zip(self.turning, couples, strict=True):
            _set_load(mbs, body.at_start, -couple)
            _set_load(mbs, body.at_end, couple)
            if not isinstance(self._assembly.parts[body.link], BeamPart):
                at_nodes[body.angle] = 0.0
        mbs.SetObjectParameter(self._nodal, "forceVector", at_nodes)

    def _add_points(self, link: int, part: BeamPart) -> None:
        """Forces on points of the pins' axis, off the nodes of an eccentric link."""
        for number, coordinate in enumerate(part.firsts.tolist()):
            name = f"load_{link}_{number}"
            marker = self._assembly.add_axis_marker(part, part.positions[number], f"{name}_point")
            self._at_points.append((self._assembly.items.add_force(name, marker), coordinate))

    def _turning_bodies(self, link: int, part: LinkPart) -> dict[int, ItemNumber]:
        """Bodies of a link on which dead loads have moments, by their angle coordinate."""
        bodies: dict[int, ItemNumber] = {}
        if not isinstance(part, BeamPart) or (part.bodies and part.section.mass_axis):
            angles = (part.firsts + part.kind.clamped).tolist()
            bodies = dict(zip(angles, part.bodies, strict=True))
        attached = (body for body in self._assembly.attached if body.link == link)
        return bodies | {body.angle: body.body.number for body in attached}

    def _add_couple(self, link: int, angle: int, body: ItemNumber) -> TurningBody:
        """Forces at the node of a body and at a link's length from it along the link."""
        name, items = f"load_{link}_{angle}", self._assembly.items
        start, end = (
            items.add_force(f"{name}_at_{i}", items.mark_place(f"{name}_point_{i}", body, x))
            for i, x in enumerate((0.0, self._assembly.parts[link].length))
        )
        return TurningBody(link, angle, start, end)


def _set_load(mbs: Any, load: ItemNumber, force: FloatArray) -> None:
    mbs.SetLoadParameter(load, "loadVector", [float(force[0]), float(force[1]), 0.0])


class StaticModel:
    """Exudyn system of a mechanism with the crank fixed.

    Parameters
    ----------
    mechanism : Mechanism
    elements : int
        Elements a link.
    kind : str
        Key of :data:`flexmech.multibody.beams.BEAM_KINDS`.
    connects : bool
        Whether loads and springs are Exudyn's own items, and springs alone hold sprung joints.
        Otherwise their forces come with the loads on the links, and sprung joints are rigid.

    Attributes
    ----------
    assembly : LinkAssembly
        The links in the frame of the clamped one.
    loads : StaticLoads
        Forces on the links.
    connectors : StaticConnectors or None
        Loads and springs, in the current position of the model.
    ties : list of TieJoint
    """

    def __init__(
        self, mechanism: Mechanism, elements: int, kind: str, *, connects: bool = False
    ) -> None:
        self.assembly = assembly = LinkAssembly(mechanism, elements, kind, bodies_have_mass=False)
        self.loads = StaticLoads(assembly)
        motion = mechanism.linkage.motion(picture_crank_angle(mechanism.linkage))
        add_pivots(assembly, motion, sprung_alone=connects)
        # Constraints of clamps and their coordinates.
        self._offsets: list[tuple[ItemNumber, int]] = []
        for number, clamp in enumerate(assembly.topology.clamps):
            self._add_clamp(clamp, is_first=not number)
        self.connectors = StaticConnectors(assembly, motion) if connects else None
        self.ties = add_ties(assembly, motion.angle, sprung_alone=connects)
        add_sliders(assembly)
        self._add_further_clamps(motion.angle)
        assembly.mbs.Assemble()

    @property
    def swelling_force(self) -> float:
        """Greatest force of an element whose free strain and curvature are restrained."""
        forces = [0.0]
        for _, part in self.assembly.beams:
            section, length = part.section, float(np.diff(part.positions).min())
            bending = abs(section.free_curvature) * section.bending_stiffness / length
            forces.append(bending + abs(section.free_strain) * section.axial_stiffness)
        return max(forces)

    def poses(self, motion: RigidMotion) -> tuple[FloatArray, FloatArray]:
        """Undeformed links in the crank's frame.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        ndarray, shape (B, size)
            Their coordinates, less the reference ones.
        ndarray, shape (B, n_links)
            Their angles in rad.
        """
        turn = motion.angle[:, self.assembly.base, None]
        origin, relative = turned(motion.origin, -turn), motion.angle - turn
        return self.assembly.poses(origin, relative), relative

    def move_to(self, motion: RigidMotion, number: int, pose: FloatArray) -> None:
        """Move the supports to position ``number`` of a batch.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        number : int
        pose : ndarray, shape (size,)
            Its row of :meth:`poses`.
        """
        assembly, set_parameter = self.assembly, self.assembly.mbs.SetObjectParameter
        nodes = assembly.nodes.to_nodes(pose)
        for constraint, coordinate in self._offsets:
            set_parameter(constraint, "offset", float(nodes[coordinate]))
        for tie in self.ties:
            if tie.rotation is not None:
                ends = tie.tie.leader, tie.tie.follower
                leading, following = (pose[assembly.angle_coordinate(end)] for end in ends)
                set_parameter(tie.rotation, "offset", float(following - leading))
        along, across = np.eye(3), normal(-motion.angle[number, assembly.base])
        along[:2, 0], along[:2, 1] = (across[1], -across[0]), across
        set_parameter(assembly.ground, "referenceRotation", along)
        if self.connectors is not None:
            self.connectors.move_to(motion, number, pose)

    def swell(self, fraction: float) -> None:
        """Give all elements a part of the free strains of their sections; 1 for all of it."""
        for _, link in self.assembly.beams:
            strains = self.assembly.kind.free_strains(link.section)
            for element in link.elements if link.section.is_free_strained else ():
                for name, strain in strains.items():
                    self.assembly.mbs.SetObjectParameter(element, name, fraction * strain)

    def _add_clamp(self, clamp: Clamp, is_first: bool) -> None:
        """Fix the place of a clamped end, and its angle where that is a coordinate."""
        assembly, end = self.assembly, clamp.link_end
        turning = assembly.turning_coordinate(end)
        if turning is None and is_first:
            # The slope of the first clamped cable lies along the frame's x axis.
            turning = assembly.kind.clamped
        node, first = assembly.end_node(end), assembly.first_coordinate(end)
        for coordinate in (0, 1) if turning is None else (0, 1, turning):
            name = f"support_{node.name}_{coordinate}"
            constraint = assembly.add_constraint(name, assembly.fixed, node, coordinate)
            self._offsets.append((constraint, first + coordinate))

    def _add_further_clamps(self, angle: FloatArray) -> None:
        """Keep the slopes of further clamped cables from turning; the angle is of all links."""
        assembly = self.assembly
        for clamp in assembly.topology.clamps[1:]:
            if assembly.turning_coordinate(clamp.link_end) is not None:
                continue
            name = f"clamp_{clamp.joint}"
            ground = assembly.items.add("ObjectGround", f"{name}_ground")
            turn = float(angle[assembly.topology.index(clamp.link_end.link)] - angle[assembly.base])
            hold_axis(assembly, name, ground, clamp.link_end, turn)


def simulation_settings(absolute_tolerance: float = 1e-8, *, of_steps: bool = False) -> Any:
    """Settings for one static step without output, and for linearization.

    Parameters
    ----------
    absolute_tolerance : float
        Where Newton's method stops.
    of_steps : bool
        Whether that is a norm of the step's coordinates, instead of one of forces in N.

    Returns
    -------
    exudyn.SimulationSettings
    """
    settings = load_exudyn().SimulationSettings()
    settings.solution.file.write = False
    # A third faster at any size; of dense matrices Exudyn warns beyond 1000 coordinates.
    settings.linearSolver.solverType = load_exudyn().LinearSolverType.EigenSparse
    settings.staticSolver.numberOfLoadSteps = 1
    settings.staticSolver.adaptiveStep = False
    settings.staticSolver.verboseMode = 0
    newton = settings.staticSolver.newton
    # The relative tolerance refers to the first residual and fails near an easy start.
    newton.relativeTolerance = 0.0
    newton.absoluteTolerance = absolute_tolerance
    newton.maxIterations = MAX_ITERATIONS
    newton.residualMode = int(of_steps)
    return settings


def static_settings() -> tuple[Any, Any]:
    """Settings of Exudyn's static solver to try in turn, until steps or forces are small.

    Forces out of balance are no measure beside a stiff link: what its round-off hides may bend a
    soft one that is pinned to it. So Newton's method goes on until its step is small, and is
    content with forces that are round-off, the absolute tolerance of the second ones, only where no
    step ever is.

    Returns
    -------
    tuple of exudyn.SimulationSettings
    """
    return simulation_settings(LAST_STEP, of_steps=True), simulation_settings()


def solve_static(assembly: LinkAssembly, settings: Sequence[Any], start: FloatArray) -> bool:
    """Move the model into static equilibrium.

    Parameters
    ----------
    assembly : LinkAssembly
    settings : sequence of exudyn.SimulationSettings
        Tried one after the other, each from the same start.
    start : ndarray, shape (size,)
        Exudyn's coordinates, less the reference ones.

    Returns
    -------
    bool
        Whether Newton's method ended by one of these settings.
    """
    exudyn, mbs = load_exudyn(), assembly.mbs
    mbs.systemData.SetODE2Coordinates(start, exudyn.ConfigurationType.Initial)
    for one in settings:
        with (
            contextlib.redirect_stdout(io.StringIO()),
            contextlib.suppress(exudyn.SolverError),
        ):
            if mbs.SolveStatic(one, updateInitialValues=False):
                return True
    return False
