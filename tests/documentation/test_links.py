"""Links inside the README and the documentation lead somewhere."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.documentation.pages import (
    DOCS,
    MADE,
    REPOSITORY,
    anchors_of,
    labels,
    links_of,
    prose_of,
    written_pages,
)

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


@pytest.mark.parametrize(
    "page", written_pages(), ids=lambda page: str(page.relative_to(REPOSITORY))
)
def test_links_lead_somewhere(page: Path) -> None:
    for link in links_of(page):
        if "://" in link or link.startswith("mailto:"):
            continue
        target, _, anchor = link.partition("#")
        if not target and anchor in labels():
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


def test_the_readme_is_short_and_shows_pictures() -> None:
    readme = REPOSITORY / "README.md"
    assert len(prose_of(readme).split()) < 600
    pictures = [link for link in links_of(readme) if link.endswith((".png", ".svg"))]
    assert len(pictures) == 3
    assert all((REPOSITORY / picture).is_file() for picture in pictures)


def test_no_address_leads_nowhere() -> None:
    """The project has no address yet, so none is printed."""
    for page in [*written_pages(), REPOSITORY / "pyproject.toml"]:
        assert "github.com/flexmech" not in page.read_text()
