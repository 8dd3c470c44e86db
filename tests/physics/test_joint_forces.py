"""Joint forces, internal forces and driving torque by hand, and structures that are not held."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import (
    AttachedBody,
    InputError,
    Load,
    Mechanism,
    RotatingArm,
    Spring,
    example_model,
    kinematics,
    load_mechanism,
)
from flexmech.analyses import KinematicsRequest
from flexmech.linkages import (
    GROUND,
    AttachmentPoint,
    Clamp,
    InverseDynamics,
    Link,
    LinkEnd,
    LinkMass,
    Pin,
    Pivot,
    RigidMotion,
    Slider,
    Topology,
    Weld,
    inverse_dynamics,
)
from tests.support.mechanisms import quick_return
from tests.support.strategies import arm, fourbar

ARM = RotatingArm(1.0)


def on_arm(motion: RigidMotion, mass: LinkMass, **acting: object) -> InverseDynamics:
    return inverse_dynamics(ARM.topology, motion, (mass,), **acting)  # type: ignore[arg-type]


def resting(angles: list[float], origins: list[list[float]]) -> RigidMotion:
    """Links at rest."""
    zero = np.zeros((len(angles), 2))
    turning = np.zeros(len(angles))
    at = np.array(angles), turning, turning, np.array(origins), zero, zero
    return RigidMotion(np.asarray(0.0), np.asarray(0.0), *at)


@pytest.mark.parametrize("hub", [0.0, 0.5])
def test_tension_and_torque_of_a_rotating_arm(hub: float) -> None:
    """A slender arm: rho omega^2 int r dr beyond x, and alpha rho int r^2 dr."""
    length, rho, speed, alpha = 2.0, 1.5, 10.0, 7.0
    linkage = RotatingArm(length, hub)
    motion = linkage.motion(np.linspace(0, 6, 5), speed, alpha)
    forces = inverse_dynamics(linkage.topology, motion, (LinkMass(length, rho),))
    for x in (0.0, 0.7, 2.0):
        tension = rho * speed**2 * ((length**2 - x**2) / 2 + hub * (length - x))
        assert forces.axial_force(0, x) == pytest.approx(tension, abs=1e-10)
    torque = alpha * rho * ((hub + length) ** 3 - hub**3) / 3
    assert forces.driving_torque == pytest.approx(torque, rel=1e-12)


def test_the_shaft_holds_an_arms_weight() -> None:
    linkage, mass = RotatingArm(2.0, 0.5), LinkMass(2.0, 1.5, (2.0,), (4.0,))
    forces = inverse_dynamics(linkage.topology, linkage.motion(0.0), (mass,), (0.0, -9.81))
    assert forces.joint_force["O2"] == pytest.approx([0.0, 7 * 9.81], abs=1e-12)
    assert forces.driving_torque == pytest.approx(9.81 * (3 * 1.5 + 4 * 2.5))


def test_beyond_a_point_mass_an_arm_carries_nothing() -> None:
    forces = on_arm(ARM.motion(0.3, 5.0), LinkMass(1.0, 0.0, (0.6,), (2.0,)))
    tension = forces.axial_force(0, np.array([0.59, 0.6, 0.61]))
    assert tension == pytest.approx([2.0 * 0.6 * 25, 2.0 * 0.6 * 25, 0.0], abs=1e-12)


def test_beyond_a_load_an_arm_carries_nothing() -> None:
    load = Load("pull", AttachmentPoint("arm", 0.6), ((3.0, 2.0),), (0.5,))
    forces = on_arm(ARM.motion(0.0), LinkMass(1.0, 0.0), loads=(load,))
    x = np.array([0.0, 0.59, 0.61, 0.9])
    inside = np.array([1.0, 1.0, 0.0, 0.0])
    assert forces.axial_force(0, x) == pytest.approx(3.0 * inside, abs=1e-15)
    assert forces.shear_force(0, x) == pytest.approx(2.0 * inside, abs=1e-15)
    moment = (2.0 * (0.6 - x) + 0.5) * inside
    assert forces.bending_moment(0, x) == pytest.approx(moment, abs=1e-15)
    assert forces.driving_torque == pytest.approx(-2.0 * 0.6 - 0.5)


def test_the_weld_of_an_l_beam_carries_the_moment_of_its_second_arm() -> None:
    """Weight of a horizontal arm of 0.4 m and 5 kg/m on an upright one of 2 m and 3 kg/m."""
    weld = Weld("B", LinkEnd("arm", "end"), LinkEnd("second", "start"))
    links = (Link("arm", 2.0), Link("second", 0.4))
    topology = Topology(links, (Clamp("O2", LinkEnd("arm", "start")),), welds=(weld,))
    motion = resting([np.pi / 2, 0.0], [[0.0, 0.0], [0.0, 2.0]])
    masses = (LinkMass(2.0, 3.0), LinkMass(0.4, 5.0))
    forces = inverse_dynamics(topology, motion, masses, (0.0, -10.0))
    assert forces.joint_force["B"] == pytest.approx([0.0, 20.0])
    for joint in ("B", "O2"):
        assert forces.joint_moment[joint] == pytest.approx(20 * 0.2)
    assert forces.bending_moment(1, 0.1) == pytest.approx(-5 * 10 * 0.3**2 / 2)
    assert forces.shear_force(1, 0.1) == pytest.approx(-5 * 10 * 0.3)
    assert forces.bending_moment(0, 1.0) == pytest.approx(-20 * 0.2)
    assert forces.axial_force(0, 0.5) == pytest.approx(-20 - 3 * 10 * 1.5)


def test_a_spring_pulls_along_its_line_and_its_damper_against_its_rate() -> None:
    """From the tip of an arm to a point of the ground, in N/m, N s/m and m."""
    place = AttachmentPoint(GROUND, 0.3, 1.4)
    spring = Spring("return", AttachmentPoint("arm", 1.0), place, 50.0, 0.2, 3.0)
    angle, speed = 0.4, 5.0
    forces = on_arm(ARM.motion(angle, speed), LinkMass(1.0, 0.0), springs=(spring,))
    tip = np.exp(1j * angle)
    away = 0.3 + 1.4j - tip
    along = away / abs(away)
    pull = 50.0 * (abs(away) - 0.2) + 3.0 * (-(1j * speed * tip) * along.conjugate()).real
    torque = (tip.conjugate() * pull * along).imag
    assert forces.driving_torque == pytest.approx(-torque, rel=1e-13)


@pytest.mark.parametrize("free_length", [0.0, 0.1])
def test_a_spring_whose_ends_meet_has_a_direction_without_free_length_alone(
    free_length: float,
) -> None:
    ends = AttachmentPoint("arm", 1.0), AttachmentPoint(GROUND, 0.0, 1.0)
    spring, motion = Spring("return", *ends, 5.0, free_length), ARM.motion([0.0, np.pi / 2])
    if free_length:
        with pytest.raises(InputError, match="spring return: its ends meet at crank angle 90 deg"):
            on_arm(motion, LinkMass(1.0, 0.0), springs=(spring,))
        return
    forces = on_arm(motion, LinkMass(1.0, 0.0), springs=(spring,))
    assert forces.driving_torque == pytest.approx([-5.0, 0.0], abs=1e-12)


def test_a_load_over_time_begins_at_crank_angle_zero() -> None:
    """A crank that accelerates is at its angle at no known time."""
    tip = AttachmentPoint("arm", 1.0)
    forces = ((0.0, 0.0), (0.0, 10.0))
    ramp = Load("ramp", tip, forces, (0.0, 0.0), "link", "time", (0.0, 1.0))
    loaded = replace(arm(), loads=(ramp,))
    data = kinematics(loaded, 2.0, crank_angles=[0.0, 1.0, 4.0]).dataset
    assert data["driving_torque"].values == pytest.approx([0.0, -5.0, -10.0], abs=1e-9)
    accelerated = KinematicsRequest(2.0, crank_angles=[0.5], crank_acceleration=1.0)
    with pytest.raises(InputError, match="crank_acceleration: the load ramp goes over time"):
        kinematics(loaded, accelerated)
    over_angle = replace(arm(), loads=(replace(ramp, over="crank_angle"),))
    torque = kinematics(over_angle, accelerated).dataset["driving_torque"].values
    bare = kinematics(arm(), accelerated).dataset["driving_torque"].values
    assert torque - bare == pytest.approx([-5.0])


def test_a_body_beside_its_link_counts_by_its_place_and_inertia() -> None:
    """On rigid links without matter of their own; the moment is about the centre of the bodies."""
    first, second = (
        AttachedBody("arm", 0.4, 2.0, 0.03),
        AttachedBody("arm", 0.9, 0.5, 0.01, (0.1, 0.2)),
    )
    linkage = quick_return()
    linkage = replace(linkage, links=tuple(replace(link, rigid=True) for link in linkage.links))
    bodies = tuple(replace(body, link="crank", position=0.05) for body in (first, second))
    data = kinematics(
        Mechanism(linkage, {}, bodies=bodies), 4.0, crank_angles=[0.3], crank_acceleration=9.0
    ).dataset.isel(crank_angle=0)
    centre = (2.0 * 0.05 + 0.5 * (0.15 + 0.2j)) / 2.5
    on_crank = data.sel(link="crank")
    expected = centre * np.exp(0.3j)
    assert on_crank["centre_position"].values @ [1, 1j] == pytest.approx(expected, rel=1e-13)
    force = -2.5 * expected * (9.0j - 16.0)
    assert on_crank["inertia_force"].values @ [1, 1j] == pytest.approx(force, rel=1e-13)
    apart = 2.0 * abs(0.05 - centre) ** 2 + 0.5 * abs(0.15 + 0.2j - centre) ** 2
    moment = -9.0 * (0.03 + 0.01 + apart)
    assert float(on_crank["inertia_moment"]) == pytest.approx(moment, rel=1e-13)


def test_both_joint_forces_weight_and_inertia_of_a_rod_are_in_balance() -> None:
    """The forces of crank and line are those on the rod, and the line's are across it."""
    mechanism = load_mechanism(example_model("slider_crank"))
    data = kinematics(mechanism).dataset
    acting = data["joint_force"].sel(joint=["A", "B"]).sum("joint")
    inertia = data["inertia_force"].sel(link="rod")
    weight = mechanism.link_mass("rod").moment(0) * np.asarray(mechanism.gravity)
    left = acting + inertia + weight[None]
    assert float(abs(left).max()) < 1e-9 * float(abs(inertia).max())
    line = abs(data["joint_force"].sel(joint="B"))
    assert float(line.sel(component="x").max()) < 1e-12 * float(line.sel(component="y").max())


