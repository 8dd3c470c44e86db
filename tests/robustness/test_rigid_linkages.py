"""Linkages of rigid links alone: their motion is known, and vibrations are refused in one line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

import flexmech
from flexmech.cli import app
from flexmech.errors import InputError

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
        assert "deg: none (links: every link is rigid" in " ".join(done.stdout.split())


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
