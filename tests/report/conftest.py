"""Reports of a session, and the browser that opens one of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

import flexmech
from tests.support import results
from tests.support.browser import MISSING, REQUIRED, installed_browser, is_required
from tests.support.report_page import Page

OF_THE_FOURBAR = (
    results.check,
    results.frequencies,
    results.campbell,
    results.stability,
    results.response,
    results.running_hammer,
    results.hammer,
    results.comparison,
    results.kinematics,
    results.balance,
    results.sweep,
    results.uncertainty,
    results.optimum,
    results.response_to_a_law,
    results.response_under_a_motor,
)

Write = Callable[..., Page]


@pytest.fixture(scope="session")
def write(tmp_path_factory: pytest.TempPathFactory) -> Write:
    """Write results into a page."""

    def written(*found: flexmech.Result, **options: Any) -> Page:
        path = tmp_path_factory.mktemp("report") / "report.html"
        return Page(flexmech.write_report(list(found), path, **options))

    return written


@pytest.fixture(scope="session")
def fourbar(write: Write) -> Page:
    """One page of nearly everything that can be asked of the aluminium four-bar."""
    return write(*(make() for make in OF_THE_FOURBAR))


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """The distribution's chromium, driven by Playwright."""
    executable = installed_browser()
    reason = "" if executable else MISSING
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        reason = "playwright is not installed (extra test-browser)"
    if reason:
        if is_required():
            pytest.fail(f"{reason}, and {REQUIRED} is set")
        pytest.skip(reason)
    with sync_playwright() as playwright:
        # A browser that root runs has no sandbox.
        started = playwright.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        yield started
        started.close()
