"""Request of a map of natural frequencies."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from flexmech.analyses.requests import check_list, in_radians
from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import InputError
from flexmech.solvers.formulation import Formulation
from flexmech.validation import POSITIVE, check_flag, check_instance, check_number, checked_array

FORMULATION = Formulation()
# Each with the mode shape of three links at nine stations, 1 kB.
MOST_FREQUENCIES = 4_000_000
# Every 5 deg of a turn, each a picture of its own.
MOST_SHAPES = 72


@dataclass(frozen=True, repr=False)
class FrequencyRequest:
    """A map of natural frequencies over crank angles and speeds.

    Parameters
    ----------
    crank_angles : ndarray, shape (A,)
        Increasing, rad.
    crank_speeds : ndarray, shape (S,)
        rad/s.
    formulation : Formulation
    speed_effect : bool or "fastest"
        Whether to split the effect of speed by term, with the first engine: at every speed, or
        at the greatest alone.
    shown_unit : str
        In which results speak of crank speeds, such as ``"rpm"``.
    tolerance : float, optional
        Estimated relative error of the frequencies by the mesh up to which the elements given
        are refined; None keeps them.
    shapes_at : ndarray, optional
        Crank angles in rad at which mode shapes are wanted, of the first engine.
    smooth : bool or ndarray
        Whether to solve for the first engine between the crank angles too, where lines bend; or
        at which crank angles in rad.

    Raises
    ------
    InputError
        If angles do not increase or are degrees, a value is not finite, or a speed repeats.

    Examples
    --------
    >>> flexmech.analyses.FrequencyRequest(np.radians([0, 90]), [0, 10, 20])
    <FrequencyRequest: 2 crank angles, 3 crank speeds, 4 modes, equilibrium>
    """

    crank_angles: FloatArray
    crank_speeds: FloatArray
    formulation: Formulation = FORMULATION
    speed_effect: bool | Literal["fastest"] = False
    shown_unit: str = "rad/s"
    tolerance: float | None = None
    shapes_at: FloatArray = field(default_factory=lambda: np.zeros(0))
    smooth: bool | FloatArray = False

    def __post_init__(self) -> None:
        check_instance(self.formulation, Formulation, "formulation", "give flexmech.Formulation()")
        if not isinstance(self.speed_effect, str):
            check_flag(self.speed_effect, "speed_effect")
        angles = in_radians("crank_angles", self.crank_angles)
        speeds = checked_array(self.crank_speeds, "crank_speeds", "rad/s")
        check_list("crank_angles", angles, increasing=True)
        check_list("crank_speeds", speeds, one="speed")
        object.__setattr__(self, "crank_angles", angles)
        object.__setattr__(self, "crank_speeds", speeds)
        shapes_at = np.atleast_1d(in_radians("shapes_at", self.shapes_at))
        if shapes_at.ndim != 1 or len(shapes_at) > MOST_SHAPES:
            raise InputError(f"shapes_at must be a list of {MOST_SHAPES} crank angles at most")
        object.__setattr__(self, "shapes_at", np.unique(shapes_at))
        if self.tolerance is not None:
            check_number(self.tolerance, "tolerance", bounds=POSITIVE)
        asked = len(angles) * len(speeds) * self.formulation.modes
        if asked > MOST_FREQUENCIES:
            raise InputError(
                f"{len(angles)} crank_angles at {len(speeds)} crank_speeds with "
                f"{self.formulation.modes} modes are {asked:.3g} frequencies; more than "
                f"{MOST_FREQUENCIES:.3g} do not fit into memory with their mode shapes"
            )

    def __repr__(self) -> str:
        return (
            f"<FrequencyRequest: {len(self.crank_angles)} crank angles, {len(self.crank_speeds)} "
            f"crank speeds, {self.formulation.modes} modes, {self.formulation.prestress}>"
        )

    @property
    def split_speeds(self) -> IntArray:
        """Numbers of the crank speeds at which the effect of speed is to be split by term."""
        if not self.speed_effect or not self.crank_speeds.any():
            return np.zeros(0, dtype=np.intp)
        if self.speed_effect == "fastest":
            return np.array([np.argmax(np.abs(self.crank_speeds))])
        return np.arange(len(self.crank_speeds))

    @property
    def full_turn(self) -> bool:
        """Whether the angles cover a full turn, so that the last leads back to the first."""
        if len(self.crank_angles) < 3:
            return False
        covered = self.crank_angles[-1] - self.crank_angles[0]
        step = float(np.max(np.diff(self.crank_angles)))
        return bool(2 * np.pi - 1.001 * step <= covered <= 2 * np.pi + 1e-9)
