"""All pages that are made from the code, written before Sphinx reads them."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from making.commands import command_page
from making.figures_of_the_papers import figures_page, study_results
from making.gallery import gallery_pages, scenario_names, scenario_results
from making.model_file import model_file_page
from making.public_names import public_name_page
from making.sessions import session_pages, session_pictures, session_results
from making.study_file import study_file_page
from making.verification import verification_page, verification_results

__all__ = ["write_pages"]

# Scenarios that take half a minute start first, as the verification does, so that no core waits
# for them in the end.
LONG = (
    "least_mass_fourbar",
    "running_hammer_test",
    "hammer_noise",
    "instability_confirmed",
    "running_fourbars",
    "critical_speeds",
    "stability_maps",
    "moisture_and_stability",
)


def write_pages(folder: Path) -> None:
    """Write the made pages to a folder; those that are unchanged keep their date."""
    folder.mkdir(parents=True, exist_ok=True)
    _run_what_takes_long()
    session_pictures(folder / "sessions")
    pages = {
        "commands.md": command_page(),
        "model_file.md": model_file_page(),
        "study_file.md": study_file_page(),
        "python.md": public_name_page(),
        "verification.md": verification_page(folder),
        "figures_of_the_papers.md": figures_page(folder),
        **gallery_pages(folder / "gallery"),
    }
    for name, text in pages.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


def _run_what_takes_long() -> None:
    """Verification, study, sessions and scenarios, as many at a time as there are cores.

    Each runs in a process of its own, for which a thread waits.
    """
    names = [*LONG, *(name for name in scenario_names() if name not in LONG)]
    runs: list[Callable[[], Path]] = [verification_results]
    runs += [partial(session_results, page) for page in session_pages()]
    runs += [partial(scenario_results, name) for name in names]
    runs.append(study_results)
    with ThreadPoolExecutor(os.cpu_count()) as waiting:
        for run in [waiting.submit(run) for run in runs]:
            run.result()
