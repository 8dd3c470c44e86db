"""Numbers of every analysis on several mechanisms, against those that are stored.

What the commands of ``cases.toml`` write into CSV files and print as JSON is compared with
``stored/``. ``tests/physics`` and ``tests/engines`` say that these numbers are right; here they
are kept from changing unnoticed.
"""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.command import Ended, columns_of, run_command

HERE = Path(__file__).parent
CASES = tomllib.loads((HERE / "cases.toml").read_text(encoding="utf-8"))
THOROUGH = CASES.pop("thorough")
# Rows of a table that are stored, evenly spread.
ROWS = 24
# Relative to a number, to the greatest of its column, and in SI units: round-off of other builds
# of LAPACK.
RELATIVE, OF_THE_GREATEST, ABSOLUTE = 1e-6, 1e-9, 1e-12
# Columns that differ by more from one build to another: the same three.
LOOSER = {
    # Estimated errors and what differs by them are small differences of great numbers.
    r".*(error|difference|gap|coherence).*": (0.02, 1e-6, 1e-12),
    # Poles are fitted to noise.
    r"hammer (identified.csv|printed): .*": (1e-4, 1e-6, 1e-12),
    # Limits of an index of 1 by a bootstrap of few samples, whose ties round-off decides.
    r"uncertainty sensitivity.csv: .*_(low|high)": (0.02, 0.0, 0.02),
    # Without damping they are round-off.
    r".*damping_ratio": (1e-6, 1e-9, 1e-10),
}
# Phases of what does not vibrate, the frequency of a rotation that nothing holds, and how many
# designs a search has tried when it is that far, which round-off decides.
LEFT_OUT = r".*_phase_deg|.*shaft.csv: (frequency|growth).*|optimize history.csv: (eval|row).*"

Stored = dict[str, Any]


@pytest.mark.parametrize(
    ("command", "case"),
    [
        pytest.param(
            command,
            case,
            id=f"{command}-{case}",
            marks=[pytest.mark.thorough] if f"{command}-{case}" in THOROUGH else [],
        )
        for command in CASES
        for case in CASES[command]
    ],
)
def test_numbers_are_those_that_are_stored(
    command: str, case: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    words = shlex.split(CASES[command][case].replace("golden:", f"{HERE}/models/"))
    ended = run_command(tmp_path, command, *words, "--json", "--no-plots")
    assert ended.exit_code == 0, ended.stderr
    numbers = numbers_of(ended)
    store = HERE / "stored" / f"{command}-{case}.json"
    if request.config.getoption("force_regen"):
        store.write_text(text_of(numbers), encoding="utf-8")
    assert differences(command, json.loads(store.read_text(encoding="utf-8")), numbers) == []


def numbers_of(ended: Ended) -> Stored:
    """Columns of all tables, and the printed numbers with their errors."""
    tables = {}
    for path in sorted(ended.folder.rglob("*.csv")):
        columns = columns_of(path)
        rows = len(next(iter(columns.values())))
        kept = np.unique(np.linspace(0, max(rows - 1, 0), min(rows, ROWS)).round().astype(int))
        tables[str(path.relative_to(ended.folder))] = {
            name: column[kept].tolist() for name, column in columns.items()
        } | {"rows": [rows]}
    printed = json.loads(ended.stdout)["numbers"]
    # A name that is printed twice stands in the order of the list.
    names = [f"{number['name']} of {number['of']} in {number['unit']}" for number in printed]
    tables["printed"] = {
        "name": names,
        "value": [number["value"] for number in printed],
        "error": [number["error"] for number in printed],
    }
    return tables


def differences(command: str, stored: Stored, numbers: Stored) -> list[str]:
    """Tables and columns that are missing or differ; more of them are no difference."""
    names = {
        f"{command} {table}: {column}": (table, column)
        for table in stored
        for column in stored[table]
    }
    deviations = {
        name: _deviation(name, column, stored[table], numbers.get(table, {}))
        for name, (table, column) in names.items()
    }
    return [
        f"{name}: {d}" for name, d in deviations.items() if d and not re.fullmatch(LEFT_OUT, name)
    ]


def _deviation(name: str, column: str, stored: Stored, numbers: Stored) -> str | None:
    if column not in numbers:
        return "is missing"
    before, now = np.array(stored[column], object), np.array(numbers[column], object)
    if before.shape != now.shape:
        return f"{len(before)} rows are {len(now)}"
    try:
        before, now = before.astype(float), now.astype(float)
    except ValueError:
        wrong = before != now
        return f"{before[wrong][0]!r} is {now[wrong][0]!r}" if wrong.any() else None
    tolerances = (looser for pattern, looser in LOOSER.items() if re.fullmatch(pattern, name))
    relative, of_the_greatest, absolute = next(tolerances, (RELATIVE, OF_THE_GREATEST, ABSOLUTE))
    finite = np.isfinite(before) & np.isfinite(now)
    greatest = np.max(np.abs(before), initial=0.0, where=np.isfinite(before))
    allowed = relative * np.abs(before) + of_the_greatest * greatest + absolute
    if "error" in column:
        # An error of round-off is of no size: a ten-millionth of the number itself counts as none.
        allowed += 1e-7 * np.abs(np.array(stored.get("value", np.zeros(len(before))), float))
    # An amplification without damping is infinite.
    apart = np.full(now.shape, np.inf)
    apart[finite] = np.abs(now[finite] - before[finite])
    apart[before == now] = 0.0
    if column.endswith("angle_deg"):
        apart = np.minimum(apart, np.abs(360.0 - apart))
    near = finite & (apart <= allowed)
    wrong = ~(near | (before == now) | (np.isnan(now) & np.isnan(before)))
    if not wrong.any():
        return None
    row = int(np.argmax(np.where(wrong, np.nan_to_num(apart / allowed, nan=np.inf), 0.0)))
    return f"row {row}: {before[row]!r} is {now[row]!r}"


def text_of(numbers: Stored) -> str:
    """JSON with a line for each column, its numbers to eleven digits."""

    def digits(value: Any) -> Any:
        return float(f"{value:.11g}") if isinstance(value, float) else value

    tables = [
        f"{json.dumps(table)}: {{\n"
        + ",\n".join(
            f"  {json.dumps(name)}: {json.dumps([digits(value) for value in column])}"
            for name, column in columns.items()
        )
        + "\n}"
        for table, columns in numbers.items()
    ]
    return "{\n" + ",\n".join(tables) + "\n}\n"
