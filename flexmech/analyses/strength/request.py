"""Request of strength: crank angles and speed, criterion, places, heat and moisture."""

from __future__ import annotations

from flexmech.analyses.crank_speeds import RAD_S, one_rad_per_s
from flexmech.analyses.options import StrengthOptions
from flexmech.analyses.requests import check_list, environment_of, in_radians
from flexmech.hygrothermal import Environment, HygrothermalState
from flexmech.mechanism import Mechanism
from flexmech.validation import (
    POSITIVE,
    check_flag,
    check_number,
)


class StrengthRequest(StrengthOptions):
    """Checked request of strength.

    Parameters as for :class:`flexmech.analyses.options.StrengthOptions`.

    Raises
    ------
    InputError
        If angles or speed are no numbers, angles do not increase, or the criterion is unknown.

    Examples
    --------
    >>> StrengthRequest(950.0, speed_unit="rpm").crank_angles.shape
    (73,)
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        angles = in_radians("crank_angles", self.crank_angles)
        check_list("crank_angles", angles, increasing=True)
        object.__setattr__(self, "crank_angles", angles)
        if self.speed is not None:
            one_rad_per_s(self.speed, self.speed_unit, "speed")
        check_flag(self.search_speed, "search_speed")
        check_number(self.revolutions, "revolutions", "", POSITIVE)
        if self.environment is not None:
            environment_of(self.environment)

    @property
    def state(self) -> Environment:
        """Heat and moisture that the links are in; dry and unheated where none was asked for."""
        return HygrothermalState() if self.environment is None else self.environment

    def speed_of(self, mechanism: Mechanism) -> float:
        """Crank speed in rad/s: as asked for, or the greatest at which a mechanism operates."""
        if self.speed is not None:
            return one_rad_per_s(self.speed, self.speed_unit, "speed")
        return float(max(mechanism.operating_speeds, key=abs, default=0.0))

    def shown_unit(self, mechanism: Mechanism) -> str:
        """Unit in which the result for a mechanism speaks of crank speeds."""
        own = mechanism.speed_unit if self.speed is None else RAD_S
        return self.speed_unit or own
