"""Sessions in the pages: commands with the lines that they print, and files changed in between.

A page holds its session in blocks, in the order of the work. A block ``console`` has commands
behind ``$ ``, each followed by what it prints on a terminal; a block ``diff`` has the lines of a
file that the user changes, a ``{code-block}`` with a ``:caption:`` the whole file of that name. All
are text of the page, which ``python docs/build.py --sessions``
brings up to date and every build compares with a run of its own.
"""

from __future__ import annotations

import hashlib
import re
import shlex
import shutil
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from making.printed import difference
from making.state import REPOSITORY, cache_folder, on_a_terminal

__all__ = [
    "FENCED",
    "run_session",
    "session_failures",
    "session_pages",
    "session_pictures",
    "session_results",
    "steps_of",
    "write_sessions",
]

# A fenced block: its fence, what stands behind it, and its lines.
FENCED = re.compile(r"^(`{3,})([^\n`]*)\n(.*?)^\1 *$", re.MULTILINE | re.DOTALL)
# Behind the line of its name and an empty one.
WHOLE_FILE = re.compile(r":caption: (\S+)\n\n(.*)", re.DOTALL)
PROMPT = "$ "
PRINTED = "printed.md"
"""File of the page with what its session prints today, beside what the session wrote."""
# A slider whose line runs through the shaft's axis has equal extremes at several crank angles.
SYMMETRIC = ("slider_crank",)


@dataclass(frozen=True)
class Step:
    """A command line with what the page says that it prints, or the change of a file."""

    kind: str
    """``console``, ``diff`` or ``file``."""
    text: str
    """The command line as it is typed behind its prompt, or the lines of the change or file."""
    printed: str = ""


def session_pages() -> list[Path]:
    """Pages that hold a session."""
    tutorials = sorted((REPOSITORY / "docs" / "tutorials").glob("*.md"))
    return [page for page in tutorials if any(steps_of(page.read_text()))]


def steps_of(text: str) -> Iterator[Step]:
    """Commands and changes of a page's text, in their order."""
    for block in FENCED.finditer(text):
        kind, lines = block[2].strip(), block[3]
        if kind == "diff":
            yield Step(kind, lines)
        elif WHOLE_FILE.fullmatch(lines):
            yield Step("file", lines)
        elif kind == "console":
            yield from _commands(lines)


def _commands(lines: str) -> Iterator[Step]:
    before, *commands = re.split(rf"^{re.escape(PROMPT)}", lines, flags=re.MULTILINE)
    if before.strip():
        raise ValueError(f"printed lines without a command: {before.splitlines()[0]!r}")
    for command in commands:
        line, _, printed = command.partition("\n")
        while line.endswith("\\"):  # it goes on behind the second prompt
            more, _, printed = printed.partition("\n")
            line += f"\n{more}"
        yield Step("console", line, printed)


def run_session(text: str, folder: Path) -> str:
    """Run the session of a page in a folder; the page's text with what is printed now."""

    def up_to_date(block: re.Match[str]) -> str:
        kind = block[2].strip()
        if kind == "diff":
            _change(block[3], folder)
        if whole := WHOLE_FILE.fullmatch(block[3]):
            (folder / whole[1]).write_text(whole[2])
        if kind != "console":
            return block[0]
        printed = [f"{PROMPT}{s.text}\n{_printed_by(s.text, folder)}" for s in _commands(block[3])]
        return f"{block[1]}{block[2]}\n{''.join(printed)}{block[1]}"

    return FENCED.sub(up_to_date, text)


def _printed_by(line: str, folder: Path) -> str:
    """What a command line of flexmech prints when it is run in a folder, ending in a new line."""
    program, *arguments = shlex.split(re.sub(r"\\\n> *", "", line))
    if program != "flexmech":
        raise ValueError(f"a session has commands of flexmech alone: {line}")
    code, printed = on_a_terminal(*arguments, folder=folder)
    if code:
        raise RuntimeError(f"{PROMPT}{line}: exit code {code}: {printed}")
    # No page needs the spaces at the ends of lines.
    return "".join(f"{line.rstrip()}\n" for line in printed.splitlines())


def _change(diff: str, folder: Path) -> None:
    """Change a file as the lines say: ``--- FILE``, ``+++ FILE``, and parts parted by ``@@``."""
    before, after, *lines = diff.splitlines()
    name = before.removeprefix("--- ")
    if before == name or after != f"+++ {name}":
        raise ValueError(f"a change begins with '--- FILE' and '+++ FILE', not {before!r}")
    text = (folder / name).read_text()
    for part in re.split(r"^@@.*$", "\n".join(lines), flags=re.MULTILINE):
        changed = part.strip("\n").splitlines()
        if not changed:
            continue
        old = "".join(f"{line[1:]}\n" for line in changed if line[:1] != "+")
        new = "".join(f"{line[1:]}\n" for line in changed if line[:1] != "-")
        # Whole lines: the part begins where a line of the file does.
        if (found := f"\n{text}".count(f"\n{old}")) != 1:
            raise ValueError(f"{name} has these lines {found} times, not once:\n{old}")
        text = f"\n{text}".replace(f"\n{old}", f"\n{new}")[1:]
    (folder / name).write_text(text)


def write_sessions(pages: list[Path]) -> list[Path]:
    """Run the sessions of pages and write what they print into them; the pages that changed."""
    # Each command is a process of its own, for which a thread waits. A page is written when its
    # session has ended, whatever becomes of the others.
    with ThreadPoolExecutor() as waiting:
        changed = list(waiting.map(_write_session, pages))
    return [page for page, differs in zip(pages, changed, strict=True) if differs]


def _write_session(page: Path) -> bool:
    """Run the session of a page and write what it prints into it; whether that changed it."""
    text = page.read_text()
    with TemporaryDirectory() as folder:
        now = run_session(text, Path(folder))
    page.write_text(now)
    return now != text


def session_results(page: Path) -> Path:
    """Folder of what a page's session wrote; it runs only if the folder is not there yet."""
    text = page.read_text()
    typed = "\n".join(step.text for step in steps_of(text))
    digest = hashlib.sha256(typed.encode()).hexdigest()[:8]
    folder = cache_folder() / "sessions" / f"{page.stem}-{digest}"
    if folder.exists():
        return folder
    started = folder.with_name(f"{folder.name}.unfinished")
    shutil.rmtree(started, ignore_errors=True)
    started.mkdir(parents=True)
    (started / PRINTED).write_text(run_session(text, started))
    started.rename(folder)
    return folder


def session_failures(page: Path) -> list[str]:
    """Commands of a page that print something else today, or the one that fails."""
    try:
        today = (session_results(page) / PRINTED).read_text()
    except (RuntimeError, ValueError) as error:
        return [f"{page.name}: {error}"]
    found = []
    for here, now in zip(steps_of(page.read_text()), steps_of(today), strict=True):
        differs = difference(here.printed, now.printed, symmetric=page.stem in SYMMETRIC)
        if differs:
            found.append(f"{page.name}: {PROMPT}{here.text}: {differs}")
    return found


def session_pictures(folder: Path) -> None:
    """Put the pictures of the sessions into a folder, a folder in it for each page."""
    for page in session_pages():
        results = session_results(page)
        for picture in results.rglob("*.png"):
            target = folder / page.stem / picture.relative_to(results)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(picture, target)
