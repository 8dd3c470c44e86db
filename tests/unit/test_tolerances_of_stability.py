"""Tolerances of stability maps: each test fails if its constant is taken away or is another one."""

from __future__ import annotations

import multiprocessing
import time
import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest

from flexmech.analyses.stability import (
    collisions,
    edges,
    selected_modes,
    solver,
    speed_range,
    speed_window,
    vibrating_linkage,
)
from flexmech.analyses.stability.collisions import Meeting, MeetingPair, meetings, met
from flexmech.analyses.stability.growth import SignedGrowth
from flexmech.analyses.stability.mode_tracking import BranchShapes
from flexmech.analyses.stability.naming import BandName, band_name, signatures_of
from flexmech.analyses.stability.parallel import _end
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.analyses.stability.speed_window import KnownEquilibria, SpeedWindow
from flexmech.dynamical_systems import FourierSeries, SampledPeriodicSystem, floquet_modes
from flexmech.errors import ComputationError, InputError
from tests.support.stability_data import FREQUENCIES, followed

# --- names of bands -----------------------------------------------------------------------------


def named(frequency, part, crank, width=1e-6) -> BandName:
    usual = np.array(frequency, dtype=float)
    return band_name(usual, np.array(part), usual, crank, width, differences=False)


def test_a_branch_with_a_small_part_in_the_mode_has_none_in_the_band():
    crank = 93.5 / 6
    for part, branches in ((0.2, (1, 2)), (0.1, ())):
        assert named([44.5, 49.0], [part, part + 0.01], crank).branches == branches


def test_a_band_is_named_up_to_a_quarter_of_the_cranks_frequency():
    for mismatch, kind in ((0.2, "principal"), (0.3, "unnamed")):
        assert named([44.5], [1.0], 89.0 / (7 + mismatch)).kind == kind


def test_what_a_narrow_band_is_named_by_meets_to_a_hundredth():
    """Twice f1 misses a multiple by a half or two hundredths; f1 + f2 is one."""
    for mismatch, kind in ((0.005, "principal"), (0.02, "sum")):
        found = named([(7 - mismatch) / 2, (9 + mismatch) / 2], [0.8, 0.5], 1.0)
        assert found.kind == kind


def test_a_mode_without_frequency_is_no_obstacle_to_a_name():
    with np.errstate(all="raise"):
        assert named([0.0, 44.5], [0.01, 1.0], 89.0 / 7).branches == (2, 2)


def test_signatures_are_clear_from_a_hundredth_on():
    name = BandName("sum", (1, 2), 7, 0.0, FREQUENCIES[:2])
    for size, known in ((0.02, True), (0.005, False)):
        own = size * np.array([1.0, -1.0] * len(FREQUENCIES))
        found = signatures_of(name, (88.0, 90.0), [followed(85.0, krein_signature=own)])
        assert bool(np.isfinite(found).all()) is known


# --- branches -----------------------------------------------------------------------------------


def modes(shapes, hertz, **known) -> SimpleNamespace:
    """Modes of one crank angle whose shapes are given as columns."""
    exponent = 2j * np.pi * np.array(hertz, dtype=float)
    return SimpleNamespace(shape=np.array(shapes, dtype=complex)[None], exponent=exponent, **known)


def branches(shapes, hertz) -> BranchShapes:
    return BranchShapes(np.array(shapes, dtype=np.complex64)[None], np.array(hertz, dtype=float))


def test_modes_that_turn_the_other_way_round_come_after_alike_ones():
    own = branches([[1.0, 0.0], [0.0, 1.0]], [10.0, 30.0])

    def taken(likeness):
        """Of the mode itself turning back and of another one that turns forward."""
        rest = np.sqrt(1 - likeness**2)
        found = modes([[1.0, likeness], [0.0, rest]], [-10.0, 10.0])
        return own.order_of(found)[0][0]

    assert taken(0.8) == 1
    own = branches([[1.0]], [10.0])
    stranger = modes([[1.0, 0.4], [0.0, 0.9]], [-10.0, 20.0])
    stranger.shape = stranger.shape[:, :1]
    assert own.order_of(stranger)[0][0] == 0


