"""The report shows a stored balance: what shakes the frame before and after."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import flexmech
from flexmech import stored_results
from flexmech.report.panels.balance import balance_panel
from flexmech.report.results import Results
from tests.support.balance_data import balance_result
from tests.support.kinematics_data import kinematics_result


def test_a_folder_with_a_balance_has_its_panel(tmp_path: Path) -> None:
    result = balance_result()
    result.save(tmp_path)
    results = stored_results(tmp_path)
    assert isinstance(results.all[0], flexmech.Balance)
    panel = balance_panel(results)
    assert panel is not None
    assert panel.answer == result.summary().answer
    (plot,) = panel.plots
    lines = {(trace.name, trace.axis): trace.y for trace in plot.traces}
    data = result.dataset
    assert len(lines) == 2 * 3 + 2
    for state in ("as given", "balanced"):
        own = data.sel(state=state)
        for name, force in (("", "shaking_force"), (", elastic links", "elastic_shaking_force")):
            size = np.linalg.norm(own[force].values, axis=-1)
            np.testing.assert_allclose(lines[f"{state}{name}", 0], size)
        np.testing.assert_allclose(lines[state, 1], own["shaking_moment"].values)
        np.testing.assert_allclose(lines[state, 2], own["driving_torque"].values)
    page = tmp_path / "report.html"
    flexmech.write_report(results.all, page)
    assert "Berkof" in page.read_text(encoding="utf-8")


def test_there_is_none_of_other_results() -> None:
    assert balance_panel(Results.of(kinematics_result())) is None
