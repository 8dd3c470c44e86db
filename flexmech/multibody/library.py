"""The one import of exudyn: quiet, without range checks, and with its log kept in."""

from __future__ import annotations

import contextlib
import io
import sys
from importlib.util import find_spec
from types import ModuleType

from flexmech.errors import InputError


def check_exudyn() -> None:
    """Refuse the engine where exudyn is not installed; it is not imported for that.

    Raises
    ------
    InputError
        With what to do.
    """
    if "exudyn" in sys.modules:
        installed = sys.modules["exudyn"] is not None
    else:
        installed = find_spec("exudyn") is not None
    if not installed:
        raise InputError(
            "the exudyn engine needs exudyn, which is not installed: pip install exudyn, or choose "
            "the reference engine (--engine reference, flexmech.ReferenceEngine)"
        )


def load_exudyn() -> ModuleType:
    """Exudyn's module.

    The core without range checks is about a third faster; it must be asked for before the
    first import, which announces the choice on the standard output: a library stays quiet.

    Raises
    ------
    InputError
        If it is not installed.
    """
    check_exudyn()
    if "exudyn" not in sys.modules:
        sys.exudynFast = True  # type: ignore[attr-defined]  # exudyn's own switch
    with contextlib.redirect_stdout(io.StringIO()):
        import exudyn
        import exudyn.itemInterface

    return exudyn
