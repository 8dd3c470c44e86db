"""Forces in random linkages with welds, sliders, bodies, loads and springs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech.errors import InputError
from flexmech.linkages import (
    GROUND,
    AttachmentPoint,
    Clamp,
    FourBar,
    InverseDynamics,
    JointSpring,
    Link,
    LinkBody,
    LinkEnd,
    LinkMass,
    Load,
    Pin,
    Pivot,
    RigidMotion,
    RotatingArm,
    Slider,
    Spring,
    Topology,
    Weld,
    continuous_angles,
    inverse_dynamics,
)
from tests.support.random_linkages import LoadedLinkage, link_masses, loaded_linkages
from tests.support.strategies import STEEL_LINKAGE

GRAVITY = (1.5, -9.81)
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)


def solved(case: LoadedLinkage) -> InverseDynamics:
    return inverse_dynamics(
        case.topology,
        case.motion,
        case.masses,
        GRAVITY,
        loads=case.loads,
        springs=case.springs,
        joint_springs=case.joint_springs,
    )


def lumps(mass: LinkMass) -> list[tuple[float, float, float, float]]:
    """Mass, inertia and place along and across of what has the link's moments."""
    half = mass.length / 2
    line = zip(mass.mass_per_length * half * WEIGHTS, half * (POINTS + 1), strict=True)
    points = zip(mass.point_masses, mass.point_positions, strict=True)
    return [
        *((m, 0.0, x, mass.offset) for m, x in line),
        *((m, 0.0, x, 0.0) for m, x in points),
        *((b.mass, b.inertia, b.position + b.offset[0], b.offset[1]) for b in mass.bodies),
    ]


def axes(motion: RigidMotion, link: int) -> np.ndarray:
    """Unit vectors along and across a link, as rows."""
    c, s = np.cos(motion.angle[link]), np.sin(motion.angle[link])
    return np.array([[c, s], [-s, c]])


def point_motion(motion: RigidMotion, link: int, x: float, y: float) -> tuple[np.ndarray, ...]:
    arm = np.array([x, y]) @ axes(motion, link)
    ahead = np.array([-arm[1], arm[0]])
    omega, alpha = motion.angular_velocity[link], motion.angular_acceleration[link]
    return (
        motion.origin[link] + arm,
        motion.origin_velocity[link] + omega * ahead,
        motion.origin_acceleration[link] + alpha * ahead - omega**2 * arm,
    )


def ends(case: LoadedLinkage, spring: Spring) -> list[tuple[np.ndarray, np.ndarray]]:
    return [
        (np.array([p.x, p.y]), np.zeros(2))
        if p.link == GROUND
        else point_motion(case.motion, case.topology.index(p.link), p.x, 0.0)[:2]
        for p in (spring.first, spring.second)
    ]


def sides(case: LoadedLinkage, joint: str) -> list[int]:
    """Numbers of the following and the leading link, or of the pivoted one."""
    index = case.topology.index
    for pin in case.topology.pins:
        if pin.joint == joint:
            return [index(pin.follower.link), index(pin.leader.link)]
    return [index(pivot.link_end.link) for pivot in case.topology.pivots if pivot.joint == joint]


