"""Free parameters of a fit, by their names, and the engine with values of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from flexmech.analyses.comparison.fit import Parameter
from flexmech.analyses.damping_ratios import with_damping_times
from flexmech.errors import InputError, suggestion
from flexmech.linear_system import Engine
from flexmech.sections import stiffened_section

DAMPING, STIFFNESS, OFFSET, GAIN, NOTHING = "damping", "stiffness", "offset", "gain", "none"
# Crank angle of a record's first sample, where the record does not tell it.
START_ANGLE = "start_angle"
# What a computed record is linear in, and the factor where it is not fitted.
LINEAR = {GAIN: 1.0, OFFSET: 0.0}
# Damping ratio of the first mode that the unit of a fitted damping time stands for.
USUAL_RATIO = 0.005
# Damping ratios from which the fit may begin, of steel to polymers.
RATIOS = (0.001, 0.003, 0.01, 0.03)
# Crank angles at which a record may begin: every 2.5 deg, a fraction of the first mode's period.
_ANGLES = 144
# Part of the model's stiffness below which no measured link is.
_LEAST_STIFFNESS = 0.05
# Usual changes, which scale the fit's steps: of a stiffness or a gain, and of an angle in deg.
_STIFFNESS_STEP, _GAIN_STEP, _ANGLE_STEP = 0.1, 0.1, 10.0


def fitted_names(names: Sequence[str], links: Sequence[str]) -> tuple[str, ...]:
    """Read what is asked to be fitted.

    Parameters
    ----------
    names : sequence of str
        Such as ``("damping", "damping:coupler", "stiffness:coupler")``. ``damping`` is one
        Kelvin-Voigt time of all links that have none of their own here, ``offset`` the gauge's
        zero, ``gain`` a factor on the computed record.
    links : sequence of str
        Names of the linkage's links.

    Returns
    -------
    tuple of str
        In the order of the parameters; empty for ``("none",)``.

    Raises
    ------
    InputError
        If a name is unknown or stands twice, or ``none`` stands beside others.
    """
    own = [f"{what}:{link}" for what in (DAMPING, STIFFNESS) for link in links]
    known = [DAMPING, *own, OFFSET, GAIN, NOTHING]
    for name in names:
        if name not in known:
            raise InputError(f"fit: {name!r} cannot be fitted; {suggestion(name, known)}")
        if names.count(name) > 1:
            raise InputError(f"fit: {name!r} stands twice; name each once")
    if NOTHING in names and len(names) > 1:
        raise InputError(f"fit: {NOTHING!r} stands beside others; write it alone, or leave it out")
    if DAMPING in names and all(f"{DAMPING}:{link}" in names for link in links):
        raise InputError(
            "fit: every link has a damping time of its own, and none is left for 'damping'; leave "
            "that out, or one of the links"
        )
    return tuple(name for name in known[:-1] if name in names)


def damping_times(links: Sequence[str], values: Mapping[str, float]) -> dict[str, float]:
    """Damping time in s of each link that has one among values by name.

    Parameters
    ----------
    links : sequence of str
        Names of all links.
    values : mapping of str to float

    Returns
    -------
    dict of str to float
    """
    common = dict.fromkeys(links, values[DAMPING]) if DAMPING in values else {}
    return common | {link: values[key] for link in links if (key := f"{DAMPING}:{link}") in values}


def stiffness_factors(values: Mapping[str, float]) -> dict[str, float]:
    """Stiffness factor of each link that has one among values by name."""
    kinds = {name: name.partition(":") for name in values}
    return {link: values[name] for name, (kind, _, link) in kinds.items() if kind == STIFFNESS}


def fitted_engine(engine: Engine, values: Mapping[str, float]) -> Engine:
    """The engine with damping times and stiffness factors of links; it keeps its element.

    Parameters
    ----------
    engine : Engine
    values : mapping of str to float
        By the names of the parameters. A factor is of the axial, bending and shear stiffness
        together, and of all that the layers of a laminate have.

    Returns
    -------
    Engine
    """
    times = damping_times(engine.mechanism.linkage.topology.link_names, values)
    if times:
        engine = with_damping_times(engine.with_(element=engine.element), times)
    factors = stiffness_factors(values)
    if not factors:
        return engine
    mechanism = engine.mechanism
    sections = {
        name: stiffened_section(section, factors[name]) if name in factors else section
        for name, section in mechanism.sections.items()
    }
    return engine.with_(mechanism=replace(mechanism, sections=sections), element=engine.element)


def free_parameters(
    names: Sequence[str],
    misfit: Callable[[Mapping[str, float]], float],
    unit_time: float,
    unit: str,
    size: float,
    ratios: Sequence[float] = RATIOS,
) -> tuple[Parameter, ...]:
    """Parameters of a fit, from the best of the crank angles and damping times tried.

    Parameters
    ----------
    names : sequence of str
    misfit : callable
        Sum of squares of the residual for values by name.
    unit_time : float
        Kelvin-Voigt time in s that damps the first mode by the usual ratio.
    unit : str
        Of the record.
    size : float
        Of the record's values, the scale of its offset.
    ratios : sequence of float
        Damping ratios of the first mode that are tried.

    Returns
    -------
    tuple of Parameter
    """
    kinds = {
        DAMPING: Parameter("", "s", unit_time, unit_time),
        STIFFNESS: Parameter("", "", 1.0, _STIFFNESS_STEP, _LEAST_STIFFNESS),
        OFFSET: Parameter("", unit, LINEAR[OFFSET], size, linear=True),
        GAIN: Parameter("", "", LINEAR[GAIN], _GAIN_STEP, linear=True),
        START_ANGLE: Parameter("", "deg", 0.0, _ANGLE_STEP),
    }
    found = {name: replace(kinds[name.partition(":")[0]], name=name) for name in names}
    trials = {
        START_ANGLE: (360 / _ANGLES * np.arange(_ANGLES)).tolist(),
        DAMPING: [unit_time * ratio / USUAL_RATIO for ratio in ratios],
    }
    for kind, choices in trials.items():
        which = [name for name in names if name.startswith(kind)]
        if which:
            start = {name: parameter.start for name, parameter in found.items()}
            misfits = [misfit(start | dict.fromkeys(which, choice)) for choice in choices]
            best = choices[int(np.argmin(misfits))]
            found |= {name: replace(found[name], start=best) for name in which}
    return tuple(found.values())
