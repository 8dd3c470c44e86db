r"""Where crunodes of a coupler curve come and go while the linkage changes.

A crunode's loop shrinks to a cusp where the margin 1 - \|cos kappa\| of its double point passes
zero, see :mod:`flexmech.linkages.DoublePoint`; two crunodes annihilate each other where two
roots of the cubic merge and the curve touches itself (a tacnode). Between such parameters each
double point is a continuous function of the parameter and is followed along the circle of
singular foci.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from flexmech import ComputationError, CouplerPoint, FourBar, InputError
from flexmech.linkages import (
    DoublePoint,
    GrashofClass,
    circuit_of,
    finite_double_points,
    focal_cubic,
    full_turn,
)

Family = Callable[[float], tuple[FourBar, CouplerPoint]]
Nodes = tuple[DoublePoint, ...]
Stop = tuple[float, Nodes]

# Part of the interval to which mergers and cusps are located.
LOCATED = 1e-12
# A step is halved until its double points move less than this part of their separation.
FOLLOWED = 0.3
# Far more than a family needs whose double points are apart but where they merge.
MOST_PARAMETERS = 20_000


class DoublePointPath:
    """Real double points at the parameters of a family, each computed once.

    Parameters
    ----------
    family : callable
        Linkage and coupler point at a parameter, continuous in it.
    start, stop : float
        Parameters.
    crank_angle : float or None
        Tells the circuit, as for :func:`flexmech.linkages.double_points`.

    Raises
    ------
    InputError
        If the linkage at ``start`` has a change point or cannot be assembled at the crank
        angle.
    """

    def __init__(
        self, family: Family, start: float, stop: float, crank_angle: float | None
    ) -> None:
        self.family = family
        self.start, self.stop = start, stop
        linkage, _ = family(start)
        self.circuit = circuit_of(linkage, crank_angle)
        self.grashof_class: GrashofClass = linkage.grashof_class
        self._known: dict[float, Nodes] = {}

    @property
    def span(self) -> float:
        """Length of the interval of parameters."""
        return abs(self.stop - self.start)

    def nodes(self, parameter: float) -> Nodes:
        """Real double points by growing place, of all circuits and isolated ones.

        Parameters
        ----------
        parameter : float

        Returns
        -------
        tuple of DoublePoint
            One or three.

        Raises
        ------
        InputError
            If the Grashof class differs from that at the start, or the point is in a pin.
        ComputationError
            If double points cannot be told apart over a part of the interval.
        """
        if parameter not in self._known:
            linkage, point = self.family(parameter)
            if linkage.grashof_class != self.grashof_class:
                raise InputError(
                    f"the linkage is a {self.grashof_class} at parameter {self.start:g} and a "
                    f"{linkage.grashof_class} at {parameter:g}: between them its circuits meet "
                    "and curves are not followed; keep the interval on one side"
                )
            found = finite_double_points(linkage, point)
            if not found:
                raise InputError(
                    f"the coupler point is in a pin at parameter {parameter:g}, where it traces "
                    "a circle; keep the interval on one side"
                )
            if len(self._known) >= MOST_PARAMETERS:
                raise ComputationError(
                    f"double points lie too close to be told apart near parameter {parameter:g}; "
                    "choose an interval without it, or change the coupler point slightly"
                )
            self._known[parameter] = found
        return self._known[parameter]

    def discriminant(self, parameter: float) -> float:
        """Of the cubic of the double points: passes zero where two merge or part."""
        return focal_cubic(*self.family(parameter)).discriminant()

    def crunodes(self, parameter: float) -> int:
        """Number of crunodes of the circuit's curve."""
        nodes = self.nodes(parameter)
        return sum(node.kind == "crunode" and node.lies_on(self.circuit) for node in nodes)

    def nearest(self, parameter: float, place: float) -> DoublePoint:
        """Double point that is nearest to a place on the circle of singular foci."""
        return min(self.nodes(parameter), key=lambda node: distance(place, node.place))

    def stretches(self, parameters: list[float]) -> list[list[Stop]]:
        """Double points followed over parameters, cut where two merge or part.

        Parameters
        ----------
        parameters : list of float
            From ``start`` to ``stop``.

        Returns
        -------
        list of list of (float, tuple of DoublePoint)
            At the parameters and, where double points move fast, at more in between; those of
            one stretch each in the order of its first. Between stretches is 1e-12 of the
            interval.
        """
        found = [[(parameters[0], self.nodes(parameters[0]))]]
        for here, there in pairwise(parameters):
            for parameter in (*self._between(here, there), there):
                nodes, last = self.nodes(parameter), found[-1][-1][1]
                if len(nodes) == len(last):
                    found[-1].append((parameter, _in_order(last, nodes)))
                else:
                    found.append([(parameter, nodes)])
        return found

    def _between(self, here: float, there: float) -> Iterator[float]:
        """Parameters that are needed to know which double point has become which."""
        middle = (here + there) / 2
        if abs(there - here) <= LOCATED * self.span or middle in (here, there):
            return
        before, after = self.nodes(here), self.nodes(there)
        if len(before) == len(after) and _is_followed(before, _in_order(before, after)):
            return
        yield from self._between(here, middle)
        yield middle
        yield from self._between(middle, there)


