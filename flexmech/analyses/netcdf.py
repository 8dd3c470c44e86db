"""NetCDF files: written as the CF conventions want them, read though they may be damaged."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import xarray as xr

from flexmech.errors import FlexmechError, InputError, one_line
from flexmech.files import written_at

# The first with integers of 64 bits is 1.9.
CONVENTIONS = "CF-1.11"
# Attributes of a file, as against those of the dataset that it holds.
FILE_ATTRIBUTES = ("Conventions", "title", "date", "command_line")
# Smaller variables would not get smaller. The size of files alone.
LEAST_COMPRESSED = 1000


def file_attributes(title: str, command_line: str = "") -> dict[str, str]:
    """Attributes of a file that is written now.

    Parameters
    ----------
    title : str
    command_line : str
        Empty where there is none.

    Returns
    -------
    dict of str to str
        With the date in UTC, or that of the environment variable ``SOURCE_DATE_EPOCH``.

    Raises
    ------
    InputError
        If that variable is no date.
    """
    found = {
        "Conventions": CONVENTIONS,
        "title": title,
        "date": written_at().strftime("%Y-%m-%dT%H:%M:%SZ"),
    }
    return found | ({"command_line": command_line} if command_line else {})


def netcdf_bytes(dataset: xr.Dataset, attributes: Mapping[str, str]) -> bytes:
    """What a file of a dataset holds, its large variables compressed without loss.

    Parameters
    ----------
    dataset : xarray.Dataset
    attributes : mapping of str to str
        Of the file, before those of the dataset.

    Returns
    -------
    bytes
    """
    # Coordinates first: a dimension that a variable has before it is written would be made twice.
    written = xr.Dataset(coords=dataset.coords, attrs={**attributes, **dataset.attrs})
    written = written.assign(dataset.data_vars)
    encoding: dict[Hashable, dict[str, Any]] = {}
    for name, variable in written.variables.items():
        if variable.dtype.kind == "f" and variable.size >= LEAST_COMPRESSED:
            encoding[name] = {"zlib": True, "shuffle": True, "complevel": 4}
        if variable.dtype.kind == "f" and name in written.coords:
            # Coordinates are never missing.
            encoding[name] = {**encoding.get(name, {}), "_FillValue": None}
    # In memory: HDF5 brings the whole program down where a disk is full.
    return bytes(written.to_netcdf(engine="h5netcdf", encoding=encoding))


def read_netcdf(path: Path) -> xr.Dataset:
    """Read a NetCDF file whole.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Dataset
        In memory.

    Raises
    ------
    InputError
        If the file is damaged, or refers to other files, which are not opened.
    """
    try:
        _refuse_references(path)
        with xr.open_dataset(path, engine="h5netcdf") as dataset:
            return dataset.load()
    except InputError:
        raise
    # What HDF5 and what reads it raise on a damaged file can be anything.
    except Exception as error:
        raise InputError(
            f"{path}: not a NetCDF file of flexmech, or a damaged one ({error})"
        ) from error


@contextmanager
def reported_as_damaged(place: object) -> Iterator[None]:
    """Use what a file holds; where something is missing in it, say so.

    Parameters
    ----------
    place : path-like
        File or folder that messages name.

    Raises
    ------
    InputError
        If what is used is not there, or of another kind or shape than a result has it.
    """
    try:
        yield
    except FlexmechError:
        raise
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise InputError(
            f"{place}: lacks something that a result holds ({one_line(str(error), 200)}); it is "
            "damaged, changed by another program or of another version: compute it again"
        ) from error


def _refuse_references(path: Path) -> None:
    """Refuse links and data that live elsewhere: a result holds all that it says."""
    with h5py.File(path, "r") as file:
        for name in file:
            link = file.get(name, getlink=True)
            if not isinstance(link, h5py.HardLink):
                raise InputError(f"{path}: {name} is a link to elsewhere; results have none")
            found = file[name]
            if not isinstance(found, h5py.Dataset):
                raise InputError(f"{path}: {name} is a group; results have none")
            if found.external or found.is_virtual:
                raise InputError(f"{path}: {name} is stored in another file; results are whole")
