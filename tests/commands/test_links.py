"""``flexmech section``, ``moisture`` and ``strength``: what is known of the links."""

from __future__ import annotations

import numpy as np
import pytest

import flexmech
from tests.support.command import MODELS
from tests.support.journeys import Journey, tells

COMPOSITE = "models/composite_fourbar.toml"
WET = MODELS.parent / "tests/data/wet_four_bar.toml"
DAY = 86400.0


@pytest.fixture(scope="module")
def sections(tmp_path_factory):
    folder = tmp_path_factory.mktemp("section") / "out"
    return Journey(folder, "section", COMPOSITE, "--no-plots")


def test_section_files_hold_what_was_printed_and_load_back(sections):
    data = ["sections.csv", "sections.nc", "summary.txt", "through_thickness.csv"]
    assert sections.ended.files == data
    sections.result()


def test_numbers_of_sections_are_those_of_the_layers(sections):
    """The coupler [C*4/G*4]: B bends it in tension, and about its pins EI is more than its own."""
    found = sections.table("sections")
    rows = {key: row for row, key in enumerate(zip(found["link"], found["coupling"], strict=True))}
    assert list(rows) == [
        (link, coupling)
        for link in ("crank", "coupler", "rocker")
        for coupling in ("with", "without")
    ]
    at = rows["coupler", "with"]
    carbon, glass, width, layer = 121.872e9, 43.1e9, 0.02, 1e-3
    plies = flexmech.load_mechanism(MODELS / "composite_fourbar.toml").sections["coupler"].layers
    carbon, glass = (plies.laminate.layers[i].ply.longitudinal_modulus for i in (0, -1))
    ea = width * 4 * layer * (carbon + glass)
    # First and second moments of the stack about the pins' axis.
    eb = width * (glass - carbon) * (4 * layer) ** 2 / 2
    ei = width * (glass + carbon) * (4 * layer) ** 3 / 3
    expected = {
        "axial_stiffness_N": ea,
        "coupling_stiffness_Nm": -eb,
        "neutral_axis_m": eb / ea,
        "bending_stiffness_Nm2": ei - eb**2 / ea,
        "membrane_modulus_Pa": (carbon + glass) / 2,
    }
    for name, value in expected.items():
        assert abs(found[name][at]) == pytest.approx(abs(value), rel=1e-8), name
    assert found["neutral_axis_m"][at] == pytest.approx(eb / ea, rel=1e-8)
    assert found["bending_stiffness_Nm2"][rows["coupler", "without"]] == pytest.approx(ei)
    assert sections.number("bending_stiffness", "coupler") == pytest.approx(ei - eb**2 / ea)
    left = 100 * (ei - eb**2 / ea) / ei
    assert tells(sections.answer, float(f"{left:.3g}"))
    assert tells(sections.answer, float(f"{-1e3 * eb / ea:.4g}"))


@pytest.mark.parametrize("link", ["crank", "coupler", "rocker"])
def test_stresses_through_the_thickness_balance_the_unit_loads(link, sections):
    found = sections.table("through_thickness")
    here = (found["link"] == link) & (found["coupling"] == "with")
    for load, expected in (
        ("axial_force", (1, 0, 0)),
        ("bending_moment", (0, 1, 0)),
        ("shear_force", (0, 0, 1)),
    ):
        sums = np.zeros(3)
        for layer in set(found["layer"][here]):
            rows = here & (found["load"] == load) & (found["layer"] == layer)
            y, stress = found["y_m"][rows], found["normal_stress_Pa"][rows]
            # Simpson's rule, exact for all that is integrated here.
            weights = np.ones(y.size)
            weights[1:-1:2], weights[2:-1:2] = 4, 2
            weights *= 0.02 * (y[1] - y[0]) / 3
            sums += weights @ np.stack([stress, -stress * y, found["shear_stress_Pa"][rows]]).T
        assert sums == pytest.approx(expected, abs=1e-7)


