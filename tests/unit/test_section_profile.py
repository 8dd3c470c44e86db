"""Sections as a result: its numbers are the section's, saved and loaded it says the same."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from flexmech import (
    BeamSection,
    HygrothermalState,
    InputError,
    Laminate,
    LaminateSection,
    Material,
    Mechanism,
    Ply,
    RotatingArm,
    load_mechanism,
    mechanism_in_state,
)
from flexmech.analyses.remarks import environment_lines
from flexmech.analyses.section_profile.compute import section_profiles
from flexmech.analyses.section_profile.result import SectionProfiles
from flexmech.analyses.summary import Table
from flexmech.materials import Layer, PlyDamping

MODELS = Path(__file__).parents[2] / "models"
CARBON = Ply(
    172.7e9, 7.2e9, 3.76e9, 3.76e9, 2.57e9, 0.29, 1566.7, PlyDamping(0.0045, 0.0422, 0.0705)
)
QUANTITIES = ("strain", "normal_stress", "shear_stress", "third_order_shear_stress")


@pytest.fixture(scope="module")
def composite() -> Mechanism:
    return load_mechanism(MODELS / "composite_fourbar.toml")


def arm(*layers: Layer) -> Mechanism:
    section = BeamSection.of_laminate(LaminateSection(Laminate(layers), 0.02))
    return Mechanism(RotatingArm(0.5), {"arm": section})


@pytest.mark.thorough
def test_a_loaded_result_says_the_same(composite: Mechanism, tmp_path: Path) -> None:
    general = replace(composite.sections["crank"], layers=None)
    some_known = replace(composite, sections={**composite.sections, "crank": general})
    none_known = Mechanism(RotatingArm(0.5), {"arm": general})
    for number, mechanism in enumerate((composite, some_known, none_known)):
        result = section_profiles(mechanism)
        result.save(tmp_path / str(number))
        loaded = SectionProfiles.load(tmp_path / str(number) / "sections.nc")
        assert loaded.dataset.identical(result.dataset)
        assert loaded.summary() == result.summary()
        for name, table in result.tables().items():
            assert loaded.tables()[name].equals(table)


def test_numbers_are_those_of_each_section(composite: Mechanism) -> None:
    found = section_profiles(composite)
    for name, section in composite.sections.items():
        values = found.dataset.sel(link=name, coupling="with")
        assert float(values["axial_stiffness"]) == section.axial_stiffness
        assert float(values["damping_time_shear"]) == section.damping.shear
        modulus = 12 * section.bending_stiffness / (0.02 * section.in_plane_thickness**3)
        assert float(values["flexural_modulus"]) == pytest.approx(modulus)
        unknown = [key for key, one in values.items() if one.ndim == 0 and one.isnull()]
        assert unknown == []
        profile = found.profile(name)
        assert profile["place"].notnull().all()
        assert float(profile["neutral_axis"]) == section.neutral_axis
        layers = section.layers
        assert layers is not None
        assert profile.sizes["layer"] == len(layers.laminate.layers)
        inside = layers.stresses(profile["place"].values, 0.0, 1.0)
        bent = profile["normal_stress"].sel(coupling="with", load="bending_moment")
        np.testing.assert_array_equal(bent.values, inside.normal_stress)


def test_pictures_are_those_of_the_links_chosen(composite: Mechanism) -> None:
    result = section_profiles(composite)
    assert list(result.figures()) == ["section_crank", "section_coupler", "section_rocker"]
    title = "through the thickness under unit loads on the pins' axis"
    for figure, link in ((result.plot(), "Crank"), (result.plot("coupler"), "Coupler")):
        (legend,) = figure.legends
        assert legend.get_title().get_text() == f"Composite four-bar\n{link}: {title}"
    axes = Figure().subplots(2, 3)
    assert result.plot("coupler", ax=axes.ravel()) is axes[0, 0].figure
    assert all(one.lines for one in axes.ravel())


def test_a_link_alone_is_that_link_of_all(composite: Mechanism) -> None:
    alone = section_profiles(composite, "coupler")
    assert alone.links == ["coupler"]
    assert alone.profile("coupler").identical(section_profiles(composite).profile("coupler"))


def test_what_is_not_known_is_not_drawn(composite: Mechanism) -> None:
    general = replace(composite.sections["crank"], layers=None)
    result = section_profiles(Mechanism(RotatingArm(0.5), {"arm": general}))
    assert result.figures() == {}
    assert list(result.tables()) == ["sections"]
    with pytest.raises(InputError, match='link: arm: section "general" tells'):
        result.plot()
    with pytest.raises(InputError, match="there is no link 'crank'; use one of arm"):
        result.plot("crank")
    assert "nothing is known" in result._repr_html_()
    assert "<img" not in result._repr_html_()


def test_runs_of_equal_layers_are_said_as_one() -> None:
    layers = [Layer(CARBON, 1e-3, angle) for angle in (0.0, 0.0, 0.5, 0.0)]
    # Materials without a name differ even so.
    layers += [Layer(Ply.isotropic(Material(youngs, 2000, 0.3)), 1e-3) for youngs in (1e9, 2e9)]
    mechanism = arm(*layers)
    section = mechanism.sections["arm"].layers
    assert section is not None
    runs = LaminateSection(Laminate((Layer(CARBON, 2e-3), *layers[2:])), 0.02)
    places = runs.places(3)
    printed = next(
        part
        for part in section_profiles(mechanism).summary().parts
        if isinstance(part, Table) and part.title == "arm under unit loads, with coupling"
    )
    assert [len(group) for group in printed.groups] == [3] * 5
    cells = np.array([[row[1:] for row in group[::-1]] for group in printed.groups[::-1]], float)
    np.testing.assert_allclose(cells[..., 0], 1e3 * places, atol=1e-12)
    bent = runs.stresses(places, 0.0, 1.0, 1.0)
    headings = [heading.split(" (")[1] for heading in printed.headings[4:]]
    units = [{"1e-6)": 1e-6, "kPa)": 1e3, "MPa)": 1e6}[unit] for unit in headings]
    for column, values, unit in zip(
        (3, 4, 5), (bent.strain, bent.normal_stress, bent.shear_stress), units, strict=True
    ):
        values = values / unit
        np.testing.assert_allclose(
            cells[..., column], values, rtol=1e-3, atol=2e-9 * np.abs(values).max()
        )
    apart = section_profiles(mechanism).dataset
    merged = section_profiles(Mechanism(RotatingArm(0.5), {"arm": BeamSection.of_laminate(runs)}))
    for name in ("axial_stiffness", "bending_stiffness", "shear_stiffness", "rotary_inertia"):
        np.testing.assert_allclose(merged.dataset[name], apart[name], rtol=1e-9)


def test_the_environment_makes_the_sections() -> None:
    mechanism = load_mechanism(MODELS / "moist_composite_fourbar.toml")
    state = HygrothermalState(60.0, 0.04)
    wet = section_profiles(mechanism, environment=state)
    same = section_profiles(mechanism_in_state(mechanism, state))
    for name in ("bending_stiffness", *QUANTITIES):
        assert wet.dataset[name].identical(same.dataset[name])
    lines = environment_lines(mechanism, state)
    assert lines[0] == "state: +60 K, 4 % moisture"
    assert lines[1].endswith("resin keeps 52.87 % of its stiffness")
    assert wet.summary().parts[-len(lines) :] == tuple(lines)
    assert environment_lines(mechanism, None) == []


def test_what_plies_swell_by_is_that_of_the_paper_s_equations() -> None:
    """Singh & Sanyal 2022, eq. 7, and eq. 8 with the resin's Poisson ratio in place of V_m."""
    mechanism = load_mechanism(MODELS / "moist_composite_fourbar.toml")
    found = section_profiles(mechanism)
    rows = found.tables()["plies"]
    assert list(rows.columns) == [
        "link",
        "ply",
        "thermal_expansion_along_per_K",
        "thermal_expansion_across_per_K",
        "moisture_expansion_along_per_percent",
        "moisture_expansion_across_per_percent",
    ]
    assert set(rows["link"]) == {"crank", "coupler", "rocker"}
    layers = mechanism.sections["coupler"].layers
    assert layers is not None
    ply = layers.laminate.layers[0].ply
    fibre, matrix = ply.origin.fibre, ply.origin.matrix
    share = ply.origin.fibre_volume_fraction
    resin = matrix.youngs_modulus * (1 - share)
    along = matrix.moisture_expansion * resin / (resin + fibre.youngs_modulus * share)
    poisson_ratio = fibre.poisson_ratio * share + matrix.poisson_ratio * (1 - share)
    across = matrix.moisture_expansion * (1 - share) * (1 + matrix.poisson_ratio)
    across -= along * poisson_ratio
    row = rows[(rows["link"] == "coupler") & (rows["ply"] == ply.name)].iloc[0]
    assert row["moisture_expansion_along_per_percent"] == pytest.approx(along / 100)
    assert row["moisture_expansion_across_per_percent"] == pytest.approx(across / 100)
    printed = str(found.summary())
    assert "coupler: swelling of its plies" in printed
    assert f"{1e3 * across / 100:.5g}" in printed


def test_nothing_is_said_of_swelling_where_nothing_is_known() -> None:
    found = section_profiles(load_mechanism(MODELS / "steel_fourbar.toml"))
    assert "plies" not in found.tables()
    assert "swelling" not in str(found.summary())
