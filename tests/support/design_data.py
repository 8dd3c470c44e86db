"""Datasets of studies of designs: they look like results, without an engine behind them."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

COUPLER, MATERIAL = "links.coupler.in_plane_thickness", "links.coupler.material"
LENGTH = {"units": "m", "shown_unit": "mm"}
LEAST = 45.0
"""Limit of the frequency in Hz."""
FAILED = 1
"""Number from 0 of the design that cannot be computed, where there is one."""
OUTPUTS: dict[str, dict[str, Any]] = {
    "f1": {"units": "Hz", "shown_unit": "Hz", "long_name": "lowest natural frequency"},
    "mass": {"units": "kg", "shown_unit": "kg", "long_name": "mass of the links"},
}


def sweep_designs(
    kind: str = "two numbers", *, limited: bool = True, failed: bool = False
) -> xr.Dataset:
    """Designs of a sweep: every combination of numbers and texts, or a sample.

    Parameters
    ----------
    kind : {"one number", "two numbers", "number and text", "sample"}
    """
    thick = np.linspace(2e-3, 5e-3, 4)
    coordinates: dict[str, Any]
    if kind == "one number":
        coordinates = {COUPLER: ("design", thick, LENGTH)}
    elif kind == "two numbers":
        first, second = np.meshgrid(thick, np.linspace(1e-3, 3e-3, 3), indexing="ij")
        coordinates = {
            COUPLER: ("design", first.ravel(), LENGTH),
            "thickness": ("design", second.ravel(), LENGTH),
        }
    elif kind == "number and text":
        coordinates = {
            COUPLER: ("design", np.repeat(thick, 2), LENGTH),
            MATERIAL: ("design", ["steel", "aluminium"] * 4),
        }
    else:
        random = np.random.default_rng(3)
        coordinates = {
            COUPLER: ("design", random.uniform(2e-3, 5e-3, 16), LENGTH),
            MATERIAL: ("design", ["[U@45/U@-45/U@0*2]s", "[U@0*4]s"] * 8),
        }
    return _with_outputs(coordinates, limited=limited, failed=failed)


def _with_outputs(coordinates: dict[str, Any], *, limited: bool, failed: bool) -> xr.Dataset:
    thick = coordinates[COUPLER][1]
    other = coordinates["thickness"][1] if "thickness" in coordinates else 2e-3
    stiff = 1.0
    if MATERIAL in coordinates:
        stiff = np.where(np.array(coordinates[MATERIAL][1]) == "steel", 1.2, 1.0)
    frequency, mass = 1.2e4 * thick * stiff + 2e3 * other, 20.0 * thick + 10.0 * other
    status, reason = np.full(thick.size, "ok", dtype="U20"), np.full(thick.size, "", dtype="U40")
    if failed:
        frequency[FAILED] = mass[FAILED] = np.nan
        status[FAILED], reason[FAILED] = "locked", "the links cannot turn"
    violation = np.maximum(LEAST - frequency, 0.0) / LEAST * limited
    attributes = {name: dict(each) for name, each in OUTPUTS.items()}
    if limited:
        attributes["f1"]["least"] = LEAST
    return xr.Dataset(
        {
            "f1": ("design", frequency, attributes["f1"]),
            "mass": ("design", mass, attributes["mass"]),
            "status": ("design", status),
            "reason": ("design", reason),
            "violation": ("design", violation),
            "within": ("design", (status == "ok") & (violation <= 0)),
            "relative_error": ("output", [1e-3, 0.0]),
        },
        {"design": np.arange(1, thick.size + 1), "output": list(OUTPUTS), **coordinates},
        {
            "title": "designs of aluminium four-bar",
            "mechanism": "aluminium four-bar",
            "engine": "reference",
            "outputs": " ".join(OUTPUTS),
            "variables": "\n".join(coordinates),
            "goals": "min mass",
        },
    )


def uncertainty_dataset(*, correlated: bool = False) -> xr.Dataset:
    """A sample with statistics, and shares of two inputs where they are not correlated."""
    data = sweep_designs("sample").drop_dims("output")
    outputs, statistics = list(OUTPUTS), dict[str, Any]()
    columns = np.stack([data[name].values for name in outputs])
    for name, part in {"p2_5": 2.5, "p50": 50.0, "p97_5": 97.5}.items():
        statistics[name] = ("output", np.percentile(columns, part, axis=1))
    statistics |= {
        "mean": ("output", columns.mean(axis=1)),
        "std": ("output", columns.std(axis=1)),
        "median_error": ("output", [0.5, 1e-3]),
        "failure_probability": ("output", [0.25, 0.0]),
    }
    data = data.assign(statistics).assign_coords(output=outputs)
    data = data.merge(frequency_bands())
    data.attrs["title"] = "uncertainty of aluminium four-bar"
    if correlated:
        return data.assign_attrs(no_shares="inputs are correlated")
    shares = np.array([[0.8, 0.1], [np.nan, np.nan]])
    for name, more in (("first_order", 0.0), ("total", 0.1)):
        for end, beside in (("", 0.0), ("_low", -0.05), ("_high", 0.07)):
            data[f"{name}{end}"] = ("output", "input"), shares + more + beside
    return data.assign_coords(input=[COUPLER, MATERIAL])


def frequency_bands() -> xr.Dataset:
    """Percentiles of two frequencies over the crank angle."""
    angle = np.linspace(0.0, 2 * np.pi, 13)
    median = np.stack([50 + 3 * np.sin(angle), 90 + 10 * np.cos(angle)])
    spread = np.array([-0.08, 0.0, 0.05])[:, None, None]
    attributes = {"units": "Hz", "designs": 64}
    over = ("percentile", "mode", "crank_angle")
    return xr.Dataset(
        {"frequency_percentile": (over, median * (1 + spread), attributes)},
        {"percentile": [2.5, 50.0, 97.5], "mode": [1, 2], "crank_angle": angle},
    )


def optimum_dataset(goals: int = 2) -> xr.Dataset:
    """Best designs, of several goals a front, of one goal one design."""
    data = sweep_designs("one number", limited=goals == 1)
    data = data.isel(design=slice(None, None, -1) if goals > 1 else slice(3, 4))
    named = ("min mass", "max f1")[:goals]
    history = np.array([[0.12, 0.1, 0.09], [60.0, 65.0, 66.0]])[:goals]
    checked = np.array([[45.02, 0.1], [45.01, 0.1]])
    return (
        data.assign(
            history=(("goal", "step"), history),
            checked=(("checking_engine", "output"), checked),
        )
        .assign_coords(
            evaluations=("step", [64, 100, 180]),
            goal=[goal.split()[1] for goal in named],
            checking_engine=["reference", "exudyn"],
        )
        .assign_attrs(
            goals="\n".join(named), optimum="name = 'best'", title="optimum of aluminium four-bar"
        )
    )
