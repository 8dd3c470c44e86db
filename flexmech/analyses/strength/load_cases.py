"""Loads of elastic links: at nonlinear equilibria at rest in their frames, or of engines' runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from flexmech.analyses.damping_ratios import CountedLoss
from flexmech.analyses.response.plan import RunPlan, engines_in_state, planned
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.run import EngineRun, mesh_error, run_engine
from flexmech.analyses.response.sprung_frame import in_axes_of_frame
from flexmech.analyses.response.stresses import carried
from flexmech.analyses.strength.joint_loads import (
    Cuts,
    InternalForces,
    JointLoads,
    LoadsAtAngles,
    LoadsOfRun,
    LoadsOfTurn,
    internal_forces,
)
from flexmech.analyses.strength.judged import JudgedMechanism
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.analyses.strength.weakest import (
    LoadsOfEngines,
    Name,
    Sought,
    angles_between,
    changes_of,
    seek,
)
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.errors import ComputationError, InputError
from flexmech.hygrothermal import mechanism_in_state
from flexmech.linkages import RigidMotion
from flexmech.mechanics import DisplacedLinks, Engine
from flexmech.threads import one_thread

# Each leaves a few hundredths of what the one before has changed.
_ROUNDS = 2


@dataclass(frozen=True)
class Equilibria(LoadsOfEngines):
    """Engines whose quasi-static equilibria are asked for.

    Parameters
    ----------
    engines, crank_angles, attributes
        See :class:`LoadsOfEngines`.
    speed : float
        Crank speed in rad/s.
    """

    speed: float

    @classmethod
    def of(cls, engines: Sequence[Engine], asked: StrengthRequest, speed: float) -> Equilibria:
        """See :meth:`LoadsOfEngines.of`; refuses loads over time."""
        dry, chosen = engines[0].mechanism, list(engines)
        for load in dry.loads:
            if load.over == "time":
                raise InputError(
                    f"load {load.name}: it goes over time, and links at rest in their frames have "
                    "no time; choose the source transient, or rigid, or let the load go over the "
                    "crank angle"
                )
        if asked.environment is not None:
            wet = mechanism_in_state(dry, asked.environment)
            chosen = [engine.with_(mechanism=wet) for engine in chosen]
        return cls(chosen, asked.crank_angles, {}, speed)

    def weakest(self, engine: Engine, judged: JudgedMechanism, report: LabelledProgress) -> Sought:
        """See :meth:`LoadsOfEngines.weakest`."""
        source = self.source(engine, report)
        every, between = angles_between(engine.mechanism, self.crank_angles)
        source.add(every)
        return seek(judged, source, rounds=_ROUNDS, between=between)

    def sought(
        self, engine: Engine, judged: JudgedMechanism, report: LabelledProgress
    ) -> tuple[Sought, dict[Name, float]]:
        """See :meth:`LoadsOfEngines.sought`: by twice the elements."""
        found = self.weakest(engine, judged, report)
        finer = engine.with_(elements=2 * engine.elements)
        return found, changes_of(judged, found, self.source(finer, report))

    def source(self, engine: Engine, report: LabelledProgress) -> LoadsAtAngles:
        """See :meth:`LoadsOfEngines.source`: those of equilibria, without any yet."""

        def compute(angles: FloatArray) -> list[DisplacedLinks]:
            found, count = [], len(angles)
            with one_thread():
                for batch in engine.batches(count):
                    motion = engine.mechanism.linkage.motion(angles[batch], self.speed, 0.0)
                    found.append(_bent(engine, motion))
                    done = int(np.arange(count)[batch][-1]) + 1
                    report(f"equilibria, {engine.name}", done, count)
            return found

        return LoadsAtAngles(engine.mechanism, compute)


def _bent(engine: Engine, motion: RigidMotion) -> DisplacedLinks:
    try:
        return DisplacedLinks.at_equilibrium(engine, motion)
    except ComputationError as error:
        remedy = "; the source rigid gives the margins of links that stay straight"
        raise ComputationError(error.message + remedy, crank_speed=error.crank_speed) from error


@dataclass(frozen=True)
class Runs(LoadsOfEngines):
    """Engines that are to run, at the crank angles of the samples, counted on over turns.

    Parameters
    ----------
    engines, crank_angles, attributes
        See :class:`LoadsOfEngines`.
    request : ResponseRequest
    plan : RunPlan
    """

    request: ResponseRequest
    plan: RunPlan

    @classmethod
    def of(cls, engines: Sequence[Engine], asked: StrengthRequest, speed: float) -> Runs:
        """See :meth:`LoadsOfEngines.of`; refuses as :func:`flexmech.response` does."""
        periodic = asked.source == "periodic"
        request = ResponseRequest(
            speed,
            revolutions=1.0 if periodic else asked.revolutions,
            start="periodic" if periodic else "rigid",
        )
        chosen, _ = engines_in_state(list(engines), request, asked.environment)
        loss = CountedLoss.of(chosen[0])
        chosen = [loss.engine(each) for each in chosen]
        plan = planned(chosen, request)
        angles = np.asarray(request.drive.crank_angle(plan.time))
        return cls(chosen, angles, loss.attributes, request, plan)

    def weakest(self, engine: Engine, judged: JudgedMechanism, report: LabelledProgress) -> Sought:
        """See :meth:`LoadsOfEngines.weakest`."""
        return self._run(engine, judged, report)[1]

    def sought(
        self, engine: Engine, judged: JudgedMechanism, report: LabelledProgress
    ) -> tuple[Sought, dict[Name, float]]:
        """See :meth:`LoadsOfEngines.sought`: by other time steps, component modes and elements."""
        run, found = self._run(engine, judged, report)
        by = run.step_error, run.reduction_error, mesh_error(run, self.request, self.plan, report)
        topology = engine.mechanism.linkage.topology
        stress, force = (
            np.sum([one.of[f"peak_{of}"] for one in by], axis=0) for of in ("stress", "force")
        )
        errors = dict(zip((("pin", joint) for joint in topology.joint_names), force, strict=True))
        for kind in ("link", "fatigue"):
            links = ((kind, name) for name in topology.link_names)
            errors |= dict(zip(links, stress, strict=True))
        return found, {name: float(error) for name, error in errors.items()}

    def source(self, engine: Engine, report: LabelledProgress) -> LoadsOfRun:
        """See :meth:`LoadsOfEngines.source`: those of a run."""
        return self._source(engine, run_engine(engine, self.request, self.plan, report))

    def _run(
        self, engine: Engine, judged: JudgedMechanism, report: LabelledProgress
    ) -> tuple[EngineRun, Sought]:
        """Run of an engine, and its loads where every part is weakest."""
        run = run_engine(engine, self.request, self.plan, report)
        return run, seek(judged, self._source(engine, run), rounds=_ROUNDS)

    def _source(self, engine: Engine, run: EngineRun) -> LoadsOfRun:
        """Internal and joint forces of a run: they balance what moves, by d'Alembert's principle.

        Accelerations are the slopes of the rates between the samples.
        """
        trajectory, running = run.trajectory, []
        drawn = carried(engine, replace(trajectory, frame=None), self.request.drive)
        motion = in_axes_of_frame(engine, drawn, trajectory)
        with one_thread():
            gained = [
                CubicSpline(trajectory.time, own)(trajectory.time, 1) for own in trajectory.rate
            ]
            for batch in engine.batches(len(trajectory.time)):
                part = trajectory[batch]
                running.append(
                    DisplacedLinks.of_run(
                        engine,
                        motion.at(batch),
                        part.time,
                        part.displacement,
                        part.rate,
                        [own[batch] for own in gained],
                        drawn.at(batch),
                        None if part.frame is None else part.frame.displacement[:, 2],
                    )
                )
        topology = engine.mechanism.linkage.topology

        def at_samples(cuts: Mapping[str, Cuts]) -> LoadsOfTurn:
            found = []
            with one_thread():
                for own in running:
                    inside = {
                        name: internal_forces(own, number, cuts[name])
                        for number, name in enumerate(topology.link_names)
                    }
                    gap = _moment_gap(own, inside, cuts)
                    found.append(LoadsOfTurn(inside, JointLoads.of_links(own, topology), gap))
            return LoadsOfTurn.joined(found)

        return LoadsOfRun(self.crank_angles, at_samples)


def _moment_gap(
    running: DisplacedLinks, inside: Mapping[str, InternalForces], cuts: Mapping[str, Cuts]
) -> FloatArray:
    """Greatest difference of bending moments from those of the curvature, and greatest moment.

    Shape (n_links, 2), in N m; zero where a link is rigid. Forces that damp the links do not count.
    """
    found = np.zeros((len(running.links), 2))
    for number, link in enumerate(running.links):
        section = running.mechanism.sections.get(link.name)
        if section is None or link.rigid:
            continue
        where, loads = cuts[link.name], inside[link.name].loads
        displacement = running.displacement[number]
        curvature = link.readings.bent_curvature(
            displacement, where.cut, where.kinks, link.vectors[1]
        )
        # About the pins' axis, from that about the neutral one.
        moment = section.bending_stiffness * (curvature - section.free_curvature)
        moment -= loads[..., 0] * section.neutral_axis
        found[number] = np.abs(loads[..., 1] - moment).max(), np.abs(moment).max()
    return found
