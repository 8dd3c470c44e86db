"""Mechanisms in heat and water: lengths, masses, softening, uptake, and links that bend.

The neat-resin linkages of Singh & Sanyal 2022, whose crossings and angles are cases of the
verification, and a small linkage of the same resin.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from flexmech import (
    Exposure,
    HygrothermalState,
    InputError,
    Mechanism,
    ReferenceEngine,
    load_mechanism,
    mechanism_in_state,
    natural_frequencies,
)
from flexmech.analyses import section_profiles
from flexmech.hygrothermal import linkage_in_state, swollen_links
from flexmech.modelfile import mechanism_from_toml
from tests.support.command import MODELS

DAY = 86400.0
WET = HygrothermalState(80.0, 0.07)
RESIN = """
youngs_modulus = "3.9 GPa"
density = "1280 kg/m^3"
poisson_ratio = 0.37
thermal_expansion = "58.4e-6 1/K"
wet_thermal_expansion = "62.6e-6 1/K"
moisture_expansion = "3.02e-3 1/percent"
equilibrium_moisture = "7 percent"
glass_transition = "210 degC"
diffusivity = "6e-13 m^2/s"
activation_energy = "45 kJ/mol"
"""
STEEL = 'youngs_modulus = "210 GPa"\ndensity = "7850 kg/m^3"\npoisson_ratio = 0.3\n'
MASSES = """
[joints.A]
mass = "20 g"
[[links.rocker.point_masses]]
position = "80 mm"
mass = "10 g"
"""


def model(*, resin: str = RESIN, crank: str = "resin", coupler: str = "", more: str = ""):
    links = "".join(
        f"""[links.{link}]
section = "rectangle"
material = "{material}"
in_plane_thickness = "6 mm"
out_of_plane_width = "10 mm"
{keys}
"""
        for link, material, keys in (
            ("crank", crank, ""),
            ("coupler", "resin", coupler),
            ("rocker", "resin", ""),
        )
    )
    return mechanism_from_toml(f"""
