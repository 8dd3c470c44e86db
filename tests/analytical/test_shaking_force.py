"""Shaking force and moment against the rate of momentum and angular momentum of the linkage.

With F and M on the frame, the frame puts -F and -M on the linkage, on which weight and loads act
besides: dP/dt = weight + loads - F, and dH/dt = their moments - M, about a point of the ground.
P and H are of positions and velocities alone, and their rates are those of the trigonometric
polynomial through a turn of them: neither accelerations nor joint forces are used.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flexmech
from flexmech import JointSpring, Load, Mechanism, Spring
from flexmech.analyses.shaking import shaking_of
from flexmech.linkages import GROUND, AttachmentPoint, RigidMotion
from flexmech.linkages.frame_forces import ShakingForce, shaft_axis, shaking_force

MODELS = Path(__file__).parents[2] / "models"
STEPS = 512
TURN = 2 * np.pi * np.arange(STEPS) / STEPS
SPEED = 20.0
POINT = (0.07, -0.11)
PUSH = np.array([3.0, -5.0])
TWIST = 0.4


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def rate(values: np.ndarray) -> np.ndarray:
    """Rate of what is periodic over a turn, (STEPS, ...)."""
    orders = np.fft.fftfreq(STEPS, 1 / STEPS)
    orders[STEPS // 2] = 0.0
    spectrum = np.fft.fft(values, axis=0)
    spectrum = spectrum * (1j * SPEED * orders).reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(np.fft.ifft(spectrum, axis=0).real)


def on_frame(mechanism: Mechanism, motion: RigidMotion) -> ShakingForce:
    """By momentum."""
    topology = mechanism.linkage.topology
    momentum, turning = np.zeros((STEPS, 2)), np.zeros(STEPS)
    force, moment = np.zeros((STEPS, 2)), np.zeros(STEPS)
    for number, link in enumerate(topology.link_names):
        own = mechanism.link_mass(link)
        mass, (x, y) = own.moment(0), own.centre
        place = motion.position(number, x, y) - POINT
        velocity = motion.velocity(number, x, y)
        momentum += mass * velocity
        turning += mass * cross(place, velocity)
        turning += own.central_inertia * motion.angular_velocity[:, number]
        weight = mass * np.broadcast_to(mechanism.gravity, place.shape)
        force += weight
        moment += cross(place, weight)
    for load in mechanism.loads:
        place = motion.position(topology.index(load.point.link), load.point.x) - POINT
        push = np.broadcast_to(PUSH, place.shape)
        force, moment = force + push, moment + cross(place, push) + TWIST
    return ShakingForce(force - rate(momentum), moment - rate(turning), POINT)


def loaded(name: str) -> Mechanism:
    """A model with gravity, a load, a spring to the ground and one between links."""
    model = flexmech.load_mechanism(MODELS / f"{name}.toml")
    topology = model.linkage.topology
    last, first = topology.links[-1], topology.links[0]
    load = Load("push", AttachmentPoint(last.name, 0.3 * last.length), (tuple(PUSH),), (TWIST,))
    to_ground = Spring(
        "to ground",
        AttachmentPoint(last.name, 0.6 * last.length),
        AttachmentPoint(GROUND, 0.4, -0.9),
        500.0,
        0.2,
        damping=3.0,
    )
    between = Spring(
        "between",
        AttachmentPoint(first.name, 0.9 * first.length),
        AttachmentPoint(last.name, 0.2 * last.length),
        300.0,
        0.0,
    )
    pivots = [JointSpring(pivot.joint, 4.0, 0.1, 0.2) for pivot in topology.pivots]
    return replace(
        model,
        gravity=(0.0, -9.81),
        loads=(load,),
        springs=(to_ground, between),
        joint_springs=tuple(pivots),
    )


@pytest.mark.parametrize(
    "name", ["aluminium_fourbar", "slider_crank", "stephenson_six_bar", "watt_six_bar"]
)
def test_it_is_the_rate_of_momentum(name: str) -> None:
    mechanism = loaded(name)
    motion = mechanism.linkage.motion(TURN, SPEED)
    found = shaking_of(mechanism, mechanism.inverse_dynamics(motion), POINT)
    wanted = on_frame(mechanism, motion)
    peak = np.abs(wanted.force).max()
    assert found.force == pytest.approx(wanted.force, abs=1e-12 * peak)
    assert found.moment == pytest.approx(wanted.moment, abs=1e-12 * np.abs(wanted.moment).max())


def test_a_line_on_a_link_puts_nothing_on_the_frame() -> None:
    """A quick-return linkage: the crank's pin slides on an arm that turns about O4."""
    linkage = flexmech.PlanarLinkage(
        points={"O2": (0.0, 0.0), "A": (0.05, 0.0), "O4": (0.0, -0.2), "C": (0.1, 0.2)},
        links=(
            flexmech.PlanarLink("crank", ("O2", "A"), rigid=True),
            flexmech.PlanarLink("arm", ("O4", "C"), rigid=True),
        ),
        ground=("O2", "O4"),
        joints=(
            flexmech.PlanarJoint("O2", "clamp"),
            flexmech.PlanarJoint("A", "slider", direction=0.0, guide="arm"),
        ),
    )
    bodies = (
        flexmech.AttachedBody("crank", 0.02, 0.3, 1e-4),
        flexmech.AttachedBody("arm", 0.2, 0.8, 5e-3, (0.0, 0.01)),
    )
    mechanism = Mechanism(linkage, {}, gravity=(0.0, -9.81), bodies=bodies)
    motion = linkage.motion(TURN, SPEED)
    found = shaking_of(mechanism, mechanism.inverse_dynamics(motion), POINT)
    wanted = on_frame(mechanism, motion)
    assert found.force == pytest.approx(wanted.force, abs=1e-12 * np.abs(wanted.force).max())
    assert found.moment == pytest.approx(wanted.moment, abs=1e-12 * np.abs(wanted.moment).max())


