"""How a command delivers a result: files, pictures, what is printed, and how it fails."""

from __future__ import annotations

import inspect
import json
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import typer
import xarray as xr
from matplotlib.figure import Figure
from PIL import Image
from typer.testing import CliRunner

from flexmech import plots
from flexmech.analyses import Result, Summary, Table
from flexmech.analyses.digits import Quantity
from flexmech.choices import PAGE_WIDTHS
from flexmech.cli import stopping
from flexmech.cli.application import COMMANDS, STUDIES
from flexmech.cli.deliver import Output, Pictures, Printing, deliver
from flexmech.cli.failures import reports_failures
from flexmech.cli.options import asked_pictures
from flexmech.cli.reading import from_options
from flexmech.cli.typed import Speeds
from flexmech.errors import ComputationError, FlexmechError, InputError
from flexmech.interruption import tidying
from tests.support.plot_data import linkage_dataset

TABLE = Table("sizes", ("name", "size"), ((("a", "1"), ("b", "20")), (("c", "3"),)), caption="mm")


class Sizes(Result):
    """A result that costs nothing."""

    stem = "sizes"
    hallmark = "size"
    files = ("sizes.csv", "sizes.nc", "sizes.png", "picture_*.png", "below/*.csv")

    def tables(self) -> dict[str, pd.DataFrame]:
        frame = pd.DataFrame({"name": ["a", "b"], "size": [1 / 3, np.nan]})
        return {"sizes": frame, "below/sizes": frame}

    def figures(self) -> dict[str, Figure]:
        return {"sizes": self.plot()}

    def plot(self, *, ax: Any = None) -> Figure:
        return plots.plot_linkage(linkage_dataset())

    def summary(self) -> Summary:
        return SUMMARY


SUMMARY = Summary(
    ("The answer.",),
    TABLE,
    "numbers are known",
    ("a <line>", TABLE),
    ("act on it",),
    (Quantity("size", 2.04, "mm", 0.1, "b"), Quantity("turns", 3.0, "")),
)
NO_PICTURES = Pictures(())
SIZES = Sizes(xr.Dataset({"size": ("place", [1.0, 2.0])}, attrs={"mechanism": "model"}))


def run(
    out: Path | None,
    failure: BaseException | None = None,
    *,
    pictures: Pictures = Pictures(),  # noqa: B008
    unit: str = "rad/s",
    printing: Printing = "answer",
) -> Any:
    app = typer.Typer()

    def compute(progress: object) -> Sizes:
        if failure is not None:
            raise failure
        return SIZES

    @app.command()
    @reports_failures
    def command() -> None:
        deliver(Sizes, compute, Output(out, pictures, printing), speeds=Speeds((), unit))

    return CliRunner().invoke(app, [])


def pictures(formats: str, width: str) -> Any:
    return from_options(asked_pictures)(no_plots=False, formats=formats, width=width)


def names(folder: Path) -> list[str]:
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())


def test_files_are_written_and_the_answer_comes_first(tmp_path: Path) -> None:
    out = tmp_path / "new" / "folder"
    result = run(out)
    assert (result.exit_code, result.stderr) == (0, "warning: act on it\n")
    assert names(out) == ["below/sizes.csv", "sizes.csv", "sizes.nc", "sizes.png", "summary.txt"]
    assert (out / "sizes.csv").read_text() == "name,size\na,0.3333333333\nb,\n"
    lines = result.stdout.strip().split("\n")
    assert lines[0] == "The answer."
    listed = ("sizes.csv", "below/sizes.csv", "sizes.nc", "sizes.png", "summary.txt")
    assert lines[-1] == "files: " + ", ".join(str(out / name) for name in listed)
    assert lines[-2] == "numbers are known"
    assert "a <line>" not in result.stdout
    rows = [line.split() for line in lines if "│" in line]
    assert [(row[1], row[3]) for row in rows] == [("a", "1"), ("b", "20"), ("c", "3")]


