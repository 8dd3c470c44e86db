"""What a hammer test is asked for, at a locked crank or a running one."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from flexmech.analyses.crank_speeds import one_rad_per_s
from flexmech.analyses.damping_ratios import DAMPING_RATIO
from flexmech.analyses.requests import check_list, in_radians
from flexmech.arrays import FloatArray
from flexmech.choices import (
    LINK_DIRECTIONS,
    MODES,
    MOST_MODES,
    MOST_SEED,
    PRESTRESS_LEVELS,
    LinkDirection,
    Prestress,
)
from flexmech.errors import InputError
from flexmech.linkages import Topology
from flexmech.mechanics import LinkPoint
from flexmech.modal_testing import IdentificationMethod
from flexmech.validation import (
    NOT_NEGATIVE,
    POSITIVE,
    check_choice,
    check_count,
    check_fields,
    check_instance,
    check_number,
)

_MIDDLE = LinkPoint("coupler", 0.5)
# Noise falls by the root of their number: more are taken for a slip of the keyboard.
_MOST_AVERAGES = 1000
# Orders to either side beyond which a crank of any speed answers nothing that can be measured.
_MOST_ORDERS = 20


@dataclass(frozen=True)
class HammerRequest:
    """A hammer test of the locked linkage.

    Parameters
    ----------
    crank_angles : array_like, shape (A,)
        At which the crank is locked, one test each; increasing, in rad.
    impact, response : LinkPoint
        Where the hammer hits and where the vibrometer looks.
    direction : {"transverse", "axial"}
        Direction of force and displacement, in the frame of each point's rigid link.
    averages : int
        Impacts over which spectra are averaged.
    bandwidth : float, optional
        Greatest frequency in Hz. Left out: a quarter above the highest of ``modes`` natural
        frequencies at any of the angles, or what the pulse given excites if that is less.
    duration : float, optional
        Duration of a record in s. Left out: until the vibration has decayed to 1e-4.
    pulse : float, optional
        Duration of the half-sine pulse in s. Left out: one over the bandwidth, at which the
        pulse's spectrum has fallen by 9.5 dB.
    noise : float
        Root mean square of noise in force and response over that of the signal.
    seed : int
        Seed of the noise.
    prestress : {"none", "axial", "equilibrium"}
        Stress of the links at rest, by their weight.
    modes : int
        Natural frequencies by which the bandwidth is chosen.
    method : {"lscf", "circle-fit"}, optional
        Method of the identification. Left out: LSCF if its package is installed.
    grid : int, optional
        Points on each link to rove the impact over, for mode shapes.

    Raises
    ------
    InputError
        If a value cannot be, or the pulse is longer than the record.

    Examples
    --------
    >>> middle = flexmech.LinkPoint.parse("coupler:0.5")
    >>> flexmech.HammerRequest(np.radians([96.9]), impact=middle, response=middle).averages
    3
    """

    crank_angles: ArrayLike
    impact: LinkPoint = _MIDDLE
    response: LinkPoint = _MIDDLE
    direction: LinkDirection = "transverse"
    averages: int = 3
    bandwidth: float | None = None
    duration: float | None = None
    pulse: float | None = None
    noise: float = 0.0
    seed: int = 0
    prestress: Prestress = "none"
    modes: int = MODES
    method: IdentificationMethod | None = None
    grid: int | None = None

    def __post_init__(self) -> None:
        angles = np.atleast_1d(in_radians("crank_angles", self.crank_angles))
        check_list("crank_angles", angles, increasing=True)
        object.__setattr__(self, "crank_angles", angles)
        _check_points(self)
        check_fields(self, {"pulse": "s"}, POSITIVE, optional=True)
        check_count(self.averages, "averages", most=_MOST_AVERAGES)
        check_count(self.seed, "seed", 0, most=MOST_SEED)
        check_number(self.noise, "noise", bounds=NOT_NEGATIVE)
        check_count(self.modes, "modes", most=MOST_MODES)
        if self.grid is not None:
            check_count(self.grid, "grid", 2, "points a link")
        if self.pulse is not None and self.duration is not None and self.pulse >= self.duration:
            raise InputError(
                f"the pulse of {self.pulse:g} s is longer than the record of {self.duration:g} s; "
                "give a shorter pulse or a longer duration"
            )

    @property
    def angles(self) -> FloatArray:
        """Crank angles in rad, shape (A,)."""
        return np.asarray(self.crank_angles, dtype=float)


@dataclass(frozen=True)
class RunningHammerRequest:
    """What a force on the linkage at a constant crank speed is asked to answer.

    Parameters
    ----------
    crank_speed : float
        In ``speed_unit``, not zero.
    impact, response : LinkPoint
        Where the force acts, and where the displacement is read; the middle of the coupler.
    direction : {"transverse", "axial"}
        Direction of both, in the axes of their links' rigid frames.
    prestress : {"none", "axial", "equilibrium"}
        Stress of the running links.
    damping_ratio : float, optional
        Z from 0 on and less than 1: the Kelvin-Voigt time of all links is 2 Z/omega_1, with the
        first natural frequency at rest averaged over the turn. Left out: the model's damping.
    orders : int
        N: harmonic transfer functions of the orders -N to N are asked for.
    bandwidth : float, optional
        Highest frequency of the force in Hz. Left out: twice the first natural frequency at
        rest, averaged over the turn.
    duration : float, optional
        Duration of a record in s, made longer to a whole number of turns: one over the distance of
        two frequencies. Left out: until an impact has decayed to 1e-4.
    speed_unit : str, optional
        Unit of the crank speed, such as ``"rpm"``, in which results speak of it. Left out: rad/s.

    Raises
    ------
    InputError
        If a value is impossible.

    Examples
    --------
    >>> point = flexmech.LinkPoint.parse("coupler:0.5")
    >>> flexmech.RunningHammerRequest(20.0, point, point, damping_ratio=0.005).orders
    2
    """

    crank_speed: float
    impact: LinkPoint = _MIDDLE
    response: LinkPoint = _MIDDLE
    direction: LinkDirection = "transverse"
    prestress: Prestress = "equilibrium"
    damping_ratio: float | None = None
    orders: int = 2
    bandwidth: float | None = None
    duration: float | None = None
    speed_unit: str | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        _ = self.speed
        if self.crank_speed == 0:
            raise InputError(
                "crank_speed is zero, at which nothing turns; ask for a hammer test at rest "
                "(flexmech.hammer_test, or flexmech hammer without --running)"
            )
        _check_points(self)
        if self.damping_ratio is not None:
            check_number(self.damping_ratio, "damping_ratio", bounds=DAMPING_RATIO)
        check_count(self.orders, "orders", most=_MOST_ORDERS)

    @cached_property
    def speed(self) -> float:
        """Crank speed in rad/s."""
        return one_rad_per_s(self.crank_speed, self.speed_unit)


def middle_of(topology: Topology) -> LinkPoint:
    """Middle of the coupler, or of the last link where there is none: where a hammer hits."""
    names = topology.link_names
    return _MIDDLE if _MIDDLE.link in names else LinkPoint(names[-1], _MIDDLE.fraction)


def _check_points(request: HammerRequest | RunningHammerRequest) -> None:
    """Refuse points, directions, levels of prestress and bands that are none."""
    for name in ("impact", "response"):
        point = getattr(request, name)
        check_instance(point, LinkPoint, name, "write flexmech.LinkPoint.parse('coupler:0.5')")
    check_choice(request.direction, LINK_DIRECTIONS, "direction")
    check_choice(request.prestress, PRESTRESS_LEVELS, "prestress")
    check_fields(request, {"bandwidth": "Hz", "duration": "s"}, POSITIVE, optional=True)
