"""What the time-varying linear model predicts of a hammer test on the running linkage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.analyses.damping_ratios import with_damping_time
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.analyses.running_hammer.request import RunningHammerRequest
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.analyses.stability.vibrating_linkage import VibratingLinkage
from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.dynamical_systems import (
    ForcedPeriodicSystem,
    balanced_response,
    floquet_modes,
    harmonic_response,
    state_modes,
)
from flexmech.errors import CRANK_SPEED, ComputationError, InputError
from flexmech.linear_system import Engine, point_rows
from flexmech.time_domain import forced_linkage

# Natural modes up to this part of the highest frequency of input and response are kept, and tried.
_DETAIL = 1.5
_COUNTS = (3, 4, 6, 8, 12, 16)
_COARSE_TURN = np.radians(np.arange(0.0, 360.0, 30.0))
# Crank angles at which the frozen linkage is solved: its resonances move by less than their
# width from one to the next.
_FROZEN_ANGLES = 180
# Frequencies at which harmonic balance is solved, and harmonics beyond those of the fastest
# moving mode and the orders.
_BALANCED, _SPARE_HARMONICS = 5, 20
_MOST_HARMONICS = 60


@dataclass(frozen=True)
class PredictionErrors:
    """How far a prediction may be off, each over the greatest amplitude of its order, (O,).

    Parameters
    ----------
    steps : ndarray
        By the steps of the propagator: change by half of them.
    balance : ndarray
        Change by harmonic balance.
    reduction : ndarray
        Change by the next larger number of moving modes.
    """

    steps: FloatArray
    balance: FloatArray
    reduction: FloatArray


@dataclass(frozen=True)
class Prediction:
    """The running linkage as a periodic system, and what it answers.

    Parameters
    ----------
    forced, larger : ForcedPeriodicSystem
        In its moving modes, and in the next larger number of them.
    hit : ForcedPeriodicSystem
        The same with the response at the impact's own point.
    steps : int
        Of the propagator a turn.
    modes, moving_modes : int
        Natural modes that have to be right, and moving modes that the states are of.
    growth_rate : float
        Of the vibration that dies out last, in 1/s; negative.
    """

    forced: ForcedPeriodicSystem
    larger: ForcedPeriodicSystem
    hit: ForcedPeriodicSystem
    steps: int
    modes: int
    moving_modes: int
    growth_rate: float

    @property
    def turn_time(self) -> float:
        """Of a turn of the crank, in s."""
        return self.forced.system.period

    def response(self, frequency: FloatArray, orders: IntArray) -> ComplexArray:
        """Harmonic transfer functions, (O, F) in m/N."""
        return harmonic_response(self.forced, frequency, orders, self.steps)

    def errors(self, frequency: FloatArray, orders: IntArray) -> PredictionErrors:
        """How far they may be off.

        Parameters
        ----------
        frequency : ndarray, shape (F,)
        orders : ndarray of int, shape (O,)

        Returns
        -------
        PredictionErrors
        """
        found = self.response(frequency, orders)
        size = np.abs(found).max(axis=1)
        size = np.where(size > 0, size, 1.0)

        def change(other: ComplexArray, mine: ComplexArray) -> FloatArray:
            return np.asarray(np.abs(other - mine).max(axis=1) / size, dtype=float)

        half = harmonic_response(self.forced, frequency, orders, self.steps // 2)
        more = harmonic_response(self.larger, frequency, orders, self.steps)
        peaks = np.abs(found).argmax(axis=1)
        spread = np.linspace(0, len(frequency) - 1, _BALANCED).round().astype(np.intp)
        some = np.unique(np.concatenate([peaks, spread]))
        harmonics = 1 if self.forced.system.is_constant else self._harmonics(orders)
        balanced = balanced_response(self.forced, frequency[some], orders, harmonics)
        return PredictionErrors(
            change(half, found), change(balanced, found[:, some]), change(more, found)
        )

    def _harmonics(self, orders: IntArray) -> int:
        matrix = self.forced.system.matrix.coefficients[0]
        fastest = float(np.abs(np.linalg.eigvals(matrix)).max()) * self.turn_time / (2 * np.pi)
        wanted = int(fastest) + int(np.abs(orders).max()) + _SPARE_HARMONICS
        return min(wanted, _MOST_HARMONICS)


def predicted_linkage(engine: Engine, request: RunningHammerRequest, highest: float) -> Prediction:
    """Linearize the running linkage, and make sure that an impact on it decays.

    Parameters
    ----------
    engine : Engine
        With the damping asked for.
    request : RunningHammerRequest
    highest : float
        Frequency of input or response in Hz that has to be right.

    Returns
    -------
    Prediction

    Raises
    ------
    InputError
        If the linkage is not damped.
    ComputationError
        If there is no equilibrium, or vibrations grow at this crank speed.
    """
    if not any(link.damping.any() for link in engine.links):
        raise InputError(
            "a record of an undamped linkage never decays, so that one impact would disturb the "
            "next; give the links damping: --damping-ratio 0.5% (damping_ratio=0.005), or damping "
            "in the model file"
        )
    # Strongly damped modes that creep back have no frequency to be counted by.
    modes = _modes_below(with_damping_time(engine, 0.0), _DETAIL * highest)
    systems, count, steps = [], 0, 0
    for larger in (0, 1):
        solver = LinkageSolver(engine, request.prestress, modes, larger=larger)
        moving = solver.moving_modes(request.speed)
        stressed = engine.stressed_links(moving.turn.motion, request.prestress)
        connected = engine.connected_matrices(
            engine.frames, moving.turn.displaced, request.prestress, stressed
        )
        stiffness = None if connected is None else connected.stiffness
        pair = (request.impact, request.response)
        systems.append(forced_linkage(moving, stressed, *pair, request.direction, stiffness))
        steps = max(steps, solver.steps_for(VibratingLinkage.of(moving, modes)))
        if not larger:
            count = moving.size
            hit = forced_linkage(
                moving, stressed, request.impact, request.impact, request.direction, stiffness
            )
    steps *= 2
    growth_rate = float(floquet_modes(systems[0].system, steps).exponent.real.max())
    if growth_rate >= 0:
        raise ComputationError(
            f"no record decays at crank speed {CRANK_SPEED}: a vibration of the running linkage "
            f"grows by {growth_rate:.3g} 1/s; give the links more damping, or take another speed "
            "(flexmech stability tells which speeds do that)",
            crank_speed=request.speed,
        )
    return Prediction(systems[0], systems[1], hit, steps, modes, count, growth_rate)


def frozen_response(
    engine: Engine, request: RunningHammerRequest, frequency: FloatArray, orders: IntArray
) -> ComplexArray:
    """Receptance of the frozen linkage at all crank angles, as a Fourier series over the turn.

    What the crank would make of the orders if it turned infinitely slowly: the mean over the
    turn is that of order 0. Without rotation terms, at the stress of the running linkage.

    Parameters
    ----------
    engine : Engine
    request : RunningHammerRequest
    frequency : ndarray, shape (F,)
        In Hz.
    orders : ndarray of int, shape (O,)

    Returns
    -------
    ndarray of complex, shape (O, F)
        In m/N.
    """
    phase = 2 * np.pi / _FROZEN_ANGLES * np.arange(_FROZEN_ANGLES)
    system = engine.linear_system(
        np.sign(request.speed) * phase,
        request.speed,
        prestress=request.prestress,
        rotation_terms=False,
        detail=1.0,
    )
    points = (request.response, request.impact)
    read, put = (point_rows(system, point, request.direction) for point in points)
    total: ComplexArray = np.zeros((len(orders), len(frequency)), dtype=complex)
    for number in range(_FROZEN_ANGLES):
        matrices = (system.mass[number], system.damping[number], system.stiffness[number])
        modes = state_modes(*matrices)
        own = modes.receptance(read[number, None], put[number, None], frequency)[:, 0, 0]
        total += np.exp(-1j * orders * phase[number])[:, None] * own
    return np.asarray(total / _FROZEN_ANGLES)


def _modes_below(engine: Engine, frequency: float) -> int:
    """Number of natural modes that reach beyond a frequency in Hz at every crank angle."""
    for count in _COUNTS:
        found = natural_frequencies(
            engine,
            _COARSE_TURN,
            modes=count,
            prestress=engine.prestress_at_rest,
            rotation_terms=False,
        )
        if found[:, -1].min() > frequency:
            return count
    raise InputError(
        f"more than {_COUNTS[-1]} natural modes lie below {frequency:.6g} Hz, more than a hammer "
        "test on the running linkage takes; ask for a narrower --bandwidth"
    )
