"""Loads, springs and sprung joints in Exudyn, standing and running."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexmech import (
    BeamSection,
    ConstantSpeed,
    ExudynEngine,
    Material,
    Mechanism,
    ReferenceEngine,
    natural_frequencies,
)
from flexmech.linear_system import DeadMoments, inertia_loads
from flexmech.linkages import (
    AttachmentPoint,
    JointSpring,
    Load,
    RigidMotion,
    Spring,
    Topology,
    continuous_angles,
)
from flexmech.linkages.motion import direction, normal
from flexmech.multibody.linearize import internal_forces, static_equilibrium
from flexmech.multibody.link_parts import BeamPart
from flexmech.multibody.static_model import StaticModel
from flexmech.multibody.straight_links import link_models
from flexmech.time_domain import LinkState
from tests.cross_engine.joined_linkages import LArm, SliderCrank, Ternary, Ties
from tests.cross_engine.test_exudyn_joints import FOUR_BAR
from tests.cross_engine.test_exudyn_system import assert_well_formatted, run_script

FloatArray = NDArray[np.float64]
KINDS = ("ancf", "geometrically-exact")


def thorough_but(*by_default: str) -> list[Any]:
    """Names of all mechanisms; without a thorough run only some."""
    return [
        pytest.param(name, marks=[pytest.mark.thorough] * (name not in by_default))
        for name in MECHANISMS
    ]


def strips(linkage: Any, **options: Any) -> Mechanism:
    """Aluminium strips under their weight."""
    section = BeamSection.rectangle(Material(68.9e9, 2923.0), 3e-3, 25.4e-3)
    names = [link.name for link in linkage.topology.links]
    return Mechanism(linkage, dict.fromkeys(names, section), gravity=(0.0, -9.81), **options)


class SprungFourBar(Ternary):
    """Its pin at B and its pivot at O4 are held by springs."""

    @property
    def topology(self) -> Topology:
        own = super().topology
        pins = tuple(replace(pin, sprung=pin.joint == "B") for pin in own.pins)
        pivots = tuple(replace(pivot, sprung=True) for pivot in own.pivots)
        return replace(own, pins=pins, pivots=pivots)


MECHANISMS: dict[str, Mechanism] = {
    "forces": strips(
        SliderCrank(),
        loads=(
            Load("constant", AttachmentPoint("coupler", 0.13), ((3.0, -2.0),), (0.05,)),
            Load(
                "table",
                AttachmentPoint("coupler", 0.3),
                ((-5.0, 0.0), (4.0, 1.0), (-2.0, 0.0)),
                (0.0, 0.1, -0.1),
                over="crank_angle",
                at=(0.0, 2.0, 4.0),
            ),
            Load("turning", AttachmentPoint("crank", 0.07), ((0.0, 6.0),), axes="link"),
        ),
    ),
    "springs": strips(
        LArm(),
        springs=(
            Spring(
                "ground",
                AttachmentPoint("ground", 0.3, 0.4),
                AttachmentPoint("leg", 0.2),
                40.0,
                0.05,
                0.3,
            ),
            Spring(
                "between",
                AttachmentPoint("arm", 0.11),
                AttachmentPoint("leg", 0.09),
                200.0,
                0.1,
                0.5,
            ),
        ),
    ),
    "springs in joints": strips(
        SliderCrank(),
        joint_springs=(JointSpring("A", 2.0, 0.01, -0.6),),
    ),
    "sprung joints": strips(
        SprungFourBar(FOUR_BAR),
        joint_springs=(
            JointSpring("B", 0.5, 0.0, 1.0, 2e4, 1.0),
            JointSpring("O4", 0.3, 0.002, 0.0, 1e4, 0.5),
        ),
    ),
    "rigid": strips(
        Ternary(FOUR_BAR, rigid=("rocker",)),
        loads=(Load("rocker", AttachmentPoint("rocker", 0.1), ((2.0, 1.0),), (0.2,), axes="link"),),
        springs=(
            Spring(
                "return",
                AttachmentPoint("ground", 0.1, -0.1),
                AttachmentPoint("rocker", 0.15),
                60.0,
                0.1,
            ),
        ),
        joint_springs=(JointSpring("O4", 0.6, 0.0, 0.1), JointSpring("A", 0.4, 0.0, -1.0)),
    ),
}


class Point:
    """A point of a link, its displacement by the link's coordinates."""

    def __init__(self, mechanism: Mechanism, links: Any, point: AttachmentPoint, kind: str) -> None:
        topology = mechanism.linkage.topology
        self.link = topology.index(point.link)
        self.x = point.x
        model = links[self.link]
        if model.rigid:
            self.turn = np.array([0.0, 0.0, 1.0])
            return
        fraction = point.x / topology.links[self.link].length
        self.rows = model.readings.displacement_at(np.array([fraction]))[0]
        near = int(np.argmin(np.abs(model.readings.nodes - point.x)))
        self.turn = np.zeros(model.size)
        self.turn[model.readings.per_node * near + model.readings.slope] = 1.0

    def place(self, motion: RigidMotion, q: FloatArray) -> FloatArray:
        angle = motion.angle[0, self.link]
        axes = np.stack([direction(angle), normal(angle)], axis=1)
        if len(q) == 3:
            own = motion.origin[0, self.link] + axes @ q[:2]
            return np.asarray(own + self.x * direction(angle + q[2]))
        return np.asarray(motion.position(self.link, self.x)[0] + axes @ (self.rows @ q))

    def force(self, motion: RigidMotion, q: FloatArray, force: Any, torque: float) -> FloatArray:
        angle = motion.angle[0, self.link]
        along, across = force @ direction(angle), force @ normal(angle)
        if len(q) == 3:
            lever = self.x * (np.cos(q[2]) * across - np.sin(q[2]) * along)
            return np.array([along, across, torque + lever])
        return np.asarray(along * self.rows[0] + across * self.rows[1] + torque * self.turn)


