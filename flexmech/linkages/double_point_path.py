"""Double points of coupler curves followed along a family of linkages."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import pairwise

from flexmech.errors import ComputationError, InputError
from flexmech.linkages.circuits import Circuit, circuit_of
from flexmech.linkages.coupler_curve import CouplerPoint
from flexmech.linkages.double_points import FiniteDoublePoint, finite_double_points, focal_cubic
from flexmech.linkages.fourbar import FourBar, GrashofClass

Family = Callable[[float], tuple[FourBar, CouplerPoint]]
Nodes = tuple[FiniteDoublePoint, ...]
Stop = tuple[float, Nodes]

# Part of the interval to which mergers are located.
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
        self.circuit: Circuit = circuit_of(linkage, crank_angle)
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
        tuple of FiniteDoublePoint
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

    def nearest(self, parameter: float, place: float) -> FiniteDoublePoint:
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
        list of list of (float, tuple of FiniteDoublePoint)
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
