"""Least and greatest values over a turn or a run, of all quantities that have extremes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from flexmech.analyses.extremes import extremes, mean_over_turns
from flexmech.analyses.kinematics.positions import values_of
from flexmech.analyses.schema import Values, schema_of
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import FourBar, InverseDynamics, rocker_swing
from flexmech.mechanism import Mechanism

Forces = Callable[[FloatArray], tuple[InverseDynamics, InverseDynamics | None]]
"""From crank angles (A,) to the forces there, by distributed masses and by lumped ones if any."""

SCHEMA = schema_of(__package__)

# Quantities with extremes by their names: the variable, and what of it counts, its ``size``, its
# ``value``, or a component by its number. Those of one group are over one dimension.
_SOUGHT: tuple[dict[str, tuple[str, str | int]], ...] = (
    {
        "angular_velocity": ("angular_velocity", "size"),
        "angular_acceleration": ("angular_acceleration", "size"),
        "centre_acceleration": ("centre_acceleration", "size"),
    },
    {"joint_force": ("joint_force", "size")},
    {"driving_torque": ("driving_torque", "value")},
    {"lumped_joint_force": ("lumped_joint_force", "size")},
    {"lumped_driving_torque": ("lumped_driving_torque", "value")},
    {"driving_power": ("driving_power", "value")},
    {"shaking_force": ("shaking_force", "size"), "shaking_moment": ("shaking_moment", "value")},
    {
        "position_x": ("point_position", 0),
        "position_y": ("point_position", 1),
        "velocity": ("point_velocity", "size"),
        "acceleration": ("point_acceleration", "size"),
    },
    {
        f"slider_{name}": (f"slider_{name}", "value")
        for name in ("position", "velocity", "acceleration")
    },
    {
        "transmission_angle": ("transmission_angle", "value"),
        "reversed_transmission_angle": ("reversed_transmission_angle", "value"),
    },
)


class Sought(NamedTuple):
    """A number at positions whose extremes are sought.

    Parameters
    ----------
    name, of : str
        What it is, and link, joint or point that it is of; empty of the whole linkage.
    unit : str
        SI unit.
    values : ndarray, shape (A,)
    """

    name: str
    of: str
    unit: str
    values: FloatArray


def sought(values: Values, mechanism: Mechanism) -> Iterator[Sought]:
    """Every number that has extremes, always in one order.

    Parameters
    ----------
    values : dict
        Of :func:`flexmech.analyses.kinematics.positions.values_of`.
    mechanism : Mechanism

    Yields
    ------
    Sought
    """
    topology = mechanism.linkage.topology
    names = {"link": topology.link_names, "joint": topology.joint_names, **values}
    for group in _SOUGHT:
        known = {name: each for name, each in group.items() if each[0] in values}
        if not known:
            continue
        dims = SCHEMA.variables[next(iter(known.values()))[0]].over
        for number, of in enumerate(names[dims[1]] if len(dims) > 1 and dims[1] in names else [""]):
            for name, (variable, counts) in known.items():
                own = values[variable][:, number] if of else values[variable]
                yield Sought(name, of, SCHEMA.variables[variable].unit, _counted(own, counts))


def _counted(values: Any, counts: str | int) -> FloatArray:
    if isinstance(counts, int):
        return np.asarray(values[:, counts])
    if counts == "value":
        return np.asarray(values)
    return np.asarray(np.linalg.norm(values, axis=-1) if values.ndim > 1 else abs(values))


def extreme_values(
    mechanism: Mechanism,
    at: Forces,
    crank_angles: FloatArray,
    point: tuple[float, float] | None = None,
    shaft_torque: float | Callable[[FloatArray], FloatArray] = 0.0,
    *,
    step: float | None = None,
) -> Values:
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
        Of the drive on the shaft itself, N m; or what gives it at the angles.
    step : float, optional
        Where the angles are times: in what steps extremes are sought, in s.

    Returns
    -------
    dict
        Of variables over ``extreme``, and of single numbers.
    """

    def found_at(angles: FloatArray) -> list[Sought]:
        torque = shaft_torque(angles) if callable(shaft_torque) else shaft_torque
        return list(sought(values_of(mechanism, *at(angles), point, torque), mechanism))

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
    values: Values = {
        "least": found.least,
        "least_angle": found.least_angle,
        "greatest": found.greatest,
        "greatest_angle": found.greatest_angle,
        "extreme_error": found.error,
        "extreme_quantity": [one.name for one in named],
        "extreme_of": [one.of for one in named],
        "extreme_unit": [one.unit for one in named],
    }
    if mean is not None:
        values["mean_driving_power"], values["mean_driving_power_error"] = mean
        linkage = mechanism.linkage
        if isinstance(linkage, FourBar) and linkage.grashof_class == "crank-rocker":
            values["rocker_swing"] = rocker_swing(linkage)
    return values