def forces_of_connectors(
    mechanism: Mechanism, links: Any, motion: RigidMotion, q: list[FloatArray], kind: str
) -> list[FloatArray]:
    """Of loads, springs and springs in joints on displaced links, from their definitions."""
    topology = mechanism.linkage.topology
    total = [np.zeros_like(each) for each in q]

    def add(point: Point, force: Any, torque: float = 0.0) -> None:
        total[point.link] += point.force(motion, q[point.link], np.asarray(force), torque)

    for load in mechanism.loads:
        point = Point(mechanism, links, load.point, kind)
        x, y, torque = load.values(motion.crank_angle[0])
        force = np.array([x, y])
        if load.axes == "link":
            angle = motion.angle[0, point.link] + point.turn @ q[point.link]
            force = x * direction(angle) + y * normal(angle)
        add(point, force, torque)
    for spring in mechanism.springs:
        places, rates, points = [], [], []
        for end in (spring.first, spring.second):
            if end.is_ground:
                places.append(np.array([end.x, end.y]))
                rates.append(np.zeros(2))
                points.append(None)
                continue
            point = Point(mechanism, links, end, kind)
            places.append(point.place(motion, q[point.link]))
            rates.append(motion.velocity(point.link, end.x)[0])
            points.append(point)
        line, approach = places[1] - places[0], rates[1] - rates[0]
        length = np.linalg.norm(line)
        pull = spring.stiffness * (length - spring.free_length)
        pull += spring.damping * (line @ approach) / length
        for point, sign in zip(points, (1.0, -1.0), strict=True):
            if point is not None:
                add(point, sign * pull * line / length)
    angles = continuous_angles(mechanism.linkage, motion)[0]
    ends = {pin.joint: (pin.follower, pin.leader) for pin in topology.pins}
    ends |= {pivot.joint: (pivot.link_end, None) for pivot in topology.pivots}
    sprung = {joint.joint for joint in (*topology.pins, *topology.pivots) if joint.sprung}
    for own in mechanism.joint_springs:
        sides = []
        for sign, end in zip((1.0, -1.0), ends[own.joint], strict=True):
            if end is not None:
                length = topology.links[topology.index(end.link)].length
                place = AttachmentPoint(end.link, 0.0 if end.end == "start" else length)
                sides.append((sign, Point(mechanism, links, place, kind)))
        opening = sum(s * (angles[p.link] + p.turn @ q[p.link]) for s, p in sides)
        rate = sum(s * motion.angular_velocity[0, p.link] for s, p in sides)
        torque = -own.torsional_stiffness * (opening - own.free_angle)
        torque -= own.torsional_damping * rate
        apart = sum(
            s * (p.place(motion, q[p.link]) - motion.position(p.link, p.x)[0]) for s, p in sides
        )
        force = -(own.radial_stiffness or 0.0) * apart * (own.joint in sprung)
        for sign, point in sides:
            add(point, sign * force, sign * torque)
    return total


