"""Strength of a mechanism's links and pins under the loads of its motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import origin, with_units
from flexmech.analyses.digits import percent
from flexmech.analyses.remarks import environment_lines
from flexmech.analyses.requests import Engines, engines_of
from flexmech.analyses.strength.dataset import pin_variables, strength_dataset
from flexmech.analyses.strength.equilibria import Equilibria
from flexmech.analyses.strength.forces import Cuts, forces_over_the_turn, internal_forces
from flexmech.analyses.strength.joint_loads import JointLoads, LoadsOfTurn
from flexmech.analyses.strength.judged_mechanism import JudgedMechanism
from flexmech.analyses.strength.margins import (
    PinFailure,
    failures_of,
    fatigue_margins,
    link_margins,
    margin_names,
    margin_variables,
    pin_margins,
    weakest_checks,
)
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.analyses.strength.result import Strength
from flexmech.analyses.strength.running import Runs
from flexmech.analyses.strength.speed_search import search_roots, search_speed
from flexmech.analyses.strength.words import straight_line
from flexmech.arrays import FloatArray, LabelledProgress, silent
from flexmech.errors import InputError
from flexmech.linear_system import Engine, checked_mechanism
from flexmech.mechanism import Mechanism, drawing, require_standing_frame

# Crank angles of equilibria at other speeds: a turn in steps of five degrees, for speed alone.
MOST_SEARCHED = 73
RIGID = "rigid"
"""In place of an engine: the links are taken as rigid."""


def strength(
    engines: Engines,
    speed: StrengthRequest | float | None = None,
    *,
    speed_unit: str | None = None,
    progress: LabelledProgress | None = None,
) -> Strength:
    """Where links and pins would break, how, and by what factor loads and speed may rise.

    The loads are the internal and joint forces of links that bend at rest in their frames, that
    vibrate, or that are taken as rigid. Stresses of cure, heat and moisture stay; the load factor
    multiplies the others.

    Parameters
    ----------
    engines : Engine, Mechanism or sequence of them
        All of one mechanism, dry and at its reference temperature. Loads of rigid links are those
        of the mechanism alone, whatever the engines.
    speed : float or StrengthRequest, optional
        Crank speed in ``speed_unit``, over a turn in steps of five degrees, or all that can be
        asked for. Left out: the greatest speed at which the mechanism operates.
    speed_unit : str, optional
        Unit of the speed, such as ``"rpm"``.
    progress : callable, optional
        Called with a label, the steps done and the steps to do, where engines compute.

    Returns
    -------
    Strength

    Raises
    ------
    InputError
        If no link's layers are known, a strength that the criterion needs is not stated, or as
        :func:`flexmech.kinematics` or :func:`flexmech.response`.
    ComputationError
        If an equilibrium or a run does not converge.

    Examples
    --------
    >>> aluminium = flexmech.Material(70e9, 2700.0, yield_strength=240e6)
    >>> section = flexmech.BeamSection.rectangle(aluminium, 10e-3, 20e-3)
    >>> arm = flexmech.Mechanism(flexmech.RotatingArm(0.5), {"arm": section})
    >>> found = flexmech.strength(arm, 100.0)
    >>> float(found.dataset["margin_speed_factor"][0].round(1))  # at rho (omega L)^2 / 2 = 240 MPa
    8.4
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
    require_standing_frame(dry.frame, "the strength of links")
    judged = JudgedMechanism.of(dry, request)
    wet, turning = judged.mechanism, request.speed_of(dry)
    rigid = all(link.rigid for link in wet.linkage.topology.links)
    source = "rigid" if rigid and request.source == "quasi-static" else request.source
    attributes: dict[str, str] = {}
    if source == "rigid":
        dataset = _of_rigid_links(judged, request.crank_angles, turning)
    else:
        dataset, attributes = _by_engines(
            judged, engines_of(engines), request, turning, progress or silent
        )
    if source == "quasi-static":
        straight = _of_rigid_links(judged, request.crank_angles, turning)
        attributes |= {"of_rigid_links": straight_line(straight)}
    _refuse_nothing(dataset)
    names = margin_names(dataset)
    return Strength(
        with_units(dataset, "strength").assign_attrs(
            **origin(dry),
            drawing=drawing(wet, float(dataset["margin_crank_angle"][0])),
            source_of_loads=source,
            crank_speed=turning,
            speed_unit=request.shown_unit(dry),
            environment_lines="\n".join(environment_lines(dry, request.environment)),
            not_judged=", ".join(name for name in judged.cuts if name not in names),
            cure_not_counted=", ".join(judged.without_cure),
            sliced=", ".join(judged.sliced),
            pin_checks_left_out="\n".join(judged.pins.left_out_lines),
            fatigue_left_out="\n".join(judged.enduring.left_out_lines),
            pins_without_diameter=", ".join(judged.pins.without_diameter),
            **attributes,
        )
    )


def _of_rigid_links(judged: JudgedMechanism, angles: FloatArray, speed: float) -> xr.Dataset:
    """What the loads of links that are taken as rigid make of links and pins."""
    loads = _loads(judged.mechanism, angles, speed, judged.cuts)
    static = _static_loads(judged.mechanism, angles, speed, judged.cuts)
    return _with_margins(_judged_by(judged, RIGID, angles, loads, static))


