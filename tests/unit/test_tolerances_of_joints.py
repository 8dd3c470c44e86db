"""Tolerances of joints and points of links: each test fails if its constant is another one."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from flexmech import ReferenceEngine
from flexmech.errors import ComputationError, InputError
from flexmech.linear_system.joints.rigid_pose import RigidPose
from flexmech.linear_system.links.rigid_body import RigidBody
from flexmech.linkages import (
    CouplerCurve,
    CouplerPoint,
    FourBar,
    LinkBody,
    PlanarJoint,
    RotatingArm,
    connection_forces,
    finite_double_points,
)
from flexmech.linkages.connection_forces import connection_matrix, solve_connections
from flexmech.linkages.linkage import continuous_angles
from flexmech.linkages.planar.dyads import TwoLoci
from tests.unit.test_rigid_pose import rigid_fourbar
from tests.unit.test_tolerances_of_linkages import (
    at_transmission_sine,
    drawn,
    drawn_four_bar,
    newton_group,
)

# --- rigid links that are displaced -------------------------------------------------------------


def poses(crank_turns, noise=0.0):
    """Poses of three rigid bars, what their joints miss in m, and how often that was computed.

    ``noise`` is what a joint misses by round-off, which changes its sign each time.
    """
    linkage = FourBar(1.0, 0.4, 0.99, 0.95)
    rigid, here = rigid_fourbar(linkage), linkage.motion(np.array([0.3]), 0.0)
    calls, sign = 0, 1.0

    class Counted(RigidPose):
        def _gap(self):
            nonlocal calls, sign
            calls, sign = calls + 1, -sign
            return super()._gap() + noise / 2 * sign

    found = []
    for turn in crank_turns:
        calls = 0
        pose = Counted.solve_position_constraints(rigid, here, np.array([[turn]]))
        found.append((pose, np.abs(RigidPose._gap(pose)).max(), calls))
    return found


def test_joints_of_rigid_links_close_to_round_off():
    """Newton's method ends at fifty times the unit round-off, not before it and not behind it."""
    assert max(gap for _, gap, _ in poses(np.linspace(0.2, 2.0, 60))) < 1.2e-14
    [(_, _, calls)] = poses([0.4], noise=4e-15)
    assert calls <= 8


def test_joints_that_round_off_keeps_open_close_to_nine_digits():
    [(pose, _, calls)] = poses([0.4], noise=3e-10)
    assert np.isfinite(pose.y).all()
    assert 15 < calls < 60
    [(pose, _, _)] = poses([0.4], noise=4e-9)
    assert np.isnan(pose.y).all()


def test_a_body_counts_as_off_the_axis_from_a_millionth_of_its_radius_of_gyration():
    radius = 0.02

    def body(part):
        return RigidBody.fixed(LinkBody(0.3, 0.5, 0.3 * radius**2, (0.0, part * radius)))

    assert body(3e-6).is_off_axis
    assert not body(3e-7).is_off_axis


# --- points of elastic links --------------------------------------------------------------------


@pytest.mark.parametrize("elements", [2, 500])
def test_rotations_inside_an_element_are_right_to_eight_digits(unit_arm, elements):
    """Of an axis that is a cubic, with few and with many elements."""
    readings = ReferenceEngine(unit_arm(100.0), elements, "euler").links[0].readings
    x = readings.nodes
    cubic = np.stack([0 * x, x**3, 3 * x**2], axis=1).ravel()
    for place in (0.05, 0.123, 0.31, 0.777, 0.93):
        assert readings.rotation_at(place) @ cubic == pytest.approx(3 * place**2, abs=1e-8)


# --- forces of joints ---------------------------------------------------------------------------


def test_equations_count_as_singular_below_nine_digits():
    """Of the conditions of all joints together, with one singular value that is small."""
    linkage = FourBar(0.9, 0.4, 1.0, 0.8)
    motion = linkage.motion(np.array([0.7]), 0.0)
    left, values, right = np.linalg.svd(connection_matrix(linkage.topology, motion)[0])

    def wrong(least):
        values[-1] = least * values[0]
        matrix = (left * values) @ right
        return connection_forces._what_is_wrong(linkage.topology, motion, matrix[None])

    assert wrong(4e-9) == ""
    assert "not held exactly once" in wrong(2.5e-10)


def test_forces_far_above_those_they_carry_are_looked_into(monkeypatch):
    """Levers do not make a hundred million; round-off in the place of zero makes more."""
    arm = RotatingArm(1.0)
    motion, unit = arm.motion(np.zeros(1), 0.0), np.ones((1, 3))
    monkeypatch.setattr(connection_forces, "_what_is_wrong", lambda *of: "looked into")
    for ratio in (2e7, 5e8):
        monkeypatch.setattr(
            connection_forces, "connection_matrix", lambda *of, r=ratio: np.eye(3)[None] / r
        )
        if ratio < 1e8:
            assert solve_connections(arm.topology, motion, unit)[0] == pytest.approx(-ratio)
        else:
            with pytest.raises(InputError, match="looked into"):
                solve_connections(arm.topology, motion, unit)


# --- coupler curves -----------------------------------------------------------------------------


def cusp_at(linkage, angle):
    """The coupler point that stands still at a crank angle: the coupler's instant centre."""
    motion = linkage.motion(angle, crank_speed=1.0)
    across, along = motion.origin_velocity[1]
    arm = complex(-along, across) / motion.angular_velocity[1] * np.exp(-1j * motion.angle[1])
    return CouplerPoint(abs(arm), float(np.angle(arm)))


