"""The frequencies command around its engines: with invented numbers, and so at no cost."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from flexmech.cli import app
from flexmech.cli.report import agreement_line, error_lines, tracking_lines
from flexmech.errors import ComputationError, FlexmechError, InputError
from tests.unit.plot_data import frequency_dataset

pytestmark = pytest.mark.usefixtures("rough_pictures")

ALUMINIUM = str(Path(__file__).parents[2] / "models" / "aluminium_fourbar.toml")
DATA = ["frequencies.csv", "frequencies.nc"]
PICTURES = ["agreement.png", "frequencies.png", "mode_shapes.png", "speed_effect.png"]


def run(*arguments: str) -> Any:
    return CliRunner().invoke(app, list(arguments))


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@dataclass
class InventedResult:
    """What moving_frequencies returns, as far as the command uses it."""

    dataset: xr.Dataset

    def save(self, folder: Path) -> list[Path]:
        folder.mkdir(parents=True, exist_ok=True)
        files = [folder / name for name in DATA]
        for file in files:
            file.write_text("data")
        return files

    def extremes(self) -> xr.Dataset:
        frequency = self.dataset["frequency"]
        return xr.Dataset(
            {
                "lowest": frequency.min("crank_angle"),
                "lowest_angle": frequency.idxmin("crank_angle"),
                "highest": frequency.max("crank_angle"),
                "highest_angle": frequency.idxmax("crank_angle"),
            }
        )

    def vibration_effect(self) -> None:
        return None

    def agreement(self) -> Any:
        if self.dataset.sizes["engine"] == 1:
            return None
        return SimpleNamespace(
            relative_difference=3.21e-5,
            engines=("reference", "exudyn"),
            crank_speed=20.0,
            crank_angle=np.radians(135.0),
            mode=3,
        )


@pytest.fixture
def invented(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """Engines and analysis that return invented numbers, and what they were called with."""
    seen = SimpleNamespace(calls=[], failure=None)

    def engine(name: str) -> Callable[..., SimpleNamespace]:
        def make(mechanism: object, elements: int, element: str) -> SimpleNamespace:
            return SimpleNamespace(name=name, elements=elements, element=element)

        return make

    def moving_frequencies(
        engines: list[SimpleNamespace], angles: Any, speeds: Any, **options: Any
    ) -> InventedResult:
        seen.calls.append((engines, angles, speeds, options))
        if seen.failure is not None:
            raise seen.failure
        return InventedResult(
            frequency_dataset(
                speeds,
                angles,
                options["modes"],
                [one.name for one in engines],
                speed_effect=options["speed_effect"],
            )
        )

    for module, contents in (
        ("analyses", {"moving_frequencies": moving_frequencies}),
        ("reference", {"ReferenceEngine": engine("reference")}),
        ("multibody", {"ExudynEngine": engine("exudyn")}),
    ):
        fake = ModuleType(f"flexmech.{module}")
        fake.__dict__.update(contents)
        monkeypatch.setitem(sys.modules, f"flexmech.{module}", fake)
    return seen


def test_defaults_are_those_of_the_manual(
    invented: SimpleNamespace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("frequencies", ALUMINIUM).exit_code == 0
    ((engines, angles, speeds, options),) = invented.calls
    assert [(one.name, one.element, one.elements) for one in engines] == [
        ("reference", None, 8),
        ("exudyn", None, 8),
    ]
    np.testing.assert_array_equal(angles, np.radians(np.arange(0, 361, 5)))
    assert list(speeds) == [0.0, 10.0, 20.0]
    assert options == {
        "modes": 4,
        "prestress": "equilibrium",
        "rotation_terms": True,
        "speed_effect": True,
        "progress": None,
    }
    assert names(tmp_path / "results") == sorted(DATA + PICTURES)


@pytest.mark.parametrize(
    ("operation", "wanted"),
    [
        ("", [0.0, 10.0, 20.0]),
        ('[operation]\ncrank_speeds = ["3 rad/s", "-1 rad/s"]\n', [-1.0, 0.0, 3.0]),
    ],
)
def test_speeds_left_out_are_those_of_the_model(
    invented: SimpleNamespace, tmp_path: Path, operation: str, wanted: list[float]
) -> None:
    text = Path(ALUMINIUM).read_text()
    model = tmp_path / "own.toml"
    model.write_text(text[: text.index("[operation]")] + operation)
    out = ["--no-plots", "--out", str(tmp_path / "out")]
    assert run("frequencies", str(model), *out).exit_code == 0
    ((_, _, speeds, _),) = invented.calls
    assert list(speeds) == wanted


def test_the_last_line_says_how_far_the_engines_differ(
    invented: SimpleNamespace, tmp_path: Path
) -> None:
    result = run("frequencies", ALUMINIUM, "--out", str(tmp_path))
    assert result.stderr == ""
    lines = result.stdout.strip().split("\n")
    assert lines[-1] == (
        "engines: reference and exudyn differ by at most 3.21e-05 of the frequency, at 20 rad/s, "
        "135 deg, mode 3"
    )
    assert lines[-2].startswith("files: ")
    for name in DATA + PICTURES:
        assert str(tmp_path / name) in lines[-2]
    rows = [line.split() for line in lines if "reference" in line or "exudyn" in line]
    assert sum(len(row) > 10 for row in rows) >= 2 * 3 * 4


@pytest.mark.parametrize(
    ("arguments", "pictures"),
    [
        ([], PICTURES),
        (["--engine", "reference"], PICTURES[1:]),
        (["--speeds", "0"], PICTURES[:3]),
        (["--prestress", "none"], PICTURES[:3]),
        (["--prestress", "axial", "--speeds", "300 rpm"], PICTURES),
        (["--no-plots"], []),
    ],
    ids=str,
)
def test_pictures_are_those_that_there_is_data_for(
    invented: SimpleNamespace, arguments: list[str], pictures: list[str], tmp_path: Path
) -> None:
    arguments = ["--angles", "0,60", "--modes", "2", *arguments]
    result = run("frequencies", ALUMINIUM, "--out", str(tmp_path), *arguments)
    assert result.exit_code == 0, result.output
    assert names(tmp_path) == sorted(DATA + pictures)
    for name in pictures:
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "elements"),
    [
        (["--element", "euler"], ["euler", "ancf"]),
        (["--element", "ancf"], ["euler", "ancf"]),
        (["--element", "geometrically-exact"], ["timoshenko", "geometrically-exact"]),
        (["--engine", "exudyn"], [None]),
        (["--engine", "exudyn", "--element", "geometrically-exact"], ["geometrically-exact"]),
        (["--engine", "reference", "--element", "euler"], ["euler"]),
    ],
    ids=str,
)
def test_an_element_goes_to_the_engine_that_has_it(
    invented: SimpleNamespace, arguments: list[str], elements: list[str], tmp_path: Path
) -> None:
    result = run("frequencies", ALUMINIUM, "--no-plots", "--out", str(tmp_path), *arguments)
    assert result.exit_code == 0
    assert [one.element for one in invented.calls[0][0]] == elements


def test_pictures_of_an_earlier_run_are_pointed_out(
    invented: SimpleNamespace, tmp_path: Path
) -> None:
    (tmp_path / "agreement.png").write_bytes(b"old")
    result = run(
        "frequencies", ALUMINIUM, "--engine", "reference", "--no-plots", "--out", str(tmp_path)
    )
    assert "from an earlier run, not of this one: agreement.png" in result.stdout
    assert result.stdout.strip().split("\n")[-1] == (
        "engines: no comparison was made, only the reference engine ran"
    )


@pytest.mark.parametrize(
    ("failure", "code", "message"),
    [
        (InputError("the linkage locks at crank angle 90 deg"), 2, "error: the linkage locks"),
        (ComputationError("no equilibrium at 5 deg"), 1, "error: no equilibrium at 5 deg"),
        (FlexmechError("other"), 1, "error: other"),
        (KeyboardInterrupt(), 130, "interrupted: "),
    ],
    ids=lambda value: type(value).__name__,
)
def test_failures_end_with_a_line_a_code_and_no_files(
    invented: SimpleNamespace, failure: BaseException, code: int, message: str, tmp_path: Path
) -> None:
    invented.failure = failure
    result = run("frequencies", ALUMINIUM, "--out", str(tmp_path / "deep" / "out"))
    assert result.exit_code == code
    assert result.stderr.startswith(message)
    assert result.stderr.count("\n") == 1
    assert result.stdout == ""
    assert names(tmp_path) == []


def test_pictures_come_all_together_or_not_at_all(
    invented: SimpleNamespace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(dataset: xr.Dataset) -> None:
        raise ComputationError("cannot draw")

    monkeypatch.setattr("flexmech.plots.plot_agreement", fail)
    result = run("frequencies", ALUMINIUM, "--out", str(tmp_path))
    assert result.exit_code == 1
    assert names(tmp_path) == DATA


def test_error_lines_name_the_greatest_error_and_its_place() -> None:
    dataset = frequency_dataset(engines=("reference",))
    errors = np.zeros(dataset["discretisation_error"].shape)
    errors[0, 2, 3, 1] = -2.5e-4
    errors[0, 1, 0, 0] = np.nan
    dataset["discretisation_error"] = (dataset["discretisation_error"].dims, errors)
    dataset["reduction_error"] = dataset["reduction_error"] * np.nan
    angle = np.degrees(float(dataset["check_angle"][3]))
    assert error_lines(dataset) == [
        "discretisation error (estimated): at most 2.5e-04 of the frequency, reference at "
        f"20 rad/s, {angle:.6g} deg, mode 2",
        "reduction error: not known",
    ]


def test_tracking_lines_name_what_is_torn_and_where_modes_veer() -> None:
    dataset = frequency_dataset(engines=("reference",))
    dataset["veering"] = dataset["veering"] & False
    assert tracking_lines(dataset) == []
    dataset["veering"][0, 2, 5, 1:3] = True
    whole = dataset["branch_whole"].values.copy()
    whole[0, 1, 3] = False
    dataset["branch_whole"] = (dataset["branch_whole"].dims, whole)
    assert tracking_lines(dataset) == [
        "veering, where close modes swap their shapes: reference at 1 of 219 positions "
        "(modes 2, 3; 20 rad/s)",
        "branches that are not whole over these angles: reference at 10 rad/s (4)",
    ]
    # A branch that this engine never meets at this speed is no torn one.
    dataset["branch_of_mode"] = dataset["branch_of_mode"].clip(max=3)
    assert len(tracking_lines(dataset)) == 1


def test_agreement_line_without_a_second_engine() -> None:
    result: Any = InventedResult(frequency_dataset(engines=("exudyn",)))
    assert agreement_line(result) == ("engines: no comparison was made, only the exudyn engine ran")
