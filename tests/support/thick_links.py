"""Thick sections as laminates have them, their axes off the pins' axis, and four-bars of them."""

from __future__ import annotations

from dataclasses import replace

from flexmech import BeamSection, FourBar, Mechanism, PointMass
from flexmech.sections import DampingTimes

LINKS = ("crank", "coupler", "rocker")
HEIGHT = 0.25 / 8
UNSYMMETRIC = (0.1, -0.05)


def section(
    neutral: float = 0.0, mass: float = 0.0, *, axial: float = 2e7, shear: float = 1 / 30
) -> BeamSection:
    """Height an eighth of the rocker; axes by the height, shear by the axial stiffness."""
    per_length = 1600.0 * HEIGHT * 0.02
    return BeamSection(
        axial_stiffness=axial,
        bending_stiffness=axial * HEIGHT**2 / 12,
        shear_stiffness=axial * shear,
        mass_per_length=per_length,
        rotary_inertia=per_length * HEIGHT**2 / 12,
        in_plane_thickness=HEIGHT,
        neutral_axis=neutral * HEIGHT,
        mass_axis=mass * HEIGHT,
    )


def fourbar(axes=(0.0, 0.0), *, stiffness=2e7, shear=1 / 30, eccentric=LINKS, **more) -> Mechanism:
    sections = {
        name: section(*(axes if name in eccentric else (0.0, 0.0)), axial=stiffness, shear=shear)
        for name in LINKS
    }
    return Mechanism(FourBar(0.35, 0.12, 0.3, 0.25), sections, **more)


def laden(axes=UNSYMMETRIC, **more) -> Mechanism:
    return fourbar(
        axes,
        gravity=(3.0, -9.81),
        joint_masses={"A": 0.1, "B": 0.2},
        link_masses=(PointMass("coupler", 0.1, 0.05),),
        **more,
    )


def damped(mechanism: Mechanism, axial: float, bending: float, shear: float) -> Mechanism:
    times = DampingTimes(axial, bending, shear)
    sections = {k: replace(s, damping=times) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def uncoupled(mechanism: Mechanism) -> Mechanism:
    """With the axes of all sections in the pins' axis, as a symmetric stack has them."""
    sections = {k: s.without_coupling() for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)
