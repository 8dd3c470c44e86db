"""Build the documentation: ``python docs/build.py [--fresh | --sessions [PAGE ...]]``.

The first page is then ``docs/_build/html/index.html``.

Pages whose code runs keep what it gave until flexmech, its models or the versions beneath it
change; ``--fresh`` runs everything again. Any warning or error of code ends the build with 1.

``--sessions`` builds nothing: it runs the sessions of the tutorials (some five minutes), or of the
pages that are named, and writes the lines that their commands print today into the pages.
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

from making.sessions import session_pages, write_sessions  # noqa: E402


def build(*, fresh: bool) -> int:
    """Build the pages as HTML; the exit code of Sphinx."""
    if fresh:
        for made in ("_build", "made"):
            shutil.rmtree(HERE / made, ignore_errors=True)
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
    asked = parser.parse_args()
    if asked.sessions is not None:
        pages = [page for page in session_pages() if page.stem in asked.sessions]
        for page in write_sessions(pages or session_pages()):
            print(f"changed: {page.relative_to(HERE)}")  # noqa: T201
    else:
        sys.exit(build(fresh=asked.fresh))
