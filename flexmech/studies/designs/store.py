"""Outputs of many designs in a Zarr store that an interrupted study can go on with."""

from __future__ import annotations

import hashlib
import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.files import given_path
from flexmech.studies.designs.evaluation import MOST_LETTERS, STATUSES, Evaluated

NAME = "designs.zarr"
INSTALL = "a study needs the extra packages of [study]: pip install 'flexmech[study]'"


@dataclass(frozen=True)
class DesignStore:
    """Numbers, statuses and reasons of designs, chunk by chunk.

    A chunk is one task, whatever the number of workers; its mark, the number of its designs that
    are done, is written after it. Neither time nor host nor path is in it, so that a study that
    was interrupted ends with the same bytes.

    Parameters
    ----------
    folder : Path
        Of the store.
    chunk : int
        Designs of a task.
    """

    folder: Path
    chunk: int

    @classmethod
    def create(cls, folder: Path, count: int, content: dict[str, Any], chunk: int) -> Self:
        """Make a store with its full shape, whole or not at all.

        Parameters
        ----------
        folder : Path
            Whatever is there is removed.
        count : int
            Designs that it has room for.
        content : dict
            What the study is: names, units, seed, versions.
        chunk : int

        Returns
        -------
        DesignStore
        """
        zarr = import_zarr()
        # Moved away at once: a folder that is half removed would look like a store to go on with.
        new = folder.with_name(f".{folder.name}.new")
        for left in (new, old := folder.with_name(f".{folder.name}.old")):
            shutil.rmtree(left, ignore_errors=True)
        columns, tasks = len(content["variables"]) + len(content["outputs"]), -(-count // chunk)
        group = zarr.create_group(store=new, attributes={**content, "statuses": list(STATUSES)})
        for name, kind, shape in (
            ("numbers", "f8", (columns,)),
            ("status", "i2", ()),
            ("reasons", "u1", (MOST_LETTERS,)),
        ):
            group.create_array(
                name,
                shape=(count, *shape),
                chunks=(chunk, *shape),
                dtype=kind,
            )
        group.create_array("done", shape=(tasks,), chunks=(1,), dtype="i4", fill_value=0)
        if folder.exists():
            folder.rename(old)
        new.rename(folder)
        shutil.rmtree(old, ignore_errors=True)
        return cls(folder, chunk)

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
            kept, chunk = dict(group.attrs), int(group["numbers"].chunks[0])
        except Exception as error:
            raise InputError(
                f"{folder}: is no store of a study that can be gone on with; use --force to begin "
                "again"
            ) from error
        now = json.loads(json.dumps({**content, "statuses": list(STATUSES)}))
        for name in (*now, *kept):
            if kept.get(name) != now.get(name):
                raise InputError(
                    f"{folder}: is of another study: {name} is {_short(kept.get(name))} there and "
                    f"{_short(now.get(name))} now; use --force to begin again, or another folder"
                )
        # A killed process leaves what it was writing under another name.
        for left in folder.rglob("*.partial"):
            left.unlink()
        for left in folder.parent.glob(f".{folder.name}.*"):
            shutil.rmtree(left)
        return cls(folder, chunk)

    def _group(self) -> Any:
        return import_zarr().open_group(store=self.folder, mode="r+")

    def pending(self) -> list[int]:
        """Numbers of the tasks that are not done."""
        return np.flatnonzero(self._group()["done"][:] == 0).tolist()

    def write(self, task: int, designs: FloatArray, found: Evaluated) -> None:
        """Write a task, and mark it as done.

        Parameters
        ----------
        task : int
        designs : ndarray, shape (n, k)
            Of the task.
        found : Evaluated
        """
        start = task * self.chunk
        where = slice(start, start + len(designs))
        # Chunks of nothing but zeros too, as of statuses: no store tells an array to keep them.
        with import_zarr().config.set({"array.write_empty_chunks": True}):
            group = self._group()
            group["numbers"][where] = np.concatenate([designs, found.values], axis=1)
            group["status"][where] = found.status
            group["reasons"][where] = _as_bytes(found.reasons)
            group["done"][task : task + 1] = len(designs)

    def read(self) -> tuple[FloatArray, Evaluated]:
        """All designs (n, k) that are done, and their outputs."""
        group = self._group()
        done = np.arange(self.chunk) < np.asarray(group["done"][:])[:, None]
        kept = np.flatnonzero(done.ravel())
        # Tasks are done one after the other in a search: the rest of its room is not read.
        end = int(kept[-1]) + 1 if len(kept) else 0
        numbers, status, letters = (
            np.asarray(group[name][:end])[kept] for name in ("numbers", "status", "reasons")
        )
        inputs = len(group.attrs["variables"])
        reasons = [bytes(row).rstrip(b"\0").decode() for row in letters]
        status = status.astype(np.intp)
        return numbers[:, :inputs], Evaluated(numbers[:, inputs:], status, reasons)


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
        raise InputError(INSTALL) from error
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
