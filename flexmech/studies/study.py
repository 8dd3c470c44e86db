"""A study of designs: what varies, what is computed, what limits it, what it aims at."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, Self

import numpy as np
import scipy

from flexmech.analyses.parameters import Parameters
from flexmech.arrays import FloatArray
from flexmech.choices import MOST_SEED, EngineName
from flexmech.errors import InputError, suggestion
from flexmech.mechanism import Mechanism
from flexmech.studies.outputs import Output
from flexmech.studies.variables import Variable
from flexmech.validation import Bounds, check_count, check_number

Sense = Literal["min", "max"]
# What datasets and tables of studies call their own variables and dimensions.
_RESERVED = {
    *("design", "status", "reason", "within", "violation", "output", "relative_error", "input"),
    *("mean", "std", "p2_5", "p50", "p97_5", "median_error", "failure_probability"),
    *(f"{index}{end}" for index in ("first_order", "total") for end in ("", "_low", "_high")),
    *("goal", "step", "history", "evaluations", "checked", "checking_engine"),
}
# Names are columns of tables, variables of stored results and words of lists.
_NAME = r"[\w.-]+"
MOST_DESIGNS = 10_000_000
"""Most designs of a study: more are a slip of the keyboard."""


@dataclass(frozen=True)
class Limit:
    """A bound that an output must keep.

    Parameters
    ----------
    output : str
    least, greatest : float
        In SI units; infinite where there is none.
    percentile : float, optional
        Percentile of the output over the uncertain variables that keeps it, in the search for the
        best design; the mean if left out.
    """

    output: str
    least: float = -np.inf
    greatest: float = np.inf
    percentile: float | None = None

    def margin(self, value: FloatArray) -> FloatArray:
        """By how much values keep the bound, over its size; negative where they do not."""
        bound = self.least if np.isfinite(self.least) else self.greatest
        kept = np.minimum(value - self.least, self.greatest - value)
        return np.asarray(kept / (abs(bound) or 1.0))

    def violation(self, value: FloatArray) -> FloatArray:
        """By how much values are beyond the bound, over the size of the bound; zero within."""
        return np.asarray(np.maximum(-self.margin(value), 0.0))


@dataclass(frozen=True)
class Goal:
    """An output that is to be as small or as great as can be.

    Parameters
    ----------
    output : str
    sense : {"min", "max"}
    percentile : float, optional
        Percentile of the output over the uncertain variables that is to be so; the mean if left
        out.
    """

    output: str
    sense: Sense = "min"
    percentile: float | None = None

    @property
    def sign(self) -> float:
        """Factor, 1 or -1, that makes the smaller value the better one."""
        return 1.0 if self.sense == "min" else -1.0


@dataclass(frozen=True)
class Correlation:
    """Correlation of two variables with distributions, by the normal copula.

    Parameters
    ----------
    variables : tuple of (str, str)
    coefficient : float
        Between -1 and 1, of the normal variables behind them.
    """

    variables: tuple[str, str]
    coefficient: float


@dataclass(frozen=True)
class Study:
    """Designs of one mechanism, and what is asked of them.

    Parameters
    ----------
    mechanism : Mechanism
        That of the model file.
    variables : tuple of Variable
    outputs : mapping of str to Output
    seed : int
        Seed of samples.
    limits : tuple of Limit
    goals : tuple of Goal
    correlations : tuple of Correlation
    engine : {"reference", "exudyn"}
    failure_values : mapping of str to float
        Value in SI units that an output counts as where a design cannot be computed.
    percentile_samples : int
        A power of two: runs of every design in the search for the best where variables have
        distributions.

    Raises
    ------
    InputError
        If nothing varies or is computed, a limit or goal names no output, the model cannot have a
        value, or percentiles are of nothing that is uncertain or of too few samples.
    """

    mechanism: Mechanism
    variables: tuple[Variable, ...]
    outputs: Mapping[str, Output]
    seed: int = 1
    limits: tuple[Limit, ...] = ()
    goals: tuple[Goal, ...] = ()
    correlations: tuple[Correlation, ...] = ()
    engine: EngineName = "reference"
    failure_values: Mapping[str, float] = field(default_factory=dict)
    percentile_samples: int = 64

    def __post_init__(self) -> None:
        if not self.variables:
            raise InputError("vary: nothing varies; name a quantity of the model and its range")
        if not self.outputs:
            raise InputError("outputs: nothing is computed; name an output")
        check_count(self.seed, "seed", least=0, most=MOST_SEED)
        for name in (*self.outputs, *self.names):
            if name in _RESERVED or not re.fullmatch(_NAME, name):
                raise InputError(
                    f"{name!r} cannot be the name of a variable or output: results have one of "
                    "their own, or it is not of letters, digits and . _ - alone; rename it (a "
                    "variable has its keys in paths = [...] then)"
                )
        both = sorted(set(self.outputs) & set(self.names))
        if both:
            raise InputError(f"{', '.join(both)}: is a variable and an output; rename one")
        keys = [key for variable in self.variables for key in variable.keys]
        twice = sorted({key for key in keys if keys.count(key) > 1})
        if twice:
            raise InputError(f"vary: {', '.join(twice)} varies twice; name it in one variable")
        for table, names in (
            ("limits", [limit.output for limit in self.limits]),
            ("goals", [goal.output for goal in self.goals]),
            ("failure_values", list(self.failure_values)),
        ):
            for name in names:
                try:
                    known_output(self.outputs, name)
                except InputError as error:
                    raise error.within(table) from error
        if self.correlations:
            self._correlated()
        check_power_of_two(self.percentile_samples, "percentile_samples", least=8)
        for name, part in self.percentiles.items():
            self._check_percentile(name, part)
        for variable in self.variables:
            variable.check(self.parameters)

    def with_(self, seed: int | None = None, engine: EngineName | None = None) -> Self:
        """The study with another seed or engine, where one is given."""
        return replace(self, seed=self.seed if seed is None else seed, engine=engine or self.engine)

    @cached_property
    def parameters(self) -> Parameters:
        """Quantities of the mechanism that can vary."""
        return Parameters.of(self.mechanism)

    @property
    def names(self) -> list[str]:
        """Names of the variables."""
        return [variable.name for variable in self.variables]

    @property
    def uncertain(self) -> list[str]:
        """Names of the variables that have a distribution, and are not chosen."""
        return [variable.name for variable in self.variables if variable.is_random]

    @property
    def percentiles(self) -> dict[str, float]:
        """Percentile of each output whose goals and limits state one; others count by the mean."""
        asked: dict[str, float | None] = {}
        each: tuple[Goal | Limit, ...] = (*self.goals, *self.limits)
        for one in each:
            if asked.setdefault(one.output, one.percentile) != one.percentile:
                raise InputError(
                    f"percentile: that of {one.output} differs among its goals and limits; give "
                    "the quantity a second name in outputs"
                )
        return {name: part for name, part in asked.items() if part is not None}

    def _check_percentile(self, name: str, part: float) -> None:
        """Refuse a percentile that nothing is spread over, or that few samples tell nothing of."""
        check_number(part, f"percentile of {name}", bounds=Bounds(above=0.0, below=100.0))
        if not self.uncertain:
            raise InputError(
                f"percentile = {part:g} of {name}: nothing is uncertain; give a variable normal, "
                "lognormal or uniform = [...], or leave percentile out"
            )
        least = 100.0 / min(part, 100.0 - part)
        if self.percentile_samples < least:
            enough = 1 << math.ceil(math.log2(least))
            raise InputError(
                f"percentile_samples = {self.percentile_samples} are too few for percentile = "
                f"{part:g} of {name}; take {enough} or more"
            )

    def combinations(self) -> FloatArray:
        """Every combination of the variables' values.

        Returns
        -------
        ndarray, shape (n, k)
            Values in SI units; texts by their places in the list. The last variable changes
            fastest.

        Raises
        ------
        InputError
            If there are too many, or a variable has a distribution without ends.
        """
        count = math.prod(variable.count for variable in self.variables)
        if count > MOST_DESIGNS:
            raise InputError(
                f"vary: {count} combinations are too many; take fewer steps, or a sample"
            )
        every = [variable.every() for variable in self.variables]
        grid = np.meshgrid(*every, indexing="ij")
        return np.stack([values.ravel() for values in grid], axis=-1)

    def sample(self, count: int) -> FloatArray:
        """Designs spread evenly over the variables' ranges and distributions.

        Sobol's sequence, scrambled by the seed (Owen 1998; ``scipy.stats.qmc.Sobol``): a design
        depends on the seed and its number alone.

        Parameters
        ----------
        count : int
            A power of two keeps the sample balanced.

        Returns
        -------
        ndarray, shape (count, k)
        """
        check_count(count, "samples", most=MOST_DESIGNS)
        return self.at(sobol_points(count, len(self.variables), self.seed))

    def at(self, probability: FloatArray) -> FloatArray:
        """Designs at the probabilities of their variables.

        Parameters
        ----------
        probability : ndarray, shape (n, k)
            Evenly distributed between 0 and 1.

        Returns
        -------
        ndarray, shape (n, k)
        """
        if self.correlations:
            standard = scipy.special.ndtri(probability) @ self._correlated().T
            probability = scipy.special.ndtr(standard)
        columns = [variable.at(probability[:, k]) for k, variable in enumerate(self.variables)]
        return np.stack(columns, axis=-1)

    def _correlated(self) -> FloatArray:
        """Root of the matrix of correlations, (k, k)."""
        matrix = np.eye(len(self.variables))
        for one in self.correlations:
            for name in one.variables:
                if name not in self.names:
                    raise InputError(
                        f"correlations: there is no variable {name!r}; "
                        f"{suggestion(name, self.names)}"
                    )
            first, second = (self.names.index(name) for name in one.variables)
            if first == second or matrix[first, second]:
                raise InputError(
                    f"correlations: {' and '.join(one.variables)} need one coefficient, of two "
                    "variables; leave the other out"
                )
            matrix[first, second] = matrix[second, first] = one.coefficient
        try:
            return np.asarray(np.linalg.cholesky(matrix))
        except np.linalg.LinAlgError as error:
            raise InputError(
                "correlations: no variables can be correlated so; the matrix of coefficients "
                "must be positive definite"
            ) from error


def check_power_of_two(samples: int, name: str, least: int) -> None:
    """Refuse a number of samples that leaves Sobol's sequence unbalanced.

    Parameters
    ----------
    samples : int
    name : str
        What messages call it.
    least : int

    Raises
    ------
    InputError
    """
    check_count(samples, name, least=least)
    if samples & (samples - 1):
        near = 1 << samples.bit_length()
        raise InputError(f"{name}: {samples} is no power of two; take {near // 2} or {near}")


def known_output(outputs: Mapping[str, Output], name: str) -> Output:
    """The output of a name.

    Parameters
    ----------
    outputs : mapping of str to Output
    name : str

    Returns
    -------
    Output

    Raises
    ------
    InputError
        If there is none; names the nearest.
    """
    if name not in outputs:
        raise InputError(f"there is no output {name!r}; {suggestion(name, list(outputs))}")
    return outputs[name]


def sobol_points(count: int, variables: int, seed: int) -> FloatArray:
    """Points of a scrambled Sobol sequence inside the unit cube.

    Parameters
    ----------
    count : int
    variables : int
    seed : int

    Returns
    -------
    ndarray, shape (count, variables)
    """
    generator = scipy.stats.qmc.Sobol(variables, scramble=True, seed=np.random.default_rng(seed))
    points = np.concatenate(
        [generator.random(min(part, count - start)) for start, part in _powers(count)]
    )
    return np.asarray(np.clip(points, np.finfo(float).tiny, 1 - np.finfo(float).eps))


def _powers(count: int) -> Sequence[tuple[int, int]]:
    """Starts and lengths of parts, each a power of two as the sequence wants them."""
    parts, start = [], 0
    while start < count:
        size = start or 1
        parts.append((start, size))
        start += size
    return parts
