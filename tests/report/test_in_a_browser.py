"""The report as a reader meets it: in a real browser, without a network."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from tests.support import results
from tests.support.report_page import Page

# The page of all results takes twenty seconds.
pytestmark = pytest.mark.thorough

WIDE, PHONE = {"width": 1400, "height": 900}, {"width": 390, "height": 800}
READY = "html[data-ready=yes]"
TURN_TO = """angle => { const slider = document.getElementById('angle');
    slider.value = angle; slider.dispatchEvent(new Event('input')); }"""
# Distance in pixels of a plot's first dot from where a value stands on the plot's axis.
OFF_THE_VALUE = """([name, value]) => { const plot = document.getElementById(name);
    const dot = plot.querySelector('.cursors circle'), axis = plot._fullLayout.yaxis;
    return Math.abs(dot.getAttribute('cy') - axis._offset - axis.l2p(value)); }"""
# Plotly gives pixels to two decimals.
SAME_PIXEL = 0.011
NEXT_FRAME = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
BEYOND = """() => [...document.querySelectorAll('.plot, .panel, #stage, #answers, svg')]
    .map(each => each.getBoundingClientRect()).filter(box => box.right > innerWidth + 1).length"""
# Plots take a new width some frames after the screen has it.
FITS = "() => document.documentElement.scrollWidth <= innerWidth"
UNFOLD = "() => document.querySelectorAll('details').forEach(each => { each.open = true; })"
# Tables that are broader than their column.
TOO_BROAD = """() => [...document.querySelectorAll('.scroll')]
    .filter(each => each.scrollWidth > each.clientWidth + 1)
    .map(each => each.getAttribute('aria-label'))"""
HEIGHTS = (
    "() => [...document.querySelectorAll('.answer')].map(e => e.getBoundingClientRect().height)"
)


@pytest.fixture(scope="module")
def page(fourbar: Page, browser: Any) -> Iterator[Any]:
    """The page on a wide screen; until its end there is no error and no request."""
    said: list[str] = []
    asked: set[str] = set()
    opened = browser.new_page(viewport=WIDE)
    opened.on("console", lambda message: said.append(f"{message.type}: {message.text}"))
    opened.on("pageerror", lambda error: said.append(str(error)))
    opened.on("request", lambda request: asked.add(request.url))
    opened.goto(fourbar.path.as_uri())
    opened.wait_for_selector(READY, state="attached", timeout=300_000)
    yield opened
    opened.close()
    assert not said
    assert {url for url in asked if not url.startswith("data:")} == {fourbar.path.as_uri()}


def turn(page: Any, angle: float) -> None:
    page.evaluate(TURN_TO, angle)
    page.evaluate(NEXT_FRAME)


def assert_tells(text: str, value: float, least: float = 10.0) -> None:
    """The first number of a text is a value rounded to the printed digits, two or more."""
    told = re.search(r"-?\d+(?:\.(\d+))?", text)
    assert told, text
    digit = 0.51 * 10.0 ** -len(told[1] or "")
    assert abs(float(told[0]) - value) <= digit, text
    assert abs(value) > least * digit


def test_the_slider_moves_the_linkage_cursors_and_numbers(page: Any) -> None:
    page.select_option("#choose-speed", "20 rad/s")

    def seen() -> list[str]:
        lines = [page.get_attribute(f"#linkage .{kind}", "points") for kind in ("rigid", "shape")]
        lines += [
            page.get_attribute(f"#plot-{name} .cursors circle >> nth=0", "cy")
            for name in ("frequency", "deflection", "forces", "transmission-angle")
        ]
        return [*lines, page.text_content("#readings")]

    turn(page, 30)
    before = seen()
    turn(page, 75)
    assert all(a != b for a, b in zip(before, seen(), strict=True))
    assert page.text_content("#angle-now") == "75°"
    page.focus("#angle")
    page.keyboard.press("ArrowRight")
    page.evaluate(NEXT_FRAME)
    assert page.text_content("#angle-now") == "76°"


def test_numbers_and_dots_at_the_cursor_are_those_of_the_dataset(page: Any) -> None:
    data = results.frequencies().dataset.sel(engine="reference")
    for speed, angle in ((0.0, 45.0), (20.0, 330.0)):
        page.select_option("#choose-speed", f"{speed:g} rad/s")
        turn(page, angle)
        row = data["frequency"].sel(crank_speed=speed).sel(crank_angle=np.radians(angle))
        for mode, value in zip(data["mode"].values, row.values, strict=True):
            text = page.text_content(f'[data-reading="Natural frequency, mode {mode}"]')
            assert "±" in text
            assert_tells(text, value)
        assert page.evaluate(OFF_THE_VALUE, ["plot-frequency", float(row[0])]) < SAME_PIXEL
    turn(page, 37)
    between = page.text_content('[data-reading="Natural frequency, mode 1"]')
    assert between.startswith("≈ "), "between computed angles"


def test_choices_show_what_was_computed_for_them(page: Any) -> None:
    page.select_option("#choose-speed", "0 rad/s")
    page.evaluate(NEXT_FRAME)
    assert "nothing was computed for 0 rad/s" in page.text_content("#plot-deflection")
    page.select_option("#choose-speed", "20 rad/s")
    page.evaluate(NEXT_FRAME)
    assert page.locator('[data-reading^="Deflection"]').count() == 3
    shape = page.get_attribute("#linkage .shape >> nth=1", "points")
    page.select_option("#choose-mode", "mode 2")
    page.evaluate(NEXT_FRAME)
    assert page.get_attribute("#linkage .shape >> nth=1", "points") != shape
    page.click("#frequencies details summary")
    page.click("#frequencies th button >> nth=2")
    cells = page.locator("#frequencies tbody tr td:nth-child(3)").all_text_contents()
    values = [float(text.split(" ")[0]) for text in cells]
    assert values == sorted(values)


def test_cards_on_the_first_screen_tell_the_numbers_of_the_datasets(page: Any) -> None:
    values = page.locator(".answer .value").all_inner_texts()
    questions = page.locator(".answer h2").all_inner_texts()
    asked = ["Critical speeds", "Deflection and stress", "Joint forces", "Driving torque"]
    assert questions[:4] == asked
    diagram = results.campbell().dataset
    met = diagram["critical_gap"].values <= 0
    assert_tells(values[0], float(diagram["critical_start"].values[met].min()))
    assert page.locator(".answer").first.bounding_box()["y"] < WIDE["height"]


def test_nothing_reaches_beyond_a_screen_and_a_page(page: Any) -> None:
    """On a wide screen, a phone, and paper; in light and in dark."""
    for viewport in (PHONE, WIDE):
        page.set_viewport_size(viewport)
        page.evaluate(UNFOLD)
        page.wait_for_function(FITS, timeout=300_000)
        assert page.evaluate(BEYOND) == 0
        heights = page.evaluate(HEIGHTS)
        assert len(heights) >= 4
        assert max(heights) - min(heights) < 0.5, "cards are equal"
    assert page.evaluate(TOO_BROAD) == []
    page.emulate_media(color_scheme="dark")
    page.wait_for_selector("html[data-theme=dark]", state="attached")
    page.click("#theme")
    assert page.get_attribute("html", "data-theme") == "light"
    # The crank is turned without scrolling back to the linkage.
    page.evaluate("window.scrollTo(0, document.body.scrollHeight)")
    assert 0 <= page.locator("#angle").bounding_box()["y"] <= WIDE["height"]
    page.emulate_media(media="print")
    assert not page.locator("#angle").is_visible()
    assert page.locator("#frequencies details .lines").is_visible(), "details are open on paper"
    page.emulate_media(media="screen")
