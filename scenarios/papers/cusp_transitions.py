"""Where a coupler curve has a cusp while its linkage changes: crunodes come or go there.

A curve's double points are the roots of a cubic (Hartenberg & Denavit 1964, ch. 6). They are
followed over a parameter from step to step; where one passes from a crunode to an isolated point
its parameter is solved for.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from flexmech import ComputationError, CouplerPoint, FourBar
from flexmech.linkages import DoublePoint, circuit_of, double_points, finite_double_points

Family = Callable[[float], tuple[FourBar, CouplerPoint]]
# Part of the interval to which a cusp is located.
LOCATED = 1e-12
# Part of a crunode's margin at a cusp: beyond, the followed double point is another one.
FOLLOWED = 1e-9


class CuspTransition(NamedTuple):
    """Parameter at which a coupler curve has a cusp.

    Parameters
    ----------
    parameter : float
    position : ndarray, shape (2,)
        Of the cusp in ground axes in m.
    crank_angle : float
        In rad from 0 to 2 pi.
    crunodes_before, crunodes_after : int
        Of the whole curve on either side of the parameter, in the order from start to stop.
    """

    parameter: float
    position: NDArray[np.float64]
    crank_angle: float
    crunodes_before: int
    crunodes_after: int


def cusp_transitions(
    family: Family, start: float, stop: float, steps: int = 64
) -> list[CuspTransition]:
    """Parameters of a family of linkages at which the coupler curve has a cusp.

    Parameters
    ----------
    family : callable
        Linkage and coupler point at a parameter, continuous in it.
    start, stop : float
        First and last parameter.
    steps : int
        Number of steps between them, over which each double point stays the nearest to itself.

    Returns
    -------
    list of CuspTransition
        In the order from ``start`` to ``stop``, located to 1e-12 of the interval.

    Raises
    ------
    ComputationError
        If a double point is lost within a step, or the number of crunodes changes elsewhere.
    """
    circuit = circuit_of(family(start)[0], None)

    def nearest(parameter: float, place: float) -> DoublePoint:
        """Double point nearest to a place on the circle of singular foci; half a turn is all."""
        return min(
            finite_double_points(*family(parameter)),
            key=lambda node: abs(math.remainder(node.place - place, math.pi)),
        )

    found = []
    for here, there in pairwise(np.linspace(start, stop, steps + 1)):
        for node in finite_double_points(*family(here)):

            def margin(parameter: float, place: float = node.place) -> float:
                return nearest(parameter, place).margin

            after = nearest(there, node.place)
            inside, crunode = max((here, node), (there, after), key=lambda end: end[1].margin)
            if (node.margin > 0) == (after.margin > 0) or not crunode.lies_on(circuit):
                continue
            parameter = float(brentq(margin, here, there, xtol=1e-15 * abs(stop - start)))
            cusp = nearest(parameter, node.place)
            if abs(cusp.margin) > FOLLOWED:
                raise ComputationError(f"a double point is lost near {parameter:g}: more steps")
            # Round-off may leave the root on the side of no attitude.
            inward = parameter + math.copysign(LOCATED * (stop - start), inside - parameter)
            nearby = (cusp, nearest(inward, node.place), crunode)
            attitudes = next(one.attitudes for one in nearby if one.attitudes)
            first, *others = (attitude.crank_angle for attitude in attitudes)
            angle = first + sum(math.remainder(o - first, 2 * math.pi) / 2 for o in others)
            found.append((parameter, np.array(cusp.position), angle % (2 * math.pi)))
    counts = []
    for a, b in pairwise([start, *(parameter for parameter, *_ in found), stop]):
        between = np.linspace(a, b, steps + 2)[1:-1]
        several = {len(double_points(*family(parameter))) for parameter in between}
        if len(several) > 1:
            raise ComputationError(f"crunodes meet between {a:g} and {b:g}, without a cusp")
        counts.append(several.pop())
    return [CuspTransition(*f, *pair) for f, pair in zip(found, pairwise(counts), strict=True)]
