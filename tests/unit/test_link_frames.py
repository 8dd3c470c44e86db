"""Link frames: compatibility at the pins, and every rotation term against its definition."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from numpy.typing import NDArray

from flexmech.analyses import solve_modes
from flexmech.errors import ComputationError, InputError
from flexmech.linear_system import (
    Engine,
    LinearSystem,
    LinkFrames,
    Prestress,
    RotationTerms,
    element_tensions,
    inertia_loads,
)
from flexmech.linear_system.links.rigid_link import rigid_link
from flexmech.linkages import (
    Clamp,
    FourBar,
    Link,
    LinkEnd,
    LinkMass,
    Pin,
    Pivot,
    RigidMotion,
    RotatingArm,
    Topology,
    Weld,
    inverse_dynamics,
)
from flexmech.linkages.motion import direction, normal
from flexmech.mechanism import Mechanism
from flexmech.reference import ReferenceEngine
from tests.cross_engine.joined_linkages import QuickReturn, welded, with_links
from tests.cross_engine.test_exudyn_connectors import strips
from tests.support.strategies import Running, arm, fourbar, running_mechanisms

FloatArray = NDArray[np.float64]
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(6)
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
OFF = RotationTerms.all_or_none(False)


def engine_of(mechanism: Mechanism, elements: int = 2) -> ReferenceEngine:
    """Unreduced, of elements with three coordinates a node; short links would get others."""
    least = 1 + len(mechanism.link_masses)
    return ReferenceEngine(mechanism, max(elements, least), "euler", component_modes=False)


def system_at(
    engine: Engine,
    angle: float | FloatArray,
    speed: float,
    terms: bool | RotationTerms = True,
    prestress: Prestress = "none",
) -> LinearSystem:
    return engine.linear_system(angle, speed, prestress=prestress, rotation_terms=terms)


def weighted_displacement(engine: ReferenceEngine, angle: FloatArray) -> FloatArray:
    """Ground displacement at Gauss points and point masses times the root of their mass.

    Shape (B, rows, n): ``W' W`` is twice the kinetic energy of unit velocities in ground axes.
    """
    frames = LinkFrames(engine.mechanism.linkage.topology, engine.links)
    motion = engine.mechanism.linkage.motion(angle)
    unit = np.broadcast_to(np.eye(frames.size), (len(angle), frames.size, frames.size))
    rows = []
    for number, q in enumerate(frames.link_coordinates(motion, unit)):
        mass, nodes = engine.mechanism.link_masses_in_order[number], engine.nodes[number]
        beams = engine.chains[number].elements
        turn = np.exp(1j * motion.angle[:, number])[:, None, None]
        places = list(zip(mass.point_positions, mass.point_masses, strict=True))
        for x, value in places:
            node = int(np.argmin(np.abs(nodes - x)))
            rows.append(np.sqrt(value) * turn * (q[:, [3 * node]] + 1j * q[:, [3 * node + 1]]))
        for element, length in enumerate(np.diff(nodes)):
            shape = beams.displacement_shapes((POINTS + 1) / 2, np.full(6, length))
            local = shape @ q[:, None, 3 * element : 3 * element + 6]
            weight = np.sqrt(mass.mass_per_length * length * WEIGHTS / 2)[:, None]
            rows.append(weight * turn * (local[:, :, 0] + 1j * local[:, :, 1]))
    stacked = np.concatenate(rows, axis=1)
    return np.concatenate([stacked.real, stacked.imag], axis=1)


def defined(engine: ReferenceEngine, angle: float, speed: float) -> tuple[FloatArray, ...]:
    """M, C, K without elasticity: P'MP, 2 P'M Pdot, P'M Pddot by finite differences."""
    # Near a dead point the motion changes within hundredths of a radian.
    step = 1e-3
    path = weighted_displacement(engine, angle + step * np.arange(-4, 5))
    here = path[4].T
    rate = np.einsum("k,kij->ij", FIRST, path) / step * speed
    change = np.einsum("k,kij->ij", SECOND, path) / step**2 * speed**2
    return here @ path[4], 2 * here @ rate, here @ change


