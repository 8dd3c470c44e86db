"""Endurance by hand: Goodman's line, rainflow counting of ASTM's examples, arms that turn."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from flexmech.analyses.strength.endurance import (
    Endurance,
    counted_cycles,
    cycles_of_turn,
    endurance,
)
from flexmech.analyses.strength.forces import cuts_of, forces_over_the_turn, internal_forces
from flexmech.linkages import RotatingArm
from flexmech.materials import FatigueStrength, Laminate, Layer, Material, Ply
from flexmech.mechanism import Mechanism
from flexmech.sections import BeamSection, LaminateSection

STEEL = FatigueStrength(565e6, 280e6, 1e6, -0.085)
# E1049-85, figure 6: the history of the worked example of section 5.4.4.
ASTM = np.array([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0])


def ranges(cycles: tuple[np.ndarray, np.ndarray, np.ndarray]) -> dict[float, float]:
    amplitude, _, count = cycles
    found: Counter[float] = Counter()
    for size, number in zip(amplitude.tolist(), count.tolist(), strict=True):
        found[2 * size] += number
    return dict(sorted(found.items()))


# --- cycles -------------------------------------------------------------------------------------


def test_rainflow_example_of_the_standard() -> None:
    """ASTM E1049-85, section 5.4.4, table of figure 6."""
    assert ranges(counted_cycles(ASTM)) == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


def test_rainflow_of_a_history_that_repeats() -> None:
    """Section 5.4.5: the same history, turn after turn, has whole cycles alone."""
    whole = {3.0: 1.0, 4.0: 1.0, 7.0: 1.0, 9.0: 1.0}
    turn = ASTM[:-1]
    for start in range(len(turn)):
        assert ranges(cycles_of_turn(np.roll(turn, start))) == whole
    # From the greatest peak to the deepest trough: mean 1/2.
    amplitude, mean, _ = cycles_of_turn(turn)
    np.testing.assert_array_equal(mean[amplitude == 4.5], 0.5)
    # Points between the turning points, and points twice, change nothing.
    finer = np.interp(np.arange(0, 8, 0.25), np.arange(9), ASTM)
    assert ranges(cycles_of_turn(np.repeat(finer, 2))) == whole


def test_no_cycles_where_nothing_moves() -> None:
    for still in (np.full(9, 3e6), 3e6 + 1e-7 * ASTM, np.zeros(9)):
        amplitude, _, _ = cycles_of_turn(still)
        assert amplitude.size == 0
    assert ranges(counted_cycles(np.array([1.0, 3.0]))) == {2.0: 0.5}


# --- Goodman, Basquin, Miner --------------------------------------------------------------------


def test_goodman_by_hand() -> None:
    found = STEEL.equivalent_amplitude(
        np.array([100e6, 100e6, 100e6]), np.array([200e6, -2e8, 6e8])
    )
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
    same = FatigueStrength(565e6, sn_points=points)
    sizes = np.geomspace(100e6, 500e6, 7)
    np.testing.assert_allclose(same.cycles(sizes), STEEL.cycles(sizes), rtol=1e-12)


def test_miner_by_hand() -> None:
    high, low = 280e6 * 10**0.085, 280e6 * 10**-0.085  # 1e5 and 1e7 cycles by the line
    sizes, zero = np.array([high, low]), np.zeros(2)
    # In a turn one high cycle and fifty low ones: the low ones count, since the high one is above
    # the limit. 1 / (1/1e5 + 50/1e7).
    count = np.array([1.0, 50.0])
    assert STEEL.turns_to_failure(sizes, zero, count) == pytest.approx(1 / 1.5e-5, rel=1e-12)
    assert STEEL.turns_to_failure(sizes[1:], zero[1:], count[1:]) == np.inf
    without = FatigueStrength(565e6, sn_points=((1e5, high), (1e7, low)))
    assert without.turns_to_failure(sizes[1:], zero[1:], count[1:]) == pytest.approx(2e5, rel=1e-12)
    unknown = replace(STEEL, basquin_exponent=None)
    assert np.isnan(unknown.turns_to_failure(sizes, zero, count))
    assert unknown.turns_to_failure(sizes[1:], zero[1:], count[1:]) == np.inf
    # A mean stress of the tensile strength breaks it at once.
    assert STEEL.turns_to_failure(sizes[:1], np.array([565e6]), count[:1]) == 0.0


def test_greatest_and_least_stress_decide_among_all_cycles() -> None:
    """The load factor is the least of those of all counted cycles, whatever the history."""
    random = np.random.default_rng(3)
    for offset in (-300e6, -20e6, 0.0, 40e6, 200e6):
        stress = offset + 60e6 * random.standard_normal(72)
        amplitude, mean, count = cycles_of_turn(stress)
        by_cycle = 1 / (amplitude / 280e6 + np.maximum(mean, 0) / 565e6)
        found = STEEL.load_factor(stress.max(), stress.min())
        assert float(found) == pytest.approx(by_cycle.min(), rel=1e-12)
        # At its factor a history is just borne for ever; a little above, it has a finite life.
        for part, forever in ((1 - 1e-9, True), (1 + 1e-9, False)):
            scale = part * float(found)
            turns = STEEL.turns_to_failure(scale * amplitude, scale * mean, count)
            assert np.isinf(turns) == forever


# --- links --------------------------------------------------------------------------------------

LENGTH, HEIGHT, WIDTH, SPEED, GRAVITY = 0.5, 10e-3, 20e-3, 600.0, 9.81
DENSITY = 7800.0
AREA = HEIGHT * WIDTH
MASS = DENSITY * AREA * LENGTH
# At the root: tension of the rotation, and what gravity adds along and across the arm.
MEAN = DENSITY * (SPEED * LENGTH) ** 2 / 2
SWING = np.hypot(MASS * GRAVITY / AREA, (MASS * GRAVITY * LENGTH / 2) * 6 / (WIDTH * HEIGHT**2))
ANGLES = np.linspace(0.0, 2 * np.pi, 3601)


def of_arm(fatigue: FatigueStrength, speed: float = SPEED) -> Endurance:
    material = Material(200e9, DENSITY, fatigue=fatigue)
    section = BeamSection.rectangle(material, HEIGHT, WIDTH)
    arm = Mechanism(RotatingArm(LENGTH), {"arm": section}, gravity=(0.0, -GRAVITY))
    cuts = cuts_of(arm, "arm", 8)
    loads, still = (
        internal_forces(forces_over_the_turn(arm, ANGLES, each), 0, cuts).loads
        for each in (speed, 0.0)
    )
    assert section.layers is not None
    return endurance(section.layers, fatigue, ANGLES, loads, still)


def test_arm_that_turns_under_its_weight() -> None:
    """Both surfaces of the root swing once a turn by the weight, about the tension."""
    found = of_arm(STEEL)
    root = 0, 0
    # Sampled in steps of a tenth of a degree, the peak is missed by 4e-7 of the swing at most.
    np.testing.assert_allclose(found.amplitude[root], SWING, rtol=1e-6)
    np.testing.assert_allclose(found.mean[root], MEAN, rtol=1e-8)
    expected = 1 / (SWING / 280e6 + MEAN / 565e6)
    np.testing.assert_allclose(found.load_factor[root], expected, rtol=1e-7)
    np.testing.assert_array_equal(found.cycles[root], 1.0)
    assert found.load_factor.min() == found.load_factor[root].min()
    # While the arm points right its weight stretches the upper surface, pointing left the lower.
    lower = ANGLES[found.peak[0, 0, 0]]
    upper = ANGLES[found.peak[0, 0, 1]]
    along = np.arctan2(MASS * GRAVITY / AREA, np.sqrt(SWING**2 - (MASS * GRAVITY / AREA) ** 2))
    assert upper == pytest.approx(2 * np.pi - along, abs=2e-3)
    assert lower == pytest.approx(np.pi + along, abs=2e-3)


def test_speed_factor_of_an_arm_under_its_weight() -> None:
    """The weight stays as the speed rises: S_a/S_e + s^2 S_m/S_u = 1; alone, the tension's root."""
    found = of_arm(STEEL)
    expected = np.sqrt((1 - SWING / 280e6) * 565e6 / MEAN)
    np.testing.assert_allclose(found.speed_factor[0, 0], expected, rtol=1e-7)
    weak = FatigueStrength(565e6, 0.99 * SWING, 1e6)
    np.testing.assert_array_equal(of_arm(weak).speed_factor[0, 0], 0.0)
    at_rest = of_arm(STEEL, 0.0).speed_factor[0, 0]
    assert np.isinf(at_rest).all()


