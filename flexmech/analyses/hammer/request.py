"""What a hammer test is asked for: where it hits and looks, and how it records."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

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
from flexmech.linear_system import LinkPoint
from flexmech.linkages import Topology
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
        Of force and displacement, in the frame of each point's rigid link.
    averages : int
        Impacts over which spectra are averaged.
    bandwidth : float, optional
        Greatest frequency in Hz. Left out: a quarter above the highest of ``modes`` natural
        frequencies at any of the angles, or what the pulse given excites if that is less.
    duration : float, optional
        Of a record in s. Left out: until the vibration has decayed to 1e-4.
    pulse : float, optional
        Duration of the half-sine pulse in s. Left out: one over the bandwidth, at which the
        pulse's spectrum has fallen by 9.5 dB.
    noise : float
        Root mean square of noise in force and response over that of the signal.
    seed : int
        Of the noise.
    prestress : {"none", "axial", "equilibrium"}
        Stress of the links at rest, by their weight.
    modes : int
        Natural frequencies by which the bandwidth is chosen.
    method : {"lscf", "circle-fit"}, optional
        Of the identification. Left out: LSCF if its package is installed.
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
        check_impacts(self)
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


def middle_of(topology: Topology) -> LinkPoint:
    """Middle of the coupler, or of the last link where there is none: where a hammer hits."""
    names = topology.link_names
    return _MIDDLE if _MIDDLE.link in names else LinkPoint(names[-1], _MIDDLE.fraction)


def check_impacts(request: object) -> None:
    """Refuse points, directions, records and noise that no hammer test can have.

    Parameters
    ----------
    request : HammerRequest or RunningHammerRequest

    Raises
    ------
    InputError
    """
    asked = vars(request)
    for name in ("impact", "response"):
        check_instance(
            asked[name], LinkPoint, name, "write flexmech.LinkPoint.parse('coupler:0.5')"
        )
    check_choice(asked["direction"], LINK_DIRECTIONS, "direction")
    check_choice(asked["prestress"], PRESTRESS_LEVELS, "prestress")
    check_count(asked["averages"], "averages", most=_MOST_AVERAGES)
    check_count(asked["seed"], "seed", 0, most=MOST_SEED)
    check_fields(
        request, {"bandwidth": "Hz", "duration": "s", "pulse": "s"}, POSITIVE, optional=True
    )
    check_number(asked["noise"], "noise", bounds=NOT_NEGATIVE)