def test_pictures_are_written_in_all_formats_asked_for(tmp_path: Path) -> None:
    result = run(tmp_path, pictures=pictures("svg, .PDF,svg", "one-column"))
    assert result.exit_code == 0
    assert {"sizes.pdf", "sizes.svg"} <= set(names(tmp_path))
    assert "sizes.png" not in names(tmp_path)
    assert "sizes.pdf" in result.stdout
    # Then another run in another format: what lies there is told.
    assert "from an earlier run, not of this one: sizes.pdf, sizes.svg" in run(tmp_path).stdout


def test_pictures_have_the_width_asked_for(tmp_path: Path) -> None:
    for width, millimetres in PAGE_WIDTHS.items():
        run(tmp_path, pictures=pictures("png", width))
        with Image.open(tmp_path / "sizes.png") as picture:
            assert picture.width == pytest.approx(millimetres / 25.4 * 200, abs=1)


@pytest.mark.parametrize("formats", ["gif", "", "png,,pdf", "pdf svg", "png;pdf"])
def test_formats_that_are_none_are_refused(formats: str) -> None:
    with pytest.raises(InputError, match=r"^--format: .* choose from png, pdf, svg"):
        pictures(formats, "two-column")


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"formats": "png"}, "formats: must be one or more of 'png', 'pdf', 'svg' in a list"),
        ({"formats": ()}, "formats: must be"),
        ({"formats": ("png", "eps")}, "formats: must be"),
        ({"width": "80 mm"}, "width: must be 'one-column' or 'two-column', got '80 mm'"),
    ],
)
def test_formats_and_widths_are_checked_in_python(
    wrong: dict[str, Any], message: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=message):
        SIZES.save(tmp_path, figures=True, **wrong)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", [*COMMANDS, *STUDIES], ids=lambda command: command.__name__)
def test_every_command_that_draws_has_all_options_of_pictures(
    command: Callable[..., None],
) -> None:
    asked = {"no_plots", "formats", "width"} & set(
        inspect.signature(from_options(command)).parameters
    )
    assert len(asked) in (0, 3)


def test_without_a_folder_it_prints_alone(tmp_path: Path) -> None:
    result = run(None)
    assert result.exit_code == 0
    assert "files:" not in result.stdout
    assert result.stdout.strip().split("\n")[-1] == "numbers are known"


def test_details_print_what_the_file_beside_the_others_has(tmp_path: Path) -> None:
    printed = run(tmp_path, printing="details").stdout
    kept = (tmp_path / "summary.txt").read_text(encoding="utf-8")
    assert kept == f"# sizes\nresult of model\n{SUMMARY}\n\n"
    for line in ("The answer.", "numbers are known", "a <line>"):
        assert line in kept
        assert line in printed
    assert printed.index("numbers are known") < printed.index("a <line>")
    assert "warning: act on it" in kept


def test_a_second_command_in_a_folder_keeps_what_the_first_has_found(tmp_path: Path) -> None:
    file = tmp_path / "summary.txt"
    file.write_text("# check\nan answer\n\n# sizes\nof yesterday\n\n", encoding="utf-8")
    run(tmp_path)
    kept = file.read_text(encoding="utf-8")
    assert kept.startswith("# check\nan answer\n\n# sizes\n")
    assert "yesterday" not in kept
    assert kept.count("The answer.") == 1


def test_programs_get_answer_numbers_units_and_errors(tmp_path: Path) -> None:
    said = json.loads(run(tmp_path, printing="json").stdout)
    assert said["answer"] == ["The answer."]
    assert said["numbers"] == [
        {"name": "size", "of": "b", "value": 2.04, "unit": "mm", "error": 0.1},
        {"name": "turns", "of": None, "value": 3.0, "unit": "", "error": None},
    ]
    assert said["table"]["rows"] == [["a", 1.0], ["b", 20.0], ["c", 3.0]]
    assert (said["trust"], said["warnings"]) == ("numbers are known", ["act on it"])
    assert said["details"]["lines"] == ["a <line>"]
    assert [table["title"] for table in said["details"]["tables"]] == ["sizes"]
    assert said["files"][-1] == str(tmp_path / "summary.txt")


