"""Many small matrices: one BLAS thread is ten times faster than several."""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import cache
from typing import cast

from threadpoolctl import ThreadpoolController


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()


def one_thread() -> AbstractContextManager[object]:
    """Context in which linear algebra runs on one thread."""
    return cast(AbstractContextManager[object], _controller().limit(limits=1, user_api="blas"))
