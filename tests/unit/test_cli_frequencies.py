"""The frequencies command around its analysis: what its options become, what its lines say."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from flexmech.analyses import MovingFrequencies
from flexmech.analyses.digits import percent
from flexmech.analyses.frequencies.compute import with_states
from flexmech.analyses.frequencies.words import error_lines, tracking_lines
from flexmech.analyses.summary import Summary, Table
from flexmech.cli import app
from flexmech.linear_system import Engine, RotationTerms
from tests.support.plot_data import frequency_dataset

pytestmark = pytest.mark.usefixtures("rough_pictures")

ALUMINIUM = str(Path(__file__).parents[2] / "models" / "aluminium_fourbar.toml")
DATA = ["frequencies.csv", "frequencies.nc", "summary.txt"]
PICTURES = ["agreement.png", "frequencies.png", "mode_shapes.png", "speed_effect.png"]
QUICK = ["--angles", "0,60", "--modes", "2", "--elements", "2"]


def run(*arguments: str) -> Any:
    return CliRunner().invoke(app, ["frequencies", *arguments, "--details"])


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What the analysis was called with; it returns invented numbers at no cost."""
    seen: dict[str, Any] = {}

    def analysis(engines: list[Engine], angles: Any, speeds: Any, **options: Any) -> Any:
        seen.update(engines=engines, angles=angles, speeds=speeds, **options)
        elements = tuple((engine.name, engine.element) for engine in engines)
        return MovingFrequencies(frequency_dataset(engines=[name for name, _ in elements]))

    monkeypatch.setattr("flexmech.analyses.moving_frequencies", analysis)
    return seen


