"""What a stored response holds: histories whole, the moving linkage in frames of one turn."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.types import FloatArray, IntArray

# Where links are takes nine tenths of a run, and is drawn for the animation's last turn alone.
PLACES = ("displacement", "rigid_position")
# Whose balance is stored: none is drawn, and none is in a table.
ENERGIES = (
    "kinetic_energy",
    "strain_energy",
    "gravity_energy",
    "dissipated_energy",
    "drive_work",
    "prestress_work",
)
# Twice the pictures of an animation: its path has a point between two of them.
MOST_FRAMES = 240
# Round-off must not lose the sample a full turn before the last one.
_ROUND_OFF = 1e-9


def needed(dataset: xr.Dataset) -> xr.Dataset:
    """Leave out what neither pictures nor comparisons need.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a response.

    Returns
    -------
    xarray.Dataset
        ``displacement`` and ``rigid_position`` over ``frame_time``, which are samples of the last
        turn, instead of ``time``, and no energies but the error of their balance.
    """
    if "frame_time" in dataset.dims:
        return dataset
    frames = _frames(dataset["crank_angle"].values)
    places = dataset[[*PLACES]].isel(time=frames)
    places = places.rename(time="frame_time", crank_angle="frame_angle")
    whole = dataset.drop_vars([*PLACES, *ENERGIES])
    return whole.merge(places, combine_attrs="override")


def _frames(angle: FloatArray) -> IntArray:
    """Samples of the last turn, evenly spaced up to the last one."""
    shown = np.flatnonzero(np.abs(angle[-1] - angle) <= 2 * np.pi * (1 + _ROUND_OFF))
    intervals = len(shown) - 1
    least = max(1, -(-intervals // MOST_FRAMES))
    # If it can be, the first one is a whole number of frames before the last one.
    whole = [step for step in range(least, 2 * least) if intervals % step == 0]
    return np.asarray(shown[:: -(whole or [least])[0]][::-1])
