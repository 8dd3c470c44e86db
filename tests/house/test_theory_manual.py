"""The theory manual and the code name the same equations and the same functions."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import flexmech

ROOT = Path(flexmech.__file__).parent
MANUAL = ROOT.parent / "docs" / "theory"
SOURCE_PAGE = MANUAL / "sources.md"
ERRATA = ROOT.parent / "docs" / "errata.md"

# How texts name a source, and what the manual calls it. "K" stands alone in docstrings too.
SOURCES = {
    r"Kumar & Chandrakar|\bK(?=, eqs?\.)": "K",
    r"Elamy et al\. 2023": "E",
    r"Singh & Sanyal 2022": "S",
    r"\bJones\b": "Jones",
    r"\bCrank(?='s eq|,)": "Crank",
    r"Ruhe 1973": "Ruhe",
    r"JCGM 100:2008": "JCGM",
}
NUMBER = r"\d+(?:\.\d+)?"
NUMBERS = (
    rf"{NUMBER}(?:\s*\([^()]*\))?"
    rf"(?:\s*(?:,\s*and|,|and|to|-|\u2013)\s*{NUMBER}(?:\s*\([^()]*\))?)*"
)
CITATION = re.compile(rf"\b(?:[Ee]qs?\.|[Ee]quations?)\s+\(?({NUMBERS})")
TAG = re.compile(r"\\tag\{([^}]*)\}")
NAME = re.compile(r"\bflexmech(?:\.[A-Za-z_]\w*)+")


def numbers_in(text: str) -> Iterator[str]:
    """Numbers of equations in a list such as ``1.35 (alpha3), 1.37-1.42 and 2``."""
    bare = re.sub(r"\([^()]*\)", " ", text)
    for first, last in re.findall(rf"({NUMBER})(?:\s*(?:-|\u2013|to)\s*({NUMBER}))?", bare):
        yield first
        if last:
            chapter, dot, start = first.rpartition(".")
            stop = last.rpartition(".")[2]
            yield from (f"{chapter}{dot}{n}" for n in range(int(start) + 1, int(stop) + 1))


def cited(text: str) -> set[tuple[str, str]]:
    """Source and number of every equation that a text cites.

    The source is named right behind ("eq. 1.58 of Kumar & Chandrakar"), or last before.
    """
    found = set()
    for citation in CITATION.finditer(text):
        before, behind = text[: citation.start()], text[citation.end() :]
        places = [(m.start(), s) for name, s in SOURCES.items() for m in re.finditer(name, text)]
        last = [short for start, short in sorted(places) if start < len(before)][-1:]
        after = [short for name, short in SOURCES.items() if re.match(rf" of (?:{name})", behind)]
        assert after or last, f"no source is named of {citation.group()!r}"
        found |= {((after or last)[0], number) for number in numbers_in(citation.group(1))}
    return found


def texts(path: Path) -> str:
    """All strings of a file, docstrings and messages, each on one line."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    constants = (node for node in ast.walk(tree) if isinstance(node, ast.Constant))
    strings = [(node.lineno, node.value) for node in constants if isinstance(node.value, str)]
    return "\n".join(" ".join(text.split()) for _, text in sorted(strings))


def tagged() -> set[tuple[str, str]]:
    """Source and number of every equation that the manual shows."""
    found = set()
    for page in sorted(MANUAL.glob("*.md")):
        for tag in TAG.findall(page.read_text(encoding="utf-8")):
            for part in tag.split(";"):
                short, _, rest = part.strip().partition(" ")
                found |= {(short, number) for number in numbers_in(rest)}
    return found


class SourceRow(NamedTuple):
    """A row of the table of equations: the source, its numbers, and both other cells."""

    source: str
    equations: str
    place: str
    words: str

    def numbers(self) -> list[tuple[str, str]]:
        return [(self.source, number) for number in numbers_in(self.equations)]


def source_rows() -> list[SourceRow]:
    """Rows of numbered equations of the page of sources."""
    page = SOURCE_PAGE.read_text(encoding="utf-8")
    cells = re.findall(r"^\| (\w+) (\d[^|]*) \| ([^|]*) \| ([^|]*) \|$", page, re.MULTILINE)
    return [SourceRow(*row) for row in cells]


