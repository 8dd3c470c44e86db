"""Files, pictures and words of a strength result."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import flexmech
from flexmech.analyses.strength.judged_mechanism import JudgedMechanism
from flexmech.analyses.strength.result import Strength
from flexmech.errors import InputError
from flexmech.plots import page_width, plot_internal_forces, plot_strength
from tests.support.figure_checks import check_texts, legend_texts, panels
from tests.support.strength_data import MODELS, STRENGTH, composite


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
    request = flexmech.StrengthRequest(crank_speed=950.0, speed_unit="rpm", source="rigid")
    straight = flexmech.strength(composite(), request).tables()["margins"]
    # Inertia alone: loads of straight links go with the square of the speed.
    np.testing.assert_allclose(straight["speed_factor"] ** 2, straight["load_factor"], rtol=1e-9)


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
    with pytest.raises(InputError, match="no link and no pin of"):
        flexmech.strength(stiff, 100.0)


def test_pins_are_judged_where_no_link_is(tmp_path: Path) -> None:
    """Sections that are stated by their stiffness have no layers."""
    mechanism = composite()
    bare = {name: replace(own, layers=None) for name, own in mechanism.sections.items()}
    pin = flexmech.JointPin("A", 8e-3, bush_length=10e-3, allowable_pv=1.8e6)
    stiff = replace(mechanism, sections=bare, joint_pins=(pin,))
    found = flexmech.strength(stiff, 950.0, speed_unit="rpm")
    assert found.tables()["margins"][["part", "kind"]].values.tolist() == [["A", "pin"]]
    assert found.tables()["strength"].empty
    assert found.summary().answer[0].startswith("pin A fails first, by p v in the bush")
    details = "\n".join(found.summary().details)
    assert "not judged, for their layers are not known: crank, coupler, rocker" in details
    assert "criteria:" not in details
    for figure in found.figures().values():
        check_texts(figure)
    assert "not judged" in legend_texts(plot_strength(found.dataset))
    plt.close("all")
    found.save(tmp_path)
    again = Strength.load(tmp_path / "strength.nc")
    xr.testing.assert_identical(again.dataset, found.dataset)


def test_rigid_links_are_at_rest_as_they_are() -> None:
    """Without an elastic link the equilibrium is that of the rigid linkage, and is called so."""
    strong = flexmech.Material(70e9, 2700.0, yield_strength=240e6)
    section = flexmech.BeamSection.rectangle(strong, 8e-3, 20e-3)
    points = {"O2": (0.0, 0.0), "O4": (0.25, 0.0), "A": (0.0, 0.1), "B": (0.2, 0.28)}
    ends = {"crank": ("O2", "A"), "coupler": ("A", "B"), "rocker": ("O4", "B")}

    def linkage(rigid: bool) -> flexmech.Mechanism:
        links = tuple(flexmech.PlanarLink(name, own, rigid=rigid) for name, own in ends.items())
        clamp = flexmech.PlanarJoint("O2", "clamp")
        planar = flexmech.PlanarLinkage(points, links, ("O2", "O4"), (clamp,))
        return flexmech.Mechanism(planar, dict.fromkeys(ends, section))

    found = flexmech.strength(linkage(rigid=True), 40.0)
    assert found.dataset.attrs["source_of_loads"] == "rigid"
    request = flexmech.StrengthRequest(crank_speed=40.0, source="rigid")
    straight = flexmech.strength(linkage(rigid=False), request)
    assert set(found.tables()["margins"]["part"]) == set(ends)
    np.testing.assert_allclose(
        found.dataset["margin_load_factor"], straight.dataset["margin_load_factor"], rtol=1e-12
    )


def test_links_in_air_for_a_time_are_judged_by_slices() -> None:
    """Water that has gone in everywhere is what a state of equal moisture has."""
    strong = []
    mechanism = flexmech.load_mechanism(MODELS / "moist_composite_fourbar.toml")
    sections = {}
    for link, section in mechanism.sections.items():
        assert section.layers is not None
        laminate = section.layers.laminate
        layers = tuple(
            replace(la, ply=replace(la.ply, strength=STRENGTH)) for la in laminate.layers
        )
        strong.append(len(layers))
        sections[link] = replace(
            section, layers=section.layers.resized(replace(laminate, layers=layers), 1.0)
        )
    mechanism = replace(mechanism, sections=sections)

    def judged(environment: object) -> Strength:
        request = flexmech.StrengthRequest(
            crank_speed=20.0, environment=environment, search_speed=False
        )
        return flexmech.strength(mechanism, request)

    year = 365.25 * 86400.0
    damp = judged(flexmech.Exposure(40.0, 0.5, 1000 * year))
    layers = mechanism.sections["coupler"].layers
    assert layers is not None
    resin = layers.laminate.layers[0].ply.resin
    assert resin is not None
    equilibrium = resin.hygrothermal.equilibrium
    assert equilibrium is not None
    water = equilibrium.saturation * 0.5**equilibrium.humidity_exponent
    equal = judged(flexmech.HygrothermalState(40.0, water))
    first, second = (one.dataset["margin_load_factor"].values for one in (damp, equal))
    np.testing.assert_allclose(first, second, rtol=1e-3)
    details = "\n".join(damp.summary().details)
    assert "layers are slices of the stated ones, each equally moist: crank" in details
    assert damp.dataset.sizes["layer"] > max(strong)
    assert "slices" not in "\n".join(equal.summary().details)
    # Without heat, and without a temperature of cure, it is water alone that strains the plies.
    cold = flexmech.StrengthRequest(
        crank_speed=20.0, environment=flexmech.Exposure(0.0, 0.5, year / 12)
    )
    assert (
        max(np.abs(own).max() for own in JudgedMechanism.of(mechanism, cold).residual.values())
        > 1e6
    )
    # After a month water is near the surfaces, which swell against the rest.
    month = judged(flexmech.Exposure(40.0, 0.5, year / 12))
    assert np.abs(month.dataset["margin_load_factor"].values / second - 1).max() > 1e-3
