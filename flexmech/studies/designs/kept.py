"""Designs of a search, kept as they are computed, so that it can be repeated from them."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.studies.designs.campaign import evaluate_all, study_content
from flexmech.studies.designs.evaluation import Evaluated
from flexmech.studies.designs.store import NAME, DesignStore
from flexmech.studies.designs.study import Study

# Designs of a task: a few workers share a population, and a search that is killed loses no more.
_TASK = 8

Outcome = tuple[FloatArray, int, str]


@dataclass
class KeptDesigns:
    """Designs that a search has computed, none twice, in a store where there is a folder.

    A search depends on its study alone: begun again, it asks for the same designs in the same
    order, and goes on where what is kept ends.

    Parameters
    ----------
    study : Study
    executor : concurrent.futures.Executor or None
    store : DesignStore or None
    """

    study: Study
    executor: Executor | None = None
    store: DesignStore | None = None
    _rows: list[FloatArray] = field(default_factory=list, repr=False)
    _known: dict[bytes, Outcome] = field(default_factory=dict, repr=False)
    _written: int = 0

    @classmethod
    def of(
        cls,
        study: Study,
        executor: Executor | None,
        folder: Path | None,
        *,
        resume: bool,
        most: int,
        content: dict[str, Any],
    ) -> Self:
        """Designs of a new search, or of one to go on with.

        Parameters
        ----------
        study : Study
        executor : concurrent.futures.Executor or None
        folder : Path or None
            Where the store is kept, if it is.
        resume : bool
            Whether to go on with the store that is there.
        most : int
            Designs that the search can ask for.
        content : dict
            What besides the study the search depends on.

        Returns
        -------
        KeptDesigns

        Raises
        ------
        InputError
            If the store is of another study or search.
        """
        if folder is None:
            return cls(study, executor)
        described = study_content(study, most) | content
        if not resume:
            store = DesignStore.create(folder / NAME, most, described, _TASK)
            return cls(study, executor, store)
        kept = cls(study, executor, DesignStore.reopen(folder / NAME, described))
        assert kept.store is not None
        kept._add(*kept.store.read())
        kept._written = len(kept._rows)
        return kept

    def __call__(self, designs: FloatArray) -> Evaluated:
        """Outputs of designs (n, k), computed where they are not known yet.

        Parameters
        ----------
        designs : ndarray, shape (n, k)

        Returns
        -------
        Evaluated
        """
        new = {row.tobytes(): row for row in designs if row.tobytes() not in self._known}
        if new:
            rows = np.array(list(new.values()))
            self._add(rows, evaluate_all(self.study, rows, executor=self.executor, task=_TASK))
            self._write(len(self._rows) - len(self._rows) % _TASK)
        return self._of(designs)

    @property
    def count(self) -> int:
        """Designs that are known."""
        return len(self._rows)

    def close(self) -> None:
        """Keep what fills no task of its own."""
        self._write(len(self._rows))

    def _add(self, designs: FloatArray, found: Evaluated) -> None:
        for row, *outcome in zip(designs, *found, strict=True):
            self._rows.append(row)
            self._known[row.tobytes()] = outcome[0], int(outcome[1]), outcome[2]

    def _write(self, end: int) -> None:
        """Keep the designs up to an end that are not kept yet, in whole tasks from the first."""
        if self.store is None:
            return
        for start in range(self._written - self._written % _TASK, end, _TASK):
            rows = np.array(self._rows[start : min(start + _TASK, end)])
            self.store.write(start // _TASK, rows, self._of(rows))
        self._written = max(self._written, end)

    def _of(self, designs: FloatArray) -> Evaluated:
        """What is known of designs."""
        values, status, reasons = zip(*(self._known[row.tobytes()] for row in designs), strict=True)
        return Evaluated(np.array(values), np.array(status, dtype=np.intp), list(reasons))
