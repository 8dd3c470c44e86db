"""The mode of a shaft that turns freely: rigid at rest, and not counted among the modes."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.datasets import DEGREES, table_over
from flexmech.analyses.frequencies.eigenproblem import Modes
from flexmech.arrays import FloatArray

RIGID = 1e-3
"""Frequency in Hz below which the shaft's mode is a rigid one."""


def shaft_readings(modes: Modes) -> dict[str, FloatArray]:
    """Natural frequency and growth rate of the shaft's mode in B positions.

    Parameters
    ----------
    modes : Modes
        Of systems with a rigid mode.

    Returns
    -------
    dict of str to ndarray, shape (B,)
        ``shaft_frequency`` in Hz, zero where it does not oscillate; ``shaft_growth_rate`` in 1/s.
    """
    frequency = np.abs(modes.rigid.imag).max(axis=1) / (2 * np.pi)
    return {"shaft_frequency": frequency, "shaft_growth_rate": modes.rigid.real.max(axis=1)}


def shaft_table(dataset: xr.Dataset) -> pd.DataFrame:
    """The shaft's mode, one row for each engine, crank speed and crank angle.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a map whose shaft is free.

    Returns
    -------
    pandas.DataFrame
        ``kind`` is ``rigid`` below :data:`RIGID`, else ``oscillates`` or ``diverges``.
    """
    frequency, growth = dataset["shaft_frequency"], dataset["shaft_growth_rate"]
    return table_over(
        "engine",
        "crank_speed",
        "crank_angle",
        engine=frequency["engine"],
        crank_speed_rad_s=frequency["crank_speed"],
        crank_angle_deg=(DEGREES * frequency["crank_angle"]).round(9),
        kind=_kind(dataset),
        frequency_Hz=frequency,
        growth_rate_1_s=growth,
    )


def shaft_lines(dataset: xr.Dataset) -> list[str]:
    """Say what became of the free shaft's mode, where the shaft is free."""
    if "shaft_frequency" not in dataset:
        return []
    kinds = _kind(dataset)
    lines = []
    if bool((kinds == "rigid").all()):
        return [
            f"rigid: the mode of the free shaft, below {RIGID:g} Hz in all positions; it is not "
            "counted among the modes"
        ]
    at_rest = (dataset["crank_speed"] == 0).values
    if at_rest.any() and bool((kinds.isel(crank_speed=at_rest) == "rigid").all()):
        lines.append(
            f"rigid: the mode of the free shaft, below {RIGID:g} Hz at rest; it is not counted "
            "among the modes"
        )
    moving = kinds.isel(crank_speed=~at_rest) if at_rest.any() else kinds
    counts = {kind: int((moving == kind).sum()) for kind in ("rigid", "oscillates", "diverges")}
    said = ", ".join(f"{kind} at {count}" for kind, count in counts.items() if count)
    highest = float(dataset["shaft_frequency"].max())
    growth = float(dataset["shaft_growth_rate"].max())
    lines.append(
        f"shaft: its mode, frozen at the crank angle, {said} of {moving.size} positions"
        f"{' at speed' if at_rest.any() else ''}; frequency at most {highest:.4g} Hz, growth rate "
        f"at most {growth:.4g} 1/s; it is not counted among the modes"
    )
    return lines


def _kind(dataset: xr.Dataset) -> xr.DataArray:
    """Of the shaft's mode in each position: rigid, oscillates or diverges."""
    frequency, growth = dataset["shaft_frequency"], dataset["shaft_growth_rate"]
    kind = np.where(frequency.values > 0, "oscillates", "diverges")
    fastest = np.maximum(frequency.values, np.abs(growth.values) / (2 * np.pi))
    return frequency.copy(data=np.where(fastest < RIGID, "rigid", kind))
