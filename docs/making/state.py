"""What the results in the pages depend on, and where they are kept meanwhile."""

from __future__ import annotations

import hashlib
import os
import pty
import re
import shutil
import subprocess
import sys
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryFile

__all__ = ["REPOSITORY", "cache_folder", "command_results", "environment", "on_a_terminal"]

REPOSITORY = Path(__file__).parents[2]
CODE = ("flexmech", "models", "scenarios")
# What a command says meanwhile where there is no terminal: how often depends on the machine.
PROGRESS = re.compile(r"^.+: \d+ of \d+ after \d+ s\n", re.MULTILINE)
PACKAGES = ("exudyn", "matplotlib", "numpy", "scipy", "xarray")


@cache
def cache_folder() -> Path:
    """Folder of results that were made by the code, the models and the versions of today."""
    digest = hashlib.sha256()
    for package in PACKAGES:
        digest.update(f"{package} {version(package)}".encode())
    for folder in CODE:
        for path in sorted((REPOSITORY / folder).rglob("*")):
            # Expected numbers are compared in every build.
            if path.is_file() and path.suffix != ".pyc" and path.name != "expected_numbers.toml":
                digest.update(str(path.relative_to(REPOSITORY)).encode() + path.read_bytes())
    return REPOSITORY / "docs" / "_build" / "kept" / digest.hexdigest()[:16]


def environment() -> dict[str, str]:
    """Environment of a process that runs the code of this repository and shows no window.

    As many processes run as there are cores: each has one thread.
    """
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    return {**os.environ, **threads, "PYTHONPATH": str(REPOSITORY), "MPLBACKEND": "Agg"}


def on_a_terminal(*arguments: str, folder: Path) -> tuple[int, str]:
    """Run a command of flexmech as on a terminal of 80 columns; its exit code, what it prints.

    Warnings and notes stand before the answer. There are neither colours nor progress.
    """
    reader, writer = pty.openpty()
    # Rich cuts wide tables at 80 columns where a terminal without colours has no height stated.
    plain = {**environment(), "COLUMNS": "80", "LINES": "25", "TERM": "dumb"}
    for name in ("CLICOLOR", "CLICOLOR_FORCE", "FORCE_COLOR"):
        plain.pop(name, None)
    with TemporaryFile() as errors:
        run = subprocess.Popen(
            [sys.executable, "-m", "flexmech", *arguments],
            stdin=subprocess.DEVNULL,
            stdout=writer,
            stderr=errors,
            cwd=folder,
            env=plain,
        )
        os.close(writer)
        printed = bytearray()
        with suppress(OSError):  # so ends on Linux what elsewhere ends in nothing to read
            while part := os.read(reader, 65536):
                printed += part
        os.close(reader)
        code = run.wait()
        errors.seek(0)
        text = PROGRESS.sub("", errors.read().decode()) + bytes(printed).decode()
    return code, text.replace("\r\n", "\n")


def command_results(name: str, *arguments: str) -> Path:
    """Folder of what a command of flexmech wrote; it runs only if the folder is not there yet."""
    folder = cache_folder() / name
    written = folder / arguments[0]
    if folder.exists():
        return written
    started = folder.with_name(f"{name}.unfinished")
    shutil.rmtree(started, ignore_errors=True)
    command = [sys.executable, "-m", "flexmech", *arguments, "--quiet", "--out", str(started)]
    run = subprocess.run(command, capture_output=True, text=True, env=environment())
    if run.returncode:
        raise RuntimeError(f"flexmech {' '.join(arguments)} failed: {run.stderr.strip()}")
    started.rename(folder)
    return written