@pytest.mark.parametrize("name", MECHANISMS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("degrees", [40.0, 200.0])
def test_the_equilibrium_is_one(name: str, kind: str, degrees: float) -> None:
    """Inner forces are in balance with inertia, weight, loads and springs, but for the joints."""
    mechanism = MECHANISMS[name]
    model = StaticModel(mechanism, 4, kind, connects=True)
    links = link_models(model)
    motion = mechanism.linkage.motion(np.array([np.radians(degrees)]), 20.0)
    loads = inertia_loads(links, motion, mechanism.gravity)
    outer = [load[0].copy() for load in loads]
    dead = DeadMoments.of(links, motion, mechanism.gravity, loads)
    found = static_equilibrium(model, motion, loads, dead)
    q = [each[0] for each in found.displacement]
    inner = [force[0] for force in internal_forces(model, found.displacement)]
    added = forces_of_connectors(mechanism, links, motion, q, kind)
    residual = []
    for number, part in enumerate(model.assembly.parts):
        own = outer[number]
        if isinstance(part, BeamPart) and part.polar is not None:
            own = part.polar.force(q[number], own)
        if links[number].rigid:
            turn = q[number][2]
            virial = motion.angular_velocity[0, number] ** 2 * links[number].mass[2, 2]
            pull = motion.origin_acceleration[0, number] - np.asarray(mechanism.gravity)
            centre = mechanism.link_mass(part.name).moment(1)
            virial -= centre * pull @ direction(motion.angle[0, number])
            own = own.copy()
            own[2] = np.cos(turn) * own[2] - np.sin(turn) * virial
        residual.append(inner[number] - own - added[number])
    ties = Ties(mechanism.linkage.topology, motion, links, found.displacement)
    size = max(np.abs(each).max() for each in (*outer, *added))
    assert np.abs(np.concatenate(added)).max() > 0.1
    assert np.abs(ties.basis.T @ np.concatenate(residual)).max() < 1e-8 * size


@pytest.mark.parametrize("name", thorough_but("springs in joints"))
@pytest.mark.parametrize(
    "kind", ["ancf", pytest.param("geometrically-exact", marks=pytest.mark.thorough)]
)
def test_a_run_accounts_for_all_energy(name: str, kind: str) -> None:
    """What loads give and dampers take is the rest of the balance."""
    mechanism, drive = MECHANISMS[name], ConstantSpeed(20.0)
    engine = ExudynEngine(mechanism, 3, kind)
    time = np.linspace(0.0, 0.03, 16)
    start = LinkState.rigid(engine.links)
    coarse, run = (engine.simulate(drive, start, time, step) for step in (2e-5, 1e-5))
    # Springs that are not free at the start strike the links: what the balance then lacks is
    # of second order in the step, as the rule is.
    assert run.energy_error < max(2e-5, coarse.energy_error / 3.8)
    assert run.energy_error < 0.01
    if name == "forces":
        assert np.abs(run.energy.prestress_work).max() > 1e-3


@pytest.mark.parametrize("name", thorough_but("springs", "sprung joints"))
def test_sensors_and_scripts_have_connectors(name: str, tmp_path: Path) -> None:
    mechanism, drive = MECHANISMS[name], ConstantSpeed(20.0)
    engine = ExudynEngine(mechanism, 3, "ancf")
    start = LinkState.rigid(engine.links)
    system = engine.running_system(drive, start, 1e-4, 40, stride=2)
    assert system.mbs.SolveDynamic(system.settings)
    time = system.step * np.arange(system.steps + 1)
    run = engine.simulate(drive, start, time, system.step)
    topology = mechanism.linkage.topology
    size = np.abs(run.joint_force).max()
    for number, (joint, of) in enumerate(
        zip(topology.joint_names, topology.joint_kinds, strict=True)
    ):
        found = system.history(f"{of}_{joint}_force")[1:, 1:3]
        np.testing.assert_allclose(found, run.joint_force[1:, number], rtol=0, atol=1e-6 * size)
    [file] = system.save(tmp_path)
    assert_well_formatted(file)
    _, found = run_script(tmp_path)
    wanted = system.history("driving_torque")[::2, 1]
    torque = found["driving_torque_Nm"].to_numpy()
    np.testing.assert_allclose(torque, wanted, rtol=0, atol=1e-6 * np.abs(wanted).max())


@pytest.mark.parametrize("name", thorough_but("forces", "sprung joints", "rigid"))
@pytest.mark.parametrize("rotation_terms", [True, pytest.param(False, marks=pytest.mark.thorough)])
def test_both_engines_agree(name: str, rotation_terms: bool) -> None:
    """Springs bend these strips by up to a tenth of their length: the mesh is fine."""
    mechanism = MECHANISMS[name]
    angles = np.radians([0.0, 130.0, 310.0])
    first, second = (
        natural_frequencies(
            engine(mechanism, 24, element), angles, 20.0, modes=3, rotation_terms=rotation_terms
        )
        for engine, element in ((ReferenceEngine, "euler"), (ExudynEngine, "ancf"))
    )
    np.testing.assert_allclose(second, first, rtol=1e-4)
