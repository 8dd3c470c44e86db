"""Rigid motion and inverse dynamics of a mechanism over crank angles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from flexmech.analyses.crank_speeds import RAD_S, one_rad_per_s
from flexmech.analyses.datasets import origin, with_units
from flexmech.analyses.kinematics.extremes import is_whole
from flexmech.analyses.kinematics.over_time import forces_along, over_time
from flexmech.analyses.kinematics.quantities import Forces, extremes_dataset
from flexmech.analyses.kinematics.result import Kinematics
from flexmech.analyses.kinematics.variables import of_centres, of_forces, of_lumps, of_points
from flexmech.analyses.remarks import crank_speed_text
from flexmech.analyses.requests import in_radians
from flexmech.analyses.shaking import (
    checked_point,
    harmonic_variables,
    shaking_of,
    shaking_variables,
)
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linear_system import Engine, checked_mechanism
from flexmech.linkages import (
    Drive,
    FourBar,
    InverseDynamics,
    Linkage,
    PlanarLinkage,
    assemblable,
    continuous_angles,
)
from flexmech.mechanism import Mechanism
from flexmech.validation import check_count, check_instance, check_number, checked_tuple

# Elements of a link whose mass is lumped: with so many the inertia force is the distributed one to
# six digits.
_MOST_LUMPS = 1000
# Of a turn whose harmonics are told: orders alias into them from those beyond 700 alone.
_HARMONIC_STEPS = 720
# Of a move with its dwell, or of a turn after a run-up; and of a whole law.
_STEPS_OF_A_CYCLE, _MOST_STEPS = 720, 20_000
# A linkage whose range of motion has a gap of less than a degree passes as one that turns.
_TURN = np.radians(np.arange(0.0, 360.0))


@dataclass(frozen=True)
class KinematicsRequest:
    """Crank angles, speed and acceleration, and how masses are lumped for a comparison.

    Parameters
    ----------
    crank_angles : array_like, shape (A,)
        In rad, increasing; a turn in steps of one degree if left out.
    crank_speed : float, optional
        In ``speed_unit``; may be zero or negative. Left out: the greatest speed at which the
        mechanism operates, zero if it names none.
    lumped : sequence of int, optional
        For each link in order the number of elements whose mass is halved onto their ends, or
        one number for all; Kumar & Chandrakar's Figure 1.5 has (1, 4, 4).
    speed_unit : str, optional
        Unit of the crank speed, such as ``"rpm"``, in which it is printed and drawn. Left out:
        rad/s, and the unit of the model file for the mechanism's speed.
    crank_acceleration : float, optional
        In rad/s^2, alpha2 of Kumar & Chandrakar's eqs. 1.35 to 1.40. At each crank angle
        the crank has the speed and this acceleration: these are states, and not one run through
        all angles.
    moment_point : tuple of float, optional
        About which the shaking moment is taken, in ground axes in m; the shaft's axis if left out.
    drive : Drive, optional
        A law of motion in place of angles, speed and acceleration: all is over time then.

    Raises
    ------
    InputError
        If a drive is given beside angles, speed or acceleration; or these are no numbers, angles do
        not increase, or a number of elements is below one or beyond 1000.

    Examples
    --------
    >>> flexmech.KinematicsRequest(crank_speed=20.0, lumped=(1, 4, 4)).crank_angles.shape
    (361,)
    """

    crank_angles: FloatArray = field(default_factory=lambda: np.radians(np.arange(361.0)))
    crank_speed: float | None = None
    lumped: Sequence[int] | None = None
    speed_unit: str | None = None
    crank_acceleration: float = 0.0
    moment_point: tuple[float, float] | None = None
    drive: Drive | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "moment_point", checked_point(self.moment_point))
        angles = in_radians("crank_angles", self.crank_angles)
        if angles.ndim != 1 or not angles.size or np.any(np.diff(angles) <= 0):
            raise InputError(
                f"crank_angles must be one or more in increasing order, got shape {angles.shape}"
            )
        object.__setattr__(self, "crank_angles", angles)
        if self.crank_speed is not None:
            one_rad_per_s(self.crank_speed, self.speed_unit)
        check_number(self.crank_acceleration, "crank_acceleration", "rad/s^2")
        if self.drive is not None:
            self._check_drive(self.drive)
        if self.lumped is not None:
            remedy = "give the elements of each link, as (1, 4, 4)"
            counts = checked_tuple(self.lumped, object, "lumped", remedy)
            for count in counts:
                check_count(count, "lumped: each number of elements")
                if count > _MOST_LUMPS:
                    raise InputError(
                        f"lumped: {count} elements of a link are beyond {_MOST_LUMPS}; the "
                        "distributed mass is what they tend to"
                    )
            object.__setattr__(self, "lumped", counts)

    def _check_drive(self, drive: Drive) -> None:
        check_instance(drive, Drive, "drive", "give a flexmech.LawDrive or another drive")
        others = self.crank_speed is not None or self.crank_acceleration
        usual = np.radians(np.arange(361.0))
        own = self.crank_angles.shape == usual.shape and np.allclose(self.crank_angles, usual)
        if others or not (own or drive.is_constant):
            raise InputError(
                "drive: a law of motion has its own angles, speed and acceleration; leave these "
                "out, or leave the drive out"
            )

    @property
    def law(self) -> Drive | None:
        """The drive, where it is more than a constant speed."""
        return None if self.drive is None or self.drive.is_constant else self.drive

    def speed_of(self, mechanism: Mechanism) -> float:
        """Crank speed in rad/s: as asked for, or the greatest at which a mechanism operates."""
        if self.crank_speed is not None:
            return one_rad_per_s(self.crank_speed, self.speed_unit)
        if self.drive is not None:
            return self.drive.greatest_speed
        return float(max(mechanism.operating_speeds, key=abs, default=0.0))

    def shown_unit(self, mechanism: Mechanism) -> str:
        """Unit in which the result for a mechanism speaks of crank speeds."""
        own = RAD_S if self.crank_speed is not None or self.drive else mechanism.speed_unit
        return self.speed_unit or own

    def lumped_of(self, mechanism: Mechanism) -> tuple[int, ...] | None:
        """Number of elements of each link of a mechanism; None where masses stay distributed.

        Parameters
        ----------
        mechanism : Mechanism

        Returns
        -------
        tuple of int or None

        Raises
        ------
        InputError
            If there are not as many numbers as links.
        """
        links = mechanism.linkage.topology.link_names
        if self.lumped is None:
            return None
        if len(self.lumped) == 1:
            return tuple(self.lumped) * len(links)
        if len(self.lumped) != len(links):
            raise InputError(
                f"lumped: {len(self.lumped)} numbers of elements for {len(links)} links; give one "
                f"for all, or one for each of {', '.join(links)}"
            )
        return tuple(self.lumped)


def kinematics(
    mechanism: Mechanism | Engine,
    speed: KinematicsRequest | float | None = None,
    *,
    speed_unit: str | None = None,
) -> Kinematics:
    """Angles, velocities, accelerations, joint forces and driving torque of the rigid linkage.

    The shaft turns at constant speed, or has an acceleration besides. Loads over time begin at
    crank angle zero. Kumar & Chandrakar, eqs. 1.22, 1.23 and 1.35 to 1.44 (1.36 corrected).

    Parameters
    ----------
    mechanism : Mechanism or Engine
        Of an engine its mechanism counts.
    speed : float or KinematicsRequest, optional
        Crank speed in ``speed_unit``, over a turn in steps of one degree, or all that can be asked
        for. Left out: the mechanism's drive, or the greatest speed at which it operates.
    speed_unit : str, optional
        Unit of the speed, such as ``"rpm"``, in which the result speaks of it. Left out: rad/s,
        that of the request, or that of the model file for the mechanism's speed.

    Returns
    -------
    Kinematics

    Raises
    ------
    InputError
        If the linkage cannot be assembled or locks at a crank angle, its connections do not
        determine the forces, the numbers of lumped masses do not fit its links, or the crank
        accelerates under a load over time.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> found = flexmech.kinematics(mechanism, 20.0)
    >>> float(abs(found.dataset["driving_torque"]).max().round(3))  # N m
    0.33
    """
    own = mechanism.mechanism if isinstance(mechanism, Engine) else mechanism
    mechanism = checked_mechanism(own)
    if not isinstance(speed, KinematicsRequest):
        drive = mechanism.drive if speed is None and speed_unit is None else None
        speed = KinematicsRequest(crank_speed=speed, speed_unit=speed_unit, drive=drive)
    elif speed_unit is not None:
        raise InputError("speed_unit: the request has its own; give it there")
    request, speed = speed, speed.speed_of(mechanism)
    elements = request.lumped_of(mechanism)
    if request.crank_acceleration:
        _refuse_loads_over_time(mechanism)

    if request.law is not None:
        return Kinematics(with_units(_along_law(mechanism, request.law, request), "kinematics"))

    def at(angles: FloatArray) -> tuple[InverseDynamics, InverseDynamics | None]:
        motion = mechanism.linkage.motion(angles, speed, request.crank_acceleration)
        time = angles / speed if speed else np.zeros_like(angles)
        forces = mechanism.inverse_dynamics(motion, time)
        if elements is None:
            return forces, None
        return forces, mechanism.inverse_dynamics(motion, time, elements)

    shaft = mechanism.shaft_inertia * request.crank_acceleration
    asked = request.crank_angles, request.moment_point, shaft
    dataset = kinematics_dataset(mechanism, *at(request.crank_angles), elements, request, shaft)
    found = extremes_dataset(mechanism, at, *asked)
    if request.crank_acceleration:
        # States, and not one run: power has no mean.
        found = found.drop_vars([n for n in found if str(n).startswith("mean_")])
    dataset = with_units(
        dataset.merge(found).merge(_harmonics(mechanism, at, request)), "kinematics"
    )
    return Kinematics(dataset.assign_attrs(warning=_on_turning(mechanism, request)))


def _along_law(mechanism: Mechanism, drive: Drive, request: KinematicsRequest) -> xr.Dataset:
    """Everything over the time of a law of motion."""
    elements = request.lumped_of(mechanism)
    at = forces_along(mechanism, drive, elements)
    cycles = drive.run_time(1.0) / drive.cycle_time
    steps = int(min(np.ceil(round(_STEPS_OF_A_CYCLE * cycles, 6)), _MOST_STEPS))
    time = drive.run_time(1.0) / steps * np.arange(steps + 1.0)
    shaft = mechanism.shaft_inertia * drive.crank_acceleration(time)
    dataset = kinematics_dataset(mechanism, *at(time), elements, request, shaft)
    return over_time(dataset, mechanism, drive, time, at, request.moment_point)


def _harmonics(mechanism: Mechanism, at: Forces, request: KinematicsRequest) -> xr.Dataset:
    """Harmonics of the shaking force; nothing where the angles are no whole turns of one run."""
    first, last = request.crank_angles[[0, -1]].tolist()
    if not is_whole(last - first) or request.crank_acceleration:
        return xr.Dataset()
    angles = first + 2 * np.pi * np.arange(_HARMONIC_STEPS) / _HARMONIC_STEPS
    try:
        forces, _ = at(angles)
    except InputError:
        # A dead point that is between the angles asked for.
        return xr.Dataset()
    found = shaking_of(mechanism, forces, request.moment_point)
    return xr.Dataset(harmonic_variables(found, angles))


def _on_turning(mechanism: Mechanism, request: KinematicsRequest) -> str:
    """Warning of a crank that is to turn and cannot turn fully; empty where it can."""
    linkage = mechanism.linkage
    if not request.speed_of(mechanism) or _turns_fully(linkage):
        return ""
    kind = f" ({linkage.grashof_class})" if isinstance(linkage, FourBar) else ""
    speed = crank_speed_text(
        {"crank_speed": request.speed_of(mechanism), "speed_unit": request.shown_unit(mechanism)}
    )
    return (
        f"the crank cannot turn fully{kind}, so that it cannot run at {speed}: the numbers are of "
        "states in which it passes an angle at that speed; change the lengths, or let it swing"
    )


def _turns_fully(linkage: Linkage) -> bool:
    """Whether the crank makes whole turns; what stands still has none to make."""
    if isinstance(linkage, FourBar):
        return linkage.crank_turns_fully
    if isinstance(linkage, PlanarLinkage) and linkage.drawing.is_stationary:
        return True
    return bool(assemblable(linkage, _TURN).all())


def _refuse_loads_over_time(mechanism: Mechanism) -> None:
    """An accelerated crank passes an angle at no known time."""
    names = [load.name for load in mechanism.loads if load.over == "time"]
    if names:
        raise InputError(
            f"crank_acceleration: the load {names[0]} goes over time, and when a crank that "
            "accelerates is at an angle is not known; leave the acceleration out, or give the "
            "load over the crank angle"
        )


_ANGLE, _LINK = "crank_angle", "link"


def kinematics_dataset(
    mechanism: Mechanism,
    forces: InverseDynamics,
    lumped: InverseDynamics | None,
    elements: Sequence[int] | None,
    request: KinematicsRequest,
    shaft: float | FloatArray,
) -> xr.Dataset:
    """Everything that tables and pictures show.

    Parameters
    ----------
    mechanism : Mechanism
    forces : InverseDynamics
        Of the distributed masses.
    lumped : InverseDynamics or None
        Of lumped masses.
    elements : sequence of int or None
        Of each link, whose mass is lumped.
    request : KinematicsRequest
    shaft : float or ndarray, shape (A,)
        Torque in N m that the shaft's own inertia takes.

    Returns
    -------
    xarray.Dataset
    """
    linkage, motion = mechanism.linkage, forces.motion
    topology = linkage.topology
    shaking = shaking_of(mechanism, forces, request.moment_point, shaft)
    dataset = xr.Dataset(
        {
            "angle": ((_ANGLE, _LINK), continuous_angles(linkage, motion)),
            "angular_velocity": ((_ANGLE, _LINK), motion.angular_velocity),
            "angular_acceleration": ((_ANGLE, _LINK), motion.angular_acceleration),
            **of_centres(forces.masses, motion),
            **of_forces(topology, forces),
            **shaking_variables(shaking, _ANGLE),
            "moment_point": ("component", np.array(shaking.point)),
            **of_points(mechanism, motion),
        },
        coords={
            _ANGLE: motion.crank_angle,
            _LINK: list(topology.link_names),
            "component": ["x", "y"],
            "joint": list(topology.joint_names),
            "joint_kind": ("joint", list(topology.joint_kinds)),
            "force_on": ("joint", [on for on, _ in topology.joint_sides]),
            "force_by": ("joint", [by for _, by in topology.joint_sides]),
        },
    )
    if isinstance(linkage, FourBar):
        for name in ("transmission_angle", "reversed_transmission_angle"):
            dataset[name] = _ANGLE, getattr(linkage, name)(motion.crank_angle)
    if lumped is not None and elements is not None:
        by_lumps = of_forces(topology, lumped)
        dataset = dataset.assign({f"lumped_{name}": of for name, of in by_lumps.items()})
        dataset = dataset.assign(of_lumps(forces.masses, elements, motion))
        lumps = (mass.lumps(count) for mass, count in zip(forces.masses, elements, strict=True))
        names = np.repeat(topology.link_names, [len(of_link) for of_link in lumps])
        dataset = dataset.assign_coords(lump_link=("lump", names))
    speed = request.speed_of(mechanism)
    attributes = {
        **origin(mechanism),
        "crank_speed": speed,
        "speed_unit": request.shown_unit(mechanism),
    }
    if request.crank_acceleration:
        attributes["crank_acceleration"] = float(request.crank_acceleration)
        attributes["shaft_inertia_torque"] = float(shaft)
    if elements is not None:
        attributes["lumped"] = ",".join(map(str, elements))
    return dataset.assign_attrs(attributes)
