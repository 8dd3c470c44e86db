"""Tolerances of Campbell diagrams: each test fails if its constant is taken away or another one."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from flexmech.analyses.campbell import bands, edges, projection
from flexmech.analyses.campbell.bands import Bands, BandSolver
from flexmech.analyses.campbell.compute import response_speeds
from flexmech.analyses.campbell.crossings import Edge, critical_speeds, edges_of
from flexmech.analyses.campbell.sampling import FIT_TOLERANCE, band_fit, sampled_bands, speed_grid
from flexmech.linear_system import RefusedPositionsError

ANGLES = np.radians(np.arange(0.0, 360.0, 5.0))


class Linkage:
    """Frequencies of one branch over crank angle and speed, whose bands are known."""

    def __init__(self, monkeypatch, frequency, *, unstable=None):
        self.frequency, self.unstable = frequency, unstable
        self.calls, self.positions = 0, 0
        for room in (bands, edges):
            monkeypatch.setattr(room, "frequencies_along", self.along)
        monkeypatch.setattr(bands, "extremes_between", self.extremes)

    def along(self, systems, angle, speed):
        self.calls += 1
        self.positions += len(angle)
        if self.unstable is not None:
            refused = self.unstable(angle, speed)
            if refused.any():
                raise RefusedPositionsError(
                    "unstable",
                    crank_speed=float(speed[refused][0]),
                    crank_angles=angle[refused],
                    crank_speeds=speed[refused],
                )
        return self.frequency(angle, speed)[:, None]

    def extremes(self, systems, angles, speeds, frequency, error, *, full_turn):
        fine = np.linspace(0.0, 2 * np.pi, 20001)
        values = np.array([self.frequency(fine, speed) for speed in speeds])
        low, high = values.argmin(axis=1), values.argmax(axis=1)
        rows = np.arange(len(speeds))
        return SimpleNamespace(
            lowest_frequency=values[rows, low][:, None],
            highest_frequency=values[rows, high][:, None],
            lowest_angle=fine[low][:, None],
            highest_angle=fine[high][:, None],
        )

    def solver(self) -> BandSolver:
        systems = SimpleNamespace(
            formulation=SimpleNamespace(modes=1), engine=SimpleNamespace(batch_size=2000)
        )
        return BandSolver(systems, ANGLES, True, np.full(1, 1e-4), lambda count: None)


def smooth(angle, speed):
    return (10 + (speed / 40) ** 2) * (1 + 0.1 * np.cos(angle - 1.0 - speed / 50))


def bent(angle, speed):
    """Another crank angle becomes the lowest at 47 rad/s."""
    return 10 + np.minimum(np.cos(angle) + speed / 47, 2 - np.cos(angle) - speed / 47 + 1.0)


# --- speeds that are solved for -----------------------------------------------------------------


def test_few_of_many_speeds_are_solved_for_and_the_others_fitted(monkeypatch):
    linkage = Linkage(monkeypatch, smooth)
    speeds = np.linspace(0.0, 100.0, 201)
    found, places = sampled_bands(linkage.solver(), speeds)
    exact = np.array([[10 + (w / 40) ** 2 for w in speeds]]).T * np.array([0.9, 1.0, 1.1])
    np.testing.assert_allclose(found.values[places, :, 0], exact, rtol=FIT_TOLERANCE)
    assert len(found.solved.crank_speed) == 17
    # A dozen speeds are all solved for.
    found, places = sampled_bands(linkage.solver(), np.linspace(0.0, 100.0, 13))
    assert np.isin(found.crank_speed[places], found.solved.crank_speed).all()
    assert len(found.solved.crank_speed) == 25
    found, places = sampled_bands(linkage.solver(), np.linspace(0.0, 100.0, 40))
    assert not np.isin(found.crank_speed[places], found.solved.crank_speed).all()


def test_a_fit_is_refined_to_what_the_mesh_is_off_by(monkeypatch):
    def wavy(angle, speed):
        return smooth(angle, speed) * (1 + 0.02 * np.sin(speed / 6))

    linkage = Linkage(monkeypatch, wavy)
    speeds = np.linspace(0.0, 100.0, 401)
    found, _ = sampled_bands(linkage.solver(), speeds)
    exact = wavy(1.0 + found.crank_speed / 50, found.crank_speed)
    assert np.abs(found.values[:, 2, 0] / exact - 1).max() < 1.5 * 3e-4
    assert 20 < len(found.solved.crank_speed) < 70
    assert 1e-6 < found.fit_error <= 3e-4


def test_two_crossings_are_seen_that_are_a_hundredth_of_the_range_apart():
    for count in (2, 10, 200):
        grid, places = speed_grid(np.linspace(0.0, 100.0, count))
        assert 128 <= len(grid) - 1 < 300
        assert len(places) == count


def test_bends_are_told_from_what_the_fit_may_be_off_by():
    nodes = np.arange(10.0)
    sense = np.array([1.0, 1.0, -1.0])[:, None]

    def missed(slope):
        """Greatest error of a fit to a curve with a bend between two nodes."""
        at = np.linspace(0.0, 9.0, 181)

        def curve(x):
            return 1 + sense * slope * np.minimum(x - 4.6, 0.0)[:, None, None]

        return np.abs(band_fit(nodes, curve(nodes), at) - curve(at))[:, ::2].max() / slope

    assert missed(1e-2) < 1e-6
    assert missed(3e-4) < 1e-6
    # Round-off of the values is no bend.
    assert missed(1e-6) > 1e-3
    # More nodes than four would run over a bend that is two nodes away.
    assert missed(1.0) < 1e-6


def test_speeds_without_solution_are_found_in_few_rounds(monkeypatch):
    def unstable(angle, speed):
        return (speed > 77.7) & (np.abs(angle - 2.0) < 0.3)

    linkage = Linkage(monkeypatch, smooth, unstable=unstable)
    found, _ = sampled_bands(linkage.solver(), np.linspace(0.0, 100.0, 51))
    exists = found.crank_speed[found.exists]
    assert 76.0 < exists.max() < 77.7
    # Speeds without solution are not solved for over whole turns.
    assert linkage.positions < 60 * len(ANGLES)
    assert linkage.calls < 90


def test_speeds_in_doubt_are_tried_at_a_sixth_of_the_angles(monkeypatch):
    for width, seen in ((0.6, True), (0.2, False)):

        def unstable(angle, speed, width=width):
            return np.abs(angle - np.radians(100.0)) < width / 2

        linkage = Linkage(monkeypatch, smooth, unstable=unstable)
        assert bool(linkage.solver().probe(np.array([10.0]))[0]) is seen
        assert linkage.positions <= 13


def test_speeds_are_tried_where_some_have_failed_at_three_angles(monkeypatch):
    tried = []

    def unstable(angle, speed):
        tried.extend(angle)
        return (speed > 50.0) & (np.abs(angle - speed / 20) < 0.3)

    solver = Linkage(monkeypatch, smooth, unstable=unstable).solver()
    for speed in (60.0, 75.0, 90.0):
        solver.solve(np.array([speed]))
    tried.clear()
    solver.probe(np.array([10.0]))
    assert 1 < len(set(tried)) <= 3


# --- critical speeds ----------------------------------------------------------------------------


def crossed(monkeypatch, frequency, orders, fastest=100.0, count=26):
    linkage = Linkage(monkeypatch, frequency)
    solver = linkage.solver()
    found, _ = sampled_bands(solver, np.linspace(0.0, fastest, count))
    passed = edges_of(found.crank_speed, found.values, np.array(orders))
    linkage.calls = linkage.positions = 0
    speeds, off = edges.exact_edges(solver, found, passed)
    return passed, speeds, off, linkage


def test_ends_of_critical_speeds_are_known_to_eight_digits(monkeypatch):
    passed, speeds, off, linkage = crossed(monkeypatch, smooth, [1, 2, 3])
    assert len(passed) == 5
    for edge in passed:
        part = 0.9 if edge.end == 0 else 1.1
        # part (10 + w^2 / 1600) = order w / (2 pi)
        roots = np.roots([part / 1600, -edge.order / (2 * np.pi), 10 * part])
        assert speeds[edge] == pytest.approx(min(roots.real), rel=2e-9)
    assert off < 1e-8
    assert linkage.calls <= 9
    # All in a few crank angles: none over whole turns.
    assert linkage.positions < 200


def test_a_band_without_width_is_met_at_once(monkeypatch):
    passed, speeds, _, linkage = crossed(monkeypatch, lambda angle, speed: 10 + 0 * angle, [1, 2])
    for edge in passed:
        assert speeds[edge] == pytest.approx(20 * np.pi / edge.order, rel=1e-10)
    assert linkage.calls <= 4
    assert linkage.positions < 100


def valleys(heights):
    """Sharp valleys at some crank angles, so high above ten at a speed."""

    def frequency(angle, speed):
        depths = [
            np.sqrt(np.sin((angle - place) / 2) ** 2 + 1e-3) + height(speed)
            for place, height in heights.items()
        ]
        return 10 + np.min(depths, axis=0) + 0.02 * np.sin(3 * (angle - 0.8))

    return frequency


def entered(monkeypatch, heights, solved=5):
    """Speed at which the first order enters the band, the exact one, and what that took."""
    frequency = valleys(heights)
    passed, speeds, _, linkage = crossed(monkeypatch, frequency, [1], count=solved)
    (low,) = (edge for edge in passed if edge.end == 0)

    def end(speed):
        least = []
        for place in heights:
            near = (place - 0.1, place + 0.1)
            found = minimize_scalar(
                lambda angle: frequency(angle, speed), bounds=near, options={"xatol": 1e-12}
            )
            least.append(found.fun)
        return min(least) - speed / (2 * np.pi)

    return speeds[low], brentq(end, 50.0, 80.0, xtol=1e-10), linkage


def test_a_ray_meets_the_first_of_two_extremes(monkeypatch):
    def last(speed):
        return 0.02 * (52 - speed) / 52

    found, exact, linkage = entered(monkeypatch, {1.01: lambda speed: 0.0, 4.03: last})
    assert found == pytest.approx(exact, rel=1e-8)
    assert linkage.positions < 400


def near_extremes(rise, above, count=2):
    """Crank angles followed, where the band's end rises and others are so far above it."""
    places = np.pi * (0.25 + np.arange(count) / count) * 2
    height = np.arange(count) * above / max(count - 1, 1)

    def frequency(end):
        return end + np.min(
            [1 - np.cos(ANGLES - at) + by for at, by in zip(places, height, strict=True)], axis=0
        )

    ends = np.array([10.0, 10.0 + rise])
    values = np.repeat(ends[:, None, None], 3, axis=1)
    angle = np.full((2, 2, 1), places[0])
    solved = Bands(
        np.array([50.0, 60.0]), values, angle, np.stack([frequency(e) for e in ends])[..., None]
    )
    solver = SimpleNamespace(crank_angles=ANGLES, full_turn=True)
    edge = Edge(1, 1, 0, 0, enters=True)
    return len(edges._extremes_near(solver, solved, edge, np.array([52.0, 53.0])))


