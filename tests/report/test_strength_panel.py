"""The report shows stored strength: its answer, what is used along the links, internal forces."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexmech
from flexmech.choices import LoadSource
from flexmech.report import write_report
from flexmech.report.answers import cards, report_summary
from flexmech.report.panel import Panel
from flexmech.report.panels.strength import strength_panel
from flexmech.report.results import Results, stored_results
from tests.report.test_in_a_browser import PHONE, READY
from tests.support.strength_data import composite


@pytest.fixture(scope="module")
def found() -> flexmech.Strength:
    return flexmech.strength(composite(), 9000.0, speed_unit="rpm")


def panel(*found: flexmech.Result) -> Panel:
    made = strength_panel(Results.of(list(found)))
    assert made is not None
    return made


def test_a_folder_with_strength_has_its_panel(found: flexmech.Strength, tmp_path: Path) -> None:
    found.save(tmp_path)
    results = stored_results(tmp_path)
    assert isinstance(results.all[0], flexmech.Strength)
    shown, said = panel(*results.all), found.summary()
    assert shown.answer == said.answer
    assert shown.tables == said.tables[:1]
    assert set(shown.lines) <= set(said.lines)
    assert shown.source
    used, forces = shown.plots
    worst = {trace.name: trace.y.max() for trace in used.traces}
    assert worst.pop("fails") == 100.0
    data = found.dataset
    for name, factor in zip(data["margin_part"], data["margin_load_factor"], strict=True):
        assert worst.pop(str(name.item())) == pytest.approx(100 / float(factor))
    assert not worst
    lines = {(trace.name.split(",")[0], trace.axis): trace.y for trace in forces.traces}
    # The crank is weakest at its root, where the first of two cuts is.
    moment = data["bending_moment"].sel(link="crank").values[0, :, 0]
    assert lines["crank", 2] == pytest.approx(moment)
    assert lines["crank", 0] == pytest.approx(data["axial_force"].sel(link="crank")[0, :, 0].values)
    assert len(lines) == 9
    # The coupler is weakest between its ends.
    place = data["position"].sel(link="coupler")
    worst = int(np.abs(place.values - float(data["margin_position"][2])).argmin())
    assert data["margin_part"].values[2] == "coupler"
    assert 0 < worst < len(place) - 1
    tension = data["axial_force"].sel(link="coupler").values[0, :, worst]
    assert lines["coupler", 0] == pytest.approx(tension)


def test_several_results_are_told_apart(found: flexmech.Strength) -> None:
    slow = flexmech.strength(composite(), 950.0, speed_unit="rpm")
    shown = panel(found, slow)
    assert [line.partition(":")[0] for line in shown.answer] == [
        "9000 rpm, quasi-static",
        "950 rpm, quasi-static",
    ]
    names = [trace.name for trace in shown.plots[0].traces]
    assert "crank at 950 rpm, quasi-static" in names
    assert len(names) == 7


@pytest.mark.parametrize(
    "source", ["quasi-static", pytest.param("periodic", marks=pytest.mark.thorough)]
)
def test_engines_are_chosen_by_the_reader(source: LoadSource) -> None:
    engines = [flexmech.ReferenceEngine(composite(), 2), flexmech.ExudynEngine(composite(), 2)]
    request = flexmech.StrengthRequest(
        crank_speed=20.0, source=source, elements=2, search_speed=False
    )
    shown = panel(flexmech.strength(engines, request))
    chosen = {trace.when.get("engine") for plot in shown.plots for trace in plot.traces}
    assert chosen == {"reference", "exudyn", None}
    angle = shown.plots[1].traces[0].x
    assert (angle[0], angle[-1]) == (0.0, 360.0)


def test_links_that_are_not_judged_are_left_out(found: flexmech.Strength) -> None:
    mechanism = composite()
    sections = dict(mechanism.sections)
    sections["rocker"] = replace(sections["rocker"], layers=None)
    shown = panel(flexmech.strength(replace(mechanism, sections=sections), 100.0))
    assert {trace.name for trace in shown.plots[0].traces} == {"crank", "coupler", "fails"}


def test_pins_alone_have_no_plots() -> None:
    mechanism = composite()
    bare = {name: replace(own, layers=None) for name, own in mechanism.sections.items()}
    pin = flexmech.JointPin("A", 8e-3, bush_length=10e-3, allowable_pv=1.8e6)
    found = flexmech.strength(replace(mechanism, sections=bare, joint_pins=(pin,)), 100.0)
    shown = panel(found)
    assert shown.plots == ()
    assert shown.answer[0].startswith("pin A fails first")
    both = panel(found, flexmech.strength(composite(), 100.0))
    assert len(both.plots) == 2


def test_first_screen_tells_the_least_load_factor(found: flexmech.Strength) -> None:
    slow = flexmech.strength(composite(), 950.0, speed_unit="rpm")
    # Questions that nothing answers are left out beside it.
    (card,) = cards(Results.of([slow, found]))
    least = float(found.dataset["margin_load_factor"].min())
    assert card.question == "Strength"
    assert card.value == f"{least:.3g}"
    assert "crank" in card.place
    assert found.summary().answer[0] in card.lines
    assert card.lines[0].startswith("At 9000 rpm")
    assert report_summary(Results.of(found)).answer[0].startswith(f"Strength: {least:.3g} times")
    assert len(cards(Results.of(flexmech.section_profiles(composite())))) == 4


def test_other_results_have_no_such_panel() -> None:
    assert strength_panel(Results.of(flexmech.section_profiles(composite()))) is None


@pytest.mark.parametrize("viewport", [{"width": 1400, "height": 900}, PHONE], ids=["wide", "phone"])
def test_page_of_strength_opens(
    found: flexmech.Strength, tmp_path: Path, browser: Any, viewport: dict[str, int]
) -> None:
    path = write_report([found], tmp_path / "report.html")
    page = browser.new_page(viewport=viewport)
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(path.as_uri())
    page.wait_for_selector(READY, state="attached", timeout=60_000)
    assert page.locator("#strength .plot").count() == 2
    width = page.evaluate("() => document.documentElement.scrollWidth")
    assert width <= viewport["width"]
    assert not complaints
    page.close()
