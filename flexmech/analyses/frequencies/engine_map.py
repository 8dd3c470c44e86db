"""Natural frequencies of one engine over a map: tracked modes, with their errors."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.frequencies.assignment import same_shapes
from flexmech.analyses.frequencies.discretisation import (
    check_angle_indices,
    damping_ratio_discretisation_error,
    discretisation_error,
)
from flexmech.analyses.frequencies.eigenproblem import solve_modes
from flexmech.analyses.frequencies.extremes import extremes_between, known_error
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.analyses.frequencies.frequency_map import frequencies_along, systems_at
from flexmech.analyses.frequencies.modal_damping import StrainEnergyDamping
from flexmech.analyses.frequencies.reduction import CheckedModes, settled
from flexmech.analyses.frequencies.refinement import Positions
from flexmech.analyses.frequencies.request import FrequencyRequest
from flexmech.analyses.frequencies.tracking import Tracker
from flexmech.linear_system import Engine
from flexmech.types import FloatArray, IntArray, LabelledProgress

__all__ = ["EngineMap", "map_engine"]

logger = logging.getLogger(__name__)

MOST_ELEMENTS = 32
"""On each link, to which a map refines the mesh by itself."""
# Modes followed besides those asked for, so that a branch may dip out and come back.
SPARE_MODES = 2

OVER_CHECKS = ("check_angle", "mode", "part", "link", "station", "component")


@dataclass(frozen=True)
class EngineMap:
    """Map of one engine.

    Parameters
    ----------
    systems : tuple of Systems
        Of each speed, with as many component modes as it has needed.
    dataset : xarray.Dataset
        Over (crank_speed, crank_angle, mode), errors and shapes over (crank_speed, check_angle,
        mode); its dimensions are without coordinates but for the branches.
    """

    systems: tuple[Systems, ...]
    dataset: xr.Dataset

    @property
    def engine(self) -> Engine:
        """With the elements that the map has needed."""
        return self.systems[0].engine


def map_engine(engine: Engine, request: FrequencyRequest, report: LabelledProgress) -> EngineMap:
    """Map of one engine, on a mesh that is fine enough if the request has a tolerance.

    The elements are doubled until the estimated error of the mesh is within the tolerance, or
    until another doubling would exceed :data:`MOST_ELEMENTS`. Meshes that would be too coarse even
    if the whole error fell with its highest order are passed over.

    Parameters
    ----------
    engine : Engine
    request : FrequencyRequest
        Engines that do not simulate answer it about the quasi-static state.
    report : callable
        Progress: ``report(label, done, total)``.

    Returns
    -------
    EngineMap
    """
    found = _map_on_mesh(engine, request, report)
    if request.tolerance is None:
        return found
    while 2 * engine.elements <= MOST_ELEMENTS:
        error = float(found.dataset["discretisation_error"].max())
        if error <= request.tolerance:
            break
        logger.info("%d elements are off by %.1e", engine.elements, error)
        order = engine.convergence(request.formulation.quasi_static_prestress).elastic
        doublings = max(1, math.ceil(math.log2(error / request.tolerance) / order))
        possible = int(math.log2(MOST_ELEMENTS / engine.elements))
        engine = engine.with_(elements=engine.elements * 2 ** min(doublings, possible))
        found = _map_on_mesh(engine, request, report)
    return found


def _map_on_mesh(engine: Engine, request: FrequencyRequest, report: LabelledProgress) -> EngineMap:
    """Map of one engine, speed by speed; a speed begins with the branches of the one before."""
    still = replace(request, formulation=request.formulation.quasi_static)
    asked = request if engine.simulates else still
    angles, modes = asked.crank_angles, asked.formulation.modes
    where = check_angle_indices(angles, asked.full_turn)
    losses = StrainEnergyDamping.of(engine)
    numbering: IntArray | None = None
    start_shapes: NDArray[Any] | None = None
    used: list[Systems] = []
    parts, done = [], 0

    def advance(count: int) -> None:
        nonlocal done
        done += count
        report(engine.name, done, len(asked.crank_speeds) * len(angles))

    for speed in asked.crank_speeds.tolist():
        checked = settled(systems_at(engine, asked, speed), angles[where], speed, SPARE_MODES)
        systems = checked.systems
        used.append(systems)
        shapes = checked.system.displacements(checked.modes.vectors)
        if start_shapes is not None:
            numbering = same_shapes(start_shapes, shapes[0], numbering)
        start_shapes = shapes[0]
        along = _along_angles(checked, asked, speed, Tracker(numbering), losses, advance)
        errors = {
            "discretisation_error": discretisation_error(systems, angles[where], speed),
            "reduction_error": checked.reduction_error.frequency,
            "mode_shape": _scaled_parts(shapes[:, :modes]),
        }
        if systems.is_damped:
            errors |= {
                "damping_ratio_discretisation_error": damping_ratio_discretisation_error(
                    systems, angles[where], speed
                ),
                "damping_ratio_reduction_error": checked.reduction_error.damping_ratio,
            }
        over_checks = {name: (OVER_CHECKS[: v.ndim], v) for name, v in errors.items()}
        part = along.isel(mode=slice(modes)).assign(over_checks)
        if request.formulation.prestress != "trajectory":
            part = part.assign(_extremes(systems, asked, speed, part))
        parts.append(part)
    dataset = xr.concat(parts, pd.Index(asked.crank_speeds, name="crank_speed"), join="inner")
    if request.formulation.prestress == "trajectory":
        quasi_static = dataset["frequency"]
        if engine.simulates:
            calm = [replace(s, formulation=still.formulation, running=None) for s in used]
            pairs = zip(calm, asked.crank_speeds.tolist(), strict=True)
            values = [frequencies_along(s, angles, speed) for s, speed in pairs]
            quasi_static = quasi_static.copy(data=np.stack(values))
        dataset["quasi_static_frequency"] = quasi_static
    return EngineMap(tuple(used), dataset)


def _along_angles(
    checked: CheckedModes,
    request: FrequencyRequest,
    crank_speed: float,
    tracker: Tracker,
    losses: StrainEnergyDamping | None,
    advance: Callable[[int], None],
) -> xr.Dataset:
    """Modes along the crank angles, batch by batch: tracked, spare ones among them."""
    systems, count, parts = checked.systems, checked.modes.count, []
    asked = request.formulation.modes

    def between(crank_angles: FloatArray) -> Positions:
        frequency, shapes = [], []
        for system in systems.batches(crank_angles, crank_speed):
            modes = solve_modes(system, asked, count - asked)
            frequency.append(modes.frequency)
            shapes.append(system.inertial_shapes(modes.vectors))
        return Positions(crank_angles, np.concatenate(frequency), np.concatenate(shapes))

    for system in systems.batches(request.crank_angles, crank_speed):
        modes = solve_modes(system, asked, count - asked)
        tracker.add(system.inertial_shapes(modes.vectors))
        found = {"frequency": modes.frequency, "damping_ratio": modes.damping_ratio}
        if losses is not None:
            states = systems.states(system.motion.crank_angle)
            prestress = systems.formulation.quasi_static_prestress
            found["strain_energy_damping"] = losses.ratio(system, modes, prestress, states)
        parts.append(found)
        advance(len(modes.frequency))
    every = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    branches = tracker.finish(
        every["frequency"], request.crank_angles, full_turn=request.full_turn, between=between
    )
    every |= {
        "branch_of_mode": branches.branch.astype(np.int64) + 1,
        "mac": branches.mac,
        "veering": branches.veering,
        "branch_unclear": branches.unclear,
    }
    return xr.Dataset(
        {name: (("crank_angle", "mode"), values) for name, values in every.items()}
        | {"branch_whole": ("branch", branches.whole)},
        coords={"branch": np.arange(1, count + 1)},
    )


def _extremes(
    systems: Systems, request: FrequencyRequest, crank_speed: float, found: xr.Dataset
) -> dict[str, tuple[str, FloatArray]]:
    """Lowest and highest frequency of each mode, between the crank angles too."""
    extremes = extremes_between(
        systems,
        request.crank_angles,
        crank_speed,
        found["frequency"].values,
        known_error(found).values,
        full_turn=request.full_turn,
    )
    return {field.name: ("mode", getattr(extremes, field.name)) for field in fields(extremes)}


def _scaled_parts(shapes: NDArray[Any]) -> FloatArray:
    """Mode shapes as real and imaginary part, the largest displacement of each mode 1."""
    amplitude = np.sqrt(np.sum(np.abs(shapes) ** 2, axis=-1))
    largest = amplitude.max(axis=(-2, -1))[..., None, None, None]
    scaled = shapes / np.where(largest > 0, largest, 1.0)
    return np.stack([scaled.real, scaled.imag], axis=2)
