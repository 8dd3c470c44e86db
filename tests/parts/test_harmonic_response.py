"""Receptances and harmonic transfer functions: constant systems in disguise, harmonic balance."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from flexmech import ComputationError, InputError, LinkPoint, ReferenceEngine, load_mechanism
from flexmech.dynamical_systems import (
    ForcedPeriodicSystem,
    FourierSeries,
    SampledPeriodicSystem,
    balanced_response,
    direct_receptance,
    harmonic_response,
)
from flexmech.mechanics import point_rows
from flexmech.solvers import forced_linkage
from flexmech.solvers.stability import LinkageSolver

FloatArray = NDArray[np.float64]
ORDERS = np.arange(-2, 3)
CENTRE = 2
NOTHING = FourierSeries.constant(np.zeros(()))


def test_receptance_of_an_oscillator_is_the_textbooks() -> None:
    """``1 / (k - m w^2 + i c w)``."""
    m, c, k, frequency = 2.0, 3.0, 800.0, np.array([0.0, 2.0, np.sqrt(400.0) / (2 * np.pi), 9.0])
    one = np.eye(1)
    found = direct_receptance(m * one, c * one, k * one, one, one, frequency)[:, 0, 0]
    w = 2 * np.pi * frequency
    assert found == pytest.approx(1 / (k - m * w**2 + 1j * c * w), rel=1e-12)


def coupled() -> ForcedPeriodicSystem:
    """A damped system of two coordinates whose coefficients change strongly along a period."""
    phase = 2 * np.pi * np.arange(33) / 33
    cosine, sine = np.cos(phase), np.sin(phase)
    matrix, force, reading = np.zeros((33, 4, 4)), np.zeros((33, 4)), np.zeros((33, 4))
    matrix[:, 0, 2] = matrix[:, 1, 3] = 1.0
    matrix[:, 2, 0], matrix[:, 3, 1] = -40 - 8 * cosine, -90 + 9 * np.cos(2 * phase)
    matrix[:, 2, 1] = matrix[:, 3, 0] = 3 * sine
    matrix[:, 2, 2], matrix[:, 3, 3] = -0.3, -0.4
    matrix[:, 2, 3], matrix[:, 3, 2] = cosine, -cosine
    force[:, 2], force[:, 3] = 1 + 0.3 * cosine, 0.2
    reading[:, 0], reading[:, 1] = 0.4 * np.sin(2 * phase), 1.0
    series = FourierSeries.through
    return ForcedPeriodicSystem(
        SampledPeriodicSystem(series(matrix), 1.3), series(force), series(reading), NOTHING
    )


def in_turning_axes(
    matrix: FloatArray, force: FloatArray, reading: FloatArray, period: float
) -> ForcedPeriodicSystem:
    """A constant system of two coordinates, written in axes that turn once a period."""
    phase, turning = 2 * np.pi * np.arange(9) / 9, 2 * np.pi / period
    quarter = np.kron(np.eye(2), np.array([[0.0, -1.0], [1.0, 0.0]]))
    # x = turned @ states
    turned = np.cos(phase)[:, None, None] * np.eye(4) + np.sin(phase)[:, None, None] * quarter
    back = np.swapaxes(turned, 1, 2)
    series = FourierSeries.through
    return ForcedPeriodicSystem(
        SampledPeriodicSystem(series(back @ (matrix @ turned) - turning * quarter), period),
        series(back @ force),
        series(reading @ turned),
        NOTHING,
    )


def test_turning_axes_do_not_change_what_a_constant_system_answers() -> None:
    generator = np.random.default_rng(3)
    matrix = generator.normal(size=(4, 4)) - 2.5 * np.eye(4)
    force, reading = generator.normal(size=(2, 4))
    turned = in_turning_axes(matrix, force, reading, 1.7)
    frequency = np.linspace(-1.0, 2.0, 31)
    rate = 2j * np.pi * frequency[:, None, None]
    plain = np.linalg.solve(rate * np.eye(4) - matrix, np.tile(force[:, None], (31, 1, 1)))
    plain = plain[..., 0] @ reading
    for found in (
        harmonic_response(turned, frequency, ORDERS, 512),
        balanced_response(turned, frequency, ORDERS, 3),
    ):
        assert found[CENTRE] == pytest.approx(plain, rel=1e-9)
        assert np.abs(np.delete(found, CENTRE, axis=0)).max() < 1e-9 * np.abs(plain).max()


def test_harmonics_of_the_force_on_a_constant_system_answer_at_their_frequencies() -> None:
    """A force, a reading and a residual that change along the period, by harmonic balance too."""
    generator = np.random.default_rng(4)
    matrix = FourierSeries.constant(generator.normal(size=(4, 4)) - 2.5 * np.eye(4))
    force, reading = map(FourierSeries.through, generator.normal(size=(2, 5, 4)))
    residual = FourierSeries.through(generator.normal(size=5))
    forced = ForcedPeriodicSystem(SampledPeriodicSystem(matrix, 1.7), force, reading, residual)
    frequency = np.linspace(-1.0, 2.0, 31)
    balanced = balanced_response(forced, frequency, ORDERS, 4)
    found = harmonic_response(forced, frequency, ORDERS, 16)
    np.testing.assert_allclose(found, balanced, rtol=0, atol=1e-12 * np.abs(balanced).max())


def test_error_of_the_harmonic_response_falls_with_the_sixth_power_of_the_step() -> None:
    forced, frequency = coupled(), np.linspace(0.0, 3.0, 50)
    exact = balanced_response(forced, frequency, ORDERS, 25)
    errors = [
        np.abs(harmonic_response(forced, frequency, ORDERS, steps) - exact).max()
        for steps in (32, 64, 128)
    ]
    assert all(np.log2(coarse / fine) > 5.5 for coarse, fine in pairwise(errors))
    assert errors[-1] < 1e-10 * np.abs(exact).max()


def test_a_negative_frequency_gives_the_conjugate_of_the_opposite_order() -> None:
    forced, frequency = coupled(), np.linspace(0.1, 3.0, 20)
    ahead = harmonic_response(forced, frequency, ORDERS, 64)
    behind = harmonic_response(forced, -frequency, -ORDERS, 64)
    np.testing.assert_allclose(behind, ahead.conj(), rtol=1e-10)


def test_modes_that_coincide_answer_as_harmonic_balance_says() -> None:
    """A Jordan block in turning axes has one Floquet mode where there should be two."""
    matrix = np.diag([-0.3, -0.3, -2.0, -3.0])
    matrix[0, 1] = 1.0
    turned = in_turning_axes(matrix, np.ones(4), np.ones(4), 1.7)
    frequency = np.array([0.0, 0.01, 0.5])
    found = harmonic_response(turned, frequency, ORDERS, 512)
    exact = balanced_response(turned, frequency, ORDERS, 3)
    np.testing.assert_allclose(found, exact, atol=1e-9 * np.abs(exact).max())


@pytest.fixture(scope="module")
def running() -> ForcedPeriodicSystem:
    """The aluminium four-bar at 20 rad/s, hit in the coupler's middle and seen in the rocker's."""
    mechanism = load_mechanism("models/aluminium_fourbar.toml")
    sections = {k: s.with_damping_time(4e-5) for k, s in mechanism.sections.items()}
    engine = ReferenceEngine(replace(mechanism, sections=sections), 4)
    moving = LinkageSolver(engine, "equilibrium", 3).moving_modes(20.0)
    stressed = engine.stressed_links(moving.turn.motion, "equilibrium")
    return forced_linkage(moving, stressed, LinkPoint("coupler", 0.5), LinkPoint("rocker", 0.5))


def test_a_running_linkage_answers_as_harmonic_balance_says(running: ForcedPeriodicSystem) -> None:
    frequency = np.array([0.0, 44.0, 48.5, 120.0])
    balanced = balanced_response(running, frequency, ORDERS, 40)
    found = harmonic_response(running, frequency, ORDERS, 640)
    for order, reference in zip(found, balanced, strict=True):
        np.testing.assert_allclose(order, reference, atol=1e-6 * np.abs(reference).max())


def test_a_rotating_arm_answers_as_the_constant_system_with_rotation_terms() -> None:
    mechanism = load_mechanism("models/rotating_arm.toml")
    sections = {"arm": mechanism.sections["arm"].with_damping_time(1e-5)}
    engine = ReferenceEngine(replace(mechanism, sections=sections), 4, component_modes=False)
    hit, seen = LinkPoint("arm", 1.0), LinkPoint("arm", 0.6)
    moving = LinkageSolver(engine, "equilibrium", 3).moving_modes(60.0)
    stressed = engine.stressed_links(moving.turn.motion, "equilibrium")
    frequency = np.linspace(0.0, 60.0, 40)
    found = harmonic_response(forced_linkage(moving, stressed, hit, seen), frequency, ORDERS, 128)
    plain = {}
    for terms in (True, False):
        system = engine.linear_system(0.0, 60.0, rotation_terms=terms)
        rows = (point_rows(system, point, "transverse")[0][None] for point in (seen, hit))
        matrices = system.mass[0], system.damping[0], system.stiffness[0]
        plain[terms] = direct_receptance(*matrices, *rows, frequency)[:, 0, 0]
    np.testing.assert_allclose(found[CENTRE], plain[True], rtol=1e-9)
    assert not np.delete(found, CENTRE, axis=0).any()
    assert np.abs(plain[False] / plain[True] - 1).max() > 1e-3


def test_what_grows_beyond_all_numbers_and_what_is_no_frequency_are_refused() -> None:
    growing = in_turning_axes(900.0 * np.eye(4), np.ones(4), np.ones(4), 1.7)
    with pytest.raises(ComputationError, match="grow beyond all numbers"):
        harmonic_response(growing, [1.0], ORDERS, 4096)
    with pytest.raises(InputError, match="frequency"):
        harmonic_response(coupled(), [np.nan], ORDERS, 64)
