"""The report shows a stored comparison with a record of each kind."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexmech import Comparison, stored_results
from flexmech.report.panels.frequencies import stability_panel
from flexmech.report.panels.hammer import comparison_panel
from tests.support.comparison_data import drawn_dataset


@pytest.mark.parametrize("kind", ["time", "frequency", "sample"])
def test_a_folder_with_a_comparison_has_its_panel(kind: str, tmp_path: Path) -> None:
    data = drawn_dataset(kind)
    Comparison(data).save(tmp_path)
    results = stored_results(tmp_path)
    panel = comparison_panel(results)
    assert panel is not None
    (plot,) = panel.plots
    measured = next(trace for trace in plot.traces if "measured" in trace.name)
    wanted = {
        "time": lambda: 1e6 * data["measured"].values,
        "frequency": lambda: np.hypot(data["measured_real"], data["measured_imag"]).values,
        "sample": lambda: data["measured"].values[:12],
    }
    np.testing.assert_allclose(measured.y, wanted[kind]())
    assert panel.tables[0].title.startswith("fitted to strain.csv")
    assert any(line.startswith("unexplained: 1 %") for line in panel.lines)
    assert stability_panel(results) is None