def test_extremes_are_followed_that_are_as_near_as_the_end_moves():
    assert near_extremes(0.0, 0.1) == 2
    assert near_extremes(0.0, 0.3) == 1
    assert near_extremes(0.7, 1.0) == 2
    assert near_extremes(0.2, 1.0) == 1
    assert near_extremes(0.7, 0.5, 6) == 3


def followed(frequency, monkeypatch, *, slope=0.0, aside=0.0436, angle=1.0):
    """A search of one extreme about 60 rad/s, in a step of a width of one."""
    monkeypatch.setattr(edges, "frequencies_along", lambda of, a, w: frequency(a, w)[:, None])
    one = np.ones(1)
    return edges._Search(
        owner=np.zeros(1, dtype=np.intp),
        sign=one,
        mode=np.zeros(1, dtype=np.intp),
        order=one,
        low=59.5 * one,
        high=60.5 * one,
        speed=60.0 * one,
        slope=slope * one,
        angle=angle * one,
        aside=aside * one,
        last=np.full((2, 1), np.nan),
        off=np.full(1, np.inf),
        converged=np.zeros(1, dtype=bool),
    )


def test_extremes_are_level_but_for_round_off(monkeypatch):
    def narrow(angle, speed):
        return 10 * (1 - 2.6e-6 * np.cos(angle - 1.02))

    search = followed(narrow, monkeypatch)
    found, _ = search._narrowed(None, np.zeros(1, dtype=np.intp), 1e-3)
    assert found[0] == pytest.approx(10 * (1 - 2.6e-6), rel=1e-10)

    def flat(angle, speed):
        return 10 * (1 + 2e-11 * np.linspace(-1.0, 1.0, 3))

    _, certain = followed(flat, monkeypatch)._narrowed(None, np.zeros(1, dtype=np.intp), 1e-3)
    assert certain.all()


