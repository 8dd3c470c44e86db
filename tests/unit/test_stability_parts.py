"""Parts of a stability map: names of bands, runs of growth, windows of speeds, processes."""

import math
from dataclasses import replace

import numpy as np
import pytest

from flexmech.analyses.damping_ratios import with_damping_ratio
from flexmech.analyses.stability import against, edges, speed_range
from flexmech.analyses.stability.collisions import Meeting, meetings
from flexmech.analyses.stability.growth import Sample, runs_of_growth, speeds_between
from flexmech.analyses.stability.mode_tracking import usual_frequencies
from flexmech.analyses.stability.naming import BandName, band_name, signatures_of
from flexmech.analyses.stability.parallel import FEW, in_order
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.errors import ComputationError
from flexmech.reference import ReferenceEngine
from flexmech.threads import one_thread
from tests.unit.stability_data import FREQUENCIES, followed

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
        band_name(np.array([41.2, 52.3, 181.0]), parts, USUAL, crank, width, differences=False)
        for width in (0.001, 0.05)
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
