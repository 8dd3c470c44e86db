"""Reading model files: bytes, TOML, tables, mechanism; and commented ones to start from."""

from __future__ import annotations

import hashlib
import os
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from flexmech.errors import InputError
from flexmech.files import bytes_of, given_path
from flexmech.linkages import PlanarLinkage
from flexmech.mechanism import Mechanism, Provenance
from flexmech.modelfile.build import build_mechanism
from flexmech.modelfile.document import ModelFile
from flexmech.modelfile.linkage_tables import PlanarTable
from flexmech.modelfile.messages import Findings, input_error, refuse_unseen_characters
from flexmech.modelfile.placing import TwoPlaces, placed_points
from flexmech.validation import check_instance

MOST_BYTES = 10_000_000
"""Of a model file or a study: a hundred times the longest tables that are written in one."""


def load_mechanism(path: str | os.PathLike[str]) -> Mechanism:
    """Mechanism of a model file.

    Parameters
    ----------
    path : path-like
        A TOML file; see :func:`flexmech.modelfile.template` for what it may hold.

    Returns
    -------
    Mechanism
        With the file's base name and the SHA-256 of its bytes as provenance.

    Raises
    ------
    InputError
        If there is no such file, it cannot be read or is not TOML in UTF-8, or a value is
        wrong. The message names the file, the dotted key, what was got, and the remedy.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> mechanism.linkage
    FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667, branch='open')
    >>> print(mechanism.to_toml().splitlines()[0])
    name = "aluminium four-bar"
    """
    file = given_path(path)
    shown = os.fspath(path)
    if file.is_dir():
        raise InputError(f"{shown}: is a folder; name a model file, such as model.toml, in it")
    if not file.exists():
        raise InputError(
            f"{shown}: there is no such file; check the path, or write a new model file with "
            "'flexmech new four-bar FILE'"
        )
    try:
        content = bytes_of(file, shown, "a model file", MOST_BYTES)
    except OSError as error:
        raise InputError(
            f"{shown}: cannot be read ({error.strerror}); check the file's permissions"
        ) from error
    try:
        # A byte-order mark, as some Windows editors write it, is not part of the text.
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise InputError(
            f"{shown}: line {line} is not UTF-8 text; save the file with UTF-8 encoding"
        ) from error
    # A name that is no text in the file system's encoding keeps what can be read of it.
    name = os.fsencode(file.name).decode(errors="replace")
    return _mechanism(text, shown, name, hashlib.sha256(content).hexdigest(), file.parent)


def mechanism_from_toml(text: str, name: str = "model.toml") -> Mechanism:
    """Mechanism of a model file's text.

    Parameters
    ----------
    text : str
        TOML.
    name : str
        What error messages and the provenance call it.

    Returns
    -------
    Mechanism

    Raises
    ------
    InputError
        As :func:`load_mechanism`.
    """
    check_instance(text, str, "text", "give the text of a model file; read files by load_mechanism")
    return _mechanism(text, name, name, hashlib.sha256(text.encode()).hexdigest())


def twofold_points(mechanism: Mechanism) -> tuple[TwoPlaces, ...]:
    """Points that lengths in a mechanism's model file place in two ways, of which one was taken.

    Parameters
    ----------
    mechanism : Mechanism

    Returns
    -------
    tuple of TwoPlaces
        Empty where it is from no file, or was changed since.
    """
    text = mechanism.provenance.text
    if not text or not isinstance(mechanism.linkage, PlanarLinkage):
        return ()
    tables = ModelFile(**tomllib.loads(text))
    if not isinstance(tables.linkage, PlanarTable):
        return ()
    placed = placed_points(tables, tables.linkage, Findings(mechanism.provenance.file))
    return placed.twofold if placed.points == mechanism.linkage.points else ()


def json_schema() -> dict[str, Any]:
    """JSON schema (draft 2020-12) of model files, for editors that complete and check TOML.

    Returns
    -------
    dict
        What the schema cannot say, such as which links a linkage has or that the lengths
        close, is checked by :func:`load_mechanism` alone.
    """
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **ModelFile.model_json_schema(),
        "title": "flexmech model file",
    }


def _mechanism(text: str, shown: str, file: str, sha256: str, folder: Path = Path()) -> Mechanism:
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(
            f"{shown}: is not valid TOML: {error}; values with a unit stand in quotes, as in "
            'crank = "100 mm"'
        ) from error
    refuse_unseen_characters(data, shown)
    try:
        tables = ModelFile.model_validate(data)
    except ValidationError as error:
        raise input_error(error, data, shown) from error
    provenance = Provenance(tables.name, tables.source, file, sha256, text)
    mechanism = build_mechanism(tables, shown, provenance, folder)
    drawn_from_file = tables.drive is not None and isinstance(tables.drive.table, str)
    if drawn_from_file or any(load.file is not None for load in tables.loads.values()):
        # The text alone has to say it all: the files beside it may be gone when it is read again.
        stated = replace(provenance, text=mechanism.to_toml())
        return replace(mechanism, provenance=stated)
    return mechanism
