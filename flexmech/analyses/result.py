"""The result of a frequency map: a frozen object around a labelled dataset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.stored_result import StoredResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["EngineAgreement", "MovingFrequencies"]


@dataclass(frozen=True)
class EngineAgreement:
    """Greatest relative difference of two engines' frequencies, and where it is.

    Parameters
    ----------
    engines : tuple of str
    relative_difference : float
        ``|f_b / f_a - 1|``.
    crank_speed, crank_angle : float
        rad/s and rad.
    mode : int
        Counted from 1.
    """

    engines: tuple[str, str]
    relative_difference: float
    crank_speed: float
    crank_angle: float
    mode: int


@dataclass(frozen=True)
class MovingFrequencies(StoredResult):
    """Natural frequencies over crank angle and speed, tracked, with their errors.

    Parameters
    ----------
    dataset : xarray.Dataset
        Variables and units are in the dataset itself; see the README.
    """

    stem = "frequencies"
    hallmark = "frequency"

    def extremes(self) -> xr.Dataset:
        """Lowest and highest frequency of each mode and the crank angles where they are.

        Returns
        -------
        xarray.Dataset
            ``lowest``, ``highest`` in Hz and ``lowest_angle``, ``highest_angle`` in rad over
            (engine, crank_speed, mode).
        """
        frequency = self.dataset["frequency"]
        angles = self.dataset["crank_angle"].values
        if len(angles) > 1 and np.isclose(angles[-1] - angles[0], 2 * np.pi):
            frequency = frequency.isel(crank_angle=slice(None, -1))  # the first one again
        return xr.Dataset(
            {
                "lowest": frequency.min("crank_angle"),
                "lowest_angle": frequency.idxmin("crank_angle"),
                "highest": frequency.max("crank_angle"),
                "highest_angle": frequency.idxmax("crank_angle"),
            }
        )

    def agreement(self) -> EngineAgreement | None:
        """How far the first two engines differ at most; None with a single engine."""
        names = [str(name) for name in self.dataset["engine"].values]
        if len(names) < 2:
            return None
        first, second = (self.dataset["frequency"].isel(engine=i).values for i in (0, 1))
        difference = np.abs(second / first - 1)
        speed, angle, mode = np.unravel_index(int(difference.argmax()), difference.shape)
        return EngineAgreement(
            engines=(names[0], names[1]),
            relative_difference=float(difference.max()),
            crank_speed=float(self.dataset["crank_speed"][speed]),
            crank_angle=float(self.dataset["crank_angle"][angle]),
            mode=int(self.dataset["mode"][mode]),
        )

    def table(self) -> pd.DataFrame:
        """One row for each engine, crank speed, crank angle and mode, as in the CSV file."""
        data = self.dataset[["frequency", "damping_ratio", "branch_of_mode"]]
        frame = data.drop_vars("element").to_dataframe(
            dim_order=["engine", "crank_speed", "crank_angle", "mode"]
        )
        frame = frame.reset_index()
        frame["crank_angle"] = np.round(np.degrees(frame["crank_angle"]), 9)
        columns = {
            "engine": "engine",
            "crank_speed": "crank_speed_rad_s",
            "crank_angle": "crank_angle_deg",
            "mode": "mode",
            "branch_of_mode": "branch",
            "frequency": "frequency_Hz",
            "damping_ratio": "damping_ratio",
        }
        return frame[list(columns)].rename(columns=columns)

    def vibration_effect(self) -> xr.DataArray | None:
        """How much vibration itself moves the frequencies, relative to the quasi-static ones.

        Returns
        -------
        xarray.DataArray or None
            Over (engine, crank_speed, crank_angle, mode); None unless the frequencies are
            those of running states (prestress ``trajectory``).
        """
        if "quasi_static_frequency" not in self.dataset:
            return None
        return self.dataset["frequency"] / self.dataset["quasi_static_frequency"] - 1

    def further_tables(self) -> dict[str, pd.DataFrame]:
        """Tables of what the dataset holds besides.

        ``vibration_effect`` has running and quasi-static frequencies side by side,
        ``damping`` the damping ratio by modal strain energy.
        """
        dims = ("engine", "crank_speed", "crank_angle", "mode")
        tables = {}
        effect = self.vibration_effect()
        if effect is not None:
            beside = self.table().drop(columns=["branch", "damping_ratio"])
            still = self.dataset["quasi_static_frequency"].transpose(*dims)
            beside["quasi_static_frequency_Hz"] = still.values.ravel()
            beside["relative_change"] = effect.transpose(*dims).values.ravel()
            tables["vibration_effect"] = beside
        if "strain_energy_damping" in self.dataset:
            damping = self.table().drop(columns=["branch", "frequency_Hz"])
            ratio = self.dataset["strain_energy_damping"].transpose(*dims)
            damping["damping_ratio"] = ratio.values.ravel()
            tables["damping"] = damping
        return tables

    def plot(self) -> Figure:
        """Natural frequencies against crank angle; see :mod:`flexmech.plots` for others."""
        from flexmech.plots import plot_frequencies

        return plot_frequencies(self.dataset)