def test_without_coupling_a_force_stretches_and_does_not_bend(sections):
    found = sections.table("through_thickness")
    rows = (found["link"] == "coupler") & (found["load"] == "axial_force")
    bent, straight = (
        np.polyfit(found["y_m"][own], found["strain"][own], 1)[0]
        for own in (rows & (found["coupling"] == which) for which in ("with", "without"))
    )
    axis = sections.number("neutral_axis", "coupler") * 1e-3
    assert bent == pytest.approx(-axis / sections.number("bending_stiffness", "coupler"), rel=1e-7)
    assert straight == pytest.approx(0, abs=1e-9 * abs(bent))


def test_a_rectangle_has_cowpers_factor_and_a_general_section_nothing_inside(tmp_path):
    steel = Journey(tmp_path / "steel", "section", "models/steel_fourbar.toml", "--link", "crank")
    found = steel.table("sections")
    assert set(found["link"]) == {"crank"}
    assert found["shear_correction"] == pytest.approx(10 * 1.3 / (12 + 11 * 0.3))
    assert found["flexural_modulus_Pa"] == pytest.approx(200e9)
    # The greatest shear stress of a rectangle is 3/2 of the mean.
    inside = steel.table("through_thickness")["shear_stress_Pa"].max()
    assert inside == pytest.approx(1.5 / (4.25e-3 * 6.1e-3))
    slender = Journey(tmp_path / "arm", "section", "models/rotating_arm_slender_70.toml")
    assert slender.ended.files == ["sections.csv", "sections.nc", "summary.txt"]
    assert slender.table("sections")["axial_stiffness_N"] == pytest.approx(4900)
    assert np.isnan(slender.table("sections")["shear_correction"]).all()


def test_heat_and_water_soften_a_section(command):
    folders = []
    for state in ((), ("--temperature-rise", "40", "--moisture", "5")):
        ended = command("section", WET, "--link", "coupler", "--no-plots", *state)
        folders.append(ended.table("sections")["axial_stiffness_N"][0])
    assert folders[1] < 0.9 * folders[0]


def test_sections_of_layers_are_drawn(command, rough_pictures):
    ended = command("section", COMPOSITE, "--link", "rocker")
    assert [name for name in ended.files if name.endswith(".png")] == ["section_rocker.png"]


# --- moisture -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def moisture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("moisture") / "out"
    air = ("--relative-humidity", "85", "--time", "20 day", "--temperature", "40")
    return Journey(folder, "moisture", WET, *air, "--no-plots")


def slab(time, thickness, diffusivity):
    """Uptake of a slab that is wet on both faces, over that in the end (Crank, eq. 4.18)."""
    odd = 2 * np.arange(400) + 1
    rate = diffusivity * (odd * np.pi / thickness) ** 2
    return 1 - (8 / (odd * np.pi) ** 2 * np.exp(-rate * np.reshape(time, (-1, 1)))).sum(axis=1)


def test_uptake_is_that_of_ficks_law(moisture):
    """A slab that is sealed on one face is half of one twice as thick."""
    found = moisture.table("moisture_uptake")
    assert list(dict.fromkeys(found["link"])) == ["coupler", "rocker"]
    for link, thickness in (("coupler", 12e-3), ("rocker", 6e-3)):
        rows = found["link"] == link
        exact = slab(found["time_s"][rows], thickness, 6e-13)
        np.testing.assert_allclose(found["uptake"][rows][1:], exact[1:], atol=1e-4)
        wet = found["moisture_percent"][rows][1:]
        np.testing.assert_allclose(wet, 7 * 0.85 * exact[1:], atol=1e-3)
        assert moisture.number("uptake", link) == pytest.approx(100 * exact[-1], abs=0.01)
        # 99 % of it, at the printed time.
        time = moisture.number("time_to_saturation", link) * DAY
        assert slab(time, thickness, 6e-13) == pytest.approx(0.99, abs=1e-6)


def test_the_water_stands_highest_at_the_open_face(moisture):
    found = moisture.table("moisture_profile")
    last = (found["link"] == "coupler") & (found["time_s"] == 20 * DAY)
    profile = found["moisture_percent"][last]
    assert profile[0] == pytest.approx(7 * 0.85, abs=0.03)
    assert (np.diff(profile) < 1e-9).all()


