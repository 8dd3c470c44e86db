"""The report shows a stored stability map: curve, bands and what it says first."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmech import StabilityMap, stored_results
from flexmech.report.answers import cards
from flexmech.report.panels.frequencies import stability_panel
from flexmech.report.results import Results
from tests.support.stability_data import GROWTH, stability_dataset


def stored(folder: Path) -> Results:
    StabilityMap(stability_dataset(engines=2)).save(folder)
    return stored_results(folder)


def test_a_folder_with_a_map_has_its_panel(tmp_path: Path) -> None:
    panel = stability_panel(stored(tmp_path))
    assert panel is not None
    (plot,) = panel.plots
    filled = [trace for trace in plot.traces if trace.fill == "itself"]
    assert [trace.x.min() for trace in filled] == [84.0, 88.1, 97.0]
    assert filled[1].y.max() == GROWTH
    curves = [trace for trace in plot.traces if trace.fill == "none"]
    assert {trace.name for trace in curves} == {"reference", "exudyn"}
    rate = dict(zip(curves[0].x.tolist(), curves[0].y.tolist(), strict=True))
    assert (rate[88.1], rate[88.7]) == (0.0, GROWTH)
    modulus = dict(zip(curves[1].x.tolist(), curves[1].y.tolist(), strict=True))
    assert np.isclose(modulus[88.7], np.exp(GROWTH * 2 * np.pi / 88.7))
    assert panel.tables[0].title.startswith("unstable bands")


def test_what_it_says_first(tmp_path: Path) -> None:
    critical = cards(stored(tmp_path))[0]
    assert critical.question == "Critical speeds"
    assert any(line.startswith("A vibration grows in 3 bands") for line in critical.lines)


def test_other_results_have_no_such_panel(tmp_path: Path) -> None:
    from flexmech import load_mechanism, section_profiles
    from flexmech.example_models import example_model

    profile = section_profiles(load_mechanism(example_model("aluminium_fourbar")))
    assert stability_panel(Results.of(profile)) is None
