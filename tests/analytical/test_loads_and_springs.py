"""Loads and springs in linear systems and equilibria, against closed forms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from flexmech import (
    BeamSection,
    ExudynEngine,
    Material,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
    load_mechanism,
    natural_frequencies,
    stability,
)
from flexmech.analyses import solve_modes
from flexmech.linear_system import Engine
from flexmech.linkages import (
    GROUND,
    AttachmentPoint,
    Clamp,
    JointSpring,
    Link,
    LinkEnd,
    Load,
    Pivot,
    Spring,
    Topology,
)

FloatArray = NDArray[np.float64]
LENGTH = 0.3
SECTION = BeamSection.rectangle(Material(70e9, 2700.0), 3e-3, 25e-3)
BENDING, MASS = SECTION.bending_stiffness, SECTION.mass_per_length
UNIT = BENDING / LENGTH**3
TIP = AttachmentPoint("arm", LENGTH)
ENGINES: list[tuple[type[Engine], str]] = [(ReferenceEngine, "euler"), (ExudynEngine, "ancf")]


def arm(**attached: object) -> Mechanism:
    return Mechanism(RotatingArm(LENGTH), {"arm": SECTION}, **attached)  # type: ignore[arg-type]


def beam(matrix: Callable[[float], list[list[float]]], count: int) -> FloatArray:
    """Frequencies in Hz at which the determinant of boundary conditions by the wave vanishes."""

    def determinant(wave: float) -> float:
        return float(np.linalg.det(np.array(matrix(wave))))

    waves = np.linspace(0.5, 12, 4000) / LENGTH
    values = [determinant(wave) for wave in waves]
    roots = [
        brentq(determinant, low, high, xtol=1e-13)
        for low, high, a, b in zip(waves, waves[1:], values, values[1:], strict=False)
        if a * b < 0
    ]
    return np.sqrt(BENDING / MASS) * np.array(roots[:count]) ** 2 / (2 * np.pi)


def terms(wave: float) -> tuple[float, float, float, float]:
    x = wave * LENGTH
    return np.cos(x), np.sin(x), np.cosh(x), np.sinh(x)


@pytest.mark.parametrize(("engine", "element"), ENGINES)
def test_cantilever_on_a_tip_spring(engine: type[Engine], element: str) -> None:
    stiffness = 3 * UNIT

    def matrix(wave: float) -> list[list[float]]:
        c, s, ch, sh = terms(wave)
        shear = BENDING * wave**3
        return [
            [ch + c, sh + s],
            [shear * (sh - s) - stiffness * (ch - c), shear * (ch + c) - stiffness * (sh - s)],
        ]

    far = Spring("side", TIP, AttachmentPoint(GROUND, LENGTH, 1e3), stiffness, 1e3)
    found = natural_frequencies(engine(arm(springs=(far,)), 24, element).unreduced(), 0.0, modes=2)
    assert found == pytest.approx(beam(matrix, 2), rel=1.2e-6)


@pytest.mark.parametrize(("engine", "element"), ENGINES)
def test_static_deflection_under_a_tip_force_and_a_spring(
    engine: type[Engine], element: str
) -> None:
    load = Load("push", TIP, ((0.0, 1e-3),))
    spring = Spring("side", TIP, AttachmentPoint(GROUND, LENGTH, 1e3), UNIT, 1e3)
    for springs, stiffness in (((), 3 * UNIT), ((spring,), 4 * UNIT)):
        made = engine(arm(loads=(load,), springs=springs), 8, element)
        motion = made.mechanism.linkage.motion(np.zeros(1))
        state = made.stressed_links(motion, "equilibrium")
        assert state.displacement is not None
        moved = made.links[0].shape[-1] @ state.displacement[0][0]
        assert moved[1] == pytest.approx(1e-3 / stiffness, rel=1e-6)


@pytest.mark.parametrize(("engine", "element"), ENGINES)
def test_a_force_inside_a_link_and_a_torque_bend_it(engine: type[Engine], element: str) -> None:
    """Tip of a cantilever under a force F at a third and a couple M there: exact with a node."""
    place, force, couple = LENGTH / 3, 1e-3, 1e-4
    load = Load("inside", AttachmentPoint("arm", place), ((0.0, force),), (couple,))
    made = engine(arm(loads=(load,)), 4, element)
    state = made.stressed_links(made.mechanism.linkage.motion(np.zeros(1)), "equilibrium")
    assert state.displacement is not None
    rest = LENGTH - place
    tip = force * (place**3 / 3 + place**2 / 2 * rest) + couple * (place**2 / 2 + place * rest)
    moved = made.links[0].shape[-1] @ state.displacement[0][0]
    assert moved[1] == pytest.approx(tip / BENDING, rel=1e-6)


@pytest.mark.parametrize(("engine", "element"), ENGINES)
def test_a_compressed_cantilever_buckles_at_eulers_load(engine: type[Engine], element: str) -> None:
    """``f^2`` falls to zero; a straight line through two points near it finds the load."""
    euler = np.pi**2 * BENDING / (4 * LENGTH**2)
    parts, squares = np.array([0.985, 0.995]), []
    for part in parts:
        load = Load("press", TIP, ((-part * euler, 0.0),))
        made = engine(arm(loads=(load,)), 8, element)
        squares.append(natural_frequencies(made, 0.0, modes=1, prestress="axial")[0] ** 2)
    at_zero = parts[1] + squares[1] * (parts[1] - parts[0]) / (squares[0] - squares[1])
    assert at_zero == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize(("engine", "element"), ENGINES)
@pytest.mark.parametrize("prestress", ["axial", "equilibrium"])
def test_becks_column_flutters(engine: type[Engine], element: str, prestress: str) -> None:
    """Under a force that follows its tip a cantilever flutters at 20.05 EI / L^2 (Beck 1952)."""
    growth = []
    for part in (20.0, 20.1):
        force = part * BENDING / LENGTH**2
        load = Load("follows", TIP, ((-force, 0.0),), axes="link")
        made = engine(arm(loads=(load,)), 16, element)
        system = made.linear_system([0.0], prestress=prestress)  # type: ignore[arg-type]
        growth.append(float(solve_modes(system, 2).eigenvalues.real.max()))
    assert growth[0] < 1e-6
    assert growth[1] > 20


def test_torsional_springs_at_the_pins_of_a_beam() -> None:
    """``EI w'' = k w'`` at both ends of a pinned beam."""
    stiffness = 2 * BENDING / LENGTH

    def matrix(wave: float) -> list[list[float]]:
        # w = A cos + B sin + C cosh + D sinh, w(0) = 0 makes C = -A
        c, s, ch, sh = terms(wave)
        k, ei = stiffness * wave, BENDING * wave**2
        return [
            [c - ch, s, sh],
            [-2 * ei, -k, -k],
            [ei * (-c - ch) + k * (-s - sh), -ei * s + k * c, ei * sh + k * ch],
        ]

    made = ReferenceEngine(_pinned(stiffness), 40, "euler").unreduced()
    found = natural_frequencies(made, 0.0, modes=2, prestress="none")
    assert found == pytest.approx(beam(matrix, 2), rel=1.2e-6)


