"""Reading NetCDF files that may be damaged, or made to read other files."""

from __future__ import annotations

from pathlib import Path

import h5py
import xarray as xr

from flexmech.errors import InputError

__all__ = ["read_netcdf"]


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
