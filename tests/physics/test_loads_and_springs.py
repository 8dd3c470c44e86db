"""Loads and springs on links against closed forms of beams: deflections, frequencies, buckling."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq, newton

from flexmech import (
    BeamSection,
    ConstantSpeed,
    ExudynEngine,
    JointSpring,
    Load,
    Material,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
    Spring,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
    response,
    stability,
)
from flexmech.analyses import ResponseRequest
from flexmech.linkages import GROUND, AttachmentPoint, Link, LinkEnd, Pivot, Topology
from tests.support.running_modes import (
    ArmInBearing,
    exponents,
    forward,
    frozen_eigenvalues,
)

FloatArray = NDArray[np.float64]
LENGTH = 0.3
SECTION = BeamSection.rectangle(Material(70e9, 2700.0), 3e-3, 25e-3)
BENDING, MASS = SECTION.bending_stiffness, SECTION.mass_per_length
UNIT = BENDING / LENGTH**3
TIP = AttachmentPoint("arm", LENGTH)
SIDE = AttachmentPoint(GROUND, LENGTH, 1e3)
ENGINES: list[tuple[Any, str]] = [(ReferenceEngine, "euler"), (ExudynEngine, "ancf")]
BOTH = pytest.mark.parametrize(("engine", "element"), ENGINES, ids=["reference", "exudyn"])


def arm(**attached: Any) -> Mechanism:
    return Mechanism(RotatingArm(LENGTH), {"arm": SECTION}, **attached)


def arm_in_bearing(bearing: JointSpring) -> Mechanism:
    return Mechanism(ArmInBearing(LENGTH), {"arm": SECTION}, joint_springs=(bearing,))


def beam(matrix: Callable[[float], list[list[float]]], count: int) -> FloatArray:
    """Frequencies in Hz at which the determinant of boundary conditions by the wave vanishes."""

    def determinant(wave: float) -> float:
        return float(np.linalg.det(np.array(matrix(wave))))

    waves = np.linspace(0.5, 9, 700) / LENGTH
    values = [determinant(wave) for wave in waves]
    roots = [
        brentq(determinant, low, high, xtol=1e-13)
        for low, high, a, b in zip(waves, waves[1:], values, values[1:], strict=False)
        if a * b < 0
    ]
    return np.sqrt(BENDING / MASS) * np.array(roots[:count]) ** 2 / (2 * np.pi)


def waves_of(wave: float) -> tuple[float, float, float, float]:
    x = wave * LENGTH
    return np.cos(x), np.sin(x), np.cosh(x), np.sinh(x)


def static_tip(engine: Any) -> float:
    """Displacement across the arm of its tip at rest in m: its shaft hardly turns."""
    request = ResponseRequest(
        ConstantSpeed(1e-2), 1e-5, samples=200_000, step=1e-4, start="equilibrium", modes=1
    )
    return float(response(engine, request).dataset["displacement"][0, 0, 0, -1, 1])


@BOTH
def test_a_cantilever_on_a_tip_spring_has_its_two_frequencies(engine: Any, element: str) -> None:
    stiffness = 3 * UNIT

    def matrix(wave: float) -> list[list[float]]:
        c, s, ch, sh = waves_of(wave)
        shear = BENDING * wave**3
        return [
            [ch + c, sh + s],
            [shear * (sh - s) - stiffness * (ch - c), shear * (ch + c) - stiffness * (sh - s)],
        ]

    sprung = arm(springs=(Spring("side", TIP, SIDE, stiffness, 1e3),))
    found = natural_frequencies(engine(sprung, 24, element).unreduced(), 0.0, modes=2)
    assert found == pytest.approx(beam(matrix, 2), rel=1.2e-6)


@BOTH
def test_a_tip_force_bends_a_cantilever_by_its_stiffness_and_that_of_a_spring(
    engine: Any, element: str
) -> None:
    attached = {
        "loads": (Load("push", TIP, ((0.0, 1e-3),)),),
        "springs": (Spring("side", TIP, SIDE, UNIT, 1e3),),
    }
    found = static_tip(engine(arm(**attached), 4, element, component_modes=False))
    assert found == pytest.approx(1e-3 / (4 * UNIT), rel=1e-6)


@BOTH
def test_a_force_and_a_couple_inside_a_cantilever_bend_its_tip(engine: Any, element: str) -> None:
    """At a third of the length: exact with a node there and without."""
    place, force, couple = LENGTH / 3, 1e-3, 1e-4
    load = Load("inside", AttachmentPoint("arm", place), ((0.0, force),), (couple,))
    rest = LENGTH - place
    tip = force * (place**3 / 3 + place**2 / 2 * rest) + couple * (place**2 / 2 + place * rest)
    found = static_tip(engine(arm(loads=(load,)), 4, element, component_modes=False))
    assert found == pytest.approx(tip / BENDING, rel=1e-6)


@BOTH
def test_a_pressed_cantilever_buckles_at_eulers_load(engine: Any, element: str) -> None:
    """``f^2`` falls to zero; a straight line through two points near it finds the load."""
    euler = np.pi**2 * BENDING / (4 * LENGTH**2)
    parts, squares = np.array([0.985, 0.995]), []
    for part in parts:
        load = Load("press", TIP, ((-part * euler, 0.0),))
        made = engine(arm(loads=(load,)), 8, element)
        squares.append(natural_frequencies(made, 0.0, modes=1, prestress="axial")[0] ** 2)
    at_zero = parts[1] + squares[1] * (parts[1] - parts[0]) / (squares[0] - squares[1])
    assert at_zero == pytest.approx(1.0, abs=1e-4)


@BOTH
@pytest.mark.parametrize("prestress", ["axial", "equilibrium"])
def test_becks_column_flutters(engine: Any, element: str, prestress: Any) -> None:
    """Under a force that follows its tip a cantilever flutters at 20.05 EI / L^2 (Beck 1952)."""
    damping = []
    for part in (20.0, 20.1):
        load = Load("follows", TIP, ((-part * BENDING / LENGTH**2, 0.0),), axes="link")
        made = engine(arm(loads=(load,)), 12, element)
        found = moving_frequencies(made, [0.0], [0.0], modes=2, prestress=prestress).dataset
        damping.append(found["damping_ratio"].values.min())
    assert damping[0] > -1e-8
    assert damping[1] < -0.02


def test_torsional_springs_at_the_pins_of_a_beam_raise_its_frequencies() -> None:
    """``EI w'' = k w'`` at both ends of a pinned beam."""
    stiffness = 2 * BENDING / LENGTH

    class Pinned(RotatingArm):
        @property
        def topology(self) -> Topology:
            ends = (Pivot("first", LinkEnd("arm", "start")), Pivot("second", LinkEnd("arm", "end")))
            return Topology((Link("arm", LENGTH),), pivots=ends)

    def matrix(wave: float) -> list[list[float]]:
        # w = A cos + B sin + C cosh + D sinh, w(0) = 0 makes C = -A
        c, s, ch, sh = waves_of(wave)
        k, ei = stiffness * wave, BENDING * wave**2
        return [
            [c - ch, s, sh],
            [-2 * ei, -k, -k],
            [ei * (-c - ch) + k * (-s - sh), -ei * s + k * c, ei * sh + k * ch],
        ]

    springs = tuple(JointSpring(name, stiffness) for name in ("first", "second"))
    mechanism = Mechanism(Pinned(LENGTH), {"arm": SECTION}, joint_springs=springs)
    engine = ReferenceEngine(mechanism, 40, "euler").unreduced()
    found = natural_frequencies(engine, 0.0, modes=2, prestress="none")
    assert found == pytest.approx(beam(matrix, 2), rel=1.2e-6)


