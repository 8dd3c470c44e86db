"""Loads at the crank angles and places where parts are weakest, sought between samples.

Samples stand no farther apart than five degrees of the crank and a thirty-second of a link. Round
by round the vertices of the parabolas through the least factor of each part and its neighbours,
over the crank angle and along the link, are sampled too.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.analyses.extremes import with_steps
from flexmech.analyses.strength.forces import Cuts, cuts_of
from flexmech.analyses.strength.joint_loads import LoadsOfTurn
from flexmech.analyses.strength.judged_mechanism import JudgedMechanism
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.analyses.strength.sampled_loads import SampledLoads
from flexmech.analyses.strength.weakest import Name, Weakest, weakest_parts, with_places
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.errors import InputError
from flexmech.linear_system import Engine
from flexmech.mechanism import Mechanism

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
    """What was found by seeking.

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
        Of the mechanism in its state.
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
            Of the mechanism, dry and at its reference temperature.
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
        Of what does not grow with the square of the speed, at the same crank angles.
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
        Of the same mechanism; begins without crank angles.

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
