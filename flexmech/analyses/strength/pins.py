"""Pins, the eyes around them and bushes: which checks a mechanism's data allow, and factors.

Shigley's *Mechanical Engineering Design*, 9th ed.: sec. 8-12 on joints loaded in shear (bearing,
tension of the net section, shear-out of the edge), sec. 12-15 on boundary-lubricated bushes.
Stresses are mean ones of their areas: the concentration at the hole's edge and Hertz's pressure are
not in them.

The speed may rise until what a check counts reaches its bound. The force at s times the speed is
F0 + s^2 F1: what acts at rest, and inertia; vectors are over what is allowed, so that the bound is
1. Functions of forces take scalars or arrays of one shape.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.strength.joint_loads import JointLoads
from flexmech.arrays import FloatArray, IntArray
from flexmech.linkages import LinkEnd, Topology
from flexmech.mechanism import JointPin, Mechanism


def speed_of_force(still: FloatArray, growing: FloatArray) -> FloatArray:
    """Speed factor at which a force reaches its bound, ``|F0 + s^2 F1| = 1``.

    Parameters
    ----------
    still, growing : ndarray, shape (..., 2)
        F0 and F1 over the allowed force.

    Returns
    -------
    ndarray, shape (...)
        Zero where the force at rest is too large already, infinite where it never is.
    """
    square, _ = _crossing(still, growing)
    return _of_square(square, np.hypot(still[..., 0], still[..., 1]))


def speed_of_pull(still: FloatArray, growing: FloatArray) -> FloatArray:
    """The same of the part of a force that tears at an eye, :func:`tearing_force`.

    Parameters
    ----------
    still, growing : ndarray, shape (..., 2)
        F0 and F1 over the allowed force: away from the link along its axis, and across.

    Returns
    -------
    ndarray, shape (...)
    """
    whole, pulls = _crossing(still, growing)
    alone, _ = _crossing(still * (0.0, 1.0), growing * (0.0, 1.0))
    # The part is convex in s^2: it leaves the bound once, while it pulls or while it pushes.
    return _of_square(np.where(pulls, whole, alone), tearing_force(still))


def tearing_force(force: FloatArray) -> FloatArray:
    """Size of a pin's force on an eye without what pushes the eye onto its link.

    Parameters
    ----------
    force : ndarray, shape (..., 2)
        Away from the link along its axis, and across.

    Returns
    -------
    ndarray, shape (...)
        The whole force where it pulls, its part across the link where it pushes: an eye that is
        rounded about the hole bears alike in all these directions.
    """
    return np.asarray(np.hypot(np.maximum(force[..., 0], 0.0), force[..., 1]))


def speed_of_wear(still: FloatArray, growing: FloatArray) -> FloatArray:
    """Speed factor at which force times sliding velocity reaches its bound.

    The velocity grows with s, so that it is at ``s |F0 + s^2 F1| = 1``: with inertia alone the cube
    root of the load factor. Squared it is a cubic equation in 1 / s^2, solved in closed form.

    Parameters
    ----------
    still, growing : ndarray, shape (..., 2)
        F0 and F1 over the force that is allowed at the speed itself.

    Returns
    -------
    ndarray, shape (...)
        Infinite where it never is.
    """
    first, both, second = _products(still, growing)
    # w^3 - |F0|^2 w^2 - 2 F0.F1 w - |F1|^2 = 0 with w = 1 / s^2, whose largest root comes first;
    # w = x + shift takes the square out of it.
    shift = first / 3
    linear = -3 * shift**2 - 2 * both
    constant = -2 * shift**3 - 2 * both * shift - second
    root = _largest_root(linear, constant) + shift
    with np.errstate(divide="ignore"):
        return np.asarray(1 / np.sqrt(np.maximum(root, 0.0)))


def _largest_root(linear: FloatArray, constant: FloatArray) -> FloatArray:
    """Largest real root of ``x^3 + linear x + constant``, by Cardano and by Viete."""
    half, third = constant / 2, linear / 3
    under = half**2 + third**3
    one = under > 0
    # One real root: the cube root without cancellation, and the other one by their product.
    large = -np.cbrt(half + np.copysign(np.sqrt(np.where(one, under, 0.0)), half))
    with np.errstate(divide="ignore", invalid="ignore"):
        small = np.where(large == 0, 0.0, -third / large)
        # Three: linear is negative, or all are zero.
        size = np.sqrt(np.maximum(-third, 0.0))
        cosine = np.where(size == 0, 0.0, -half / size**3)
    three = 2 * size * np.cos(np.arccos(np.clip(cosine, -1.0, 1.0)) / 3)
    return np.where(one, large + small, three)


def _products(still: FloatArray, growing: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Scalar products of F0 with itself, of both, and of F1 with itself."""
    first, both = np.sum(still * still, axis=-1), np.sum(still * growing, axis=-1)
    return first, both, np.sum(growing * growing, axis=-1)


