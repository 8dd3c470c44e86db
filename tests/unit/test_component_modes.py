"""Component-mode reduction of the links."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

from flexmech import load_mechanism
from flexmech.analyses import solve_modes
from flexmech.analyses.frequencies.formulation import Formulation, Systems
from flexmech.analyses.frequencies.reduction import converged_modes
from flexmech.choices import PRESTRESS_LEVELS, Prestress
from flexmech.linear_system import (
    GREAT_DETAIL,
    ComponentModes,
    Engine,
    LinearSystem,
    component_modes,
)
from flexmech.linear_system.assembly.reduced_system import reduced_system
from flexmech.linear_system.assembly.system import _inverse_by_blocks, condense
from flexmech.linear_system.links.rotation_terms import RotationTerms, SystemMatrices
from flexmech.linkages import AttachmentPoint, JointSpring, Spring
from flexmech.mechanism import Mechanism
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from tests.support.random_mechanisms import random_case
from tests.support.strategies import arm, fourbar

HEAVY = fourbar(joint_masses={"A": 0.02, "B": 0.05})
ANGLES = np.linspace(0.0, 2 * np.pi, 13)


def reduction(
    mechanism: Mechanism,
    *,
    modes: int = 4,
    fastest: float = 0.0,
    bowed: bool = False,
    detail: float = 1.0,
) -> ComponentModes:
    engine = ReferenceEngine(mechanism, 8)
    return component_modes(
        mechanism.linkage.topology,
        engine.links,
        modes,
        fastest,
        couples_axially=bowed,
        detail=detail,
    )


def systems(mechanism: Mechanism, speed: float, prestress: str, terms: bool) -> list[LinearSystem]:
    engine = ReferenceEngine(mechanism, 8)
    return [
        engine.linear_system(
            ANGLES, speed, prestress=prestress, rotation_terms=terms, modes=6, detail=detail
        )
        for detail in (1.0, None)
    ]


@pytest.mark.parametrize("terms", [False, True])
@pytest.mark.parametrize("prestress", ["none", "axial", "equilibrium"])
@pytest.mark.parametrize("speed", [0.0, 20.0])
def test_six_frequencies_in_component_modes(speed: float, prestress: str, terms: bool) -> None:
    for mechanism in (fourbar(), HEAVY):
        reduced, full = systems(mechanism, speed, prestress, terms)
        assert reduced.size < full.size / 2
        found, exact = (solve_modes(system, 6).frequency for system in (reduced, full))
        assert found == pytest.approx(exact, rel=3e-5)


@pytest.mark.parametrize("name", ["aluminium_fourbar", "watt_six_bar", "slider_crank"])
def test_the_mass_couples_no_end_with_a_mode(models: Path, name: str) -> None:
    """Eigenvalues of frozen positions rest on it: the mass beyond the ends is not looked at."""
    engine = ReferenceEngine(load_mechanism(models / f"{name}.toml"))
    system = engine.linear_system(ANGLES, rotation_terms=False, detail=1.0)
    assert system.unit_mass_from is not None
    ends = system.unit_mass_from
    assert 0 < ends < system.size
    beyond = system.mass[:, ends:]
    expected = np.eye(system.size)[ends:] * np.ones((len(beyond), 1, 1))
    scale = np.sqrt(np.einsum("bii->bi", system.mass))
    assert np.abs((beyond - expected) / scale[:, ends:, None] / scale[:, None]).max() < 1e-10


def test_reduced_frequencies_of_a_resting_linkage_lie_above_the_full_ones() -> None:
    reduced, full = systems(fourbar(), 0.0, "none", False)
    found, exact = (solve_modes(system, 6).frequency for system in (reduced, full))
    assert (found >= exact * (1 - 1e-10)).all()
    assert (found > exact * (1 + 1e-9)).any()


def test_finer_detail_brings_the_error_down() -> None:
    engine = ReferenceEngine(fourbar(), 16)
    exact = solve_modes(engine.unreduced().linear_system(ANGLES, prestress="none"), 6).frequency
    errors = []
    for detail in (1.0, 2.0, 4.0):
        system = engine.linear_system(ANGLES, prestress="none", modes=6, detail=detail)
        errors.append(np.abs(solve_modes(system, 6).frequency / exact - 1).max())
    assert errors[0] > 4 * errors[1] > 16 * errors[2]


def test_reduced_links_keep_their_rigid_ends() -> None:
    for full, reduced in zip(
        ReferenceEngine(fourbar(), 8).links, reduction(fourbar()).links, strict=True
    ):
        for end in ("start", "end"):
            kept = reduced.model.end_displacement(end)
            rows = reduced.basis[full.end_displacement(end)]
            unit = np.zeros_like(rows)
            unit[np.arange(len(kept)), kept] = 1.0
            assert np.array_equal(rows, unit)
    assert [len(link.model.start) for link in reduction(fourbar()).links] == [0, 2, 0]


def test_reduced_matrices_are_projections() -> None:
    section_damped = fourbar(damping_time=1e-5)
    for full, reduced in zip(
        ReferenceEngine(section_damped, 8).links, reduction(section_damped).links, strict=True
    ):
        basis = reduced.basis
        for name in ("mass", "stiffness", "gyroscopic", "centrifugal_mass", "damping"):
            projected = basis.T @ getattr(full, name) @ basis
            scale = np.abs(projected).max()
            assert getattr(reduced.model, name) == pytest.approx(projected, abs=1e-14 * scale)
        assert reduced.model.shape == pytest.approx(full.shape @ basis, abs=1e-14)
        assert scipy.linalg.eigvalsh(reduced.model.mass)[0] > 0


def test_static_shapes_of_the_ends_are_exact() -> None:
    """A static load at a joined end bends the reduced link as it bends the full one."""
    full = ReferenceEngine(fourbar(), 8).links[0]
    reduced = reduction(fourbar()).links[0]
    free = np.arange(3, full.size)
    load = np.zeros(full.size)
    load[full.end] = [3.0, 2.0]
    exact = np.zeros(full.size)
    exact[free] = np.linalg.solve(full.stiffness[np.ix_(free, free)], load[free])
    model = reduced.model
    found = reduced.basis @ np.linalg.solve(model.stiffness, reduced.basis.T @ load)
    assert found == pytest.approx(exact, rel=1e-8, abs=1e-12 * np.abs(exact).max())


def test_more_modes_more_speed_and_bowing_keep_more_coordinates() -> None:
    def size(**settings: float) -> int:
        return sum(link.model.size for link in reduction(fourbar(), **settings).links)

    assert size(modes=8) > size(modes=4)
    assert size(fastest=200.0) > size(fastest=0.0)
    assert size(bowed=True) > size(bowed=False)
    assert size(detail=2.0) > size(detail=1.0)
    condensed = [link.condensed for link in reduction(fourbar(), bowed=True).links]
    assert all(c.any() for c in condensed)
    assert not any(link.condensed.any() for link in reduction(fourbar()).links)


def test_an_arm_has_no_joined_end() -> None:
    link = reduction(arm()).links[0]
    assert len(link.model.start) == len(link.model.end) == 0
    engine = ReferenceEngine(arm(), 8)
    found, exact = (
        solve_modes(engine.linear_system(0.0, 10.0, modes=3, detail=detail), 3).frequency
        for detail in (1.0, None)
    )
    assert found == pytest.approx(exact, rel=2e-5)


def test_condensed_coordinates_follow_statically() -> None:
    full = ReferenceEngine(fourbar(), 3).unreduced().linear_system([0.3, 1.0], 20.0)
    condensed = np.zeros(full.size, dtype=bool)
    condensed[[2, 5, 7]] = True
    matrices, expansion = condense(full, condensed)
    kept = np.flatnonzero(~condensed)
    forces = full.stiffness @ expansion
    scale = np.abs(full.stiffness).max()
    assert np.abs(forces[:, condensed]).max() < 1e-12 * scale
    assert np.array_equal(expansion[0, kept], np.eye(len(kept)))
    # Where the stiffness is symmetric, Guyan's is the Schur complement.
    still = (
        ReferenceEngine(fourbar(), 3)
        .unreduced()
        .linear_system([0.3, 1.0], 20.0, rotation_terms=False)
    )
    symmetric, _ = condense(still, condensed)
    inverse = np.linalg.inv(still.stiffness)[:, kept[:, None], kept]
    assert np.linalg.inv(symmetric.stiffness) == pytest.approx(inverse, rel=1e-6, abs=1e-12)
    assert matrices.mass.shape == (2, len(kept), len(kept))


def test_what_one_position_couples_is_inverted_together() -> None:
    """Of three positions, of two links each, a spring is between the links in the last."""
    chance = np.random.default_rng(0)
    matrices = np.zeros((3, 5, 5))
    matrices[:, :2, :2], matrices[:, 2:, 2:] = (
        np.eye(n) + 0.3 * chance.random((3, n, n)) for n in (2, 3)
    )
    for coupling in (0.0, 0.2):
        matrices[2, 1, 3] = coupling
        found = _inverse_by_blocks(matrices)
        assert found == pytest.approx(np.linalg.inv(matrices), rel=1e-12, abs=1e-14)
    assert found[2, 1, 3] != 0


@pytest.mark.parametrize("prestress", ["none", "equilibrium"])
def test_expanded_modes_are_those_of_the_full_system(prestress: str) -> None:
    reduced, full = systems(HEAVY, 20.0, prestress, False)
    modes, exact = solve_modes(reduced, 3), solve_modes(full, 3)
    shapes = reduced.unreduced_vectors(modes.vectors, full.frames)
    overlap = np.swapaxes(exact.vectors, 1, 2) @ full.mass @ shapes
    assert np.abs(overlap) == pytest.approx(np.broadcast_to(np.eye(3), overlap.shape), abs=2e-3)
    here, there = (
        np.abs(system.displacements(vectors))
        for system, vectors in ((reduced, modes.vectors), (full, exact.vectors))
    )
    assert here == pytest.approx(there, abs=2e-3 * there.max())


@pytest.mark.parametrize("prestress", ["none", "axial", "equilibrium"])
@pytest.mark.parametrize("seed", [0, 1, 3])
def test_damping_ratios_in_turning_frames(seed: int, prestress: str) -> None:
    """The usual modes, and what the ends that turn against their links ask of damped ones."""
    case = random_case(seed, damped=True)
    engine = ReferenceEngine(case.mechanism, 16, "euler")
    found, exact = (
        solve_modes(
            engine.linear_system(
                case.crank_angles,
                case.crank_speed,
                prestress=prestress,
                modes=4,
                detail=detail,
            ),
            3,
        ).damping_ratio
        for detail in (1.0, None)
    )
    np.testing.assert_allclose(found, exact, rtol=2e-3)


def test_damping_of_several_times_in_a_link(models: Path) -> None:
    """Of plies whose bending, stretching and shear lose differently; more modes, less error."""
    engine = ReferenceEngine(load_mechanism(models / "composite_fourbar.toml"), 8)
    exact = solve_modes(engine.unreduced().linear_system(ANGLES), 4).frequency
    errors = [
        np.abs(solve_modes(engine.linear_system(ANGLES, detail=d), 4).frequency / exact - 1).max()
        for d in (1.0, 2.0, 4.0)
    ]
    assert errors[0] > 3 * errors[1] > 9 * errors[2]
    assert errors[2] < 5e-6


def test_thick_links_stretch_by_their_own_inertia(models: Path, tmp_path: Path) -> None:
    """At frequencies like those at which they bend: held links too, each end by itself."""
    text = (models / "composite_fourbar.toml").read_text()
    thick = tmp_path / "thick.toml"
    thick.write_text(text.replace('thickness = "1 mm"', 'thickness = "5 mm"'))
    engine = ReferenceEngine(load_mechanism(thick), 8, "zigzag")
    exact = solve_modes(engine.unreduced().linear_system(ANGLES), 6)
    system = engine.linear_system(ANGLES, modes=6, detail=2.0)
    found = solve_modes(system, 6)
    assert system.size < 70
    np.testing.assert_allclose(found.frequency, exact.frequency, rtol=1e-5)
    np.testing.assert_allclose(found.damping_ratio, exact.damping_ratio, rtol=1e-3)


@pytest.mark.parametrize(
    ("speed", "damping_time", "elements", "element"),
    [
        (45.0, 0.0, 8, "euler"),
        (60.0, 0.0, 32, "euler"),
        (33.0, 1e-3, 8, "euler"),
        (60.0, 1e-3, 8, "euler"),
        (60.0, 3e-4, 16, "euler"),
        (60.0, 0.0, 16, "timoshenko"),
    ],
)
def test_deep_bows_and_strong_damping_in_great_detail(
    aluminium: Mechanism, speed: float, damping_time: float, elements: int, element: str
) -> None:
    """Where no number of straight links' modes helps, and the less so the finer the mesh."""
    sections = {n: s.with_damping_time(damping_time) for n, s in aluminium.sections.items()}
    engine = ReferenceEngine(replace(aluminium, sections=sections), elements, element)
    angles = np.radians([0.0, 30.0, 330.0])
    exact = solve_modes(engine.unreduced().linear_system(angles, speed), 3)

    def error(detail: float) -> float:
        system = engine.linear_system(angles, speed, modes=3, detail=detail)
        assert system.size < 40
        found = solve_modes(system, 3)
        ratio = np.abs(found.damping_ratio - exact.damping_ratio)
        assert np.all(ratio <= 5e-4 * exact.damping_ratio + 1e-7) or detail < GREAT_DETAIL
        return float(np.abs(found.frequency / exact.frequency - 1).max())

    assert error(1.0) > 2e-5
    assert error(GREAT_DETAIL) < 1.2e-5


