"""A hand-made hammer test on a running linkage, without a linkage behind its numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from flexmech.arrays import ComplexArray

FREQUENCY = np.linspace(0.0, 90.0, 451)
ORDERS = (-1, 0, 1)
PEAKS = {-1: 0.002, 0: 0.0056, 1: 0.014}
IDENTIFIED = 1.02
"""Identified over predicted amplitude."""
FROZEN = 0.5
OVER_BOTH = ("order", "frequency")


def resonance() -> ComplexArray:
    """Of every order: a mode at 45 Hz, whose greatest amplitude is that of its order."""
    own = 1 / (45.0**2 - FREQUENCY**2 + 2j * 0.005 * 45.0 * FREQUENCY)
    size = np.array([PEAKS[order] for order in ORDERS]) / np.abs(own).max()
    return size[:, None] * own


def running_hammer_dataset(orders: tuple[int, ...] = ORDERS, **attrs: Any) -> xr.Dataset:
    """Of these orders, all among -1, 0 and 1."""
    predicted = resonance()
    values: dict[str, Any] = {}
    for name, part in (("receptance", IDENTIFIED), ("predicted", 1.0), ("frozen", FROZEN)):
        values[f"{name}_real"] = (OVER_BOTH, part * predicted.real)
        values[f"{name}_imag"] = (OVER_BOTH, part * predicted.imag)
    peaks = np.abs(predicted).max(axis=1)
    at = FREQUENCY[np.abs(predicted).argmax(axis=1)]
    for name, value in (
        ("predicted_peak", peaks),
        ("predicted_peak_frequency", at),
        ("identified_peak", IDENTIFIED * peaks),
        ("identified_peak_frequency", at),
        ("bins_apart", np.zeros(3, dtype=int)),
        ("step_error", np.full(3, 1e-8)),
        ("balance_error", np.full(3, 1e-9)),
        ("reduction_error", np.full(3, 1e-3)),
        ("halving_change", np.full(3, 8e-5)),
    ):
        values[name] = ("order", value)
    values["impact_angle"] = ("impact", 2 * np.pi * (np.arange(9) + 0.5) / 9)
    values["decay"] = ("impact", np.full(9, 8e-5))
    dataset = xr.Dataset(
        values,
        coords={"order": list(ORDERS), "frequency": FREQUENCY, "impact": np.arange(1, 10)},
    )
    about: dict[str, Any] = {
        "mechanism": "aluminium four-bar",
        "engine": "exudyn",
        "element": "ancf",
        "elements": 8,
        "crank_speed": 20.0,
        "speed_unit": "rad/s",
        "impact_point": "coupler:0.5",
        "response_point": "rocker:0.5",
        "direction": "transverse",
        "prestress": "equilibrium",
        "averages": 1,
        "noise": 0.0,
        "seed": 0,
        "bandwidth": 90.0,
        "pulse": 0.0111,
        "peak_force": 0.003,
        "peak_response": 1.2e-6,
        "turns": 23,
        "turn_time": np.pi / 10,
        "step": 2.8e-4,
        "step_lag": 2e-6,
        "highest_fitted_order": 4,
        "condition": 1.3,
        "misfit": 0.01,
        "twin_defect": 5e-4,
        "moving_modes": 5,
        "propagator_steps": 1280,
        "decay_rate": 1.41,
        "theory_lines": "",
    }
    return dataset.sel(order=list(orders)).assign_attrs(about | attrs)
