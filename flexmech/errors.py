"""The two kinds of failure that a user can meet, each with one clear message."""

from __future__ import annotations

__all__ = ["ComputationError", "FlexmechError", "InputError"]


class FlexmechError(Exception):
    """Base of every error that flexmech raises on purpose.

    The message names what is wrong (file, key or crank angle) and the remedy.
    """

    exit_code = 1


class InputError(FlexmechError, ValueError):
    """What was asked for cannot be: a wrong file, value, option or geometry."""

    exit_code = 2


class ComputationError(FlexmechError, RuntimeError):
    """What was asked for is well posed, but the computation failed."""

    exit_code = 1
