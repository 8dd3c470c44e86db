"""How much a running linkage is amplified at critical speeds by its vibration.

The links' greatest deflection on the periodic motion, over that of the same inertia forces and
loads acting quasi-statically: a dynamic load factor. It is 1 where nothing vibrates. Both follow
from the linear equations about the quasi-static equilibrium, whose periodic motion is found
directly (:mod:`flexmech.solvers.shooting`).

A range of speed in which an order of the crank meets a branch is much wider than a resonance,
because the frequency changes over the turn. The motion is resonant where the order meets the mean
frequency, nearly; the Floquet multipliers of the turn there say at which speed it is. Without
damping it grows there without bound.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from flexmech.analyses.campbell.crossings import HIGHEST, CriticalSpeed, ray
from flexmech.analyses.campbell.engine_bands import EngineDiagram
from flexmech.analyses.campbell.request import CampbellRequest
from flexmech.analyses.response.measurements import deflections
from flexmech.arrays import ComplexArray, FloatArray
from flexmech.choices import Prestress
from flexmech.errors import ComputationError, InputError
from flexmech.linkages import ConstantSpeed
from flexmech.mechanics import Engine, is_constant_turn
from flexmech.mechanics.running import DrivenLinkage
from flexmech.solvers import MotionsOfTurn, quasi_static_turn
from flexmech.solvers.formulation import Systems

logger = logging.getLogger(__name__)

# Steps in a period of the highest order and of the lowest frequency, and of a turn at least: the
# trapezoidal rule then lowers that frequency by 1.4e-3.
_STEPS_A_PERIOD, _LEAST_STEPS = 48, 360
# Where the lowest frequency makes more periods than this in a turn, nothing excites it.
_MOST_PERIODS = 40
# Detail of the component modes: with it the motion is that of all coordinates to 1e-3.
_DETAIL = 2.0
# A free vibration may be the one that an order meets if its frequency at crank angle zero is that
# of the order but for this factor: the multipliers of fast ones come as near to 1 by chance.
_ALIKE = 1.5
# A speed nearer to the resonance than this part of its half width is at it: the motion is then
# greatest but for 2 %.
_NEAR = 0.2
# Speeds closer than this, relatively, are one.
_SAME_SPEED = 1e-6
# A quasi-static deflection that changes by less than this part over the turn excites nothing.
_STEADY = 1e-9


@dataclass(frozen=True)
class RunningMotion:
    """The running linkage at a speed.

    Parameters
    ----------
    crank_speed : float
        In rad/s.
    amplification : float
        Greatest deflection of the links over that without vibration.
    exponents : ndarray of complex, shape (2 n,)
        Of the free vibrations over a turn.
    frequencies : ndarray, shape (2 n,)
        Of these in rad/s.
    """

    crank_speed: float
    amplification: float
    exponents: ComplexArray
    frequencies: FloatArray

    def nearest_resonance(self, order: int) -> float:
        """Speed in rad/s at which an order is resonant, or this one where that is as good."""
        ratio = self.frequencies / (order * abs(self.crank_speed))
        met = self.exponents[(ratio > 1 / _ALIKE) & (ratio < _ALIKE)]
        if not len(met):
            return self.crank_speed
        nearest = met[np.argmin(np.abs(met))]
        if abs(nearest.imag) <= _NEAR * abs(nearest.real):
            return self.crank_speed
        return self.crank_speed * (1 + float(nearest.imag) / (2 * np.pi * order))


@dataclass
class RunningMotions:
    """Periodic motions of an engine's links at the crank speeds that are asked for, each once.

    Parameters
    ----------
    engine : Engine
        With a prescribed shaft.
    prestress : {"none", "axial", "equilibrium"}
        About which quasi-static state the equations are linear.
    modes : int
        Natural frequencies that count.
    orders : int
        The highest order that counts.
    first_frequency : float
        Highest frequency of the first branch in Hz.
    """

    engine: Engine
    prestress: Prestress
    modes: int
    orders: int
    first_frequency: float
    known: dict[float, RunningMotion] = field(init=False, default_factory=dict)
    _refused: list[float] = field(init=False, default_factory=list)

    def at(self, crank_speed: float) -> RunningMotion | None:
        """The motion at a crank speed in rad/s; None where there is none, or nothing excites it."""
        near = _SAME_SPEED * abs(crank_speed)
        if any(abs(speed - crank_speed) <= near for speed in self._refused):
            return None
        for speed, motion in self.known.items():
            if abs(speed - crank_speed) <= near:
                return motion
        try:
            self.known[crank_speed] = self._motion(crank_speed)
        except (ComputationError, InputError) as refusal:
            logger.info("the motion at %g rad/s is not known: %s", crank_speed, refusal)
            self._refused.append(crank_speed)
            return None
        return self.known[crank_speed]

    def _motion(self, crank_speed: float) -> RunningMotion:
        drive = ConstantSpeed(crank_speed)
        periods = self.first_frequency * drive.revolution_time
        if periods > _MOST_PERIODS:
            raise InputError("the crank is too slow for the links to vibrate")
        steps = max(_LEAST_STEPS, _STEPS_A_PERIOD * max(self.orders, math.ceil(periods)))
        linkage = DrivenLinkage(
            self.engine, drive, self.prestress, modes=self.modes, detail=_DETAIL
        )
        still = deflections(self.engine, quasi_static_turn(linkage, steps))
        greatest = float(np.abs(still).max())
        if np.ptp(still, axis=0).max() <= _STEADY * greatest:
            raise InputError("nothing excites the links in the course of a turn")
        turn = MotionsOfTurn.of(linkage, steps)
        moved = float(np.abs(deflections(self.engine, turn.periodic())).max())
        return RunningMotion(crank_speed, moved / greatest, *turn.free_vibrations())


def with_amplification(
    engine: Engine, diagrams: Sequence[EngineDiagram], request: CampbellRequest
) -> tuple[list[EngineDiagram], dict[float, float]]:
    """Diagrams whose critical speeds say by how much the running linkage is amplified there.

    Parameters
    ----------
    engine : Engine
        By whose linear equations the links run.
    diagrams : sequence of EngineDiagram
    request : CampbellRequest

    Returns
    -------
    list of EngineDiagram
    dict of float to float
        Amplification by the operating speed in rad/s, of those within the diagram; none without
        damping, where it depends on how near to a resonance a speed is, to the last digit.
    """
    formulation, level = request.formulation, request.formulation.prestress
    if engine.shaft == "free":
        engine = engine.with_(shaft="prescribed")
    if is_constant_turn(engine, engine.mechanism.linkage.motion(request.turn, 1.0)):
        return list(diagrams), {}
    if not Systems(engine, formulation).damped_by:
        return [_unbounded(each) for each in diagrams], {}
    motions = RunningMotions(
        engine,
        "equilibrium" if level == "trajectory" else level,
        modes=formulation.modes,
        orders=int(request.orders.max()),
        first_frequency=float(np.nanmax(diagrams[0].sampled.values[:, HIGHEST, 0])),
    )
    low, high = request.crank_speeds[[0, -1]].tolist()
    there = {
        speed: motion.amplification
        for speed in engine.mechanism.operating_speeds
        if speed and low <= speed <= high and (motion := motions.at(speed)) is not None
    }
    for each in diagrams:
        for one in each.critical:
            _meet_resonance(motions, each, one)
    return [
        replace(each, critical=[_amplified(motions, one) for one in each.critical])
        for each in diagrams
    ], there


def _unbounded(diagram: EngineDiagram) -> EngineDiagram:
    """The diagram of an undamped linkage, whose deflection has no bound at resonance."""
    met = [
        replace(one, amplification=np.inf) if _mean_crossing(diagram, one)[1] else one
        for one in diagram.critical
    ]
    return replace(diagram, critical=met)


def _meet_resonance(
    motions: RunningMotions, diagram: EngineDiagram, critical: CriticalSpeed
) -> None:
    """Find the motion at the resonance in a range, or at the end that is nearest to it."""
    speed, is_met = _mean_crossing(diagram, critical)
    motion = motions.at(speed) if speed else None
    if motion is not None and is_met:
        resonance = motion.nearest_resonance(critical.order)
        if critical.start <= resonance <= critical.end:
            motions.at(resonance)


def _mean_crossing(diagram: EngineDiagram, critical: CriticalSpeed) -> tuple[float, bool]:
    """Speed in a range at which the order meets the branch's mean frequency, or is nearest to it.

    And whether it meets it.
    """
    sampled, branch = diagram.sampled, critical.branch - 1
    known = np.flatnonzero(sampled.exists)
    grid, mean = sampled.crank_speed[known], sampled.values[known, 1, branch]
    inside = grid[(grid > critical.start) & (grid < critical.end)]
    speeds = np.concatenate([[critical.start], inside, [critical.end]])
    off = ray(critical.order, speeds) - np.interp(speeds, grid, mean)
    places = np.flatnonzero(off[:-1] * off[1:] < 0)
    if not len(places):
        return float(speeds[np.abs(off).argmin()]), False
    n = places[0]
    part = off[n] / (off[n] - off[n + 1])
    return float(speeds[n] + part * (speeds[n + 1] - speeds[n])), True


def _amplified(motions: RunningMotions, critical: CriticalSpeed) -> CriticalSpeed:
    """The critical speed with the greatest of the amplifications that are known in its range."""
    slack = _SAME_SPEED * abs(critical.end)
    here = [
        motion
        for speed, motion in motions.known.items()
        if critical.start - slack <= speed <= critical.end + slack
    ]
    if not here:
        return critical
    most = max(here, key=lambda motion: motion.amplification)
    return replace(critical, amplification=most.amplification, resonance=most.crank_speed)
