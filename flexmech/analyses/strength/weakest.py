"""Where each part of a mechanism is weakest, and where between samples it is weaker still."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.kinematics.extremes import is_whole
from flexmech.analyses.strength.endurance import Endurance, stress_along
from flexmech.analyses.strength.joint_loads import LoadsOfTurn
from flexmech.analyses.strength.judged import JudgedLink, judge
from flexmech.analyses.strength.judged_mechanism import JudgedMechanism
from flexmech.analyses.strength.judged_pins import judge_pins
from flexmech.arrays import FloatArray, IntArray

# Of a step: a vertex nearer to a sample is that sample.
_SAME = 1e-6
_TURN = 2 * np.pi

Name = tuple[str, str]
"""Kind and name of a part, as of its margin."""


@dataclass(frozen=True)
class Weakest:
    """The least factor of a part, and places between samples where it may be less.

    Parameters
    ----------
    name : (str, str)
        Kind and part.
    factor : float
        Load or speed factor.
    of_speed : bool
        Which of both.
    at : tuple of float
        Crank angles of it in rad; of fatigue those of both ends of the greatest cycle.
    place : float
        Of it, from the start of the link in m; not a number of a pin.
    crank_angles : tuple of float
        Between samples, in rad.
    places : tuple of float
        Between samples, from the start of the link in m.
    """

    name: Name
    factor: float
    of_speed: bool
    at: tuple[float, ...] = ()
    place: float = math.nan
    crank_angles: tuple[float, ...] = ()
    places: tuple[float, ...] = ()


def weakest_parts(
    judged: JudgedMechanism,
    crank_angles: FloatArray,
    loads: LoadsOfTurn,
    static: LoadsOfTurn | None,
) -> Iterator[Weakest]:
    """The least factors of all parts.

    Parameters
    ----------
    judged : JudgedMechanism
    crank_angles : ndarray, shape (A,)
        In rad, increasing.
    loads : LoadsOfTurn
        There.
    static : LoadsOfTurn or None
        Part of them that does not grow with the square of the speed.

    Yields
    ------
    Weakest
    """
    links, pins = judged.judge(loads, static)
    for name, found in links.items():
        yield _of_link(judged, name, found, crank_angles, loads, None)
        if static is not None:
            yield _of_link(judged, name, found, crank_angles, loads, static)
    for number, check in enumerate(judged.pins.made):
        for of_speed, worst, factor in (
            (False, pins.worst, pins.load_factor),
            (True, pins.fastest, pins.speed_factor),
        ):
            if not np.isfinite(factor[number]):
                continue

            def at(some: IntArray, of_speed: bool = of_speed, check: object = check) -> float:
                still = static.at(some).joints if static is not None else None
                one = judge_pins([check], loads.at(some).joints, still)  # type: ignore[list-item]
                return float((one.speed_factor if of_speed else one.load_factor)[0])

            angles = _vertices(crank_angles, int(worst[number]), at, turns=True)
            pin, here = ("pin", check.joint), (float(crank_angles[worst[number]]),)
            yield Weakest(pin, float(factor[number]), of_speed, here, math.nan, angles)
    still = None if static is None else static.links
    for name, one in judged.enduring.judge(crank_angles, loads.links, still).items():
        yield _of_fatigue(judged, name, one, crank_angles, loads)


def _of_link(
    judged: JudgedMechanism,
    name: str,
    found: JudgedLink,
    crank_angles: FloatArray,
    loads: LoadsOfTurn,
    static: LoadsOfTurn | None,
) -> Weakest:
    """A link's least load factor, or its least speed factor where static loads are given."""
    of_speed = static is not None
    factor, worst = (
        (found.speed_factor, found.fastest) if of_speed else (found.load_factor, found.worst)
    )
    place, layer, surface = (int(n) for n in np.unravel_index(np.argmin(factor), factor.shape))
    least = float(factor[place, layer, surface])
    if not np.isfinite(least) or not least:
        return Weakest(("link", name), least, of_speed)
    own, still = loads.links[name], None if static is None else static.links[name].loads
    asked, residual = judged.request.criterion, judged.residual[name]

    def factors(angle: IntArray, where: IntArray) -> FloatArray:
        """At one crank angle and some places of this layer and surface."""
        acting = own.loads[angle][:, where]
        stays = None if still is None else still[angle][:, where]
        one = judge(judged.layers[name], acting, stays, residual, asked)
        return (one.speed_factor if of_speed else one.load_factor)[:, layer, surface]

    angle = int(worst[place, layer, surface])
    angles = _vertices(
        crank_angles, angle, lambda some: float(factors(some, np.array([place]))[0]), turns=True
    )
    x = own.place
    places = _vertices(x, place, lambda some: float(factors(np.array([angle]), some)[0]))
    here = (float(crank_angles[angle]),)
    return Weakest(("link", name), least, of_speed, here, float(x[place]), angles, places)


