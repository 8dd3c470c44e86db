"""The report without a browser: what it takes, what it refuses, and what stands in the page."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import flexmech
from flexmech.analyses.digits import with_error
from flexmech.cli import app
from flexmech.modelfile import KINDS, template
from flexmech.report import Results, page, stored_results, write_report
from flexmech.report.embedding import Arrays, breakable_markup, equation_markup, json_text
from flexmech.report.last_turn import over_a_turn, thinning
from flexmech.report.moving_linkage import moving_linkage

ROOT = Path(__file__).parents[2]
ALUMINIUM = str(ROOT / "models" / "aluminium_fourbar.toml")
MOST_BYTES = 8_000_000


def run(*arguments: str) -> Any:
    return CliRunner().invoke(app, list(arguments))


def content(text: str) -> Any:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found
    return json.loads(found[1])


def test_the_page_needs_nothing_else(written: Any) -> None:
    text = written.text
    assert len(text.encode()) < MOST_BYTES
    assert text.count("* plotly.js v") == 1
    # Else the page takes twice as long to open: see flexmech/report/embedding.py.
    assert text.count(".register([])") == 1
    own = text.replace(re.search(r"<script>/\*\*\n\* plotly.*?</script>", text, re.DOTALL)[0], "")
    assert not re.search(r"(src|href)\s*=\s*[\"'](?!#|data:)", own)
    for said in ("flexmech 0.1.0", "plotly ", "aluminium_fourbar.toml", "[linkage]", "SHA-256"):
        assert said in own
    names = [panel.name for panel in page.panels_of(written.results)]
    running = ["frequencies", "campbell", "response", "spectrum"]
    assert names == [*running, "kinematics", "sections", "mechanism"]
    for name in names:
        assert f'id="{name}"' in own


def test_every_figure_has_words_and_an_equation(written: Any) -> None:
    for panel in page.panels_of(written.results):
        assert panel.equation, panel.name
        assert panel.source, panel.name
        assert panel.caption.endswith("."), panel.name
        for plot in panel.plots:
            assert plot.text
            for trace in plot.traces:
                assert len(trace.x) == len(trace.y), (plot.name, trace.name)


def test_numbers_in_the_page_are_the_results(written: Any) -> None:
    data = content(written.text)
    frequency = written.results.first(flexmech.MovingFrequencies).dataset["frequency"]
    reading = next(
        one
        for one in data["readings"]
        if one["group"] == "Natural frequency" and one["label"] == "mode 2"
    )
    import base64

    stored = np.frombuffer(base64.b64decode(data["arrays"][reading["value"]]), "<f4")
    np.testing.assert_allclose(stored, frequency[0, 0, :, 1].values, rtol=1e-7)
    assert [each["name"] for each in data["choices"]["speed"]] == ["0 rad/s", "20 rad/s"]


@pytest.mark.thorough
def test_stored_results_give_the_same_panels(written: Any, tmp_path: Path) -> None:
    for number, result in enumerate(written.results.all):
        result.save(tmp_path / str(number))
    loaded = stored_results(tmp_path)
    assert [type(each) for each in loaded.all] == [type(each) for each in written.results.all]
    out = tmp_path / "report.html"
    done = run("report", str(tmp_path), "--out", str(out))
    assert done.exit_code == 0, done.stderr
    assert done.stdout.startswith("Critical speeds: from 26.")
    again, first = content(out.read_text("utf-8")), content(written.text)
    assert [plot["name"] for plot in again["plots"]] == [plot["name"] for plot in first["plots"]]


def test_bad_input_is_one_line(tmp_path: Path, written: Any) -> None:
    (tmp_path / "empty").mkdir()
    out = str(tmp_path / "report.html")
    for arguments, words in (
        ((str(tmp_path / "empty"),), "holds no NetCDF file"),
        ((ALUMINIUM, "--include", "noise"), "--include: got 'noise'"),
        ((ALUMINIUM, "--include", "moisture"), "--include moisture needs --relative-humidity"),
        ((ALUMINIUM, "--include", "coupler-curve"), "needs a coupler point"),
        ((ALUMINIUM, "--include", "campbell", "--speeds", "0"), "--campbell-speeds"),
        ((ALUMINIUM, "--campbell-speeds", "fast"), "--campbell-speeds"),
        ((str(tmp_path / "empty"), "--speeds", "3"), "shown as it is"),
        ((str(tmp_path / "none.toml"),), "none.toml"),
    ):
        done = run("report", *arguments, "--out", out)
        assert done.exit_code == 2, arguments
        assert words in done.stderr
        assert len(done.stderr.strip().splitlines()) == 1
    for place in (tmp_path, tmp_path / "no" / "report.html"):
        assert run("report", ALUMINIUM, "--out", str(place)).exit_code == 2
    assert not Path(out).exists()
    other = flexmech.load_mechanism(ROOT / "models" / "steel_fourbar.toml")
    check = flexmech.check_mechanism(flexmech.ReferenceEngine(other, 2))
    with pytest.raises(flexmech.InputError, match="different model files"):
        write_report([*written.results.all, check], out)
    with pytest.raises(flexmech.InputError, match="one result or more"):
        write_report([], out)


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    done = run("report", ALUMINIUM, "--out", str(tmp_path / "report.html"))
    assert done.exit_code == 2
    assert 'pip install "flexmech[report]"' in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_a_damaged_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "frequencies.nc").write_bytes(b"nothing")
    done = run("report", str(tmp_path), "--out", str(tmp_path / "report.html"))
    assert done.exit_code == 2
    assert "frequencies.nc" in done.stderr


def test_markup_of_names_is_text() -> None:
    text = json_text({"a": "</script>&\u2028\u2029"})
    assert not set(text) & set("<>&\u2028\u2029")
    assert json.loads(text) == {"a": "</script>&\u2028\u2029"}
    assert breakable_markup("<b>") == "&lt;b&gt;"
    assert breakable_markup(f"<{'a/' * 9}> rad/s") == f"&lt;{'a/<wbr>' * 9}&gt; rad/s"
    assert equation_markup("<i> K_g e^{λt}") == "&lt;i&gt; K<sub>g</sub> e<sup>λt</sup>"


def test_the_last_turn_goes_from_zero_to_a_full_turn() -> None:
    forwards = over_a_turn(np.radians(np.arange(0.0, 900.5, 1.0)))
    assert forwards.angle[[0, -1]].tolist() == [0.0, 360.0]
    assert np.all(np.diff(forwards.angle) > 0)
    values = np.arange(0.0, 900.5, 1.0)
    np.testing.assert_allclose(forwards.of(values) % 360, forwards.angle % 360)
    assert forwards.of(values).min() >= 540.0, "of the last turn alone"
    backwards = over_a_turn(np.radians(-np.arange(0.0, 720.5, 0.5)))
    np.testing.assert_allclose(
        backwards.of(-np.arange(0.0, 720.5, 0.5)) % 360, backwards.angle % 360
    )
    assert backwards.left_out > 0
    part = over_a_turn(np.radians(np.arange(30.0, 91.0, 1.0)))
    assert part.angle[[0, -1]].tolist() == [30.0, 90.0]


def test_thinning_keeps_both_ends() -> None:
    kept = thinning(2881, 400)
    assert kept[0] == 0
    assert kept[-1] == 2880
    assert len(kept) <= 402
    assert thinning(3).tolist() == [0, 1, 2]


def test_numbers_have_the_digits_that_their_errors_leave() -> None:
    assert with_error(26.7161, 0.0099) == "26.72 ± 0.01"
    assert with_error(0.2017, 0.00012) == "0.2017 ± 0.0001"
    assert with_error(2.0, float("nan")) == "2"


def test_mode_shapes_turn_with_the_links(written: Any) -> None:
    """Shapes in link frames, turned back, are those of the map; pins do not move across."""
    import base64

    mechanism = flexmech.load_mechanism(ALUMINIUM)
    arrays = Arrays()
    drawn = moving_linkage(mechanism, written.results, arrays)

    def decoded(number: int) -> Any:
        return np.frombuffer(base64.b64decode(arrays.encoded[number]), "<f4")

    one = drawn["shapes"][0]
    angles = decoded(one["angle"])
    assert angles[[0, -1]].tolist() == [0.0, 360.0]
    shape = decoded(one["values"]).reshape(len(angles), 3, one["stations"], 2)
    assert np.hypot(*np.moveaxis(shape, -1, 0)).max() == pytest.approx(1.0, rel=1e-6)
    assert np.abs(shape[:, 0, 0]).max() < 1e-6, "the crank is clamped"
    follows = np.sum(shape[1:] * shape[:-1], axis=(1, 2, 3))
    assert np.all(follows > 0), "no shape turns its sign from angle to angle"
    turn = [decoded(link["turn"]) for link in drawn["links"]]
    origin = decoded(drawn["links"][1]["origin"]).reshape(-1, 2)
    np.testing.assert_allclose(origin[:, 0], 0.102 * np.cos(turn[0]), atol=1e-6)


def test_a_mechanism_built_in_python_is_drawn_if_it_is_given(written: Any, tmp_path: Path) -> None:
    check = written.results.first(flexmech.ModelCheck)
    bare = flexmech.ModelCheck(check.dataset.assign_attrs(model_text="", model_sha256=""))
    assert content(write_report(bare, tmp_path / "a.html").read_text("utf-8"))["linkage"] is None
    mechanism = flexmech.load_mechanism(ALUMINIUM)
    page = write_report(bare, tmp_path / "b.html", mechanism=mechanism).read_text("utf-8")
    assert len(content(page)["linkage"]["links"]) == 3
    assert Results.of(bare).attribute("model_text") == ""


def test_the_title_is_the_models_and_not_a_templates(written: Any) -> None:
    check = written.results.first(flexmech.ModelCheck).dataset

    def title(name: str, file: str) -> str:
        told = check.assign_attrs(mechanism=name, model_file=file)
        return page._title(Results.of(flexmech.ModelCheck(told)))

    assert title("aluminium four-bar", "aluminium_fourbar.toml") == "Aluminium four-bar"
    for kind in KINDS:
        name = tomllib.loads(template(kind))["name"]
        assert title(name, "feed_pump.toml") == "Feed_pump"
        assert title(f"{name} of the feed pump", "feed_pump.toml").endswith("of the feed pump")


def test_the_campbell_diagram_ends_where_that_of_the_command_does() -> None:
    """At 1.5 times the greatest speed, which is one of its speeds."""
    engine = flexmech.ReferenceEngine(flexmech.load_mechanism(ALUMINIUM), 2)
    few = np.radians(np.arange(0.0, 360.0, 90.0))
    request = flexmech.ReportRequest([10.0, 20.0], few, ("campbell",), modes=1, tolerance=None)
    found = flexmech.report_results(engine, request).first(flexmech.CampbellDiagram)
    assert found is not None
    speeds = found.dataset["crank_speed"].values
    assert speeds[[0, -1]] == pytest.approx([0.0, 30.0])
    assert np.isclose(speeds, 20.0).any()
