"""Blocks of code of the README and the documentation, run page by page.

Cells of notebooks run when the pages are read. Here run the blocks ``sh`` (commands of flexmech and
of Python), ``toml`` (parts of a model file) and ``python``, in the order of their page. Used as
``python -m making.blocks PAGE`` in a folder of its own; what fails is named by its block.
"""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

from making.sessions import FENCED
from making.state import REPOSITORY, cache_folder, environment

__all__ = ["block_failures", "block_folder", "pages_with_blocks"]

DOCS = REPOSITORY / "docs"
RUN = ("python", "sh", "toml")
# Shown, not run here: output, formulas, and what sessions and cells have.
SHOWN = ("text", "", "math", "console", "diff")
# Parts of a command line that set flexmech up, that CI itself runs, or that show a window.
LEFT_OUT = (
    *("python3 -m venv", ".venv/bin/pip install", "python -m pip install", ". .venv/bin"),
    *("pytest", "tests.faults", "ruff", "mypy", "docs/build.py", "python -m build"),
)


def pages_with_blocks() -> list[Path]:
    """Pages that somebody wrote and that have blocks to run."""
    pages = [REPOSITORY / "README.md", REPOSITORY / "CONTRIBUTING.md"]
    written = (path for path in sorted(DOCS.rglob("*.md")) if not _is_made(path))
    return [page for page in [*pages, *written] if any(kind in RUN for kind, _ in _blocks(page))]


def block_folder(page: Path) -> Path:
    """Folder in which the blocks of a page run, with what they leave there."""
    digest = hashlib.sha256(page.read_bytes()).hexdigest()[:8]
    return cache_folder() / "blocks" / f"{page.stem}-{digest}"


def block_failures(page: Path) -> list[str]:
    """What fails of a page; its blocks run only if they, or what they depend on, have changed."""
    folder = block_folder(page)
    if folder.exists():
        return []
    started = folder.with_name(f"{folder.name}.unfinished")
    shutil.rmtree(started, ignore_errors=True)
    started.mkdir(parents=True)
    for name in ("models", "scenarios", "docs", "tests"):
        (started / name).symlink_to(REPOSITORY / name)
    place = {"PYTHONPATH": os.pathsep.join([str(DOCS), str(REPOSITORY)])}
    ran = subprocess.run(
        [sys.executable, "-m", "making.blocks", str(page)],
        capture_output=True,
        text=True,
        cwd=started,
        env=environment() | place,
    )
    if ran.returncode:
        printed = (ran.stderr.strip() or f"exit code {ran.returncode}").splitlines()
        return [f"{page.relative_to(REPOSITORY)}: {' | '.join(printed[-3:])}"]
    started.rename(folder)
    return []


def _is_made(path: Path) -> bool:
    return path.relative_to(DOCS).parts[0] in ("_build", "made")


def _blocks(page: Path) -> list[tuple[str, str]]:
    """Language and text of the blocks of a page."""
    found = [(block[2].strip(), block[3]) for block in FENCED.finditer(page.read_text())]
    for kind, _ in found:
        if kind not in (*RUN, *SHOWN) and not kind.startswith("{"):
            raise RuntimeError(f"{page.name}: a block of unknown language {kind!r}")
    return found


def _run_page(page: Path) -> None:
    names: dict[str, Any] = {"__name__": "__main__"}
    model = tomllib.loads((REPOSITORY / "models" / "aluminium_fourbar.toml").read_text())
    for number, (kind, text) in enumerate(_blocks(page), 1):
        try:
            if kind == "sh":
                for line in text.replace("\\\n", " ").splitlines():
                    _run_line(line)
            elif kind == "toml":
                model = _with_the_rest(model, text)
            elif kind == "python":
                exec(compile(text, f"block {number}", "exec"), names)
        except Exception as error:
            first = text.strip().partition("\n")[0]
            raise SystemExit(f"block {number} ({kind}: {first}): {error}") from error


def _run_line(line: str) -> None:
    """Run the parts of a command line that are flexmech or Python."""
    for part in line.split("&&"):
        words = shlex.split(part, comments=True)
        command = " ".join(words)
        if not words or any(known in command for known in LEFT_OUT):
            continue
        program = Path(words[0]).name
        if program not in ("flexmech", "python"):
            raise RuntimeError(f"nothing runs {command!r}")
        module = ["-m", "flexmech"] if program == "flexmech" else []
        run = subprocess.run([sys.executable, *module, *words[1:]], capture_output=True, text=True)
        if run.returncode:
            raise RuntimeError(f"{command}: exit code {run.returncode}: {run.stderr.strip()}")


def _with_the_rest(model: dict[str, Any], text: str) -> dict[str, Any]:
    """Model file with a part of a page in it, read; a drawn linkage begins a file of its own."""
    import tomli_w

    from flexmech.modelfile import mechanism_from_toml

    part = tomllib.loads(text)
    if part.get("linkage", {}).get("kind") == "planar":
        model = {"name": "linkage of this page", "source": "this page", **part}
    else:
        model = _merged(model, part)
    mechanism_from_toml(tomli_w.dumps(model))
    return model


def _merged(whole: dict[str, Any], part: dict[str, Any]) -> dict[str, Any]:
    """Tables of both; where both state a value, that of the part.

    A link that states its section is stated whole: other sections have other keys.
    """
    result = dict(whole)
    for key, entry in part.items():
        both = isinstance(entry, dict) and isinstance(whole.get(key), dict)
        both = both and "section" not in entry
        result[key] = _merged(whole[key], entry) if both else entry
    return result


if __name__ == "__main__":
    _run_page(Path(sys.argv[1]))