def assert_rotation_terms_follow_from_ground_axes(
    mechanism: Mechanism, angle: float, speed: float
) -> None:
    engine = engine_of(mechanism)
    mass, damping, stiffness = defined(engine, angle, speed)
    system = system_at(engine, angle, speed)
    still = system_at(engine, angle, speed, terms=False)
    assert system.mass[0] == pytest.approx(mass, abs=1e-12 * np.abs(mass).max())
    scale = np.abs(damping).max()
    assert system.damping[0] == pytest.approx(damping, abs=1e-8 * scale)
    # The elastic stiffness is much greater: compare what rotation adds.
    added = system.stiffness[0] - still.stiffness[0]
    scale = np.abs(stiffness).max() + 1e-8 * np.abs(still.stiffness).max()
    assert added == pytest.approx(stiffness, abs=1e-6 * scale)


@settings(max_examples=25)
@given(running_mechanisms())
def test_rotation_terms_of_a_fourbar_follow_from_ground_axes(drawn: Running) -> None:
    assert_rotation_terms_follow_from_ground_axes(
        drawn.mechanism, drawn.crank_angle, drawn.crank_speed
    )


def test_rotation_terms_of_an_arm_follow_from_ground_axes() -> None:
    assert_rotation_terms_follow_from_ground_axes(arm(1.0, 0.3), 0.4, 30.0)


@settings(max_examples=15)
@given(running_mechanisms())
def test_switched_terms_add_up_to_all_of_them(drawn: Running) -> None:
    engine = engine_of(drawn.mechanism)

    def matrices(*on: bool) -> tuple[FloatArray, FloatArray]:
        system = system_at(engine, drawn.crank_angle, drawn.crank_speed, RotationTerms(*on))
        return system.damping, system.stiffness

    none, every = matrices(False, False, False), matrices(True, True, True)
    singles = [matrices(*row) for row in np.eye(3, dtype=bool).tolist()]
    for kind in (0, 1):
        total = sum(single[kind] - none[kind] for single in singles)
        scale = np.abs(every[kind]).max()
        assert every[kind] - none[kind] == pytest.approx(total, abs=1e-12 * scale)
    assert singles[0][0].any()
    assert not singles[1][0].any()
    assert not singles[2][0].any()


@settings(max_examples=15)
@given(running_mechanisms())
def test_joined_ends_move_alike_and_held_ends_stay(drawn: Running) -> None:
    system = system_at(engine_of(drawn.mechanism), drawn.crank_angle, drawn.crank_speed)
    unit = np.eye(system.size)[None]
    moved = np.moveaxis(system.displacements(unit)[0], 0, -1)  # link, station, component, m
    crank, coupler, rocker = moved
    assert coupler[0] == pytest.approx(crank[-1], abs=1e-14)
    assert rocker[-1] == pytest.approx(coupler[-1], abs=1e-14)
    assert not crank[0].any()
    assert not rocker[0].any()
    # Three free translations at A, B and inside: the pins take four coordinates away.
    assert system.size == sum(link.size for link in system.frames.links) - 3 - 2 - 4


def test_gathered_loads_do_the_same_work_as_the_links_own() -> None:
    engine = engine_of(fourbar())
    motion = engine.mechanism.linkage.motion(np.array([0.4, 2.0]), np.array([20.0, 10.0]))
    frames = LinkFrames(engine.mechanism.linkage.topology, engine.links)
    random = np.random.default_rng(3)
    loads = [random.normal(size=(2, link.size)) for link in engine.links]
    moves = random.normal(size=(2, frames.size, 1))
    own = sum(
        np.sum(f * q[:, :, 0], axis=1)
        for f, q in zip(loads, frames.link_coordinates(motion, moves), strict=True)
    )
    assert np.sum(frames.gather(motion, loads) * moves[:, :, 0], axis=1) == pytest.approx(own)


