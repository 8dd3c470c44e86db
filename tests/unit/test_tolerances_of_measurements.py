"""Tolerances of hammer tests and comparisons: each test fails if its constant is another one."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.signal
import xarray as xr

import flexmech
from flexmech.analyses.comparison import fit, over_frequency, over_time, parameters, result
from flexmech.analyses.hammer import compute as hammer
from flexmech.analyses.hammer import measurement, plan, transient, uff
from flexmech.analyses.hammer import result as hammer_result
from flexmech.analyses.hammer.locked_linkage import LockedLinkage
from flexmech.analyses.running_hammer import compute as running
from flexmech.analyses.running_hammer import measured, prediction
from flexmech.analyses.running_hammer import plan as running_plan
from flexmech.analyses.running_hammer import result as running_result
from flexmech.dynamical_systems import direct_receptance
from flexmech.errors import ComputationError, InputError
from tests.support.hammer_data import damped_engine, small_request
from tests.support.running_hammer_data import running_hammer_dataset

# --- records of a locked linkage ----------------------------------------------------------------


@pytest.fixture(scope="module")
def locked() -> LockedLinkage:
    return LockedLinkage.at(damped_engine(), np.radians(30.0), "none")


def planned(locked, **asked) -> plan.RecordPlan:
    return plan.planned_record(replace(small_request(0.0), **asked), [locked])


def test_records_reach_beyond_the_peaks_of_the_modes(locked):
    highest = locked.natural_frequencies(2)[-1]
    assert 1.15 * highest < planned(locked).bandwidth < 1.45 * highest


def test_records_last_until_vibrations_are_below_the_noise_of_a_test(locked):
    taken = planned(locked)
    slowest = -locked.poles(taken.bandwidth).real.max() + taken.decay_rate
    left = np.exp(-slowest * (taken.duration - taken.pulse.end))
    assert 1e-9 < left <= 1.01e-4
    assert taken.sampling_rate == pytest.approx(2.56 * taken.bandwidth)
    assert taken.duration * taken.bandwidth >= 199
    # A record of more lines than analysers have gets an exponential window instead.
    short = planned(locked, duration=60 / taken.bandwidth)
    assert short.window is not None
    assert np.exp(
        -(-locked.poles(short.bandwidth).real.max() + short.decay_rate)
        * (short.duration - short.pulse.end)
    ) == pytest.approx(1e-4)


def test_records_have_as_many_lines_as_analysers():
    for needed, lines in ((0.01, 200), (3.0, 400), (1e9, 6400)):
        request = SimpleNamespace(duration=None)
        assert plan._samples(request, 100.0, needed) == round(2.56 * lines)
    for duration, refused in ((0.6, False), (0.4, True)):
        request = SimpleNamespace(duration=duration)
        if refused:
            with pytest.raises(InputError, match="samples up to"):
                plan._samples(request, 100.0, 0.0)
        else:
            assert plan._samples(request, 100.0, 0.0) > 128


def test_pulses_excite_the_band_within_twenty_decibels(locked):
    for part in (1.2, 1.4):
        pulse = flexmech.dynamical_systems.HalfSinePulse(1.0, part / 100.0)
        weak = abs(pulse.spectrum(np.array([100.0]))[0]) / pulse.momentum < 0.1
        if weak:
            with pytest.raises(InputError, match="excites frequencies up to"):
                planned(locked, bandwidth=100.0, pulse=part / 100.0)
        else:
            planned(locked, bandwidth=100.0, pulse=part / 100.0)
    assert weak


def test_forces_move_links_by_a_millionth_of_their_length(locked):
    lengths = [link.length for link in locked.engine.mechanism.linkage.topology.links]
    hit = locked.rows([small_request(0.0).impact], "transverse")[0]
    for pulse in (None, 2e-3, 1e-3, 5e-4):
        taken = planned(locked, pulse=pulse)
        time = taken.pulse.start + np.linspace(0.0, 0.5, 4000)
        moved = np.abs(locked.motion(locked.station_rows(), hit, taken.pulse, time)).max()
        assert 3e-7 < moved / min(lengths) < 1.02e-6


def test_the_filter_of_records_rings_before_and_after_the_pulse(locked):
    taken = planned(locked)
    taps = transient._filter(taken)
    rings = len(taps) // 2 * taken.step
    assert 1.0 < taken.pulse.start / rings < 2.0
    window = taken.force_window
    assert rings < window.length - taken.pulse.end < 2 * rings
    assert 0.2 < window.taper / (window.length - taken.pulse.end) < 0.5


def test_what_sampling_would_fold_into_the_band_is_stopped(locked):
    taken = planned(locked)
    fine = taken.sampling_rate * taken.oversampling
    folded = np.linspace(taken.sampling_rate - taken.bandwidth, fine / 2, 2000)
    within = np.linspace(0.0, taken.bandwidth, 500)
    taps = transient._filter(taken)
    stopped, passed = (
        np.abs(scipy.signal.freqz(taps, worN=at, fs=fine)[1]) for at in (folded, within)
    )
    assert 1e-5 < stopped.max() < 1.2e-4
    assert np.abs(passed - 1).max() < 1.5e-4


def test_steps_are_shorter_than_samples_and_pulses(locked):
    """Exact transients cost nothing: their force is sampled four times as finely."""
    taken = planned(locked, bandwidth=200.0)
    assert taken.oversampling == 40
    assert planned(locked, bandwidth=200.0, pulse=1e-4).pulse.duration / (
        planned(locked, bandwidth=200.0, pulse=1e-4).step
    ) == pytest.approx(80, rel=0.05)
    with pytest.raises(InputError, match="steps, more than 4000000"):
        planned(locked, bandwidth=200.0, pulse=2e-5)
    assert planned(locked, bandwidth=200.0, pulse=6e-5).samples > 0
    simulates = replace(locked, engine=SimpleNamespace(
        simulates=True, elements=2, links=locked.engine.links, mechanism=locked.engine.mechanism
    ))  # fmt: skip
    assert planned(simulates, bandwidth=200.0).oversampling == 10


def test_records_of_an_undamped_linkage_are_refused():
    for ratio, refused in ((1e-7, False), (1e-9, True)):
        own = LockedLinkage(None, 0.0, "none", None)
        pole = np.array([-ratio - 1j, -ratio + 1j])
        own.__dict__["modes"] = SimpleNamespace(poles=pole, below=lambda hertz: slice(None))
        if refused:
            with pytest.raises(InputError, match="is not damped"):
                own.poles(10.0)
        else:
            assert len(own.poles(10.0)) == 1


def test_records_are_read_between_their_lines():
    """Those of very short steps stay as they are."""
    time = np.arange(2000) / 256.0
    records = np.exp(-1.5 * time)[None] * np.sin(2 * np.pi * 37.3 * time)
    assert np.abs(transient.unwarped(records, 256.0, 1e-6) - records).max() < 1e-4
    # The trapezoidal rule lowers tan(pi f h) / (pi h) to f.
    step = 1e-3
    lowered = np.arctan(np.pi * 37.3 * step) / (np.pi * step)
    rule = np.exp(-1.5 * time)[None] * np.sin(2 * np.pi * lowered * time)
    spectrum = np.abs(np.fft.rfft(transient.unwarped(rule, 256.0, step)[0], 1 << 18))
    assert spectrum.argmax() * 256.0 / (1 << 18) == pytest.approx(37.3, abs=0.01)


def test_large_systems_keep_their_component_modes(aluminium):
    for elements, unreduced in ((8, True), (64, False)):
        engine = flexmech.ReferenceEngine(aluminium, elements)
        size = LockedLinkage.at(engine, 0.5, "none").system.size
        assert (size > 2.9 * elements * 2) is unreduced
        # They are enough for the modes of links up to many times the usual frequency.
        assert size > 30


# --- impacts on a running linkage ---------------------------------------------------------------


def run_turns(rate, **asked):
    request = SimpleNamespace(duration=None, **asked)
    return running_plan._turns(request, SimpleNamespace(growth_rate=-rate, turn_time=1.0))


def test_modes_beyond_the_band_add_little_but_their_flexibility(monkeypatch):
    """The direct solution is at most some lines, a resonance being many of them wide."""
    solved = []

    def direct(*of):
        solved.append(len(of[-1]))
        return direct_receptance(*of)

    monkeypatch.setattr(measurement, "direct_receptance", direct)
    found = flexmech.hammer_test(damped_engine(), small_request(0.0)).dataset
    assert 1e-5 < found["superposition_error"].max() < 1e-2
    assert 40 < min(solved) <= max(solved) < 130


def circle(natural, ratio):
    """Receptances of one mode about its natural frequency, and their frequencies."""
    pole = 2 * np.pi * natural * complex(-ratio, np.sqrt(1 - ratio**2))

    def receptance(hertz):
        return 1 / (2j * np.pi * hertz - pole)

    one = SimpleNamespace(
        poles=np.array([pole]),
        exact_at=receptance,
        modes=SimpleNamespace(receptance=lambda hertz, decay_rate: receptance(hertz)[None]),
    )
    taken = SimpleNamespace(decay_rate=0.0, bandwidth=100.0)
    found = hammer._circles([one], taken, 1)
    return receptance(found["circle_frequency"][1][0, 0]), found["circle_frequency"][1][0, 0]


def test_circles_close_to_a_thirteenth_and_have_no_corners():
    points, hertz = circle(10.0, 0.01)
    about = 2 * np.unwrap(np.angle(points))
    assert 1 - np.ptp(about) / (2 * np.pi) == pytest.approx(1 / 13, rel=0.1)
    assert np.abs(np.diff(about)).max() < np.radians(15.0)
    # Of a mode that hardly vibrates they would begin below zero.
    points, hertz = circle(10.0, 0.3)
    assert 1e-3 < hertz.min() < 0.1


def test_pulses_are_drawn_without_corners():
    drawn = np.sin(np.pi * hammer._PULSE_PLACES)
    assert drawn[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert np.abs(np.diff(drawn)).max() < 0.05
    assert len(drawn) < 1000


def test_the_verdict_is_of_the_first_three_modes():
    apart = np.array([[0.01, 0.01, 0.02, 0.5]])
    over = ("crank_angle", "mode")
    names = [
        f"{by}_{what}" for by in ("eigen", "identified") for what in ("frequency", "damping_ratio")
    ]
    values = [1.0, 1.0, 1 + apart, 1 + apart]
    dataset = xr.Dataset(
        {n: (over, np.broadcast_to(v, (1, 4))) for n, v in zip(names, values, strict=True)}
    )
    assert "first 3 modes: frequencies 2 %" in hammer_result._verdict(dataset)


def test_nodes_of_links_in_universal_files_never_meet():
    fractions = {name: np.linspace(0.0, 1.0, 500).tolist() for name in ("crank", "coupler")}
    nodes = SimpleNamespace(names=list(fractions), fractions=fractions)
    labels = {
        uff._Nodes.label(nodes, flexmech.LinkPoint(name, fraction))
        for name, own in fractions.items()
        for fraction in own
    }
    assert len(labels) == 1000
    # Short enough to be read.
    assert max(labels) < 10**6


def test_impacts_decay_to_a_part_that_noise_hides():
    for rate in (0.5, 1.0, 3.0):
        turns = run_turns(rate)
        # One turn in which an impact comes, and one in which what is left is measured.
        left = np.exp(-rate * (turns - 2))
        assert 1e-6 < left <= 1.01e-4


def test_impacts_are_spread_over_the_turn_and_jittered():
    phase = running_plan._phases(13, 1, 720)
    apart = np.diff(phase) * 13
    assert 0.75 < apart.min() < 0.99
    assert 1.01 < apart.max() < 1.25
    # Too evenly spaced, orders that are a multiple of their number apart cannot be told.
    assert np.unique(np.round(apart, 3)).size > 5


def planned_runs(monkeypatch, bandwidth=100.0, orders=2, turn_time=0.3):
    monkeypatch.setattr(running_plan, "_greatest", lambda *of: 1e-3)
    links = [SimpleNamespace(length=length) for length in (0.1, 0.3)]
    linkage = SimpleNamespace(topology=SimpleNamespace(links=links))
    engine = SimpleNamespace(mechanism=SimpleNamespace(linkage=linkage))
    request = SimpleNamespace(orders=orders, seed=1, duration=None, pulse=None)
    about = SimpleNamespace(
        turn_time=turn_time, growth_rate=-20.0, forced=None, hit=None, steps=None
    )
    return running_plan.planned(engine, request, about, bandwidth)


def test_runs_identify_orders_beyond_those_asked_for(monkeypatch):
    taken = planned_runs(monkeypatch)
    assert 4 <= taken.fitted <= 7
    # More impacts than orders, so that a misfit shows, and not many more.
    assert 1 <= len(taken.phase) - (2 * taken.fitted + 1) <= 4
    # The first impacts move links by a ten-thousandth of the shortest.
    assert taken.peak_force * 1e-3 / 0.1 == pytest.approx(1e-4)
    assert 300 < planned_runs(monkeypatch, bandwidth=30.0, turn_time=0.02).steps < 1000
    assert planned_runs(monkeypatch, bandwidth=20_000.0).samples < 1_000_000
    with pytest.raises(InputError, match="more than 1000000 steps"):
        planned_runs(monkeypatch, bandwidth=60_000.0)


def test_modes_count_up_to_half_again_the_highest_frequency(monkeypatch):
    asked = []

    def below(engine, frequency):
        asked.append(frequency)
        raise InputError("enough")

    monkeypatch.setattr(prediction, "_modes_below", below)
    monkeypatch.setattr(prediction, "with_damping_time", lambda engine, time: engine)
    engine = SimpleNamespace(links=[SimpleNamespace(damping=np.ones(1))])
    with pytest.raises(InputError):
        prediction.predicted_linkage(engine, None, 100.0)
    assert 120.0 < asked[0] < 250.0


def test_frozen_resonances_move_by_less_than_their_width_between_angles():
    """Of a linkage with the damping of metal, a half per cent."""
    angles = 2 * np.pi / prediction._FROZEN_ANGLES * np.arange(prediction._FROZEN_ANGLES)
    engine = flexmech.ReferenceEngine(damped_engine().mechanism, 2)
    hertz = flexmech.natural_frequencies(engine, angles, modes=2)
    moved = (np.abs(np.diff(hertz, axis=0)) / hertz[1:]).max()
    assert 0.1 * 2 * 0.005 < moved < 2 * 2 * 0.005


def test_the_band_of_a_running_test_holds_the_first_resonance(monkeypatch):
    monkeypatch.setattr(running, "lowest_frequency", lambda engine: 2 * np.pi * 40.0)
    monkeypatch.setattr(running, "with_damping_time", lambda engine, time: engine)
    chosen = running._bandwidth(None, SimpleNamespace(bandwidth=None, pulse=None))
    assert 1.3 * 40 < chosen < 3 * 40


def test_peaks_are_looked_for_near_those_predicted():
    predicted, identified = np.zeros((1, 400)), np.zeros((1, 400))
    for own, apart, near in ((20, 4, True), (20, 7, False), (200, 9, True), (200, 12, False)):
        predicted[:], identified[:] = 0.0, 0.0
        predicted[0, own] = identified[0, own + apart] = 1.0
        found = running._peak_bins(predicted, identified)[1][0]
        assert bool(found == own + apart) is near


def test_sidebands_agree_within_a_twentieth_and_a_bin():
    def said(**changed):
        data = running_hammer_dataset()
        for name, values in changed.items():
            data[name] = ("order", np.asarray(values))
        return "predicted agree" in running_result._verdict(data)

    peaks = running_hammer_dataset()["predicted_peak"].values
    assert said(identified_peak=1.04 * peaks)
    assert not said(identified_peak=1.07 * peaks)
    assert said(bins_apart=[1, 0, 1])
    assert not said(bins_apart=[2, 0, 0])
    # What is told is of the first sidebands.
    farther = running_hammer_dataset().assign_coords(order=[-3, 0, 1])
    farther["bins_apart"] = ("order", [9, 0, 0])
    assert "predicted agree" in running_result._verdict(farther)


def test_orders_that_change_are_hit_half_as_hard(monkeypatch):
    forces, curvature = [], 0.0

    def added(run, pulses, *of):
        forces.append(pulses[0])
        size = [force + curvature * force**3 for force in pulses]
        return np.array(size)[:, None], np.ones(3)

    def response(taken, added):
        return SimpleNamespace(response=np.full((1, 1), added.mean() / taken.force))

    class Plan:
        steps = 1

        def __init__(self, force):
            self.force = force

        def softer(self, factor):
            return Plan(factor * self.force)

        def pulses(self):
            return [self.force] * 12

    monkeypatch.setattr(measured, "added_by_impacts", added)
    monkeypatch.setattr(measured, "_estimated", response)
    request = SimpleNamespace(orders=0, noise=0.0, speed=20.0)

    def taken(bend):
        nonlocal curvature
        curvature = bend
        forces.clear()
        return measured.measured_response(None, request, Plan(1.0), lambda *of: None).plan.force

    for bend, force in ((0.01, 1.0), (0.02, 0.5), (0.7, 0.125)):
        assert taken(bend) == force
    with pytest.raises(ComputationError, match="however small they are"):
        taken(10.0)
    # All, then a third half as hard, then the others; and so on.
    assert forces == pytest.approx([1.0, *np.repeat(0.5 ** np.arange(1.0, 5.0), 2)])


def test_orders_that_are_not_there_have_no_change_of_their_own():
    whole = np.array([[1e-5], [1.0], [1e-3]])
    found = measured._change(whole, 0.5 * whole, 1)
    assert found == pytest.approx([0.05, 0.5, 0.5])


def test_harmonic_balance_has_spare_harmonics_up_to_sixty():
    def harmonics(fastest, orders=(0, 1)):
        matrix = np.array([[[0.0, 1.0], [-((2 * np.pi * fastest) ** 2), 0.0]]])
        system = SimpleNamespace(matrix=SimpleNamespace(coefficients=matrix), period=1.0)
        own = SimpleNamespace(forced=SimpleNamespace(system=system), turn_time=1.0)
        return prediction.Prediction._harmonics(own, np.array(orders))

    # What the fastest moving mode answers falls off within a dozen harmonics or so beyond it.
    assert 10 + 12 < harmonics(10.5) < 10 + 40
    assert harmonics(500.0) == 60


def test_modes_are_counted_until_one_lies_beyond(monkeypatch):
    def frequencies(engine, angles, modes, **of):
        assert len(angles) >= 12
        assert np.ptp(angles) + angles[1] == pytest.approx(2 * np.pi)
        return np.tile(10.0 * np.arange(1, modes + 1), (len(angles), 1))

    monkeypatch.setattr(prediction, "natural_frequencies", frequencies)
    engine = SimpleNamespace(prestress_at_rest="none")
    assert [prediction._modes_below(engine, f) for f in (15.0, 55.0, 155.0)] == [3, 6, 16]
    with pytest.raises(InputError, match="more than 16 natural modes"):
        prediction._modes_below(engine, 170.0)


# --- fits ---------------------------------------------------------------------------------------


def test_slopes_are_known_to_what_differences_leave():
    random = np.random.default_rng(1)

    def curve(x):
        return np.exp(3 * x) + 1e-10 * random.standard_normal(1)

    slopes = fit._central(curve, np.array([0.2]), np.array([-np.inf]))
    assert slopes[0, 0] == pytest.approx(3 * np.exp(0.6), rel=1e-6)
    # At a bound the difference is one-sided.
    slopes = fit._central(np.exp, np.array([0.2]), np.array([0.2]))
    assert slopes[0, 0] == pytest.approx(np.exp(0.2), rel=2e-4)


def test_fits_step_by_usual_changes():
    """Differences by a ten-thousandth of them are neither round-off nor as large as what is fitted.

    A hundred thousandth of a stiffness, a thousandth of a degree.
    """
    names = (f"{parameters.STIFFNESS}:rocker", parameters.GAIN, parameters.START_ANGLE)
    found = parameters.free_parameters(names, lambda values: 0.0, 1e-5, "m", 1e-3)
    steps = [fit._DIFFERENCE * one.scale for one in found]
    assert all(3e-6 < step < 3e-5 for step in steps[:2])
    assert 3e-4 < steps[2] < 3e-3


def test_deflections_are_sought_at_every_degree():
    """A peak a few degrees wide is found, and a warning costs no more than some hundreds."""
    sampled = []

    def readings(turn, number):
        sampled.append(len(turn))
        return np.exp(-(((turn - 0.4321) * 360 / 3) ** 2))[None]

    links = [SimpleNamespace(length=2.0)]
    problem = SimpleNamespace(
        _motion=lambda values: SimpleNamespace(readings=readings),
        engine=SimpleNamespace(
            mechanism=SimpleNamespace(
                linkage=SimpleNamespace(topology=SimpleNamespace(links=links))
            )
        ),
    )
    assert over_time.TimeProblem._greatest_deflection(problem, {}) == pytest.approx(0.5, rel=0.05)
    assert max(sampled) < 1000


def test_intervals_are_those_of_95_percent():
    assert fit._quantile(1e9) == pytest.approx(1.95996, rel=1e-5)


def test_parameters_that_can_hardly_be_told_apart_are_refused():
    own = np.random.default_rng(2).standard_normal((100, 2))
    both = tuple(fit.Parameter(name, "", 1.0, 1.0) for name in "ab")
    residual = np.ones((1, 100))
    for apart, refused in ((1e-5, False), (1e-7, True)):
        slopes = np.column_stack([own[:, 0], own[:, 0] + apart * own[:, 1]])
        if refused:
            with pytest.raises(ComputationError, match="apart"):
                fit._white_covariance(both, slopes, residual, 2)
        else:
            assert np.isfinite(fit._white_covariance(both, slopes, residual, 2)).all()


def test_processes_have_as_many_orders_as_samples_tell():
    white = np.random.default_rng(3).standard_normal((1, 2000))
    filter_of = np.zeros(36)
    filter_of[[0, 35]] = 1.0, -0.95
    late = scipy.signal.lfilter([1.0], filter_of, white, axis=1)
    assert 35 <= len(fit.autoregression(late)) <= 40
    filter_of = np.zeros(66)
    filter_of[[0, 65]] = 1.0, -0.95
    later = scipy.signal.lfilter([1.0], filter_of, white, axis=1)
    assert len(fit.autoregression(later)) <= 40
    # Each coefficient of a short record would be known to no third.
    assert len(fit.autoregression(late[:, :240])) <= 30


def test_the_spectrum_of_a_sharp_process_is_added_up_finely_enough():
    """Of a mode with a damping of 0.5 % at forty samples a period, in closed form: 4 zeta w h."""
    turn = 2 * np.pi / 40
    radius = np.exp(-0.005 * turn)
    process = np.array([2 * radius * np.cos(turn), -(radius**2)])
    first = process[0] / (1 - process[1])
    correlation = [1.0, first]
    for _ in range(20_000):
        correlation.append(process[0] * correlation[-1] + process[1] * correlation[-2])
    exact = 1 / (2 * np.sum(np.square(correlation)) - 1)
    assert fit._independent_samples(process) == pytest.approx(exact, rel=2e-3)


def test_fits_begin_where_they_find_the_record():
    """Among crank angles a fraction of a period apart, and damping of steel to polymers."""
    best = {"start_angle": 123.4, "damping": 0.012}

    def misfit(values):
        return sum(abs(np.log(values[k] / best[k])) if k == "damping" else
                   abs(values[k] - best[k]) for k in values if k in best)  # fmt: skip

    found = {
        p.name: p
        for p in parameters.free_parameters(
            ["damping", "start_angle", "stiffness:coupler"], misfit, 0.005, "", 1.0
        )
    }
    assert abs(found["start_angle"].start - 123.4) <= 1.25
    assert found["damping"].start == pytest.approx(0.01)
    for ratio in (0.0007, 0.05):
        best["damping"] = ratio
        start = parameters.free_parameters(["damping"], misfit, 0.005, "", 1.0)[0].start
        assert 0.5 < start / ratio < 2.0
    assert 0.01 < found["stiffness:coupler"].least < 0.3


def time_record(rate, length, first=10.0):
    time = np.arange(round(length * rate) + 1) / rate
    record = SimpleNamespace(first_frequency=2 * np.pi * first, time=time, source="record.csv")
    record._is_long_enough = partial(over_time.TimeProblem._is_long_enough, record)
    return record


def test_records_over_time_show_the_first_mode():
    check = over_time.TimeProblem.__post_init__
    check(time_record(23.0, 10.0))
    with pytest.raises(InputError, match="cannot show vibrations"):
        check(time_record(21.0, 10.0))
    check(time_record(1000.0, 0.31))
    with pytest.raises(InputError, match="is too short"):
        check(time_record(1000.0, 0.29))
    modes = flexmech.choices.MODES
    check(time_record(100.0, (4 * (2 * modes + 4) + 2) / 100))
    with pytest.raises(InputError, match="is too short"):
        check(time_record(100.0, max(0.31, (4 * (2 * modes + 4) - 3) / 100)))


def test_free_vibrations_that_are_one_but_for_round_off_count_once():
    first = np.sin(np.arange(50.0))
    other = np.cos(3 * np.arange(50.0))
    for apart, counted in ((1e-7, True), (2e-10, False)):
        free = np.stack([first, first + apart * other], axis=1)
        own = SimpleNamespace(_motions=lambda values, free=free: (0.0, free), record=other)
        computed = over_time.TimeProblem.curve(own, {})
        assert bool(np.abs(computed - other).max() < 1e-6) is counted


def test_the_gauge_is_turned_where_less_than_half_is_explained():
    own = SimpleNamespace(record=np.array([1.0, -1.0]))
    unexplained = over_time.TimeProblem._unexplained_if_reversed
    assert np.isnan(unexplained(own, 0.4))
    with pytest.raises(TypeError):
        unexplained(own, 0.6)


def test_frequency_responses_have_the_modes_beyond_their_band():
    def modes(highest):
        own = SimpleNamespace(
            frequency=np.array([0.0, highest]),
            engine=SimpleNamespace(elements=8, links=[SimpleNamespace(size=60)] * 3),
            _natural_frequencies=lambda count: np.array([10.0 * count]),
        )
        return over_frequency.ReceptanceProblem._modes.func(own)

    assert modes(50.0) == 8
    assert modes(60.0) == 16


def test_frequency_responses_need_lines_beside_the_resonance():
    values = np.ones(20, dtype=complex)
    for lines, refused in ((15, True), (16, False)):
        column = flexmech.MeasuredQuantity("H", "m/N", values[:lines])
        record = flexmech.MeasuredRecord("frequency", np.arange(1.0, lines + 1), (column,), "r.csv")
        request = SimpleNamespace(angle=0.5, quantity=None, fit=())
        engine = damped_engine()
        if refused:
            with pytest.raises(InputError, match="too few"):
                over_frequency.receptance_problem(engine, record, request)
        else:
            over_frequency.receptance_problem(engine, record, request)


def test_fits_that_mean_little_are_told():
    def warned(**attrs):
        return len(result._warnings(xr.Dataset(attrs=attrs)))

    assert warned(unexplained=0.4) == 0
    assert warned(unexplained=0.6) == 1

    def said(turned):
        return result._warnings(
            xr.Dataset(attrs={"unexplained": 0.9, "turned_unexplained": turned})
        )

    assert "sign turned" in said(0.6)[0]
    assert "sign turned" not in said(0.8)[0]
    for apart, count in ((0.05, 0), (0.2, 1)):
        data = xr.Dataset(
            {"residual": ("sample", [apart]), "measured": ("sample", [1.0])},
            attrs={"unexplained": 1},
        )
        assert len(result._warnings(data)) == count
    for value, hardly in ((0.9, False), (0.98, True)):
        both = xr.Dataset(
            {"correlation": (("parameter", "with_parameter"), [[1.0, value], [value, 1.0]])},
            coords={"parameter": ["a", "b"]},
        )
        assert ("hardly" in result._correlation_lines(both)[0]) is hardly
    for widened, white in ((1.1, True), (1.4, False)):
        data = xr.Dataset(
            {"residual": ("time", [1.0]), "fitted": ("parameter", [1.0])},
            attrs={"unit": "", "unexplained": 0.1, "residual_order": 0, "widened": widened},
        )
        assert ("white noise: the" in result._residual_lines(data)[1]) is white


@pytest.mark.parametrize(("apart", "fitted"), [(3e-9, 1.0), (3e-10, 0.0)])
def test_free_vibrations_that_are_alike_count_once(apart, fitted):
    """Of two that differ by round-off the difference is none, and fits no record."""
    axis = np.eye(4)
    free = np.stack([axis[0], axis[0] + 2 * apart * axis[1]], axis=1)
    own = SimpleNamespace(_motions=lambda values: (np.zeros(4), free), record=axis[1])
    found = over_time.TimeProblem.curve(own, {})
    assert found[1] == pytest.approx(fitted, abs=1e-6)


def test_spectra_are_read_between_lines_to_a_hundred_thousandth():
    """Against the sum over the record at the frequencies that are read."""
    rate, count, step = 400.0, 512, 1 / 1600
    time = np.arange(count) / rate
    record = np.exp(-(((time - 0.64) / 0.12) ** 2)) * np.cos(377 * (time - 0.64))
    read = np.arctan(np.pi * rate / count * np.arange(count // 2 + 1) * step) / (np.pi * step)
    exact = np.fft.irfft(np.exp(-2j * np.pi * read[:, None] * time) @ record, count)
    gap = np.abs(transient.unwarped(record[None], rate, step)[0] - exact).max()
    assert 1e-7 < gap / np.abs(exact).max() < 1e-5


def test_displacements_are_looked_for_in_three_periods_of_the_first_mode():
    """A beat of two modes is at its greatest late; and at many instants of each period."""

    def motion(rows, hit, unit, time):
        return np.where(np.abs(time - unit.start - 2.9) < 0.012, 1.0, 1e-3)

    linkage = SimpleNamespace(topology=SimpleNamespace(links=[SimpleNamespace(length=1.0)]))
    own = SimpleNamespace(
        engine=SimpleNamespace(mechanism=SimpleNamespace(linkage=linkage)),
        natural_frequencies=lambda count: [1.0],
        rows=lambda *of: [None],
        station_rows=lambda: None,
        motion=motion,
    )
    request = SimpleNamespace(impact=None, direction=None)
    pulse = SimpleNamespace(start=0.0, duration=0.01)
    assert plan._force(request, [own], pulse) == pytest.approx(1e-6)