def test_a_displaced_slider_pushes_where_it_is() -> None:
    mechanism = flexmech.load_mechanism(MODELS / "slider_crank.toml")
    topology, motion = mechanism.linkage.topology, mechanism.linkage.motion(TURN, SPEED)
    forces = mechanism.inverse_dynamics(motion)
    joint_force = np.stack([forces.joint_force[name] for name in topology.joint_names], axis=1)
    moved = np.zeros((STEPS, 3))
    moved[:, 0] = 0.01 * np.cos(3 * TURN)
    asked = topology, motion, joint_force, forces.driving_torque, POINT
    found, still = (
        shaking_force(*asked, moved=displaced)
        for displaced in (lambda link, x: (moved, np.zeros_like(moved)), None)
    )
    push = -forces.joint_force["B"]
    assert found.force == pytest.approx(still.force, abs=1e-12)
    wanted = still.moment + moved[:, 0] * push[:, 1]
    assert np.abs(wanted - still.moment).max() > 1e-3 * np.abs(still.moment).max()
    assert found.moment == pytest.approx(wanted, abs=1e-12 * np.abs(wanted).max())


def test_the_clamped_end_of_an_arm_on_a_hub() -> None:
    """It lies beyond the axis of the shaft."""
    mechanism = flexmech.load_mechanism(MODELS / "rotating_arm.toml")
    mechanism = replace(mechanism, linkage=flexmech.RotatingArm(length=0.3, hub_radius=0.05))
    motion = mechanism.linkage.motion(TURN, SPEED)
    found = shaking_of(mechanism, mechanism.inverse_dynamics(motion), POINT)
    wanted = on_frame(mechanism, motion)
    assert found.force == pytest.approx(wanted.force, abs=1e-12 * np.abs(wanted.force).max())
    assert found.moment == pytest.approx(wanted.moment, abs=1e-12 * np.abs(wanted.moment).max())
    # Of an arm that turns steadily the force goes through the axis.
    axis = shaft_axis(mechanism.linkage.topology, motion)
    about = shaking_of(mechanism, mechanism.inverse_dynamics(motion), axis)
    assert np.abs(about.moment).max() < 1e-12 * np.abs(wanted.moment).max()


