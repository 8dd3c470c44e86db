"""Strength of a mechanism's links and pins under the loads of its motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from flexmech import plots
from flexmech.analyses.datasets import filled, origin, padded
from flexmech.analyses.digits import percent
from flexmech.analyses.requests import Engines, asks, engines_of
from flexmech.analyses.result import Result
from flexmech.analyses.schema import Values, schema_of
from flexmech.analyses.strength.joint_loads import InternalForces, LoadsAtAngles, LoadsOfTurn
from flexmech.analyses.strength.judged import JudgedLink, JudgedMechanism
from flexmech.analyses.strength.load_cases import Equilibria, Runs
from flexmech.analyses.strength.margins import (
    NO_LAYER,
    PinFailure,
    failures_of,
    link_margins,
    margin_names,
    margin_variables,
    pin_margins,
    weakest_checks,
)
from flexmech.analyses.strength.pins import JudgedPins, PinCheck
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.analyses.strength.speed_search import search_roots, search_speed
from flexmech.analyses.strength.weakest import LoadsOfEngines, Name, angles_between, seek
from flexmech.analyses.strength.words import ASKED, straight_line, summary_of
from flexmech.analyses.summary import Summary, environment_lines
from flexmech.arrays import FloatArray, IntArray, LabelledProgress, silent
from flexmech.errors import InputError
from flexmech.mechanics import Engine, checked_mechanism
from flexmech.mechanism import Mechanism
from flexmech.sections import SURFACES

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Factors that files leave empty where no load or speed leads to failure.
_FACTORS = ("", "margin_", "pin_", "fatigue_")


class Strength(Result):
    """Internal forces of links over the turn, and how far layers and pins are from failure.

    Parameters
    ----------
    dataset : xarray.Dataset
        The variables of ``schema.toml``: internal forces along the links over the crank angle; over
        (engine, link, station, layer, surface) the least factors over the turn; checks of pins over
        ``pin_check``; parts over ``margin``, the weakest first. Links with fewer stations or layers
        have NaN after them.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "strength"
    subject = "strength"
    hallmark = "margin_load_factor"

    def tabulated(self) -> xr.Dataset:
        """The dataset without factors that are infinite, and layers of what has none."""
        data = self.dataset
        names = [f"{of}{name}_factor" for of in _FACTORS for name in ("load", "speed")]
        finite = {n: data[n].where(np.isfinite(data[n])) for n in names if n in data}
        layer = data["margin_layer"]
        return data.assign({**finite, "margin_layer": layer.where(layer != NO_LAYER)})

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw the linkage, each link coloured by its load factor, the worst places marked.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            The user's.
        """
        return plots.plot_strength(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """The part that fails first, how, and the factors by which loads and speed may rise."""
        return summary_of(self.dataset)


_FORCES = ("axial_force", "bending_moment", "shear_force")


def strength_dataset(
    mechanism: Mechanism,
    engine: str,
    angles: FloatArray,
    forces: Mapping[str, InternalForces],
    judged: Mapping[str, JudgedLink],
    judged_at: FloatArray,
) -> xr.Dataset:
    """Stresses of the links under one engine's forces.

    Parameters
    ----------
    mechanism : Mechanism
        In its state.
    engine : str
        Whose internal forces they are.
    angles : ndarray, shape (A,)
        Crank angles in rad.
    forces : mapping of str to InternalForces
        Forces of every link.
    judged : mapping of str to JudgedLink
        Links to judge, whose layers are known.
    judged_at : ndarray, shape (B,)
        Crank angles at which they were judged, in rad.

    Returns
    -------
    xarray.Dataset
    """
    links = list(forces)
    count = max(len(one.place) for one in forces.values())
    deep = max((len(one.criterion) for one in judged.values()), default=1)
    along = padded([np.moveaxis(forces[name].loads, 1, -1) for name in links], count)
    shape = (len(links), count, deep, len(SURFACES))

    def of_links(size: tuple[int, ...], values: Mapping[str, Any], otherwise: Any = np.nan) -> Any:
        places = (((links.index(name),), value) for name, value in values.items())
        return filled(size, places, otherwise)

    def of_places(field: str, otherwise: Any = np.nan) -> Any:
        return of_links(shape, {n: getattr(one, field) for n, one in judged.items()}, otherwise)

    known = {name: mechanism.layers_of(name) for name in links}
    stacks = {name: own.laminate.layers for name, own in known.items() if own is not None}
    layered = shape[0], deep
    values: Values = {
        "engine": [engine],
        "link": links,
        "crank_angle": angles,
        "station": np.arange(1, count + 1),
        "layer": np.arange(1, deep + 1),
        "surface": list(SURFACES),
        "position": padded([forces[name].place for name in links], count),
        "criterion": of_links(layered, {n: one.criterion for n, one in judged.items()}, ""),
        "ply": of_links(layered, {n: [la.ply.name for la in own] for n, own in stacks.items()}, ""),
        "angle": of_links(layered, {n: [la.angle for la in own] for n, own in stacks.items()}),
        "length": [body.length for body in mechanism.linkage.topology.links],
    }
    of_engine: Values = {
        **{name: along[:, :, number] for number, name in enumerate(_FORCES)},
        "failure_index": of_places("index"),
        "load_factor": of_places("load_factor"),
        "speed_factor": of_places("speed_factor"),
        "worst_angle": of_links(shape, {n: judged_at[one.worst] for n, one in judged.items()}),
        "failure_mode": of_places("mode", ""),
    }
    return schema_of(__package__).dataset(values, parts=[of_engine], along="engine")


def pin_variables(
    checks: Sequence[PinCheck], judged: JudgedPins, angles: FloatArray, asked: IntArray
) -> dict[str, Any]:
    """Variables of what one engine's forces make of the pins; none without checks.

    Parameters
    ----------
    checks : sequence of PinCheck
    judged : JudgedPins
    angles : ndarray, shape (A,)
        Crank angles in rad.
    asked : ndarray of int, shape (B,)
        Numbers of those that were asked for, evenly apart as they may be: means are over them.

    Returns
    -------
    dict
        Over ``pin_check``, and over (engine, pin_check).
    """
    if not checks:
        return {}
    words = {name: [getattr(one, name) for one in checks] for name in ("joint", "link", "mode")}
    numbers = {
        "stress": judged.stress,
        "mean": judged.stresses[:, asked].mean(axis=1),
        "load_factor": judged.load_factor,
        "speed_factor": judged.speed_factor,
        "worst_angle": angles[judged.worst],
    }
    return {
        **{f"pin_{name}": ("pin_check", np.array(texts)) for name, texts in words.items()},
        "pin_allowable": ("pin_check", [one.allowable for one in checks]),
        **{f"pin_{n}": (("engine", "pin_check"), value[None]) for n, value in numbers.items()},
    }


# Crank angles of equilibria at other speeds: a turn in steps of five degrees, for speed alone.
MOST_SEARCHED = 73
LEAST_ERROR = 1e-6
"""Relative error of a load factor: less is below the digits of all that is printed."""
# Rounds for rigid links, which cost little: five usually settle every factor.
_ROUNDS = 8
RIGID = "rigid"
"""In place of an engine: the links are taken as rigid."""


@asks(StrengthRequest)
def strength(mechanism: Engines, request: StrengthRequest) -> Strength:
    """Where links and pins would break, how, and by what factor loads and speed may rise.

    The loads are the internal and joint forces of links that bend at rest in their frames, that
    vibrate, or that are taken as rigid. Stresses of cure, heat and moisture stay; the load factor
    multiplies the others.

    Parameters
    ----------
    mechanism : Mechanism, Engine or sequence of them
        All of one mechanism, dry and at its reference temperature. Loads of rigid links are those
        of the mechanism alone, whatever the engines.

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
    first = mechanism[0] if isinstance(mechanism, Sequence) and mechanism else mechanism
    dry = checked_mechanism(first.mechanism if isinstance(first, Engine) else first)
    engines = engines_of(mechanism, request)
    judged = JudgedMechanism.of(dry, request)
    wet, turning = judged.mechanism, request.speed_of(dry)
    rigid = all(link.rigid for link in wet.linkage.topology.links)
    source = "rigid" if rigid and request.source == "quasi-static" else request.source
    if source == "rigid":
        dataset, attributes = _of_rigid_links(judged, request.crank_angles, turning)
    else:
        dataset, attributes = _by_engines(
            judged, engines, request, turning, request.progress or silent
        )
    if source == "quasi-static":
        straight, judged_at = _of_rigid_links(judged, request.crank_angles, turning)
        attributes |= judged_at | {"of_rigid_links": straight_line(straight)}
    _refuse_nothing(dataset)
    names = margin_names(dataset)
    return Strength(
        Strength.schema()
        .labelled(dataset)
        .assign_attrs(
            **origin(dry),
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


def _of_rigid_links(
    judged: JudgedMechanism, angles: FloatArray, speed: float
) -> tuple[xr.Dataset, dict[str, str]]:
    """Stresses of links and pins under the loads of rigid links, and the remarks on them."""
    mechanism = judged.mechanism
    every, between = angles_between(mechanism, angles)
    moving = LoadsAtAngles.of_rigid_links(mechanism, speed)
    still = LoadsAtAngles.of_rigid_links(mechanism, 0.0) if _grows(mechanism, speed) else None
    for source in (moving, still):
        if source is not None:
            source.add(every)
    found = seek(judged, moving, still, rounds=_ROUNDS, between=between)
    dataset = _judged_by(judged, RIGID, angles, found.crank_angles, found.loads, found.static)
    judged_at = {} if between or len(angles) == 1 else {"judged_at": ASKED}
    return _with_errors(_with_margins(dataset), found.change), judged_at


def _by_engines(
    judged: JudgedMechanism,
    engines: list[Engine],
    request: StrengthRequest,
    speed: float,
    report: LabelledProgress,
) -> tuple[xr.Dataset, dict[str, str]]:
    """Stresses of links by engines' equilibria or runs, and the remarks on them."""
    at_rest = request.source == "quasi-static"
    source: type[LoadsOfEngines] = Equilibria if at_rest else Runs
    asked = source.of(engines, request, speed)
    first, *others = asked.engines
    found, errors = asked.sought(first, judged, report)
    of_engines = {first.name: found.loads}
    of_engines |= {engine.name: asked.again(engine, found, report) for engine in others}
    gaps = [loads.moment_gap for loads in of_engines.values()]
    each = [
        _judged_by(judged, name, asked.crank_angles, found.crank_angles, loads)
        for name, loads in of_engines.items()
    ]
    dataset = xr.concat(
        each, "engine", data_vars="minimal", coords="minimal", compat="override", join="override"
    )
    known = {name: change + errors.get(name, 0.0) for name, change in found.change.items()}
    dataset = _with_margins(dataset)
    # At rest no speed raises the loads.
    attributes = asked.attributes | _gap_attribute([gap for gap in gaps if gap is not None])
    if not request.search_speed or not speed:
        return _with_errors(dataset, known), attributes

    thinned = replace(request, crank_angles=_searched_angles(dataset, request.crank_angles))

    weakest: dict[float, dict[str, int]] = {}

    def least(factor: float) -> dict[str, float]:
        faster = source.of(engines[:1], thinned, factor * speed)
        engine = faster.engines[0]
        there = faster.weakest(engine, judged, report)
        angles = there.crank_angles
        own = _judged_by(judged, engine.name, angles, angles, there.loads)
        weakest[factor] = weakest_checks(own)
        return _load_factors(_with_margins(own))

    if at_rest:
        search = search_roots(least, _load_factors(_with_margins(each[0])))
    else:
        search = search_speed(least, float(dataset["margin_load_factor"][0]))
    weakest[1.0] = weakest_checks(each[0])
    # The speeds of pins may bring rows of a second check.
    dataset = _with_margins(dataset, failures_of(search.speed_factor, weakest))
    dataset = _with_errors(dataset, known)
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
    return dataset, attributes | {"search_note": search.note}


def _gap_attribute(gaps: list[FloatArray]) -> dict[str, str]:
    """How far bending moments of runs are from those of the curvature, over each link's peak."""
    if not gaps:
        return {}
    apart, peak = np.moveaxis(np.array(gaps), -1, 0)
    bent = peak > 0
    return {"moment_gap": percent(float((apart[bent] / peak[bent]).max(initial=0.0)))}


def _searched_angles(dataset: xr.Dataset, angles: FloatArray) -> FloatArray:
    """Crank angles of equilibria at other speeds: not all of many, but the worst of every part.

    A pin has one for each of its checks: the speed may choose another check than the loads.
    """
    every = np.arange(0, len(angles), math.ceil(len(angles) / MOST_SEARCHED))
    some = angles[np.unique([*every, len(angles) - 1])]
    names = ("margin_crank_angle", "pin_worst_angle")
    worst = [dataset[name].values.ravel() for name in names if name in dataset]
    return np.unique(np.concatenate([some, *worst]))


def _refuse_nothing(dataset: xr.Dataset) -> None:
    """Refuse loads that stress nothing: no margin follows from them."""
    stressed = dataset["margin_index"].values > 0
    if not np.any(stressed | np.isfinite(dataset["margin_load_factor"].values)):
        raise InputError(
            "crank_speed: nothing loads links or pins at this speed, so that no margin follows; "
            "give a crank speed, or write in the model file, under [operation], crank_speeds = "
            '["300 rpm"]; a linkage at rest needs gravity or a load'
        )


def _load_factors(dataset: xr.Dataset) -> dict[str, float]:
    """Least load factor of each part."""
    return dict(zip(margin_names(dataset), dataset["margin_load_factor"].values, strict=True))


def _judged_by(
    judged: JudgedMechanism,
    engine: str,
    angles: FloatArray,
    judged_at: FloatArray,
    loads: LoadsOfTurn,
    static: LoadsOfTurn | None = None,
) -> xr.Dataset:
    """Stresses of links and pins by one engine's loads at crank angles, with those asked for."""
    links, pins = judged.judge(loads, static)
    numbers = np.searchsorted(judged_at, angles)
    asked = loads.at(numbers)
    dataset = strength_dataset(judged.mechanism, engine, angles, asked.links, links, judged_at)
    still = None if static is None else static.links
    enduring = judged.enduring.judge(judged_at, loads.links, still)
    return dataset.assign(
        **pin_variables(judged.pins.made, pins, judged_at, numbers),
        **judged.enduring.variables(dataset, enduring, judged_at),
    )


def _with_errors(dataset: xr.Dataset, errors: Mapping[Name, float]) -> xr.Dataset:
    """The dataset with the relative error of the load factor of every margin."""
    parts = zip(dataset["margin_kind"].values, dataset["margin_part"].values, strict=True)
    known = [max(errors.get((str(kind), str(part)), 0.0), LEAST_ERROR) for kind, part in parts]
    return dataset.assign(margin_error=("margin", known))


def _with_margins(
    dataset: xr.Dataset, failures: Mapping[str, PinFailure] | None = None
) -> xr.Dataset:
    """The dataset with the margins of all kinds of parts; of pins as their speeds were searched."""
    of_links = link_margins(dataset), link_margins(dataset, "fatigue")
    return dataset.assign(margin_variables(*of_links, pin_margins(dataset, failures)))


def _grows(mechanism: Mechanism, speed: float) -> bool:
    """Whether what is not there at rest grows with the square of the speed."""
    damped = any(spring.damping for spring in mechanism.springs)
    damped |= any(spring.torsional_damping for spring in mechanism.joint_springs)
    timed = any(load.over == "time" for load in mechanism.loads)
    return bool(speed and not damped and not timed)