def test_a_bearing_of_radial_stiffness_is_a_spring_across_the_tip() -> None:
    held = arm_in_bearing(JointSpring("bearing", radial_stiffness=3 * UNIT))
    sprung = arm(springs=(Spring("side", TIP, SIDE, 3 * UNIT, 1e3),))
    found, expected = (
        natural_frequencies(
            ReferenceEngine(mechanism, 8, "euler").unreduced(), 0.0, modes=3, prestress="none"
        )
        for mechanism in (held, sprung)
    )
    assert found == pytest.approx(expected, rel=1e-9)


def test_a_cantilever_on_a_dashpot_and_a_torsional_damper_decays_by_its_complex_waves() -> None:
    """``EI w''' = (k + c s) w`` and ``EI w'' = -d s w'`` at the tip."""
    radial, turning, stiffness = 0.4, 2e-3, 3 * BENDING / LENGTH**3
    bearing = JointSpring(
        "bearing",
        torsional_damping=turning,
        radial_stiffness=stiffness,
        radial_damping=radial,
    )

    def determinant(wave: complex) -> complex:
        x, rate = wave * LENGTH, 1j * np.sqrt(BENDING / MASS) * wave**2
        c, s, ch, sh = np.cos(x), np.sin(x), np.cosh(x), np.sinh(x)
        spring, turn = stiffness + radial * rate, turning * rate * wave
        shear, bending = BENDING * wave**3, BENDING * wave**2
        # w = A (cosh - cos) + B (sinh - sin)
        rows = [
            [shear * (sh - s) - spring * (ch - c), shear * (ch + c) - spring * (sh - s)],
            [bending * (ch + c) + turn * (sh + s), bending * (sh + s) + turn * (ch - c)],
        ]
        return complex(np.linalg.det(np.array(rows)))

    def root(near: float) -> complex:
        rate = 1j * np.sqrt(BENDING / MASS) * newton(determinant, complex(near, 0.01 * near)) ** 2
        return complex(rate if rate.imag > 0 else -rate.conjugate())

    # Undamped, the waves of a clamped-free beam on a spring begin at 2.
    expected = np.array([root(near / LENGTH) for near in (2.0, 4.7)])
    engine = ReferenceEngine(arm_in_bearing(bearing), 16, "euler")
    found = exponents(engine, 1e-3, 2, "none")
    assert found == pytest.approx(expected[np.argsort(expected.imag)], rel=1e-5)
    assert (-found.real / abs(found)).min() > 0.02