def test_branches_of_alike_modes_go_by_a_twentieth_of_the_frequency():
    own = branches(np.eye(2), [10.0, 10.4])
    small, great = np.sqrt(0.45), np.sqrt(0.55)
    mixed = modes([[small, great], [great, small]], [10.1, 10.3])
    assert own.order_of(mixed)[0].tolist() == [0, 1]
    far = modes([[small, great], [great, small]], [11.0, 11.2])
    assert own.order_of(far)[0].tolist() == [1, 0]


def test_branches_take_over_what_is_clear():
    own = branches(np.eye(2), [10.0, -10.0])

    def kept(growth=0.0, alike=1.0, signature=1.0):
        both = np.ones(2)
        other = modes(np.eye(2), [11.0, -11.0], log_modulus=growth * both)
        other.signature = signature * both
        return own.updated(other, alike * both).frequency[0] == 10.0

    assert not kept(growth=1e-8)
    assert kept(growth=1e-6)
    assert not kept(alike=0.6)
    assert kept(alike=0.4)
    assert not kept(signature=0.7)
    assert kept(signature=0.5)


def test_growth_is_what_exceeds_the_round_off_of_a_double_multiplier():
    measure = SignedGrowth(SimpleNamespace(is_hamiltonian=True))
    beside = 2 * np.pi * 7.3j
    for growth, sign in ((1e-8, -1), (1e-6, 1)):
        exponent = np.array([growth + beside, -growth + beside, beside.conjugate()])
        assert np.sign(measure.of_exponents(exponent, 1.0)) == sign


# --- modes that meet ----------------------------------------------------------------------------


def pairs_of(lower_growth=-0.4, apart=0.0, orders=0.0):
    """Meetings of a mode with itself between two speeds, at the lower of which it may grow."""
    crank = 2 * FREQUENCIES[0] / (7 + apart)
    lower = followed(2 * np.pi * crank, lower_growth)
    upper = followed(2 * np.pi * 2 * FREQUENCIES[0] / (7 + apart + orders))
    every = meetings([lower, upper], 1)
    return [meeting.order for pair in every for meeting in pair.meetings]


def test_modes_that_stay_together_at_a_speed_meet_there():
    assert pairs_of(apart=3e-7, orders=0.3) == [7]
    assert pairs_of(apart=1e-4, orders=0.3) == []


def test_the_edge_beyond_a_band_is_no_meeting():
    assert pairs_of(lower_growth=3.0, apart=-0.03, orders=0.3) == []
    assert pairs_of(lower_growth=3.0, apart=-0.1, orders=0.3) == [7]


def test_modes_are_kept_together_where_their_slope_is_less_than_half():
    for slope, locked in ((0.4, True), (0.6, False)):
        # With frequencies that change the sum follows the crank but for a part of it.
        low, high = 76.0, 77.0
        first = 10 * low / (4 * np.pi)
        last = first + (1 - slope) * 10 * (high - low) / (4 * np.pi)
        assert Meeting(low, high, (first, first), (last, last), 10).is_locked is locked


def test_a_pair_is_left_after_three_hopeless_orders(monkeypatch):
    asked, sampled = [], []

    def middle(strengths):
        left = iter(strengths)

        def found(solver, meeting, negligible):
            asked.append(meeting)
            return 80.0, next(left)

        return found

    monkeypatch.setattr(collisions, "_sampled", lambda *of: sampled.append(of))
    every = [Meeting(80.0, 81.0, (44.0, 44.0), (44.0, 44.0), 7)] * 9
    lowest = (2 * np.pi * 44.0) ** 2
    of_ratio = SimpleNamespace(is_hamiltonian=False)

    def kept(strengths):
        asked.clear()
        sampled.clear()
        monkeypatch.setattr(collisions, "_middle", middle(strengths))
        met(of_ratio, MeetingPair((0, 0), every), lowest, 1.0)
        return len(sampled), len(asked)

    # Over the growth that counts: a third of it is worth a look.
    assert kept([0.5] * 9) == (9, 9)
    assert kept([0.25] * 9) == (0, 3)
    assert kept([0.25, 0.25, 0.5] * 3) == (3, 9)


