"""Linkages of rigid links alone: their motion is known, and vibrations are refused in one line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

import flexmech
from flexmech.cli import app
from flexmech.errors import InputError
from flexmech.modelfile import mechanism_from_toml

PUSHER = Path(__file__).parents[2] / "models" / "carton_pusher.toml"
ELASTIC = re.compile(
    r"^material = .*\nsection = .*\nin_plane_thickness = .*\nout_of_plane_width = .*\n",
    re.MULTILINE,
)


@pytest.fixture
def rigid(tmp_path: Path) -> Path:
    model = tmp_path / "rigid.toml"
    text = ELASTIC.sub('rigid = true\nmass = "1 kg"\n', PUSHER.read_text(encoding="utf-8"))
    model.write_text(text, encoding="utf-8")
    return model


@pytest.mark.parametrize(
    "arguments",
    [
        *("check MODEL", "check MODEL --angle 30", "kinematics MODEL --angles 0:360:30"),
        *("coupler-curve MODEL --point 10mm,20deg", "report MODEL --include kinematics"),
    ],
)
def test_what_concerns_the_motion_alone_runs(arguments: str, rigid: Path, tmp_path: Path) -> None:
    out = ["--out", str(tmp_path / "out" if "report" not in arguments else tmp_path / "r.html")]
    words = [word.replace("MODEL", str(rigid)) for word in arguments.split()]
    plots = [] if words[0] == "report" else ["--no-plots"]
    done = CliRunner().invoke(app, [*words, *out, *plots])
    assert done.exit_code == 0, done.stderr
    if words[0] == "check":
        assert "deg: links: every link is rigid" in " ".join(done.stdout.split())


@pytest.mark.parametrize(
    "arguments",
    [
        *("frequencies MODEL --engine both", "campbell MODEL --speeds 0,10", "report MODEL"),
        *("response MODEL --speed 5", "stability MODEL --speeds 10", "hammer MODEL"),
        *("hammer MODEL --running 60", "export MODEL --speed 5"),
    ],
)
def test_what_asks_for_elastic_links_is_refused(arguments: str, rigid: Path) -> None:
    words = [word.replace("MODEL", str(rigid)) for word in arguments.split()]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 2, done.stderr
    assert done.stderr.startswith(f"error: {rigid}: links: every link is rigid")
    assert "flexmech kinematics" in done.stderr


def test_engines_of_them_are_made_and_refuse_to_compute(rigid: Path) -> None:
    mechanism = flexmech.load_mechanism(rigid)
    for engine in (flexmech.ReferenceEngine(mechanism, 2), flexmech.ExudynEngine(mechanism, 2)):
        with pytest.raises(InputError, match="every link is rigid"):
            engine.linear_system([0.0])
    with pytest.raises(InputError, match="links: none has a section"):
        flexmech.section_profiles(mechanism)


BEARING = """
name = "rigid links on a bearing"
source = "made for this test"
[linkage]
kind = "planar"
drawn_at = "60 deg"
ground = ["O2", "O4"]
[linkage.points]
O2 = ["0 mm", "0 mm"]
A = ["50 mm", "86.6 mm"]
B = ["300 mm", "200 mm"]
O4 = ["250 mm", "0 mm"]
[links.crank]
points = ["O2", "A"]
rigid = true
[links.coupler]
points = ["A", "B"]
rigid = true
mass = "1 kg"
inertia = "0.01 kg m^2"
centre = "130 mm"
[links.rocker]
points = ["B", "O4"]
ROCKER
[joints.O2]
kind = "clamp"
[joints.O4]
radial_stiffness = "1e6 N/m"
"""
STIFF = """section = "general"
axial_stiffness = "{0}e9 N"
bending_stiffness = "{0}e6 N m^2"
shear_stiffness = "{0}e9 N"
mass_per_length = "6 kg/m"
rotary_inertia = "1e-3 kg m"
in_plane_thickness = "40 mm"
"""


def test_rigid_links_on_a_bearing_vibrate_beside_one_stiff_link() -> None:
    """What the message advises: how stiff that link is does not change the bearing's modes."""
    rigid = mechanism_from_toml(BEARING.replace("ROCKER", "rigid = true"))
    with pytest.raises(InputError, match="as stiff as you like where springs, bearings or"):
        flexmech.natural_frequencies(flexmech.ReferenceEngine(rigid), 1.0)
    one, other = (
        flexmech.natural_frequencies(
            flexmech.ReferenceEngine(
                mechanism_from_toml(BEARING.replace("ROCKER", STIFF.format(size)))
            ),
            *(1.0, 0.0),
            modes=2,
        )
        for size in (1, 10)
    )
    assert one[0] > 10
    assert other == pytest.approx(one, rel=1e-3)
