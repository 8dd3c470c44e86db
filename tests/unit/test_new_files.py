"""Model files to start from: their names, and the sizes that are asked for."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flexmech import load_mechanism
from flexmech.cli import app
from flexmech.errors import InputError
from flexmech.modelfile import KINDS, SIZES, mechanism_from_toml, new_file, template

SIZED = {"crank": "40 mm", "rod": "16 cm", "offset": "-5 mm", "mass": "200 g", "speed": "1500 rpm"}


def run(*arguments: object) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, ["new", *map(str, arguments)])
    return result.exit_code, result.stdout, result.stderr


def options(**sizes: str) -> list[str]:
    return [text for size, value in sizes.items() for text in (f"--{size}", value)]


def test_sizes_of_a_slider_crank_become_lengths_of_its_links(tmp_path: Path):
    file = tmp_path / "press.toml"
    code, printed, _ = run("slider-crank", file, *options(**SIZED))
    assert (code, printed) == (0, f"wrote {file}; next: flexmech check {file}\n")
    mechanism = load_mechanism(file)
    assert mechanism.provenance.name == "press"
    lengths = [link.length for link in mechanism.linkage.topology.links]
    assert lengths == pytest.approx([0.04, 0.16], rel=1e-14)
    assert mechanism.linkage.points["B"][1] == pytest.approx(-0.005, abs=1e-17)
    assert mechanism.joint_masses == {"B": 0.2}
    assert (mechanism.operating_speeds[0], mechanism.speed_unit) == (
        pytest.approx(50 * math.pi),
        "rpm",
    )
    # As it was typed, and the comments where they stood.
    text = file.read_text(encoding="utf-8")
    assert 'length = "16 cm"\n' in text
    assert "B = [" not in text.replace("# B = [", "")
    (own,) = (line for line in text.split("\n") if line.startswith("offset ="))
    (other,) = (line for line in template("slider-crank").split("\n") if line[:8] == "offset =")
    assert own.index("#") == other.index("#")


def test_sizes_that_are_left_out_are_the_template_s(tmp_path: Path):
    file = tmp_path / "mine.toml"
    assert run("slider-crank", file, "--rod", "250 mm")[0] == 0
    usual = mechanism_from_toml(template("slider-crank")).linkage.topology.links
    crank, rod = load_mechanism(file).linkage.topology.links
    assert (crank.length, rod.length) == (usual[0].length, pytest.approx(0.25))


def test_a_terminal_is_asked_for_those_that_are_left_out():
    asked: dict[str, str] = {}

    def answer(words: str, usual: str) -> str:
        asked[words] = usual
        # The first answer is asked for again, with what is wrong with it.
        return {"crank speed": "10"}.get(words, "10 rps" if "crank speed" in words else usual)

    text = new_file("slider-crank", "mine", {"rod": "250 mm"}, answer)
    assert asked == {
        "length of the crank": "60 mm",
        "offset of the slider's line": "0 mm",
        "mass of the slider": "0.15 kg",
        "crank speed": "300 rpm",
        "got '10', which has no unit; write an angular speed with its unit, for example "
        '"20 rad/s"; crank speed': "300 rpm",
    }
    assert mechanism_from_toml(text).speed_unit == "rps"


@pytest.mark.parametrize("kind", KINDS)
def test_a_new_file_is_its_template_but_for_the_name(kind: str):
    name = 'a "press" of ümläuts'
    text = new_file(kind, name, {})
    assert mechanism_from_toml(text).provenance.name == name
    lines = zip(text.split("\n"), template(kind).split("\n"), strict=True)
    assert [own for own, other in lines if own != other] == ['name = "a \\"press\\" of ümläuts"']


@pytest.mark.parametrize("kind", KINDS)
def test_an_undamped_template_says_so(kind: str):
    mechanism = mechanism_from_toml(template(kind))
    damped = any(section.specific_damping for section in mechanism.sections.values())
    assert ("# No damping is stated here: the links are undamped" in template(kind)) != damped


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["slider-crank", "--rod", "160"], "--rod: got '160', which has no unit; write a length"),
        (["slider-crank", "--mass", "5 mm"], "--mass: got '5 mm', whose unit 'mm'"),
        (["slider-crank", "--crank", "-4 mm"], "links.crank.length: must be"),
        (["slider-crank", "--offset", "1 m"], "links.rod.length: got 200 mm, but the line of slid"),
        (["four-bar", "--rod", "160 mm"], "--rod is a size of slider-crank, and not of four-bar"),
        (
            ["watt_six_bar", "--rod", "1 m"],
            "--rod is of a new slider-crank; leave it out, and edit",
        ),
    ],
)
def test_wrong_sizes_are_refused_and_nothing_is_written(
    arguments: list[str], message: str, tmp_path: Path
):
    kind, *sizes = arguments
    code, printed, errors = run(kind, tmp_path / "wrong.toml", *sizes)
    assert (code, printed) == (2, "")
    assert message in errors
    assert errors.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_unknown_sizes_are_refused():
    with pytest.raises(InputError, match="unknown kind of linkage 'sliding'"):
        new_file("sliding", "x", {})
    assert set(SIZES) == {"slider-crank"}
