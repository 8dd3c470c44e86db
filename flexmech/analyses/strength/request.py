"""What can be asked of strength: crank angles and speed, criterion, places, heat and moisture."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flexmech.analyses.crank_speeds import RAD_S, one_rad_per_s
from flexmech.analyses.requests import check_list, environment_of, in_radians
from flexmech.arrays import FloatArray
from flexmech.choices import (
    CRITERIA,
    ELEMENTS_A_LINK,
    LOAD_SOURCES,
    MOST_ELEMENTS,
    CriterionName,
    LoadSource,
)
from flexmech.errors import InputError
from flexmech.hygrothermal import Environment, HygrothermalState
from flexmech.mechanism import Mechanism
from flexmech.validation import (
    POSITIVE,
    check_choice,
    check_count,
    check_flag,
    check_number,
)


@dataclass(frozen=True)
class StrengthRequest:
    """Crank angles and speed, and by which criterion plies are judged.

    Parameters
    ----------
    crank_angles : array_like, shape (A,)
        In rad, increasing; a turn in steps of five degrees if left out.
    crank_speed : float, optional
        In ``speed_unit``. Left out: the greatest speed at which the mechanism operates, zero if it
        names none.
    criterion : {"max-stress", "tsai-hill", "tsai-wu", "hashin", "puck", "von-mises"}, optional
        Of plies with fibres; Tsai-Wu's if left out. Isotropic layers are judged by von Mises'
        equivalent stress in any case.
    speed_unit : str, optional
        Unit of the crank speed, such as ``"rpm"``, in which it is printed and drawn. Left out:
        rad/s, and the unit of the model file for the mechanism's speed.
    elements : int
        Parts into which each link is divided: stresses are computed at their ends, and on both
        sides of masses, loads and springs.
    environment : HygrothermalState or Exposure, optional
        Heat and moisture that the links are in.
    source : {"quasi-static", "periodic", "transient", "rigid"}
        Whose internal forces they are: of an engine's elastic links at rest in their frames, in
        nonlinear equilibrium with inertia, weight, loads and springs; in one turn of their periodic
        motion, or in a run of ``revolutions`` turns that begins with straight links, which run by
        samples of their own, and not by crank angles; or of links that are taken as rigid.
    revolutions : float
        Turns of a transient run.
    search_speed : bool
        Of elastic links: whether to search the crank speed at which parts fail, by some ten more
        equilibria or some thirty more runs of the first engine. Loads of rigid links need no
        search.

    Raises
    ------
    InputError
        If angles or speed are no numbers, angles do not increase, or the criterion is unknown.

    Examples
    --------
    >>> flexmech.StrengthRequest(crank_speed=950.0, speed_unit="rpm").crank_angles.shape
    (73,)
    """

    crank_angles: FloatArray = field(default_factory=lambda: np.radians(np.arange(0.0, 361.0, 5.0)))
    crank_speed: float | None = None
    criterion: CriterionName | None = None
    speed_unit: str | None = None
    elements: int = ELEMENTS_A_LINK
    environment: Environment | None = None
    source: LoadSource = "quasi-static"
    revolutions: float = 4.0
    search_speed: bool = True

    def __post_init__(self) -> None:
        angles = in_radians("crank_angles", self.crank_angles)
        check_list("crank_angles", angles, increasing=True)
        object.__setattr__(self, "crank_angles", angles)
        if self.crank_speed is not None:
            one_rad_per_s(self.crank_speed, self.speed_unit)
        if self.criterion is not None:
            check_choice(self.criterion, CRITERIA, "criterion")
        check_choice(self.source, LOAD_SOURCES, "source")
        check_flag(self.search_speed, "search_speed")
        check_number(self.revolutions, "revolutions", "", POSITIVE)
        check_count(self.elements, "elements")
        if self.elements > MOST_ELEMENTS:
            raise InputError(f"elements: {self.elements} are beyond {MOST_ELEMENTS} a link")
        if self.environment is not None:
            environment_of(self.environment)

    @property
    def state(self) -> Environment:
        """Heat and moisture that the links are in; dry and unheated where none was asked for."""
        return HygrothermalState() if self.environment is None else self.environment

    def speed_of(self, mechanism: Mechanism) -> float:
        """Crank speed in rad/s: as asked for, or the greatest at which a mechanism operates."""
        if self.crank_speed is not None:
            return one_rad_per_s(self.crank_speed, self.speed_unit)
        return float(max(mechanism.operating_speeds, key=abs, default=0.0))

    def shown_unit(self, mechanism: Mechanism) -> str:
        """Unit in which the result for a mechanism speaks of crank speeds."""
        own = mechanism.speed_unit if self.crank_speed is None else RAD_S
        return self.speed_unit or own
