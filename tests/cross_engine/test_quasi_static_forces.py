"""Internal forces at the quasi-static equilibrium: both engines, rigid links, and the curvature."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmech.errors import InputError
from flexmech.linear_system import DisplacedLinks, Engine, bent_curvature, kinks_of
from flexmech.linkages import GROUND, AttachmentPoint, JointSpring, Load, RotatingArm, Spring
from flexmech.materials import Material
from flexmech.mechanism import Mechanism, PointMass
from flexmech.modelfile import load_mechanism
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from flexmech.sections import BeamSection

MODELS = Path(__file__).parents[2] / "models"
ANGLES = np.radians(np.arange(3.0, 363.0, 15.0))
PARTS = 8


def four_bar(stiffness: float) -> Mechanism:
    """The paper's four-bar under weight and a spring that bows its coupler."""
    mechanism = load_mechanism(MODELS / "aluminium_fourbar.toml")
    ends = AttachmentPoint(GROUND, 0.05, 0.3), AttachmentPoint("coupler", 0.1)
    return replace(
        mechanism,
        gravity=(0.0, -9.81),
        springs=(Spring("s", *ends, stiffness, 0.05),),
        link_masses=(PointMass("rocker", 0.1, 0.05),),
    )


def slider_crank() -> Mechanism:
    """A rigid crank, and a rod under a load that keeps its direction."""
    mechanism = load_mechanism(MODELS / "slider_crank.toml")
    rod = mechanism.linkage.topology.link_names[1]
    load = Load("l", AttachmentPoint(rod, 0.05), ((30.0, -80.0),), (0.4,))
    return replace(mechanism, loads=(load,), gravity=(0.0, -9.81))


def six_bar() -> Mechanism:
    """With a follower force and a torsional spring."""
    mechanism = load_mechanism(MODELS / "stephenson_six_bar.toml")
    last, joint = mechanism.linkage.topology.links[-1], mechanism.linkage.topology.joint_names[-1]
    turned = Load("t", AttachmentPoint(last.name, 0.4 * last.length), ((-2.0, 5.0),), axes="link")
    spring = JointSpring(joint, torsional_stiffness=0.8)
    return replace(mechanism, loads=(turned,), joint_springs=(spring,))


def cuts(mechanism: Mechanism, link: int) -> np.ndarray:
    """At the ends of equal parts, and beside what acts between them."""
    name = mechanism.linkage.topology.link_names[link]
    mass, length = mechanism.link_mass(name), mechanism.linkage.topology.links[link].length
    jumps = np.array([*mass.point_positions, *mechanism.acting_at(name)])
    beside = 2e-9 * length
    places = np.concatenate([np.linspace(0, length, PARTS + 1), jumps - beside, jumps + beside])
    apart = [x for x in places if not np.any(np.abs(x - jumps) < beside / 2)]
    return np.unique(np.clip(apart, beside, length - beside))


def found(engine: Engine, speed: float) -> tuple[DisplacedLinks, list[np.ndarray]]:
    mechanism = engine.mechanism
    motion = mechanism.linkage.motion(ANGLES, speed, 0.0)
    links = DisplacedLinks.at_equilibrium(engine, motion)
    count = len(mechanism.linkage.topology.links)
    return links, [links.section_forces(n, cuts(mechanism, n)) for n in range(count)]


def gaps(first: list[np.ndarray], second: list[np.ndarray]) -> np.ndarray:
    """Of each link and kind of force, over its peak."""
    return np.array(
        [
            np.abs(one - other).max(axis=(0, 1)) / np.abs(other).max(axis=(0, 1))
            for one, other in zip(first, second, strict=True)
        ]
    )


def rigid_forces(mechanism: Mechanism, speed: float) -> list[np.ndarray]:
    forces = mechanism.inverse_dynamics(mechanism.linkage.motion(ANGLES, speed, 0.0))
    return [
        np.stack(
            [
                kind(n, cuts(mechanism, n))
                for kind in (forces.axial_force, forces.bending_moment, forces.shear_force)
            ],
            axis=-1,
        )
        for n in range(len(mechanism.linkage.topology.links))
    ]


CASES: dict[str, tuple[Callable[[], Mechanism], float]] = {
    "stiff four-bar, slow": (lambda: four_bar(0.3), 1.0),
    "bowed four-bar, fast": (lambda: four_bar(300.0), 25.0),
    "slider-crank, slow": (slider_crank, 5.0),
    "slider-crank, fast": (slider_crank, 150.0),
    "six-bar, slow": (six_bar, 1.0),
    "six-bar, fast": (six_bar, 25.0),
}


