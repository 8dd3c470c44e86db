"""Peaks of a design over a turn of the crank, sought between crank angles as well."""

from __future__ import annotations

import numpy as np

from flexmech.analyses.extremes import Values, greatest_between
from flexmech.analyses.frequencies.positions import strain_energy_damping
from flexmech.arrays import FloatArray
from flexmech.choices import Prestress
from flexmech.errors import InputError, suggestion
from flexmech.linkages import CouplerPoint
from flexmech.linkages.motion import direction
from flexmech.mechanism import Mechanism
from flexmech.studies.designs.design import Design

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


def peak_joint_force(design: Design, speed: float, angles: int, joint: str | None) -> float:
    """Greatest force in a joint of the rigid linkage over a turn, in N.

    Parameters
    ----------
    design : Design
    speed : float
        Crank speed in rad/s.
    angles : int
        Crank angles over the turn that count in any case.
    joint : str or None
        The greatest of all joints if left out.

    Returns
    -------
    float

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

    return _greatest(forces_at, angles)


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
