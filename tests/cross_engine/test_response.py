"""Exudyn's nonlinear run against the linear reference, started and driven alike."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine, moving_frequencies
from flexmech.analyses.response.measurements import bending_strains, deflections
from flexmech.dynamical_systems import VibrationState
from flexmech.linkages import ConstantSpeed
from flexmech.time_domain import (
    DrivenLinkage,
    LinkState,
    linear_run,
    periodic_state,
    simulated_orbit,
)


def damped(mechanism, time):
    sections = {k: s.with_damping_time(time) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def one_turn(drive, samples=360):
    return drive.revolution_time / samples * np.arange(samples + 1)


@pytest.fixture(scope="module")
def simulated(aluminium):
    """Exudyn's run over a turn from a rigid start; each is made once."""

    @cache
    def turn(speed, steps, elements):
        drive = ConstantSpeed(speed)
        engine = ExudynEngine(aluminium, elements=elements)
        step = drive.revolution_time / steps
        return engine, engine.simulate(drive, LinkState.rigid(engine.links), one_turn(drive), step)

    return turn


@pytest.fixture
def both(aluminium, simulated):
    """Deflections (N, links) of Exudyn and of the linear reference."""

    def pair(speed, steps, elements=8, level="equilibrium"):
        drive = ConstantSpeed(speed)
        time, step = one_turn(drive), drive.revolution_time / steps
        reference = ReferenceEngine(aluminium, elements=elements)
        linkage = DrivenLinkage(reference, drive, level)
        run = linear_run(linkage, linkage.unstressed(), np.zeros(linkage.size), time, step)
        first = deflections(*simulated(speed, steps, elements))
        return first, deflections(reference, run)

    return pair


def gap(pair, link=1):
    first, second = (curves[:, link] for curves in pair)
    return np.abs(first - second).max() / np.abs(first).max()


def test_slow_crank_is_linear(both):
    """At 2 rad/s deflections are a hundredth of those at 20: linear theory holds.

    Most of the gap is that of the time steps: 5e-4 and 6e-4, with half the step 1e-4 and 2e-4.
    """
    pair = both(2.0, 5760, elements=4)
    assert [gap(pair, link) for link in (1, 2)] == [pytest.approx(0, abs=1e-3)] * 2


@pytest.mark.thorough
def test_the_gap_grows_with_the_deflection(both):
    """Linear about straight links: the gap of a turn goes with the speed.

    Inertia forces, and with them the deflection and the shift of the frequencies, grow with
    its square; the time of a turn in which the shifted vibration runs out of phase falls with
    the speed. Measured 0.046, 0.102 and 0.200.
    """
    gaps = [gap(both(speed, 2880, elements=4, level="none")) for speed in (5.0, 10.0, 20.0)]
    assert gaps[1] / gaps[0] == pytest.approx(2.0, rel=0.2)
    assert gaps[2] / gaps[1] == pytest.approx(2.0, rel=0.2)
    # With axial forces 0.055, about the equilibrium 0.009.
    axial = gap(both(20.0, 2880, elements=4, level="axial"))
    assert axial < 0.4 * gaps[2]


@pytest.mark.thorough
def test_linearization_about_the_equilibrium_closes_most_of_it(both):
    """And what is left is no matter of step or mesh: geometric nonlinearity."""
    usual = gap(both(20.0, 2880))
    assert usual < 0.015
    assert gap(both(20.0, 1440)) == pytest.approx(usual, rel=0.2)
    assert gap(both(20.0, 2880, elements=4)) == pytest.approx(usual, rel=0.2)


@pytest.mark.parametrize("name", ["aluminium", pytest.param("steel", marks=pytest.mark.thorough)])
def test_periodic_orbit_is_nearly_that_of_the_simulation(mechanisms, name):
    """Started on the linear periodic orbit, the simulation comes back to it."""
    mechanism = mechanisms[name]
    drive = ConstantSpeed(10.0)
    time, step = one_turn(drive), drive.revolution_time / 2880
    engine = ExudynEngine(mechanism)
    linkage = DrivenLinkage(engine, drive, "equilibrium", with_energy=False)
    start = periodic_state(linkage, 2880)
    state = linkage.link_state(
        linkage.equations(np.zeros(1)),
        VibrationState(start.position[None], start.velocity[None], start.acceleration[None]),
    )
    curves = deflections(engine, engine.simulate(drive, state, time, step))
    assert np.abs(curves[-1] - curves[0]).max() < 1e-3 * np.abs(curves).max()


