"""What an engine offers that simulates the nonlinear motion itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, Protocol, get_args, runtime_checkable

from flexmech.linkages import CrankDrive
from flexmech.time_domain.recording import Trajectory
from flexmech.time_domain.state import LinkState
from flexmech.types import FloatArray

__all__ = ["INTEGRATORS", "Integrator", "Simulator"]

Integrator = Literal["trapezoidal", "generalized-alpha"]
INTEGRATORS: tuple[Integrator, ...] = get_args(Integrator)


@runtime_checkable
class Simulator(Protocol):
    """An engine that runs the linkage with large displacements."""

    def simulate(
        self,
        drive: CrankDrive,
        start: LinkState,
        sample_time: FloatArray,
        step: float,
        *,
        integrator: Integrator = "trapezoidal",
        progress: Callable[[int, int], None] | None = None,
    ) -> Trajectory:
        """Run from a state of the links.

        Parameters
        ----------
        drive : CrankDrive
        start : LinkState
            State at time zero.
        sample_time : ndarray, shape (N,)
            Increasing, zero or later, in s.
        step : float
            Time step in s.
        integrator : {"trapezoidal", "generalized-alpha"}
        progress : callable, optional
            Called with the steps done and the steps to do.

        Returns
        -------
        Trajectory

        Raises
        ------
        ComputationError
            If a step does not converge; names its time and the crank angle.
        """
