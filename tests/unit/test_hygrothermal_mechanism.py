"""Mechanisms in heat and water, from model files: lengths, moisture, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech.analyses import natural_frequencies
from flexmech.errors import InputError
from flexmech.hygrothermal import (
    Environment,
    Exposure,
    HygrothermalState,
    absorbing_links,
    coupler_point_in_state,
    inert_links,
    link_diffusion,
    link_profile,
    linkage_in_state,
    mechanism_in_state,
    swollen_links,
)
from flexmech.linkages import CouplerPoint, FourBar
from flexmech.mechanism import Mechanism
from flexmech.modelfile import mechanism_from_toml
from flexmech.reference import ReferenceEngine
from tests.analytical.slab_series import slab_uptake

DAY = 86400.0
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
diffusivity_temperature = "20 degC"
activation_energy = "45 kJ/mol"
"""
STEEL = """
youngs_modulus = "210 GPa"
density = "7850 kg/m^3"
poisson_ratio = 0.3
"""


def model(
    *,
    ground: str = "",
    materials: dict[str, str] | None = None,
    crank: str = "resin",
    rocker: str = "resin",
    coupler: str = "",
    environment: str = "",
) -> Mechanism:
    materials = {"resin": RESIN, "steel": STEEL} if materials is None else materials
    text = f"""
name = "test linkage"
source = "invented"
[linkage]
kind = "four-bar"
ground = "200 mm"
crank = "100 mm"
coupler = "160 mm"
rocker = "160 mm"
{ground}
"""
    for name, keys in materials.items():
        text += f"[materials.{name}]\n{keys}\n"
    for link, material, keys in (
        ("crank", crank, ""),
        ("coupler", "resin", coupler),
        ("rocker", rocker, ""),
    ):
        text += f"""[links.{link}]
section = "rectangle"
material = "{material}"
in_plane_thickness = "6 mm"
out_of_plane_width = "10 mm"
{keys}
"""
    return mechanism_from_toml(text + environment)


def test_swollen_lengths_of_the_errata() -> None:
    linkage = linkage_in_state(
        model(ground='ground_thermal_expansion = "62.6e-6 1/K"'), HygrothermalState(80, 0.07)
    )
    assert linkage.crank == pytest.approx(0.102614800, abs=1e-9)
    assert linkage.coupler == pytest.approx(0.16 * 1.026148, rel=1e-12)
    assert linkage.ground == pytest.approx(0.2 * (1 + 62.6e-6 * 80), rel=1e-12)


def test_uniform_expansion_of_everything_turns_no_angle() -> None:
    """If the frame swelled like the links, no angle would change (errata of the paper)."""
    mechanism = model()
    swollen = linkage_in_state(mechanism, HygrothermalState(80, 0.07))
    scaled = replace(swollen, ground=0.2 * 1.026148)
    angles = np.radians(np.arange(0, 360, 30))
    assert isinstance(mechanism.linkage, FourBar)
    assert scaled.motion(angles).angle == pytest.approx(mechanism.linkage.motion(angles).angle)


def test_dry_mechanism_is_the_same_to_the_last_bit() -> None:
    mechanism = model(coupler='exposed_faces = "upper"', environment=MASSES)
    again = mechanism_in_state(mechanism, HygrothermalState())
    assert again == mechanism
    angles = np.radians([0, 100, 200])
    first, second = (
        natural_frequencies(ReferenceEngine(m), angles, 15.0) for m in (mechanism, again)
    )
    assert np.array_equal(first, second)


MASSES = """
[joints.A]
mass = "20 g"
[[links.rocker.point_masses]]
position = "80 mm"
mass = "10 g"
"""


def test_point_masses_move_with_their_link() -> None:
    wet = mechanism_in_state(model(environment=MASSES), HygrothermalState(0, 0.07))
    assert wet.link_masses[0].position == pytest.approx(0.08 * (1 + 0.302 * 0.07))
    assert wet.link_masses[0].mass == 0.01
    assert wet.joint_masses == {"A": 0.02}


