"""Tolerances of motion in time: each test fails if its constant is taken away or is another one."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from flexmech.errors import ComputationError
from flexmech.linkages import ConstantSpeed
from flexmech.time_domain.integrators import runs
from flexmech.time_domain.integrators.position_table import PositionTable
from flexmech.time_domain.periodic_motion import forced_modes, nonlinear_orbit, orbit_newton
from flexmech.time_domain.periodic_motion.moving_modes import counts_of_modes
from flexmech.time_domain.recorded_runs.states import ShaftMotion

# --- positions of a turn ------------------------------------------------------------------------


def interpolated(fastest, harmonic, *, connected=False):
    """Error of a wave over a turn by interpolation, and the positions solved for that."""
    solved = []

    def wave(time):
        return np.cos(2 * np.pi * harmonic * time)

    def solve(time):
        solved.extend(time)
        return [wave(time)[:, None]]

    speeds = 2 * np.pi * np.stack([np.ones(361), np.full(361, fastest)], axis=1)
    linkage = SimpleNamespace(
        drive=ConstantSpeed(2 * np.pi),
        connectors=SimpleNamespace(any=connected, is_interpolated=True),
        motion=lambda time: SimpleNamespace(angular_velocity=speeds),
    )
    time = np.linspace(0.0, 0.999, 3001)
    found = PositionTable(linkage, solve).at(time)[0][:, 0]
    return np.abs(found - wave(time)).max(), len(solved)


def test_positions_of_a_turn_are_as_close_as_links_turn_fast():
    """The third harmonic of the angle of a link that turns three times as fast as the crank."""
    error, count = interpolated(3.0, 9)
    assert 1e-12 < error < 1e-9
    assert count < 300
    # Of springs the sixth one.
    error, _ = interpolated(3.0, 18, connected=True)
    assert 1e-12 < error < 1e-9


def test_the_weight_of_an_arm_has_positions_enough():
    error, count = interpolated(1.0, 3)
    assert error < 1e-9
    assert count < 200


def test_displacements_beyond_any_linkage_diverge():
    linkage = SimpleNamespace(prestress="none", drive=ConstantSpeed(1.0))
    for size, refused in ((1e5, False), (1e7, True)):
        history = SimpleNamespace(position=np.array([[0.0], [size]]))
        if refused:
            with pytest.raises(ComputationError, match="diverges"):
                runs._refuse_divergence(linkage, np.arange(2.0), history)
        else:
            runs._refuse_divergence(linkage, np.arange(2.0), history)


def test_shafts_run_away_beyond_a_quarter_of_a_turn():
    for angle, refused in ((1.2, False), (-2.0, True)):
        shaft = SimpleNamespace(rotation=np.array([0.0, angle]))
        if refused:
            with pytest.raises(ComputationError, match="behind its prescribed"):
                ShaftMotion.refuse_runaway(shaft, ConstantSpeed(1.0), np.arange(2.0))
        else:
            ShaftMotion.refuse_runaway(shaft, ConstantSpeed(1.0), np.arange(2.0))


# --- moving modes -------------------------------------------------------------------------------


def turn_of(frequency, common):
    overlap = dict(enumerate(common, 1))
    return SimpleNamespace(
        frozen_squares=np.square(np.asarray(frequency, dtype=float))[None],
        frames=SimpleNamespace(size=len(frequency)),
        rigid_modes=0,
        is_constant=False,
        subspace=lambda count: SimpleNamespace(least_common=np.array([overlap[count]])),
    )


def test_subspaces_of_moving_modes_are_smooth():
    """Those end before a gap, and are like their fixed basis."""
    steps = [1.5, 1.5, 1.05, 1.15, 1.5, 1.5]
    frequency = np.cumprod([1.0, *steps])
    assert counts_of_modes(turn_of(frequency, [1.0] * 7), 2, 1) == [4]
    frequency = np.cumprod([1.0] + [1.5] * 6)
    assert counts_of_modes(turn_of(frequency, [1.0, 1.0, 0.1, 0.3, 1.0, 1.0, 1.0]), 2, 1) == [4]


def test_the_end_of_a_subspace_is_sought_among_ten_modes():
    frequency = np.cumprod([1.0] + [1.01] * 6 + [1.5] + [1.01] * 30)
    assert counts_of_modes(turn_of(frequency, [1.0] * 38), 2, 1) == [7]
    frequency = np.cumprod([1.0] + [1.01] * 15 + [1.5] + [1.01] * 30)
    assert counts_of_modes(turn_of(frequency, [1.0] * 47), 2, 1)[0] <= 12


def splined(waves, steps):
    """Greatest error of a spline through samples of so many waves of a turn, inside it."""
    place = np.linspace(0.0, 1.0, steps + 1)
    wave = CubicSpline(place, np.sin(2 * np.pi * waves * place + 1.0))
    fine = np.linspace(0.2, 0.8, 4001)
    return np.abs(wave(fine) - np.sin(2 * np.pi * waves * fine + 1.0)).max()


def test_readings_between_steps_are_those_of_the_fastest_mode(monkeypatch):
    counted = []

    class EnoughError(Exception):
        pass

    def transitions(system, steps):
        counted.append(steps)
        raise EnoughError

    monkeypatch.setattr(forced_modes, "transition_matrices", transitions)
    nothing = SimpleNamespace(coefficients=np.zeros((1, 2, 2)), plus=None)
    for waves in (10.0, 200.0):
        own = SimpleNamespace(
            moving=SimpleNamespace(with_undamped_links=nothing),
            damping=(),
            size=2,
            force=SimpleNamespace(coefficients=np.zeros((1, 2))),
            period=1.0,
            fastest=2 * np.pi * waves,
        )
        with pytest.raises(EnoughError):
            forced_modes.ForcedModes.with_damping(own, ())
    # Of a slow linkage its loads, up to the 60th harmonic.
    for waves, steps in ((60, counted[0]), (200, counted[1])):
        assert 1e-5 < splined(waves, steps) < 1e-3


# --- orbits -------------------------------------------------------------------------------------


def orbit_of(monkeypatch, tails):
    """Samples that an orbit takes whose fastest harmonics are of these sizes."""
    taken = []

    def equations(engine, speed, count):
        taken.append(count)
        motion = SimpleNamespace(crank_angle=None)
        return SimpleNamespace(
            motion=motion, frames=SimpleNamespace(size=1), at_stations=lambda q: np.ones(1)
        )

    left = iter(tails)
    run = SimpleNamespace(state=SimpleNamespace(z=np.ones(1), displacement=None, error=0.0))
    monkeypatch.setattr(nonlinear_orbit, "OrbitEquations", equations)
    monkeypatch.setattr(nonlinear_orbit, "_equilibrium", lambda equations: None)
    monkeypatch.setattr(nonlinear_orbit, "_found", lambda *of: (run, 1))
    monkeypatch.setattr(nonlinear_orbit, "_tail", lambda moved: next(left))
    monkeypatch.setattr(nonlinear_orbit, "at_angles", lambda *of: None)
    monkeypatch.setattr(nonlinear_orbit, "_at", lambda *of: (None, None))
    nonlinear_orbit._orbit(None, 20.0, 8)
    return taken


def test_orbits_are_resolved_to_a_ten_thousandth_or_told_of(monkeypatch):
    assert orbit_of(monkeypatch, [5e-5]) == [128]
    assert orbit_of(monkeypatch, [2e-4, 5e-4]) == [128, 256]
    with pytest.raises(ComputationError, match="is not resolved"):
        orbit_of(monkeypatch, [2e-2, 2e-3])


class Scalar:
    """Equations of one number, whose linear answer is off by a factor."""

    mass = np.ones((1, 1, 1))

    def __init__(self, residual, slope):
        self.residual, self.slope, self.calls = residual, slope, 0

    def state(self, z, damping_rate=0.0):
        force = self.residual(z)
        return SimpleNamespace(z=z, residual=force, error=float(np.abs(force).max()), stressed=z)

    def linearized(self, stressed, damping_rate):
        return stressed

    def run(self, monkeypatch, start):
        own = self

        class Modal:
            def __init__(self, *of):
                pass

            def detuning(self, matrices):
                return 1.0

            def solve(self, matrices, force):
                own.calls += 1
                return force / own.slope(matrices), 1

        monkeypatch.setattr(orbit_newton, "_ModalPreconditioner", Modal)
        monkeypatch.setattr(orbit_newton, "_in_static_balance", lambda e, m, state, rate: state)
        return orbit_newton.newton(self, np.full((1, 1), float(start)))


def test_orbits_are_found_to_nine_digits_in_a_dozen_passes(monkeypatch):
    """Each pass leaves a part of the residual, as with matrices that are not quite the tangent."""

    def run(left):
        return Scalar(lambda z: z, lambda z: 1 / (1 - left)).run(monkeypatch, 1.0)

    found = run(0.2)
    assert found.converged
    assert 1e-10 < found.state.error <= 1e-9
    assert found.passes < 14
    assert not run(0.3).converged
    assert run(0.3).passes == 14
    # A correction that is as long as the step before is no progress.
    assert run(0.7).passes > 5
    assert run(0.8).passes == 0


def test_steps_are_shortened_sixty_fold(monkeypatch):
    """Newton's method for an arcus tangent goes too far by far."""

    def run(start):
        return Scalar(np.arctan, lambda z: 1 / (1 + z**2)).run(monkeypatch, start)

    assert run(8.0).converged
    assert not run(1000.0).converged
    assert run(1000.0).passes == 0
