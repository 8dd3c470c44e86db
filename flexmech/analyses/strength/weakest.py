"""Where each part of a mechanism is weakest, and where between samples it is weaker still.

Samples stand no farther apart than five degrees of the crank and a thirty-second of a link. Round
by round the vertices of the parabolas through the least factor of each part and its neighbours,
over the crank angle and along the link, are sampled too.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.analyses.extremes import is_whole, with_steps
from flexmech.analyses.strength.endurance import Endurance, stress_along
from flexmech.analyses.strength.joint_loads import Cuts, LoadsOfTurn, SampledLoads, cuts_of
from flexmech.analyses.strength.judged import JudgedLink, JudgedMechanism, judge
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.arrays import FloatArray, IntArray, LabelledProgress
from flexmech.errors import InputError
from flexmech.mechanics import Engine
from flexmech.mechanism import Mechanism

# Part of the range of samples: a vertex nearer to a sample is that sample, whose stress is less
# than its own by the square of that alone.
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
        Place of it, from the start of the link in m; not a number of a pin.
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
        # A stress may have either sign: its vertex is that of the parabola itself.
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
        Number of the least factor.
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


STEP = np.radians(5.0)
"""Between crank angles at which parts are judged, at most."""
_PARTS = 32
# The search ends when a round changes every factor by less than this part: the next round would
# change less than a tenth of it, which is below the printed digits.
_SETTLED = 1e-8

Factor = tuple[Name, str]
"""A factor of a part, and which one."""


@dataclass(frozen=True)
class Sought:
    """Cuts, crank angles and loads that the search for the weakest places has reached.

    Parameters
    ----------
    crank_angles : ndarray, shape (A,)
        At which loads are known, in rad, increasing: those asked for, and others.
    cuts : dict of str to Cuts
        At the places asked for, and where parts are weakest.
    loads : LoadsOfTurn
    static : LoadsOfTurn or None
    change : dict of (str, str) to float
        By kind and part: relative change of its least factors by the last round.
    """

    crank_angles: FloatArray
    cuts: dict[str, Cuts]
    loads: LoadsOfTurn
    static: LoadsOfTurn | None
    change: dict[Name, float]


@dataclass(frozen=True)
class LoadsOfEngines(ABC):
    """Engines whose loads at one crank speed are asked for.

    Parameters
    ----------
    engines : list of Engine
        Engines of the mechanism in its state.
    crank_angles : ndarray, shape (A,)
        At which loads are asked for, in rad, increasing.
    attributes : dict of str to str
        What was chosen for the engines.
    """

    engines: list[Engine]
    crank_angles: FloatArray
    attributes: dict[str, str]

    @classmethod
    @abstractmethod
    def of(cls, engines: Sequence[Engine], asked: StrengthRequest, speed: float) -> Self:
        """Engines of a mechanism in its state.

        Parameters
        ----------
        engines : sequence of Engine
            Engines of the mechanism, dry and at its reference temperature.
        asked : StrengthRequest
        speed : float
            Crank speed in rad/s, whatever that of the request.

        Returns
        -------
        LoadsOfEngines

        Raises
        ------
        InputError
            If links cannot have these loads.
        """

    @abstractmethod
    def source(self, engine: Engine, report: LabelledProgress) -> SampledLoads:
        """Loads of an engine, to which crank angles can be added.

        Parameters
        ----------
        engine : Engine
        report : callable
            Progress.

        Returns
        -------
        SampledLoads
        """

    @abstractmethod
    def weakest(self, engine: Engine, judged: JudgedMechanism, report: LabelledProgress) -> Sought:
        """Loads of an engine where every part is weakest.

        Parameters
        ----------
        engine : Engine
        judged : JudgedMechanism
        report : callable
            Progress.

        Returns
        -------
        Sought

        Raises
        ------
        InputError
            If links that are to be at rest in their frames have a free shaft.
        ComputationError
            If an equilibrium or a run does not converge.
        """

    @abstractmethod
    def sought(
        self, engine: Engine, judged: JudgedMechanism, report: LabelledProgress
    ) -> tuple[Sought, dict[Name, float]]:
        """Loads of an engine where every part is weakest, and how far they are known.

        Parameters
        ----------
        engine : Engine
        judged : JudgedMechanism
        report : callable
            Progress.

        Returns
        -------
        Sought
        dict of (str, str) to float
            By kind and part, relative: by a finer discretisation.
        """

    def again(self, engine: Engine, found: Sought, report: LabelledProgress) -> LoadsOfTurn:
        """Loads of another engine at the crank angles and places that were found by one.

        Parameters
        ----------
        engine : Engine
        found : Sought
        report : callable
            Progress.

        Returns
        -------
        LoadsOfTurn
        """
        source = self.source(engine, report)
        source.add(found.crank_angles)
        return source.loads(found.cuts)


def angles_between(mechanism: Mechanism, crank_angles: FloatArray) -> tuple[FloatArray, bool]:
    """Crank angles asked for, and others between them, no more than five degrees apart.

    Parameters
    ----------
    mechanism : Mechanism
    crank_angles : ndarray, shape (A,)
        In rad, increasing.

    Returns
    -------
    ndarray, shape (B,)
        Those asked for alone where the linkage cannot be moved through the others.
    bool
        Whether it can be moved from the first of them to the last, so that parts may be weaker
        between them; of one angle there is nothing between.
    """
    if len(crank_angles) == 1:
        return crank_angles, False
    every = with_steps(crank_angles, STEP)
    try:
        mechanism.linkage.motion(every)
    except InputError:
        return crank_angles, False
    return every, True


def seek(
    judged: JudgedMechanism,
    source: SampledLoads,
    static: SampledLoads | None = None,
    *,
    rounds: int,
    between: bool = True,
) -> Sought:
    """Find where every part is weakest.

    Parameters
    ----------
    judged : JudgedMechanism
    source : SampledLoads
        Crank angles are added to it.
    static : SampledLoads, optional
        Loads of what does not grow with the square of the speed, at the same crank angles.
    rounds : int
    between : bool
        Whether crank angles may be added.

    Returns
    -------
    Sought
    """
    mechanism, elements = judged.mechanism, judged.request.elements
    fine = elements * math.ceil(_PARTS / elements)
    places: dict[str, tuple[float, ...]] = {}
    found: list[Weakest] = []
    factors: dict[Factor, float] = {}
    change: dict[Name, float] = {}
    for number in range(rounds + 1):
        cuts = {name: cuts_of(mechanism, name, fine, places.get(name, ())) for name in judged.cuts}
        loads = source.loads(cuts)
        still = None if static is None else static.loads(cuts)
        found = list(weakest_parts(judged, source.crank_angles, loads, still))
        change = _changes(factors, _factors(found))
        factors = _factors(found)
        if number == rounds or (number and max(change.values(), default=0.0) < _SETTLED):
            break
        places = with_places(places, found)
        new = np.array([angle for part in found for angle in part.crank_angles])
        for one in (source, static) if between and new.size else ():
            if one is not None:
                one.add(new)
    weakest: dict[str, list[float]] = {}
    for part in found:
        if not math.isnan(part.place):
            weakest.setdefault(part.name[1], []).append(part.place)
    asked = {
        name: cuts_of(mechanism, name, elements, weakest.get(name, ())) for name in judged.cuts
    }
    return Sought(
        source.crank_angles,
        asked,
        source.loads(asked),
        None if static is None else static.loads(asked),
        change,
    )


def changes_of(judged: JudgedMechanism, coarse: Sought, finer: SampledLoads) -> dict[Name, float]:
    """Relative changes of the least load factors of all parts with a finer mesh.

    Parameters
    ----------
    judged : JudgedMechanism
    coarse : Sought
    finer : SampledLoads
        Loads of the same mechanism on a finer mesh; begins without crank angles.

    Returns
    -------
    dict of (str, str) to float
        By kind and part, at the places and crank angles where these are weakest.
    """
    found = weakest_parts(judged, coarse.crank_angles, coarse.loads, None)
    angles = np.unique([angle for part in found for angle in part.at])
    if not angles.size:
        return {}
    finer.add(angles)
    some = np.searchsorted(coarse.crank_angles, angles)
    both = (
        _factors(weakest_parts(judged, angles, loads, None))
        for loads in (coarse.loads.at(some), finer.loads(coarse.cuts))
    )
    return _changes(*both)


def _factors(found: Iterable[Weakest]) -> dict[Factor, float]:
    return {(part.name, part.of): part.factor for part in found}


def _changes(before: Mapping[Factor, float], now: Mapping[Factor, float]) -> dict[Name, float]:
    """Greatest relative change of the factors of each part."""
    found: dict[Name, float] = {}
    for (name, of), factor in now.items():
        earlier = before.get((name, of), math.nan)
        same = earlier == factor or not (math.isfinite(earlier) and math.isfinite(factor))
        apart = 0.0 if same else abs(factor - earlier) / max(abs(factor), abs(earlier))
        found[name] = max(found.get(name, 0.0), apart)
    return found