def test_a_beam_on_a_radial_spring() -> None:
    """Clamped, its end in a bearing of stiffness k: the same as on a spring across it."""
    bearing = JointSpring("bearing", radial_stiffness=3 * UNIT)
    mechanism = Mechanism(ArmInBearing(LENGTH), {"arm": SECTION}, joint_springs=(bearing,))
    far = Spring("side", TIP, AttachmentPoint(GROUND, LENGTH, 1e3), 3 * UNIT, 1e3)
    found, expected = (
        natural_frequencies(
            ReferenceEngine(each, 8, "euler").unreduced(), 0.0, modes=3, prestress="none"
        )
        for each in (mechanism, arm(springs=(far,)))
    )
    assert found == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("speed", [0.0, 20.0])
def test_engines_agree_on_a_fourbar_with_loads_and_springs(speed: float) -> None:
    aluminium = load_mechanism("models/aluminium_fourbar.toml")
    mechanism = replace(
        aluminium,
        loads=(
            Load("pack", AttachmentPoint("coupler", 0.14), ((1.0, -1.0),)),
            Load("turns", AttachmentPoint("rocker", 0.1), ((-1.0, 1.0),), (0.02,), axes="link"),
        ),
        springs=(
            Spring(
                "back",
                AttachmentPoint("rocker", 0.2),
                AttachmentPoint(GROUND, 0.5, 0.1),
                20.0,
                0.1,
                0.1,
            ),
            Spring(
                "between",
                AttachmentPoint("crank", 0.05),
                AttachmentPoint("rocker", 0.2),
                100.0,
                0.2,
            ),
        ),
        joint_springs=(JointSpring("B", 0.05, 1e-3, 1.0),),
    )
    angles = np.radians([20.0, 130.0, 250.0])
    first, second = (
        natural_frequencies(engine(mechanism, 8, element), angles, speed)
        for engine, element in ENGINES
    )
    assert second == pytest.approx(first, rel=1e-4)
    assert not np.allclose(
        first, natural_frequencies(ReferenceEngine(aluminium, 8), angles, speed), rtol=1e-3
    )


