"""What a result came from, and what its variables mean."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from functools import cache
from importlib import resources
from importlib.metadata import version

import xarray as xr

from flexmech.linear_system import Engine
from flexmech.mechanism import Mechanism


@cache
def _version(package: str) -> str:
    return version(package)


def origin(mechanism: Mechanism, *packages: str) -> dict[str, str | int]:
    """Attributes that tell a mechanism, its model file, and the versions of packages."""
    source = mechanism.provenance
    return {
        "mechanism": source.name,
        "source": source.source,
        "model_file": source.file,
        "model_sha256": source.sha256,
        "model_text": source.text,
        **versions(*packages),
    }


def versions(*packages: str) -> dict[str, str]:
    """Attributes that tell the versions of flexmech, of what it computes with, and of packages."""
    return {f"{name}_version": _version(name) for name in ("flexmech", "numpy", "scipy", *packages)}


def provenance(engines: Sequence[Engine]) -> dict[str, str | int]:
    """Attributes of a result of engines, all of one mechanism."""
    packages = ["exudyn"] if any(e.name == "exudyn" for e in engines) else []
    return {**origin(engines[0].mechanism, *packages), "elements": engines[0].elements}


@cache
def _variables(question: str) -> dict[str, list[str]]:
    text = resources.files("flexmech.analyses").joinpath("variables.toml").read_text("utf-8")
    known = tomllib.loads(text)
    return {**known["common"], **known[question]}


def with_units(dataset: xr.Dataset, question: str) -> xr.Dataset:
    """The dataset, each of its variables with its unit and what it is in words.

    Parameters
    ----------
    dataset : xarray.Dataset
        Changed in place.
    question : str
        Folder of the analysis: a table of ``variables.toml``.

    Returns
    -------
    xarray.Dataset
    """
    for name, (unit, long_name) in _variables(question).items():
        if name in dataset.variables:
            dataset[name].attrs.update(units=unit, long_name=long_name)
    return dataset
