"""Command line: the only place that prints, shows progress or exits.

Heavy modules are imported inside the commands, so that ``flexmech --help`` answers at once.
"""

from flexmech.cli.app import app, main

__all__ = ["app", "main"]
