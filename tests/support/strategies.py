"""Random linkages, sections and mechanisms for hypothesis, and a few fixed ones."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from flexmech.linkages import FourBar, RotatingArm
from flexmech.materials import Material
from flexmech.mechanism import Mechanism, PointMass
from flexmech.sections import BeamSection

STEEL = Material(200e9, 7800.0)
ALUMINIUM = Material(68.9e9, 2923.0)
LINKS = ("crank", "coupler", "rocker")
STEEL_LINKAGE = FourBar(ground=0.254, crank=0.100, coupler=0.2794, rocker=0.2667)
ALUMINIUM_LINKAGE = FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667)


@dataclass(frozen=True)
class Posture:
    """A linkage at a crank angle where the coupler is known to have ``coupler_angle``."""

    linkage: FourBar
    crank_angle: float
    coupler_angle: float


@dataclass(frozen=True)
class Running:
    """A mechanism at a crank angle, turning slowly against its natural frequencies."""

    mechanism: Mechanism
    crank_angle: float
    crank_speed: float


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_infinity=False, allow_subnormal=False)


def angles() -> st.SearchStrategy[float]:
    return numbers(-np.pi, np.pi)


@st.composite
def postures(draw: st.DrawFn, size: float = 1.0) -> Posture:
    """Ground, crank and coupler are drawn at any angles; the rocker closes the loop."""
    ground, crank, coupler = (size * draw(numbers(0.2, 1.0)) for _ in range(3))
    theta2, theta3 = draw(angles()), draw(angles())
    a = crank * np.exp(1j * theta2)
    b = a + coupler * np.exp(1j * theta3)
    rocker = abs(b - ground)
    assume(0.15 * size <= rocker)
    sine_of_transmission = abs(np.sin(np.angle((b - a) / (b - ground))))
    assume(sine_of_transmission >= 0.3)
    assume(ground * crank <= 4 * coupler * rocker)
    shortest, *middle, longest = sorted((ground, crank, coupler, rocker))
    away_from_change_point = abs(shortest + longest - sum(middle)) > 1e-3 * longest
    assume(away_from_change_point)
    left = np.imag((ground - a).conjugate() * (b - a)) > 0
    linkage = FourBar(ground, crank, coupler, float(rocker), "open" if left else "crossed")
    return Posture(linkage, theta2, theta3)


@st.composite
def sections(draw: st.DrawFn) -> BeamSection:
    material = Material(draw(numbers(50e9, 210e9)), draw(numbers(1500.0, 8000.0)))
    return BeamSection.rectangle(
        material,
        in_plane_thickness=draw(numbers(2e-3, 6e-3)),
        out_of_plane_width=draw(numbers(5e-3, 25e-3)),
    )


@st.composite
def running_mechanisms(draw: st.DrawFn) -> Running:
    posture = draw(postures(size=0.4))
    beams = {link: draw(sections()) for link in LINKS}
    masses = {joint: draw(st.sampled_from((0.0, 0.01, 0.03))) for joint in ("A", "B")}
    on_link = draw(st.sampled_from((None, *LINKS)))
    linkage = posture.linkage
    points = ()
    if on_link:
        place = draw(st.sampled_from((0.3, 0.5))) * linkage.lengths[on_link]
        points = (PointMass(on_link, place, 0.01),)
    mechanism = Mechanism(linkage, beams, joint_masses=masses, link_masses=points)
    rate = np.abs(linkage.motion(posture.crank_angle, 1.0).angular_velocity).max()
    speed = draw(numbers(0.02, 0.12)) * _slowest_estimate(mechanism) / rate
    return Running(mechanism, posture.crank_angle, float(speed))


def _slowest_estimate(mechanism: Mechanism) -> float:
    """Rough first angular frequency in rad/s: a link between pins, or the crank with all masses."""
    lengths = {link.name: link.length for link in mechanism.linkage.topology.links}
    masses = mechanism.link_masses_in_order
    slowest = [
        np.pi**2 * np.sqrt(mechanism.sections[m].bending_stiffness / (mass.moment(0) * x**3))
        for (m, x), mass in zip(lengths.items(), masses, strict=True)
    ]
    stiffness = 3 * mechanism.sections["crank"].bending_stiffness / lengths["crank"] ** 3
    slowest.append(np.sqrt(stiffness / sum(mass.moment(0) for mass in masses)))
    return float(min(slowest))


def fourbar(
    linkage: FourBar = ALUMINIUM_LINKAGE,
    material: Material = ALUMINIUM,
    thickness: tuple[float, float, float] = (4.24e-3, 1.6e-3, 1.6e-3),
    width: float = 25.4e-3,
    damping_time: float = 0.0,
    **others: object,
) -> Mechanism:
    """A four-bar like the aluminium one of Kumar & Chandrakar."""
    beams = {
        link: BeamSection.rectangle(material, h, width).with_damping_time(damping_time)
        for link, h in zip(LINKS, thickness, strict=True)
    }
    return Mechanism(linkage, beams, **others)  # type: ignore[arg-type]


def arm(length: float = 1.0, hub_radius: float = 0.0, thickness: float = 0.01) -> Mechanism:
    section = BeamSection.rectangle(STEEL, thickness, 0.02)
    return Mechanism(RotatingArm(length, hub_radius), {"arm": section})


def scaled(linkage: FourBar, factor: float) -> FourBar:
    return replace(linkage, **{k: factor * v for k, v in linkage.lengths.items()})