def test_a_coupler_point_stands_still_below_a_billionth_of_the_linkage_a_radian():
    """Below it velocities, known to 1e-15, do not give the tangent to six digits."""
    linkage = FourBar(0.25, 0.1, 0.28, 0.27)
    point = cusp_at(linkage, 1.1)
    curve, size = CouplerCurve(linkage, point), linkage.crank + point.distance
    gain = np.hypot(*curve.second_derivative(1.1))
    moving, still = (1.1 + part * size / gain for part in (5e-9, 3e-10))
    # The tangent of a cusp is the direction in which the point is accelerated.
    first, second = curve.derivative(moving), curve.second_derivative(1.1)
    sine = (first[0] * second[1] - first[1] * second[0]) / np.hypot(*first) / gain
    assert abs(sine) < 1e-6
    assert np.isfinite(curve.curvature(moving))
    with pytest.raises(InputError, match="stands still"):
        curve.curvature(still)


def test_a_double_point_is_a_cusp_up_to_a_loop_as_small_as_round_off():
    """The margin of a double point grows with the distance of the coupler point from a cusp's."""
    linkage = FourBar(0.25, 0.1, 0.28, 0.27)
    cusp = cusp_at(linkage, 1.1)

    def nearest(away):
        point = CouplerPoint(cusp.distance * (1 + away), cusp.angle)
        return min(finite_double_points(linkage, point), key=lambda node: abs(node.margin))

    unit = nearest(1e-6).margin / 1e-6
    for margin, kind in ((4e-11, "cusp"), (-4e-11, "cusp"), (1e-9, "crunode"), (-1e-9, "acnode")):
        found = nearest(margin / unit)
        assert found.margin == pytest.approx(margin, rel=1e-3)
        assert found.kind == kind


# --- places that are one, positions that lock ---------------------------------------------------


def test_lengths_in_nine_digits_make_a_change_point():
    """Lengths are one within a billionth of them all, here 0.8 m."""
    assert FourBar(0.3 + 2e-10, 0.1, 0.2, 0.2).grashof_class == "change-point"
    assert FourBar(0.3 - 3e-9, 0.1, 0.2, 0.2).grashof_class != "change-point"


def test_a_linkage_locks_where_a_velocity_has_less_than_nine_digits():
    """Coupler and rocker are in line but for a millionth."""
    linkage = FourBar(0.25, 0.2, 0.21, 0.15)
    linkage.motion(at_transmission_sine(linkage, 5e-6))
    with pytest.raises(InputError, match="locks"):
        linkage.motion(at_transmission_sine(linkage, 2e-7))


# --- the way around a turn ----------------------------------------------------------------------


def test_angles_are_followed_past_a_dead_point_in_steps_of_half_a_degree():
    """A link that turns around while the crank turns by a degree and a half."""

    def angle(crank):
        turned = np.asarray(crank) - np.radians(200.75)
        return np.pi * np.tanh(turned / np.radians(0.8))[..., None]

    def motion(crank, speed=0.0):
        within = np.angle(np.exp(1j * angle(crank)))
        return SimpleNamespace(crank_angle=np.asarray(crank), angle=within)

    asked = np.radians([100.0, 195.0, 206.0, 300.0])
    found = continuous_angles(SimpleNamespace(motion=motion), motion(asked))
    turned = found[:, 0] - found[0, 0]
    assert turned == pytest.approx([0.0, 0.0, 2 * np.pi, 2 * np.pi], abs=1e-3)


def test_postures_are_found_from_guesses_that_miss_by_a_degree():
    """Those that are farther away may be others, on the far side of a dead point."""
    linkage = drawn_four_bar()
    group, known = newton_group(linkage), linkage._assembly._driven
    path, angle = group.trace_path(known), np.array([0.4])
    exact = group.motion(known(angle), angle, path)[2].turn
    near = replace(path, unknowns=path.unknowns + 0.01)
    assert group.motion(known(angle), angle, near)[2].turn == pytest.approx(exact, abs=1e-14)
    far = replace(path, unknowns=path.unknowns + 0.04)
    with pytest.raises(ComputationError, match="no position of coupler, rocker is found"):
        group.motion(known(angle), angle, far)


def test_lines_written_in_degrees_are_parallel_to_nine_digits():
    """A body that two parallel lines guide does not turn."""
    points = {"O2": 0, "A": 0.1j, "B": 0.3 + 0.05j, "C": 0.3, "D": 0.4}
    links = {"crank": "O2 A", "rod": "A B", "piston!": "B C D"}

    def is_guided(apart):
        sliders = [
            PlanarJoint("C", "slider", direction=0.0),
            PlanarJoint("D", "slider", direction=np.pi + apart),
        ]
        steps = drawn(points, links, "O2", *sliders)._assembly.steps
        return all(isinstance(step, TwoLoci) for step in steps)

    assert is_guided(3e-10)
    assert not is_guided(4e-9)


def test_links_of_new_lengths_are_joined_to_round_off(monkeypatch):
    """Newton's method ends where a step leaves the unit round-off of the size, and not later."""
    linkage, steps = drawn_four_bar(), []
    own = {link.name: link.length for link in linkage.topology.links}
    solve = np.linalg.lstsq
    monkeypatch.setattr(np.linalg, "lstsq", lambda *of, **by: steps.append(1) or solve(*of, **by))
    for factor in np.linspace(1.0, 1.3, 40):
        coupler = factor * own["coupler"]
        places = linkage.resized({**own, "coupler": coupler}, 1.0).points
        a, b, o4 = (complex(*places[name]) for name in ("A", "B", "O4"))
        assert abs(b - a) == pytest.approx(coupler, abs=4e-16)
        assert abs(b - o4) == pytest.approx(own["rocker"], abs=4e-16)
    assert len(steps) < 40 * 8
