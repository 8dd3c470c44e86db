"""Internal forces of elastic links, by an engine that runs them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmech.analyses.damping_ratios import CountedLoss
from flexmech.analyses.response.plan import RunPlan, engines_in_state, planned
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.run import run_engine
from flexmech.analyses.response.stresses import running_forces
from flexmech.analyses.strength.forces import Cuts, InternalForces, internal_forces
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.linear_system import Engine
from flexmech.threads import one_thread


@dataclass(frozen=True)
class Runs:
    """Engines that are to run, and what they are asked.

    Parameters
    ----------
    engines : list of Engine
        Of the mechanism in its state.
    request : ResponseRequest
    plan : RunPlan
    attributes : dict of str to str
        What was chosen for them.
    """

    engines: list[Engine]
    request: ResponseRequest
    plan: RunPlan
    attributes: dict[str, str]

    @classmethod
    def of(cls, engines: Sequence[Engine], asked: StrengthRequest, speed: float) -> Runs:
        """Plan the runs of some engines.

        Parameters
        ----------
        engines : sequence of Engine
            Of the mechanism, dry and at its reference temperature.
        asked : StrengthRequest
        speed : float
            Crank speed in rad/s, whatever that of the request.

        Returns
        -------
        Runs

        Raises
        ------
        InputError
            As :func:`flexmech.response`.
        """
        periodic = asked.source == "periodic"
        request = ResponseRequest(
            speed,
            revolutions=1.0 if periodic else asked.revolutions,
            start="periodic" if periodic else "rigid",
        )
        chosen, _ = engines_in_state(list(engines), request, asked.environment)
        loss = CountedLoss.of(chosen[0])
        chosen = [loss.engine(each) for each in chosen]
        return cls(chosen, request, planned(chosen, request), loss.attributes)

    @property
    def crank_angles(self) -> FloatArray:
        """At the samples, in rad, counted on over turns."""
        return np.asarray(self.request.drive.crank_angle(self.plan.time))

    def forces(
        self, engine: Engine, cuts: Mapping[str, Cuts], report: LabelledProgress
    ) -> dict[str, InternalForces]:
        """Run an engine.

        Axial and shear forces follow from its joint forces and the inertia of links that move as
        rigid ones, what vibration adds to that along the links being of second order; bending
        moments are those of the curvature.

        Parameters
        ----------
        engine : Engine
        cuts : mapping of str to Cuts
        report : callable
            Progress.

        Returns
        -------
        dict of str to InternalForces
            Of every link. Bending moments of rigid links with a clamp are not numbers.
        """
        with one_thread():
            run = run_engine(engine, self.request, self.plan, report)
        trajectory = run.trajectory
        by_joints = running_forces(engine, trajectory, self.request.drive)
        found = {}
        for number, link in enumerate(engine.links):
            own = internal_forces(by_joints, number, cuts[link.name])
            section = engine.mechanism.sections.get(link.name)
            if section is not None and not link.rigid:
                rows = link.readings.curvatures_at(cuts[link.name].cut)
                curvature = trajectory.displacement[number] @ rows.T - section.free_curvature
                loads = own.loads.copy()
                # About the pins' axis, from that about the neutral one.
                loads[..., 1] = (
                    section.bending_stiffness * curvature - loads[..., 0] * section.neutral_axis
                )
                own = replace(own, loads=loads)
            found[link.name] = own
        return found
