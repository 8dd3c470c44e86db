"""What a reader sees first: answers whose numbers are those of the files, on any screen."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from flexmech import CampbellDiagram, Response
from tests.report.test_in_a_browser import BEYOND, PHONE, READY, WIDE

SIZES = pytest.mark.parametrize("viewport", [WIDE, PHONE], ids=["wide", "phone"])
BOXES = "() => [...document.querySelectorAll('.answer')].map(each => each.getBoundingClientRect())"
UNFOLD = "() => document.querySelectorAll('details').forEach(each => { each.open = true; })"
# Tables that are broader than their column.
TOO_BROAD = """() => [...document.querySelectorAll('.scroll')]
    .filter(each => each.scrollWidth > each.clientWidth + 1)
    .map(each => each.getAttribute('aria-label'))"""
# How far the first cells of a table go from its left edge when a column that is too narrow is
# scrolled to its right end.
MOVED = """table => { const column = table.closest('.scroll'); column.style.width = '150px';
    column.scrollLeft = 1000; const left = column.getBoundingClientRect().left;
    const first = [table.querySelector('th'), table.querySelector('td')]
        .map(cell => Math.abs(cell.getBoundingClientRect().left - left));
    const scrolled = column.scrollLeft; column.style.width = ''; return [scrolled, ...first]; }"""
# Plots whose toolbar lies on their legend or their axes.
COVERED = """() => [...document.querySelectorAll('.plot')].filter(plot => {
    const bar = plot.querySelector('.modebar').getBoundingClientRect();
    return bar.height > 0 && [...plot.querySelectorAll('.legend, .plotbg, .gridlayer, .bglayer')]
        .map(each => each.getBoundingClientRect())
        .some(box => box.top < bar.bottom && box.bottom > bar.top
            && box.left < bar.right && box.right > bar.left);
    }).map(plot => plot.id)"""


@pytest.fixture
def viewport() -> dict[str, int]:
    """Where a test names no size."""
    return WIDE


@pytest.fixture
def page(written: Any, browser: Any, viewport: dict[str, int]) -> Iterator[Any]:
    """The report on a screen of a size; a phone has no pointer."""
    phone = viewport is PHONE
    opened = browser.new_page(viewport=viewport, has_touch=phone, is_mobile=phone)
    opened.goto(written.path.as_uri())
    opened.wait_for_selector(READY, state="attached", timeout=60_000)
    yield opened
    opened.close()


def number(text: str) -> tuple[float, float, str]:
    """First number of a text, half a unit of its last digit, and the word behind it."""
    found = re.search(r"(-?\d+(?:\.(\d+))?) (\S+)", text)
    assert found, text
    return float(found[1]), 0.51 * 10.0 ** -len(found[2] or ""), found[3].rstrip(".,;")


def assert_tells(text: str, value: float, unit: str) -> None:
    told, digit, word = number(text)
    assert word == unit
    assert abs(told - value) <= digit
    assert abs(value) > 10 * digit, "two digits at least"


def test_each_card_tells_the_numbers_of_the_datasets(written: Any, page: Any) -> None:
    cards = [
        {
            "question": card.locator("h2").inner_text(),
            "value": card.locator(".value").inner_text(),
            "place": card.locator(".place").inner_text(),
            "text": " ".join(card.locator("p:not(.value):not(.place)").all_inner_texts()),
        }
        for card in page.locator(".answer").all()
    ]
    critical, bending, force, torque = cards
    asked = ["Critical speeds", "Deflection and stress", "Joint forces", "Driving torque"]
    assert [card["question"] for card in cards] == asked

    diagram = written.results.first(CampbellDiagram).dataset
    met = diagram["critical_gap"].values <= 0
    lowest = np.argmin(np.where(met, diagram["critical_start"].values, np.inf))
    assert_tells(critical["value"], float(diagram["critical_start"][lowest]), "rad/s")
    order, branch = (int(diagram[f"critical_{of}"][lowest]) for of in ("order", "branch"))
    assert critical["place"] == f"the lowest, of order {order}, branch {branch}"
    first = diagram.sel(crank_speed=20.0, branch=1).isel(engine=0)
    (low,), (high,) = zip(*re.findall(r"f1 is (\S+) to (\S+) Hz", critical["text"]), strict=True)
    assert_tells(f"{low} Hz", float(first["lowest_frequency"]), "Hz")
    assert_tells(f"{high} Hz", float(first["highest_frequency"]), "Hz")
    assert critical["text"].startswith("20 rad/s is clear of orders 1 to 10")
    assert "Avoid " in critical["text"], "a wide screen shows all of it"

    run = written.results.first(Response).dataset.isel(engine=0)
    at_speed = "At 20 rad/s, the greatest operating speed."
    for card, name, of, unit, factor in (
        (bending, "peak_deflection", "link", "mm", 1e3),
        (force, "peak_joint_force", "joint", "N", 1.0),
    ):
        most = str(run[name].idxmax(of).item())
        assert_tells(card["value"], factor * float(run[name].max()), unit)
        assert most in card["place"].replace(",", "").split()
        assert card["text"].startswith(at_speed)
        others = dict(re.findall(rf"(\w+) (\S+) {unit}[,.]", card["text"].partition("others: ")[2]))
        assert set(others) == set(run[of].values.tolist()) - {most}
        for other, text in others.items():
            assert_tells(f"{text} {unit}", factor * float(run[name].sel({of: other})), unit)
    stressed = str(run["peak_stress"].idxmax("link").item())
    stress = bending["text"].partition("normal stress is ")[2]
    assert_tells(stress, 1e-6 * float(run["peak_stress"].max()), "MPa")
    assert f"in the {stressed}, " in stress
    assert_tells(torque["value"], float(run["peak_driving_torque"]), "N")
    assert torque["value"].endswith(" N m")
    assert torque["text"] == at_speed


@SIZES
def test_the_cards_are_equal_and_stand_on_the_first_screen(
    page: Any, viewport: dict[str, int]
) -> None:
    boxes = page.evaluate(BOXES)
    assert len(boxes) == 4
    for of in ("width", "height"):
        assert max(box[of] for box in boxes) - min(box[of] for box in boxes) < 0.5
    assert max(box["bottom"] for box in boxes) < page.locator("#play").bounding_box()["y"]
    rows = {round(box["top"]) for box in boxes}
    assert len(rows) == (1 if viewport is WIDE else 2)
    # What is unfolded makes none of them larger than the others.
    page.evaluate(UNFOLD)
    heights = [box["height"] for box in page.evaluate(BOXES)]
    assert max(heights) - min(heights) < 0.5


@SIZES
def test_tables_fit_their_column(page: Any, viewport: dict[str, int]) -> None:
    page.evaluate(UNFOLD)
    assert page.evaluate(TOO_BROAD) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= viewport["width"]
    assert page.evaluate(BEYOND) == 0
    # What would be the same in every row stands once.
    title = page.text_content("#response caption")
    assert title == "Peaks (state: dry, engine: reference, speed: 20 rad/s)"
    scrolled, *moved = page.locator("#frequencies table >> nth=1").evaluate(MOVED)
    assert scrolled > 20, "or nothing was tried"
    assert max(moved) < 1.5, "what a row is of stays in sight"


@SIZES
def test_the_toolbar_covers_nothing_and_sends_nothing(page: Any, viewport: dict[str, int]) -> None:
    titles = page.locator("#plot-campbell .modebar-btn").evaluate_all(
        "found => found.map(each => each.getAttribute('data-title'))"
    )
    assert "Reset axes" in titles
    assert not any("hare" in title or "loud" in title for title in titles)
    if viewport is PHONE:  # elsewhere it shows while a pointer is on the plot
        assert page.evaluate(COVERED) == []


@pytest.mark.parametrize("viewport", [PHONE], ids=["phone"])
def test_answers_are_open_and_details_folded(written: Any, page: Any) -> None:
    run = written.results.first(Response)
    for line in run.summary().answer:
        assert page.locator("#response .said", has_text=line).is_visible()
    assert page.locator("details[open]").count() == 0
    for folded in ("#response .equation", "#frequencies ul.lines", "#provenance pre"):
        assert not page.locator(folded).is_visible()
    page.click("#response summary")
    assert page.locator("#response .equation").is_visible()
    assert page.locator("#response ul.lines").is_visible()
