"""Rotating beams: the L-beam by exact equations (V13), cantilevers (V3), spin-up (V6), criticals.

The published frequencies of the L-beam (Wallrapp & Schwertassek 1998) are of linear theory with the
tension of the straight arms, and cases of the verification; in fact the long arm bows by 2.5 % of
its length. The oracle knows no finite elements: geometrically exact beams (Reissner 1972, without
shear) in the rotating frame, as ordinary differential equations along the arms; the steady state by
shooting, the frequencies of small vibrations about it where the matrix from forces at the hub to
those at the free end is singular.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
from numpy.typing import NDArray

from flexmech import (
    BeamSection,
    ComputationError,
    ConstantSpeed,
    ExudynEngine,
    Mechanism,
    ReferenceEngine,
    campbell,
    example_model,
    load_mechanism,
    natural_frequencies,
    response,
)
from flexmech.analyses import ResponseRequest
from flexmech.verification import verification_case

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
SPEED = 6.0
L_BEAM = load_mechanism(example_model("rotating_l_beam"))
LINKS = {"long": 2.0, "short": 0.4}
ENGINES = (ReferenceEngine(L_BEAM, 28, "euler"), ExudynEngine(L_BEAM, 28, "ancf"))


def along(
    section: BeamSection, speed: float, frequency: float, state: ComplexArray
) -> ComplexArray:
    """Derivative along an arm of place, angle, forces (x, y) and moment, (6, 1 + k).

    The first column is the steady state, the others small vibrations about it.
    """
    mass = section.mass_per_length
    place, angle = state[:2, 0].real, state[2, 0].real
    force, moment = state[3:5, 0].real, state[5, 0].real
    axis = np.array([np.cos(angle), np.sin(angle)])
    normal = np.array([-axis[1], axis[0]])
    stretch = 1 + force @ axis / section.axial_stiffness
    slope = stretch * axis
    result = np.zeros_like(state)
    result[:2, 0], result[2, 0] = slope, moment / section.bending_stiffness
    result[3:5, 0] = -mass * speed**2 * place
    result[5, 0] = force[0] * slope[1] - force[1] * slope[0]
    moved, turned, pulled, bent = state[:2, 1:], state[2, 1:], state[3:5, 1:], state[5, 1:]
    stretched = (axis @ pulled + (force @ normal) * turned) / section.axial_stiffness
    tilted = np.outer(axis, stretched) + stretch * np.outer(normal, turned)
    result[:2, 1:], result[2, 1:] = tilted, bent / section.bending_stiffness
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    coriolis = 2j * speed * frequency * (quarter @ moved)
    result[3:5, 1:] = mass * (coriolis - (frequency**2 + speed**2) * moved)
    result[5, 1:] = force[0] * tilted[1] - force[1] * tilted[0]
    result[5, 1:] += pulled[0] * slope[1] - pulled[1] * slope[0]
    return result


def exact(root: FloatArray, speed: float, frequency: float = 0.0) -> tuple[Any, ComplexArray]:
    """Place and angle of the corner, and the state (6, 4) at the free end, by forces at the hub."""
    state = np.zeros((6, 4), dtype=complex)
    state[3:, 0], state[3:, 1:] = root, np.diag([1e3, 1.0, 1.0])
    corner = None
    for name, length in LINKS.items():
        section = L_BEAM.sections[name]

        def slope(_: float, y: ComplexArray, section: BeamSection = section) -> ComplexArray:
            return along(section, speed, frequency, y.reshape(6, 4)).ravel()

        end = scipy.integrate.solve_ivp(
            slope, (0.0, length), state.ravel(), method="DOP853", rtol=1e-10, atol=1e-11
        )
        state = end.y[:, -1].reshape(6, 4).copy()
        if corner is None:
            corner = state[:3, 0].real.copy()
            state[2, 0] += np.pi / 2
    return corner, state


def steady_root(speed: float) -> FloatArray:
    """Forces and moment at the hub in the steady state; none at the free end."""
    scale, root = np.array([10.0, 1.0, 1.0]), np.zeros(3)
    for part in (0.5, 1.0):
        root = scipy.optimize.fsolve(
            lambda r, part=part: exact(r * scale, part * speed)[1][3:, 0].real / scale,
            root,
            xtol=1e-12,
        )
    return root * scale


def exact_frequency(root: FloatArray, speed: float, near: float) -> float:
    """Frequency in Hz of small vibrations about the steady state."""

    def singular(frequency: float) -> float:
        moved = exact(root, speed, 2 * np.pi * frequency)[1][3:, 1:]
        return float(np.linalg.det(moved).real)

    return float(scipy.optimize.newton(singular, near, x1=1.001 * near, tol=1e-8))


@pytest.fixture(scope="module")
def root() -> FloatArray:
    return steady_root(SPEED)


@pytest.mark.parametrize("engine", ENGINES, ids=["reference", "exudyn"])
def test_frequencies_about_the_steady_state_of_the_l_beam(engine: Any, root: FloatArray) -> None:
    """Component modes of straight arms would give 1.7 Hz: a body that turns as one has none."""
    assert exact(root, SPEED)[0][1] == pytest.approx(-0.0508626, rel=1e-5)
    found = natural_frequencies(engine, 0.3, SPEED, modes=3)
    expected = [exact_frequency(root, SPEED, near) for near in found]
    np.testing.assert_allclose(expected, (1.033801, 7.659861, 17.065340), rtol=1e-6)
    np.testing.assert_allclose(found, expected, rtol=6e-6)
    # The published second one is of linear theory: 2.4 % below that of the bowed arms.
    assert found / (1.044, 7.478, 17.09) - 1 == pytest.approx([-0.0098, 0.0243, -0.0014], abs=1e-4)


def test_the_l_beam_at_rest_has_its_published_frequencies_by_the_exact_equations() -> None:
    frequency = [exact_frequency(np.zeros(3), 0.0, near) for near in (0.96, 7.0, 16.8)]
    np.testing.assert_allclose(frequency, (0.9614, 7.0364, 16.757), rtol=3e-5)


@pytest.mark.thorough
def test_above_the_first_frequency_at_rest_tension_holds_the_l_beam() -> None:
    """The inertia forces of a displacement alone are beyond the stiffness of straight arms."""
    root = steady_root(12.0)
    found = natural_frequencies(ENGINES[0], 0.3, 12.0, modes=2)
    expected = [exact_frequency(root, 12.0, near) for near in found]
    np.testing.assert_allclose(found, expected, rtol=4e-5)


def test_a_rotating_cantilever_flaps_as_published_in_component_modes() -> None:
    """Hamza-Cherif & Houmat, ICAS 2004, Table 2."""
    flap = verification_case("Rotating arm of slenderness 70: flap, speeds 2 to 10")
    reduced = replace(flap, measured_by=flap.measured_by.with_(component_modes=True))
    assert reduced.outcome().verdict == "passed"


@pytest.mark.parametrize("engine", ["reference", "exudyn"])
def test_the_square_of_a_slender_chords_frequency_is_the_flaps_less_the_speeds(
    engine: str,
) -> None:
    """About the geometrically exact equilibrium, without the stretch."""
    case = verification_case("Rotating arm of slenderness 70: flap, speeds 2 to 10")
    speeds, flap = np.array(case.measured_by.settings["speeds"]), case.expected_values()
    arm = case.measured_by.with_(
        engine=engine, elements=16, slenderness=1000, prestress="equilibrium"
    )
    np.testing.assert_allclose(arm.values(), flap, rtol=case.tolerance)
    chord = arm.with_(rotation_terms=True).values()
    np.testing.assert_allclose(chord, np.sqrt(flap**2 - speeds**2), rtol=case.tolerance)


def test_without_geometric_stiffness_the_spin_up_beam_diverges() -> None:
    """V6: Simo & Vu-Quoc 1986; its drive is the published cycloid."""
    spin_up, t = ConstantSpeed(6.0, run_up_time=15.0), np.linspace(0.0, 15.0, 31)
    published = 6 / 15 * (t - 15 / (2 * np.pi) * np.sin(2 * np.pi * t / 15))
    assert spin_up.crank_speed(t) == pytest.approx(published, rel=0, abs=1e-12)
    engine = ReferenceEngine(load_mechanism(example_model("spin_up_beam")), 4)
    with pytest.raises(ComputationError, match="diverges"):
        response(engine, ResponseRequest(spin_up, 4.0, samples=36, step=0.01, prestress="none"))


@pytest.mark.parametrize("rotation_terms", [False, True])
def test_orders_of_the_crank_meet_a_slender_arm_at_its_critical_speeds(
    unit_arm: Callable[[float], Mechanism], *, rotation_terms: bool
) -> None:
    """Order n at ``w / n`` frozen, and at ``w / sqrt(n^2 + 1)`` with the centripetal terms.

    Frequencies of a clamped beam of Blevins, Formulas for Natural Frequency and Mode Shape, 1979,
    table 8-1. Beyond the first frequency at rest the arm without tension turns over.
    """
    fastest, orders = 3.4, [1, 2, 3, 7, 8]
    result = campbell(
        ReferenceEngine(unit_arm(2e4), 32),
        np.linspace(0.0, fastest, 18),
        crank_angles=np.radians(np.arange(0.0, 360.0, 60.0)),
        orders=orders,
        modes=2,
        prestress="none",
        rotation_terms=rotation_terms,
    )
    table = result.critical_speeds().query("nearest_relative_gap == 0")
    for branch, clamped in enumerate((1.8751040687119611, 4.694091132974175), start=1):
        for order in orders:
            wanted = clamped**2 / (np.sqrt(order**2 + 1) if rotation_terms else order)
            row = table[(table["order"] == order) & (table["branch"] == branch)]
            assert len(row) == (wanted < fastest)
            for edge in ("from_rad_s", "to_rad_s"):
                np.testing.assert_allclose(row[edge], np.full(len(row), wanted), rtol=1e-6)
