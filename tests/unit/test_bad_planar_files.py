"""Wrong files of drawn linkages, loads and springs: each gets its one message."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from flexmech.cli import app
from flexmech.modelfile import mechanism_from_toml, template

SIX_BAR = template("planar")
O2 = 'O2 = ["0 mm", "0 mm"]\n'
# As somebody draws it, without lengths.
SLIDER = (
    template("slider-crank")
    .replace('drawn_at = "0 deg"', 'drawn_at = "90 deg"')
    .replace(O2, f'{O2}A = ["0 mm", "60 mm"]\nB = ["190 mm", "0 mm"]\n')
    .replace('length = "60 mm"\n', "")
    .replace('length = "200 mm"\n', "")
    .replace("offset = ", "# offset = ")
)
LOAD = '[loads.push]\npoint = "D"\nforce = ["1 N", "0 N"]\n\n[environment]'
SPRING = (
    '[springs.s]\npoints = ["D", "O2"]\nstiffness = "1 N/m"\nfree_length = "0 m"\n\n[environment]'
)


def joint(name: str, keys: str) -> tuple[str, str]:
    """A table of a joint before that of the environment."""
    return "[environment]", f"[joints.{name}]\n{keys}\n\n[environment]"


def link(name: str, points: str, keys: str = "rigid = true") -> tuple[str, str]:
    return "[joints.O2]", f"[links.{name}]\npoints = {points}\n{keys}\n\n[joints.O2]"


def load(old: str, new: str) -> tuple[str, str]:
    assert old in LOAD
    return "[environment]", LOAD.replace(old, new)


def spring(old: str, new: str) -> tuple[str, str]:
    assert old in SPRING
    return "[environment]", SPRING.replace(old, new)


# What is replaced in the six-bar, and what the message says.
WRONG_SIX_BARS = [
    # The drive.
    ('kind = "clamp"', 'kind = "pin"', "linkage: no joint is a clamp, so that nothing drives"),
    (*joint("O4", 'kind = "clamp"'), "joints O2 and O4 are clamps: two drives; keep one"),
    ('ground = ["O2", "O4", "O6"]', 'ground = ["O4", "O6"]', "clamp O2 is no point of the ground"),
    (*link("weight", '["O2", "D"]'), "crank, weight meet at the clamp O2; say which are on the"),
    # Chains.
    ('points = ["O6", "D"]', 'points = ["O6", "Z"]', "link output: there is no point 'Z'"),
    ('points = ["O6", "D"]', 'points = ["O6"]', "link output: give the points at its two ends"),
    ('points = ["O6", "D"]', "", "links.output: points is missing; add the points at its two ends"),
    (
        'points = ["A", "B", "C"]',
        'points = ["A", "B", "C", "A"]',
        "link coupler returns to point A; a link is a chain that does not",
    ),
    (
        'ground = ["O2", "O4", "O6"]',
        'ground = ["O2", "O4"]',
        "the chain does not close: link output can still move while the crank stands",
    ),
    (
        'D = ["473.2 mm", "400 mm"]',
        'D = ["473.2 mm", "400 mm"]\nX = ["0 mm", "600 mm"]\nY = ["100 mm", "600 mm"]',
        "point X is used by no link; leave it out or join it",
    ),
    (
        "O6 = [",
        'X = ["0 mm", "600 mm"]\nO6 = [',
        "point X is used by no link",
    ),
    (
        "O6 = [",
        'X = ["300 mm", "500 mm"]\nO6 = [',
        "points X and O6 coincide; give one point one name",
    ),
    ('ground = ["O2"', 'ground = ["Q", "O2"', "ground: there is no point 'Q'; use one of"),
    ('ground = ["O2", "O4", "O6"]', "", "linkage.ground: is missing; add it, for example ground"),
    # Bodies.
    (
        "O6 = [",
        'X = ["0 mm", "600 mm"]\nY = ["100 mm", "600 mm"]\nO6 = [',
        "point X is used by no link",
    ),
    (
        *link("brace", '["A", "D"]'),
        "the chain is redundant at joint [A-Z0-9]+, at crank angle 60 deg as drawn: it is held by",
    ),
    (
        'ground = ["O2", "O4", "O6"]',
        'ground = ["O2", "A", "O4", "O6"]',
        "crank: the chain is redundant at joint A, at crank angle 60 deg",
    ),
    # Joints.
    (*joint("Z", 'kind = "pin"'), "joints.Z: the linkage has no such joint"),
    (*joint("D", 'kind = "hinge"'), "joints.D.kind: got 'hinge'; use one of pin, clamp, weld"),
    (*joint("D", 'kind = "weld"\nlinks = ["output"]'), "joint D welds one link; two or more"),
    (
        *joint("D", 'kind = "weld"\nlinks = ["output", "crank"]'),
        "joint D: link 'crank' does not pass through it; use one of connector, output",
    ),
    (*joint("D", 'links = ["output"]'), "joints.D: joint D is a pin; links belong to a clamp or"),
    (*joint("D", 'direction = "0 deg"'), "joints.D: joint D is a pin; direction and guide belong"),
    (*joint("D", 'inertia = "1 kg m^2"'), "joints.D: inertia belongs to a slider"),
    (*joint("D", 'radial_damping = "1 N s/m"'), "radial_damping needs a radial_stiffness"),
    (*joint("O2", 'torsional_stiffness = "1 N m/rad"'), "is not valid TOML"),
    (
        '[joints.O2]\nkind = "clamp"',
        '[joints.O2]\nkind = "clamp"\nradial_stiffness = "1 N/m"',
        r"joints.O2: spring in joint O2: it is no pin or pivot; these are \[",
    ),
    (*joint("Z", 'radial_stiffness = "1 N/m"'), "joints.Z: the linkage has no such joint"),
    (*joint("D", 'torsional_stiffness = "1 N m"'), "not that of a torsional stiffness"),
    # Links.
    (
        'points = ["O6", "D"]',
        'points = ["O6", "D"]\nrigid = true\nbodies = [{ position = "2 m", mass = "1 g" }]',
        r"links.output.bodies\[0\].position: got 2 m, which is beyond the end of the output",
    ),
    (
        'points = ["A", "B", "C"]',
        'points = ["A", "B", "C"]\npoint_masses = [{ position = "0 m", mass = "1 g", beam = 3 }]',
        r"links.coupler.point_masses\[0\].position: got beam 3, but the coupler has 2",
    ),
    (
        *link("spare", '["D", "O4"]', 'mass = "1 kg"'),
        "links.spare.section: is missing; add it, for example section",
    ),
    (
        *link("spare", '["D", "O4"]', 'rigid = true\nsection = "none"\nmas = "1 kg"'),
        "links.spare.mas: unknown key 'mas'; did you mean 'mass'",
    ),
    (*link("ground", '["D", "O4"]'), "a link cannot be called 'ground' here; rename it"),
    # Loads and springs.
    (*load('point = "D"', 'point = "Z"'), "loads.push: there is no point 'Z'"),
    (*load('point = "D"', ""), "loads.push: give either point, or link and position"),
    (*load('point = "D"', 'position = "0 m"'), "loads.push: position is given without link"),
    (*load('point = "D"', 'link = "connector"\nposition = "9 m"'), "loads.push: got 9 m, which is"),
    (*load('point = "D"', 'point = "D"\ntorque = "1 N m"'), "connector, output meet at D; say on"),
    (
        *load('point = "D"', 'point = "D"\nlink = "crank"'),
        "loads.push: link crank does not pass through D; there are connector, output",
    ),
    (*load('force = ["1 N", "0 N"]', ""), "give either force and torque, or a table, or a file"),
    (*load("force", 'over = "time"\nforce'), "over belongs to a table or file"),
    (
        *load('point = "D"\nforce = ["1 N", "0 N"]', 'point = "A"\nlink = "crank"\nover = "time"\n'
              'table = [["0 s", "1 N"]]'),
        r"loads.push: table\[0\]: got 2 values; give time, force along x and y",
    ),
    (
        *load('point = "D"\nforce = ["1 N", "0 N"]', 'point = "A"\nlink = "crank"\nover = "time"\n'
              'table = [["0 deg", "1 N", "0 N"]]'),
        r"loads.push: table\[0\]: got '0 deg', whose unit 'deg'.*a time",
    ),
    (
        *load('point = "D"\nforce = ["1 N", "0 N"]', 'point = "A"\nlink = "crank"\n'
              'over = "crank_angle"\nfile = "nothing.csv"'),
        "loads.push: file nothing.csv: cannot be read: No such file",
    ),
    (*spring('["D", "O2"]', '["D"]'), "springs.s.points.*is missing; give one more value"),
    (*spring('["D", "O2"]', '["D", 3]'), "springs.s.points.*write the name of a point"),
    (*spring('["D", "O2"]', '["O4", "O2"]'), "has both ends on ground; join two links"),
    (*spring('["D", "O2"]', '["D", "Z"]'), "springs.s: there is no point 'Z'"),
    (*spring("1 N/m", "1 N"), "springs.s.stiffness:.*not that of a spring stiffness"),
]  # fmt: skip

SLIDES = 'kind = "slider"\ndirection = "0 deg"'
GUIDED = 'kind = "slider"\ndirection = "0 deg"\nguide = "rod"'
# What is replaced in the slider-crank.
WRONG_SLIDERS = [
    ('direction = "0 deg"', "", "joints.B: joint B is a slider without direction; give the angle"),
    (SLIDES, GUIDED, "slider B: its guide rod passes through the point itself; a link does not"),
    (SLIDES, GUIDED.replace("rod", "rot"), "slider B: no link 'rot' can guide it; did you mean"),
    ('ground = ["O2"]', 'ground = ["O2", "B"]', "slider B is a point of the ground, which does"),
    ('mass = "0.15 kg"', 'inertia = "1e-5 kg m^2"', "a slider on the ground does not turn; leave"),
    ("rigid = true", "", "links.crank.section: is missing"),
    ('# centre = "25 mm"', 'centre = "90 mm"', "links.crank.centre: got 0.09 m, which is beyond"),
    (
        'A = ["0 mm", "60 mm"]\nB = ["190 mm", "0 mm"]',
        'A = ["0 mm", "60 mm"]\nB = ["0 mm", "260 mm"]',
        "locks at crank angle 90 deg: at joint B rod and its line are in a dead point",
    ),
    (
        "[joints.B]",
        '[links.arm]\npoints = ["C", "D"]\nrigid = true\n\n[joints.B]',
        "link arm: there is no point 'C'",
    ),
    (
        'B = ["190 mm", "0 mm"]',
        'B = ["190 mm", "0 mm"]\nC = ["0 mm", "-1 m"]\nD = ["1 m", "-1 m"]\n[links.arm]\n'
        'points = ["C", "D"]\nrigid = true',
        "link arm is joined to nothing that the crank drives; let it share a point",
    ),
    (
        'B = ["190 mm", "0 mm"]',
        'B = ["190 mm", "0 mm"]\nC = ["250 mm", "90 mm"]\n[links.arm]\n'
        'points = ["B", "C"]\nrigid = true',
        "the chain does not close: link arm can still move while the crank stands",
    ),
]  # fmt: skip


def refusal(text: str, folder: Path) -> str:
    """What the command line says of a file, in one line."""
    file = folder / "wrong.toml"
    file.write_text(text, encoding="utf-8")
    result = CliRunner().invoke(app, ["check", str(file)])
    assert result.exit_code == 2, result.stderr
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    return result.stderr


@pytest.mark.parametrize("case", WRONG_SIX_BARS, ids=lambda case: case[2][:50])
def test_wrong_six_bars_are_refused(case: tuple[str, str, str], tmp_path: Path) -> None:
    old, new, message = case
    assert old in SIX_BAR
    told = refusal(SIX_BAR.replace(old, new, 1), tmp_path)
    assert re.search(message, told), told


@pytest.mark.parametrize("case", WRONG_SLIDERS, ids=lambda case: case[2][:50])
def test_wrong_slider_cranks_are_refused(case: tuple[str, str, str], tmp_path: Path) -> None:
    old, new, message = case
    assert old in SLIDER
    told = refusal(SLIDER.replace(old, new, 1), tmp_path)
    assert re.search(message, told), told


def test_a_guide_that_bends_is_refused(tmp_path: Path) -> None:
    old, new = joint("D", 'kind = "slider"\ndirection = "0 deg"\nguide = "crank"')
    told = refusal(SIX_BAR.replace(old, new, 1), tmp_path)
    assert "slider D: its guide crank is flexible; a line stays straight on a rigid link" in told


def test_a_guide_that_is_welded_to_what_slides_is_refused(tmp_path: Path) -> None:
    text = SLIDER.replace("B = [", 'C = ["100 mm", "200 mm"]\nB = [', 1).replace(
        "[joints.B]",
        '[links.arm]\npoints = ["A", "C"]\nrigid = true\n\n[joints.A]\nkind = "weld"\n'
        'links = ["rod", "arm"]\n\n[joints.B]\nguide = "arm"',
    )
    told = refusal(text, tmp_path)
    assert "slider B: its guide arm is welded to a link that slides; a body does not" in told


def test_keys_of_drawings_have_no_place_in_a_four_bar(tmp_path: Path) -> None:
    four_bar = template("four-bar")
    told = refusal(four_bar.replace("[links.crank]", "[links.crank]\nrigid = true"), tmp_path)
    assert 'links.crank.rigid: leave it out, or draw the linkage with kind = "planar"' in told
    text = four_bar.replace("[environment]", '[joints.A]\nkind = "pin"\n\n[environment]')
    assert "joints.A.kind: leave it out" in refusal(text, tmp_path)


def test_load_files_are_read_beside_the_model_and_refused_line_by_line(tmp_path: Path) -> None:
    old, new = load(
        'point = "D"\nforce = ["1 N", "0 N"]',
        'point = "A"\nlink = "crank"\nover = "crank_angle"\nfile = "push.csv"',
    )
    text = SIX_BAR.replace(old, new, 1)
    file = tmp_path / "push.csv"
    for content, message in (
        ("angle,force\n0,1\n", "its first line must be crank_angle_deg,force_x_N,force_y_N"),
        ("crank_angle_deg,force_x_N,force_y_N\n0,1\n", "line 2 has 2 fields, the first line 3"),
        ("crank_angle_deg,force_x_N,force_y_N\n0,a,1\n", "line 2 has 'a', which is no number"),
        ("crank_angle_deg,force_x_N,force_y_N\n0,nan,1\n", "line 2 has 'nan', which is no number"),
        ("crank_angle_deg,force_x_N,force_y_N\n0,1_0,1\n", "line 2 has '1_0', which is no number"),
        (
            "crank_angle_deg,force_x_N,force_y_N\n0,1e25,1\n",
            "line 2: got '1e25 N', but a force here",
        ),
        ("", "its first line must be"),
        ("crank_angle_deg,force_x_N,force_y_N\n0,1,0\n0,2,0\n", "its places must increase"),
        ("crank_angle_deg,force_x_N,force_y_N\n0,1,0\n360,2,0\n", "span a turn or more"),
    ):
        file.write_text(content)
        told = refusal(text, tmp_path)
        assert message in told, told


def test_a_load_file_ends_up_in_the_text_of_the_mechanism(tmp_path: Path) -> None:
    """So that a result says all of its model, wherever it is read again."""
    from flexmech import load_mechanism

    old, new = load(
        'point = "D"\nforce = ["1 N", "0 N"]',
        'point = "A"\nlink = "crank"\nover = "crank_angle"\nfile = "push.csv"',
    )
    model = tmp_path / "model.toml"
    model.write_text(SIX_BAR.replace(old, new, 1))
    rows = "crank_angle_deg,force_x_N,force_y_N,torque_Nm\n10,1,2,0.5\n200,3,4,0.25\n"
    (tmp_path / "push.csv").write_text(rows)
    mechanism = load_mechanism(model)
    (push,) = mechanism.loads
    assert push.force == ((1.0, 2.0), (3.0, 4.0))
    assert push.torque == (0.5, 0.25)
    assert mechanism_from_toml(mechanism.provenance.text) == mechanism


def test_frames_stand_still_where_several_clamps_hold_them(tmp_path: Path) -> None:
    """All of it welded; it is drawn once and is there at every crank angle, at crank speed 0."""
    text = (
        'name = "portal"\nsource = "this test"\n[linkage]\nkind = "planar"\nground = ["O", "Q"]\n'
        '[linkage.points]\nO = ["0 m", "0 m"]\nA = ["0 m", "0.5 m"]\nB = ["0.7 m", "0.5 m"]\n'
        'Q = ["0.7 m", "0 m"]\n[links.frame]\npoints = ["O", "A", "B", "Q"]\nmaterial = "steel"\n'
        'section = "rectangle"\nin_plane_thickness = "10 mm"\nout_of_plane_width = "30 mm"\n'
        '[materials.steel]\nyoungs_modulus = "200 GPa"\ndensity = "7800 kg/m^3"\n'
        'poisson_ratio = 0.3\n[joints.O]\nkind = "clamp"\n[joints.Q]\nkind = "clamp"\n'
    )
    frame = mechanism_from_toml(text)
    motion = frame.linkage.motion([0.0, 1.0])
    assert np.array_equal(motion.angle[0], motion.angle[1])
    assert motion.position(2, 0.5) == pytest.approx(np.array([[0.7, 0.0]] * 2), abs=1e-15)
    assert mechanism_from_toml(frame.to_toml()).linkage == frame.linkage
    file = tmp_path / "portal.toml"
    file.write_text(text)
    run = ["frequencies", str(file), "--angles", "0", "--speeds", "0", "--no-plots"]
    asked = [*run, "--engine", "reference", "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(app, asked)
    assert result.exit_code == 0, result.stderr
    assert "25.64" in result.stdout
    asked[asked.index("--speeds") + 1] = "10"
    result = CliRunner().invoke(app, asked)
    assert result.exit_code == 2
    assert "the frame stands still, clamped at several points: nothing turns" in result.stderr
