"""States that a linkage passes through while it runs, at any crank angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from flexmech.linear_system import Engine
from flexmech.linkages import CrankDrive
from flexmech.time_domain import DrivenLinkage, simulated_orbit, simulator
from flexmech.types import FloatArray

# The settled motion moves frequencies by a part of what speed does; a step of an eighth of a
# degree makes 1e-3 of the deflection.
STEPS_PER_TURN = 2880
SAMPLES_PER_TURN = 720


@dataclass(frozen=True)
class RunningStates:
    """Elastic displacements along the settled, periodic motion at one crank speed.

    Parameters
    ----------
    displacement : tuple of CubicSpline
        Of each link in its frame, over the angle that the crank has turned by in a turn.
    sense : float
        Of the rotation: 1 counter-clockwise, -1 clockwise.
    """

    displacement: tuple[CubicSpline, ...]
    sense: float

    @classmethod
    def of(cls, engine: Engine, crank_speed: float) -> RunningStates:
        """Simulate the periodic motion of an engine.

        Parameters
        ----------
        engine : Engine
            One that simulates.
        crank_speed : float
            In rad/s, not zero.

        Returns
        -------
        RunningStates

        Raises
        ------
        InputError
            If the engine does not simulate.
        ComputationError
            If no periodic motion is found.
        """
        engine = engine.with_(shaft="prescribed")
        simulating, drive = simulator(engine), CrankDrive(crank_speed)
        turn = drive.revolution_time
        time = turn / SAMPLES_PER_TURN * np.arange(SAMPLES_PER_TURN + 1, dtype=float)
        linkage = DrivenLinkage(engine, drive, "equilibrium", with_energy=False)
        orbit = simulated_orbit(
            linkage,
            STEPS_PER_TURN,
            lambda start: simulating.simulate(drive, start, time, turn / STEPS_PER_TURN),
        )
        angle = np.abs(drive.crank_angle(time))
        splines = []
        for q in orbit.turn.displacement:
            closed = q.copy()
            closed[-1] = closed[0]
            splines.append(CubicSpline(angle, closed, bc_type="periodic"))
        return cls(tuple(splines), float(np.sign(crank_speed)))

    def at(self, crank_angle: FloatArray) -> list[FloatArray]:
        """Displacements of each link at crank angles (A,), shape (A, n_link)."""
        turned = np.mod(self.sense * crank_angle, 2 * np.pi)
        return [np.asarray(spline(turned), dtype=float) for spline in self.displacement]
