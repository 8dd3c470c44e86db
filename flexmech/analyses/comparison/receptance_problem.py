"""A measured frequency-response function beside that of the locked linkage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.comparison.fit import Parameter
from flexmech.analyses.comparison.parameters import GAIN, Fitted, with_damping_times, with_stiffness
from flexmech.analyses.comparison.start import USUAL_RATIO, named, parameters_from, start_values
from flexmech.analyses.frequencies import natural_frequencies
from flexmech.choices import MOST_MODES
from flexmech.dynamical_systems import direct_receptance
from flexmech.errors import InputError
from flexmech.linear_system import Engine, LinkPoint, point_rows
from flexmech.types import FloatArray

ComplexArray = NDArray[np.complex128]
Kind = Literal["receptance", "mobility", "accelerance"]
MOBILITIES: dict[str, Kind] = {
    "m/N": "receptance",
    "m/(N s)": "mobility",
    "m/(N s^2)": "accelerance",
}
"""What a response over a force is called, by its SI unit."""
ORDERS: dict[Kind, int] = {"receptance": 0, "mobility": 1, "accelerance": 2}
# The model has all modes up to this multiple of the record's highest frequency.
REACH = 1.5
EXAMPLE = 'write "coupler:0.5", or impact and response as "coupler:0.5,rocker:0.5"'


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
        link = "coupler" if "coupler" in links else links[-1]
        return LinkPoint(link, 0.5), LinkPoint(link, 0.5)
    parts = text.split(",")
    if len(parts) > 2:
        raise InputError(f"quantity: {text!r} has {len(parts)} points; {EXAMPLE}")
    try:
        points = [LinkPoint.parse(part) for part in parts]
    except InputError as error:
        raise error.within("quantity") from error
    return points[0], points[-1]


@dataclass(frozen=True)
class ReceptanceProblem:
    """A frequency-response function measured with the crank locked.

    Parameters
    ----------
    engine : Engine
        Of the mechanism as its model says.
    crank_angle : float
        In rad.
    impact, response : LinkPoint
        Both across their links.
    kind : {"receptance", "mobility", "accelerance"}
    frequency : ndarray, shape (F,)
        In Hz.
    record : ndarray of complex, shape (F,)
        In m/N, or per second or per square second of that.
    fitted : Fitted
    """

    engine: Engine
    crank_angle: float
    impact: LinkPoint
    response: LinkPoint
    kind: Kind
    frequency: FloatArray
    record: ComplexArray
    fitted: Fitted

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the links."""
        return self.engine.mechanism.linkage.topology.link_names

    @cached_property
    def first_frequency(self) -> float:
        """First natural frequency at this crank angle in rad/s."""
        found = natural_frequencies(
            self.engine, self.crank_angle, modes=1, prestress=self.engine.prestress_at_rest
        )
        return float(2 * np.pi * found[0])

    @property
    def measured(self) -> FloatArray:
        """Real and imaginary part of the record, (2, F)."""
        return _parts(self.record)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """What is fitted, and from where."""
        unit_time = 2 * USUAL_RATIO / self.first_frequency
        return parameters_from(start_values(named(self.fitted), unit_time, self.misfit), unit_time)

    @property
    def linear_unknowns(self) -> int:
        """None: the model is at rest before the impact."""
        return 0

    def computed(self, values: Sequence[float]) -> FloatArray:
        """Real and imaginary part of the computed function, (2, F)."""
        by_name = dict(zip(named(self.fitted), values, strict=True))
        return _parts(self.function(by_name))

    def misfit(self, values: Mapping[str, float]) -> float:
        """Sum of squares of the residual for values by name."""
        return float(np.sum(np.abs(self.record - self.function(values)) ** 2))

    def function(self, values: Mapping[str, float]) -> ComplexArray:
        """Computed frequency-response function for values by name, (F,)."""
        engine = with_damping_times(self.engine, self.fitted.times_of(self.links, values))
        engine = with_stiffness(engine, self.fitted.factors(values))
        system = engine.linear_system(
            self.crank_angle, prestress=engine.prestress_at_rest, modes=self._modes
        )
        rows = [point_rows(system, point, "transverse") for point in (self.response, self.impact)]
        matrices = (system.mass[0], system.damping[0], system.stiffness[0])
        found = direct_receptance(*matrices, rows[0], rows[1], self.frequency)[:, 0, 0]
        found = values.get(GAIN, 1.0) * found
        return np.asarray((2j * np.pi * self.frequency) ** ORDERS[self.kind] * found)

    @cached_property
    def _modes(self) -> int:
        """Modes up to beyond the highest frequency of the record."""
        highest, most = REACH * float(self.frequency[-1]), 8
        free = min(MOST_MODES, sum(link.size for link in self.engine.links) // 2)
        while most < free:
            found = natural_frequencies(
                self.engine,
                self.crank_angle,
                modes=most,
                prestress=self.engine.prestress_at_rest,
            )
            if found[-1] > highest:
                return most
            most *= 2
        raise InputError(
            f"the record reaches {self.frequency[-1]:.4g} Hz, beyond what {self.engine.elements} "
            "elements a link can show; give the part of the record below the lower modes"
        )


def _parts(values: ComplexArray) -> FloatArray:
    return np.stack([values.real, values.imag])
