"""Request of a hammer test, at a locked crank or a running one."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from flexmech.analyses.crank_speeds import asked_speeds, in_unit, one_rad_per_s
from flexmech.analyses.damping_ratios import DAMPING_RATIO
from flexmech.analyses.options import HammerOptions, RunningHammerOptions
from flexmech.analyses.requests import check_list, in_radians
from flexmech.arrays import FloatArray
from flexmech.choices import MOST_MODES, Prestress
from flexmech.crank_values import GREATEST
from flexmech.errors import InputError, naming
from flexmech.linkages import Topology
from flexmech.mechanics import LinkPoint
from flexmech.mechanism import Mechanism
from flexmech.validation import (
    NOT_NEGATIVE,
    POSITIVE,
    check_count,
    check_fields,
    check_instance,
    check_number,
)

_MIDDLE = LinkPoint("coupler", 0.5)
# Orders to either side beyond which a crank of any speed answers nothing that can be measured.
_MOST_ORDERS = 20


class HammerRequest(HammerOptions):
    """A hammer test of the locked linkage, checked.

    Parameters as for :class:`flexmech.analyses.options.HammerOptions`.

    Raises
    ------
    InputError
        If a value cannot be, or the pulse is longer than the record.

    Examples
    --------
    >>> middle = flexmech.LinkPoint.parse("coupler:0.5")
    >>> HammerRequest(np.radians([96.9]), impact=middle).averages
    3
    """

    # As they are at a mechanism; see at_points.
    crank_angles: FloatArray
    impact: LinkPoint
    response: LinkPoint
    prestress: Prestress

    def __post_init__(self) -> None:
        super().__post_init__()
        angles = np.atleast_1d(in_radians("crank_angles", self.crank_angles))
        check_list("crank_angles", angles, increasing=True)
        object.__setattr__(self, "crank_angles", angles)
        object.__setattr__(self, "prestress", self.prestress or "none")
        _check_force(self)
        check_fields(self, {"pulse": "s"}, POSITIVE, optional=True)
        check_number(self.noise, "noise", bounds=NOT_NEGATIVE)
        check_count(self.modes, "modes", most=MOST_MODES)
        if self.pulse is not None and self.duration is not None and self.pulse >= self.duration:
            raise InputError(
                f"pulse, duration: the pulse of {self.pulse:g} s is longer than the record of "
                f"{self.duration:g} s; give a shorter pulse or a longer duration"
            )


class RunningHammerRequest(RunningHammerOptions):
    """Checked request of the response to a force on the linkage at constant crank speed.

    Parameters as for :class:`flexmech.analyses.options.RunningHammerOptions`.

    Raises
    ------
    InputError
        If a value is impossible.

    Examples
    --------
    >>> RunningHammerRequest(20.0, damping_ratio=0.005).orders
    2
    """

    impact: LinkPoint
    response: LinkPoint
    prestress: Prestress

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.speed is not None and not self.crank_speed:
            raise InputError(
                "speed is zero, at which nothing turns; ask for a hammer test at rest "
                "(flexmech.hammer_test, or flexmech hammer without --running)"
            )
        object.__setattr__(self, "prestress", self.prestress or "equilibrium")
        _check_force(self)
        check_count(self.orders, "orders", most=_MOST_ORDERS)

    @cached_property
    def crank_speed(self) -> float:
        """Crank speed in rad/s."""
        assert self.speed is not None, "as of a mechanism, where it is left out"
        return one_rad_per_s(self.speed, self.speed_unit, "speed")

    def of(self, mechanism: Mechanism) -> RunningHammerRequest:
        """The request with a mechanism's own speed and points, where none are asked for."""
        request = at_points(self, mechanism.linkage.topology)
        if self.speed is not None:
            return request
        speeds, shown = asked_speeds(None, self.speed_unit, mechanism, GREATEST)
        return replace(request, speed=float(in_unit(speeds, shown)[0]), speed_unit=shown)


_Request = TypeVar("_Request", HammerRequest, RunningHammerRequest)


def at_points(request: _Request, topology: Topology) -> _Request:
    """The request with its points on a linkage: those asked for, or the middle of the coupler.

    Parameters
    ----------
    request : HammerRequest or RunningHammerRequest
    topology : Topology

    Returns
    -------
    HammerRequest or RunningHammerRequest

    Raises
    ------
    InputError
        If a point is on no link.
    """
    impact = request.impact or middle_of(topology)
    response = request.response or impact
    with naming("impact"):
        impact.index(topology)
    with naming("response"):
        response.index(topology)
    return replace(request, impact=impact, response=response)


def middle_of(topology: Topology) -> LinkPoint:
    """Middle of the coupler, or of the last link where there is none: where a hammer hits."""
    names = topology.link_names
    return _MIDDLE if _MIDDLE.link in names else LinkPoint(names[-1], _MIDDLE.fraction)


def _check_force(request: HammerRequest | RunningHammerRequest) -> None:
    """Refuse points and bands that are none."""
    for name in ("impact", "response"):
        if (point := getattr(request, name)) is not None:
            check_instance(point, LinkPoint, name, "write flexmech.LinkPoint.parse('coupler:0.5')")
    check_fields(request, {"bandwidth": "Hz", "duration": "s"}, POSITIVE, optional=True)
    if request.damping_ratio is not None:
        check_number(request.damping_ratio, "damping_ratio", bounds=DAMPING_RATIO)