def test_speeds_do_not_run_away_from_their_step(monkeypatch):
    """An extreme that moves almost as the ray does meets it far away, if at all."""

    def along(angle, speed):
        return speed / (2 * np.pi) + 1e-3 * (2 - np.cos(angle - 1.0))

    search = followed(along, monkeypatch, slope=(1 - 1e-6) / (2 * np.pi))
    search.advance(None, 1e-3)
    assert 60.6 < search.speed[0] < 61.5


def test_of_many_extremes_the_lowest_three_are_followed(monkeypatch):
    places = 0.3 + 0.6 * np.arange(10)
    heights = {p: lambda speed, p=p: 0.01 * np.sin(7 * p) for p in places.tolist()}
    found, exact, linkage = entered(monkeypatch, heights)
    assert found == pytest.approx(exact, rel=1e-8)
    assert linkage.positions < 200


def test_a_band_with_hardly_any_width_is_flat_but_for_round_off(monkeypatch):
    def narrow(angle, speed):
        noise = 1e-12 * np.sin(1e7 * angle + 1e5 * speed)
        return 10 * (1 - 2.6e-6 * np.cos(angle - 1.02) + noise)

    passed, speeds, _, linkage = crossed(monkeypatch, narrow, [1])
    for edge in passed:
        part = 1 - 2.6e-6 if edge.end == 0 else 1 + 2.6e-6
        assert speeds[edge] == pytest.approx(20 * np.pi * part, rel=2e-10)
    assert linkage.positions < 100