def test_growth_beside_a_band_is_looked_at_close_to_its_edges(monkeypatch):
    asked = []

    def sample(self, speed):
        asked.append(speed - 80.0)
        return SimpleNamespace(signed_growth=0.1**2 - asked[-1] ** 2)

    monkeypatch.setattr(collisions.SignedGrowth, "sample", sample)
    found = collisions._sampled(None, 80.0, 0.1)
    assert [each.signed_growth > 0 for each in found.samples] == [True, False, False]
    assert max(asked) < 0.2


def middle_of(monkeypatch, square, strength=0.0):
    """Where two modes are found to meet between 80 and 81 rad/s, and the speeds asked for."""
    asked = []

    def at(solver, meeting, speed):
        asked.append(speed)
        return square(speed)

    monkeypatch.setattr(collisions, "_square", at)
    crank = 80.4 / (2 * np.pi)
    meeting = Meeting(80.0, 81.0, (3.5 * crank, 3.5 * crank), (3.5 * crank, 3.5 * crank), 7)
    return (*collisions._middle(None, meeting, 0.0), asked)


def test_the_middle_of_a_narrow_band_is_told_beside_round_off(monkeypatch):
    def rounded(speed):
        return 2e-2**2 - 4 * (speed - 80.41) ** 2 + 5e-5 * np.sin(1e6 * speed)

    centre, _, asked = middle_of(monkeypatch, rounded)
    assert centre == pytest.approx(80.41, abs=1e-3)
    assert min(asked) >= 80.0
    assert max(asked) <= 81.0


def test_the_middle_of_a_band_of_damped_modes_is_refined(monkeypatch):
    def damped(speed):
        return 0.3**2 - 4 * (speed - 80.52) ** 2 - 30 * (speed - 80.52) ** 4

    centre, strength, asked = middle_of(monkeypatch, damped)
    assert centre == pytest.approx(80.52, abs=2e-3)
    assert strength == pytest.approx(0.3, rel=1e-2)
    assert len(asked) <= 8


def test_modes_that_meet_are_told_by_angle_before_frequency():
    def first_of(*own):
        """Angle and frequency of modes that turn forward, the first being wanted at (1, 40)."""
        angle = np.array([each[0] for each in own] + [-1.0])
        hertz = np.array([each[1] for each in own] + [40.0])
        known = SimpleNamespace(angle=angle, exponent=2j * np.pi * hertz, period=1 / (80 * np.pi))
        return collisions._places(known, np.array([40.0, 40.0]))[0]

    assert first_of((1.0, 60.0), (1.1, 40.0)) == 1
    assert first_of((1.0, 60.0), (1.5, 40.0)) == 0
    assert first_of((1.0, 42.0), (1.1, 40.0)) == 1
    assert first_of((1.0, 40.8), (1.1, 40.0)) == 0


# --- edges --------------------------------------------------------------------------------------


@pytest.mark.parametrize("edge", [88.1234567, 88.7654321, 89.1])
def test_edges_are_known_to_eight_digits_and_no_more(monkeypatch, edge):
    asked = []

    def step(self, speed):
        asked.append(speed)
        return 1.0 if speed < edge else -1.0

    monkeypatch.setattr(edges.SignedGrowth, "__call__", step)
    found = edges.find_edge(None, edges.EdgeSearch(88.0, 90.0, 1.0, -1.0))
    assert found.crank_speed == pytest.approx(edge, abs=1e-6)
    assert len(asked) < 28


