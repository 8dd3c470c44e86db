"""Numbers over the crank angle whose extremes are told: of links, joints, points and the drive."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr

from flexmech.analyses.kinematics.extremes import extremes, mean_over_turns
from flexmech.analyses.kinematics.variables import of_centres, of_forces, of_points
from flexmech.analyses.shaking import shaking_of
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import FourBar, InverseDynamics, rocker_swing
from flexmech.mechanism import Mechanism

Forces = Callable[[FloatArray], tuple[InverseDynamics, InverseDynamics | None]]
"""From crank angles (A,) to the forces there, by distributed masses and by lumped ones if any."""

_EXTREME = "extreme"


class Quantity(NamedTuple):
    """A number over the crank angle.

    Parameters
    ----------
    name : str
        What it is, such as ``"joint_force"``.
    of : str
        Link, joint or point that it is of; empty of the whole linkage.
    unit : str
        SI unit.
    values : ndarray, shape (A,)
    """

    name: str
    of: str
    unit: str
    values: FloatArray


def quantities(
    mechanism: Mechanism,
    forces: InverseDynamics,
    lumped: InverseDynamics | None,
    point: tuple[float, float] | None = None,
    shaft_torque: float | FloatArray = 0.0,
) -> Iterator[Quantity]:
    """Every number whose extremes are told, always in one order.

    Parameters
    ----------
    mechanism : Mechanism
    forces : InverseDynamics
        In positions (A,), by distributed masses.
    lumped : InverseDynamics or None
        By lumped masses.
    point : tuple of float, optional
        About which the shaking moment is taken, m.
    shaft_torque : float or ndarray, shape (A,)
        Of the drive on the shaft itself, N m.

    Yields
    ------
    Quantity
    """
    motion, topology = forces.motion, mechanism.linkage.topology
    centres, points = of_centres(forces.masses, motion), of_points(mechanism, motion)
    for number, link in enumerate(topology.link_names):
        for name, unit in (("angular_velocity", "rad/s"), ("angular_acceleration", "rad/s^2")):
            yield Quantity(name, link, unit, abs(getattr(motion, name)[:, number]))
        size = np.linalg.norm(centres["centre_acceleration"][1][:, number], axis=-1)
        yield Quantity("centre_acceleration", link, "m/s^2", size)
    for prefix, by in (("", forces), ("lumped_", lumped)):
        if by is None:
            continue
        found = of_forces(topology, by)
        for number, joint in enumerate(topology.joint_names):
            size = np.linalg.norm(found["joint_force"][1][:, number], axis=-1)
            yield Quantity(f"{prefix}joint_force", joint, "N", size)
        yield Quantity(f"{prefix}driving_torque", "", "N m", by.driving_torque)
    yield Quantity("driving_power", "", "W", forces.driving_power)
    shaking = shaking_of(mechanism, forces, point, shaft_torque)
    yield Quantity("shaking_force", "", "N", np.linalg.norm(shaking.force, axis=-1))
    yield Quantity("shaking_moment", "", "N m", shaking.moment)
    for number, place_of in enumerate(points["point"][1] if "point" in points else ()):
        for axis, component in enumerate("xy"):
            place = points["point_position"][1][:, number, axis]
            yield Quantity(f"position_{component}", place_of, "m", place)
        for name, unit in (("velocity", "m/s"), ("acceleration", "m/s^2")):
            size = np.linalg.norm(points[f"point_{name}"][1][:, number], axis=-1)
            yield Quantity(name, place_of, unit, size)
    for number, slider in enumerate(points["slider"][1] if "slider" in points else ()):
        for name, unit in (("position", "m"), ("velocity", "m/s"), ("acceleration", "m/s^2")):
            along = points[f"slider_{name}"][1][:, number]
            yield Quantity(f"slider_{name}", slider, unit, along)
    if isinstance(linkage := mechanism.linkage, FourBar):
        for name in ("transmission_angle", "reversed_transmission_angle"):
            yield Quantity(name, "", "rad", getattr(linkage, name)(motion.crank_angle))


def extremes_dataset(
    mechanism: Mechanism,
    at: Forces,
    crank_angles: FloatArray,
    point: tuple[float, float] | None = None,
    shaft_torque: float | Callable[[FloatArray], FloatArray] = 0.0,
    *,
    step: float | None = None,
) -> xr.Dataset:
    """Least and greatest values from the first crank angle to the last, and the mean power.

    Between the angles too, unless the linkage cannot be moved through all of them.

    Parameters
    ----------
    mechanism : Mechanism
    at : callable
        See :data:`Forces`.
    crank_angles : ndarray, shape (A,)
        In rad, increasing.
    point : tuple of float, optional
    shaft_torque : float or callable
        As in :func:`quantities`; or what gives it at the angles.
    step : float, optional
        Where the angles are times: in what steps extremes are sought, in s.

    Returns
    -------
    xarray.Dataset
        Over ``extreme``, told by its ``extreme_quantity``, ``extreme_of`` and ``extreme_unit``.
    """

    def found_at(angles: FloatArray) -> list[Quantity]:
        own = shaft_torque(angles) if callable(shaft_torque) else shaft_torque
        return list(quantities(mechanism, *at(angles), point, own))

    def values_at(angles: FloatArray) -> FloatArray:
        return np.stack([one.values for one in found_at(angles)], axis=1)

    named = found_at(crank_angles[:1])
    try:
        found, mean = extremes(values_at, crank_angles, step=step), None
        if step is None:
            mean = mean_over_turns(lambda angles: at(angles)[0].driving_power, crank_angles)
    except InputError:
        # It passes a dead point, or a gap of its range of motion.
        found, mean = extremes(values_at, crank_angles, between=False), None
    coordinates = {"quantity": "name", "of": "of", "unit": "unit"}
    dataset = xr.Dataset(
        {
            "least": (_EXTREME, found.least),
            "least_angle": (_EXTREME, found.least_angle),
            "greatest": (_EXTREME, found.greatest),
            "greatest_angle": (_EXTREME, found.greatest_angle),
            "extreme_error": (_EXTREME, found.error),
        },
        {
            f"{_EXTREME}_{name}": (_EXTREME, [getattr(one, field) for one in named])
            for name, field in coordinates.items()
        },
    )
    if mean is not None:
        dataset["mean_driving_power"], dataset["mean_driving_power_error"] = mean
        linkage = mechanism.linkage
        if isinstance(linkage, FourBar) and linkage.grashof_class == "crank-rocker":
            dataset["rocker_swing"] = rocker_swing(linkage)
    return dataset
