"""From arrays of a frequency map to one labelled dataset."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.frequencies.modal_damping import links_without_loss
from flexmech.analyses.frequencies.request import FrequencyRequest
from flexmech.analyses.frequencies.tracking import Branches
from flexmech.analyses.provenance import provenance, with_units
from flexmech.analyses.stations import rigid_positions
from flexmech.linear_system import Engine
from flexmech.types import FloatArray, IntArray

__all__ = ["EngineMap", "SpeedMap", "build_dataset", "with_states"]


MAP_DIMS = ("engine", "crank_speed", "crank_angle", "mode")
UNITS = {
    "frequency": ("Hz", "natural frequency"),
    "damping_ratio": ("1", "damping ratio"),
    "strain_energy_damping": ("1", "damping ratio by modal strain energy"),
    "branch_of_mode": ("1", "tracked branch of the mode"),
    "mac": ("1", "modal assurance criterion with the same branch at the previous crank angle"),
    "veering": ("1", "branch veers against another here"),
    "branch_whole": ("1", "branch is tracked without a break and back to itself"),
    "discretisation_error": ("1", "estimated relative error of the frequency by the mesh"),
    "reduction_error": ("1", "relative error of the frequency by component modes"),
    "mode_shape": ("1", "displacement of the mode in ground axes, largest 1"),
    "rigid_position": ("m", "position of the undeformed links"),
    "quasi_static_frequency": ("Hz", "natural frequency at the quasi-static equilibrium"),
    "speed_effect": ("Hz", "change of the frequency that the term adds"),
    "crank_speed": ("rad/s", "crank speed"),
    "crank_angle": ("rad", "crank angle"),
    "check_angle": ("rad", "crank angle of the error estimates and mode shapes"),
    "station": ("1", "place along the link over its length"),
}


@dataclass(frozen=True)
class SpeedMap:
    """Map of one engine at one crank speed: A angles, m tracked modes, C check angles.

    Parameters
    ----------
    frequency, damping_ratio : ndarray, shape (A, m)
    branches : Branches
    mode_shape : ndarray, shape (C, modes, n_links, n_stations, 2)
    reduction_error, discretisation_error : ndarray, shape (C, modes)
    strain_energy_damping : ndarray, shape (A, m), or None
        Damping ratio by modal strain energy; None where no section tells a loss.
    """

    frequency: FloatArray
    damping_ratio: FloatArray
    branches: Branches
    mode_shape: NDArray[Any]
    reduction_error: FloatArray
    discretisation_error: FloatArray
    strain_energy_damping: FloatArray | None = None


@dataclass(frozen=True)
class EngineMap:
    """Map of one engine: one part for each speed.

    Parameters
    ----------
    engine : Engine
        As it was used at last: with component modes or without.
    detail : float
        How many component modes the most demanding speed has needed.
    check_angles : ndarray of int
        Indices of the check angles.
    speeds : list of SpeedMap
    """

    engine: Engine
    detail: float
    check_angles: IntArray
    speeds: list[SpeedMap]


def build_dataset(
    engines: Sequence[Engine],
    request: FrequencyRequest,
    maps: Sequence[EngineMap],
    speed_effect: dict[str, FloatArray] | None,
    quasi_static: FloatArray | None = None,
) -> xr.Dataset:
    """Label the results of all engines.

    Parameters
    ----------
    engines : sequence of Engine
    request : FrequencyRequest
    maps : sequence of EngineMap
        One for each engine.
    speed_effect : dict of str to ndarray, shape (S, A, modes), or None
    quasi_static : ndarray, shape (E, S, A, modes), or None
        Frequencies at the quasi-static equilibrium, where others were asked for.

    Returns
    -------
    xarray.Dataset
    """
    modes = request.formulation.modes
    tracked = min(part.frequency.shape[1] for each in maps for part in each.speeds)
    where = maps[0].check_angles
    variables = {
        name: (("engine", "crank_speed", *dims), values)
        for name, dims, values in _stacked(maps, modes, tracked)
    }
    motion = engines[0].mechanism.linkage.motion(request.crank_angles[where])
    positions = rigid_positions(engines[0], motion)
    variables["rigid_position"] = (("check_angle", "link", "station", "component"), positions)
    if speed_effect:
        dims = ("term", *MAP_DIMS[1:])
        variables["speed_effect"] = (dims, np.stack(list(speed_effect.values())))
    if quasi_static is not None:
        variables["quasi_static_frequency"] = (MAP_DIMS, quasi_static)
    dataset = xr.Dataset(
        variables,
        coords={
            "engine": [e.name for e in engines],
            "element": ("engine", [e.element for e in engines]),
            "crank_speed": request.crank_speeds,
            "crank_angle": request.crank_angles,
            "mode": np.arange(1, modes + 1),
            "branch": np.arange(1, tracked + 1),
            "check_angle": request.crank_angles[where],
            "part": ["real", "imaginary"],
            "link": list(engines[0].mechanism.linkage.topology.link_names),
            "station": np.linspace(0.0, 1.0, positions.shape[2]),
            "component": ["x", "y"],
            **({"term": list(speed_effect)} if speed_effect else {}),
        },
        attrs={
            **provenance(engines),
            "prestress": request.formulation.prestress,
            "rotation_terms": "on" if request.formulation.rotation_terms else "off",
            "speed_unit": request.speed_unit,
        },
    )
    if "strain_energy_damping" in dataset:
        unknown = ", ".join(links_without_loss(engines[0].mechanism))
        dataset["strain_energy_damping"].attrs["links_without_data"] = unknown
    return with_units(dataset, UNITS)


def with_states(states: dict[str, xr.Dataset], environment_lines: Sequence[str]) -> xr.Dataset:
    """Join the datasets of a mechanism dry and in an environment.

    Parameters
    ----------
    states : dict of str to xarray.Dataset
        By what a state is called, the dry one first.
    environment_lines : sequence of str
        What the environment does to each link.

    Returns
    -------
    xarray.Dataset
        Over ``state`` besides. What there is of one state alone is not a number in the other.
    """
    parts = list(states.values())
    for part in parts:
        for name in set(parts[0].data_vars) - set(part.data_vars):
            part[name] = xr.full_like(parts[0][name], np.nan)
    joined = xr.concat(
        parts,
        pd.Index(list(states), name="state"),
        coords="minimal",
        compat="override",
        join="inner",
        combine_attrs="override",
    )
    return joined.assign_attrs(environment_lines="\n".join(environment_lines))


def _stacked(
    maps: Sequence[EngineMap], modes: int, tracked: int
) -> Iterator[tuple[str, tuple[str, ...], NDArray[Any]]]:
    """Name, dimensions and values over (engine, crank_speed, ...) of what each speed has."""
    parts = [[_variables(part, modes, tracked) for part in each.speeds] for each in maps]
    for name, (dims, _) in parts[0][0].items():
        if all(name in part for each in parts for part in each):
            values = np.stack([np.stack([part[name][1] for part in each]) for each in parts])
            yield name, dims, values


def _variables(
    part: SpeedMap, modes: int, tracked: int
) -> dict[str, tuple[tuple[str, ...], NDArray[Any]]]:
    """Variables of one engine and speed, of the modes asked for alone."""
    over_angles, over_checks = ("crank_angle", "mode"), ("check_angle", "mode")
    branches, asked = part.branches, slice(modes)
    variables: dict[str, tuple[tuple[str, ...], NDArray[Any]]] = {
        "frequency": (over_angles, part.frequency[:, asked]),
        "damping_ratio": (over_angles, part.damping_ratio[:, asked]),
        "branch_of_mode": (over_angles, branches.branch[:, asked].astype(np.int64) + 1),
        "mac": (over_angles, branches.mac[:, asked]),
        "veering": (over_angles, branches.veering[:, asked]),
        "branch_whole": (("branch",), branches.whole[:tracked]),
        "discretisation_error": (over_checks, part.discretisation_error[:, asked]),
        "reduction_error": (over_checks, part.reduction_error[:, asked]),
        "mode_shape": (
            (*over_checks, "part", "link", "station", "component"),
            _scaled_parts(part.mode_shape),
        ),
    }
    if part.strain_energy_damping is not None:
        variables["strain_energy_damping"] = (over_angles, part.strain_energy_damping[:, asked])
    return variables


def _scaled_parts(shapes: NDArray[Any]) -> FloatArray:
    """Mode shapes as real and imaginary part, the largest displacement of each mode 1."""
    amplitude = np.sqrt(np.sum(np.abs(shapes) ** 2, axis=-1))
    largest = amplitude.max(axis=(-2, -1))[..., None, None, None]
    scaled = shapes / np.where(largest > 0, largest, 1.0)
    return np.stack([scaled.real, scaled.imag], axis=2)
