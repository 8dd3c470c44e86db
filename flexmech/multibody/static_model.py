"""Static Exudyn system of a mechanism: built once, moved through the crank angles.

The model is in the crank's frame: the shaft's clamp is then a constraint on single
coordinates with a constant constraint Jacobian, whatever the crank angle. What changes
from one position to the next are the coordinates, the ground pivots, the lines of the ground
and the loads.

Convergence criteria of Exudyn's static solver.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system import LAST_STEP, MAX_ITERATIONS
from flexmech.linkages import LinkEnd, RigidMotion, picture_crank_angle
from flexmech.mechanism import Mechanism
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.connectors import ConnectorItems, StaticConnectors, angle_of_end
from flexmech.multibody.items import ItemNumber
from flexmech.multibody.joints import SliderJoint, TieJoint, add_sliders, add_ties
from flexmech.multibody.library import load_exudyn
from flexmech.multibody.static_loads import StaticLoads

RELATIVE_RESIDUAL = 1e-10
"""Part of the load that may be out of balance where Exudyn's static solver takes no small step.

Its second criterion, beside the round-off of the model. Convergence is quadratic: the last
iteration brings far more than that.
"""


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
    grounds : list of tuple of LinkEnd, ItemNumber and ItemNumber
        Link ends that are pinned to the ground, the ground and the pin of each.
    hubs : list of tuple of ItemNumber, int and float
        What holds each end that is clamped to a hub along the crank's frame, number of the end's
        angle among the coordinates of all links, and distance of the end from the shaft's axis.
    connectors : ConnectorItems or None
        Loads and springs.
    applied : StaticConnectors or None
        The same, in the current position of the model.
    ties : list of TieJoint
    sliders : list of SliderJoint
    """

    def __init__(
        self, mechanism: Mechanism, elements: int, kind: str, *, connects: bool = False
    ) -> None:
        self.assembly = assembly = LinkAssembly(mechanism, elements, kind, bodies_have_mass=False)
        self.grounds: list[tuple[LinkEnd, ItemNumber, ItemNumber]] = []
        self.hubs: list[tuple[ItemNumber, int, float]] = []
        self.loads = StaticLoads(assembly)
        fixed = assembly.add_fixed_coordinate()
        self._offsets = self._add_supports(fixed, sprung_alone=connects)
        self.connectors = ConnectorItems(assembly, fixed, runs=False) if connects else None
        self.applied = None if self.connectors is None else StaticConnectors(self.connectors)
        self.ties: list[TieJoint] = []
        self.sliders: list[SliderJoint] = []
        topology = assembly.topology
        if topology.ties or topology.sliders or topology.clamps[1:]:
            linkage = mechanism.linkage
            angle = linkage.motion(picture_crank_angle(linkage)).angle
            self.ties = add_ties(assembly, angle, sprung_alone=connects)
            self.sliders = add_sliders(assembly)
            self._add_further_clamps(angle)
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

    def move_to(self, motion: RigidMotion, number: int) -> FloatArray:
        """Move the supports to position ``number`` of a batch.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        number : int

        Returns
        -------
        ndarray, shape (size,)
            Coordinates of the undeformed links, less the reference ones.
        """
        assembly = self.assembly
        turn = motion.angle[number, assembly.base]
        cosine, sine = np.cos(turn), np.sin(turn)
        back = np.array([[cosine, sine], [-sine, cosine]])
        pose = np.empty(assembly.size)
        for link, part in enumerate(assembly.parts):
            origin = back @ motion.origin[number, link]
            angle = float(motion.angle[number, link] - turn)
            pose[part.coordinates] = part.pose(origin, angle)
        nodes = assembly.nodes.to_nodes(pose)
        set_parameter = assembly.mbs.SetObjectParameter
        for constraint, coordinate in self._offsets:
            set_parameter(constraint, "offset", float(nodes[coordinate]))
        for end, ground, _ in self.grounds:
            place = assembly.part_of(end).end_place(end.end, pose)
            set_parameter(ground, "referencePosition", [*map(float, place), 0.0])
        for tie in self.ties:
            if tie.rotation is not None and tie.turns_nodes:
                leading, following = (
                    pose[assembly.angle_coordinate(end)]
                    for end in (tie.tie.leader, tie.tie.follower)
                )
                set_parameter(tie.rotation, "offset", float(following - leading))
        for slider in self.sliders:
            if slider.ground is not None:
                place, normal = back @ slider.place, back @ slider.normal
                set_parameter(slider.ground, "referencePosition", [*map(float, place), 0.0])
                set_parameter(slider.constraint, "normalMarker1", [*map(float, normal), 0.0])
        if self.applied is not None:
            self.applied.move_to(motion, number, pose)
        return pose

    @contextlib.contextmanager
    def links_alone(self) -> Iterator[None]:
        """Context without the springs between links, for a linearization of the links."""
        if self.connectors is None:
            yield
            return
        self.connectors.activate(False)
        yield
        self.connectors.activate(True)

    def swell(self, part: float) -> None:
        """Give all elements a part of the free strains of their sections; 1 for all of it."""
        assembly = self.assembly
        for _, link in assembly.beams:
            for element in link.elements if link.section.is_free_strained else ():
                assembly.kind.swell(assembly.mbs, element, link.section, part)

    def _add_supports(self, fixed: ItemNumber, sprung_alone: bool) -> list[tuple[ItemNumber, int]]:
        """Fix clamped and pivoted ends; returns constraints of clamps and their coordinates."""
        assembly = self.assembly
        fixed_ends: list[tuple[LinkEnd, tuple[int, ...]]] = []
        for number, clamp in enumerate(assembly.topology.clamps):
            turning = assembly.turning_coordinate(clamp.link_end)
            if turning is not None:
                fixed_ends.append((clamp.link_end, (0, 1, turning)))
            else:
                # The slope of the first clamped cable lies along the frame's x axis.
                fixed_ends.append(
                    (clamp.link_end, (0, 1) if number else (0, 1, assembly.kind.clamped))
                )
        for pivot in assembly.topology.pivots:
            if pivot.sprung and sprung_alone:
                continue
            name, end = f"pivot_{pivot.joint}", pivot.link_end
            self.grounds.append((end, *assembly.add_ground_pin(name, end, (0.0, 0.0))))
        offsets = []
        radius = {clamp.link_end: clamp.hub for clamp in assembly.topology.clamps if clamp.hub}
        for place, coordinates in fixed_ends:
            node, first = assembly.end_node(place), assembly.first_coordinate(place)
            for coordinate in coordinates:
                constraint = assembly.add_constraint(
                    f"support_{node.name}_{coordinate}", fixed, node, coordinate
                )
                offsets.append((constraint, first + coordinate))
                if place in radius and not coordinate:
                    angle = angle_of_end(assembly, place)
                    self.hubs.append((constraint, angle, radius[place]))
        return offsets

    def _add_further_clamps(self, angle: FloatArray) -> None:
        """Keep the slopes of further clamped cables from turning; the angle is of all links."""
        assembly = self.assembly
        for clamp in assembly.topology.clamps[1:]:
            if assembly.turning_coordinate(clamp.link_end) is not None:
                continue
            name, items = f"clamp_{clamp.joint}_rotation", assembly.items
            ground = items.add("ObjectGround", f"{name}_ground")
            turn = float(angle[assembly.topology.index(clamp.link_end.link)] - angle[assembly.base])
            frames = [
                assembly.add_body_frame(ground, f"{name}_on_ground", 0.0),
                assembly.add_frame_marker(clamp.link_end, f"{name}_axis", -turn),
            ]
            items.add(
                "GenericJoint", name, markerNumbers=frames, constrainedAxes=[0, 0, 0, 0, 0, 1]
            )


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
    content with forces that are round-off only where no step ever is; see :func:`set_tolerance`.

    Returns
    -------
    tuple of exudyn.SimulationSettings
    """
    return simulation_settings(LAST_STEP, of_steps=True), simulation_settings()


def set_tolerance(settings: tuple[Any, Any], loaded: float, round_off: float) -> None:
    """Set which forces out of balance :func:`static_settings` are content with.

    Parameters
    ----------
    settings : tuple of exudyn.SimulationSettings
    loaded : float
        Size of the loads in N.
    round_off : float
        Of forces between nodes in N.
    """
    allowed = max(RELATIVE_RESIDUAL * loaded, round_off)
    settings[1].staticSolver.newton.absoluteTolerance = allowed


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
