"""Histories of a run at its samples, and their limit of vanishing steps."""

from __future__ import annotations

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
        energy = EnergyHistory(
            *(getattr(self.energy, field.name)[where] for field in fields(self.energy))
        )
        return replace(
            self,
            time=self.time[where],
            displacement=[q[where] for q in self.displacement],
            rate=[r[where] for r in self.rate],
            joint_force=self.joint_force[where],
            driving_torque=self.driving_torque[where],
            energy=energy,
            shaft=None if self.shaft is None else self.shaft[where],
            frame=None if self.frame is None else self.frame[where],
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

        def limits(fine: Any, coarse: Any) -> list[FloatArray]:
            return [limit(*(getattr(of, f.name) for of in (fine, coarse))) for f in fields(fine)]

        energy, shaft = EnergyHistory(*limits(self.energy, coarser.energy)), None
        if self.shaft is not None:
            shaft = ShaftMotion(*limits(self.shaft, coarser.shaft))
        frame = None
        if self.frame is not None:
            frame = FrameMotion(*limits(self.frame, coarser.frame))
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
            shaft=shaft,
            frame=frame,
        )