def _crossing(still: FloatArray, growing: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Largest s^2 at which ``|F0 + s^2 F1| = 1``, and whether it is one at which F pulls.

    Infinite where the force does not grow; negative or not a number where there is none.
    """
    first, both, second = _products(still, growing)
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(both**2 + second * (1 - first))
        # Either form of the root of the quadratic equation, without cancellation.
        square = np.where(both > 0, (1 - first) / (both + root), (root - both) / second)
        square = np.where(second == 0, np.where(first <= 1, np.inf, np.nan), square)
        along = np.where(
            growing[..., 0] == 0, still[..., 0], still[..., 0] + square * growing[..., 0]
        )
    return square, (square >= 0) & (along >= 0)


def _of_square(square: FloatArray, at_rest: FloatArray) -> FloatArray:
    """Root of s^2; none is left where the force at rest is beyond its bound."""
    with np.errstate(invalid="ignore"):
        return np.where(at_rest > 1, 0.0, np.sqrt(square))


Number = TypeVar("Number", float, FloatArray)

SHEAR_YIELD = 1 / math.sqrt(3)
"""Yield strength in shear over that in tension, by von Mises."""


def bearing_pressure(force: Number, diameter: float, thickness: float) -> Number:
    """Force over the projected area of a pin in its hole, F / (d t), in Pa.

    Parameters
    ----------
    force : float or ndarray
        In N.
    diameter : float
        Diameter of the pin in m.
    thickness : float
        Length of the hole along the pin in m.

    Returns
    -------
    float or ndarray
    """
    return force / (diameter * thickness)


def net_tension(force: Number, width: float, diameter: float, thickness: float) -> Number:
    """Force over the two sides of an eye beside its hole, F / ((w - d) t), in Pa.

    Parameters
    ----------
    force : float or ndarray
        That pulls the pin away from the link in N.
    width : float
        Width of the eye in m.
    diameter : float
    thickness : float

    Returns
    -------
    float or ndarray
    """
    return force / ((width - diameter) * thickness)


def shear_out(force: Number, edge_distance: float, diameter: float, thickness: float) -> Number:
    """Force over the two planes along which a pin tears out, F / (2 (e - d / 2) t), in Pa.

    The planes touch the hole's sides; they are counted from its edge on, and not from its centre,
    which is on the safe side.

    Parameters
    ----------
    force : float or ndarray
        That pulls the pin away from the link in N.
    edge_distance : float
        From the centre of the hole to the end of the link in m.
    diameter : float
    thickness : float

    Returns
    -------
    float or ndarray
    """
    return force / (2 * (edge_distance - diameter / 2) * thickness)


def pressure_velocity(force: Number, rate: Number, diameter: float, length: float) -> Number:
    """Bearing pressure times sliding velocity of a bush, F / (d L) times rate d / 2, in Pa m/s.

    Parameters
    ----------
    force : float or ndarray
        In N.
    rate : float or ndarray
        Size of the angular velocity of the pin in the bush in rad/s.
    diameter : float
        Diameter of the pin in m.
    length : float
        Length of the bush in m.

    Returns
    -------
    float or ndarray
    """
    return bearing_pressure(force, diameter, length) * (rate * (diameter / 2))


PinMode = Literal["bearing yield", "bearing pressure", "net tension", "shear-out", "p v"]
TEARING: tuple[PinMode, ...] = ("net tension", "shear-out")
"""Checks of what tears at an eye."""
BY_YIELD: tuple[PinMode, ...] = ("bearing yield", *TEARING)
"""Checks against the yield strength of the link."""
WANT = "because {} is missing"
INSIDE = "because the hole is not at an end of the link"


@dataclass(frozen=True)
class PinCheck:
    """A stress at a pin against what is allowed.

    Parameters
    ----------
    joint : str
    mode : str
        How the pin or the eye would fail.
    stress : float
        By a force of 1 N, in Pa; of p v by 1 N at 1 rad/s, in Pa m/s.
    allowable : float
        In Pa, or in Pa m/s.
    end : LinkEnd, optional
        End of the link whose eye it is; None of the bush.
    """

    joint: str
    mode: PinMode
    stress: float
    allowable: float
    end: LinkEnd | None = None

    @property
    def link(self) -> str:
        """Link whose eye it is; empty of the bush."""
        return "" if self.end is None else self.end.link


@dataclass(frozen=True)
class LeftOut:
    """Checks of a pin that are not made.

    Parameters
    ----------
    joint : str
    modes : tuple of str
    why : str
        In words that follow "left out".
    link : str
        Whose eye it is; empty of the bush.
    """

    joint: str
    modes: tuple[PinMode, ...]
    why: str
    link: str = ""


@dataclass(frozen=True)
class PinChecks:
    """Checks of all pins of a mechanism.

    Parameters
    ----------
    made : tuple of PinCheck
    left_out : tuple of LeftOut
        Left out of joints that state a diameter.
    without_diameter : tuple of str
        Pins, pivots and sliders that state none.
    """

    made: tuple[PinCheck, ...]
    left_out: tuple[LeftOut, ...]
    without_diameter: tuple[str, ...]

    @property
    def left_out_lines(self) -> list[str]:
        """Checks that are left out and the reasons, a line for each reason."""
        places: dict[tuple[str, str], dict[str, list[str]]] = {}
        for one in self.left_out:
            of_reason = places.setdefault((", ".join(one.modes), one.why), {})
            of_reason.setdefault(one.joint, []).extend([one.link] if one.link else [])
        return [
            f"pins: {modes} not checked {why}: "
            + ", ".join(
                f"{joint} ({', '.join(links)})" if links else joint
                for joint, links in joints.items()
            )
            for (modes, why), joints in places.items()
        ]

    @classmethod
    def of(cls, mechanism: Mechanism) -> PinChecks:
        """Find the checks that a mechanism's data allow.

        Parameters
        ----------
        mechanism : Mechanism
            In its state.

        Returns
        -------
        PinChecks
        """
        found = [one for pin in mechanism.joint_pins for one in _checks_of(mechanism, pin)]
        stated = {pin.joint for pin in mechanism.joint_pins}
        joints = mechanism.linkage.topology.turning_ends
        return cls(
            tuple(one for one in found if isinstance(one, PinCheck)),
            tuple(one for one in found if isinstance(one, LeftOut)),
            tuple(joint for joint in joints if joint not in stated),
        )


def _checks_of(mechanism: Mechanism, pin: JointPin) -> Iterator[PinCheck | LeftOut]:
    topology = mechanism.linkage.topology
    ends = [end for end in topology.turning_ends[pin.joint] if end is not None]
    slides = any(slider.joint == pin.joint for slider in topology.sliders)
    if slides and _is_inside(topology, ends[0]):
        # The forces of its block on the link and of its beams on each other are not separated.
        every: tuple[PinMode, ...] = ("bearing pressure", *BY_YIELD, "p v")
        yield LeftOut(pin.joint, every, INSIDE, ends[0].link)
        return
    holes = {end: _thickness(mechanism, pin, end) for end in ends}
    for end, thickness in holes.items():
        if thickness is not None:
            yield from _checks_of_eye(mechanism, pin, end, thickness)
        else:
            yield LeftOut(
                pin.joint, ("bearing pressure", *BY_YIELD), WANT.format("eye_thickness"), end.link
            )
    known = [thickness for thickness in holes.values() if thickness is not None]
    length = pin.bush_length or min(known, default=None)
    if pin.allowable_pv is None:
        yield LeftOut(pin.joint, ("p v",), WANT.format("allowable_pv"))
    elif length is None:
        yield LeftOut(pin.joint, ("p v",), WANT.format("bush_length"))
    else:
        stress = pressure_velocity(1.0, 1.0, pin.diameter, length)
        yield PinCheck(pin.joint, "p v", stress, pin.allowable_pv)


def _checks_of_eye(
    mechanism: Mechanism, pin: JointPin, end: LinkEnd, thickness: float
) -> Iterator[PinCheck | LeftOut]:
    pressure = bearing_pressure(1.0, pin.diameter, thickness)
    strength = _yield_strength(mechanism, end.link)
    if pin.allowable_bearing_pressure is not None:
        allowed = pin.allowable_bearing_pressure
        yield PinCheck(pin.joint, "bearing pressure", pressure, allowed, end)
    elif isinstance(strength, str):
        missing = WANT.format("allowable_bearing_pressure")
        yield LeftOut(pin.joint, ("bearing pressure",), missing, end.link)
    if isinstance(strength, str):
        yield LeftOut(pin.joint, BY_YIELD, strength, end.link)
        return
    yield PinCheck(pin.joint, "bearing yield", pressure, strength, end)
    if _is_inside(mechanism.linkage.topology, end):
        yield LeftOut(pin.joint, TEARING, INSIDE, end.link)
        return
    width, edge = _width(mechanism, pin, end), pin.eye(end.link).edge_distance
    if width is None:
        yield LeftOut(pin.joint, ("net tension",), WANT.format("eye_width"), end.link)
    else:
        stress = net_tension(1.0, width, pin.diameter, thickness)
        yield PinCheck(pin.joint, "net tension", stress, strength, end)
    if edge is None:
        yield LeftOut(pin.joint, ("shear-out",), WANT.format("eye_edge_distance"), end.link)
    else:
        stress = shear_out(1.0, edge, pin.diameter, thickness)
        yield PinCheck(pin.joint, "shear-out", stress, SHEAR_YIELD * strength, end)


def _is_inside(topology: Topology, end: LinkEnd) -> bool:
    """Whether a beam goes on at its end in another one."""
    return any(end in (weld.leader, weld.follower) for weld in topology.welds)


def _thickness(mechanism: Mechanism, pin: JointPin, end: LinkEnd) -> float | None:
    """Length of a hole, as stated or as the link's section has it; None where it has no layers."""
    stated, layers = pin.eye(end.link).thickness, mechanism.layers_of(end.link)
    if stated is not None or layers is None:
        return stated
    return layers.width


def _width(mechanism: Mechanism, pin: JointPin, end: LinkEnd) -> float | None:
    """Width of an eye; None where none is stated and the link itself is narrower than the pin."""
    stated, section = pin.eye(end.link).width, mechanism.sections.get(end.link)
    if stated is not None or section is None or section.in_plane_thickness <= pin.diameter:
        return stated
    return section.in_plane_thickness


def _yield_strength(mechanism: Mechanism, link: str) -> float | str:
    """Yield strength of a link of one isotropic material, or why there is none."""
    layers = mechanism.layers_of(link)
    if layers is None:
        return "because the material of the link is unknown"
    (ply, *others) = {layer.ply for layer in layers.laminate.layers}
    if others or ply.isotropic_material is None:
        return "because strengths of plies do not give that of an eye"
    if ply.yield_strength is None:
        return WANT.format("yield_strength of the material")
    return ply.yield_strength


Size = Callable[[FloatArray], FloatArray]
SpeedOf = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True)
class JudgedPins:
    """Stress and factors of each check, at every crank angle.

    Parameters
    ----------
    stresses : ndarray, shape (c, A)
        In Pa, or in Pa m/s.
    load_factors, speed_factors : ndarray, shape (c, A)
        Speed factors are not numbers where they do not follow.
    """

    stresses: FloatArray
    load_factors: FloatArray
    speed_factors: FloatArray

    @property
    def stress(self) -> FloatArray:
        """Greatest stress of each check, (c,)."""
        return np.asarray(self.stresses.max(axis=1))

    @property
    def worst(self) -> IntArray:
        """Number of the crank angle at which the stress of each check is greatest, (c,)."""
        return np.asarray(self.stresses.argmax(axis=1))

    @property
    def load_factor(self) -> FloatArray:
        """Least load factor of each check, (c,)."""
        return np.asarray(self.load_factors.min(axis=1))

    @property
    def speed_factor(self) -> FloatArray:
        """Least speed factor of each check, (c,)."""
        return np.asarray(self.speed_factors.min(axis=1))

    @property
    def fastest(self) -> IntArray:
        """Number of the crank angle at which the speed factor of each check is least, (c,)."""
        return np.asarray(self.speed_factors.argmin(axis=1))


