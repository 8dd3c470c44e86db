"""From the measurements at all crank angles to one labelled dataset."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import provenance
from flexmech.analyses.hammer.charts import chart_variables
from flexmech.analyses.hammer.grid import grid_points, grid_variables
from flexmech.analyses.hammer.measurement import Measurement
from flexmech.analyses.hammer.plan import LEFT, RecordPlan
from flexmech.analyses.hammer.request import HammerRequest
from flexmech.analyses.hammer.uff import geometry_variables
from flexmech.linear_system import Engine
from flexmech.types import ComplexArray, FloatArray

OVER_LINES = ("crank_angle", "frequency")
OVER_MODES = ("crank_angle", "mode")
OVER_RECORDS = ("crank_angle", "average", "time")
PARTS: dict[str, str] = {"_real": "real", "_imag": "imag"}
"""Endings of the names of a complex variable's parts: files hold real numbers alone."""

# Places of the half-sine's curve over its duration, and of a circle's points over the distance
# from the natural frequency: denser about it.
PULSE_PLACES = np.linspace(0.0, 1.0, 101)
CIRCLE_PLACES = np.linspace(-1.0, 1.0, 161) ** 3
# Half the range of frequencies of a circle, in halves of the half-power bandwidth.
REACH = 8.0
# Bandwidth over the least frequency of a circle.
LARGEST = 1e4

# Receptances of a measurement, and what it knows of each mode.
OF_LINES: dict[str, Callable[[Measurement], ComplexArray]] = {
    "receptance": lambda each: each.estimate.h1,
    "receptance_h2": lambda each: each.estimate.h2,
    "unwindowed_receptance": lambda each: each.unwindowed[0],
    "exact_receptance": lambda each: each.exact,
    "superposed_receptance": lambda each: each.superposed,
    "identified_receptance": lambda each: each.modes.receptance(
        each.estimate.frequency, each.estimate.added_damping
    )[0],
}
OF_MODES: dict[str, Callable[[Measurement], FloatArray]] = {
    "identified_frequency": lambda each: each.modes.frequency,
    "identified_damping_ratio": lambda each: each.modes.damping_ratio,
    "identified_residue_real": lambda each: each.modes.residue[0].real,
    "identified_residue_imag": lambda each: each.modes.residue[0].imag,
    "eigen_frequency": lambda each: np.abs(each.poles) / (2 * np.pi),
    "eigen_damping_ratio": lambda each: -each.poles.real / np.abs(each.poles),
}
OF_ANGLES: dict[str, Callable[[Measurement], float]] = {
    "simulation_error": lambda each: _gap(each.estimate.h1, each.exact),
    "superposition_error": lambda each: _gap(each.superposed, each.exact),
    "direct_difference": lambda each: each.direct_difference,
    "residual_term": lambda each: each.residual,
    "identification_misfit": lambda each: each.modes.misfit,
}


def dataset_of(
    engine: Engine, request: HammerRequest, plan: RecordPlan, found: Sequence[Measurement]
) -> xr.Dataset:
    """Put the measurements of all crank angles together.

    Parameters
    ----------
    engine : Engine
    request : HammerRequest
    plan : RecordPlan
    found : sequence of Measurement
        At the request's crank angles.

    Returns
    -------
    xarray.Dataset
        Modes of an angle that has fewer than another are not numbers.
    """
    variables: dict[str, Any] = {
        "force": (OVER_RECORDS, np.stack([each.force for each in found])),
        "response": (OVER_RECORDS, np.stack([each.response for each in found])),
        "coherence": (OVER_LINES, np.stack([each.estimate.coherence for each in found])),
    }
    for name, value in OF_LINES.items():
        lines = np.stack([value(each) for each in found])
        variables |= {
            name + ending: (OVER_LINES, getattr(lines, part)) for ending, part in PARTS.items()
        }
    modes = max(len(each.poles) for each in found)
    for name, of_modes in OF_MODES.items():
        table = np.full((len(found), modes), np.nan)
        for row, each in zip(table, found, strict=True):
            values = of_modes(each)
            row[: len(values)] = values
        variables[name] = (OVER_MODES, table)
    variables |= _circles(found, plan, modes)
    # A single pair of points has no mode shape: the grid of impacts has.
    variables["mac"] = (OVER_MODES, np.full((len(found), modes), np.nan))
    variables |= _roved(found, modes)
    variables |= chart_variables([each.modes for each in found])
    variables |= geometry_variables(engine, request.angles)
    shape = plan.pulse.force(plan.pulse.start + plan.pulse.duration * PULSE_PLACES)
    variables["pulse_force"] = ("pulse_time", shape)
    for name, of_angle in OF_ANGLES.items():
        variables[name] = ("crank_angle", [of_angle(each) for each in found])
    dataset = xr.Dataset(
        variables,
        coords={
            "crank_angle": request.angles,
            "average": np.arange(1, request.averages + 1),
            "time": plan.time,
            "frequency": found[0].estimate.frequency,
            "mode": np.arange(1, modes + 1),
            "pulse_time": plan.pulse.start + plan.pulse.duration * PULSE_PLACES,
            "link": list(engine.mechanism.linkage.topology.link_names),
            **_grid_coordinates(engine, request),
        },
    )
    return dataset.assign_attrs(
        provenance([engine]),
        engine=engine.name,
        element=engine.element,
        impact=str(request.impact),
        response_point=str(request.response),
        direction=request.direction,
        prestress=request.prestress,
        noise=request.noise,
        seed=request.seed,
        bandwidth=plan.bandwidth,
        sampling_rate=plan.sampling_rate,
        duration=plan.duration,
        pulse=plan.pulse.duration,
        pulse_start=plan.pulse.start,
        peak_force=plan.pulse.peak_force,
        step=plan.step,
        simulates=int(engine.simulates),
        window_decay_rate=plan.decay_rate,
        left_at_the_end=LEFT,
        method=found[0].modes.method,
    )


