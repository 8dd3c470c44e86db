"""The brief page: the numbers of the commands on one screen and one sheet, and what is lacking."""

from __future__ import annotations

import html
import json
import re
from pathlib import Path
from typing import Any

import pytest

import flexmech
from flexmech.analyses.digits import rounded
from tests.report.conftest import Write
from tests.support import results
from tests.support.command import MODELS, run_command

MODEL = "models/aluminium_fourbar.toml"
COARSE = ("--elements", "2", "--engine", "reference")
BRIEF = ("--brief", "--speeds", "20", "--modes", "2", "--campbell-speeds", "0:30:10")
RUN = ("--speed", "20", "--start", "periodic", "--revolutions", "1", "--modes", "2")
MOST_BYTES = 400_000
SHEETS = re.compile(rb"/Type\s*/Page[^s]")
# Parts of the page that reach beyond a screen, and words that reach beyond their part.
BEYOND = """() => [...document.querySelectorAll('header, #stage, .answer, .answer *, #panels')]
    .filter(each => each.getBoundingClientRect().right > innerWidth + 1
        || each.scrollWidth > each.clientWidth + 1 && each.clientWidth)
    .map(each => each.textContent)"""
TURNED = "before => document.getElementById('angle').value != before"
ON_ONE_SCREEN = "() => document.documentElement.scrollHeight <= innerHeight"


def text_of(page: Path) -> str:
    """Words of a page without its elements, with single blanks."""
    body = page.read_text(encoding="utf-8").partition("<body")[2].partition("<script")[0]
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", body)).split())


def test_the_brief_page_tells_the_numbers_of_the_commands(tmp_path: Path) -> None:
    page = tmp_path / "brief.html"
    asked = (*BRIEF, *COARSE, "--out", page)
    ended = run_command(tmp_path, "report", MODEL, *asked)
    assert ended.exit_code == 0, ended.stderr
    text = text_of(page)

    ended = run_command(tmp_path / "run", "response", MODEL, *RUN, *COARSE, "--no-plots", "--json")
    run = json.loads(ended.stdout)["numbers"]

    def told(name: str, of: str | None = None) -> list[str]:
        known = sorted(run, key=lambda one: -one["value"])
        return [
            f"{rounded(one['value'], one['error'])} {one['unit']}"
            for one in known
            if one["name"] == name and of in (None, one["of"])
        ]

    assert f"Deflection at the tool {told('peak_path_deviation')[0]}" in text
    assert f"Stress and safety factor {told('peak_stress')[0]}, factor" in text
    assert f"{told('rms_torque')[0]} RMS peak {told('peak_driving_torque')[0]}" in text
    for joint in ("O2", "A", "B", "O4"):
        mean, peak = (told(name, joint)[0] for name in ("cubic_mean_force", "peak_joint_force"))
        assert f"{joint} {mean.removesuffix(' N')} {peak.removesuffix(' N')}" in text
    factor = re.search(r"MPa, factor ([\d.]+)", text)
    assert factor, text
    stress = max(one["value"] for one in run if one["name"] == "peak_stress")
    # Bending stress alone, without shear; yield strength of the model file in MPa.
    assert float(factor[1]) == pytest.approx(240 / stress, rel=5e-3)
    mechanism = flexmech.load_mechanism(MODELS.parent / MODEL)
    assert f"Moving mass {1e3 * mechanism.total_mass:.4g} g" in text
    assert "orders 1 to 10 of the crank meet" in text


def test_the_brief_page_is_small_and_needs_nothing_else(write: Write) -> None:
    page = write(results.check(), results.response(), brief=True)
    assert len(page.text.encode()) < MOST_BYTES
    assert "plotly.js v" not in page.text
    assert not re.search(r"(src|href)\s*=\s*[\"'](?!#|data:)", page.text)
    assert page.content["plots"] == []
    assert len(page.content["linkage"]["runs"]) == results.response().dataset.sizes["engine"]


def test_what_no_analysis_answers_is_a_line_with_its_remedy(tmp_path: Path) -> None:
    """A model without strengths, and a folder without a run."""
    model = tmp_path / "unknown.toml"
    text = (MODELS.parent / MODEL).read_text(encoding="utf-8")
    model.write_text(re.sub(r"(?m)^yield_strength.*$", "", text), encoding="utf-8")
    page = tmp_path / "brief.html"
    asked = (*BRIEF, *COARSE, "--out", page)
    ended = run_command(tmp_path, "report", model, *asked)
    assert ended.exit_code == 0, ended.stderr
    assert re.search(r"No safety factor: links\.crank: [^.]*yield_strength", text_of(page))
    results.check().save(tmp_path / "check")
    ended = run_command(tmp_path, "report", tmp_path / "check", "--brief", "--out", page)
    assert ended.exit_code == 0, ended.stderr
    assert text_of(page).count("flexmech response answers it") == 3
    assert "flexmech campbell answers it" in text_of(page)


@pytest.mark.thorough
def test_the_brief_page_fits_a_screen_a_phone_and_a_sheet(write: Write, browser: Any) -> None:
    page = write(results.check(), results.response(), results.campbell(), brief=True)
    opened = browser.new_page(viewport={"width": 1366, "height": 768})
    said: list[str] = []
    opened.on("pageerror", lambda error: said.append(str(error)))
    opened.goto(page.path.as_uri())
    opened.wait_for_selector("html[data-ready=yes]", state="attached", timeout=60_000)
    assert opened.evaluate(ON_ONE_SCREEN)
    before = opened.input_value("#angle")
    opened.wait_for_function(
        "before => document.getElementById('angle').value != before", arg=before
    )
    assert len(SHEETS.findall(opened.pdf(prefer_css_page_size=True))) == 1
    assert opened.evaluate(BEYOND) == []
    opened.set_viewport_size({"width": 390, "height": 800})
    assert opened.evaluate(BEYOND) == []
    opened.close()
    assert not said
