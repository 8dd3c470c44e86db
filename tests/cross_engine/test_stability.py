"""Stability of the running aluminium linkage: both engines, their bands, and what closes these."""

from dataclasses import replace

import numpy as np
import pytest

from flexmech import stability
from flexmech.analyses.damping_ratios import lowest_frequency, with_damping_time
from flexmech.analyses.stability.engine_map import map_engine
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.analyses.stability.selected_modes import matched
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from flexmech.threads import one_thread


def quiet(label, done, total):
    pass


def damped(engine, ratio):
    return with_damping_time(engine, 2 * ratio / lowest_frequency(engine))


@pytest.mark.parametrize("prestress", ["axial", "equilibrium"])
@pytest.mark.parametrize("speed", [20.0, 60.0])
def test_engines_have_the_same_moduli(aluminium, prestress, speed):
    engines = [ReferenceEngine(aluminium), ExudynEngine(aluminium)]
    with one_thread():
        first, other = (
            (solver := LinkageSolver(damped(engine, 0.001), prestress, 8)).solve(
                solver.moving(speed)
            )
            for engine in engines
        )
    order = matched(first.exponent * first.period, other.exponent * other.period)
    assert np.exp(other.log_modulus[order]) == pytest.approx(np.exp(first.log_modulus), abs=1e-3)


@pytest.fixture(scope="module")
def maps(aluminium):
    request = StabilityRequest(
        np.array([74.0, 76.0, 78.0]), prestress="axial", modes=5, damping_ratio=0.001
    )
    engines = [ReferenceEngine(aluminium), ExudynEngine(aluminium)]
    return [map_engine(engine, request, quiet) for engine in engines]


def test_a_band_that_is_narrower_than_the_step_is_found_named_and_closed(maps):
    band = maps[0].bands[0]
    assert (band.kind, band.branches, band.order) == ("principal", (2, 2), 8)
    assert not band.lower.is_open
    assert not band.upper.is_open
    # Twice the second frequency, some 48.8 Hz, is eight times that of the crank.
    assert 76.0 < band.lower.crank_speed < 76.6 < band.upper.crank_speed < 77.5
    assert 0.004 < band.closing_damping_ratio < 0.01


def test_what_meets_in_a_band_has_opposite_krein_signatures(maps):
    """The Hamilton function is definite: a signature is the sign of the frequency."""
    for found in maps:
        assert found.is_definite
        for each in found.speeds:
            clear = np.abs(each.krein_signature) > 0.1
            assert clear.sum() >= 8
            sense = np.sign(each.exponent.imag)
            assert np.array_equal(np.sign(each.krein_signature)[clear], sense[clear])
        for band in found.bands:
            assert band.signatures[0] > 0.01
            assert band.signatures[1] < -0.01


def test_the_edges_of_both_engines_agree_within_their_errors(maps):
    first, other = (found.bands[0] for found in maps)
    for ours, theirs in ((first.lower, other.lower), (first.upper, other.upper)):
        apart = abs(ours.crank_speed - theirs.crank_speed)
        assert apart < 0.1
        assert apart < 3 * (ours.error + theirs.error)


def test_growth_ends_at_the_closing_damping_ratio(maps, aluminium):
    band = maps[0].bands[0]
    engine = ReferenceEngine(aluminium)
    solver = LinkageSolver(damped(engine, 1.0), "axial", 5)
    speeds = np.linspace(band.lower.crank_speed, band.upper.crank_speed, 9)
    with one_thread():
        linkages = [solver.moving(float(speed)) for speed in speeds]
        below, above = (
            max(solver.growth_at(each, part * band.closing_damping_ratio) for each in linkages)
            for part in (0.97, 1.01)
        )
    assert below > 0 > above


@pytest.mark.thorough
def test_the_edge_error_is_true(maps, aluminium):
    # Of the mesh, which is the greatest: twice the elements put the edge nearly where they are.
    request = StabilityRequest(
        np.array([75.5, 76.0, 77.6]), prestress="axial", modes=5, damping_ratio=0.001
    )
    finer = map_engine(ReferenceEngine(aluminium, elements=16), request, quiet).bands[0]
    for ours, theirs in zip(
        (maps[0].bands[0].lower, maps[0].bands[0].upper), (finer.lower, finer.upper), strict=True
    ):
        assert abs(ours.crank_speed - theirs.crank_speed) < 1.5 * ours.error
        assert theirs.mesh_error < 0.5 * ours.mesh_error


@pytest.mark.parametrize("ratio", [0.3, pytest.param(0.1, marks=pytest.mark.thorough)])
def test_a_speed_without_equilibrium_is_told_and_the_map_goes_on(aluminium, ratio):
    # Much damping closes all bands, whose edges are not the subject; less leaves one.
    request = StabilityRequest(np.array([60.0, 150.0]), modes=1, damping_ratio=ratio)
    found = map_engine(ReferenceEngine(aluminium, elements=2), request, quiet)
    assert [each.crank_speed for each in found.speeds] == [60.0, 150.0]
    assert "crank angle" in found.speeds[1].reason


