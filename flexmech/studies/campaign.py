"""Designs given to workers, and kept as they come back.

Outputs stand in a Zarr store with which an interrupted study goes on, and from which a search can
be repeated.
"""

from __future__ import annotations

import hashlib
import json
import os
import secrets
import shutil
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field
from multiprocessing import get_context, parent_process
from pathlib import Path
from threading import Thread
from typing import Any, Self

import numpy as np

from flexmech.analyses.datasets import versions
from flexmech.arrays import FloatArray, IntArray, LabelledProgress
from flexmech.errors import InputError, missing_extra
from flexmech.files import FolderLock, given_path
from flexmech.studies.evaluation import MOST_LETTERS, STATUSES, Evaluated
from flexmech.studies.study import Study
from flexmech.studies.tasks import check_executor, computed_tasks, gathered

NAME = "designs.zarr"


# Designs of a chunk: a file each of numbers, statuses, reasons and marks.
_CHUNK = 256


@dataclass(frozen=True)
class DesignStore:
    """Numbers, statuses and reasons of designs.

    Each design has its mark, which is written after it. Neither time nor host nor path is in the
    store, nor which designs were a task, so that a study that was interrupted ends with the same
    bytes. One run at a time writes it, from when it is opened until it is closed.

    Parameters
    ----------
    folder : Path
        Folder of the store.
    lock : FolderLock
    """

    folder: Path
    lock: FolderLock

    @classmethod
    def create(cls, folder: Path, count: int, content: dict[str, Any]) -> Self:
        """Make a store with its full shape, whole or not at all.

        Parameters
        ----------
        folder : Path
            Whatever is there is removed.
        count : int
            Designs that it has room for.
        content : dict
            What the study is: names, units, seed, versions.

        Returns
        -------
        DesignStore

        Raises
        ------
        InputError
            If another run writes a store there.
        """
        zarr = import_zarr()
        folder.parent.mkdir(parents=True, exist_ok=True)
        earlier = _locked(folder) if folder.exists() else None
        _remove_left(folder)
        # The new folder has its own name: another run may begin in the same folder at the same
        # moment.
        new = folder.with_name(f".{folder.name}.{secrets.token_hex(4)}")
        new.mkdir()
        lock = _locked(new)
        group = zarr.create_group(store=new, attributes={**content, "statuses": list(STATUSES)})
        columns = len(content["variables"]) + len(content["outputs"])
        for name, kind, shape in (
            ("numbers", "f8", (columns,)),
            ("status", "i2", ()),
            ("reasons", "u1", (MOST_LETTERS,)),
            ("done", "u1", ()),
        ):
            group.create_array(
                name, shape=(count, *shape), chunks=(_CHUNK, *shape), dtype=kind, fill_value=0
            )
        if earlier is not None:
            # Moved away at once: a folder that is half removed would look like a store to go on
            # with.
            folder.rename(old := new.with_name(f"{new.name}.old"))
            shutil.rmtree(old, ignore_errors=True)
            earlier.release()
        try:
            new.rename(folder)
        except OSError as error:
            shutil.rmtree(new, ignore_errors=True)
            raise InputError(_taken(folder)) from error
        return cls(folder, lock)

    @classmethod
    def reopen(cls, folder: Path, content: dict[str, Any]) -> Self:
        """Open a store to go on with it.

        Parameters
        ----------
        folder : Path
        content : dict
            What the study is now.

        Returns
        -------
        DesignStore

        Raises
        ------
        InputError
            If it is of another study, model or version; names the difference.
        """
        zarr = import_zarr()
        try:
            group = zarr.open_group(store=folder, mode="r+")
            kept = dict(group.attrs)
            whole = group["done"].shape == group["status"].shape
        except Exception as error:
            raise InputError(
                f"{folder}: is no store of a study that can be gone on with; use --force to begin "
                "again"
            ) from error
        if not whole:
            raise InputError(
                f"{folder}: is of an earlier version of flexmech; use --force to begin again, or "
                "another folder"
            )
        now = json.loads(json.dumps({**content, "statuses": list(STATUSES)}))
        for name in (*now, *kept):
            if kept.get(name) != now.get(name):
                raise InputError(
                    f"{folder}: is of another study: {name} is {_short(kept.get(name))} there and "
                    f"{_short(now.get(name))} now; use --force to begin again, or another folder"
                )
        lock = _locked(folder)
        # A killed process leaves what it was writing under another name.
        for left in folder.rglob("*.partial"):
            left.unlink()
        _remove_left(folder)
        return cls(folder, lock)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()

    def close(self) -> None:
        """Let other runs have it."""
        self.lock.release()

    def _group(self) -> Any:
        return import_zarr().open_group(store=self.folder, mode="r+")

    def pending(self) -> IntArray:
        """Numbers of the designs that are not done."""
        return np.flatnonzero(self._group()["done"][:] == 0)

    def write(self, start: int, designs: FloatArray, found: Evaluated) -> None:
        """Write designs, and mark them as done.

        Parameters
        ----------
        start : int
            Number of the first of them.
        designs : ndarray, shape (n, k)
            One after the other.
        found : Evaluated
        """
        where = slice(start, start + len(designs))
        # Chunks of nothing but zeros too, as of statuses: no store tells an array to keep them.
        with import_zarr().config.set({"array.write_empty_chunks": True}):
            group = self._group()
            group["numbers"][where] = np.concatenate([designs, found.values], axis=1)
            group["status"][where] = found.status
            group["reasons"][where] = _as_bytes(found.reasons)
            group["done"][where] = 1

    def read(self) -> tuple[FloatArray, Evaluated]:
        """All designs (n, k) that are done, and their outputs."""
        group = self._group()
        kept = np.flatnonzero(group["done"][:])
        # Designs are done one after the other in a search: the rest of its room is not read.
        end = int(kept[-1]) + 1 if len(kept) else 0
        numbers, status, letters = (
            np.asarray(group[name][:end])[kept] for name in ("numbers", "status", "reasons")
        )
        inputs = len(group.attrs["variables"])
        reasons = [bytes(row).rstrip(b"\0").decode() for row in letters]
        status = status.astype(np.intp)
        return numbers[:, :inputs], Evaluated(numbers[:, inputs:], status, reasons)