@pytest.mark.parametrize("lumped", [True, False])
def test_without_loads_the_mean_power_of_a_turn_is_zero(lumped: bool) -> None:
    """At steps of 60 degrees, whose own mean is far from it; of whole turns alone."""
    angles = np.radians(np.arange(0.0, 361.0, 60.0))
    asked = KinematicsRequest(20.0, crank_angles=angles, lumped=(1, 4, 4) if lumped else None)
    result = kinematics(fourbar(), asked)
    assert abs(result.dataset["driving_power"].values[:-1].mean()) > 0.1
    (mean,) = (one.value for one in result.summary().numbers if one.name == "mean_driving_power")
    assert abs(mean) < 1e-9
    half = kinematics(fourbar(), 20.0, crank_angles=angles[:4]).summary()
    assert not any(one.name == "mean_driving_power" for one in half.numbers)


def test_a_corner_of_a_load_between_the_degrees_is_the_greatest_torque() -> None:
    """The extremes are sought between the samples, and their error is stated."""
    corner = np.radians(100.37)
    table = ((0.0, 0.0), (0.0, 10.0), (0.0, 0.0))
    places = (0.0, float(corner), float(np.radians(300.0)))
    load = Load(
        "push", AttachmentPoint("arm", 1.0), table, (0, 0, 0), "link", "crank_angle", places
    )
    data = kinematics(replace(arm(), loads=(load,)), 5.0).dataset
    torque = data.isel(extreme=data["extreme_quantity"].values == "driving_torque")
    assert float(torque["least"][0]) == pytest.approx(-10.0, abs=1e-8)
    assert float(torque["least_angle"][0]) == pytest.approx(corner, abs=1e-8)
    assert float(torque["extreme_error"][0]) < 1e-7


