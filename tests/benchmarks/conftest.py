"""Benchmarks state speed as a ratio of two medians measured in one run.

Run with ``pytest tests/benchmarks``. Nothing is asserted about time; the ratios are printed
at the end and kept in pytest-benchmark's ``extra_info`` (``--benchmark-json``).
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import pytest

ROWS: list[tuple[str, str]] = []


@pytest.fixture
def against(benchmark):
    """Time a function against a plain one, in turn, and note the ratio of the medians."""

    def run(
        name: str,
        function: Callable[[], object],
        plain: Callable[[], object],
        *,
        rounds: int = 7,
        plain_rounds: int = 3,
        plain_covers: float = 1.0,
    ) -> float:
        function()  # imports and caches
        times: dict[str, list[float]] = {"ours": [], "plain": []}
        for number in range(max(rounds, plain_rounds)):
            for key, count, call in (
                ("ours", rounds, function),
                ("plain", plain_rounds, plain),
            ):
                if number < count:
                    start = time.perf_counter()
                    call()
                    times[key].append(time.perf_counter() - start)
        ours = float(np.median(times["ours"]))
        other = float(np.median(times["plain"])) / plain_covers
        ratio = other / ours
        benchmark.extra_info.update(ratio=ratio, seconds=ours, plain_seconds=other)
        ROWS.append((name, f"{ours * 1e3:10.1f} ms {other * 1e3:12.1f} ms {ratio:9.2f}"))
        benchmark.pedantic(function, rounds=1)
        return ratio

    return run


@pytest.fixture
def note(benchmark):
    """Add a line to the summary."""

    def add(name: str, seconds: float, peak_megabytes: float) -> None:
        benchmark.extra_info.update(seconds=seconds, peak_megabytes=peak_megabytes)
        ROWS.append((name, f"{seconds * 1e3:10.1f} ms   peak {peak_megabytes:7.1f} MB"))
        benchmark.pedantic(lambda: None, rounds=1)

    return add


@pytest.fixture
def tell():
    """Add any line to the summary."""
    return lambda name, row: ROWS.append((name, row))


def pytest_terminal_summary(terminalreporter):
    if ROWS:
        terminalreporter.section("flexmech against plain loops (medians, one thread)")
        terminalreporter.write_line(f"{'':58s}   flexmech        other     ratio")
        for name, row in ROWS:
            terminalreporter.write_line(f"{name:58s} {row}")
