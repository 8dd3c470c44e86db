"""The report as a reader meets it: in a real browser, without a network."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexmech import MovingFrequencies, ReferenceEngine, Response, load_mechanism
from flexmech.example_models import example_model
from flexmech.report import ReportRequest, report_results, write_report

WIDE, PHONE = {"width": 1400, "height": 900}, {"width": 390, "height": 800}
READY = "html[data-ready=yes]"
TURN_TO = """angle => { const slider = document.getElementById('angle');
    slider.value = angle; slider.dispatchEvent(new Event('input')); }"""
# Distance in pixels of a plot's first dot from where a value stands on the plot's own axis.
OFF_THE_VALUE = """([name, value]) => { const plot = document.getElementById(name);
    const dot = plot.querySelector('.cursors circle'), axis = plot._fullLayout.yaxis;
    return Math.abs(dot.getAttribute('cy') - axis._offset - axis.l2p(value)); }"""
# Plotly gives pixels to two decimals.
SAME_PIXEL = 0.011
NEXT_FRAME = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
BEYOND = """() => [...document.querySelectorAll('.plot, .panel, #stage, #answers, svg')]
    .map(each => each.getBoundingClientRect()).filter(box => box.right > innerWidth + 1).length"""

Open = Callable[..., Any]


@pytest.fixture(scope="module")
def pages(browser: Any) -> Iterator[Pages]:
    """Pages that were opened, which tests share, and what they said and asked for."""
    kept = Pages(browser)
    yield kept
    for page in kept.opened.values():
        page.close()


@dataclass
class Pages:
    """Pages of a browser by file and width."""

    browser: Any
    opened: dict[tuple[Path, int], Any] = field(default_factory=dict)
    said: list[str] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)

    def open(self, path: Path, viewport: dict[str, int] = WIDE, **context: Any) -> Any:
        """A page of a file at a width, opened once."""
        key = (path, viewport["width"])
        if key not in self.opened:
            page = self.opened[key] = self.browser.new_page(viewport=viewport, **context)
            page.on("console", lambda message: self.said.append(f"{message.type}: {message.text}"))
            page.on("pageerror", lambda error: self.said.append(str(error)))
            page.on("request", lambda request: self.asked.append(request.url))
            page.goto(path.as_uri())
            page.wait_for_selector(READY, state="attached", timeout=60_000)
        return self.opened[key]


@pytest.fixture
def opened(pages: Pages) -> Iterator[Open]:
    """Open a page; until the test's end there is no error and no request but for the file."""
    yield pages.open
    assert not pages.said
    own = {path.as_uri() for path, _ in pages.opened}
    assert {url for url in pages.asked if not url.startswith("data:")} == own


def turn(page: Any, angle: float) -> None:
    page.evaluate(TURN_TO, angle)
    page.evaluate(NEXT_FRAME)


def reading(page: Any, of: str) -> str:
    return str(page.text_content(f'[data-reading="{of}"]'))


def shows(text: str, value: float) -> bool:
    """Whether a reading is a value, rounded to the reading's digits, with an error."""
    shown = text.split(" ")[0]
    digits = len(shown.partition(".")[2])
    return "±" in text and abs(float(shown) - value) <= 0.51 * 10.0**-digits


def test_the_slider_moves_linkage_cursors_and_numbers(written: Any, opened: Open) -> None:
    page = opened(written.path)

    def seen() -> list[str]:
        lines = [page.get_attribute(f"#linkage .{kind}", "points") for kind in ("rigid", "shape")]
        lines.append(page.get_attribute("#linkage .run >> nth=1", "points"))
        lines += [
            page.get_attribute(f"#plot-{name} .cursors circle >> nth=0", "cy")
            for name in ("frequency", "deflection", "forces", "transmission-angle")
        ]
        return [*lines, page.get_attribute("#plot-frequency .cursors line", "x1")]

    turn(page, 30)
    before, words = seen(), page.text_content("#readings")
    page.evaluate(
        "() => { window.calls = 0; for (const plot of document.querySelectorAll('.plot'))"
        " plot.on('plotly_afterplot', () => { window.calls += 1; }); }"
    )
    turn(page, 75)
    assert all(a != b for a, b in zip(before, seen(), strict=True))
    assert page.text_content("#readings") != words
    assert page.text_content("#angle-now") == "75°"
    page.focus("#angle")
    page.keyboard.press("ArrowRight")
    page.evaluate(NEXT_FRAME)
    assert page.text_content("#angle-now") == "76°"
    assert page.evaluate("window.calls") == 0, "Plotly draws nothing while the crank turns"


