"""Random command lines and model files: each runs, or is refused in one line that says where.

Drawn from a seed, run in this process. ``FLEXMECH_FUZZ=10000`` asks for so many cases in the
thorough suite, and ``FLEXMECH_FUZZ_SEED`` for others.
"""

from __future__ import annotations

import os
import random
import re
import warnings
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from flexmech import InputError
from flexmech.cli import app
from flexmech.modelfile import KINDS, mechanism_from_toml, template
from tests.support.command import MODELS

SHIPPED = (
    *("aluminium_fourbar", "composite_fourbar", "moist_composite_fourbar", "neat_resin_figure_8"),
    *("rotating_arm", "slider_crank", "watt_six_bar", "carton_pusher", "steel_fourbar"),
)
PUSHER = (MODELS / "carton_pusher.toml").read_text(encoding="utf-8")
TEXTS = [
    *(template(kind) for kind in KINDS),
    *((MODELS / f"{name}.toml").read_text(encoding="utf-8") for name in SHIPPED),
    *(path.read_text(encoding="utf-8") for path in (MODELS.parent / "tests/data").glob("e*.toml")),
    # Rigid links alone: only their motion is known.
    re.sub(
        r"(?m)^material = .*\nsection = .*\n(in|out)_.*\n(in|out)_.*\n", "rigid = true\n", PUSHER
    ),
]
RECORD = "crank_angle_deg,mode,frequency_Hz\n" + "\n".join(
    f"{angle},{mode},{44 + 4 * mode}" for mode in (1, 2) for angle in range(0, 360, 60)
)
CASES = int(os.environ.get("FLEXMECH_FUZZ", "100"))
SEED = int(os.environ.get("FLEXMECH_FUZZ_SEED", "1"))
BLOCK = 12

NUMBERS = (
    *("0", "-1", "1", "2.5", "1e-300", "1e300", "1e308", "1e-160", "1e400", "-0", "007", "1,5"),
    *("nan", "inf", "", " ", "9" * 5000, "1e-3000000", "0x10", "1_000", "99999999999999999999"),
)
UNITS = (
    *("mm", "m", "inch", "GPa", "Pa", "MPa", "kg", "g", "kg/m^3", "deg", "rad", "rad/s", "rpm"),
    *("Hz", "s", "ms", "day", "K", "degC", "%", "percent", "1/K", "m^2/s", "kJ/mol", "N", "", "µ"),
    *("*".join(["m"] * 1000), "m^9^9", "furlong", "\x1b[31m", "m/s/s", "mm mm"),
)
NAMES = (
    *("crank", "coupler", "rocker", "arm", "A", "O2", "name\x1b[31m", "two\nlines", "\u202ename"),
    *("文", "x" * 20_000, "", " ", "a.b", "$\\frac", "[red]", "'", "é", "\x00"),
)
KEYS = ("youngs_modulus", "grond", "mass", "\x1b[2J", "type", "damping_ratio", "density", "name")
NAMED = re.compile(
    r"\.toml|\.csv|--[a-z]|crank angle|crank_angle|stdout|links\.|No such command|Missing"
)


def quoted(draw: random.Random) -> str:
    """A value of a model file."""
    kind = draw.randrange(6)
    text = f"{draw.choice(NUMBERS)} {draw.choice(UNITS)}"
    if kind == 0:
        text = draw.choice(NAMES)
    if kind == 1:
        return draw.choice(("1", "-1.5", "true", "nan", "[]", "{}", "[1, 2]", "inf", "1e400"))
    if kind == 2:
        text = f"{10 ** draw.uniform(-12, 12):.4g} {draw.choice(UNITS[:24])}"
    letters = (c if c.isprintable() and c not in '"\\' else f"\\u{ord(c):04x}" for c in text)
    return f'"{"".join(letters)}"'


def mutated(text: str, draw: random.Random) -> str:
    """The model file with one thing changed, or a number by a power of ten: a slip of a unit."""
    quantities = list(re.finditer(r"(?<==) *\"(-?[0-9.e-]+) ([^\"]+)\"", text))
    if draw.random() < 0.7 and quantities:
        found = draw.choice(quantities)
        number = float(found[1]) * 10.0 ** draw.choice((-9, -6, -3, -1, 1, 3, 6, 9, 12))
        return f'{text[: found.start()]} "{number:g} {found[2]}"{text[found.end() :]}'
    lines = text.split("\n")
    written = [n for n, line in enumerate(lines) if " = " in line and not line.startswith("#")]
    at = draw.choice(written)
    key, value = lines[at].split(" = ", 1)
    lines[at] = draw.choice(
        (
            *(f"{key} = {quoted(draw)}", f"{key} = {quoted(draw)}"),
            *(f"{draw.choice(KEYS)} = {value}", "", f"{lines[at]}\n{lines[at]}"),
            *(f"[{draw.choice(('links.crank', 'x', 'joints.A', 'plies'))}]", draw.choice(NAMES)),
        )
    )
    return "\n".join(lines)


