"""Outputs that a study computes of every design.

Peaks over a turn of the crank are sought between crank angles as well.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple, get_args

import numpy as np

from flexmech.analyses.digits import rounded
from flexmech.analyses.extremes import Values, greatest_between
from flexmech.analyses.frequencies.extremes import Extremes
from flexmech.analyses.frequencies.positions import strain_energy_damping
from flexmech.analyses.stability.compute import stability
from flexmech.arrays import FloatArray
from flexmech.choices import Prestress
from flexmech.errors import InputError, suggestion
from flexmech.linkages import CouplerPoint, FourBar
from flexmech.linkages.motion import direction
from flexmech.mechanism import Mechanism
from flexmech.studies.design import Design, ExtremesWanted, FrequencyNeeds, every_extreme
from flexmech.units import (
    ANGLE,
    FORCE,
    FREQUENCY,
    LENGTH,
    MASS,
    RATIO,
    STRESS,
    TORQUE,
    Dimension,
    from_si,
)
from flexmech.validation import check_choice, check_count

# Damping ratios cost a solution of eigenvalues at every crank angle, and dip where modes veer: they
# are sought in steps of 2.5 deg, of which three zooms leave less than a hundredth. A damping ratio
# is known to 1e-5 of it then.
_STEP, _ZOOMS = np.radians(2.5), 3


def peak_driving_torque(design: Design, speed: float, angles: int) -> float:
    """Greatest driving torque of the rigid linkage over a turn, in N m.

    Parameters
    ----------
    design : Design
    speed : float
        Crank speed in rad/s.
    angles : int
        Crank angles over the turn that count in any case.

    Returns
    -------
    float
    """

    def torque_at(crank_angle: FloatArray) -> FloatArray:
        return np.abs(design.forces_at(crank_angle, speed).driving_torque)[:, None]

    return _greatest(torque_at, angles)


def peak_joint_forces(
    design: Design, speed: float, angles: int, joint: str | None
) -> dict[str, float]:
    """Greatest force in each joint of the rigid linkage over a turn, in N.

    Parameters
    ----------
    design : Design
    speed : float
        Crank speed in rad/s.
    angles : int
        Crank angles over the turn that count in any case.
    joint : str or None
        That joint alone; all joints if left out.

    Returns
    -------
    dict of str to float

    Raises
    ------
    InputError
        If there is no such joint.
    """
    names = design.mechanism.linkage.topology.joint_names
    if joint is not None and joint not in names:
        raise InputError(f"there is no joint {joint!r}; {suggestion(joint, list(names))}")
    chosen = names if joint is None else (joint,)

    def forces_at(crank_angle: FloatArray) -> FloatArray:
        found = design.forces_at(crank_angle, speed).joint_force
        return np.stack([np.linalg.norm(found[name], axis=-1) for name in chosen], axis=1)

    peaks = greatest_between(forces_at, _closed_turn(angles)).value
    return dict(zip(chosen, peaks.tolist(), strict=True))


def path_error(design: Design, angles: int, points: tuple[tuple[float, float], ...]) -> float:
    """Greatest distance of the path of the coupler point from that of the model, in m.

    Parameters
    ----------
    design : Design
    angles : int
        Crank angles over the turn that count in any case.
    points : tuple of (float, float)
        The greatest of their distances from the path, if there are some; else that of places at
        equal crank angles.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the mechanism has no coupler point.
    """
    mechanism, model = design.mechanism, design.model
    point, of_model = (_coupler_point(one) for one in (mechanism, model))
    if not points:

        def apart_at(crank_angle: FloatArray) -> FloatArray:
            here = _places(mechanism, point, crank_angle)
            there = _places(model, of_model, crank_angle)
            return np.asarray(np.linalg.norm(here - there, axis=-1)[:, None])

        return _greatest(apart_at, angles)

    def nearness_at(crank_angle: FloatArray) -> FloatArray:
        places = _places(mechanism, point, crank_angle)
        return np.asarray(-np.linalg.norm(places[:, None] - np.array(points), axis=-1))

    nearest = greatest_between(nearness_at, _closed_turn(angles)).value
    return float(-nearest.min())


def least_damping(
    design: Design, speed: float, angles: int, mode: int, prestress: Prestress
) -> float:
    """Least damping ratio of a mode by modal strain energy over a turn.

    Parameters
    ----------
    design : Design
    speed : float
        Crank speed in rad/s.
    angles : int
        Crank angles over the turn that count in any case.
    mode : int
        Its number from 1.
    prestress : {"none", "axial", "equilibrium"}

    Returns
    -------
    float
    """

    def less_damping_at(crank_angle: FloatArray) -> FloatArray:
        found = strain_energy_damping(
            design.engine, crank_angle, speed, modes=max(mode, 3), prestress=prestress
        )
        return -found[:, mode - 1 : mode]

    found = greatest_between(less_damping_at, _closed_turn(angles), step=_STEP, zooms=_ZOOMS)
    return float(-found.value[0])


def _greatest(values_at: Values, angles: int) -> float:
    return float(greatest_between(values_at, _closed_turn(angles)).value.max())


def _closed_turn(count: int) -> FloatArray:
    """Evenly spaced crank angles over a turn with both its ends, in rad, (count + 1,)."""
    return np.linspace(0.0, 2 * np.pi, count + 1)


def _coupler_point(mechanism: Mechanism) -> CouplerPoint:
    if mechanism.coupler_point is None:
        raise InputError("path_error needs a coupler_point in the model file")
    return mechanism.coupler_point


def _places(mechanism: Mechanism, point: CouplerPoint, crank_angle: FloatArray) -> FloatArray:
    """Places of a coupler point in m, (A, 2)."""
    motion = mechanism.linkage.motion(crank_angle)
    coupler = mechanism.linkage.topology.index("coupler")
    arm = point.distance * direction(motion.angle[..., coupler] + point.angle)
    return np.asarray(motion.origin[..., coupler, :] + arm)


Quantity = Literal[
    "lowest_frequency",
    "highest_frequency",
    "order_margin",
    "mass",
    "transmission_angle",
    "path_error",
    "peak_driving_torque",
    "peak_joint_force",
    "peak_deflection",
    "peak_strain",
    "peak_stress",
    "path_deviation",
    "residual_amplitude",
    "strain_energy_damping",
    "largest_multiplier",
    "stable_speed_margin",
]
"""Names of what can be computed of a design."""

OF_FREQUENCIES = ("lowest_frequency", "highest_frequency", "order_margin")
"""Quantities that are found from the natural frequencies over a turn."""

COSTLY = (
    "peak_deflection",
    "peak_strain",
    "peak_stress",
    "path_deviation",
    "residual_amplitude",
    "strain_energy_damping",
    "largest_multiplier",
    "stable_speed_margin",
)
"""Quantities that take a second or more a design, or nearly so."""

_SHOWN = {LENGTH: "mm", ANGLE: "deg", STRESS: "MPa"}
# Part of the crank speed by which unstable bands are searched for, and at how many speeds.
_REACH, _SPEEDS = 0.5, 51


class Kind(NamedTuple):
    """Kind of an output.

    Parameters
    ----------
    dimension : Dimension
    words : str
        For axes and tables.
    compute : callable
        Takes a design and the output.
    """

    dimension: Dimension
    words: str
    compute: Callable[[Design, Output], float]


@dataclass(frozen=True)
class Output:
    """A number that a study computes of every design.

    Parameters
    ----------
    quantity : str
        One of :data:`Quantity`.
    speed : float, optional
        Crank speed in rad/s; the design's own where the speed varies, else the greatest at which
        the mechanism operates, zero if it names none.
    mode : int
        Mode of frequencies, damping and residual vibration; the lowest is 1.
    orders : tuple of int
        Multiples of the crank speed that ``order_margin`` keeps away from.
    link, joint, point : str, optional
        Where deflection, strain, stress and residual vibration, joint force, and the deviation from
        the path are taken; the greatest of all if left out. A point is a joint, ``"coupler point"``
        or a body of a link, as ``"coupler body 1"``.
    prestress : {"none", "axial", "equilibrium"}
        Prestress of frequencies.
    angles : int
        Crank angles over a turn, between which extremes are sought as well.
    points : tuple of (float, float)
        In m: the path of the coupler point should pass them. Left out: ``path_error`` is the
        greatest distance from the path of the model itself at equal crank angles.

    Raises
    ------
    InputError
        If the quantity is unknown or a number impossible.

    Examples
    --------
    >>> flexmech.studies.Output("lowest_frequency", speed=62.8).dimension.unit
    'Hz'
    """

    quantity: Quantity
    speed: float | None = None
    mode: int = 1
    orders: tuple[int, ...] = (1, 2, 3, 4, 5, 6)
    link: str | None = None
    joint: str | None = None
    point: str | None = None
    prestress: Prestress = "equilibrium"
    angles: int = 36
    points: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        if self.quantity not in get_args(Quantity):
            raise InputError(
                f"there is no output {self.quantity!r}; "
                f"{suggestion(str(self.quantity), list(get_args(Quantity)))}"
            )
        check_count(self.mode, "mode")
        check_count(self.angles, "angles", least=4)
        check_choice(self.prestress, ("none", "axial", "equilibrium"), "prestress")

    @property
    def kind(self) -> Kind:
        """Quantity of the output."""
        return KINDS[self.quantity]

    @property
    def dimension(self) -> Dimension:
        """Dimension of the output's numbers."""
        return self.kind.dimension

    @property
    def shown_unit(self) -> str:
        """Unit in which results speak of it."""
        return _SHOWN.get(self.dimension, self.dimension.unit)

    def speed_of(self, design: Design) -> float:
        """Crank speed in rad/s: its own, or that of a design."""
        return design.speed if self.speed is None else self.speed

    @property
    def extremes(self) -> ExtremesWanted:
        """Frequencies of a turn that it seeks between the crank angles."""
        if self.quantity == "order_margin":
            return every_extreme(max(self.mode, 3))
        return frozenset({(int(self.quantity == "highest_frequency"), self.mode - 1)})

    def needs_of(self, design: Design) -> FrequencyNeeds | None:
        """Natural frequencies that it needs of a design; None where it needs none."""
        if self.quantity not in OF_FREQUENCIES:
            return None
        return FrequencyNeeds(self.speed_of(design), self.prestress, self.angles, max(self.mode, 3))

    def text(self, value: float, error: float = 0.0) -> str:
        """A number of it with its unit, to the digits that its error leaves."""
        scale = from_si(1.0, self.shown_unit)
        return f"{rounded(value * scale, error * scale)} {self.shown_unit}".rstrip()

    def of(self, design: Design) -> float:
        """The number of one design in SI units.

        Parameters
        ----------
        design : Design

        Returns
        -------
        float

        Raises
        ------
        FlexmechError
            If the design cannot be computed.
        """
        return float(self.kind.compute(design, self))

    def governed_by(self, design: Design) -> str:
        """Link, joint or point whose peak is the output; empty where it is not one of several.

        Parameters
        ----------
        design : Design

        Returns
        -------
        str

        Raises
        ------
        FlexmechError
            If the design cannot be computed.
        """
        name, speed = PEAKS.get(self.quantity), self.speed_of(design)
        if self.quantity == "peak_joint_force" and self.joint is None:
            forces = peak_joint_forces(design, speed, self.angles, None)
            return max(forces, key=lambda joint: forces[joint])
        if name is None or self.link is not None or self.point is not None:
            return ""
        return design.place_of_peak(name, speed)