def test_moisture_files_hold_what_was_printed_and_load_back(moisture):
    csv = ["moisture_profile.csv", "moisture_uptake.csv"]
    assert moisture.ended.files == ["moisture.nc", *csv, "summary.txt"]
    data = moisture.result().dataset
    assert float(data["mass_balance_error"].max()) < 1e-12
    uptake = 100 * data["uptake"].sel(link="rocker").values[-1]
    assert tells(moisture.said["answer"][0], round(uptake, 2))


@pytest.mark.thorough
def test_water_through_the_sides_enters_by_the_product_of_two_slabs(tmp_path):
    model = tmp_path / "sides.toml"
    text = WET.read_text(encoding="utf-8")
    model.write_text(text.replace('exposed_faces = "lower"', "exposed_sides = true"))
    air = ("--relative-humidity", "100", "--time", "20 day")
    journey = Journey(tmp_path / "out", "moisture", model, *air, "--link", "coupler", "--no-plots")
    found = journey.table("moisture_uptake")
    left = (1 - slab(found["time_s"], 6e-3, 6e-13)) * (1 - slab(found["time_s"], 10e-3, 6e-13))
    np.testing.assert_allclose(found["uptake"][3:], 1 - left[3:], atol=1e-3)
    apart = np.abs(found["uptake"] - 1 + left)[1:]
    estimated = journey.result().dataset["uptake_error"].values[0, 1:]
    assert (apart < 2 * np.maximum(estimated, 1e-7)).all()
    assert estimated.max() < 3 * apart.max()
    assert np.isnan(found["shen_springer_uptake"]).all()


# --- strength -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def strength(tmp_path_factory):
    folder = tmp_path_factory.mktemp("strength") / "out"
    words = ("--speed", "20", "--elements", "2", "--angles", "0:345:15", "--no-plots")
    return Journey(folder, "strength", COMPOSITE, *words)


def test_strength_files_hold_what_was_printed_and_load_back(strength):
    csv = ["internal_forces.csv", "margins.csv", "strength.csv"]
    assert strength.ended.files == [*csv, "strength.nc", "summary.txt"]
    strength.result()


def test_a_margin_is_the_least_load_factor_of_its_link(strength):
    """The factor multiplies the stresses of the loads up to failure."""
    places, margins = strength.table("strength"), strength.table("margins")
    for row, link in enumerate(margins["part"]):
        least = places["load_factor"][places["link"] == link].min()
        assert margins["load_factor"][row] == pytest.approx(least, rel=1e-9)
    assert (np.diff(margins["load_factor"]) >= 0).all()
    assert margins["part"][0] in strength.said["answer"][0]
    assert tells(strength.answer, float(f"{margins['load_factor'][0]:.3g}"))


def test_an_arm_that_carries_its_own_inertia_has_the_forces_of_a_bar(tmp_path):
    """At constant speed: N(x) = rho A omega^2 (L^2 - x^2) / 2, and no moment."""
    words = ("--speed", "20", "--angles", "0,90", "--elements", "8", "--no-plots")
    model = tmp_path / "arm.toml"
    text = (MODELS / "rotating_arm.toml").read_text(encoding="utf-8")
    model.write_text(
        text.replace("poisson_ratio", 'yield_strength = "200 MPa"\npoisson_ratio', 1),
        encoding="utf-8",
    )
    found = Journey(tmp_path / "out", "strength", model, *words).table("internal_forces")
    arm = flexmech.load_mechanism(model)
    mass, length = arm.sections["arm"].mass_per_length, arm.linkage.length
    hub = arm.linkage.hub_radius
    place = found["position_m"]
    exact = mass * 400 * ((length - place) * hub + (length**2 - place**2) / 2)
    np.testing.assert_allclose(found["axial_force_N"], exact, rtol=1e-6, atol=1e-6 * exact.max())
    assert np.abs(found["bending_moment_Nm"]).max() < 1e-9 * exact.max()