def damaged(text: str, draw: random.Random) -> str:
    """A record with a cell, a line or its heading changed, or as it is."""
    lines = text.split("\n")
    at = draw.randrange(len(lines))
    cells = lines[at].split(",")
    cells[draw.randrange(len(cells))] = draw.choice((*NUMBERS, *NAMES[:6]))
    changed = draw.choice((lines[at], ",".join(cells), "", draw.choice(NAMES)))
    return "\n".join([*lines[:at], changed, *lines[at + 1 :]])


STATE = {"temperature-rise": ("20", "50 K", "-30 degC"), "moisture": ("1", "2 %", "101")}
SMALL = {"elements": ("1", "2"), "modes": ("1", "2")}
RUN = {
    "speed": ("10", "100 rpm", "-5"),
    "revolutions": ("0.05", "0.1"),
    "step": ("1 ms", "2 ms"),
    "samples": ("60", "100"),
}
# What a command is always asked with, and what now and then, by its options.
ALWAYS: dict[str, dict[str, tuple[str, ...]]] = {
    "frequencies": {
        "engine": ("reference", "reference", "exudyn", "both"),
        "angles": ("0", "0,90", "0:90:45", "10 deg,200 deg"),
        "elements": ("1", "2"),
    },
    "campbell": {
        "speeds": ("0,10", "0:30:15 rpm", "20", "0:5000:2500 rpm"),
        "angles": ("0:360:60", "0,90,180"),
        **SMALL,
    },
    "stability": {
        "speeds": ("10", "20,30", "-20,-10", "100:300:100 rpm", "0,10"),
        "damping-ratio": ("1%", "0.05", "0", "2"),
        **SMALL,
    },
    "hammer": {"angle": ("0", "0,90"), "damping-ratio": ("5%", "0.1", "0"), "elements": ("1",)},
    "compare": {"speed": ("0", "10", "100 rpm")},
    "report": {
        "include": ("frequencies", "section", "frequencies,section", "moisture"),
        "speeds": ("0,10", "20"),
        "angles": ("0,90", "0:360:120"),
        "elements": ("1",),
    },
    "export": {**RUN, "elements": ("1", "2")},
    "response": {**RUN, "engine": ("reference", "reference", "exudyn"), "elements": ("1", "2")},
    "coupler-curve": {"point": ("33 mm,320 deg", "0.1 m,45 deg")},
    "moisture": {"relative-humidity": ("85", "50 %", "100"), "time": ("30 day", "1 h", "1e9 s")},
}
SOMETIMES: dict[str, dict[str, tuple[str, ...]]] = {
    "frequencies": {
        "speeds": ("0,10", "100 rpm", "0:20:10", "5000 rpm"),
        "prestress": ("none", "axial", "equilibrium"),
        "element": ("euler", "timoshenko", "reddy", "ancf"),
        "rotation-terms": ("all", "coriolis", "centripetal,tangential"),
        "mass": ("lumped", "distributed"),
        "shaft": ("free", "prescribed"),
        "modes": ("1", "2", "12"),
        **STATE,
    },
    "campbell": {"orders": ("1:3", "2", "1,4", "0"), "prestress": ("none", "axial"), **STATE},
    "stability": {
        "prestress": ("axial", "equilibrium"),
        "steps": ("auto", "64", "100"),
        "frame": ("link", "inertial"),
    },
    "hammer": {
        "impact": ("coupler:0.5", "crank:1", "arm:0.5", "rocker:2"),
        "response": ("coupler:0.5", "rocker:0.3", "arm:1"),
        "direction": ("transverse", "axial"),
        "bandwidth": ("100", "2 kHz", "0"),
        "pulse": ("1 ms", "1", "1e-9"),
        "noise": ("1%", "-1"),
        "averages": ("1", "2", "0"),
    },
    "compare": {
        "angle": ("0", "45 deg"),
        "fit": ("none", "stiffness:coupler", "damping", "offset"),
        "quantity": ("frequency", "coupler_mid_strain", "coupler:0.5"),
    },
    "report": STATE,
    "export": {"start": ("rigid", "equilibrium"), **STATE},
    "response": {"start": ("rigid", "equilibrium"), "run-up": ("0.01", "1e-300"), **STATE},
    "check": {"angle": ("0", "90", "400 deg")},
    "coupler-curve": {"angles": ("0:360:10", "0:90:5"), **STATE},
    "kinematics": {
        "speed": ("10", "100 rpm", "-5", "0"),
        "angles": ("0:360:10", "0,90", "-30"),
        "lumped": ("1,4,4", "2", "1,0,4", "4,4"),
    },
    "moisture": {"temperature": ("80", "353 K"), "link": ("crank", "rocker")},
    "section": {"link": ("crank", "arm"), **STATE},
}