def test_the_top_of_a_band_is_found_to_a_thousandth_of_its_growth():
    asked = []

    def rate(speed):
        asked.append(speed)
        arch = np.sqrt(np.maximum((speed - 88.0) * (89.8 - speed), 0.0))
        return arch * (1 + 0.8 * np.exp(-10 * (speed - 88.6) ** 2))

    known = SimpleNamespace(moving=lambda speed: speed, growth_rate=rate)

    def modes(speed, angle):
        own = SimpleNamespace(growth_rate=rate(speed), angle=np.array([angle]))
        return SimpleNamespace(exponent=np.array([1.0 + 1.0j]), **vars(own))

    known.solve = lambda speed: modes(speed, np.pi)
    best, alike = edges.find_top(known, (88.1, 88.0, 89.8))
    assert len(asked) < 13
    assert best.growth_rate == pytest.approx(rate(np.linspace(88.0, 89.8, 10_001)).max(), rel=1e-3)
    assert alike
    # Beside a real multiplier one that is not: two resonances overlap.
    known.solve = lambda speed: modes(speed, np.pi if speed < 89.0 else 1.0)
    assert not edges.find_top(known, (88.1, 88.0, 89.8))[1]
    known.solve = lambda speed: modes(speed, np.pi if speed < 89.0 else 0.0)
    assert not edges.find_top(known, (88.1, 88.0, 89.8))[1]


def measured_edge(monkeypatch, own, mesh, more=None, half=None):
    """Errors of an edge at zero with a bracket of one, by measures of growth over the speed."""

    class Measured:
        def __init__(self, solver):
            self.at = self.__call__ = solver

        def __call__(self, speed):
            return self.at(speed)

    class Solver:
        def __init__(self, growth):
            self.growth = growth

        def __call__(self, speed):
            return self.growth(speed)

        def moving(self, speed):
            return speed

        def sampled_coarsely(self):
            return self

        def both_reductions(self, speed):
            return speed, speed

        def with_more_modes(self):
            return Solver(more or own)

        def refined(self):
            return Solver(mesh)

        def with_half_the_steps(self, moving):
            return Solver(half or own)

    monkeypatch.setattr(edges, "SignedGrowth", Measured)
    return edges.edge_errors(Solver(own), edges.FoundEdge(0.0, 0.0, 1.0))


def test_the_slope_of_growth_is_taken_where_it_is_neither_bent_nor_round_off(monkeypatch):
    def growth(speed):
        return speed + 40 * speed**3 + 1e-7 * np.sin(1e7 * speed)

    found = measured_edge(monkeypatch, growth, lambda speed: growth(speed) + 0.01)
    # The change by half the element length is the error less a quarter of it, in second order.
    assert found.mesh_error == pytest.approx(0.01 * 4 / 3, rel=2e-3)
    assert found.step_error == found.reduction_error == 0.0
    assert found.crank_speed == 0.0


def test_edges_that_move_far_are_sought_anew(monkeypatch):
    """Growth that falls faster and faster: a straight line puts the edge farther away."""

    def moved(by):
        def other(speed):
            return by - speed - 2 * max(speed, 0.0)

        return measured_edge(monkeypatch, lambda speed: -speed, other).mesh_error * 3 / 4

    assert moved(0.2) == pytest.approx(0.2)
    assert moved(0.3) == pytest.approx(0.1, abs=2e-3)
    # One that is nowhere near is off by twice the bracket.
    assert moved(20.0) == pytest.approx(2.0)


# --- damping that closes a band -----------------------------------------------------------------


def closed(growth, start=0.0, band=(88.0, 88.9, 90.0)):
    """Damping ratio that closes a band, and the ratios asked for."""
    asked = []

    def at(speed, ratio):
        asked.append(ratio)
        return growth(speed, ratio)

    known = SimpleNamespace(moving=lambda speed: speed, growth_at=at)
    low, top, high = band
    return edges.closing_damping_ratio(known, edges.ClosingSearch(top, low, high, start)), asked


