"""Force and moment that shake the frame: values, harmonics and words."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses.schema import Values
from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.linkages import Drive, InverseDynamics, MotorRun, continuous_angles
from flexmech.linkages.frame_forces import ShakingForce, shaking_force
from flexmech.mechanism import Mechanism
from flexmech.validation import check_pair

MOST_ORDER = 10
"""Most order of harmonics: orders of the crank angle from zero to this one."""

_PARTS = ("shaking_force", "shaking_moment")
_MM = 1e3
# Part of the greatest order below which an order stands in the table alone, not in a line.
_SHOWN = 1e-3


def checked_point(point: tuple[float, float] | None) -> tuple[float, float] | None:
    """Point about which moments are taken, as floats; None for the axis of the shaft.

    Parameters
    ----------
    point : tuple of float or None
        In ground axes, m.

    Returns
    -------
    tuple of float or None

    Raises
    ------
    InputError
        If it is no pair of numbers.
    """
    if point is None:
        return None
    check_pair(point, "moment_point", "m")
    x, y = point
    return float(x), float(y)


def shaft_torque(drive: Drive, shaft_inertia: float, time: FloatArray) -> FloatArray:
    """Torque on shaft and rotor, which the frame bears besides that on the links.

    A rotor with the inertia J behind a gear of the ratio n, which keeps the sense of rotation, has
    the angular momentum ``n J omega``: the frame bears its rate, and not ``n^2 J`` times the
    acceleration of the crank, by which gear and motor load the crank.

    Parameters
    ----------
    drive : Drive
    shaft_inertia : float
        In kg m^2, with that of a rotor that turns rigidly with the crank.
    time : ndarray, shape (N,)
        In s.

    Returns
    -------
    ndarray, shape (N,)
        In N m.
    """
    acceleration = drive.crank_acceleration(time)
    if not isinstance(drive, MotorRun):
        return shaft_inertia * acceleration
    rotor = drive.equation.train.rigid_inertia
    return (shaft_inertia - rotor) * acceleration + drive.rotor_torque(time)


def shaking_of(
    mechanism: Mechanism,
    forces: InverseDynamics,
    point: tuple[float, float] | None = None,
    shaft: float | FloatArray = 0.0,
) -> ShakingForce:
    """Shaking force and moment of a rigid linkage.

    Parameters
    ----------
    mechanism : Mechanism
        Whose springs to the ground count.
    forces : InverseDynamics
        Forces of the mechanism.
    point : tuple of float, optional
        About which the moment is taken, m; the shaft's axis if left out.
    shaft : float or ndarray, shape (...)
        Torque in N m on the shaft itself and on a motor's rotor; see :func:`shaft_torque`.

    Returns
    -------
    ShakingForce
    """
    topology, motion = mechanism.linkage.topology, forces.motion
    joint_force = np.stack([forces.joint_force[name] for name in topology.joint_names], axis=-2)
    return shaking_force(
        topology,
        motion,
        joint_force,
        forces.driving_torque + shaft,
        point,
        springs=mechanism.springs,
        joint_springs=mechanism.joint_springs,
        angles=mechanism_angles(mechanism, forces),
    )


def mechanism_angles(mechanism: Mechanism, forces: InverseDynamics) -> FloatArray | None:
    """Angles of the links counted on, where a spring in a joint needs them."""
    if not any(spring.torsional_stiffness for spring in mechanism.joint_springs):
        return None
    return continuous_angles(mechanism.linkage, forces.motion)


def harmonic_values(found: ShakingForce, crank_angle: FloatArray, prefix: str = "") -> Values:
    """Harmonics of a turn: each order is ``amplitude cos(order crank_angle + phase)``.

    Parameters
    ----------
    found : ShakingForce
        At A crank angles, evenly over one turn, its end left out.
    crank_angle : ndarray, shape (A,)
        In rad.
    prefix : str
        Before the names.

    Returns
    -------
    dict
        ``shaking_force_amplitude`` and ``_phase`` (order, component), ``shaking_moment_amplitude``
        and ``_phase`` (order), and ``shaking_force_order`` (order), the greatest size of an order's
        force, which goes round an ellipse; with the coordinate ``order``.
    """
    orders = np.arange(min(MOST_ORDER, (len(crank_angle) - 1) // 2) + 1)
    waves = np.exp(-1j * np.multiply.outer(orders, crank_angle)) / len(crank_angle)
    waves[1:] *= 2
    values: Values = {"order": orders}
    for name, over_turn in zip(_PARTS, (found.force, found.moment), strict=True):
        parts = waves @ over_turn
        # Less is what round-off leaves of an order that there is not.
        there = np.abs(parts) > ROUND_OFF * np.abs(over_turn).max(initial=0.0)
        parts = np.where(there, parts, 0.0)
        values[f"{prefix}{name}_amplitude"] = np.abs(parts)
        values[f"{prefix}{name}_phase"] = np.angle(parts)
        if parts.ndim > 1:
            # Half its long axis: what turns with the crank and what turns against it add up.
            x, y = parts.T
            size = (np.abs(x + 1j * y) + np.abs(x - 1j * y)) / 2
            values[f"{prefix}{name}_order"] = size
    return values


def point_text(data: xr.Dataset) -> str:
    """The point about which the moment is taken, in words."""
    x, y = (f"{_MM * place + 0.0:.6g}" for place in data["moment_point"].values.tolist())
    return f"({x}, {y}) mm"


def harmonics_line(data: xr.Dataset, what: str = "shaking") -> str:
    """Greatest sizes of the orders of force and moment.

    Parameters
    ----------
    data : xarray.Dataset
        Without further dimensions.
    what : str
        Whose, in words.

    Returns
    -------
    str
        Orders of less than a thousandth of the greatest are left out.
    """
    force, moment = data["shaking_force_order"].values, data["shaking_moment_amplitude"].values
    shown = [
        f"{order}: {force[n]:.4g} N, {moment[n]:.4g} N m"
        for n, order in enumerate(data["order"].values)
        if force[n] > _SHOWN * force.max() or moment[n] > _SHOWN * moment.max()
    ]
    listed = "; ".join(shown) or "none"
    return f"{what} force and moment by order of the crank angle, greatest magnitudes: {listed}"
