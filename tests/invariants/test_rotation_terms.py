"""Rotation terms and joints against the displacements of points in the axes of the ground.

Links without mass carry point masses at places where their displacement is known. With W the
ground displacement of these by unit coordinates, times the root of their mass, kinetic energy asks
for M = W'W, C = 2 W'W' and K = W'W'' besides the elastic stiffness, the rates by differences over
the crank angle: no matrix of a link enters. The links may be welded, slide, or be rigid.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from flexmech import (
    AttachedBody,
    BeamSection,
    FourBar,
    Material,
    Mechanism,
    PlanarLinkage,
    PointMass,
    ReferenceEngine,
    RotatingArm,
    RotationTerms,
)
from tests.support.mechanisms import four_bar, l_arm, quick_return, slider_crank

FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
STEP = 2e-3
SPEED = 20.0
ANGLE = 0.4
PLACES = {0.25: 0.3, 0.5: 0.2, 0.75: 0.4}  # kg
# Massless but for what the solver of a mass matrix needs.
SECTION = BeamSection.rectangle(Material(70e9, 2700.0), 4e-3, 20e-3)
LIGHT = replace(SECTION, mass_per_length=1e-13, rotary_inertia=1e-19)
LINKAGES: dict[str, Callable[[], FourBar | PlanarLinkage | RotatingArm]] = {
    "four-bar": lambda: FourBar(0.254, 0.102, 0.2794, 0.2667),
    "arm on a hub": lambda: RotatingArm(0.3, 0.05),
    "welded legs": lambda: l_arm(),
    "slider-crank": lambda: slider_crank(line=0.2),
    "slotted lever": lambda: quick_return(),
    "welded coupler": lambda: four_bar(beyond=0.12),
    "rigid coupler": lambda: four_bar("coupler", "beyond", beyond=0.12),
    "rigid rod": lambda: slider_crank("rod"),
}


def carrying(linkage: FourBar | PlanarLinkage | RotatingArm) -> Mechanism:
    """Each link with three point masses and none of its own."""
    links = linkage.topology.links
    points = tuple(
        PointMass(link.name, part * link.length, mass)
        for link in links
        for part, mass in PLACES.items()
    )
    sections = {link.name: LIGHT for link in links if not link.rigid}
    return Mechanism(linkage, sections, link_masses=points)


def engine_of(mechanism: Mechanism) -> ReferenceEngine:
    return ReferenceEngine(mechanism, 4, "euler", component_modes=False)


def weighted_displacement(engine: ReferenceEngine, angles: np.ndarray) -> np.ndarray:
    """Ground displacement of the point masses by unit coordinates, times the root of each mass.

    Shape (B, rows, n).
    """
    system = engine.linear_system(angles, 0.0, prestress="none")
    unit = np.broadcast_to(np.eye(system.size), (len(angles), system.size, system.size))
    moved = system.displacements(unit)  # (B, m, link, station, 2)
    stations = np.linspace(0.0, 1.0, moved.shape[3])
    rows = []
    for part, mass in PLACES.items():
        (station,) = np.flatnonzero(np.isclose(stations, part))
        at = moved[:, :, :, station]
        rows.append(np.sqrt(mass) * at.reshape(len(angles), system.size, -1))
    return np.swapaxes(np.concatenate(rows, axis=2), 1, 2)


@pytest.mark.parametrize("make", LINKAGES.values(), ids=LINKAGES)
def test_mass_coriolis_and_centrifugal_matrices_follow_from_ground_axes(make: Callable) -> None:
    engine = engine_of(carrying(make()))
    path = weighted_displacement(engine, ANGLE + STEP * np.arange(-4, 5))
    here = path[4].T
    rate = SPEED * np.einsum("k,kij->ij", FIRST, path) / STEP
    change = SPEED**2 * np.einsum("k,kij->ij", SECOND, path) / STEP**2
    system, frozen = (
        engine.linear_system(ANGLE, SPEED, prestress="none", rotation_terms=terms)
        for terms in (True, False)
    )
    for found, expected, error in (
        (system.mass[0], here @ path[4], 1e-10),
        (system.damping[0], 2 * here @ rate, 1e-8),
        (system.stiffness[0] - frozen.stiffness[0], here @ change, 1e-6),
    ):
        scale = np.abs(expected).max() + 1e-9 * np.abs(frozen.stiffness).max() * (error > 1e-7)
        np.testing.assert_allclose(found, expected, rtol=0, atol=error * scale)


@pytest.mark.parametrize("make", LINKAGES.values(), ids=LINKAGES)
def test_joined_ends_move_alike_and_held_ends_stay(make: Callable) -> None:
    """Those on lines of the ground along these."""
    linkage = make()
    system = engine_of(carrying(linkage)).linear_system(ANGLE, 0.0, prestress="none")
    moved, topology = system.displacements(np.eye(system.size)[None])[0], linkage.topology

    def at(end) -> np.ndarray:
        return moved[:, topology.index(end.link), -1 if end.end == "end" else 0]

    scale = 1e-12 * np.abs(moved).max()
    for tie in topology.ties:
        np.testing.assert_allclose(at(tie.leader), at(tie.follower), atol=scale)
    for held in (*topology.clamps, *topology.pivots):
        np.testing.assert_allclose(at(held.link_end), 0.0, atol=scale)
    for slider in topology.sliders:
        if not slider.guide:
            across = np.array([-np.sin(slider.direction), np.cos(slider.direction)])
            np.testing.assert_allclose(at(slider.link_end) @ across, 0.0, atol=scale)


@pytest.mark.parametrize("name", ["four-bar", "slotted lever"])
def test_rotation_terms_that_are_switched_on_alone_add_up_to_all(name: str) -> None:
    """Coriolis terms are in the damping; at rest there is none of them."""
    engine = engine_of(carrying(LINKAGES[name]()))

    def matrices(*on: bool) -> tuple[np.ndarray, np.ndarray]:
        terms = RotationTerms(*on)
        system = engine.linear_system(ANGLE, SPEED, prestress="none", rotation_terms=terms)
        return system.damping, system.stiffness

    none, every = matrices(False, False, False), matrices(True, True, True)
    singles = [matrices(*row) for row in np.eye(3, dtype=bool).tolist()]
    for kind in (0, 1):
        total = sum(single[kind] - none[kind] for single in singles)
        scale = np.abs(every[kind]).max()
        np.testing.assert_allclose(every[kind] - none[kind], total, atol=1e-12 * scale)
    assert [single[0].any() for single in singles] == [True, False, False]
    still = engine.linear_system(ANGLE, 0.0, prestress="none")
    assert not still.terms.any
    assert still.is_conservative


@pytest.mark.parametrize("stiff", [False, True], ids=["elastic", "rigid"])
def test_a_free_shaft_turns_all_links_on_it(stiff: bool) -> None:
    """Two arms welded to a shaft: a rotation of the shaft moves each as a rigid body about it.

    The lowest frequency is zero, and its shape the distance from the axis.
    """
    linkage = l_arm("arm") if stiff else l_arm()
    sections = {link.name: SECTION for link in linkage.topology.links if not link.rigid}
    bodies = (AttachedBody("arm", 0.1, 0.2, 1e-4),)
    mechanism = Mechanism(linkage, sections, bodies=bodies)
    engine = ReferenceEngine(mechanism, 4, "euler", component_modes=False, shaft="free")
    system = engine.linear_system(ANGLE, 0.0, prestress="none")
    values, vectors = np.linalg.eig(np.linalg.solve(system.mass[0], system.stiffness[0]))
    lowest = int(np.argmin(np.abs(values)))
    assert abs(values[lowest]) < 1e-6 * np.sort(np.abs(values))[1]
    moved = system.displacements(vectors[:, [lowest]].real[None])[0, 0]
    motion = linkage.motion(ANGLE, 1.0)
    lengths = [link.length for link in linkage.topology.links]
    stations = np.linspace(0.0, 1.0, moved.shape[1])
    rigid = np.stack([motion.velocity(n, stations * length) for n, length in enumerate(lengths)])
    turn = moved[1, -1] @ rigid[1, -1] / (rigid[1, -1] @ rigid[1, -1])
    np.testing.assert_allclose(moved, turn * rigid, atol=1e-6 * np.abs(moved).max())