@pytest.mark.parametrize("speed", [60.0, -60.0])
def test_a_damper_of_the_ground_on_an_arm_that_turns_has_frozen_eigenvalues(speed: float) -> None:
    """A bearing that resists motion in ground axes, which the turning frame feels as ``c omega J``.

    The system is constant: exponents are the frozen eigenvalues.
    """
    bearing = JointSpring("bearing", radial_stiffness=2e3, radial_damping=3.0)
    engine = ReferenceEngine(arm_in_bearing(bearing), 6, "euler")
    found = exponents(engine, speed, 2, "none")
    expected = forward(frozen_eigenvalues(engine, speed, "none"), 2)
    assert found == pytest.approx(expected, rel=1e-8)
    assert found.real.max() < -1.0


@pytest.mark.parametrize("part", [10.0, 40.0])
def test_a_force_that_follows_the_tip_of_a_running_arm_makes_it_flutter(part: float) -> None:
    """Beck's column on a shaft that turns: it flutters above a force, which its tension raises."""
    load = Load("follows", TIP, ((-part * BENDING / LENGTH**2, 0.0),), axes="link")
    engine = ReferenceEngine(arm(loads=(load,)), 8, "euler")
    found, expected = exponents(engine, 20.0, 2), forward(frozen_eigenvalues(engine, 20.0), 2)
    assert np.sort(found.real) == pytest.approx(np.sort(expected.real), rel=1e-8, abs=1e-6)
    assert np.sort(found.imag) == pytest.approx(np.sort(expected.imag), rel=1e-8)
    assert bool(found.real.max() > 10) is (part > 20.0)


@pytest.mark.parametrize("prestress", ["axial", "equilibrium"])
def test_an_arm_with_a_spring_to_its_axis_runs_with_its_frozen_frequencies(
    prestress: Any,
) -> None:
    """It ends on the shaft's axis: nothing changes as the arm turns."""
    spring = Spring("to the axis", TIP, AttachmentPoint(GROUND, 0.0, 0.0), 2000.0, 0.2)
    engine = ReferenceEngine(arm(springs=(spring,)), 4, "euler")
    found = stability(engine, [40.0], prestress=prestress, modes=2).dataset
    frozen = natural_frequencies(engine.unreduced(), 0.3, 40.0, modes=2, prestress=prestress)
    floquet = np.sort(found["frequency"].values[0, 0])[::2]
    assert floquet == pytest.approx(frozen, rel=1e-6)
    free = natural_frequencies(ReferenceEngine(arm(), 4, "euler"), 0.3, 40.0, modes=1)
    assert frozen[0] < 0.9 * free[0]  # it presses the arm, along a line through its root


def test_strain_energy_of_a_bent_arm_is_half_the_work_of_its_force() -> None:
    """``F^2 L^3 / (6 EI)`` of a force across the tip."""
    force = 0.5
    load = Load("tip", TIP, ((0.0, force),), axes="link")
    engine = ReferenceEngine(arm(loads=(load,)), 2, "euler", component_modes=False)
    request = ResponseRequest(
        ConstantSpeed(0.05), 1e-4, samples=20_000, step=1e-3, start="equilibrium", modes=1
    )
    energy = response(engine, request).dataset["strain_energy"].values
    wanted = force**2 * LENGTH**3 / (6 * BENDING)
    np.testing.assert_allclose(energy, wanted, rtol=1e-3)


def test_engines_agree_on_a_four_bar_with_loads_and_springs() -> None:
    aluminium = load_mechanism("models/aluminium_fourbar.toml")
    rocker = AttachmentPoint("rocker", 0.2)
    mechanism = replace(
        aluminium,
        loads=(
            Load("pack", AttachmentPoint("coupler", 0.14), ((1.0, -1.0),)),
            Load("turns", AttachmentPoint("rocker", 0.1), ((-1.0, 1.0),), (0.02,), axes="link"),
        ),
        springs=(
            Spring("back", rocker, AttachmentPoint(GROUND, 0.5, 0.1), 20.0, 0.1, 0.1),
            Spring("between", AttachmentPoint("crank", 0.05), rocker, 100.0, 0.2),
        ),
        joint_springs=(JointSpring("B", 0.05, 1e-3, 1.0),),
    )
    angles = np.radians([20.0, 130.0, 250.0])
    for speed in (0.0, 20.0):
        first, second = (
            natural_frequencies(engine(mechanism, 8, element), angles, speed)
            for engine, element in ENGINES
        )
        assert second == pytest.approx(first, rel=1e-4)
        without = natural_frequencies(ReferenceEngine(aluminium, 8), angles, speed)
        assert np.abs(first / without - 1).max() > 1e-3


def test_loads_over_time_do_not_act_on_frozen_positions() -> None:
    late = Load("late", TIP, ((-5.0, 0.0), (-5.0, 0.0)), (0.0, 0.0), over="time", at=(0.0, 1.0))
    for prestress in ("axial", "equilibrium"):
        found, expected = (
            natural_frequencies(ReferenceEngine(mechanism, 4), 0.0, 10.0, prestress=prestress)
            for mechanism in (arm(loads=(late,)), arm())
        )
        np.testing.assert_array_equal(found, expected)