@pytest.mark.parametrize("case", CASES)
def test_both_engines(case: str) -> None:
    """Corotational beams, and Exudyn's static solver.

    Exudyn's exact beams, which the rod of the slider-crank is made of, have linear shapes and need
    twice the elements.
    """
    make, speed = CASES[case]
    mechanism = make()
    links, reference = found(ReferenceEngine(mechanism, 8), speed)
    other = ExudynEngine(mechanism, 8)
    if other.element == "geometrically-exact":
        other = other.with_(elements=16)
    others, exudyn = found(other, speed)
    for joint, force in links.joint_force.items():
        np.testing.assert_allclose(
            others.joint_force[joint], force, atol=1e-3 * np.abs(force).max()
        )
    assert gaps(exudyn, reference).max() < 1e-3
    bent = gaps(reference, rigid_forces(mechanism, speed))
    # Those of rigid links would not do where links bend.
    if case == "bowed four-bar, fast":
        assert bent.min() > 0.08
        assert bent.max() < 0.6
    assert (bent.max() > 1e-2) == (case not in {"slider-crank, slow", "stiff four-bar, slow"})


def test_gap_of_the_engines_falls_with_the_mesh() -> None:
    """Cuts of the bowed coupler lie inside elements, whose chords turn by a third of a radian."""
    mechanism = four_bar(300.0)
    forces = [found(engine(mechanism, 16), 5.0)[1] for engine in (ReferenceEngine, ExudynEngine)]
    assert gaps(*forces)[1].max() < 5e-5


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
def test_shear_force_is_the_slope_of_the_moment(engine: type[Engine]) -> None:
    """Along and across the turned axis of a link that bows: ``dM/ds = -V``."""
    links, _ = found(engine(four_bar(300.0), 16), 5.0)
    places = np.array([0.03, 0.21])
    step = 1e-5
    around = np.sort(np.concatenate([places - step, places, places + step]))
    before, here, after = np.moveaxis(
        links.section_forces(1, around).reshape(len(ANGLES), 2, 3, 3), 2, 0
    )
    slope = (after - before)[..., 1] / (2 * step)
    np.testing.assert_allclose(-slope, here[..., 2], atol=2e-4 * np.abs(slope).max())


def test_straight_links_bear_what_rigid_ones_do() -> None:
    """Without displacement it is inverse dynamics, found by another sum."""
    for make, speed in (CASES["bowed four-bar, fast"], (slider_crank, 30.0), (six_bar, 9.0)):
        mechanism = make()
        engine, motion = ReferenceEngine(mechanism, 8), mechanism.linkage.motion(ANGLES, speed, 0.0)
        straight = [np.zeros((len(ANGLES), link.size)) for link in engine.links]
        acting = tuple(engine.connectors.point_forces(motion))
        links = DisplacedLinks(mechanism, engine.links, motion, straight, acting)
        forces = [links.section_forces(n, cuts(mechanism, n)) for n in range(len(straight))]
        assert gaps(forces, rigid_forces(mechanism, speed)).max() < 1e-10
        for joint, force in mechanism.inverse_dynamics(motion).joint_force.items():
            size = np.abs(force).max()
            np.testing.assert_allclose(links.joint_force[joint], force, atol=1e-10 * size)


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
def test_moment_is_that_of_the_curvature(engine: type[Engine]) -> None:
    """Statics of the displaced links against the mean curvature of their elements."""
    off = []
    for elements in (8, 16):
        mechanism = four_bar(300.0)
        links, _ = found(engine(mechanism, elements), 25.0)
        readings, section = links.links[1].readings, mechanism.sections["coupler"]
        nodes = readings.nodes
        rows = np.stack([readings.rotation_at(x / nodes[-1]) for x in nodes])
        turned = links.displacement[1] @ rows.T
        if engine is ExudynEngine:  # a slope vector is turned by its arc sine, stretch left out
            turned = np.arcsin(turned)
        bent = np.diff(turned, axis=1) / np.diff(nodes)
        moment = links.section_forces(1, (nodes[1:] + nodes[:-1]) / 2)[..., 1]
        off.append(np.abs(section.bending_stiffness * bent - moment).max() / np.abs(moment).max())
    assert off[1] < 1e-3
    assert off[0] / off[1] > (3 if engine is ExudynEngine else 3.8)


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
def test_curvature_of_links_that_bow(engine: type[Engine]) -> None:
    """Statics of the displaced links against the curvature that running links are judged by.

    The coupler bows by a tenth. Beside the spring and the mass the moment has a kink.
    """
    mechanism = four_bar(300.0)
    links, _ = found(engine(mechanism, 16), 25.0)
    for number, name in ((1, "coupler"), (2, "rocker")):
        link, kinks = links.links[number], kinks_of(mechanism, name)
        places = np.linspace(0.02, 0.98, 33) * mechanism.linkage.topology.links[number].length
        moment = links.bending_moment(number, places)
        curvature = bent_curvature(link, links.displacement[number], places, kinks)
        stiffness, size = mechanism.sections[name].bending_stiffness, np.abs(moment).max()
        np.testing.assert_allclose(stiffness * curvature, moment, atol=1e-3 * size)
        smooth = bent_curvature(link, links.displacement[number], places)
        assert np.abs(stiffness * smooth - moment).max() > 5e-3 * size
    rows = links.links[1].readings.curvatures_at(places)
    small = mechanism.sections["coupler"].bending_stiffness * links.displacement[1] @ rows.T
    moment = links.bending_moment(1, places)
    assert np.abs(small - moment).max() > 1e-2 * np.abs(moment).max()


