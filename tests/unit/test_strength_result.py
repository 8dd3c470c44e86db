"""Files, pictures and words of a strength result."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import flexmech
from flexmech.analyses.strength.result import Strength
from flexmech.errors import InputError
from flexmech.plots import page_width, plot_internal_forces, plot_strength
from tests.unit.figure_checks import check_texts, legend_texts, panels
from tests.unit.strength_data import composite


@pytest.fixture(scope="module")
def found() -> Strength:
    return flexmech.strength(composite(), 950.0, speed_unit="rpm")


def test_columns_of_the_files(found: Strength) -> None:
    tables = found.tables()
    assert list(tables["strength"]) == [
        "engine",
        "link",
        "position_m",
        "layer",
        "surface",
        "crank_angle_deg",
        "criterion",
        "index",
        "load_factor",
    ]
    assert list(tables["margins"]) == [
        "part",
        "kind",
        "load_factor",
        "speed_factor",
        "where",
        "layer",
        "crank_angle_deg",
        "mode_of_failure",
    ]
    # Nine places in 10, 8 and 6 layers with two surfaces each.
    assert len(tables["strength"]) == 9 * (10 + 8 + 6) * 2
    assert set(tables["margins"]["kind"]) == {"link"}
    assert len(tables["internal_forces"]) == 3 * 73 * 9


def test_margins_are_the_worst_of_the_places(found: Strength) -> None:
    tables = found.tables()
    margins = tables["margins"].set_index("part")
    assert margins["load_factor"].is_monotonic_increasing
    for link, rows in tables["strength"].groupby("link"):
        worst = rows.loc[rows["load_factor"].idxmin()]
        assert margins.loc[link, "load_factor"] == worst["load_factor"]
        assert margins.loc[link, "layer"] == worst["layer"]
        assert margins.loc[link, "crank_angle_deg"] == worst["crank_angle_deg"]
    # Inertia alone: loads go with the square of the speed.
    np.testing.assert_allclose(margins["speed_factor"] ** 2, margins["load_factor"], rtol=1e-9)


def test_worst_angle_is_that_of_the_turn(found: Strength) -> None:
    """At the worst crank angle alone the same factor is found."""
    first = found.dataset.isel(margin=0)
    angle = float(first["margin_crank_angle"])
    request = flexmech.StrengthRequest(np.array([angle]), 950.0, speed_unit="rpm")
    alone = flexmech.strength(composite(), request).dataset
    assert float(alone["margin_load_factor"][0]) == pytest.approx(
        float(first["margin_load_factor"]), rel=1e-12
    )


def test_file_is_read_back(found: Strength, tmp_path: Path) -> None:
    found.save(tmp_path)
    again = Strength.load(tmp_path / "strength.nc")
    xr.testing.assert_identical(again.dataset, found.dataset)
    assert str(again.summary()) == str(found.summary())


def test_answer_comes_first(found: Strength) -> None:
    summary = found.summary()
    first = found.tables()["margins"].iloc[0]
    said = summary.answer[0]
    assert said.startswith(f"{first['part']} fails first, by {first['mode_of_failure']} in layer")
    assert f"a factor of {first['load_factor']:.3g}" in said
    assert f"the speed by {first['speed_factor']:.3g}" in said
    assert any("F12* = -1/2" in line for line in summary.lines)
    assert any("free edges" in line and "holes" in line for line in summary.lines)
    assert any("stress_free_temperature" in line for line in summary.lines)


def test_overloaded_link_is_warned_of() -> None:
    mechanism = composite()
    summary = flexmech.strength(mechanism, 30000.0, speed_unit="rpm").summary()
    assert "must fall to" in summary.answer[0]
    assert "does not bear" in summary.warnings[0]


@pytest.mark.parametrize("width", [180.0, 88.0])
def test_pictures_show_the_numbers(found: Strength, width: float) -> None:
    data = found.dataset
    with page_width(width):
        drawn, forces = plot_strength(data), plot_internal_forces(data)
        for figure in (drawn, forces):
            check_texts(figure)
    texts = {text.get_text() for text in panels(drawn)[0].texts}
    assert {f"{factor:.3g}" for factor in data["margin_load_factor"].values} <= texts
    assert "worst place, with its load factor" in legend_texts(drawn)
    moment = panels(forces)[2]
    values = data["bending_moment"].sel(link="crank").values[0]
    shown = [np.asarray(line.get_ydata()) for line in moment.lines]
    for envelope in (values.min(axis=0), values.max(axis=0)):
        assert any(len(line) == 9 and np.allclose(line, envelope) for line in shown)
    plt.close("all")


def test_rigid_links_are_named_and_grey() -> None:
    mechanism = composite()
    sections = dict(mechanism.sections)
    sections["rocker"] = replace(sections["rocker"], layers=None)
    found = flexmech.strength(replace(mechanism, sections=sections), 950.0, speed_unit="rpm")
    assert found.tables()["margins"]["part"].tolist() == ["crank", "coupler"]
    assert any("not judged" in line and "rocker" in line for line in found.summary().lines)
    assert "not judged" in legend_texts(plot_strength(found.dataset))
    plt.close("all")


def test_request_is_checked() -> None:
    with pytest.raises(InputError, match="criterion"):
        flexmech.StrengthRequest(criterion="tresca")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="elements"):
        flexmech.StrengthRequest(elements=0)
    with pytest.raises(InputError, match="increase"):
        flexmech.StrengthRequest([1.0, 0.5])  # type: ignore[arg-type]
    mechanism = composite()
    bare = {name: replace(own, layers=None) for name, own in mechanism.sections.items()}
    stiff = replace(mechanism, sections=bare)
    with pytest.raises(InputError, match="no link of"):
        flexmech.strength(stiff, 100.0)
