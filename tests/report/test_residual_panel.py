"""What rings after a stop in the report: each mode over the time of the move."""

from __future__ import annotations

import numpy as np

from flexmech import Response
from flexmech.report.panels.residual import residual_panel
from flexmech.report.results import Results
from tests.support.driven_data import driven_run, shaped_run


def test_modes_stand_over_the_time_until_the_stop() -> None:
    run = shaped_run()
    panel = residual_panel(Results.of(run))
    assert panel is not None
    assert panel.answer == run.summary().answer[:1]
    (plot,) = panel.plots
    data = run.dataset
    found = data["move_amplitude"].max("link")
    shown = [m for m in found["mode"].values if found.sel(mode=m).max() >= 0.01 * found.max()]
    assert len(plot.axes) == len(shown)
    assert all(axis.logarithmic for axis in plot.axes)
    plain, shaped = (trace for trace in plot.traces if trace.axis == 0)
    assert (plain.name, shaped.name) == ("plain law", "ZV shaper")
    first = 1e3 * found.sel(law="plain", mode=1).values
    np.testing.assert_array_equal(plain.y, first)
    np.testing.assert_array_equal(plain.x, data["whole_move_time"].sel(law="plain"))
    assert (shaped.x > plain.x[: len(shaped.x)]).all()


def test_a_run_without_times_of_a_move_has_none() -> None:
    assert residual_panel(Results.of(driven_run())) is None
    assert isinstance(driven_run(), Response)
