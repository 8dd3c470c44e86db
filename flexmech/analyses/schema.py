"""Schema of a result, declared once: its variables, the tables of its CSV files, its pictures.

A folder of an analysis has a file ``schema.toml``; what several analyses report stands in the files
of ``flexmech/analyses/aspects``, which it names under ``aspects``. Labels of NetCDF files, CSV
tables, pictures and the tables of ``docs/files.md`` come from it.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.datasets import Columns, column_of, columns_along, table_of

_HOME = "flexmech.analyses"
Values = dict[str, Any]
"""Arrays by the names of their variables, over the dimensions that a schema declares."""
EACH = re.compile(r"\{([\w ]+)\}")
"""In the name of a column: what stands there in turn."""
_POSITION, _SINGLE = "position", "single"
_SECTIONS = ("index", "columns", "tables", "pictures", "when")


@dataclass(frozen=True)
class Variable:
    """A variable of a dataset.

    Parameters
    ----------
    unit, long_name : str
        SI unit, and what it is in words.
    over : tuple of str
        Dimensions; ``position`` stands for the crank angle, or for time.
    coordinate : bool
        Whether it is a coordinate.
    """

    unit: str
    long_name: str
    over: tuple[str, ...] = ()
    coordinate: bool = False


@dataclass(frozen=True)
class TableOfFile:
    """The table of a CSV file.

    Parameters
    ----------
    over : tuple of str
        Dimensions over which its rows go, the last one fastest, and whose columns come first.
    columns : tuple of str
        Groups of the columns that follow.
    needs : str
        Variable without which there is no such table; empty where there always is one.
    known : str
        Column whose empty cells leave out their rows; may be empty.
    rows : tuple of str
        Dimensions in the order of the rows, where it is not that of the columns.
    """

    over: tuple[str, ...]
    columns: tuple[str, ...]
    needs: str = ""
    known: str = ""
    rows: tuple[str, ...] = ()


@dataclass(frozen=True)
class Picture:
    """A picture of a result.

    Parameters
    ----------
    draws : str
        Function of :mod:`flexmech.plots` that draws it from the dataset; empty of what the
        result's own ``plot`` draws.
    needs : str
        Variable without which there is no such picture; empty where there always is one.
    detail : bool
        Whether the answer can do without it.
    """

    draws: str = ""
    needs: str = ""
    detail: bool = False


@dataclass(frozen=True)
class Schema:
    """Declarations of a result, by their names.

    Parameters
    ----------
    variables : mapping of str to Variable
    index : mapping of str to mapping of str to str
        By dimension the columns that a table over it begins with, and their variables.
    columns : mapping of str to mapping of str to str
        By group the columns and their variables. A column with ``{component}`` in its name stands
        for one at each place along the dimension that the table is not over; the word in braces is
        for readers.
    tables : mapping of str to TableOfFile
    pictures : mapping of str to Picture
    when : mapping of str to str
        Groups of columns and tables that there are not always, and when there are, in words.
    """

    variables: Mapping[str, Variable] = field(default_factory=dict)
    index: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    columns: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    tables: Mapping[str, TableOfFile] = field(default_factory=dict)
    pictures: Mapping[str, Picture] = field(default_factory=dict)
    when: Mapping[str, str] = field(default_factory=dict)

    def dataset(
        self,
        values: Values,
        position: str = "crank_angle",
        parts: Sequence[Values] = (),
        along: str = "",
    ) -> xr.Dataset:
        """The dataset of values by the names of their variables, labelled.

        Parameters
        ----------
        values : mapping of str to array_like
            Each over the dimensions that are declared.
        position : {"crank_angle", "time"}
            What the positions are over.
        parts : sequence of mapping of str to array_like, optional
            Further values, of one place along a dimension after the other, such as each engine.
            Coordinates are those of the first.
        along : str
            This dimension, the first one of such variables.

        Returns
        -------
        xarray.Dataset
        """
        found: dict[str, tuple[tuple[str, ...], Any]] = {}
        coordinates = []
        first: Values = parts[0] if parts else {}
        for name in [*values, *first]:
            # A coordinate of names, such as those of links, is declared nowhere.
            known = self.variables.get(name, Variable("", "", (name,), True))
            over, array = _at(position, known.over), values.get(name, first.get(name))
            if known.coordinate:
                coordinates.append(name)
            elif name in first:
                over = (along, *(dim for dim in over if dim != along))
                array = np.stack([np.asarray(part[name]) for part in parts])
            found[name] = over, array
        return self.labelled(xr.Dataset(found).set_coords(coordinates))

    def labelled(self, dataset: xr.Dataset) -> xr.Dataset:
        """The dataset, changed in place: its variables with their units and what they are."""
        for name, variable in self.variables.items():
            if name in dataset.variables:
                attributes = {"units": variable.unit, "long_name": variable.long_name}
                dataset[name].attrs.update(attributes)
        return dataset

    def tables_of(self, dataset: xr.Dataset) -> dict[str, pd.DataFrame]:
        """The tables of all files that the dataset has something for, by their names."""
        return {
            name: self.table(name, dataset)
            for name, one in self.tables.items()
            if not one.needs or one.needs in dataset.variables
        }

    def table(self, name: str, dataset: xr.Dataset) -> pd.DataFrame:
        """The table of one file.

        Parameters
        ----------
        name : str
        dataset : xarray.Dataset

        Returns
        -------
        pandas.DataFrame
        """
        declared = self.tables[name]
        position = "time" if "time" in dataset.dims else "crank_angle"
        over = _at(position, declared.over)
        columns: Columns = {}
        for dim in declared.over:
            columns |= self.index[dim]
        if position != "time" and _POSITION in declared.over:
            del columns["time_s"]
        for group in declared.columns:
            for column, variable in self.columns[group].items():
                if group not in self.when or variable in dataset.variables:
                    columns |= _along(dataset, column, variable, over)
        table = table_of(dataset, _at(position, declared.rows) or over, columns)
        if declared.known:
            table = table.dropna(subset=[declared.known]).reset_index(drop=True)
        return table


def _at(position: str, over: tuple[str, ...]) -> tuple[str, ...]:
    """Dimensions with what the positions of a dataset are over."""
    return tuple(position if dim == _POSITION else dim for dim in over)


def _along(dataset: xr.Dataset, column: str, name: str, over: tuple[str, ...]) -> Columns:
    """A column, or those of the places along the dimension that the table is not over."""
    form = EACH.sub("{}", column)
    if form == column:
        return {column: name}
    values = column_of(dataset, column, name)
    (dim,) = {*map(str, values.dims)} - {*over}
    return {**columns_along(form, values, dim)}


@cache
def schema_of(package: str) -> Schema:
    """The schema of an analysis.

    Parameters
    ----------
    package : str
        Its folder, such as ``"flexmech.analyses.kinematics"``.

    Returns
    -------
    Schema
        Empty where the folder has no ``schema.toml``.
    """
    file = resources.files(package).joinpath("schema.toml")
    if not file.is_file():
        return Schema()
    asked = tomllib.loads(file.read_text("utf-8"))
    aspects = resources.files(f"{_HOME}.aspects")
    names = ["common", *asked.get("aspects", [])]
    texts = [aspects.joinpath(f"{name}.toml").read_text("utf-8") for name in names]
    variables: dict[str, Variable] = {}
    sections: dict[str, dict[str, Any]] = {name: {} for name in _SECTIONS}
    for text in [*map(tomllib.loads, texts), asked]:
        variables |= _variables(text)
        for name, section in sections.items():
            section |= text.get(name, {})
    tables = {
        name: TableOfFile(tuple(one.pop("over")), tuple(one.pop("columns", [name])), **one)
        for name, one in sections.pop("tables").items()
    }
    pictures = {name: Picture(**one) for name, one in sections.pop("pictures").items()}
    return Schema(variables, tables=tables, pictures=pictures, **sections)


def _variables(text: Mapping[str, Any]) -> dict[str, Variable]:
    return {
        name: Variable(unit, words, () if over == _SINGLE else tuple(over.split()), coordinate)
        for kind, coordinate in (("variables", False), ("coordinates", True))
        for over, names in text.get(kind, {}).items()
        for name, (unit, words) in names.items()
    }
