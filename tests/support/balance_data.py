"""Balances of the aluminium four-bar, for pictures and pages."""

from __future__ import annotations

from functools import cache

import numpy as np
import xarray as xr

from flexmech import Balance, BalanceRequest, balance
from tests.support.strategies import fourbar

__all__ = ["balance_dataset", "balance_result"]

SPEED = 20.0


@cache
def balance_result() -> Balance:
    angles = np.radians(np.arange(0.0, 361.0, 5.0))
    request = BalanceRequest(SPEED, crank_angles=angles, elastic=False)
    found = balance(fourbar(), request)
    # Elastic links as smooth numbers of a real size, for a run takes seconds.
    turn = np.linspace(0.0, 2 * np.pi, 181)
    force = np.zeros((2, turn.size, 2))
    force[..., 0] = np.array([4.0, 1.0])[:, None] * np.cos(turn)
    force[..., 1] = np.array([2.0, 1.5])[:, None] * np.sin(3 * turn)
    dataset = found.dataset.assign(
        elastic_shaking_force=(("state", "elastic_angle", "component"), force),
        elastic_shaking_moment=(("state", "elastic_angle"), 0.2 * force[..., 0]),
        first_frequency=("state", [43.7, 20.1]),
    )
    return Balance(dataset.assign_coords(elastic_angle=turn))


def balance_dataset() -> xr.Dataset:
    return balance_result().dataset.copy(deep=True)
