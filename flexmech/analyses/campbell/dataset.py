"""From the diagrams of the engines to one labelled dataset."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.campbell.crossings import CriticalSpeed
from flexmech.analyses.campbell.engine_bands import EngineDiagram, Gap
from flexmech.analyses.campbell.request import CampbellRequest
from flexmech.analyses.campbell.steady_response import SteadyResponse
from flexmech.analyses.provenance import provenance, with_units
from flexmech.analyses.response import probes
from flexmech.types import FloatArray


def dataset_of(
    diagrams: Sequence[EngineDiagram], request: CampbellRequest, steady: SteadyResponse | None
) -> xr.Dataset:
    """Join the diagrams of all engines, and label them.

    Parameters
    ----------
    diagrams : sequence of EngineDiagram
    request : CampbellRequest
    steady : SteadyResponse, optional
        Of the first engine.

    Returns
    -------
    xarray.Dataset
        Frequencies over (engine, crank_speed, branch), not a number in gaps; critical speeds over
        ``critical`` and gaps over ``gap``, each with the engine that it is of.
    """
    engines = [diagram.engine for diagram in diagrams]
    checked = np.unique(np.concatenate([each.checked_speeds for each in diagrams]))
    over = ("engine", "crank_speed", "branch")
    values = np.stack([each.sampled.values[each.places] for each in diagrams])
    dataset = xr.Dataset(
        {
            "lowest_frequency": (over, values[:, :, 0]),
            "mean_frequency": (over, values[:, :, 1]),
            "highest_frequency": (over, values[:, :, 2]),
            "solved": (over[:2], np.stack([_solved(each) for each in diagrams])),
            "discretisation_error": (
                ("engine", "check_speed", "branch"),
                _by_checked_speed(diagrams, checked),
            ),
            "fit_error": ("engine", [each.sampled.fit_error for each in diagrams]),
            "projection_error": ("engine", [each.projection_error for each in diagrams]),
            "crossing_error": ("engine", [each.crossing_error for each in diagrams]),
        }
        | _table("critical", CriticalSpeed, [(d, c) for d in diagrams for c in d.critical])
        | _table("gap", Gap, [(d, g) for d in diagrams for g in d.gaps]),
        coords={
            "engine": [engine.name for engine in engines],
            "element": ("engine", [engine.element for engine in engines]),
            "elements": ("engine", [engine.elements for engine in engines]),
            "crank_speed": request.crank_speeds,
            "check_speed": checked,
            "branch": np.arange(1, request.formulation.modes + 1),
            "order": request.orders,
        },
    )
    if steady is not None:
        dataset["peak_ratio"] = (("response_speed", "link"), steady.ratio)
        links = list(engines[0].mechanism.linkage.topology.link_names)
        dataset = dataset.assign_coords(
            response_speed=steady.crank_speed, link=links, probe=("link", probes(engines[0]))
        )
        dataset.attrs["without_periodic_motion"] = "\n".join(steady.left_out.values())
    angles = np.degrees(request.crank_angles)
    turn = "a turn" if request.full_turn else f"{angles[0]:.6g} to {angles[-1]:.6g} deg"
    return with_units(dataset, "campbell").assign_attrs(
        provenance(engines),
        prestress=request.formulation.prestress,
        rotation_terms="on" if request.formulation.rotation_terms else "off",
        speed_unit=request.speed_unit,
        crank_angles=f"{turn}, {len(request.turn)} angles",
        operating_speeds=" ".join(map(repr, map(float, engines[0].mechanism.operating_speeds))),
    )


def _by_checked_speed(diagrams: Sequence[EngineDiagram], checked: FloatArray) -> FloatArray:
    """Errors by the mesh, (engine, speed, branch); not a number where one was not checked."""
    every = np.full((len(diagrams), len(checked), diagrams[0].mesh_error.shape[1]), np.nan)
    for number, each in enumerate(diagrams):
        every[number, np.searchsorted(checked, each.checked_speeds)] = each.mesh_error
    return every


def _solved(diagram: EngineDiagram) -> NDArray[np.bool_]:
    """Which of the crank speeds asked for were solved for rather than fitted."""
    sampled = diagram.sampled
    return np.isin(sampled.crank_speed[diagram.places], sampled.solved.crank_speed)


def _table(
    dimension: str, kind: type, rows: Sequence[tuple[EngineDiagram, object]]
) -> dict[str, tuple[str, NDArray[Any]]]:
    """Variables over a dimension, one for each field, named like ``critical_order``."""
    columns: dict[str, list[Any]] = {"engine": [diagram.engine.name for diagram, _ in rows]}
    for each in fields(kind):
        columns[each.name] = [getattr(row, each.name) for _, row in rows]
    types: dict[str, Any] = {
        "engine": str,
        "reason": str,
        "order": np.intp,
        "branch": np.intp,
        "count": np.intp,
    }
    types |= {"starts_inside": bool, "ends_inside": bool}
    return {
        f"{dimension}_{name}": (dimension, np.array(values, dtype=types.get(name, float)))
        for name, values in columns.items()
    }
