"""Links of the README and of the pages lead somewhere, and the README answers its readers."""

from __future__ import annotations

import re
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]
DOCS = REPOSITORY / "docs"
MADE = ("_build", "made")
FENCED = re.compile(r"^(`{3,})[^\n`]*\n.*?^\1 *$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"(?<!\\)\]\(([^)\s]+)\)")
LABEL = re.compile(r"^(?:\$\$ ?)?\(([\w-]+)\)=?$", re.MULTILINE)
HEADING = re.compile(r"^#{1,6} +(.*)$", re.MULTILINE)
# Questions that a reader of the README has answered within two links, and where.
ANSWERS = {
    "my own linkage, in rpm": "docs/how_to/own_linkage.md#my-own-linkage-in-rpm",
    "which speed to avoid": "docs/how_to/avoid_speeds.md#which-speed-to-avoid",
    "how sure is that": "docs/theory/errors.md#how-sure-is-that",
    "why frozen damping ratios turn negative": (
        "docs/theory/damping.md#why-frozen-damping-ratios-can-be-negative"
    ),
    "how do I cite it": "docs/how_to/cite.md#how-do-i-cite-it",
}


def written_pages() -> list[Path]:
    """README, the guide for contributors and the pages of ``docs/`` that somebody wrote."""
    pages = [path for path in DOCS.rglob("*.md") if path.relative_to(DOCS).parts[0] not in MADE]
    return [REPOSITORY / "README.md", REPOSITORY / "CONTRIBUTING.md", *sorted(pages)]


def prose_of(page: Path) -> str:
    """A page without its blocks of code."""
    return FENCED.sub("", page.read_text())


def links_of(page: Path) -> list[str]:
    return LINK.findall(prose_of(page))


def anchors_of(page: Path) -> set[str]:
    plain = (
        re.sub(r"[^\w\- ]", "", text.strip().lower()) for text in HEADING.findall(prose_of(page))
    )
    return {text.replace(" ", "-") for text in plain}


def test_links_lead_somewhere() -> None:
    labels = {label for page in written_pages() for label in LABEL.findall(page.read_text())}
    for page in written_pages():
        for link in links_of(page):
            if "://" in link or link.startswith("mailto:"):
                continue
            target, _, anchor = link.partition("#")
            if not target and anchor in labels:
                continue
            path = (page.parent / target).resolve() if target else page
            if path.is_relative_to(DOCS) and path.relative_to(DOCS).parts[0] in MADE:
                continue  # made when the pages are built, where a link to nothing is an error
            assert path.exists(), f"{page.name}: {link}"
            if anchor:
                assert anchor in anchors_of(path), f"{page.name}: {link}"


def test_the_readme_answers_its_readers() -> None:
    links = set(links_of(REPOSITORY / "README.md"))
    for question, answer in ANSWERS.items():
        assert answer in links, question
        path, _, anchor = answer.partition("#")
        assert anchor in anchors_of(REPOSITORY / path), question
