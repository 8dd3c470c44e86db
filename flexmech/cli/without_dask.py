"""Commands do without Dask: xarray and pint import it only to ask whether arrays are its own.

Where it is installed, that takes half a second. Only studies on a cluster use it.
"""

from __future__ import annotations

import sys
from typing import cast

_Modules = dict[str, object]


def leave_out_dask() -> None:
    """Make libraries find no Dask, as where it is not installed."""
    cast(_Modules, sys.modules).setdefault("dask", None)


def admit_dask() -> None:
    """Undo :func:`leave_out_dask`."""
    if sys.modules.get("dask", sys) is None:
        del sys.modules["dask"]
