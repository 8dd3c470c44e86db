"""The result of kinematics: its tables, pictures and words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.datasets import DEGREES, Columns, columns_along, table_of
from flexmech.analyses.remarks import crank_speed_text
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table
from flexmech.arrays import ROUND_OFF

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Angles that some linkages have, in words.
_TRANSMISSION = {
    "transmission_angle": "transmission angle",
    "reversed_transmission_angle": "transmission angle with the rocker driving",
}


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
        four-bars ``transmission_angle`` and ``reversed_transmission_angle``. With lumped masses
        the forces by these, with names that begin with ``lumped_``, and every mass with its
        acceleration and inertia force over ``lump``. The attributes ``crank_speed``, and where
        the crank accelerates ``crank_acceleration`` in rad/s^2 and ``shaft_inertia_torque`` in
        N m, which the shaft's own inertia takes besides the driving torque.
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
        "forces_lumped.csv",
        "drive_lumped.csv",
        "lumped_masses.csv",
        "kinematics.nc",
        "kinematics.png",
        "joint_forces.png",
        "drive.png",
    )

    def tables(self) -> dict[str, pd.DataFrame]:
        """Motion of links, joint forces, and what drives; by lumped masses too if asked for."""
        data = self.dataset
        tables = {
            "kinematics": _motion_table(data),
            "forces": _force_table(data),
            "drive": _drive_table(data),
        }
        if "lumped_joint_force" in data:
            tables["forces_lumped"] = _force_table(data, "lumped_")
            tables["drive_lumped"] = _drive_table(data, "lumped_")
            tables["lumped_masses"] = _lump_table(data)
        return tables

    def figures(self) -> dict[str, Figure]:
        """Motion of the links, joint forces, and torque and power of the drive."""
        return {
            "kinematics": self.plot(),
            "joint_forces": plots.plot_joint_forces(self.dataset),
            "drive": plots.plot_drive(self.dataset),
        }

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw angles, angular velocities and accelerations of the links.

        Parameters
        ----------
        ax : sequence of matplotlib.axes.Axes, optional
            Three of the user's.
        """
        return plots.plot_kinematics(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Greatest values and where they are."""
        data = self.dataset
        motion = Table(
            f"greatest values over the crank angles, {data.attrs['mechanism']} at "
            f"{crank_speed_text(data.attrs)}{_acceleration_text(data)}",
            ("link", "rad/s", "at deg", "rad/s²", "at deg", "centre m/s²", "at deg"),
            (tuple(_link_row(data.sel(link=link)) for link in data["link"].values),),
        )
        lumped = "lumped_joint_force" in data
        joints = Table(
            "greatest joint forces",
            ("joint", "kind", "of", "on", "N", "at deg", *(("lumped N", "at deg") * lumped)),
            (tuple(_joint_row(data.sel(joint=joint), lumped) for joint in data["joint"].values),),
            text_columns=4,
        )
        torque = float(_size(data["joint_force"]).max() * abs(data["centre_position"]).max())
        power = torque * abs(float(data.attrs["crank_speed"]))
        lines = [_extremes("driving torque", data["driving_torque"], "N m", torque)]
        if lumped:
            what = f"driving torque by {data.sizes['lump']} lumped masses"
            lines.append(_extremes(what, data["lumped_driving_torque"], "N m", torque))
        lines.append(_extremes("driving power", data["driving_power"], "W", power))
        if shaft := float(data.attrs.get("shaft_inertia_torque", 0.0)):
            lines.append(f"driving torque: the shaft's own inertia takes {shaft:.5g} N m besides")
        mean = _mean(data["driving_power"])
        if mean is not None and "crank_acceleration" not in data.attrs:
            lines.append(f"mean driving power over the turn: {_number(mean, power)} W")
        for angle, words in _TRANSMISSION.items():
            if angle in data:
                lines.append(_extremes(words, DEGREES * data[angle], "deg"))
        return Summary((motion, joints, *lines))


def _acceleration_text(data: xr.Dataset) -> str:
    """Acceleration of the crank in words; nothing where its speed is constant."""
    acceleration = data.attrs.get("crank_acceleration")
    return "" if acceleration is None else f" and {float(acceleration):.6g} rad/s²"


def _motion_table(data: xr.Dataset) -> pd.DataFrame:
    vectors = {
        "centre_{}_m": "centre_position",
        "centre_a{}_m_s2": "centre_acceleration",
        "inertia_force_{}_N": "inertia_force",
    }
    columns: Columns = {
        "crank_angle_deg": "crank_angle",
        "link": "link",
        "angle_deg": "angle",
        "angular_velocity_rad_s": "angular_velocity",
        "angular_acceleration_rad_s2": "angular_acceleration",
        **_components(data, vectors),
        "inertia_moment_Nm": "inertia_moment",
    }
    return table_of(data, ("crank_angle", "link"), columns)


def _force_table(data: xr.Dataset, of: str = "") -> pd.DataFrame:
    columns: Columns = {
        "crank_angle_deg": "crank_angle",
        "joint": "joint",
        "of": "force_by",
        "on": "force_on",
        **_components(data, {"{}_N": f"{of}joint_force"}),
        "moment_Nm": f"{of}joint_moment",
    }
    return table_of(data, ("crank_angle", "joint"), columns)


def _drive_table(data: xr.Dataset, of: str = "") -> pd.DataFrame:
    columns = {"torque_Nm": f"{of}driving_torque", "power_W": f"{of}driving_power"}
    if not of:
        columns |= {f"{angle}_deg": angle for angle in _TRANSMISSION if angle in data}
    return table_of(data, ("crank_angle",), {"crank_angle_deg": "crank_angle", **columns})


def _lump_table(data: xr.Dataset) -> pd.DataFrame:
    vectors = {"a{}_m_s2": "lump_acceleration", "inertia_force_{}_N": "lump_inertia_force"}
    columns: Columns = {
        "crank_angle_deg": "crank_angle",
        "link": "lump_link",
        "position_m": "lump_position",
        "mass_kg": "lump_mass",
        **_components(data, vectors),
    }
    return table_of(data, ("crank_angle", "lump"), columns)


def _components(data: xr.Dataset, vectors: dict[str, str]) -> dict[str, xr.DataArray]:
    """Columns of vectors in the plane, named by its axes."""
    parts = (columns_along(form, data[name], "component") for form, name in vectors.items())
    return {column: values for part in parts for column, values in part.items()}


def _link_row(link: xr.Dataset) -> tuple[str, ...]:
    sizes = [abs(link[name]) for name in ("angular_velocity", "angular_acceleration")]
    sizes.append(_size(link["centre_acceleration"]))
    return (link["link"].item(), *(text for size in sizes for text in _greatest(size)))


def _joint_row(joint: xr.Dataset, lumped: bool) -> tuple[str, ...]:
    names = ["joint_force", *(["lumped_joint_force"] if lumped else [])]
    texts = (text for name in names for text in _greatest(_size(joint[name])))
    said = ("joint", "joint_kind", "force_by", "force_on")
    return (*(joint[name].item() for name in said), *texts)


def _size(vector: xr.DataArray) -> xr.DataArray:
    """Length of a vector in the plane."""
    whole = vector.transpose(..., "component")
    return whole.isel(component=0, drop=True).copy(data=np.linalg.norm(whole.values, axis=-1))


def _greatest(size: xr.DataArray) -> tuple[str, str]:
    """Greatest value, and the first crank angle where it is but for round-off."""
    values = size.values
    place = int(np.argmax(values >= values.max() * (1 - ROUND_OFF)))
    return f"{values[place]:.5g}", f"{DEGREES * float(size['crank_angle'][place]):.6g}"


def _extremes(what: str, quantity: xr.DataArray, unit: str, scale: float = 0.0) -> str:
    """Least and greatest value, and where; below round-off of the scale it is zero."""
    values = quantity.values
    ends = (
        f"{_number(values[place], scale)} {unit} "
        f"(at {DEGREES * float(quantity['crank_angle'][place]):.6g} deg)"
        for place in (int(values.argmin()), int(values.argmax()))
    )
    return f"{what}: " + " to ".join(ends)


def _number(value: float, scale: float) -> str:
    return f"{0.0 if abs(value) <= ROUND_OFF * scale else value:.5g}"


def _mean(values: xr.DataArray) -> float | None:
    """Over a whole turn, by the trapezoidal rule; None where the angles are no whole turns."""
    angles = values["crank_angle"].values
    turns = (angles[-1] - angles[0]) / (2 * np.pi)
    if turns < 0.5 or abs(turns - round(turns)) > 1e-9:
        return None
    return float(np.trapezoid(values.values, angles) / (angles[-1] - angles[0]))
