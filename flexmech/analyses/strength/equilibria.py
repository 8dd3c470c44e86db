"""Loads of elastic links at rest in their frames: at each crank angle's nonlinear equilibrium."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.strength.judged_mechanism import JudgedMechanism
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.analyses.strength.sampled_loads import LoadsAtAngles
from flexmech.analyses.strength.sought import (
    LoadsOfEngines,
    Sought,
    angles_between,
    changes_of,
    seek,
)
from flexmech.analyses.strength.weakest import Name
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.errors import ComputationError, InputError
from flexmech.hygrothermal import mechanism_in_state
from flexmech.linear_system import DisplacedLinks, Engine
from flexmech.linkages import RigidMotion
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
        remedy = "; what they would bear if they stayed straight is asked for by the source rigid"
        raise ComputationError(error.message + remedy, crank_speed=error.crank_speed) from error
