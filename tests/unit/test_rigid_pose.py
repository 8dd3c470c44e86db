"""Rigid links and sliders that are displaced by finite amounts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from flexmech.linear_system.joints.joint_points import joint_points
from flexmech.linear_system.joints.rigid_coordinates import RigidCoordinates
from flexmech.linear_system.joints.rigid_pose import RigidPose
from flexmech.linkages import FourBar, Link, LinkEnd, Pin, Pivot, RigidMotion, Topology
from tests.unit.test_link_ties import Course, topologies

FloatArray = NDArray[np.float64]


def solved(
    topology: Topology, seed: int, scale: float
) -> tuple[RigidCoordinates, RigidMotion, FloatArray, RigidPose]:
    """A pose at random independent coordinates that is not near a locked one."""
    rigid, motion = RigidCoordinates(topology), Course(topology, seed).at(0.0)
    assume(len(rigid.independent_coordinates) > 0 and len(rigid.links) > 0)
    random = np.random.default_rng(seed)
    w = scale * random.normal(size=(1, len(rigid.independent_coordinates)))
    pose = RigidPose.solve_position_constraints(rigid, motion, w)
    assume(np.isfinite(pose.y).all() and np.abs(pose.coordinates).max() < 10)
    return rigid, motion, w, pose


@settings(max_examples=25, deadline=None)
@given(topologies(), st.integers(0, 1000))
def test_how_a_pose_can_move_is_its_derivative(topology: Topology, seed: int) -> None:
    rigid, motion, w, pose = solved(topology, seed, 0.02)
    # Near a dead point a difference over 1e-5 is off by 6e-6, and by the square of less.
    step = 1e-6
    points = [p for p in map(rigid.leader, joint_points(topology)) if p is not None]
    for number in range(w.shape[1]):
        ahead, back = (
            RigidPose.solve_position_constraints(
                rigid, motion, w + sign * step * np.eye(w.shape[1])[number]
            )
            for sign in (1, -1)
        )
        rate = (ahead.y - back.y)[0] / (2 * step)
        np.testing.assert_allclose(pose.coordinates[0, :, number], rate, atol=1e-6)
        for point in points:
            moved = (ahead.displacement([point]) - back.displacement([point]))[0, 0] / (2 * step)
            found = pose.rows([point])[0] @ pose.coordinates[0, :, number]
            np.testing.assert_allclose(found, moved, atol=1e-6)


@settings(max_examples=25, deadline=None)
@given(topologies(), st.integers(0, 1000))
def test_stiffness_is_the_second_derivative_of_the_work_of_dead_forces(
    topology: Topology, seed: int
) -> None:
    """Forces on points that lead flexible links, and on places of the rigid links."""
    rigid, motion, w, pose = solved(topology, seed, 0.02)
    random = np.random.default_rng(seed + 1)
    points = [p for p in map(rigid.leader, joint_points(topology)) if p is not None]
    at_points = {point: random.normal(size=(1, 2)) for point in points}
    # In the frame of each rigid link: a force, its place, and what is left as a generalized one.
    acting = {n: (random.normal(size=2), random.normal(size=2)) for n in rigid.links}

    def work(at: RigidPose) -> float:
        total = sum(float(np.sum(f * at.displacement([p])[:, 0])) for p, f in at_points.items())
        for link, (force, place) in acting.items():
            u, v, phi = at.y[0, rigid.of_link(link)]
            turn = np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]])
            total += float(force @ (np.array([u, v]) + turn @ place))
        return total

    forces = np.zeros_like(pose.y)
    virial = np.zeros((1, len(topology.links)))
    for link, (force, place) in acting.items():
        phi = pose.y[0, rigid.of_link(link)[2]]
        turned = np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]]) @ place
        lever = np.array([-turned[1], turned[0]])
        forces[0, rigid.of_link(link)] = [*force, force @ lever]
        virial[0, link] = force @ turned
    found = pose.geometric_stiffness(at_points, forces, virial)
    total = np.zeros((rigid.size, rigid.size))
    for link in rigid.links:
        total[rigid.of_link(link)[2], rigid.of_link(link)[2]] = found.rotation_stiffness[0, link]
    for number, slider in enumerate(topology.sliders):
        if slider.guide:
            turn = rigid.of_link(topology.index(slider.guide))[2]
            slide = 3 * len(rigid.links) + number
            total[turn, slide] = total[slide, turn] = found.guide_stiffness[0, number]
    matrix = pose.coordinates[0].T @ total @ pose.coordinates[0]
    count, step = w.shape[1], 1e-3
    numbers = np.eye(count)

    def at(a: int, b: int, i: float, j: float) -> float:
        moved = w + step * (i * numbers[a] + j * numbers[b])
        return work(RigidPose.solve_position_constraints(rigid, motion, moved))

    def second(a: int, b: int, h: float) -> float:
        if a == b:
            return (at(a, a, h, 0) - 2 * at(a, a, 0, 0) + at(a, a, -h, 0)) / (h * step) ** 2
        corners = at(a, b, h, h) - at(a, b, h, -h) - at(a, b, -h, h) + at(a, b, -h, -h)
        return corners / (2 * h * step) ** 2

    for a in range(count):
        for b in range(count):
            # Near a dead point the work is far from a parabola: what goes with the step's
            # square is taken off.
            derivative = (4 * second(a, b, 0.5) - second(a, b, 1)) / 3
            scale = 1 + np.abs(matrix).max() * 10
            assert matrix[a, b] == pytest.approx(-derivative, abs=1e-4 * scale)


def test_a_bar_in_tension_resists_with_its_force_over_its_length() -> None:
    """A rigid bar between a pivot and a flexible end that pulls it along."""
    length, pull = 0.4, 30.0
    topology = Topology(
        (Link("bar", length, rigid=True), Link("rope", 0.3)),
        pivots=(Pivot("O", LinkEnd("bar", "start")),),
        pins=(Pin("A", LinkEnd("bar", "end"), LinkEnd("rope", "start")),),
    )
    rigid, motion = RigidCoordinates(topology), Course(topology, 2).at(0.0)
    pose = RigidPose.solve_position_constraints(rigid, motion, np.zeros((1, 1)))
    angle = motion.angle[0, 0]
    force = pull * np.array([[np.cos(angle), np.sin(angle)]])
    point = next(p for p in map(rigid.leader, joint_points(topology)) if p is not None)
    found = pose.geometric_stiffness({point: force}, np.zeros((1, 3)), np.zeros((1, 2)))
    assert found.rotation_stiffness[0, 0] / length**2 == pytest.approx(pull / length, rel=1e-12)


def rigid_fourbar(linkage: FourBar) -> RigidCoordinates:
    """Three rigid bars whose crank turns freely."""
    topology = linkage.topology
    pivots = tuple(Pivot(clamp.joint, clamp.link_end) for clamp in topology.clamps)
    links = tuple(replace(link, rigid=True) for link in topology.links)
    return RigidCoordinates(
        replace(topology, links=links, clamps=(), pivots=(*pivots, *topology.pivots))
    )


def test_bars_that_turn_far_are_where_the_linkage_is() -> None:
    linkage = FourBar(0.3, 0.1, 0.25, 0.2)
    rigid, here = rigid_fourbar(linkage), linkage.motion(np.array([0.3]), 0.0)
    turned = linkage.motion(np.array([1.7]), 0.0).angle - here.angle
    (independent,) = rigid.independent_coordinates
    assert independent % 3 == 2
    w = turned[:, [independent // 3]]
    pose = RigidPose.solve_position_constraints(rigid, here, w)
    np.testing.assert_allclose(pose.y[:, 2::3], turned, rtol=0, atol=1e-13)


def test_bars_out_of_reach_have_no_place() -> None:
    """The other two bars are together too short for the crank to turn further."""
    linkage = FourBar(0.3, 0.25, 0.1, 0.15)
    rigid, here = rigid_fourbar(linkage), linkage.motion(np.array([0.5, 0.5]), 0.0)
    pose = RigidPose.solve_position_constraints(rigid, here, np.array([[1.5], [-0.1]]))
    assert np.isnan(pose.y[0]).all()
    assert np.isfinite(pose.y[1]).all()
