"""A run of the linear or stretching links of a linkage that is struck on the way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.choices import LinkDirection
from flexmech.errors import InputError
from flexmech.linear_system import LinkPoint, displacement_row
from flexmech.time_domain.driven_linkage import DrivenLinkage
from flexmech.time_domain.linear_run import BLOCK_STEPS, march_on, refuse_divergence, start_state
from flexmech.time_domain.pulse import Impact
from flexmech.time_domain.state import VibrationState
from flexmech.time_domain.step_table import StepTable
from flexmech.time_domain.stretch_march import Course
from flexmech.types import FloatArray

__all__ = ["struck_run"]


def struck_run(
    linkage: DrivenLinkage,
    start: VibrationState,
    step: float,
    steps: int,
    impacts: Sequence[Impact],
    seen: LinkPoint,
    direction: LinkDirection,
) -> FloatArray:
    """Displacement of a point at every step of a run by the trapezoidal rule.

    Parameters
    ----------
    linkage : DrivenLinkage
        At constant crank speed.
    start : VibrationState
        Position and velocity at time zero, (n,); the acceleration follows.
    step : float
        In s.
    steps : int
    impacts : sequence of Impact
        Which act besides the loads of the motion, all on the same point; none leaves them alone.
    seen : LinkPoint
    direction : {"transverse", "axial"}
        In which the displacement is read, in the axes of the point's link.

    Returns
    -------
    ndarray, shape (steps + 1,)
        In m, from the undeformed link.

    Raises
    ------
    InputError
        If the linkage has no such link, or the impacts are on several points.
    ComputationError
        If displacements grow beyond all bounds; names the time and the crank angle.
    """
    if len({(impact.point, impact.direction) for impact in impacts}) > 1:
        raise InputError("the impacts of a run must all be on one point and in one direction")
    place = seen.index(linkage.frames.topology)
    row = displacement_row(linkage.links[place], seen.fraction, direction)
    load = _unit_load(linkage, impacts[0]) if impacts else None
    table, course = StepTable(linkage, step, load), Course()
    state = start_state(linkage, start.position, start.velocity)
    found = np.empty(steps + 1)
    for done in range(0, steps, BLOCK_STEPS):
        count = min(BLOCK_STEPS, steps - done)
        time = step * np.arange(done, done + count + 1, dtype=float)
        force = np.zeros(len(time)) + sum(impact.pulse.force(time) for impact in impacts)
        with np.errstate(over="ignore", invalid="ignore"):
            history, following, course = march_on(linkage, table, time, state, course, force)
        refuse_divergence(linkage, time, history)
        coordinates = following.expanded(history)
        moved = linkage.frames.link_motion(linkage.motion(time), *coordinates)[place][0]
        found[done : done + count + 1] = moved @ row
        state = history[-1]
    return found


def _unit_load(linkage: DrivenLinkage, impact: Impact) -> list[FloatArray]:
    """Forces on the reduced links, (n_link,) each, of 1 N on the impact's point."""
    hit = impact.point.index(linkage.frames.topology)
    load = [np.zeros(link.size) for link in linkage.links]
    load[hit] = displacement_row(linkage.links[hit], impact.point.fraction, impact.direction)
    return load