@settings(max_examples=150)
@given(loaded_linkages())
def test_all_power_becomes_kinetic_energy(case: LoadedLinkage) -> None:
    """Driving power and that of weight, loads and springs is the kinetic energy's rate.

    A term is a force times a velocity, or a torque times an angular velocity; its size is
    counted before what is at right angles cancels. What the crank's joints carry has a power
    too, which drops out.
    """
    motion, forces = case.motion, solved(case)
    terms = [float(forces.driving_power)]
    crank = case.topology.links[0].length * abs(float(motion.crank_speed))
    sizes = [crank * max(float(np.abs(force).max()) for force in forces.joint_force.values())]

    def add(force: np.ndarray, velocity: np.ndarray) -> None:
        terms.append(float(force @ velocity))
        sizes.append(float(np.linalg.norm(force) * np.linalg.norm(velocity)))

    def turn(torque: float, link: int) -> None:
        add(np.array([torque]), motion.angular_velocity[link : link + 1])

    for link, mass in enumerate(case.masses):
        for m, inertia, x, y in lumps(mass):
            _, velocity, acceleration = point_motion(motion, link, x, y)
            add(-m * acceleration, velocity)
            add(m * np.asarray(GRAVITY), velocity)
            turn(-inertia * motion.angular_acceleration[link], link)
    for load in case.loads:
        link = case.topology.index(load.point.link)
        force = np.asarray(load.force[0])
        if load.axes == "link":
            force = force @ axes(motion, link)
        add(force, point_motion(motion, link, load.point.x, 0.0)[1])
        turn(load.torque[0], link)
    for spring in case.springs:
        (p1, v1), (p2, v2) = ends(case, spring)
        length = np.linalg.norm(p2 - p1)
        along = (p2 - p1) / length
        pull = spring.stiffness * (length - spring.free_length)
        pull = pull + spring.damping * (v2 - v1) @ along
        add(pull * along, v1)
        add(-pull * along, v2)
    for own in case.joint_springs:
        follower, *leader = sides(case, own.joint)
        angle, rate = (
            of[follower] - sum(of[link] for link in leader)
            for of in (motion.angle, motion.angular_velocity)
        )
        torque = -own.torsional_stiffness * (angle - own.free_angle)
        torque -= own.torsional_damping * rate
        turn(torque, follower)
        for link in leader:
            turn(-torque, link)
    assert abs(sum(terms)) <= 1e-12 * max(sizes)


def cross(arm: np.ndarray, force: np.ndarray) -> float:
    return float(arm[0] * force[1] - arm[1] * force[0])


def end_forces(case: LoadedLinkage, forces: InverseDynamics, link: str) -> tuple[np.ndarray, float]:
    """What joints do to a link's end: force, and couple on it."""
    topology, end = case.topology, LinkEnd(link, "end")
    force, couple = np.zeros(2), 0.0
    for holder in (*topology.clamps, *topology.pivots, *topology.sliders):
        if holder.link_end == end:
            force = force + forces.joint_force[holder.joint]
            couple += forces.joint_moment[holder.joint]
    for tie in topology.ties:
        for place, sign in ((tie.follower, 1), (tie.leader, -1)):
            if place == end:
                force = force + sign * forces.joint_force[tie.joint]
                couple += sign * forces.joint_moment[tie.joint]
    return force, couple


@settings(max_examples=100)
@given(loaded_linkages())
def test_what_a_link_carries_at_its_end_is_what_the_joint_there_gives(case: LoadedLinkage) -> None:
    """A cut beyond the last force: from the start, all forces but those on the end are passed."""
    forces = solved(case)
    for number, link in enumerate(case.topology.links):
        reach = [link.length, *(float(one.x) for one in forces.on_guides if one.link == number)]
        beyond = max(reach) * (1 + 1e-9)
        force, couple = end_forces(case, forces, link.name)
        force = axes(case.motion, number) @ force
        # About the cut; the distributed mass ends with the link.
        couple += cross(np.array([link.length - beyond, 0.0]), force)
        if max(reach) > link.length and case.masses[number].mass_per_length:
            continue
        found = [
            getattr(forces, name)(number, beyond)
            for name in ("axial_force", "shear_force", "bending_moment")
        ]
        size = 1e-10 + 1e-8 * sum(np.abs(f).max() for f in forces.joint_force.values())
        size += 1e-8 * sum(abs(float(m)) for m in forces.joint_moment.values())
        size += 1e-8 * np.abs(forces.inertia_force).max()
        assert np.abs(np.array(found) - [*force, couple]).max() <= size