def ratio_of(growth, start=0.0):
    """At one speed: a band without width, on whose edge its top is."""
    return closed(lambda speed, ratio: growth(ratio), start, (89.0, 89.0, 90.0))


def test_the_ratio_that_closes_a_band_is_found_in_few_steps():
    for root in (1e-3, 1e-2):
        found, asked = ratio_of(lambda ratio, root=root: root - ratio)
        assert found == pytest.approx(root, rel=1e-5)
        assert len(asked) <= 7
    found, asked = ratio_of(lambda ratio: 0.0105 - ratio, 0.01)
    assert found == pytest.approx(0.0105, rel=1e-5)
    assert len(asked) <= 4
    found, asked = ratio_of(lambda ratio: 1.0 if ratio < 0.105 else -1.0, 0.1)
    assert len(asked) <= 18
    # Growth that damping takes off later and later: a straight line leads far beyond.
    found, asked = ratio_of(lambda ratio: 9e-6 - ratio**2)
    assert found == pytest.approx(3e-3, rel=1e-5)
    assert max(asked) < 6e-3
    assert len(asked) <= 12


def test_ratios_that_close_a_band_have_three_digits():
    found, asked = ratio_of(lambda ratio: 1.0 if ratio < 0.0123456 else -1.0)
    assert found == pytest.approx(0.0123456, rel=3e-5)
    assert len(asked) < 26


def test_ratios_that_close_a_band_lie_between_none_and_critical_damping():
    found, asked = ratio_of(lambda ratio: 1.0)
    assert np.isnan(found)
    assert 1.0 < max(asked) < 40.0
    assert ratio_of(lambda ratio: 0.8 - ratio)[0] == pytest.approx(0.8, rel=1e-5)
    assert ratio_of(lambda ratio: 1e-8 - ratio)[0] == pytest.approx(1e-8, rel=1e-3)
    assert ratio_of(lambda ratio: 1e-10 - ratio)[0] == 0.0


def test_the_last_growth_is_tracked_as_damping_moves_it():
    def growth(speed, ratio):
        return 1 - 100 * ratio - 3 * (speed - 88.9 - 40 * ratio) ** 2

    found, asked = closed(growth)
    assert found == pytest.approx(0.01, rel=2e-3)
    assert len(asked) < 60

    def far(speed, ratio):
        return 1 - 100 * ratio - 0.5 * (speed - 88.2 - 140 * ratio) ** 2

    assert closed(far, band=(88.0, 88.2, 90.0))[0] == pytest.approx(0.01, rel=2e-3)
    # At the edge of a band nothing is asked for beyond.
    edge, asked = closed(
        lambda speed, ratio: 0.01 - ratio + 1e3 * (speed > 90.0), 0.0, (88, 89.995, 90)
    )
    assert edge == pytest.approx(0.01, rel=1e-5)
    assert len(asked) <= 7


# --- turns, windows, steps ----------------------------------------------------------------------


def sampled_until_enough(monkeypatch, digits_a_sample):
    asked = []

    def turn(self, speed, samples, fastest):
        asked.append(samples)
        return SimpleNamespace(turn=samples, orbit=None)

    def found(turn, count, frame):
        return SimpleNamespace(
            series_error=10 ** (-digits_a_sample * turn),
            samples_for=lambda error: -np.log10(error) / digits_a_sample,
        )

    monkeypatch.setattr(solver.LinkageSolver, "_turn", turn)
    monkeypatch.setattr(solver, "counts_of_modes", lambda *of: [3])
    monkeypatch.setattr(solver, "moving_modes", found)
    return solver.LinkageSolver(None, "none", 3).moving_modes(20.0).series_error, asked


