"""Receptances by direct solution and by superposition, and the exact answer to a pulse."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

import flexmech
from flexmech.dynamical_systems import HalfSinePulse, direct_receptance, pulse_response, state_modes
from flexmech.errors import ComputationError
from flexmech.linear_system import LinkPoint, point_rows

ANGLE = np.radians([96.9])
POINTS = [LinkPoint("coupler", 0.4), LinkPoint("rocker", 0.3)]


@pytest.fixture(scope="module")
def composite():
    """Links with different damping times: the damped modes are complex."""
    model = flexmech.load_mechanism(flexmech.example_model("composite_fourbar"))
    engine = flexmech.ReferenceEngine(model, elements=4, component_modes=False)
    system = engine.linear_system(ANGLE, prestress="none")
    matrices = [m[0] for m in (system.mass, system.damping, system.stiffness)]
    rows = np.stack([point_rows(system, point, "transverse")[0] for point in POINTS])
    return matrices, rows


def test_superposition_of_all_modes_is_the_direct_solution(composite):
    matrices, rows = composite
    frequency = np.linspace(0.0, 5e3, 101)
    direct = direct_receptance(*matrices, rows, rows, frequency)
    superposed = state_modes(*matrices).receptance(rows, rows, frequency)
    assert np.abs(superposed - direct).max() < 1e-8 * np.abs(direct).max()
    # Reciprocity: a force and a displacement that change places.
    np.testing.assert_allclose(direct[:, 0, 1], direct[:, 1, 0], rtol=1e-7)


def test_the_residual_term_stands_for_what_is_left_out(composite):
    """Its error goes with the square of the frequency over that of the first mode left out."""
    matrices, rows = composite
    modes = state_modes(*matrices)
    kept = modes.below(2e3)
    assert kept.sum() == 6
    assert modes.residual(rows, rows, kept)[0, 0] > 0
    frequency = np.array([0.0, 250.0, 500.0])
    gap = np.abs(
        modes.receptance(rows, rows, frequency, kept) - modes.receptance(rows, rows, frequency)
    )
    static = np.abs(modes.residual(rows, rows, kept)).max()
    assert gap[0].max() < 1e-9 * static
    assert gap[2].max() / gap[1].max() == pytest.approx(4.0, rel=0.15)


def test_the_residual_of_one_oscillator_of_two():
    """By hand: two oscillators side by side, of which the stiffer one is left out."""
    mass, damping, stiffness = np.eye(2), np.diag([0.1, 2.0]), np.diag([1e2, 1e6])
    modes = state_modes(mass, damping, stiffness)
    both = np.array([[1.0, 1.0]])
    kept = modes.below(100.0)
    np.testing.assert_allclose(np.abs(modes.poles[kept]), 10.0)
    assert modes.residual(both, both, kept)[0, 0] == pytest.approx(1e-6)


def test_the_answer_to_a_pulse_is_that_of_the_matrix_exponential(composite):
    (mass, damping, stiffness), rows = composite
    modes = state_modes(mass, damping, stiffness)
    pulse = HalfSinePulse(3.0, 2e-4, start=1e-4)
    time = np.linspace(0.0, 2e-3, 21)
    found = pulse_response(modes.poles, modes.residues(rows, rows[:1])[:, :, 0], pulse, time)
    size, rate = len(mass), np.pi / pulse.duration
    # Two more states make the half-sine.
    state = np.zeros((2 * size + 2, 2 * size + 2))
    state[:size, size:-2] = np.eye(size)
    state[size:-2, :size] = -np.linalg.solve(mass, stiffness)
    state[size:-2, size:-2] = -np.linalg.solve(mass, damping)
    state[size:-2, -2] = np.linalg.solve(mass, rows[0])
    state[-2, -1], state[-1, -2] = rate, -rate
    start = np.zeros(2 * size + 2)
    start[-1] = pulse.peak_force
    ended = scipy.linalg.expm(state * pulse.duration) @ start
    ended[-2:] = 0
    for t, displacement in zip(time, found, strict=True):
        since = max(0.0, t - pulse.start)
        if since <= pulse.duration:
            exact = scipy.linalg.expm(state * since) @ start
        else:
            exact = scipy.linalg.expm(state * (since - pulse.duration)) @ ended
        assert displacement == pytest.approx(rows @ exact[:size], abs=1e-6 * np.abs(found).max())


def test_the_spectra_of_pulse_and_answer_give_the_receptance(composite):
    """The closed forms in time, in frequency and of the pulse belong together."""
    matrices, rows = composite
    modes = state_modes(*matrices)
    pulse = HalfSinePulse(1.0, 3e-4, start=1e-3)
    time = np.arange(0.0, 1.7, 2e-5)
    motion = pulse_response(modes.poles, modes.residues(rows[1:], rows[:1])[:, :, 0], pulse, time)
    frequency = np.array([300.0, 880.0, 1024.0, 1400.0])
    turning = np.exp(-2j * np.pi * frequency[:, None] * time)
    spectrum = 2e-5 * turning @ motion[:, 0]
    exact = modes.receptance(rows[1:], rows[:1], frequency)[:, 0, 0]
    gap = np.abs(spectrum / pulse.spectrum(frequency) - exact)
    assert gap.max() < 2e-3 * np.abs(exact).max()


def test_critical_damping_is_no_sum_of_modes():
    with pytest.raises(ComputationError, match=r"meet in one pole.*change the damping ratio"):
        state_modes(np.eye(1), np.array([[2.0]]), np.eye(1))
