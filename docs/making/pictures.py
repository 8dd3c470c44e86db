"""Pictures of the README and the pages that stand in the repository, made by the build.

GitHub shows them without a build. A build makes each anew and holds the one in ``docs/pictures/``
against it; ``docs/build.py --pictures`` puts the new ones there. The report is photographed by a
browser: without one it is not compared, unless ``FLEXMECH_REQUIRE_BROWSER`` is set, as in CI.
"""

from __future__ import annotations

import io
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from making.blocks import block_folder
from making.state import REPOSITORY, cache_folder, environment
from tests.support.browser import MISSING, installed_browser, is_required

__all__ = ["PICTURES", "README", "alike", "changed_pictures", "write_pictures"]

PICTURES = REPOSITORY / "docs" / "pictures"
README = REPOSITORY / "README.md"
# By their names: the command that draws a picture, or the file that the blocks of the README leave.
BY_COMMAND = {
    "carton_pusher.png": ("check models/carton_pusher.toml", "check/check.png"),
    "frequencies.png": ("frequencies models/aluminium_fourbar.toml", "frequencies/frequencies.png"),
}
CAMPBELL, REPORT = "campbell.png", "report.png"
WINDOW = (1280, 1100)
# Root mean square of the differences of colours, of 255: another build of FreeType shifts the edges
# of letters by 1; one word that changes counts 2 and more.
TOLERANCE = 1.5


def changed_pictures() -> list[str]:
    """Pictures that do not show what the code draws today, line by line."""
    return [
        f"docs/pictures/{name}: shows an older state; run docs/build.py --pictures"
        for name, made in _made().items()
        if not alike(PICTURES / name, made.read_bytes())
    ]


def write_pictures() -> None:
    """Put the pictures that the code draws today into the repository."""
    for name, made in _made().items():
        shutil.copy(made, PICTURES / name)


def _made() -> dict[str, Path]:
    """The pictures of today by the names of those in the repository; the README's blocks have run.

    Raises
    ------
    RuntimeError
        If a command fails, or if there is no browser where one is required.
    """
    folder = cache_folder() / "pictures"
    made = {name: folder / name for name in (*BY_COMMAND, REPORT)}
    made[CAMPBELL] = block_folder(README) / "results/campbell" / CAMPBELL
    folder.mkdir(parents=True, exist_ok=True)
    for name, (command, drawn) in BY_COMMAND.items():
        if not made[name].exists():
            made[name].write_bytes(_drawn_by(command, drawn))
    if not made[REPORT].exists() and not _photograph(
        block_folder(README) / "report.html", made[REPORT]
    ):
        print(f"{REPORT} is not compared: no browser", flush=True)  # noqa: T201
        del made[REPORT]
    return made


def alike(stored: Path, made: bytes) -> bool:
    """Whether a picture of the repository is one of today, but for the edges of letters."""
    files = (stored, io.BytesIO(made))
    before, now = (np.asarray(Image.open(file).convert("RGB"), float) for file in files)
    return before.shape == now.shape and float(np.sqrt(np.mean((before - now) ** 2))) < TOLERANCE


def _drawn_by(command: str, drawn: str) -> bytes:
    with tempfile.TemporaryDirectory() as results:
        words = [*shlex.split(command), "--out", results]
        run = subprocess.run(
            [sys.executable, "-m", "flexmech", *words],
            capture_output=True,
            text=True,
            cwd=REPOSITORY,
            env=environment(),
        )
        if run.returncode:
            raise RuntimeError(f"{command}: exit code {run.returncode}: {run.stderr.strip()}")
        return (Path(results) / drawn).read_bytes()


def _photograph(page: Path, picture: Path) -> bool:
    """Photograph the top of a page in a browser; false where there is none."""
    executable = installed_browser()
    if executable is None:
        if is_required():
            raise RuntimeError(MISSING)
        return False
    # A browser that root runs has no sandbox.
    quiet = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars")
    with tempfile.TemporaryDirectory() as profile:
        subprocess.run(
            [
                *(executable, *quiet, f"--user-data-dir={profile}"),
                f"--window-size={WINDOW[0]},{WINDOW[1]}",
                *("--virtual-time-budget=5000", f"--screenshot={picture}", page.as_uri()),
            ],
            check=True,
            capture_output=True,
            timeout=300,
        )
    return True
