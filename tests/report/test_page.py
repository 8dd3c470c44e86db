"""The page needs nothing else, is of one mechanism, and names of a model are text in it."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

import flexmech
from tests.report.conftest import Write
from tests.support import results
from tests.support.command import MODELS, run_command
from tests.support.report_page import Page

MOST_BYTES = 8_000_000
EVIL = "</script><script>window.hacked = 1</script> <b>& \u2028 \u2029"


def test_the_page_needs_no_network_and_names_its_versions_and_its_model(fourbar: Page) -> None:
    assert len(fourbar.text.encode()) < MOST_BYTES
    page = re.sub(r"<script>/\*\*\n\* plotly.*?</script>", "", fourbar.text, flags=re.DOTALL)
    assert len(page) < len(fourbar.text), "plotly is inside"
    assert not re.search(r"(src|href)\s*=\s*[\"'](?!#|data:)", page)
    sha = results.check().dataset.attrs["model_sha256"]
    for words in (f"flexmech {flexmech.__version__}", "plotly ", "aluminium_fourbar.toml", sha):
        assert words in page
    assert "[linkage]" in page, "the model file"
    assert [choice["name"] for choice in fourbar.content["choices"]["engine"]] == [
        "reference",
        "exudyn",
    ]


def test_the_command_reports_a_model_and_then_what_it_stored(tmp_path: Path) -> None:
    """At rest and at 20 rad/s with two elements a link; the report of the folder is the same."""
    page = tmp_path / "report.html"
    words = ("--speeds", "0,20", "--angles", "0:360:90", "--elements", "2", "--modes", "2")
    asked = (*words, "--engine", "reference", "--include", "frequencies,kinematics")
    ended = run_command(tmp_path, "report", "models/aluminium_fourbar.toml", *asked, "--out", page)
    assert ended.exit_code == 0, ended.stderr
    first = Page(page)
    assert first.panels == ["frequencies", "kinematics", "mechanism", "provenance"]
    drawn = first.traces("frequency")
    frequencies = {trace.name: trace.y for trace in drawn if trace.name != "veering"}
    assert set(frequencies) == {"0 rad/s", "20 rad/s"}
    engine = flexmech.ReferenceEngine(flexmech.load_mechanism(MODELS / "aluminium_fourbar.toml"), 2)
    found = flexmech.moving_frequencies(engine, np.radians(np.arange(0, 361, 90)), [0, 20], modes=2)
    np.testing.assert_allclose(
        frequencies["20 rad/s"], found.dataset["frequency"][0, 1, :, 1], rtol=1e-6
    )
    folder = tmp_path / "stored"
    for number, result in enumerate((found, results.kinematics())):
        result.save(folder / str(number))
    ended = run_command(tmp_path, "report", folder, "--out", page)
    assert ended.exit_code == 0, ended.stderr
    again = Page(page)
    assert again.panels == ["frequencies", "kinematics", "provenance"]
    # CSV files are rounded, NetCDF files are not.
    assert again.content["arrays"][0] in first.content["arrays"]


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("EMPTY",), "holds no NetCDF file"),
        (("DAMAGED",), "frequencies.nc"),
        (("none.toml",), "none.toml"),
        (("MODEL", "--include", "noise"), "noise"),
        (("MODEL", "--include", "moisture"), "--relative-humidity"),
        (("MODEL", "--include", "coupler-curve"), "coupler point"),
        (("MODEL", "--include", "campbell", "--speeds", "0"), "--campbell-speeds"),
        (("MODEL", "--campbell-speeds", "fast"), "--campbell-speeds"),
        (("EMPTY", "--speeds", "3"), "--speeds"),
        (("MODEL", "--brief", "--include", "section"), "--include"),
        (("MODEL", "--brief", "--speeds", "0"), "--speeds"),
    ],
)
def test_what_cannot_be_reported_is_refused_in_a_line(
    words: tuple[str, ...], named: str, tmp_path: Path
) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / "frequencies.nc").write_bytes(b"nothing")
    places = {
        "EMPTY": str(tmp_path / "empty"),
        "DAMAGED": str(tmp_path / "damaged"),
        "MODEL": "models/aluminium_fourbar.toml",
    }
    typed = [places.get(word, word) for word in words]
    page = tmp_path / "report.html"
    ended = run_command(tmp_path, "report", *typed, "--out", page)
    assert ended.exit_code == 2
    assert named in ended.stderr
    assert len(ended.stderr.strip().splitlines()) == 1
    assert not page.exists()


def test_results_of_two_models_and_of_none_are_refused(tmp_path: Path) -> None:
    steel = flexmech.load_mechanism(MODELS / "steel_fourbar.toml")
    check = flexmech.check_mechanism(flexmech.ReferenceEngine(steel, 2))
    with pytest.raises(flexmech.InputError, match="different model files"):
        flexmech.write_report([results.check(), check], tmp_path / "a.html")
    with pytest.raises(flexmech.InputError, match="one result or more"):
        flexmech.write_report([], tmp_path / "a.html")
    assert not list(tmp_path.iterdir())


def test_a_mechanism_of_python_is_drawn_if_it_is_given(write: Write) -> None:
    check = results.check()
    attributes = check.dataset.attrs | {"model_text": "", "model_sha256": ""}
    bare = flexmech.ModelCheck(check.dataset.assign_attrs(attributes))
    assert write(bare).content["linkage"] is None
    drawn = write(bare, mechanism=results.fourbar()).content["linkage"]
    assert len(drawn["links"]) == 3


def test_a_title_is_the_name_of_the_model_or_else_of_its_file(write: Write) -> None:
    """Not the name that a template came with, and nobody changed."""

    def title(name: str, file: str) -> str:
        told = results.check().dataset.assign_attrs(mechanism=name, model_file=file)
        return re.search("<title>(.*?)</title>", write(flexmech.ModelCheck(told)).text)[1]

    assert title("feed pump", "pump.toml") == "Feed pump"
    assert title("my four-bar", "feed_pump.toml") == "Feed_pump"


def test_names_of_a_model_are_text(write: Write) -> None:
    """Whatever stands in them: none ends a script or becomes an element."""
    check = results.check()
    told = check.dataset.assign_attrs(
        mechanism=EVIL, source=EVIL, model_text=f"# {EVIL}\n{check.dataset.attrs['model_text']}"
    )
    page = write(dataclasses.replace(check, dataset=told))
    assert "window.hacked" in page.text
    assert "<script>window" not in page.text
    assert "<b>" not in page.text


@pytest.mark.thorough
def test_links_that_do_not_bend_have_no_curve(write: Write) -> None:
    data = flexmech.plots.chosen(results.response().dataset, engine="reference")
    rigid = data.assign(deflection=data["deflection"].where(data["link"] != "crank", 0.0))
    page = write(flexmech.Response(rigid))
    labels = {trace.axis for trace in page.traces("deflection")}
    assert labels
    assert not any("Crank" in label for label in labels)


def test_double_points_of_a_coupler_curve_stand_on_the_page(write: Write) -> None:
    data = results.coupler_paths().dataset
    shown = write(results.coupler_paths()).traces("coupler")
    crunodes = [(float(t.x[0]), float(t.y[0])) for t in shown if t.name == "crunode"]
    np.testing.assert_allclose(crunodes, 1e3 * data["double_point_position"], rtol=1e-6)


def test_several_results_of_a_kind_are_told_apart(write: Write) -> None:
    """Torques of inertia grow as the square of the speed."""
    request = (
        flexmech.analyses.KinematicsRequest(speed, crank_angles=results.TURN)
        for speed in (10.0, 20.0)
    )
    page = write(*(flexmech.kinematics(results.fourbar(), each) for each in request))
    torque = {
        trace.when["speed"]: np.abs(trace.y).max()
        for trace in page.traces("drive")
        if trace.axis.startswith("Torque")
    }
    assert torque["20 rad/s"] == pytest.approx(4 * torque["10 rad/s"], rel=1e-6)


def test_a_report_computes_kinematics_and_a_campbell_diagram_at_its_speeds() -> None:
    """The diagram ends at 1.5 times the greatest speed; rigid motion at zero is left out."""
    request = flexmech.report.ReportRequest(
        [0.0, 10.0, 20.0],
        np.radians([0.0, 90.0, 180.0, 270.0]),
        include=("campbell", "kinematics"),
        modes=1,
        tolerance=None,
    )
    found = flexmech.report_results(results.reference(), request)
    speeds = [each.dataset.attrs["crank_speed"] for each in found.of_kind(flexmech.Kinematics)]
    assert speeds == [10.0, 20.0]
    diagram = found.first(flexmech.CampbellDiagram)
    assert diagram.dataset["crank_speed"].values[[0, -1]] == pytest.approx([0.0, 30.0])
