"""Tolerances of frequency maps: each test fails if its constant is taken away or is another one."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse
import xarray as xr

from flexmech.analyses import damping_ratios
from flexmech.analyses.digits import rounded
from flexmech.analyses.frequencies import (
    discretisation,
    eigenproblem,
    engine_map,
    extremes,
    inverse_iteration,
    quadratic_eigenproblem,
    reduction,
)
from flexmech.analyses.frequencies.extremes import extremes_between
from flexmech.analyses.frequencies.pictured import bent_angles
from flexmech.analyses.frequencies.quartic import predicted_minimum
from flexmech.analyses.frequencies.reduction import ModeErrors
from flexmech.analyses.frequencies.refinement import (
    Chain,
    Positions,
    ambiguous_modes,
    is_unambiguous,
    refined,
)
from flexmech.analyses.frequencies.tracking import find_veering
from flexmech.analyses.frequencies.words import shaft_kind
from flexmech.analyses.requests import sampled_turn
from flexmech.arrays import SAME_PLACE

TURN = np.radians(np.arange(0.0, 361.0, 5.0))

# --- extremes over the crank angle --------------------------------------------------------------


def found_extremes(monkeypatch, curve, error, angles=TURN):
    """Lowest value and its angle, and the number of solutions that took."""
    solved = []

    def along(systems, speeds, row, trial, usual):
        solved.extend(trial.ravel())
        return curve(trial)[..., None]

    monkeypatch.setattr(extremes, "frequencies_at_trials", along)
    known = curve(angles)[None, :, None]
    whole = bool(np.isclose(np.ptp(angles), 2 * np.pi))
    of_one = np.array([error]), np.zeros(1)
    found = extremes_between(None, angles, of_one[1], known, of_one[0], full_turn=whole)
    return float(found.lowest_frequency[0, 0]), float(found.lowest_angle[0, 0]), len(solved)


def veering(width):
    return lambda angle: 100 + 40 * np.sqrt(np.sin((angle - 1.234) / 2) ** 2 + width**2)


@pytest.mark.parametrize("width", [1.0, 0.1, 1e-2, 1e-3])
def test_extremes_are_known_to_the_first_digit_of_their_error(monkeypatch, width):
    least, counts = 100 + 40 * width, []
    for error in (1e-3, 1e-5, 1e-7, 0.0):
        value, _, count = found_extremes(monkeypatch, veering(width), error)
        assert 0 <= value / least - 1 <= max(0.2 * error, 3e-9)
        counts.append(count)
    # Both extremes of the turn; the highest is level.
    assert max(counts) <= 26
    assert counts[0] < 12


def test_flat_curves_with_round_off_are_not_searched(monkeypatch):
    def flat(angle):
        return 100 * (1 + 1e-9 * np.sin(1e5 * angle))

    assert found_extremes(monkeypatch, flat, 0.0)[2] == 0


def test_of_minima_that_round_off_tells_apart_the_first_is_taken(monkeypatch):
    def alike(angle):
        return 100 + np.cos(2 * angle) + 1e-10 * np.sin(angle)

    value, angle, _ = found_extremes(monkeypatch, alike, 0.0)
    assert np.degrees(angle) == pytest.approx(90.0, abs=0.1)
    assert value == pytest.approx(99.0 - 1e-10, abs=1e-12)


def test_extremes_are_sought_between_steps_of_fifteen_degrees(monkeypatch):
    for step, divided in ((15.0, True), (16.0, False)):
        angles = np.radians(np.arange(0.0, 300.0, step))
        _value, angle, count = found_extremes(monkeypatch, veering(1.0), 1e-5, angles)
        assert (abs(angle - 1.234) < 1e-2) is divided
        assert (count > 0) is divided


def test_a_minimum_is_tried_beside_the_middle_node():
    nodes = np.arange(5.0)[:, None]
    for least in (2.0, 2.001, 2.3):
        found = predicted_minimum(nodes, (nodes - least) ** 2)
        assert found.reach[0] < 12
        assert abs(found.at[0] - least) < 0.08
        assert min(found.value[0], (2 - least) ** 2) - found.remainder[0] <= 1e-12


def test_the_minimum_of_a_quartic_is_told_between_its_samples():
    nodes = np.arange(5.0)[:, None]

    def quartic(x):
        return (x - 2.37) ** 2 * (1 + 0.05 * (x - 2.37) + 0.02 * (x - 2.37) ** 2)

    found = predicted_minimum(nodes, quartic(nodes))
    assert found.at[0] == pytest.approx(2.37, abs=1e-4)


def test_bends_that_the_nodes_do_not_resolve_are_not_predicted():
    nodes = np.arange(5.0)[:, None]
    for width, trusted in ((0.3, False), (3.0, True)):
        found = predicted_minimum(nodes, np.sqrt((nodes - 2.2) ** 2 + width**2))
        assert bool(np.isfinite(found.at[0])) is trusted


# --- lines between crank angles -----------------------------------------------------------------


def lines(curve):
    """Angles added to a grid of 15 deg, and how far lines are off then, over the range."""
    grid = np.radians(np.arange(0.0, 361.0, 15.0))

    def solve(angles):
        return curve(angles)[None, :, None]

    added, _ = bent_angles(solve, grid, solve(grid), full_turn=True)
    every, fine = np.union1d(grid, added), np.linspace(0, 2 * np.pi, 5001)
    off = np.abs(np.interp(fine, every, curve(every)) - curve(fine)).max()
    return len(added), off / np.ptp(curve(fine))


def test_lines_bend_as_far_as_one_sees():
    count, off = lines(lambda angle: 100 + 10 * np.cos(angle))
    assert 1e-3 < off < 5e-3
    assert count < 60
    # A range is at least a part of the frequency: what is smaller is not drawn larger.
    assert lines(lambda angle: 100 + 5e-3 * np.cos(angle))[0] == 0
    assert lines(lambda angle: 100 + 0.5 * np.cos(angle))[0] > 0


def test_a_bend_is_divided_three_times():
    count, _ = lines(lambda angle: 100 + np.abs(np.sin(angle / 2 - 1.01)))
    assert 5 <= count <= 7


# --- modes and their branches -------------------------------------------------------------------


def unclear(scores, step, *, moved):
    """Whether two modes that keep so much of their shape are clear, in place or exchanged."""
    amplitude = np.sqrt(np.array([[scores, 1 - scores], [1 - scores, scores]]))
    origin = np.arange(2)
    if moved:
        amplitude, origin = amplitude[:, ::-1], origin[::-1]
    return not is_unambiguous(amplitude[None], origin[None], np.radians([step])).all()


def test_shapes_are_clear_by_four_fifths_of_their_energy():
    assert not unclear(0.85, 1.0, moved=False)
    assert unclear(0.75, 1.0, moved=False)


def test_what_is_exchanged_within_half_a_degree_crosses():
    """A step over two degrees bounds the width by the score that is left."""
    assert unclear(0.9, 2.0, moved=True)
    assert not unclear(0.97, 2.0, moved=True)
    assert not unclear(0.9, 2.0, moved=False)


def test_shapes_that_come_and_go_are_told():
    for alike, gone in ((0.15, True), (0.25, False)):
        amplitude = np.sqrt(np.array([[[1.0, 0.0], [0.0, alike]]]))
        assert ambiguous_modes(amplitude, np.radians([1.0]))[1][0].tolist() == [False, gone]


def test_steps_are_divided_at_whole_degrees_but_for_rounding():
    ends = np.radians(np.array([3.0, 4.0, 6.5]))
    for off in (-1e-14, 0.0, 1e-14):
        angle = ends * (1 + off)
        nothing = np.zeros((3, 1))
        chain = Chain(Positions(angle, nothing, nothing), np.ones(3, dtype=bool), np.empty(0))
        assert np.degrees(chain.middles()) == pytest.approx([3.5, 5.0])
    assert np.radians(1 / 16) / 1000 > SAME_PLACE


def test_steps_that_stay_unclear_are_divided_down_to_a_sixteenth_of_a_degree():
    """Shapes that jump half the way into each other; beside them are steps of a degree."""

    def between(angle):
        turned = np.where(np.degrees(angle) > 30.3, np.pi / 4, 0.0)
        shapes = [[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]]
        return Positions(angle, np.zeros((len(angle), 2)), np.moveaxis(shapes, 2, 0))

    angle = np.radians(np.array([20.0, 25.0, 35.0, 40.0]))
    chain = refined(Chain(between(angle), np.ones(4, dtype=bool), np.empty(0)), between)
    step = np.degrees(chain.step)
    assert step.min() == pytest.approx(1 / 16)
    start = np.degrees(chain.positions.crank_angle[:-1])
    beside = np.searchsorted(start, [29.4, 31.4]) - 1
    assert step[beside] == pytest.approx([1.0, 1.0])
    assert step.max() == pytest.approx(5.0)


def test_the_mean_of_a_frequency_is_that_of_a_whole_turn(monkeypatch):
    def along(systems, angle, speed):
        return (10 + 3 * np.cos(angle) + np.cos(9 * angle) + 0.1 * np.sin(20 * angle))[:, None]

    monkeypatch.setattr(damping_ratios, "frequencies_along", along)
    monkeypatch.setattr(damping_ratios, "Systems", lambda *of: None)
    lowest = damping_ratios.lowest_frequency(SimpleNamespace(prestress_at_rest="none"))
    assert lowest == pytest.approx(20 * np.pi, rel=1e-12)


def test_bounds_are_told_by_positions_every_fifteen_degrees():
    """The extremes of a third harmonic are missed by less than a tenth, as bounds may be."""
    turn = sampled_turn(0.1)
    assert turn[0] == 0.1
    # Half a step beside an extreme of the third harmonic.
    assert np.cos(3 * np.diff(turn).max() / 2) > 0.9
    assert np.ptp(turn) + np.diff(turn).max() == pytest.approx(2 * np.pi)
    assert len(turn) < 100


def test_the_last_digit_of_a_number_is_known_to_five_units():
    assert rounded(12.3456789012, 1e-12, most=8) == "12.345679"
    assert rounded(12.3456789012, 4e-6, most=8) == "12.345679"
    assert rounded(12.3456789012, 6e-6, most=8) == "12.34568"


def veers(least, turned):
    """Whether two branches veer with a least relative gap and shapes that turn by an angle."""
    angle = np.linspace(-1.0, 1.0, 21)
    half = 50 * np.sqrt(least**2 + (3 * angle) ** 2)
    frequency = np.stack([100 - half, 100 + half], axis=1)
    near = np.flatnonzero(2 * half <= 2 * least * 100)
    amplitude = np.zeros((20, 2, 2))
    amplitude[near[0] : near[-1]] = np.sin(turned / (near[-1] - near[0]))
    return bool(find_veering(frequency, amplitude, angle, np.ones(21, dtype=bool)).any())


def test_branches_veer_that_come_close_and_exchange_their_shapes():
    assert veers(0.2, 1.0)
    assert not veers(0.3, 1.0)
    assert veers(0.2, 0.5)
    assert not veers(0.2, 0.25)
    assert veers(0.2, 1.5)
    assert not veers(0.2, 2.0)


# --- the frozen eigenproblem --------------------------------------------------------------------


def sharpened(ratio, monkeypatch):
    """Relative error of the lowest square of a system with so great a ratio of its squares."""
    random = np.random.default_rng(3)
    basis = np.linalg.qr(random.standard_normal((6, 6)))[0]
    squares = np.geomspace(1.0, ratio, 6)
    root = basis * np.sqrt(squares)
    stiffness = (root @ root.T)[None]
    every = np.linalg.eigvalsh(stiffness)
    lowest = every[:, :2].copy()
    tried = []
    factor = np.linalg.cholesky
    monkeypatch.setattr(np.linalg, "cholesky", lambda a: (tried.append(1), factor(a))[1])
    system = SimpleNamespace(stiffness=stiffness, mass=np.eye(6)[None])
    eigenproblem._sharpen(system, every, lowest)
    return abs(lowest[0, 0] - 1.0), bool(tried)


def test_modes_are_sharpened_where_round_off_takes_the_tenth_digit(monkeypatch):
    assert not sharpened(1e4, monkeypatch)[1]
    error, tried = sharpened(2e7, monkeypatch)
    assert tried
    assert error < 1e-9


def test_shapes_that_may_creep_are_looked_at():
    """Of a mode with a damping ratio of 0.85 or 0.95 that is lower than one that oscillates."""
    for ratio, doubtful in ((0.85, False), (0.95, True)):
        damped = np.array(
            [-ratio + 1j * np.sqrt(1 - ratio**2), -ratio - 1j * np.sqrt(1 - ratio**2)]
        )
        inverse = np.concatenate([1 / damped, 1 / np.array([2j, -2j])])[None]
        assert quadratic_eigenproblem._oscillating_modes(inverse, 1)[1][0] == doubtful


def test_a_shape_creeps_if_its_eigenvalue_is_slower_than_it():
    for part, creeps in ((0.6, True), (0.8, False)):
        value = part * (-0.99 - 1j * np.sqrt(1 - 0.99**2))
        system = SimpleNamespace(stiffness=np.eye(1)[None], mass=np.eye(1)[None])
        found = quadratic_eigenproblem._sorted_out(
            system, 0, np.ones(1), np.array([1 / value.conjugate()]), np.ones((1, 1))
        )
        assert found[2].tolist() == [creeps]


def test_what_grows_far_faster_than_it_can_be_known_is_round_off():
    for slowness, diverges in ((1e-8, True), (1e-10, False)):
        inverse = np.array([[1j, -1j, slowness]])
        assert quadratic_eigenproblem._diverges(inverse)[0] == diverges


def test_newtons_method_ends_at_the_round_off_of_an_eigenvalue(monkeypatch):
    factors = []
    splu = inverse_iteration.splu
    monkeypatch.setattr(inverse_iteration, "splu", lambda a, **of: (factors.append(1), splu(a))[1])
    random = np.random.default_rng(4)
    errors = []
    for _ in range(40):
        damping = 0.3 * random.standard_normal((3, 3))
        stiffness = np.diag([1.0, 4.0, 9.0]) + 0.3 * random.standard_normal((3, 3))
        companion = np.block([[np.zeros((3, 3)), np.eye(3)], [-stiffness, -damping]])
        values, states = np.linalg.eig(companion)
        place = int(values.imag.argmax())
        parts = {"mass": np.eye(3), "damping": damping, "stiffness": stiffness}
        sparse = {name: scipy.sparse.csc_array(part) for name, part in parts.items()}
        pencil = inverse_iteration.Pencil.of(SimpleNamespace(**sparse))
        near = states[:3, place, None] + 0.02 * random.standard_normal((3, 1))
        start = values[None, place, None] * (1 + 0.01 * random.standard_normal())
        given = [pencil], start, near[None]
        found = inverse_iteration.newton_values(*given, steps=reduction.MOST_STEPS)
        errors.append(abs(found[0, 0] / values[place] - 1))
    assert max(errors) < 1e-13
    assert len(factors) <= 40 * 4


@pytest.mark.parametrize(("highest", "anew"), [(1.5e6, True), (1.5e5, False)])
def test_lowest_frequencies_are_computed_anew_where_tables_would_show_their_round_off(
    highest, anew
):
    """Ten digits of a squared frequency, beside another of so many times it."""
    system = SimpleNamespace(stiffness=np.diag([1.0, highest])[None], mass=np.eye(2)[None])
    squares = np.array([[5.0]])
    eigenproblem._sharpen(system, np.array([[1.0, highest]]), squares)
    assert squares[0, 0] == pytest.approx(1.0 if anew else 5.0)


# --- component modes and meshes -----------------------------------------------------------------


def test_a_reduction_will_do_with_errors_below_what_is_asked():
    def enough(frequency=0.0, ratio=0.0, own=0.01, *, damped=True):
        modes = SimpleNamespace(damping_ratio=np.full((1, 1), own))
        errors = ModeErrors(np.full((1, 1), frequency), np.full((1, 1), ratio))
        return errors.small(modes, damped=damped).all()

    assert enough(frequency=1e-5)
    assert not enough(frequency=4e-5)
    assert enough(ratio=5e-6)
    assert not enough(ratio=2e-5)
    assert enough(ratio=2e-5, damped=False)
    assert enough(ratio=5e-8, own=0.0)
    assert not enough(ratio=2e-7, own=0.0)


def test_two_modes_have_led_to_one_eigenvalue(monkeypatch):
    """Then the modes are those of the unreduced matrices, without a start."""
    own = np.array([1.0, 1.0 + 1e-9, 3.0])

    def found(apart):
        values = np.array([1.0, 1.0 + apart])
        engine = SimpleNamespace(frames=None)
        engine.unreduced = lambda: engine
        system = SimpleNamespace(unreduced_vectors=lambda vectors, frames: vectors)
        systems = SimpleNamespace(
            engine=engine,
            formulation=SimpleNamespace(modes=2),
            stressed=lambda *of: None,
            at=lambda *of: system,
        )
        modes = SimpleNamespace(vectors=np.zeros((1, 1, 2)), eigenvalues=np.zeros((1, 2)))
        exact = SimpleNamespace(pencils=lambda: iter([None]))
        monkeypatch.setattr(reduction, "replace", lambda systems, **of: systems)
        monkeypatch.setattr(reduction, "solve_modes", lambda *of: modes)
        monkeypatch.setattr(reduction, "UnreducedPositions", lambda *of: exact)
        monkeypatch.setattr(reduction, "newton_values", lambda *of, **more: values[None])
        monkeypatch.setattr(reduction, "solve_eigenvalues", lambda *of: own[None, :2] + 1)
        return reduction.unreduced_eigenvalues(systems, np.zeros(1), 0.0)[0]

    assert found(1e-9)[0] == 2.0
    assert found(1e-7)[0] == 1.0


def test_meshes_are_compared_with_finer_ones_that_a_check_can_pay():
    assert [discretisation._compared_mesh(n) for n in (4, 16, 17, 32)] == [16, 64, 34, 64]


def test_component_modes_have_no_part_in_the_error_of_the_mesh():
    def apart(mesh, by_reduction):
        errors = (ModeErrors(np.full(1, e), np.zeros(1)) for e in (mesh, by_reduction))
        return discretisation._outweighs(*errors)

    assert apart(1e-3, 1e-4)
    assert not apart(1e-3, 4e-4)
    assert apart(1e-9, 5e-7)
    assert not apart(1e-9, 2e-6)


def test_a_dozen_angles_of_a_turn_are_checked():
    for full_turn in (True, False):
        places = discretisation.check_angle_indices(TURN, full_turn)
        assert len(places) == 12
        assert np.diff(places).max() <= 7


def test_meshes_that_would_be_too_coarse_in_the_highest_order_are_passed_over(monkeypatch):
    tried = []

    def engine(elements):
        return SimpleNamespace(elements=elements, with_=lambda elements: engine(elements))

    def checked(engine, request, order=4):
        tried.append(engine.elements)
        error = ModeErrors(np.array([[(2 / engine.elements) ** order]]), np.zeros((1, 1)))
        return [SimpleNamespace(mesh_error=error)]

    monkeypatch.setattr(engine_map, "_map_on_mesh", lambda engine, *of: engine.elements)

    def mapped(order, tolerance):
        tried.clear()
        monkeypatch.setattr(engine_map, "_checked_speeds", lambda *of: checked(*of, order))
        return engine_map.map_engine(engine(2), SimpleNamespace(tolerance=tolerance), None)

    assert mapped(4, 3e-4) == 16
    assert tried == [2, 16]
    assert mapped(4, 1e-2) == 8
    assert tried == [2, 8]
    # In a lower order no mesh is passed over that might do, and none has more than 32 elements.
    assert mapped(2, 1e-2) == 32
    assert tried == [2, 8, 16, 32]
    assert mapped(1, 1e-6) == 32


def test_a_mode_of_a_quarter_of_an_hour_is_rigid():
    over = ("engine", "crank_speed", "crank_angle")
    hertz = xr.DataArray(np.array([[[3e-4, 3e-3]]]), dims=over)
    known = xr.Dataset({"shaft_frequency": hertz, "shaft_growth_rate": 0 * hertz})
    assert shaft_kind(known).values.ravel().tolist() == ["rigid", "oscillates"]