name = "test linkage"
source = "invented"
[linkage]
kind = "four-bar"
ground = "200 mm"
crank = "100 mm"
coupler = "160 mm"
rocker = "160 mm"
[materials.resin]
{resin}
[materials.steel]
{STEEL}
{links}{more}""")


@pytest.mark.parametrize("figure", ["3", "12"])
def test_neat_resin_linkages_swell_soften_and_gain_water(figure: str) -> None:
    """R-914 at 100 degC with 7 % of water: 62.6e-6 * 80 + 3.02e-3 * 7 = 0.026148 longer.

    Chamis: of the glass transition of 106.36 degC, the root of 6.36 / 190 is left of the stiffness.
    """
    mechanism = load_mechanism(MODELS / f"neat_resin_figure_{figure}.toml")
    dry, wet = mechanism.linkage, linkage_in_state(mechanism, WET)
    for link in ("crank", "coupler", "rocker"):
        assert wet.lengths[link] / dry.lengths[link] == pytest.approx(1.026148, abs=1e-9)
    assert wet.ground / dry.ground == pytest.approx(1.005008, abs=1e-9)
    kept = np.sqrt(((410 * (0.005 * 49 - 0.7 + 1) - 32) / 1.8 - 100) / 190)
    assert kept == pytest.approx(0.18297, abs=1e-5)
    for link, section in mechanism_in_state(mechanism, WET).sections.items():
        before = mechanism.sections[link]
        stiffness = section.axial_stiffness / before.axial_stiffness
        assert stiffness == pytest.approx(kept * 1.026148**2, rel=1e-9)
        mass = section.mass_per_length / before.mass_per_length
        assert mass == pytest.approx(1.07 / 1.026148, rel=1e-9)
    # 8551-7: 70.0e-6 * 80 + 3.09e-3 * 2 = 0.011780; it takes up 2 % at most.
    text = (MODELS / f"neat_resin_figure_{figure}.toml").read_text(encoding="utf-8")
    other = mechanism_from_toml(text.replace('material = "R-914"', 'material = "8551-7"'))
    links = swollen_links(other, HygrothermalState(80.0, 0.02))
    assert [link.elongation for link in links.values()] == pytest.approx([0.011780] * 3, abs=1e-9)
    with pytest.raises(InputError, match="2 % at 100 % relative humidity"):
        mechanism_in_state(other, WET)


def test_a_frame_that_swells_with_the_links_changes_no_angle() -> None:
    mechanism = load_mechanism(MODELS / "neat_resin_figure_3.toml")
    mechanism = replace(mechanism, ground_thermal_expansion=0.026148 / 80)
    turn = np.radians(np.arange(0.0, 360.0, 30.0))
    dry, wet = (
        linkage_in_state(mechanism, s).motion(turn).angle for s in (HygrothermalState(), WET)
    )
    np.testing.assert_allclose(wet, dry, atol=1e-12)


def test_a_dry_mechanism_has_the_same_frequencies_to_the_last_bit() -> None:
    mechanism = model(coupler='exposed_faces = "upper"', more=MASSES)
    again = mechanism_in_state(mechanism, HygrothermalState())
    assert again == mechanism
    first, second = (natural_frequencies(ReferenceEngine(m), 1.0, 15.0) for m in (mechanism, again))
    assert np.array_equal(first, second)


def test_point_masses_move_with_their_link_and_metal_stays_dry() -> None:
    wet = mechanism_in_state(model(crank="steel", more=MASSES), HygrothermalState(0, 0.07))
    assert wet.link_masses[0].position == pytest.approx(0.08 * (1 + 0.302 * 0.07))
    assert (wet.link_masses[0].mass, wet.joint_masses) == (0.01, {"A": 0.02})
    links = swollen_links(model(crank="steel"), Exposure(40, 0.85, DAY))
    assert links["crank"].water == links["crank"].elongation == 0.0
    assert links["coupler"].water > 0


def test_water_of_an_exposed_link_is_that_of_ficks_series() -> None:
    """Both faces wet, Arrhenius at 60 degC: Crank's eq. 4.18 for a plate of 6 mm."""
    link = swollen_links(model(), Exposure(40.0, 0.85, 5 * DAY))["coupler"]
    diffusivity = 6e-13 * np.exp(45e3 / 8.314462618 * (1 / 293.15 - 1 / 333.15))
    odd = 2 * np.arange(200) + 1
    fourier = diffusivity * 5 * DAY / 0.006**2
    share = 1 - np.sum(8 / (odd * np.pi) ** 2 * np.exp(-((odd * np.pi) ** 2) * fourier))
    assert link.water == pytest.approx(0.07 * 0.85 * share, rel=1e-4)
    assert link.section.free_curvature == 0.0
    sides = swollen_links(model(coupler="exposed_sides = true"), Exposure(40.0, 0.85, 5 * DAY))
    assert sides["coupler"].water > 1.2 * link.water


def test_a_saturated_exposure_is_the_uniform_state() -> None:
    mechanism = model()
    long = mechanism_in_state(mechanism, Exposure(40.0, 1.0, 4000 * DAY))
    uniform = mechanism_in_state(mechanism, HygrothermalState(40.0, 0.07))
    assert long.linkage.coupler == pytest.approx(uniform.linkage.coupler, rel=1e-9)
    for name in ("bending_stiffness", "mass_per_length", "shear_stiffness"):
        first, second = (getattr(m.sections["coupler"], name) for m in (long, uniform))
        assert first == pytest.approx(second, rel=1e-7)


def test_a_link_with_one_wet_face_bends_away_from_it_and_comes_back() -> None:
    """The lower side grows: the link turns to the left, and its dry side carries more."""
    mechanism = model(coupler='exposed_faces = "lower"')
    early, late = (
        swollen_links(mechanism, Exposure(40.0, 0.85, days * DAY))["coupler"] for days in (2, 400)
    )
    assert early.section.free_curvature > 5 * abs(late.section.free_curvature) > 0
    assert early.section.neutral_axis > 0
    assert early.water < late.water


