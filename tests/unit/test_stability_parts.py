"""Parts of a stability map: names of bands, runs of growth, windows of speeds, processes."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from flexmech.analyses.damping_ratios import with_damping_ratio
from flexmech.analyses.stability import against, edges, speed_range
from flexmech.analyses.stability.collisions import Meeting, meetings
from flexmech.analyses.stability.growth import (
    Sample,
    SignedGrowth,
    dips,
    runs_of_growth,
    speeds_between,
    speeds_inside,
)
from flexmech.analyses.stability.mode_tracking import usual_frequencies
from flexmech.analyses.stability.naming import (
    DIVERGENCE,
    UNNAMED,
    BandName,
    band_name,
    closing_fits,
    following_speeds,
    multiplier_fits,
    name_of_growth,
    signatures_of,
    without_repetition,
)
from flexmech.analyses.stability.parallel import FEW, in_order
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.errors import ComputationError
from flexmech.reference import ReferenceEngine
from flexmech.threads import one_thread
from tests.support.stability_data import FREQUENCIES, followed

USUAL = np.array([44.0, 49.0, 180.0])


def name_of(frequency, part, crank, *, differences=False):
    found = band_name(
        np.array(frequency), np.array(part), USUAL, crank, 0.02, differences=differences
    )
    return found.kind, found.branches, found.order


def test_a_mode_that_meets_itself_makes_a_principal_band():
    assert name_of([44.5, 49.0, 181.0], [0.99, 0.05, 0.02], 89 / 7) == ("principal", (1, 1), 7)


def test_two_modes_make_a_sum():
    assert name_of([44.5, 49.0, 181.0], [0.7, 0.7, 0.02], 93.5 / 6) == ("sum", (1, 2), 6)


def test_differences_have_names_only_where_they_can_grow():
    frequency, part, crank = [44.5, 49.0, 181.0], [0.02, 0.7, 0.7], 132 / 11
    assert name_of(frequency, part, crank, differences=True) == ("difference", (2, 3), 11)
    assert name_of(frequency, part, crank)[0] != "difference"


def test_modes_that_changed_places_are_named_by_their_frequency():
    # Branch 3 carries the frequency that is usual for branch 2.
    assert name_of([44.0, 180.0, 49.0], [0.1, 0.1, 0.99], 14.0) == ("principal", (2, 2), 7)


def test_a_narrow_band_is_named_by_what_meets_exactly():
    # Twice f1 is near seven times the crank's frequency, but f1 + f2 is eight times that.
    parts, crank = np.array([0.8, 0.5, 0.02]), 93.5 / 8
    names = [
        band_name(np.array([41.2, 52.3, 181.0]), parts, USUAL, crank, pull, differences=False)
        for pull in (0.004, 0.175)
    ]
    assert [(name.kind, name.order) for name in names] == [("sum", 8), ("principal", 7)]


def test_a_name_that_cannot_be_gives_way_to_the_next():
    parts, crank = np.array([0.8, 0.5, 0.02]), 93.5 / 8
    found = band_name(
        np.array([41.2, 52.3, 181.0]),
        parts,
        USUAL,
        crank,
        0.05,
        differences=False,
        is_refused=lambda name: name.kind == "principal",
    )
    assert (found.kind, found.order) == ("sum", 8)


def test_no_multiple_is_no_name():
    assert name_of([44.5, 49.0, 181.0], [0.99, 0.0, 0.0], 89 / 7.5) == ("unnamed", (), 0)
    found = band_name(
        np.array([44.5]), np.array([0.9]), np.array([44.0]), 7.0, 0.02, differences=False
    )
    assert math.isnan(found.mismatch) or found.mismatch < 0.25


def samples(growth):
    return [Sample(float(speed), g, g) for speed, g in growth.items()]


def test_signatures_are_those_beside_the_band_where_both_are_clear():
    # Branch 1 is about to meet another one at 91; -f_b is the mode of branch b that turns back.
    found = [followed(speed) for speed in (85.0, 87.0, 91.0, 96.0)]
    signature = np.array([0.9, -0.9, 0.8, -0.8, -0.7, 0.7, 0.6, -0.6])
    found = [replace(each, krein_signature=signature) for each in found]
    found[1] = replace(found[1], krein_signature=signature / 2)
    found[2] = replace(found[2], krein_signature=signature * np.repeat([0, 1, 1, 1], 2))
    ends = (88.0, 90.0)

    def named(kind, branches):
        # Beside the band frequencies are a little different.
        return BandName(kind, branches, 7, 0.0, tuple(1.01 * FREQUENCIES[b - 1] for b in branches))

    def signatures(kind, branches):
        return signatures_of(named(kind, branches), ends, found)

    assert signatures("sum", (1, 2)) == (0.45, -0.4)
    assert signatures("principal", (2, 2)) == (0.4, -0.4)
    assert signatures("sum", (2, 3)) == (0.4, 0.35)
    assert signatures("difference", (2, 3)) == (0.4, -0.35)
    assert signatures_of(named("sum", (2, 4)), (84.0, 88.0), found) == (0.8, -0.6)
    assert np.isnan(signatures("unnamed", ())).all()
    assert np.isnan(signatures_of(named("sum", (1, 2)), (80.0, 99.0), found)).all()
    # A mixture was taken for another branch: a mode is known by its frequency.
    places = np.array([0, 1, 6, 7, 4, 5, 2, 3])
    swapped = [
        replace(each, exponent=each.exponent[places], krein_signature=each.krein_signature[places])
        for each in found
    ]
    assert signatures_of(named("sum", (1, 2)), ends, swapped) == (0.45, -0.4)


def test_usual_frequencies_are_free_of_what_mixtures_were_taken_for():
    # Slow speeds show another member of a family; later two branches change places.
    found = usual_frequencies(
        np.array(
            [
                [44.0, 49.0, 160.0],
                [44.0, 49.0, 161.0],
                [44.0, 49.0, 162.0],
                [44.0, 180.0, 49.0],
                [44.2, 180.5, 49.5],
                [44.1, 49.2, 181.0],
            ]
        )
    )
    assert found.tolist() == [44.1, 49.2, 180.5]


def test_runs_lie_between_speeds_at_which_nothing_grows():
    runs = runs_of_growth(samples({1: -1, 2: 1, 3: 2, 4: -1, 5: 3, 6: -1}), [])
    assert [run.brackets for run in runs] == [((2, 1), (3, 4)), ((5, 4), (5, 6))]
    assert [run.fastest for run in runs] == [3, 5]


def test_runs_are_open_at_the_ends_and_where_equilibrium_ends():
    runs = runs_of_growth(samples({1: 1, 2: 1, 4: 1, 5: -1}), [3.0])
    assert [run.brackets for run in runs] == [((1, 1), (2, 2)), ((4, 4), (4, 5))]


def test_between_growing_speeds_far_apart_more_are_asked_for():
    grown = samples({1: 1, 3: 1, 3.5: 1, 5: -1, 6: 1, 8: 1})
    assert speeds_between(grown, 1.0, [7.0]) == [2.0]
    assert speeds_between(grown, 0.5, [7.0]) == [1.5, 2.0, 2.5]


def test_a_dip_between_two_bands_is_followed_down_to_where_nothing_grows(monkeypatch):
    """Two bands, 1 to 4.9 and 5.1 to 9: no sample lies between them."""

    def growth(self, speed):
        signed = (speed - 5.0) ** 2 - 0.01
        return Sample(speed, signed, signed)

    monkeypatch.setattr(SignedGrowth, "sample", growth)
    measure = SignedGrowth(None)
    known = [growth(None, speed) for speed in (1.0, 3.0, 4.5, 7.0, 9.0)]
    (dip,) = dips(known, [])
    assert dip.lowest.crank_speed == 4.5
    assert dips(known, [4.0]) == []
    found = measure.into(dip)
    assert found[-1].signed_growth < 0 < min(each.signed_growth for each in found[:-1])
    assert len(runs_of_growth(known + found, [])) == 2


def test_growth_inside_a_wide_run_is_looked_at_closer_to_its_ends():
    wide, narrow = runs_of_growth(samples({1: -1, 2: 1, 5: -1, 6: 1, 6.5: -1}), [])
    speeds = speeds_inside([wide, narrow], 4, 3.0)
    assert speeds == pytest.approx([1 + 4 * share for share in (0.1464, 0.5, 0.8536)], abs=1e-3)


def growing(angle, crank=20.0):
    """Two modes, the first of which grows; angle of its multiplier in half turns."""
    exponent = np.array([1.0 + 1j * np.pi * angle * crank, -1.0 + 300j])
    return SimpleNamespace(
        exponent=exponent,
        angle=np.array([np.pi * angle, 1.0]),
        period=1 / crank,
        crank_speed=2 * np.pi * crank,
    )


@pytest.mark.parametrize(
    ("angle", "kind", "order", "fits"),
    [
        (1.0, "principal", 5, True),
        (-1.0, "principal", 5, True),
        (1.0, "principal", 4, False),
        (0.0, "principal", 4, True),
        (0.0, "principal", 5, False),
        (0.5157, "principal", 5, False),
        (0.5157, "sum", 5, True),
        (1.0, "sum", 5, False),
        (0.3, "difference", 2, True),
    ],
)
def test_a_real_multiplier_is_that_of_one_mode_and_of_its_order(angle, kind, order, fits):
    branches = (1, 1) if kind == "principal" else (1, 2)
    name = BandName(kind, branches, order, 0.0, (50.0, 50.0))
    assert multiplier_fits(name, growing(angle)) is fits


def test_two_bands_of_one_name_have_none():
    once, twice = BandName("sum", (1, 2), 5, 0.0, (43.0, 47.0)), BandName("sum", (2, 3), 12, 0.0)
    found = without_repetition([once, twice, UNNAMED, twice, DIVERGENCE, DIVERGENCE, UNNAMED])
    assert found == [once, UNNAMED, UNNAMED, UNNAMED, DIVERGENCE, DIVERGENCE, UNNAMED]


def test_growth_without_oscillation_is_divergence():
    assert name_of_growth(growing(0.0), [], differences=False) is DIVERGENCE
    assert name_of_growth(growing(0.3), [], differences=False) is UNNAMED


def test_modes_are_followed_at_the_same_speeds_whatever_is_asked_for():
    far, near = (following_speeds(fastest, 7.0) for fastest in (116.0, 20.0))
    assert near.tolist() == [14.0, 21.0]
    assert far[: len(near)].tolist() == near.tolist()
    assert far[-1] == 119.0
    assert following_speeds(-20.0, 7.0).tolist() == [-14.0, -21.0]


@pytest.fixture(scope="module")
def solver(aluminium):
    return LinkageSolver(ReferenceEngine(aluminium, elements=4), "equilibrium", 4)


def test_a_window_gives_what_is_built_at_each_speed(solver):
    windowed = replace(solver, windows=(solver.window(30.0, 34.0),))
    assert windowed.windows[0].error < 1e-8
    speed = 31.234
    direct, between = (s.solve(s.moving(speed)) for s in (solver, windowed))
    for exponent in direct.exponent:
        assert np.abs(between.exponent - exponent).min() < 1e-6 * abs(exponent)


def test_a_second_parameter_is_mapped_by_windows_where_these_are_cheaper(aluminium, monkeypatch):
    engine = ReferenceEngine(aluminium, elements=4)
    request = StabilityRequest(np.linspace(84.0, 88.0, 9), modes=2, damping_ratio=0.001)
    parameter = against.Against.of(aluminium, ("damping-ratio", [0.0, 0.01]))
    built = []
    own = against.LinkageSolver.moving

    def counting(self, crank_speed):
        built.append(any(window.contains(crank_speed) for window in self.windows))
        return own(self, crank_speed)

    monkeypatch.setattr(against, "in_order", lambda task, items: map(task, items))
    monkeypatch.setattr(against.LinkageSolver, "moving", counting)

    def mapped():
        with one_thread():
            return against.map_against([engine], request, parameter, lambda *_: None)

    by_windows = mapped()
    assert built == [True] * 9
    monkeypatch.setattr(against, "windows_are_cheaper", lambda *_: False)
    one_by_one = mapped()
    assert built[9:] == [False] * 9
    assert (by_windows["against_unstable"] == one_by_one["against_unstable"]).all()
    assert set(by_windows["against_unstable"].values.ravel()) == {"yes", "no"}
    rates = by_windows["against_growth_rate"].values
    assert rates == pytest.approx(one_by_one["against_growth_rate"].values, abs=1e-5)


def test_few_speeds_need_no_windows():
    assert speed_range.windows_are_cheaper(np.arange(60.0, 100.0, 0.5).tolist(), 270.0)
    assert not speed_range.windows_are_cheaper(np.arange(60.0, 100.0, 2.0).tolist(), 270.0)


def test_growth_alone_is_that_of_the_kept_modes(solver):
    damped = replace(solver, engine=with_damping_ratio(solver.engine, 0.002), modes=2)
    for speed in (31.0, 89.0):
        moving = damped.moving(speed)
        assert damped.growth_at(moving) == pytest.approx(damped.solve(moving).growth_rate, rel=1e-9)


def test_growth_alone_is_held_to_the_trace_of_the_system(solver, monkeypatch):
    monkeypatch.setattr("flexmech.analyses.stability.solver.LIOUVILLE", -1.0)
    moving = solver.moving(31.0)
    for ask in (solver.solve, solver.growth_at):
        with pytest.raises(ComputationError, match="Liouville"):
            ask(moving)


def test_an_edge_is_found_from_what_is_known_of_its_bracket(monkeypatch):
    asked = []

    def growth(self, speed):
        asked.append(speed)
        return speed**3 - 8

    monkeypatch.setattr(edges.SignedGrowth, "__call__", growth)
    found = edges.find_edge(None, edges.EdgeSearch(3.0, 1.0, 19.0, -7.0))
    assert found.crank_speed == pytest.approx(2.0, rel=1e-7)
    assert found.width == 2.0
    assert not {1.0, 3.0} & set(asked)
    assert len(set(asked)) == len(asked)
    assert abs(found.growth) < 1e-6
    assert edges.find_edge(None, edges.EdgeSearch(3.0, 3.0, 19.0, 19.0)).width == 0.0


def test_a_window_does_not_reach_beyond_the_last_equilibrium(solver):
    with pytest.raises(ComputationError):
        solver.window(150.0, 160.0)


def test_clockwise_speeds_have_windows_too(solver):
    windowed = replace(solver, windows=(solver.window(-34.0, -30.0),))
    direct, between = (s.solve(s.moving(-33.0)) for s in (solver, windowed))
    for exponent in direct.exponent:
        assert np.abs(between.exponent - exponent).min() < 1e-6 * abs(exponent)


@pytest.mark.parametrize("count", [1, FEW, 3 * FEW])
def test_tasks_answer_in_order_from_any_number_of_processes(count):
    offset = np.arange(5)
    assert list(in_order(lambda item: item + int(offset[-1]), range(count))) == [
        item + 4 for item in range(count)
    ]


def test_an_error_of_a_task_arrives_as_it_is():
    def fails(item):
        raise ComputationError("item 3") if item == 3 else ValueError(item)

    with pytest.raises(ComputationError, match="item 3"):
        list(in_order(lambda item: fails(item) if item == 3 else item, range(20)))


def test_multipliers_that_miss_liouvilles_integral_are_refused(solver, monkeypatch):
    linkage = solver.moving(30.0)
    monkeypatch.setattr("flexmech.analyses.stability.solver.LIOUVILLE", -1.0)
    with pytest.raises(ComputationError, match="Liouville"):
        solver.solve(linkage)


def test_modes_that_stay_together_between_two_speeds_meet_between_them():
    free = 10 * 76.0 / (4 * np.pi)
    meeting = Meeting(76.0, 77.0, (free, free), (free * 77 / 76, free * 77 / 76), 10)
    assert 76.0 <= meeting.crank_speed <= 77.0
    assert meeting.slope == -5.0


def test_two_modes_that_creep_meet_nowhere():
    def creeping(speed):
        found = followed(speed)
        exponent = found.exponent.copy()
        exponent[:2] = -1.0, -2.0
        return replace(found, exponent=exponent)

    pairs = meetings([creeping(80.0), creeping(81.0)], len(FREQUENCIES))
    assert pairs
    assert (0, 0) not in [pair.branches for pair in pairs]
    assert all(np.isfinite(meeting.crank_speed) for pair in pairs for meeting in pair.meetings)


@pytest.mark.parametrize("start", [0.0, 1e-3])
def test_a_name_fits_the_damping_that_closes_its_band(start):
    """By the growth of two modes that meet: ``(s + d_a) (s + d_b) = g^2``."""
    lowest, growth = 2 * np.pi * 43.0, 15.3
    name = BandName("sum", (1, 2), 5, 0.0, (43.0, 47.0))
    decay = (2 * np.pi * np.array(name.frequencies)) ** 2 / lowest
    closing = growth / np.sqrt(np.prod(decay))
    slower = np.roots([1.0, start * decay.sum(), start**2 * np.prod(decay) - growth**2]).max()
    for factor, fits in ((1.0, True), (1.9, True), (2.1, False), (1 / 1.9, True), (1 / 2.1, False)):
        assert closing_fits(name, slower, start, factor * closing, lowest) is fits
    wrong = BandName("principal", (5, 5), 22, 0.0, (199.0, 199.0))
    assert not closing_fits(wrong, slower, start, closing, lowest)
    assert closing_fits(wrong, slower, start, float("nan"), lowest)
    assert closing_fits(UNNAMED, slower, start, closing, lowest)
