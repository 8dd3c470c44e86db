"""When searches for motions go on, take more effort, are content and give up."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from flexmech import ReferenceEngine
from flexmech.errors import ComputationError
from flexmech.linkages import ConstantSpeed
from flexmech.time_domain import DrivenLinkage, LinkState, simulated_orbit, static_balance
from flexmech.time_domain.integrators import stretch_march
from flexmech.time_domain.integrators.stage_operators import stage_operators
from flexmech.time_domain.periodic_motion import nonlinear_orbit as orbits
from flexmech.time_domain.periodic_motion import shooting

STEP = 1e-4


@pytest.fixture(scope="module")
def stretching(aluminium):
    engine = ReferenceEngine(aluminium, elements=2)
    return DrivenLinkage(engine, ConstantSpeed(20.0), stretches=True)


def test_a_step_takes_more_passes_where_they_gain_little(stretching, monkeypatch):
    march, taken = stretch_march.StretchMarch(stretching, STEP), []
    changes = iter([])

    def passes_of(rows, start, passes):
        taken.append(passes)
        history = np.zeros((3, 2, stretching.size))
        history[place, 0, 0] = 1.0
        return history, next(changes)

    monkeypatch.setattr(march, "_fixed_passes", passes_of)
    monkeypatch.setattr(stretch_march, "_newton", lambda *rest: taken.append("newton"))

    def passes(*scripted):
        nonlocal changes
        taken.clear()
        changes = iter(scripted)
        march._block(None, None)
        return list(taken)

    # Against H^2 z'' of one.
    place = 2
    assert passes(9e-4) == [2]
    assert passes(2e-3, 9e-4) == [2, 3]
    assert passes(9e-4) == [3]
    assert passes(3e-5) == [3]
    assert passes(9e-4) == [2]
    assert passes(1.0, 1.0, 1.0, np.inf) == [2, 3, 4, 6, "newton"]
    # Links that are at rest have a position of one.
    march.restart()
    place = 0
    assert passes(9e-10) == [2]
    assert passes(2e-9, 9e-10) == [2, 3]


def test_newtons_method_goes_to_round_off_and_holds_a_link_at_rest(unit_arm, monkeypatch):
    """In its own frame an arm that turns evenly rests, once it is stretched."""
    engine = ReferenceEngine(unit_arm(100.0), elements=2)
    linkage = DrivenLinkage(engine, ConstantSpeed(1.0), "none", stretches=True)
    rest = static_balance(linkage, np.zeros(linkage.size))
    time = np.array([STEP, 2 * STEP])
    rows = stage_operators(linkage.equations(time), linkage.stretch, 2 * STEP)
    forces = stretch_march.StretchForces(linkage.stretch, 2, 2 * STEP)
    start = np.zeros((3, linkage.size))
    start[0] = rest
    moved = stretch_march._newton(rows, forces, linkage.stretch, start, 2 * STEP)
    assert np.abs(moved[0] - rest).max() < 1e-9 * np.abs(rest).max()


def test_newtons_method_of_a_bow_goes_to_round_off(stretching, monkeypatch):
    rows = stage_operators(stretching.equations(np.array([0.01, 0.02])), stretching.stretch, 0.02)
    forces = stretch_march.StretchForces(stretching.stretch, 2, 0.02)
    start = np.zeros((3, stretching.size))
    found = stretch_march._newton(rows, forces, stretching.stretch, start, 0.02)[0]
    monkeypatch.setattr(stretch_march, "NEWTON_CHANGE", 1e-13)
    exact = stretch_march._newton(rows, forces, stretching.stretch, start, 0.02)[0]
    assert np.abs(found - exact).max() < 1e-11 * np.abs(exact).max()


@pytest.fixture(scope="module")
def linear(aluminium):
    return DrivenLinkage(ReferenceEngine(aluminium, elements=2), ConstantSpeed(20.0), "none")


def orbit(linkage, closures):
    """Search among turns that end so far from their start, over their greatest displacement."""
    left = iter(closures)

    def turn(start: LinkState):
        away = 1 - next(left)
        pairs = (start.displacement, [away * q for q in start.displacement])
        displacement = [np.stack(pair) for pair in zip(*pairs, strict=True)]
        return SimpleNamespace(displacement=displacement, rate=[0 * q for q in displacement])

    return simulated_orbit(linkage, 100, turn)


def test_turns_are_simulated_until_one_closes(linear):
    found = orbit(linear, [1e-2, 1e-3, 1.5e-4])
    assert found.turns == 3
    assert found.closure == pytest.approx(1.5e-4)
    # The best of turns that come no nearer counts where it closes nearly.
    assert orbit(linear, [1e-2, 1.5e-3, 1.6e-3]).closure == pytest.approx(1.5e-3)
    with pytest.raises(ComputationError, match=r"the best of 3 turns ends 0\.25 %"):
        orbit(linear, [1e-2, 2.5e-3, 2.6e-3])
    with pytest.raises(ComputationError, match="the best of 12 turns"):
        orbit(linear, np.linspace(0.9, 0.1, 20))


def damped_motions(monkeypatch, finds):
    """Damping over the crank speed of the motions that are looked for one after the other."""
    rates = []

    def newton(equations, start, rate):
        rates.append(rate / 10.0)
        state = SimpleNamespace(z=None)
        return orbits.NewtonRun(state, finds(rate / 10.0, rates), 1, 1.0)

    monkeypatch.setattr(orbits, "newton", newton)
    equations = SimpleNamespace(crank_speed=-10.0, state=lambda z: None)
    run, passes = orbits._by_continuation(equations, None)
    assert passes == len(rates)
    return run.converged, rates


def test_damping_falls_ever_faster_where_motions_are_found(monkeypatch):
    found, rates = damped_motions(monkeypatch, lambda rate, rates: True)
    assert found
    assert rates == pytest.approx([2.0, 2.0 * 0.4**1.5, 2.0 * 0.4 ** (1.5 + 2.25), 0.0])


def test_damping_falls_less_where_a_motion_is_not_found(monkeypatch):
    found, rates = damped_motions(monkeypatch, lambda rate, rates: rate > 0.7)
    assert not found
    assert 0.7 < min(rate for rate in rates if rate > 0.7) < 0.8
    assert len(rates) <= 16
    found, rates = damped_motions(monkeypatch, lambda rate, rates: False)
    assert not found
    assert rates == [2.0]


def test_a_motion_that_a_turn_returns_to_itself_is_refused():
    unit = SimpleNamespace(stiffness=np.eye(1)[None], mass=np.eye(1)[None])
    linkage = SimpleNamespace(
        equations=lambda time: unit, drive=SimpleNamespace(speed=3.0, revolution_time=2.0), size=1
    )
    forced = np.array([1e-3, 0.0])
    found = shooting._fixed_point(linkage, np.diag([1 - 1e-6, 0.0]), forced)
    assert found == pytest.approx([1e3, 0.0])
    with pytest.raises(ComputationError, match="is critical: a free vibration fits one turn"):
        shooting._fixed_point(linkage, np.diag([1 - 1e-8, 0.0]), forced)


@pytest.mark.parametrize("steps", [360, 1440])
def test_an_arm_at_its_critical_speed_is_refused(unit_arm, steps):
    """Twice its weight's turn fits a period of the arm, with the lag of the steps to all digits."""
    engine = ReferenceEngine(unit_arm(70.0), elements=2)

    def linkage(speed):
        return DrivenLinkage(engine, ConstantSpeed(speed), "none", modes=1)

    def off(speed):
        """Angle by which a turn misses a whole number of periods of the slowest vibration."""
        multipliers = np.linalg.eigvals(shooting.turn_map(linkage(speed), steps)[0])
        slow = np.abs(multipliers - 1).argmin()
        return abs(np.angle(multipliers[slow]))

    low, high = 2.47, 2.49
    for _ in range(6):
        # The angle is a straight line to zero and up again.
        left, right = off(low), off(high)
        critical = (low * right + high * left) / (left + right)
        width = (high - low) / 100
        low, high = critical - width, critical + width
    with pytest.raises(ComputationError, match="is critical"):
        shooting.periodic_state(linkage(critical), steps)
    shooting.periodic_state(linkage(critical * (1 + 1e-6)), steps)


def test_an_orbit_about_which_a_vibration_fits_the_turn_is_refused(monkeypatch):
    equations = SimpleNamespace(crank_speed=10.0)
    state = SimpleNamespace(error=1.0)
    for detuning, refused in ((1e-6, False), (1e-8, True)):
        run = orbits.NewtonRun(state, True, 1, detuning)
        monkeypatch.setattr(orbits, "newton", lambda *of, run=run: run)
        if refused:
            with pytest.raises(ComputationError, match="is critical"):
                orbits._found(equations, None)
        else:
            assert orbits._found(equations, None) == (run, 1)
