"""Lengths, steps, crank angles and force of the impacts on a running linkage."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexmech.analyses.hammer.plan import STEPS_A_PULSE
from flexmech.analyses.response.plan import STEPS_PER_PERIOD
from flexmech.analyses.running_hammer.prediction import Prediction
from flexmech.analyses.running_hammer.request import RunningHammerRequest
from flexmech.arrays import FloatArray, IntArray
from flexmech.dynamical_systems import ForcedPeriodicSystem, HalfSinePulse, harmonic_response
from flexmech.errors import InputError
from flexmech.linear_system import Engine

# Part of its greatest response to which an impact has died out before the next one comes.
_DECAYED = 1e-4
# Orders that are identified besides those asked for: what they answer is not taken for theirs.
GUARD_ORDERS = 3

# Impacts besides one for each order, whose misfit tells what the orders leave out; and by how much
# of their distance crank angles are jittered to either side.
_SPARE_IMPACTS = 2
_JITTER = 0.1
# Of a turn, at least: a degree; and of a run, more of which take hours.
_LEAST_STEPS = 360
_MOST_STEPS = 1_000_000
# Greatest displacement that the first impacts are meant to cause, over the shortest link.
_SMALL = 1e-4
# Turns besides those in which an impact decays: one in which it comes, and one at the end in
# which what is left is measured.
_MORE_TURNS = 2


@dataclass(frozen=True)
class RunPlan:
    """Runs of a hammer test, all from crank angle zero.

    Parameters
    ----------
    turn_time : float
        In s.
    turns : int
        Of a run, which is a record too.
    steps : int
        Time steps a turn.
    phase : ndarray, shape (K,)
        Of the impacts in their first turn, from 0 to 1.
    pulse : float
        Duration in s.
    peak_force : float
        In N.
    bandwidth : float
        In Hz.
    fitted : int
        Highest order that is identified, guards included.
    """

    turn_time: float
    turns: int
    steps: int
    phase: FloatArray
    pulse: float
    peak_force: float
    bandwidth: float
    fitted: int

    @property
    def step(self) -> float:
        """Time step in s."""
        return self.turn_time / self.steps

    @property
    def samples(self) -> int:
        """Of a record; the first of the next turn is not one of them."""
        return self.turns * self.steps

    @property
    def resolution(self) -> float:
        """Distance of two frequencies in Hz."""
        return 1 / (self.turns * self.turn_time)

    @property
    def bins(self) -> int:
        """Frequencies from zero up to the bandwidth."""
        return int(self.bandwidth / self.resolution * (1 + 1e-9)) + 1

    @property
    def frequency(self) -> FloatArray:
        """Of the input, in Hz."""
        return np.asarray(self.resolution * np.arange(self.bins, dtype=float))

    def pulses(self) -> list[HalfSinePulse]:
        """Of all impacts."""
        starts = (self.phase * self.turn_time).tolist()
        return [HalfSinePulse(self.peak_force, self.pulse, start) for start in starts]

    def softer(self, factor: float) -> RunPlan:
        """The same with a part of the force."""
        return replace(self, peak_force=factor * self.peak_force)


def planned(
    engine: Engine, request: RunningHammerRequest, prediction: Prediction, bandwidth: float
) -> RunPlan:
    """Plan the runs by what is predicted.

    Parameters
    ----------
    engine : Engine
    request : RunningHammerRequest
    prediction : Prediction
    bandwidth : float
        In Hz.

    Returns
    -------
    RunPlan

    Raises
    ------
    InputError
        If the record is too short for an impact to decay or for its pulse, or a run would take
        too many steps.
    """
    time = prediction.turn_time
    turns = _turns(request, prediction)
    pulse = 1 / bandwidth if request.pulse is None else request.pulse
    if pulse > time * (turns - _MORE_TURNS):
        raise InputError(
            f"a pulse of {pulse:.4g} s is longer than the record of {turns * time:.4g} s; give a "
            "shorter --pulse, or a longer --duration"
        )
    shortest = min(1 / (STEPS_PER_PERIOD * bandwidth), pulse / STEPS_A_PULSE)
    steps = max(_LEAST_STEPS, 2 * int(np.ceil(time / shortest / 2)))
    if steps * turns > _MOST_STEPS:
        raise InputError(
            f"a run of {turns} turns with {steps} steps each takes more than {_MOST_STEPS} steps; "
            "ask for a lower --bandwidth, a longer --pulse, or more damping"
        )
    fitted = request.orders + GUARD_ORDERS
    plan = RunPlan(
        turn_time=time,
        turns=turns,
        steps=steps,
        phase=_phases(2 * fitted + 1 + _SPARE_IMPACTS, request.seed, steps // 2),
        pulse=pulse,
        peak_force=1.0,
        bandwidth=bandwidth,
        fitted=fitted,
    )
    shortest_link = min(link.length for link in engine.mechanism.linkage.topology.links)
    orders = np.arange(-fitted, fitted + 1)
    greatest = max(
        _greatest(forced, prediction.steps, plan, orders)
        for forced in (prediction.forced, prediction.hit)
    )
    return plan.softer(_SMALL * shortest_link / greatest)


def _turns(request: RunningHammerRequest, prediction: Prediction) -> int:
    """Turns of a run at whose end an impact has decayed."""
    decay = -np.log(_DECAYED) / -prediction.growth_rate / prediction.turn_time
    needed = int(np.ceil(decay)) + _MORE_TURNS
    if request.duration is None:
        return needed
    turns = int(np.ceil(request.duration / prediction.turn_time * (1 - 1e-9)))
    if turns < needed:
        raise InputError(
            f"in a record of {request.duration:.6g} s an impact does not decay to {_DECAYED:g}, "
            f"which takes {needed * prediction.turn_time:.4g} s; give --duration that or more, or "
            "more damping (--damping-ratio)"
        )
    return turns


def _phases(count: int, seed: int, double_steps: int) -> FloatArray:
    """Evenly spaced places of the turn, each jittered, (count,).

    All impacts begin as a double step does: steps then make the same of each pulse, and what they
    make of it is not taken for a dependence on the crank angle.
    """
    jitter = _JITTER * np.random.default_rng(seed).uniform(-1.0, 1.0, count)
    places = (np.arange(count) + 0.5 + jitter) / count
    return np.asarray(np.round(double_steps * places) / double_steps)


def _greatest(forced: ForcedPeriodicSystem, steps: int, plan: RunPlan, orders: IntArray) -> float:
    """Bound of the response to a pulse of 1 N, in m."""
    found = harmonic_response(forced, plan.frequency, orders, steps)
    pulse = np.abs(HalfSinePulse(1.0, plan.pulse).spectrum(plan.frequency))
    return float(2 * plan.resolution * (np.abs(found) @ pulse).sum())
