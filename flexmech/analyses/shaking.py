"""Shaking force and moment in datasets: their variables, harmonics, tables and words."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.datasets import DEGREES, Columns, columns_along, table_of
from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.linkages import InverseDynamics, continuous_angles
from flexmech.linkages.frame_forces import ShakingForce, shaking_force
from flexmech.mechanism import Mechanism
from flexmech.validation import check_pair

MOST_ORDER = 10
"""Of harmonics: orders of the crank angle from zero to this one."""

Variables = dict[str, tuple[tuple[str, ...], Any]]
"""Dimensions and values of variables by their names."""

_ORDER, _COMPONENT = "order", "component"
_PARTS = ("shaking_force", "shaking_moment")
_NUMBERS = ("amplitude", "phase")
_MM = 1e3
# Of the greatest order: less is not told in a line, and stands in the table.
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


def shaking_of(
    mechanism: Mechanism,
    forces: InverseDynamics,
    point: tuple[float, float] | None = None,
    shaft_torque: float | FloatArray = 0.0,
) -> ShakingForce:
    """Shaking force and moment of a rigid linkage.

    Parameters
    ----------
    mechanism : Mechanism
        Whose springs to the ground count.
    forces : InverseDynamics
        Of the mechanism.
    point : tuple of float, optional
        About which the moment is taken, m; the shaft's axis if left out.
    shaft_torque : float or ndarray, shape (...)
        Of the drive on the shaft itself, which turns with an acceleration, N m.

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
        forces.driving_torque + shaft_torque,
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


def shaking_variables(found: ShakingForce, over: str, prefix: str = "") -> Variables:
    """Variables of a dataset.

    Parameters
    ----------
    found : ShakingForce
        In positions (A,).
    over : str
        Dimension of the positions.
    prefix : str
        Before the names.

    Returns
    -------
    dict
        ``shaking_force`` (over, component) and ``shaking_moment`` (over).
    """
    return {
        f"{prefix}shaking_force": ((over, _COMPONENT), found.force),
        f"{prefix}shaking_moment": ((over,), found.moment),
    }


def harmonic_variables(found: ShakingForce, crank_angle: FloatArray, prefix: str = "") -> Variables:
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
    variables: Variables = {_ORDER: ((_ORDER,), orders)}
    sizes = (found.force, (_ORDER, _COMPONENT)), (found.moment, (_ORDER,))
    for name, (values, dims) in zip(_PARTS, sizes, strict=True):
        parts = waves @ values
        # Less is what round-off leaves of an order that there is not.
        there = np.abs(parts) > ROUND_OFF * np.abs(values).max(initial=0.0)
        parts = np.where(there, parts, 0.0)
        variables[f"{prefix}{name}_amplitude"] = dims, np.abs(parts)
        variables[f"{prefix}{name}_phase"] = dims, np.angle(parts)
        if _COMPONENT in dims:
            # Half its long axis: what turns with the crank and what turns against it add up.
            x, y = parts.T
            size = (np.abs(x + 1j * y) + np.abs(x - 1j * y)) / 2
            variables[f"{prefix}{name}_order"] = (_ORDER,), size
    return variables


def shaking_columns(data: xr.Dataset, prefix: str = "") -> Columns:
    """Columns of a table over the dimensions of the shaking force.

    Parameters
    ----------
    data : xarray.Dataset
    prefix : str
        Before the names of the variables and the columns.

    Returns
    -------
    dict
        None where the dataset is of an earlier version, which had no shaking force.
    """
    if f"{prefix}shaking_force" not in data:
        return {}
    force = data[f"{prefix}shaking_force"]
    return {
        **columns_along(f"{prefix}shaking_force_{{}}_N", force, _COMPONENT),
        f"{prefix}shaking_moment_Nm": f"{prefix}shaking_moment",
    }


def harmonics_table(data: xr.Dataset, over: str = "") -> pd.DataFrame:
    """A row for each order, and for each place along a further dimension.

    Parameters
    ----------
    data : xarray.Dataset
        With the variables of :func:`harmonic_variables`.
    over : str
        That dimension; empty where there is none.

    Returns
    -------
    pandas.DataFrame
    """
    columns: Columns = {over: over} if over else {}
    columns[_ORDER] = _ORDER
    units = {"shaking_force": "N", "shaking_moment": "Nm"}
    for name, unit in units.items():
        for number in _NUMBERS:
            own, suffix = data[f"{name}_{number}"], unit
            if number == "phase":
                own, suffix = DEGREES * own, "deg"
            if _COMPONENT in own.dims:
                columns |= columns_along(f"{name}_{{}}_{number}_{suffix}", own, _COMPONENT)
            else:
                columns[f"{name}_{number}_{suffix}"] = own
        if name == "shaking_force":
            columns["shaking_force_greatest_N"] = "shaking_force_order"
    return table_of(data, ((over,) if over else ()) + (_ORDER,), columns)


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
        for n, order in enumerate(data[_ORDER].values)
        if force[n] > _SHOWN * force.max() or moment[n] > _SHOWN * moment.max()
    ]
    told = "; ".join(shown) or "none"
    return f"{what} force and moment by order of the crank angle, greatest sizes: {told}"
