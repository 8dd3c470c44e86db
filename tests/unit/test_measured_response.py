"""Impacts on a made-up periodic system whose harmonic transfer functions are known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from flexmech import ComputationError, RunningHammerRequest
from flexmech.analyses.running_hammer.measured import MeasuredResponse, measured_response
from flexmech.analyses.running_hammer.plan import RunPlan
from flexmech.arrays import ComplexArray, FloatArray
from flexmech.dynamical_systems import HalfSinePulse

STEPS, TURNS = 200, 8
PLAN = RunPlan(
    turn_time=1.0,
    turns=TURNS,
    steps=STEPS,
    phase=(np.arange(9) + 0.5 + 0.1 * np.sin(np.arange(9))) / 9,
    pulse=0.05,
    peak_force=1.0,
    bandwidth=15.0,
    fitted=3,
)
REQUEST = RunningHammerRequest(2 * np.pi, orders=1, damping_ratio=0.1)
SWING = 0.4
"""The reading swings by so much with the crank: H_1 and H_-1 are half of it times H_0."""
TWIN = 3.0


def oscillator(frequency: FloatArray) -> ComplexArray:
    """Receptance at 6 Hz with a damping ratio of 8 %."""
    s, natural = 2j * np.pi * frequency, 2 * np.pi * 6.0
    return 1 / (s**2 + 2 * 0.08 * natural * s + natural**2)


def linear(pulses: Sequence[HalfSinePulse]) -> FloatArray:
    """What the impacts add, at every step of a run."""
    frequency = PLAN.resolution * np.arange(PLAN.samples // 2 + 1)
    force = sum((pulse.spectrum(frequency) for pulse in pulses), np.zeros(len(frequency)))
    moved = np.fft.irfft(oscillator(frequency) * force, PLAN.samples) / PLAN.step
    phase = 2 * np.pi * np.arange(PLAN.samples) / STEPS
    return np.append((1 + SWING * np.cos(phase)) * moved, 0.0)


def run_with(
    curvature: float = 0.0, corner: float = 0.0
) -> Callable[[Sequence[HalfSinePulse]], FloatArray]:
    """Runs about a motion of the twin; a curvature fades out as impacts shrink, a corner stays."""
    motion = TWIN * np.sin(2 * np.pi * np.arange(PLAN.samples + 1) / STEPS)

    def run(pulses: Sequence[HalfSinePulse]) -> FloatArray:
        added = linear(pulses)
        return motion + added + curvature * added**2 + corner * np.abs(added)

    return run


def measured(
    run: Callable[[Sequence[HalfSinePulse]], FloatArray], request: RunningHammerRequest = REQUEST
) -> MeasuredResponse:
    return measured_response(run, request, PLAN, lambda label, done, total: None)


def known(order: int) -> ComplexArray:
    return oscillator(PLAN.frequency) * (1.0 if order == 0 else SWING / 2 * (abs(order) == 1))


def test_known_functions_are_identified() -> None:
    found = measured(run_with())
    largest = np.abs(known(0)).max()
    for place, order in enumerate(range(-3, 4)):
        np.testing.assert_allclose(
            found.estimate.response[place], known(order), atol=1e-4 * largest
        )
    assert found.halving_change.max() < 1e-9
    assert found.estimate.misfit < 1e-4
    assert found.plan.peak_force == PLAN.peak_force
    assert found.twin_defect < 1e-9


def test_impacts_are_halved_until_that_changes_nothing() -> None:
    strong = measured(run_with(curvature=60.0))
    assert strong.plan.peak_force in (0.5, 0.25, 0.125)
    assert strong.halving_change.max() < 0.01
    np.testing.assert_allclose(
        strong.estimate.response[3], known(0), atol=0.03 * np.abs(known(0)).max()
    )


def test_runs_that_are_never_linear_are_refused() -> None:
    """A quadratic term so strong that five times half the force does not do."""
    with pytest.raises(ComputationError, match="halving the impacts still changes"):
        measured(run_with(curvature=3e4))


def test_averages_bring_noise_down_by_the_root_of_their_number() -> None:
    errors = []
    for averages in (1, 16):
        found = measured(run_with(), replace(REQUEST, noise=0.05, averages=averages))
        errors.append(np.abs(found.estimate.response[3] - known(0)).mean())
    assert 2.5 < errors[0] / errors[1] < 6
    again = measured(run_with(), replace(REQUEST, noise=0.05))
    assert np.abs(again.estimate.response[3] - known(0)).mean() == errors[0]


def test_what_is_left_in_the_last_turn_is_told() -> None:
    found = measured(run_with())
    assert found.decay.shape == (9,)
    assert 0 < found.decay.max() < 1e-4
    assert found.peak_response == pytest.approx(
        max(np.abs(linear([pulse])).max() for pulse in PLAN.pulses())
    )
