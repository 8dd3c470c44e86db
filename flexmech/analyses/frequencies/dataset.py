"""From arrays of a frequency map to one labelled dataset."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from flexmech.analyses.frequencies.discretisation import check_angle_indices
from flexmech.analyses.frequencies.modal_damping import links_without_loss
from flexmech.analyses.frequencies.request import FrequencyRequest
from flexmech.analyses.provenance import provenance, with_units
from flexmech.analyses.stations import rigid_positions
from flexmech.linear_system import Engine
from flexmech.mechanism import drawing
from flexmech.types import FloatArray


def joined(
    engines: Sequence[Engine],
    request: FrequencyRequest,
    maps: Sequence[xr.Dataset],
    speed_effect: dict[str, FloatArray] | None,
    pictured: Sequence[xr.Dataset] = (),
) -> xr.Dataset:
    """Join the maps of all engines, and label them.

    Parameters
    ----------
    engines : sequence of Engine
    request : FrequencyRequest
    maps : sequence of xarray.Dataset
        One for each engine; see :class:`flexmech.analyses.frequencies.engine_map.EngineMap`.
    speed_effect : dict of str to ndarray, shape (S, A, modes), or None
    pictured : sequence of xarray.Dataset
        What pictures of the first engine show besides.

    Returns
    -------
    xarray.Dataset
    """
    first, formulation = engines[0], request.formulation
    names = xr.DataArray([engine.name for engine in engines], dims="engine", name="engine")
    dataset = xr.concat(maps, names, join="inner")
    checks = request.crank_angles[check_angle_indices(request.crank_angles, request.full_turn)]
    positions = rigid_positions(first, first.mechanism.linkage.motion(checks))
    dataset["rigid_position"] = (("check_angle", "link", "station", "component"), positions)
    if speed_effect:
        values = np.stack(list(speed_effect.values()))
        dataset["speed_effect"] = (("term", "crank_speed", "crank_angle", "mode"), values)
        dataset = dataset.assign_coords(term=list(speed_effect))
    if "strain_energy_damping" in dataset:
        unknown = ", ".join(links_without_loss(first.mechanism))
        dataset["strain_energy_damping"].attrs["links_without_data"] = unknown
    dataset = dataset.assign_coords(
        element=("engine", [_element(engine) for engine in engines]),
        elements=("engine", [engine.elements for engine in engines]),
        crank_angle=request.crank_angles,
        mode=np.arange(1, formulation.modes + 1),
        check_angle=checks,
        part=["real", "imaginary"],
        link=list(first.mechanism.linkage.topology.link_names),
        station=np.linspace(0.0, 1.0, positions.shape[2]),
        component=["x", "y"],
    )
    lumps = max(engine.lumped_mass_count for engine in engines)
    for part in pictured:
        dataset = dataset.merge(part)
    return with_units(dataset, "frequencies").assign_attrs(
        provenance(engines),
        drawing=drawing(first.mechanism),
        prestress=formulation.prestress,
        rotation_terms="on" if formulation.rotation_terms else "off",
        speed_unit=request.speed_unit,
        **({"lumped_masses": lumps} if lumps else {}),
    )


def _element(engine: Engine) -> str:
    """Kind of element, and that masses are lumped where they are."""
    return engine.element if engine.mass == "distributed" else f"{engine.element}, lumped masses"


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
    both = xr.concat(
        parts,
        xr.DataArray(list(states), dims="state", name="state"),
        coords="minimal",
        compat="override",
        join="inner",
        combine_attrs="override",
    )
    return both.assign_attrs(environment_lines="\n".join(environment_lines))
