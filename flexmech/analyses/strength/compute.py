"""Strength of a mechanism's links under the loads of its motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import xarray as xr

from flexmech.analyses.datasets import origin, with_units
from flexmech.analyses.remarks import environment_lines
from flexmech.analyses.requests import Engines, engines_of
from flexmech.analyses.strength.dataset import margins, strength_dataset
from flexmech.analyses.strength.forces import (
    Cuts,
    InternalForces,
    forces_over_the_turn,
    internal_forces,
)
from flexmech.analyses.strength.judged_mechanism import JudgedMechanism
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.analyses.strength.result import Strength
from flexmech.analyses.strength.running import Runs
from flexmech.analyses.strength.speed_search import search_speed
from flexmech.arrays import FloatArray, LabelledProgress, silent
from flexmech.errors import InputError
from flexmech.linear_system import Engine, checked_mechanism
from flexmech.mechanism import Mechanism, drawing

RIGID = "rigid"
"""In place of an engine: the links move as rigid ones."""


def strength(
    engines: Engines,
    speed: StrengthRequest | float | None = None,
    *,
    speed_unit: str | None = None,
    progress: LabelledProgress | None = None,
) -> Strength:
    """Where the links would break, how, and by what factor loads and speed may rise.

    The loads are the internal forces of the rigid linkage in its steady motion, or of elastic links
    that run. Stresses of cure, heat and moisture stay; the load factor multiplies the others.

    Parameters
    ----------
    engines : Engine, Mechanism or sequence of them
        All of one mechanism, dry and at its reference temperature. Quasi-static loads are those of
        the mechanism alone, whatever the engines.
    speed : float or StrengthRequest, optional
        Crank speed in ``speed_unit``, over a turn in steps of five degrees, or all that can be
        asked for. Left out: the greatest speed at which the mechanism operates.
    speed_unit : str, optional
        Unit of the speed, such as ``"rpm"``.
    progress : callable, optional
        Called with a label, the steps done and the steps to do, where engines run.

    Returns
    -------
    Strength

    Raises
    ------
    InputError
        If no link's layers are known, a strength that the criterion needs is not stated, or as
        :func:`flexmech.kinematics` or :func:`flexmech.response`.
    ComputationError
        If a run diverges or does not converge.

    Examples
    --------
    >>> aluminium = flexmech.Material(70e9, 2700.0, yield_strength=240e6)
    >>> section = flexmech.BeamSection.rectangle(aluminium, 10e-3, 20e-3)
    >>> arm = flexmech.Mechanism(flexmech.RotatingArm(0.5), {"arm": section})
    >>> found = flexmech.strength(arm, 100.0)
    >>> float(found.dataset["margin_speed_factor"][0].round(2))  # at rho (omega L)^2 / 2 = 240 MPa
    8.43
    """
    first = engines[0] if isinstance(engines, Sequence) and engines else engines
    own = first.mechanism if isinstance(first, Engine) else first
    dry = checked_mechanism(own)
    if not isinstance(speed, StrengthRequest):
        request = StrengthRequest(crank_speed=speed, speed_unit=speed_unit)
    elif speed_unit is not None:
        raise InputError("speed_unit: the request has its own; give it there")
    else:
        request = speed
    judged = JudgedMechanism.of(dry, request)
    wet, turning = judged.mechanism, request.speed_of(dry)
    attributes: dict[str, str] = {}
    if request.source == "quasi-static":
        angles, cuts = request.crank_angles, judged.cuts
        forces = _all_forces(wet, angles, turning, cuts)
        found = judged.judge(forces, _static_forces(wet, angles, turning, cuts))
        dataset = strength_dataset(wet, RIGID, angles, forces, found)
        dataset = dataset.assign(margins(dataset))
    else:
        dataset, attributes = _by_engines(
            judged, engines_of(engines), request, turning, progress or silent
        )
    parts = dataset["margin_part"].values.tolist()
    return Strength(
        with_units(dataset, "strength").assign_attrs(
            **origin(dry),
            drawing=drawing(wet, float(dataset["margin_crank_angle"][0])),
            source_of_loads=request.source,
            crank_speed=turning,
            speed_unit=request.shown_unit(dry),
            environment_lines="\n".join(environment_lines(dry, request.environment)),
            not_judged=", ".join(name for name in judged.cuts if name not in parts),
            cure_not_counted=", ".join(judged.without_cure),
            **attributes,
        )
    )


def _by_engines(
    judged: JudgedMechanism,
    engines: list[Engine],
    request: StrengthRequest,
    speed: float,
    report: LabelledProgress,
) -> tuple[xr.Dataset, dict[str, str]]:
    """What runs of engines make of the links, and what is to be said of them."""
    runs = Runs.of(engines, request, speed)
    each = []
    for engine in runs.engines:
        forces = runs.forces(engine, judged.cuts, report)
        found = judged.judge(forces)
        of_engine = engine.name, runs.crank_angles, forces, found
        each.append(strength_dataset(judged.mechanism, *of_engine))
    dataset = xr.concat(
        each, "engine", data_vars="minimal", coords="minimal", compat="override", join="override"
    )
    dataset = dataset.assign(margins(dataset))
    if not request.search_speed:
        return dataset, runs.attributes

    def least(factor: float) -> dict[str, float]:
        faster = Runs.of(engines[:1], request, factor * speed)
        found = judged.judge(faster.forces(faster.engines[0], judged.cuts, report))
        return {name: float(one.load_factor.min()) for name, one in found.items()}

    search = search_speed(least, float(dataset["margin_load_factor"][0]))
    first = dataset["margin_part"] == search.first
    dataset = dataset.assign(
        margin_speed_factor=dataset["margin_speed_factor"].where(~first, search.speed_factor),
        searched_speed_factor=("search", search.factor),
        searched_load_factor=("search", search.load_factor),
        searched_part=("search", search.part),
    )
    return dataset, runs.attributes | {"search_note": search.note}


def _all_forces(
    mechanism: Mechanism, angles: FloatArray, speed: float, cuts: Mapping[str, Cuts]
) -> dict[str, InternalForces]:
    found = forces_over_the_turn(mechanism, angles, speed)
    return {
        name: internal_forces(found, number, cuts[name])
        for number, name in enumerate(mechanism.linkage.topology.link_names)
    }


def _static_forces(
    mechanism: Mechanism, angles: FloatArray, speed: float, cuts: Mapping[str, Cuts]
) -> dict[str, InternalForces] | None:
    """What is left of the loads at rest; None where the rest does not grow with speed squared."""
    damped = any(spring.damping for spring in mechanism.springs)
    damped |= any(spring.torsional_damping for spring in mechanism.joint_springs)
    timed = any(load.over == "time" for load in mechanism.loads)
    if not speed or damped or timed:
        return None
    return _all_forces(mechanism, angles, 0.0, cuts)
