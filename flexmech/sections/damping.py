"""Damping of a beam section: by deformation, and by what a cycle takes."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from flexmech.errors import InputError

__all__ = ["DampingTimes", "SpecificDamping"]


@dataclass(frozen=True)
class DampingTimes:
    """Kelvin-Voigt times tau in s: force = stiffness (strain + tau d(strain)/dt).

    A material has one time; a laminate damps stretching, bending and shear differently.

    Parameters
    ----------
    axial, bending, shear : float
        Of the axial force, the bending moment about the neutral axis and the shear force.

    Raises
    ------
    InputError
        If a time is negative or not a number.
    """

    axial: float = 0.0
    bending: float = 0.0
    shear: float = 0.0

    def __post_init__(self) -> None:
        _check_not_negative(self, "damping_time", " s")

    @classmethod
    def uniform(cls, time: float) -> DampingTimes:
        """The same time in s for all deformations."""
        return cls(time, time, time)

    @property
    def any(self) -> bool:
        """Whether anything is damped."""
        return self.axial > 0 or self.bending > 0 or self.shear > 0


@dataclass(frozen=True)
class SpecificDamping:
    """Specific damping capacity psi: energy lost in a cycle over the largest strain energy.

    Independent of frequency, as measured on fibre composites; psi is four pi times the
    damping ratio (Adams & Bacon 1973). What a cycle of stretching and bending at once loses
    in the product of the two, in an unsymmetric stack, is not counted.

    Parameters
    ----------
    axial, bending, shear : float
        Of stretching along and bending about the neutral axis, and of shear.

    Raises
    ------
    InputError
        If a value is negative or not a number.
    """

    axial: float
    bending: float
    shear: float

    def __post_init__(self) -> None:
        _check_not_negative(self, "specific damping", "")

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
        if not (np.isfinite(angular_frequency) and angular_frequency > 0):
            raise InputError(f"damping frequency must be positive, got {angular_frequency} rad/s")
        turn = 2 * np.pi * angular_frequency
        return DampingTimes(self.axial / turn, self.bending / turn, self.shear / turn)


def _check_not_negative(record: DampingTimes | SpecificDamping, what: str, unit: str) -> None:
    for field in fields(record):
        value = getattr(record, field.name)
        if not (np.isfinite(value) and value >= 0):
            raise InputError(f"{what} must be zero or positive, got {value}{unit}")
