"""What a model file states by its dotted keys, and the mechanism with some of it changed."""

from __future__ import annotations

import copy
import tomllib
import types
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Self, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

from flexmech.errors import InputError, suggestion
from flexmech.mechanism import Mechanism
from flexmech.model_text import quantity
from flexmech.modelfile.base_table import QuantityField, WrittenField
from flexmech.modelfile.build import build_mechanism
from flexmech.modelfile.document import ModelFile
from flexmech.modelfile.messages import input_error
from flexmech.modelfile.read import mechanism_from_toml
from flexmech.units import TEMPERATURE, Dimension, parse_quantity

SHOWN = "the changed model"
# Say what a mechanism is called and where it is from, and not what it is.
_LABELS = ("name", "source", "notes")
Keys = tuple[str, ...]


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
        return {
            ".".join(keys): stated for keys, stated in self._stated if isinstance(stated, Dimension)
        }

    @cached_property
    def texts(self) -> dict[str, str]:
        """Texts by their keys, such as the name of a link's material or a stacking sequence."""
        return {".".join(keys): stated for keys, stated in self._stated if isinstance(stated, str)}

    @cached_property
    def _stated(self) -> list[tuple[Keys, Dimension | str]]:
        return list(_of_table(ModelFile(**self.data), self.data))

    @cached_property
    def _keys(self) -> dict[str, Keys]:
        return {".".join(keys): keys for keys, _ in self._stated}

    def value(self, key: str) -> float:
        """Value of one of :attr:`quantities` in SI units."""
        found: Any = self.data
        for name in self._keys[key]:
            found = found[int(name) if isinstance(found, list) else name]
        dimension = self.quantities[key]
        return float(found) if isinstance(found, int | float) else parse_quantity(found, dimension)

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
            tables = ModelFile(**data)
        except ValidationError as error:
            raise input_error(error, data, SHOWN) from error
        return build_mechanism(tables, SHOWN, self.mechanism.provenance)

    def text_with(self, values: Mapping[str, float | str]) -> str:
        """The model file with other values; see :meth:`with_values`."""
        import tomli_w

        return tomli_w.dumps(self._data_with(values))

    def _data_with(self, values: Mapping[str, float | str]) -> dict[str, Any]:
        """The content of the file with other values."""
        data = copy.deepcopy(dict(self.data))
        for key, value in values.items():
            if key not in self._keys:
                raise InputError(
                    f"the model states no quantity {key!r}; {suggestion(key, sorted(self._keys))}"
                )
            *outer, last = self._keys[key]
            table: Any = data
            for name in outer:
                table = table[int(name) if isinstance(table, list) else name]
            stated = value if isinstance(value, str) else quantity(value, self.quantities[key])
            table[int(last) if isinstance(table, list) else last] = stated
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


def _of_table(inside: BaseModel, data: Mapping[str, Any]) -> Iterator[tuple[Keys, Dimension | str]]:
    """Keys of what a table states, with the dimension of quantities and the text of others."""
    for name, own in data.items():
        field = type(inside).model_fields[name]
        annotation = Annotated[(field.annotation, *field.metadata)] if field.metadata else None
        if name in _LABELS:
            continue
        for keys, stated in _of_value(annotation or field.annotation, getattr(inside, name), own):
            yield (name, *keys), stated


def _of_value(annotation: Any, inside: Any, own: Any) -> Iterator[tuple[Keys, Dimension | str]]:
    """The same of the value of a field, whatever it is."""
    if isinstance(inside, BaseModel):
        if isinstance(own, Mapping):
            yield from _of_table(inside, own)
    elif isinstance(own, Mapping) and isinstance(inside, Mapping):
        for name, each in own.items():
            for keys, stated in _of_value(_entries(annotation, dict), inside[name], each):
                yield (name, *keys), stated
    elif isinstance(own, list) and isinstance(inside, Sequence):
        for number, (one, each) in enumerate(zip(inside, own, strict=True)):
            for keys, stated in _of_value(_entries(annotation, list, tuple), one, each):
                yield (str(number), *keys), stated
    else:
        marks = [mark for mark in _marks(annotation) if isinstance(mark, QuantityField)]
        if marks and not isinstance(marks[0], WrittenField):
            if marks[0].dimension is not TEMPERATURE:
                yield (), marks[0].dimension
        elif not marks and isinstance(own, str):
            yield (), own


def _options(annotation: Any) -> Iterator[Any]:
    """An annotation, and those that are alternatives in it."""
    yield annotation
    if get_origin(annotation) in (Annotated, Union, types.UnionType):
        inner = get_args(annotation)
        for option in inner[:1] if get_origin(annotation) is Annotated else inner:
            yield from _options(option)


def _marks(annotation: Any) -> Iterator[Any]:
    """What an annotation, or an alternative in it, is marked with."""
    for option in _options(annotation):
        yield from getattr(option, "__metadata__", ())


def _entries(annotation: Any, *kinds: type) -> Any:
    """Annotation of the entries of a list or a table by name."""
    for option in _options(annotation):
        if get_origin(option) in kinds:
            return [each for each in get_args(option) if each is not Ellipsis][-1]
    return Any
