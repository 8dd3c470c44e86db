"""The report shows a stored hammer test on the running linkage."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmech import RunningHammerTest, stored_results
from flexmech.report.answers import report_summary
from flexmech.report.panels.frequencies import stability_panel
from flexmech.report.panels.hammer import running_hammer_panel
from flexmech.report.results import Results
from tests.support.running_hammer_data import IDENTIFIED, PEAKS, running_hammer_dataset


def stored(folder: Path) -> Results:
    RunningHammerTest(running_hammer_dataset()).save(folder)
    return stored_results(folder)


def test_a_folder_with_a_test_has_its_panel(tmp_path: Path) -> None:
    results = stored(tmp_path)
    panel = running_hammer_panel(results)
    assert panel is not None
    (plot,) = panel.plots
    assert [axis.title for axis in plot.axes] == [
        "order -1 (m/N)",
        "order 0 (m/N)",
        "order +1 (m/N)",
    ]
    identified = [trace for trace in plot.traces if trace.name == "identified from impacts"]
    for trace, peak in zip(identified, PEAKS.values(), strict=True):
        np.testing.assert_allclose(trace.y.max(), IDENTIFIED * peak)
    assert panel.tables[0].title.startswith("harmonic response")
    assert any("condition number" in line for line in panel.lines)
    assert stability_panel(results) is None


def test_how_sure_it_is_stands_first(tmp_path: Path) -> None:
    said = report_summary(stored(tmp_path))
    assert any("exudyn: the sidebands" in str(line) for line in said.details)
