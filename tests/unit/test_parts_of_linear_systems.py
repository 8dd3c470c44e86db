"""Parts of linear systems: stressed links, rigid links, engines' copies and what they say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np
import pytest

from flexmech import BeamSection, Material, Mechanism, ReferenceEngine, RotatingArm
from flexmech.analyses.frequencies.eigenproblem import solve_modes
from flexmech.arrays import FloatArray
from flexmech.linear_system import (
    RotationTerms,
    SparsePositions,
    StressedLinks,
    TheoryDifference,
    has_dampers,
    refuse_positions,
    whole,
)
from flexmech.linear_system.assembly.element_kinds import TheoryComparison
from flexmech.linear_system.joints.position_errors import RefusedPositionsError
from flexmech.linear_system.links.rigid_link import rigid_link
from flexmech.linkages import GROUND, AttachmentPoint, JointSpring, LinkMass, Spring
from flexmech.mechanism import AttachedBody
from tests.cross_engine.joined_linkages import QuickReturn
from tests.cross_engine.test_exudyn_connectors import strips
from tests.cross_engine.test_exudyn_joints import FOUR_BAR

BETWEEN = AttachmentPoint(GROUND, 0.1, 0.2), AttachmentPoint("coupler", 0.1)


def stressed(batch: int) -> StressedLinks:
    """One link of two coordinates with all that a state has."""
    random = np.random.default_rng(0)
    squares, vectors = ([random.normal(size=(batch, 2, 2))] for _ in range(2)), None
    tangent, damping = squares
    vectors = [[random.normal(size=(batch, 2))] for _ in range(3)]
    return StressedLinks(
        tangent, vectors[0], vectors[1], damping, vectors[2], random.normal(size=(batch, 1))
    )


def arrays(links: StressedLinks) -> dict[str, FloatArray]:
    """By name; lists have one array."""
    names = [field.name for field in fields(links) if field.name not in ("unstressed", "motion")]
    values = {name: getattr(links, name) for name in names}
    return {k: v[0] if isinstance(v, list) else v for k, v in values.items()}


def test_some_positions_have_all_of_a_state() -> None:
    whole = arrays(stressed(5))
    some = arrays(stressed(5).at(slice(1, 3)))
    assert some.keys() == whole.keys()
    for name, values in some.items():
        np.testing.assert_array_equal(values, whole[name][1:3])


def test_some_positions_have_their_motion() -> None:
    angles = np.linspace(0.0, 1.0, 5)
    whole = replace(stressed(5), motion=FOUR_BAR.motion(angles, np.ones(5)))
    some = whole.at(slice(1, 3)).motion
    assert some is not None
    np.testing.assert_array_equal(some.crank_angle, angles[1:3])


def test_a_repeated_position_has_all_of_a_state() -> None:
    one = arrays(stressed(1))
    for name, values in arrays(stressed(1).repeated(3)).items():
        np.testing.assert_array_equal(values, one[name][[0, 0, 0]])


def test_points_of_a_rigid_link_move_as_it_turns() -> None:
    """By the displacement of its start and the rotation times the distance from there."""
    readings = rigid_link("bar", LinkMass(0.3, 1.0)).readings
    moved = readings.displacement_at(np.array([0.0, 0.25, 1.0])) @ [0.01, -0.02, 0.1]
    np.testing.assert_allclose(moved[:, 0], 0.01)
    np.testing.assert_allclose(moved[:, 1], -0.02 + 0.1 * np.array([0.0, 0.075, 0.3]))


@pytest.mark.parametrize("element", ["euler", "timoshenko"])
def test_a_turning_section_keeps_the_centrifugal_potential_of_its_own_inertia(element: str) -> None:
    """Of a link that turns, the centrifugal mass leaves out that about centres of mass alone."""
    strip = BeamSection.rectangle(Material(69e9, 2700.0), 4e-3, 25e-3)
    eccentric = replace(strip, mass_axis=1.5e-3, layers=None)
    arm = Mechanism(RotatingArm(0.3), {"arm": eccentric})
    [link] = ReferenceEngine(arm, 3, element).links
    turn = link.fields.tangential
    about_centres = strip.rotary_inertia * 0.3 if element == "timoshenko" else 0.0
    left_out = turn @ (whole(link.mass) - whole(link.centrifugal_mass)) @ turn
    assert left_out == pytest.approx(about_centres, rel=1e-9, abs=1e-12)


def test_the_difference_of_two_theories_is_told_with_its_modes() -> None:
    """The greatest one over the angles, and from which mode on it is more than a hundredth."""
    by_theory = {
        "euler": np.array([[10.01, 20.4, 31.5], [10.0, 20.6, 30.9]]),
        "timoshenko": np.array([[10.0, 20.0, 30.0], [10.0, 20.0, 30.0]]),
    }
    found = TheoryComparison(by_theory.__getitem__, eccentric=False)
    assert found.difference("euler", "timoshenko") == TheoryDifference(pytest.approx(0.05), 3, 2)
    assert found.difference("euler", "euler") == TheoryDifference(0.0, 1, 0)


@pytest.mark.parametrize(
    "damper",
    [
        {"joint_springs": (JointSpring("A", torsional_damping=0.1),)},
        {"joint_springs": (JointSpring("A", radial_stiffness=1e5, radial_damping=1.0),)},
        {"springs": (Spring("s", *BETWEEN, 10.0, 0.1, 1.0),)},
    ],
)
def test_each_kind_of_damper_is_one(damper: dict[str, tuple[object, ...]]) -> None:
    assert has_dampers(strips(FOUR_BAR, **damper))
    assert not has_dampers(strips(FOUR_BAR, springs=(Spring("s", *BETWEEN, 10.0, 0.1),)))


def test_the_first_position_that_fails_is_named() -> None:
    motion = FOUR_BAR.motion(np.radians([0.0, 30.0, 60.0, 90.0]), 2.0)
    with pytest.raises(RefusedPositionsError, match="at crank angle 30 deg") as caught:
        refuse_positions(motion, np.array([False, True, False, True]), "it fails", "")
    np.testing.assert_allclose(np.degrees(caught.value.crank_angles), [30.0, 90.0])


def test_a_copy_of_an_engine_keeps_what_is_not_changed(aluminium: Mechanism) -> None:
    engine = ReferenceEngine(aluminium, 3, "timoshenko", False, 4, "free", "lumped")
    assert engine.with_() == engine
    assert engine.with_(elements=4) == ReferenceEngine(
        aluminium, 4, "timoshenko", False, 4, "free", "lumped"
    )


def test_links_that_bow_are_reduced_anew(aluminium: Mechanism) -> None:
    """After straight ones were, whose stretching need not follow a bow."""

    def frequencies(engine: ReferenceEngine) -> FloatArray:
        system = engine.linear_system([0.7], 20.0, modes=3, detail=1.0)
        return np.abs(np.linalg.eigvals(np.linalg.solve(system.mass[0], system.stiffness[0])))

    used, new = ReferenceEngine(aluminium, 4), ReferenceEngine(aluminium, 4)
    used.linear_system([0.7], 20.0, prestress="none", modes=3, detail=1.0)
    found, wanted = (np.sort(frequencies(engine))[:3] for engine in (used, new))
    np.testing.assert_allclose(found, wanted, rtol=1e-12)


@pytest.mark.parametrize(
    ("attached", "rigid_modes"),
    [
        (lambda: {}, 1),
        (lambda: {"joint_springs": (JointSpring("A", 0.1),)}, 0),
        (lambda: {"springs": (Spring("s", *BETWEEN, 10.0, 0.1),)}, 0),
        (lambda: {"joint_springs": (JointSpring("A", torsional_damping=0.1),)}, 1),
    ],
)
def test_springs_hold_a_free_shaft(
    attached: Callable[[], dict[str, object]], rigid_modes: int
) -> None:
    mechanism = replace(strips(FOUR_BAR, **attached()), gravity=(0.0, 0.0))
    assert ReferenceEngine(mechanism, 2, shaft="free").rigid_modes == rigid_modes


def test_coordinates_of_a_link_that_slides_are_found_back_from_all_displacements() -> None:
    """The slide is along the line as the displaced guide has it, whose line is off its pivot."""
    linkage = QuickReturn()
    engine = ReferenceEngine(strips(linkage), 2, "euler", component_modes=False)
    frames, motion = engine.frames, linkage.motion(np.array([0.7]))
    z = 1e-6 * np.random.default_rng(0).normal(size=(1, frames.size, 1))
    places = frames.link_coordinates(motion, z)
    np.testing.assert_allclose(frames.independent(motion, places), z, rtol=0, atol=1e-18)
    pose = frames.displaced_ties_by(motion, [q[..., 0] for q in places]).pose
    own = frames.rigid.independent_coordinates
    np.testing.assert_allclose(pose.y[:, own], z[:, : len(own), 0], rtol=0, atol=1e-10)


def test_a_position_at_rest_leaves_the_others_their_rotation_terms(aluminium: Mechanism) -> None:
    engine = ReferenceEngine(aluminium, 2, component_modes=False)
    both = engine.linear_system([0.7, 0.7], [0.0, 20.0], prestress="none")
    alone = engine.linear_system([0.7], [20.0], prestress="none")
    for name in ("damping", "stiffness"):
        exact = getattr(alone, name)[0]
        atol = 1e-12 * np.abs(exact).max()
        np.testing.assert_allclose(getattr(both, name)[1], exact, rtol=0, atol=atol)
    assert not both.damping[0].any()


def test_sparse_matrices_have_bodies_that_turn_with_their_sections() -> None:
    """As the whole ones have, about an equilibrium that bows the link."""
    body = AttachedBody("arm", 0.3, 0.25, 3e-4, (0.02, 0.06))
    strip = BeamSection.rectangle(Material(69e9, 2700.0), 2e-3, 25e-3)
    arm = Mechanism(RotatingArm(0.3), {"arm": strip}, bodies=(body,), gravity=(0.0, -9.81))
    engine = ReferenceEngine(arm, 4, "euler", component_modes=False)
    motion = arm.linkage.motion(np.array([0.3]), np.array([6.0]))
    stressed = engine.stressed_links(motion, "equilibrium")
    system = engine.linear_system([0.3], 6.0, stressed=stressed)
    sparse = SparsePositions(engine.frames, motion, stressed, RotationTerms()).at(0)
    for name in ("mass", "damping", "stiffness"):
        exact = getattr(system, name)[0]
        atol = 1e-12 * np.abs(exact).max()
        np.testing.assert_allclose(getattr(sparse, name).toarray(), exact, rtol=0, atol=atol)


def test_springs_bend_links_at_rest(aluminium: Mechanism) -> None:
    """So that frequencies at rest are those about an equilibrium."""
    springs = (Spring("s", *BETWEEN, 10.0, 0.1),)
    assert ReferenceEngine(strips(FOUR_BAR, springs=springs), 2).prestress_at_rest == "equilibrium"
    assert ReferenceEngine(aluminium, 2).prestress_at_rest == "none"


def test_damped_links_in_great_detail_answer_as_unreduced_ones(aluminium: Mechanism) -> None:
    """Without prestress, where damping resists that pins turn against the links they lead."""
    strip = BeamSection.rectangle(Material(69e9, 2700.0), 4e-3, 25e-3).with_damping_time(4e-4)
    mechanism = replace(aluminium, sections=dict.fromkeys(aluminium.sections, strip))
    engine, angles = ReferenceEngine(mechanism, 8, "euler"), np.radians([0.0, 90.0, 200.0])
    reduced, whole_links = (
        solve_modes(each.linear_system(angles, 20.0, prestress="none", modes=4, detail=detail), 4)
        for each, detail in ((engine, 4.0), (engine.unreduced(), None))
    )
    assert whole_links.damping_ratio.max() > 0.01
    for name in ("frequency", "damping_ratio"):
        exact = getattr(whole_links, name)
        np.testing.assert_allclose(getattr(reduced, name), exact, rtol=1e-6)
