"""Shaking force of a running four-bar, for pictures: smooth invented numbers of a real size."""

from __future__ import annotations

import numpy as np
import xarray as xr

from tests.support.plot_data import response_dataset

__all__ = ["running_shaking_dataset"]


def framed_dataset() -> xr.Dataset:
    """A response with a frame on springs that two engines know to a percent of each other."""
    data = response_dataset()
    time = data["time"].values
    moved = np.stack([2e-4 * np.sin(40.0 * time), 5e-5 * np.cos(70.0 * time)], axis=-1)
    both = np.stack([moved, 1.01 * moved])
    over = ("engine", "time", "component")
    return data.assign(
        frame_displacement=(over, both),
        frame_rotation=(over[:2], 3.0 * both[..., 0]),
        floor_force=(over, 4e4 * both),
    )


def running_shaking_dataset() -> xr.Dataset:
    data = response_dataset()
    angle, time = data["crank_angle"].values, data["time"].values
    rigid = np.stack([5.0 * np.cos(angle), 2.0 * np.sin(2 * angle)], axis=-1)
    ringing = 0.4 * np.sin(300.0 * time)[:, None]
    force = np.stack([rigid + ringing, rigid + 1.01 * ringing])
    orders = np.arange(11)
    size = 5.0 * 0.5**orders
    return data.assign(
        shaking_force=(("engine", "time", "component"), force),
        shaking_moment=(("engine", "time"), 0.2 * force[..., 0]),
        rigid_shaking_force=(("time", "component"), rigid),
        rigid_shaking_moment=("time", 0.2 * rigid[:, 0]),
        shaking_force_order=(("engine", "order"), np.stack([size, 1.02 * size])),
        shaking_moment_amplitude=(("engine", "order"), np.stack([0.2 * size, 0.2 * size])),
        rigid_shaking_force_order=("order", 0.9 * size),
        rigid_shaking_moment_amplitude=("order", 0.19 * size),
        moment_point=("component", [0.0, 0.0]),
    ).assign_coords(order=orders)