def test_a_turn_is_sampled_until_six_digits_are_known(monkeypatch):
    for digits in (0.1, 0.06, 0.05, 0.04, 0.03, 0.025, 0.01):
        error, asked = sampled_until_enough(monkeypatch, digits)
        assert error <= 1e-6
        assert asked[0] == 96
        # No more than half again as many as are needed.
        assert len(asked) == 1 or asked[-1] < 1.51 * 6 / digits
        assert len(asked) <= 2
    # Of what falls too slowly the most that fit into memory are taken, and the error is told.
    assert sampled_until_enough(monkeypatch, 0.005)[1][-1] == 768


def test_multipliers_that_miss_the_trace_by_a_millionth_are_refused():
    solver._check_trace(1e-7, 20.0)
    with pytest.raises(ComputationError, match="Liouville"):
        solver._check_trace(1e-5, 20.0)


def test_windows_are_as_narrow_as_interpolation_needs_and_no_narrower():
    built = []

    def window(low, high):
        built.append(high - low)
        if high > 95.0:
            raise ComputationError("no equilibrium")
        return SimpleNamespace(low=low, high=high, error=1e-6 * ((high - low) / 4) ** 6)

    found = speed_range.narrow_windows(SimpleNamespace(window=window), (80.0, 100.0))
    assert max(each.error for each in found) <= 1e-6
    assert max(each.error for each in found) > 1e-9
    assert max(each.high for each in found) > 93.0
    assert min(built) > 0.5


def test_windows_of_a_fortieth_of_the_lowest_frequency_have_six_nodes():
    """A resonance far away, as of a matrix that goes with the square of the speed, to 1e-8."""
    lowest = 100.0
    ends = speed_range.window_ends([20.0, 60.0], lowest)
    assert len(ends) == 16
    assert ends[0] == (57.5, 60.0)
    low, high = ends[0]
    nodes = speed_window.chebyshev_nodes(low, high)
    built = [
        SimpleNamespace(
            crank_speed=speed,
            conservative=SimpleNamespace(coefficients=np.array([1 / (1 - (speed / lowest) ** 2)])),
        )
        for speed in nodes
    ]
    assert 1e-10 < SpeedWindow(low, high, built).error < 1e-7
    assert not speed_range.windows_are_cheaper(np.linspace(20.0, 60.0, 90).tolist(), lowest)
    assert speed_range.windows_are_cheaper(np.linspace(20.0, 60.0, 100).tolist(), lowest)


def test_harmonics_about_the_largest_hold_all_but_a_thousandth():
    """Of a phase that swings by a radian; beyond the fourth, Bessel's functions are small."""
    turn = 2 * np.pi * np.arange(96) / 96
    wave = np.exp(1j * (7 * turn + np.sin(turn)))
    number, shares = selected_modes._largest_harmonic(wave[:, None, None])
    assert number.tolist() == [7]
    assert 1e-7 < 1 - shares.sum() < 1e-3
    assert len(shares) == 9


def test_a_turn_has_steps_for_the_shapes_that_are_compared():
    assert StabilityRequest(np.array([20.0]), steps=32).steps == 32
    with pytest.raises(InputError, match="from 32 to"):
        StabilityRequest(np.array([20.0]), steps=16)


def test_no_part_of_a_turn_without_equilibrium_is_passed_over():
    assert np.degrees(np.diff(speed_range.TURN)).max() <= 20.0
    assert len(speed_range.TURN) <= 36


def test_a_known_equilibrium_goes_with_the_square_of_the_speed():
    def displacement(speed):
        return [np.full((4, 2), 1e-3 * speed**2 + 1e-7 * speed**4)]

    known = KnownEquilibria()
    for speed in (20.0, 21.0, 22.0):
        known.add(speed, displacement(speed))
    assert known.near(26.0, 4)[0][0, 0] == pytest.approx(displacement(26.0)[0][0, 0], rel=1e-12)
    # More of them would make more of what each is off by.
    random = np.random.default_rng(1)
    for speed in np.linspace(15.0, 22.0, 12):
        known.add(speed, [q * (1 + 1e-9 * random.standard_normal()) for q in displacement(speed)])
    assert known.near(26.0, 4)[0][0, 0] == pytest.approx(displacement(26.0)[0][0, 0], rel=1e-6)


