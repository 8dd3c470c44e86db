"""What the results in the pages depend on, and where they are kept meanwhile."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path

__all__ = ["REPOSITORY", "cache_folder", "command_results", "environment"]

REPOSITORY = Path(__file__).parents[2]
CODE = ("flexmech", "models", "scenarios")
PACKAGES = ("exudyn", "matplotlib", "numpy", "scipy", "xarray")


@cache
def cache_folder() -> Path:
    """Folder of results that were made by the code, the models and the versions of today."""
    digest = hashlib.sha256()
    for package in PACKAGES:
        digest.update(f"{package} {version(package)}".encode())
    for folder in CODE:
        for path in sorted((REPOSITORY / folder).rglob("*")):
            if path.is_file() and path.suffix != ".pyc":
                digest.update(str(path.relative_to(REPOSITORY)).encode() + path.read_bytes())
    return REPOSITORY / "docs" / "_build" / "kept" / digest.hexdigest()[:16]


def environment() -> dict[str, str]:
    """Environment of a process that runs the code of this repository and shows no window."""
    return {**os.environ, "PYTHONPATH": str(REPOSITORY), "MPLBACKEND": "Agg"}


def command_results(name: str, *arguments: str) -> Path:
    """Folder of what a command of flexmech wrote; it runs only if the folder is not there yet."""
    folder = cache_folder() / name
    if folder.exists():
        return folder
    started = folder.with_name(f"{name}.unfinished")
    shutil.rmtree(started, ignore_errors=True)
    command = [sys.executable, "-m", "flexmech", *arguments, "--quiet", "--out", str(started)]
    run = subprocess.run(command, capture_output=True, text=True, env=environment())
    if run.returncode:
        raise RuntimeError(f"flexmech {' '.join(arguments)} failed: {run.stderr.strip()}")
    started.rename(folder)
    return folder
