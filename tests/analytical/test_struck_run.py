"""A struck run of the linkage: what the impact adds is what the harmonic response predicts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import ConstantSpeed, LinkPoint, ReferenceEngine, load_mechanism
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.arrays import ComplexArray, FloatArray
from flexmech.dynamical_systems import HalfSinePulse, VibrationState, harmonic_response
from flexmech.linear_system import Prestress, displacement_row
from flexmech.time_domain import DrivenLinkage, LinkageUnderImpact, forced_linkage
from flexmech.time_domain.integrators.linear_march import LinearMarch

SPEED, TURNS = 20.0, 4
TURN = 2 * np.pi / SPEED
HIT, SEEN = LinkPoint("coupler", 0.5), LinkPoint("rocker", 0.5)
PULSE = HalfSinePulse(0.01, 0.02, 0.3 * TURN)
# Orders beyond these answer less than 1e-3 of the greatest.
ORDERS = np.arange(-14, 15)


def engine() -> ReferenceEngine:
    mechanism = load_mechanism("models/aluminium_fourbar.toml")
    sections = {k: s.with_damping_time(4e-4) for k, s in mechanism.sections.items()}
    return ReferenceEngine(replace(mechanism, sections=sections), 4)


def run(linkage: DrivenLinkage, steps: int, *pulses: HalfSinePulse) -> FloatArray:
    nothing = np.zeros(linkage.size)
    still = VibrationState(nothing, nothing, nothing)
    struck = LinkageUnderImpact(linkage, TURN / steps, HIT, SEEN, "transverse")
    return struck.run(still, TURNS * steps, pulses)


def spectrum(linkage: DrivenLinkage, steps: int) -> ComplexArray:
    """Fourier integral of what the impact adds."""
    added = run(linkage, steps, PULSE) - run(linkage, steps)
    return np.fft.rfft(added[:-1]) * TURN / steps


@pytest.mark.parametrize("prestress", ["none", "equilibrium"])
def test_an_impact_is_answered_at_all_orders_as_predicted(prestress: Prestress) -> None:
    """The error of the step, which is of second order, is taken off."""
    struck = engine()
    output = np.arange(1, 60) / (TURNS * TURN)
    moving = LinkageSolver(struck, prestress, 5).moving_modes(SPEED)
    stressed = struck.stressed_links(moving.turn.motion, prestress)
    forced = forced_linkage(moving, stressed, HIT, SEEN)
    entering = output - ORDERS[:, None] / TURN
    response = harmonic_response(forced, entering.ravel(), ORDERS, 640)
    own = np.arange(len(ORDERS))
    response = response.reshape(len(ORDERS), len(ORDERS), -1)[own, own]
    predicted = (response * PULSE.spectrum(entering)).sum(axis=0)
    linkage = DrivenLinkage(struck, ConstantSpeed(SPEED), prestress, modes=6, with_energy=False)
    coarse, fine = (spectrum(linkage, steps)[1 : len(output) + 1] for steps in (800, 1600))
    largest = np.abs(predicted).max()
    assert 0.01 < np.abs(coarse - fine).max() / largest < 0.06
    np.testing.assert_allclose((4 * fine - coarse) / 3, predicted, atol=5e-3 * largest)


def test_linear_links_answer_in_proportion_to_the_force() -> None:
    struck = engine()
    linkage = DrivenLinkage(struck, ConstantSpeed(SPEED), "axial", modes=3, with_energy=False)
    twin, once, twice = (run(linkage, 500, *pulses) for pulses in ((), (PULSE,), (PULSE, PULSE)))
    np.testing.assert_allclose(twice - twin, 2 * (once - twin), atol=1e-9 * np.abs(once).max())
    assert np.abs(once - twin).max() > 1e-7


def test_two_points_of_a_linkage_that_hardly_turns_answer_each_other_alike() -> None:
    """Maxwell and Betti: what a pulse at one point moves at another it moves there from this."""
    model = load_mechanism("models/aluminium_fourbar.toml")
    linkage = DrivenLinkage(
        ReferenceEngine(model, 2), ConstantSpeed(1e-3), "none", modes=3, with_energy=False
    )
    points, nothing = (LinkPoint("coupler", 0.5), LinkPoint("rocker", 0.3)), np.zeros(linkage.size)
    still, pulse = VibrationState(nothing, nothing, nothing), HalfSinePulse(0.01, 0.005, 0.001)
    first, second = (
        LinkageUnderImpact(linkage, 1e-4, *ends, "transverse").run(still, 200, (pulse,))
        for ends in (points, points[::-1])
    )
    assert np.abs(first).max() > 1e-7
    np.testing.assert_allclose(second, first, rtol=0, atol=1e-3 * np.abs(first).max())


def test_steps_meet_where_one_block_ends_and_the_next_begins() -> None:
    """What follows a pulse statically does so from the first instant of a block on."""
    linkage = DrivenLinkage(engine(), ConstantSpeed(SPEED), with_energy=False)
    load = [np.zeros(link.size) for link in linkage.links]
    load[1] = displacement_row(linkage.links[1], 0.4, "axial")
    time, nothing = 1e-4 * np.arange(7.0), np.zeros(linkage.size)
    force, march = 1e5 * time, LinearMarch(linkage, 1e-4, load)
    first, own = march.advance(time[:4], VibrationState(nothing, nothing, nothing), force[:4])
    following = march.advance(time[3:], first[-1], force[3:])[1].offset
    assert np.abs(own.offset[3] - own.offset[0]).max() > 0.01 * np.abs(own.offset).max()
    np.testing.assert_allclose(following[0], own.offset[3], rtol=1e-12)