def distance(place: float, other: float) -> float:
    """Way between places on the circle of singular foci, on which a half turn is all."""
    return abs(math.remainder(other - place, math.pi))


def _in_order(nodes: Nodes, found: Nodes) -> Nodes:
    """Found double points in the order of known ones; they never overtake each other."""
    turned = [(*found[n:], *found[:n]) for n in range(len(found))]
    return min(
        turned,
        key=lambda order: sum(
            distance(a.place, b.place) for a, b in zip(nodes, order, strict=True)
        ),
    )


def _is_followed(nodes: Nodes, ahead: Nodes) -> bool:
    gaps = [distance(a.place, b.place) for side in (nodes, ahead) for a, b in pairwise(side)]
    if len(nodes) > 1:
        gaps += [distance(side[-1].place, side[0].place) for side in (nodes, ahead)]
    moved = max(distance(a.place, b.place) for a, b in zip(nodes, ahead, strict=True))
    return moved <= FOLLOWED * min(gaps, default=math.pi / 2)


Place = tuple[float, DoublePoint]

TURN = 2 * math.pi
FEWEST_STEPS = 2

# Parts of the interval: how exactly cusps are solved for, and up to where two transitions are
# one.
EXACT = 1e-15
SIMULTANEOUS = 1e-9


@dataclass(frozen=True)
class CuspTransition:
    """Parameter at which a coupler curve changes its number of crunodes.

    Parameters
    ----------
    kind : {"cusp", "tacnode"}
        A loop shrinks to a cusp or grows from one; or two crunodes meet or part.
    parameter : float
    position : ndarray, shape (2,)
        Of the cusp or tacnode in ground axes in m.
    crank_angles : ndarray, shape (2,)
        In rad from 0 to 2 pi, the smaller first; equal for a cusp.
    crunodes_before, crunodes_after : int
        Of the whole curve on either side of the parameter, in the order from ``start`` to
        ``stop``. Of transitions at one parameter, as in symmetric curves, each gives the
        numbers before and after all of them.
    """

    kind: Literal["cusp", "tacnode"]
    parameter: float
    position: NDArray[np.float64]
    crank_angles: NDArray[np.float64]
    crunodes_before: int
    crunodes_after: int

    @property
    def crank_angle(self) -> float:
        """Crank angle in rad: of the cusp, or the smaller one of the tacnode."""
        return float(self.crank_angles[0])


def cusp_transitions(
    family: Family,
    start: float,
    stop: float,
    steps: int = 64,
    crank_angle: float | None = None,
) -> tuple[CuspTransition, ...]:
    """Parameters of a family of linkages at which crunodes of the coupler curve come and go.

    By continuation: the double points (Hartenberg & Denavit 1964, ch. 6) are followed from
    step to step, and where one passes from a crunode to an isolated point its parameter is
    solved for. Steps are halved where double points move fast. Crunodes that vanish and come
    back within a step are found where the margin or the cubic's discriminant dips between
    two steps; in the first and the last step, and several at once, they may be missed.

    Parameters
    ----------
    family : callable
        Linkage and coupler point at a parameter, continuous in it.
    start, stop : float
        First and last parameter; ``stop`` may be the smaller.
    steps : int
        Number of steps between them; at least 2.
    crank_angle : float, optional
        A crank angle of the circuit in rad, as for :func:`flexmech.linkages.double_points`;
        of the linkage at ``start``.

    Returns
    -------
    tuple of CuspTransition
        In the order from ``start`` to ``stop``; cusps are located to 1e-12 of the interval,
        tacnodes, where two roots are one, to some 1e-11.

    Raises
    ------
    InputError
        If start and stop are not two finite numbers, there are too few steps, the Grashof
        class changes on the way, or the coupler point gets into a pin.
    ComputationError
        If double points cannot be told apart over a part of the interval.
    """
    _refuse_interval(start, stop, steps)
    path = DoublePointPath(family, start, stop, crank_angle)
    parameters = _with_dips(path, [float(p) for p in np.linspace(start, stop, steps + 1)])
    stretches = path.stretches(parameters)
    found = [cusp for stops in stretches for cusp in _cusps(path, stops)]
    for before, after in pairwise(stretches):
        found += _tacnodes(path, before[-1], after[0])
    return _counted(path, found)


def _with_dips(path: DoublePointPath, parameters: list[float]) -> list[float]:
    """Parameters, and those between where double points merge that part again in a step."""
    found = list(parameters)
    values = [path.discriminant(parameter) for parameter in parameters]
    for n in range(1, len(parameters) - 1):
        turn = _dip(path.discriminant, parameters[n - 1 : n + 2], values[n - 1 : n + 2])
        if turn is not None and turn not in found:
            found.append(turn)
    return sorted(found, key=lambda parameter: abs(parameter - path.start))