def judge_pins(
    checks: Sequence[PinCheck], loads: JointLoads, static: JointLoads | None
) -> JudgedPins:
    """Judge pins over the turn.

    Parameters
    ----------
    checks : sequence of PinCheck
    loads : JointLoads
        At A crank angles.
    static : JointLoads or None
        Forces that do not grow with the square of the speed, in the same positions; None where the
        rest does not either, and no speed factor follows.

    Returns
    -------
    JudgedPins
    """
    stress = np.zeros((len(checks), len(loads.force)))
    speed = np.full_like(stress, np.nan)
    for number, check in enumerate(checks):
        size, speed_of = _GROWTH.get(check.mode, (_length, speed_of_force))
        acting = _acting(check, loads, loads)
        stress[number] = check.stress * size(acting)
        if static is not None:
            still = _acting(check, static, loads)
            over = check.stress / check.allowable
            speed[number] = speed_of(over * still, over * (acting - still))
    allowable = np.array([check.allowable for check in checks])
    with np.errstate(divide="ignore"):
        return JudgedPins(stress, allowable[:, None] / stress, speed)


def _acting(check: PinCheck, loads: JointLoads, running: JointLoads) -> FloatArray:
    """Force that a check counts, (A, 2); of a bush times the rate at which it runs."""
    if check.end is None:
        return loads.vector(check.joint) * running.turning(check.joint)[:, None]
    return loads.on_eye(check.end)


def _length(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(vectors[..., 0], vectors[..., 1]))


# How large what a check counts is, and at which speed it reaches its bound.
_GROWTH: dict[PinMode, tuple[Size, SpeedOf]] = {
    **dict.fromkeys(TEARING, (tearing_force, speed_of_pull)),
    "p v": (_length, speed_of_wear),
}
