"""The base of every result: a frozen object around a labelled dataset.

NetCDF files follow the CF conventions, and damaged ones are refused. CSV files hold no text that a
spreadsheet takes for a formula.
"""

from __future__ import annotations

import re
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import h5py
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.schema import Schema, schema_of
from flexmech.analyses.summary import Summary
from flexmech.choices import PAGE_WIDTHS, PICTURE_FORMATS, PageWidth, PictureFormat
from flexmech.errors import FlexmechError, InputError, one_line
from flexmech.files import given_path, moved_into, written_at
from flexmech.units import NUMBER
from flexmech.validation import check_flag

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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
    """Content of a file of a dataset, its large variables compressed without loss.

    Parameters
    ----------
    dataset : xarray.Dataset
    attributes : mapping of str to str
        Attributes of the file, before those of the dataset.

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


# What spreadsheets take for the beginning of a formula, where a number does not follow.
_FORMULA = re.compile(rf"(?!{NUMBER}$)[=+\-@\t\r].", re.DOTALL)


def csv_text(table: pd.DataFrame, form: str) -> str:
    r"""A table as CSV, names that would be formulas in a spreadsheet behind an apostrophe.

    Parameters
    ----------
    table : pandas.DataFrame
    form : str
        Format of its numbers, such as ``"%.10g"``.

    Returns
    -------
    str

    Examples
    --------
    >>> csv_text(pd.DataFrame({"link": ["=HYPERLINK(1)", "rod"], "mm": [1.5, -2.0]}), "%.3g")
    "link,mm\n'=HYPERLINK(1),1.5\nrod,-2\n"
    """
    written = table.rename(columns=_plain)
    for name in written.columns:
        if pd.api.types.is_numeric_dtype(written[name]):
            continue
        names = [own for own in written[name].unique() if isinstance(own, str)]
        if any(_plain(own) != own for own in names):
            written[name] = written[name].map(_plain)
    return str(written.to_csv(index=False, float_format=form, lineterminator="\n"))


def _plain(text: object) -> object:
    return f"'{text}" if isinstance(text, str) and _FORMULA.match(text) else text


# Dots per inch of pictures: twice what a screen shows.
DOTS_PER_INCH = 200


@dataclass(frozen=True, eq=False, repr=False)
class Result(ABC):
    """Result of an analysis.

    Parameters
    ----------
    dataset : xarray.Dataset
        Variables with named dimensions, their units in the attributes, and where they come
        from in the dataset's own attributes.
    stored_as : mapping of str to str
        Conventions, title, date and command line of the NetCDF file that it was loaded from;
        empty otherwise.
    """

    dataset: xr.Dataset
    stored_as: Mapping[str, str] = field(default_factory=dict)

    stem: ClassVar[str]
    """Name of the NetCDF file, without its ending."""
    subject: ClassVar[str] = "result"
    """Name of the result in the title of its NetCDF file."""
    hallmark: ClassVar[str]
    """Variable that a result of this kind holds."""
    files: ClassVar[tuple[str, ...]] = ()
    """Patterns of files that such a result may write besides those of its schema."""
    significant_digits: ClassVar[int] = 10
    """Format of the numbers in CSV files."""
    digits: ClassVar[Mapping[str, int]] = {}
    """Significant digits of columns that have others, in all tables or in one, as in
    ``"topology.x_m"``."""

    @classmethod
    def schema(cls) -> Schema:
        """Variables, tables and pictures, as the folder of the analysis declares them."""
        return schema_of(cls.__module__.rpartition(".")[0])

    def tabulated(self) -> xr.Dataset:
        """The dataset with what tables have besides."""
        return self.dataset

    def tables(self) -> dict[str, pd.DataFrame]:
        """Tables by the name of their CSV file without its ending."""
        return self.schema().tables_of(self.tabulated())

    def table(self, name: str) -> pd.DataFrame:
        """The table of one CSV file of the schema, without its ending."""
        return self.schema().table(name, self.tabulated())

    def pictures(self) -> list[str]:
        """Names of the pictures that there is data for."""
        pictures = self.schema().pictures.items()
        held = self.dataset.variables
        return [name for name, one in pictures if not one.needs or one.needs in held]

    def figures(self, *, details: bool = True) -> dict[str, Figure]:
        """Pictures that there is data for, by the names of their files without the ending.

        Parameters
        ----------
        details : bool
            Whether all of them, or those that the answer needs.
        """
        known = self.schema().pictures
        if not known:
            return {self.stem: self.plot()}
        wanted = (name for name in self.pictures() if details or not known[name].detail)
        draws = {name: known[name].draws for name in wanted}
        return {
            name: getattr(plots, function)(self.dataset) if function else self.plot()
            for name, function in draws.items()
        }

    @abstractmethod
    def summary(self) -> Summary:
        """Summary in tables and lines."""

    @cached_property
    def said(self) -> Summary:
        """The summary, made once however often it is read."""
        return self.summary()

    @abstractmethod
    def plot(self, *, ax: Axes | None = None) -> Figure:
        """Draw the picture that answers the question, in axes of the user's if they are given."""

    def texts(self) -> dict[str, str]:
        """Further text files, such as model files, by name."""
        return {}

    @property
    def title(self) -> str:
        """Name of the result, and of its mechanism."""
        mechanism = self.dataset.attrs.get("mechanism", "")
        return f"{self.subject} of {mechanism}" if mechanism else self.subject

    def datasets(self) -> dict[str, xr.Dataset]:
        """Datasets of the NetCDF files, by their names without the ending."""
        return {self.stem: self.dataset}

    @classmethod
    def file_patterns(cls, formats: Collection[PictureFormat]) -> tuple[str, ...]:
        """Patterns of all files that a result writes with pictures in formats.

        Parameters
        ----------
        formats : collection of {"png", "pdf", "svg"}
            None of them: no pictures.

        Returns
        -------
        tuple of str
        """
        patterns, schema = list[str](), cls.schema()
        tables = [f"{name}.csv" for name in schema.tables]
        pictures = [f"{name}.png" for name in schema.pictures]
        datasets = [f"{cls.stem}.nc"] if tables else []
        for name in (*tables, *datasets, *pictures, *cls.files):
            stem, picture, _ = name.rpartition(".png")
            patterns += [f"{stem}.{each}" for each in formats] if picture else [name]
        return tuple(patterns)

    def save(
        self,
        folder: str | Path,
        *,
        figures: bool = False,
        details: bool = True,
        formats: Sequence[PictureFormat] = ("png",),
        width: PageWidth = "two-column",
        command_line: str = "",
    ) -> list[Path]:
        """Write CSV and NetCDF files, and pictures if they are wanted; all or none.

        Parameters
        ----------
        folder : str or Path
            Made if it is not there.
        figures : bool
            Whether to write the pictures too.
        details : bool
            Whether all pictures, or those that the answer needs.
        formats : sequence of {"png", "pdf", "svg"}
            Formats of the pictures: each is written in all of them.
        width : {"one-column", "two-column"}
            Width of the pictures on a journal's page: 88 or 180 mm.
        command_line : str
            That the NetCDF files name as what made them; none if left out.

        Returns
        -------
        list of Path

        Raises
        ------
        InputError
            If the folder cannot be written to, or a format or width is none of these.
        """
        folder, names = given_path(folder), []
        check_flag(figures, "figures")
        check_flag(details, "details")
        _check_pictures(formats if figures else ("png",), width)
        form = f"%.{self.significant_digits}g"
        attributes = file_attributes(self.title, command_line) | dict(self.stored_as)

        def path(name: str) -> Path:
            names.append(name)
            target = temporary / name
            target.parent.mkdir(exist_ok=True)
            return target

        with moved_into(folder) as temporary:
            for name, table in self.tables().items():
                written = self._written(name, table)
                text = csv_text(written, form)
                path(f"{name}.csv").write_text(text, encoding="utf-8", newline="\n")
            for name, dataset in self.datasets().items():
                path(f"{name}.nc").write_bytes(netcdf_bytes(dataset, attributes))
            # Without pictures matplotlib is not loaded: that takes a third of a second.
            if figures:
                self._draw(details, formats, width, path)
            for name, text in self.texts().items():
                path(name).write_text(text, encoding="utf-8", newline="\n")
        return [folder / name for name in names]

    def _draw(
        self,
        details: bool,
        formats: Sequence[PictureFormat],
        width: PageWidth,
        path: Callable[[str], Path],
    ) -> None:
        """Write the pictures in all formats, each where the path of its name is."""
        with warnings.catch_warnings(), plots.page_width(PAGE_WIDTHS[width]):
            # Letters of a name that the typeface lacks are shown as boxes.
            warnings.filterwarnings("ignore", "Glyph .* missing", UserWarning)
            for name, figure in self.figures(details=details).items():
                for each in dict.fromkeys(formats):
                    plots.save_figure(figure, path(f"{name}.{each}"), dpi=DOTS_PER_INCH)

    def _written(self, name: str, table: pd.DataFrame) -> pd.DataFrame:
        """A table whose columns with digits of their own are texts; not a number is nothing."""
        texts: dict[str, Any] = {}
        for column in table:
            digits = self.digits.get(f"{name}.{column}", self.digits.get(column))
            if digits is not None:
                texts[column] = table[column].map(f"{{:.{digits}g}}".format, na_action="ignore")
        return table.assign(**texts)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a NetCDF file back.

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        Result
            Result of this class.

        Raises
        ------
        InputError
            If the file is not there or is no such result of flexmech.
        """
        path = given_path(path)
        if not path.is_file():
            raise InputError(f"{path}: no such result file")
        return cls.of_file(path, read_netcdf(path))

    @classmethod
    def of_file(cls, path: Path, loaded: xr.Dataset) -> Self:
        """Make the result of what a file holds.

        Parameters
        ----------
        path : Path
            Named in messages.
        loaded : xarray.Dataset
            What :func:`flexmech.analyses.result.read_netcdf` gives of it.

        Returns
        -------
        Result
            Result of this class.

        Raises
        ------
        InputError
            If it is no such result of flexmech, or lacks what one holds.
        """
        if cls.hallmark not in loaded:
            raise InputError(
                f"{path}: holds no variable {cls.hallmark!r}; not a {cls.stem} result of flexmech"
            )
        given = [name for name in FILE_ATTRIBUTES if name in loaded.attrs]
        found = cls(loaded, {name: str(loaded.attrs.pop(name)) for name in given})
        with reported_as_damaged(path):
            found.summary()
        return found

    def __repr__(self) -> str:
        sizes = ", ".join(f"{name} {size}" for name, size in self.dataset.sizes.items())
        return f"<{type(self).__name__} of {self.dataset.attrs.get('mechanism', '')}: {sizes}>"

    def _repr_html_(self) -> str:
        try:
            picture = plots.figure_html(self.plot())
        except InputError:
            picture = ""  # there is nothing to draw; the summary says why
        return picture + self.summary()._repr_html_()


def _check_pictures(formats: Sequence[str], width: str) -> None:
    """Refuse formats that are not known, none, and other widths than those of a page."""
    listed = isinstance(formats, Sequence) and not isinstance(formats, str | bytes)
    if not listed or not formats or any(form not in [*PICTURE_FORMATS] for form in formats):
        known = ", ".join(map(repr, PICTURE_FORMATS))
        raise InputError(f"formats: must be one or more of {known} in a list, got {formats!r}")
    if not isinstance(width, str) or width not in PAGE_WIDTHS:
        known = " or ".join(map(repr, PAGE_WIDTHS))
        raise InputError(f"width: must be {known}, got {width!r}")
