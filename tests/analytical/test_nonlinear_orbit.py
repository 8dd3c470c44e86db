"""The periodic motion by Newton's method: linear links, a rotating arm, its own equations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from flexmech import ComputationError, InputError, ReferenceEngine
from flexmech.linear_system import StressedLinks
from flexmech.linkages import ConstantSpeed
from flexmech.time_domain import DrivenLinkage, nonlinear_orbit, periodic_turn
from flexmech.time_domain.periodic_motion.orbit_equations import at_angles, derivatives
from flexmech.verification.methods.frequencies import unit_arm


class LinearLinks(ReferenceEngine):
    """Links whose internal forces are linear: the orbit is that of the linear equations."""

    def stressed_links(self, motion, prestress, near=None):
        return StressedLinks.unloaded(self.links)

    def running_links(self, motion, displacement):
        stiffness = [link.stiffness for link in self.links]
        forces = [q @ k for q, k in zip(displacement, stiffness, strict=True)]
        return StressedLinks(stiffness, list(displacement), forces)


def damped(mechanism, time):
    sections = {k: s.with_damping_time(time) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def test_derivatives_of_harmonics_are_exact():
    first, second = derivatives(32, -3.0)
    angle = 2 * np.pi / 32 * np.arange(32)
    z = 0.3 + np.cos(5 * angle) - 2 * np.sin(15 * angle)
    exact = -5 * np.sin(5 * angle) - 30 * np.cos(15 * angle)
    assert first @ z == pytest.approx(-3.0 * exact, abs=1e-10)
    exact = -25 * np.cos(5 * angle) + 450 * np.sin(15 * angle)
    assert second @ z == pytest.approx(9.0 * exact, abs=1e-10)
    elsewhere = np.array([0.1, 2.0])
    exact = 0.3 + np.cos(5 * elsewhere) - 2 * np.sin(15 * elsewhere)
    assert at_angles(z[:, None], elsewhere)[:, 0] == pytest.approx(exact, abs=1e-12)


def test_any_samples_are_found_again_at_their_own_angles() -> None:
    """Those too whose fastest harmonic, of which samples show the cosine alone, is great."""
    samples = np.random.default_rng(0).normal(size=(8, 2))
    angle = 2 * np.pi / 8 * np.arange(8)
    np.testing.assert_allclose(at_angles(samples, angle), samples, rtol=0, atol=1e-13)


@pytest.mark.parametrize("time", [0.0, 1e-4])
def test_orbit_of_linear_links_is_that_of_the_linear_equations(aluminium, time):
    """The trapezoidal rule of the linear equations comes to it in second order."""
    engine = LinearLinks(damped(aluminium, time), elements=2)
    orbit = nonlinear_orbit(engine, 40.0, samples=96)
    assert orbit.residual < 1e-9
    assert orbit.passes <= 3  # GMRES solves a step to 1e-4
    linkage = DrivenLinkage(engine.unreduced(), ConstantSpeed(40.0), "none")
    gaps = []
    for steps in (1920, 3840):
        turn = periodic_turn(linkage, steps)
        size = max(np.abs(q).max() for q in turn)
        pairs = zip(turn, orbit.displacement, strict=True)
        gaps.append(max(np.abs(a[:: steps // 96] - b).max() for a, b in pairs) / size)
    assert gaps[1] < 2e-3
    assert np.log2(gaps[0] / gaps[1]) == pytest.approx(2.0, abs=0.3)


def test_rate_is_the_derivative_of_the_displacement(aluminium):
    orbit = nonlinear_orbit(ReferenceEngine(aluminium, elements=2), 20.0, samples=256)
    first = derivatives(256, 20.0)[0]
    for q, rate in zip(orbit.displacement, orbit.rate, strict=True):
        assert np.abs(first @ q - rate).max() < 1e-4 * np.abs(rate).max()


def test_backwards_is_the_mirrored_time(aluminium):
    """Without damping the motion of a linkage that turns backwards is the same, run back."""
    engine = ReferenceEngine(aluminium, elements=2)
    there, back = (nonlinear_orbit(engine, speed, samples=64) for speed in (20.0, -20.0))
    for one, other in zip(there.displacement, back.displacement, strict=True):
        assert np.abs(one - other).max() < 1e-6 * np.abs(one).max()
    for one, other in zip(there.rate, back.rate, strict=True):
        assert np.abs(one + other).max() < 1e-6 * np.abs(one).max()


def test_rotating_arm_rests_on_its_equilibrium():
    engine = ReferenceEngine(unit_arm(slenderness=1000.0), elements=4)
    orbit = nonlinear_orbit(engine, 3.0, samples=8)
    assert orbit.distance < 1e-8
    assert np.abs(orbit.displacement[0] - orbit.displacement[0][0]).max() < 1e-12
    assert np.abs(orbit.displacement[0]).max() > 1e-7


def test_a_critical_speed_has_one_message():
    """An arm whose free vibration fits half a turn of the crank."""
    engine = ReferenceEngine(unit_arm(slenderness=1000.0), elements=4, component_modes=False)

    # It rests in its frame, stretched by the square of the speed.
    stretched = nonlinear_orbit(engine, 1.8, samples=1).displacement

    def gap(speed):
        running = [(speed / 1.8) ** 2 * q for q in stretched]
        system = engine.linear_system(0.0, speed, running=running)
        free = np.linalg.solve(system.mass[0], system.stiffness[0])
        spin = np.linalg.solve(system.mass[0], system.damping[0])
        n = len(free)
        state = np.block([[np.zeros((n, n)), np.eye(n)], [-free, -spin]])
        return np.abs(np.linalg.eigvals(state).imag).min() - 2 * speed

    speed = brentq(gap, 1.7, 1.9, xtol=1e-11, rtol=1e-11)
    # Where it rests it is found at once. Its weight moves it, by so little that it is as stiff.
    assert nonlinear_orbit(engine, speed).residual < 1e-9
    heavy = engine.with_(mechanism=replace(engine.mechanism, gravity=(0.0, -1e-5)))
    with pytest.raises(ComputationError, match="critical: a free vibration fits one turn"):
        nonlinear_orbit(heavy, speed)
    assert nonlinear_orbit(heavy, (1 + 1e-5) * speed).residual < 1e-9


@pytest.mark.thorough
def test_no_orbit_is_said_and_not_replaced(aluminium):
    """At 150 rad/s the links have not even a quasi-static equilibrium."""
    with pytest.raises(ComputationError, match="no periodic motion found at crank speed 150 rad/s"):
        nonlinear_orbit(ReferenceEngine(aluminium, elements=2), 150.0)


def test_refuses_what_makes_no_sense(aluminium):
    engine = ReferenceEngine(aluminium, elements=2)
    with pytest.raises(InputError, match="crank speed"):
        nonlinear_orbit(engine, 0.0)
    with pytest.raises(InputError, match="samples"):
        nonlinear_orbit(engine, 20.0, samples=0)