def test_curvature_of_a_link_that_shears_is_of_its_rotations() -> None:
    thick = BeamSection.rectangle(Material(70e9, 2700.0, 0.33), 30e-3, 20e-3)
    push = Load("push", AttachmentPoint("arm", 0.25), ((0.0, 900.0),), axes="link")
    arm = Mechanism(RotatingArm(0.25), {"arm": thick}, loads=(push,))
    links, _ = found(ReferenceEngine(arm, 8, "timoshenko"), 1.0)
    places = np.linspace(0.02, 0.23, 9)
    curvature = bent_curvature(links.links[0], links.displacement[0], places, [])
    moment = links.bending_moment(0, places)
    np.testing.assert_allclose(thick.bending_stiffness * curvature, moment, rtol=1e-3)


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
def test_stretched_arm(engine: type[Engine]) -> None:
    """A mass at the tip of a soft arm turns on the stretched radius, by hand."""
    stiffness, mass, length, speed = 2e4, 0.5, 0.4, 100.0
    section = BeamSection(stiffness, 50.0, math.inf, 1e-6, 1e-12, 5e-3)
    tip = (PointMass("arm", length, mass),)
    arm = Mechanism(RotatingArm(length), {"arm": section}, link_masses=tip)
    forces = found(engine(arm, 4), speed)[1][0]
    expected = mass * speed**2 * length / (1 - mass * speed**2 * length / stiffness)
    np.testing.assert_allclose(forces[..., 0], expected, rtol=1e-6)
    assert np.abs(forces[..., 1:]).max() < 1e-6 * expected


def test_each_force_alone_is_that_of_all() -> None:
    links, forces = found(ReferenceEngine(six_bar(), 4), 9.0)
    for number, own in enumerate(forces):
        places = cuts(links.mechanism, number)
        alone = links.axial_force, links.bending_moment, links.shear_force
        np.testing.assert_array_equal(np.stack([of(number, places) for of in alone], -1), own)


def test_load_over_time_is_refused() -> None:
    place, values = AttachmentPoint("coupler", 0.1), ((1.0, 0.0), (2.0, 0.0))
    late = Load("late", place, values, (0.0, 0.0), over="time", at=(0.0, 1.0))
    engine = ReferenceEngine(replace(four_bar(0.3), loads=(late,)), 4)
    with pytest.raises(InputError, match=r"late.*over time"):
        DisplacedLinks.at_equilibrium(engine, engine.mechanism.linkage.motion(ANGLES, 1.0, 0.0))


def test_free_shaft_is_refused() -> None:
    engine = ReferenceEngine(replace(four_bar(0.3), shaft_inertia=1e-3), 4, shaft="free")
    with pytest.raises(InputError, match=r"equilibrium.*prescribed"):
        DisplacedLinks.at_equilibrium(engine, engine.mechanism.linkage.motion(ANGLES, 1.0, 0.0))


def test_thick_pushed_arm() -> None:
    """Shear-flexible elements of both engines, and mass along the link."""
    thick = BeamSection.rectangle(Material(70e9, 2700.0, 0.33), 30e-3, 20e-3)
    push = Load("push", AttachmentPoint("arm", 0.25), ((0.0, 900.0),), axes="link")
    arm = Mechanism(RotatingArm(0.25), {"arm": thick}, loads=(push,))
    _, reference = found(ReferenceEngine(arm, 8, "timoshenko"), 300.0)
    _, exudyn = found(ExudynEngine(arm, 8, "geometrically-exact"), 300.0)
    assert gaps(exudyn, reference).max() < 1e-3