def test_name_says_the_state() -> None:
    wet = mechanism_in_state(model(), HygrothermalState(80, 0.07))
    assert wet.provenance.name == "test linkage, +80 K, 7 % moisture"


def test_metal_links_stay_dry() -> None:
    mechanism = model(crank="steel")
    assert absorbing_links(mechanism) == ("coupler", "rocker")
    assert inert_links(mechanism) == ("crank",)
    links = swollen_links(mechanism, HygrothermalState(40, 0.05))
    assert links["crank"].elongation == 0.0
    assert links["coupler"].elongation > 0.01
    assert swollen_links(mechanism, Exposure(40, 0.85, DAY))["crank"].water == 0.0


def test_coupler_point_swells_with_the_coupler() -> None:
    point = coupler_point_in_state(model(), CouplerPoint(0.05, 0.4), HygrothermalState(80, 0.07))
    assert point.distance == pytest.approx(0.05 * 1.026148)
    assert point.angle == 0.4


def test_moisture_of_an_exposed_link_is_that_of_the_series() -> None:
    mechanism = model()
    exposure = Exposure(40.0, 0.85, 5 * DAY)
    link = swollen_links(mechanism, exposure)["coupler"]
    diffusion = link_diffusion(mechanism, "coupler")
    diffusivity = float(diffusion.layers[0].diffusivity.at(333.15))
    share = float(slab_uptake(np.array([5 * DAY]), 0.006, diffusivity)[0])
    assert link.water == pytest.approx(0.07 * 0.85 * share, rel=1e-4)
    assert link.section.free_curvature == 0.0
    assert not link.section.is_eccentric


def test_one_wet_face_bends_the_link_away_from_it() -> None:
    mechanism = model(coupler='exposed_faces = "lower"')
    link = swollen_links(mechanism, Exposure(40.0, 0.85, 2 * DAY))["coupler"]
    # The lower side grows: the link turns to the left, and its dry side carries more.
    assert link.section.free_curvature > 0
    assert link.section.neutral_axis > 0
    assert link.distance_of_pins != link.length


def test_distance_of_pins_is_that_of_the_bent_link_at_rest() -> None:
    """A coupler that nothing pulls: the engines leave its pins where the arc has them."""
    mechanism = model(coupler='exposed_faces = "lower"')
    state = Exposure(40.0, 0.85, 2 * DAY)
    wet = mechanism_in_state(mechanism, state)
    rigid = linkage_in_state(mechanism, state)
    engine = ReferenceEngine(wet, elements=32)
    angles = np.radians([20.0, 140.0])
    motion = wet.linkage.motion(angles)
    found = engine.stressed_links(motion, "equilibrium").displacement
    assert found is not None
    # The rocker is unloaded and straight, so its angle is that of the rigid linkage.
    moved = found[2][:, engine.links[2].end]
    turned = moved[:, 1] / swollen_links(mechanism, state)["rocker"].length
    wanted = rigid.motion(angles).angle[:, 2] - motion.angle[:, 2]
    assert turned == pytest.approx(wanted, rel=2e-3)


def test_water_through_the_sides_comes_on_top() -> None:
    exposure = Exposure(40.0, 0.85, 2 * DAY)
    narrow, both = (
        swollen_links(model(coupler=keys), exposure)["coupler"].water
        for keys in ("", "exposed_sides = true")
    )
    assert both > 1.2 * narrow


def test_dry_air_and_no_time_leave_a_link_dry() -> None:
    for exposure in (Exposure(0.0, 0.85, 0.0), Exposure(0.0, 0.0, DAY)):
        link = swollen_links(model(), exposure)["coupler"]
        assert link.water == pytest.approx(0.0, abs=1e-15)
        assert link.elongation == pytest.approx(0.0, abs=1e-15)


def test_saturated_exposure_is_the_uniform_state() -> None:
    mechanism = model()
    long = mechanism_in_state(mechanism, Exposure(40.0, 1.0, 4000 * DAY))
    uniform = mechanism_in_state(mechanism, HygrothermalState(40.0, 0.07))
    assert long.linkage.coupler == pytest.approx(uniform.linkage.coupler, rel=1e-9)  # type: ignore[attr-defined]
    for name in ("bending_stiffness", "mass_per_length", "shear_stiffness"):
        first, second = (getattr(m.sections["coupler"], name) for m in (long, uniform))
        assert first == pytest.approx(second, rel=1e-7)


