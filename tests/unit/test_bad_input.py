"""Wrong model files and command lines: each is refused with its file, its key and the remedy."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flexmech.cli import app
from flexmech.crank_values import MOST_ANGLES, MOST_SPEEDS
from flexmech.errors import InputError
from flexmech.modelfile import load_mechanism, mechanism_from_toml, template

FOUR_BAR = template("four-bar")
# What stands before the first of several errors.
MANY = "(?:[0-9]+ errors: )?"
ARM = template("rotating-arm")
MATERIAL = '[materials.aluminium]\nyoungs_modulus = "70 GPa"\n'
ROCKER = FOUR_BAR[FOUR_BAR.index("[links.rocker]") : FOUR_BAR.index("# Or a section")]
GENERAL = """[links.rocker]
section = "general"
axial_stiffness = "3.5e6 N"
bending_stiffness = "1.2 N m^2"
shear_stiffness = "1.1e6 N"
mass_per_length = "0.135 kg/m"
rotary_inertia = "4.5e-8 kg m"
in_plane_thickness = "2 mm"
"""

# What is replaced in the four-bar template, by what, the key that the message must name, and
# what it must say: what was got and the remedy.
WRONG_FOUR_BARS = [
    # Unknown keys, and the nearest known one.
    ('ground = "254 mm"', 'grond = "254 mm"', "linkage.grond", "unknown key.*'ground'"),
    ("[operation]", "[operations]", "operations", "unknown key.*did you mean 'operation'"),
    ("[links.coupler]", "[link.coupler]", "link", "unknown key.*did you mean 'links'"),
    ("youngs_modulus", "young_modulus", "materials.aluminium.young_modulus", "'youngs_modulus'"),
    ("[links.crank]\n", "[links.crank]\nwidth = 3\n", "links.crank.width", "known key|use one of"),
    ("crank_speeds", "crank_speed", "operation.crank_speed", "did you mean 'crank_speeds'"),
    ("gravity", "gravitation", "environment.gravitation", "unknown key.*gravity"),
    ('notes = ""', 'note = ""', "note", "unknown key.*did you mean 'notes'"),
    ("[operation]", "[joints.A]\nmas = '1 g'\n[operation]", "joints.A.mas", "did you mean 'mass'"),
    # Missing keys and tables, and an example of what to add.
    ('crank = "100 mm"\n', "", "linkage.crank", 'missing; add it, for example crank = "279.4 mm"'),
    (
        'kind = "four-bar"',
        "",
        "linkage.kind",
        'missing; add it.*"four-bar", "rotating-arm" or "planar"',
    ),
    ('name = "my four-bar"\n', "", "name", "missing; add it, for example name ="),
    (re.search(r"source = .*\n", FOUR_BAR)[0], "", "source", "missing; add it"),  # type: ignore[index]
    ('density = "2700 kg/m^3"\n', "", "materials.aluminium.density", 'missing.*"7800 kg/m\\^3"'),
    ("poisson_ratio = 0.33\n", "", "materials.aluminium.poisson_ratio", "missing"),
    (ROCKER, "", "links.rocker", r"missing; add a table \[links.rocker\]"),
    (
        ROCKER,
        ROCKER.replace('section = "rectangle"\n', ""),
        "links.rocker.section",
        'missing; add it.*"rectangle", "laminate" or "general"',
    ),
    (ROCKER, ROCKER.replace('material = "aluminium"\n', ""), "links.rocker.material", "missing"),
    (
        ROCKER,
        GENERAL.replace('shear_stiffness = "1.1e6 N"', 'shear_stiffness = "stiff"'),
        "links.rocker.shear_stiffness",
        'number and a unit, for example "4900 N", or "rigid"',
    ),
    ("[operation]", "[joints.A]\n[operation]", "joints.A", "mass is missing"),
    # Names that are not there.
    ('kind = "four-bar"', 'kind = "fourbar"', "linkage.kind", "'fourbar'; did you mean 'four-bar'"),
    ('branch = "open"', 'branch = "opened"', "linkage.branch", "'opened'; did you mean 'open'"),
    ('section = "rectangle"', 'section = "square"', "links.crank.section", "'square'.*rectangle"),
    ('material = "aluminium"', 'material = "aluminum"', "links.crank.material", "'aluminium'"),
    (MATERIAL, "[other]\n", "other", "unknown key"),
    (
        "[links.rocker]",
        "[links.follower]",
        "links.follower",
        "no such link.*crank, coupler, rocker",
    ),
    ("[links.rocker]", "[links.roker]", "links.roker", "did you mean 'rocker'"),
    (
        "[operation]",
        '[joints.O2]\ntorsional_stiffness = "1 N m/rad"\n[operation]',
        "joints.O2",
        "spring in joint O2: it is no pin or pivot; these are",
    ),
    ("[operation]", '[joints.C]\nmass = "1 g"\n[operation]', "joints.C", "no such joint.*O2, A, B"),
    # Units.
    ('"100 mm"', "100", "linkage.crank", 'the number 100, which has no unit.*"279.4 mm"'),
    ('"100 mm"', '"100"', "linkage.crank", "'100', which has no unit; write a length"),
    ('"100 mm"', '"100 kg"', "linkage.crank", "'100 kg'.*is not that of a length"),
    ('"100 mm"', '"0,1 m"', "linkage.crank", "'0,1 m'.*decimal point"),
    ('"100 mm"', '"nan mm"', "linkage.crank", "'nan mm'.*number and a unit"),
    ('"100 mm"', '"inf mm"', "linkage.crank", "'inf mm'.*number and a unit"),
    ('"100 mm"', "nan", "linkage.crank", "number nan, which has no unit"),
    ('"100 mm"', '"1e400 m"', "linkage.crank", "too large; write a smaller number"),
    ('"100 mm"', "true", "linkage.crank", "True, which is not a length"),
    ('"70 GPa"', '"70 gpa"', "materials.aluminium.youngs_modulus", "did you mean 'GPa'"),
    ('"70 GPa"', '"70 kN"', "materials.aluminium.youngs_modulus", "not that of a stress"),
    ('"2700 kg/m^3"', '"2700 kg/m^2"', "materials.aluminium.density", "not that of a density"),
    ('"10 rad/s"', '"5 Hz"', "operation.crank_speeds[0]", 'not an angular speed.*"5 rps"'),
    ('"300 rpm"', "300", "operation.crank_speeds[1]", "has no unit"),
    ('["0 m/s^2"', '["0 m/s"', "environment.gravity[0]", "not that of an acceleration"),
    # Values out of bounds.
    ('"100 mm"', '"-100 mm"', "linkage.crank", "must be positive, got '-100 mm'"),
    ('"100 mm"', '"0 mm"', "linkage.crank", "must be positive, got '0 mm'"),
    ('"4 mm"', '"0 mm"', "links.crank.in_plane_thickness", "must be positive"),
    ('"25 mm"', '"-25 mm"', "links.crank.out_of_plane_width", "must be positive"),
    ('"70 GPa"', '"-70 GPa"', "materials.aluminium.youngs_modulus", "must be positive"),
    ('"2700 kg/m^3"', '"0 kg/m^3"', "materials.aluminium.density", "must be positive"),
    ("0.33", "0.5", "materials.aluminium.poisson_ratio", "between -1 and 0.5, got 0.5"),
    ("0.33", "nan", "materials.aluminium.poisson_ratio", "'nan'.*write a ratio"),
    ('"4 mm"', '"1e-200 mm"', "links.crank.in_plane_thickness", "lies between 1 nm and 1 m"),
    ('"4 mm"', '"16 m"', "links.crank.in_plane_thickness", "did you mean '16 mm'"),
    ('"4 mm"', '"1e6 mm"', "links.crank.in_plane_thickness", "lies between 1 nm and 1 m"),
    ('"100 mm"', '"6e-5 mm"', "linkage.crank", "a length here lies between 0.1 µm and 1 km"),
    ('"100 mm"', '"1e-160 inch"', "linkage.crank", "check the number and its unit"),
    ('"100 mm"', f'"1 {"m*" * 1000}m"', "linkage.crank", "the unit .* is unknown"),
    ('"100 mm"', '"1 m^9^9^9"', "linkage.crank", "the unit 'm.9.9.9' is unknown"),
    ('"70 GPa"', '"70 Pa"', "materials.aluminium.youngs_modulus", "did you mean '70 GPa'"),
    (
        '"70 GPa"',
        '"3.76e-9 GPa"',
        "materials.aluminium.youngs_modulus",
        "between 1 kPa and 1e6 GPa",
    ),
    ('"10 rad/s"', '"1e308 rad/s"', "operation.crank_speeds[0]", "at most 1e6 rad/s"),
    # Geometry.
    ('coupler = "280 mm"', 'coupler = "900 mm"', "linkage", "cannot be assembled.*shorten it"),
    # Damping.
    (MATERIAL, MATERIAL + "damping_ratio = 0.01\n", "materials.aluminium", "damping_frequency"),
    (
        MATERIAL,
        MATERIAL + 'damping_frequency = "50 Hz"\n',
        "materials.aluminium",
        "damping_frequency is given without damping_ratio; give both",
    ),
    (
        MATERIAL,
        MATERIAL + 'damping_time = "1e-5 s"\ndamping_ratio = 0.01\n',
        "materials.aluminium",
        "both given; keep damping_time",
    ),
    (
        MATERIAL,
        MATERIAL + 'damping_time = "-1e-5 s"\n',
        "materials.aluminium.damping_time",
        "must be zero or positive",
    ),
    (
        MATERIAL,
        MATERIAL + 'damping_ratio = 1.5\ndamping_frequency = "50 Hz"\n',
        "materials.aluminium.damping_ratio",
        "must be at least 0 and less than 1, got 1.5",
    ),
    (
        MATERIAL,
        MATERIAL + 'damping_ratio = 0.01\ndamping_frequency = "300 rad/s"\n',
        "materials.aluminium.damping_frequency",
        'not a frequency.*"50 Hz"',
    ),
    # Point masses.
    (
        "[links.rocker]",
        '[[links.coupler.point_masses]]\nposition = "281 mm"\nmass = "1 g"\n[links.rocker]',
        "links.coupler.point_masses[0].position",
        "beyond the end of the coupler; choose 0 to 0.28 m",
    ),
    (
        "[links.rocker]",
        '[[links.coupler.point_masses]]\nposition = "-1 mm"\nmass = "1 g"\n[links.rocker]',
        "links.coupler.point_masses[0].position",
        "must be zero or positive",
    ),
    (
        "[links.rocker]",
        '[[links.coupler.point_masses]]\nposition = "1 mm"\nmass = "-1 g"\n[links.rocker]',
        "links.coupler.point_masses[0].mass",
        "must be zero or positive",
    ),
    (
        "[links.rocker]",
        '[links.coupler.point_masses]\nposition = "1 mm"\nmass = "1 g"\n[links.rocker]',
        "links.coupler.point_masses",
        "write a list",
    ),
    # The wrong kind of value.
    ("[operation]", "joints = 3\n[operation]", "environment.joints", "unknown key"),
    ('name = "my four-bar"', "name = 4", "name", "got 4; write text in quotes"),
    ('name = "my four-bar"', 'name = " "', "name", "text that is not empty"),
    ('["10 rad/s", "300 rpm"]', '"10 rad/s"', "operation.crank_speeds", "write a list"),
    (
        '["0 m/s^2", "0 m/s^2"]',
        '["0 m/s^2"]',
        "environment.gravity[1]",
        "missing; give one more value",
    ),
    ('["0 m/s^2", "0 m/s^2"]', '["0 N", "0 N", "0 N"]', "environment.gravity", "give 2"),
    # A general section, and its keys.
    (ROCKER, GENERAL + 'material = "aluminium"\n', "links.rocker.material", "unknown key"),
    (
        ROCKER,
        GENERAL.replace("1.2 N m^2", "1.2 N m"),
        "links.rocker.bending_stiffness",
        "not that of a bending stiffness",
    ),
    (
        ROCKER,
        GENERAL.replace("4.5e-8 kg m", "0 kg m"),
        "links.rocker.rotary_inertia",
        "must be positive",
    ),
    # Not TOML; the line is named.
    ('"100 mm"', "100 mm", "is not valid TOML", r"at line \d+.*in quotes"),
    ("[linkage]", "[linkage", "is not valid TOML", r"at line \d+"),
    ('name = "my four-bar"', 'name = "a"\nname = "b"', "is not valid TOML", r"at line \d+"),
]


def _identity(case: tuple[str, str, str, str]) -> str:
    return f"{case[2]}: {case[3]}"[:60]


@pytest.mark.parametrize("case", WRONG_FOUR_BARS, ids=_identity)
def test_wrong_four_bar_files_are_refused(case: tuple[str, str, str, str], tmp_path: Path) -> None:
    old, new, key, message = case
    assert old in FOUR_BAR
    file = tmp_path / "wrong.toml"
    file.write_text(FOUR_BAR.replace(old, new, 1), encoding="utf-8")
    result = CliRunner().invoke(app, ["frequencies", str(file), "--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert result.stdout == ""
    expected = rf"error: {re.escape(str(file))}: {MANY}{re.escape(key)}:? .*(?:{message})"
    assert re.match(expected, result.stderr, re.DOTALL), result.stderr
    assert result.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


WRONG_ARMS = [
    ('length = "300 mm"', 'crank = "300 mm"', "linkage.crank", "unknown key.*length"),
    ('length = "300 mm"', "", "linkage.length", "missing"),
    ('"20 mm"', '"-20 mm"', "linkage.hub_radius", "must be zero or positive"),
    ('"20 mm"', '"20 deg"', "linkage.hub_radius", "not that of a length"),
    ("[links.arm]", "[links.crank]", "links.crank", "no such link; use one of arm"),
    ("[operation]", '[joints.A]\nmass = "1 g"\n[operation]', "joints.A", "no such joint.*O2"),
]


@pytest.mark.parametrize("case", WRONG_ARMS, ids=_identity)
def test_wrong_arm_files_are_refused(case: tuple[str, str, str, str]) -> None:
    old, new, key, message = case
    assert old in ARM
    with pytest.raises(InputError, match=rf"^arm\.toml: {MANY}{re.escape(key)}: .*{message}"):
        mechanism_from_toml(ARM.replace(old, new, 1), "arm.toml")


def test_there_are_more_than_55_wrong_files() -> None:
    assert len({case[1:] for case in WRONG_FOUR_BARS} | {case[1:] for case in WRONG_ARMS}) > 55


def test_lines_of_broken_toml_are_counted_right() -> None:
    text = FOUR_BAR.replace('"100 mm"', "100 mm", 1)
    line = next(i for i, row in enumerate(text.split("\n"), 1) if "100 mm" in row)
    with pytest.raises(InputError, match=rf"at line {line}, column"):
        mechanism_from_toml(text)


def test_files_that_are_not_there_or_no_text(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nothing\.toml: there is no such file; check the path"):
        load_mechanism(tmp_path / "nothing.toml")
    with pytest.raises(InputError, match="is a folder; name a model file"):
        load_mechanism(tmp_path)
    latin = tmp_path / "latin.toml"
    latin.write_bytes('name = "x"\nsource = "Müller"\n'.encode("latin-1"))
    with pytest.raises(InputError, match=r"latin\.toml: line 2 is not UTF-8 text; save"):
        load_mechanism(latin)
    empty = tmp_path / "empty.toml"
    empty.write_text("")
    with pytest.raises(InputError, match=r"4 errors: name: is missing.* \| links: is missing"):
        load_mechanism(empty)


def test_files_that_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Taking the permission away would not stop the superuser, as whom tests often run.
    def refuse(_: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    file = tmp_path / "locked.toml"
    file.write_text(FOUR_BAR)
    monkeypatch.setattr(Path, "read_bytes", refuse)
    with pytest.raises(InputError, match=r"locked\.toml: cannot be read \(Permission denied\)"):
        load_mechanism(file)


def test_unknown_kind_of_template() -> None:
    with pytest.raises(InputError, match="'four_bar'; did you mean 'four-bar'"):
        template("four_bar")


# Arguments after "frequencies MODEL", and what the message on stderr must say.
WRONG_COMMAND_LINES = [
    (["--speeds", ""], "--speeds: .*a value is missing"),
    (["--speeds", "0,,10"], "--speeds: .*a value is missing"),
    (["--speeds", "fast"], "--speeds: got 'fast'.*\"20 rad/s\""),
    (["--speeds", "5 Hz"], '--speeds: .*is a frequency.*"5 rps"'),
    (["--speeds", "10 m/s"], "--speeds: .*not that of an angular speed"),
    (["--speeds", "300 RPM"], "--speeds: .*did you mean 'rpm'"),
    (["--speeds", "nan"], "--speeds: got 'nan'"),
    (["--speeds", "inf"], "--speeds: got 'inf'"),
    (["--speeds", "1e999"], "--speeds: .*too large"),
    (["--speeds", "0,10,10"], "--speeds: .*10 rad/s appears twice; give each speed once"),
    (["--speeds", "60 rpm,1 rps"], "--speeds: .*1 rps appears twice"),
    (["--speeds", "0,50 rpm,100"], '--speeds: .*once, at the end: "0,50,100 rpm"'),
    (["--speeds", "10 rad/s,50,100 rpm"], "--speeds: .*give each value its unit"),
    (["--speeds", "0:100:0.001 rpm"], f"--speeds: .*at most {MOST_SPEEDS} values"),
    (["--angles", ""], "--angles: .*a value is missing"),
    (["--angles", "0:360"], "--angles: .*has 2 parts; write START:STOP:STEP"),
    (["--angles", "0:360:5:1"], "--angles: .*has 4 parts"),
    (["--angles", "0:360:0"], "--angles: .*STEP must be positive"),
    (["--angles", "0:360:-5"], "--angles: .*STEP must be positive"),
    (["--angles", "360:0:5"], "--angles: .*STOP must not be less than START"),
    (["--angles", "0:360:1e-9"], f"--angles: .*at most {MOST_ANGLES} values"),
    (["--angles", "0:nan:5"], "--angles: got 'nan'"),
    (["--angles", "0:360:5 mm"], "--angles: .*not that of an angle"),
    (["--angles", "::"], "--angles: .*a value is missing"),
    (["--angles", "0,10,10"], "--angles: .*10 follows 10.*increasing order"),
    (["--angles", "0,20,10"], "--angles: .*10 follows 20.*increasing order"),
    (["--angles", "a,b"], "--angles: got 'a'"),
    (["--modes", "0"], "--modes"),
    (["--modes", "-1"], "--modes"),
    (["--modes", "many"], "--modes"),
    (["--elements", "0"], "--elements"),
    (["--elements", "2.5"], "--elements"),
    (["--engine", "ansys"], "--engine.*'reference', 'exudyn', 'both'"),
    (
        ["--element", "shell"],
        "--element.*'euler', 'timoshenko', 'reddy', 'zigzag', 'ancf', 'geometrically-exact'",
    ),
    (["--prestress", "some"], "--prestress.*'none', 'axial', 'equilibrium'"),
    (
        ["--engine", "reference", "--element", "ancf"],
        "--element ancf .*engine, which has euler, .*, reddy, zigzag; choose --engine exudyn",
    ),
    (["--engine", "reference", "--element", "geometrically-exact"], "choose --engine exudyn"),
    (["--engine", "exudyn", "--element", "euler"], "which has ancf, geometrically-exact"),
    (["--rotation-term"], "No such option.*--rotation-terms"),
    (
        ["--rotation-terms", "coriolis,gyroscopic"],
        "--rotation-terms: .*'gyroscopic' is no rotation term; write all, none, or a comma list "
        "of coriolis, centripetal, tangential",
    ),
    (["--speed", "10"], "No such option.*--speeds"),
    (["--speeds"], "--speeds.*requires an argument"),
    (["another.toml"], "[Uu]nexpected extra argument"),
]


@pytest.mark.parametrize(("arguments", "message"), WRONG_COMMAND_LINES, ids=str)
def test_wrong_command_lines_are_refused(
    arguments: list[str], message: str, tmp_path: Path
) -> None:
    file = tmp_path / "model.toml"
    file.write_text(FOUR_BAR, encoding="utf-8")
    out = tmp_path / "out"
    result = CliRunner().invoke(app, ["frequencies", str(file), "--out", str(out), *arguments])
    assert result.exit_code == 2
    assert result.stdout == ""
    assert re.search(message, " ".join(result.stderr.split())), result.stderr
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["frequencies"], "Missing argument"),
        (["frequency", "model.toml"], "No such command"),
        (["check"], "Missing argument"),
        (["check", "nothing.toml"], r"nothing\.toml: there is no such file"),
        (["new"], "Missing argument"),
        (["new", "four-bar"], "Missing argument"),
        (["new", "eight-legs", "x.toml"], "no example 'eight-legs'; use one of four-bar"),
        (["new", "four-bar", "no/such/folder/x.toml"], "there is no folder"),
        (["new", "four-bar", "."], "is a folder; name a file"),
        (["schema", "--out", "no/such/folder/x.json"], "there is no folder"),
        (["schema", "--out", "."], "is a folder; name a file"),
        (["--verbose"], "No such option"),
    ],
    ids=str,
)
def test_wrong_commands_are_refused(
    arguments: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 2
    assert re.search(message, " ".join(result.stderr.split())), result.stderr
    assert list(tmp_path.iterdir()) == []


def test_result_folders_that_cannot_be_written_are_refused_at_once(tmp_path: Path) -> None:
    model = tmp_path / "model.toml"
    model.write_text(FOUR_BAR, encoding="utf-8")
    taken = tmp_path / "taken"
    (taken / "frequencies.csv").mkdir(parents=True)
    for out, message in (
        (model, r"cannot write to .*model\.toml \(Not a directory\); choose a folder"),
        (model / "below", r"cannot write to .*below \(Not a directory\); choose a folder"),
        (tmp_path / ("x" * 300), r"File name too long"),
        (taken, r"frequencies\.csv is a folder there; remove it or choose another one"),
    ):
        result = CliRunner().invoke(app, ["frequencies", str(model), "--out", str(out)])
        assert result.exit_code == 2
        assert re.search(rf"error: --out.*{message}", result.stderr), result.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["model.toml", "taken"]


def test_new_never_replaces_a_file_unasked(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("precious")
    result = CliRunner().invoke(app, ["new", "four-bar", str(file)])
    assert result.exit_code == 2
    assert "exists already; choose another name, or --force" in result.stderr
    assert file.read_text() == "precious"