PEAKS = {
    "peak_deflection": "deflection",
    "peak_strain": "strain",
    "peak_stress": "stress",
    "path_deviation": "path_deviation",
}
"""Peaks of the response over links or points, by the outputs that are the greatest of them."""


def _frequencies(design: Design, output: Output) -> Extremes:
    needs = output.needs_of(design)
    assert needs is not None
    return design.frequencies(needs)


def _peak(design: Design, output: Output) -> float:
    of = output.point if output.quantity == "path_deviation" else output.link
    return design.peak(PEAKS[output.quantity], output.speed_of(design), of)


def _residual(design: Design, output: Output) -> float:
    """Amplitude of a mode after the stop of the design's law of motion."""
    return design.residual_amplitude(output.mode, output.link)


def _lowest(design: Design, output: Output) -> float:
    return float(_frequencies(design, output).lowest_frequency[output.mode - 1])


def _highest(design: Design, output: Output) -> float:
    return float(_frequencies(design, output).highest_frequency[output.mode - 1])


def _order_margin(design: Design, output: Output) -> float:
    """Least relative distance of an order's frequency from a band of frequencies; 0 inside."""
    found = _frequencies(design, output)
    order = np.array(output.orders) * abs(output.speed_of(design)) / (2 * np.pi)
    if not order.all():
        raise InputError("order_margin needs a crank speed; state speed = ...")
    low, high = found.lowest_frequency, found.highest_frequency
    apart = np.maximum(low - order[:, None], order[:, None] - high)
    return float(np.maximum(apart / order[:, None], 0.0).min())


