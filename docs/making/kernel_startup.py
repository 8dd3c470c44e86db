"""What a notebook kernel does before it runs the cells of a page: plain output of commands."""

import os
import subprocess
import sys

from IPython.core.magic import register_cell_magic

# The kernel asks programs for the colours of a terminal; in a page they print as in a pipe.
for name in ("CLICOLOR", "CLICOLOR_FORCE", "FORCE_COLOR"):
    os.environ.pop(name, None)


@register_cell_magic
def sh(line: str, cell: str) -> None:
    """Run a cell by the shell as ``%%sh`` does, its output in one piece; a failure is an error.

    IPython's own gives the output in pieces, between which the pages would break the lines.
    """
    run = subprocess.run(["sh", "-e", "-c", cell], capture_output=True, text=True)
    sys.stderr.write(run.stderr)
    sys.stdout.write(run.stdout)
    if run.returncode:
        raise RuntimeError(f"exit code {run.returncode}: {run.stderr}")
