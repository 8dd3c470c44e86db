"""What stability needs of the linkage at a crank speed: a small periodic system and its shapes.

Its frequencies decide the steps of the propagator in a turn, which must fit into memory.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import FourierSeries, SampledPeriodicSystem
from flexmech.errors import CRANK_SPEED, ComputationError
from flexmech.time_domain import MovingModes

# Of a turn; more do not fit into memory with the smallest of linkages.
MOST_STEPS = 1_000_000
SHAPE_ANGLES = 16
"""Crank angles a turn at which the shapes of modes are compared: a shape changes as the linkage's
position does, in the first few harmonics of the turn."""


@dataclass(frozen=True)
class VibratingLinkage:
    """The linkage in m moving modes, without the matrices from which they were made.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    scale : ndarray, shape (m,)
        See :class:`flexmech.time_domain.MovingModes`.
    conservative, dissipative : FourierSeries
        Of the system's matrix (2 m, 2 m), and of what damping of links adds to it.
    attached : FourierSeries
        What dampers of springs and joints and follower forces add to it.
    weighted : ndarray, shape (SHAPE_ANGLES, N, m)
        From y to the coordinates of all unreduced links, weighted by their mass.
    lowest : ndarray, shape (SHAPE_ANGLES, modes, m)
        From y to the amplitudes of the lowest natural modes at the same crank angles, without
        rigid ones.
    rigid : ndarray, shape (SHAPE_ANGLES, r, m)
        From y to the amplitudes of rigid modes: that of a free shaft.
    fastest : float
        Greatest natural frequency in rad/s that the steps must resolve.
    highest : float
        Greatest natural frequency in rad/s of the modes whose Floquet modes are kept.
    least_square, least_angle : float
        Least square of a natural frequency in (rad/s)^2, and its crank angle in rad.
    is_definite : bool
        Whether the Hamilton function is positive definite at all crank angles.
    orbit_distance, orbit_residual : float or None
        Of the periodic motion, if it is about one.
    """

    crank_speed: float
    scale: FloatArray
    conservative: FourierSeries
    dissipative: FourierSeries
    attached: FourierSeries
    weighted: FloatArray
    lowest: FloatArray
    rigid: FloatArray
    fastest: float
    highest: float
    least_square: float
    least_angle: float
    is_definite: bool
    orbit_distance: float | None = None
    orbit_residual: float | None = None

    @classmethod
    def of(cls, moving: MovingModes, modes: int) -> VibratingLinkage:
        """Take what is needed from moving modes.

        Parameters
        ----------
        moving : MovingModes
        modes : int
            Natural modes whose Floquet modes are kept.

        Returns
        -------
        VibratingLinkage
        """
        turn = moving.turn
        some = slice(None, None, len(moving.basis) // SHAPE_ANGLES)
        basis, squares = moving.basis[some], turn.frozen_squares
        first = turn.rigid_modes
        natural = np.swapaxes(turn.frozen_modes[some, :, : first + modes], 1, 2)
        amplitude = natural @ turn.mass[some] @ basis
        least = int(turn.static_squares.argmin())
        # A constant system is solved exactly, whatever else moves in it.
        asked = min(first + modes, moving.size)
        counted = asked if turn.is_constant else moving.size
        return cls(
            crank_speed=turn.crank_speed,
            scale=moving.scale,
            conservative=moving.conservative,
            dissipative=moving.dissipative,
            attached=moving.attached,
            weighted=turn.weighted_shapes(basis, some),
            lowest=amplitude[:, first:],
            rigid=amplitude[:, :first],
            fastest=float(np.sqrt(max(squares[:, counted - 1].max(), 0.0))),
            highest=float(np.sqrt(max(squares[:, asked - 1].max(), 0.0))),
            least_square=float(turn.static_squares[least]),
            least_angle=float(turn.motion.crank_angle[least]),
            is_definite=moving.is_definite,
        )

    @property
    def size(self) -> int:
        """Number m of moving modes."""
        return len(self.scale)

    @property
    def is_constant(self) -> bool:
        """Whether nothing changes in the turn, so that the Floquet modes are eigenvectors."""
        return not any(
            series.harmonics for series in (self.conservative, self.attached, self.dissipative)
        )

    @property
    def period(self) -> float:
        """Time of a turn in s."""
        return 2 * np.pi / abs(self.crank_speed)

    def spacing(self, steps: int) -> int:
        """Steps between instants that show all harmonics of the modes kept."""
        wanted = max(LEAST_STEPS, SHAPES_A_PERIOD * self.highest * self.period / (2 * np.pi))
        places = steps // SHAPE_ANGLES
        divisors = [n for n in range(1, places + 1) if places % n == 0]
        return max([1, *(n for n in divisors if steps / n >= wanted)])

    def system(self, damping: float) -> SampledPeriodicSystem:
        """Periodic system with the damping of links times a factor; 0 leaves it out."""
        matrix = self.conservative.plus(self.attached, 1.0).plus(self.dissipative, damping)
        return SampledPeriodicSystem(matrix, self.period)

    def with_potential_alone(self) -> VibratingLinkage:
        """The linkage without dampers of springs and joints and without follower forces."""
        return replace(self, attached=FourierSeries(np.zeros_like(self.attached.coefficients)))


# Steps are this part of a period of the fastest moving mode over 2 pi, or shorter: a propagator of
# sixth order then leaves 1e-7 of the multipliers of the modes asked for, which are slower.
RADIANS_A_STEP = 1.5
# A free shaft moves far more slowly, and what the steps leave of the fastest modes shows there.
RADIANS_BESIDE_A_FREE_SHAFT = 0.5
# Of a turn at speeds above all modes: eight a crank angle at which shapes are compared.
LEAST_STEPS = 128
# Instants in a period of the highest frequency kept: the harmonics of a mode are some orders of the
# crank around its frequency, and two would be the limit.
SHAPES_A_PERIOD = 2.5
# Bytes that the steps of a turn may take, and what is kept of each step: matrices of the size of A,
# and waves of each harmonic (measured).
MOST_BYTES, MATRICES_A_STEP, WAVES_A_STEP = 4e9, 10, 12


def steps_of_turn(moving: VibratingLinkage, asked: int | None, *, beside_free_shaft: bool) -> int:
    """Steps of a turn: those asked for, or as many as the fastest moving mode wants.

    Parameters
    ----------
    moving : VibratingLinkage
        A constant one is solved by its eigenvalues, with any number of steps.
    asked : int or None
        A multiple of :data:`SHAPE_ANGLES`, at most :data:`MOST_STEPS`.
    beside_free_shaft : bool
        Whether the crank's shaft rotates freely.

    Returns
    -------
    int

    Raises
    ------
    ComputationError
        If the steps do not fit into memory.
    """
    if asked is None:
        steps = _wanted_steps(moving, beside_free_shaft=beside_free_shaft)
        remedy = "fewer modes or faster crank speeds"
    else:
        steps, remedy = asked, "fewer steps"
    if moving.is_constant:
        return int(min(steps, MOST_STEPS))
    _refuse_too_many_steps(steps, moving, remedy)
    return int(steps)


def _wanted_steps(moving: VibratingLinkage, *, beside_free_shaft: bool) -> float:
    """Steps that the fastest moving mode wants, however many."""
    radians = RADIANS_BESIDE_A_FREE_SHAFT if beside_free_shaft else RADIANS_A_STEP
    wanted = max(LEAST_STEPS, moving.fastest * moving.period / radians)
    return float(2 * SHAPE_ANGLES * np.ceil(wanted / (2 * SHAPE_ANGLES)))


def _refuse_too_many_steps(steps: float, moving: VibratingLinkage, remedy: str) -> None:
    """Refuse steps that do not fit into memory."""
    matrices = MATRICES_A_STEP * (2 * moving.size) ** 2
    waves = WAVES_A_STEP * len(moving.conservative.coefficients)
    size = np.dtype(float).itemsize * steps * (matrices + waves)
    frequency = moving.fastest / (2 * np.pi)
    if size > MOST_BYTES:
        raise ComputationError(
            f"a turn at crank speed {CRANK_SPEED} takes {steps:.7g} steps, since the fastest mode "
            f"vibrates at {frequency:.3g} Hz; they need some {size / 1e9:.2g} GB, and at most "
            f"{MOST_BYTES / 1e9:g} are taken: ask for {remedy}",
            crank_speed=moving.crank_speed,
        )
