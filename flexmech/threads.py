"""Many small matrices: one BLAS thread is ten times faster than several, and memory is kept."""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import cache
from typing import cast

import numpy as np
from threadpoolctl import ThreadpoolController

# Speed alone: once a block of this size has been freed, the GNU C library keeps up to twice as much
# of what is freed, in place of giving it back and asking for it anew in each batch (mallopt(3),
# dynamic threshold, which goes to 32 MiB). A sixth of the time of a map of frequencies.
_KEPT_BYTES = 30 * 2**20


@cache
def _keep_freed_memory() -> None:
    np.empty(_KEPT_BYTES, dtype=np.uint8)


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()


def one_thread() -> AbstractContextManager[object]:
    """Context in which linear algebra runs on one thread."""
    _keep_freed_memory()
    return cast(AbstractContextManager[object], _controller().limit(limits=1, user_api="blas"))
