"""Loads of elastic links at rest in their frames: at each crank angle's nonlinear equilibrium."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.strength.forces import Cuts, internal_forces
from flexmech.analyses.strength.joint_loads import JointLoads, LoadsOfTurn
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.errors import ComputationError, InputError
from flexmech.hygrothermal import mechanism_in_state
from flexmech.linear_system import DisplacedLinks, Engine
from flexmech.linkages import RigidMotion
from flexmech.threads import one_thread


@dataclass(frozen=True)
class Equilibria:
    """Engines whose quasi-static equilibria are asked for.

    Parameters
    ----------
    engines : list of Engine
        Of the mechanism in its state.
    crank_angles : ndarray, shape (A,)
        In rad.
    speed : float
        Crank speed in rad/s.
    """

    engines: list[Engine]
    crank_angles: FloatArray
    speed: float

    @classmethod
    def of(cls, engines: Sequence[Engine], asked: StrengthRequest, speed: float) -> Equilibria:
        """Engines of a mechanism in its state.

        Parameters
        ----------
        engines : sequence of Engine
            Of the mechanism, dry and at its reference temperature.
        asked : StrengthRequest
        speed : float
            Crank speed in rad/s, whatever that of the request.

        Returns
        -------
        Equilibria

        Raises
        ------
        InputError
            If a load goes over time, or as :func:`flexmech.mechanism_in_state`.
        """
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
        return cls(chosen, asked.crank_angles, speed)

    @property
    def attributes(self) -> dict[str, str]:
        """What was chosen for the engines: nothing."""
        return {}

    def loads(
        self, engine: Engine, cuts: Mapping[str, Cuts], report: LabelledProgress
    ) -> LoadsOfTurn:
        """Internal and joint forces of an engine's equilibria.

        Parameters
        ----------
        engine : Engine
        cuts : mapping of str to Cuts
        report : callable
            Progress.

        Returns
        -------
        LoadsOfTurn

        Raises
        ------
        InputError
            If the shaft is free.
        ComputationError
            If an equilibrium does not converge or is unstable; names the crank angle.
        """
        topology, found = engine.mechanism.linkage.topology, []
        count = len(self.crank_angles)
        with one_thread():
            for batch in engine.batches(count):
                angles = self.crank_angles[batch]
                motion = engine.mechanism.linkage.motion(angles, self.speed, 0.0)
                links = _bent(engine, motion)
                inside = {
                    name: internal_forces(links, number, cuts[name])
                    for number, name in enumerate(topology.link_names)
                }
                found.append(LoadsOfTurn(inside, JointLoads.of_steady_links(links, topology)))
                report(f"equilibria, {engine.name}", int(np.arange(count)[batch][-1]) + 1, count)
        return LoadsOfTurn.joined(found)


def _bent(engine: Engine, motion: RigidMotion) -> DisplacedLinks:
    try:
        return DisplacedLinks.at_equilibrium(engine, motion)
    except ComputationError as error:
        remedy = "; what they would bear if they stayed straight is asked for by the source rigid"
        raise ComputationError(error.message + remedy, crank_speed=error.crank_speed) from error
