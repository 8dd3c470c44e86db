"""The dataset of strength: internal forces, what is found at each place, and the margins."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import filled, padded
from flexmech.analyses.strength.forces import InternalForces
from flexmech.analyses.strength.judged import JudgedLink
from flexmech.arrays import FloatArray
from flexmech.mechanism import Mechanism
from flexmech.sections import SURFACES

_PLACE = ("engine", "link", "station", "layer", "surface")
_FORCES = ("axial_force", "bending_moment", "shear_force")


def strength_dataset(
    mechanism: Mechanism,
    engine: str,
    angles: FloatArray,
    forces: Mapping[str, InternalForces],
    judged: Mapping[str, JudgedLink],
) -> xr.Dataset:
    """What one engine's forces make of the links.

    Parameters
    ----------
    mechanism : Mechanism
        In its state.
    engine : str
        Whose internal forces they are.
    angles : ndarray, shape (A,)
        Crank angles in rad.
    forces : mapping of str to InternalForces
        Of every link.
    judged : mapping of str to JudgedLink
        Of links whose layers are known.

    Returns
    -------
    xarray.Dataset
    """
    links = list(forces)
    count = max(len(one.place) for one in forces.values())
    deep = max(len(one.criterion) for one in judged.values())
    along = padded([np.moveaxis(forces[name].loads, 1, -1) for name in links], count)
    shape = (len(links), count, deep, len(SURFACES))
    numbers = {links.index(name): one for name, one in judged.items()}

    def of_places(values: Mapping[int, Any], otherwise: float | str = np.nan) -> Any:
        entries = (((link,), value) for link, value in values.items())
        return _PLACE, filled(shape, entries, otherwise)[None]

    def of_layers(values: Mapping[int, Any], otherwise: float | str) -> Any:
        entries = (((link,), value) for link, value in values.items())
        return ("link", "layer"), filled((len(links), deep), entries, otherwise)

    stacks = {}
    for link, name in enumerate(links):
        if (layers := mechanism.layers_of(name)) is not None:
            stacks[link] = layers.laminate.layers
    lengths = [body.length for body in mechanism.linkage.topology.links]
    return xr.Dataset(
        {
            "position": (("link", "station"), padded([forces[n].place for n in links], count)),
            **{
                name: (("engine", "link", "crank_angle", "station"), along[None, :, :, number])
                for number, name in enumerate(_FORCES)
            },
            "failure_index": of_places({n: one.index for n, one in numbers.items()}),
            "load_factor": of_places({n: one.load_factor for n, one in numbers.items()}),
            "speed_factor": of_places({n: one.speed_factor for n, one in numbers.items()}),
            "worst_angle": of_places({n: angles[one.worst] for n, one in numbers.items()}),
            "failure_mode": of_places({n: one.mode for n, one in numbers.items()}, ""),
            "criterion": of_layers({n: one.criterion for n, one in numbers.items()}, ""),
            "ply": of_layers({n: [la.ply.name for la in own] for n, own in stacks.items()}, ""),
            "angle": of_layers({n: [la.angle for la in own] for n, own in stacks.items()}, np.nan),
            "length": ("link", lengths),
        },
        coords={
            "engine": [engine],
            "link": links,
            "crank_angle": angles,
            "station": np.arange(1, count + 1),
            "layer": np.arange(1, deep + 1),
            "surface": list(SURFACES),
        },
    )


def margins(dataset: xr.Dataset) -> dict[str, Any]:
    """The worst place of each judged link, by whatever engine, weakest link first.

    Parameters
    ----------
    dataset : xarray.Dataset

    Returns
    -------
    dict
        Variables over ``margin``.
    """
    rows = []
    for name in dataset["link"].values.tolist():
        own = dataset.sel(link=name)
        factor = own["load_factor"].values
        if np.isnan(factor).all():
            continue
        engine, station, layer, surface = np.unravel_index(np.nanargmin(factor), factor.shape)
        at = {"engine": engine, "station": station, "layer": layer, "surface": surface}
        worst = own.isel(at)
        speeds = own["speed_factor"].values
        rows.append(
            {
                "part": name,
                "kind": "link",
                "load_factor": float(worst["load_factor"]),
                "speed_factor": np.nan if np.isnan(speeds).all() else float(np.nanmin(speeds)),
                "position": float(worst["position"]),
                "layer": int(worst["layer"]),
                "surface": str(worst["surface"].item()),
                "crank_angle": float(worst["worst_angle"]),
                "mode": str(worst["failure_mode"].item()),
                "index": float(worst["failure_index"]),
            }
        )
    rows.sort(key=lambda row: row["load_factor"])
    return {f"margin_{name}": ("margin", np.array([row[name] for row in rows])) for name in rows[0]}
