"""What a hammer test on the running linkage is asked to be."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from flexmech import choices
from flexmech.analyses.crank_speeds import one_rad_per_s
from flexmech.analyses.damping_ratios import DAMPING_RATIO
from flexmech.analyses.hammer.request import check_impacts
from flexmech.errors import InputError
from flexmech.linear_system import LinkPoint
from flexmech.validation import check_count, check_number

# Orders to either side beyond which a crank of any speed answers nothing that can be measured.
_MOST_ORDERS = 20
_MIDDLE = LinkPoint("coupler", 0.5)


@dataclass(frozen=True)
class RunningHammerRequest:
    """Impacts on the linkage at a constant crank speed.

    Parameters
    ----------
    crank_speed : float
        In ``speed_unit``, not zero.
    impact, response : LinkPoint
        Where the hammer hits, and where the displacement is read; the middle of the coupler.
    direction : {"transverse", "axial"}
        Of both, in the axes of their links' rigid frames.
    prestress : {"none", "axial", "equilibrium"}
        Of the prediction, and of the runs of engines that do not simulate.
    damping_ratio : float, optional
        Z from 0 on and less than 1: the Kelvin-Voigt time of all links is 2 Z/omega_1, with the
        first natural frequency at rest averaged over the turn. Left out: the model's damping.
    orders : int
        N: harmonic transfer functions of the orders -N to N are asked for.
    averages : int
        Impacts at each crank angle; each has noise of its own.
    bandwidth : float, optional
        Highest frequency of the input in Hz. Left out: twice the first natural frequency at
        rest, averaged over the turn, or what the pulse given excites if that is less.
    duration : float, optional
        Of a record in s, made longer to a whole number of turns. Left out: until an impact has
        decayed to 1e-4.
    pulse : float, optional
        Duration of the half-sine pulse in s. Left out: one over the bandwidth.
    noise : float
        Root mean square of the noise over that of each record of force and response.
    seed : int
        Of the noise and of the jitter of the crank angles.
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
    direction: choices.LinkDirection = "transverse"
    prestress: choices.Prestress = "equilibrium"
    damping_ratio: float | None = None
    orders: int = 2
    averages: int = 1
    bandwidth: float | None = None
    duration: float | None = None
    pulse: float | None = None
    noise: float = 0.0
    seed: int = 0
    speed_unit: str | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        _ = self.speed
        if self.crank_speed == 0:
            raise InputError(
                "crank_speed is zero, at which nothing turns; ask for a hammer test at rest "
                "(flexmech.hammer_test, or flexmech hammer without --running)"
            )
        check_impacts(self)
        if self.damping_ratio is not None:
            check_number(self.damping_ratio, "damping_ratio", bounds=DAMPING_RATIO)
        check_count(self.orders, "orders", most=_MOST_ORDERS)

    @cached_property
    def speed(self) -> float:
        """Crank speed in rad/s."""
        return one_rad_per_s(self.crank_speed, self.speed_unit)
