"""Endurance by hand: Goodman's line, Basquin's, Miner's sum, rainflow counting, arms that turn."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import flexmech
from flexmech import (
    BeamSection,
    FatigueStrength,
    InputError,
    Laminate,
    LaminateSection,
    Load,
    Material,
    Mechanism,
    Ply,
    RotatingArm,
    Strength,
    strength,
)
from flexmech.analyses import StrengthRequest
from flexmech.linkages import AttachmentPoint
from flexmech.materials import Layer, ply_in_state
from flexmech.modelfile import mechanism_from_toml
from tests.support.command import MODELS

STEEL = FatigueStrength(565e6, 280e6, 1e6, -0.085)


def test_goodman_by_hand() -> None:
    amplitude, mean = np.full(3, 100e6), np.array([200e6, -2e8, 6e8])
    found = STEEL.equivalent_amplitude(amplitude, mean)
    np.testing.assert_allclose(found[:2], [100e6 / (1 - 200 / 565), 100e6], rtol=1e-14)
    assert np.isinf(found[2])
    # Stress from 100 to 300 MPa: mean 200, amplitude 100.
    factor = STEEL.load_factor(np.array(300e6), np.array(100e6))
    assert float(factor) == pytest.approx(1 / (100 / 280 + 200 / 565), rel=1e-14)
    # On the line the equivalent amplitude is the endurance limit.
    on = STEEL.equivalent_amplitude(factor * 100e6, factor * 200e6)
    assert float(on) == pytest.approx(280e6, rel=1e-12)
    # Compression is no relief: from -300 to -100 as from -100 to 100.
    pressed = STEEL.load_factor(np.array(-100e6), np.array(-300e6))
    assert float(pressed) == pytest.approx(2.8, rel=1e-14)


def test_basquin_by_hand() -> None:
    """Ten times the life at 10**-0.085 of the amplitude; two points give the same line."""
    assert float(STEEL.cycles(np.array(280e6 * 10**0.085))) == pytest.approx(1e5, rel=1e-12)
    points = ((1e3, 280e6 * 1e3**0.085), (1e6, 280e6))
    same, sizes = FatigueStrength(565e6, sn_points=points), np.geomspace(100e6, 500e6, 7)
    np.testing.assert_allclose(same.cycles(sizes), STEEL.cycles(sizes), rtol=1e-12)


def test_miner_by_hand() -> None:
    high, low = 280e6 * 10**0.085, 280e6 * 10**-0.085  # 1e5 and 1e7 cycles by the line
    # In a turn one high cycle and fifty low ones: the low ones count, since the high one is above
    # the limit. 1 / (1/1e5 + 50/1e7).
    sizes, zero, count = np.array([high, low]), np.zeros(2), np.array([1.0, 50.0])
    assert STEEL.turns_to_failure(sizes, zero, count) == pytest.approx(1 / 1.5e-5, rel=1e-12)
    assert STEEL.turns_to_failure(sizes[1:], zero[1:], count[1:]) == np.inf
    without = FatigueStrength(565e6, sn_points=((1e5, high), (1e7, low)))
    assert without.turns_to_failure(sizes[1:], zero[1:], count[1:]) == pytest.approx(2e5, rel=1e-12)
    unknown = replace(STEEL, basquin_exponent=None)
    assert np.isnan(unknown.turns_to_failure(sizes, zero, count))
    # A mean stress of the tensile strength breaks it at once.
    assert STEEL.turns_to_failure(sizes[:1], np.array([565e6]), count[:1]) == 0.0


LENGTH, HEIGHT, WIDTH, SPEED, GRAVITY, DENSITY = 0.5, 10e-3, 20e-3, 600.0, 9.81, 7800.0
AREA = HEIGHT * WIDTH
MASS = DENSITY * AREA * LENGTH
# At the root: tension of the rotation, and what gravity adds along and across the arm.
MEAN = DENSITY * (SPEED * LENGTH) ** 2 / 2
SWING = np.hypot(MASS * GRAVITY / AREA, (MASS * GRAVITY * LENGTH / 2) * 6 / (WIDTH * HEIGHT**2))
ANGLES = np.linspace(0.0, 2 * np.pi, 721)


def arm_of(fatigue: FatigueStrength, **others: Any) -> Mechanism:
    material = Material(200e9, DENSITY, yield_strength=1e9, fatigue=fatigue)
    section = BeamSection.rectangle(material, HEIGHT, WIDTH)
    return Mechanism(RotatingArm(LENGTH), {"arm": section}, **others)


def at_root(fatigue: FatigueStrength, speed: float = SPEED) -> dict[str, np.ndarray]:
    """Numbers of both surfaces at the root of an arm that turns under its weight."""
    arm = arm_of(fatigue, gravity=(0.0, -GRAVITY))
    request = StrengthRequest(speed, crank_angles=ANGLES, source="rigid")
    rows = strength(arm, request).tables()["endurance"]
    return {str(name): values[:2].to_numpy() for name, values in rows.items()}


def test_both_surfaces_of_the_root_swing_by_the_weight_about_the_tension() -> None:
    found = at_root(STEEL)
    # Sampled in steps of half a degree, the peak is missed by 1e-5 of the swing at most.
    np.testing.assert_allclose(found["stress_amplitude_Pa"], SWING, rtol=1e-5)
    np.testing.assert_allclose(found["mean_stress_Pa"], MEAN, rtol=1e-8)
    expected = 1 / (SWING / 280e6 + MEAN / 565e6)
    np.testing.assert_allclose(found["load_factor"], expected, rtol=1e-6)
    np.testing.assert_array_equal(found["cycles_per_turn"], 1.0)
    # While the arm points right its weight stretches the upper surface, pointing left the lower.
    lower, upper = np.radians(found["crank_angle_deg"])
    along = np.arctan2(MASS * GRAVITY / AREA, np.sqrt(SWING**2 - (MASS * GRAVITY / AREA) ** 2))
    assert upper == pytest.approx(2 * np.pi - along, abs=5e-3)
    assert lower == pytest.approx(np.pi + along, abs=5e-3)


def test_speed_factor_of_an_arm_under_its_weight() -> None:
    """The weight stays as the speed rises: S_a/S_e + s^2 S_m/S_u = 1."""
    expected = np.sqrt((1 - SWING / 280e6) * 565e6 / MEAN)
    np.testing.assert_allclose(at_root(STEEL)["speed_factor"], expected, rtol=1e-6)
    weak = FatigueStrength(565e6, 0.99 * SWING, 1e6)
    np.testing.assert_array_equal(at_root(weak)["speed_factor"], 0.0)


def test_turns_of_an_arm_under_its_weight() -> None:
    """One cycle a turn of the equivalent amplitude: Basquin's line says how many."""
    limit = 0.25 * SWING
    own = FatigueStrength(MEAN * 2, limit, 1e7, -0.1)
    expected = 1e7 * (SWING / (1 - 1 / 2) / limit) ** (-1 / 0.1)
    np.testing.assert_allclose(at_root(own)["turns_to_failure"], expected, rtol=2e-4)
    np.testing.assert_array_equal(at_root(STEEL)["turns_to_failure"], np.inf)
    line = FatigueStrength(MEAN * 2, sn_points=((1e5, limit * 100**0.1), (1e7, limit)))
    np.testing.assert_allclose(at_root(line)["turns_to_failure"], expected, rtol=2e-4)
    # Without an endurance limit the load factor is to the last point of the line.
    for name in ("load_factor", "speed_factor"):
        np.testing.assert_array_equal(at_root(line)[name], at_root(own)[name])
    unknown = at_root(replace(own, basquin_exponent=None))
    assert np.isnan(unknown["turns_to_failure"]).all()


