"""The one import of exudyn: quiet, without range checks, and with its log kept in."""

from __future__ import annotations

import contextlib
import io
import sys
from types import ModuleType


def load_exudyn() -> ModuleType:
    """Exudyn's module.

    The core without range checks is about a third faster; it must be asked for before the
    first import, which announces the choice on the standard output: a library stays quiet.
    """
    if "exudyn" not in sys.modules:
        sys.exudynFast = True  # type: ignore[attr-defined]  # exudyn's own switch
    with contextlib.redirect_stdout(io.StringIO()):
        import exudyn
        import exudyn.itemInterface

    return exudyn
