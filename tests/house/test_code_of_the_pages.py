"""Refusals of the documentation's build: other printed numbers, code that fails.

The build itself runs all pages: ``python docs/build.py``.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
sys.path.insert(0, str(DOCS))
from making.printed import difference  # noqa: E402
from making.sessions import run_session  # noqa: E402

# What the papers have. K counts its figures from 1.1 on, and behind 1.9 from 2.0; its tables are
# lists without numbers, and so is the one table of S, which the text calls Table 1. What section 3
# of S says of angles has no figure.
PRINTED_IN = {
    "K": [
        *(f"Figure 1.{n}" for n in range(1, 10)),
        *(f"Figure 2.{n}" for n in range(9)),
        "Lists of section 3",
    ],
    "E": [*(f"Figure {n}" for n in range(1, 10)), *(f"Table {n}" for n in range(1, 7))],
    "S": [*(f"Figure {n}" for n in range(1, 13)), "Section 3", "Table 1"],
}
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

```{code-block} text
:caption: motors.csv

name
```
"""


@pytest.mark.parametrize("paper", PRINTED_IN)
def test_every_figure_and_table_of_the_papers_has_one_row(paper: str) -> None:
    rows = tomllib.loads((DOCS / "making" / "figures_of_the_papers.toml").read_text())["rows"]
    found = []
    for row in (row for row in rows if row["paper"] == paper):
        kind, _, rest = row["number"].partition(" ")
        several = kind == "Figures"
        found += [f"Figure {n}" for n in rest.split(", ")] if several else [row["number"]]
        assert bool(row.get("ours") or row.get("table")) != bool(row.get("reason")), row["number"]
    assert sorted(found) == sorted(PRINTED_IN[paper])


@pytest.mark.parametrize(
    ("today", "symmetric", "differs"),
    [
        ("│ both   │ 2466.57 Hz │ 270.0 │ 12 modes", False, ""),
        ("both 2466.58 Hz 270.1 12 modes", False, ""),
        ("both 2470.57 Hz 270.0 12 modes", False, "'2466.57' is printed as '2470.57'"),
        ("both 2466.57 Hz 90.0 12 modes", False, "'270.0' is printed as '90.0'"),
        ("both 2466.57 Hz 90.0 12 modes", True, ""),
        ("both 2466.57 Hz 270.0 13 modes", True, "'12' is printed as '13'"),
        ("both 2466.57 Hz 270.0 12", True, "'modes' is printed as ''"),
    ],
)
def test_printed_lines_are_alike_but_for_round_off(
    today: str, symmetric: bool, differs: str
) -> None:
    page = "│ both │ 2466.57 Hz │ 270.0 │ 12 modes"
    assert difference(page, today, symmetric=symmetric) == differs


def test_a_session_is_written_as_it_is_printed_today(tmp_path: Path) -> None:
    now = run_session(PAGE, tmp_path)
    assert now == PAGE.replace("something else", "wrote one.toml; next: flexmech check one.toml")
    assert 'length = "30 mm"' in (tmp_path / "one.toml").read_text()
    assert (tmp_path / "motors.csv").read_text() == "name\n"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('-length = "160 mm"', '-length = "161 mm"', "0 times, not once"),
        ("$ flexmech new", "flexmech new", "printed lines without a command"),
        ("$ flexmech new", "$ rm", "commands of flexmech alone"),
        ("$ flexmech new", "$ flexmech mew", "exit code 2"),
    ],
)
def test_a_session_that_cannot_run_is_refused(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    with pytest.raises((RuntimeError, ValueError), match=message):
        run_session(PAGE.replace(old, new), tmp_path)


@pytest.mark.parametrize(
    ("block", "told"),
    [
        ("```python\n1 / 0\n```\n", r"block 2 \(python: 1 / 0\): division by zero"),
        ("```sh\npython -c 'raise SystemExit(3)'\n```\n", "block 2 .*: exit code 3"),
        ("```sh\nls\n```\n", "nothing runs 'ls'"),
    ],
)
def test_a_block_that_fails_is_named(block: str, told: str, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"```python\nx = 1\n```\n\n{block}")
    ended = subprocess.run(
        [sys.executable, "-m", "making.blocks", str(page)],
        capture_output=True,
        text=True,
        cwd=DOCS,
        timeout=300,
    )
    assert ended.returncode == 1
    assert re.search(told, ended.stderr)
