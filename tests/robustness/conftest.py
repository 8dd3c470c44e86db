"""What all tests of robustness need."""

from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest


@pytest.fixture(autouse=True)
def _interruptible() -> Iterator[None]:
    """Tests and what they start can be interrupted, also if the tests run in the background.

    A shell lets its background jobs ignore SIGINT, and programs started by these inherit that.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
