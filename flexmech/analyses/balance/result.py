"""The result of a balance: its tables, picture, model file and words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from flexmech import plots
from flexmech.analyses.balance.words import summary_of
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Balance(Result):
    """Counterweights of a linkage, and its shaking force, torque and joint forces with them.

    Parameters
    ----------
    dataset : xarray.Dataset
        The variables of ``schema.toml``: counterweights over ``counterweight``, named by their
        links; loads before and after over ``state`` ("as given", "balanced"). The attribute
        ``balanced_model`` is the model file with the counterweights.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "balance"
    subject = "balance"
    hallmark = "counterweight_mass"
    files = ("balanced.toml",)

    def tabulated(self) -> xr.Dataset:
        """The dataset with sizes of joint forces."""
        force = self.dataset["joint_force"].transpose(..., "component")
        return self.dataset.assign(
            joint_force_size=(force.dims[:-1], np.linalg.norm(force.values, axis=-1))
        )

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