def test_rainflow_example_of_the_standard() -> None:
    """ASTM E1049-85, secs. 5.4.4 and 5.4.5: the history as a pull on a slow arm, turn after turn.

    It repeats with ranges of 3, 4, 7 and 9 once each, of means -1/2, 1, 1/2 and 1/2.
    """
    history, unit = np.array([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0]), 20e6
    own = FatigueStrength(565e6, 40e6, 1e6, -0.1)
    force = tuple((unit * AREA * size, 0.0) for size in history)
    places = tuple(np.radians(45.0 * np.arange(8)).tolist())
    tip = AttachmentPoint("arm", LENGTH)
    pull = Load("pull", tip, force, (0.0,) * 8, "link", "crank_angle", places)
    request = StrengthRequest(
        1e-3, crank_angles=np.radians(np.arange(0.0, 361.0, 15.0)), source="rigid"
    )
    row = strength(arm_of(own, loads=(pull,)), request).tables()["endurance"].iloc[0]
    amplitude, mean = unit * np.array([1.5, 2.0, 3.5, 4.5]), unit * np.array([-0.5, 1.0, 0.5, 0.5])
    assert row["stress_amplitude_Pa"] == pytest.approx(amplitude[3], rel=1e-9)
    assert row["mean_stress_Pa"] == pytest.approx(mean[3], rel=1e-6)
    assert row["cycles_per_turn"] == 4
    equivalent = amplitude / (1 - np.maximum(mean, 0.0) / 565e6)
    damage = np.sum((equivalent / 40e6) ** 10.0) / 1e6
    assert row["turns_to_failure"] == pytest.approx(1 / damage, rel=1e-6)


