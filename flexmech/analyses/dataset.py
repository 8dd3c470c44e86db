"""From arrays of a frequency map to one labelled dataset."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.mapping import FrequencyRequest
from flexmech.analyses.modal_damping import links_without_loss
from flexmech.analyses.provenance import provenance
from flexmech.analyses.tracking import Branches
from flexmech.linear_system import Engine
from flexmech.types import FloatArray, IntArray

__all__ = ["EngineMap", "SpeedMap", "build_dataset"]


MAP_DIMS = ("engine", "crank_speed", "crank_angle", "mode")
CHECK_DIMS = ("engine", "crank_speed", "check_angle", "mode")
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
    count = request.modes

    def stacked(pick: str, limit: int | None = count) -> NDArray[Any]:
        parts = [[np.asarray(_pick(s, pick))[..., :limit] for s in m.speeds] for m in maps]
        return np.stack([np.stack(part) for part in parts])

    tracked = min(s.frequency.shape[1] for m in maps for s in m.speeds)
    where = maps[0].check_angles
    variables: dict[str, tuple[Any, ...]] = {
        "frequency": (MAP_DIMS, stacked("frequency")),
        "damping_ratio": (MAP_DIMS, stacked("damping_ratio")),
        "branch_of_mode": (MAP_DIMS, stacked("branches.branch").astype(np.int64) + 1),
        "mac": (MAP_DIMS, stacked("branches.mac")),
        "veering": (MAP_DIMS, stacked("branches.veering")),
        "branch_whole": (("engine", "crank_speed", "branch"), stacked("branches.whole", tracked)),
        "discretisation_error": (CHECK_DIMS, stacked("discretisation_error")),
        "reduction_error": (CHECK_DIMS, stacked("reduction_error")),
        "mode_shape": ((*CHECK_DIMS, "part", "link", "station", "component"), _shapes(maps)),
        "rigid_position": (
            ("check_angle", "link", "station", "component"),
            _positions(engines[0], request.crank_angles[where]),
        ),
    }
    if all(s.strain_energy_damping is not None for m in maps for s in m.speeds):
        unknown = {"links_without_data": ", ".join(links_without_loss(engines[0].mechanism))}
        losses = stacked("strain_energy_damping")
        variables["strain_energy_damping"] = (MAP_DIMS, losses, unknown)
    if speed_effect:
        dims = ("term", *MAP_DIMS[1:])
        variables["speed_effect"] = (dims, np.stack(list(speed_effect.values())))
    if quasi_static is not None:
        variables["quasi_static_frequency"] = (MAP_DIMS, quasi_static)
    links = list(engines[0].mechanism.linkage.topology.link_names)
    stations = variables["rigid_position"][1].shape[2]
    dataset = xr.Dataset(
        variables,
        coords={
            "engine": [e.name for e in engines],
            "element": ("engine", [e.element for e in engines]),
            "crank_speed": request.crank_speeds,
            "crank_angle": request.crank_angles,
            "mode": np.arange(1, count + 1),
            "branch": np.arange(1, tracked + 1),
            "check_angle": request.crank_angles[where],
            "part": ["real", "imaginary"],
            "link": links,
            "station": np.linspace(0.0, 1.0, stations),
            "component": ["x", "y"],
            **({"term": list(speed_effect)} if speed_effect else {}),
        },
        attrs={
            **provenance(engines),
            "prestress": request.prestress,
            "rotation_terms": "on" if request.rotation_terms else "off",
        },
    )
    for name, (units, long_name) in UNITS.items():
        if name in dataset.variables:
            dataset[name].attrs.update(units=units, long_name=long_name)
    return dataset


def _pick(part: SpeedMap, path: str) -> object:
    value: object = part
    for name in path.split("."):
        value = getattr(value, name)
    return value


def _shapes(maps: Sequence[EngineMap]) -> FloatArray:
    """Mode shapes as real and imaginary part, the largest displacement of each mode 1."""
    shapes = np.stack([np.stack([s.mode_shape for s in m.speeds]) for m in maps])
    amplitude = np.sqrt(np.sum(np.abs(shapes) ** 2, axis=-1))
    largest = amplitude.max(axis=(-2, -1))[..., None, None, None]
    scaled = shapes / np.where(largest > 0, largest, 1.0)
    return np.stack([scaled.real, scaled.imag], axis=4)


def _positions(engine: Engine, crank_angles: FloatArray) -> FloatArray:
    """Undeformed stations in ground axes; (C, n_links, n_stations, 2)."""
    motion = engine.mechanism.linkage.motion(crank_angles)
    parts = []
    for number, link in enumerate(engine.links):
        length = engine.mechanism.linkage.topology.links[number].length
        places = np.linspace(0.0, length, len(link.shape))
        parts.append(np.stack([motion.position(number, float(x)) for x in places], axis=1))
    return np.stack(parts, axis=1)
