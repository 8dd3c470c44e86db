"""The parameters of a fit by their names, and from where it begins."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from flexmech.analyses.comparison.fit import Parameter
from flexmech.analyses.comparison.parameters import DAMPING, GAIN, OFFSET, STIFFNESS, Fitted

START_ANGLE = "start_angle"
"""Crank angle of a record's first sample, where the record does not tell it."""
USUAL_RATIO = 0.005
"""Damping ratio of the first mode that the unit of a fitted damping time stands for."""
# Damping ratios from which the fit may begin, and crank angles at which a record may.
RATIOS = (0.001, 0.003, 0.01, 0.03)
ANGLES = 144
# Part of the model's stiffness below which no measured link is, and a usual change of it.
LEAST_STIFFNESS, STIFFNESS_STEP = 0.05, 0.1
ANGLE_STEP = 10.0
GAIN_STEP = 0.1


def named(fitted: Fitted, *, free_angle: bool = False) -> tuple[str, ...]:
    """Names of the parameters in their order."""
    return (
        *((DAMPING,) if fitted.damping else ()),
        *(f"{DAMPING}:{link}" for link in fitted.damped_links),
        *(f"{STIFFNESS}:{link}" for link in fitted.stiff_links),
        *((OFFSET,) if fitted.offset else ()),
        *((GAIN,) if fitted.gain else ()),
        *((START_ANGLE,) if free_angle else ()),
    )


def start_values(
    names: Sequence[str], unit_time: float, misfit: Callable[[Mapping[str, float]], float]
) -> dict[str, float]:
    """Best of the crank angles and damping times tried; the rest as the model has it.

    Parameters
    ----------
    names : sequence of str
    unit_time : float
        Kelvin-Voigt time in s that damps the first mode by the usual ratio.
    misfit : callable
        Sum of squares of the residual for values by name.

    Returns
    -------
    dict of str to float
    """
    others = {STIFFNESS: 1.0, OFFSET: 0.0, GAIN: 1.0, START_ANGLE: 0.0}
    start = {name: others.get(name.partition(":")[0], unit_time) for name in names}

    def tried(choices: Sequence[float], which: Sequence[str]) -> None:
        if which:
            misfits = [misfit(start | dict.fromkeys(which, choice)) for choice in choices]
            start.update(dict.fromkeys(which, choices[int(np.argmin(misfits))]))

    tried((360 / ANGLES * np.arange(ANGLES)).tolist(), [n for n in names if n == START_ANGLE])
    times = [unit_time * ratio / USUAL_RATIO for ratio in RATIOS]
    tried(times, [name for name in names if name.startswith(DAMPING)])
    return start


def parameters_from(
    start: Mapping[str, float], unit_time: float, unit: str = "", size: float = 1.0
) -> tuple[Parameter, ...]:
    """Parameters of a fit.

    Parameters
    ----------
    start : mapping of str to float
        From where each begins.
    unit_time : float
        Scale of damping times in s.
    unit : str
        Of the record.
    size : float
        Of the record's values, the scale of its offset.

    Returns
    -------
    tuple of Parameter
    """

    def parameter(name: str, value: float) -> Parameter:
        kind = name.partition(":")[0]
        if kind == DAMPING:
            return Parameter(name, "s", value, unit_time)
        if kind == STIFFNESS:
            return Parameter(name, "", value, STIFFNESS_STEP, LEAST_STIFFNESS)
        if kind == GAIN:
            return Parameter(name, "", value, GAIN_STEP)
        if kind == OFFSET:
            return Parameter(name, unit, value, size)
        return Parameter(name, "deg", value, ANGLE_STEP)

    return tuple(parameter(name, value) for name, value in start.items())