def test_a_crank_that_cannot_turn_fully_is_a_warning_at_a_speed() -> None:
    """Values are then of the angles asked for alone."""
    swinging = replace(fourbar(), linkage=replace(fourbar().linkage, crank=0.25, coupler=0.1))
    swinging = replace(swinging, linkage=replace(swinging.linkage, rocker=0.11))
    part = np.radians([25.0, 30.0, 35.0])
    running = kinematics(swinging, 1500.0, crank_angles=part, speed_unit="rpm")
    (warning,) = running.summary().warnings
    assert "cannot turn fully (double-rocker)" in warning
    assert kinematics(swinging, 0.0, crank_angles=part).summary().warnings == ()
    apart = kinematics(swinging, 20.0, crank_angles=np.radians([30.0, 330.0]))
    assert apart.dataset["extreme_error"].isnull().all()


SQUARE = (Link("left", 1.0), Link("top", 1.0), Link("right", 1.0))
PORTAL = resting([np.pi / 2, 0.0, np.pi / 2], [[0, 0], [0, 1], [1, 0]])
CORNERS = (
    Weld("A", LinkEnd("left", "end"), LinkEnd("top", "start")),
    Weld("B", LinkEnd("top", "end"), LinkEnd("right", "end")),
)
FOOT = Clamp("O2", LinkEnd("left", "start"))
HELD_WRONGLY = [
    (
        Topology(SQUARE, (FOOT, Clamp("O4", LinkEnd("right", "start"))), welds=CORNERS),
        r"12 connection forces for 9 .*: joint B repeats",
    ),
    (
        Topology(
            SQUARE,
            (FOOT,),
            pins=(Pin("B", LinkEnd("top", "end"), LinkEnd("right", "end")),),
            welds=CORNERS[:1],
            sliders=(Slider("S", LinkEnd("left", "end"), 0.0),),
        ),
        r"joint S repeats .*, and the right can move",
    ),
]


