"""What a mechanism states of its pins, and which checks follow from it or are left out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from flexmech.analyses.strength.pin_stresses import (
    SHEAR_YIELD,
    bearing_pressure,
    net_tension,
    pressure_velocity,
    shear_out,
)
from flexmech.linkages import LinkEnd, Topology
from flexmech.mechanism import JointPin, Mechanism

PinMode = Literal["bearing yield", "bearing pressure", "net tension", "shear-out", "p v"]
TEARING: tuple[PinMode, ...] = ("net tension", "shear-out")
"""Checks of what tears at an eye."""
BY_YIELD: tuple[PinMode, ...] = ("bearing yield", *TEARING)
"""Checks against the yield strength of the link."""
WANT = "for want of {}"
INSIDE = "for the hole is not at an end of the link"


@dataclass(frozen=True)
class PinCheck:
    """A stress at a pin against what is allowed.

    Parameters
    ----------
    joint : str
    mode : str
        How the pin or the eye would fail.
    stress : float
        By a force of 1 N, in Pa; of p v by 1 N at 1 rad/s, in Pa m/s.
    allowable : float
        In Pa, or in Pa m/s.
    end : LinkEnd, optional
        Of the link whose eye it is; None of the bush.
    """

    joint: str
    mode: PinMode
    stress: float
    allowable: float
    end: LinkEnd | None = None

    @property
    def link(self) -> str:
        """Link whose eye it is; empty of the bush."""
        return "" if self.end is None else self.end.link


@dataclass(frozen=True)
class LeftOut:
    """Checks of a pin that are not made.

    Parameters
    ----------
    joint : str
    modes : tuple of str
    why : str
        In words that follow "left out".
    link : str
        Whose eye it is; empty of the bush.
    """

    joint: str
    modes: tuple[PinMode, ...]
    why: str
    link: str = ""


@dataclass(frozen=True)
class PinChecks:
    """Checks of all pins of a mechanism.

    Parameters
    ----------
    made : tuple of PinCheck
    left_out : tuple of LeftOut
        Of joints that state a diameter.
    without_diameter : tuple of str
        Pins, pivots and sliders that state none.
    """

    made: tuple[PinCheck, ...]
    left_out: tuple[LeftOut, ...]
    without_diameter: tuple[str, ...]

    @property
    def left_out_lines(self) -> list[str]:
        """What is left out and why, in words, a line for each reason."""
        places: dict[tuple[str, str], dict[str, list[str]]] = {}
        for one in self.left_out:
            of_reason = places.setdefault((", ".join(one.modes), one.why), {})
            of_reason.setdefault(one.joint, []).extend([one.link] if one.link else [])
        return [
            f"pins, {modes} left out {why}: "
            + ", ".join(
                f"{joint} ({', '.join(links)})" if links else joint
                for joint, links in joints.items()
            )
            for (modes, why), joints in places.items()
        ]

    @classmethod
    def of(cls, mechanism: Mechanism) -> PinChecks:
        """Find the checks that a mechanism's data allow.

        Parameters
        ----------
        mechanism : Mechanism
            In its state.

        Returns
        -------
        PinChecks
        """
        found = [one for pin in mechanism.joint_pins for one in _checks_of(mechanism, pin)]
        stated = {pin.joint for pin in mechanism.joint_pins}
        joints = mechanism.linkage.topology.turning_ends
        return cls(
            tuple(one for one in found if isinstance(one, PinCheck)),
            tuple(one for one in found if isinstance(one, LeftOut)),
            tuple(joint for joint in joints if joint not in stated),
        )


def _checks_of(mechanism: Mechanism, pin: JointPin) -> Iterator[PinCheck | LeftOut]:
    topology = mechanism.linkage.topology
    ends = [end for end in topology.turning_ends[pin.joint] if end is not None]
    slides = any(slider.joint == pin.joint for slider in topology.sliders)
    if slides and _is_inside(topology, ends[0]):
        # What its block does to the link and what its beams do to each other is not told apart.
        every: tuple[PinMode, ...] = ("bearing pressure", *BY_YIELD, "p v")
        yield LeftOut(pin.joint, every, INSIDE, ends[0].link)
        return
    holes = {end: _thickness(mechanism, pin, end) for end in ends}
    for end, thickness in holes.items():
        if thickness is not None:
            yield from _checks_of_eye(mechanism, pin, end, thickness)
        else:
            yield LeftOut(
                pin.joint, ("bearing pressure", *BY_YIELD), WANT.format("eye_thickness"), end.link
            )
    known = [thickness for thickness in holes.values() if thickness is not None]
    length = pin.bush_length or min(known, default=None)
    if pin.allowable_pv is None:
        yield LeftOut(pin.joint, ("p v",), WANT.format("allowable_pv"))
    elif length is None:
        yield LeftOut(pin.joint, ("p v",), WANT.format("bush_length"))
    else:
        stress = pressure_velocity(1.0, 1.0, pin.diameter, length)
        yield PinCheck(pin.joint, "p v", stress, pin.allowable_pv)


def _checks_of_eye(
    mechanism: Mechanism, pin: JointPin, end: LinkEnd, thickness: float
) -> Iterator[PinCheck | LeftOut]:
    pressure = bearing_pressure(1.0, pin.diameter, thickness)
    strength = _yield_strength(mechanism, end.link)
    if pin.allowable_bearing_pressure is not None:
        allowed = pin.allowable_bearing_pressure
        yield PinCheck(pin.joint, "bearing pressure", pressure, allowed, end)
    elif isinstance(strength, str):
        missing = WANT.format("allowable_bearing_pressure")
        yield LeftOut(pin.joint, ("bearing pressure",), missing, end.link)
    if isinstance(strength, str):
        yield LeftOut(pin.joint, BY_YIELD, strength, end.link)
        return
    yield PinCheck(pin.joint, "bearing yield", pressure, strength, end)
    if _is_inside(mechanism.linkage.topology, end):
        yield LeftOut(pin.joint, TEARING, INSIDE, end.link)
        return
    width, edge = _width(mechanism, pin, end), pin.eye(end.link).edge_distance
    if width is None:
        yield LeftOut(pin.joint, ("net tension",), WANT.format("eye_width"), end.link)
    else:
        stress = net_tension(1.0, width, pin.diameter, thickness)
        yield PinCheck(pin.joint, "net tension", stress, strength, end)
    if edge is None:
        yield LeftOut(pin.joint, ("shear-out",), WANT.format("eye_edge_distance"), end.link)
    else:
        stress = shear_out(1.0, edge, pin.diameter, thickness)
        yield PinCheck(pin.joint, "shear-out", stress, SHEAR_YIELD * strength, end)


def _is_inside(topology: Topology, end: LinkEnd) -> bool:
    """Whether a beam goes on at its end in another one."""
    return any(end in (weld.leader, weld.follower) for weld in topology.welds)


def _thickness(mechanism: Mechanism, pin: JointPin, end: LinkEnd) -> float | None:
    """Length of a hole, as stated or as the link's section has it; None where it has no layers."""
    stated, layers = pin.eye(end.link).thickness, mechanism.layers_of(end.link)
    if stated is not None or layers is None:
        return stated
    return layers.width


def _width(mechanism: Mechanism, pin: JointPin, end: LinkEnd) -> float | None:
    """Width of an eye; None where none is stated and the link itself is narrower than the pin."""
    stated, section = pin.eye(end.link).width, mechanism.sections.get(end.link)
    if stated is not None or section is None or section.in_plane_thickness <= pin.diameter:
        return stated
    return section.in_plane_thickness


def _yield_strength(mechanism: Mechanism, link: str) -> float | str:
    """Yield strength of a link of one isotropic material, or why there is none."""
    layers = mechanism.layers_of(link)
    if layers is None:
        return "for its material is not known"
    (ply, *others) = {layer.ply for layer in layers.laminate.layers}
    if others or ply.isotropic_material is None:
        return "for the strengths of plies do not give that of an eye"
    if ply.yield_strength is None:
        return WANT.format("yield_strength of the material")
    return ply.yield_strength
