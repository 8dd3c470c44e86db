"""The pages of the documentation, and what stands in them."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]
DOCS = REPOSITORY / "docs"
MADE = ("_build", "made")

sys.path.insert(0, str(DOCS))
from making.sessions import FENCED  # noqa: E402

LINK = re.compile(r"(?<!\\)\]\(([^)\s]+)\)")
LABEL = re.compile(r"^(?:\$\$ ?)?\(([\w-]+)\)=?$", re.MULTILINE)
HEADING = re.compile(r"^#{1,6} +(.*)$", re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """A block of code in a page: its language and its text."""

    language: str
    text: str


def written_pages() -> list[Path]:
    """README, the guide for contributors and the pages of ``docs/`` that somebody wrote."""
    pages = [path for path in DOCS.rglob("*.md") if path.relative_to(DOCS).parts[0] not in MADE]
    return [REPOSITORY / "README.md", REPOSITORY / "CONTRIBUTING.md", *sorted(pages)]


def blocks_of(page: Path) -> list[Block]:
    """Blocks of code of a page, those that are executed when it is built among them."""
    found = []
    for match in FENCED.finditer(page.read_text()):
        language, text = match[2].strip(), match[3]
        if language.startswith("{code-cell}"):
            # Options of a cell; no line of Python begins so.
            lines = text.splitlines(keepends=True)
            text = "".join(line for line in lines if not line.startswith(":"))
            language = "cell"
        found.append(Block(language, text))
    return found


def prose_of(page: Path) -> str:
    """A page without its blocks of code."""
    return FENCED.sub("", page.read_text())


def links_of(page: Path) -> Iterator[str]:
    """Targets of the links and pictures of a page."""
    yield from (match[1] for match in LINK.finditer(prose_of(page)))


def anchors_of(page: Path) -> set[str]:
    """Anchors that the headings of a page have, on a public forge and in the built pages."""
    return {_anchor(heading) for heading in HEADING.findall(prose_of(page))}


def labels() -> set[str]:
    """Labels of places and equations, which a link of any page may name."""
    return {label for page in written_pages() for label in LABEL.findall(page.read_text())}


def _anchor(heading: str) -> str:
    plain = re.sub(r"[^\w\- ]", "", heading.strip().lower())
    return plain.replace(" ", "-")
