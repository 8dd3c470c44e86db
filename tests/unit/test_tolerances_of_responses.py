"""Tolerances of runs, spectra and sweeps: each test fails if its constant is another one."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from flexmech.analyses.comparison.result import _warnings
from flexmech.analyses.response import (
    plan,
    run,
    run_errors,
    spectra,
    start,
    tension_at_start,
    words,
)
from flexmech.analyses.response.agreement import _large_bow
from flexmech.analyses.response.dataset import _frames
from flexmech.analyses.speed_sweep import compute as sweep
from flexmech.analyses.stability.words import shaft_lines
from flexmech.errors import ComputationError
from flexmech.linkages import ConstantSpeed

# --- samples and bands --------------------------------------------------------------------------


def test_samples_show_what_rings_half_again_as_fast_as_the_highest_frequency():
    request = SimpleNamespace(duration=1.0, sample_interval=0.01)
    for highest in (200.0, 500.0, 1000.0):
        rate = plan._refinement(request, highest) / request.sample_interval
        assert 2 * 1.4 * highest < rate < 2 * 2.2 * highest


def test_links_that_turn_without_stretching_are_loose():
    stiffness = np.diag([1e-11, 1e-9, 1.0])
    assert plan._lowest(stiffness, np.eye(3), loose=True) == pytest.approx(1e-9)


def test_forces_count_below_what_rings_along_the_links(monkeypatch):
    monkeypatch.setattr(plan, "_predicted_range", lambda *of: (40.0, 400.0, False))
    monkeypatch.setattr(plan, "lowest_axial_frequency", lambda *of: 8000.0)
    request = SimpleNamespace(
        duration=1.0,
        sample_interval=1e-3,
        sample_time=lambda refinement: None,
        drive=ConstantSpeed(20.0),
    )
    # Far above what bends, and below what rings so fast that the step decides on it.
    assert 5 * 400 < plan.planned([None], request).band < 0.75 * 8000


# --- steps --------------------------------------------------------------------------------------


class Off:
    """A run that is off by so much, and its limit of vanishing steps."""

    def __init__(self, step, error):
        self.step, self.error = step, error

    def extrapolated(self, coarser, order):
        gain = 1 / ((coarser.step / self.step) ** order - 1)
        return Off(self.step, self.error + gain * (self.error - coarser.error))


def steps_of(monkeypatch, error, *, stretches=False, unbalanced=0, band=0.1):
    """Steps a period of the highest frequency that are run, where each is off by so much."""
    steps = []
    monkeypatch.setattr(run, "stretches_in_runs", lambda *of: stretches)
    monkeypatch.setattr(run, "is_reduced", lambda engine: False)

    def taken(engine, request, plan, step, progress, detail, passes):
        steps.append(1 / step)
        if len(steps) <= unbalanced:
            raise run.UnbalancedStepError("no balance")
        return Off(step, error(step))

    def apart(first, finer, drive, left):
        part = 1.0 if left is None else left.part
        return run_errors.RunError(part * abs(first[1].error - finer[1].error), {})

    monkeypatch.setattr(run, "_run", taken)
    monkeypatch.setattr(run, "difference_of_runs", apart)
    own = SimpleNamespace(time=np.array([0.0, 1.0]), highest=1.0, band=band)
    engine = SimpleNamespace(name="reference", simulates=True)
    request = SimpleNamespace(step=None, prestress="none", drive=None)
    found = run.run_engine(engine, request, own, lambda *of: None)
    return steps, found.step_error.linkage, abs(found.trajectory.error)


def test_runs_are_halved_until_one_of_two_estimates_is_below_two_hundredths(monkeypatch):
    """A third of what halving changes of a run, or of the extrapolated one."""
    # Of second order alone, which extrapolation takes away: told as if it did not.
    steps, told, true = steps_of(monkeypatch, lambda step: 4 * step**2)
    assert steps == pytest.approx([8.0, 16.0])
    assert told == pytest.approx(4 / 16**2)
    assert true < 1e-12
    # Of which halving changes too much; the extrapolated run agrees with the next one.
    steps, told, true = steps_of(monkeypatch, lambda step: 80 * step**2 + 800 * step**4)
    assert steps == pytest.approx([8.0, 16.0, 32.0])
    assert 5e-3 < told <= 2e-2
    assert 4 * true < told < 6 * true
    assert len(steps_of(monkeypatch, lambda step: 80 * step**2 + 1600 * step**4)[0]) == 4


@pytest.mark.parametrize(("stretches", "order"), [(False, 2), (True, 4)])
def test_of_a_vibration_that_is_out_of_phase_more_than_all_of_the_change_is_left(
    monkeypatch, stretches, order
):
    """Extrapolated from two runs that lag: a slow one is nearly mended, a fast one is worse."""
    step, duration = 1e-3, 2.0
    time, kinds = np.linspace(0.0, duration, 8001), ("deflection", "stress", "force", "torque")
    left = run_errors.Remainder.by_halving(step, duration, stretches=stretches)
    frozen = SimpleNamespace(topology=SimpleNamespace(links=()))
    engine = SimpleNamespace(mechanism=SimpleNamespace(linkage=frozen))
    monkeypatch.setattr(run_errors, "_histories", lambda engine, own, drive: own.histories)

    def off(frequency):
        """True error of the extrapolated run, told error, and a part of the change."""
        rate = 2 * np.pi * frequency
        curves = [
            np.cos(rate * (1 - run_errors.step_lag(rate * h, stretches=stretches)) * time)
            for h in (step, step / 2)
        ]
        limit = curves[1] + (curves[1] - curves[0]) / (2**order - 1)
        runs = [
            SimpleNamespace(
                histories=dict.fromkeys(kinds, (curve[:, None, None], np.ones(1))),
                time=time,
                peak_joint_force=np.ones(1),
                peak_driving_torque=1.0,
            )
            for curve in curves
        ]
        error = run_errors.difference_of_runs((engine, runs[0]), (engine, runs[1]), None, left)
        true = np.abs(limit - np.cos(rate * time)).max()
        return true, float(error.of["deflection"][0]), np.abs(curves[1] - curves[0]).max()

    true, told, changed = off(0.5 * left.resolved)
    # The filter knows nothing beyond the end of the run.
    assert true < told < 1.3 * left.part * changed
    true, told, changed = off(4 * left.resolved)
    assert changed < true < told == pytest.approx(left.fast * changed, rel=0.05)


def test_steps_show_the_band_of_forces(monkeypatch):
    steps = steps_of(monkeypatch, lambda step: 0.0, band=100.0)[0]
    assert 6.0 < steps[0] / 100.0 < 7.0


def test_of_links_that_stretch_two_thirds_may_be_left(monkeypatch):
    steps, told, true = steps_of(monkeypatch, lambda step: 100 * step**4, stretches=True)
    assert steps == pytest.approx([8.0, 16.0])
    assert told == pytest.approx(2 / 3 * (100 / 8**4 - 100 / 16**4))
    assert true < 1e-12


def test_steps_that_are_too_long_by_far_are_no_steps_to_begin_with(monkeypatch):
    assert len(steps_of(monkeypatch, lambda step: 3e6 * step**4)[0]) == 6
    with pytest.raises(ComputationError, match="no time step is short enough"):
        steps_of(monkeypatch, lambda step: 40 * step**0.5)
    assert len(steps_of(monkeypatch, lambda step: 0.0, unbalanced=5)[0]) == 7
    with pytest.raises(run.UnbalancedStepError):
        steps_of(monkeypatch, lambda step: 0.0, unbalanced=6)


def difference(monkeypatch, force):
    """Error of a force of so many newtons, beside one of 1 N."""
    monkeypatch.setattr(run_errors, "deflections", lambda engine, of: np.ones((5, 1)))
    monkeypatch.setattr(run_errors, "greatest_stresses", lambda engine, of, drive: np.zeros((5, 1)))
    own = SimpleNamespace(linkage=SimpleNamespace(topology=SimpleNamespace(links=())))

    def trajectory(factor):
        history = np.zeros((5, 2, 2))
        history[:, 0, 0], history[:, 1, 0] = 1.0, factor * force
        return SimpleNamespace(
            time=np.arange(5.0),
            joint_force=history,
            peak_joint_force=np.abs(history[0, :, 0]),
            driving_torque=np.ones(5),
            peak_driving_torque=1.0,
            frame=None,
        )

    pair = trajectory(1.0), trajectory(-1.0)
    first, finer = ((SimpleNamespace(mechanism=own), each) for each in pair)
    return run_errors.difference_of_runs(first, finer, None).of["force"][1]


def test_forces_that_are_round_off_of_none_have_no_error(monkeypatch):
    assert difference(monkeypatch, 1e-11) < 0.1
    assert difference(monkeypatch, 1e-8) == pytest.approx(2.0)


def test_a_start_is_differentiated_over_a_part_of_a_turn():
    """Displacements are known to ten digits, and change by some harmonics of the crank."""
    drive = ConstantSpeed(2 * np.pi)
    time = start._start_times(drive)
    for harmonic in (1, 5):
        position = np.sin(2 * np.pi * harmonic * time + 1.0) + 1e-10 * np.array([1, -1, 1])
        rate = 2 * np.pi * harmonic * np.cos(1.0)
        assert abs(start._rate(position, time) / rate - 1) < 1e-5


def test_a_periodic_start_is_found_in_steps_of_a_quarter_of_a_degree():
    """The trapezoidal rule lowers a frequency f by (pi f h)^2 / 3 of itself."""
    request = SimpleNamespace(drive=ConstantSpeed(20.0))
    lag = (np.pi * 12 / start._steps_of_a_turn(request, 1.0)) ** 2 / 3
    assert 1e-5 < lag < 1e-3
    assert start._steps_of_a_turn(request, 1e-5) == pytest.approx(2 * np.pi / 20 / 1e-5, rel=1e-4)


def test_steady_motion_is_found_in_steps_of_half_a_degree(monkeypatch):
    steps = []
    monkeypatch.setattr(sweep, "periodic_turn", lambda linkage, count: steps.append(count))
    monkeypatch.setattr(sweep, "_greatest", lambda *of: None)
    linkage = SimpleNamespace(drive=ConstantSpeed(2 * np.pi))
    for highest in (1.0, 100.0):
        sweep.periodic_peaks(linkage, highest)
    # Peaks between steps are missed by (pi k / n)^2 / 2, of the tenth harmonic a thousandth.
    assert 1e-4 < (np.pi * 10 / steps[0]) ** 2 / 2 < 2e-3
    assert steps[1] == pytest.approx(4000)


def test_quasi_static_peaks_of_five_harmonics_are_known_to_a_thousandth(monkeypatch):
    """Wherever they are on the turn, and of a turn that is a few hundred positions."""
    sampled = []

    def greatest(linkage, moved):
        return np.abs(moved[0]).max(axis=0)

    monkeypatch.setattr(sweep, "_greatest", greatest)
    monkeypatch.setattr(sweep, "VibrationState", lambda position, *rates: position)
    for peak in np.linspace(0.3, 0.31, 7):

        def equations(time, peak=peak):
            sampled.append(len(time))
            wave = np.cos(5 * (2 * np.pi * time - peak))[:, None]
            return SimpleNamespace(quasi_static=lambda: wave)

        linkage = SimpleNamespace(
            drive=ConstantSpeed(2 * np.pi),
            quasi_static_equations=equations,
            link_motion=lambda equations, at_rest: [(at_rest, None, None)],
            bases=[np.eye(1)],
        )
        assert sweep.quasi_static_peaks(linkage)[0] == pytest.approx(1.0, rel=1e-3)
    assert max(sampled) < 1000


def test_stretch_is_taken_back_to_a_ten_thousandth():
    """Each pass leaves what the links have turned by: of a tenth of a radian a tenth of it."""
    passes = []

    def forces(displacement):
        passes.append(displacement)
        return [1.1 * displacement[0] + 0.01]

    frames = SimpleNamespace(
        links=[SimpleNamespace(stiffness=None, is_axial=np.array([True]))],
        assemble=lambda *of: SimpleNamespace(stiffness=np.eye(1)),
        gather=lambda motion, force: force[0],
        link_coordinates=lambda motion, step: [step],
    )
    found = tension_at_start.without_second_order_stretch(
        frames, None, [np.zeros((1, 1))], [np.zeros((1, 1))], forces
    )
    assert found[0][0, 0] == pytest.approx(-0.01 / 1.1, rel=2e-4)
    assert len(passes) < 10


# --- spectra ------------------------------------------------------------------------------------


def test_windows_hold_six_periods_of_the_lowest_frequency_and_fill_a_picture():
    time = 1e-3 * np.arange(8192)
    found = spectra.spectrogram(np.sin(2 * np.pi * 20 * time)[None], 1e-3, 20.0, 100.0)
    assert 1 / found.frequency[1] == pytest.approx(0.3, rel=0.01)
    assert 80 < len(found.time) <= 161
    # Of fewer samples than sixteen no spectrum is made.
    assert len(spectra.spectrogram(np.ones((1, 200)), 1e-3, 1000.0, 500.0).frequency) == 9


@pytest.mark.parametrize(("apart", "told"), [(2.4, True), (1.6, False)])
def test_frequencies_are_told_apart_by_half_the_main_lobe(apart, told):
    """Two waves whose distance is so many lines: between their peaks the spectrum falls or not."""
    time, length = 1e-3 * np.arange(1000), 1.0
    pair = [100.0, 100.0 + apart / length]
    signal = sum(
        np.sin(2 * np.pi * f * time + phase) for f, phase in zip(pair, (0, 1), strict=True)
    )
    hertz, amplitude = spectra.amplitude_spectrum(np.pad(signal, (0, 7000))[None], 1e-3, 500.0)
    assert len(hertz) == 4001
    assert len(amplitude) == 1
    note = spectra.resolution_note(np.array([pair]), length)
    assert ("cannot tell" not in note) is told
    time = np.linspace(0.0, 100.0, 401)
    window = spectra.window_duration(time, np.tile([1.0, 1.0 + apart / 20], (401, 1)), 1.0)
    assert window == pytest.approx(max(6.0, 2 / (apart / 20)))


# --- what is told -------------------------------------------------------------------------------


def test_the_last_turn_is_whole_however_many_went_before():
    for turns in (1, 40, 250_000):
        for first in np.linspace(0.0, 1.0, 30):
            angle = 2 * np.pi * (turns + np.arange(-300, 1) / 240) + first
            assert len(_frames(angle)) == 241
        assert words._crank(0.1 + 2 * np.pi * turns * (1 - 1e-16), 0.1)[1] == turns + 1
    assert words._crank(0.1 + 2 * np.pi * (1 - 3e-8), 0.1)[1] == 1


def test_free_shafts_that_leave_small_rotations_are_told():
    for degrees, lines in ((2.0, 1), (12.0, 2)):
        rotation = xr.DataArray([np.radians(degrees)], dims="engine", coords={"engine": ["x"]})
        data = xr.Dataset(
            {
                "shaft_rotation": rotation,
                "peak_shaft_rotation": rotation,
                "peak_crank_speed_fluctuation": rotation,
                "nonlinear": ("engine", [False]),
            },
            attrs={"crank_speed": 20.0},
        )
        assert len(words.shaft_lines(data)) == lines


def test_deflections_of_a_hundredth_of_a_link_are_large():
    for part, said in ((0.005, False), (0.02, True)):
        data = xr.Dataset(
            {
                "deflection": (("engine", "link", "time"), np.full((2, 1, 1), part)),
                "length": ("link", [1.0]),
                "nonlinear": ("engine", [0, 1]),
            },
            coords={"engine": ["linear", "simulated"], "link": ["coupler"]},
        )
        assert bool(_large_bow(data)) is said
        compared = xr.Dataset(attrs={"bow": part, "unexplained": 0.1})
        assert bool(_warnings(compared)) is said


def test_what_grows_at_less_than_a_thousandth_a_second_is_still():
    for rate, said in ((3e-4, "does not grow"), (3e-3, "grows with")):
        data = xr.Dataset(
            {"shaft_growth_rate": (("engine", "crank_speed"), [[rate]])},
            coords={"engine": ["reference"], "crank_speed": [20.0]},
            attrs={"speed_unit": "rad/s"},
        )
        assert said in shaft_lines(data)[0]


@pytest.mark.parametrize(("beyond", "shown"), [(3e-10, 9), (3e-9, 8)])
def test_a_frame_a_full_turn_before_the_last_one_is_not_lost_to_round_off(beyond, shown):
    assert len(_frames(np.linspace(-2 * np.pi * (1 + beyond), 0.0, 9))) == shown