def _locked(folder: Path) -> FolderLock:
    try:
        return FolderLock(folder)
    except BlockingIOError as error:
        raise InputError(_taken(folder)) from error


def _taken(folder: Path) -> str:
    return (
        f"{folder}: another run writes its designs there; wait until it has ended, or choose "
        "another folder"
    )


def _remove_left(folder: Path) -> None:
    """Remove stores that killed runs have begun or moved away: nobody holds their lock."""
    for left in folder.parent.glob(f".{folder.name}.*"):
        with suppress(BlockingIOError):
            lock = FolderLock(left)
            shutil.rmtree(left, ignore_errors=True)
            lock.release()


def folder_of_designs(folder: Path | None, *, resume: bool, force: bool) -> Path | None:
    """Folder in which a study keeps its designs.

    Parameters
    ----------
    folder : Path or None
    resume : bool
        Whether to go on with the designs that are there.
    force : bool
        Whether to begin again.

    Returns
    -------
    Path or None

    Raises
    ------
    InputError
        If there are designs and neither is wanted, or none to go on with.
    """
    if folder is None:
        return None
    there = (given_path(folder) / NAME).exists()
    if there and not (resume or force):
        raise InputError(
            f"{folder / NAME}: holds designs already; go on with --resume, or use --force"
        )
    if resume and not there:
        raise InputError(f"--resume: there is no {folder / NAME} to go on with; leave it out")
    return given_path(folder)


def digest(text: str) -> str:
    """SHA-256 of a text."""
    return hashlib.sha256(text.encode()).hexdigest()