def test_greatest_and_least_stress_decide_and_a_history_at_its_factor_is_borne_for_ever() -> None:
    sizes, means, count = np.array([90e6, 30e6]), np.array([40e6, 70e6]), np.ones(2)
    factor = float(STEEL.load_factor(np.array(130e6), np.array(-50e6)))
    assert factor == pytest.approx(1 / (90 / 280 + 40 / 565), rel=1e-12)
    for part, forever in ((1 - 1e-9, True), (1 + 1e-9, False)):
        scale = part * factor
        assert np.isinf(STEEL.turns_to_failure(scale * sizes, scale * means, count)) == forever


def test_a_hot_resin_endures_less_and_a_metal_as_much() -> None:
    mechanism = flexmech.load_mechanism(MODELS / "neat_resin_figure_8.toml")
    neat = mechanism.sections["coupler"].layers.laminate.layers[0].ply.isotropic_material
    own = FatigueStrength(60e6, 15e6, 1e7, -0.1)
    ply = Ply.isotropic(replace(neat, fatigue=own))
    hot = ply_in_state(ply, 333.15, 0.0, 293.15)
    kept = hot.longitudinal_modulus / ply.longitudinal_modulus
    assert kept < 0.99
    # All stresses are as much smaller: a smaller stress lives as long as the old one did.
    for amplitude, mean in ((20e6, 0.0), (10e6, 30e6)):
        stress = kept * np.array(amplitude), kept * np.array(mean)
        then = hot.fatigue.cycles(hot.fatigue.equivalent_amplitude(*stress))
        dry = own.cycles(own.equivalent_amplitude(np.array(amplitude), np.array(mean)))
        np.testing.assert_allclose(then, dry, rtol=1e-10)
    metal = Ply.isotropic(Material(70e9, 2700.0, fatigue=STEEL))
    assert ply_in_state(metal, 373.0, 0, 293.0).fatigue == STEEL


ALUMINIUM = (MODELS / "aluminium_fourbar.toml").read_text(encoding="utf-8")
BY_EXPONENT = """
[materials.aluminium.fatigue]
tensile_strength = "310 MPa"
endurance_limit = "97 MPa"
endurance_cycles = 5e8
basquin_exponent = -0.09
"""
BY_POINTS = """
[materials.aluminium.fatigue]
tensile_strength = "310 MPa"
sn_points = [{ cycles = 1e4, amplitude = "231.7 MPa" }, { cycles = 5e8, amplitude = "97 MPa" }]
"""


def with_fatigue(text: str) -> Mechanism:
    return mechanism_from_toml(ALUMINIUM.replace("[links.crank]\n", f"{text}\n[links.crank]\n", 1))


@pytest.mark.parametrize("text", [BY_EXPONENT, BY_POINTS])
def test_fatigue_is_read_written_and_read_back(text: str) -> None:
    mechanism = with_fatigue(text)
    for link, known in (("coupler", True), ("rocker", True), ("crank", False)):
        fatigue = mechanism.sections[link].layers.laminate.layers[0].ply.fatigue
        assert (fatigue is not None) == known
        assert not known or fatigue.tensile_strength == 310e6
    assert mechanism_from_toml(mechanism.to_toml()) == mechanism


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BY_EXPONENT.replace("endurance_cycles = 5e8\n", ""), "belong together"),
        (BY_EXPONENT.replace("-0.09", "0.09"), "basquin_exponent: must lie between -1 and 0"),
        (BY_EXPONENT.replace('"310 MPa"', '"90 MPa"'), "less than tensile_strength"),
        (BY_EXPONENT + BY_POINTS.splitlines()[-1], "keep one of them"),
        (BY_POINTS.replace("5e8", "5e3"), "more cycles and a smaller amplitude"),
        (BY_POINTS.replace('"97 MPa"', '"97 mm"'), r"sn_points\[1\].amplitude"),
        (BY_POINTS.replace(', { cycles = 5e8, amplitude = "97 MPa" }', ""), "give one more"),
    ],
)
def test_wrong_fatigue_is_refused_by_its_key(text: str, words: str) -> None:
    with pytest.raises(InputError, match=r"materials\.aluminium\.fatigue") as refused:
        with_fatigue(text)
    assert refused.match(words)


