"""Reading model files: bytes, TOML, tables, mechanism; and commented ones to start from.

Dotted keys name the quantities of a model file; with some of them changed it gives another
mechanism.
"""

from __future__ import annotations

import hashlib
import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Self, get_args, get_origin

from pydantic import BaseModel, ValidationError

from flexmech import si
from flexmech.errors import InputError, suggestion
from flexmech.files import bytes_of, given_path
from flexmech.linkages import PlanarLinkage
from flexmech.mechanism import Mechanism, Provenance
from flexmech.model_text import quantity
from flexmech.modelfile.build import build_mechanism
from flexmech.modelfile.document import ModelFile
from flexmech.modelfile.linkage_tables import PlanarTable
from flexmech.modelfile.messages import Findings, input_error, refuse_unseen_characters
from flexmech.modelfile.placing import TwoPlaces, placed_points
from flexmech.units import TEMPERATURE, Dimension
from flexmech.validation import check_instance, check_number

MOST_BYTES = 10_000_000
"""Greatest size of a model file or a study: a hundred times that of the longest ones."""


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
    name = Path(file).stem if tables.name is None else tables.name
    provenance = Provenance(name, tables.source, file, sha256, text)
    mechanism = build_mechanism(tables, shown, provenance, folder)
    drawn_from_file = tables.drive is not None and isinstance(tables.drive.table, str)
    if drawn_from_file or any(load.file is not None for load in tables.loads.values()):
        # The text alone has to say it all: the files beside it may be gone when it is read again.
        return replace(mechanism, provenance=replace(provenance, text=mechanism.to_toml()))
    return mechanism


SHOWN = "the changed model"
# Say what a mechanism is called and where it is from, and not what it is.
_LABELS = ("name", "source", "notes")
Keys = tuple[str, ...]
StatedField = tuple[Keys, si.QuantityField | str]


@dataclass(frozen=True)
class StatedModel:
    """What a model file states, by dotted keys such as ``links.coupler.in_plane_thickness``.

    Parameters
    ----------
    mechanism : Mechanism
        One that is not from a file, or was changed since, is written as :meth:`Mechanism.to_toml`
        does.
    data : mapping
        The file's content as parsed from TOML.
    """

    mechanism: Mechanism
    data: Mapping[str, Any]

    @classmethod
    def of(cls, mechanism: Mechanism) -> Self:
        """What the model file of a mechanism states."""
        text = mechanism.provenance.text
        if not text or mechanism_from_toml(text) != mechanism:
            text = mechanism.to_toml()
        return cls(mechanism, tomllib.loads(text))

    @cached_property
    def quantities(self) -> dict[str, Dimension]:
        """Quantities by their keys; those in lists by their place, as ``linkage.points.C.0``.

        Temperatures and operating speeds are left out.
        """
        return {key: field.dimension for key, field in self._fields.items()}

    @cached_property
    def texts(self) -> dict[str, str]:
        """Texts by their keys, such as the name of a link's material or a stacking sequence."""
        return {".".join(keys): stated for keys, stated in self._stated if isinstance(stated, str)}

    @cached_property
    def _stated(self) -> list[StatedField]:
        return list(_of_table(self._tables, self.data))

    @cached_property
    def _fields(self) -> dict[str, si.QuantityField]:
        stated = ((".".join(keys), field) for keys, field in self._stated)
        return {key: field for key, field in stated if not isinstance(field, str)}

    @cached_property
    def _tables(self) -> ModelFile:
        return ModelFile(**self.data)

    @cached_property
    def _keys(self) -> dict[str, Keys]:
        return {".".join(keys): keys for keys, _ in self._stated}

    def value(self, key: str) -> float:
        """Value of one of :attr:`quantities` in SI units; infinite where it is without bound."""
        stated: Any = self.data
        for name in self._keys[key]:
            stated = stated[int(name) if isinstance(stated, list) else name]
        return self._fields[key].parse(stated)

    def with_values(self, values: Mapping[str, float | str]) -> Mechanism:
        """The mechanism whose model file states other values.

        Parameters
        ----------
        values : mapping of str to float or str
            By :attr:`quantities` in SI units, by :attr:`texts` as they stand in the file.

        Returns
        -------
        Mechanism
            With the provenance of the unchanged one.

        Raises
        ------
        InputError
            If there is no such key, or a value is impossible.
        """
        data = self._data_with(values)
        try:
            tables = ModelFile(**_read_where_same(self._tables, self.data, data))
        except ValidationError as error:
            raise input_error(error, data, SHOWN) from error
        return build_mechanism(tables, SHOWN, self.mechanism.provenance)

    def text_with(self, values: Mapping[str, float | str]) -> str:
        """The model file with other values; see :meth:`with_values`."""
        import tomli_w

        return tomli_w.dumps(self._data_with(values))

    def _data_with(self, values: Mapping[str, float | str]) -> dict[str, Any]:
        """The content of the file with other values."""
        data = dict(self.data)
        for key, value in values.items():
            if key not in self._keys:
                raise InputError(
                    f"the model states no quantity {key!r}; {suggestion(key, sorted(self._keys))}"
                )
            if not isinstance(value, str):
                dimension = self.quantities[key]
                check_number(value, key, dimension.unit)
                value = quantity(value, dimension)
            data = _with_entry(data, self._keys[key], value)
        return data


