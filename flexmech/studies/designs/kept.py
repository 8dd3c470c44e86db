"""Designs of a search, kept as they are computed, so that it can be repeated from them."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np

from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.studies.designs.campaign import study_content
from flexmech.studies.designs.evaluation import Evaluated
from flexmech.studies.designs.store import NAME, DesignStore
from flexmech.studies.designs.study import Study
from flexmech.studies.designs.tasks import check_executor, computed_tasks

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
    progress : callable or None
        Called as ``progress(label, done, total)``.
    """

    study: Study
    executor: Executor | None = None
    store: DesignStore | None = None
    progress: LabelledProgress | None = None
    _asked: dict[bytes, Outcome] = field(default_factory=dict, repr=False)
    _stored: dict[bytes, Outcome] = field(default_factory=dict, repr=False)

    @classmethod
    def of(
        cls,
        study: Study,
        executor: Executor | None,
        folder: Path | None,
        *,
        progress: LabelledProgress | None = None,
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
        progress : callable, optional
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
        check_executor(executor)
        if folder is None:
            return cls(study, executor, None, progress)
        described = study_content(study, most) | content
        if not resume:
            store = DesignStore.create(folder / NAME, most, described)
            return cls(study, executor, store, progress)
        store = DesignStore.reopen(folder / NAME, described)
        kept = cls(study, executor, store, progress)
        kept._stored = _outcomes(*store.read())
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
        new = {row.tobytes(): row for row in designs if row.tobytes() not in self._asked}
        if new:
            self._compute(np.array(list(new.values())))
        values, status, reasons = zip(*(self._asked[row.tobytes()] for row in designs), strict=True)
        return Evaluated(np.array(values), np.array(status, dtype=np.intp), list(reasons))

    @property
    def count(self) -> int:
        """Designs that were asked for."""
        return len(self._asked)

    def close(self) -> None:
        """Let other runs have the store."""
        if self.store is not None:
            self.store.close()

    def _compute(self, rows: FloatArray) -> None:
        """Add designs in the order in which they are asked for, which is that of the store.

        What the store holds of them is not computed again.
        """
        start, keys = self.count, [row.tobytes() for row in rows]
        pending = np.array([n for n, key in enumerate(keys) if key not in self._stored], dtype=int)
        tasks = computed_tasks(
            self.study, rows, pending, self.executor, self._report(start), "search"
        )
        for numbers, found in tasks:
            if self.store is not None:
                self.store.write(start + int(numbers[0]), rows[numbers], found)
            self._stored |= _outcomes(rows[numbers], found)
        self._asked |= {key: self._stored[key] for key in keys}

    def _report(self, before: int) -> LabelledProgress | None:
        """Progress that counts designs asked for before."""
        report = self.progress
        if report is None:
            return None
        return lambda label, done, total: report(label, before + done, before + total)


def _outcomes(designs: FloatArray, found: Evaluated) -> dict[bytes, Outcome]:
    """What is found of each design."""
    rows = zip(designs, found.values, found.status.tolist(), found.reasons, strict=True)
    return {row.tobytes(): (values, status, reason) for row, values, status, reason in rows}
