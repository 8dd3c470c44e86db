"""Runs of the linear or stretching links of a linkage that is struck on the way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.choices import LinkDirection
from flexmech.dynamical_systems import HalfSinePulse
from flexmech.linear_system import LinkPoint, displacement_row
from flexmech.time_domain.driven_linkage import DrivenLinkage
from flexmech.time_domain.linear_run import BLOCK_STEPS, refuse_divergence, start_state
from flexmech.time_domain.marching import marching
from flexmech.time_domain.state import VibrationState
from flexmech.types import FloatArray


class StruckLinkage:
    """A driven linkage with a hammer on one of its points and an eye on another.

    What the time steps of a turn need is solved once, for all runs.

    Parameters
    ----------
    linkage : DrivenLinkage
        At constant crank speed.
    step : float
        In s.
    hit, seen : LinkPoint
        Where the impacts act, and where the displacement is read.
    direction : {"transverse", "axial"}
        Of both, in the axes of their links' frames.

    Raises
    ------
    InputError
        If the linkage has no such link, or its shaft is free.
    """

    def __init__(
        self,
        linkage: DrivenLinkage,
        step: float,
        hit: LinkPoint,
        seen: LinkPoint,
        direction: LinkDirection,
    ) -> None:
        linkage.engine.require_prescribed_shaft("a run with impacts")
        self._linkage, self._step = linkage, step
        topology = linkage.frames.topology
        struck, self._place = hit.index(topology), seen.index(topology)
        self._row = displacement_row(linkage.links[self._place], seen.fraction, direction)
        load = [np.zeros(link.size) for link in linkage.links]
        load[struck] = displacement_row(linkage.links[struck], hit.fraction, direction)
        self._march = marching(linkage, step, load)

    def run(
        self, start: VibrationState, steps: int, pulses: Sequence[HalfSinePulse] = ()
    ) -> FloatArray:
        """Displacement of the point at every step of a run.

        Parameters
        ----------
        start : VibrationState
            Position and velocity at time zero, (n,); the acceleration follows.
        steps : int
        pulses : sequence of HalfSinePulse
            Which act besides the loads of the motion.

        Returns
        -------
        ndarray, shape (steps + 1,)
            In m, from the undeformed link.

        Raises
        ------
        ComputationError
            If displacements grow beyond all bounds; names the time and the crank angle.
        """
        linkage, march = self._linkage, self._march
        march.restart()
        state = start_state(linkage, start.position, start.velocity)
        whole = march.stride * -(-steps // march.stride)
        found = np.empty(whole + 1)
        for done in range(0, whole, BLOCK_STEPS):
            count = min(BLOCK_STEPS, whole - done)
            time = self._step * np.arange(done, done + count + 1, dtype=float)
            force = np.zeros(len(time)) + sum(pulse.force(time) for pulse in pulses)
            with np.errstate(over="ignore", invalid="ignore"):
                history, following = march.on(time, state, force)
            refuse_divergence(linkage, time, history)
            coordinates = following.expanded(history)
            moved = linkage.frames.link_motion(linkage.motion(time), *coordinates)
            found[done : done + count + 1] = moved[self._place][0] @ self._row
            state = history[-1]
        return found[: steps + 1]
