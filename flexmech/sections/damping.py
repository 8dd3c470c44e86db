"""Damping of a beam section: by deformation, and by what a cycle takes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flexmech import si
from flexmech.model_text import TomlTable, quantity
from flexmech.units import TIME
from flexmech.validation import POSITIVE, check_number


@dataclass(frozen=True)
class DampingTimes:
    """Kelvin-Voigt times tau in s: force = stiffness (strain + tau d(strain)/dt).

    A material has one time; a laminate damps stretching, bending and shear differently.

    Parameters
    ----------
    axial : float
        Kelvin-Voigt time of stretching along the neutral axis, in s.
    bending : float
        Kelvin-Voigt time of bending about it, in s.
    shear : float
        Kelvin-Voigt time of shear, in s.
    warping : float, optional
        Kelvin-Voigt time of warping cross-sections, in s; as of bending if left out. A change of
        the shear angle along the link asks for it in zigzag and third-order beams.
    stated : bool
        Whether anybody says so. Times of zero that nobody states leave open whether the
        specific damping counts in motion over time.

    Raises
    ------
    InputError
        If a time is negative or not a number.
    """

    axial: si.TimeOrZero = 0.0
    bending: si.TimeOrZero = 0.0
    shear: si.TimeOrZero = 0.0
    warping: si.TimeOrZero | None = None
    stated: bool = field(default=True, compare=False, repr=False)

    def __post_init__(self) -> None:
        si.check(self, "damping_time")

    @classmethod
    def uniform(cls, time: float) -> DampingTimes:
        """The same time in s for all deformations."""
        return cls(time, time, time)

    @property
    def any(self) -> bool:
        """Whether anything is damped."""
        return any(time > 0 for time in _stated(self).values())

    @property
    def of_warping(self) -> float:
        """Time of warping, stated or that of bending."""
        return self.bending if self.warping is None else self.warping

    @property
    def is_uniform(self) -> bool:
        """Whether all deformations are damped alike."""
        return self.axial == self.bending == self.shear == self.of_warping

    def to_table(self) -> TomlTable:
        """Table ``damping_times`` of a link in a model file."""
        return {name: quantity(time, TIME) for name, time in _stated(self).items()}


@dataclass(frozen=True)
class SpecificDamping:
    """Specific damping capacity psi: energy lost in a cycle over the largest strain energy.

    Independent of frequency, as measured on fibre composites; psi is four pi times the
    damping ratio (Adams & Bacon 1973). What a cycle of stretching and bending at once loses
    in the product of the two, in an unsymmetric stack, is not counted.

    Parameters
    ----------
    axial : float
        Kelvin-Voigt time of stretching along the neutral axis.
    bending : float
        Bending of bending about it.
    shear : float
        Shear of shear.
    warping : float, optional
        Warping of warping cross-sections; as of bending if left out.

    Raises
    ------
    InputError
        If a value is negative or not a number.
    """

    axial: si.SpecificDamping
    bending: si.SpecificDamping
    shear: si.SpecificDamping
    warping: si.SpecificDamping | None = None

    def __post_init__(self) -> None:
        si.check(self, "specific damping")

    def times(self, angular_frequency: float) -> DampingTimes:
        """Kelvin-Voigt times with the same loss at one angular frequency in rad/s.

        Viscous damping of a harmonic strain loses ``2 pi omega tau`` of its largest energy
        in a cycle.

        Parameters
        ----------
        angular_frequency : float

        Returns
        -------
        DampingTimes

        Raises
        ------
        InputError
            If the frequency is not positive.
        """
        check_number(angular_frequency, "damping frequency", "rad/s", POSITIVE)
        turn = 2 * np.pi * angular_frequency
        warping = None if self.warping is None else self.warping / turn
        return DampingTimes(self.axial / turn, self.bending / turn, self.shear / turn, warping)

    def to_table(self) -> TomlTable:
        """Table ``specific_damping`` of a link in a model file."""
        return si.table(self)


def _stated(damping: DampingTimes | SpecificDamping) -> dict[str, float]:
    """Values by deformation, without those that are left out."""
    times = {name: getattr(damping, name) for name in ("axial", "bending", "shear", "warping")}
    return {name: value for name, value in times.items() if value is not None}
