"""The dataset of strength: internal forces, what is found at each place and of each pin."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import filled, padded
from flexmech.analyses.schema import Values, schema_of
from flexmech.analyses.strength.forces import InternalForces
from flexmech.analyses.strength.judged import JudgedLink
from flexmech.analyses.strength.judged_pins import JudgedPins
from flexmech.analyses.strength.pin_checks import PinCheck
from flexmech.arrays import FloatArray, IntArray
from flexmech.mechanism import Mechanism
from flexmech.sections import SURFACES

_FORCES = ("axial_force", "bending_moment", "shear_force")


def strength_dataset(
    mechanism: Mechanism,
    engine: str,
    angles: FloatArray,
    forces: Mapping[str, InternalForces],
    judged: Mapping[str, JudgedLink],
    judged_at: FloatArray,
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
    judged_at : ndarray, shape (B,)
        Crank angles at which they were judged, in rad.

    Returns
    -------
    xarray.Dataset
    """
    links = list(forces)
    count = max(len(one.place) for one in forces.values())
    deep = max((len(one.criterion) for one in judged.values()), default=1)
    along = padded([np.moveaxis(forces[name].loads, 1, -1) for name in links], count)
    shape = (len(links), count, deep, len(SURFACES))
    numbers = {links.index(name): one for name, one in judged.items()}

    def of_links(
        size: tuple[int, ...], values: Mapping[int, Any], otherwise: float | str = np.nan
    ) -> Any:
        return filled(size, (((link,), value) for link, value in values.items()), otherwise)

    stacks = {}
    for link, name in enumerate(links):
        if (layers := mechanism.layers_of(name)) is not None:
            stacks[link] = layers.laminate.layers
    layered = shape[0], deep
    values: Values = {
        "engine": [engine],
        "link": links,
        "crank_angle": angles,
        "station": np.arange(1, count + 1),
        "layer": np.arange(1, deep + 1),
        "surface": list(SURFACES),
        "position": padded([forces[name].place for name in links], count),
        "criterion": of_links(layered, {n: one.criterion for n, one in numbers.items()}, ""),
        "ply": of_links(layered, {n: [la.ply.name for la in own] for n, own in stacks.items()}, ""),
        "angle": of_links(layered, {n: [la.angle for la in own] for n, own in stacks.items()}),
        "length": [body.length for body in mechanism.linkage.topology.links],
    }
    of_engine: Values = {
        **{name: along[:, :, number] for number, name in enumerate(_FORCES)},
        "failure_index": of_links(shape, {n: one.index for n, one in numbers.items()}),
        "load_factor": of_links(shape, {n: one.load_factor for n, one in numbers.items()}),
        "speed_factor": of_links(shape, {n: one.speed_factor for n, one in numbers.items()}),
        "worst_angle": of_links(shape, {n: judged_at[one.worst] for n, one in numbers.items()}),
        "failure_mode": of_links(shape, {n: one.mode for n, one in numbers.items()}, ""),
    }
    return schema_of(__package__).dataset(values, parts=[of_engine], along="engine")


def pin_variables(
    checks: Sequence[PinCheck], judged: JudgedPins, angles: FloatArray, asked: IntArray
) -> dict[str, Any]:
    """Variables of what one engine's forces make of the pins; none without checks.

    Parameters
    ----------
    checks : sequence of PinCheck
    judged : JudgedPins
    angles : ndarray, shape (A,)
        Crank angles in rad.
    asked : ndarray of int, shape (B,)
        Numbers of those that were asked for, evenly apart as they may be: means are over them.

    Returns
    -------
    dict
        Over ``pin_check``, and over (engine, pin_check).
    """
    if not checks:
        return {}
    words = {name: [getattr(one, name) for one in checks] for name in ("joint", "link", "mode")}
    numbers = {
        "stress": judged.stress,
        "mean": judged.stresses[:, asked].mean(axis=1),
        "load_factor": judged.load_factor,
        "speed_factor": judged.speed_factor,
        "worst_angle": angles[judged.worst],
    }
    return {
        **{f"pin_{name}": ("pin_check", np.array(texts)) for name, texts in words.items()},
        "pin_allowable": ("pin_check", [one.allowable for one in checks]),
        **{f"pin_{n}": (("engine", "pin_check"), value[None]) for n, value in numbers.items()},
    }
