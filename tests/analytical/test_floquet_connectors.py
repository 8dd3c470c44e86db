"""Dampers of springs and joints and forces that follow, in the running linkage's multipliers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import scipy.optimize
from numpy.typing import NDArray

from flexmech import ExudynEngine, Mechanism, ReferenceEngine, RotatingArm, load_mechanism
from flexmech.analyses.frequencies.eigenproblem import solve_modes
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.dynamical_systems import floquet_modes
from flexmech.linear_system import Engine, Prestress
from flexmech.linkages import GROUND, AttachmentPoint, JointSpring, Load, Spring
from flexmech.time_domain import moving_modes
from tests.analytical.test_loads_and_springs import BENDING, LENGTH, SECTION, TIP, ArmInBearing
from tests.analytical.test_moving_modes import (
    farthest,
    integrated_monodromy,
    multipliers,
    sampled,
    soft,
    steps_of,
)

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
MASS = SECTION.mass_per_length


def arm_in_bearing(bearing: JointSpring) -> Mechanism:
    return Mechanism(ArmInBearing(LENGTH), {"arm": SECTION}, joint_springs=(bearing,))


def exponents(
    engine: Engine, speed: float, modes: int, prestress: Prestress = "axial"
) -> ComplexArray:
    """Of the branches that turn forward, with the whole turns of their largest harmonics."""
    found = LinkageSolver(engine, prestress, modes).solved(speed)
    both = found.modes.exponent
    forward = both[both.imag > 0]
    return np.asarray(forward[np.argsort(forward.imag)])


def frozen(
    engine: Engine, speed: float, modes: int, prestress: Prestress = "axial"
) -> ComplexArray:
    """Eigenvalues of ``M z'' + C z' + K z = 0`` at one crank angle, with all rotation terms."""
    system = engine.unreduced().linear_system(0.7, speed, prestress=prestress)
    mass, rest = system.mass[0], np.hstack((system.stiffness[0], system.damping[0]))
    size = system.size
    matrix = np.block([[np.zeros((size, size)), np.eye(size)], [-np.linalg.solve(mass, rest)]])
    values = np.linalg.eigvals(matrix)
    forward = values[values.imag > 0]
    return np.asarray(forward[np.argsort(forward.imag)][:modes])


def roots(determinant: Callable[[complex], complex], starts: FloatArray) -> ComplexArray:
    """Complex wave numbers at which a determinant vanishes, and ``s = i sqrt(EI / m) wave^2``."""
    waves = np.array([scipy.optimize.newton(determinant, complex(x, 0.01 * x)) for x in starts])
    return np.asarray(1j * np.sqrt(BENDING / MASS) * waves**2)


def test_a_cantilever_on_a_dashpot_and_a_torsional_damper() -> None:
    """``EI w''' = (k + c s) w`` and ``EI w'' = -d s w'`` at the tip, in complex wave numbers."""
    bearing = JointSpring(
        "bearing",
        torsional_damping=2e-3,
        radial_stiffness=3 * BENDING / LENGTH**3,
        radial_damping=0.4,
    )

    def determinant(wave: complex) -> complex:
        x, rate = wave * LENGTH, 1j * np.sqrt(BENDING / MASS) * wave**2
        c, s, ch, sh = np.cos(x), np.sin(x), np.cosh(x), np.sinh(x)
        spring = 3 * BENDING / LENGTH**3 + bearing.radial_damping * rate
        turn = bearing.torsional_damping * rate * wave
        shear, bending = BENDING * wave**3, BENDING * wave**2
        # w = A (cosh - cos) + B (sinh - sin)
        rows = [
            [shear * (sh - s) - spring * (ch - c), shear * (ch + c) - spring * (sh - s)],
            [bending * (ch + c) + turn * (sh + s), bending * (sh + s) + turn * (ch - c)],
        ]
        return complex(np.linalg.det(np.array(rows)))

    # The undamped roots are real waves; those of a clamped-free beam on a spring begin at 2.
    expected = roots(determinant, np.array([2.0, 4.7]) / LENGTH)
    expected = np.where(expected.imag > 0, expected, -expected.conj())
    made = ReferenceEngine(arm_in_bearing(bearing), 24, "euler")
    found = exponents(made, 1e-3, 2, "none")
    assert found == pytest.approx(expected[np.argsort(expected.imag)], rel=2e-6)
    assert (-found.real / abs(found)).min() > 0.02


@pytest.mark.parametrize("speed", [60.0, -60.0])
def test_a_damper_of_the_ground_on_an_arm_that_turns(speed: float) -> None:
    """A bearing that resists motion in ground axes, which the turning frame feels as ``c omega J``.

    The system is constant: exponents are the frozen eigenvalues.
    """
    bearing = JointSpring("bearing", radial_stiffness=2e3, radial_damping=3.0)
    made = ReferenceEngine(arm_in_bearing(bearing), 6, "euler")
    found = exponents(made, speed, 2, "none")
    assert found == pytest.approx(frozen(made, speed, 2, "none"), rel=1e-8)
    assert found.real.max() < -1.0


