"""Thick and unsymmetric sections, as laminates have them: both engines, all that they do.

Exudyn's geometrically exact beams are linear. Bending converges in fourth order, but what pins
that move, stress and eccentric mass add is of third and second; where less is wanted than these
leave, frequencies and deflections are extrapolated from meshes one twice as fine as the other.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from flexmech import (
    ConstantSpeed,
    ExudynEngine,
    InputError,
    Mechanism,
    ReferenceEngine,
    load_mechanism,
    natural_frequencies,
)
from flexmech.analyses import deflections
from flexmech.mechanics.running import DrivenLinkage, LinkState
from flexmech.sections import stiffened_section
from flexmech.solvers import linear_run, solve_modes
from tests.support.command import MODELS
from tests.support.strategies import fourbar as slender_fourbar
from tests.support.thick_links import LINKS, UNSYMMETRIC, damped, fourbar, laden, uncoupled

ANGLES = np.radians([40.0, 200.0])


def reference(mechanism: Mechanism, elements: int) -> ReferenceEngine:
    return ReferenceEngine(mechanism, elements, "timoshenko", component_modes=False)


def exudyn(mechanism: Mechanism, elements: int) -> ExudynEngine:
    return ExudynEngine(mechanism, elements, "geometrically-exact", component_modes=False)


def extrapolated(values: Any) -> np.ndarray:
    """Limit of values from meshes of which each is twice as fine as the one before.

    The error has even powers of the element length, as Romberg's trapezoidal sums have.
    """
    factor = 4
    while len(values) > 1:
        values = [(factor * b - a) / (factor - 1) for a, b in pairwise(values)]
        factor *= 4
    return np.asarray(values[0])


def frequencies(engine: Any, speed: float, angles: Any = ANGLES, **options: Any) -> np.ndarray:
    return natural_frequencies(engine, angles, speed, modes=4, **options)


def gap(mechanism: Mechanism, speed: float, **options: Any) -> float:
    """Greatest relative difference of four frequencies, both engines on the same meshes.

    Extrapolated in third order. Rotation terms make an error of first order in the mesh, the
    same in both engines.
    """
    coarse, fine = (
        frequencies(exudyn(mechanism, n), speed, **options)
        / frequencies(reference(mechanism, n), speed, **options)
        for n in (12, 24)
    )
    return float(np.abs((8 * fine - coarse) / 7 - 1).max())


@pytest.mark.thorough
@pytest.mark.parametrize(("axes", "speed"), [((0, 0), 50.0), (UNSYMMETRIC, 0.0), (UNSYMMETRIC, 50)])
def test_frequencies_agree(axes: tuple[float, float], speed: float) -> None:
    """Measured 4e-6, and 2.3e-5 of unsymmetric links; the coupling moves them by up to 7 %."""
    mechanism = fourbar(axes)
    assert gap(mechanism, speed) < (5e-5 if any(axes) else 1e-5)
    if any(axes):
        with_it, without = (
            frequencies(reference(m, 8), speed) for m in (mechanism, uncoupled(mechanism))
        )
        assert np.abs(without / with_it - 1).max() > 0.05


@pytest.mark.parametrize("axes", [(0.0, 0.0), UNSYMMETRIC])
def test_eight_elements_are_enough(axes: tuple[float, float]) -> None:
    """Linear elements as they are would be 2 to 10 percent high."""
    mechanism = fourbar(axes)
    exact = frequencies(reference(mechanism, 16), 0.0)
    error = np.abs(frequencies(exudyn(mechanism, 8), 0.0) / exact - 1).max(axis=0)
    assert error[:2].max() < 2e-4
    assert error.max() < 1e-3


def test_tension_acts_along_the_normal_of_the_section() -> None:
    """As in the exact beam (Haringx), not along the axis (Engesser): they differ by N / kGA.

    Measured 5e-6 at 200 rad/s, where the other theory would be 6e-4 off.
    """
    assert gap(fourbar(), 200.0, angles=ANGLES[:1], rotation_terms=False) < 2e-5


@pytest.mark.parametrize("link", LINKS)
def test_one_unsymmetric_link_with_weight_and_masses(link: str) -> None:
    """Joints between a link with arms and links without; a node at a point mass."""
    assert gap(laden(eccentric=(link,)), 30.0, angles=ANGLES[:1]) < 5e-5


def test_damping_ratios_agree() -> None:
    """Stretching, bending and shear damped unlike, so that the arms tell them apart."""
    mechanism = damped(laden((0.3, -0.2)), 1e-4, 2e-5, 5e-5)
    ratios = [
        extrapolated(
            [
                solve_modes(engine(mechanism, n).linear_system(ANGLES[:1], 50.0), 4).damping_ratio
                for n in (6, 12, 24)
            ]
        )
        for engine in (exudyn, reference)
    ]
    np.testing.assert_allclose(ratios[0], ratios[1], rtol=5e-4)


def test_a_stiffer_laminate_moves_frequencies_of_both_engines_alike() -> None:
    mechanism = load_mechanism(MODELS / "composite_fourbar.toml")
    coupler = stiffened_section(mechanism.sections["coupler"], 1.1)
    stiffer = replace(mechanism, sections={**mechanism.sections, "coupler": coupler})
    moved = []
    for engine in (
        ReferenceEngine(mechanism, 8, "timoshenko"),
        ExudynEngine(mechanism, 8, "geometrically-exact"),
    ):
        before, after = (frequencies(e, 0.0) for e in (engine, engine.with_(mechanism=stiffer)))
        moved.append(after / before - 1)
    assert moved[0].max() > 0.03
    # Tolerance of the change, which the elements' own errors hardly touch.
    assert moved[1] == pytest.approx(moved[0], abs=0.02 * moved[0].max())


@pytest.mark.parametrize("element", ["reddy", "zigzag"])
def test_frequencies_go_with_the_root_of_the_factor_of_all_stiffnesses(element: str) -> None:
    mechanism = load_mechanism(MODELS / "composite_fourbar.toml")
    sections = {k: s.with_damping_time(0.0) for k, s in mechanism.sections.items()}
    stiff = {k: stiffened_section(s, 1.21) for k, s in sections.items()}
    before, after = (
        frequencies(ReferenceEngine(replace(mechanism, sections=own), 2, element, False), 0.0)
        for own in (sections, stiff)
    )
    assert after == pytest.approx(1.1 * before, rel=1e-7)
    with pytest.raises(InputError, match="factor of a stiffness"):
        stiffened_section(sections["coupler"], 0.0)


# --- runs -----------------------------------------------------------------------------------------


def deflected(engine: Any, drive: ConstantSpeed, time: np.ndarray, step: float) -> Any:
    """Middle deflections of all links (N, links) from straight links, and the run."""
    if isinstance(engine, ExudynEngine):
        run = engine.simulate(drive, LinkState.rigid(engine.links), time, step)
    else:
        linkage = DrivenLinkage(engine, drive, "equilibrium")
        run = linear_run(linkage, linkage.unstressed(), np.zeros(linkage.size), time, step)
    return deflections(engine, run.displacement), run


@pytest.mark.thorough
def test_runs_of_both_engines_agree() -> None:
    """Run-up of undamped unsymmetric links: 3e-4 of the peaks apart, 8e-2 without coupling."""
    drive, step, time = ConstantSpeed(20.0, run_up_time=0.05), 1e-4, np.linspace(0.0, 0.05, 101)
    mechanism = fourbar(UNSYMMETRIC, stiffness=2e6)
    exact, linear = deflected(reference(mechanism, 6), drive, time, step)
    curves, runs = zip(
        *(deflected(exudyn(mechanism, n), drive, time, step) for n in (8, 16)), strict=True
    )
    peak = np.abs(exact).max(axis=0)
    assert np.all(np.abs(extrapolated(curves) - exact).max(axis=0) < 5e-4 * peak)
    without, _ = deflected(reference(uncoupled(mechanism), 3), drive, time, step)
    assert np.all(np.abs(without - exact).max(axis=0) > 0.08 * peak)
    for run in (*runs, linear):
        assert run.energy_error < 1e-5


@pytest.mark.parametrize("integrator", ["trapezoidal", "generalized-alpha"])
def test_energy_is_balanced(integrator: str) -> None:
    """With weight, masses and damping: the balance closes in second order of the step."""
    mechanism, errors = damped(laden((0.3, -0.2), stiffness=2e6), 1e-3, 2e-5, 5e-5), []
    engine, drive, time = exudyn(mechanism, 3), ConstantSpeed(30.0), np.linspace(0.0, 0.1, 11)
    for step in (2e-4, 1e-4):
        start = LinkState.rigid(engine.links)
        errors.append(engine.simulate(drive, start, time, step, integrator=integrator).energy_error)
    assert errors[1] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.3)


def test_stiff_links_have_the_forces_of_rigid_ones() -> None:
    """Joint forces and torque through arms, with the centres of mass off the pins' axis."""
    mechanism = damped(laden(stiffness=2e9), 2e-6, 2e-6, 2e-6)
    engine, time = ExudynEngine(mechanism, 3), np.linspace(0.0, 0.4, 41)
    drive = ConstantSpeed(-8.0, run_up_time=0.2, start_angle=1.0)
    start = mechanism.linkage.motion(drive.crank_angle(np.zeros(1)))
    sagging = engine.stressed_links(start, "equilibrium").displacement
    still = LinkState([q[0] for q in sagging], LinkState.rigid(engine.links).rate)
    run = engine.simulate(drive, still, time, 5e-4)
    rates = drive.crank_angle(time), drive.crank_speed(time), drive.crank_acceleration(time)
    rigid = mechanism.inverse_dynamics(mechanism.linkage.motion(*rates))
    joints = mechanism.linkage.topology.joint_names
    wanted = np.stack([rigid.joint_force[joint] for joint in joints], axis=1)
    assert np.abs(run.joint_force - wanted).max() < 1e-3 * np.abs(wanted).max()
    torque = run.driving_torque - rigid.driving_torque
    assert np.abs(torque).max() < 2e-3 * np.abs(rigid.driving_torque).max()


def test_cables_of_eccentric_sections_are_refused_and_exact_beams_chosen() -> None:
    mechanism = fourbar(UNSYMMETRIC, eccentric=("coupler",))
    with pytest.raises(InputError, match=r"section of coupler .* use element 'geometrically"):
        ExudynEngine(mechanism, 4, "ancf")
    with pytest.raises(InputError, match=r"cannot: use prestress 'equilibrium'"):
        ExudynEngine(mechanism, 4).linear_system(0.0, 10.0, prestress="axial")
    assert ExudynEngine(mechanism, 4).element == "geometrically-exact"
    assert ExudynEngine(slender_fourbar(), 4).element == "ancf"
