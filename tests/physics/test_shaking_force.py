"""Shaking force and moment: rates of momentum, orders of a slider-crank, an elastic run's mean.

With F and M on the frame, the frame puts -F and -M on the linkage, on which weight and loads act
besides: dP/dt = weight + loads - F, and dH/dt = their moments - M, about a point of the ground.
P and H are of positions and velocities alone, and their rates are those of the trigonometric
polynomial through a turn of them: neither accelerations nor joint forces are used.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import simpson

from flexmech import (
    AttachedBody,
    ExudynEngine,
    JointSpring,
    Load,
    Mechanism,
    MotorDrive,
    ReferenceEngine,
    RotatingArm,
    Spring,
    TorqueMotor,
    example_model,
    kinematics,
    load_mechanism,
    response,
)
from flexmech.analyses import KinematicsRequest, ResponseRequest
from flexmech.linkages import GROUND, AttachmentPoint
from tests.support.mechanisms import quick_return, slider_crank
from tests.support.sprung_frame_data import stiffened
from tests.support.strategies import fourbar

STEPS = 256
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


def by_momentum(mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray]:
    """Force on the frame, (STEPS, 2), and its moment about the point, (STEPS,)."""
    topology, motion = mechanism.linkage.topology, mechanism.linkage.motion(TURN, SPEED)
    momentum, turning = np.zeros((STEPS, 2)), np.zeros(STEPS)
    force, moment = np.zeros((STEPS, 2)), np.zeros(STEPS)
    for number, link in enumerate(topology.link_names):
        own = mechanism.link_mass(link)
        mass, (x, y) = own.moment(0), own.centre
        place, velocity = motion.position(number, x, y) - POINT, motion.velocity(number, x, y)
        momentum += mass * velocity
        turning += mass * cross(place, velocity)
        turning += own.central_inertia * motion.angular_velocity[:, number]
        weight = mass * np.broadcast_to(mechanism.gravity, place.shape)
        force, moment = force + weight, moment + cross(place, weight)
    for load in mechanism.loads:
        place = motion.position(topology.index(load.point.link), load.point.x) - POINT
        push = np.broadcast_to(PUSH, place.shape)
        force, moment = force + push, moment + cross(place, push) + TWIST
    return force - rate(momentum), moment - rate(turning)


def loaded(name: str) -> Mechanism:
    """A model with weight, a load, a spring to the ground, one between links, some in joints."""
    model = load_mechanism(example_model(name))
    topology = model.linkage.topology
    last, first = topology.links[-1], topology.links[0]
    load = Load("push", AttachmentPoint(last.name, 0.3 * last.length), (tuple(PUSH),), (TWIST,))
    far, near = (AttachmentPoint(last.name, part * last.length) for part in (0.6, 0.2))
    springs = (
        Spring("to ground", far, AttachmentPoint(GROUND, 0.4, -0.9), 500.0, 0.2, damping=3.0),
        Spring("between", AttachmentPoint(first.name, 0.9 * first.length), near, 300.0, 0.0),
    )
    pivots = tuple(JointSpring(pivot.joint, 4.0, 0.1, 0.2) for pivot in topology.pivots)
    return replace(
        model, gravity=(0.0, -9.81), loads=(load,), springs=springs, joint_springs=pivots
    )


def slotted() -> Mechanism:
    """A line on a lever puts nothing on the frame."""
    linkage = quick_return()
    linkage = replace(linkage, links=tuple(replace(link, rigid=True) for link in linkage.links))
    bodies = (
        AttachedBody("crank", 0.02, 0.3, 1e-4),
        AttachedBody("lever", 0.2, 0.8, 5e-3, (0, 0.01)),
    )
    return Mechanism(linkage, {}, gravity=(0.0, -9.81), bodies=bodies)


def on_a_hub() -> Mechanism:
    """The clamped end of the arm lies beyond the axis of the shaft."""
    model = load_mechanism(example_model("rotating_arm"))
    return replace(model, linkage=RotatingArm(length=0.3, hub_radius=0.05))


MECHANISMS = {
    "four-bar": lambda: loaded("aluminium_fourbar"),
    "slider-crank": lambda: loaded("slider_crank"),
    "six-bar": lambda: loaded("watt_six_bar"),
    "slotted lever": slotted,
    "arm on a hub": on_a_hub,
}


@pytest.mark.parametrize("make", MECHANISMS.values(), ids=MECHANISMS)
def test_it_is_the_rate_of_momentum(make: object) -> None:
    mechanism = make()  # type: ignore[operator]
    data = kinematics(mechanism, SPEED, crank_angles=TURN, moment_point=POINT).dataset
    force, moment = by_momentum(mechanism)
    np.testing.assert_allclose(data["shaking_force"], force, atol=1e-12 * np.abs(force).max())
    np.testing.assert_allclose(data["shaking_moment"], moment, atol=1e-12 * np.abs(moment).max())


def test_an_accelerated_shaft_pushes_back_on_the_frame() -> None:
    """By minus the moment of inertia about the shaft times the acceleration."""
    mechanism = replace(on_a_hub(), shaft_inertia=0.3)
    asked = KinematicsRequest(SPEED, crank_angles=TURN[:4], crank_acceleration=7.0)
    heavy = kinematics(mechanism, asked)
    light = kinematics(replace(mechanism, shaft_inertia=0.0), asked).dataset
    more = heavy.dataset["shaking_moment"] - light["shaking_moment"]
    np.testing.assert_allclose(more, -0.3 * 7.0, rtol=1e-12)
    first, along, second = (mechanism.link_mass("arm").moment(order) for order in (0, 1, 2))
    about_axis = second + 2 * 0.05 * along + 0.05**2 * first
    np.testing.assert_allclose(light["shaking_moment"], -7.0 * about_axis, rtol=1e-12)
    np.testing.assert_allclose(light["driving_torque"], 7.0 * about_axis, rtol=1e-12)
    assert "order" not in heavy.dataset  # states, and not a turn


def test_a_slider_crank_has_its_textbook_orders() -> None:
    """All mass at the wrist pin: cos, and (r / l) cos 2 but for higher powers of r / l."""
    crank, rod, mass, speed = 0.05, 1.0, 0.3, 10.0
    linkage = slider_crank("crank", "rod", crank=crank, rod=rod, offset=0.0)
    data = kinematics(Mechanism(linkage, {}, joint_masses={"B": mass}), speed).dataset
    first, ratio = mass * crank * speed**2, crank / rod
    x = data["shaking_force_amplitude"].sel(component="x").values
    assert x[1] == pytest.approx(first, rel=1e-12)
    assert x[2] == pytest.approx(first * (ratio + ratio**3 / 4 + 15 * ratio**5 / 128), rel=1e-7)
    assert np.abs(x[[0, 3, 5, 7]]).max() < 1e-12 * first
    assert np.abs(data["shaking_force_amplitude"].sel(component="y")).max() < 1e-12 * first


def waves(data: xr.Dataset, angles: np.ndarray) -> np.ndarray:
    """Each order of the shaking force at crank angles, (order, angle, component)."""
    turned = data["order"].values[:, None, None] * angles[:, None]
    phase = data["shaking_force_phase"].values[:, None]
    return data["shaking_force_amplitude"].values[:, None] * np.cos(turned + phase)


def test_orders_add_up_to_the_force_whatever_angles_are_asked_for() -> None:
    mechanism = load_mechanism(example_model("slider_crank"))
    asked = KinematicsRequest(100.0, crank_angles=np.radians([0.0, 90.0, 360.0]))
    data = kinematics(mechanism, asked).dataset
    angles = np.radians(np.arange(0.0, 361.0, 7.0))
    force = kinematics(mechanism, 100.0, crank_angles=angles).dataset["shaking_force"].values
    # Orders beyond ten are of the size of the tenth.
    rest = data["shaking_force_order"].values[-1]
    assert 0 < rest < 1e-3 * np.abs(force).max()
    assert waves(data, angles).sum(axis=0) == pytest.approx(force, abs=2 * rest)
    # The size of an order is the long axis of its ellipse.
    fine = waves(data, np.linspace(0.0, 2 * np.pi, 20_001))
    sizes = np.linalg.norm(fine, axis=-1).max(axis=1)
    assert data["shaking_force_order"].values == pytest.approx(sizes, rel=1e-6)


def test_orders_of_a_linkage_with_sharp_peaks_have_no_alias() -> None:
    """Against ten times as many steps; the tenth order is a hundredth of the first and more."""
    linkage = replace(fourbar().linkage, crank=0.1325, coupler=0.1525)
    mechanism = fourbar(linkage)
    angles = 2 * np.pi * np.arange(7200) / 7200
    fine = kinematics(mechanism, SPEED, crank_angles=angles).dataset["shaking_force"].values
    spectrum = np.fft.fft(fine @ [1, 1j]) / len(angles)
    orders = np.arange(11)
    # A rotating pair of arrows: the long axis is the sum of their lengths.
    size = abs(spectrum[orders]) + abs(spectrum[-orders])
    size[0] /= 2
    assert size[10] > 1e-2 * size[1]
    data = kinematics(mechanism, SPEED).dataset
    assert data["shaking_force_order"].values == pytest.approx(size, rel=1e-8)


def sprung() -> Mechanism:
    """The aluminium four-bar with weight, a load, and a spring and damper to the ground."""
    middle = AttachmentPoint("coupler", 0.14)
    pull = Spring("pull", middle, AttachmentPoint(GROUND, 0.1, 0.5), 100.0, 0.3, damping=1.0)
    load = Load("push", AttachmentPoint("rocker", 0.2), ((1.0, -2.0),))
    return replace(fourbar(), gravity=(0.0, -9.81), springs=(pull,), loads=(load,))


def test_the_mean_over_a_turn_of_elastic_links_is_weight_and_loads() -> None:
    """Over a turn of periodic motion momentum comes back to itself."""
    mechanism = sprung()
    asked = ResponseRequest(SPEED, 1.0, samples=180, start="periodic", prestress="axial")
    data = response(ReferenceEngine(mechanism, 4), asked).dataset.isel(engine=0)
    mass = sum(own.moment(0) for own in mechanism.link_masses_in_order)
    weight = mass * np.array(mechanism.gravity) + (1.0, -2.0)
    peak = float(np.linalg.norm(data["shaking_force"].values, axis=-1).max())
    rigid = data["rigid_shaking_force"].values[1:].mean(axis=0)
    assert rigid == pytest.approx(weight, abs=1e-12 * peak)
    # Linear equations are off by the square of the deflections: 5 mm of 280 mm here.
    assert float(abs(data["deflection"]).max()) > 4e-3
    assert data["shaking_force"].values[1:].mean(axis=0) == pytest.approx(weight, abs=1e-3 * peak)


def test_the_shaft_of_a_run_up_pushes_back() -> None:
    light, heavy = fourbar(), replace(fourbar(), shaft_inertia=0.05)
    asked = ResponseRequest(SPEED, 0.1, samples=40, run_up_time=0.1, prestress="none", step=5e-4)
    runs = [
        response(ReferenceEngine(each, 1), asked).dataset.isel(engine=0) for each in (light, heavy)
    ]
    torque = 0.05 * asked.drive.crank_acceleration(runs[0]["time"].values)
    for name in ("shaking_moment", "rigid_shaking_moment"):
        more = (runs[1][name] - runs[0][name]).values
        np.testing.assert_allclose(more, -torque, atol=1e-9 * np.abs(torque).max())


COUPLINGS = ({}, {"coupling_stiffness": 40.0, "coupling_damping": 0.05})


@pytest.mark.parametrize("coupling", COUPLINGS, ids=["rigid", "on a coupling"])
def test_a_frame_bears_the_angular_momentum_of_a_rotor_behind_a_gear(
    coupling: dict[str, float],
) -> None:
    """An arm and its shaft of inertia I, speed theta', rotor at n psi': -d(I theta' + n J psi')/dt.

    With the n^2 J that the crank feels it was four times as great, and without the rotor a fifth.
    """
    ratio, rotor = 5.0, 4e-3
    motor = TorqueMotor((0.0, 150.0), (0.6, 0.0), gear_ratio=ratio, inertia=rotor, **coupling)
    model = load_mechanism(example_model("rotating_arm"))
    arm = replace(model, gravity=(0.0, 0.0), linkage=RotatingArm(0.3), shaft_inertia=2e-3)
    arm = stiffened(replace(arm, drive=MotorDrive(motor, time=0.1)), 30.0)
    inertia = 2e-3 + float(arm.link_masses_in_order[0].moment(2))
    asked = ResponseRequest(arm.drive, start="rigid", samples=2000, modes=1, step=5e-5)
    runs = [kinematics(arm).dataset]
    runs += [
        response(make(arm, 2), asked).dataset.isel(engine=0)
        for make in (ReferenceEngine, ExudynEngine)
    ]
    for data in runs:
        speed = data["crank_speed_over_time"] + data.get("crank_speed_fluctuation", 0.0)
        momentum = (inertia * speed + rotor * data["motor_speed"]).values
        given = simpson(data["shaking_moment"].values, x=data["time"].values)
        assert given == pytest.approx(momentum[0] - momentum[-1], rel=5e-4)
        of_rigid = data.get("rigid_shaking_moment", data["shaking_moment"])
        wanted = np.interp(data["time"], runs[0]["time"], runs[0]["shaking_moment"])
        assert of_rigid.values == pytest.approx(wanted, abs=1e-4 * np.abs(wanted).max())
