"""Histories of a run at its samples, and their limit of vanishing steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.time_domain.recorded_runs.states import FrameMotion, ShaftMotion


@dataclass(frozen=True)
class EnergyHistory:
    """Energies at the samples in J, each of shape (N,).

    Parameters
    ----------
    kinetic, strain, gravity : ndarray, shape (N,)
    dissipated, drive_work, prestress_work : ndarray, shape (N,)
        Since the start of the run.
    """

    kinetic: FloatArray
    strain: FloatArray
    gravity: FloatArray
    dissipated: FloatArray
    drive_work: FloatArray
    prestress_work: FloatArray

    @property
    def imbalance(self) -> FloatArray:
        """Energy that nothing accounts for, (N,)."""
        stored = self.kinetic + self.strain + self.gravity
        work = self.drive_work - self.dissipated + self.prestress_work
        return np.asarray(stored - stored[0] - work)


@dataclass(frozen=True)
class Trajectory:
    """A run of the linkage at N samples.

    Parameters
    ----------
    time : ndarray, shape (N,)
        In s.
    displacement, rate : list of ndarray, shape (N, n_link)
        As in :class:`flexmech.time_domain.StepBlock`.
    joint_force : ndarray, shape (N, n_joints, 2)
    driving_torque : ndarray, shape (N,)
        Both as far as the band of the recorder lets them through.
    peak_joint_force : ndarray, shape (n_joints,)
    peak_driving_torque : float
        Greatest size of these at any step.
    energy : EnergyHistory
    energy_error : float
        Greatest ``|work of drive and changing prestress - change of kinetic, strain and gravity
        energy - dissipated|`` over all steps, relative to the peak kinetic energy.
    step : float
        Time step in s.
    shaft : ShaftMotion, optional
        Of a shaft that is free.
    frame : FrameMotion, optional
        Of a frame on springs.
    """

    time: FloatArray
    displacement: list[FloatArray]
    rate: list[FloatArray]
    joint_force: FloatArray
    driving_torque: FloatArray
    peak_joint_force: FloatArray
    peak_driving_torque: float
    energy: EnergyHistory
    energy_error: float
    step: float
    shaft: ShaftMotion | None = None
    frame: FrameMotion | None = None

    def __getitem__(self, where: slice) -> Trajectory:
        """The same run at some of the samples."""

        def taken(history: FloatArray) -> FloatArray:
            return np.asarray(history[where])

        return replace(
            self,
            time=taken(self.time),
            displacement=[taken(q) for q in self.displacement],
            rate=[taken(r) for r in self.rate],
            joint_force=taken(self.joint_force),
            driving_torque=taken(self.driving_torque),
            energy=_of_fields(taken, self.energy),
            shaft=_of_fields(taken, self.shaft),
            frame=_of_fields(taken, self.frame),
        )

    def extrapolated(self, coarser: Trajectory, order: int) -> Trajectory:
        """Limit of vanishing steps, by a run with greater ones (Richardson).

        Parameters
        ----------
        coarser : Trajectory
            At the same samples.
        order : int
            Of the method's error.

        Returns
        -------
        Trajectory
            With this run's step. Its energies balance as they do at the samples.
        """
        gain = 1 / ((coarser.step / self.step) ** order - 1)

        def limit(fine: FloatArray, coarse: FloatArray) -> FloatArray:
            return fine + gain * (fine - coarse)

        energy = _of_fields(limit, self.energy, coarser.energy)
        return replace(
            self,
            displacement=list(map(limit, self.displacement, coarser.displacement)),
            rate=list(map(limit, self.rate, coarser.rate)),
            joint_force=limit(self.joint_force, coarser.joint_force),
            driving_torque=limit(self.driving_torque, coarser.driving_torque),
            peak_joint_force=limit(self.peak_joint_force, coarser.peak_joint_force),
            peak_driving_torque=float(
                limit(*map(np.array, (self.peak_driving_torque, coarser.peak_driving_torque)))
            ),
            energy=energy,
            energy_error=float(np.abs(energy.imbalance).max() / energy.kinetic.max()),
            shaft=_of_fields(limit, self.shaft, coarser.shaft),
            frame=_of_fields(limit, self.frame, coarser.frame),
        )


def _of_fields(function: Callable[..., FloatArray], *histories: Any) -> Any:
    """What a function makes of every field of the same histories of some runs; None of none."""
    if histories[0] is None:
        return None
    names = [field.name for field in fields(histories[0])]
    changed = (function(*(getattr(own, name) for own in histories)) for name in names)
    return type(histories[0])(*changed)
