"""Slider-cranks that run or whose shaft is free."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmech.analyses import natural_frequencies, solve_modes
from flexmech.analyses.response import ResponseRequest, response
from flexmech.choices import EngineName
from flexmech.linkages import CrankDrive
from flexmech.types import FloatArray
from flexmech.verification.methods.engines import SLENDER, engine_of_name, example
from flexmech.verification.methods.floating_rod import CRANK_SPEED, END_TIME, FloatingRod

FREE_SHAFT = "slider_crank_free_shaft"


def rod_peak(*, order: int) -> FloatArray:
    """Greatest first sine of the rod of Simeon's slider-crank, by few functions.

    Parameters
    ----------
    order : {3, 4}
        Of the strain energy in which tension and slopes meet.

    Returns
    -------
    ndarray, shape (2,)
        In m, and its time in s.
    """
    rod = FloatingRod.rich() if order == 4 else FloatingRod.of_the_test_set(order=order)
    time, q = rod.run(tolerance=1e-4)
    size = np.abs(q[0])
    return np.array([size.max(), time[size.argmax()]])


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
    request = ResponseRequest(
        CrankDrive(CRANK_SPEED), turns, samples=1000, start="equilibrium", step=step
    )
    found = response(chosen, request).dataset["deflection"].isel(engine=0).sel(link="rod")
    return np.array([float(np.abs(found).max())])


def free_shaft_frequencies(
    *, engine: EngineName, elements: int, crank_angles: Sequence[float], modes: int
) -> FloatArray:
    """Natural frequencies of the slider-crank with a free shaft, at rest, without damping.

    Parameters
    ----------
    engine : {"reference", "exudyn"}
    elements : int
    crank_angles : sequence of float
        In deg.
    modes : int
        Above the free motion.

    Returns
    -------
    ndarray, shape (n_angles, modes)
        In Hz.
    """
    damped = example(FREE_SHAFT)
    sections = {name: section.with_damping_time(0.0) for name, section in damped.sections.items()}
    chosen = engine_of_name(
        engine, replace(damped, sections=sections), elements, element=SLENDER[engine], shaft="free"
    )
    return natural_frequencies(chosen, np.radians(crank_angles), modes=modes)


def free_shaft_decay_rates(
    *, engine: EngineName, elements: int, crank_angles: Sequence[float]
) -> FloatArray:
    """Least and greatest decay rate of the first two bending modes over crank angles.

    Parameters
    ----------
    engine : {"reference", "exudyn"}
    elements : int
    crank_angles : sequence of float
        In deg.

    Returns
    -------
    ndarray, shape (2, 2)
        In 1/s, by mode; the least first.
    """
    chosen = engine_of_name(
        engine,
        example(FREE_SHAFT),
        elements,
        element=SLENDER[engine],
        shaft="free",
        component_modes=False,
    )
    system = chosen.linear_system(np.radians(crank_angles))
    decay = -solve_modes(system, 2).eigenvalues.real
    return np.stack([decay.min(axis=0), decay.max(axis=0)], axis=1)