def tabulated() -> set[tuple[str, str]]:
    """Source and number of every row that leads to an equation of the manual."""
    shown = (row for row in source_rows() if re.match(r"\[[^]]*\]\(#", row.place))
    return {number for row in shown for number in row.numbers()}


def starred() -> set[tuple[str, str]]:
    """Source and number of every equation that the page of sources marks as misprinted."""
    return {
        (row.source, number)
        for row in source_rows()
        for number in re.findall(rf"({NUMBER})\*", row.equations)
    }


def misprinted() -> set[tuple[str, str]]:
    """Source and number of every equation in the tables of the errata."""
    found = set()
    text = ERRATA.read_text(encoding="utf-8")
    for section in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        short = section.partition(":")[0]
        for cell in re.findall(r"^\| ([^|]*) \| [^|]* \| [^|]* \|", section, re.MULTILINE):
            found |= {(short, n) for n in re.findall(r"^\d\.\d+|(?<=\()\d+(?=\))", cell)}
    return found


def named_in_manual() -> list[str]:
    pages = [*MANUAL.glob("*.md"), ERRATA]
    return sorted({n for page in pages for n in NAME.findall(page.read_text(encoding="utf-8"))})


def resolved(name: str) -> Any:
    """What a dotted name stands for; raises where there is none."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            value: Any = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            fields = getattr(value, "__dataclass_fields__", {})
            annotated = inspect.get_annotations(value) if isinstance(value, type) else {}
            if part in fields or part in annotated:
                return value
            value = getattr(value, part)
        return value
    raise AssertionError(name)


def test_every_cited_equation_is_in_the_manual() -> None:
    everywhere: set[tuple[str, str]] = set()
    for path in sorted(ROOT.rglob("*.py")):
        everywhere |= cited(texts(path))
    assert {short for short, _ in everywhere} == set(SOURCES.values())
    assert sorted(everywhere - tagged()) == []


def test_every_equation_of_the_manual_is_in_its_table() -> None:
    assert sorted(tagged() ^ tabulated()) == []


# How far each paper counts; E gives four of its numbers twice.
NUMBERED = {
    "K": [f"1.{n}" for n in range(1, 66)],
    "E": [str(n) for n in (*range(1, 50), 43, 44, 45, 46)],
    "S": [str(n) for n in range(1, 13)],
}


def test_every_numbered_equation_of_the_papers_has_its_row() -> None:
    for paper, numbers in NUMBERED.items():
        rows = [number for row in source_rows() for number in row.numbers() if row.source == paper]
        assert sorted(number for _, number in rows) == sorted(numbers), paper


def test_stars_are_the_misprints_of_the_errata() -> None:
    assert sorted(starred() ^ misprinted()) == []
    # What stands in the manual is marked there too.
    shown = {
        (part.strip().partition(" ")[0], number)
        for page in sorted(MANUAL.glob("*.md"))
        for tag in TAG.findall(page.read_text(encoding="utf-8"))
        for part in tag.split(";")
        for number in re.findall(rf"({NUMBER})\*", part)
    }
    assert sorted(shown ^ (starred() & tagged())) == []


def test_anchors_of_the_table_stand_before_equations() -> None:
    pages = "\n".join(page.read_text(encoding="utf-8") for page in MANUAL.glob("*.md"))
    wanted = set(re.findall(r"\]\(#([\w-]+)\)", SOURCE_PAGE.read_text(encoding="utf-8")))
    assert sorted(wanted - set(re.findall(r"^\(([\w-]+)\)=$", pages, re.MULTILINE))) == []


def test_every_name_in_the_manual_exists() -> None:
    for name in named_in_manual():
        assert resolved(name) is not None, name


def test_every_page_is_in_the_table_of_contents() -> None:
    index = (MANUAL / "index.md").read_text(encoding="utf-8")
    listed = re.findall(r"^(\w+)$", index.split("```")[1], re.MULTILINE)
    assert set(listed) == {page.stem for page in MANUAL.glob("*.md")} - {"index"}