def test_numbers_at_the_cursor_are_those_of_the_files(written: Any, opened: Open) -> None:
    page = opened(written.path)
    frequencies = written.results.first(MovingFrequencies).tables()["frequencies"]
    run = written.results.first(Response).tables()["response"]
    for speed in (0.0, 20.0):
        page.select_option("#choose-speed", f"{speed:g} rad/s")
        for angle in (0.0, 45.0, 330.0):
            turn(page, angle)
            row = frequencies[np.isclose(frequencies["crank_angle_deg"], angle)]
            row = row[row["crank_speed_rad_s"] == speed]
            for mode, value in zip(row["mode"], row["frequency_Hz"], strict=True):
                assert shows(reading(page, f"Natural frequency, mode {mode}"), value)
            first_mode = row[row["mode"] == 1]["frequency_Hz"].item()
            assert page.evaluate(OFF_THE_VALUE, ["plot-frequency", first_mode]) < SAME_PIXEL
    turn(page, 37)
    assert reading(page, "Natural frequency, mode 1").startswith("≈ "), "between computed angles"
    for angle in (30.0, 201.0):
        turn(page, angle)
        sample = run[np.isclose(run["crank_angle_deg"] % 360, angle)].iloc[-1]
        for of, column in (("coupler", "coupler_mid"), ("crank", "crank_tip")):
            value = 1e3 * sample[f"{column}_deflection_m"]
            assert shows(reading(page, f"Deflection, {of}"), value)
        force = np.hypot(sample["pin_A_x_N"], sample["pin_A_y_N"])
        assert shows(reading(page, "Joint force, A"), force)


def test_choices_show_what_was_computed_for_them(written: Any, opened: Open) -> None:
    page = opened(written.path)
    page.select_option("#choose-speed", "0 rad/s")
    page.evaluate(NEXT_FRAME)
    assert "nothing was computed for 0 rad/s" in page.text_content("#plot-deflection")
    assert page.locator('[data-reading^="Deflection"]').count() == 0
    page.select_option("#choose-speed", "20 rad/s")
    page.evaluate(NEXT_FRAME)
    assert page.locator('[data-reading^="Deflection"]').count() == 3
    shape = page.get_attribute("#linkage .shape >> nth=1", "points")
    page.select_option("#choose-mode", "mode 2")
    page.evaluate(NEXT_FRAME)
    assert page.get_attribute("#linkage .shape >> nth=1", "points") != shape
    assert page.text_content("#readings tr.chosen td").startswith("mode 2")
    page.click("#frequencies details summary")
    page.click("#frequencies details th button >> nth=2")
    cells = page.locator("#frequencies details tbody tr td:nth-child(3)").all_text_contents()
    values = [float(text.split(" ")[0]) for text in cells]
    assert values == sorted(values)
    assert page.get_attribute("#frequencies details th >> nth=2", "aria-sort") == "ascending"


@pytest.mark.parametrize(
    "viewport",
    [WIDE, pytest.param(PHONE, marks=pytest.mark.thorough)],
    ids=["wide", "phone"],
)
def test_nothing_reaches_beyond_the_screen(
    written: Any, opened: Open, viewport: dict[str, int]
) -> None:
    page = opened(written.path, viewport)
    assert page.evaluate("document.documentElement.scrollWidth") <= viewport["width"]
    assert page.evaluate(BEYOND) == 0
    page.emulate_media(color_scheme="dark", reduced_motion="reduce")
    page.wait_for_selector("html[data-theme=dark]", state="attached")
    page.click("#theme")
    assert page.get_attribute("html", "data-theme") == "light"
    for plot in page.locator(".plot").all():
        assert plot.get_attribute("aria-label")
    # The crank is turned without scrolling back to the linkage.
    page.evaluate("window.scrollTo(0, document.body.scrollHeight)")
    assert page.locator("#play").is_visible()
    box = page.locator("#angle").bounding_box()
    assert 0 <= box["y"] <= viewport["height"]


@pytest.mark.thorough
def test_it_prints_without_controls_and_whole(written: Any, opened: Open) -> None:
    page = opened(written.path, PHONE)
    page.set_viewport_size({"width": 700, "height": 900})
    page.emulate_media(media="print")
    assert not page.locator("#angle").is_visible()
    assert not page.locator("#theme").is_visible()
    assert page.evaluate(BEYOND) == 0
    drawn = page.pdf(prefer_css_page_size=True)
    assert drawn.startswith(b"%PDF")
    assert page.locator("#frequencies details .lines").is_visible(), "details are open on paper"
    page.emulate_media(media="screen")
    page.set_viewport_size(PHONE)


@pytest.mark.thorough
def test_names_of_a_model_are_text(evil: Any, opened: Open) -> None:
    page = opened(evil.path)
    assert page.evaluate("window.hacked") is None
    assert page.text_content("h1") == evil.name
    assert evil.name in page.text_content("pre")
    for place in ("#readings td", "#response td"):
        assert any(evil.name in text for text in page.locator(place).all_text_contents())


@pytest.mark.thorough
def test_welds_springs_and_loads_are_drawn_and_move(
    tmp_path_factory: pytest.TempPathFactory, opened: Open
) -> None:
    engine = ReferenceEngine(load_mechanism(example_model("carton_pusher")), 2)
    results = report_results([engine], ReportRequest([6.0], include=("kinematics",)))
    page = opened(write_report(results.all, tmp_path_factory.mktemp("pusher") / "report.html"))
    count = {
        kind: page.locator(f"#linkage .{kind}").count()
        for kind in ("weld", "body", "mass", "varies", "stiff", "damper", "gravity")
    }
    assert count == {
        "weld": 1,
        "body": 2,
        "mass": 4,
        "varies": 1,
        "stiff": 1,
        # Beside the spring, and in the joint at B.
        "damper": 2,
        "gravity": 1,
    }
    spring = page.locator("#linkage polyline.spring").first
    before = str(spring.get_attribute("points")).split()
    turn(page, 200.0)
    after = str(spring.get_attribute("points")).split()
    assert before[-1] == after[-1] == "0.800000,-0.380000"
    assert before[0] != after[0]