def test_what_lies_there_from_an_earlier_run_is_named(tmp_path: Path) -> None:
    (tmp_path / "picture_crank.png").write_bytes(b"old")
    (tmp_path / "notes.txt").write_text("mine")
    result = run(tmp_path, pictures=NO_PICTURES)
    assert "from an earlier run, not of this one: picture_crank.png" in result.stdout
    assert "sizes.png" not in names(tmp_path)


@pytest.mark.parametrize(
    ("failure", "code", "message"),
    [
        (InputError("the linkage locks at 90 deg"), 2, "error: the linkage locks at 90 deg"),
        (
            ComputationError("no equilibrium at {crank_speed}", crank_speed=10 * np.pi),
            1,
            "error: no equilibrium at 300 rpm",
        ),
        (FlexmechError("other"), 1, "error: other"),
        (KeyboardInterrupt(), 130, "interrupted: "),
    ],
    ids=lambda value: type(value).__name__,
)
def test_failures_end_with_a_line_a_code_and_no_files(
    failure: BaseException, code: int, message: str, tmp_path: Path
) -> None:
    result = run(tmp_path / "deep" / "out", failure, unit="rpm")
    assert result.exit_code == code
    assert result.stderr.startswith(message)
    assert result.stderr.count("\n") == 1
    assert result.stdout == ""
    assert names(tmp_path) == []
    assert list(tmp_path.iterdir()) == []


def test_files_come_all_together_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sizes.csv").write_text("old")

    def fail(self: Sizes) -> dict[str, Figure]:
        raise ComputationError("cannot draw")

    monkeypatch.setattr(Sizes, "figures", fail)
    assert run(tmp_path).exit_code == 1
    assert names(tmp_path) == ["sizes.csv"]
    assert (tmp_path / "sizes.csv").read_text() == "old"


def test_a_folder_that_cannot_be_written_is_refused_before_the_work(tmp_path: Path) -> None:
    taken = tmp_path / "taken"
    (taken / "picture_crank.png").mkdir(parents=True)
    for out, message in (
        (taken, "picture_crank.png is a folder there; remove it"),
        (Path(__file__), r"cannot write to"),
    ):
        result = run(out, AssertionError("it was computed"))
        assert result.exit_code == 2
        assert result.stderr.startswith("error: --out: ")
        assert message in result.stderr
    # Where no pictures are asked for, none can be in the way.
    assert run(taken, pictures=NO_PICTURES).exit_code == 0


def test_a_summary_is_a_text_and_a_page() -> None:
    assert str(SUMMARY).split("\n")[:11] == [
        "warning: act on it",
        "The answer.",
        "sizes",
        "name  size",
        "----------",
        "a        1",
        "b       20",
        "----------",
        "c        3",
        "mm",
        "numbers are known",
    ]
    page = SUMMARY._repr_html_()
    assert "<td>20</td>" in page
    assert "a &lt;line&gt;" in page


def test_a_result_shows_itself_in_a_notebook_and_in_one_line() -> None:
    assert repr(SIZES) == "<Sizes of model: place 2>"
    page = SIZES._repr_html_()
    assert page.startswith('<img src="data:image/png;base64,')
    assert "The answer." in page


def test_a_signal_that_compiled_code_turned_into_an_error_is_still_one(tmp_path: Path) -> None:
    """Matplotlib's drawing makes a ValueError of an exception that passes through it."""
    app = typer.Typer()

    @app.command()
    @reports_failures
    def command() -> None:
        try:
            with tidying():
                stopping._stop(signal.SIGTERM, None)
        except KeyboardInterrupt:
            raise ValueError("Invalid bounding box") from None

    result = CliRunner().invoke(app, [])
    assert result.exit_code == 143
    assert result.stderr == "terminated: files that were not complete were not written\n"
    # A later run of this process knows nothing of it.
    failure = ValueError("a defect of the program")
    assert run(tmp_path, failure).exception is failure
