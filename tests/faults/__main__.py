"""Put faults into the package one at a time, and see whether the tests fail by them.

``python -m tests.faults`` tries each fault of ``table.toml`` on the test that is named there: all
of them must be caught. ``--tests tests/golden tests/physics`` tries them on other tests,
``--only TEXT`` those whose file or text holds it, and ``--draw 60 --seed 7`` faults that nobody has
seen, drawn in the rooms of physics (see ``drawing.py``), on the default suite.

The heavy libraries are imported once; each fault has a fork of that process, in which one module of
the package is compiled from the changed text. The files of the package are not touched.
"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import importlib
import importlib.machinery
import os
import resource
import signal
import sys
import time
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
TABLE = Path(__file__).parent / "table.toml"
# The default suite; the stored numbers first, which most faults change.
SUITE = ("golden", "physics", "invariants", "parts", "engines", "commands", "figures", "report")
# Seconds of processor time after which a changed program is taken to run for ever.
LIMIT = 600
HEAVY = ("numpy", "scipy.optimize", "pandas", "xarray", "matplotlib.figure", "exudyn", "hypothesis")
VERDICTS = {0: "NOT CAUGHT", 1: "caught", -signal.SIGXCPU: "caught: runs for ever"}


@dataclasses.dataclass(frozen=True)
class Fault:
    """A text of the package, the wrong text in its place, and the tests that fail by it."""

    file: str
    old: str
    new: str
    tests: tuple[str, ...] = ()
    # Index among equal texts; the table holds texts that stand once in their files.
    offset: int | None = None

    def source(self) -> str:
        """Source of the module with the fault in it.

        Raises
        ------
        LookupError
            If the text does not stand in the file, or stands there more than once.
        """
        text = (ROOT / self.file).read_text(encoding="utf-8")
        if self.offset is None and text.count(self.old) != 1:
            raise LookupError(f"{self.file} holds {text.count(self.old)} times: {self.old}")
        start = text.index(self.old, self.offset or 0)
        return text[:start] + self.new + text[start + len(self.old) :]

    def __str__(self) -> str:
        return f"{self.file}: {' '.join(self.old.split())}  ->  {' '.join(self.new.split())}"


def main() -> int:
    """Try the faults asked for; 0 if all were caught, 1 if not, 2 if one cannot be tried."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description=__doc__)
    parser.add_argument("--only", default="", help="faults whose file or text holds this")
    parser.add_argument("--tests", nargs="+", help="tests in place of those that the table names")
    parser.add_argument("--draw", type=int, metavar="N", help="N faults drawn anew")
    parser.add_argument("--seed", type=int, default=0, help="seed of the draw")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="faults tried at a time")
    asked = parser.parse_args()
    os.chdir(ROOT)
    os.environ["OPENBLAS_NUM_THREADS"] = "1"

    faults = drawn_faults(asked.draw, asked.seed) if asked.draw else faults_of_table()
    faults = [fault for fault in faults if asked.only in str(fault)]
    if asked.tests or asked.draw:
        tests = tuple(asked.tests or [f"tests/{folder}" for folder in SUITE])
        faults = [dataclasses.replace(fault, tests=tests) for fault in faults]
    for fault in faults:
        fault.source()
    for name in HEAVY:
        importlib.import_module(name)
    sound = sorted({test for fault in faults for test in fault.tests})
    if not asked.draw and _exit_code(_start(None, sound)[0]) != 0:
        print("error: these tests fail without any fault: run them by pytest")
        return 2

    counts = {"caught": 0, "NOT CAUGHT": 0, "cannot be tried": 0}
    for fault, code, failed, seconds in outcomes(faults, asked.jobs):
        verdict = VERDICTS.get(code, f"cannot be tried: pytest ended with {code}")
        counts[verdict.split(":")[0]] += 1
        by = f"  by {failed}" if failed and fault.tests != (failed,) else ""
        print(f"{verdict:12s} {seconds:6.1f} s  {fault}{by}", flush=True)
    print(", ".join(f"{count} {verdict}" for verdict, count in counts.items() if count))
    return 2 if counts["cannot be tried"] else int(counts["NOT CAUGHT"] > 0)


def faults_of_table() -> list[Fault]:
    """Faults of the table, in its order."""
    rows = tomllib.loads(TABLE.read_text(encoding="utf-8"))["fault"]
    return [Fault(row["file"], row["old"], row["new"], (row["test"],)) for row in rows]


def drawn_faults(count: int, seed: int) -> list[Fault]:
    """Faults that are drawn in the rooms of physics."""
    from tests.faults.drawing import draw

    return [Fault(file, old, new, offset=offset) for file, offset, old, new in draw(count, seed)]


def outcomes(faults: Sequence[Fault], jobs: int) -> Iterator[tuple[Fault, int, str, float]]:
    """Each fault with pytest's exit code, the test that failed and the seconds, as they end."""
    waiting, running = list(faults), {}
    while waiting or running:
        while waiting and len(running) < jobs:
            fault = waiting.pop(0)
            process, answer = _start(fault, fault.tests)
            running[process] = fault, answer, time.monotonic()
        process, status = os.wait()
        fault, answer, began = running.pop(process)
        with os.fdopen(answer) as failed:
            yield fault, os.waitstatus_to_exitcode(status), failed.read(), time.monotonic() - began


class _FirstFailure:
    """Plugin of pytest that writes the name of the test that failed."""

    def __init__(self, answer: int) -> None:
        self.answer = answer

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:
            os.write(self.answer, report.nodeid.encode())


def _start(fault: Fault | None, tests: Sequence[str]) -> tuple[int, int]:
    """Process that runs the tests with the fault in the package, and what its failure is read from.

    The process exits as pytest does.
    """
    read, write = os.pipe()
    process = os.fork()
    if process:
        os.close(write)
        return process, read
    code = 3
    try:
        resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT + 10))
        with Path(os.devnull).open("w") as nowhere, contextlib.redirect_stdout(nowhere):
            os.dup2(nowhere.fileno(), 1)
            os.dup2(nowhere.fileno(), 2)
            if fault is not None:
                _compile_from(ROOT / fault.file, fault.source())
            pytest = importlib.import_module("pytest")
            words = ["-x", "-n0", "-p", "no:cacheprovider", *tests]
            code = int(pytest.main(words, plugins=[_FirstFailure(write)]))
    finally:
        os._exit(code)


def _exit_code(process: int) -> int:
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])


def _compile_from(path: Path, source: str) -> None:
    """Have the import of this file compile this source in its place."""
    loader = importlib.machinery.SourceFileLoader
    get_code = loader.get_code

    def changed(self: importlib.machinery.SourceFileLoader, name: str) -> object:
        if Path(self.path) == path:
            return compile(source, self.path, "exec", dont_inherit=True)
        return get_code(self, name)

    loader.get_code = changed  # type: ignore[method-assign,assignment]


if __name__ == "__main__":
    sys.exit(main())
