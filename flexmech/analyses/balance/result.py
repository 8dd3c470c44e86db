"""The result of a balance: its tables, picture, model file and words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.balance.words import summary_of
from flexmech.analyses.datasets import Columns, columns_along, table_of
from flexmech.analyses.result import Result
from flexmech.analyses.shaking import harmonics_table, shaking_columns
from flexmech.analyses.summary import Summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Balance(Result):
    """Counterweights of a linkage, and its shaking force, torque and joint forces with them.

    Parameters
    ----------
    dataset : xarray.Dataset
        Over ``counterweight``, named by its link: ``counterweight_mass``, ``counterweight_radius``,
        ``counterweight_angle``, ``counterweight_place`` (component) and ``counterweight_about``,
        the joint about which the link rotates. Over ``state`` ("as given", "balanced"):
        ``shaking_force`` (crank_angle, component) and ``shaking_moment`` (crank_angle) by the
        inertia of rigid links, with their harmonics over ``order``; ``driving_torque``
        (crank_angle), ``joint_force`` (crank_angle, joint, component), ``moving_mass``; of elastic
        links in periodic motion ``elastic_shaking_force`` (elastic_angle, component),
        ``elastic_shaking_moment`` (elastic_angle) and ``first_frequency``. The attribute
        ``balanced_model`` is the model file with the counterweights.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "balance"
    subject = "balance"
    hallmark = "counterweight_mass"
    files = (
        "balance.csv",
        "counterweights.csv",
        "balanced_harmonics.csv",
        "balance.nc",
        "balance.png",
        "balanced.toml",
    )

    def tables(self) -> dict[str, pd.DataFrame]:
        """Loads over the crank angle before and after; the counterweights; harmonics."""
        data = self.dataset
        size: xr.DataArray = xr.apply_ufunc(
            lambda parts: np.linalg.norm(parts, axis=-1),
            data["joint_force"],
            input_core_dims=[["component"]],
        )
        columns: Columns = {
            "state": "state",
            "crank_angle_deg": "crank_angle",
            **shaking_columns(data),
            "driving_torque_Nm": "driving_torque",
            **columns_along("joint_force_{}_N", size, "joint"),
        }
        places = columns_along("{}_m", data["counterweight_place"], "component")
        weights: Columns = {
            "link": "counterweight",
            "mass_kg": "counterweight_mass",
            "radius_m": "counterweight_radius",
            "angle_deg": "counterweight_angle",
            **places,
        }
        tables = {
            "balance": table_of(data, ("state", "crank_angle"), columns),
            "counterweights": table_of(data, ("counterweight",), weights),
        }
        if "order" in data:
            tables["balanced_harmonics"] = harmonics_table(data, "state")
        return tables

    def texts(self) -> dict[str, str]:
        """The balanced model file."""
        return {"balanced.toml": str(self.dataset.attrs["balanced_model"])}

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw shaking force, shaking moment and driving torque before and after.

        Parameters
        ----------
        ax : sequence of matplotlib.axes.Axes, optional
            Four of the user's.
        """
        return plots.plot_balance(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """The counterweights, the shaking force before and after, and what they cost."""
        return summary_of(self.dataset)
