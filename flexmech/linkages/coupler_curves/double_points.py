r"""Double points of a coupler curve, exactly: crunodes and cusps.

A double point E is reached with the coupler in two attitudes. A and its second place are then
mirror images in the line O2-E, since both lie on the circles about O2 and about E; so are B and
its second place in O4-E. The coupler turns by the same angle about E whichever pin is looked
at, so that E sees O2-O4 under the angle epsilon from E-A to E-B, or epsilon plus pi: the finite
double points lie on the *circle of singular foci* through O2 and O4 (Hartenberg & Denavit 1964,
ch. 6; Hunt, Kinematic Geometry of Mechanisms, 1978).

With d the ground, a, c crank and rocker, e = E-A, f = E-B, and signed distances rho2 from O2
along the direction eta and rho4 from O4 along eta + epsilon, the place is
E = rho2 (cos eta, sin eta), where

    rho2 = d sin(eta + epsilon) / sin(epsilon),    rho4 = d sin(eta) / sin(epsilon).

tan eta = w sin epsilon keeps both finite where epsilon = 0, E lies on the line A-B and the circle
becomes the ground's line:

    rho2 = d (1 + w cos epsilon) / q,    rho4 = d w / q,    q^2 = 1 + w^2 sin^2 epsilon.

E-A makes the angle +kappa with eta in one attitude and -kappa in the other, and E-B the same
with eta + epsilon. The circles of A and B ask for

    cos kappa = (a^2 - e^2 - rho2^2) / (2 e rho2) = (c^2 - f^2 - rho4^2) / (2 f rho4),

a cubic in w:

    ((a^2 - e^2) q^2 - d^2 (1 + w cos epsilon)^2) f w
        = ((c^2 - f^2) q^2 - d^2 w^2) e (1 + w cos epsilon).

Each real root with \|cos kappa\| < 1 is a crunode if the linkage passes from one attitude to the
other without being taken apart, and else a place where two curves cross. Where \|cos kappa\| = 1
the attitudes are one, E is the coupler's instant centre, and the point stands still: a cusp.
Where \|cos kappa\| > 1 the point is isolated (an acnode) and no attitude reaches it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.errors import InputError
from flexmech.linkages.coupler_curves.curve import CouplerPoint, CouplerTriangle
from flexmech.linkages.coupler_curves.focal_cubic import FocalCubic
from flexmech.linkages.fourbar import FourBar
from flexmech.validation import check_instance

Circuit = Literal["open", "crossed", "upper", "lower", "whole"]
CrankMotion = Literal["turns", "swings in two ranges", "swings in one range"]


@lru_cache(maxsize=16)
def crank_motion(linkage: FourBar) -> CrankMotion:
    """Range of the crank's motion, which distinguishes the circuits.

    Parameters
    ----------
    linkage : FourBar

    Returns
    -------
    {"turns", "swings in two ranges", "swings in one range"}
        A full turn on either branch (crank-rocker and double-crank); between limits on either
        side of the ground's line, over both branches (double-rocker and rocker-crank); or over
        both branches between limits on one circuit (triple-rocker).

    Raises
    ------
    InputError
        If the linkage has a change point, where circuits meet.
    """
    grashof_class = linkage.grashof_class
    if grashof_class == "change-point":
        raise InputError(
            "the linkage has a change point (shortest and longest link together are as long as "
            "the other two): its circuits meet there and cannot be distinguished; change a link "
            "length slightly"
        )
    if grashof_class in ("crank-rocker", "double-crank"):
        return "turns"
    return "swings in one range" if grashof_class == "triple-rocker" else "swings in two ranges"


def circuit_of(linkage: FourBar, crank_angle: float | None = None) -> Circuit:
    """Name of the circuit in which a linkage moves.

    Parameters
    ----------
    linkage : FourBar
    crank_angle : float, optional
        A crank angle of the circuit in rad, where the crank swings within two ranges; without
        it the one above the ground's line is meant. Otherwise without effect.

    Returns
    -------
    {"open", "crossed", "upper", "lower", "whole"}
        The branch of a crank that turns fully, the side of the ground's line of one that swings
        in two ranges, or the only circuit.

    Raises
    ------
    InputError
        If the linkage has a change point or cannot be assembled at the crank angle.
    """
    motion = crank_motion(linkage)
    if motion == "turns":
        return linkage.branch
    if motion == "swings in one range":
        return "whole"
    if crank_angle is None:
        return "upper"
    linkage.transmission_angle(crank_angle)
    return "upper" if math.sin(crank_angle) > 0 else "lower"


def circuit_of_position(
    linkage: FourBar, motion: CrankMotion, pin: tuple[float, float], coupler_angle: float
) -> Circuit:
    """Name of the circuit to which a position of the linkage belongs.

    Parameters
    ----------
    linkage : FourBar
        Its branch is without effect.
    motion : {"turns", "swings in two ranges", "swings in one range"}
        As :func:`crank_motion` gives it.
    pin : tuple of two floats
        Place of pin A in m.
    coupler_angle : float
        Angle theta3 in rad.

    Returns
    -------
    {"open", "crossed", "upper", "lower", "whole"}
    """
    if motion == "turns":
        to_o4 = linkage.ground - pin[0]
        left = to_o4 * math.sin(coupler_angle) + pin[1] * math.cos(coupler_angle)
        return "open" if left > 0 else "crossed"
    if motion == "swings in two ranges":
        return "upper" if pin[1] > 0 else "lower"
    return "whole"


# The loop of a crunode is about margin^1.5 of the linkage in size: below this margin it is
# smaller than the round-off of a place, and crunode, cusp and acnode are one.
CUSP_MARGIN = 1e-10


class Attitude(NamedTuple):
    """Configuration of the linkage at a double point.

    Parameters
    ----------
    crank_angle, coupler_angle : float
        In rad.
    circuit : Circuit
    """

    crank_angle: float
    coupler_angle: float
    circuit: Circuit


@dataclass(frozen=True)
class DoublePoint:
    r"""Real double point of a coupler curve: a crunode, a cusp or an acnode.

    Parameters
    ----------
    place : float
        Where on the circle of singular foci: arctan w, from -pi/2 to pi/2, the ends being one
        point.
    position : ndarray, shape (2,)
        In ground axes in m.
    margin : float
        1 - \|cos kappa\| over the square of crank / (E-A) or rocker / (E-B) where that is less
        than one: positive for a crunode, zero for a cusp, negative for an acnode.
    attitudes : tuple of Attitude
        Of the two passages, that with the smaller crank angle first; none of an acnode.
    """

    place: float
    position: FloatArray
    margin: float
    attitudes: tuple[Attitude, ...]

    @property
    def kind(self) -> Literal["crunode", "cusp", "acnode"]:
        """Self-intersection, point of zero speed or isolated point: by the margin in round-off."""
        if abs(self.margin) <= CUSP_MARGIN:
            return "cusp"
        return "crunode" if self.margin > 0 else "acnode"

    @property
    def crank_angles(self) -> FloatArray:
        """Crank angles of the two passages in rad, from 0 to 2 pi, ascending; equal for a cusp."""
        return np.array([attitude.crank_angle for attitude in self.attitudes])

    @property
    def coupler_angles(self) -> FloatArray:
        """Angles theta3 of the coupler at those crank angles in rad, from 0 to 2 pi.

        They tell the branch where the crank cannot turn fully and a curve runs over both.
        """
        return np.array([attitude.coupler_angle for attitude in self.attitudes])

    def lies_on(self, circuit: Circuit) -> bool:
        """Whether both attitudes belong to a circuit."""
        return bool(self.attitudes) and all(a.circuit == circuit for a in self.attitudes)


def double_points(
    linkage: FourBar, point: CouplerPoint, crank_angle: float | None = None
) -> tuple[DoublePoint, ...]:
    """Crunodes and cusps of the curve that a coupler point traces, without a search.

    The curve is that of one circuit: what the linkage reaches without being taken apart. With
    a crank that turns fully it is the linkage's branch; with a crank that swings, both branches
    between two limit positions. The roots of the cubic in the module's text (Hartenberg &
    Denavit 1964, ch. 6), at most three.

    Parameters
    ----------
    linkage : FourBar
    point : CouplerPoint
        A point in pin A or B has a circle or an arc for its curve, and no double points.
    crank_angle : float, optional
        A crank angle of the circuit in rad, where the crank swings within two separate ranges;
        without it the range above the ground's line is meant. Otherwise without effect.

    Returns
    -------
    tuple of DoublePoint
        By their first crank angle.

    Raises
    ------
    InputError
        If the linkage has a change point, where circuits meet, or cannot be assembled at
        ``crank_angle``.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/neat_resin_figure_8.toml")
    >>> points = flexmech.double_points(mechanism.linkage, mechanism.coupler_point, 0.0)
    >>> [point.kind for point in points]
    ['crunode']
    """
    _check_coupler(linkage, point)
    circuit = circuit_of(linkage, crank_angle)
    found = (node for node in finite_double_points(linkage, point) if node.lies_on(circuit))
    return tuple(sorted(found, key=lambda node: node.attitudes))


def finite_double_points(linkage: FourBar, point: CouplerPoint) -> tuple[DoublePoint, ...]:
    """Real double points of the sextic: of every circuit, between circuits, and isolated ones.

    Parameters
    ----------
    linkage : FourBar
        Its branch is without effect.
    point : CouplerPoint

    Returns
    -------
    tuple of DoublePoint
        One or three by growing place; none of a point in a pin.

    Raises
    ------
    InputError
        If the linkage has a change point.
    """
    _check_coupler(linkage, point)
    motion = crank_motion(linkage)
    cubic = focal_cubic(linkage, point)
    near, far, *_ = cubic.triangle
    if min(near, far) <= ROUND_OFF * linkage.coupler:  # the point is in a pin
        return ()
    return tuple(_node(linkage, point, cubic.triangle, motion, place) for place in cubic.roots())


def _check_coupler(linkage: object, point: object) -> None:
    check_instance(linkage, FourBar, "linkage", "give a flexmech.FourBar")
    check_instance(point, CouplerPoint, "point", "give a flexmech.CouplerPoint")


def focal_cubic(linkage: FourBar, point: CouplerPoint) -> FocalCubic:
    """Cubic whose roots are the double points; its discriminant tells how many are real."""
    # NumPy's scalars, where the lengths come from an array, take three times as long.
    d, a, b, c = (float(length) for length in linkage.lengths.values())
    return FocalCubic(d, a, c, CouplerTriangle(*map(float, point.triangle(b))))


def _node(
    linkage: FourBar,
    point: CouplerPoint,
    triangle: CouplerTriangle,
    motion: CrankMotion,
    place: float,
) -> DoublePoint:
    t, s = math.sin(place), math.cos(place)
    scale = math.hypot(s, triangle.sine * t)
    along = (s / scale, triangle.sine * t / scale)
    to_o2 = linkage.ground * (s + triangle.cosine * t) / scale
    to_o4 = linkage.ground * t / scale
    # The side with the longer arms keeps its meaning where E is in O2 or O4.
    if triangle.near * abs(to_o2) >= triangle.far * abs(to_o4):
        less, more = _versines(linkage.crank, triangle.near, to_o2)
    else:
        less, more = _versines(linkage.rocker, triangle.far, to_o4)
    position = (to_o2 * along[0], to_o2 * along[1])
    # Far from the pins kappa is small by itself.
    longest = max(1.0, triangle.near / linkage.crank, triangle.far / linkage.rocker)
    margin = min(less, more) * longest**2
    attitudes: tuple[Attitude, ...] = ()
    if margin >= -CUSP_MARGIN:
        kappa = 2 * math.atan2(math.sqrt(max(less, 0.0)), math.sqrt(max(more, 0.0)))
        if margin <= CUSP_MARGIN:
            kappa = math.pi * round(kappa / math.pi)
        eta = math.atan2(along[1], along[0])
        turned = (eta + kappa, eta - kappa)
        attitudes = tuple(sorted(_attitude(linkage, point, motion, position, x) for x in turned))
    return DoublePoint(place, np.array(position), margin, attitudes)


def _versines(radius: float, arm: float, distance: float) -> tuple[float, float]:
    """1 - cos kappa and 1 + cos kappa, without the difference of nearly equal squares."""
    scale = 2 * arm * distance
    reach = arm + distance
    gap = distance - arm
    return (
        (reach - radius) * (reach + radius) / scale,
        (radius - gap) * (radius + gap) / scale,
    )


def _attitude(
    linkage: FourBar,
    point: CouplerPoint,
    motion: CrankMotion,
    position: tuple[float, float],
    to_pin: float,
) -> Attitude:
    """Configuration in which E-A has a given direction."""
    a_x = position[0] + point.distance * math.cos(to_pin)
    a_y = position[1] + point.distance * math.sin(to_pin)
    coupler_angle = full_turn(to_pin + math.pi - point.angle)
    circuit = circuit_of_position(linkage, motion, (a_x, a_y), coupler_angle)
    return Attitude(full_turn(math.atan2(a_y, a_x)), coupler_angle, circuit)


def full_turn(angle: float) -> float:
    """The angle from 0 to 2 pi, the latter excluded."""
    turned = angle % (2 * math.pi)
    return turned if turned < 2 * math.pi else 0.0
