"""The quantities of a model file by their keys, and the mechanism with one of them changed."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from flexmech.errors import InputError, suggestion
from flexmech.mechanism import Mechanism
from flexmech.model_text import quantity
from flexmech.modelfile.base_table import QuantityField
from flexmech.modelfile.build import build_mechanism
from flexmech.modelfile.document import ModelFile
from flexmech.modelfile.messages import input_error
from flexmech.modelfile.read import mechanism_from_toml
from flexmech.units import TEMPERATURE, Dimension

SHOWN = "the changed model"
Keys = tuple[str, ...]


def quantities_of(mechanism: Mechanism) -> dict[str, Dimension]:
    """Quantities that the model file of a mechanism states, by their dotted keys.

    Parameters
    ----------
    mechanism : Mechanism
        One that is not from a file, or was changed since, is written as :meth:`Mechanism.to_toml`
        does.

    Returns
    -------
    dict of str to Dimension
        Such as ``linkage.coupler``, a length. Temperatures, numbers in lists and operating speeds
        are left out.
    """
    data = _data(mechanism)
    return {".".join(keys): dimension for keys, dimension in _stated(ModelFile(**data), data)}


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
    data = copy.deepcopy(_data(mechanism))
    found = {".".join(keys): (keys, each) for keys, each in _stated(ModelFile(**data), data)}
    if key not in found:
        raise InputError(f"the model states no quantity {key!r}; {suggestion(key, sorted(found))}")
    keys, dimension = found[key]
    table = data
    for name in keys[:-1]:
        table = table[name]
    table[keys[-1]] = quantity(value, dimension)
    try:
        tables = ModelFile(**data)
    except ValidationError as error:
        raise input_error(error, data, SHOWN) from error
    changed = build_mechanism(tables, SHOWN, "", "")
    return replace(changed, provenance=mechanism.provenance)


def _data(mechanism: Mechanism) -> dict[str, Any]:
    """The mechanism's own model file, where it still is that mechanism's."""
    text = mechanism.provenance.text
    if not text or mechanism_from_toml(text) != mechanism:
        text = mechanism.to_toml()
    return tomllib.loads(text)


def _stated(table: BaseModel, data: Mapping[str, Any]) -> Iterator[tuple[Keys, Dimension]]:
    """Keys of the quantities that a table states, and what they are."""
    fields = type(table).model_fields
    for name in data:
        inside = getattr(table, name)
        parts: list[tuple[Keys, Any, Any]]
        if isinstance(inside, BaseModel):
            parts = [((name,), inside, data[name])]
        elif isinstance(inside, dict):
            parts = [((name, key), each, data[name][key]) for key, each in inside.items()]
        else:
            dimension = None if isinstance(data[name], list) else _dimension(fields[name])
            if dimension not in (None, TEMPERATURE):
                assert dimension is not None
                yield (name,), dimension
            continue
        for keys, each, own in parts:
            if isinstance(each, BaseModel) and isinstance(own, Mapping):
                for more, found in _stated(each, own):
                    yield (*keys, *more), found


def _dimension(field: FieldInfo) -> Dimension | None:
    """Dimension of a quantity, whether it has to be stated or not; None of other fields."""
    marks = [*field.metadata]
    for option in get_args(field.annotation):
        marks += getattr(option, "__metadata__", ())
    return next((mark.dimension for mark in marks if isinstance(mark, QuantityField)), None)
