"""The response command around its analysis: files, pictures and what is printed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from typer.testing import CliRunner

from flexmech import plots
from flexmech.analyses.response import Response, ResponseRequest, response
from flexmech.cli import app
from flexmech.cli.response_pictures import write_animations
from flexmech.cli.response_report import (
    agreement_line,
    check_lines,
    load_lines,
    peak_table,
    spectrogram_lines,
)
from flexmech.errors import ComputationError, InputError
from flexmech.linkages import CrankDrive
from flexmech.modelfile import load_mechanism
from flexmech.reference import ReferenceEngine

pytestmark = pytest.mark.usefixtures("rough_pictures")

ALUMINIUM = str(Path(__file__).parents[2] / "models" / "aluminium_fourbar.toml")
DATA = ["response.csv", "response.nc"]
PICTURES = ["forces.png", "response.png", "spectrum.png"]
ANIMATIONS = ["animation.gif", "animation.mp4"]
QUICK = ["--speed", "20", "--engine", "reference"]


def run(*arguments: str) -> Any:
    return CliRunner().invoke(app, ["response", *arguments])


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture(scope="module")
def short_response() -> Response:
    """A fifth of a turn with one engine; too short for a spectrogram."""
    engine = ReferenceEngine(load_mechanism(ALUMINIUM), elements=2)
    return response(engine, ResponseRequest(CrankDrive(20.0), revolutions=0.2, samples=120))


@pytest.fixture(scope="module")
def two_responses(short_response: Response) -> Response:
    """The same, and a second engine whose deflections are all 1 % larger."""
    first = short_response.dataset
    second = first.assign_coords(engine=["exudyn"], element=("engine", ["ancf"]))
    second["deflection"] = 1.01 * second["deflection"]
    second["step"] = 2 * second["step"]
    of_engines = [name for name in first if "engine" in first[name].dims]
    both = xr.concat([first[of_engines], second[of_engines]], "engine")
    return Response(xr.merge([first.drop_vars(["engine", "element", *of_engines]), both]))


@pytest.fixture
def invented(
    monkeypatch: pytest.MonkeyPatch, short_response: Response, two_responses: Response
) -> SimpleNamespace:
    """An analysis that returns a run made before, and drawings that cost nothing."""
    seen = SimpleNamespace(
        engines=[], requests=[], options=[], animated=[], failure=None, mp4=True, spectrogram=False
    )

    def analysis(engines: list[Any], request: ResponseRequest, **options: Any) -> Response:
        seen.engines.append([(one.name, one.element, one.elements) for one in engines])
        seen.requests.append(request)
        seen.options.append(options)
        if seen.failure is not None:
            raise seen.failure
        result = short_response if len(engines) == 1 else two_responses
        if seen.spectrogram:
            return Response(result.dataset.assign(spectrogram=("engine", [0.0] * len(engines))))
        return result

    def write_animation(dataset: xr.Dataset, path: Path, **options: Any) -> None:
        path.write_bytes(b"frames")
        seen.animated.append(path.name)

    def drawing(dataset: xr.Dataset) -> Figure:
        return Figure(figsize=(1, 1))

    monkeypatch.setattr("flexmech.analyses.response.response", analysis)
    for name in ("plot_response", "plot_forces", "plot_spectrum", "plot_spectrogram"):
        monkeypatch.setattr(plots, name, drawing, raising=False)
    monkeypatch.setattr(plots, "write_animation", write_animation, raising=False)
    monkeypatch.setattr(plots, "mp4_available", lambda: seen.mp4, raising=False)
    return seen


def test_defaults_are_those_of_the_manual(
    invented: SimpleNamespace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = run(ALUMINIUM, "--speed", "300 rpm")
    assert result.exit_code == 0, result.output
    assert invented.engines == [[("reference", "euler", 8), ("exudyn", "ancf", 8)]]
    (request,) = invented.requests
    assert request.drive.speed == pytest.approx(10 * np.pi)
    assert request == ResponseRequest(
        request.drive,
        revolutions=4.0,
        samples=720,
        start="rigid",
        step=None,
        integrator="trapezoidal",
        prestress="equilibrium",
        modes=4,
    )
    assert request.drive.is_constant
    assert invented.options == [{"check_mesh": False, "progress": None}]
    assert names(tmp_path / "results") == sorted(DATA + PICTURES)


@pytest.mark.parametrize(
    ("arguments", "elements"),
    [
        (["--element", "euler"], ["euler", "ancf"]),
        (["--element", "geometrically-exact"], ["timoshenko", "geometrically-exact"]),
        (["--engine", "exudyn"], ["ancf"]),
        (["--engine", "exudyn", "--element", "geometrically-exact"], ["geometrically-exact"]),
        (["--engine", "reference", "--element", "euler"], ["euler"]),
    ],
    ids=str,
)
def test_an_element_goes_to_the_engine_that_has_it(
    invented: SimpleNamespace, arguments: list[str], elements: list[str], tmp_path: Path
) -> None:
    result = run(ALUMINIUM, "--speed", "20", *arguments, "--no-plots", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert [element for _, element, _ in invented.engines[0]] == elements


@pytest.mark.parametrize(
    ("arguments", "files"),
    [
        ([], PICTURES),
        (["--no-plots"], []),
        (["--animate"], PICTURES + ANIMATIONS),
        (["--no-plots", "--animate"], ANIMATIONS),
    ],
    ids=str,
)
def test_files_are_those_asked_for(
    invented: SimpleNamespace, arguments: list[str], files: list[str], tmp_path: Path
) -> None:
    result = run(ALUMINIUM, *QUICK, *arguments, "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert names(tmp_path) == sorted(DATA + files)
    (line,) = (line for line in result.stdout.split("\n") if line.startswith("files: "))
    assert sorted(line[7:].split(", ")) == sorted(str(tmp_path / name) for name in DATA + files)
    assert "ffmpeg" not in result.stdout
    for name in set(files) & set(PICTURES):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")


def test_a_spectrogram_is_drawn_where_there_is_one(
    invented: SimpleNamespace, tmp_path: Path
) -> None:
    invented.spectrogram = True
    result = run(ALUMINIUM, *QUICK, "--out", str(tmp_path))
    assert names(tmp_path) == sorted([*DATA, *PICTURES, "spectrogram.png"])
    assert "too short" not in result.stdout


def test_without_ffmpeg_there_is_a_gif_and_a_line(
    invented: SimpleNamespace, tmp_path: Path
) -> None:
    invented.mp4 = False
    (tmp_path / "animation.mp4").write_bytes(b"old")
    result = run(ALUMINIUM, *QUICK, "--no-plots", "--animate", "--out", str(tmp_path))
    assert invented.animated == ["animation.gif"]
    assert "MP4 needs ffmpeg" in result.stdout
    assert "from an earlier run, not of this one: animation.mp4" in result.stdout
    assert (tmp_path / "animation.mp4").read_bytes() == b"old"


@pytest.mark.parametrize(
    ("failure", "code", "message"),
    [
        (InputError("the linkage locks at crank angle 90 deg"), 2, "error: the linkage locks"),
        (ComputationError("the linear response diverges"), 1, "error: the linear response"),
        (KeyboardInterrupt(), 130, "interrupted: "),
    ],
    ids=lambda value: type(value).__name__,
)
def test_failures_end_with_a_line_a_code_and_no_files(
    invented: SimpleNamespace, failure: BaseException, code: int, message: str, tmp_path: Path
) -> None:
    invented.failure = failure
    result = run(ALUMINIUM, *QUICK, "--out", str(tmp_path / "deep" / "out"))
    assert result.exit_code == code
    assert result.stderr.startswith(message)
    assert result.stderr.count("\n") == 1
    assert result.stdout == ""
    assert names(tmp_path) == []


def test_pictures_and_animations_come_all_together_or_not_at_all(
    invented: SimpleNamespace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*arguments: Any, **options: Any) -> None:
        raise ComputationError("cannot draw")

    def fail_at_mp4(dataset: xr.Dataset, path: Path, **options: Any) -> None:
        path.write_bytes(b"half")
        if path.suffix == ".mp4":
            fail()

    out = ["--out", str(tmp_path)]
    monkeypatch.setattr(plots, "write_animation", fail_at_mp4)
    assert run(ALUMINIUM, *QUICK, "--animate", "--no-plots", *out).exit_code == 1
    assert names(tmp_path) == DATA
    monkeypatch.setattr(plots, "plot_spectrum", fail)
    assert run(ALUMINIUM, *QUICK, *out).exit_code == 1
    assert names(tmp_path) == DATA


def test_animations_show_their_progress(
    invented: SimpleNamespace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write_animation(
        dataset: xr.Dataset, path: Path, *, progress: Callable[[int, int], None]
    ) -> None:
        path.write_bytes(b"frames")
        progress(1, 2)

    monkeypatch.setattr(plots, "write_animation", write_animation, raising=False)
    shown: list[tuple[str, int, int]] = []
    write_animations(xr.Dataset(), tmp_path, lambda *step: shown.append(step))
    assert shown == [("animation.gif", 1, 2), ("animation.mp4", 1, 2)]


# --- what is printed ------------------------------------------------------------------------


def test_the_last_line_compares_the_engines(invented: SimpleNamespace, tmp_path: Path) -> None:
    result = run(ALUMINIUM, "--speed", "20", "--no-plots", "--out", str(tmp_path))
    assert result.stdout.strip().split("\n")[-1] == (
        "engines: deflections of reference and exudyn differ by at most 9.9e-03 (crank), "
        "9.9e-03 (coupler), 9.9e-03 (rocker) of the link's peak"
    )
    rows = [line.split() for line in result.stdout.split("\n") if line.startswith("│")]
    assert [(row[1], row[3]) for row in rows] == [
        (engine, link)
        for engine in ("reference", "exudyn")
        for link in ("crank", "coupler", "rocker")
    ]


def test_checks_and_loads_are_listed_engine_by_engine(
    short_response: Response, two_responses: Response
) -> None:
    result = two_responses
    step = float(short_response.dataset["step"][0])
    data = result.dataset.assign(mesh_error=("engine", [1e-3, 2e-3]))
    lines = check_lines(data)
    assert f"time step: {step:.4g} s (reference), {2 * step:.4g} s (exudyn)" in lines
    assert lines[-1] == (
        "mesh: twice the elements change deflections by 1.0e-03 (reference), 2.0e-03 (exudyn) of "
        "their peak"
    )
    assert len(check_lines(result.dataset)) == len(lines) - 1
    torque, *forces = load_lines(result)
    rigid = float(abs(data["rigid_driving_torque"]).max())
    assert torque.endswith(f"{rigid:.4g} N m (rigid links)")
    assert [line.split("(")[1] for line in forces] == ["reference)", "exudyn)", "rigid links)"]
    pin = data["rigid_joint_force"].sel(joint="B").values
    assert f"B {np.hypot(pin[:, 0], pin[:, 1]).max():.4g}, O4" in forces[-1]
    assert agreement_line(short_response) == (
        "engines: no comparison was made, only the reference engine ran"
    )
    assert spectrogram_lines(data.assign(spectrogram=0.0)) == []


@pytest.mark.parametrize(
    ("start", "degrees", "shown", "turn"),
    [
        (0.0, 0.0, "0", "1"),
        (0.0, 359.5, "359.5", "1"),
        (0.0, 360.0, "0", "2"),
        (0.0, 900.25, "180.25", "3"),
        (0.0, -10.0, "350", "1"),
        (0.0, -370.0, "350", "2"),
        (90.0, 449.0, "89", "1"),
    ],
)
def test_the_crank_at_the_peak_is_an_angle_and_a_turn(
    start: float, degrees: float, shown: str, turn: str, short_response: Response
) -> None:
    data = short_response.dataset.isel(time=[0, 1]).copy(deep=True)
    data = data.assign_coords(crank_angle=("time", np.radians([start, degrees])))
    data["deflection"] = data["deflection"] * 0.0
    data["deflection"][:, 1] = -1e-3
    _, _, _, deflection, at, turns, strain = peak_table(Response(data), "peaks [m]").columns
    assert list(deflection.cells) == ["1"] * 3
    assert list(at.cells) == [shown] * 3
    assert list(turns.cells) == [turn] * 3
    assert [cell == "-" for cell in strain.cells] == [True, False, False]
