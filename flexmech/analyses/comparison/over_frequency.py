"""A measured frequency-response function beside that of the locked linkage."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses.comparison.dataset import comparison_dataset
from flexmech.analyses.comparison.fit import fitted
from flexmech.analyses.comparison.parameters import DAMPING, GAIN, fitted_names
from flexmech.analyses.comparison.receptance_problem import (
    MOBILITIES,
    ReceptanceProblem,
    points_of,
)
from flexmech.analyses.comparison.request import ComparisonRequest
from flexmech.errors import InputError
from flexmech.linear_system import Engine
from flexmech.measured_data import MeasuredQuantity, MeasuredRecord
from flexmech.types import IntArray, StepProgress

# Crank angles that are the same, in rad.
SAME_ANGLE = np.radians(0.01)
LEAST_LINES = 16
# An error of the hammer's force is common to neighbouring frequencies, and looks like damping.
DEFAULT = (DAMPING, GAIN)


def compared_over_frequency(
    engine: Engine, record: MeasuredRecord, request: ComparisonRequest, progress: StepProgress
) -> xr.Dataset:
    """Lay a frequency-response function beside the computed one, and fit.

    Parameters
    ----------
    engine : Engine
    record : MeasuredRecord
        Over frequency: a complex receptance, mobility or accelerance.
    request : ComparisonRequest
        With a crank angle.
    progress : callable

    Returns
    -------
    xarray.Dataset
        Real and imaginary parts of ``measured``, ``computed`` and ``residual`` over frequency,
        and the fit.

    Raises
    ------
    InputError
        If the record holds no such function, or none at this crank angle.
    ComputationError
        If the fit fails.
    """
    assert request.angle is not None
    name, points = _chosen(record, request.quantity)
    column = _column(record, name)
    rows = _at_angle(record, request.angle)
    frequency = record.position[rows]
    if len(frequency) < LEAST_LINES:
        raise InputError(
            f"{record.source}: holds {len(frequency)} frequencies, too few for a "
            f"frequency-response function; give at least {LEAST_LINES}"
        )
    if not np.all(np.diff(frequency) > 0) or frequency[0] < 0:
        raise InputError(
            f"{record.source}: its frequencies must be positive and increase; give one function, "
            "from its lowest frequency to its highest"
        )
    links = engine.mechanism.linkage.topology.link_names
    names = fitted_names(request.fit or DEFAULT, links)
    if names.offset:
        raise InputError("fit: a frequency-response function has no offset; fit damping, stiffness")
    impact, response = points_of(points, links)
    kind = MOBILITIES[column.unit]
    problem = ReceptanceProblem(
        engine,
        request.angle,
        impact,
        response,
        kind,
        frequency,
        np.asarray(column.values[rows], dtype=complex),
        names,
    )
    fit = fitted(problem, progress)
    dataset = comparison_dataset(
        engine,
        record,
        request,
        fit,
        problem.record,
        fit.computed[0] + 1j * fit.computed[1],
        dimension="frequency",
        unit=column.unit,
        column=column.name,
        quantity=f"{kind} at {response} from a force at {impact}",
        first_frequency=problem.first_frequency,
    )
    return dataset.assign_coords(frequency=frequency).assign_attrs(kind=kind)


def _chosen(record: MeasuredRecord, asked: str | None) -> tuple[str | None, str | None]:
    """Name of the function asked for and the text of its points, of ``NAME@POINT,POINT``."""
    if asked is None:
        return None, None
    name, at, points = asked.rpartition("@")
    if at:
        return name.strip(), points
    known = (*record.names, *record.unreadable)
    return (asked, None) if asked in known else (None, asked)


def _column(record: MeasuredRecord, name: str | None) -> MeasuredQuantity:
    """The complex quantity of a response over a force: that of a name, or the only one."""
    own = [q for q in record.quantities if np.iscomplexobj(q.values)]
    if name is not None:
        chosen = record.quantity(name)
        own = [chosen] if np.iscomplexobj(chosen.values) else []
    if len(own) > 1:
        raise InputError(
            f"{record.source}: holds {len(own)} frequency-response functions: "
            f"{', '.join(q.name for q in own[:10])}; choose one with the points of its impact and "
            f'response, as in --quantity "{own[0].name}@coupler:0.5,rocker:0.5"'
        )
    if not own:
        reasons = [
            r for n, r in record.unreadable.items() if n.lower().endswith(("_real", "_imag"))
        ]
        raise InputError(
            reasons[0]
            if reasons
            else f"{record.source}: holds no frequency-response function; give its real and "
            "imaginary part as two columns, such as receptance_real_m_N and receptance_imag_m_N"
        )
    if own[0].unit not in MOBILITIES:
        raise InputError(
            f"{record.source}: {own[0].name!r} is in {own[0].unit or '1'}; give a displacement, "
            "velocity or acceleration over a force, as m/N, m/(N s) or m/(N s^2)"
        )
    return own[0]


def _at_angle(record: MeasuredRecord, angle: float) -> IntArray:
    """Rows that were taken at the crank angle asked for; all where the record does not tell."""
    if not record.has("crank_angle"):
        return np.arange(len(record.position))
    own = np.asarray(record.quantity("crank_angle").values, dtype=float)
    apart = np.abs(np.angle(np.exp(1j * (own - angle))))
    rows = np.flatnonzero(apart <= SAME_ANGLE)
    if not len(rows):
        known = ", ".join(f"{value:g}" for value in np.unique(np.degrees(own).round(6))[:10])
        raise InputError(
            f"{record.source}: was taken at crank angles of {known} deg, not "
            f"{np.degrees(angle):g}; give one of these with --angle"
        )
    return rows