@pytest.mark.parametrize("prestress", PRESTRESS_LEVELS)
@pytest.mark.parametrize("engine_kind", [ReferenceEngine, ExudynEngine])
def test_strong_damping_at_following_ends_stays_reduced(
    engine_kind: type[Engine], prestress: Prestress
) -> None:
    """What damps an end that turns against its link is resisted by the link's damping too.

    A static answer is then ``1 + lambda tau`` times too great, with any number of modes.
    """
    case = random_case(5025, damped=True, angles=3)
    sections = case.mechanism.sections
    mechanism = replace(
        case.mechanism, sections={n: s.with_damping_time(5e-3) for n, s in sections.items()}
    )
    engine = engine_kind(mechanism, 8)
    angles, speed = case.crank_angles, 3.0 * case.crank_speed

    def error(detail: float) -> float:
        system = engine.linear_system(angles, speed, prestress=prestress, modes=1, detail=detail)
        assert system.size <= 20
        found = solve_modes(system, 1).eigenvalues
        return float(np.abs(found / exact - 1).max())

    whole = engine.unreduced().linear_system(angles, speed, prestress=prestress)
    exact = solve_modes(whole, 1).eigenvalues
    assert error(1.0) > 1e-4
    assert error(2.0) < 1e-5


@pytest.mark.parametrize(
    "seeds", [range(3), pytest.param(range(3, 24), marks=pytest.mark.thorough)], ids=str
)
def test_random_damped_mechanisms_stay_reduced_at_high_speed(seeds: range) -> None:
    """All but few, with the frequencies and damping ratios of all coordinates."""
    details = []
    for seed in seeds:
        case = random_case(seed, damped=True)
        speed = 2.5 * case.crank_speed
        engine = ReferenceEngine(case.mechanism, 8, "euler")
        checked = converged_modes(Systems(engine, Formulation(modes=3)), case.crank_angles, speed)
        whole = engine.unreduced().linear_system(case.crank_angles, speed)
        exact = solve_modes(whole, 3)
        np.testing.assert_allclose(checked.modes.frequency, exact.frequency, rtol=2.1e-5)
        np.testing.assert_allclose(checked.modes.damping_ratio, exact.damping_ratio, rtol=1.1e-3)
        if checked.system.size < whole.size / 2:
            details.append(checked.systems.detail)
    assert len(details) >= 7 / 8 * len(seeds)
    assert details.count(GREAT_DETAIL) >= len(seeds) // 4