@settings(max_examples=50)
@given(loaded_linkages(), st.floats(0.05, 0.9))
def test_shear_force_is_the_slope_of_the_bending_moment(case: LoadedLinkage, part: float) -> None:
    forces = solved(case)
    for number, mass in enumerate(case.masses):
        x, step = part * mass.length, 1e-3 * mass.length
        fixed = [*mass.point_positions, *(body.position for body in mass.bodies)]
        fixed += [float(f.x) for f in (*forces.applied, *forces.on_guides) if f.link == number]
        if mass.offset or any(abs(x - place) <= 2 * step for place in fixed):
            continue
        near = forces.bending_moment(number, np.array([x - step, x + step]))
        shear = forces.shear_force(number, np.array([x - step, x, x + step]))
        mean = shear @ [1, 4, 1] / 6
        size = np.abs(near).max() / step + np.abs(shear).max() + np.abs(forces.start_force).max()
        assert abs((near[1] - near[0]) / (2 * step) + mean) <= 1e-11 * size


@given(loaded_linkages())
def test_a_slider_is_pushed_across_its_line(case: LoadedLinkage) -> None:
    forces = solved(case)
    for slider in case.topology.sliders:
        angle = slider.direction
        if slider.guide:
            angle += case.motion.angle[case.topology.index(slider.guide)]
        force = forces.joint_force[slider.joint]
        along = force @ [np.cos(angle), np.sin(angle)]
        assert abs(along) <= 1e-14 * np.abs(force).max()
    guided = [slider for slider in case.topology.sliders if slider.guide]
    for slider, back in zip(guided, forces.on_guides, strict=True):
        assert np.array_equal(back.force, -forces.joint_force[slider.joint])
        held = case.topology.index(slider.link_end.link)
        end = 0.0 if slider.link_end.end == "start" else case.topology.links[held].length
        place = case.motion.position(back.link, back.x, back.y)
        assert place == pytest.approx(case.motion.position(held, end), abs=1e-13)


@given(st.data())
def test_moments_of_a_link_are_those_of_its_parts(data: st.DataObject) -> None:
    mass = data.draw(link_masses(0.8))
    parts = lumps(mass)
    assert mass.moment(0) == pytest.approx(sum(m for m, *_ in parts), rel=1e-13, abs=1e-15)
    assert mass.moment(1) == pytest.approx(sum(m * x for m, _, x, _ in parts), rel=1e-12)
    assert mass.moment_across == pytest.approx(
        sum(m * y for m, _, _, y in parts), rel=1e-12, abs=1e-15
    )
    polar = sum(i + m * (x**2 + y**2) for m, i, x, y in parts)
    assert mass.moment(2) == pytest.approx(polar, rel=1e-12, abs=1e-15)
    if mass.moment(0) > 1e-3:
        x0, y0 = mass.centre
        central = sum(i + m * ((x - x0) ** 2 + (y - y0) ** 2) for m, i, x, y in parts)
        assert mass.central_inertia == pytest.approx(central, rel=1e-9, abs=1e-9)


def test_a_body_near_an_end_is_fixed_there_and_stays_where_it_is() -> None:
    bodies = [LinkBody(1e-4, 2.0, 0.1, (0.0, 0.03)), LinkBody(0.5, 1.0), LinkBody(0.5005, 1.0)]
    mass = LinkMass.of_points(1.0, 0.0, [], bodies=bodies)
    assert [body.position for body in mass.bodies] == [0.0, 0.5, 0.5]
    assert [body.centre[0] for body in mass.bodies] == pytest.approx([1e-4, 0.5, 0.5005])
    assert mass.moment(2) == pytest.approx(LinkMass(1.0, 0.0, bodies=tuple(bodies)).moment(2))


