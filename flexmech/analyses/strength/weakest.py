"""Where each part of a mechanism is weakest, and where between samples it is weaker still."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.extremes import is_whole
from flexmech.analyses.strength.endurance import Endurance, stress_along
from flexmech.analyses.strength.joint_loads import LoadsOfTurn
from flexmech.analyses.strength.judged import JudgedLink, judge
from flexmech.analyses.strength.judged_mechanism import JudgedMechanism
from flexmech.arrays import FloatArray, IntArray

# Of the range of samples: a vertex nearer to a sample is that sample, whose stress is less than its
# own by the square of that alone.
_SAME = 1e-6
_TURN = 2 * np.pi
_OF = {False: "loads", True: "speed"}

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
    of : str
        Which of the part's factors: those of loads and of speed, and of a pin by each check.
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
    of: str
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
    for of_speed, worst, factors in (
        (False, pins.worst, pins.load_factors),
        (True, pins.fastest, pins.speed_factors),
    ):
        for number, check in enumerate(judged.pins.made):
            own, at = factors[number], int(worst[number])
            if np.isfinite(own[at]):
                angles = _vertices(crank_angles, at, own.take, turns=True)
                pin, here = ("pin", check.joint), (float(crank_angles[at]),)
                of = f"{_OF[of_speed]} {number}"
                yield Weakest(pin, float(own[at]), of, here, math.nan, angles)
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
        return Weakest(("link", name), least, _OF[of_speed])
    own, still = loads.links[name], None if static is None else static.links[name].loads
    asked, residual = judged.request.criterion, judged.residual[name]

    def factors(angle: IntArray | int, where: IntArray | int) -> FloatArray:
        """At pairs of a crank angle and a place, of this layer and surface."""
        acting = own.loads[angle, where][None]
        stays = None if still is None else still[angle, where][None]
        one = judge(judged.layers[name], acting, stays, residual, asked)
        return (one.speed_factor if of_speed else one.load_factor)[:, layer, surface]

    angle = int(worst[place, layer, surface])
    angles = _vertices(crank_angles, angle, lambda some: factors(some, place), turns=True)
    x = own.place
    places = _vertices(x, place, lambda some: factors(angle, some))
    here = (float(crank_angles[angle]),)
    return Weakest(("link", name), least, _OF[of_speed], here, float(x[place]), angles, places)


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
        return Weakest(("fatigue", name), least, _OF[False])
    stress = stress_along(judged.enduring.layers[name], own.loads)[..., layer, surface]
    here: list[float] = []
    angles: list[float] = []
    for sign in (1.0, -1.0):
        values = sign * stress[:, place]
        top = int(values.argmax())
        here.append(float(crank_angles[top]))
        # Of a stress, which may be of either sign, the vertex is that of the parabola itself.
        angles += _vertices(crank_angles, top, (-values).take, inverse=False, turns=True)
    swing = np.ptp(stress, axis=0)
    places = _vertices(own.place, place, (1.0 / np.where(swing > 0, swing, 1.0)).take)
    x = float(own.place[place])
    return Weakest(("fatigue", name), least, _OF[False], tuple(here), x, tuple(angles), places)


def _vertices(
    samples: FloatArray,
    number: int,
    factors_at: Callable[[IntArray], FloatArray],
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
    factors_at : callable
        From numbers of samples to their factors.
    inverse : bool
        Whether the parabola is of the inverse of the factor, which stresses are proportional to.
    turns : bool
        Whether samples are crank angles, whose last one may be the first of the next turn.

    Returns
    -------
    tuple of float
        One or none.
    """
    count, span = len(samples), float(samples[-1] - samples[0])
    numbers, x = np.arange(count), samples
    if turns and is_whole(span):
        # The end of a turn is its beginning.
        numbers = np.concatenate([numbers[:-1], numbers, numbers[1:]])
        x = np.concatenate([samples[:-1] - _TURN, samples, samples[1:] + _TURN])
        number += count - 1
    same, here = _SAME * max(span, np.finfo(float).tiny), x[number]
    left, right = np.flatnonzero(x < here - same), np.flatnonzero(x > here + same)
    jumps = np.flatnonzero(np.diff(samples) == 0)
    if not left.size or not right.size or np.any(samples[jumps] == here):
        return ()
    sides = np.array([left[-1], number, right[0]])
    x, sides = x[sides], numbers[sides]
    before, after = np.diff(x)
    factors = factors_at(sides)
    with np.errstate(divide="ignore", invalid="ignore"):
        values = 1.0 / factors if inverse else -factors
    if not np.isfinite(values).all():
        return ()
    rise, fall = (values[1] - values[0]) / before, (values[2] - values[1]) / after
    bend = (fall - rise) / (before + after)
    if bend >= 0:
        return ()
    vertex = (x[0] + x[1]) / 2 - rise / (2 * bend)
    if not x[0] < vertex < x[2] or np.abs(vertex - x).min() <= same:
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
