"""What an engine offers that simulates the nonlinear motion itself: states, impacts, runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, Self, cast

import numpy as np

from flexmech.choices import LINK_DIRECTIONS, Integrator, LinkDirection
from flexmech.dynamical_systems import HalfSinePulse
from flexmech.errors import InputError
from flexmech.linear_system import Engine, LinkModel, LinkPoint
from flexmech.linkages import CrankDrive, LockedCrank
from flexmech.numbers import check_choice, check_instance
from flexmech.time_domain.recorded_runs.recording import Trajectory
from flexmech.types import FloatArray, StepProgress


@dataclass(frozen=True)
class LinkState:
    """Elastic state of all links at an instant, in the frames of their rigid motion.

    Parameters
    ----------
    displacement, rate : list of ndarray, shape (n_link,)
        Each link's coordinates less those of the undeformed link, and their time
        derivatives in that frame.
    """

    displacement: list[FloatArray]
    rate: list[FloatArray]

    @classmethod
    def rigid(cls, links: Sequence[LinkModel]) -> Self:
        """Undeformed links that move with the velocities of the rigid motion."""
        return cls([np.zeros(link.size) for link in links], [np.zeros(link.size) for link in links])


@dataclass(frozen=True)
class Impact:
    """A pulse on a point of a link, in the axes of the link's rigid frame.

    Parameters
    ----------
    point : LinkPoint
    direction : {"transverse", "axial"}
        Across the link's frame or along it; the force turns with the frame.
    pulse : HalfSinePulse

    Raises
    ------
    InputError
        If one is no such thing.
    """

    point: LinkPoint
    direction: LinkDirection
    pulse: HalfSinePulse

    def __post_init__(self) -> None:
        check_instance(self.point, LinkPoint, "point of an impact", "give a flexmech.LinkPoint")
        check_choice(self.direction, LINK_DIRECTIONS, "direction of an impact")
        check_instance(self.pulse, HalfSinePulse, "pulse of an impact", "give a HalfSinePulse")


class Simulator(Protocol):
    """An engine that runs the linkage with large displacements."""

    def simulate(
        self,
        drive: CrankDrive | LockedCrank,
        start: LinkState,
        sample_time: FloatArray,
        step: float,
        *,
        integrator: Integrator = "trapezoidal",
        progress: StepProgress | None = None,
        band: float | None = None,
        impacts: Sequence[Impact] = (),
    ) -> Trajectory:
        """Run from a state of the links.

        Parameters
        ----------
        drive : CrankDrive or LockedCrank
        start : LinkState
            State at time zero.
        sample_time : ndarray, shape (N,)
            Increasing, zero or later, in s.
        step : float
            Time step in s.
        integrator : {"trapezoidal", "generalized-alpha"}
        progress : callable, optional
            Called with the steps done and the steps to do.
        band : float, optional
            Frequency in Hz up to which joint forces and torque are kept.
        impacts : sequence of Impact
            Pulses on points of links, whose work the energy balance does not know.

        Returns
        -------
        Trajectory

        Raises
        ------
        ComputationError
            If a step does not converge; names its time and the crank angle.
        """

    def point_histories(
        self,
        drive: CrankDrive | LockedCrank,
        start: LinkState,
        points: Sequence[tuple[LinkPoint, LinkDirection]],
        step: float,
        steps: int,
        *,
        impacts: Sequence[Impact] = (),
        progress: StepProgress | None = None,
    ) -> FloatArray:
        """Displacement of points of links at every step of the trapezoidal rule.

        Parameters
        ----------
        drive : CrankDrive or LockedCrank
        start : LinkState
            State at time zero.
        points : sequence of (LinkPoint, {"transverse", "axial"})
        step : float
            In s.
        steps : int
        impacts : sequence of Impact
        progress : callable, optional
            Called with the steps done and the steps to do.

        Returns
        -------
        ndarray, shape (steps + 1, n_points)
            In m, in the frames of the rigid links.
        """


def simulator(engine: Engine) -> Simulator:
    """Take an engine as one that simulates; refuse one that does not."""
    if not engine.simulates:
        raise InputError(
            f"the {engine.name} engine does not simulate the running linkage with large "
            "displacements; use the exudyn engine"
        )
    return cast(Simulator, engine)