def test_the_weld_of_an_l_beam_carries_the_moment_of_its_second_arm() -> None:
    """Weight of a horizontal arm of 0.4 m at the end of an upright one of 2 m."""
    links = (Link("arm", 2.0), Link("second", 0.4))
    weld = Weld("B", LinkEnd("arm", "end"), LinkEnd("second", "start"))
    topology = Topology(links, (Clamp("O2", LinkEnd("arm", "start")),), welds=(weld,))
    zero = np.zeros((2, 2))
    motion = RigidMotion(
        crank_angle=np.asarray(np.pi / 2),
        crank_speed=np.asarray(0.0),
        angle=np.array([np.pi / 2, 0.0]),
        angular_velocity=np.zeros(2),
        angular_acceleration=np.zeros(2),
        origin=np.array([[0.0, 0.0], [0.0, 2.0]]),
        origin_velocity=zero,
        origin_acceleration=zero,
    )
    masses = (LinkMass(2.0, 3.0), LinkMass(0.4, 5.0))
    forces = inverse_dynamics(topology, motion, masses, (0.0, -10.0))
    assert forces.joint_force["B"] == pytest.approx([0.0, 20.0])
    assert forces.joint_moment["B"] == pytest.approx(20 * 0.2)
    assert forces.joint_moment["O2"] == pytest.approx(20 * 0.2)
    assert forces.bending_moment(1, 0.0) == pytest.approx(-20 * 0.2)
    assert forces.bending_moment(1, 0.1) == pytest.approx(-5 * 10 * 0.3**2 / 2)
    assert forces.shear_force(1, 0.1) == pytest.approx(-5 * 10 * 0.3)
    assert forces.bending_moment(0, 1.0) == pytest.approx(-20 * 0.2)
    assert forces.axial_force(0, 0.5) == pytest.approx(-20 - 3 * 10 * 1.5)


def arm_with_load(load: Load) -> InverseDynamics:
    arm = RotatingArm(1.0)
    return inverse_dynamics(arm.topology, arm.motion(0.0), (LinkMass(1.0, 0.0),), loads=(load,))


def test_a_load_makes_tension_shear_and_moment_jump() -> None:
    load = Load("pull", AttachmentPoint("arm", 0.6), ((3.0, 2.0),), (0.5,))
    forces = arm_with_load(load)
    for x in (0.0, 0.59, 0.6):
        assert forces.axial_force(0, x) == pytest.approx(3.0)
        assert forces.shear_force(0, x) == pytest.approx(2.0)
        assert forces.bending_moment(0, x) == pytest.approx(2.0 * (0.6 - x) + 0.5)
    assert forces.axial_force(0, 0.61) == pytest.approx(0.0, abs=1e-15)
    assert forces.shear_force(0, np.array([0.5, 0.61])) == pytest.approx([2.0, 0.0], abs=1e-15)
    assert forces.bending_moment(0, 0.7) == pytest.approx(0.0, abs=1e-15)
    assert forces.driving_torque == pytest.approx(-2.0 * 0.6 - 0.5)


def test_a_load_over_time_takes_the_time_of_each_position() -> None:
    load = Load(
        "push",
        AttachmentPoint("arm", 1.0),
        ((0.0, 0.0), (0.0, 4.0)),
        (0, 0),
        "link",
        "time",
        (0, 1),
    )
    arm = RotatingArm(1.0)
    forces = inverse_dynamics(
        arm.topology,
        arm.motion(np.zeros(3)),
        (LinkMass(1.0, 0.0),),
        loads=(load,),
        time=[0.0, 0.5, 2.0],
    )
    assert forces.driving_torque == pytest.approx([0.0, -2.0, -4.0])


def test_a_spring_whose_ends_meet_is_refused() -> None:
    spring = Spring(
        "return", AttachmentPoint("arm", 1.0), AttachmentPoint(GROUND, 0.0, 1.0), 5.0, 0.1
    )
    arm = RotatingArm(1.0)
    with pytest.raises(InputError, match="spring return: its ends meet at crank angle 90 deg"):
        inverse_dynamics(
            arm.topology, arm.motion([0.0, np.pi / 2]), (LinkMass(1.0, 1.0),), springs=(spring,)
        )


