"""Records from files of any kind that is known here, told by the ending."""

from __future__ import annotations

from os import PathLike

from flexmech.files import given_path
from flexmech.measured_data.csv_files import read_csv_record
from flexmech.measured_data.record import MeasuredRecord
from flexmech.measured_data.uff_records import read_uff_record

UFF_ENDINGS = (".uff", ".unv", ".uf", ".bunv")


def read_record(path: str | PathLike[str]) -> MeasuredRecord:
    r"""Read a record: a universal file by its ending, else a CSV file.

    Parameters
    ----------
    path : path-like
        A file that ends with ``.uff`` or ``.unv`` is read as a universal file.

    Returns
    -------
    MeasuredRecord

    Raises
    ------
    InputError
        If it cannot be read, or holds no record with units.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
    ...     _ = file.write("time [ms],strain (um/m)\n0,10\n1,12\n2,9\n")
    ...     file.flush()
    ...     record = flexmech.read_record(file.name)
    >>> record.abscissa, record.quantity("strain").values.max().round(9)
    ('time', np.float64(1.2e-05))
    """
    file = given_path(path)
    return read_uff_record(file) if file.suffix.lower() in UFF_ENDINGS else read_csv_record(file)
