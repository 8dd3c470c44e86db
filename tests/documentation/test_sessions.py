"""The sessions in the tutorials are what their commands print, line by line."""

from __future__ import annotations

import difflib
import re
import sys
from pathlib import Path

import pytest

import flexmech
from tests.documentation.pages import DOCS

sys.path.insert(0, str(DOCS))
from making.sessions import Step, run_session, session_pages, steps_of

PAGES = session_pages()
IDS = [page.stem for page in PAGES]
# From a new file to the report, in this order; other commands stand in between.
WHOLE = ["new", "check", "frequencies", "campbell", "response", "report"]
REMEDY = "python docs/build.py --sessions"
# A slider whose line runs through the shaft's axis: extremes are equal at several crank angles, and
# the last bit decides which is named. With another kernel of OpenBLAS (OPENBLAS_CORETYPE=Prescott)
# nothing else of this page changed, and nothing at all of the aluminium four-bar's.
SYMMETRIC = ("slider_crank",)
ANGLE = re.compile(r"\d{1,3}\.\d")


def commands_of(page: Path) -> list[str]:
    """Names of the commands of a page, in their order."""
    steps = steps_of(page.read_text())
    return [step.text.split()[1] for step in steps if step.kind == "console"]


def block(step: Step) -> str:
    """A step as a block of a page."""
    lines = step.text if step.kind == "diff" else f"$ {step.text}\n{step.printed}"
    return f"```{step.kind}\n{lines}```\n"


def test_there_are_the_three_sessions() -> None:
    assert {"slider_crank", "four_bar_of_a_paper", "hot_moist_composite"} <= set(IDS)


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_a_session_goes_from_a_new_file_to_the_report(page: Path) -> None:
    commands = iter(commands_of(page))
    assert all(name in commands for name in WHOLE), list(commands_of(page))


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_every_command_stands_with_what_it_prints(page: Path) -> None:
    empty = [s.text for s in steps_of(page.read_text()) if s.kind == "console" and not s.printed]
    assert not empty, f"{REMEDY} writes what these print: {empty}"


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_the_changes_fit_the_new_file(page: Path, tmp_path: Path) -> None:
    """The new file is as its changes take it, and a model when they are made."""
    steps = [s for s in steps_of(page.read_text()) if s.kind == "diff" or " new " in s.text]
    text = "".join(block(step) for step in steps)
    assert run_session(text, tmp_path) == text
    (model,) = tmp_path.glob("*.toml")
    flexmech.load_mechanism(model)


def test_the_four_bar_is_that_of_the_library(tmp_path: Path) -> None:
    """Cells of the page take the library's, readers the one that they have written."""
    (page,) = (page for page in PAGES if page.stem == "four_bar_of_a_paper")
    steps = [s for s in steps_of(page.read_text()) if s.kind == "diff" or " new " in s.text]
    run_session("".join(block(step) for step in steps), tmp_path)
    written = flexmech.load_mechanism(tmp_path / "four_bar.toml")
    models = DOCS.parent / "models"
    library = flexmech.load_mechanism(models / "aluminium_fourbar.toml")
    assert written.linkage == library.linkage
    assert written.sections == library.sections


PAGE = """Words.

```console
$ flexmech new slider-crank one.toml --crank "40 mm" \\
>     --rod "160 mm"
something else
```

```diff
--- one.toml
+++ one.toml
@@
-length = "160 mm"
+length = "30 mm"
```

```text
$ flexmech nonsense, which is no session
```
"""


def test_printed_lines_are_those_of_today(tmp_path: Path) -> None:
    now = run_session(PAGE, tmp_path)
    assert now == PAGE.replace("something else", "wrote one.toml; next: flexmech check one.toml")
    assert 'length = "30 mm"' in (tmp_path / "one.toml").read_text()


def test_warnings_are_told_before_the_answer(tmp_path: Path) -> None:
    """As on a terminal; and what the file says now is what counts."""
    now = run_session(f"{PAGE}\n```console\n$ flexmech check one.toml\n```\n", tmp_path)
    first = now.rpartition("$ flexmech check one.toml\n")[2].splitlines()[0]
    assert first.startswith("warning: "), first


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('-length = "160 mm"', '-length = "161 mm"', "0 times, not once"),
        ('-length = "160 mm"', "-", "not once"),
        ("+++ one.toml", "+++ two.toml", "'--- FILE' and '\\+\\+\\+ FILE'"),
        ("$ flexmech new", "flexmech new", "printed lines without a command"),
        ("$ flexmech new", "$ rm", "commands of flexmech alone"),
        ("$ flexmech new", "$ flexmech mew", "exit code 2"),
    ],
)
def test_what_cannot_run_is_told(tmp_path: Path, old: str, new: str, message: str) -> None:
    with pytest.raises((RuntimeError, ValueError), match=message):
        run_session(PAGE.replace(old, new), tmp_path)


@pytest.mark.thorough
@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_every_printed_line_is_that_of_the_page(page: Path, tmp_path: Path) -> None:
    text = page.read_text()
    now = run_session(text, tmp_path)
    changed = difflib.unified_diff(
        text.splitlines(), now.splitlines(), page.name, "printed today", n=0, lineterm=""
    )
    same = now == text or (page.stem in SYMMETRIC and same_but_for_ties(text, now))
    assert same, f"{REMEDY} writes into the pages:\n" + "\n".join(changed)


def same_but_for_ties(text: str, other: str) -> bool:
    """Words and numbers in the same order, but for angles of which one is as good as the other."""
    ours, theirs = words_of(text), words_of(other)
    return len(ours) == len(theirs) and all(
        one == two or tied(one, two) for one, two in zip(ours, theirs, strict=True)
    )


def words_of(text: str) -> list[str]:
    """Words and numbers without the frames of tables, which are as wide as what they hold."""
    return re.sub("[\u2500-\u257f]", " ", text).split()


def tied(one: str, two: str) -> bool:
    """Angles of equal extremes: mirrored in the line, turned by half a turn, or both."""
    if not (ANGLE.fullmatch(one) and ANGLE.fullmatch(two)):
        return False
    a, b = float(one), float(two)
    return any(abs(difference) < 0.051 for difference in (within(a - b), within(a + b)))


def within(angle: float) -> float:
    """An angle in degrees, whole half turns taken off."""
    return (angle + 90) % 180 - 90


def test_ties_are_those_of_a_symmetric_linkage() -> None:
    table = "│ both │ 2466.57 │ 270.0 │"
    assert same_but_for_ties(table, "│ both │ 2466.57 │ 90.0 │")
    assert tied("320.3", "39.7")
    assert not tied("320.3", "39.8"), "not the place of an equal extreme"
    assert not same_but_for_ties(table, "│ both │ 2466.58 │ 270.0 │")
    assert not same_but_for_ties(table, "│ both │ 2466.57 │")
    assert not tied("1500", "1320"), "no angle of a table"