@pytest.mark.thorough
def test_bands_and_their_names_do_not_depend_on_the_step(steel):
    """Modes that damping holds together beside a band are mixtures, at more of finer steps."""
    found = []
    for step in (0.5, 2.0):
        speeds = np.arange(160.0, 180.1, step)
        request = StabilityRequest(speeds, modes=4, damping_ratio=0.001)
        found.append(map_engine(ReferenceEngine(steel, elements=4), request, quiet).bands)
    names = [(band.kind, band.branches, band.order) for band in found[0]]
    assert names == [(band.kind, band.branches, band.order) for band in found[1]]
    assert len(names) == 6
    for fine, coarse in zip(*found, strict=True):
        assert fine.lower.crank_speed == pytest.approx(coarse.lower.crank_speed, abs=1e-5)
        assert fine.upper.crank_speed == pytest.approx(coarse.upper.crank_speed, abs=1e-5)


def _name(band):
    return band.kind, band.branches, band.order


@pytest.mark.thorough
def test_a_band_has_one_name_in_whatever_range_and_step_it_is_found(aluminium):
    """Modes 1 and 2 meet there at five times the crank's frequency; or the name is uncertain.

    All ranges hold 112 rad/s or so, where it grows fastest.
    """
    ranges = [
        np.array([112.0, 116.0]),
        np.arange(100.0, 116.1, 2.0),
        np.arange(108.0, 120.1, 4.0),
        np.arange(105.0, 114.1, 1.5),
        # Twice mode 2 joins in from 117 on: of the whole there is no name.
        np.arange(110.0, 121.1, 1.5),
    ]
    engine, named = ReferenceEngine(aluminium, elements=4), set()
    for speeds in ranges:
        request = StabilityRequest(speeds, modes=4, damping_ratio=0.001)
        bands = map_engine(engine, request, quiet).bands
        (band,) = (
            each for each in bands if each.lower.crank_speed < 113.0 < each.upper.crank_speed
        )
        named |= {_name(band)} - {("unnamed", (), 0)}
        assert bool(np.isnan(band.lower.error)) is band.lower.is_open
        assert bool(np.isnan(band.upper.error)) is band.upper.is_open
    assert named == {("sum", (1, 2), 5)}


@pytest.mark.thorough
def test_over_damping_each_row_is_about_its_own_periodic_motion(aluminium):
    engine, asked = ReferenceEngine(aluminium, elements=2), {"modes": 2, "damping_ratio": 0.03}
    over = stability(
        engine, [25.0], prestress="trajectory", against=("damping-ratio", [0.01, 0.02]), **asked
    )
    rows = over.dataset["against_growth_rate"].values[0, :, 0]
    for row, ratio in zip(rows, (0.01, 0.02), strict=True):
        asked["damping_ratio"] = ratio
        running, still = (
            float(stability(engine, [25.0], prestress=level, **asked).dataset["growth_rate"][0, 0])
            for level in ("trajectory", "equilibrium")
        )
        assert row == pytest.approx(running, rel=1e-9)
        assert abs(row - still) > 1e-4 * abs(still)


def test_multipliers_obey_liouville_in_every_row(maps):
    for found in maps:
        assert max(each.liouville_defect for each in found.speeds) < 1e-6


def test_multipliers_are_the_same_in_both_frames(aluminium):
    solver = LinkageSolver(damped(ReferenceEngine(aluminium), 0.001), "equilibrium", 8)
    with one_thread():
        link, ground = (
            (own := replace(solver, frame=frame)).solve(own.moving(60.0))
            for frame in ("link", "inertial")
        )
    logs = [modes.log_modulus + 1j * modes.angle for modes in (link, ground)]
    apart = np.exp(logs[0]) - np.exp(logs[1][matched(*logs)])
    assert np.abs(apart).max() < 1e-8


def test_the_periodic_motion_has_nearly_the_multipliers_of_the_equilibrium(aluminium):
    # At 20 rad/s the motion is some tenth of its greatest displacement away from it.
    engine = damped(ReferenceEngine(aluminium, elements=4), 0.005)
    solvers = [LinkageSolver(engine, level, 4) for level in ("equilibrium", "trajectory")]
    with one_thread():
        linkages = [solver.moving(20.0) for solver in solvers]
        modes = [s.solve(linkage) for s, linkage in zip(solvers, linkages, strict=True)]
    assert linkages[0].orbit_distance is None
    assert 0.01 < linkages[1].orbit_distance < 0.5
    assert linkages[1].orbit_residual < 1e-6
    order = matched(*(each.exponent * each.period for each in modes))
    rates = modes[1].exponent.real[order] - modes[0].exponent.real
    assert 0 < np.abs(rates).max() < 0.2 * np.abs(modes[0].exponent.real).max()
