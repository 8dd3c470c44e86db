"""Seeds of the random campaigns, which turn with the commit."""

from __future__ import annotations

import subprocess
from functools import cache
from pathlib import Path

# Where there is no repository.
FALLBACK = "0448"


@cache
def commit() -> str:
    """Hexadecimal name of the commit that is checked out."""
    try:
        asked = ["git", "rev-parse", "HEAD"]
        done = subprocess.run(asked, cwd=Path(__file__).parent, capture_output=True, text=True)
    except OSError:
        return FALLBACK
    return done.stdout.strip() if done.returncode == 0 else FALLBACK


def turning_seeds(count: int, of: int) -> list[int]:
    """Consecutive seeds below ``of``, others at each commit; all of them in turn.

    They stand in the name of each test, so that ``pytest NAME[seed]`` of the same commit draws the
    mechanism again.
    """
    first = int(commit()[:8], 16) * count % of
    return [(first + n) % of for n in range(count)]
