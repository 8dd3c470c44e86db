"""All pages that are made from the code, written before Sphinx reads them."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from making.blocks import block_failures, pages_with_blocks
from making.columns import variable_page
from making.commands import command_page
from making.figures_of_the_papers import changed_page
from making.gallery import gallery_pages, scenario_failures, scenario_names
from making.model_file import model_file_page
from making.pictures import changed_pictures
from making.public_names import public_name_page
from making.sessions import session_failures, session_pages, session_pictures
from making.study_file import study_file_page
from making.verification import verification_page, verification_results

__all__ = ["run_everything", "write_pages"]

# In s; the build prints the time of what takes longer.
TOLD = 5.0

# What takes longest starts first, so that no core waits for it in the end.
LONG = (
    "13_instability_confirmed",
    "11_moisture_and_stability",
    "papers/elamy_thresholds",
    "papers/elamy_2023",
)


def run_everything() -> list[str]:
    """Run what the pages show, as many at a time as there are cores; what fails, line by line.

    Pictures of the repository are compared last, with what the README's blocks have drawn.
    Verification, sessions, blocks of code and scenarios run in processes of their own, for
    each of which a thread waits, and are kept: the pages find them.
    """
    names = scenario_names()
    runs: list[Callable[[], list[str]]] = [partial(_failures, verification_results)]
    runs += [partial(session_failures, page) for page in session_pages()]
    runs += [partial(scenario_failures, name) for name in LONG]
    runs += [partial(block_failures, page) for page in pages_with_blocks()]
    runs += [partial(scenario_failures, name) for name in names if name not in LONG]
    with ThreadPoolExecutor(os.cpu_count()) as waiting:
        failed = [failure for failures in waiting.map(_timed, runs) for failure in failures]
    return failed or [*changed_pictures(), *changed_page()]


def _timed(run: Callable[[], list[str]]) -> list[str]:
    since = time.monotonic()
    failures = run()
    if (took := time.monotonic() - since) > TOLD:
        about = getattr(run, "args", ("",))[0]
        print(f"{took:6.1f} s  {getattr(about, '__name__', about)}", flush=True)  # noqa: T201
    return failures


def _failures(run: Callable[[], Path]) -> list[str]:
    try:
        run()
    except RuntimeError as error:
        return [str(error)]
    return []


def write_pages(folder: Path) -> None:
    """Write the made pages to a folder; those that are unchanged keep their date."""
    folder.mkdir(parents=True, exist_ok=True)
    session_pictures(folder / "sessions")
    pages = {
        "commands.md": command_page(),
        "model_file.md": model_file_page(),
        "study_file.md": study_file_page(),
        "python.md": public_name_page(),
        "variables.md": variable_page(),
        "verification.md": verification_page(folder),
        **gallery_pages(folder / "gallery"),
    }
    for name, text in pages.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text() != text:
            path.write_text(text)