@pytest.mark.parametrize("speed", [0.0, 12.0])
def test_engines_agree_on_a_pusher_with_a_load_and_a_spring(speed: float) -> None:
    """Rigid crank, welded rocker, slider, a table of loads over the crank angle, gravity."""
    mechanism = load_mechanism("models/carton_pusher.toml")
    angles = np.radians([0.0, 38.0, 120.0, 250.0])
    first, second = (
        natural_frequencies(engine(mechanism, 8, element), angles, speed, modes=3)
        for engine, element in ENGINES
    )
    assert second == pytest.approx(first, rel=5e-5)


def test_loads_over_time_do_not_act_on_frozen_positions() -> None:
    late = Load("late", TIP, ((-5.0, 0.0), (-5.0, 0.0)), (0.0, 0.0), over="time", at=(0.0, 1.0))
    for prestress in ("axial", "equilibrium"):
        found, expected = (
            natural_frequencies(ReferenceEngine(each, 4), 0.0, 10.0, prestress=prestress)
            for each in (arm(loads=(late,)), arm())
        )
        np.testing.assert_array_equal(found, expected)


class ArmInBearing(RotatingArm):
    """Its tip is in a bearing of the ground that does not turn: springs alone hold it."""

    @property
    def topology(self) -> Topology:
        return Topology(
            (Link("arm", LENGTH),),
            (Clamp("O2", LinkEnd("arm", "start")),),
            (Pivot("bearing", LinkEnd("arm", "end"), sprung=True),),
        )


class _Pinned(RotatingArm):
    @property
    def topology(self) -> Topology:
        ends = (Pivot("first", LinkEnd("arm", "start")), Pivot("second", LinkEnd("arm", "end")))
        return Topology((Link("arm", LENGTH),), pivots=ends)


def _pinned(stiffness: float) -> Mechanism:
    springs = tuple(JointSpring(name, stiffness) for name in ("first", "second"))
    return Mechanism(_Pinned(LENGTH), {"arm": SECTION}, joint_springs=springs)


@pytest.mark.parametrize("prestress", ["axial", "equilibrium"])
def test_floquet_modes_of_an_arm_with_a_spring_to_its_axis(prestress: str) -> None:
    """It ends on the shaft's axis: nothing changes as the arm turns.

    Floquet exponents are then the frozen eigenvalues with rotation terms.
    """
    spring = Spring("to the axis", TIP, AttachmentPoint(GROUND, 0.0, 0.0), 2000.0, 0.2)
    made = ReferenceEngine(arm(springs=(spring,)), 4, "euler")
    found = stability(made, [40.0], prestress=prestress, modes=2)  # type: ignore[arg-type]
    frozen = natural_frequencies(made.unreduced(), 0.3, 40.0, modes=2, prestress=prestress)  # type: ignore[arg-type]
    floquet = np.sort(found.dataset["frequency"].values[0, 0])[::2]
    assert floquet == pytest.approx(frozen, rel=1e-6)
    free = natural_frequencies(ReferenceEngine(arm(), 4, "euler"), 0.3, 40.0, modes=1)
    assert frozen[0] < 0.9 * free[0]  # it presses the arm, along a line through its root
