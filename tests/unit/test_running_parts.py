"""Parts of running linkages: their turns, orbits and bars, each against what defines it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexmech import ConstantSpeed, LinkPoint, Mechanism, ReferenceEngine, RotatingArm
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.dynamical_systems import VibrationState
from flexmech.linear_system import is_constant_turn, point_rows, whole
from flexmech.linkages import GROUND, AttachmentPoint, JointSpring, Load, Spring
from flexmech.time_domain import DrivenLinkage, LinkState, forced_linkage, nonlinear_orbit
from flexmech.time_domain.equations_of_motion.natural_coordinates import natural_links
from flexmech.time_domain.periodic_motion.orbit_equations import derivatives
from flexmech.time_domain.periodic_motion.shooting import simulated_orbit, turn_map
from tests.cross_engine.joined_linkages import QuickReturn, Ternary
from tests.cross_engine.test_exudyn_connectors import strips
from tests.cross_engine.test_exudyn_joints import FOUR_BAR

RIGID = Ternary(FOUR_BAR, rigid=("coupler",))


def test_a_bar_has_the_inertia_of_its_rigid_link() -> None:
    """Whatever part of it is on the rotation, which a spring in its joint asks for."""
    mechanism = strips(RIGID, joint_springs=(JointSpring("A", 0.1),))
    engine = ReferenceEngine(mechanism, 2, "euler", component_modes=False)
    _, links = natural_links(engine)
    number = engine.topology.index("coupler")
    products = []
    for model in (engine.links[number], links[number].model):
        own = model.fields
        fields = np.stack([own.along, own.across, own.tangential], axis=1)
        products.append(fields.T @ whole(model.mass) @ fields)
    assert links[number].model.size == 5
    np.testing.assert_allclose(products[1], products[0], rtol=1e-12, atol=1e-15)


def test_rates_of_an_orbit_are_those_of_its_displacements() -> None:
    """Of ends on a rigid link too, which turns by finite angles."""
    engine = ReferenceEngine(strips(RIGID), 2, "euler", component_modes=False)
    orbit = nonlinear_orbit(engine, 12.0, samples=512)
    first = derivatives(512, 12.0)[0]
    for place, rate in zip(orbit.displacement, orbit.rate, strict=True):
        np.testing.assert_allclose(rate, first @ place, rtol=0, atol=3e-5 * np.abs(rate).max())


def test_the_frame_of_a_displaced_rigid_link_has_its_own_speed() -> None:
    """The rate of its angle, by differences of fourth order between the samples of a turn."""
    engine = ReferenceEngine(strips(RIGID), 2, "euler")
    turn = LinkageSolver(engine, "equilibrium", 2).moving_modes(15.0).turn
    number, step = engine.topology.index("coupler"), turn.period / len(turn.motion.crank_angle)
    turned = turn.displaced.angle[:, number] - turn.motion.angle[:, number]
    near, far = (np.roll(turned, -n) - np.roll(turned, n) for n in (1, 2))
    rate = (8 * near - far) / (12 * step)
    own = turn.frame_speed[:, number] - turn.motion.angular_velocity[:, number]
    assert np.abs(rate).max() > 1e-4
    np.testing.assert_allclose(own, rate, rtol=0, atol=5e-2 * np.abs(rate).max())


@pytest.mark.parametrize(("axes", "constant"), [("link", True), ("ground", False)])
def test_a_force_that_turns_with_an_arm_is_constant_on_it(axes: str, constant: bool) -> None:
    load = Load("tip", AttachmentPoint("arm", 0.3), ((0.0, 1.0),), axes=axes)  # type: ignore[arg-type]
    arm = replace(strips(RotatingArm(0.3), loads=(load,)), gravity=(0.0, 0.0))
    engine = ReferenceEngine(arm, 2, "euler")
    motion = arm.linkage.motion(np.linspace(0.0, 6.0, 7), 10.0)
    assert is_constant_turn(engine, motion) is constant


def test_springs_are_in_the_static_answer_beyond_the_moving_modes() -> None:
    """With that of the moving modes it is the flexibility of the unreduced, sprung linkage."""
    spring = Spring(
        "s", AttachmentPoint(GROUND, 0.1, 0.3), AttachmentPoint("coupler", 0.1), 4e3, 0.1
    )
    hit, seen = LinkPoint("coupler", 0.4), LinkPoint("rocker", 0.5)
    mechanism: Mechanism = replace(strips(FOUR_BAR, springs=(spring,)), gravity=(0.0, 0.0))
    engine = ReferenceEngine(mechanism, 4, "euler")
    moving = LinkageSolver(engine, "none", 2).moving_modes(1e-3)
    motion = moving.turn.motion
    stressed = engine.stressed_links(motion, "none")
    connected = engine.connected_matrices(engine.frames, motion, "none", None)
    assert connected is not None
    forced = forced_linkage(moving, stressed, hit, seen, connected=connected.stiffness)
    count, size = len(motion.crank_angle), moving.size
    force, reading, rest = (
        part.samples(count) for part in (forced.force, forced.reading, forced.residual)
    )
    root = np.sqrt(moving.scale)
    slow = np.linalg.solve(moving.stiffness, (force[:, size:] * root)[..., None])[..., 0]
    found = rest + np.sum(reading[:, :size] * root * slow, axis=1)
    system = engine.unreduced().linear_system(motion.crank_angle, 0.0, prestress="none")
    into, out = (point_rows(system, point, "transverse") for point in (hit, seen))
    wanted = np.sum(out * np.linalg.solve(system.stiffness, into[..., None])[..., 0], axis=1)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-6 * np.abs(wanted).max())


def test_the_second_turn_of_a_simulation_closes_where_it_only_adds_a_constant() -> None:
    """To the motion of the linear equations: their map tells the start of the periodic one."""
    engine = ReferenceEngine(strips(FOUR_BAR), 2, "euler")
    linkage, steps = DrivenLinkage(engine, ConstantSpeed(20.0)), 720
    (monodromy, forced), n = turn_map(linkage, steps), linkage.size
    equations = linkage.equations(np.zeros(1))
    added = 0.05 * np.linalg.solve(np.eye(2 * n) - monodromy, forced)

    def simulated(start: LinkState) -> Any:
        end = monodromy @ np.concatenate(linkage.coordinates(start)) + forced + added
        state = VibrationState(end[None, :n], end[None, n:], np.zeros((1, n)))
        last = linkage.link_state(equations, state)
        places, rates = (
            [np.stack(pair) for pair in zip(*both, strict=True)]
            for both in ((start.displacement, last.displacement), (start.rate, last.rate))
        )
        return SimpleNamespace(displacement=places, rate=rates)

    orbit = simulated_orbit(linkage, steps, simulated)
    assert orbit.turns == 2
    assert orbit.closure < 1e-6


def test_rates_of_a_slide_are_found_back_from_the_state_that_they_made() -> None:
    """The turning of the frames moves the ends of the links besides, at which nothing slides."""
    engine = ReferenceEngine(strips(QuickReturn()), 2, "euler", component_modes=False)
    linkage = DrivenLinkage(engine, ConstantSpeed(20.0), "none")
    position, velocity = np.random.default_rng(0).normal(size=(2, linkage.size)) * [[1e-3], [1e-2]]
    vibration = VibrationState(position[None], velocity[None], 0 * position[None])
    state = linkage.link_state(linkage.equations(np.zeros(1)), vibration)
    for found, wanted in zip(linkage.coordinates(state), (position, velocity), strict=True):
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())
