"""A request for frequencies, and the linear systems of one engine over it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flexmech.analyses.reduction import CheckedModes, accurate_reduction
from flexmech.analyses.running_states import RunningStates
from flexmech.errors import InputError
from flexmech.linear_system import Engine, LinearSystem, Prestress, RotationTerms
from flexmech.types import FloatArray, IntArray

__all__ = ["SPARE_MODES", "FrequencyRequest", "MapPrestress", "Mapping"]

MapPrestress = Prestress | Literal["trajectory"]

# Modes followed besides those asked for, so that a branch may dip out and come back.
SPARE_MODES = 2


@dataclass(frozen=True)
class FrequencyRequest:
    """What a map of frequencies is asked to cover.

    Parameters
    ----------
    crank_angles : ndarray, shape (A,)
        Increasing, rad.
    crank_speeds : ndarray, shape (S,)
        rad/s.
    modes : int
    prestress : {"none", "axial", "equilibrium", "trajectory"}
        ``trajectory``: in the states of the simulated, settled motion.
    rotation_terms : bool or RotationTerms

    Raises
    ------
    InputError
        If angles do not increase, a value is not finite, a speed repeats, or no mode is
        asked for.
    """

    crank_angles: FloatArray
    crank_speeds: FloatArray
    modes: int
    prestress: MapPrestress
    rotation_terms: bool | RotationTerms

    def __post_init__(self) -> None:
        for name in ("crank_angles", "crank_speeds"):
            values = getattr(self, name)
            if values.ndim != 1 or not len(values):
                raise InputError(f"{name} must be a list of one value or more")
            if not np.all(np.isfinite(values)):
                raise InputError(f"{name} must be finite numbers, got {values}")
        if np.any(np.diff(self.crank_angles) <= 0):
            raise InputError("crank_angles must increase; sort them and leave out repetitions")
        if len(np.unique(self.crank_speeds)) != len(self.crank_speeds):
            raise InputError("crank_speeds repeats a speed; give each one once")
        if self.modes < 1:
            raise InputError(f"modes must be 1 or more, got {self.modes}")

    @property
    def quasi_static_prestress(self) -> Prestress:
        """The level nearest to the one asked for that needs no simulation."""
        return "equilibrium" if self.prestress == "trajectory" else self.prestress

    @property
    def full_turn(self) -> bool:
        """Whether the angles cover a full turn, so that the last leads back to the first."""
        if len(self.crank_angles) < 3:
            return False
        covered = self.crank_angles[-1] - self.crank_angles[0]
        step = float(np.max(np.diff(self.crank_angles)))
        return bool(2 * np.pi - 1.001 * step <= covered <= 2 * np.pi + 1e-9)


class Mapping:
    """Linear systems of one engine over a request, batch by batch, all reduced alike.

    Parameters
    ----------
    engine : Engine
    request : FrequencyRequest
    detail : float
        How many component modes to take; :meth:`check` settles it by their error.
    """

    def __init__(self, engine: Engine, request: FrequencyRequest, detail: float = 1.0) -> None:
        self.engine = engine
        self.request = request
        self.detail = detail
        self._running: dict[float, RunningStates] = {}
        motion = engine.mechanism.linkage.motion(request.crank_angles, 1.0)
        self._speed_ratio = float(np.abs(motion.angular_velocity).max())

    def systems(self, crank_speed: float) -> Iterator[LinearSystem]:
        """Systems along the crank angles, a batch at a time."""
        angles, size = self.request.crank_angles, self.engine.batch_size
        for start in range(0, len(angles), size):
            batch = angles[start : start + size]
            yield self._system(self.engine, self.detail, batch, crank_speed)

    def check(self, crank_speed: float, where: IntArray) -> CheckedModes:
        """Modes at some crank angles; settles how many component modes the map takes.

        Parameters
        ----------
        crank_speed : float
        where : ndarray of int
            Indices of the check angles.

        Returns
        -------
        CheckedModes
        """
        angles = self.request.crank_angles[where]
        checked = accurate_reduction(
            self.engine,
            lambda engine, detail: self._system(engine, detail, angles, crank_speed),
            self.request.modes,
            SPARE_MODES,
        )
        self.engine, self.detail = checked.engine, checked.detail
        return checked

    def _system(
        self, engine: Engine, detail: float, crank_angles: FloatArray, crank_speed: float
    ) -> LinearSystem:
        return engine.linear_system(
            crank_angles,
            crank_speed,
            prestress=self.request.quasi_static_prestress,
            running=self.states(crank_angles, crank_speed),
            rotation_terms=self.request.rotation_terms,
            modes=self.request.modes,
            fastest=self._speed_ratio * abs(crank_speed),
            detail=detail,
        )

    def states(self, crank_angles: FloatArray, crank_speed: float) -> list[FloatArray] | None:
        """Running states where they are asked for; at rest there is nothing to run.

        Parameters
        ----------
        crank_angles : ndarray, shape (B,)
        crank_speed : float

        Returns
        -------
        list of ndarray, shape (B, n_link), or None
            Elastic displacements to linearize about in place of the prestress.
        """
        if self.request.prestress != "trajectory" or not crank_speed:
            return None
        if crank_speed not in self._running:
            self._running[crank_speed] = RunningStates.of(self.engine, crank_speed)
        return self._running[crank_speed].at(crank_angles, crank_speed)