def test_a_spring_without_free_length_may_pass_its_other_end() -> None:
    spring = Spring(
        "return", AttachmentPoint("arm", 1.0), AttachmentPoint(GROUND, 0.0, 1.0), 5.0, 0.0
    )
    arm = RotatingArm(1.0)
    motion = arm.motion([0.0, np.pi / 2])
    forces = inverse_dynamics(arm.topology, motion, (LinkMass(1.0, 0.0),), springs=(spring,))
    assert forces.driving_torque == pytest.approx([-5.0, 0.0], abs=1e-12)


def test_a_spring_in_a_pin_winds_up_with_every_turn() -> None:
    linkage = STEEL_LINKAGE
    angles = np.array([0.3, 0.3 + 2 * np.pi, 0.3 - 4 * np.pi])
    motion = linkage.motion(angles)
    counted = continuous_angles(linkage, motion)
    assert counted[:, 0] == pytest.approx(angles)
    assert counted[:, 1:] == pytest.approx(np.broadcast_to(counted[0, 1:], (3, 2)))
    masses = tuple(LinkMass(x, 0.0) for x in (0.1, 0.2794, 0.2667))
    torque = inverse_dynamics(
        linkage.topology,
        motion,
        masses,
        joint_springs=(JointSpring("A", 2.0),),
        continuous_angles=counted,
    ).driving_torque
    rate = 1 - linkage.motion(0.3, 1.0).angular_velocity[1]
    assert np.diff(torque) == pytest.approx([2 * 2 * np.pi * rate, -2 * 6 * np.pi * rate])


@pytest.mark.parametrize(
    ("lengths", "gained"), [((0.3, 1.0, 1.2, 1.1), 0), ((0.3, 1.0, 1.1, 0.9), 1)]
)
@pytest.mark.parametrize("branch", ["open", "crossed"])
def test_angles_are_counted_on(lengths, gained, branch) -> None:
    """A drag link's coupler and rocker turn with the crank, a crank-rocker's swing."""
    ground, crank, *rest = lengths if gained else (lengths[1], lengths[0], *lengths[2:])
    linkage = FourBar(ground, crank, *rest, branch)
    around = np.linspace(-7, 14, 2000)
    counted = continuous_angles(linkage, linkage.motion(around))
    assert np.abs(np.diff(counted, axis=0)).max() < 0.2
    one = linkage.motion([0.5, 0.5 + 2 * np.pi])
    turned = np.diff(continuous_angles(linkage, one), axis=0)[0] / (2 * np.pi)
    assert turned == pytest.approx([1, gained, gained], abs=1e-9)


def test_angles_of_a_crank_that_does_not_turn_fully_are_followed_both_ways() -> None:
    linkage = FourBar(1.0, 0.9, 0.6, 0.65)
    stands = np.array([a for a in np.radians(np.arange(-89, 90)) if _stands(linkage, a)])
    motion = linkage.motion(stands)
    counted = continuous_angles(linkage, motion)
    assert np.abs(np.diff(counted, axis=0)).max() < 1.0
    shifted = continuous_angles(linkage, linkage.motion(stands + 2 * np.pi))
    assert shifted == pytest.approx(counted, abs=1e-9)


def _stands(linkage, angle: float) -> bool:
    try:
        linkage.motion(angle)
    except InputError:
        return False
    return True


# A portal of three bars and other structures that are not held exactly once.
SQUARE = (Link("left", 1.0), Link("top", 1.0), Link("right", 1.0))


def still(angles: list[float], origins: list[list[float]]) -> RigidMotion:
    zero = np.zeros((len(angles), 2))
    return RigidMotion(
        crank_angle=np.asarray(0.0),
        crank_speed=np.asarray(0.0),
        angle=np.array(angles),
        angular_velocity=np.zeros(len(angles)),
        angular_acceleration=np.zeros(len(angles)),
        origin=np.array(origins),
        origin_velocity=zero,
        origin_acceleration=zero,
    )


