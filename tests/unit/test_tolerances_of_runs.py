"""Tolerances of the equations of runs: each test fails if its constant is another one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from flexmech import ConstantSpeed, FourBar, Mechanism, ReferenceEngine, natural_frequencies
from flexmech.dynamical_systems import VibrationState
from flexmech.materials import Material
from flexmech.sections import BeamSection
from flexmech.time_domain import DrivenLinkage, static_balance
from flexmech.time_domain.equations_of_motion import (
    natural_coordinates,
    reduced_links,
    turning_sections,
)
from flexmech.time_domain.equations_of_motion.linkage_stretch import LinkageStretch
from flexmech.time_domain.equations_of_motion.stress_history import _low_rank_factors
from flexmech.time_domain.integrators import stretch_march
from flexmech.time_domain.integrators.stage_operators import stage_operators
from flexmech.time_domain.periodic_motion import orbit_newton
from tests.cross_engine.test_exudyn_joints import strips

LINKAGE = FourBar(ground=0.4, crank=0.12, coupler=0.3, rocker=0.28)


def eccentric(
    modulus: float, height: float, axis: float, elements: int, gravity: float = -20.0
) -> ReferenceEngine:
    """A four-bar whose links have their neutral axis and centre of mass off the pins."""
    strip = BeamSection.rectangle(Material(modulus, 2700.0), height, 25e-3)
    section = replace(strip, mass_axis=axis, neutral_axis=axis, layers=None)
    sections = dict.fromkeys(("crank", "coupler", "rocker"), section)
    mechanism = Mechanism(LINKAGE, sections, gravity=(0.0, gravity))
    return ReferenceEngine(mechanism, elements, "euler", component_modes=False)


def at_rest(engine: ReferenceEngine, speed: float = 8.0) -> np.ndarray:
    """Displacements of all links of a run in balance."""
    linkage = DrivenLinkage(engine, ConstantSpeed(speed), stretches=True)
    z = static_balance(linkage, np.zeros(linkage.size))
    nothing = np.zeros((1, linkage.size))
    state = linkage.link_state(
        linkage.equations(np.zeros(1)), VibrationState(z[None], nothing, nothing)
    )
    return np.concatenate(state.displacement)


def test_bars_of_all_sections_hardly_lift_the_neutral_axis() -> None:
    engine = eccentric(69e9, 36e-3, 6e-3, 8, gravity=0.0)
    linkage = DrivenLinkage(engine, ConstantSpeed(1e-3), stretches=True)
    equations = linkage.equations(np.zeros(1), frozen=True)
    squares = scipy.linalg.eigvalsh(equations.stiffness[0], equations.mass[0])[:4]
    expected = natural_frequencies(engine, np.zeros(1), modes=4)[0]
    low = 1 - np.sqrt(squares) / (2 * np.pi * np.asarray(expected))
    assert np.all(low < 3e-6)
    # A stiffer bar costs a deep bow its energy balance.
    assert np.all(low > 3e-7)


def test_sections_of_an_eccentric_link_turn_by_five_polynomials(monkeypatch) -> None:
    engine = eccentric(2e9, 4e-3, 1e-3, 16)
    found = at_rest(engine)
    monkeypatch.setattr(turning_sections, "SMOOTH_SHAPES", 100)
    every = at_rest(engine)
    assert 1e-9 < np.abs(found - every).max() / np.abs(every).max() < 1e-7


def test_bars_of_rigid_links_are_stiff(monkeypatch) -> None:
    """They yield by some 1e-6 of the displacements, and leave Newton's method its digits."""
    engine = ReferenceEngine(strips("rigid coupler"), 4, "euler", component_modes=False)
    found = at_rest(engine)
    monkeypatch.setattr(natural_coordinates, "RIGIDITY", 1e3)
    stiffer = at_rest(engine)
    assert 2e-7 < np.abs(found - stiffer).max() / np.abs(stiffer).max() < 2e-6


def test_round_off_beside_stiff_bars_ends_the_search_of_a_balance(monkeypatch) -> None:
    """With bars ten times as stiff no pass gained the tenth digit."""
    monkeypatch.setattr(natural_coordinates, "RIGIDITY", 1e3)
    engine = ReferenceEngine(strips("rigid coupler"), 8, "euler", component_modes=False)
    found = at_rest(engine)
    assert np.abs(found).max() > 1e-6


@pytest.mark.parametrize(("part", "least", "most"), [(0.9, 1e-12, 1e-10), (0.65, 1e-8, 3e-7)])
def test_balances_are_found_to_ten_digits_or_to_the_end_of_progress(
    part: float, least: float, most: float, monkeypatch
) -> None:
    """With a tangent that is too small by a tenth, and so far that a pass halves no change."""
    engine = ReferenceEngine(strips("slider-crank", 1e-3), 8, "euler", component_modes=False)
    exact, own = at_rest(engine, 4.0), LinkageStretch.static_force

    def softer(self, turns, position):
        force, tangent = own(self, turns, position)
        return force, part * tangent

    monkeypatch.setattr(LinkageStretch, "static_force", softer)
    assert least < np.abs(at_rest(engine, 4.0) - exact).max() / np.abs(exact).max() < most


