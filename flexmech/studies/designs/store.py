"""Outputs of many designs in a Zarr store that an interrupted study can go on with."""

from __future__ import annotations

import hashlib
import json
import secrets
import shutil
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import InputError
from flexmech.files import FolderLock, given_path
from flexmech.studies.designs.evaluation import MOST_LETTERS, STATUSES, Evaluated

NAME = "designs.zarr"
INSTALL = "a study needs the extra packages of [study]: pip install 'flexmech[study]'"


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
        Of the store.
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
        # Of a name of its own: another run may begin in the same folder at the same moment.
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