def _mass(design: Design, output: Output) -> float:
    return float(sum(link.moment(0) for link in design.mechanism.link_masses_in_order))


def _transmission_angle(design: Design, output: Output) -> float:
    """Least angle between coupler and rocker, or its supplement, over the turn in rad."""
    linkage = design.mechanism.linkage
    if not isinstance(linkage, FourBar):
        raise InputError("transmission_angle is of four-bars; choose another output")
    least, greatest = linkage.transmission_angle_limits()
    return min(least, np.pi - greatest)


def _path_error(design: Design, output: Output) -> float:
    return path_error(design, output.angles, output.points)


def _peak_torque(design: Design, output: Output) -> float:
    return peak_driving_torque(design, output.speed_of(design), output.angles)


def _peak_joint_force(design: Design, output: Output) -> float:
    forces = peak_joint_forces(design, output.speed_of(design), output.angles, output.joint)
    return max(forces.values())


def _damping(design: Design, output: Output) -> float:
    speed = output.speed_of(design)
    return least_damping(design, speed, output.angles, output.mode, output.prestress)


def _multiplier(design: Design, output: Output) -> float:
    """Greatest modulus of the Floquet multipliers of a turn."""
    found = stability(design.engine, [output.speed_of(design)]).dataset
    return float(found["multiplier_modulus"].max())