def _roved(found: Sequence[Measurement], modes: int) -> dict[str, Any]:
    """Receptances and mode shapes of a grid of impacts; nothing without one."""
    shapes = [each.grid for each in found if each.grid is not None]
    if not shapes:
        return {}
    receptance, over = (
        np.stack([each.unwindowed[1:] for each in found]),
        ("crank_angle", "point", "frequency"),
    )
    parts = {
        f"grid_receptance{ending}": (over, getattr(receptance, part))
        for ending, part in PARTS.items()
    }
    return parts | grid_variables(shapes, modes)


def _grid_coordinates(engine: Engine, request: HammerRequest) -> dict[str, Any]:
    if request.grid is None:
        return {}
    points = grid_points(engine, request.grid)
    return {
        "point": np.arange(1, len(points) + 1),
        "point_link": ("point", [point.link for point in points]),
        "point_fraction": ("point", [point.fraction for point in points]),
    }


def _circles(found: Sequence[Measurement], plan: RecordPlan, modes: int) -> dict[str, Any]:
    """Receptances about each mode, exact and identified, closely enough to draw circles."""
    shape = (len(found), modes, len(CIRCLE_PLACES))
    frequency = np.full(shape, np.nan)
    exact, identified = np.full((2, *shape), np.nan, dtype=complex)
    for angle, each in enumerate(found):
        natural = np.abs(each.poles) / (2 * np.pi)
        half = REACH * natural * -each.poles.real / np.abs(each.poles)
        half += REACH * plan.decay_rate / (2 * np.pi)
        # Up to the middle between neighbouring modes.
        apart = np.diff(natural, prepend=-np.inf, append=np.inf)
        half = np.minimum(half, np.minimum(apart[:-1], apart[1:]) / 2)
        for mode, (middle, width) in enumerate(zip(natural, half, strict=True)):
            around = np.maximum(middle + width * CIRCLE_PLACES, plan.bandwidth / LARGEST)
            frequency[angle, mode] = around
            exact[angle, mode] = each.exact_at(around)
            identified[angle, mode] = each.modes.receptance(around, plan.decay_rate)[0]
    over = (*OVER_MODES, "circle_point")
    variables: dict[str, Any] = {"circle_frequency": (over, frequency)}
    for name, values in (("exact", exact), ("identified", identified)):
        for ending, part in PARTS.items():
            variables[f"circle_{name}_receptance{ending}"] = (over, getattr(values, part))
    return variables


def receptance_of(dataset: xr.Dataset, name: str = "receptance") -> ComplexArray:
    """Complex values of a variable that is stored as two.

    Parameters
    ----------
    dataset : xarray.Dataset
    name : str
        Without the ending of its parts.

    Returns
    -------
    ndarray of complex
        Of the variable's shape.
    """
    real, imaginary = (dataset[name + ending].values for ending in PARTS)
    return np.asarray(real + 1j * imaginary)


def _gap(values: ComplexArray, exact: ComplexArray) -> float:
    """Greatest difference over the peak."""
    return float(np.abs(values - exact).max() / np.abs(exact).max())
