"""Linkages that run: deflections over a turn, and the spin-up of an arm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Literal

import numpy as np

from flexmech.analyses import deflections
from flexmech.analyses.response.compute import response
from flexmech.arrays import FloatArray
from flexmech.choices import EngineName
from flexmech.linkages import ConstantSpeed
from flexmech.mechanics import Engine
from flexmech.mechanics.running import DrivenLinkage, LinkState, Trajectory
from flexmech.mechanism import Mechanism
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from flexmech.solvers import linear_run, periodic_state
from flexmech.verification.methods.engines import SLENDER, engine_of_name, example
from flexmech.verification.methods.floating_rod import CRANK_SPEED, END_TIME
from flexmech.verification.methods.stored_tables import stored_table

# A degree of the crank each.
SAMPLES = 360
SPIN_UP = ConstantSpeed(6.0, run_up_time=15.0)
"""Drive of Simo & Vu-Quoc 1986: to 6 rad/s within 15 s."""
# In s: a step of 5 ms, a three-hundredth of the arm's slowest vibration; the speed is steady from
# 15 s on.
SPIN_UP_TIME = np.linspace(0.0, 20.0, 4001)
STEADY_FROM = 16.0


def stored_deflection(*, program: str, every: int) -> FloatArray:
    """Deflection of the aluminium four-bar's coupler in its middle by another program, as stored.

    Parameters
    ----------
    program : {"mbdyn", "opensees"}
    every : int
        In deg of the crank angle.

    Returns
    -------
    ndarray, shape (n,)
        In mm.
    """
    column = stored_table("aluminium_20_rad_s_history")[f"{program}_mm"].dropna()
    return np.asarray(column.to_numpy(dtype=float)[::every])


def running_deflection(
    *,
    model: str,
    engine: EngineName,
    crank_speed: float,
    every: int,
    elements: int = 8,
    most: int = 360,
) -> FloatArray:
    """Deflection of the coupler's middle in the first turn from undeformed links.

    Parameters
    ----------
    model : str
    engine : {"reference", "exudyn"}
    crank_speed : float
        In rad/s.
    every : int
        In deg of the crank angle.
    elements : int
    most : int
        Last crank angle, in deg.

    Returns
    -------
    ndarray, shape (n,)
        In mm.
    """
    chosen = engine_of_name(engine, example(model), elements)
    run = response(
        chosen, ConstantSpeed(crank_speed), revolutions=1, samples=SAMPLES, start="rigid"
    )
    curve = np.asarray(run.dataset["deflection"].isel(engine=0).sel(link="coupler"))
    # A sample is a degree.
    return np.asarray(1e3 * curve[: most + 1 : every])


def _damped(model: str, damping_time: float) -> Mechanism:
    mechanism = example(model)
    sections = mechanism.sections.items()
    return replace(mechanism, sections={k: s.with_damping_time(damping_time) for k, s in sections})


def _turn(drive: ConstantSpeed) -> FloatArray:
    return np.asarray(drive.revolution_time / SAMPLES * np.arange(SAMPLES + 1))


def steady_deflection(
    *,
    model: str,
    damping_time: float,
    crank_speed: float,
    turns: int,
    steps: int,
    links: Sequence[int],
    every: int,
) -> FloatArray:
    """Deflections in the last of some turns of a damped simulation in Exudyn.

    Parameters
    ----------
    model : str
    damping_time : float
        Kelvin-Voigt, of all links, in s.
    crank_speed : float
        In rad/s.
    turns, steps : int
        Number of turns, and time steps in each.
    links : sequence of int
    every : int
        In deg of the crank angle.

    Returns
    -------
    ndarray, shape (n_links, n)
        In mm.
    """
    drive = ConstantSpeed(crank_speed)
    engine = ExudynEngine(_damped(model, damping_time))
    time = (turns - 1) * drive.revolution_time + _turn(drive)
    run = engine.simulate(drive, LinkState.rigid(engine.links), time, drive.revolution_time / steps)
    return _sampled(engine, run, links, every)


def periodic_deflection(
    *,
    model: str,
    damping_time: float,
    crank_speed: float,
    steps: int,
    links: Sequence[int],
    every: int,
) -> FloatArray:
    """Deflections of the periodic motion that the reference engine solves for directly.

    Parameters
    ----------
    model : str
    damping_time : float
        Kelvin-Voigt, of all links, in s.
    crank_speed : float
        In rad/s.
    steps : int
        Time steps a turn.
    links : sequence of int
    every : int
        In deg of the crank angle.

    Returns
    -------
    ndarray, shape (n_links, n)
        In mm.
    """
    drive = ConstantSpeed(crank_speed)
    engine = ReferenceEngine(_damped(model, damping_time))
    linkage = DrivenLinkage(engine, drive, "equilibrium")
    start = periodic_state(linkage, steps)
    run = linear_run(
        linkage, start.position, start.velocity, _turn(drive), drive.revolution_time / steps
    )
    return _sampled(engine, run, links, every)


def _sampled(engine: Engine, run: Trajectory, links: Sequence[int], every: int) -> FloatArray:
    curves = 1e3 * deflections(engine, run.displacement)[::every]
    # The last sample of a turn is the first one of the next.
    return np.asarray(curves[:-1].T[list(links)])


def spin_up_trajectory(engine: Engine, step: float = 0.005) -> Trajectory:
    """Run an arm through the spin-up, by Exudyn's simulation or linearly with axial forces.

    Parameters
    ----------
    engine : Engine
    step : float
        In s.

    Returns
    -------
    Trajectory
        At :data:`SPIN_UP_TIME`.
    """
    if isinstance(engine, ExudynEngine):
        return engine.simulate(SPIN_UP, LinkState.rigid(engine.links), SPIN_UP_TIME, step)
    linkage = DrivenLinkage(engine, SPIN_UP, "axial")
    nothing = np.zeros(linkage.size)
    return linear_run(linkage, nothing, nothing, SPIN_UP_TIME, step)


def _tip(engine: Engine, run: Trajectory) -> FloatArray:
    """Displacement of the arm's tip in its frame; (t, 2), in m."""
    return np.asarray(np.einsum("cn,bn->bc", engine.links[0].shape[-1], run.displacement[0]))