def test_profile_has_slices_of_the_thickness() -> None:
    profile = link_profile(model(), "coupler", Exposure(40.0, 0.85, 2 * DAY))
    assert isinstance(profile.moisture, tuple)
    moisture = np.array(profile.moisture[0])
    assert len(moisture) == 32
    assert moisture == pytest.approx(moisture[::-1], rel=1e-13)
    assert np.all(np.diff(moisture[:16]) < 0)
    assert moisture.max() < 0.07 * 0.85


@pytest.mark.parametrize(
    ("mechanism", "environment", "said"),
    [
        (model(), HygrothermalState(90, 0.07), "links.crank: at 110 degC the resin is above"),
        (model(), HygrothermalState(0, 0.08), "links.crank: .*more than the resin takes up"),
        (
            model(materials={"resin": STEEL, "steel": STEEL}),
            HygrothermalState(10, 0.0),
            "heat and moisture change nothing in 'test linkage'",
        ),
    ],
)
def test_refused_states(mechanism: Mechanism, environment: Environment, said: str) -> None:
    with pytest.raises(InputError, match=said):
        mechanism_in_state(mechanism, environment)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (("diffusivity", "activation"), "links.coupler: its resin has no diffusivity"),
        (("equilibrium", "wet_"), "links.coupler: its resin has no equilibrium_moisture"),
    ],
)
def test_diffusion_needs_its_numbers(lines: tuple[str, ...], said: str) -> None:
    text = "\n".join(line for line in RESIN.splitlines() if not line.startswith(lines))
    with pytest.raises(InputError, match=said):
        mechanism_in_state(
            model(materials={"resin": text, "steel": STEEL}, crank="steel"),
            Exposure(0.0, 0.85, DAY),
        )


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: HygrothermalState(np.nan, 0.0), "temperature_rise must be a number"),
        (lambda: HygrothermalState(0.0, -0.01), "moisture must be zero or positive"),
        (
            lambda: Exposure(0.0, 1.2, 1.0),
            "relative_humidity must be at least 0",
        ),
        (lambda: Exposure(0.0, 0.5, -1.0), "time of exposure must be zero or positive"),
        (lambda: Exposure(0.0, 0.5, np.inf), "time of exposure"),
    ],
)
def test_impossible_states(build: object, said: str) -> None:
    with pytest.raises(InputError, match=said):
        build()  # type: ignore[operator]


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ('wet_thermal_expansion = "1e-6 1/K"', "wet_thermal_expansion is given without"),
        ('activation_energy = "45 kJ/mol"', "activation_energy is given without diffusivity"),
        ('glass_transition = "210 K/s"', "materials.resin.glass_transition"),
        ('equilibrium_moisture = "120 %"', "materials.resin.equilibrium_moisture"),
        ('moisture_expansion = "-1 1/percent"', "materials.resin.moisture_expansion"),
        ('diffusivity = "0 m^2/s"', "materials.resin.diffusivity"),
        ('thermal_expansion = "5 mm"', "materials.resin.thermal_expansion"),
        ('glas_transition = "210 degC"', "did you mean 'glass_transition'"),
    ],
)
def test_wrong_keys_are_named(keys: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        model(materials={"resin": STEEL + keys, "steel": STEEL})


def test_temperatures_on_their_scales() -> None:
    assert model(
        environment='[environment]\nreference_temperature = "68 degF"'
    ).reference_temperature == (pytest.approx(293.15))
    assert model().reference_temperature == 293.15


def test_coupler_point_of_a_model_file() -> None:
    found = model(ground='coupler_point = { distance = "5 cm", angle = "90 deg" }').coupler_point
    assert found is not None
    assert found.distance == pytest.approx(0.05)
    assert found.angle == pytest.approx(np.pi / 2)
