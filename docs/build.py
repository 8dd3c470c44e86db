"""Build the documentation: ``python docs/build.py [--fresh]``.

The first page is then ``docs/_build/html/index.html``.

Pages whose code runs keep what it gave until flexmech, its models or the versions beneath it
change; ``--fresh`` runs everything again. Any warning or error of code ends the build with 1.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from pathlib import Path

from sphinx.cmd.build import main as sphinx_build

HERE = Path(__file__).parent


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
    parser.add_argument("--fresh", action="store_true", help="run all code again")
    sys.exit(build(fresh=parser.parse_args().fresh))