@cache
def _tip_across(model: str, engine: EngineName, elements: int, step: float) -> FloatArray:
    """Deflection of the tip in m at :data:`SPIN_UP_TIME`; two cases ask for one run."""
    chosen = engine_of_name(engine, example(model), elements)
    return _tip(chosen, spin_up_trajectory(chosen, step))[:, 1]


def spin_up_least_deflection(
    *,
    model: str,
    engine: EngineName,
    elements: int,
    quantity: Literal["deflection", "time"],
    step: float = 0.005,
) -> FloatArray:
    """Least deflection of the arm's tip during the spin-up, or its time.

    Parameters
    ----------
    model : str
    engine : {"reference", "exudyn"}
    elements : int
    quantity : {"deflection", "time"}
    step : float
        In s.

    Returns
    -------
    ndarray, shape (1,)
        In m or s.
    """
    across = _tip_across(model, engine, elements, step)
    least = across.argmin()
    return np.array([(across if quantity == "deflection" else SPIN_UP_TIME)[least]])


def spin_up_extension(
    *, model: str, engine: EngineName, elements: int, step: float = 0.005
) -> FloatArray:
    """Mean extension of the arm at its steady speed.

    Parameters
    ----------
    model : str
    engine : {"reference", "exudyn"}
    elements : int
    step : float
        In s.

    Returns
    -------
    ndarray, shape (1,)
        In m.
    """
    chosen = engine_of_name(engine, example(model), elements, component_modes=False)
    along = _tip(chosen, spin_up_trajectory(chosen, step))[SPIN_UP_TIME > STEADY_FROM, 0]
    return np.array([along.mean()])


def running_rod_peak(*, engine: EngineName, elements: int, step: float) -> FloatArray:
    """Greatest deflection of the rod's middle in an engine's run of Simeon's slider-crank.

    Parameters
    ----------
    engine : {"reference", "exudyn"}
    elements : int
    step : float
        In s.

    Returns
    -------
    ndarray, shape (1,)
        In m.
    """
    chosen = engine_of_name(engine, example("slider_crank"), elements, element=SLENDER[engine])
    turns = END_TIME * CRANK_SPEED / (2 * np.pi)
    drive = ConstantSpeed(CRANK_SPEED)
    run = response(chosen, drive, turns, samples=1000, start="equilibrium", step=step)
    found = run.dataset["deflection"].isel(engine=0).sel(link="rod")
    return np.array([float(np.abs(found).max())])
