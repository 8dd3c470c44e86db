"""Designs whose properties scatter: percentiles and means of their outputs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError, one_line
from flexmech.studies.evaluation import MOST_LETTERS, STATUSES, Evaluated
from flexmech.studies.study import Study, sobol_points

# The probability that the k-th of n ordered values is not exceeded is (k - 1/2) / n, as of points
# that are spread evenly; other rules take the percentiles of few values too near to the median.
_RULE: Literal["hazen"] = "hazen"


@dataclass(frozen=True)
class Scatter:
    """Sample of a study's uncertain variables around every design that its search chooses.

    All designs have the same random numbers: two designs differ by what is chosen alone, and the
    goal is a continuous function of it.

    Parameters
    ----------
    study : Study
    probability : ndarray, shape (s, r)
        Probability of the values of the r uncertain variables.

    Raises
    ------
    InputError
        If nothing is left to choose.
    """

    study: Study
    probability: FloatArray

    @classmethod
    def of(cls, study: Study) -> Self:
        """Scatter of a study; of one in which nothing is uncertain, a sample of one."""
        uncertain = len(study.uncertain)
        if uncertain == len(study.variables):
            raise InputError(
                "vary: every variable has a distribution, and none is left to choose; give one of "
                "them range = [...] or values = [...]"
            )
        if not uncertain:
            return cls(study, np.ones((1, 0)))
        for one in study.correlations:
            for name in set(one.variables) - set(study.uncertain):
                raise InputError(
                    f"correlations: {name} is chosen by the search and cannot go with "
                    f"{' or '.join(set(one.variables) - {name})}; give it a distribution, or leave "
                    "the correlation out"
                )
        return cls(study, sobol_points(study.percentile_samples, uncertain, study.seed))

    @property
    def samples(self) -> int:
        """Runs of a design."""
        return len(self.probability)

    def designs(self, chosen: FloatArray) -> FloatArray:
        """Designs at probabilities of what is chosen, uncertain variables at their medians.

        Parameters
        ----------
        chosen : ndarray, shape (n, c)
            Between 0 and 1.

        Returns
        -------
        ndarray, shape (n, k)
        """
        point = np.full((len(chosen), len(self.study.variables)), 0.5)
        point[:, self._chosen] = chosen
        return self.study.at(point)

    def evaluated(
        self, designs: FloatArray, evaluate: Callable[[FloatArray], Evaluated]
    ) -> Evaluated:
        """Percentiles and means of the outputs of designs; a failing sample fails its design.

        Parameters
        ----------
        designs : ndarray, shape (n, k)
        evaluate : callable
            Gives the outputs of rows (n s, k).

        Returns
        -------
        Evaluated
        """
        if not self.study.uncertain:
            return evaluate(designs)
        found = evaluate(self._around(designs))
        shape = (len(designs), self.samples)
        status = found.status.reshape(shape)
        values = with_failures(self.study, found).reshape(*shape, -1)
        reasons, first = [""] * len(designs), np.zeros(len(designs), dtype=np.intp)
        for number in np.flatnonzero(np.isnan(values).any(axis=(1, 2))):
            sample = int(np.flatnonzero(status[number])[0])
            first[number] = status[number, sample]
            reason = found.reasons[number * self.samples + sample]
            failed = f"{np.count_nonzero(status[number])} of {self.samples} samples: {reason}"
            reasons[number] = one_line(failed, MOST_LETTERS)
        return Evaluated(self._statistics(values), first, reasons)

    def errors(
        self, designs: FloatArray, evaluate: Callable[[FloatArray], Evaluated]
    ) -> FloatArray:
        """Relative errors of the percentiles and means of one design by the number of samples.

        For percentiles it is half of the distance between the ordered values one standard deviation
        of their binomial count away on either side; points that are spread evenly are off by less.

        Parameters
        ----------
        designs : ndarray, shape (1, k)
        evaluate : callable

        Returns
        -------
        ndarray, shape (m,)
        """
        if not self.study.uncertain:
            return np.zeros(len(self.study.outputs))
        values = with_failures(self.study, evaluate(self._around(designs)))
        errors = []
        for name, column in zip(self.study.outputs, values.T, strict=True):
            part = self.study.percentiles.get(name)
            if part is None:
                error = column.std() / np.sqrt(self.samples)
                size = abs(column.mean())
            else:
                apart = np.sqrt(part * (100.0 - part) / self.samples)
                ends = np.clip([part - apart, part, part + apart], 0.0, 100.0)
                low, middle, high = np.percentile(column, ends, method=_RULE)
                error, size = (high - low) / 2, abs(middle)
            errors.append(error / (size or 1.0))
        return np.array(errors)

    @property
    def _chosen(self) -> list[int]:
        """Columns of the variables that are chosen."""
        random = self.study.uncertain
        return [number for number, name in enumerate(self.study.names) if name not in random]

    def _around(self, designs: FloatArray) -> FloatArray:
        """Every sample of every design, (n s, k)."""
        point = np.full((self.samples, len(self.study.variables)), 0.5)
        uncertain = np.setdiff1d(np.arange(point.shape[1]), self._chosen)
        point[:, uncertain] = self.probability
        rows = np.tile(self.study.at(point), (len(designs), 1))
        rows[:, self._chosen] = np.repeat(designs[:, self._chosen], self.samples, axis=0)
        return rows

    def _statistics(self, values: FloatArray) -> FloatArray:
        """Percentile or mean of every output, (n, m), from values (n, s, m)."""
        columns = []
        for number, name in enumerate(self.study.outputs):
            own, part = values[:, :, number], self.study.percentiles.get(name)
            columns.append(
                own.mean(axis=1) if part is None else np.percentile(own, part, axis=1, method=_RULE)
            )
        return np.stack(columns, axis=-1)


def with_failures(study: Study, found: Evaluated) -> FloatArray:
    """Outputs of designs (n, m) with what a failure is worth, where the study says it.

    Parameters
    ----------
    study : Study
    found : Evaluated

    Returns
    -------
    ndarray, shape (n, m)
        Not numbers where that is not said.
    """
    failed = found.status != 0
    values = found.values.copy()
    for number, name in enumerate(study.outputs):
        if name in study.failure_values:
            values[failed, number] = study.failure_values[name]
    return values


def causes_of(found: Evaluated) -> str:
    """How many designs failed for which cause."""
    counts = Counter(found.status.tolist())
    return ", ".join(
        f"{counts[code]} {name}" for code, name in enumerate(STATUSES) if code and counts[code]
    )