def _of_fatigue(
    judged: JudgedMechanism,
    name: str,
    found: Endurance,
    crank_angles: FloatArray,
    loads: LoadsOfTurn,
) -> Weakest:
    """A link's least load factor of fatigue: both ends of its greatest cycle count."""
    factor = found.load_factor
    place, layer, surface = (int(n) for n in np.unravel_index(np.argmin(factor), factor.shape))
    least, own = float(factor[place, layer, surface]), loads.links[name]
    if not np.isfinite(least) or not least:
        return Weakest(("fatigue", name), least, False)
    stress = stress_along(judged.enduring.layers[name], own.loads)[..., layer, surface]
    here: list[float] = []
    angles: list[float] = []
    for sign in (1.0, -1.0):
        values = sign * stress[:, place]
        top = int(values.argmax())
        here.append(float(crank_angles[top]))
        # Of a stress, which may be of either sign, the vertex is that of the parabola itself.
        angles += _vertices(
            crank_angles,
            top,
            lambda some: -float(values[some][0]),  # noqa: B023
            inverse=False,
            turns=True,
        )
    swing = np.ptp(stress, axis=0)
    places = _vertices(own.place, place, lambda some: 1.0 / float(swing[some][0] or 1.0))
    x = float(own.place[place])
    return Weakest(("fatigue", name), least, False, tuple(here), x, tuple(angles), places)


def _vertices(
    samples: FloatArray,
    number: int,
    factor_at: Callable[[IntArray], float],
    *,
    inverse: bool = True,
    turns: bool = False,
) -> tuple[float, ...]:
    """Vertex of the parabola through a sample and its neighbours, if it is between samples.

    Parameters
    ----------
    samples : ndarray, shape (n,)
        Ascending; two that are equal are the sides of a jump, over which there is no parabola.
    number : int
        Of the least factor.
    factor_at : callable
        Of one sample.
    inverse : bool
        Whether the parabola is of the inverse of the factor, which stresses are proportional to.
    turns : bool
        Whether samples are crank angles, whose last one may be the first of the next turn.

    Returns
    -------
    tuple of float
        One or none.
    """
    last = len(samples) - 1
    sides, shift = np.array([number - 1, number, number + 1]), np.zeros(3)
    if number in (0, last) and turns and is_whole(float(samples[-1] - samples[0])):
        sides, shift = np.array([last - 1, number, 1]), np.zeros(3)
        shift[0 if number == 0 else 2] = -_TURN if number == 0 else _TURN
    if last < 2 or sides[0] < 0 or sides[2] > last:
        return ()
    x = samples[sides] + shift
    before, after = np.diff(x)
    if not before or not after:
        return ()
    factors = np.array([factor_at(sides[n : n + 1]) for n in range(3)])
    with np.errstate(divide="ignore", invalid="ignore"):
        values = 1.0 / factors if inverse else -factors
    if not np.isfinite(values).all():
        return ()
    rise, fall = (values[1] - values[0]) / before, (values[2] - values[1]) / after
    bend = (fall - rise) / (before + after)
    if bend >= 0:
        return ()
    vertex = (x[0] + x[1]) / 2 - rise / (2 * bend)
    near = min(abs(vertex - x[1]) / min(before, after), 1.0)
    if not x[0] < vertex < x[2] or near <= _SAME:
        return ()
    beyond = _TURN * (float(vertex > samples[-1]) - float(vertex < samples[0]))
    return (float(vertex - beyond * turns),)


def with_places(
    places: Mapping[str, tuple[float, ...]], parts: list[Weakest]
) -> dict[str, tuple[float, ...]]:
    """Places along links, with those of the weakest parts.

    Parameters
    ----------
    places : mapping of str to tuple of float
    parts : list of Weakest

    Returns
    -------
    dict of str to tuple of float
    """
    found = dict(places)
    for part in parts:
        if part.places:
            found[part.name[1]] = (*found.get(part.name[1], ()), *part.places)
    return found
