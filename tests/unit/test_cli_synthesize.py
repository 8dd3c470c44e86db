"""Synthesis of crank-rockers, as a result and from ``flexmech synthesize``; refusals."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

from flexmech import CrankRockerSynthesis, InputError, crank_rocker_synthesis
from flexmech.cli.application import app
from flexmech.modelfile import mechanism_from_toml, template

WANTED = ["--deviation", "20", "--rocker-angle", "100"]
TABLE, DATASET, PICTURE = (f"transmission_angle.{ending}" for ending in ("csv", "nc", "png"))


def synthesize(*arguments: str):
    return CliRunner().invoke(app, ["synthesize", *arguments])


def test_proportions_and_their_check() -> None:
    result = synthesize(*WANTED)
    assert result.exit_code == 0, result.output
    assert result.output.splitlines() == [
        "Crank 0.1408, coupler 0.9005, rocker 0.4572 of the ground: crank-rocker with transmission "
        "angles of 70 to 110 deg.",
        "The rocker swings through 35.87 deg, with a time ratio of 1.",
        result.output.splitlines()[2],
    ]
    gap = result.output.splitlines()[2]
    assert gap.startswith("check: computed back from the lengths, what was wanted is met within ")
    assert float(gap.split()[-2]) < 1e-9
    more = synthesize(*WANTED, "--details").output.splitlines()
    assert more[-1] == "check: transmission angle 70 to 110 deg, rocker at 100 deg at crank angle 0"


def test_lengths_are_a_table_for_a_model_file() -> None:
    result = synthesize(*WANTED, "--ground", "0.4 m")
    assert result.exit_code == 0, result.output
    table = result.output[result.output.index("[linkage]") : result.output.index("check:")]
    assert tomllib.loads(table)["linkage"]["crank"] == "56.3188 mm"
    model = template("four-bar")
    start, end = model.index("[linkage]"), model.index("[materials")
    linkage = mechanism_from_toml(model[:start] + table + model[end:]).linkage
    assert linkage.ground == 0.4
    limits = np.degrees(linkage.transmission_angle_limits())
    assert limits == pytest.approx([70, 110], abs=1e-3)


@pytest.mark.usefixtures("rough_pictures")
def test_files(tmp_path: Path) -> None:
    out = tmp_path / "new"
    result = synthesize(*WANTED, "--out", str(out))
    assert result.exit_code == 0, result.output
    assert (
        result.output.splitlines()[-1]
        == f"files: {out / TABLE}, {out / DATASET}, {out / PICTURE}, {out / 'summary.txt'}"
    )
    assert (out / TABLE).read_text().splitlines()[:2] == [
        "crank_angle_deg,transmission_angle_deg",
        "0,70",
    ]
    table = np.loadtxt(out / TABLE, delimiter=",", skiprows=1)
    assert table[:, 0] == pytest.approx(np.arange(361))
    assert table[[0, 180, 360], 1] == pytest.approx([70, 110, 70], abs=1e-8)
    assert (out / PICTURE).read_bytes().startswith(b"\x89PNG")

    later = synthesize("--deviation", "30", "--rocker-angle", "90", "--out", str(out), "--no-plots")
    assert later.output.splitlines()[-2:] == [
        f"files: {out / TABLE}, {out / DATASET}, {out / 'summary.txt'}",
        f"from an earlier run, not of this one: {PICTURE}",
    ]


def test_no_picture_unless_wanted(tmp_path: Path) -> None:
    assert synthesize(*WANTED, "--out", str(tmp_path), "--no-plots").exit_code == 0
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["summary.txt", TABLE, DATASET]


def test_a_user_s_script(tmp_path: Path) -> None:
    """Ten lines with public names alone."""
    script = f"""
import flexmech
import numpy as np
found = flexmech.crank_rocker_synthesis(np.radians(20), np.radians(100), ground=0.4)
linkage = flexmech.FourBar(*found.dataset["length"].values)
figure = found.plot()
files = found.save({str(tmp_path)!r}, figures=True)
loaded = flexmech.CrankRockerSynthesis.load(files[1])
print(loaded.summary())
"""
    names: dict[str, object] = {}
    exec(script, names)
    limits = np.degrees(names["linkage"].transmission_angle_limits())
    assert limits == pytest.approx([70, 110], abs=1e-9)
    assert isinstance(names["figure"], Figure)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(CrankRockerSynthesis.files)


def test_a_loaded_result_says_the_same(tmp_path: Path) -> None:
    for ground in (None, 0.4):
        result = crank_rocker_synthesis(*np.radians([20, 100]), ground)
        result.save(tmp_path)
        loaded = CrankRockerSynthesis.load(tmp_path / DATASET)
        assert loaded.dataset.identical(result.dataset)
        for name, variable in result.dataset.variables.items():
            assert loaded.dataset[name].dtype.kind == variable.dtype.kind, name
        assert str(loaded.summary()) == str(result.summary())
        assert ("[linkage]" in str(result.summary())) == (ground is not None)
        assert loaded.tables()["transmission_angle"].equals(result.tables()["transmission_angle"])


def test_plots_into_axes_of_the_user() -> None:
    axes = Figure().subplots()
    assert crank_rocker_synthesis(*np.radians([20, 100])).plot(ax=axes) is axes.figure
    assert axes.lines


def test_what_python_refuses() -> None:
    for arguments, said in (
        ((30, 90), "deviation must lie between 0 and 90 deg"),
        (("30 deg", 1.5), "deviation must be a number of rad"),
        (([0.3, 0.4], 1.5), "deviation must be a number of rad"),
        ((0.5, 1.6, "400 mm"), "ground must be a number of m"),
    ):
        with pytest.raises(InputError, match=said):
            crank_rocker_synthesis(*arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--deviation", "20", "--rocker-angle", "60"), "rocker angle must lie between 70 and 180"),
        (
            ("--deviation", "95", "--rocker-angle", "100"),
            "--deviation: must lie between 0 and 90 deg",
        ),
        (
            ("--deviation", "nan", "--rocker-angle", "100"),
            "--deviation: must lie between .*, got nan",
        ),
        (("--deviation", "20 deg", "--rocker-angle", "100"), "'--deviation'.*valid"),
        (("--deviation", "20"), "Missing option '--rocker-angle'"),
        ((*WANTED, "--ground", "4 kg"), "--ground: .*not that of a length"),
        ((*WANTED, "--ground", "400"), "--ground: .*has no unit"),
        ((*WANTED, "--ground", "0 mm"), "--ground: must be positive, got '0 mm'"),
        ((*WANTED, "--ground=-4 mm"), "--ground: must be positive, got '-4 mm'"),
        ((*WANTED, "--ground", ""), "--ground: got ''"),
    ],
)
def test_refuses(arguments: tuple[str, ...], message: str) -> None:
    result = synthesize(*arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    (line,) = [line for line in result.stderr.splitlines() if "rror:" in line]
    assert re.search(message, line), line


def test_refuses_a_file_for_a_folder(tmp_path: Path) -> None:
    place = tmp_path / "taken"
    place.write_text("")
    result = synthesize(*WANTED, "--out", str(place))
    assert result.exit_code == 2
    assert result.stdout == ""
    assert "--out" in result.stderr