@pytest.mark.parametrize(("size", "harmonics"), [(8, 1), (1, 400)])
def test_the_memory_of_a_turn_is_what_is_said(monkeypatch, size, harmonics):
    """Matrices of each step, and the waves of each harmonic."""
    steps = 2048
    random = np.random.default_rng(2)
    coefficients = 1e-3 * random.standard_normal((harmonics + 1, 2 * size, 2 * size)) + 0j
    system = SampledPeriodicSystem(FourierSeries(coefficients), 1.0)
    tracemalloc.start()
    floquet_modes(system, steps).shapes()
    _, used = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    moving = SimpleNamespace(
        size=size, conservative=system.matrix, is_constant=False, fastest=1.0, crank_speed=1.0
    )
    monkeypatch.setattr(vibrating_linkage, "MOST_BYTES", 4 * used)
    assert vibrating_linkage.steps_of_turn(moving, steps, beside_free_shaft=False) == steps
    monkeypatch.setattr(vibrating_linkage, "MOST_BYTES", used / 4)
    with pytest.raises(ComputationError, match="GB"):
        vibrating_linkage.steps_of_turn(moving, steps, beside_free_shaft=False)


def test_turns_take_no_more_than_memory_has():
    """Of matrices of ten modes, 32 kB a step."""
    series = FourierSeries(np.zeros((1, 20, 20), dtype=complex))
    moving = SimpleNamespace(
        size=10, conservative=series, is_constant=False, fastest=1.0, crank_speed=1.0
    )
    vibrating_linkage.steps_of_turn(moving, 96_000, beside_free_shaft=False)
    with pytest.raises(ComputationError, match="fewer steps"):
        vibrating_linkage.steps_of_turn(moving, 160_000, beside_free_shaft=False)


def swinging(waves, depth, harmonic=1):
    """A swing of so many periods a turn whose stiffness changes, and its steps."""
    rate = 2 * np.pi * waves
    coefficients = np.zeros((harmonic + 1, 2, 2), dtype=complex)
    coefficients[0] = [[0.0, rate], [-rate, 0.0]]
    coefficients[harmonic, 1, 0] = -depth * rate / 2
    series = FourierSeries(coefficients)
    moving = SimpleNamespace(
        size=1, conservative=series, is_constant=False, fastest=rate, crank_speed=1.0, period=1.0
    )
    steps = [
        vibrating_linkage.steps_of_turn(moving, None, beside_free_shaft=free)
        for free in (False, True)
    ]
    return SampledPeriodicSystem(series, 1.0), steps


def multipliers(system, steps):
    angle = np.angle(np.exp(floquet_modes(system, steps).exponent))
    return np.sort(angle)


def test_steps_resolve_the_fastest_moving_mode():
    system, (steps, beside_free_shaft) = swinging(400.3, 0.2)
    assert 1200 < steps < 2500
    assert 2 * steps < beside_free_shaft < 5 * steps
    apart = np.abs(multipliers(system, steps) - multipliers(system, 3 * steps)).max()
    # Of a turn of two and a half thousand radians.
    assert 1e-10 < apart < 1e-4
    # Of slow modes what changes along the turn.
    system, (steps, _) = swinging(0.31, 0.5, harmonic=8)
    apart = np.abs(multipliers(system, steps) - multipliers(system, 3 * steps)).max()
    assert apart < 1e-7
    assert steps < 300


def test_processes_have_half_a_second_to_end():
    context = multiprocessing.get_context("fork")
    quick, slow = (context.Process(target=time.sleep, args=(s,)) for s in (0.1, 30.0))
    began = time.monotonic()
    for process in (quick, slow):
        process.start()
    _end([quick, slow])
    assert quick.exitcode == 0
    assert slow.exitcode != 0
    assert 0.2 < time.monotonic() - began < 5.0
