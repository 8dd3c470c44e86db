"""The report shows stored studies of designs: each with its plot, its table and its answer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from flexmech import Result, stored_results, write_report
from flexmech.report.answers import cards
from flexmech.report.panel import Panel, Plot
from flexmech.report.panels import panels_of
from flexmech.report.panels.designs import MOST_OUTPUTS
from flexmech.report.results import Results
from flexmech.studies import DesignSweep, Optimum, Uncertainty
from tests.report.test_in_a_browser import PHONE, READY
from tests.support.design_data import (
    COUPLER,
    FAILED,
    LEAST,
    MATERIAL,
    optimum_dataset,
    sweep_designs,
    uncertainty_dataset,
)


def panel_of(result: Result) -> Panel:
    """The only panel of a report of one result."""
    (panel,) = panels_of(Results.of(result))
    said = result.summary()
    assert panel.answer == said.answer
    assert panel.tables == said.tables[:1]
    assert set(panel.lines) <= set(said.lines)
    assert panel.caption
    assert panel.source
    return panel


def points(plot: Plot, name: str, axis: int = 0) -> np.ndarray:
    """Places of a plot's points of a name."""
    (trace,) = [
        trace
        for trace in plot.traces
        if (trace.name, trace.axis, trace.look) == (name, axis, "points")
    ]
    return np.stack([trace.x, trace.y], axis=-1)


class TestSweep:
    def test_outputs_are_drawn_over_every_number(self) -> None:
        dataset = sweep_designs("two numbers", failed=True)
        panel = panel_of(DesignSweep(dataset))
        assert [plot.x_title for plot in panel.plots] == [
            "coupler in plane thickness (mm)",
            "thickness (mm)",
        ]
        within = dataset["within"].values
        beyond = ~within & (np.arange(within.size) != FAILED)
        for plot, name in zip(panel.plots, (COUPLER, "thickness"), strict=True):
            assert [axis.title for axis in plot.axes] == ["f1 (Hz)", "mass (kg)"]
            for axis, output in enumerate(("f1", "mass")):
                wanted = np.stack([1e3 * dataset[name], dataset[output]], axis=-1)
                found = points(plot, "keeps every limit", axis)
                np.testing.assert_allclose(found, wanted[within])
                np.testing.assert_allclose(points(plot, "beyond a limit", axis), wanted[beyond])
            (limit,) = [trace for trace in plot.traces if trace.name == "limit"]
            assert set(limit.y) == {LEAST}
            assert limit.legend

    def test_texts_have_numbers_and_a_key(self) -> None:
        dataset = sweep_designs("number and text", limited=False)
        plot = panel_of(DesignSweep(dataset)).plots[1]
        assert plot.title == "Over coupler material: 1: aluminium, 2: steel"
        found = points(plot, "designs")
        np.testing.assert_array_equal(found[:, 0], np.where(dataset[MATERIAL] == "steel", 2, 1))

    def test_what_is_left_out_is_told(self) -> None:
        dataset = sweep_designs()
        names = [f"f{number}" for number in range(MOST_OUTPUTS + 1)]
        more = dataset.drop_dims("output").assign(dict.fromkeys(names, dataset["f1"]))
        more["relative_error"] = "output", np.zeros(len(names))
        more = more.assign_coords(output=names).assign_attrs(outputs=" ".join(names), goals="")
        panel = panel_of(DesignSweep(more))
        assert panel.thinned == (f"plots of f{MOST_OUTPUTS}",)
        assert all(len(plot.axes) == MOST_OUTPUTS for plot in panel.plots)

    def test_where_all_designs_fail_the_words_remain(self) -> None:
        dataset = sweep_designs(failed=True).isel(design=[FAILED])
        panel = panel_of(DesignSweep(dataset))
        assert not panel.plots
        assert panel.answer[0] == "0 of 1 designs keep every limit."


