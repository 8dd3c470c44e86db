"""Constant systems: receptances by two ways, and the exact response to a half-sine pulse."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg

from flexmech import ComputationError
from flexmech.dynamical_systems import HalfSinePulse, direct_receptance, pulse_response, state_modes

ROWS = np.array([[1.0, 0.0, 0.3], [0.0, 1.0, -0.2]])
# Three masses; the dampers are not proportional to the springs, so that modes are complex.
MASS = np.array([[2.0, 0.1, 0.0], [0.1, 1.0, 0.0], [0.0, 0.0, 0.5]])
STIFFNESS = np.array([[3e4, -1e4, 0.0], [-1e4, 4e4, -2e4], [0.0, -2e4, 6e4]])
DAMPING = np.array([[4.0, 0.0, 0.0], [0.0, 0.5, -0.2], [0.0, -0.2, 9.0]])
SYSTEM = MASS, DAMPING, STIFFNESS


def test_superposition_of_all_modes_is_the_direct_solution_and_reciprocal():
    frequency = np.linspace(0.0, 100.0, 101)
    direct = direct_receptance(*SYSTEM, ROWS, ROWS, frequency)
    superposed = state_modes(*SYSTEM).receptance(ROWS, ROWS, frequency)
    assert np.abs(superposed - direct).max() < 1e-12 * np.abs(direct).max()
    np.testing.assert_allclose(direct[:, 0, 1], direct[:, 1, 0], rtol=1e-12)
    np.testing.assert_allclose(direct[0].real, ROWS @ np.linalg.solve(STIFFNESS, ROWS.T))


def test_the_receptance_of_one_oscillator_in_its_resonance_is_one_over_i_omega_c():
    one = np.eye(1)
    omega = np.sqrt(400.0 / 2.0)
    found = direct_receptance(2 * one, 3 * one, 400 * one, one, one, np.array([omega / 2 / np.pi]))
    assert found[0, 0, 0] == pytest.approx(1 / (3j * omega), rel=1e-12)


def test_the_residual_is_the_flexibility_of_the_oscillator_left_out():
    modes = state_modes(np.eye(2), np.diag([0.1, 2.0]), np.diag([1e2, 1e6]))
    both = np.array([[1.0, 1.0]])
    kept = modes.below(100.0)
    np.testing.assert_allclose(np.abs(modes.poles[kept]), 10.0)
    assert modes.residual(both, both, kept)[0, 0] == pytest.approx(1e-6)


def test_the_response_to_a_pulse_is_that_of_the_matrix_exponential():
    modes = state_modes(*SYSTEM)
    pulse = HalfSinePulse(3.0, 0.02, start=0.01)
    time = np.linspace(0.0, 0.2, 21)
    found = pulse_response(modes.poles, modes.residues(ROWS, ROWS[:1])[:, :, 0], pulse, time)
    rate = np.pi / pulse.duration
    # Two more states make the half-sine.
    state = np.zeros((8, 8))
    state[:3, 3:6] = np.eye(3)
    state[3:6, :3], state[3:6, 3:6] = (-np.linalg.solve(MASS, m) for m in (STIFFNESS, DAMPING))
    state[3:6, 6] = np.linalg.solve(MASS, ROWS[0])
    state[6, 7], state[7, 6] = rate, -rate
    start = np.zeros(8)
    start[7] = pulse.peak_force
    ended = scipy.linalg.expm(state * pulse.duration) @ start
    ended[6:] = 0
    for t, displacement in zip(time, found, strict=True):
        since = max(0.0, t - pulse.start)
        during = since <= pulse.duration
        exact = scipy.linalg.expm(state * (since if during else since - pulse.duration)) @ (
            start if during else ended
        )
        assert displacement == pytest.approx(ROWS @ exact[:3], abs=1e-9 * np.abs(found).max())


def test_critical_damping_is_no_sum_of_modes():
    with pytest.raises(ComputationError, match="one pole"):
        state_modes(np.eye(1), np.array([[2.0]]), np.eye(1))