@pytest.mark.parametrize("seed", [5303, 5312, 5317])
@pytest.mark.parametrize("engine_kind", [ReferenceEngine, ExudynEngine])
def test_dampers_of_springs_and_joints_stay_reduced(engine_kind: type[Engine], seed: int) -> None:
    """A following end alone turns in the frozen frame, and not the shape that it carries.

    A spring's and a joint's forces on links bend them in ways that few modes have.
    """
    case = random_case(seed, angles=3)
    lengths, ground = case.mechanism.linkage.lengths, AttachmentPoint("ground", 0.1, -0.3)
    on_coupler = AttachmentPoint("coupler", 0.4 * lengths["coupler"])
    mechanism = replace(
        case.mechanism,
        springs=(Spring("damper", on_coupler, ground, 1000.0, 0.3, damping=3.0),),
        joint_springs=(JointSpring("B", torsional_stiffness=1.0, torsional_damping=0.01),),
    )
    engine, angles, speed = engine_kind(mechanism, 8), case.crank_angles, case.crank_speed
    system = engine.linear_system(angles, speed, prestress="none", modes=2, detail=2.0)
    assert system.size <= 30
    whole = engine.unreduced().linear_system(angles, speed, prestress="none")
    exact = solve_modes(whole, 2).eigenvalues
    np.testing.assert_allclose(solve_modes(system, 2).eigenvalues, exact, rtol=1e-5)


