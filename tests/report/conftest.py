"""One report a session, small and quick, and a browser that opens it."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexmech
from flexmech.report import ReportRequest, Results, report_results, write_report

MODELS = Path(__file__).parents[2] / "models"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
# Set where a browser must be found: a test is not skipped then.
REQUIRED = "FLEXMECH_REQUIRE_BROWSER"
EVIL = "</script><script>window.hacked = 1</script> <b>& \u2028 \u2029"


@dataclass(frozen=True)
class Written:
    """A report and the results in it."""

    path: Path
    results: Results

    @property
    def text(self) -> str:
        return self.path.read_text(encoding="utf-8")


@dataclass(frozen=True)
class Named:
    """A report of a mechanism of a certain name."""

    path: Path
    name: str


def small_results(model: str, **request: Any) -> Results:
    """Results of a coarse mesh at few angles: what they say is tested elsewhere."""
    engine = flexmech.ReferenceEngine(flexmech.load_mechanism(MODELS / model), 2)
    return report_results(
        [engine],
        ReportRequest(
            np.array([0.0, 20.0]),
            np.radians(np.arange(0.0, 361.0, 15.0)),
            modes=2,
            tolerance=None,
            campbell_speeds=np.array([20.0, 25.0, 30.0]),
            **request,
        ),
    )


@pytest.fixture(scope="session")
def written(tmp_path_factory: pytest.TempPathFactory) -> Written:
    results = small_results("aluminium_fourbar.toml")
    folder = tmp_path_factory.mktemp("report")
    return Written(write_report(results.all, folder / "report.html"), results)


@pytest.fixture(scope="session")
def evil(written: Written, tmp_path_factory: pytest.TempPathFactory) -> Named:
    """The same report of a model whose names would be markup if they were not escaped."""

    def renamed(result: flexmech.Result) -> flexmech.Result:
        attributes = result.dataset.attrs
        text = f"# {EVIL}\n{attributes['model_text']}"
        told = result.dataset.assign_attrs(mechanism=EVIL, source=EVIL, model_text=text)
        if "joint" in told.coords:
            joints = {name: f"{EVIL}{name}" for name in told["joint"].values.tolist()}
            told = told.assign_coords(joint=list(joints.values()))
            if "extreme_of" in told:
                pairs = zip(told["extreme_quantity"].values, told["extreme_of"].values, strict=True)
                # A point may have a joint's name.
                of = [
                    joints.get(str(name), str(name)) if "joint" in str(what) else str(name)
                    for what, name in pairs
                ]
                told["extreme_of"] = told["extreme_of"].dims, of
        return replace(result, dataset=told)

    results = [renamed(each) for each in written.results.all]
    path = tmp_path_factory.mktemp("evil") / "report.html"
    return Named(write_report(results, path), EVIL)


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """The distribution's chromium, driven by Playwright."""
    executable = next(filter(None, map(shutil.which, BROWSERS)), None)
    reason = "" if executable else f"no browser is installed ({', '.join(BROWSERS)})"
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        reason = "playwright is not installed (extra test-browser)"
    if reason:
        if os.environ.get(REQUIRED):
            pytest.fail(f"{reason}, and {REQUIRED} is set")
        pytest.skip(reason)
    with sync_playwright() as playwright:
        # A browser that root runs has no sandbox.
        started = playwright.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        yield started
        started.close()
