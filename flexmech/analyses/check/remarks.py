"""A linkage in a sentence, and remarks of an engineer on a mechanism.

What cannot be at all is refused where a number is read (:mod:`flexmech.plausible`); here are the
ranges of what is usual. Sections without known layers are judged by what their stiffnesses and
masses say together.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import Drive, FourBar, Linkage, PlanarLinkage, assemblable
from flexmech.linkages.change_points import passing
from flexmech.mechanism import Mechanism
from flexmech.sections import BeamSection
from flexmech.units import ZERO_CELSIUS, from_si

# A range of motion with a gap of less than a degree passes as a whole turn.
_TURN = np.radians(np.arange(0.0, 360.0))


def linkage_in_short(linkage: Linkage) -> str:
    """Kind and size of a linkage, whether its crank turns fully, and its transmission angle.

    Parameters
    ----------
    linkage : Linkage

    Returns
    -------
    str
        A sentence.

    Examples
    --------
    >>> linkage_in_short(flexmech.FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667))
    'A four-bar, crank-rocker: the crank turns fully; the transmission angle is 32.21 to 81.33 deg.'
    """
    if isinstance(linkage, FourBar):
        angles = " to ".join(f"{math.degrees(a):.4g}" for a in linkage.transmission_angle_limits())
        return (
            f"A four-bar, {linkage.grashof_class}: the crank {_turns(linkage.crank_turns_fully)}; "
            f"the transmission angle is {angles} deg."
        )
    if not isinstance(linkage, PlanarLinkage):
        (arm,) = linkage.topology.links
        return f"An arm of {1e3 * arm.length:.6g} mm on a hub: it turns fully."
    if linkage.drawing.is_stationary:
        return "A frame that stands still: nothing drives it."
    return f"{_planar_kind(linkage)}: the crank {_turns(turns_fully(linkage))}."


def turns_fully(linkage: Linkage) -> bool:
    """Whether the crank makes whole turns; a linkage that stands still has none to make.

    Parameters
    ----------
    linkage : Linkage

    Returns
    -------
    bool
        True if the crank turns fully; for a drawn linkage, if it has no change point and assembles
        at all whole degrees.
    """
    if isinstance(linkage, FourBar):
        return linkage.crank_turns_fully
    if isinstance(linkage, PlanarLinkage) and linkage.drawing.is_stationary:
        return True
    return bool(not linkage.change_angles.size and assemblable(linkage, _TURN).all())


def _planar_kind(linkage: PlanarLinkage) -> str:
    """A drawing in words: a slider-crank with its lengths, or the number of links and sliders."""
    links, topology = linkage.links, linkage.topology
    sliders = topology.sliders
    count, many = len(links), len(sliders)
    if len(topology.links) == count == 2 and many == 1 and not sliders[0].guide:
        crank, rod = (1e3 * link.length for link in topology.links)
        return f"A slider-crank of {crank:.6g} and {rod:.6g} mm"
    moving = f"A planar linkage of {count} moving link{'s' * (count > 1)}"
    return f"{moving}, {many} slider{'s' * (many > 1)}" if many else moving


def _turns(fully: bool) -> str:
    return "turns fully" if fully else "does not turn fully"


# In m/s^2, some 1e4 times that of weight: the fastest machines stay well below it.
_MOST_ACCELERATION = 1e5
_GRAVITY = 9.80665
# Time in which the crank gains its speed over the period of the first mode. A cycloidal move takes
# pi times as long: a tenth of a period.
_LEAST_RISE = 0.03


def on_transmission(linkage: PlanarLinkage, least: float) -> Iterator[str]:
    """On joints of a drawn linkage whose transmission angle is small.

    Parameters
    ----------
    linkage : PlanarLinkage
    least : float
        Usual transmission angle in degrees.

    Yields
    ------
    str
        Nothing of a crank that does not turn fully, which ends where a transmission angle is zero.
    """
    if linkage.drawing.is_stationary or not turns_fully(linkage):
        return
    for joint, angle in linkage.transmission_angles(_TURN).items():
        place = int(angle.argmin())
        degrees = math.degrees(float(angle[place]))
        if degrees < least:
            yield (
                f"joint {joint}: transmission angle {degrees:.4g} deg (pressure angle "
                f"{90 - degrees:.4g} deg) at crank angle {math.degrees(_TURN[place]):.4g} deg is "
                f"below {least:g} deg: joint forces are large for little motion"
            )


def on_drive(mechanism: Mechanism, first: float | None) -> Iterator[str]:
    """On a law of motion, or a run-up, that is faster than machines are.

    Parameters
    ----------
    mechanism : Mechanism
    first : float or None
        First natural frequency in Hz, where it is known.

    Yields
    ------
    str
    """
    drive = mechanism.drive
    if not isinstance(drive, Drive) or drive.is_constant:
        return
    crank = mechanism.linkage.topology.links[0]
    times = drive.passing_times
    accelerations, speeds = drive.crank_acceleration(times), drive.crank_speed(times)
    gained, speed = float(np.abs(accelerations).max()), float(np.abs(speeds).max())
    reached = crank.length * float(np.hypot(accelerations, speeds**2).max())
    if reached > _MOST_ACCELERATION:
        yield (
            f"drive, {drive.words}: the end of the {crank.name} is accelerated by up to "
            f"{reached:.3g} m/s^2, {reached / _GRAVITY:.3g} times its weight; check the times"
        )
    if first and gained and speed / gained * first < _LEAST_RISE:
        yield (
            f"drive, {drive.words}: the crank gains its speed of {speed:.4g} rad/s in some "
            f"{speed / gained:.2g} s, {speed / gained * first:.2g} of a period of the first "
            f"natural frequency, {first:.4g} Hz: the links cannot follow; check the times"
        )


# Ashby, Materials Selection in Mechanical Design: foams and soft rubber, diamond.
_LEAST_MODULUS, _MOST_MODULUS = 1e6, 1.1e12
# Polymer foams, osmium.
_LEAST_DENSITY, _MOST_DENSITY = 10.0, 2.3e4
# Speed of longitudinal waves in a bar, m/s: rubber, diamond.
_LEAST_WAVE_SPEED, _MOST_WAVE_SPEED = 10.0, 1.9e4
# Below it shear and the ends govern: a link is no beam. Above it its own weight bends it.
_LEAST_SLENDERNESS, _MOST_SLENDERNESS = 5.0, 1000.0
# In degrees, of a crank that is drawn: what coordinates of three digits leave.
_AS_DRAWN_AT = 0.1
# In degrees; Alt's limits, as in Balli & Chand 2002, Mechanism and Machine Theory 37, 175-195.
USUAL_TRANSMISSION_ANGLE = (40.0, 140.0)
# Above that of machines, 10 or less, and below a slip of a unit: millimetres for centimetres are
# decided with links that differ by a factor of two.
_MOST_LENGTH_RATIO = 20.0
# Part of the longest link: lengths are made as exactly as this.
_NEARLY_IN_LINE = 1e-3
# Point masses over the mass of all links: a tool may be ten times as heavy, grams for kilograms a
# thousand times.
_MOST_ADDED = 20.0
# Radius of gyration over the longest link: a hub's is a hundredth, g for kg make a thirtieth of it.
_LEAST_GYRATION = 1e-3
# The moon's is 1.6 m/s^2, Jupiter's 25.
_LEAST_GRAVITY, _MOST_GRAVITY = 1.0, 30.0
# In K: composites are cured at less, and machines run at more; 20 for 20 degC is below.
_LEAST_TEMPERATURE, _MOST_TEMPERATURE = 200.0, 500.0
# Turns a second over the first natural frequency: the third harmonic of the loads meets it there.
# Strain by inertia along a link: that of metals when they yield.
_MOST_SPEED_RATIO, _MOST_INERTIA_STRAIN = 1 / 3, 2e-3
# Greatest damping ratio of the first mode: rubber has as much.
_MOST_DAMPING_RATIO = 0.2


def remarks(mechanism: Mechanism, frequency: FloatArray | None = None) -> tuple[str, ...]:
    """Lines on numbers of a mechanism that are unusual, with what is usual.

    Parameters
    ----------
    mechanism : Mechanism
    frequency : ndarray, optional
        Natural frequencies at rest in Hz, ascending, where they are known.

    Returns
    -------
    tuple of str
        Empty where nothing stands out.
    """
    remarks = [*_on_sections(mechanism), *_on_masses(mechanism), *_on_environment(mechanism)]
    if isinstance(mechanism.linkage, FourBar):
        remarks += _on_four_bar(mechanism.linkage, mechanism.operating_speeds)
    if isinstance(mechanism.linkage, PlanarLinkage):
        remarks += _on_drawing(mechanism.linkage)
        remarks += on_transmission(mechanism.linkage, USUAL_TRANSMISSION_ANGLE[0])
        if mechanism.operating_speeds and not mechanism.linkage.drawing.is_stationary:
            remarks += _on_turning(mechanism.linkage)
    first = None if frequency is None or not len(frequency) else float(frequency[0])
    remarks += on_drive(mechanism, first)
    if frequency is not None and len(frequency) and frequency[0] > 0:
        remarks += _on_first_frequency(mechanism, float(frequency[0]))
    return tuple(remarks)


def _on_sections(mechanism: Mechanism) -> Iterator[str]:
    for link in mechanism.linkage.topology.links:
        if link.name not in mechanism.sections:
            continue
        section = mechanism.sections[link.name]
        yield from (f"{link.name}: {text}" for text in _on_material(section))
        yield from (f"{link.name}: {text}" for text in _on_strengths(section))
        yield from (f"{link.name}: {text}" for text in _on_shape(section, link.length))


def _on_strengths(section: BeamSection) -> Iterator[str]:
    """On a material that tears before it yields."""
    layers = () if section.layers is None else section.layers.laminate.layers
    for ply in dict.fromkeys(layer.ply for layer in layers):
        material = ply.isotropic_material
        if material is None or material.fatigue is None or material.yield_strength is None:
            continue
        tensile, yields = material.fatigue.tensile_strength, material.yield_strength
        if tensile < yields:
            yield (
                f"tensile strength {from_si(tensile, 'MPa'):.4g} MPa is below the yield strength "
                f"{from_si(yields, 'MPa'):.4g} MPa: a material yields before it tears; check both"
            )


def _on_material(section: BeamSection) -> Iterator[str]:
    """On modulus and density, or on what a section without a width tells of them."""
    if section.layers is None:
        speed = math.sqrt(section.axial_stiffness / section.mass_per_length)
        if not _LEAST_WAVE_SPEED <= speed <= _MOST_WAVE_SPEED:
            yield (
                f"EA and rho A are those of a material in which sound travels at {speed:.3g} m/s, "
                f"usual are {_LEAST_WAVE_SPEED:g} to {_MOST_WAVE_SPEED:g} m/s; check their units"
            )
        return
    area = section.layers.width * section.in_plane_thickness
    modulus, density = section.axial_stiffness / area, section.mass_per_length / area
    if not _LEAST_MODULUS <= modulus <= _MOST_MODULUS:
        than = "softer than rubber" if modulus < _LEAST_MODULUS else "stiffer than diamond"
        yield f"Young's modulus {modulus:.4g} Pa is {than}; check its unit"
    if not _LEAST_DENSITY <= density <= _MOST_DENSITY:
        than = "lighter than foam" if density < _LEAST_DENSITY else "heavier than any metal"
        yield f"density {density:.4g} kg/m^3 is {than}; check its unit"


def _on_shape(section: BeamSection, length: float) -> Iterator[str]:
    """On thickness and width against the length, and thickness against the stiffness."""
    thickness = section.in_plane_thickness
    slenderness, size = length / thickness, f"{_mm(thickness)} thick at a length of {_mm(length)}"
    if slenderness < _LEAST_SLENDERNESS:
        yield (
            f"{size} is no slender beam (length over thickness {slenderness:.2g}, below "
            f"{_LEAST_SLENDERNESS:g}): beam theory says little of it"
        )
    elif slenderness > _MOST_SLENDERNESS:
        yield (
            f"{size} is a string rather than a beam (length over thickness {slenderness:.4g}, "
            f"above {_MOST_SLENDERNESS:g})"
        )
    if section.layers is not None and section.layers.width > length:
        yield (
            f"{_mm(section.layers.width)} wide at a length of {_mm(length)}: it bends as a plate, "
            "stiffer than a beam"
        )
    radius = math.sqrt(section.bending_stiffness / section.axial_stiffness)
    if section.layers is None and not 0.1 * thickness <= radius <= 0.5 * thickness:
        yield (
            f"EI over EA asks for a thickness of {_mm(2 * radius)} to {_mm(math.sqrt(12) * radius)}"
            f", {_mm(thickness)} is stated; strains at the surface depend on it"
        )


def _on_masses(mechanism: Mechanism) -> Iterator[str]:
    links = mechanism.linkage.topology.links
    total = sum(
        mechanism.sections[link.name].mass_per_length * link.length
        for link in links
        if link.name in mechanism.sections
    ) + sum(body.mass for body in mechanism.bodies)
    masses = {f"joint {name}": mass for name, mass in mechanism.joint_masses.items()}
    masses |= {
        f"{point.link} at {_mm(point.position)}": point.mass for point in mechanism.link_masses
    }
    for where, mass in masses.items():
        if mass > _MOST_ADDED * total:
            yield (
                f"{where}: a point mass of {mass:.4g} kg is {mass / total:.3g} times the mass of "
                "all links; check its unit"
            )
    size, every = max(link.length for link in links), total + sum(masses.values())
    for body in mechanism.bodies:
        rest = every - body.mass
        if rest and body.mass > _MOST_ADDED * rest:
            yield (
                f"{body.link}: a body of {body.mass:.4g} kg is {body.mass / rest:.3g} times the "
                "mass of all else that moves; check its unit"
            )
        if not body.inertia or not body.mass:
            continue
        radius = math.sqrt(body.inertia / body.mass)
        if not _LEAST_GYRATION * size <= radius <= size:
            side = "longer than any link" if radius > size else "hardly more than a point"
            yield (
                f"{body.link}: an inertia of {body.inertia:.4g} kg m^2 with {body.mass:.4g} kg is "
                f"that of a radius of gyration of {_mm(radius)}, {side} (up to {_mm(size)}); check "
                "their units"
            )


def _on_environment(mechanism: Mechanism) -> Iterator[str]:
    gravity = math.hypot(*mechanism.gravity)
    if gravity and not _LEAST_GRAVITY <= gravity <= _MOST_GRAVITY:
        yield f"gravity of {gravity:.4g} m/s^2: on earth it is 9.81 m/s^2; check its unit"
    kelvin = mechanism.reference_temperature
    if not _LEAST_TEMPERATURE <= kelvin <= _MOST_TEMPERATURE:
        yield f"reference temperature {kelvin - ZERO_CELSIUS:.4g} degC is unusual; check its unit"


def _on_four_bar(linkage: FourBar, speeds: tuple[float, ...]) -> Iterator[str]:
    least, greatest = linkage.transmission_angle_limits()
    low, high = USUAL_TRANSMISSION_ANGLE
    if not linkage.crank_turns_fully:
        # It ends where coupler and rocker are in line: its transmission angle says no more.
        if speeds:
            yield (
                f"the crank cannot turn fully ({linkage.grashof_class}), but operating speeds are "
                "stated"
            )
    elif least < math.radians(low) or greatest > math.radians(high):
        ends = " to ".join(f"{math.degrees(angle):.4g}" for angle in (least, greatest))
        yield (
            f"transmission angle {ends} deg leaves the usual {low:g} to {high:g} deg: "
            "joint forces are large for little motion; see flexmech synthesize"
        )
    lengths = sorted(linkage.lengths.values())
    if lengths[-1] > _MOST_LENGTH_RATIO * lengths[0]:
        yield (
            f"lengths from {_mm(lengths[0])} to {_mm(lengths[-1])}: a ratio of "
            f"{lengths[-1] / lengths[0]:.3g}; check their units"
        )
    apart = abs(lengths[0] + lengths[-1] - lengths[1] - lengths[2])
    if apart < _NEARLY_IN_LINE * lengths[-1]:
        yield "all links come into one line, or nearly: small errors of lengths decide how it moves"


def _on_drawing(linkage: PlanarLinkage) -> Iterator[str]:
    """On a crank that does not stand at the crank angle for which the linkage is drawn."""
    drawing = linkage.drawing
    first = drawing.link(drawing.crank).beams[0]
    start, end = (drawing.complex_point(name) for name in (first.start, first.end))
    apart = cmath.phase((end - start) / cmath.rect(1.0, linkage.drawn_angle))
    if abs(apart) > math.radians(_AS_DRAWN_AT):
        stands, said = cmath.phase(end - start), linkage.drawn_angle
        yield (
            f"the {drawing.crank} is drawn at {math.degrees(stands):.4g} deg, from {first.start} "
            f"to {first.end}, and drawn_at says {math.degrees(said):.4g} deg: crank angles count "
            "from drawn_at; correct one of them, unless that is meant"
        )


def _on_turning(linkage: PlanarLinkage) -> Iterator[str]:
    """On a crank that is to turn and cannot."""
    if linkage.change_angles.size:
        yield (
            f"{passing(linkage.change_angles)}, where small errors of lengths decide how it moves, "
            "and operating speeds are stated"
        )
    elif not turns_fully(linkage):
        yield "the crank cannot turn fully, and operating speeds are stated"


def _on_first_frequency(mechanism: Mechanism, first: float) -> Iterator[str]:
    """On crank speeds against the first natural frequency, and its damping."""
    speed = max((abs(each) for each in mechanism.operating_speeds), default=0.0)
    turns, unit = speed / (2 * math.pi), mechanism.speed_unit
    speed_text = f"{from_si(speed, unit):.6g} {unit}"
    if turns > _MOST_SPEED_RATIO * first:
        yield (
            f"operating speed {speed_text} turns the crank {turns:.4g} times a second, the "
            f"first natural frequency is {first:.4g} Hz: below three times as much linkages ring "
            "and links may buckle; check the unit of the speed"
        )
    for link in mechanism.linkage.topology.links[:1] if speed else ():
        section = mechanism.sections.get(link.name)
        if section is None or link.rigid:
            continue
        strain = section.mass_per_length * (speed * link.length) ** 2 / section.axial_stiffness / 2
        if strain > _MOST_INERTIA_STRAIN:
            yield (
                f"{link.name}: stretched by {100 * strain:.2g} % at {speed_text} by its own "
                "inertia, more than materials bear"
            )
    times = [section.damping.bending for section in mechanism.sections.values()]
    ratio = float(np.max(times, initial=0.0)) * math.pi * first
    if ratio > _MOST_DAMPING_RATIO:
        yield (
            f"damping of up to {100 * ratio:.3g} % of critical in the first mode, usual is below "
            f"{100 * _MOST_DAMPING_RATIO:g} %; check the damping time"
        )


def _mm(metres: float) -> str:
    return f"{metres:.4g} m" if metres >= 1 else f"{metres * 1e3:.4g} mm"
