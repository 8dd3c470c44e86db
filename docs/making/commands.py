"""The command reference, from the help of the commands."""

from __future__ import annotations

import re
import subprocess
import sys

from making.state import REPOSITORY, environment

__all__ = ["command_page"]

HEAD = """# Commands

What `flexmech COMMAND --help` says, on one page. Every command ends with exit code 0, with 1 where
a computation fails, with 2 where something asked for cannot be, 130 after Ctrl-C and 143 after
SIGTERM. Speeds are a comma list or `START:STOP:STEP` with one unit at the end for all of them
(`"0:900:10 rpm"`); without a unit they are rad/s. Angles are degrees.

"""
ASKED = ("utils", "docs", "--name", "flexmech")


def command_page() -> str:
    """Markdown of all commands and their options."""
    made = subprocess.run(
        [sys.executable, "-m", "typer", "flexmech.cli.application", *ASKED],
        check=True,
        capture_output=True,
        text=True,
        cwd=REPOSITORY,
        env=environment(),
    ).stdout
    # The list of commands is the table of contents of the page.
    body = made[made.index("## `flexmech ") :]
    return HEAD + re.sub(r"\{(MODEL|FILE)\}", r"\1", body)