@pytest.mark.parametrize(("held", "said"), HELD_WRONGLY, ids=["twice", "one part twice"])
def test_structures_that_are_not_held_exactly_once_are_refused(held: Topology, said: str) -> None:
    with pytest.raises(InputError, match=said):
        inverse_dynamics(held, PORTAL, tuple(LinkMass(1.0, 1.0) for _ in SQUARE), (1.0, -9.81))


@pytest.mark.parametrize(("sine", "refused"), [(4e-9, False), (1e-10, True)])
def test_two_links_in_line_hold_their_weight_until_round_off(sine: float, refused: bool) -> None:
    """Forces are half of it over the sine."""
    pins = (
        Pin("A", LinkEnd("left", "end"), LinkEnd("top", "start")),
        Pin("B", LinkEnd("top", "end"), LinkEnd("right", "end")),
    )
    pivots = (Pivot("O4", LinkEnd("right", "start")),)
    held = Topology(SQUARE, (FOOT,), pivots=pivots, pins=pins)
    level = resting([np.pi / 2, sine, np.pi - sine], [[0, 0], [0, 1], [2, 1]])
    asked = held, level, tuple(LinkMass(1.0, 1.0) for _ in SQUARE), (0.0, -9.81)
    if refused:
        with pytest.raises(InputError, match="joint B repeats"):
            inverse_dynamics(*asked)
        return
    largest = np.abs(inverse_dynamics(*asked).start_force).max()
    assert largest == pytest.approx(9.81 / (2 * sine), rel=1e-6)