def test_turns_of_an_arm_under_its_weight() -> None:
    """One cycle a turn of the equivalent amplitude: Basquin's line says how many."""
    limit = 0.25 * SWING
    own = FatigueStrength(MEAN * 2, limit, 1e7, -0.1)
    equivalent = SWING / (1 - 1 / 2)
    expected = 1e7 * (equivalent / limit) ** (-1 / 0.1)
    np.testing.assert_allclose(of_arm(own).turns[0, 0], expected, rtol=1e-4)
    np.testing.assert_array_equal(of_arm(STEEL).turns[0, 0], np.inf)
    line = FatigueStrength(MEAN * 2, sn_points=((1e5, limit * 100**0.1), (1e7, limit)))
    found = of_arm(line)
    np.testing.assert_allclose(found.turns[0, 0], expected, rtol=1e-4)
    # Without an endurance limit the load factor is to the last point of the line.
    np.testing.assert_array_equal(found.load_factor, of_arm(own).load_factor)
    np.testing.assert_array_equal(found.speed_factor, of_arm(own).speed_factor)
    calm = replace(line, sn_points=((1e5, SWING * 900), (1e7, SWING * 300)), tensile_strength=1e12)
    assert (of_arm(calm).load_factor > 100).all()
    assert np.isfinite(of_arm(calm).turns[0, 0]).all()
    unknown = of_arm(replace(own, basquin_exponent=None))
    assert np.isnan(unknown.turns[0, 0]).all()
    assert np.isnan(unknown.cycles).all()