def test_condensation_keeps_what_is_first_order_in_the_eigenvalue() -> None:
    """Of a stiffness that is not symmetric too: ``K + s C`` eliminated, at small s."""
    random = np.random.default_rng(0)
    n, gone = 7, np.arange(7) >= 4
    stiffness = 10 * np.eye(n) + random.normal(size=(n, n))
    damping, mass = random.normal(size=(2, n, n))
    reduced, _ = condense(SystemMatrices(mass[None], damping[None], stiffness[None]), gone)

    def eliminated(s: float) -> np.ndarray:
        whole = stiffness + s * damping
        return np.linalg.inv(np.linalg.inv(whole)[:4, :4])

    step = 1e-5
    slope = (eliminated(step) - eliminated(-step)) / (2 * step)
    assert reduced.stiffness[0] == pytest.approx(eliminated(0.0), rel=1e-9)
    assert reduced.damping[0] == pytest.approx(slope, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize("speed", [4.0, 10.0])
def test_a_stretched_arm_in_great_detail(models: Path, speed: float) -> None:
    """By up to one part in a hundred: its axis tilts less than its sections would turn.

    An engine does not reduce an arm, which turns as one body.
    """
    engine = ReferenceEngine(load_mechanism(models / "rotating_arm_slender_70.toml"), 16)
    assert engine.element == "timoshenko"
    exact = solve_modes(engine.linear_system(0.0, speed), 4).frequency
    motion = engine.mechanism.linkage.motion(np.zeros(1), speed)
    stressed = engine.stressed_links(motion, "equilibrium")

    def error(detail: float) -> float:
        modes = component_modes(
            engine.topology, engine.links, 4, speed, couples_axially=True, detail=detail
        )
        reduced = (engine.links, modes, motion, stressed, RotationTerms())
        found = solve_modes(reduced_system(*reduced), 4).frequency
        return float(np.abs(found / exact - 1).max())

    usual, great = error(GREAT_DETAIL / 2), error(2 * GREAT_DETAIL)
    assert usual > 1e-4
    assert great < 1e-5