def test_inertia_loads_do_work_like_the_distributed_forces() -> None:
    engine = engine_of(fourbar(joint_masses={"B": 0.1}), 3)
    gravity = (1.0, -9.81)
    motion = engine.mechanism.linkage.motion(np.array([0.4]), np.array([20.0]))
    loads = inertia_loads(engine.links, motion, gravity)
    for number, mass in enumerate(engine.mechanism.link_masses_in_order):
        length, angle = mass.length, motion.angle[0, number]
        places = [
            (mass.mass_per_length * length * w / 2, (p + 1) * length / 2)
            for p, w in zip(POINTS, WEIGHTS, strict=True)
        ]
        places += list(zip(mass.point_masses, mass.point_positions, strict=True))
        work = 0.0
        for m, x in places:
            force = complex(*(-m * (motion.acceleration(number, x)[0] - gravity)))
            local = force * np.exp(-1j * angle)
            field = x**2 * (length - x) + 0.3 * x**3  # any cubic across, linear along
            work += local.real * 2 * x + local.imag * field
        nodes = engine.nodes[number]
        slope = 2 * nodes * length - 3 * nodes**2 + 0.9 * nodes**2
        across = nodes**2 * (length - nodes) + 0.3 * nodes**3
        q = np.stack([2 * nodes, across, slope], axis=1).ravel()
        assert loads[number][0] @ q == pytest.approx(work, rel=1e-12)


def test_matter_off_the_axis_is_pulled_outward_by_its_first_moment() -> None:
    engine = engine_of(fourbar())
    motion = engine.mechanism.linkage.motion(np.array([0.3, 2.0]), np.array([10.0, 20.0]))
    off = [
        replace(link, first_moment=np.add(link.first_moment, [[5.0], [2.0]]))
        for link in engine.links
    ]
    on_axis, off_axis = (
        inertia_loads(links, motion, (0.0, -9.81)) for links in (engine.links, off)
    )
    for number, (here, there) in enumerate(zip(on_axis, off_axis, strict=True)):
        pull = 2 * motion.angular_velocity[:, number, None] ** 2
        np.testing.assert_allclose(there - here, np.broadcast_to(pull, here.shape), rtol=1e-9)


@settings(max_examples=15)
@given(running_mechanisms())
def test_element_tensions_are_the_axial_force_of_the_rigid_linkage(drawn: Running) -> None:
    mechanism, engine = drawn.mechanism, engine_of(drawn.mechanism, 3)
    motion = mechanism.linkage.motion(np.array([drawn.crank_angle]), drawn.crank_speed)
    topology, masses = mechanism.linkage.topology, mechanism.link_masses_in_order
    forces = inverse_dynamics(topology, motion, masses)
    tensions = element_tensions(mechanism, engine.nodes, motion)
    for link, (nodes, tension) in enumerate(zip(engine.nodes, tensions, strict=True)):
        scale = np.abs(tension).max()
        for element, start in enumerate(nodes[:-1]):
            for s in (0.1, 0.45, 0.8):
                x = start + s * (nodes[element + 1] - start)
                found = np.polynomial.legendre.legval(2 * s - 1, tension[0, element])
                assert found == pytest.approx(forces.axial_force(link, x)[0], abs=1e-7 * scale)


def test_positions_in_a_batch_do_not_influence_each_other() -> None:
    engine = engine_of(fourbar(damping_time=1e-5))
    angles, speeds = np.array([0.1, 2.0, 4.0]), np.array([0.0, 20.0, -7.0])
    together = engine.linear_system(angles, speeds, prestress="equilibrium")
    for i in range(3):
        alone = engine.linear_system(angles[i], speeds[i], prestress="equilibrium")
        for name in ("mass", "damping", "stiffness"):
            both = getattr(together, name)[i], getattr(alone, name)[0]
            assert both[0] == pytest.approx(both[1], abs=1e-10 * np.abs(both[1]).max())


def test_crank_angle_and_speed_broadcast_to_a_flat_batch() -> None:
    system = engine_of(fourbar()).linear_system(np.zeros((3, 1)), [1.0, 2.0], prestress="none")
    assert system.mass.shape == (6, system.size, system.size)
    assert system.motion.crank_speed.tolist() == [1.0, 2.0] * 3


def test_no_rotation_terms_at_rest() -> None:
    system = system_at(engine_of(fourbar()), 0.3, 0.0, terms=True)
    assert not system.terms.any
    assert system.is_conservative
    assert not system_at(engine_of(fourbar()), 0.3, 1.0, terms=True).is_conservative
    assert not system_at(engine_of(fourbar(damping_time=1e-5)), 0.3, 0.0).is_conservative


