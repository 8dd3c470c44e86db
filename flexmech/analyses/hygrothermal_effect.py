"""Natural frequencies in heat and water beside those of the dry linkage."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.result import MovingFrequencies
from flexmech.analyses.stored_result import StoredResult
from flexmech.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["HygrothermalEffect", "hygrothermal_effect"]


@dataclass(frozen=True)
class HygrothermalEffect(StoredResult):
    """Frequencies of one linkage in two states, mode by mode in ascending order.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``frequency`` in the state and ``dry_frequency`` in Hz over (engine, crank_speed,
        crank_angle, mode).
    """

    stem = "hygrothermal_effect"
    hallmark = "dry_frequency"

    @property
    def relative_change(self) -> xr.DataArray:
        """Frequency in the state over the dry one, less one."""
        return self.dataset["frequency"] / self.dataset["dry_frequency"] - 1

    def table(self) -> pd.DataFrame:
        """One row for each engine, crank speed, crank angle and mode."""
        dims = ("engine", "crank_speed", "crank_angle", "mode")
        every = self.dataset.assign(relative_change=self.relative_change)
        frame = every.to_dataframe(dim_order=dims).reset_index()
        frame["crank_angle"] = np.round(np.degrees(frame["crank_angle"]), 9)
        columns = {
            "engine": "engine",
            "crank_speed": "crank_speed_rad_s",
            "crank_angle": "crank_angle_deg",
            "mode": "mode",
            "dry_frequency": "dry_frequency_Hz",
            "frequency": "frequency_Hz",
            "relative_change": "relative_change",
        }
        return frame[list(columns)].rename(columns=columns)

    def plot(self) -> Figure:
        """Frequencies of both states against crank angle."""
        from flexmech.plots import plot_hygrothermal_effect

        return plot_hygrothermal_effect(self.dataset)


def hygrothermal_effect(
    dry: MovingFrequencies, wet: MovingFrequencies, state: str
) -> HygrothermalEffect:
    """Put the frequencies of two states side by side.

    Modes are paired by their order. Where two come near to each other and swap their shapes
    (veering), a pair is not the same shape.

    Parameters
    ----------
    dry, wet : MovingFrequencies
        Over the same engines, crank angles, crank speeds and modes.
    state : str
        Name of the second state, for titles.

    Returns
    -------
    HygrothermalEffect

    Raises
    ------
    InputError
        If the two are not over the same positions.
    """
    first, second = dry.dataset["frequency"], wet.dataset["frequency"]
    try:
        first, second = xr.align(first, second, join="exact")
    except ValueError as error:
        raise InputError(
            "frequencies of two states can only be compared over the same engines, crank angles, "
            f"crank speeds and modes ({error})"
        ) from error
    plain = {"frequency": second, "dry_frequency": first}
    dataset = xr.Dataset(
        {
            name: values.reset_coords(drop=True).assign_attrs(
                units="Hz", long_name=name.replace("_", " ")
            )
            for name, values in plain.items()
        },
        attrs={**wet.dataset.attrs, "state": state},
    )
    return HygrothermalEffect(dataset)
