"""Results that are written as NetCDF and CSV and read back exactly equal."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Self

import pandas as pd
import xarray as xr

from flexmech.errors import InputError
from flexmech.files import moved_into

__all__ = ["StoredResult"]


@dataclass(frozen=True)
class StoredResult(ABC):
    """A frozen object around a labelled dataset.

    Parameters
    ----------
    dataset : xarray.Dataset
        Variables and units are in the dataset itself; see the README.
    """

    dataset: xr.Dataset

    stem: ClassVar[str]
    """Name of the files, without their endings."""
    hallmark: ClassVar[str]
    """Variable that a result of this kind holds."""

    @abstractmethod
    def table(self) -> pd.DataFrame:
        """What the CSV file holds."""

    def further_tables(self) -> dict[str, pd.DataFrame]:
        """Tables besides the first, by the name of their CSV file without its ending."""
        return {}

    def save(self, folder: str | Path) -> list[Path]:
        """Write CSV files and a NetCDF file, each whole or not at all.

        Parameters
        ----------
        folder : str or Path
            Made if it is not there.

        Returns
        -------
        list of Path

        Raises
        ------
        InputError
            If the folder cannot be written to.
        """
        folder = Path(folder)
        tables = {self.stem: self.table(), **self.further_tables()}
        names = [*(f"{stem}.csv" for stem in tables), f"{self.stem}.nc"]
        with moved_into(folder) as temporary:
            for name, table in zip(names, tables.values(), strict=False):
                table.to_csv(temporary / name, index=False, float_format="%.10g")
            self.dataset.to_netcdf(temporary / names[-1], engine="h5netcdf")
        return [folder / name for name in names]

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a NetCDF file back.

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        StoredResult
            Of this class.

        Raises
        ------
        InputError
            If the file is not there or is no such result of flexmech.
        """
        path = Path(path)
        if not path.is_file():
            raise InputError(f"{path}: no such result file")
        try:
            with xr.open_dataset(path, engine="h5netcdf") as dataset:
                loaded = dataset.load()
        except (OSError, ValueError) as error:
            raise InputError(f"{path}: not a NetCDF file of flexmech ({error})") from error
        if cls.hallmark not in loaded:
            raise InputError(
                f"{path}: holds no variable {cls.hallmark!r}; not a {cls.stem} result of flexmech"
            )
        return cls(loaded)
