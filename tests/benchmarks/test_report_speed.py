"""The report in a browser: how soon it is drawn, and its frames a second while the crank turns."""

from __future__ import annotations

import shutil
import time

import pytest

from flexmech import ExudynEngine, ReferenceEngine
from flexmech.report import ReportRequest, report_results, write_report

playwright = pytest.importorskip("playwright.sync_api")

SECONDS = 5
# Turns the crank by a degree a frame, with all panels drawn.
DRAG = """async seconds => {
    const slider = document.getElementById('angle');
    const start = performance.now();
    let frames = 0;
    while (performance.now() < start + 1000 * seconds) {
        slider.value = frames % 360;
        slider.dispatchEvent(new Event('input'));
        await new Promise(requestAnimationFrame);
        frames += 1;
    }
    return frames / seconds;
}"""


def test_report_of_the_aluminium_four_bar(aluminium, tmp_path, benchmark, tell):
    executable = shutil.which("chromium")
    if executable is None:
        pytest.skip("no chromium is installed")
    start = time.perf_counter()
    engines = [ReferenceEngine(aluminium), ExudynEngine(aluminium)]
    path = write_report(report_results(engines, ReportRequest()).all, tmp_path / "report.html")
    written = time.perf_counter() - start
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        start = time.perf_counter()
        page.goto(path.as_uri())
        page.wait_for_selector("html[data-opened=yes]", state="attached")
        opened = time.perf_counter() - start
        page.wait_for_selector("html[data-ready=yes]", state="attached")
        drawn = time.perf_counter() - start
        frames = page.evaluate(DRAG, SECONDS)
        browser.close()
    megabytes = path.stat().st_size / 1e6
    benchmark.extra_info.update(
        written_seconds=written,
        opened_seconds=opened,
        drawn_seconds=drawn,
        frames=frames,
        megabytes=megabytes,
    )
    rows = (
        ("report of the aluminium four-bar, written", f"{written:10.2f} s {megabytes:12.1f} MB"),
        ("report opened in a browser", f"{opened:10.2f} s"),
        ("report, plots below the screen drawn too", f"{drawn:10.2f} s"),
        ("report, crank turned by the slider", f"{frames:10.0f} frames a second"),
    )
    for row in rows:
        tell(*row)
    benchmark.pedantic(lambda: None, rounds=1)