def test_a_ray_meets_a_band_at_a_speed_of_the_grid(monkeypatch):
    """Within round-off it is in the step before it or in that behind."""
    for off in (-1e-9, 0.0, 1e-9):

        def frequency(angle, speed, off=off):
            return (1 + off) * (30 / np.pi) * (1.1 + 0.1 * np.cos(angle - 1.0))

        _, speeds, _, linkage = crossed(monkeypatch, frequency, [1])
        assert min(speeds.values()) == pytest.approx(60.0, rel=5e-9)
        assert linkage.positions < 100


def test_a_ray_that_comes_within_a_tenth_of_a_band_is_told():
    speed = np.linspace(0.0, 100.0, 11)
    for gap, told in ((0.05, 1), (0.2, 0)):
        level = np.full((11, 3, 1), 100 / (2 * np.pi) / (1 - gap))
        assert len(critical_speeds(speed, level, np.array([1]), {})) == told


def test_periodic_motions_are_sought_at_a_hundred_speeds_that_are_not_slow():
    found = response_speeds(np.linspace(0.0, 100.0, 1001))
    assert len(found) == 100
    assert found.min() == 5.0
    assert response_speeds(np.array([1.0, 4.0, 6.0, 100.0])).tolist() == [6.0, 100.0]


def test_the_smallest_space_is_taken_that_is_right_to_seven_digits(monkeypatch):
    tried = []

    def solved(space, count):
        if space is None:
            return np.ones(count)
        tried.append(space)
        return np.ones(count) * (1 + 1e-4 * 30.0 ** -len(tried))

    class Whole:
        def __init__(self, *of, **space):
            self.space = space

        def at(self, *of):
            return None

    monkeypatch.setattr(projection, "ProjectedSystems", Whole)
    monkeypatch.setattr(projection, "krylov_projected", lambda full, space: space)
    monkeypatch.setattr(projection, "solve_frequencies", solved)
    monkeypatch.setattr(projection, "replace", lambda whole, space: Whole(space=space))
    systems = SimpleNamespace(
        formulation=SimpleNamespace(modes=3), engine=SimpleNamespace(unreduced=lambda: None)
    )
    # Errors of 3e-6, 1e-7.
    _, error = projection.projected_systems(systems, np.zeros(1), np.zeros(1))
    assert len(tried) == 2
    assert error < 2e-7
