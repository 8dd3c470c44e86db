"""The result of a run: histories, checks and spectra."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.stored_result import StoredResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Response"]


class Response(StoredResult):
    """How the linkage answers its own running, by one engine or more.

    Parameters
    ----------
    dataset : xarray.Dataset
        Variables and units are in the dataset itself; see the README.
    """

    stem = "response"
    hallmark = "deflection"

    def peaks(self) -> xr.Dataset:
        """Greatest size of each link's deflection and strain, and of torque and joint forces.

        Returns
        -------
        xarray.Dataset
            ``deflection``, ``strain`` over (engine, link), ``driving_torque`` over (engine),
            ``joint_force`` over (engine, joint), and the crank angle of each peak deflection
            in rad as ``deflection_angle``.
        """
        data = self.dataset
        size = abs(data["deflection"])
        force = (data["joint_force"] ** 2).sum("component") ** 0.5
        return xr.Dataset(
            {
                "deflection": size.max("time"),
                "deflection_angle": data["crank_angle"][size.argmax("time")].drop_vars("time"),
                "strain": abs(data["strain"]).max("time"),
                "driving_torque": abs(data["driving_torque"]).max("time"),
                "joint_force": force.max("time"),
            }
        )

    def agreement(self) -> xr.DataArray | None:
        """Greatest difference of two engines' deflections over the peak of each link.

        Returns
        -------
        xarray.DataArray or None
            Over (link); None with a single engine.
        """
        deflection = self.dataset["deflection"]
        if deflection.sizes["engine"] < 2:
            return None
        first, second = (deflection.isel(engine=i, drop=True) for i in (0, 1))
        peak = abs(second).max("time")
        return (abs(first - second).max("time") / peak).where(peak > 0, 0.0)

    def table(self) -> pd.DataFrame:
        """One row for each engine and sample, as in the CSV file."""
        return pd.concat([self._engine_table(str(e)) for e in self.dataset["engine"].values])

    def _engine_table(self, engine: str) -> pd.DataFrame:
        data = self.dataset.sel(engine=engine)
        angle = np.round(np.degrees(data["crank_angle"].values), 9)
        columns = {"engine": engine, "time_s": data["time"].values, "crank_angle_deg": angle}
        # Pinned links first, then what the shaft holds.
        ordered = sorted(data["link"].values, key=lambda name: _place(data, name) == "tip")
        for link in ordered:
            where = {"middle": "mid", "tip": "tip"}[_place(data, link)]
            columns[f"{link}_{where}_deflection_m"] = data["deflection"].sel(link=link).values
        for link in ordered:
            if _place(data, link) == "middle":
                columns[f"{link}_mid_strain"] = data["strain"].sel(link=link).values
        columns["driving_torque_Nm"] = data["driving_torque"].values
        for joint in data["joint"].values:
            if joint in self.pins:
                for axis in ("x", "y"):
                    force = data["joint_force"].sel(joint=joint, component=axis)
                    columns[f"pin_{joint}_{axis}_N"] = force.values
        return pd.DataFrame(columns)

    @property
    def pins(self) -> list[str]:
        """Joints between links, as against those that the ground or the shaft holds."""
        joints = self.dataset["joint"]
        return [
            str(j)
            for j, kind in zip(joints.values, self.dataset["joint_kind"].values, strict=True)
            if kind == "pin"
        ]

    def plot(self) -> Figure:
        """Deflections against time; see :mod:`flexmech.plots` for others."""
        from flexmech.plots import plot_response

        return plot_response(self.dataset)


def _place(data: xr.Dataset, link: str) -> str:
    return str(data["probe"].sel(link=link).item())
