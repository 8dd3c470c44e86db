"""Many small matrices: one BLAS thread is ten times faster than several."""

from __future__ import annotations

from functools import cache

from threadpoolctl import ThreadpoolController

__all__ = ["one_thread"]


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()


def one_thread():  # type: ignore[no-untyped-def]  # threadpoolctl is not typed
    """Context in which linear algebra runs on one thread."""
    return _controller().limit(limits=1, user_api="blas")
