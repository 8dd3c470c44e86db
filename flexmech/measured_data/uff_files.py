"""Universal files (UFF) of modal tests, written and read through pyuff (extra ``modal-test``).

Data sets: 151 header, 164 units, 18 frames, 15 nodes, 82 trace lines, 58 functions at nodes, 55
modes at nodes. Their formats are those of the Structural Dynamics Research Laboratory, University
of Cincinnati. All is written in SI units, as text: functions with 12 digits, their first abscissa
and its step, nodes, frames and modes with 6.
"""

from __future__ import annotations

from importlib.util import find_spec
from os import PathLike
from pathlib import Path

from flexmech.errors import InputError, one_line
from flexmech.files import given_path, moved_into
from flexmech.measured_data.uff_contents import UffFile
from flexmech.measured_data.uff_datasets import contents_of, datasets_of

EXTRA = 'a universal file needs pyuff, which is not installed: pip install "flexmech[modal-test]"'


def check_uff() -> None:
    """Refuse to begin where pyuff is missing.

    Raises
    ------
    InputError
        It says what to install.
    """
    if find_spec("pyuff") is None:
        raise InputError(EXTRA)


def write_uff(path: str | PathLike[str], contents: UffFile) -> Path:
    """Write a universal file, whole or not at all.

    Parameters
    ----------
    path : path-like
        Replaced if it exists. Its ending is ``.uff`` or ``.unv`` by custom.
    contents : UffFile

    Returns
    -------
    Path

    Raises
    ------
    InputError
        pyuff is not installed, the folder does not exist or cannot be written, values are not
        finite, or a function is unevenly spaced.
    """
    check_uff()
    import pyuff

    target = given_path(path)
    if not target.parent.is_dir():
        raise InputError(f"{target}: there is no folder {target.parent}; make it first")
    datasets = datasets_of(contents)
    with moved_into(target.parent) as temporary:
        pyuff.UFF(str(temporary / target.name)).write_sets(datasets, mode="overwrite")
    return target


def read_uff(path: str | PathLike[str]) -> UffFile:
    """Read a universal file.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    UffFile
        In SI units; functions without a known unit as they stand.

    Raises
    ------
    InputError
        pyuff is not installed, or the file cannot be read or is no universal file.
    """
    check_uff()
    import pyuff

    file = given_path(path)
    if not file.is_file():
        raise InputError(f"{file}: there is no such file; name a universal file (.uff, .unv)")
    try:
        reader = pyuff.UFF(str(file))
        datasets = [reader.read_sets(number) for number in range(reader.get_n_sets())]
        if not datasets:
            raise InputError(
                f"{file}: holds no data set of a universal file; its lines of '    -1' are missing"
            )
        return contents_of(datasets)
    except InputError:
        raise
    except Exception as error:
        # pyuff raises bare Exceptions, and whatever NumPy raises, for what it cannot read.
        raise InputError(
            f"{file}: cannot be read as a universal file: {one_line(str(error))}; export it anew, "
            "as text (ASCII)"
        ) from error
