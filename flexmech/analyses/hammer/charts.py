"""Stabilisation charts of a hammer test as variables of its dataset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.modal_testing import IdentifiedModes, StabilisationChart

Variables = dict[str, tuple[tuple[str, ...], NDArray[Any]]]
OVER = ("crank_angle", "pole")


def chart_variables(modes: Sequence[IdentifiedModes]) -> Variables:
    """Variables over crank angle and pole; none where no chart was made.

    Parameters
    ----------
    modes : sequence of IdentifiedModes
        One for each crank angle.

    Returns
    -------
    dict of str to tuple
        ``chart_order``: modes of the model; not a number beyond the last pole of an angle.
        ``chart_frequency`` in Hz and ``chart_damping_ratio``. ``chart_state``: ``new``,
        ``frequency`` (stable in it alone), ``stable`` (in damping as well), or ``chosen`` for a
        mode; empty beyond the last pole.
    """
    charts = [each.chart for each in modes]
    if not any(charts):
        return {}
    size = max(chart.order.size for chart in charts if chart)
    numbers = np.full((3, len(charts), size), np.nan)
    state = np.full((len(charts), size), "", dtype=object)
    for row, chart in enumerate(charts):
        if chart is None:
            continue
        count = chart.order.size
        numbers[:, row, :count] = chart.order, chart.frequency, chart.damping_ratio
        state[row, :count] = _states(chart)
    order, frequency, ratio = numbers
    return {
        "chart_order": (OVER, order),
        "chart_frequency": (OVER, frequency),
        "chart_damping_ratio": (OVER, ratio),
        "chart_state": (OVER, state.astype(str)),
    }


def _states(chart: StabilisationChart) -> NDArray[np.str_]:
    known = np.select(
        [chart.stable, chart.stable_frequency], ["stable", "frequency"], default="new"
    )
    known[chart.chosen] = "chosen"
    return known
