"""The result of kinematics: its tables, pictures and words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.datasets import Columns, columns_along, table_of
from flexmech.analyses.kinematics.words import TRANSMISSION, summary_of
from flexmech.analyses.motor import motor_columns
from flexmech.analyses.result import Result
from flexmech.analyses.shaking import harmonics_table, shaking_columns
from flexmech.analyses.summary import Summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Kinematics(Result):
    """Motion of the rigid linkage over the crank angle, and the forces that it takes.

    Parameters
    ----------
    dataset : xarray.Dataset
        Over (crank_angle, link): ``angle`` without jumps, ``angular_velocity``,
        ``angular_acceleration``, and of the centres of mass ``centre_position``,
        ``centre_acceleration``, ``inertia_force`` (all with component) and ``inertia_moment``.
        Over (crank_angle, joint): ``joint_force`` (component) and ``joint_moment`` on the held
        or following link. Over crank_angle: ``driving_torque``, ``driving_power``, and of
        four-bars ``transmission_angle`` and ``reversed_transmission_angle``; ``shaking_force``
        (component) and ``shaking_moment`` of all that the mechanism exerts on its frame, about
        ``moment_point`` (component), and over whole turns their amplitudes and phases over
        ``order``, as ``shaking_force_amplitude``. With lumped masses
        the forces by these, with names that begin with ``lumped_``, and every mass with its
        acceleration and inertia force over ``lump``. ``point_position``, ``point_velocity`` and
        ``point_acceleration`` (crank_angle, point, component) of what moves, and
        ``slider_position``, ``slider_velocity`` and ``slider_acceleration`` (crank_angle, slider)
        along its line. Over ``extreme``: ``least`` and ``greatest`` value of what
        ``extreme_quantity`` and ``extreme_of`` name, in ``extreme_unit``, with their crank angles
        and ``extreme_error``, found between the angles too; under a law of motion all is over
        ``time``, with ``crank_speed_over_time``, ``crank_acceleration``, and ``least_time`` and
        ``greatest_time`` of extremes; and under a motor ``motor_torque``, ``motor_speed`` and
        ``motor_power`` on its own shaft, ``motor_current``, and a turn of the settled motion over
        ``settled_angle``; ``mean_driving_power`` over whole
        turns with its error, and ``rocker_swing`` of a crank-rocker. The attributes
        ``crank_speed``, and where the crank accelerates ``crank_acceleration`` in rad/s^2 and
        ``shaft_inertia_torque`` in N m, which the shaft's own inertia takes besides the driving
        torque.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "kinematics"
    subject = "kinematics and joint forces"
    hallmark = "angular_acceleration"
    files = (
        "kinematics.csv",
        "forces.csv",
        "drive.csv",
        "shaking_force.csv",
        "shaking_harmonics.csv",
        "motion.csv",
        "forces_lumped.csv",
        "drive_lumped.csv",
        "lumped_masses.csv",
        "kinematics.nc",
        "kinematics.png",
        "motion.png",
        "joint_forces.png",
        "shaking_force.png",
        "shaking_orders.png",
        "drive.png",
        "law.png",
        "motor.png",
    )

    def tables(self) -> dict[str, pd.DataFrame]:
        """Motion of links and points, joint forces, drive, shaking force; by lumped masses too."""
        data = self.dataset
        tables = {
            "kinematics": _motion_table(data),
            "forces": _force_table(data),
            "drive": _drive_table(data),
        }
        if shaking := shaking_columns(data):
            over, first = _over(data)
            tables["shaking_force"] = table_of(data, (over,), {**first, **shaking})
        if "order" in data:
            tables["shaking_harmonics"] = harmonics_table(data)
        if "point" in data:
            tables["motion"] = _point_table(data)
        if "lumped_joint_force" in data:
            tables["forces_lumped"] = _force_table(data, "lumped_")
            tables["drive_lumped"] = _drive_table(data, "lumped_")
            tables["lumped_masses"] = _lump_table(data)
        return tables

    def figures(self) -> dict[str, Figure]:
        """Motion of links and points, joint forces, drive, and what shakes the frame."""
        figures = {"kinematics": self.plot()}
        if plots.drawn_points(self.dataset):
            figures["motion"] = plots.plot_motion(self.dataset)
        figures["joint_forces"] = plots.plot_joint_forces(self.dataset)
        figures["drive"] = plots.plot_drive(self.dataset)
        if "crank_acceleration" in self.dataset:
            figures["law"] = plots.plot_law(self.dataset)
        if "motor_torque" in self.dataset:
            figures["motor"] = plots.plot_motor(self.dataset)
        if "shaking_force" in self.dataset:
            figures["shaking_force"] = plots.plot_shaking_force(self.dataset)
        if "order" in self.dataset:
            figures["shaking_orders"] = plots.plot_shaking_orders(self.dataset)
        return figures

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw angles, angular velocities and accelerations of the links.

        Parameters
        ----------
        ax : sequence of matplotlib.axes.Axes, optional
            Three of the user's.
        """
        return plots.plot_kinematics(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Strokes, greatest forces and torque; what each place does and carries; all extremes."""
        return summary_of(self.dataset)