def _by_engines(
    judged: JudgedMechanism,
    engines: list[Engine],
    request: StrengthRequest,
    speed: float,
    report: LabelledProgress,
) -> tuple[xr.Dataset, dict[str, str]]:
    """What engines' equilibria or runs make of the links, and what is to be said of them."""
    at_rest = request.source == "quasi-static"
    source: type[Equilibria] | type[Runs] = Equilibria if at_rest else Runs
    asked = source.of(engines, request, speed)
    each, gaps = [], []
    for engine in asked.engines:
        loads = asked.loads(engine, judged.cuts, report)
        gaps.append(loads.moment_gap)
        each.append(_judged_by(judged, engine.name, asked.crank_angles, loads))
    dataset = xr.concat(
        each, "engine", data_vars="minimal", coords="minimal", compat="override", join="override"
    )
    dataset = _with_margins(dataset)
    # At rest no speed raises the loads.
    attributes = asked.attributes | _gap_attribute([gap for gap in gaps if gap is not None])
    if not request.search_speed or not speed:
        return dataset, attributes

    thinned = replace(request, crank_angles=_searched_angles(dataset, request.crank_angles))

    weakest: dict[float, dict[str, int]] = {}

    def least(factor: float) -> dict[str, float]:
        faster = source.of(engines[:1], thinned, factor * speed)
        engine = faster.engines[0]
        loads = faster.loads(engine, judged.cuts, report)
        found = _judged_by(judged, engine.name, faster.crank_angles, loads)
        weakest[factor] = weakest_checks(found)
        return _load_factors(_with_margins(found))

    if at_rest:
        search = search_roots(least, _load_factors(_with_margins(each[0])))
    else:
        search = search_speed(least, float(dataset["margin_load_factor"][0]))
    weakest[1.0] = weakest_checks(each[0])
    dataset = _with_margins(dataset, failures_of(search.speed_factor, weakest))
    factors = [
        own if kind == "pin" else search.speed_factor.get(name, np.nan)
        for name, kind, own in zip(
            margin_names(dataset),
            dataset["margin_kind"].values.tolist(),
            dataset["margin_speed_factor"].values.tolist(),
            strict=True,
        )
    ]
    dataset = dataset.assign(
        margin_speed_factor=("margin", factors),
        searched_speed_factor=("search", search.factor),
        searched_load_factor=("search", search.load_factor),
        searched_part=("search", search.part),
    )
    counted = f"{len(thinned.crank_angles)} of {len(request.crank_angles)}" if at_rest else ""
    note = {"search_note": search.note, "searched_angles": counted}
    return dataset, attributes | note


def _gap_attribute(gaps: list[FloatArray]) -> dict[str, str]:
    """How far bending moments of runs are from those of the curvature, over each link's peak."""
    if not gaps:
        return {}
    apart, peak = np.moveaxis(np.array(gaps), -1, 0)
    bent = peak > 0
    return {"moment_gap": percent(float((apart[bent] / peak[bent]).max(initial=0.0)))}


def _searched_angles(dataset: xr.Dataset, angles: FloatArray) -> FloatArray:
    """Crank angles of equilibria at other speeds: not all of many, but the worst of each part."""
    worst = np.abs(angles - dataset["margin_crank_angle"].values[:, None]).argmin(axis=1)
    every = np.arange(0, len(angles), math.ceil(len(angles) / MOST_SEARCHED))
    return np.asarray(angles[np.unique([*every, len(angles) - 1, *worst])])


def _refuse_nothing(dataset: xr.Dataset) -> None:
    """Refuse loads that stress nothing: no margin follows from them."""
    stressed = dataset["margin_index"].values > 0
    if not np.any(stressed | np.isfinite(dataset["margin_load_factor"].values)):
        raise InputError(
            "crank_speed: nothing loads links or pins at this speed, so that no margin follows; "
            "give a crank speed, or write in the model file, under [operation], crank_speeds = "
            '["300 rpm"]; what stands still needs gravity or a load'
        )


def _load_factors(dataset: xr.Dataset) -> dict[str, float]:
    """Least load factor of each part."""
    return dict(zip(margin_names(dataset), dataset["margin_load_factor"].values, strict=True))


def _judged_by(
    judged: JudgedMechanism,
    engine: str,
    angles: FloatArray,
    loads: LoadsOfTurn,
    static: LoadsOfTurn | None = None,
) -> xr.Dataset:
    """What one engine's loads make of links and pins."""
    links, pins = judged.judge(loads, static)
    dataset = strength_dataset(judged.mechanism, engine, angles, loads.links, links)
    still = None if static is None else static.links
    enduring = judged.enduring.judge(angles, loads.links, still)
    return dataset.assign(
        **pin_variables(judged.pins.made, pins, angles),
        **judged.enduring.variables(dataset, enduring, angles),
    )


def _with_margins(
    dataset: xr.Dataset, failures: Mapping[str, PinFailure] | None = None
) -> xr.Dataset:
    """The dataset with the margins of all kinds of parts; of pins as their speeds were searched."""
    rows = link_margins(dataset), pin_margins(dataset, failures), fatigue_margins(dataset)
    return dataset.assign(margin_variables(*rows))


def _loads(
    mechanism: Mechanism, angles: FloatArray, speed: float, cuts: Mapping[str, Cuts]
) -> LoadsOfTurn:
    found, topology = forces_over_the_turn(mechanism, angles, speed), mechanism.linkage.topology
    links = {
        name: internal_forces(found, number, cuts[name])
        for number, name in enumerate(topology.link_names)
    }
    return LoadsOfTurn(links, JointLoads.of_steady_links(found, topology))


def _static_loads(
    mechanism: Mechanism, angles: FloatArray, speed: float, cuts: Mapping[str, Cuts]
) -> LoadsOfTurn | None:
    """What is left of the loads at rest; None where the rest does not grow with speed squared."""
    damped = any(spring.damping for spring in mechanism.springs)
    damped |= any(spring.torsional_damping for spring in mechanism.joint_springs)
    timed = any(load.over == "time" for load in mechanism.loads)
    if not speed or damped or timed:
        return None
    return _loads(mechanism, angles, 0.0, cuts)
