"""Build the documentation: ``python docs/build.py [--fresh]``.

The first page is then ``docs/_build/html/index.html``.

First all code of the README and the pages runs once: blocks, sessions of the tutorials, scenarios,
the verification. Printed sessions are held against their pages, and numbers of scenarios against
``scenarios/expected_numbers.toml``. A message names page, block and command of what fails or
differs, and the build ends with exit code 1, as it does after any warning of Sphinx. What was
computed is kept in ``docs/_build/kept/``, with numbers in files ``numbers.json``, until flexmech,
its models or the versions beneath it change; ``--fresh`` runs everything again.

``--sessions`` builds nothing: it runs the sessions of the tutorials (some five minutes), or of the
pages that are named, and writes the lines that their commands print today into the pages.
``--campaigns`` runs the scenarios that take too long for a build and keeps what they give in
``docs/kept/``. ``--pictures`` draws the pictures of ``docs/pictures/`` anew: a build compares them.
``--papers`` writes ``docs/figures_of_the_papers.md`` and its pictures from the scenarios.
``--columns`` writes the tables of ``docs/files.md`` as the schemas of the results have them.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from pathlib import Path

from sphinx.cmd.build import main as sphinx_build

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from making.blocks import block_failures  # noqa: E402
from making.columns import PAGE, with_columns  # noqa: E402
from making.figures_of_the_papers import write_page  # noqa: E402
from making.gallery import CAMPAIGNS, keep_campaign  # noqa: E402
from making.pages import run_everything  # noqa: E402
from making.pictures import README, write_pictures  # noqa: E402
from making.sessions import session_pages, write_sessions  # noqa: E402


def build(*, fresh: bool) -> int:
    """Run all code and build the pages as HTML; the exit code."""
    if fresh:
        for made in ("_build", "made"):
            shutil.rmtree(HERE / made, ignore_errors=True)
    failures = run_everything()
    for failure in failures:
        print(f"error: {failure}", file=sys.stderr)  # noqa: T201
    if failures:
        return 1
    pages = HERE / "_build" / "html"
    # Pages whose code runs are read in as many processes as there are cores.
    jobs = ["-j", str(os.cpu_count() or 1)]
    return sphinx_build(["-W", "--keep-going", "-q", *jobs, "-b", "html", str(HERE), str(pages)])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--fresh", action="store_true", help="run all code again")
    what.add_argument(
        "--sessions",
        nargs="*",
        metavar="PAGE",
        choices=[page.stem for page in session_pages()],
        help="write what the sessions of the tutorials print today into the pages",
    )
    what.add_argument("--campaigns", action="store_true", help="run scenarios that take long")
    what.add_argument("--pictures", action="store_true", help="draw docs/pictures/ anew")
    what.add_argument("--papers", action="store_true", help="write the page of the papers' figures")
    what.add_argument("--columns", action="store_true", help="write columns into docs/files.md")
    asked = parser.parse_args()
    if asked.sessions is not None:
        pages = [page for page in session_pages() if page.stem in asked.sessions]
        for page in write_sessions(pages or session_pages()):
            print(f"changed: {page.relative_to(HERE)}")  # noqa: T201
    elif asked.campaigns:
        for name in CAMPAIGNS:
            keep_campaign(name)
    elif asked.pictures:
        if failures := block_failures(README):
            sys.exit("\n".join(failures))
        write_pictures()
    elif asked.papers:
        write_page()
    elif asked.columns:
        PAGE.write_text(with_columns(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    else:
        sys.exit(build(fresh=asked.fresh))
