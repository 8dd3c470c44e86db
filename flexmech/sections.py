"""Beam sections: what a link's cross-section is to a beam."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexmech.errors import InputError
from flexmech.materials import Material

__all__ = ["BeamSection"]


@dataclass(frozen=True)
class BeamSection:
    """Stiffness, mass and damping of a beam per length, for bending in the linkage's plane.

    Parameters
    ----------
    axial_stiffness : float
        EA in N.
    bending_stiffness : float
        EI in N m^2.
    shear_stiffness : float
        kGA in N, with the shear correction factor k.
    mass_per_length : float
        rho A in kg/m.
    rotary_inertia : float
        rho I in kg m.
    in_plane_thickness : float
        Extent of the section in the plane of the linkage in m (surface strain, drawings).
    damping_time : float
        Kelvin-Voigt time tau in s: stress = E (strain + tau d(strain)/dt).

    Raises
    ------
    InputError
        If a value is not a number or not positive (``damping_time`` may be zero).
    """

    axial_stiffness: float
    bending_stiffness: float
    shear_stiffness: float
    mass_per_length: float
    rotary_inertia: float
    in_plane_thickness: float
    damping_time: float = 0.0

    def __post_init__(self) -> None:
        for name in (
            "axial_stiffness",
            "bending_stiffness",
            "shear_stiffness",
            "mass_per_length",
            "rotary_inertia",
            "in_plane_thickness",
        ):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"{name} of a beam section must be positive, got {value}")
        if not (np.isfinite(self.damping_time) and self.damping_time >= 0):
            raise InputError(f"damping_time must be zero or positive, got {self.damping_time} s")

    @classmethod
    def rectangle(
        cls, material: Material, in_plane_thickness: float, out_of_plane_width: float
    ) -> BeamSection:
        """Solid rectangle of one material.

        Parameters
        ----------
        material : Material
        in_plane_thickness : float
            h in m, in the plane of the linkage: I = b h^3 / 12.
        out_of_plane_width : float
            b in m, along the joint axes.

        Returns
        -------
        BeamSection
            Undamped. Shear correction factor of Cowper (1966) for a rectangle,
            k = 10 (1 + nu) / (12 + 11 nu).
        """
        for name, value in (
            ("in_plane_thickness", in_plane_thickness),
            ("out_of_plane_width", out_of_plane_width),
        ):
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"{name} must be positive, got {value} m")
        area = in_plane_thickness * out_of_plane_width
        second_moment = out_of_plane_width * in_plane_thickness**3 / 12
        nu = material.poisson_ratio
        correction = 10 * (1 + nu) / (12 + 11 * nu)
        return cls(
            axial_stiffness=material.youngs_modulus * area,
            bending_stiffness=material.youngs_modulus * second_moment,
            shear_stiffness=correction * material.shear_modulus * area,
            mass_per_length=material.density * area,
            rotary_inertia=material.density * second_moment,
            in_plane_thickness=in_plane_thickness,
        )

    def with_damping_time(self, damping_time: float) -> BeamSection:
        """The same section with Kelvin-Voigt time ``damping_time`` in s."""
        return replace(self, damping_time=damping_time)

    def with_damping_ratio(self, ratio: float, frequency: float) -> BeamSection:
        """The same section, damped by ``ratio`` of critical at ``frequency`` in Hz.

        A mode of pure Kelvin-Voigt material has the damping ratio omega tau / 2.
        """
        if not (np.isfinite(ratio) and ratio >= 0):
            raise InputError(f"damping ratio must be zero or positive, got {ratio}")
        if not (np.isfinite(frequency) and frequency > 0):
            raise InputError(f"damping frequency must be positive, got {frequency} Hz")
        return self.with_damping_time(2 * ratio / (2 * np.pi * frequency))