def _over(data: xr.Dataset) -> tuple[str, Columns]:
    """What a dataset is over, and the first columns of its tables."""
    if "time" in data.dims:
        return "time", {"time_s": "time", "crank_angle_deg": "crank_angle"}
    return "crank_angle", {"crank_angle_deg": "crank_angle"}


def _motion_table(data: xr.Dataset) -> pd.DataFrame:
    vectors = {
        "centre_{}_m": "centre_position",
        "centre_a{}_m_s2": "centre_acceleration",
        "inertia_force_{}_N": "inertia_force",
    }
    columns: Columns = {
        **_over(data)[1],
        "link": "link",
        "angle_deg": "angle",
        "angular_velocity_rad_s": "angular_velocity",
        "angular_acceleration_rad_s2": "angular_acceleration",
        **_components(data, vectors),
        "inertia_moment_Nm": "inertia_moment",
    }
    return table_of(data, (_over(data)[0], "link"), columns)


def _force_table(data: xr.Dataset, of: str = "") -> pd.DataFrame:
    columns: Columns = {
        **_over(data)[1],
        "joint": "joint",
        "of": "force_by",
        "on": "force_on",
        **_components(data, {"{}_N": f"{of}joint_force"}),
        "moment_Nm": f"{of}joint_moment",
    }
    return table_of(data, (_over(data)[0], "joint"), columns)


def _drive_table(data: xr.Dataset, of: str = "") -> pd.DataFrame:
    columns: Columns = {"torque_Nm": f"{of}driving_torque", "power_W": f"{of}driving_power"}
    if "time" in data.dims and not of:
        law = {"speed_rad_s": "crank_speed_over_time", "acceleration_rad_s2": "crank_acceleration"}
        columns = {**{f"crank_{name}": values for name, values in law.items()}, **columns}
        if "shaft_inertia_torque" in data:
            columns["shaft_inertia_torque_Nm"] = "shaft_inertia_torque"
        columns |= motor_columns(data)
    if not of:
        columns |= {f"{angle}_deg": angle for angle in TRANSMISSION if angle in data}
    return table_of(data, (_over(data)[0],), {**_over(data)[1], **columns})


def _point_table(data: xr.Dataset) -> pd.DataFrame:
    """Points along the ground's axes, and sliders along their lines too."""
    kinds = {"": ("position", "m"), "v": ("velocity", "m_s"), "a": ("acceleration", "m_s2")}
    vectors = {f"{short}{{}}_{unit}": f"point_{name}" for short, (name, unit) in kinds.items()}
    columns: Columns = {
        **_over(data)[1],
        "point": "point",
        **_components(data, vectors),
    }
    if "slider" in data:
        for short, (name, unit) in kinds.items():
            of_line = data[f"slider_{name}"].rename(slider="point")
            columns[f"{short or 's'}_along_{unit}"] = of_line.reindex(point=data["point"].values)
    if "crank_acceleration" in data.attrs:
        acceleration = float(data.attrs["crank_acceleration"])
        columns["crank_acceleration_rad_s2"] = xr.DataArray(acceleration)
    return table_of(data, (_over(data)[0], "point"), columns)


def _lump_table(data: xr.Dataset) -> pd.DataFrame:
    vectors = {"a{}_m_s2": "lump_acceleration", "inertia_force_{}_N": "lump_inertia_force"}
    columns: Columns = {
        **_over(data)[1],
        "link": "lump_link",
        "position_m": "lump_position",
        "mass_kg": "lump_mass",
        **_components(data, vectors),
    }
    return table_of(data, (_over(data)[0], "lump"), columns)


def _components(data: xr.Dataset, vectors: dict[str, str]) -> dict[str, xr.DataArray]:
    """Columns of vectors in the plane, named by its axes."""
    parts = (columns_along(form, data[name], "component") for form, name in vectors.items())
    return {column: values for part in parts for column, values in part.items()}
