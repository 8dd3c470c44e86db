"""The response command around its analysis: files, pictures and what is printed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from flexmech import plots
from flexmech.analyses.digits import rounded
from flexmech.analyses.response.compute import response
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.result import Response
from flexmech.analyses.response.words import check_lines, load_lines, peak_table
from flexmech.cli import app
from flexmech.errors import ComputationError
from flexmech.linkages import ConstantSpeed
from flexmech.modelfile import load_mechanism
from flexmech.reference import ReferenceEngine

pytestmark = pytest.mark.usefixtures("rough_pictures")

ALUMINIUM = str(Path(__file__).parents[2] / "models" / "aluminium_fourbar.toml")
DATA = ["response.csv", "response.nc", "summary.txt"]
PICTURES = ["forces.png", "response.png", "running_shaking_force.png", "spectrum.png"]
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
    return response(engine, ResponseRequest(ConstantSpeed(20.0), revolutions=0.2, samples=120))


@pytest.fixture(scope="module")
def two_responses(short_response: Response) -> Response:
    """The same, and a second engine whose deflections are all 1 % larger."""
    first = short_response.dataset
    second = first.assign_coords(
        engine=["exudyn"], element=("engine", ["ancf"]), nonlinear=("engine", [True])
    )
    second["deflection"] = 1.01 * second["deflection"]
    second["step"] = 2 * second["step"]
    of_engines = [name for name in first if "engine" in first[name].dims]
    both = xr.concat([first[of_engines], second[of_engines]], "engine")
    return Response(
        xr.merge([first.drop_vars(["engine", "element", "nonlinear", *of_engines]), both])
    )


@pytest.fixture
def invented(
    monkeypatch: pytest.MonkeyPatch, short_response: Response, two_responses: Response
) -> SimpleNamespace:
    """An analysis that returns a run made before, and animations that cost nothing."""
    seen = SimpleNamespace(engines=[], requests=[], options=[], animated=[], mp4=True)

    def analysis(engines: list[Any], request: ResponseRequest, **options: Any) -> Response:
        seen.engines.append([(one.name, one.element, one.elements) for one in engines])
        seen.requests.append(request)
        seen.options.append(options)
        return short_response if len(engines) == 1 else two_responses

    def write_animation(dataset: xr.Dataset, path: Path, **options: Any) -> None:
        path.write_bytes(b"frames")
        seen.animated.append(path.name)

    monkeypatch.setattr("flexmech.analyses.response.compute.response", analysis)
    monkeypatch.setattr(plots, "write_animation", write_animation)
    monkeypatch.setattr(plots, "mp4_available", lambda: seen.mp4)
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
        300.0,
        revolutions=4.0,
        samples=720,
        start="rigid",
        step=None,
        integrator="trapezoidal",
        prestress="equilibrium",
        modes=4,
        speed_unit="rpm",
    )
    assert request.drive.is_constant
    assert invented.options == [{"check_mesh": False, "environment": None, "progress": None}]
    assert names(tmp_path / "results") == sorted(DATA + PICTURES)


@pytest.mark.parametrize(
    ("arguments", "files"),
    [
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


def test_a_spectrogram_is_drawn_where_there_is_one(short_response: Response) -> None:
    assert "spectrogram" not in short_response.figures()
    data = short_response.dataset
    deflection = data["deflection"]
    windows = {"window_frequency": [1.0, 2.0, 3.0], "window_time": [0.01, 0.02]}
    levels = xr.DataArray(np.ones((1, 3, 3, 2)), dims=("engine", "link", *windows))
    frequency = xr.DataArray(np.full((1, 2, 1), 2.0), dims=("engine", "window_time", "mode"))
    longer = data.assign(spectrogram=levels, natural_frequency=frequency)
    longer = longer.assign_coords(**windows, mode=[1], engine=deflection["engine"])
    assert "spectrogram" in Response(longer).figures()
    assert "too short" in str(short_response.summary())
    assert "too short" not in str(Response(longer).summary())


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


def test_animations_come_all_together_or_not_at_all(
    invented: SimpleNamespace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail_at_mp4(dataset: xr.Dataset, path: Path, **options: Any) -> None:
        path.write_bytes(b"half")
        if path.suffix == ".mp4":
            raise ComputationError("cannot draw")

    monkeypatch.setattr(plots, "write_animation", fail_at_mp4)
    result = run(ALUMINIUM, *QUICK, "--animate", "--no-plots", "--out", str(tmp_path))
    assert result.exit_code == 1
    assert names(tmp_path) == []


def test_animations_show_their_progress(
    short_response: Response,
    invented: SimpleNamespace,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def write_animation(
        dataset: xr.Dataset, path: Path, *, progress: Callable[[int, int], None]
    ) -> None:
        path.write_bytes(b"frames")
        progress(1, 2)

    monkeypatch.setattr(plots, "write_animation", write_animation)
    shown: list[tuple[str, int, int]] = []
    short_response.save_animations(tmp_path, lambda *step: shown.append(step))
    assert shown == [("animation.gif", 1, 2), ("animation.mp4", 1, 2)]


def test_a_saved_run_says_the_same(short_response: Response, tmp_path: Path) -> None:
    loaded = Response.load(short_response.save(tmp_path, store="all")[1])
    xr.testing.assert_identical(loaded.dataset, short_response.dataset)
    assert str(loaded.summary()) == str(short_response.summary())


# --- what is printed ------------------------------------------------------------------------


def test_the_last_line_compares_the_engines(
    short_response: Response, two_responses: Response
) -> None:
    summary, own = two_responses.summary(), short_response.errors()["deflection"].isel(engine=0)
    worst = str(own.idxmin().item())
    reference = f"{float(own.min()):.1e}"
    assert summary.details[-1] == (
        "engines: deflections of reference and exudyn differ by at most 9.9e-03 (crank), "
        "9.9e-03 (coupler), 9.9e-03 (rocker) of the link's peak"
        f", which is beyond their estimated errors (of {worst}: {reference} (reference), "
        f"{reference} (exudyn)); not among these are the error by the mesh, which --check-mesh "
        "gives, and what the linear equations of reference leave out"
    )
    table: Any = summary.table
    assert [row[:2] for group in table.groups for row in group] == [
        (engine, link)
        for engine in ("reference", "exudyn")
        for link in ("crank", "coupler", "rocker")
    ]
    assert short_response.summary().details[-1] == (
        "engines: no comparison was made, only the reference engine ran"
    )


def test_a_difference_that_the_mesh_does_not_explain_names_an_engine(
    two_responses: Response,
) -> None:
    data = two_responses.dataset.copy(deep=True)
    of = {n: n.replace("step_error_of", "mesh_error_of") for n in data if "step_error_of" in str(n)}
    data = data.assign({name: 2 * data[step] for step, name in of.items()})
    data["mesh_error"] = data["step_error"]
    ends = "trust exudyn, since no error tells what the linear equations of reference leave out"
    assert Response(data).summary().details[-1].endswith(ends)
    data["nonlinear"][:] = True
    data["step_error_of_deflection"][1] = 0.0
    assert (
        Response(data).summary().details[-1].endswith("trust exudyn, whose errors are the smaller")
    )


def test_engines_that_agree_have_one_block_of_the_table(two_responses: Response) -> None:
    data = two_responses.dataset.copy(deep=True)
    data["step_error_of_deflection"][:] = 0.006
    summary = Response(data).summary()
    assert summary.details[-1].endswith("of the link's peak, within their estimated errors")
    table: Any = summary.table
    assert [row[:2] for group in table.groups for row in group] == [
        ("both", link) for link in ("crank", "coupler", "rocker")
    ]


def test_a_small_links_own_error_counts(two_responses: Response) -> None:
    """Over the greatest deflection of the linkage its error was nothing."""
    data = two_responses.dataset.copy(deep=True)
    for of in ("deflection", "peak_deflection"):
        data[f"step_error_of_{of}"].loc[{"link": "crank"}] = 0.006
        data[f"step_error_of_{of}"].loc[{"link": "coupler"}] = 1e-4
        data[f"step_error_of_{of}"].loc[{"link": "rocker"}] = 2e-4
    changed = Response(data)
    within = changed.within_errors()
    assert within is not None
    assert within["deflection"].values.tolist() == [True, False, False]
    assert "beyond their estimated errors (of coupler: " in changed.summary().details[-1]
    line = next(line for line in check_lines(data) if line.startswith("error by the time step"))
    assert "6.0e-03 (crank), 1.0e-04 (coupler), 2.0e-04 (rocker), exudyn" in line
    table: Any = changed.summary().table
    digits = [len(row[3].replace(".", "").lstrip("0")) for group in table.groups for row in group]
    assert digits[0] == 3 < digits[2]


def test_of_deep_bows_the_nonlinear_engine_is_trusted(two_responses: Response) -> None:
    data = two_responses.dataset.copy(deep=True)
    bow = 0.05 * float(data["length"].sel(link="crank"))
    data["deflection"] *= bow / float(abs(data["deflection"].sel(link="crank")).max())
    assert (
        "trust exudyn, which follows displacements of any size"
        in Response(data).summary().details[-1]
    )


def test_checks_and_loads_are_listed_engine_by_engine(
    short_response: Response, two_responses: Response
) -> None:
    result = two_responses
    step = float(short_response.dataset["step"][0])
    errors = {
        "mesh_error": "engine",
        "mesh_error_of_deflection": "link",
        "mesh_error_of_peak_deflection": "link",
        "mesh_error_of_force": "joint",
        "mesh_error_of_peak_force": "joint",
        "mesh_error_of_torque": "engine",
        "mesh_error_of_peak_torque": "engine",
    }
    data = result.dataset
    of_engines = xr.DataArray([1e-3, 2e-3], coords={"engine": data["engine"]})
    data = data.assign(
        {
            name: number
            * (of_engines if over == "engine" else of_engines * xr.ones_like(data[over], float))
            for number, (name, over) in enumerate(errors.items(), start=1)
        }
    )
    lines = check_lines(data)
    assert f"time step: {step:.4g} s (reference), {2 * step:.4g} s (exudyn)" in lines
    assert lines[-2:] == [
        "mesh: twice the elements change deflections, of the link's peak: 2.0e-03 (crank), "
        "2.0e-03 (coupler), 2.0e-03 (rocker), reference; 4.0e-03 (crank), 4.0e-03 (coupler), "
        "4.0e-03 (rocker), exudyn",
        "mesh: twice the elements change forces, of the peak: joint forces 4.0e-03 (reference), "
        "8.0e-03 (exudyn), their peaks 5.0e-03 (reference), 1.0e-02 (exudyn); torque 6.0e-03 "
        "(reference), 1.2e-02 (exudyn), its peak 7.0e-03 (reference), 1.4e-02 (exudyn)",
    ]
    assert len(check_lines(result.dataset)) == len(lines) - 2
    band, sides, torque, *forces = load_lines(result.peaks(), result.dataset)
    assert f"up to {data.attrs['force_band']:.4g} Hz" in band
    assert "A of the crank on the coupler, B of the coupler on the rocker" in sides
    rigid = float(abs(data["rigid_driving_torque"]).max())
    assert torque.endswith(f"{rigid:.4g} N m (rigid links)")
    assert [line.split("(")[1] for line in forces] == ["reference)", "exudyn)", "rigid links)"]
    pin = data["rigid_joint_force"].sel(joint="B").values
    assert f"B {np.hypot(pin[:, 0], pin[:, 1]).max():.4g}, O4" in forces[-1]


@pytest.mark.parametrize(
    ("start", "degrees", "shown", "turn"),
    [
        (0.0, 0.0, "0.0", "1"),
        (0.0, 359.5, "359.5", "1"),
        (0.0, 360.0, "0.0", "2"),
        (0.0, 900.25, "180.2", "3"),
        (0.0, -10.0, "350.0", "1"),
        (0.0, -370.0, "350.0", "2"),
        (90.0, 449.0, "89.0", "1"),
    ],
)
def test_the_crank_at_the_peak_is_an_angle_and_a_turn(
    start: float, degrees: float, shown: str, turn: str, short_response: Response
) -> None:
    data = short_response.dataset.copy(deep=True)
    data["peak_deflection"][:], data["peak_deflection_angle"][:] = 1e-3, np.radians(degrees)
    (rows,) = peak_table(Response(data).peaks(), np.radians(start), "peaks").groups
    assert [row[3:6] for row in rows] == [("1.0000", shown, turn)] * 3
    assert [row[6] == "-" for row in rows] == [True, False, False]


def test_forces_have_an_agreement_of_their_own(two_responses: Response) -> None:
    """Deflections of the second engine are 1 % larger; its forces shall differ by 4 %."""
    data = two_responses.dataset.copy(deep=True)
    data["joint_force"][1] *= 1.04
    data["peak_joint_force"][1] *= 1.02
    data["driving_torque"][1] *= 1.25
    lines = [str(part) for part in Response(data).summary().details[:-1]]
    histories, peaks = (line for line in lines if line.startswith("engines: "))
    band = f"up to {data.attrs['force_band']:.3g} Hz"
    assert histories.startswith(f"engines: joint forces {band} of reference and exudyn differ")
    agreement = Response(data).force_agreement()
    assert agreement is not None
    size = np.hypot(*np.moveaxis(data["joint_force"].values[0], -1, 0)).max(axis=0)
    expected = 0.04 * size / data["peak_joint_force"].values[1]
    assert agreement["joint_force"].values == pytest.approx(expected)
    assert f"{expected[0]:.1e} (O2)" in histories
    assert "peaks of these joint forces differ by 2.0e-02 (O2), 2.0e-02 (A)" in peaks
    # Errors of a fiftieth explain the peaks of the forces, not that of torque by itself.
    assert "(of torque: " in histories
    assert "beyond their estimated errors (of " in peaks
    data["step_error_of_peak_force"][:] = data["step_error_of_peak_torque"][:] = 0.011
    lines = [str(part) for part in Response(data).summary().details[:-1]]
    histories, peaks = (line for line in lines if line.startswith("engines: "))
    assert peaks.endswith("of torque by 0.0e+00, within their estimated errors")
    assert "beyond their estimated errors (of torque: " in histories
    within = Response(data).within_errors()
    assert within is not None
    assert bool(within["peak_joint_force"].all())
    assert not bool(within["driving_torque"])
    same = Response(data.sel(engine=["reference"]))
    assert same.within_errors() is None
    assert same.force_agreement() is None
    assert not any(str(part).startswith("engines: ") for part in same.summary().details[:-1])


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [
        (146.384, 0.0, "146.4"),
        (146.384, 2e-3, "146.4"),
        (146.384, 4e-2, "150"),
        (146.384, 0.5, "100"),
        (5.0362, 2e-4, "5.036"),
        (0.54321, 5e-3, "0.543"),
        (0.0, 1e-3, "0"),
    ],
)
def test_a_value_has_the_digits_that_its_error_supports(
    value: float, error: float, shown: str
) -> None:
    assert rounded(value, error * value) == shown
