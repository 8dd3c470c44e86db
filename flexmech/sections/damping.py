"""Damping of a beam section: by deformation, and by what a cycle takes."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from flexmech.model_text import TomlTable, quantity
from flexmech.numbers import NOT_NEGATIVE, POSITIVE, check_number
from flexmech.units import RATIO, TIME

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
        for name in ("axial", "bending", "shear"):
            check_number(getattr(self, name), "damping_time", "s", NOT_NEGATIVE)

    @classmethod
    def uniform(cls, time: float) -> DampingTimes:
        """The same time in s for all deformations."""
        return cls(time, time, time)

    @property
    def any(self) -> bool:
        """Whether anything is damped."""
        return self.axial > 0 or self.bending > 0 or self.shear > 0

    @property
    def is_uniform(self) -> bool:
        """Whether all deformations are damped alike."""
        return self.axial == self.bending == self.shear

    def to_table(self) -> TomlTable:
        """Table ``damping_times`` of a link in a model file."""
        return {name: quantity(time, TIME) for name, time in asdict(self).items()}


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
        for name in ("axial", "bending", "shear"):
            check_number(getattr(self, name), "specific damping", "", NOT_NEGATIVE)

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
        return DampingTimes(self.axial / turn, self.bending / turn, self.shear / turn)

    def to_table(self) -> TomlTable:
        """Table ``specific_damping`` of a link in a model file."""
        return {name: quantity(loss, RATIO) for name, loss in asdict(self).items()}