PORTAL = still([np.pi / 2, 0.0, np.pi / 2], [[0, 0], [0, 1], [1, 0]])
CORNERS = (
    Weld("A", LinkEnd("left", "end"), LinkEnd("top", "start")),
    Weld("B", LinkEnd("top", "end"), LinkEnd("right", "end")),
)
FOOT = Clamp("O2", LinkEnd("left", "start"))
MASSES = tuple(LinkMass(1.0, 1.0) for _ in SQUARE)


def test_a_portal_that_is_clamped_twice_is_refused() -> None:
    held = Topology(SQUARE, (FOOT, Clamp("O4", LinkEnd("right", "start"))), welds=CORNERS)
    with pytest.raises(InputError, match=r"12 connection forces for 9 .*: joint B constrains what"):
        inverse_dynamics(held, PORTAL, MASSES)


def test_a_portal_on_a_roller_is_held_too_often() -> None:
    held = Topology(
        SQUARE, (FOOT,), welds=CORNERS, sliders=(Slider("O4", LinkEnd("right", "start"), 0.0),)
    )
    with pytest.raises(
        InputError, match=r"10 connection forces for 9 .*: joint O4 constrains what"
    ):
        inverse_dynamics(held, PORTAL, MASSES)


def test_as_many_connections_as_equations_can_still_hold_one_part_twice() -> None:
    """The top follows by two pins, the right link swings, and the left one is held twice."""
    corner, swinging = CORNERS[0], Pin("B", LinkEnd("top", "end"), LinkEnd("right", "end"))
    held = Topology(
        SQUARE,
        (FOOT,),
        pins=(swinging,),
        welds=(corner,),
        sliders=(Slider("S", LinkEnd("left", "end"), 0.0),),
    )
    with pytest.raises(
        InputError, match=r"joint S constrains what .*, and the right can move .* has B"
    ):
        inverse_dynamics(held, PORTAL, MASSES, (1.0, -9.81))


def test_a_singular_structure_is_refused_at_its_crank_angle() -> None:
    """A roller whose line lies along the arm about the pivot cannot hold it."""
    link = (Link("bar", 1.0), Link("strut", 1.0))
    held = Topology(
        link,
        (Clamp("O2", LinkEnd("bar", "start")),),
        (Pivot("O4", LinkEnd("strut", "start")),),
        sliders=(Slider("S", LinkEnd("strut", "end"), np.pi / 2),),
    )
    motion = still([0.0, 0.0], [[0, 0], [0, 1]])
    with pytest.raises(
        InputError, match=r"at crank angle 0 deg: joint S constrains .* the strut can"
    ):
        inverse_dynamics(held, motion, MASSES[:2], (0.0, -9.81))


@pytest.mark.parametrize(("sine", "refused"), [(4e-9, False), (1e-10, True)])
def test_two_links_in_line_hold_nothing_but_for_what_round_off_cannot_be(sine, refused) -> None:
    """Their weight makes forces of a half of it over the sine."""
    pins = (
        Pin("A", LinkEnd("left", "end"), LinkEnd("top", "start")),
        Pin("B", LinkEnd("top", "end"), LinkEnd("right", "end")),
    )
    held = Topology(SQUARE, (FOOT,), pivots=(Pivot("O4", LinkEnd("right", "start")),), pins=pins)
    level = still([np.pi / 2, sine, np.pi - sine], [[0, 0], [0, 1], [2, 1]])
    if refused:
        with pytest.raises(InputError, match="joint B constrains what"):
            inverse_dynamics(held, level, MASSES, (0.0, -9.81))
    else:
        forces = inverse_dynamics(held, level, MASSES, (0.0, -9.81)).start_force
        assert np.abs(forces).max() == pytest.approx(9.81 / (2 * sine), rel=1e-6)
