"""A motor in the report: what it gives over time, and what is told of it."""

from __future__ import annotations

import numpy as np

from flexmech.report.panels.kinematics import kinematics_panel
from flexmech.report.panels.motor import motor_panel
from flexmech.report.results import Results
from tests.support.driven_data import driven_kinematics
from tests.support.motor_data import motor_kinematics, motor_response


def test_the_motor_of_rigid_and_of_elastic_links() -> None:
    rigid, elastic = motor_kinematics(), motor_response()
    panel = motor_panel(Results((rigid, elastic)))
    assert panel is not None
    assert panel.answer[0] == rigid.summary().answer[0]
    first, second = panel.plots
    data = rigid.dataset
    assert first.axes[0].title == "crank (rad/s)"
    assert len(first.axes) == 4
    np.testing.assert_array_equal(first.traces[0].y, data["crank_speed_over_time"])
    np.testing.assert_array_equal(first.traces[-1].y, data["motor_current"])
    own = elastic.dataset
    speed = own["crank_speed_over_time"] + own["crank_speed_fluctuation"][0]
    np.testing.assert_array_equal(second.traces[1].y, speed)


def test_only_results_under_a_motor_have_it() -> None:
    assert motor_panel(Results.of(driven_kinematics())) is None
    both = kinematics_panel(Results((driven_kinematics(), motor_kinematics())))
    alone = kinematics_panel(Results.of(driven_kinematics()))
    assert both == alone