@pytest.mark.thorough
def test_direct_periodic_solution_is_where_a_damped_simulation_settles(aluminium):
    mechanism = damped(aluminium, 3e-4)
    drive = ConstantSpeed(20.0)
    steps, turns = 1440, 4
    time = (turns - 1) * drive.revolution_time + one_turn(drive)
    engine = ExudynEngine(mechanism)
    rigid = LinkState.rigid(engine.links)
    settled = deflections(
        engine, engine.simulate(drive, rigid, time, drive.revolution_time / steps)
    )
    assert np.abs(settled[-1] - settled[0]).max() < 1e-3 * np.abs(settled).max()
    reference = ReferenceEngine(mechanism)
    linkage = DrivenLinkage(reference, drive, "equilibrium")
    start = periodic_state(linkage, steps)
    run = linear_run(
        linkage, start.position, start.velocity, one_turn(drive), drive.revolution_time / steps
    )
    direct = deflections(reference, run)
    difference = np.abs(direct - settled).max(axis=0) / np.abs(settled).max(axis=0)
    assert np.all(difference < 1e-3), difference


def test_simulated_orbit_closes(aluminium):
    mechanism = damped(aluminium, 1e-4)
    drive = ConstantSpeed(20.0)
    time, step = one_turn(drive), drive.revolution_time / 1440
    engine = ExudynEngine(mechanism)
    linkage = DrivenLinkage(engine, drive, "equilibrium", with_energy=False)
    orbit = simulated_orbit(linkage, 1440, lambda start: engine.simulate(drive, start, time, step))
    assert orbit.closure < 2e-4
    curves = deflections(engine, orbit.turn)
    assert np.abs(curves[-1] - curves[0]).max() < 5e-4 * np.abs(curves).max()


def test_strain_gauges_of_both_engines_read_alike(aluminium, simulated):
    drive = ConstantSpeed(5.0)
    time, step = one_turn(drive), drive.revolution_time / 2880
    exudyn, run = simulated(5.0, 2880, 8)
    reference = ReferenceEngine(aluminium)
    linkage = DrivenLinkage(reference, drive, "equilibrium")
    linear = linear_run(linkage, linkage.unstressed(), np.zeros(linkage.size), time, step)
    first, second = bending_strains(exudyn, run), bending_strains(reference, linear)
    for link in (1, 2):
        peak = np.abs(first[:, link]).max()
        assert np.abs(first[:, link] - second[:, link]).max() < 2e-2 * peak
        # A pinned link bent to +y is stretched there.
        assert np.corrcoef(first[:, link], deflections(exudyn, run)[:, link])[0, 1] > 0.98


@pytest.mark.thorough
def test_vibration_moves_the_frequencies_of_the_running_linkage(aluminium):
    """V2, last row: 45.158 and 47.683 Hz become 45.197 and 47.663 in the settled simulation.

    The row does not say how it was damped; the shift of the first mode grows as the
    damping falls, from 0.03 Hz at 3e-4 s to 0.08 Hz at 5e-5 s.
    """
    mechanism = damped(aluminium, 2e-4)
    result = moving_frequencies(
        ExudynEngine(mechanism, elements=8),
        [0.0],
        [20.0],
        modes=2,
        prestress="trajectory",
        rotation_terms=False,
    )
    still = result.dataset["quasi_static_frequency"].values.ravel()
    shift = result.dataset["frequency"].values.ravel() - still
    assert shift[0] == pytest.approx(45.197 - 45.158, abs=8e-3)
    assert still + shift == pytest.approx([45.197, 47.663], rel=4e-4)


def test_damping_of_bowed_links(aluminium):
    """Kelvin-Voigt damps strain: a bowed link that bends further is not stretched.

    With the damping matrix of straight links the ratio of the first mode at 20 rad/s is half
    as large again as the tau omega / 2 of a bending mode.
    """
    mechanism = damped(aluminium, 2e-4)
    result = moving_frequencies(
        [ReferenceEngine(mechanism, elements=16), ExudynEngine(mechanism, elements=16)],
        np.radians([0.0, 60.0, 180.0]),
        [20.0],
        modes=2,
        rotation_terms=False,
    )
    ratio = result.dataset["damping_ratio"].values
    expected = 2e-4 * np.pi * result.dataset["frequency"].values
    assert ratio == pytest.approx(expected, rel=3e-2)
    assert ratio[0] == pytest.approx(ratio[1], rel=1e-3)