def test_an_accelerated_shaft_pushes_back_on_the_frame() -> None:
    """The drive turns crank and shaft, and the frame takes both torques with the other sign."""
    model = flexmech.load_mechanism(MODELS / "rotating_arm.toml")
    heavy = replace(model, shaft_inertia=0.3)
    asked = flexmech.KinematicsRequest(TURN[:4], SPEED, crank_acceleration=7.0)
    light, more = (flexmech.kinematics(each, asked).dataset for each in (model, heavy))
    wanted = light["shaking_moment"] - 0.3 * 7.0
    np.testing.assert_allclose(more["shaking_moment"], wanted, rtol=1e-12)
    assert "order" not in more  # states, and not a turn
    hub = model.linkage.topology.clamps[0].hub
    first, along, second = (model.link_mass("arm").moment(order) for order in (0, 1, 2))
    about_axis = second + 2 * hub * along + hub**2 * first
    np.testing.assert_allclose(light["shaking_moment"], -7.0 * about_axis, rtol=1e-12)


class TestHarmonics:
    def test_they_add_up_to_the_force(self) -> None:
        """Amplitudes and phases of a smooth force give it back, at other crank angles too."""
        mechanism = flexmech.load_mechanism(MODELS / "slider_crank.toml")
        angles = np.radians(np.arange(0.0, 361.0, 7.0))
        whole = flexmech.KinematicsRequest(np.radians([0.0, 90.0, 360.0]), 100.0)
        data = flexmech.kinematics(mechanism, whole).dataset
        orders = data["order"].values
        waves = np.cos(
            orders[:, None, None] * angles[:, None] + data["shaking_force_phase"].values[:, None]
        )
        built = np.sum(data["shaking_force_amplitude"].values[:, None] * waves, axis=0)
        wanted = shaking_of(
            mechanism, mechanism.inverse_dynamics(mechanism.linkage.motion(angles, 100.0))
        )
        # What is beyond order ten: the tenth itself is of that size.
        rest = data["shaking_force_order"].values[-1]
        assert 0 < rest < 1e-3 * np.abs(wanted.force).max()
        assert built == pytest.approx(wanted.force, abs=2 * rest)

    def test_the_size_of_an_order_is_the_long_axis_of_its_ellipse(self) -> None:
        mechanism = flexmech.load_mechanism(MODELS / "steel_fourbar.toml")
        data = flexmech.kinematics(mechanism, 20.0).dataset
        turn = np.linspace(0.0, 2 * np.pi, 100_001)[:, None]
        for n in (0, 1, 2, 5):
            wave = np.cos(n * turn + data["shaking_force_phase"].values[n])
            path = data["shaking_force_amplitude"].values[n] * wave
            size = np.linalg.norm(path, axis=1).max()
            assert float(data["shaking_force_order"][n]) == pytest.approx(size, rel=1e-8)

    def test_the_slider_crank_has_its_textbook_orders(self) -> None:
        """All mass at the wrist pin: cos, and (r / l) cos 2 but for the fourth power of r / l."""
        crank, rod, mass, speed = 0.05, 1.0, 0.3, 10.0
        linkage = flexmech.PlanarLinkage(
            points={"O": (0.0, 0.0), "A": (0.0, crank), "B": (np.sqrt(rod**2 - crank**2), 0.0)},
            links=(
                flexmech.PlanarLink("crank", ("O", "A"), rigid=True),
                flexmech.PlanarLink("rod", ("A", "B"), rigid=True),
            ),
            ground=("O",),
            joints=(
                flexmech.PlanarJoint("O", "clamp"),
                flexmech.PlanarJoint("B", "slider", direction=0.0),
            ),
        )
        mechanism = Mechanism(linkage, {}, joint_masses={"B": mass})
        data = flexmech.kinematics(mechanism, speed).dataset
        first = mass * crank * speed**2
        ratio = crank / rod
        x = data["shaking_force_amplitude"].sel(component="x").values
        assert x[1] == pytest.approx(first, rel=1e-12)
        assert x[2] == pytest.approx(first * (ratio + ratio**3 / 4 + 15 * ratio**5 / 128), rel=1e-7)
        assert np.abs(x[[0, 3, 5, 7]]).max() < 1e-12 * first
        assert np.abs(data["shaking_force_amplitude"].sel(component="y")).max() < 1e-12 * first