def test_margins_of_fatigue_stand_beside_those_of_yield_and_are_read_back(tmp_path) -> None:
    fast = StrengthRequest(1200.0, speed_unit="rpm", source="rigid")
    found = strength(with_fatigue(BY_EXPONENT), fast)
    margins = found.tables()["margins"].set_index(["kind", "part"])
    for link, rows in found.tables()["endurance"].groupby("link"):
        worst, margin = rows.loc[rows["load_factor"].idxmin()], margins.loc[("fatigue", link)]
        factor = 1 / (worst["stress_amplitude_Pa"] / 97e6 + worst["mean_stress_Pa"] / 310e6)
        assert margin["load_factor"] == pytest.approx(factor, rel=1e-12)
        # Inertia alone: loads go with the square of the speed.
        assert margin["speed_factor"] == pytest.approx(np.sqrt(factor), rel=1e-9)
    turns = float(found.dataset["turns_to_failure"].sel(link="coupler").min())
    assert f"it fails after {turns:.3g} turns" in found.summary().answer[1]
    found.save(tmp_path)
    again = Strength.load(tmp_path / "strength.nc")
    xr.testing.assert_identical(again.dataset, found.dataset)


def test_links_whose_fatigue_is_not_judged_are_told_with_the_reason() -> None:
    tough = Ply.isotropic(Material(70e9, 2700.0, yield_strength=240e6, fatigue=STEEL))
    other = Ply.isotropic(Material(200e9, 7800.0, yield_strength=240e6, fatigue=STEEL))
    layers = Layer(tough, 1e-3), Layer(other, 2e-3)
    mechanism = with_fatigue(BY_EXPONENT)
    mixed = BeamSection.of_laminate(LaminateSection(Laminate(layers), 20e-3))
    push = Load("push", AttachmentPoint("crank", 0.05), ((1.0, 0.0),))
    timed = replace(push, force=((1.0, 0.0),) * 2, torque=(0.0,) * 2, over="time", at=(0.0, 1.0))
    sections = {**mechanism.sections, "coupler": mixed}
    rigid = StrengthRequest(20.0, source="rigid")
    part = StrengthRequest(20.0, crank_angles=np.radians([0.0, 5.0, 10.0]), search_speed=False)
    coarse = replace(rigid, crank_angles=np.radians([0.0, 90.0, 180.0, 270.0]))
    for model, asked, words in (
        (replace(mechanism, sections=sections), rigid, "fatigue of composite links .*: coupler"),
        (mechanism, part, "do not cover a turn"),
        (mechanism, replace(part, source="rigid"), "do not cover a turn"),
        (mechanism, coarse, "steps of 30 deg"),
        (replace(mechanism, loads=(timed,)), rigid, "loads over time.*: push"),
    ):
        left_out = strength(model, asked).dataset.attrs["fatigue_left_out"]
        assert re.search(words, left_out), left_out


@pytest.mark.thorough
def test_periodic_runs_are_judged_by_their_own_stress() -> None:
    """A sixth of its lowest frequency makes the bending of an arm 1/35 larger."""
    strong = with_fatigue(BY_EXPONENT).sections["rocker"].with_damping_ratio(0.02, frequency=40.0)
    arm = Mechanism(RotatingArm(0.3), {"arm": strong}, gravity=(0.0, -9.81))
    asked = StrengthRequest(15.0, source="periodic", search_speed=False)
    found = strength(flexmech.ReferenceEngine(arm, elements=2), asked)
    still = strength(arm, replace(asked, source="rigid"))
    running, at_rest = (float(one.dataset["stress_amplitude"].max()) for one in (found, still))
    assert running == pytest.approx(at_rest * (1 + 1 / 35), rel=0.01)