def test_both_coordinates_of_a_rotation_have_mass() -> None:
    """The rotation of a rigid coupler to which a link is welded, and the difference of its ends."""
    engine = ReferenceEngine(strips("rigid ternary coupler"), 4, "euler", component_modes=False)
    linkage = DrivenLinkage(engine, ConstantSpeed(10.0), stretches=True)
    coupler = linkage.unreduced[engine.topology.index("coupler")]
    values = scipy.linalg.eigvalsh(np.asarray(coupler.mass))
    assert values[0] > 1e-3 * values[-1]


def test_distributions_of_stress_leave_out_round_off() -> None:
    random = np.random.default_rng(0)
    shapes = random.normal(size=(3, 200))
    values = random.normal(size=(120, 2)) @ shapes[:2]
    values += 1e-13 * random.normal(size=(120, 1)) * shapes[2]
    share, found = _low_rank_factors(values, np.ones(200))
    assert share.shape[1] == 3
    assert np.abs(share @ found - values).max() < 1e-13 * np.abs(values).max()


def frequencies(name: str, *, component_modes: bool) -> tuple[np.ndarray, DrivenLinkage]:
    """Natural frequencies in rad/s of a run's equations about its equilibrium, at one instant."""
    engine = ReferenceEngine(strips(name, 1e-3), 24, "euler", component_modes=component_modes)
    linkage = DrivenLinkage(
        engine, ConstantSpeed(4.0), "equilibrium", modes=4, detail=reduced_links.DETAIL
    )
    equations = linkage.equations(np.array([0.1]))
    squares = scipy.linalg.eigvals(equations.stiffness[0], equations.mass[0]).real
    return np.sort(np.sqrt(np.abs(squares))), linkage


def test_component_modes_reach_ten_times_the_frequencies_asked_for() -> None:
    found, linkage = frequencies("ternary coupler", component_modes=True)
    full, _ = frequencies("ternary coupler", component_modes=False)
    assert full[11] > 9 * full[3]
    np.testing.assert_allclose(found[11], full[11], rtol=1e-4)
    # A fifth of all coordinates does.
    assert linkage.size < len(full) / 5


def test_bows_have_axial_modes_enough() -> None:
    """With four of them this crank and its rod were 6e-3 off."""
    found, linkage = frequencies("slider-crank", component_modes=True)
    full, _ = frequencies("slider-crank", component_modes=False)
    np.testing.assert_allclose(found[:6], full[:6], rtol=2e-4)
    assert linkage.frames.size < 80


def test_stretching_links_have_axial_modes_enough() -> None:
    """What they leave is not seen beside what bending modes do."""
    reduced, full = (
        at_rest(ReferenceEngine(strips("slider-crank", 1e-3), 12, "euler", component_modes=c), 4.0)
        for c in (True, False)
    )
    assert np.abs(reduced - full).max() < 4e-5 * np.abs(full).max()


class PoorTangents(stretch_march.StretchForces):
    """Of which Newton's method gains half a digit a pass."""

    def tangents(self):
        elastic, damped = super().tangents()
        return 0.95 * elastic, damped


def test_newtons_method_in_time_ends_at_nine_digits(aluminium) -> None:
    linkage = DrivenLinkage(
        ReferenceEngine(aluminium, elements=2), ConstantSpeed(20.0), stretches=True
    )
    step = 0.012
    rows = stage_operators(linkage.equations(np.array([0.01, 0.016])), linkage.stretch, step)
    start = np.zeros((3, linkage.size))
    kinds = stretch_march.StretchForces, PoorTangents
    exact, found = (
        stretch_march._newton(rows, kind(linkage.stretch, 2, step), linkage.stretch, start, step)
        for kind in kinds
    )
    gap = np.abs(found[0] - exact[0]).max() / np.abs(exact[0]).max()
    assert 1e-11 < gap < 1.5e-10


def test_detunings_below_a_hundredth_are_found_with_all_coordinates(monkeypatch) -> None:
    """Three steps of inverse iteration from a random motion tell what is nearly singular."""

    def detuning(least: float, next_one: float) -> float:
        modal = object.__new__(orbit_newton._ModalPreconditioner)
        values = np.array([[least, next_one, 1.0, 1.0, 1.0, 1.0]])
        modal.modes, modal.moving = np.zeros((1, 6, 6)), 6
        monkeypatch.setattr(modal, "_precondition", lambda f: f / values.ravel(), raising=False)
        monkeypatch.setattr(modal, "_solve", lambda matrices, y: (y / values, 1), raising=False)
        return modal.detuning(None)

    assert detuning(0.02, 1.0) == 1.0
    assert detuning(0.005, 1.0) == pytest.approx(0.005, rel=1e-6)
    # A motion that is two and a half times as far from singular hardly counts.
    assert detuning(0.008, 0.02) == pytest.approx(0.008, rel=2e-2)