def _stable_margin(design: Design, output: Output) -> float:
    """How much faster than the crank speed the first band lies in which vibrations grow.

    They are about the quasi-static equilibrium: motions of many speeds take minutes a design.
    Relative to the speed, 0 within a band, and no more than the reach of the search.
    """
    speed = output.speed_of(design)
    speeds = speed * np.linspace(1.0, 1.0 + _REACH, _SPEEDS)
    found = stability(design.engine, speeds, prestress="equilibrium").dataset
    edges = found["band_lower"].values
    return float(min(edges.min(initial=np.inf) / speed - 1.0, _REACH))


KINDS: Mapping[str, Kind] = {
    "lowest_frequency": Kind(FREQUENCY, "lowest natural frequency over the turn", _lowest),
    "highest_frequency": Kind(FREQUENCY, "highest natural frequency over the turn", _highest),
    "order_margin": Kind(RATIO, "least distance from the crank's orders", _order_margin),
    "mass": Kind(MASS, "mass of the links", _mass),
    "transmission_angle": Kind(ANGLE, "least transmission angle", _transmission_angle),
    "path_error": Kind(LENGTH, "greatest error of the coupler path", _path_error),
    "peak_driving_torque": Kind(TORQUE, "peak driving torque, rigid links", _peak_torque),
    "peak_joint_force": Kind(FORCE, "peak joint force, rigid links", _peak_joint_force),
    "peak_deflection": Kind(LENGTH, "peak deflection", _peak),
    "peak_strain": Kind(RATIO, "peak strain", _peak),
    "peak_stress": Kind(STRESS, "peak normal stress", _peak),
    "path_deviation": Kind(LENGTH, "deviation from the path on rigid links", _peak),
    "residual_amplitude": Kind(LENGTH, "amplitude of a mode after the stop", _residual),
    "strain_energy_damping": Kind(RATIO, "least damping ratio by strain energy", _damping),
    "largest_multiplier": Kind(RATIO, "greatest Floquet multiplier", _multiplier),
    "stable_speed_margin": Kind(RATIO, "distance to the next unstable band", _stable_margin),
}
"""Kind of output by its quantity."""