def quantities_of(mechanism: Mechanism) -> dict[str, Dimension]:
    """Quantities that the model file of a mechanism states, by their dotted keys.

    Parameters
    ----------
    mechanism : Mechanism

    Returns
    -------
    dict of str to Dimension
        See :attr:`StatedModel.quantities`.
    """
    return StatedModel.of(mechanism).quantities


def mechanism_with(mechanism: Mechanism, key: str, value: float) -> Mechanism:
    """The mechanism whose model file states another value.

    Parameters
    ----------
    mechanism : Mechanism
    key : str
        One of :func:`quantities_of`.
    value : float
        In SI units.

    Returns
    -------
    Mechanism
        With the provenance of the unchanged one.

    Raises
    ------
    InputError
        If there is no such key, or the value is impossible.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> longer = flexmech.modelfile.mechanism_with(mechanism, "linkage.coupler", 0.29)
    >>> longer.linkage.coupler
    0.29
    """
    return StatedModel.of(mechanism).with_values({key: value})


def _with_entry(table: Any, keys: Keys, stated: Any) -> Any:
    """A table or list with another entry; what is not on the way to it is shared."""
    if not keys:
        return stated
    copied: Any = list(table) if isinstance(table, list) else dict(table)
    place = int(keys[0]) if isinstance(table, list) else keys[0]
    copied[place] = _with_entry(table[place], keys[1:], stated)
    return copied


def _read_where_same(
    tables: ModelFile, before: Mapping[str, Any], data: Mapping[str, Any]
) -> dict[str, Any]:
    """Content of a file, in which tables that are the same as before are already read.

    Pydantic takes those as they are and reads what has changed, which saves half the time.
    """
    read = dict(data)
    for key, stated in data.items():
        known = getattr(tables, key)
        if stated is before[key]:
            read[key] = known
        elif isinstance(known, dict):
            same = {name: known[name] for name in known if stated[name] is before[key][name]}
            read[key] = stated | same
    return read


def _of_table(inside: BaseModel, data: Mapping[str, Any]) -> Iterator[StatedField]:
    """Keys of what a table states, with the fields of quantities and the text of others."""
    for name, value in data.items():
        field = type(inside).model_fields[name]
        annotation = Annotated[(field.annotation, *field.metadata)] if field.metadata else None
        if name in _LABELS:
            continue
        for keys, stated in _of_value(annotation or field.annotation, getattr(inside, name), value):
            yield (name, *keys), stated


def _of_value(annotation: Any, inside: Any, value: Any) -> Iterator[StatedField]:
    """The same of the value of a field, whatever it is."""
    if isinstance(inside, BaseModel):
        if isinstance(value, Mapping):
            yield from _of_table(inside, value)
    elif isinstance(value, Mapping) and isinstance(inside, Mapping):
        for name, entry in value.items():
            for keys, stated in _of_value(_entries(annotation, dict), inside[name], entry):
                yield (name, *keys), stated
    elif isinstance(value, list) and isinstance(inside, Sequence):
        for number, (one, entry) in enumerate(zip(inside, value, strict=True)):
            for keys, stated in _of_value(_entries(annotation, list, tuple), one, entry):
                yield (str(number), *keys), stated
    else:
        mark = si.mark_of(annotation)
        if mark is None:
            if isinstance(value, str):
                yield (), value
        elif mark.dimension is not TEMPERATURE and not isinstance(mark, si.WrittenField):
            yield (), mark


def _entries(annotation: Any, *kinds: type) -> Any:
    """Annotation of the entries of a list or a table by name."""
    for option in si.options(annotation):
        if get_origin(option) in kinds:
            return [kind for kind in get_args(option) if kind is not Ellipsis][-1]
    return Any