def test_defaults_are_those_of_the_manual(
    asked: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = run(ALUMINIUM, "--no-plots")
    assert result.exit_code == 0, result.output
    engines = [(one.name, one.element, one.elements) for one in asked.pop("engines")]
    assert engines == [("reference", "euler", 8), ("exudyn", "ancf", 8)]
    np.testing.assert_array_equal(asked.pop("angles"), np.radians(np.arange(0, 361, 5)))
    assert asked == {
        "speeds": pytest.approx([0.0, 10.0, 20.0]),
        "modes": None,
        "prestress": "equilibrium",
        "rotation_terms": RotationTerms(),
        "speed_effect": False,
        "environment": None,
        "speed_unit": "rad/s",
        "tolerance": 1e-3,
        "shapes_at": None,
        "smooth": False,
        "shaft": "prescribed",
        "progress": None,
    }
    assert names(tmp_path / "results") == DATA


@pytest.mark.parametrize(
    ("arguments", "elements"),
    [
        (["--element", "euler"], ["euler", "ancf"]),
        (["--element", "ancf"], ["euler", "ancf"]),
        (["--element", "geometrically-exact"], ["timoshenko", "geometrically-exact"]),
        (["--engine", "exudyn"], ["ancf"]),
        (["--engine", "exudyn", "--element", "geometrically-exact"], ["geometrically-exact"]),
        (["--engine", "reference", "--element", "euler"], ["euler"]),
    ],
    ids=str,
)
def test_an_element_goes_to_the_engine_that_has_it(
    asked: dict[str, Any], arguments: list[str], elements: list[str], tmp_path: Path
) -> None:
    result = run(ALUMINIUM, "--no-plots", "--out", str(tmp_path), *arguments)
    assert result.exit_code == 0, result.output
    assert [one.element for one in asked["engines"]] == elements


@pytest.mark.parametrize(
    ("operation", "wanted"),
    [
        ("", [0.0, 10.0, 20.0]),
        ('[operation]\ncrank_speeds = ["3 rad/s", "-1 rad/s"]\n', [-1.0, 0.0, 3.0]),
    ],
)
def test_speeds_left_out_are_those_of_the_model(
    tmp_path: Path, operation: str, wanted: list[float]
) -> None:
    text = Path(ALUMINIUM).read_text()
    model = tmp_path / "own.toml"
    model.write_text(text[: text.index("[operation]")] + operation)
    out = ["--engine", "reference", "--no-plots", "--out", str(tmp_path / "out")]
    assert run(str(model), *QUICK, *out).exit_code == 0
    found = MovingFrequencies.load(tmp_path / "out" / "frequencies.nc").dataset
    assert found["crank_speed"].values.tolist() == wanted


@pytest.mark.parametrize(
    ("arguments", "pictures"),
    [
        ([], PICTURES),
        (["--engine", "reference"], PICTURES[1:]),
        pytest.param(["--speeds", "0"], PICTURES[:3], marks=pytest.mark.thorough),
        pytest.param(["--prestress", "none"], PICTURES[:3], marks=pytest.mark.thorough),
    ],
    ids=str,
)
def test_pictures_are_those_that_there_is_data_for(
    arguments: list[str], pictures: list[str], tmp_path: Path
) -> None:
    result = run(ALUMINIUM, *QUICK, "--out", str(tmp_path), *arguments)
    assert result.exit_code == 0, result.output
    assert names(tmp_path) == sorted(DATA + pictures)
    for name in pictures:
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")


def test_the_unit_typed_is_the_unit_read(tmp_path: Path) -> None:
    """One unit, at the end, is that of all speeds; files stay in SI."""
    options = ["--engine", "reference", "--no-plots", "--out", str(tmp_path)]
    result = run(ALUMINIUM, *QUICK, "--speeds", "0,50,100 rpm", *options)
    assert result.exit_code == 0, result.output
    loaded = MovingFrequencies.load(tmp_path / "frequencies.nc")
    speeds = loaded.dataset["crank_speed"].values
    assert speeds == pytest.approx([0.0, 5.235987755982989, 10.471975511965978])
    lines = result.stdout.split("\n")
    (heading,) = [line for line in lines if "mode" in line and "engine" in line]
    assert "rpm" in heading
    cells = [line.split("│")[2].strip() for line in lines if line.startswith("│")]
    assert list(dict.fromkeys(cells)) == ["0", "50", "100"]
    assert "rad/s" not in result.stdout
    legend = loaded.plot().legends[0]
    assert [text.get_text() for text in legend.get_texts()][:3] == ["0 rpm", "50 rpm", "100 rpm"]


def test_a_failure_speaks_of_the_speed_as_it_was_typed(tmp_path: Path) -> None:
    options = [*QUICK, "--engine", "reference", "--prestress", "axial", "--no-plots"]
    result = run(ALUMINIUM, *options, "--speeds", "0:3000:1500 rpm", "--out", str(tmp_path))
    assert result.exit_code == 1
    assert "crank speed 3000 rpm" in result.stderr
    assert "rad/s" not in result.stderr


def test_the_last_line_says_how_far_the_engines_differ(tmp_path: Path) -> None:
    dataset = frequency_dataset()
    dataset["frequency"][1] = dataset["frequency"][0]
    dataset["frequency"][1, 2, 27, 2] = dataset["frequency"][0, 2, 27, 2] * (1 + 3.21e-5)
    line = (
        "engines: reference and exudyn differ by at most 3.21e-05 of the frequency, at 20 rad/s, "
        "135 deg, mode 3"
    )
    for error, judged in (
        (2e-5, ", within their estimated errors (2.0e-05 of reference and 2.0e-05 of exudyn)"),
        (1e-5, ", which is beyond their estimated errors (1.0e-05 of reference and 1.0e-05 of "),
    ):
        dataset["discretisation_error"][:], dataset["reduction_error"][:] = error, 0.0
        assert MovingFrequencies(dataset).summary().details[-1].startswith(line + judged)
    dataset["discretisation_error"][1] /= 2
    assert (
        "; trust exudyn, whose error is the smaller"
        in MovingFrequencies(dataset).summary().details[-1]
    )
    alone = MovingFrequencies(frequency_dataset(engines=("exudyn",)))
    assert alone.summary().details[-1] == (
        "engines: no comparison was made, only the exudyn engine ran"
    )


def test_engines_agree_where_errors_explain_every_mode_alone() -> None:
    """The greatest difference is within its error; a smaller one of another mode is not."""
    dataset = frequency_dataset()
    dataset["discretisation_error"][:], dataset["reduction_error"][:] = 1e-6, 0.0
    dataset["discretisation_error"].loc[{"mode": 4}] = 0.05
    dataset["frequency"][1] = dataset["frequency"][0]
    dataset["frequency"][1, 2, 27, 3] *= 1.06
    dataset["frequency"][1, 1, 9, 1] *= 1.02
    said = MovingFrequencies(dataset).summary()
    assert said.trust.startswith("reference and exudyn differ by 2 %, more than their errors of ")
    line = (
        "engines: reference and exudyn differ by 2.00e-02 of the frequency, at 10 rad/s, 45 deg, "
    )
    assert said.details[-1].startswith(f"{line}mode 2, which is beyond their estimated errors")
    assert said.warnings[0] == said.details[-1]


def test_the_last_line_says_why_a_tolerance_is_not_reached() -> None:
    dataset = frequency_dataset()
    dataset["frequency"][1] = dataset["frequency"][0] * (1 + 1.5e-3)
    dataset["discretisation_error"][:], dataset["reduction_error"][:] = 9e-4, 0.0
    assert MovingFrequencies(dataset).summary().details[-1].endswith("9.0e-04 of exudyn)")
    dataset = dataset.assign_attrs(tolerance=1e-3).assign_coords(elements=("engine", [8, 32]))
    each = "; each error is within the tolerance of 1e-03, both together are not"
    assert MovingFrequencies(dataset).summary().details[-1].endswith(each)
    dataset["discretisation_error"][1] = 1.2e-3
    needed = (
        "; beyond the tolerance of 1e-03, for which exudyn needs more than the 32 elements on a "
        "link that are taken unasked; trust reference"
    )
    assert MovingFrequencies(dataset).summary().details[-1].endswith(needed)
    dataset["frequency"][1] = dataset["frequency"][0] * (1 + 9e-4)
    assert "tolerance" not in MovingFrequencies(dataset).summary().details[-1]


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
    unclear = xr.zeros_like(dataset["veering"])
    unclear[0, 2, 6, 1:3] = True
    angle = np.degrees(float(dataset["crank_angle"][6]))
    assert tracking_lines(dataset.assign(branch_unclear=unclear))[1] == (
        "branches that are not clear, even in the shortest steps between the angles: reference at "
        f"20 rad/s, modes 2, 3, before {angle:.6g} deg"
    )
    # A branch that this engine never meets at this speed is no torn one.
    dataset["branch_of_mode"] = dataset["branch_of_mode"].clip(max=3)
    assert len(tracking_lines(dataset)) == 1


def test_a_free_shaft_is_asked_of_all_engines(asked: dict[str, Any], tmp_path: Path) -> None:
    result = run(ALUMINIUM, "--shaft", "free", "--no-plots", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert len(asked["engines"]) == 2
    assert asked["shaft"] == "free"


def test_the_mode_of_a_free_shaft_is_rigid_and_has_a_table(tmp_path: Path) -> None:
    more = ("--engine", "reference", "--shaft", "free", "--speeds", "0")
    result = run(ALUMINIUM, *QUICK, *more, "--no-plots", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert "rigid: the mode of the free shaft, below 0.001 Hz in all positions" in result.output
    header, *rows = (tmp_path / "shaft.csv").read_text().splitlines()
    columns = "engine,crank_speed_rad_s,crank_angle_deg,kind,frequency_Hz,growth_rate_1_s"
    assert header == columns
    assert [row.split(",")[:4] for row in rows] == [
        ["reference", "0", angle, "rigid"] for angle in ("0", "60")
    ]


# --- what is printed first ----------------------------------------------------------------------

MODES, SPEEDS = (1, 2), (0.0, 20.0)


def damped(error: float, *, engines: tuple[str, ...] = ("reference",)) -> xr.Dataset:
    """Ratios of 0.1 % at the first angle and 0.3 % elsewhere, in every mode."""
    data = frequency_dataset(SPEEDS, modes=len(MODES), engines=engines)
    ratio = xr.full_like(data["frequency"], 3e-3)
    ratio[{"crank_angle": 0}] = 1e-3
    wrong = xr.full_like(data["discretisation_error"], error)
    return data.assign(
        damping_ratio=ratio,
        damping_ratio_discretisation_error=wrong,
        damping_ratio_reduction_error=0.5 * wrong,
    ).assign_attrs(damped_by="Kelvin-Voigt")


def first_said(data: xr.Dataset) -> Summary:
    return MovingFrequencies(data).summary()


def table_of(said: Summary) -> Table:
    assert said.table is not None
    return said.table


def test_damping_ratios_of_modes_stand_in_the_table_where_something_is_damped() -> None:
    table = table_of(first_said(damped(1e-6)))
    assert table.headings[-2:] == ("damping %", "to %")
    assert "damping: by Kelvin-Voigt" in table.caption
    for group in table.groups:
        for row in group:
            assert [float(cell) for cell in row[-2:]] == pytest.approx([0.1, 0.3])
    plain = table_of(first_said(frequency_dataset()))
    assert plain.headings[-1] == "at deg"
    assert plain.caption == ""


def test_both_kinds_of_damping_have_columns_of_their_own() -> None:
    data = damped(1e-6)
    data = data.assign(strain_energy_damping=2 * data["damping_ratio"])
    table = table_of(first_said(data))
    assert table.headings[-4:] == ("damping %", "to %", "strain-energy damping %", "to %")
    # No error is known of the second: three digits.
    assert table.groups[0][0][-2:] == ("0.200", "0.600")
    names = {number.name for number in first_said(data).numbers}
    assert {"lowest_damping_ratio", "highest_strain_energy_damping"} <= names


def test_damping_has_the_digits_that_its_error_leaves() -> None:
    """Mesh and component modes together are off by 1.5 times the error of the mesh."""
    cells = {}
    for error in (1e-7, 2e-4):
        said = first_said(damped(error))
        cells[error] = table_of(said).groups[0][0][-2:]
        assert said.trust.endswith(f"; damping to {percent(1.5 * error / 3e-3)} of it")
        number = next(n for n in said.numbers if n.name == "highest_damping_ratio")
        assert number.value == pytest.approx(0.3)
        assert number.error == pytest.approx(150 * error)
    assert cells == {1e-7: ("0.1000", "0.3000"), 2e-4: ("0.10", "0.30")}


def test_engines_that_differ_leave_fewer_digits_of_damping() -> None:
    data = damped(1e-7, engines=("reference", "exudyn"))
    data["damping_ratio"][1] *= 1.05
    both = table_of(first_said(data)).groups[0][0]
    assert both[0] == "both"
    assert both[-2:] == ("0.10", "0.30")


def test_a_mode_that_nothing_damps_has_no_ratio() -> None:
    data = damped(1e-7)
    data["damping_ratio"][:] = 1e-14
    assert table_of(first_said(data)).groups[0][0][-2:] == ("0", "0")


def in_two_states(error: float, engines: tuple[str, ...] = ("reference",)) -> xr.Dataset:
    """Frequencies that heat and moisture lower by 1.23456 %."""
    dry = frequency_dataset(SPEEDS, modes=2, engines=engines, speed_effect=False)
    dry["discretisation_error"][:] = error
    dry["reduction_error"][:] = 0.0
    wet = dry.assign(frequency=(1 - 0.0123456) * dry["frequency"])
    both = with_states({"dry": dry, "+60 K": wet}, ["state: +60 K"])
    return both.assign_attrs(mechanism="invented")


@pytest.mark.parametrize(
    ("error", "told"),
    [
        # No more than four digits, below which the error is none of them.
        (1e-7, "-1.235 %"),
        (1e-4, "-1.23 % ± 0.02 %"),
        (2e-3, "-1.2 % ± 0.4 %"),
        (2e-2, "-1 % ± 4 %"),
    ],
)
def test_changes_in_percent_end_where_their_error_begins(error: float, told: str) -> None:
    """Of frequencies in both states together."""
    said = first_said(in_two_states(error))
    assert said.answer[-1] == f"Heat and moisture change f1 by {told} against the dry linkage."
    (line,) = (str(part) for part in said.details if str(part).startswith("against dry"))
    assert line == f"against dry: {told} (mode 1), {told} (mode 2)"


def test_engines_that_differ_in_a_change_are_its_error() -> None:
    data = in_two_states(1e-7, ("reference", "exudyn"))
    data["frequency"][{"state": 1, "engine": 1}] *= 1.003
    assert "by -1.2 % ± 0.3 % against" in first_said(data).answer[-1]


def test_what_the_speed_changes_has_the_error_of_both_speeds() -> None:
    data = frequency_dataset(SPEEDS, modes=2, engines=("reference",))
    data["reduction_error"][:] = 0.0
    data["discretisation_error"][:, 0] = 1e-4
    data["discretisation_error"][:, 1] = 2e-4
    assert first_said(data).answer[1].endswith(" % ± 0.03 %.")
    data["frequency"][:, 1] = 1.02 * data["frequency"][:, 0].values
    assert "changes f1 by +2.00 % ± 0.03 %." in first_said(data).answer[1]
