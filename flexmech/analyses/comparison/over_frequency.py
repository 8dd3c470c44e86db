"""A measured frequency-response function beside that of the locked linkage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import xarray as xr

from flexmech.analyses.comparison.fit import Fit
from flexmech.analyses.comparison.problem import (
    DAMPING,
    GAIN,
    LITTLE_EXPLAINED,
    OFFSET,
    RATIOS,
    ComparisonRequest,
    LinearTerms,
    RecordProblem,
    fitted_engine,
    fitted_names,
    rows_taken_at,
)
from flexmech.analyses.comparison.quantities import COMPANIONS
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.arrays import FloatArray, IntArray
from flexmech.choices import MOST_MODES
from flexmech.dynamical_systems import direct_receptance
from flexmech.errors import InputError
from flexmech.measured_data import MeasuredQuantity, MeasuredRecord
from flexmech.mechanics import GREAT_DETAIL, Engine, LinearSystem, LinkPoint, point_rows

# What a response over a force is called by its SI unit, and how often it is differentiated.
_KINDS: dict[str, tuple[str, int]] = {
    "m/N": ("receptance", 0),
    "m/(N s)": ("mobility", 1),
    "m/(N s^2)": ("accelerance", 2),
}
# Crank angles that are the same, in rad: what a protractor and rounding leave.
_SAME_ANGLE = np.radians(0.01)
# A resonance is drawn by a few lines, and there are to be some beside it.
_LEAST_LINES = 16
# The model has all modes up to this multiple of the record's highest frequency.
_REACH = 1.5
# An error of the hammer's force is common to neighbouring frequencies, and looks like damping.
_DEFAULT = (DAMPING, GAIN)
_EXAMPLE = 'write "coupler:0.5", or impact and response as "coupler:0.5,rocker:0.5"'


@dataclass(frozen=True, kw_only=True)
class ReceptanceProblem(RecordProblem):
    """A frequency-response function measured with the crank locked.

    Parameters
    ----------
    engine : Engine
    record : ndarray of complex, shape (N,)
        In m/N, or per second or per square second of that.
    names : tuple of str
    column, unit, quantity : str
    crank_angle : float
        In rad.
    impact, response : LinkPoint
        Both across their links.
    frequency : ndarray, shape (N,)
        In Hz.
    """

    crank_angle: float
    impact: LinkPoint
    response: LinkPoint
    frequency: FloatArray

    dimension = "frequency"

    @cached_property
    def first_frequency(self) -> float:
        """First natural frequency at this crank angle in rad/s."""
        return float(2 * np.pi * self._natural_frequencies(1)[0])

    @property
    def damping_ratios(self) -> tuple[float, ...]:
        """Scale factors of both signs: no search crosses zero, an infinite resonance."""
        return (*RATIOS, *(-ratio for ratio in RATIOS))

    def labelled(self, dataset: xr.Dataset, fit: Fit) -> xr.Dataset:
        """The dataset with its frequencies."""
        kind, _ = _KINDS[self.unit]
        labelled = dataset.assign_coords(frequency=self.frequency).assign_attrs(kind=kind)
        if GAIN in self.names or fit.unexplained < LITTLE_EXPLAINED:
            return labelled
        return labelled.assign_attrs(self._with_gain())

    def _with_gain(self) -> dict[str, float]:
        """Part of the record that a gain would leave unexplained, and that gain."""
        other = replace(self, names=(*self.names, GAIN))
        start = other.with_linear([parameter.start for parameter in other.parameters])
        values = other.by_name(start)
        spread = float(np.sum(np.abs(self.record - self.record.mean()) ** 2))
        return {"turned_unexplained": other.misfit(values) / spread, "gain": values[GAIN]}

    def linear_terms(self, values: Mapping[str, float]) -> LinearTerms:
        """Computed frequency-response function for values by name, which the gain multiplies."""
        system = self._system(values)
        damping = system.damping[0]
        negative = [n for n, v in values.items() if n.startswith(DAMPING) and v < 0]
        if negative:
            # No section has a negative damping time, but the damping matrix is linear in it.
            without = self._system({**values, **dict.fromkeys(negative, 0.0)}).damping[0]
            damping = 2 * without - damping
        rows = [point_rows(system, point, "transverse") for point in (self.response, self.impact)]
        matrices = (system.mass[0], damping, system.stiffness[0])
        receptance = direct_receptance(*matrices, rows[0], rows[1], self.frequency)[:, 0, 0]
        rate = (2j * np.pi * self.frequency) ** _KINDS[self.unit][1]
        return LinearTerms({GAIN: np.asarray(rate * receptance)})

    def _system(self, values: Mapping[str, float]) -> LinearSystem:
        """Equations of the locked linkage for values by name, damping times by their size."""
        sizes = {n: abs(v) if n.startswith(DAMPING) else v for n, v in values.items()}
        engine = fitted_engine(self.engine, sizes)
        return engine.linear_system(
            self.crank_angle,
            prestress=engine.prestress_at_rest,
            modes=self._modes,
            detail=GREAT_DETAIL,
        )

    def _natural_frequencies(self, modes: int) -> FloatArray:
        level = self.engine.prestress_at_rest
        return natural_frequencies(self.engine, self.crank_angle, modes=modes, prestress=level)

    @cached_property
    def _modes(self) -> int:
        """Modes up to beyond the highest frequency of the record."""
        highest, most = _REACH * float(self.frequency[-1]), 8
        free = min(MOST_MODES, sum(link.size for link in self.engine.links) // 2)
        while most < free:
            if self._natural_frequencies(most)[-1] > highest:
                return most
            most *= 2
        raise InputError(
            f"the record reaches {self.frequency[-1]:.4g} Hz, beyond what {self.engine.elements} "
            "elements a link can show; give the part of the record below the lower modes"
        )


def receptance_problem(
    engine: Engine, record: MeasuredRecord, request: ComparisonRequest
) -> ReceptanceProblem:
    """Read a frequency-response function and the points that it is of.

    Parameters
    ----------
    engine : Engine
    record : MeasuredRecord
        Over frequency: a complex receptance, mobility or accelerance.
    request : ComparisonRequest
        With a crank angle.

    Returns
    -------
    ReceptanceProblem

    Raises
    ------
    InputError
        If the record holds no such function, or none at this crank angle.
    """
    assert request.angle is not None
    name, points = _chosen(record, request.quantity)
    column = _column(record, name)
    rows = _at_angle(record, request.angle)
    frequency = record.position[rows]
    if len(frequency) < _LEAST_LINES:
        raise InputError(
            f"{record.source}: holds {len(frequency)} frequencies, too few for a "
            f"frequency-response function; give at least {_LEAST_LINES}"
        )
    if not np.all(np.diff(frequency) > 0) or frequency[0] < 0:
        raise InputError(
            f"{record.source}: its frequencies must be positive and increase; give one function, "
            "from its lowest frequency to its highest"
        )
    links = engine.mechanism.linkage.topology.link_names
    names = fitted_names(request.fit or _DEFAULT, links)
    if OFFSET in names:
        raise InputError("fit: a frequency-response function has no offset; fit damping, stiffness")
    impact, response = points_of(points, links)
    return ReceptanceProblem(
        engine=engine,
        record=np.asarray(column.values[rows], dtype=complex),
        names=names,
        column=column.name,
        unit=column.unit,
        quantity=f"{_KINDS[column.unit][0]} at {response} from a force at {impact}",
        crank_angle=request.angle,
        impact=impact,
        response=response,
        frequency=frequency,
    )


def points_of(text: str | None, links: Sequence[str]) -> tuple[LinkPoint, LinkPoint]:
    """Points of impact and response.

    Parameters
    ----------
    text : str, optional
        One point for both, or two with a comma between; the middle of the coupler, or of the
        only link, by default.
    links : sequence of str

    Returns
    -------
    tuple of LinkPoint

    Raises
    ------
    InputError
        If it is none, or off its link.
    """
    if text is None:
        middle = LinkPoint("coupler" if "coupler" in links else links[-1], 0.5)
        return middle, middle
    parts = text.split(",")
    if len(parts) > 2:
        raise InputError(f"quantity: {text!r} has {len(parts)} points; {_EXAMPLE}")
    try:
        points = [LinkPoint.parse(part) for part in parts]
    except InputError as error:
        raise error.within("quantity") from error
    return points[0], points[-1]


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
    known = record.quantities if name is None else [record.quantity(name)]
    functions = [q for q in known if np.iscomplexobj(q.values)]
    if len(functions) > 1:
        raise InputError(
            f"{record.source}: holds {len(functions)} frequency-response functions: "
            f"{', '.join(q.name for q in functions[:10])}; choose one with the points of its "
            f'impact and response, as in --quantity "{functions[0].name}@coupler:0.5,rocker:0.5"'
        )
    if not functions:
        parts = [n for n in record.unreadable if n.lower().endswith(("_real", "_imag"))]
        others = [n for n in record.unreadable if n.lower() not in COMPANIONS]
        for unreadable in (*parts, *others):
            raise InputError(record.unreadable[unreadable])
        raise InputError(
            f"{record.source}: holds no frequency-response function; give its real and "
            "imaginary part as two columns, such as receptance_real_m_N and receptance_imag_m_N"
        )
    if functions[0].unit not in _KINDS:
        raise InputError(
            f"{record.source}: {functions[0].name!r} is in {functions[0].unit or '1'}; give a "
            "displacement, velocity or acceleration over a force, as m/N, m/(N s) or m/(N s^2)"
        )
    return functions[0]


def _at_angle(record: MeasuredRecord, angle: float) -> IntArray:
    """Rows that were taken at the crank angle asked for; all where the record does not tell."""
    if not record.has("crank_angle"):
        return np.arange(len(record.position))
    angles = np.asarray(record.quantity("crank_angle").values, dtype=float)
    near = np.abs(np.angle(np.exp(1j * (angles - angle)))) <= _SAME_ANGLE
    return rows_taken_at(
        record, near, np.degrees(angles).round(6), np.degrees(angle), "angle", "deg"
    )