def import_zarr() -> Any:
    """The library of the store.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        import zarr
    except ImportError as error:
        raise missing_extra("a study", "zarr", "study") from error
    return zarr


def _as_bytes(reasons: list[str]) -> Any:
    """Texts as bytes of UTF-8, cut to the room they have, (n, MOST_LETTERS)."""
    room = np.zeros((len(reasons), MOST_LETTERS), dtype=np.uint8)
    for row, reason in zip(room, reasons, strict=True):
        text = reason.encode()[:MOST_LETTERS].decode(errors="ignore").encode()
        row[: len(text)] = np.frombuffer(text, dtype=np.uint8)
    return room


def _short(value: object) -> str:
    text = json.dumps(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


# In s, for a scheduler to answer.
_PATIENCE = "10s"


def evaluate_all(
    study: Study,
    designs: FloatArray,
    *,
    executor: Executor | None = None,
    progress: LabelledProgress | None = None,
    folder: Path | None = None,
    resume: bool = False,
    content: dict[str, Any] | None = None,
) -> Evaluated:
    """Outputs of designs, by workers where there are some, and kept where there is a folder.

    Parameters
    ----------
    study : Study
    designs : ndarray, shape (n, k)
    executor : concurrent.futures.Executor, optional
        Any: of processes on this machine, of Dask, executorlib, Parsl or MPI. Left out: this
        process.
    progress : callable, optional
        Called as ``progress(label, done, total)``.
    folder : Path, optional
        Where the store of the designs is kept.
    resume : bool
        Whether to go on with a store that is there.
    content : dict, optional
        What else the study is, for the store.

    Returns
    -------
    Evaluated

    Raises
    ------
    InputError
        If the executor is none, the store is of another study, or another run writes it.
    ComputationError
        If a worker was killed.
    """
    check_executor(executor)
    every = np.arange(len(designs))
    if folder is None:
        return gathered(study, designs, computed_tasks(study, designs, every, executor, progress))
    described = study_content(study, len(designs)) | (content or {})
    if resume:
        store = DesignStore.reopen(folder / NAME, described)
    else:
        store = DesignStore.create(folder / NAME, len(designs), described)
    with store:
        for numbers, found in computed_tasks(study, designs, store.pending(), executor, progress):
            store.write(int(numbers[0]), designs[numbers], found)
        return store.read()[1]


def study_content(study: Study, count: int) -> dict[str, Any]:
    """Content of a study, in a form that a store keeps and compares.

    Parameters
    ----------
    study : Study
    count : int
        Number of designs.

    Returns
    -------
    dict
        Its variables and outputs with their units, its seed, the digest of the model, versions.
    """
    varied = {
        f"vary.{variable.name}": [variable.distribution, variable.numbers, variable.keys]
        + [variable.steps] * (variable.distribution == "range")
        for variable in study.variables
    }
    # The version of the engine's library too, which alone computes the numbers of that engine.
    packages = ("exudyn",) if study.engine == "exudyn" else ()
    return {
        "model": digest(study.mechanism.to_toml()),
        "designs": count,
        "seed": study.seed,
        "engine": study.engine,
        "variables": study.names,
        **varied,
        "outputs": list(study.outputs),
        **{f"outputs.{name}": asdict(output) for name, output in study.outputs.items()},
        "correlations": [[*one.variables, one.coefficient] for one in study.correlations],
        "units": [variable.unit for variable in study.variables]
        + [output.dimension.unit for output in study.outputs.values()],
        **versions(*packages),
    }


@contextmanager
def workers(count: int = 1, cluster: str | None = None) -> Iterator[Executor | None]:
    """Workers of this machine, or of a Dask cluster.

    Parameters
    ----------
    count : int
        Processes on this machine; one computes in this process.
    cluster : str, optional
        Address of the scheduler, such as ``tcp://scheduler:8786``.

    Yields
    ------
    concurrent.futures.Executor or None

    Raises
    ------
    InputError
        If the extra is not installed, or no scheduler answers.
    """
    if cluster is not None:
        try:
            import distributed
        except ImportError as error:
            raise missing_extra("--cluster", "distributed", "cluster") from error
        try:
            # Not the default one: xarray would lock the files it writes here by way of the cluster.
            client: Any = distributed.Client(  # type: ignore[no-untyped-call]
                cluster, timeout=_PATIENCE, set_as_default=False
            )
        except (OSError, ValueError) as error:
            raise InputError(
                f"--cluster {cluster}: no scheduler answers there; start one with 'dask "
                "scheduler', and workers with 'dask worker', in an environment that has flexmech"
            ) from error
        with client:
            yield client.get_executor()
    elif count > 1:
        # A fork would copy the threads of libraries in whatever state they are.
        with ProcessPoolExecutor(count, get_context("spawn"), _end_with_parent) as pool:
            yield pool
    else:
        yield None


def _end_with_parent() -> None:
    """Let a worker end if the process that gives it tasks is killed; it would wait for ever."""
    if (parent := parent_process()) is None:
        return

    def wait_for_it() -> None:
        parent.join()
        os._exit(1)

    Thread(target=wait_for_it, daemon=True).start()


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
    """Results of each design."""
    rows = zip(designs, found.values, found.status.tolist(), found.reasons, strict=True)
    return {row.tobytes(): (values, status, reason) for row, values, status, reason in rows}