def test_speed_factor_is_the_root_of_any_loads() -> None:
    """Against a bracketed root, with loads that stay beside loads that grow, place by place."""
    random = np.random.default_rng(8)
    angles = np.radians(np.arange(0.0, 361.0, 10.0))
    scale = np.array([4000.0, 60.0, 30.0])
    still = 0.4 * scale * random.standard_normal((37, 5, 3))
    moving = scale * random.standard_normal((37, 5, 3))
    still[-1], moving[-1] = still[0], moving[0]
    section = BeamSection.rectangle(Material(200e9, 7800.0, fatigue=STEEL), HEIGHT, WIDTH)
    assert section.layers is not None
    found = endurance(section.layers, STEEL, angles, still + moving, still).speed_factor

    def used(factor: float, place: int, side: float) -> float:
        loads = (still + factor**2 * moving)[:, place]
        stress = loads[:, 0] / AREA + side * loads[:, 1] * 6 / (WIDTH * HEIGHT**2)
        amplitude, mean = (stress.max() - stress.min()) / 2, (stress.max() + stress.min()) / 2
        return amplitude / 280e6 + max(mean, 0.0) / 565e6 - 1

    for place in range(5):
        for number, side in enumerate((1.0, -1.0)):
            root = brentq(used, 0.0, 100.0, args=(place, side), xtol=1e-13)
            assert found[place, 0, number] == pytest.approx(root, rel=1e-9)


def test_angles_of_isotropic_layers_and_further_turns_change_nothing() -> None:
    random = np.random.default_rng(5)
    turn = np.radians(np.arange(0.0, 360.0, 10.0))
    loads = np.array([4000.0, 60.0, 30.0]) * random.standard_normal((36, 3, 3))
    own = FatigueStrength(565e6, 20e6, 1e6, -0.085)
    ply = Ply.isotropic(Material(200e9, 7800.0, fatigue=own))
    found = [
        endurance(
            LaminateSection(Laminate((Layer(ply, HEIGHT, angle),)), WIDTH),
            own,
            np.concatenate([turn + 2 * np.pi * number for number in range(turns)]),
            np.tile(loads, (turns, 1, 1)),
        )
        for angle, turns in ((0.0, 1), (0.7, 1), (0.0, 3))
    ]
    assert np.isfinite(found[0].turns).all()
    for other in found[1:]:
        np.testing.assert_allclose(other.load_factor, found[0].load_factor, rtol=1e-12)
        np.testing.assert_allclose(other.turns, found[0].turns, rtol=1e-10)
