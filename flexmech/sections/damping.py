"""Damping of a beam section: by deformation, and by what a cycle takes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flexmech.model_text import TomlTable, quantity
from flexmech.units import RATIO, TIME
from flexmech.validation import NOT_NEGATIVE, POSITIVE, check_number


@dataclass(frozen=True)
class DampingTimes:
    """Kelvin-Voigt times tau in s: force = stiffness (strain + tau d(strain)/dt).

    A material has one time; a laminate damps stretching, bending and shear differently.

    Parameters
    ----------
    axial, bending, shear : float
        Of the axial force, the bending moment about the neutral axis and the shear force.
    warping : float, optional
        Of what a change of the shear angle along the link asks for (zigzag and third-order
        beams); as of bending where it is left out.
    stated : bool
        Whether anybody says so. Times of zero that nobody states leave open whether the
        specific damping counts in motion over time.

    Raises
    ------
    InputError
        If a time is negative or not a number.
    """

    axial: float = 0.0
    bending: float = 0.0
    shear: float = 0.0
    warping: float | None = None
    stated: bool = field(default=True, compare=False, repr=False)

    def __post_init__(self) -> None:
        for time in _stated(self).values():
            check_number(time, "damping_time", "s", NOT_NEGATIVE)

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
    axial, bending, shear : float
        Of stretching along and bending about the neutral axis, and of shear.
    warping : float, optional
        Of warping, as in :class:`DampingTimes`.

    Raises
    ------
    InputError
        If a value is negative or not a number.
    """

    axial: float
    bending: float
    shear: float
    warping: float | None = None

    def __post_init__(self) -> None:
        for loss in _stated(self).values():
            check_number(loss, "specific damping", "", NOT_NEGATIVE)

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
        return {name: quantity(loss, RATIO) for name, loss in _stated(self).items()}


def _stated(damping: DampingTimes | SpecificDamping) -> dict[str, float]:
    """Values by deformation, without those that are left out."""
    own = {name: getattr(damping, name) for name in ("axial", "bending", "shear", "warping")}
    return {name: value for name, value in own.items() if value is not None}