def _dip(
    function: Callable[[float], float], parameters: list[float], values: list[float]
) -> float | None:
    """Where a function of one sign at three parameters has the other between them, if it does.

    It is looked for only where the middle value is the nearest to zero; of equal neighbours
    it is the first, lest a dip be found twice.
    """
    sign = 1.0 if values[1] > 0 else -1.0
    before, here, after = (sign * value for value in values)
    if not 0 <= here <= after or not here < before:
        return None
    bounds = min(parameters), max(parameters)
    dip = minimize_scalar(lambda x: sign * function(x), bounds=bounds, method="bounded")
    return float(dip.x) if dip.fun < 0 else None


def _cusps(path: DoublePointPath, stops: list[Stop]) -> list[CuspTransition]:
    """Cusps along a stretch on which no double points merge or part."""
    found = []
    for column in range(len(stops[0][1])):
        places = [(parameter, nodes[column]) for parameter, nodes in stops]
        for bracket in (*_changes(places), *_dips(path, places)):
            found += _cusp(path, *bracket)
    return found


def _changes(places: list[Place]) -> Iterator[tuple[Place, Place]]:
    """Neighbours between which the margin changes its sign."""
    return ((a, b) for a, b in pairwise(places) if (a[1].margin > 0) != (b[1].margin > 0))


def _dips(path: DoublePointPath, places: list[Place]) -> Iterator[tuple[Place, Place]]:
    """Neighbours of parameters at which the margin has passed zero on its way back."""
    for n in range(1, len(places) - 1):
        three = places[n - 1 : n + 2]
        place = three[1][1].place
        turn = _dip(
            _margin_near(path, place), [p for p, _ in three], [node.margin for _, node in three]
        )
        if turn is not None:
            there = turn, path.nearest(turn, place)
            yield three[0], there
            yield there, three[2]


def _margin_near(path: DoublePointPath, place: float) -> Callable[[float], float]:
    return lambda parameter: path.nearest(parameter, place).margin


def _cusp(path: DoublePointPath, here: Place, there: Place) -> list[CuspTransition]:
    """Cusp between two places of one double point, if it is the circuit's."""
    inside, node = max(here, there, key=lambda place: place[1].margin)
    if not node.lies_on(path.circuit):
        return []
    margin = _margin_near(path, node.place)
    parameter = float(brentq(margin, here[0], there[0], xtol=EXACT * path.span))
    # Round-off may leave the root on the side of no attitude.
    nudged = parameter + np.sign(inside - parameter) * LOCATED * path.span
    candidates = (path.nearest(p, node.place) for p in (parameter, nudged, inside))
    cusp = next(candidate for candidate in candidates if candidate.attitudes)
    angle = _mean_angle(*(attitude.crank_angle for attitude in cusp.attitudes))
    position = np.array(path.nearest(parameter, node.place).position)
    return [CuspTransition("cusp", parameter, position, np.array([angle, angle]), 0, 0)]


def _tacnodes(path: DoublePointPath, before: Stop, after: Stop) -> list[CuspTransition]:
    """Meeting of the two double points that are on one side only, if they are crunodes."""
    parameter, three = max(before, after, key=lambda stop: len(stop[1]))
    pairs = zip(three, (*three[1:], three[0]), strict=True)
    one, two = min(pairs, key=lambda pair: distance(pair[0].place, pair[1].place))
    if not all(node.kind == "crunode" and node.lies_on(path.circuit) for node in (one, two)):
        return []
    others = [attitude.crank_angle for attitude in two.attitudes]
    angles = []
    for angle in (attitude.crank_angle for attitude in one.attitudes):
        nearest = min(others, key=lambda other: abs(math.remainder(other - angle, TURN)))
        angles.append(_mean_angle(angle, nearest))
    position = (np.array(one.position) + two.position) / 2
    return [CuspTransition("tacnode", parameter, position, np.sort(angles), 0, 0)]


def _counted(path: DoublePointPath, found: list[CuspTransition]) -> tuple[CuspTransition, ...]:
    """The transitions in order, with the crunodes counted half-way between them."""
    groups: list[list[CuspTransition]] = []
    for transition in sorted(found, key=lambda one: abs(one.parameter - path.start)):
        last = groups[-1][-1].parameter if groups else math.inf
        if abs(transition.parameter - last) > SIMULTANEOUS * path.span:
            groups.append([])
        groups[-1].append(transition)
    limits = [path.start, *(group[0].parameter for group in groups), path.stop]
    counts = [path.crunodes((p + q) / 2) for p, q in pairwise(limits)]
    return tuple(
        replace(transition, crunodes_before=before, crunodes_after=after)
        for group, (before, after) in zip(groups, pairwise(counts), strict=True)
        for transition in group
    )


def _mean_angle(angle: float, other: float) -> float:
    return full_turn(angle + math.remainder(other - angle, TURN) / 2)


def _refuse_interval(start: float, stop: float, steps: int) -> None:
    if not (math.isfinite(start) and math.isfinite(stop) and start != stop):
        raise InputError(
            f"start and stop must be two different finite parameters, got {start} and {stop}"
        )
    if steps < FEWEST_STEPS:
        raise InputError(f"at least {FEWEST_STEPS} steps are needed to follow, got {steps}")
