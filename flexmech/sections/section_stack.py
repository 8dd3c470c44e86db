"""Beam sections of one link in several designs, as arrays over the designs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.sections.beam_section import BeamSection


@dataclass(frozen=True)
class SectionStack:
    """Numbers (D,) of D sections, by which beams are computed as by those of one.

    Parameters
    ----------
    sections : tuple of BeamSection
        Symmetric ones, whose axes are that of the pins, without free strains.
    places : int
        How often the number of each is repeated.
    """

    sections: tuple[BeamSection, ...]
    places: int = 1
    neutral_axis: ClassVar[float] = 0.0
    mass_axis: ClassVar[float] = 0.0
    first_moment_of_mass: ClassVar[float] = 0.0
    free_strain: ClassVar[float] = 0.0
    free_curvature: ClassVar[float] = 0.0

    def repeated(self, places: int) -> SectionStack:
        """Columns (D * places, 1) of as many places in each design."""
        return SectionStack(self.sections, places)

    def _every(self, number: Callable[[BeamSection], float]) -> FloatArray:
        values = np.array([number(section) for section in self.sections])
        return values if self.places == 1 else np.repeat(values, self.places)[:, None]

    @cached_property
    def axial_stiffness(self) -> FloatArray:
        """Axial stiffness EA in N."""
        return self._every(lambda section: section.axial_stiffness)

    @cached_property
    def bending_stiffness(self) -> FloatArray:
        """Bending stiffness EI in N m^2."""
        return self._every(lambda section: section.bending_stiffness)

    @cached_property
    def shear_stiffness(self) -> FloatArray:
        """Shear stiffness kGA in N."""
        return self._every(lambda section: section.shear_stiffness)

    @cached_property
    def mass_per_length(self) -> FloatArray:
        """In kg/m."""
        return self._every(lambda section: section.mass_per_length)

    @cached_property
    def rotary_inertia(self) -> FloatArray:
        """In kg m."""
        return self._every(lambda section: section.rotary_inertia)

    @cached_property
    def damping_times(self) -> FloatArray:
        """Kelvin-Voigt times of stretching, bending, warping and shear in s, (D, 4)."""
        return np.stack([damping_times(section) for section in self.sections])


def damping_times(section: BeamSection | SectionStack) -> FloatArray:
    """Kelvin-Voigt times of stretching, bending, warping and shear.

    Parameters
    ----------
    section : BeamSection or SectionStack
        Of one design or of D.

    Returns
    -------
    ndarray, shape (4,) or (D, 4)
        In s.
    """
    if isinstance(section, SectionStack):
        return section.damping_times
    times = section.damping
    return np.array([times.axial, times.bending, times.of_warping, times.shear])
