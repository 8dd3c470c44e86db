"""The report shows a stored hammer test: receptances, coherence, and the table of modes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmech import stored_results
from flexmech.report.panels.hammer import hammer_panel
from flexmech.report.results import Results
from tests.support.hammer_data import small_test


def test_a_folder_with_a_test_has_its_panel(tmp_path: Path) -> None:
    found = small_test(0.01)
    found.save(tmp_path)
    panel = hammer_panel(stored_results(tmp_path))
    assert panel is not None
    (plot,) = panel.plots
    assert [trace.name for trace in plot.traces[:2]] == [
        "eigen model, exact, 30 deg",
        "measured (H1), 30 deg",
    ]
    data = found.dataset.isel(crank_angle=1)
    measured = data["receptance_real"].values + 1j * data["receptance_imag"].values
    np.testing.assert_allclose(plot.traces[4].y, np.abs(measured))
    np.testing.assert_allclose(plot.traces[5].y, data["coherence"])
    assert panel.tables[0].headings[2:4] == ("FE Hz", "Ex Hz")


def test_other_results_have_no_such_panel() -> None:
    from flexmech import load_mechanism, section_profiles
    from flexmech.example_models import example_model

    profile = section_profiles(load_mechanism(example_model("aluminium_fourbar")))
    assert hammer_panel(Results.of(profile)) is None
