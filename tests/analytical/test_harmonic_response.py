"""Harmonic transfer functions: constant systems in disguise, harmonic balance, running linkages."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from flexmech import (
    ComputationError,
    InputError,
    LinkPoint,
    Mechanism,
    ReferenceEngine,
    load_mechanism,
)
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.arrays import ComplexArray, FloatArray
from flexmech.dynamical_systems import (
    ForcedPeriodicSystem,
    FourierSeries,
    SampledPeriodicSystem,
    balanced_response,
    direct_receptance,
    harmonic_response,
)
from flexmech.linear_system import Engine, LinearSystem, point_rows
from flexmech.time_domain import forced_linkage
from flexmech.time_domain.periodic_motion.forced_linkage import residual_flexibility

ORDERS = np.arange(-2, 3)
CENTRE = 2
NOTHING = FourierSeries.constant(np.zeros(()))
HIT, SEEN = LinkPoint("coupler", 0.5), LinkPoint("rocker", 0.5)


def model(name: str, damping_time: float) -> Mechanism:
    mechanism = load_mechanism(f"models/{name}.toml")
    sections = {k: s.with_damping_time(damping_time) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def plain_response(
    system: LinearSystem, hit: LinkPoint, seen: LinkPoint, frequency: FloatArray
) -> ComplexArray:
    """Receptance of a constant system at its first position, by direct solution."""
    rows = (point_rows(system, point, "transverse")[0][None] for point in (seen, hit))
    return direct_receptance(
        system.mass[0], system.damping[0], system.stiffness[0], *rows, frequency
    )[:, 0, 0]


def coupled() -> ForcedPeriodicSystem:
    """A damped system of two coordinates whose coefficients change strongly along a period."""
    period = 1.3
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
        SampledPeriodicSystem(series(matrix), period), series(force), series(reading), NOTHING
    )


def in_turning_axes(
    matrix: FloatArray, force: FloatArray, reading: FloatArray, period: float
) -> ForcedPeriodicSystem:
    """A constant system of two coordinates, written in axes that turn once a period."""
    phase, turning = 2 * np.pi * np.arange(9) / 9, 2 * np.pi / period
    quarter = np.kron(np.eye(2), np.array([[0.0, -1.0], [1.0, 0.0]]))
    turned = (
        np.cos(phase)[:, None, None] * np.eye(4) + np.sin(phase)[:, None, None] * quarter
    )  # x = turned @ states
    back = np.swapaxes(turned, 1, 2)
    series = FourierSeries.through
    return ForcedPeriodicSystem(
        SampledPeriodicSystem(series(back @ (matrix @ turned) - turning * quarter), period),
        series(back @ force),
        series(reading @ turned),
        NOTHING,
    )


@pytest.fixture(scope="module")
def at_rest() -> LinearSystem:
    engine = ReferenceEngine(model("aluminium_fourbar", 4e-5), 4)
    return engine.linear_system(np.radians(96.9), 0.0)


def test_a_linkage_at_rest_answers_at_the_frequency_of_the_force_alone(
    at_rest: LinearSystem,
) -> None:
    frequency = np.linspace(0.0, 400.0, 60)
    force, reading = (point_rows(at_rest, point, "transverse")[0] for point in (HIT, SEEN))
    still = ForcedPeriodicSystem.constant(
        at_rest.mass[0], at_rest.damping[0], at_rest.stiffness[0], force, reading, period=0.3
    )
    found = harmonic_response(still, frequency, ORDERS, 16)
    plain = plain_response(at_rest, HIT, SEEN, frequency)
    np.testing.assert_allclose(found[CENTRE], plain, rtol=1e-9)
    assert not np.delete(found, CENTRE, axis=0).any()


@pytest.mark.parametrize("by", ["propagator", "balance"])
def test_turning_axes_do_not_change_what_a_constant_system_answers(by: str) -> None:
    generator = np.random.default_rng(3)
    matrix = generator.normal(size=(4, 4)) - 2.5 * np.eye(4)
    force, reading = generator.normal(size=(2, 4))
    turned = in_turning_axes(matrix, force, reading, 1.7)
    frequency = np.linspace(-1.0, 2.0, 31)
    found = (
        harmonic_response(turned, frequency, ORDERS, 512)
        if by == "propagator"
        else balanced_response(turned, frequency, ORDERS, 3)
    )
    rate = 2j * np.pi * frequency[:, None, None]
    plain = np.linalg.solve(rate * np.eye(4) - matrix, np.tile(force[:, None], (31, 1, 1)))
    plain = plain[..., 0] @ reading
    largest = np.abs(plain).max()
    np.testing.assert_allclose(found[CENTRE], plain, rtol=1e-9)
    np.testing.assert_allclose(np.delete(found, CENTRE, axis=0), 0.0, atol=1e-9 * largest)


def test_a_constant_system_answers_each_harmonic_of_a_force_at_its_own_frequency() -> None:
    """A force and a reading that change along the period, by harmonic balance as well."""
    generator = np.random.default_rng(4)
    matrix = FourierSeries.constant(generator.normal(size=(4, 4)) - 2.5 * np.eye(4))
    force, reading = map(FourierSeries.through, generator.normal(size=(2, 5, 4)))
    residual = FourierSeries.through(generator.normal(size=5))
    forced = ForcedPeriodicSystem(SampledPeriodicSystem(matrix, 1.7), force, reading, residual)
    frequency = np.linspace(-1.0, 2.0, 31)
    found = harmonic_response(forced, frequency, ORDERS, 16)
    balanced = balanced_response(forced, frequency, ORDERS, 4)
    np.testing.assert_allclose(found, balanced, rtol=0, atol=1e-12 * np.abs(balanced).max())


@pytest.mark.parametrize("crank_speed", [60.0, -60.0])
def test_a_rotating_arm_answers_as_the_constant_system_with_rotation_terms(
    crank_speed: float,
) -> None:
    engine = ReferenceEngine(model("rotating_arm", 1e-5), 4, component_modes=False)
    hit, seen = LinkPoint(engine.links[0].name, 1.0), LinkPoint(engine.links[0].name, 0.6)
    forced = linkage(engine, crank_speed, hit=hit, seen=seen)
    frequency = np.linspace(0.0, 60.0, 40)
    found = harmonic_response(forced, frequency, ORDERS, 128)
    plain = plain_response(engine.linear_system(0.0, crank_speed), hit, seen, frequency)
    np.testing.assert_allclose(found[CENTRE], plain, rtol=1e-9)
    assert not np.delete(found, CENTRE, axis=0).any()
    still = plain_response(
        engine.linear_system(0.0, crank_speed, rotation_terms=False), hit, seen, frequency
    )
    assert np.abs(still / plain - 1).max() > 1e-3


def linkage(
    engine: Engine,
    crank_speed: float,
    modes: int = 3,
    hit: LinkPoint = HIT,
    seen: LinkPoint = SEEN,
) -> ForcedPeriodicSystem:
    moving = LinkageSolver(engine, "equilibrium", modes).moving_modes(crank_speed)
    stressed = engine.stressed_links(moving.turn.motion, "equilibrium")
    return forced_linkage(moving, stressed, hit, seen)


@pytest.fixture(scope="module")
def running() -> ForcedPeriodicSystem:
    return linkage(ReferenceEngine(model("aluminium_fourbar", 4e-5), 4), 20.0)


def test_harmonic_balance_gives_the_same_response_of_a_running_linkage(
    running: ForcedPeriodicSystem,
) -> None:
    frequency = np.array([0.0, 30.0, 44.0, 48.5, 120.0])
    balanced = balanced_response(running, frequency, ORDERS, 40)
    found = harmonic_response(running, frequency, ORDERS, 640)
    for order, reference in zip(found, balanced, strict=True):
        np.testing.assert_allclose(order, reference, atol=1e-6 * np.abs(reference).max())


def test_the_propagators_error_falls_with_the_sixth_power_of_its_step() -> None:
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


def test_few_moving_modes_do_with_the_static_answer_of_what_they_leave_out() -> None:
    """Hit and seen at the same point, where the modes left out answer most."""
    engine, point = ReferenceEngine(model("aluminium_fourbar", 4e-5), 4), LinkPoint("coupler", 0.25)
    frequency = np.linspace(0.0, 30.0, 7)
    few, many = (linkage(engine, 20.0, modes, point, point) for modes in (3, 8))
    bare = replace(few, residual=NOTHING)
    # The steps resolve the fastest of the many modes.
    whole = harmonic_response(many, frequency, [0], 1600)
    with_rest, without = (harmonic_response(f, frequency, [0], 640) for f in (few, bare))
    error, missing = (np.abs(found / whole - 1).max() for found in (with_rest, without))
    assert error < 1e-3
    assert missing > 10 * error


def test_few_coordinates_all_move() -> None:
    """One element a link has fewer coordinates than modes are asked for."""
    engine = ReferenceEngine(model("aluminium_fourbar", 0.0), 1)
    frequency = np.linspace(0.0, 40.0, 5)
    few, all_of_them = (linkage(engine, 20.0, modes) for modes in (4, 16))
    found, whole = (harmonic_response(f, frequency, ORDERS, 4096) for f in (few, all_of_them))
    np.testing.assert_allclose(found, whole, atol=1e-2 * np.abs(whole).max())


def test_nothing_is_left_out_where_all_coordinates_move() -> None:
    engine = ReferenceEngine(model("rotating_arm", 0.0), 3)
    moving = LinkageSolver(engine, "equilibrium", 2).moving_modes(50.0)
    stressed = engine.stressed_links(moving.turn.motion, "equilibrium")
    point = LinkPoint(engine.links[0].name, 1.0)
    assert not residual_flexibility(moving, stressed, point, point).any()


def test_modes_may_coincide() -> None:
    """A Jordan block in turning axes has one Floquet mode where there should be two."""
    matrix = np.diag([-0.3, -0.3, -2.0, -3.0])
    matrix[0, 1] = 1.0
    turned = in_turning_axes(matrix, np.ones(4), np.ones(4), 1.7)
    frequency = np.array([0.0, 0.01, 0.5])
    found = harmonic_response(turned, frequency, ORDERS, 512)
    exact = balanced_response(turned, frequency, ORDERS, 3)
    np.testing.assert_allclose(found, exact, atol=1e-9 * np.abs(exact).max())


def test_modes_that_die_out_at_once_answer_as_harmonic_balance_says() -> None:
    """Heavily damped links creep back by exp(-1e4) in a turn, and faster at some crank angles."""
    engine = ReferenceEngine(model("aluminium_fourbar", 4e-3), 4)
    forced, frequency = linkage(engine, 20.0, 6, HIT, SEEN), np.array([0.0, 20.0, 44.0])
    found = harmonic_response(forced, frequency, ORDERS, 5120)
    balanced = balanced_response(forced, frequency, ORDERS, 40)
    for order, reference in zip(found, balanced, strict=True):
        np.testing.assert_allclose(order, reference, atol=1e-6 * np.abs(balanced).max())


def test_growth_beyond_all_numbers_is_refused() -> None:
    growing = in_turning_axes(900.0 * np.eye(4), np.ones(4), np.ones(4), 1.7)
    with pytest.raises(ComputationError, match="grow beyond all numbers"):
        harmonic_response(growing, [1.0], ORDERS, 4096)


def test_a_frequency_that_is_none_is_refused() -> None:
    with pytest.raises(InputError, match="frequency"):
        harmonic_response(coupled(), [np.nan], ORDERS, 64)