def chain(leader_first: bool) -> tuple[Topology, RigidMotion]:
    """Two links in one line, pinned together and to the ground at both far ends."""
    left_end, right_start = LinkEnd("left", "end"), LinkEnd("right", "start")
    leader, follower = (left_end, right_start) if leader_first else (right_start, left_end)
    topology = Topology(
        links=(Link("left", 1.0), Link("right", 1.0)),
        pivots=(Pivot("P", LinkEnd("left", "start")), Pivot("Q", LinkEnd("right", "end"))),
        pins=(Pin("A", leader, follower),),
    )
    pair = np.zeros((1, 2, 2))
    angle = np.array([[0.3, -0.8]])
    zero = np.zeros((1, 2))
    motion = RigidMotion(zero[:, 0], zero[:, 0], angle, zero, zero, pair, pair, pair)
    return topology, motion


def test_frequencies_at_rest_do_not_depend_on_which_end_leads() -> None:
    links = [replace(engine_of(arm()).links[0], name=name) for name in ("left", "right")]
    found = []
    for first in (True, False):
        topology, motion = chain(first)
        frames = LinkFrames(topology, links)
        matrices = frames.assemble(motion, [link.stiffness for link in links], OFF)
        m, k = matrices.mass[0], matrices.stiffness[0]
        found.append(np.sort(np.linalg.eigvals(np.linalg.solve(m, k)).real))
    assert found[0] == pytest.approx(found[1], rel=1e-7)


def oscillator(mass: float, damping: float, stiffness: float) -> LinearSystem:
    system = system_at(engine_of(arm()), 0.5, 3.0)
    size = system.size
    eye = np.eye(size)[None]
    return replace(
        system,
        mass=mass * eye,
        damping=damping * eye,
        stiffness=stiffness * eye * np.arange(1, size + 1),
    )


def test_frequency_and_damping_of_single_oscillators() -> None:
    modes = solve_modes(oscillator(2.0, 0.8, 50.0), 2)
    assert modes.frequency[0] == pytest.approx(np.sqrt([25.0, 50.0]) / (2 * np.pi))
    assert modes.damping_ratio[0] == pytest.approx(0.4 / (2 * np.sqrt([25.0, 50.0])))


def test_a_linkage_that_does_not_oscillate_is_refused_with_its_place() -> None:
    place = r"crank angle 28.6479 deg and crank speed 3 rad/s"
    with pytest.raises(
        ComputationError, match=f"fewer than 1 of the lowest modes oscillate.*{place}"
    ):
        solve_modes(oscillator(1.0, 300.0, 50.0), 1)
    with pytest.raises(ComputationError, match=f"diverges without oscillating.*{place}"):
        solve_modes(oscillator(1.0, 0.1, -50.0), 1)
    unstable = replace(oscillator(1.0, 0.0, -50.0), terms=OFF)
    with pytest.raises(ComputationError, match=f"statically unstable.*{place}"):
        solve_modes(unstable, 1)


@pytest.mark.parametrize("count", [0, 1000])
def test_more_modes_than_coordinates_are_refused(count: int) -> None:
    with pytest.raises(InputError, match=rf"modes: {count} were asked for, the model has \d+"):
        solve_modes(system_at(engine_of(fourbar()), 0.3, 0.0), count)


def test_positions_out_of_reach_are_refused() -> None:
    linkage = FourBar(0.5, 0.3, 0.3, 0.3)
    engine = engine_of(fourbar(linkage, thickness=(2e-3, 2e-3, 2e-3)))
    with pytest.raises(InputError, match="cannot be assembled at crank angle 180 deg"):
        engine.linear_system([0.0, np.pi])