class TestUncertainty:
    def test_parts_of_the_designs_rise_to_all_of_them(self) -> None:
        dataset = uncertainty_dataset()
        frequency, mass, *_ = panel_of(Uncertainty(dataset)).plots
        curve = frequency.traces[0]
        np.testing.assert_array_equal(curve.x, np.sort(dataset["f1"]))
        np.testing.assert_allclose(curve.y, 100 * np.arange(1, 17) / 16)
        places = {
            name: [float(t.x[0]) for t in frequency.traces if t.name == name]
            for name in ("median", "2.5 and 97.5 %", "limit")
        }
        own = dataset.sel(output="f1")
        assert places == {
            "median": [float(own["p50"])],
            "2.5 and 97.5 %": [float(own["p2_5"]), float(own["p97_5"])],
            "limit": [LEAST],
        }
        assert not [trace for trace in mass.traces if trace.name == "limit"]

    def test_shares_have_intervals(self) -> None:
        plot = panel_of(Uncertainty(uncertainty_dataset())).plots[-2]
        np.testing.assert_allclose(points(plot, "first order")[:, 1], [0.8, 0.1])
        total = next(t for t in plot.traces if t.name == "total" and t.look != "points")
        np.testing.assert_allclose(total.y, [0.85, 0.97, np.nan, 0.15, 0.27, np.nan])
        assert plot.title.endswith("1: coupler in plane thickness, 2: coupler material")

    def test_correlated_inputs_have_none(self) -> None:
        panel = panel_of(Uncertainty(uncertainty_dataset(correlated=True)))
        assert [plot.name for plot in panel.plots] == [
            *("distribution-f1", "distribution-mass", "frequency-bands")
        ]

    def test_bands_of_frequencies_stand_above_each_other(self) -> None:
        dataset = uncertainty_dataset()
        plot = panel_of(Uncertainty(dataset)).plots[-1]
        assert [axis.title for axis in plot.axes] == ["mode 2 (Hz)", "mode 1 (Hz)"]
        for axis, mode in enumerate((2, 1)):
            low, median, high = dataset["frequency_percentile"].sel(mode=mode).values
            first, second, third = [trace for trace in plot.traces if trace.axis == axis]
            for trace, values in ((first, low), (second, high), (third, median)):
                np.testing.assert_array_equal(trace.y, values)
            assert (second.fill, third.name) == ("to previous", "median")
        assert [trace.name for trace in plot.traces if trace.legend] == [
            *("95 % of the designs", "median")
        ]


class TestOptimum:
    def test_front_search_and_both_engines(self) -> None:
        dataset = optimum_dataset()
        panel = panel_of(Optimum(dataset))
        front, search = panel.plots
        wanted = np.sort(np.stack([dataset["mass"], dataset["f1"]], axis=-1), axis=0)
        np.testing.assert_array_equal(points(front, "best designs"), wanted)
        mass, frequency = search.traces
        np.testing.assert_array_equal(mass.x, [64, 100, 100, 180, 180])
        np.testing.assert_array_equal(mass.y, [0.12, 0.12, 0.1, 0.1, 0.09])
        assert frequency.axis == 1
        (table,) = panel.folded
        assert table.headings[2:4] == ("reference", "exudyn")
        assert table.groups == (
            (("f1", "Hz", "45.02", "45.01", "0.1"), ("mass", "kg", "0.1", "0.1", "0")),
        )
        assert "computed anew by reference and exudyn" in panel.caption

    def test_one_goal_has_no_front(self) -> None:
        assert [plot.name for plot in panel_of(Optimum(optimum_dataset(1))).plots] == ["search"]


@pytest.mark.parametrize(
    ("kind", "dataset"),
    [
        (DesignSweep, sweep_designs(failed=True)),
        (Uncertainty, uncertainty_dataset()),
        (Optimum, optimum_dataset()),
    ],
    ids=["sweep", "uncertainty", "optimum"],
)
def test_a_stored_study_is_a_page_that_opens_with_its_answer(
    kind: type[Result], dataset: xr.Dataset, tmp_path: Path
) -> None:
    kind(dataset).save(tmp_path)
    found = stored_results(tmp_path)
    assert isinstance(found.all[0], kind)
    # Cards of speeds and forces would say that nothing was computed.
    assert not cards(found)
    text = write_report(list(found.all), tmp_path / "report.html").read_text("utf-8")
    assert panels_of(found)[0].title in text
    assert 'class="answer"' not in text


def test_the_key_of_long_texts_does_not_widen_a_phone(tmp_path: Path, browser: Any) -> None:
    dataset = sweep_designs("sample")
    layups = ["[U@45/U@-45/U@45/U@-45/U@0/U@45/U@-45/U@0/U@90]s", "[U@0*4]s"]
    dataset[MATERIAL] = "design", layups * 8
    path = write_report(DesignSweep(dataset), tmp_path / "report.html")
    page = browser.new_page(viewport=PHONE, is_mobile=True)
    page.goto(path.as_uri())
    page.wait_for_selector(READY, state="attached", timeout=60_000)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    page.close()