@pytest.mark.parametrize("part", [10.0, 40.0])
def test_a_force_that_follows_the_tip_of_a_running_arm(part: float) -> None:
    """Beck's column on a shaft that turns: it flutters above a force, which its tension raises."""
    load = Load("follows", TIP, ((-part * BENDING / LENGTH**2, 0.0),), axes="link")
    arm = Mechanism(RotatingArm(LENGTH), {"arm": SECTION}, loads=(load,))
    made = ReferenceEngine(arm, 8, "euler")
    found, expected = exponents(made, 20.0, 2), frozen(made, 20.0, 2)
    growing = part > 20.0
    assert np.sort(found.real) == pytest.approx(np.sort(expected.real), rel=1e-8, abs=1e-6)
    assert np.sort(found.imag) == pytest.approx(np.sort(expected.imag), rel=1e-8)
    assert bool(found.real.max() > 10) is growing


CONNECTED: dict[str, object] = {
    "loads": (
        Load("turns", AttachmentPoint("rocker", 0.2667), ((-3.0, 2.0),), (0.02,), axes="link"),
    ),
    "springs": (
        Spring(
            "back",
            AttachmentPoint("rocker", 0.2667),
            AttachmentPoint(GROUND, 0.5, 0.1),
            50.0,
            0.1,
            0.2,
        ),
        Spring(
            "between",
            AttachmentPoint("crank", 0.0),
            AttachmentPoint("rocker", 0.2667),
            0.0,
            0.2,
            0.3,
        ),
    ),
    "joint_springs": (JointSpring("B", 0.05, 2e-3, 1.0),),
}


@pytest.mark.thorough
def test_multipliers_of_the_unreduced_equations_with_connectors(mechanisms) -> None:
    """Against the second-order equations of the frozen system, in time by another method."""
    made = replace(soft(mechanisms["aluminium"]), **CONNECTED)
    engine = ReferenceEngine(made, elements=1, component_modes=False)
    turn = sampled(engine, 30.0, "axial", samples=256)
    moving = moving_modes(turn, turn.frames.size)
    modes = floquet_modes(moving.system(), 8 * steps_of(turn, moving.size))
    expected = np.linalg.eigvals(integrated_monodromy(engine, 30.0, "axial"))
    found = multipliers(modes)
    assert farthest(found, expected) < 1e-8
    assert farthest(expected, found) < 1e-8
    assert modes.liouville_defect < 1e-10
    # Dampers and the force that follows count, each by itself.
    without = moving.conservative.coefficients
    assert np.abs(moving.attached.coefficients).max() > 1e-3 * np.abs(without).max()


@pytest.mark.thorough
def test_engines_agree_on_a_linkage_with_dampers_and_a_force_that_follows(mechanisms) -> None:
    made = replace(mechanisms["aluminium"], **CONNECTED)
    first, second = (
        LinkageSolver(engine, "equilibrium", 3).solved(40.0).modes
        for engine in (ReferenceEngine(made, 6, "euler"), ExudynEngine(made, 6, "ancf"))
    )
    gap = first.exponent[:, None] * first.period - second.exponent * second.period
    turned = gap.imag - 2 * np.pi * np.round(gap.imag / (2 * np.pi))
    relative = np.hypot(gap.real, turned) / np.abs(first.exponent[:, None] * first.period)
    assert relative.min(axis=1).max() < 1e-4
    assert (first.exponent.real < -1.0).any()


def test_a_constant_turn_is_found_by_computation() -> None:
    """Welds and a damper to the shaft's axis leave nothing that changes; gravity does."""
    beam = load_mechanism("models/rotating_l_beam.toml")
    damper = Spring(
        "axis", AttachmentPoint("short", 0.4), AttachmentPoint(GROUND, 0.0, 0.0), 0.0, 1.0, 0.5
    )
    steady = replace(beam, springs=(damper,))
    aside = replace(damper, second=AttachmentPoint(GROUND, 0.1, 0.0))
    solvers = [
        LinkageSolver(ReferenceEngine(each, 4), "axial", 3)
        for each in (
            beam,
            steady,
            replace(beam, springs=(aside,)),
            replace(beam, gravity=(0.0, -9.81)),
        )
    ]
    moving = [solver.moving(6.0) for solver in solvers]
    assert [each.conservative.harmonics == 0 for each in moving] == [True, True, False, False]
    # What changes along the turn is reduced.
    assert moving[3].size < moving[0].size / 2
    found = solvers[1].solved(6.0).modes.exponent
    expected = frozen(solvers[1].engine, 6.0, 3)
    forward = found[found.imag > 0]
    # The frozen system's matrix in all coordinates knows its slow modes to about 1e-7.
    assert forward[np.argsort(forward.imag)] == pytest.approx(expected, rel=1e-6)
    assert expected.real.max() < -1e-3


def test_a_force_that_follows_the_tip_does_not_buckle_a_column() -> None:
    """The symmetric part of its stiffness alone is indefinite; frozen modes vibrate below flutter.

    Their least square decides whether a running linkage is called statically unstable.
    """
    force = 15.0 * BENDING / LENGTH**2
    load = Load("follows", TIP, ((-force, 0.0),), axes="link")
    column = Mechanism(RotatingArm(LENGTH), {"arm": SECTION}, loads=(load,))
    engine = ReferenceEngine(column, 4, "euler")
    turn = LinkageSolver(engine, "axial", 2).moving_modes(1e-2).turn
    still = solve_modes(engine.linear_system([0.0], prestress="axial"), 1).eigenvalues
    assert turn.frozen_squares.min() < 0
    np.testing.assert_allclose(turn.static_squares, float(np.abs(still[0, 0]) ** 2), rtol=1e-6)