def test_matrices_the_same_in_all_positions_turn_with_the_joined_ends() -> None:
    """``N'XN`` by the sum over cosines and sines, against N of each position by itself."""
    engine = engine_of(fourbar())
    system = system_at(engine, np.linspace(0.0, 6.0, 7), 0.0)
    frames, motion = system.frames, system.motion
    unit = np.broadcast_to(np.eye(frames.size), (7, frames.size, frames.size))
    maps = frames.link_coordinates(motion, unit)
    random = np.random.default_rng(1)
    stiffness = [random.normal(size=2 * (link.size,)) for link in frames.links]
    stiffness = [matrix + matrix.T for matrix in stiffness]
    found = frames.assemble(motion, stiffness, OFF)
    for matrices, assembled in (
        (stiffness, found.stiffness),
        ([link.mass for link in frames.links], found.mass),
    ):
        expected = sum(n.swapaxes(1, 2) @ x @ n for n, x in zip(maps, matrices, strict=True))
        assert assembled == pytest.approx(expected, abs=1e-13 * np.abs(expected).max())


def test_centripetal_terms_vanish_where_nothing_turns_yet() -> None:
    """At speed zero and under an acceleration of the crank tangential terms alone are left."""
    engine = engine_of(strips(FourBar(0.254, 0.102, 0.2794, 0.2667)))
    motion = engine.mechanism.linkage.motion(np.array([0.7]), np.zeros(1), np.array([300.0]))
    straight = [link.stiffness for link in engine.links]
    none, centripetal, tangential = (
        engine.frames.assemble(motion, straight, RotationTerms(False, *on)).stiffness
        for on in ((False, False), (True, False), (False, True))
    )
    np.testing.assert_allclose(centripetal, none, rtol=1e-12, atol=1e-12 * np.abs(none).max())
    assert np.abs(tangential - none).max() > 1.0


def test_the_stiffness_of_a_guide_is_between_its_rotation_and_the_slide_on_it() -> None:
    """Twice the product of both, as the frame of the guide sees the point that slides."""
    linkage = QuickReturn()
    engine = engine_of(strips(linkage))
    motion, size = linkage.motion(np.array([0.7])), engine.frames.size
    guide_stiffness = 3.0
    matrix = engine.frames.guide_matrix(motion, np.full((1, 1), guide_stiffness))[0]
    z = np.random.default_rng(0).normal(size=size)
    crank, rocker = (q[0, :, 0] for q in engine.frames.link_coordinates(motion, z[None, :, None]))
    angles, end = motion.angle[0], crank[engine.links[0].end]
    moved = end[0] * direction(angles[0]) + end[1] * normal(angles[0])
    slide = moved @ direction(angles[1]) + rocker[2] * linkage.offset
    assert z @ matrix @ z == pytest.approx(2 * guide_stiffness * rocker[2] * slide, rel=1e-9)


@pytest.mark.parametrize("rigid", [False, True])
def test_all_ends_on_a_hub_move_as_it_turns(rigid: bool) -> None:
    """Across the first link by the hub's radius; one that is welded there at an angle alike."""
    hub, motion = 0.05, RotatingArm(0.3, hub_radius=0.05).motion(np.array([0.7]))
    first, second = LinkEnd("arm", "start"), LinkEnd("other", "start")
    topology = Topology(
        links=(Link("arm", 0.3, rigid), Link("other", 0.2)),
        clamps=(Clamp("O2", first, hub=hub),),
        welds=(Weld("H", first, second),),
    ).with_free_shaft()
    elastic = [engine_of(strips(RotatingArm(length))).clamped_links[0] for length in (0.3, 0.2)]
    links = [elastic[0], replace(elastic[1], name="other")]
    if rigid:
        links[0] = rigid_link("arm", LinkMass(0.3, 1.0))
    frames = LinkFrames(topology, links)
    both = with_links(motion, welded(motion, 0, 0.0, 0.8))
    z = np.random.default_rng(0).normal(size=(1, frames.size, 1))
    parts = [q[0, :, 0] for q in frames.link_coordinates(both, z)]
    turn = parts[0][links[0].start_rotation[0]]
    assert turn != 0
    for q, link, angle in zip(parts, links, both.angle[0], strict=True):
        x, y = q[link.start]
        moved = x * direction(angle) + y * normal(angle)
        np.testing.assert_allclose(moved, hub * turn * normal(motion.angle[0, 0]), atol=1e-12)
