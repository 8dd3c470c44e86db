"""Request of a stability map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.analyses.damping_ratios import DAMPING_RATIO
from flexmech.analyses.requests import check_list
from flexmech.arrays import FloatArray
from flexmech.choices import (
    KEPT_MODES,
    MapPrestress,
    MovingFrame,
)
from flexmech.errors import InputError
from flexmech.solvers.floquet_modes import MOST_STEPS, SHAPE_ANGLES
from flexmech.validation import check_count, check_number, checked_array

# So that half of them, by which the error of the steps is estimated, meet all crank angles at which
# shapes are compared.
LEAST_STEPS = 2 * SHAPE_ANGLES


@dataclass(frozen=True)
class StabilityRequest:
    """Crank speeds of a stability map, and about which motion it is linearized.

    Parameters
    ----------
    crank_speeds : ndarray, shape (S,)
        rad/s, not zero, all of one sign; kept from the slowest to the fastest.
    prestress : {"none", "axial", "equilibrium", "trajectory"}
    frame : {"link", "inertial"}
        Frame of the coordinates. Floquet multipliers are the same in both.
    modes : int
        Natural modes whose Floquet modes are kept.
    steps : int, optional
        Steps of the propagator a turn, a multiple of 16; chosen by the fastest mode where it is
        left out.
    damping_ratio : float, optional
        Z from 0 on and less than 1: the Kelvin-Voigt time of all links is 2 Z/omega_1, with the
        first natural frequency at rest averaged over the turn. Left out: the model's damping.
    shown_unit : str
        In which results speak of crank speeds.

    Raises
    ------
    InputError
        If a speed is zero, not finite, repeats or turns the other way than the first; or another
        value is impossible.

    Examples
    --------
    >>> request = StabilityRequest(np.array([90.0, 80.0]), damping_ratio=0.001)
    >>> request.crank_speeds
    array([80., 90.])
    """

    crank_speeds: FloatArray
    prestress: MapPrestress = "equilibrium"
    frame: MovingFrame = "link"
    modes: int = KEPT_MODES
    steps: int | None = None
    damping_ratio: float | None = None
    shown_unit: str = "rad/s"

    def __post_init__(self) -> None:
        object.__setattr__(self, "crank_speeds", _checked_speeds(self.crank_speeds))
        if self.steps is not None:
            _check_steps(self.steps)
        if self.damping_ratio is not None:
            check_number(self.damping_ratio, "damping_ratio", bounds=DAMPING_RATIO)

    @property
    def ends(self) -> tuple[float, float]:
        """Lowest and highest crank speed in rad/s, between which bands are sought."""
        return float(self.crank_speeds.min()), float(self.crank_speeds.max())


def _checked_speeds(values: FloatArray) -> FloatArray:
    """Crank speeds from the slowest to the fastest."""
    speeds = checked_array(values, "crank_speeds", "rad/s")
    check_list("crank_speeds", speeds, one="speed")
    if not speeds.all():
        raise InputError(
            "crank_speeds holds zero, at which nothing turns and there is no period; begin above it"
        )
    if speeds.min() < 0 < speeds.max():
        raise InputError(
            "crank_speeds turn both ways; modes are followed from slow to fast, so ask for "
            "forward and backward speeds one after the other"
        )
    return np.asarray(speeds[np.argsort(np.abs(speeds))])


def _check_steps(steps: int) -> None:
    check_count(steps, "steps")
    steps = int(steps)
    if not LEAST_STEPS <= steps <= MOST_STEPS or steps % SHAPE_ANGLES:
        near = max(LEAST_STEPS, min(MOST_STEPS, SHAPE_ANGLES * -(-steps // SHAPE_ANGLES)))
        raise InputError(
            f"steps must be a multiple of {SHAPE_ANGLES} from {LEAST_STEPS} to {MOST_STEPS}, got "
            f"{steps}; the nearest above is {near}"
        )
