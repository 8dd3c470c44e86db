"""The Exudyn engine: the same mechanism from multibody beam elements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from flexmech.arrays import SAME_PLACE, FloatArray, StepProgress
from flexmech.choices import (
    ELEMENTS,
    INTEGRATORS,
    MODES,
    Integrator,
    LinkDirection,
    MassChoice,
    ShaftChoice,
)
from flexmech.errors import InputError
from flexmech.linkages import Drive, LockedCrank, MotorRun, RigidMotion
from flexmech.linkages.inverse_dynamics import LinkForces
from flexmech.mechanics import (
    DeadMoments,
    Engine,
    LinkModel,
    LinkPoint,
    Prestress,
    StressedLinks,
    TheoryComparison,
    acts_at_rest,
)
from flexmech.mechanics.beams import compare_theories
from flexmech.mechanics.running import Impact, LinkState, Recorder, Trajectory
from flexmech.mechanism import Mechanism
from flexmech.multibody.beams import refuse_sections
from flexmech.multibody.exudyn_system import ExudynSystem
from flexmech.multibody.items import check_exudyn
from flexmech.multibody.linearize import (
    internal_forces,
    link_models,
    running_tangents,
    static_equilibrium,
    unit_tension_stiffness,
)
from flexmech.multibody.running.loads import MotorOnHub, TorqueTable
from flexmech.multibody.running.model import RunningModel
from flexmech.multibody.running.simulation import PointRecorder, Simulation
from flexmech.multibody.static_model import StaticModel
from flexmech.validation import POSITIVE, check_choice, check_number, checked_array


class ExudynEngine(Engine):
    """Links of Exudyn's ANCF cable or geometrically exact beam elements.

    Mass, stiffness and damping come from Exudyn's linearization, the quasi-static
    equilibrium from its static solver; the transformation to link frames is the one that
    all engines share. Parameters as for :class:`flexmech.mechanics.Engine`; the
    element is ``"ancf"``, the default of slender links, or ``"geometrically-exact"``, which is
    the default where shear matters and the only one for sections whose neutral axis or centre
    of mass is off the pins' axis.

    Raises
    ------
    InputError
        If exudyn is not installed, the element is unknown or cannot have such a section, or there
        is no element.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> flexmech.ExudynEngine(mechanism, elements=4)
    ExudynEngine(aluminium four-bar, 4 ancf elements a link)
    """

    name: ClassVar[str] = "exudyn"
    element_kinds: ClassVar[tuple[str, ...]] = ELEMENTS["exudyn"]
    counterparts: ClassVar[dict[str, str]] = {
        "euler": "ancf",
        "timoshenko": "geometrically-exact",
        "reddy": "geometrically-exact",
        "zigzag": "geometrically-exact",
    }
    theories: ClassVar[dict[str, str]] = {"ancf": "euler", "geometrically-exact": "timoshenko"}
    finer_elements: ClassVar[dict[str, str]] = {"ancf": "geometrically-exact"}
    untensioned_elements: ClassVar[tuple[str, ...]] = ("geometrically-exact",)
    simulates: ClassVar[bool] = True
    solves_connectors: ClassVar[bool] = True

    @property
    def axial_modes_of_bows(self) -> int:
        """Number of axial modes that a bowed link needs to bend without stretch.

        Cables stretch by the slopes of their cubic shapes: nothing less than all of their axial
        coordinates, two for each element, makes up for that.
        """
        return 2 * self.elements if self.element == "ancf" else 0

    def __init__(
        self,
        mechanism: Mechanism,
        elements: int = 8,
        element: str | None = None,
        component_modes: bool = True,
        modes: int = MODES,
        shaft: ShaftChoice = "prescribed",
        mass: MassChoice = "distributed",
    ) -> None:
        check_exudyn()
        super().__init__(mechanism, elements, element, component_modes, modes, shaft, mass)
        refuse_sections(mechanism, self.element)

    @classmethod
    def compare_theories(cls, mechanism: Mechanism, modes: int) -> TheoryComparison:
        """See :meth:`Engine.compare_theories`: Exudyn's own beams converge too slowly for it."""
        return compare_theories(mechanism, modes)

    @cached_property
    def model(self) -> StaticModel:
        """The Exudyn system, moved through the crank angles."""
        return StaticModel(
            self.mechanism, self.elements, self.element, connects=acts_at_rest(self.mechanism)
        )

    @cached_property
    def clamped_links(self) -> tuple[LinkModel, ...]:
        """Unreduced link models in Exudyn's coordinates, node by node."""
        return link_models(self.model)

    @cached_property
    def _unit_tension(self) -> dict[int, FloatArray]:
        return unit_tension_stiffness(self.model)

    def _is_straight(self, motion: RigidMotion, prestress: Prestress) -> bool:
        straight = super()._is_straight(motion, prestress)
        if prestress == "axial" and self.element in self.untensioned_elements:
            other = "" if self.mechanism.is_eccentric else "element 'ancf' or "
            raise InputError(
                "prestress 'axial' needs an element that can carry tension in its straight "
                "shape; the geometrically exact beam cannot: use "
                f"{other}prestress 'equilibrium'"
            )
        return straight

    def _elastic_equilibrium(
        self,
        motion: RigidMotion,
        loads: Sequence[FloatArray],
        dead: DeadMoments,
        near: Sequence[FloatArray] | None,
    ) -> StressedLinks:
        # The static solver goes from one crank angle to the next by itself.
        del near
        displacement, tangent, damping = static_equilibrium(self.model, motion, loads, dead)
        force = internal_forces(self.model, displacement)
        return StressedLinks(tangent, displacement, force, damping)

    def simulate(
        self,
        drive: Drive,
        start: LinkState,
        sample_time: FloatArray,
        step: float,
        *,
        integrator: Integrator = "trapezoidal",
        progress: StepProgress | None = None,
        band: float | None = None,
        impacts: Sequence[Impact] = (),
    ) -> Trajectory:
        """Run the linkage with large displacements from time zero to the last sample.

        Parameters
        ----------
        drive : Drive
        start : LinkState
            State at time zero.
        sample_time : ndarray, shape (N,)
            Increasing times in s, zero or later, at which the run is kept.
        step : float
            Time step in s.
        integrator : {"trapezoidal", "generalized-alpha"}
            The implicit trapezoidal rule with constraints on velocities, which keeps the
            energy, or generalized-alpha, which damps what is too fast for the step.
        progress : callable, optional
            Called with the steps done and their total, every hundred steps.
        band : float, optional
            Frequency in Hz up to which joint forces and torque are kept.
        impacts : sequence of Impact
            Pulses on points of links, in directions that turn with the links' rigid frames. The
            energy balance does not include their work: its error is then not a number.

        Returns
        -------
        Trajectory

        Raises
        ------
        InputError
            If the step, a sample or the integrator cannot be, or the start tears a joint.
        ComputationError
            If a step does not converge; names its time and the crank angle.
        """
        check_number(step, "step", "s", POSITIVE)
        sample_time = checked_array(sample_time, "sample_time", "s")
        check_choice(integrator, INTEGRATORS, "integrator")
        if len(sample_time) == 0 or sample_time[0] < 0 or np.any(np.diff(sample_time) <= 0):
            raise InputError("sample times must be zero or later and increase")
        if band is not None:
            check_number(band, "band", "Hz", POSITIVE)
        recorder = Recorder(sample_time, step, band)
        torque = self._torque_on_free_shaft(drive, step, recorder.steps)
        model = self._running(drive, recorder.steps * step, impacts, torque)
        Simulation(model, step, recorder.steps, integrator).run(start, recorder, progress)
        trajectory = recorder.finish()
        return replace(trajectory, energy_error=float("nan")) if impacts else trajectory

    def _running(
        self,
        drive: Drive,
        duration: float,
        impacts: Sequence[Impact] = (),
        torque: TorqueTable | MotorOnHub | None = None,
    ) -> RunningModel:
        made_of = self.mechanism, self.elements, self.element
        return RunningModel(*made_of, drive, self.clamped_links, duration, impacts, torque)

    def _torque_on_free_shaft(
        self, drive: Drive, step: float, steps: int
    ) -> TorqueTable | MotorOnHub | None:
        """Torque at the steps of a run, or the motor; None where the shaft is prescribed."""
        if isinstance(drive, LockedCrank):
            self.require_prescribed_shaft("a run with the crank locked")
            return None
        if self.shaft == "prescribed":
            return None
        if isinstance(drive, MotorRun):
            return MotorOnHub(drive)
        return TorqueTable.at_steps(self.mechanism, drive, step, steps)

    def point_histories(
        self,
        drive: Drive,
        start: LinkState,
        points: Sequence[tuple[LinkPoint, LinkDirection]],
        step: float,
        steps: int,
        *,
        impacts: Sequence[Impact] = (),
        progress: StepProgress | None = None,
    ) -> FloatArray:
        """Displacement of points of links at every step, as of a vibrometer on the links' frames.

        Parameters
        ----------
        drive : Drive
        start : LinkState
            State at time zero.
        points : sequence of (LinkPoint, {"transverse", "axial"})
        step : float
            Time step of the trapezoidal rule in s.
        steps : int
        impacts : sequence of Impact
            Pulses on points of links, in directions that turn with the links' rigid frames.
        progress : callable, optional
            Called with the steps done and their total, every hundred steps.

        Returns
        -------
        ndarray, shape (steps + 1, n_points)
            In m, in the frames of the rigid links.

        Raises
        ------
        InputError
            If a point is on no link, the step cannot be, or the start tears a joint.
        ComputationError
            If a step does not converge; names its time and the crank angle.
        """
        self.require_prescribed_shaft("a record of points")
        check_number(step, "step", "s", POSITIVE)
        model = self._running(drive, steps * step, impacts)
        recorder = PointRecorder(self.mechanism.linkage.topology, self.clamped_links, points)
        Simulation(model, step, steps, "trapezoidal").run(start, recorder, progress)
        return recorder.finish()

    def running_system(
        self,
        drive: Drive,
        start: LinkState,
        step: float,
        steps: int,
        *,
        integrator: Integrator = "trapezoidal",
        stride: int = 1,
    ) -> ExudynSystem:
        """The system that :meth:`simulate` runs, with named items and sensors.

        Parameters
        ----------
        drive : Drive
        start : LinkState
            State at time zero.
        step : float
            Time step in s.
        steps : int
        integrator : {"trapezoidal", "generalized-alpha"}
        stride : int
            Steps from one sample that the script writes to the next.

        Returns
        -------
        ExudynSystem

        Raises
        ------
        InputError
            If the step or the integrator cannot be, or the start tears a joint.
        """
        self.require_prescribed_shaft("the exported system")
        check_number(step, "step", "s", POSITIVE)
        check_choice(integrator, INTEGRATORS, "integrator")
        model = self._running(drive, steps * step)
        simulation = Simulation(model, step, steps, integrator)
        return ExudynSystem.of(simulation, start, stride)

    def internal_forces(
        self, motion: RigidMotion, displacement: Sequence[FloatArray]
    ) -> list[FloatArray]:
        """See :meth:`Engine.internal_forces`."""
        del motion
        return internal_forces(self.model, displacement)

    def running_links(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray] | None = None,
    ) -> StressedLinks:
        """Elastic stiffness, forces and damping; see :meth:`Engine.running_links`."""
        rate = rate if self.has_damped_links else None
        tangent, damping = running_tangents(self.model, motion, displacement, rate)
        force = internal_forces(self.model, displacement)
        return StressedLinks(tangent, list(displacement), force, damping)

    def _tensioned(self, motion: RigidMotion, forces: LinkForces) -> dict[int, FloatArray]:
        """Tangents of the straight links by the mean tension of each element.

        With the crank held most linkages are statically determinate: the linear static solution's
        axial force is that of the rigid linkage. It is quadratic along an element, and its mean is
        what the element's end displacements alone would give.
        """
        tangent = {}
        for number, unit in self._unit_tension.items():
            nodes = self.clamped_links[number].readings.nodes
            length = np.diff(nodes)
            inside = SAME_PLACE * length  # off the point masses that may sit at the nodes
            near, middle, far = (
                forces.axial_force(number, at)
                for at in (nodes[:-1] + inside, nodes[:-1] + length / 2, nodes[1:] - inside)
            )
            mean = (near + 4 * middle + far) / 6
            stiffness = self.clamped_links[number].stiffness
            tangent[number] = stiffness + np.tensordot(mean, unit, axes=1)
        return tangent
