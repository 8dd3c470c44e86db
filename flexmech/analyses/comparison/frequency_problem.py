"""Measured natural frequencies over the crank angle beside the computed ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmech.analyses.comparison.fit import Parameter
from flexmech.analyses.comparison.parameters import Fitted, with_stiffness
from flexmech.analyses.comparison.start import named, parameters_from, start_values
from flexmech.analyses.frequencies import natural_frequencies
from flexmech.errors import InputError
from flexmech.linear_system import Engine
from flexmech.types import FloatArray, IntArray

# Modes among which a record without their numbers is placed.
CANDIDATES = 6


def nearest_mode(
    engine: Engine, crank_speed: float, angle: FloatArray, frequency: FloatArray
) -> int:
    """Number of the mode, from 1, whose computed frequencies are nearest to measured ones.

    Parameters
    ----------
    engine : Engine
    crank_speed : float
        In rad/s.
    angle, frequency : ndarray, shape (N,)
        In rad and Hz.

    Returns
    -------
    int
    """
    computed = _frequencies(engine, crank_speed, angle, CANDIDATES)
    apart = np.abs(np.log(computed / frequency[:, None])).mean(axis=0)
    return int(apart.argmin()) + 1


@dataclass(frozen=True)
class FrequencyProblem:
    """Natural frequencies of modes at crank angles.

    Parameters
    ----------
    engine : Engine
        Of the mechanism as its model says.
    crank_speed : float
        In rad/s.
    angle : ndarray, shape (N,)
        In rad.
    mode : ndarray of int, shape (N,)
        From 1.
    record : ndarray, shape (N,)
        In Hz.
    fitted : Fitted
    """

    engine: Engine
    crank_speed: float
    angle: FloatArray
    mode: IntArray
    record: FloatArray
    fitted: Fitted

    def __post_init__(self) -> None:
        if self.fitted.damps:
            raise InputError(
                "fit: natural frequencies hardly change with damping and do not tell it; fit "
                "stiffness:LINK, or give a record over time or a frequency-response function"
            )
        if self.fitted.offset or self.fitted.gain:
            raise InputError("fit: frequencies have no offset and no gain; fit stiffness:LINK")

    @property
    def measured(self) -> FloatArray:
        """Record, (1, N)."""
        return self.record[None]

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """What is fitted, and from where."""
        return parameters_from(start_values(named(self.fitted), 1.0, self.misfit), 1.0)

    @property
    def linear_unknowns(self) -> int:
        """None."""
        return 0

    def computed(self, values: Sequence[float]) -> FloatArray:
        """Computed frequencies (1, N)."""
        return self._at(dict(zip(named(self.fitted), values, strict=True)))[None]

    def misfit(self, values: Mapping[str, float]) -> float:
        """Sum of squares of the residual for values by name."""
        return float(np.sum((self.record - self._at(values)) ** 2))

    def _at(self, values: Mapping[str, float]) -> FloatArray:
        engine = with_stiffness(self.engine, self.fitted.factors(values))
        found = _frequencies(engine, self.crank_speed, self.angle, int(self.mode.max()))
        return np.asarray(found[np.arange(len(self.angle)), self.mode - 1])


def _frequencies(engine: Engine, crank_speed: float, angle: FloatArray, modes: int) -> FloatArray:
    prestress = "equilibrium" if crank_speed else engine.prestress_at_rest
    return natural_frequencies(engine, angle, crank_speed, modes=modes, prestress=prestress)