def words(draw: random.Random, model: str, out: str) -> Iterator[str]:
    """A small analysis by sensible options, of which some are anything."""
    name = draw.choice(sorted(SOMETIMES))
    yield from (name, model)
    if name == "compare":
        record = Path(f"{out}.csv")
        record.write_text(damaged(RECORD, draw), encoding="utf-8")
        yield str(record)
    chosen = dict(ALWAYS.get(name, {}))
    chosen |= {k: v for k, v in SOMETIMES[name].items() if draw.random() < 0.35}
    for option, values in chosen.items():
        odd = draw.choice((*NUMBERS, *NAMES)) + draw.choice(("", f" {draw.choice(UNITS)}"))
        yield from (f"--{option}", draw.choice(values) if draw.random() < 0.94 else odd)
    yield from ("--out", f"{out}.html" if name == "report" else out)
    if name not in ("report", "export"):
        yield "--no-plots"


def check(typed: list[str]) -> None:
    """It runs without a warning, or ends in one line that names a file, an option or an angle."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        done = CliRunner().invoke(app, typed)
    told = f"{typed}\n{done.stderr[-600:]}"
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise AssertionError(told) from done.exception
    assert done.exit_code in (0, 1, 2), told
    assert not caught, f"{told}\n{caught[0].message} {caught[0].filename}:{caught[0].lineno}"
    for printed in (done.stdout, done.stderr):
        assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\u202e]", printed), told
    if done.exit_code == 0:
        assert all(line.startswith("warning: ") for line in done.stderr.splitlines()), told
        return
    assert done.stdout == "", told
    assert done.stderr.startswith("error: "), told
    assert done.stderr.count("\n") == 1, told
    assert len(done.stderr) < 6000, told
    assert NAMED.search(done.stderr), told
    assert not re.search(r"Traceback|<[A-Za-z]+\.[a-z]+: '|object at 0x", done.stderr), told


@pytest.mark.thorough
@pytest.mark.parametrize("block", range((CASES + BLOCK - 1) // BLOCK))
def test_any_command_line_and_model_file_runs_or_is_refused_in_one_line(block, tmp_path):
    broken = []
    for number in range(block * BLOCK, min(CASES, (block + 1) * BLOCK)):
        draw = random.Random(f"{SEED}/{number}")
        text = draw.choice(TEXTS)
        for _ in range(draw.choice((0, 0, 1, 1, 1, 2))):
            text = mutated(text, draw)
        model = tmp_path / f"model_{number}.toml"
        model.write_text(text, encoding="utf-8")
        try:
            check(list(words(draw, str(model), str(tmp_path / "out"))))
        except AssertionError as error:
            broken.append(f"case {number}: {error} {error.__cause__!r}")
    assert not broken, "\n\n".join(broken)


VALUES = st.recursive(
    st.sampled_from(['"a"', "1", "1.5", "true", "[]", "nan"]),
    lambda inner: (
        st.lists(inner, max_size=3).map(lambda items: f"[{', '.join(items)}]")
        | st.dictionaries(
            st.sampled_from(["kind", "crank", "section", "material", "mass"]), inner, max_size=3
        ).map(lambda table: "{" + ", ".join(f"{k} = {v}" for k, v in table.items()) + "}")
    ),
    max_leaves=6,
)
TABLES = st.dictionaries(
    st.sampled_from(["name", "source", "linkage", "links", "materials", "joints", "x"]), VALUES
).map(lambda tables: "\n".join(f"{key} = {value}" for key, value in tables.items()))


@given(st.text(max_size=40) | TABLES)
def test_any_text_is_refused_as_a_model_file_by_its_name(text):
    with pytest.raises(InputError, match=r"^any\.toml: "):
        mechanism_from_toml(text, "any.toml")


# Found by it with another seed: an odd length of a model, or an odd number of a record.
FOUND = {
    "round-off of unreduced matrices": ('"4.25 mm"', '"4.25e-6 mm"', "60,1,48", "check"),
    "squares that overflow": ("", "", "60,1,1e-160", "compare"),
}


@pytest.mark.parametrize("name", FOUND)
def test_what_it_has_found(name, tmp_path):
    old, new, row, command = FOUND[name]
    model, record = tmp_path / "model.toml", tmp_path / "record.csv"
    text = (MODELS / "steel_fourbar.toml").read_text(encoding="utf-8")
    model.write_text(text.replace(old, new, 1), encoding="utf-8")
    record.write_text(f"{RECORD.replace('60,1,48', row)}\n", encoding="utf-8")
    more = [str(record), "--speed", "10"] if command == "compare" else []
    check([command, str(model), *more, "--out", str(tmp_path / "out"), "--no-plots"])
