"""A program that writes sets of files into one folder until it is stopped.

Used as ``python writer.py FOLDER MARK``: every file of a set holds the mark and the number of the
set. It imports no more than the files' own room, so that it starts at once.
"""

from __future__ import annotations

import sys
from itertools import count
from pathlib import Path

from flexmech.files import moved_into

NAMES = [*(f"table_{n}.csv" for n in range(8)), "below/table.csv"]


def main(folder: Path, mark: str) -> None:
    for number in count():
        with moved_into(folder) as temporary:
            (temporary / "below").mkdir()
            for name in NAMES:
                (temporary / name).write_text(f"{mark} {number}")
        if not number:
            sys.stdout.write("ready\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])