def test_pins_of_a_bent_link_are_where_the_engine_leaves_them() -> None:
    """Nothing loads the coupler: the unloaded straight rocker turns as in the rigid linkage."""
    mechanism = model(coupler='exposed_faces = "lower"')
    state, angles = Exposure(40.0, 0.85, 2 * DAY), np.radians([20.0, 140.0])
    wet, rigid = mechanism_in_state(mechanism, state), linkage_in_state(mechanism, state)
    engine, motion = ReferenceEngine(wet, elements=32), wet.linkage.motion(angles)
    moved = engine.stressed_links(motion, "equilibrium").displacement[2][:, engine.links[2].end]
    turned = moved[:, 1] / swollen_links(mechanism, state)["rocker"].length
    wanted = rigid.motion(angles).angle[:, 2] - motion.angle[:, 2]
    assert turned == pytest.approx(wanted, rel=2e-3)


def test_an_environment_of_an_analysis_is_the_mechanism_in_that_state() -> None:
    mechanism = load_mechanism(MODELS / "moist_composite_fourbar.toml")
    state = HygrothermalState(60.0, 0.04)
    wet = mechanism_in_state(mechanism, state)
    profiles = section_profiles(mechanism, environment=state).dataset
    assert profiles["normal_stress"].identical(section_profiles(wet).dataset["normal_stress"])


def test_swelling_of_plies_is_that_of_the_papers_equations() -> None:
    """Eq. 7, and eq. 8 with the resin's Poisson ratio in place of V_m."""
    mechanism = load_mechanism(MODELS / "moist_composite_fourbar.toml")
    ply = mechanism.sections["coupler"].layers.laminate.layers[0].ply
    fibre, matrix = ply.origin.fibre, ply.origin.matrix
    share = ply.origin.fibre_volume_fraction
    resin = matrix.youngs_modulus * (1 - share)
    along = matrix.moisture_expansion * resin / (resin + fibre.youngs_modulus * share)
    across = matrix.moisture_expansion * (1 - share) * (1 + matrix.poisson_ratio)
    across -= along * (fibre.poisson_ratio * share + matrix.poisson_ratio * (1 - share))
    rows = section_profiles(mechanism).tables()["plies"]
    row = rows[(rows["link"] == "coupler") & (rows["ply"] == ply.name)].iloc[0]
    assert row["moisture_expansion_along_per_percent"] == pytest.approx(along / 100)
    assert row["moisture_expansion_across_per_percent"] == pytest.approx(across / 100)


def in_state(state: HygrothermalState | Exposure, **options: str) -> Callable[[], Mechanism]:
    return lambda: mechanism_in_state(model(**options), state)


def without(*keys: str) -> str:
    return "\n".join(line for line in RESIN.splitlines() if not line.startswith(keys))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (in_state(HygrothermalState(90, 0.07)), "links.crank: at 110 degC the resin is above"),
        (in_state(HygrothermalState(0, 0.08)), "links.crank: .*more than the resin takes up"),
        (in_state(HygrothermalState(10.0), resin=STEEL, crank="steel"), "change nothing in 'test"),
        (
            in_state(Exposure(0, 0.85, DAY), crank="steel", resin=without("diffus", "activation")),
            "links.coupler: its resin has no diffusivity",
        ),
        (
            in_state(Exposure(0, 0.85, DAY), crank="steel", resin=without("equilib", "wet_")),
            "links.coupler: its resin has no equilibrium_moisture",
        ),
        (lambda: HygrothermalState(0.0, -0.01), "moisture must be zero or positive"),
        (lambda: Exposure(0.0, 1.2, 1.0), "relative_humidity must be at least 0"),
        (lambda: Exposure(0.0, 0.5, -1.0), "time of exposure"),
        (
            lambda: model(resin=STEEL + 'activation_energy = "45 kJ/mol"'),
            "activation_energy is given without diffusivity",
        ),
        (
            lambda: model(resin=STEEL + 'thermal_expansion = "5 mm"'),
            "materials.resin.thermal_expansion",
        ),
        (
            lambda: model(resin=STEEL + 'glas_transition = "210 degC"'),
            "did you mean 'glass_transition'",
        ),
    ],
)
def test_states_that_no_mechanism_has_are_refused(make: Callable[[], object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        make()
